//! The camera that looks at the eye, and when it draws.

use super::model::{EyeAssets, EyeParts, METRES_A_MM};
use super::shading::iris_relief::{IRIS_MARCH_FAST, IRIS_MARCH_FIXED, IRIS_MARCH_FULL, IrisMarch};
use crate::frame::Panel;
use crate::frame::ledger::WorkLedger;
use crate::frame::readiness::Readiness;
use bevy::camera::{ClearColorConfig, RenderTarget, visibility::RenderLayers};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::camera::ExtractedCamera;
use bevy::render::extract_component::{ExtractComponent, ExtractComponentPlugin};
use bevy::render::renderer::ViewQuery;
use core::ops::RangeInclusive;

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

/// What an eye camera looks at, in the head's frame from the globe's centre, mm: a little behind the cornea.
const TARGET_MM: Vec3 = Vec3::new(0.0, 0.0, -10.5);

/// How the iris of an eye is computed. How far each is from paths of light: `ocularium measure iris-picture`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
pub enum EyeShading {
    /// Where it is seen, by steps of the size of what a pixel shows and five segments behind the border layer, light's way to each of
    /// which is looked along: for rasterisers on processors.
    Fast,
    /// The same by more steps and eight segments.
    #[default]
    Full,
    /// By 64 steps and 64 segments everywhere, in the pupil too: what the others are measured against.
    FixedSteps,
}

impl EyeShading {
    /// What it is called in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Full => "full",
            Self::FixedSteps => "fixed-steps",
        }
    }

    /// How the iris is followed.
    pub fn march(self) -> IrisMarch {
        match self {
            Self::Fast => IRIS_MARCH_FAST,
            Self::Full => IRIS_MARCH_FULL,
            Self::FixedSteps => IRIS_MARCH_FIXED,
        }
    }
}

/// How finely an eye camera draws.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
pub struct EyeQuality {
    /// Samples a pixel. Software rasterisers take three times as long for four.
    pub msaa: Msaa,
    /// How the iris is computed. Where several cameras look at one eye, the costliest is used for all.
    pub shading: EyeShading,
}

impl EyeQuality {
    /// One sample a pixel and the quickest iris: for rasterisers on processors.
    pub const PLAIN: Self = Self {
        msaa: Msaa::Off,
        shading: EyeShading::Fast,
    };
}

impl Default for EyeQuality {
    fn default() -> Self {
        Self {
            msaa: Msaa::Sample4,
            shading: EyeShading::Full,
        }
    }
}

/// A camera that looks at an eye in the world, this [`super::EyeModel`], into its own [`Panel`]. It draws
/// only when the picture has changed.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect, ExtractComponent)]
#[reflect(Component)]
#[require(EyeOrbit, EyeQuality, Drawn)]
pub struct EyeCamera(#[entities] pub Entity);

/// Where an eye camera stands: on a sphere about the eye.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct EyeOrbit {
    /// To the patient's right, degrees, −85 to 85.
    pub azimuth_deg: f32,
    /// Up, degrees, −80 to 80.
    pub elevation_deg: f32,
    /// Distance from the cornea, mm, [`Self::DISTANCES_MM`].
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
    /// How far from the cornea it may stand, mm.
    pub const DISTANCES_MM: RangeInclusive<f32> = 35.0..=1000.0;

    /// Keeps every number in its range.
    pub fn clamped(self) -> Self {
        let finite = |value: f32, or: f32| if value.is_finite() { value } else { or };
        Self {
            azimuth_deg: finite(self.azimuth_deg, 0.0).clamp(-85.0, 85.0),
            elevation_deg: finite(self.elevation_deg, 0.0).clamp(-80.0, 80.0),
            distance_mm: finite(self.distance_mm, 93.0)
                .clamp(*Self::DISTANCES_MM.start(), *Self::DISTANCES_MM.end()),
        }
    }

    /// Unit direction from the eye to the camera, head frame.
    pub fn direction(self) -> Vec3 {
        let (azimuth, elevation) = (
            self.azimuth_deg.to_radians(),
            self.elevation_deg.to_radians(),
        );
        Vec3::new(
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            -azimuth.cos() * elevation.cos(),
        )
    }

    /// Where the camera stands in the head's frame, from the globe's centre, mm.
    pub fn place_mm(self) -> Vec3 {
        TARGET_MM + self.direction() * (self.distance_mm + 2.0)
    }

    /// Where the camera stands in the space of the eye, m.
    fn transform(self) -> Transform {
        let target = TARGET_MM * METRES_A_MM;
        Transform::from_translation(self.place_mm() * METRES_A_MM).looking_at(target, Vec3::Y)
    }
}

/// A camera that looks at this eye, with all that it needs to draw into its panel.
pub fn eye_camera(model: Entity, panel: Panel, layers: RenderLayers) -> impl Bundle {
    (
        EyeCamera(model),
        Camera3d::default(),
        Camera {
            order: -2,
            is_active: false,
            clear_color: ClearColorConfig::Custom(Color::linear_rgb(0.030, 0.027, 0.026)),
            ..default()
        },
        RenderTarget::Image(panel.image.clone().into()),
        panel,
        Msaa::Sample4,
        Tonemapping::None,
        layers,
    )
}

/// What of a camera its aim depends on, and changes.
type Aiming<'a> = (
    &'a EyeCamera,
    &'a EyeOrbit,
    &'a Panel,
    &'a mut Transform,
    &'a mut Projection,
);

/// Puts the cameras where their orbits say, wherever their eyes hang, with fields that fit their panels'
/// shapes. A model's scale makes the way to it longer, not the camera larger.
pub fn aim_cameras(
    mut transforms: ParamSet<(TransformHelper, Query<Aiming>)>,
    cameras: Query<(Entity, &EyeCamera)>,
) {
    let places: Vec<_> = cameras
        .iter()
        .map(|(camera, eye)| {
            let helper = transforms.p0();
            (camera, helper.compute_global_transform(eye.0).ok())
        })
        .collect();
    let mut aiming = transforms.p1();
    for (entity, place) in places {
        let Ok((_, orbit, panel, mut transform, mut projection)) = aiming.get_mut(entity) else {
            continue;
        };
        let place = place.unwrap_or_default();
        let own = orbit.clamped().transform();
        transform.set_if_neq(Transform {
            translation: place.transform_point(own.translation),
            rotation: place.rotation() * own.rotation,
            scale: Vec3::ONE,
        });
        let fov = vertical_field(panel.size.x as f32 / panel.size.y as f32);
        let current = match &*projection {
            Projection::Perspective(perspective) => perspective.fov,
            _ => 0.0,
        };
        if current != fov {
            *projection = Projection::Perspective(PerspectiveProjection {
                fov,
                near: 5.0 * METRES_A_MM,
                far: 2000.0 * METRES_A_MM,
                ..default()
            });
        }
    }
}

/// What a camera's last drawn frame showed; a frame that would show the same is not drawn.
#[derive(Component, Default, Reflect)]
#[reflect(Component, from_reflect = false)]
pub struct Drawn {
    #[reflect(ignore)]
    orbit: Option<EyeOrbit>,
    #[reflect(ignore)]
    size: UVec2,
    #[reflect(ignore)]
    msaa: Option<Msaa>,
    /// The eye has changed since.
    #[reflect(ignore)]
    is_stale: bool,
    #[reflect(ignore)]
    settled: bool,
    #[reflect(ignore)]
    unsettled_frames: u32,
    /// What was drawn when all of it was there: which building of the eye, how finely.
    #[reflect(ignore)]
    whole: Option<(u64, EyeQuality)>,
}

/// What of a camera decides whether it draws.
type Drawing<'a> = (
    &'a EyeCamera,
    &'a EyeOrbit,
    &'a EyeQuality,
    &'a Panel,
    &'a mut Drawn,
    &'a mut Camera,
    &'a mut Msaa,
);

/// Wakes the cameras in frames in which something changed.
pub fn wake_cameras(
    models: Query<Ref<EyeParts>>,
    readiness: Res<Readiness>,
    mut cameras: Query<Drawing>,
) {
    // Until every pipeline exists and every texture has arrived, a frame is drawn to ask for them
    // and one when they are there; those between would show nothing.
    let settled = readiness.quiet_frames() >= 3;
    for (eye, orbit, quality, panel, mut drawn, mut camera, mut msaa) in &mut cameras {
        let drawn = &mut *drawn;
        let Ok(parts) = models.get(eye.0) else {
            // An eye that is gone leaves an empty picture, which is drawn once.
            let awake = panel.visible && (drawn.orbit.is_some() || drawn.size != panel.size);
            if camera.is_active != awake {
                camera.is_active = awake;
            }
            if awake {
                *drawn = Drawn {
                    size: panel.size,
                    ..default()
                };
            }
            continue;
        };
        drawn.is_stale |= parts.is_changed();
        drawn.unsettled_frames = if settled {
            0
        } else {
            drawn.unsettled_frames + 1
        };
        let changed = drawn.orbit != Some(*orbit)
            || drawn.size != panel.size
            || drawn.is_stale
            || drawn.msaa != Some(quality.msaa)
            || (settled && !drawn.settled);
        // What others wait for, such as the view for a window's new size, is not the eye's to wait for.
        let this = Some((
            parts.built(),
            EyeQuality {
                shading: parts.shading,
                ..*quality
            },
        ));
        let may = settled || drawn.unsettled_frames <= 2 || drawn.whole == this;
        let awake = panel.visible && changed && may;
        msaa.set_if_neq(quality.msaa);
        if camera.is_active != awake {
            camera.is_active = awake;
        }
        if awake {
            *drawn = Drawn {
                orbit: Some(*orbit),
                size: panel.size,
                msaa: Some(quality.msaa),
                is_stale: false,
                settled,
                unsettled_frames: drawn.unsettled_frames,
                whole: if settled { this } else { drawn.whole },
            };
        }
    }
}

/// Computes each iris as the most demanding of the cameras that look at it wants it.
pub fn choose_shading(
    cameras: Query<(&EyeCamera, &EyeQuality)>,
    mut models: Query<(Entity, &mut EyeParts)>,
    mut assets: EyeAssets,
) {
    for (model, mut parts) in &mut models {
        let own = cameras.iter().filter(|(camera, _)| camera.0 == model);
        let wanted = own.map(|(_, quality)| quality.shading).max();
        let wanted = wanted.unwrap_or_default();
        if parts.shading == wanted {
            continue;
        }
        let parts = &mut *parts;
        parts.shading = wanted;
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.shading = wanted;
            }
        }
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
