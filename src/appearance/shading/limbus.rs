//! The limbus, where the cornea goes over into the sclera. Twin: `shaders/lib/limbus.wgsl`.

use super::knots::{Knot, knot_at};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::sclera::LAMELLAE;
use glam::DVec3;

/// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
pub fn limbus_share(r: f64, limbus_radius: f64) -> f64 {
    smoothstep(limbus_radius + 0.27, limbus_radius - 0.63, r)
}

/// The surface's normal there: the globe's outside, the cornea's own from a third of the way in.
pub fn limbus_normal(globe: DVec3, cornea: DVec3, share: f64) -> DVec3 {
    globe.lerp(cornea, smoothstep(0.0, 0.35, share)).normalize()
}

/// Between which knots of what lamellae do ([`crate::tissue::sclera::lamellae`]) this share of their thickness lies.
pub fn lamellae_knot(share: f64) -> Knot {
    knot_at(share.clamp(0.0, 1.0).sqrt(), LAMELLAE)
}

/// How much of the white's colour is seen where lamellae send this back and all of the sclera `whole`.
pub fn limbus_white(reflected: DVec3, whole: DVec3) -> DVec3 {
    reflected / whole.max(DVec3::splat(1e-3))
}

/// How much of what lies behind the cornea is lit and seen where lamellae pass this and all of the sclera `whole`: nothing
/// of it there.
pub fn limbus_through(passed: DVec3, whole: DVec3) -> DVec3 {
    let kept = (passed - whole) / (DVec3::ONE - whole).max(DVec3::splat(1e-3));
    kept * kept
}

/// How far from the axis (mm) a place counts as being where the transition is `width` mm wide and not 0.9, as
/// [`limbus_share`] has it.
pub fn limbus_place(r: f64, limbus_radius: f64, width: f64) -> f64 {
    limbus_radius + (r - limbus_radius) * (0.9 / width.max(1e-3))
}

/// Width of the transition where a place lies in this direction (`sine` of the angle to the horizontal), against
/// 0.9 mm: above and below the sclera goes further over the cornea, whose vertical diameter looks a millimetre less.
pub fn limbus_width(sine: f64) -> f64 {
    0.87 + 0.48 * sine * sine
}

/// Radius (mm) within which the cornea alone is seen, in every direction.
pub fn clear_cornea_mm(limbus_radius: f64) -> f64 {
    limbus_radius - 0.63 * limbus_width(1.0)
}

/// What the lipid of an arcus scatters where it is densest, as a share of what all of the sclera's lamellae do (a choice: it is
/// nearly white there, and the limbus' own rim before it is clear).
pub const ARCUS_DENSEST: f64 = 0.3;

/// Density of the lipid of an arcus at a place of the cornea, `r` mm from the axis: a ring with a clear rim outside it,
/// which comes first above and below; `lipid` 0 to 1.
pub fn arcus_share(r: f64, sine: f64, limbus_radius: f64, lipid: f64) -> f64 {
    let inside = limbus_radius - r;
    let wide = 0.7 + 1.3 * lipid;
    let ring = smoothstep(-0.05, 0.4, inside) * smoothstep(wide + 0.7, 0.35 * wide, inside);
    let first = smoothstep(0.0, 0.5, lipid);
    let last = 0.65 * smoothstep(0.15, 0.85, lipid);
    ring * (last + (first - last) * sine * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mesh of the clear cornea has no code of the white: there is none within its radius, in any direction, and there is
    /// some just outside it above and below.
    #[test]
    fn no_white_is_seen_within_the_clear_cornea() {
        for limbus_mm in [5.0, 5.85, 6.5] {
            let clear = clear_cornea_mm(limbus_mm);
            let share = |r: f64, sine: f64| {
                limbus_share(
                    limbus_place(r, limbus_mm, 0.9 * limbus_width(sine)),
                    limbus_mm,
                )
            };
            for sine in [-1.0, -0.6, 0.0, 0.3, 1.0] {
                // Up to a rounding of the border itself.
                assert_eq!(share(clear - 1e-9, sine), 1.0, "{limbus_mm} mm, {sine}");
            }
            assert!(share(clear + 0.05, 1.0) < 1.0 && share(clear + 0.05, 0.0) == 1.0);
        }
    }

    #[test]
    fn an_arcus_begins_above_and_below_and_leaves_the_rim_clear() {
        let at = |inside: f64, sine: f64, lipid: f64| arcus_share(5.85 - inside, sine, 5.85, lipid);
        assert_eq!(at(0.7, 1.0, 0.0), 0.0);
        assert!(at(0.7, 1.0, 0.15) > 0.05 && at(0.7, 0.0, 0.15) == 0.0);
        // The lucid interval, the ring, the clear middle.
        assert!(at(-0.06, 1.0, 1.0) == 0.0 && at(0.04, 1.0, 1.0) < 0.2 * at(0.5, 1.0, 1.0));
        assert!(at(0.6, 0.0, 1.0) > 0.5 && at(0.6, 1.0, 1.0) > 0.8 && at(2.8, 0.0, 1.0) == 0.0);
    }
}
