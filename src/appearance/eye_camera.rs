//! The camera that looks at the eye, and when it draws.

use crate::app::Panels;
use crate::ledger::WorkLedger;
use crate::readiness::Readiness;
use bevy::camera::{ClearColorConfig, RenderTarget, visibility::RenderLayers};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::camera::ExtractedCamera;
use bevy::render::extract_component::{ExtractComponent, ExtractComponentPlugin};
use bevy::render::renderer::ViewQuery;

/// Layer of everything that belongs to the eye.
pub const EYE_LAYER: usize = 30;

/// Half of the field that the camera shows across its smaller side, rad.
const HALF_FIELD: f32 = 12.5 * std::f32::consts::PI / 180.0;

/// Largest width of what is shown, in its usual height: there the face ends on the temple's side. Wider
/// panels come nearer.
const WIDEST: f32 = 1.08;

/// Vertical field (rad) of a panel whose width is `aspect` times its height.
fn vertical_field(aspect: f32) -> f32 {
    let share = (WIDEST / aspect).min(1.0) / aspect.min(1.0);
    2.0 * (HALF_FIELD.tan() * share).atan()
}

/// How finely the eye is drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct EyeQuality {
    /// Samples a pixel. Software rasterisers take three times as long for four.
    pub msaa: Msaa,
}

impl Default for EyeQuality {
    fn default() -> Self {
        Self {
            msaa: Msaa::Sample4,
        }
    }
}

/// Marks the camera that looks at the eye.
#[derive(Component, Clone, Copy, Debug, ExtractComponent)]
pub struct EyeCamera;

/// Where the camera stands: on a sphere about the eye.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct EyeOrbit {
    /// To the patient's right, degrees, −85 to 85.
    pub azimuth_deg: f32,
    /// Up, degrees, −80 to 80.
    pub elevation_deg: f32,
    /// Distance from the cornea, mm, 35 to 400.
    pub distance_mm: f32,
}

impl Default for EyeOrbit {
    fn default() -> Self {
        Self {
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            distance_mm: 93.0,
        }
    }
}

impl EyeOrbit {
    /// Keeps every number in its range.
    pub fn clamped(self) -> Self {
        let finite = |value: f32, or: f32| if value.is_finite() { value } else { or };
        Self {
            azimuth_deg: finite(self.azimuth_deg, 0.0).clamp(-85.0, 85.0),
            elevation_deg: finite(self.elevation_deg, 0.0).clamp(-80.0, 80.0),
            distance_mm: finite(self.distance_mm, 93.0).clamp(35.0, 400.0),
        }
    }

    fn transform(self) -> Transform {
        let (azimuth, elevation) = (
            self.azimuth_deg.to_radians(),
            self.elevation_deg.to_radians(),
        );
        let direction = Vec3::new(
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            -azimuth.cos() * elevation.cos(),
        );
        let target = Vec3::new(0.0, 0.0, -10.5);
        Transform::from_translation(target + direction * (self.distance_mm + 2.0))
            .looking_at(target, Vec3::Y)
    }
}

/// The camera and all that it needs to draw into the eye's panel.
pub fn camera_bundle(panels: &Panels) -> impl Bundle {
    (
        EyeCamera,
        Camera3d::default(),
        Camera {
            order: -2,
            is_active: false,
            clear_color: ClearColorConfig::Custom(Color::linear_rgb(0.030, 0.027, 0.026)),
            ..default()
        },
        RenderTarget::Image(panels.eye.image.clone().into()),
        Msaa::Sample4,
        Tonemapping::None,
        RenderLayers::layer(EYE_LAYER),
    )
}

/// Puts the camera where the orbit says, with a field that fits the panel's shape.
pub fn aim_camera(
    orbit: Res<EyeOrbit>,
    panels: Res<Panels>,
    mut camera: Query<(&mut Transform, &mut Projection), With<EyeCamera>>,
) {
    for (mut transform, mut projection) in &mut camera {
        let aspect = panels.eye.size.x as f32 / panels.eye.size.y as f32;
        let fov = vertical_field(aspect);
        transform.set_if_neq(orbit.clamped().transform());
        let current = match &*projection {
            Projection::Perspective(perspective) => perspective.fov,
            _ => 0.0,
        };
        if current != fov {
            *projection = Projection::Perspective(PerspectiveProjection {
                fov,
                near: 5.0,
                far: 2000.0,
                ..default()
            });
        }
    }
}

/// What the last drawn frame showed; a frame that would show the same is not drawn.
#[derive(Default)]
pub struct Drawn {
    orbit: Option<EyeOrbit>,
    size: UVec2,
    version: u64,
    msaa: Option<Msaa>,
    settled: bool,
    unsettled_frames: u32,
    /// What was drawn when all of it was there: which building of the eye, how smoothly.
    whole: Option<(u64, Msaa)>,
}

/// Wakes the camera in frames in which something changed.
pub fn wake_camera(
    parts: Res<super::EyeParts>,
    orbit: Res<EyeOrbit>,
    panels: Res<Panels>,
    readiness: Res<Readiness>,
    quality: Res<EyeQuality>,
    mut drawn: Local<Drawn>,
    mut camera: Query<(&mut Camera, &mut Msaa), With<EyeCamera>>,
) {
    // Until every pipeline exists and every texture has arrived, a frame is drawn to ask for them
    // and one when they are there; those between would show nothing.
    let settled = readiness.quiet_frames() >= 3;
    drawn.unsettled_frames = if settled {
        0
    } else {
        drawn.unsettled_frames + 1
    };
    let changed = drawn.orbit != Some(*orbit)
        || drawn.size != panels.eye.size
        || drawn.version != parts.version
        || drawn.msaa != Some(quality.msaa)
        || (settled && !drawn.settled);
    // What others wait for, such as the view for a window's new size, is not the eye's to wait for.
    let this = Some((parts.built, quality.msaa));
    let may = settled || drawn.unsettled_frames <= 2 || drawn.whole == this;
    let awake = panels.eye.visible && changed && may;
    for (mut camera, mut msaa) in &mut camera {
        msaa.set_if_neq(quality.msaa);
        if camera.is_active != awake {
            camera.is_active = awake;
        }
    }
    if awake {
        *drawn = Drawn {
            orbit: Some(*orbit),
            size: panels.eye.size,
            version: parts.version,
            msaa: Some(quality.msaa),
            settled,
            unsettled_frames: drawn.unsettled_frames,
            whole: if settled { this } else { drawn.whole },
        };
    }
}

/// Counts the passes where they run.
pub fn build_render(app: &mut App) {
    app.add_plugins(ExtractComponentPlugin::<EyeCamera>::default());
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(Core3d, count_pass.in_set(Core3dSystems::PostProcess));
    }
}

fn count_pass(view: ViewQuery<(&ExtractedCamera, &EyeCamera)>, ledger: Res<WorkLedger>) {
    let (camera, _) = view.into_inner();
    if let Some(size) = camera.physical_target_size {
        ledger.eye_passes(1);
        ledger.eye_pixels(u64::from(size.x) * u64::from(size.y));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_panel_shows_more_than_the_face_or_less_than_the_eye() {
        let half = HALF_FIELD.tan();
        for aspect in [0.1, 0.5, 1.0, 1.05, 1.3, 1.9, 4.0] {
            let up = (0.5 * vertical_field(aspect)).tan();
            let aside = up * aspect;
            assert!(aside <= WIDEST * half * 1.0001, "{aspect}: {aside} aside");
            // The smaller side of an upright panel spans the usual field.
            assert!(
                aspect > 1.0 || (aside / half - 1.0).abs() < 1e-5,
                "{aspect}"
            );
            // Lids stand 6 mm above and below the middle, the usual field 20 mm.
            assert!(aspect > 3.0 || up > 0.3 * half, "{aspect}: {up} up");
        }
    }
}
