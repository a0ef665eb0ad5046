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
