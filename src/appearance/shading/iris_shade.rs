//! The light that iris and pupil send back. Eye frame, mm. Twin: `shaders/lib/iris_shade.wgsl`.

use super::iris_relief::{
    IrisFrame, IrisPlace, IrisTexel, iris_level, iris_step, iris_texel, relief_gain, relief_march,
    relief_normal, relief_shadow,
};
use crate::appearance::images::MapView;
use crate::appearance::light_table::iris_light;
use crate::optics::smoothstep::smoothstep;
use glam::{DVec2, DVec3};

/// Longest path (mm) of the reflectance map.
pub const IRIS_PATH_MAX_MM: f64 = 2.5;

/// The maps of one iris.
#[derive(Clone, Debug)]
pub struct IrisMaps {
    /// Relief, thickness and melanin.
    pub relief: MapView,
    /// Reflectance by path and melanin.
    pub reflectance: MapView,
    /// Light of the lamps.
    pub light: MapView,
}

/// Path (mm) of light through the stroma, in towards z and out at the cosine of the view.
pub fn iris_path(thickness: f64, towards_z: f64, view_cosine: f64) -> f64 {
    thickness * 0.5 * (1.0 / (-towards_z).max(0.35) + 1.0 / view_cosine.max(0.35))
}

/// Radiance at the edges of the iris: the root lies in the shade of the limbus; the ruff is pigment
/// without stroma. `v` runs from the pupil's edge to the root.
pub fn iris_edges(radiance: DVec3, v: f64) -> DVec3 {
    let root = smoothstep(0.80, 1.02, v);
    let ruff = smoothstep(0.035, 0.0, v);
    radiance
        * DVec3::ONE.lerp(DVec3::new(0.30, 0.33, 0.38), root)
        * DVec3::ONE.lerp(DVec3::new(0.16, 0.11, 0.08), ruff)
}

/// What of the surroundings reaches a place of this height: over the dome they arrive nearly evenly;
/// what is deep sees less of them.
pub fn iris_openness(height: f64) -> f64 {
    (0.80 + height * 2.2).clamp(0.35, 1.15)
}

/// Where a refracted ray meets the iris, what is there, and how it is turned to the ray.
#[derive(Clone, Copy, Debug)]
pub struct IrisSurface {
    /// Place over the plane of the iris, mm.
    pub at: DVec2,
    /// Place in the map.
    pub place: IrisPlace,
    /// What the map has there.
    pub texel: IrisTexel,
    /// Normal of the relief.
    pub normal: DVec3,
    /// Cosine of the ray to it.
    pub view_cosine: f64,
    /// Level of the map.
    pub lod: f64,
}

/// Where a refracted ray that lands at `point` of the iris' plane meets it, `start` being that point's place
/// in the map.
pub fn iris_surface(
    maps: &IrisMaps,
    iris: &IrisFrame,
    point: DVec2,
    direction: DVec3,
    start: &IrisPlace,
    footprint: f64,
) -> IrisSurface {
    let lod = iris_level(maps.relief.size(), footprint, point.length(), iris.width());
    // The next coarser level, by its number: between two, devices break ties differently.
    let moved = relief_march(&maps.relief, start, direction, lod.ceil());
    let place = IrisPlace {
        uv: iris_step(start, moved),
        ..*start
    };
    let texel = iris_texel(&maps.relief, place.uv, lod);
    let normal = relief_normal(
        &maps.relief,
        &place,
        texel.height,
        footprint,
        lod,
        iris.relief,
    );
    IrisSurface {
        at: point + moved,
        place,
        texel,
        normal,
        view_cosine: (-normal.dot(direction)).max(0.2),
        lod,
    }
}

/// Reflectance of tissue on the path of light that arrives with this z.
pub fn iris_reflectance(maps: &IrisMaps, surface: &IrisSurface, towards_z: f64) -> DVec3 {
    let path = iris_path(surface.texel.thickness, towards_z, surface.view_cosine);
    let at = DVec2::new(path / IRIS_PATH_MAX_MM, surface.texel.melanin);
    let [r, g, b, _] = maps.reflectance.sample(at, 0.0);
    DVec3::new(r, g, b)
}

/// What the iris sends back of a lamp with an irradiance / π of one in the unit direction `light` of the
/// eye frame.
pub fn iris_lamp(maps: &IrisMaps, iris: &IrisFrame, surface: &IrisSurface, light: DVec3) -> DVec3 {
    let arrives = iris_light(&maps.light, light, surface.at, iris.root, iris.limbus);
    let towards = arrives.truncate();
    let shadow = relief_shadow(
        &maps.relief,
        &surface.place,
        surface.texel.height,
        towards,
        surface.lod,
    );
    let gain = arrives.w * relief_gain(surface.normal, towards) * shadow;
    gain * iris_reflectance(maps, surface, towards.z)
}

/// Mean cosine in the aqueous of light from all of the sky before an eye: cosines beyond the critical angle
/// do not occur.
pub const IRIS_SKY_COSINE: f64 = 0.87;

/// What the iris sends back of surroundings with an irradiance / π of one.
pub fn iris_ambient(maps: &IrisMaps, surface: &IrisSurface) -> DVec3 {
    0.92 * iris_openness(surface.texel.height) * iris_reflectance(maps, surface, -IRIS_SKY_COSINE)
}

/// What shows through the pupil: nearly black, and what the lens sends back (`lens`) of the lamps' `light`.
pub fn pupil_radiance(light: DVec3, lens: DVec3) -> DVec3 {
    DVec3::new(0.0016, 0.0013, 0.0012) + light * lens
}

/// Share of the iris (0 in the pupil, 1 outside) at a place of the map: the pupil's margin is uneven
/// and softened over a pixel.
pub fn pupil_edge(uv: DVec2, footprint: f64, width: f64) -> f64 {
    let uneven = 0.006 * (uv.x * 81.6814).sin() + 0.005 * (uv.x * 37.6991 + 1.7).sin();
    let soft = (0.75 * footprint / width).max(0.008);
    smoothstep(-soft, soft, uv.y - uneven)
}

/// Pupil, iris and, past the root, the dark angle behind the limbus, each by its share.
pub fn iris_and_pupil(pupil: DVec3, iris: DVec3, edge: f64, v: f64) -> DVec3 {
    let beyond = smoothstep(1.0, 1.12, v);
    pupil.lerp(iris.lerp(DVec3::new(0.03, 0.028, 0.027), beyond), edge)
}
