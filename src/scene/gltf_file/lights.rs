//! Lights of a glTF file, and those of a file without any.

use super::super::model::{EyePlacement, SceneLight};
use super::extras::OfLight;
use glam::{Mat4, Vec3};
use std::f32::consts::PI;

/// A key light over the viewer's left shoulder and light from everywhere; white is about
/// [`super::EMISSION_CD_M2`].
pub(super) fn default_lights(eye: &EyePlacement) -> Vec<SceneLight> {
    let (forward, up) = (Vec3::from(eye.forward), Vec3::from(eye.up));
    let direction = forward + 0.6 * forward.cross(up) - 0.9 * up;
    vec![
        SceneLight::Directional {
            direction: direction.normalize().into(),
            color: [1.0, 0.97, 0.92],
            illuminance_lux: 400.0,
            shadows: true,
        },
        SceneLight::Ambient {
            color: [0.92, 0.96, 1.0],
            brightness: 60.0,
        },
    ]
}

/// A light of `KHR_lights_punctual`: candela for points, lux for the sun. A spot shines all
/// around, with the intensity of its axis, and is remarked on.
pub(super) fn read_light(
    light: &gltf::khr_lights_punctual::Light,
    world: Mat4,
    own: &OfLight,
) -> Option<SceneLight> {
    use gltf::khr_lights_punctual::Kind;
    let (color, intensity) = (light.color(), light.intensity());
    let is_usable =
        intensity.is_finite() && intensity >= 0.0 && color.iter().all(|c| c.is_finite());
    match light.kind() {
        _ if !is_usable => None,
        Kind::Directional => Some(SceneLight::Directional {
            direction: (-world.z_axis.truncate()).try_normalize()?.into(),
            color,
            illuminance_lux: intensity,
            shadows: own.shadows.unwrap_or(true),
        }),
        Kind::Point | Kind::Spot { .. } => Some(SceneLight::Point {
            position: world.w_axis.truncate().into(),
            color,
            intensity_lm: intensity * 4.0 * PI,
            range: light
                .range()
                .filter(|r| r.is_finite() && *r > 0.0)
                .unwrap_or(100.0),
            shadows: own.shadows.unwrap_or(false),
        }),
    }
}
