//! The view in the main world: when it is captured, and what each frame of it shows.

use super::frame::{
    CaptureRequest, CaptureResult, CaptureSource, FieldMap, PerceptFrame, PerceptReturn,
    SceneCamera,
};
use super::gpu_data::{FORGET, PerceptUniform, default_voxel_angle_rad, pixels_per_radian};
use super::places::{candidates_of, direction_of, distance_m, unseen_places};
use super::sharpness_field::SharpnessClock;
use super::visual_field::VisualField;
use crate::anatomy::{Eyelids, GazeController, Glaucoma, Lens, Pupil, SharpnessField};
use crate::app::session::PatientMarker;
use crate::app::{Panels, Session, SimulationClock};
use crate::motion::{Candidates, visual_field};
use crate::readiness::Readiness;
use crate::scene::catalog::LoadedScene;
use crate::scene::model::{EyePlacement, SceneModel};
use crate::scene::photo_view::photo_images;
use crate::scene::spawn::{
    SCENE_LAYER, ScenePart, ambient, anisotropy, mean_luminance, spawn_model,
};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraMainTextureUsages, ClearColorConfig, Exposure, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use wgpu_types::DeviceType;

/// Near plane of the scene camera, m: a page held before the eye is still drawn.
pub const NEAR_M: f32 = 0.02;
/// Largest side of the scene's picture that every device takes.
const LARGEST_TEXTURE: u32 = 8192;
/// Below this opening of the lids nothing new is seen.
const SEEING_APERTURE: f64 = 0.25;
/// Brightness of the picture against its mean luminance: the mean becomes this shade of grey.
const MIDDLE_GREY: f64 = 0.30;
/// Texels of the visual-field map along a side, and half the angle it covers.
const FIELD_SIDE: u32 = 64;
const FIELD_HALF_DEG: f32 = 40.0;

/// What the user chooses about the view.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ViewOptions {
    /// Draw a ring where the eye looks?
    pub marker: bool,
    /// FAST threshold for candidates, 0 to 255.
    pub threshold: u8,
    /// Scene texels a view pixel along each axis, 1 to 4. The picture of a view is drawn once, so
    /// it may be drawn well; a software rasteriser makes even that once a wait.
    pub supersampling: u32,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            marker: false,
            threshold: 20,
            supersampling: 2,
        }
    }
}

/// How far the capture of the present view has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// The view differs from what was captured.
    #[default]
    Wanted,
    /// Asked for; the answer is on its way.
    Asked,
    /// Captured.
    Done,
}

/// The view's state.
#[derive(Resource, Default)]
pub struct Percept {
    stage: Stage,
    serial: u64,
    size: UVec2,
    scene_version: u64,
    restarts: u64,
    scale: u32,
    forget_scene: bool,
    waited: u32,
    forget: bool,
    photo: Option<(Handle<Image>, Handle<Image>)>,
    placement: EyePlacement,
    clock: SharpnessClock,
    clock_s: f64,
    epoch: u64,
    field: Option<FieldMap>,
    field_of: Option<crate::anatomy::PatientFile>,
    shown: Option<PerceptUniform>,
    captured: CaptureResult,
}

impl Percept {
    /// The captured view: corners and vergence.
    pub fn captured(&self) -> &CaptureResult {
        &self.captured
    }

    /// Is the present view captured?
    pub fn is_captured(&self) -> bool {
        self.stage == Stage::Done
    }

    /// Tangents of half the field of a view of this size: the scene's angle spans its smaller side.
    pub fn half_field(&self, size: UVec2) -> Vec2 {
        let half = (0.5 * self.placement.vertical_fov_deg.to_radians()).tan();
        let aspect = size.x as f32 / size.y as f32;
        if aspect >= 1.0 {
            Vec2::new(half * aspect, half)
        } else {
            Vec2::new(half, half / aspect)
        }
    }

    /// Direction (azimuth, elevation, rad) and distance (m) of a place of the view, in its pixels.
    pub fn look_at(&self, place: Vec2) -> (f64, f64, f64) {
        let size = self.captured.size;
        let (azimuth, elevation) = direction_of(place, size, self.half_field(size));
        let pixel = place
            .clamp(Vec2::ZERO, (size.as_vec2() - 1.0).max(Vec2::ZERO))
            .as_uvec2();
        let at = (pixel.y * size.x + pixel.x) as usize;
        let vergence = self.captured.vergence_d.get(at).copied().unwrap_or(0.0);
        (azimuth, elevation, distance_m(vergence))
    }
}

/// Unit direction of gaze in the view's frame.
fn gaze_direction(azimuth_rad: f64, elevation_rad: f64) -> [f32; 3] {
    [
        (azimuth_rad.sin() * elevation_rad.cos()) as f32,
        elevation_rad.sin() as f32,
        (-azimuth_rad.cos() * elevation_rad.cos()) as f32,
    ]
}

type OldScene = Or<(With<ScenePart>, With<SceneCamera>)>;

/// Spawns the scene that is looked at, when it changes.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are the stores that it fills"
)]
pub fn load_scene(
    session: Res<Session>,
    readiness: Res<Readiness>,
    adapter: Option<Res<RenderAdapterInfo>>,
    mut percept: ResMut<Percept>,
    old: Query<Entity, OldScene>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    if percept.scene_version == session.scene_version {
        return;
    }
    percept.scene_version = session.scene_version;
    percept.stage = Stage::Wanted;
    percept.size = UVec2::ZERO;
    percept.forget_scene = true;
    percept.photo = None;
    for entity in &old {
        commands.entity(entity).despawn();
    }
    readiness.restart();
    match &*session.scene {
        LoadedScene::Model(model) => {
            percept.placement = model.eye;
            let device = adapter.map_or(DeviceType::Other, |adapter| adapter.device_type);
            spawn_model(
                model,
                anisotropy(device),
                &mut commands,
                &mut meshes,
                &mut materials,
                &mut images,
            );
            commands.spawn(scene_camera(model));
        }
        LoadedScene::Photo(photo) => {
            percept.placement = EyePlacement {
                vertical_fov_deg: photo.vertical_fov_deg,
                ..EyePlacement::default()
            };
        }
    }
}

fn scene_camera(model: &SceneModel) -> impl Bundle {
    let (color, brightness) = ambient(model);
    let eye = Vec3::from(model.eye.position_m);
    let background = model.background;
    // Bevy's exposure is 1 / (1.2 · 2^EV): choose it so that the picture holds luminance itself
    // over the mean, which half floats resolve.
    let unit = mean_luminance(model);
    let scaled = |c: f32| c / unit;
    (
        SceneCamera,
        Camera3d {
            depth_texture_usages: (TextureUsages::RENDER_ATTACHMENT
                | TextureUsages::TEXTURE_BINDING)
                .into(),
            ..default()
        },
        Camera {
            order: -1,
            is_active: false,
            clear_color: ClearColorConfig::Custom(Color::linear_rgb(
                scaled(background[0]),
                scaled(background[1]),
                scaled(background[2]),
            )),
            ..default()
        },
        Hdr,
        Exposure {
            ev100: (unit / 1.2).log2(),
        },
        CameraMainTextureUsages::default(),
        AmbientLight {
            color,
            brightness,
            ..default()
        },
        Msaa::Off,
        Tonemapping::None,
        // One tap of four texels: a browser may run on a software rasteriser, and cannot say so.
        #[cfg(target_arch = "wasm32")]
        bevy::light::ShadowFilteringMethod::Hardware2x2,
        Transform::from_translation(eye)
            .looking_to(Vec3::from(model.eye.forward), Vec3::from(model.eye.up)),
        RenderLayers::layer(SCENE_LAYER),
    )
}

/// Takes in a finished capture: candidates for the eye, distances for the user's pointer.
pub fn receive(
    returned: Res<PerceptReturn>,
    session: Res<Session>,
    mut percept: ResMut<Percept>,
    mut candidates: ResMut<Candidates>,
    mut clock: ResMut<SimulationClock>,
) {
    let Some(result) = returned.take() else {
        return;
    };
    if result.serial != percept.serial || percept.stage != Stage::Asked {
        return;
    }
    percept.captured = result;
    percept.stage = Stage::Done;
    percept.forget_scene = false;
    percept.shown = None;
    candidates.list = candidates_of(&percept, session.seed);
    let middle = percept.captured.size.as_vec2() * 0.5;
    candidates.ahead_distance_m = percept.look_at(middle).2;
    candidates.version += 1;
    clock.ready = true;
}

type SceneCameraParts<'a> = (&'a mut Camera, &'a mut Projection, &'a mut RenderTarget);

/// Asks for a capture when scene or size changed, as soon as everything that it shows is built.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads and drives"
)]
pub fn drive_capture(
    panels: Res<Panels>,
    session: Res<Session>,
    readiness: Res<Readiness>,
    options: Res<ViewOptions>,
    returned: Res<PerceptReturn>,
    mut clock: ResMut<SimulationClock>,
    mut candidates: ResMut<Candidates>,
    mut percept: ResMut<Percept>,
    mut images: ResMut<Assets<Image>>,
    mut camera: Query<SceneCameraParts, With<SceneCamera>>,
) {
    let size = panels.view.size;
    if !panels.view.visible {
        // Candidates only matter to an eye that looks about by itself; it may do so unseen, but
        // the very first view is needed for the clock to start.
        for (mut camera, _, _) in &mut camera {
            camera.is_active = false;
        }
        if !clock.ready && readiness.quiet_frames() >= 3 {
            // An eye that is shown alone still looks about; no pass of the view runs for it.
            (candidates.list, candidates.ahead_distance_m) =
                unseen_places(&session.scene, session.seed);
            candidates.version += 1;
            clock.ready = true;
        }
        return;
    }
    let scale = supersampling(size, &options);
    if percept.size != size || percept.scale != scale {
        percept.size = size;
        percept.scale = scale;
        percept.stage = Stage::Wanted;
        percept.waited = 0;
        readiness.restart();
        match &*session.scene {
            LoadedScene::Model(_) => {
                let picture = images.add(picture_image(size * scale));
                let half = percept.half_field(size);
                for (_, mut projection, mut target) in &mut camera {
                    *target = RenderTarget::Image(picture.clone().into());
                    *projection = Projection::Perspective(PerspectiveProjection {
                        fov: 2.0 * half.y.atan(),
                        near: NEAR_M,
                        far: 1000.0,
                        ..default()
                    });
                }
            }
            LoadedScene::Photo(photo) => {
                let (colour, vergence, half_vertical) = photo_images(photo, size);
                // Cropping to the panel's shape narrows the field.
                percept.placement.vertical_fov_deg = half_vertical;
                percept.photo = Some((images.add(colour), images.add(vergence)));
            }
        }
    }
    // The camera draws twice: once so that its pipelines are asked for, once for the capture.
    if percept.stage == Stage::Wanted && readiness.quiet_frames() >= 3 {
        percept.stage = Stage::Asked;
        percept.serial += 1;
        percept.waited = 0;
    } else {
        percept.waited += 1;
    }
    let drawing = match percept.stage {
        Stage::Wanted => percept.waited <= 2,
        // Until it is recorded: its pipelines may be late. The answer takes longer.
        Stage::Asked => returned.recorded() < percept.serial,
        Stage::Done => false,
    };
    for (mut camera, _, _) in &mut camera {
        if camera.is_active != drawing {
            camera.is_active = drawing;
        }
    }
}

/// What was asked for, as far as the largest texture allows.
fn supersampling(size: UVec2, options: &ViewOptions) -> u32 {
    let most = LARGEST_TEXTURE / size.max_element().max(1);
    options.supersampling.clamp(1, most.max(1))
}

fn picture_image(size: UVec2) -> Image {
    let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba16Float, None);
    image.asset_usage = bevy::asset::RenderAssetUsages::RENDER_WORLD;
    image.data = None;
    image
}

/// What of the patient decides what is seen.
type SeeingParts<'a> = (
    &'a GazeController,
    &'a Pupil,
    &'a Lens,
    &'a Eyelids,
    &'a SharpnessField,
    Option<&'a Glaucoma>,
);

/// The frame of the view: what the passes are to do, if anything.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads"
)]
pub fn perceive(
    panels: Res<Panels>,
    session: Res<Session>,
    clock: Res<SimulationClock>,
    options: Res<ViewOptions>,
    readiness: Res<Readiness>,
    mut percept: ResMut<Percept>,
    patient: Query<SeeingParts, With<PatientMarker>>,
    mut commands: Commands,
) {
    let Ok((gaze, pupil, lens, lids, field, glaucoma)) = patient.single() else {
        return;
    };
    let percept = &mut *percept;
    if percept.restarts != session.restarts {
        percept.restarts = session.restarts;
        percept.clock = SharpnessClock::default();
        percept.clock_s = 0.0;
        percept.epoch = 0;
        percept.forget = true;
        percept.shown = None;
    }
    let mut rebase_steps = FORGET;
    let passed = (clock.time_s - percept.clock_s).max(0.0);
    percept.clock_s = clock.time_s;
    if let Some(rebase) = percept.clock.advance(passed, field.starve_rate_per_s) {
        rebase_steps = rebase.steps;
    }
    while percept.epoch < lids.blink_epoch {
        percept.epoch += 1;
        if percept.clock.blink().is_some() {
            percept.forget = true;
        }
    }
    percept.epoch = percept.epoch.min(lids.blink_epoch);
    update_field_map(percept, &session, glaucoma.is_some());

    let size = percept.captured.size;
    // Until a panel of another size has its own capture, it shows the old one.
    let stands_in = percept.stage == Stage::Wanted
        && percept.captured.serial == percept.serial
        && size != UVec2::ZERO
        && size != panels.view.size
        && !percept.forget_scene;
    let drawn = if stands_in { size } else { panels.view.size };
    let mut uniform = static_uniform(percept, drawn, &options);
    uniform.target_size = panels.view.size.as_vec2().to_array();
    uniform.fixation = gaze_direction(gaze.azimuth_rad, gaze.elevation_rad);
    uniform.focus_vergence_d = lens.accommodation_d as f32;
    uniform.refraction_d = lens.spherical_equivalent_d as f32;
    uniform.pupil_m = (pupil.diameter_mm * 1e-3) as f32;
    uniform.lid_aperture = lids.aperture as f32;
    uniform.epoch = u32::from(percept.clock.epoch());
    uniform.starve_steps = percept.clock.starve_steps();
    uniform.rebase_steps = rebase_steps;
    uniform.coc_cap_rad = field.blur_cap_rad as f32;
    uniform.voxel_size_m = field.voxel_m as f32;
    if options.marker && !stands_in {
        place_marker(&mut uniform, gaze, panels.view.size);
    }
    if glaucoma.is_some() {
        glaucoma_numbers(&mut uniform, &session);
    }

    let visible = panels.view.visible;
    if rebase_steps != FORGET && !(visible && percept.stage == Stage::Done) {
        // Nobody will shift the old keys now, and unshifted they would read as perfectly sharp.
        percept.forget = true;
    }
    if percept.forget {
        uniform.rebase_steps = FORGET;
    }
    let captured = percept.stage == Stage::Done && size == panels.view.size;
    let capture = (visible && percept.stage == Stage::Asked).then(|| CaptureRequest {
        serial: percept.serial,
        source: match &percept.photo {
            Some((colour, vergence)) => CaptureSource::Photo {
                colour: colour.clone(),
                vergence: vergence.clone(),
            },
            None => CaptureSource::Scene,
        },
        forget: percept.forget_scene,
    });
    // During a saccade vision is suppressed, and behind closed lids there is none.
    if readiness.quiet_frames() < 3 {
        // A pass whose pipeline is not built yet is skipped, so what was asked for may not be shown.
        percept.shown = None;
    }
    let first = percept.shown.is_none();
    // A new view is looked at once all the same, or its voxels that an older view left unseen would
    // stand between those that it saw.
    let seeing = lids.aperture > SEEING_APERTURE && (!gaze.in_saccade || first);
    let changed = percept.shown.as_ref() != Some(&uniform);
    let frame = PerceptFrame {
        visible,
        update: visible && captured && (clock.moved || first) && seeing,
        present: visible && (captured || stands_in) && (changed || percept.forget),
        forget: captured && percept.forget,
        uniform,
        capture,
        glaucoma: percept.field.clone(),
        target: panels.view.image.clone(),
    };
    if frame.present {
        percept.shown = Some(uniform);
        percept.forget = false;
    }
    commands.insert_resource(frame);
}

fn static_uniform(percept: &Percept, size: UVec2, options: &ViewOptions) -> PerceptUniform {
    let half = percept.half_field(size);
    let forward = Vec3::from(percept.placement.forward).normalize_or(Vec3::NEG_Z);
    let right = forward
        .cross(Vec3::from(percept.placement.up))
        .normalize_or(Vec3::X);
    let up = right.cross(forward);
    let pixels = pixels_per_radian(size.x, half.x);
    let photo = percept.photo.is_some();
    // A picture of a scene holds luminance over its mean; a photograph is shown as it is.
    let exposure = if photo { 1.0 } else { MIDDLE_GREY as f32 };
    PerceptUniform {
        right: right.to_array(),
        tan_half_fov_x: half.x,
        up: up.to_array(),
        tan_half_fov_y: half.y,
        back: (-forward).to_array(),
        near_m: NEAR_M,
        eye_m: [0.0; 3],
        size: size.to_array(),
        supersampling: if photo {
            1
        } else {
            supersampling(size, options)
        },
        fast_threshold: u32::from(options.threshold),
        pixels_per_radian: pixels,
        voxel_angle_rad: default_voxel_angle_rad(pixels),
        exposure,
        luma_exposure: exposure,
        target_size: size.as_vec2().to_array(),
        field_half_width_rad: FIELD_HALF_DEG.to_radians(),
        display_referred: u32::from(photo),
        ..PerceptUniform::default()
    }
}

fn place_marker(uniform: &mut PerceptUniform, gaze: &GazeController, size: UVec2) {
    let [x, y, z] = gaze_direction(gaze.azimuth_rad, gaze.elevation_rad);
    if z < -0.05 {
        let u = x / -z / uniform.tan_half_fov_x;
        let v = y / -z / uniform.tan_half_fov_y;
        uniform.marker = [
            (0.5 + 0.5 * u) * size.x as f32,
            (0.5 - 0.5 * v) * size.y as f32,
        ];
        uniform.marker_radius_px = (size.min_element() as f32 * 0.022).max(5.0);
    }
}

/// What glaucoma adds beyond the lost field itself (Nießner 2013, section 3: the penalty).
fn glaucoma_numbers(uniform: &mut PerceptUniform, session: &Session) {
    let factor = visual_field(&session.patient).map_or(1.0, |field| field.glaucoma_factor());
    // The healthy slope is one minute of arc in E2; the uniform adds what exceeds it.
    let slope = uniform.neural_floor_rad / uniform.eccentricity_e2_rad;
    uniform.eccentricity_penalty = (factor as f32 - 1.0).max(0.0) * slope;
    uniform.loss_blur_rad = 1.6_f32.to_radians();
    uniform.loss_darkening = 0.28;
    uniform.loss_desaturation = 0.5;
}

fn update_field_map(percept: &mut Percept, session: &Session, wanted: bool) {
    if !wanted {
        percept.field = None;
        percept.field_of = None;
        return;
    }
    if percept.field_of.as_ref() == Some(&session.patient) {
        return;
    }
    let Some(field) = visual_field(&session.patient) else {
        return;
    };
    percept.field_of = Some(session.patient.clone());
    percept.field = Some(FieldMap {
        version: percept.field.as_ref().map_or(1, |map| map.version + 1),
        side: FIELD_SIDE,
        seen: Arc::new(field_texels(&field)),
    });
}

fn field_texels(field: &VisualField) -> Vec<f32> {
    let angle = |i: u32| {
        let share = (f64::from(i) + 0.5) / f64::from(FIELD_SIDE) * 2.0 - 1.0;
        (share * f64::from(FIELD_HALF_DEG)).to_radians()
    };
    (0..FIELD_SIDE)
        .flat_map(|row| {
            (0..FIELD_SIDE).map(move |column| field.seen(angle(column), -angle(row)) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_map_has_the_highest_row_first_and_left_first() {
        let field = VisualField::glaucoma(
            crate::anatomy::GlaucomaStage::Moderate,
            crate::anatomy::Laterality::OD,
            60.0,
        );
        let texels = field_texels(&field);
        let at = |column: usize, row: usize| texels[row * FIELD_SIDE as usize + column];
        let degrees = |i: usize| (i as f64 + 0.5) / 64.0 * 80.0 - 40.0;
        // The texel of (+10.6°, +15.6°).
        let expected = field.seen(degrees(40).to_radians(), (-degrees(19)).to_radians()) as f32;
        assert_eq!(at(40, 19), expected);
        assert!(texels.iter().all(|&seen| (0.0..=1.0).contains(&seen)));
        assert!(texels.iter().any(|&seen| seen < 0.5) && texels.iter().any(|&seen| seen > 0.9));
    }
}
