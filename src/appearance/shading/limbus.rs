//! The limbus, where the cornea goes over into the sclera. Twin: `shaders/lib/limbus.wgsl`.

use super::knots::{Knot, knot_at};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::sclera::LAMELLAE;
use glam::{DVec2, DVec3};

/// How far within and beyond the limbus' radius the sclera's lamellae fade over the cornea, mm (choices: half of the step of luminance is then at
/// that radius, as half of a white-to-white diameter says, and the step as wide as in photographs, which `measure looks` shows).
pub const LIMBUS_WITHIN_MM: f64 = 0.4;
/// See [`LIMBUS_WITHIN_MM`].
pub const LIMBUS_BEYOND_MM: f64 = 0.95;
/// How far that is in all.
pub const LIMBUS_MM: f64 = LIMBUS_WITHIN_MM + LIMBUS_BEYOND_MM;

/// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
pub fn limbus_share(r: f64, limbus_radius: f64) -> f64 {
    smoothstep(
        limbus_radius + LIMBUS_BEYOND_MM,
        limbus_radius - LIMBUS_WITHIN_MM,
        r,
    )
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

/// How far from the axis (mm) a place counts as being where the transition is `width` mm wide and not [`LIMBUS_MM`], as
/// [`limbus_share`] has it.
pub fn limbus_place(r: f64, limbus_radius: f64, width: f64) -> f64 {
    limbus_radius + (r - limbus_radius) * (LIMBUS_MM / width.max(1e-3))
}

/// Share of the cornea's own shape where the transition is `width` mm wide: all of it where the cornea is clear, none from the limbus' radius on.
pub fn limbus_shaped(r: f64, limbus_radius: f64, width: f64) -> f64 {
    let place = limbus_place(r, limbus_radius, width);
    smoothstep(limbus_radius, limbus_radius - LIMBUS_WITHIN_MM, place)
}

/// How much narrower the transition is where it is narrowest (a choice: it changes along the limbus over one to four millimetres).
const LIMBUS_UNEVEN: f64 = 0.22;

/// Width of the transition at a place (mm from the axis), against [`LIMBUS_MM`]: above and below the sclera goes further over the cornea,
/// whose vertical diameter looks a millimetre less, and here and there less far; `own` (rad) makes it that of this eye.
pub fn limbus_width(at: DVec2, own: f64) -> f64 {
    let sine = at.y / at.length().max(1e-3);
    let broad = (1.1 * at.x + own).sin() + (1.5 * at.y - 1.3 * own).sin();
    let waves = broad + 0.6 * (2.9 * at.x + 1.7 * at.y + broad + 2.0 * own).sin();
    limbus_widest(sine) * (1.0 - LIMBUS_UNEVEN * (0.5 + waves / 5.2))
}

/// How far beyond the limbus' radius some of the cornea is seen at most, mm.
pub fn limbal_reach_mm() -> f64 {
    LIMBUS_BEYOND_MM * limbus_widest(1.0)
}

/// The most that it can be in this direction (`sine` of the angle to the horizontal).
pub fn limbus_widest(sine: f64) -> f64 {
    0.87 + 0.48 * sine * sine
}

/// Radius (mm) within which the cornea alone is seen, in every direction.
pub fn clear_cornea_mm(limbus_radius: f64) -> f64 {
    limbus_radius - LIMBUS_WITHIN_MM * limbus_widest(1.0)
}

/// What the lipid of an arcus scatters where it is densest, as a share of what all of the sclera's lamellae do (a choice: it is
/// nearly white there, and the limbus' own rim before it is clear).
pub const ARCUS_DENSEST: f64 = 0.3;

/// Width of the clear rim about it, mm, within the limbus' own edge, of which the last seventh is hardly seen (the lucid interval of Vogt; a choice
/// of its width).
const ARCUS_CLEAR_MM: f64 = 0.08;

/// Density of the lipid of an arcus at a place of the cornea, `r` mm from the axis: a ring, sharp outwards and soft inwards, with a clear rim
/// outside it, within the limbus of this `width` ([`limbus_width`]), which comes first and is broadest above and below and is as uneven as that
/// limbus; `lipid` 0 to 1.
pub fn arcus_share(r: f64, sine: f64, limbus_radius: f64, lipid: f64, width: f64) -> f64 {
    let inside = limbus_radius - r - 0.85 * LIMBUS_WITHIN_MM * width;
    // 0 where that limbus is as wide as it can be there, 1 where it is narrowest.
    let lean = (1.0 - width / limbus_widest(sine)) / LIMBUS_UNEVEN;
    let wide = (0.5 + 0.6 * lipid) * (1.0 - 0.35 * lean) * (0.85 + 0.25 * sine * sine);
    let ring = smoothstep(ARCUS_CLEAR_MM, ARCUS_CLEAR_MM + 0.25, inside)
        * (1.0 - smoothstep(ARCUS_CLEAR_MM + 0.35 * wide, wide + 0.6, inside));
    let first = smoothstep(0.0, 0.5, lipid);
    let last = 0.65 * smoothstep(0.15, 0.85, lipid);
    ring * (last + (first - last) * sine * sine) * (1.0 - 0.3 * lean)
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
            let share = |r: f64, turn: f64, own: f64| {
                let width = limbus_width(DVec2::from_angle(turn) * r, own);
                limbus_share(limbus_place(r, limbus_mm, LIMBUS_MM * width), limbus_mm)
            };
            let mut least: f64 = 1.0;
            for k in 0..360 {
                let turn = f64::from(k).to_radians();
                for own in [0.0, 1.0, 2.5, 4.4] {
                    // Up to a rounding of the border itself.
                    assert_eq!(share(clear - 1e-9, turn, own), 1.0, "{limbus_mm} mm, {k}°");
                    least = least.min(share(clear + 0.12, turn, own));
                }
            }
            assert!(least < 1.0);
        }
    }

    /// What is beyond the mesh of the limbus has no code of the cornea, and beyond the limbus' radius there is none of its shape.
    #[test]
    fn no_cornea_is_seen_beyond_the_limbus_mesh() {
        let limbus_mm = 5.85;
        let reach = limbus_mm + limbal_reach_mm();
        let mut most: f64 = 0.0;
        for k in 0..360 {
            let turn = DVec2::from_angle(f64::from(k).to_radians());
            for own in [0.0, 1.0, 2.5, 4.4] {
                let share = |r: f64| {
                    let width = LIMBUS_MM * limbus_width(turn * r, own);
                    limbus_share(limbus_place(r, limbus_mm, width), limbus_mm)
                };
                assert_eq!(share(reach + 1e-9), 0.0, "{k}");
                most = most.max(share(reach - 0.2));
                let width = LIMBUS_MM * limbus_width(turn * limbus_mm, own);
                assert!(limbus_shaped(limbus_mm, limbus_mm, width) < 1e-9);
                let clear = clear_cornea_mm(limbus_mm);
                assert_eq!(limbus_shaped(clear, limbus_mm, width), 1.0);
            }
        }
        assert!(most > 0.0);
    }

    #[test]
    fn the_limbus_is_wider_above_and_uneven_as_its_eye_has_it() {
        let widths = |own: f64, from: f64| -> Vec<f64> {
            let turns = (0..40).map(|k| (from + f64::from(k) - 20.0).to_radians());
            turns
                .map(|turn| limbus_width(5.85 * DVec2::from_angle(turn), own))
                .collect()
        };
        let mean = |from: f64| {
            let all: Vec<f64> = (0..60)
                .flat_map(|own| widths(f64::from(own), from))
                .collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        assert!(mean(90.0) > 1.3 * mean(0.0) && mean(270.0) > 1.3 * mean(180.0));
        let around = |own: f64| -> Vec<f64> {
            let turns = (0..360).map(|k| DVec2::from_angle(f64::from(k).to_radians()));
            turns
                .map(|turn| limbus_width(5.85 * turn, own) / limbus_widest(turn.y))
                .collect()
        };
        let (one, other) = (around(0.3), around(2.0));
        let spread = |w: &[f64]| {
            w.iter().fold(0.0_f64, |m, v| m.max(*v)) / w.iter().fold(9.0_f64, |m, v| m.min(*v))
        };
        assert!(spread(&one) > 1.1 && spread(&other) > 1.1);
        assert!(one.iter().zip(&other).any(|(a, b)| (a - b).abs() > 0.08));
    }

    #[test]
    fn an_arcus_begins_above_and_below_and_leaves_the_rim_clear() {
        let width = |sine: f64| 0.89 * limbus_widest(sine);
        let at = |inside: f64, sine: f64, lipid: f64| {
            arcus_share(5.85 - inside, sine, 5.85, lipid, width(sine))
        };
        assert_eq!(at(0.7, 1.0, 0.0), 0.0);
        assert!(at(1.1, 1.0, 0.15) > 0.05 && at(1.0, 0.0, 0.15) == 0.0);
        // The lucid interval, which ends past where the limbus' own haze does, the ring, the clear middle.
        for sine in [0.0, 1.0] {
            let haze = |inside: f64| {
                1.0 - limbus_share(
                    limbus_place(5.85 - inside, 5.85, LIMBUS_MM * width(sine)),
                    5.85,
                )
            };
            let clear = (0..200)
                .map(|k| 0.01 * f64::from(k))
                .find(|inside| haze(*inside) < 0.05 && at(*inside, sine, 1.0) < 0.15);
            let clear = clear.expect("a clear rim");
            assert!(at(clear + 0.5, sine, 1.0) > 0.5, "{sine}: {clear}");
        }
        assert!(at(0.95, 0.0, 1.0) > 0.38 && at(1.15, 1.0, 1.0) > 0.65 && at(2.4, 0.0, 1.0) == 0.0);
    }
}
