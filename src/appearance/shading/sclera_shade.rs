//! The sclera's diffuse light. Eye frame, mm.
//! Twin: `shaders/lib/sclera_shade.wgsl`.

use super::footprint::footprint_level;
use super::lid_shade::LidShade;
use super::surroundings::wrapped_cosines;
use crate::appearance::images::MapView;
use glam::{DVec2, DVec3};

/// The map is azimuthal equidistant from the front, to 100°.
pub const SCLERA_HALF_ANGLE: f64 = 1.7453293;

/// Colour and normal of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScleraSurface {
    /// Albedo, linear sRGB.
    pub albedo: DVec3,
    /// Normal with the map's relief.
    pub normal: DVec3,
}

/// Place in the map of a point of the globe.
pub fn sclera_uv(p: DVec3) -> DVec2 {
    let n = p.normalize();
    let angle = (-n.z).clamp(-1.0, 1.0).acos();
    let direction = n.truncate().normalize_or_zero();
    0.5 + 0.5 * direction * (angle / SCLERA_HALF_ANGLE)
}

/// The normal with the relief of the map, from its height here and a step to the right and above.
pub fn sclera_normal(normal: DVec3, here: f64, right: f64, above: f64) -> DVec3 {
    let bump = DVec2::new(right - here, above - here) * 1.3;
    (normal - bump.extend(0.0)).normalize()
}

/// What the white takes up of a lamp with an irradiance / π of one, at this cosine: light travels under the
/// surface, red furthest.
pub fn sclera_lamp(cosine: f64) -> DVec3 {
    wrapped_cosines(cosine, DVec3::new(0.42, 0.30, 0.24))
}

/// What the lids reflect back is warm, most of it near their margins.
pub fn sclera_lid_bounce(shade: &LidShade) -> DVec3 {
    let near_lid = (-shade.upper_gap.min(shade.lower_gap).max(0.0) / 1.1).exp();
    DVec3::ONE.lerp(DVec3::new(1.05, 0.86, 0.80), near_lid * 0.8)
}

/// Mean albedo of the white, linear sRGB: what a thin layer of tissue is seen over.
pub const SCLERA_WHITE: DVec3 = DVec3::new(0.70, 0.59, 0.54);

/// What the conjunctiva leaves of the light from the white below it, by Beer and Lambert: all of it where it
/// is thin and clear (`share` 0), as much as makes the white look like flesh where it is thick (`share` 1).
pub fn conjunctiva_filter(flesh: DVec3, share: f64) -> DVec3 {
    (flesh / SCLERA_WHITE).powf(share.clamp(0.0, 1.0))
}

/// Albedo and normal at a point `p`; `map` holds the albedo and in its last channel the height.
pub fn sclera_surface(
    map: &MapView,
    p: DVec3,
    normal: DVec3,
    footprint: f64,
    sclera_radius: f64,
) -> ScleraSurface {
    let uv = sclera_uv(p);
    let texels = map.size().x;
    let lod = footprint_level(footprint, 2.0 * SCLERA_HALF_ANGLE * sclera_radius / texels);
    let [r, g, b, here] = map.sample(uv, lod);
    let height = |x: f64, y: f64| map.sample(uv + DVec2::new(x, y) * (1.5 / texels), lod)[3];
    ScleraSurface {
        albedo: DVec3::new(r, g, b),
        normal: sclera_normal(normal, here, height(1.0, 0.0), height(0.0, 1.0)),
    }
}
