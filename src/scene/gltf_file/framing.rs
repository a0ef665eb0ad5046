//! Where the eye stands: where the file's camera is, or before a scene without one; and whether the scene's size
//! is plausible.

use super::super::model::{EyePlacement, SceneModel};
use glam::{Mat4, Vec3};

/// Nearest that the eye is put before a scene without a camera, m: beyond the view's near plane.
const NEAREST_M: f32 = 0.03;

/// An eye in front of the scene (at +z), at the height of its middle, so far away that the nearer
/// side fills 70 % of the view.
pub(super) fn frame(scene: &SceneModel) -> EyePlacement {
    let eye = EyePlacement::default();
    let Some((low, high)) = scene.bounds() else {
        return eye;
    };
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    let half = (high - low) / 2.0;
    if half.x < 0.05 * half.y.max(half.z) {
        // A wall along the line of sight is a line too: stand to its side.
        let distance =
            half.y.max(half.z).max(1e-3) / (0.7 * (0.5 * eye.vertical_fov_deg.to_radians()).tan());
        let centre = (low + high) / 2.0;
        let position = Vec3::new(high.x + distance.max(NEAREST_M), centre.y, centre.z);
        return EyePlacement {
            position_m: position.into(),
            forward: [-1.0, 0.0, 0.0],
            ..eye
        };
    }
    let spread = half.x.max(half.y).max(0.1 * half.z).max(1e-3);
    let distance = spread / (0.7 * (0.5 * eye.vertical_fov_deg.to_radians()).tan());
    let distance = distance.max(NEAREST_M);
    let centre = (low + high) / 2.0;
    if half.y < 0.05 * half.x.max(half.z) {
        // A floor, seen level, is a line: look down on it by 30°.
        let forward = Vec3::new(0.0, -0.5, -0.75f32.sqrt());
        let position = centre - forward * distance.max(half.x.max(half.z) * 2.0);
        return EyePlacement {
            position_m: position.into(),
            forward: forward.into(),
            up: Vec3::new(0.0, 0.75f32.sqrt(), -0.5).into(),
            ..eye
        };
    }
    let position = Vec3::new(centre.x, centre.y, high.z + distance);
    EyePlacement {
        position_m: position.into(),
        ..eye
    }
}

/// Asks whether the unit is right where a scene is larger than 200 m or smaller than 5 cm: distance is
/// what matters here.
pub(super) fn odd_size(scene: &SceneModel) -> Option<String> {
    let (low, high) = scene.bounds()?;
    let widest = (0..3).map(|k| high[k] - low[k]).fold(0.0f32, f32::max);
    let size = if widest >= 1e6 {
        format!("{widest:.1e} m")
    } else if widest >= 1.0 {
        format!("{widest:.0} m")
    } else if widest >= 1e-4 {
        format!("{:.1} mm", widest * 1e3)
    } else {
        format!("{widest:.1e} m")
    };
    let guess = if widest > 200.0 {
        "Is its unit the millimetre or the centimetre (--scene-unit mm, cm, or \"Its unit\" among the controls)?"
    } else if widest < 0.05 {
        "Should it be larger? Every other unit makes it smaller still: scale it where it was made."
    } else {
        return None;
    };
    Some(format!(
        "\"{}\" is {size} wide if its unit is the metre, as glTF says. {guess}",
        scene.name
    ))
}

/// The eye where a camera is; `None` of one that looks nowhere.
pub(super) fn eye_of_camera(camera: &gltf::Camera, world: Mat4) -> Option<EyePlacement> {
    let position = world.w_axis.truncate();
    let forward = (-world.z_axis.truncate()).try_normalize()?;
    let up = (world.y_axis.truncate() - forward * world.y_axis.truncate().dot(forward))
        .try_normalize()?;
    let (vertical, aspect) = match camera.projection() {
        gltf::camera::Projection::Perspective(p) => (p.yfov(), p.aspect_ratio().unwrap_or(1.0)),
        gltf::camera::Projection::Orthographic(_) => return None,
    };
    let vertical = vertical.clamp(CAMERA_RAD[0], CAMERA_RAD[1]);
    let horizontal = 2.0 * ((0.5 * vertical).tan() * aspect.clamp(0.1, 10.0)).atan();
    position.is_finite().then(|| EyePlacement {
        position_m: position.into(),
        forward: forward.into(),
        up: up.into(),
        vertical_fov_deg: vertical.to_degrees(),
        horizontal_fov_deg: horizontal.to_degrees(),
    })
}

/// Vertical angles of a camera that are shown, rad: 1° to 149°.
const CAMERA_RAD: [f32; 2] = [0.02, 2.6];

/// A remark on a camera whose angle is not one.
pub(super) fn odd_angle(camera: &gltf::Camera, name: &str) -> Option<String> {
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
        return None;
    };
    let [least, most] = CAMERA_RAD;
    (!(least..=most).contains(&lens.yfov())).then(|| {
        format!(
            "\"{name}\": its camera {} has a vertical angle (yfov) of {}, and is shown with the nearest of {least} to \
             {most} rad.",
            camera.index(),
            lens.yfov()
        )
    })
}
