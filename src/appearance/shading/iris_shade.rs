//! The light that iris and pupil send back. Eye frame, mm. Twin: `shaders/lib/iris_shade.wgsl`.

use super::iris_relief::{
    IrisFrame, IrisPlace, iris_level, iris_step, iris_texel, relief_gain, relief_march,
    relief_normal, relief_shadow,
};
use super::lid_shade::LidShade;
use super::studio::studio_ambient;
use crate::appearance::images::MapView;
use crate::appearance::light_table::iris_light;
use crate::appearance::materials::Studio;
use crate::optics::smoothstep::smoothstep;
use glam::{DMat3, DVec2, DVec3, Vec3};

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

/// Radiance of the iris where a refracted ray lands at `point` of its plane, `start` being that point's
/// place in the map.
#[expect(clippy::too_many_arguments, reason = "the shader's own arguments")]
pub fn iris_radiance(
    maps: &IrisMaps,
    iris: &IrisFrame,
    studio: &Studio,
    head_from_eye: DMat3,
    point: DVec2,
    direction: DVec3,
    start: &IrisPlace,
    footprint: f64,
    shade: &LidShade,
) -> DVec3 {
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
    let view_cosine = (-normal.dot(direction)).max(0.2);

    let eye_from_head = head_from_eye.transpose();
    let light_of = |lamp: Vec3| {
        let light = eye_from_head * lamp.as_dvec3();
        iris_light(&maps.light, light, point + moved, iris.root, iris.limbus)
    };
    let (key, fill) = (
        light_of(studio.key_direction),
        light_of(studio.fill_direction),
    );
    let shadow = relief_shadow(&maps.relief, &place, texel.height, key.truncate(), lod);
    let path = iris_path(texel.thickness, key.z, view_cosine);
    let at = DVec2::new(path / IRIS_PATH_MAX_MM, texel.melanin);
    let [r, g, b, _] = maps.reflectance.sample(at, 0.0);

    let key_gain = key.w * relief_gain(normal, key.truncate()) * shadow * shade.key;
    let fill_gain = fill.w * relief_gain(normal, fill.truncate()) * shade.sky;
    let open = iris_openness(texel.height) * shade.sky * 0.92;
    let light = studio.key_color.as_dvec3() * key_gain
        + studio.fill_color.as_dvec3() * fill_gain
        + studio_ambient(studio, -head_from_eye.z_axis) * open;
    iris_edges(DVec3::new(r, g, b) * light, place.uv.y)
}

/// What shows through the pupil: nearly black, and what the lens sends back (`lens`) of the lamps' light.
pub fn pupil_radiance(studio: &Studio, lens: DVec3, shade: &LidShade) -> DVec3 {
    let light = (studio.key_color.as_dvec3() + studio.fill_color.as_dvec3()) * shade.key;
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
