//! How finely skin and hairs of each eye are divided: by the camera in whose picture it is largest.

use super::hair;
use super::model::{EyeModel, EyeParts, METRES_A_MM};
use super::probe::ProbeCamera;
use super::region_parts::{self, level_for};
use bevy::camera::visibility::RenderLayers;
use bevy::prelude::*;

/// How far the skin of an eye reaches towards a camera from the globe's centre, mm.
const REACH_MM: f32 = 20.0;

/// Pixels for each unit of length at this distance before a camera.
fn pixels_at(distance: f32, clip_from_view: Mat4, height_px: f32) -> f32 {
    // An orthographic camera has the same everywhere.
    let is_perspective = clip_from_view.w_axis.w == 0.0;
    let before = if is_perspective {
        distance.max(1e-6)
    } else {
        1.0
    };
    0.5 * height_px * clip_from_view.y_axis.y / before
}

/// Chooses the levels; an eye that gets another one is posed anew.
pub fn choose_levels(
    mut models: Query<(&mut EyeParts, &GlobalTransform, Option<&RenderLayers>), With<EyeModel>>,
    // A probe's cameras stand within the eye.
    cameras: Query<(&Camera, &GlobalTransform, Option<&RenderLayers>), Without<ProbeCamera>>,
) {
    for (mut parts, place, layers) in &mut models {
        let layers = layers.cloned().unwrap_or_default();
        let millimetre = METRES_A_MM * place.scale().abs().max_element();
        let pixels = cameras.iter().filter_map(|(camera, from, sees)| {
            let size = camera.physical_viewport_size()?;
            if !sees.cloned().unwrap_or_default().intersects(&layers) {
                return None;
            }
            let distance = from.translation().distance(place.translation());
            let nearest = distance - REACH_MM * millimetre;
            Some(millimetre * pixels_at(nearest, camera.clip_from_view(), size.y as f32))
        });
        // An eye that no camera sees stays as it is.
        let Some(pixels) = pixels.reduce(f32::max) else {
            continue;
        };
        let level = level_for(pixels, parts.level, &region_parts::PIXELS_A_MM);
        let hair_level = level_for(pixels, parts.hair_level, &hair::PIXELS_A_MM);
        if (level, hair_level) != (parts.level, parts.hair_level) {
            parts.level = level;
            parts.hair_level = hair_level;
            parts.pose = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_millimetre_has_as_many_pixels_as_a_projection_says() {
        // 100 px for 2 m at 1 m of a right angle's field.
        let right_angle =
            Mat4::perspective_infinite_reverse_rh(std::f32::consts::FRAC_PI_2, 1.0, 0.01);
        for (distance, wanted) in [(1.0, 50.0), (0.1, 500.0), (4.0, 12.5)] {
            let found = pixels_at(distance, right_angle, 100.0);
            assert!((found / wanted - 1.0).abs() < 1e-5, "{distance}: {found}");
        }
        let even = Mat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
        assert!((pixels_at(3.0, even, 100.0) - 50.0).abs() < 1e-4);
        assert!(pixels_at(-1.0, right_angle, 100.0).is_finite());
    }
}
