//! The limbus, where the cornea goes over into the sclera. Twin: `shaders/lib/limbus.wgsl`.

use crate::optics::smoothstep::smoothstep;
use glam::DVec3;

/// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
pub fn limbus_share(r: f64, limbus_radius: f64) -> f64 {
    smoothstep(limbus_radius + 0.27, limbus_radius - 0.63, r)
}

/// The surface's normal there: the globe's outside, the cornea's own from a third of the way in.
pub fn limbus_normal(globe: DVec3, cornea: DVec3, share: f64) -> DVec3 {
    globe.lerp(cornea, smoothstep(0.0, 0.35, share)).normalize()
}

/// Tint of the blue-grey ring where the sclera thins over the dark angle.
pub fn limbus_tint(share: f64) -> DVec3 {
    let ring = share * (1.0 - share) * 4.0;
    DVec3::ONE.lerp(DVec3::new(0.62, 0.66, 0.72), ring * 0.75)
}

/// How far from the axis (mm) a place counts as being where the transition is `width` mm wide and not 0.9, as
/// [`limbus_share`] has it.
pub fn limbus_place(r: f64, limbus_radius: f64, width: f64) -> f64 {
    limbus_radius + (r - limbus_radius) * (0.9 / width.max(1e-3))
}

/// Width of the transition where a place lies in this direction (`sine` of the angle to the horizontal), against
/// 0.9 mm: above and below the sclera goes further over the cornea, whose vertical diameter looks a millimetre less.
pub fn limbus_width(sine: f64) -> f64 {
    0.97 + 0.48 * sine * sine
}

/// What lipid in the cornea's rim sends back, linear sRGB, where it covers all (a choice: photographs show it cream).
pub const ARCUS_COLOR: DVec3 = DVec3::new(0.62, 0.58, 0.47);

/// Share of a place of the cornea, `r` mm from the axis, that an arcus covers: a ring with a clear rim outside it,
/// which comes first above and below; `lipid` 0 to 1.
pub fn arcus_share(r: f64, sine: f64, limbus_radius: f64, lipid: f64) -> f64 {
    let inside = limbus_radius - r;
    let wide = 0.7 + 1.3 * lipid;
    let ring = smoothstep(-0.05, 0.4, inside) * smoothstep(wide + 0.7, 0.35 * wide, inside);
    let first = smoothstep(0.0, 0.5, lipid);
    let last = 0.65 * smoothstep(0.15, 0.85, lipid);
    0.85 * ring * (last + (first - last) * sine * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

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
