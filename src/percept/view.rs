//! The view of one camera in the main world: when it is captured, and what each frame of it shows.

use super::frame::{
    CaptureRequest, CaptureResult, CaptureSource, FieldMap, PerceptFrame, PerceptReturn,
};
use super::gpu_data::{
    FORGET, MediaUniform, PerceptUniform, default_voxel_angle_rad, mip_levels, pixels_per_radian,
};
use super::memory::SharpnessField;
use super::movers::{Moved, MoverData};
use super::places::{candidates_of, direction_of, distance_m, from_the_other_eye};
use super::sees_as::{SeesAs, Worn};
use super::sight::{CameraLook, Look, SceneChanges};
use crate::anatomy::{
    Accommodation, Cornea, Effective, Eye, EyeFinder, Eyelids, Gaze, Iris, Lids, OcularMedia,
    Patient, Pupil, Refraction, VisualField,
};
use crate::appearance::lid_edges::lid_edges;
use crate::frame::readiness::Readiness;
use crate::frame::{Panel, SimulationClock};
use crate::motion::{Candidates, GazeController};
use crate::optics::glare::Veil;
use crate::scene::photo::PhotoScene;
use crate::scene::photo_view::{Photograph, photo_images};
use bevy::camera::RenderTarget;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::reflect::ReflectComponent;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Near plane of a view's camera, m: a page held before the eye is still drawn.
pub const NEAR_M: f32 = 0.02;
/// Largest side of the scene's picture that every device takes.
const LARGEST_TEXTURE: u32 = 8192;
/// Below this opening of the lids nothing new is seen.
const SEEING_APERTURE: f64 = 0.25;
/// Frames without a pipeline under way after which what is drawn is whole.
const QUIET_FRAMES: usize = 3;
/// First mip level that is part of a veil: what is scattered by less is no veil yet.
const FIRST_VEIL_LEVEL: u32 = 1;
/// Texels of the visual-field map along a side, and half the angle it covers.
const FIELD_SIDE: u32 = 64;
const FIELD_HALF_DEG: f32 = 40.0;

/// What is shown where nothing is seen any more: people with field loss report blurred and missing parts,
/// not black ones (Crabb et al. 2013, who do not measure how blurred: these three are choices). Blur,
/// share of the light and share of the colour that are gone.
const LOSS_BLUR_DEG: f32 = 1.6;
const LOSS_DARKENING: f32 = 0.28;
const LOSS_DESATURATION: f32 = 0.5;

/// What a user chooses about a view, on its camera.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct ViewOptions {
    /// Is the view drawn at all? One that is not costs nothing and remembers what was seen.
    pub is_shown: bool,
    /// Draw a ring where the eye looks?
    pub marker: bool,
    /// FAST threshold for candidates, 0 to 255.
    pub threshold: u8,
    /// Scene texels a view pixel along each axis, 1 to 4. The picture of a view is drawn once, so
    /// it may be drawn well; a software rasteriser makes even that once a wait.
    pub supersampling: u32,
    /// Factor on what the camera's own exposure leaves, before the output transform; a photograph
    /// is shown as it is.
    pub exposure: f32,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            is_shown: true,
            marker: false,
            threshold: 20,
            supersampling: 2,
            exposure: 1.0,
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

/// What a capture was asked to do, beside making the view static.
#[derive(Clone, Debug, Default)]
struct Asked {
    /// Forget everything that was remembered?
    forget: bool,
    /// What has moved.
    moved: Moved,
}

/// A photograph as it was laid out for a view.
#[derive(Debug)]
struct LaidOut {
    photo: Arc<PhotoScene>,
    colour: Handle<Image>,
    vergence: Handle<Image>,
    /// Tangent of half the angle that the view's smaller side spans.
    tan_half: f32,
}

/// From where, and how wide, a view looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sight {
    /// World from camera, without its scale.
    pose: Isometry3d,
    /// Tangents of half the field.
    half: Vec2,
    /// Near plane, m.
    near_m: f32,
}

/// The state of the view of one camera.
#[derive(Component, Debug)]
pub struct Percept {
    /// Which view this is, in the order in which they were made.
    born: u64,
    stage: Stage,
    serial: u64,
    size: UVec2,
    scale: u32,
    waited: u32,
    /// What is seen is another scene: nothing remembered applies, and time waits for it.
    is_new: bool,
    /// Captured while something was not built yet: to be captured again.
    is_unfinished: bool,
    /// Captured while the answer to an earlier capture was on its way: its own will not come.
    is_unread: bool,
    forget: bool,
    lifetime: u64,
    /// Asked for by [`Percept::take_again`].
    is_outdated: bool,
    /// The voxels of the memory are divided otherwise than those of the next capture.
    forget_voxels: bool,
    /// What was asked for last.
    asked: Asked,
    /// What has moved in it as it is to be captured next, and by name that of which it keeps something.
    moved: Moved,
    known_movers: HashSet<u32>,
    /// Who knows where she may look in it.
    told: Option<Entity>,
    /// How its camera drew it.
    look: Look,
    /// Threshold, exposure and edge of a voxel with which it was captured.
    taken_with: (u8, f32, f64),
    /// The target that was drawn into last, and whether as nobody's view.
    drawn_into: Option<(Handle<Image>, UVec2, bool)>,
    photo: Option<LaidOut>,
    sight: Sight,
    /// Where the eye was when the memory began: the origin of its voxels, m.
    origin: Vec3,
    field: Option<FieldMap>,
    /// What clouded media do to the light, and of which media in a view of what size that is.
    media: Option<(OcularMedia, [u32; 2], f32, MediaUniform)>,
    shown: Option<(PerceptUniform, Option<MediaUniform>)>,
    captured: CaptureResult,
    captured_half: Vec2,
    returned: PerceptReturn,
}

impl Default for Percept {
    fn default() -> Self {
        static BORN: AtomicU64 = AtomicU64::new(0);
        Self {
            born: BORN.fetch_add(1, Ordering::Relaxed),
            stage: Stage::Wanted,
            serial: 0,
            size: UVec2::ZERO,
            scale: 1,
            waited: 0,
            is_new: true,
            is_unfinished: false,
            is_unread: false,
            forget: false,
            lifetime: 0,
            is_outdated: false,
            forget_voxels: false,
            asked: Asked::default(),
            moved: Moved::default(),
            known_movers: HashSet::default(),
            told: None,
            look: Look::default(),
            taken_with: (0, 0.0, 0.0),
            drawn_into: None,
            photo: None,
            sight: Sight::default(),
            origin: Vec3::ZERO,
            field: None,
            media: None,
            shown: None,
            captured: CaptureResult::default(),
            captured_half: Vec2::ONE,
            returned: PerceptReturn::default(),
        }
    }
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

    /// Tangents of half the field of the captured view.
    pub fn half_field(&self) -> Vec2 {
        self.captured_half
    }

    /// What is before the camera is another scene, of which nothing is remembered; to be called after
    /// it was put there.
    pub fn begin_scene(&mut self) {
        self.stage = Stage::Wanted;
        self.size = UVec2::ZERO;
        self.is_new = true;
        self.photo = None;
    }

    /// Takes the picture again, for a change that nobody else notices: of a material of one's own, say.
    pub fn take_again(&mut self) {
        self.is_outdated = true;
    }

    /// Direction (azimuth, elevation, rad) and distance (m) of a place of the view, in its pixels.
    pub fn look_at(&self, place: Vec2) -> (f64, f64, f64) {
        let size = self.captured.size;
        let (azimuth, elevation) = direction_of(place, size, self.captured_half);
        let pixel = place
            .clamp(Vec2::ZERO, (size.as_vec2() - 1.0).max(Vec2::ZERO))
            .as_uvec2();
        let at = (pixel.y * size.x + pixel.x) as usize;
        let vergence = self.captured.vergence_d.get(at).copied().unwrap_or(0.0);
        (azimuth, elevation, distance_m(vergence))
    }

    /// Asks for a capture of the view as it is now. What changes before it is recorded asks for another:
    /// the device may have been given this one already.
    fn ask(&mut self) {
        self.stage = Stage::Asked;
        self.serial += 1;
        self.is_outdated = false;
        self.asked = Asked {
            forget: self.is_new || self.forget_voxels,
            moved: self.moved.clone(),
        };
        self.forget_voxels = false;
        // From now on the memory keeps something of each of these under its name, and of no other.
        self.known_movers = self.moved.here.iter().map(MoverData::name).collect();
        self.is_unread = false;
        self.waited = 0;
        self.captured_half = self.sight.half;
    }

    /// [`media_uniform`], worked out where something has changed.
    fn media_uniform(&mut self, media: &OcularMedia, uniform: &PerceptUniform) -> MediaUniform {
        let scale = uniform.pixels_per_radian;
        match &self.media {
            Some((of, size, at, known)) if (of, *size, *at) == (media, uniform.size, scale) => {
                *known
            }
            _ => {
                let found = media_uniform(media, uniform);
                self.media = Some((*media, uniform.size, scale, found));
                found
            }
        }
    }

    /// Has the capture that was asked for last been recorded?
    fn is_recorded(&self) -> bool {
        self.returned.recorded() >= self.serial
    }
}

/// What comes back to a view, and to whom it is told.
type Receiving<'a> = (
    &'a SeesAs,
    &'a Worn,
    &'a ViewOptions,
    &'a mut Percept,
    Option<&'a Panel>,
);

/// Takes in finished captures: candidates for the eye, distances for the user's pointer.
pub(super) fn receive(
    mut views: Query<Receiving>,
    mut people: Query<(&GazeController, &Patient, Option<&mut Candidates>)>,
    mut has_come: Local<bool>,
    readiness: Res<Readiness>,
    finder: EyeFinder,
    mut clock: ResMut<SimulationClock>,
    mut commands: Commands,
) {
    // Who is seen through by several cameras chooses by the first that was made, of those that have seen.
    let mut first: HashMap<Entity, (bool, u64)> = HashMap::default();
    for (sees, _, options, percept, panel) in &views {
        if let Some((_, patient)) = finder.find(sees.0)
            && is_shown(options, panel)
        {
            let own = (percept.is_new, percept.born);
            let chosen = first.entry(patient).or_insert(own);
            *chosen = (*chosen).min(own);
        }
    }
    let (mut is_waiting, mut can_see) = (false, false);
    for (sees, worn, options, mut percept, panel) in &mut views {
        let mut is_news = false;
        let own = (percept.is_new, percept.born);
        if let Some(result) = percept.returned.take()
            && result.serial > percept.captured.serial
            && percept.stage != Stage::Wanted
        {
            let is_last = result.serial == percept.serial;
            // The answer to the last one would have been on its way by now.
            percept.is_unread = !is_last && percept.is_recorded();
            percept.captured = result;
            if is_last && percept.stage == Stage::Asked {
                percept.stage = Stage::Done;
                percept.is_new = false;
                percept.shown = None;
            }
            *has_come = true;
            is_news = true;
        }
        let found = finder.find(sees.0);
        // A camera that sees as another now has news for her.
        if let Some((eye, patient)) = found
            && (is_news || (percept.told != Some(patient) && !percept.is_new))
            && first.get(&patient) == Some(&own)
            && let Ok((controller, person, candidates)) = people.get_mut(patient)
        {
            percept.told = Some(patient);
            let middle = percept.captured.size.as_vec2() * 0.5;
            let mut found = Candidates {
                list: candidates_of(&percept, controller.seed()),
                ahead_distance_m: percept.look_at(middle).2,
            };
            if let Some(side) = finder.laterality(eye)
                && side != person.leading
            {
                for candidate in &mut found.list {
                    *candidate = from_the_other_eye(candidate, side, person);
                }
            }
            match candidates {
                Some(mut candidates) => *candidates = found,
                None => {
                    commands.entity(patient).insert(found);
                }
            }
        }
        // A view of nobody, or of no size, has no answer to wait for.
        let sees_something = worn.size() != UVec2::ZERO && found.is_some();
        can_see |= sees_something;
        is_waiting |= sees_something && percept.is_new && is_shown(options, panel);
    }
    // Where nobody can see there are only the pipelines to wait for.
    let is_blind = !can_see && readiness.quiet_frames() >= QUIET_FRAMES;
    if (*has_come && !is_waiting) || is_blind {
        *has_come = false;
        clock.ready = true;
    }
}

/// Is a view drawn, if there is anybody to see?
fn is_shown(options: &ViewOptions, panel: Option<&Panel>) -> bool {
    options.is_shown && panel.is_none_or(|panel| panel.visible)
}

/// The parts of a camera that a capture needs.
type Capturing<'a> = (
    &'a SeesAs,
    &'a mut Worn,
    &'a ViewOptions,
    CameraLook,
    &'a GlobalTransform,
    Option<&'a Panel>,
    Option<&'a Photograph>,
    Option<&'a RenderLayers>,
    Ref<'a, Projection>,
    &'a mut Percept,
    &'a mut Camera,
    &'a mut RenderTarget,
);

/// Asks for captures where size, sight or scene have changed, as soon as everything that they show is
/// built.
pub(super) fn drive_captures(
    readiness: Res<Readiness>,
    changes: Res<SceneChanges>,
    clear: Option<Res<ClearColor>>,
    finder: EyeFinder,
    people: Query<&SharpnessField>,
    mut images: ResMut<Assets<Image>>,
    mut views: Query<Capturing>,
) {
    let is_recolored = clear.is_some_and(|clear| clear.is_changed());
    for (
        sees,
        mut worn,
        options,
        look,
        transform,
        panel,
        photo,
        layers,
        projection,
        mut percept,
        mut camera,
        mut target,
    ) in &mut views
    {
        let size = worn.size();
        let memory = finder
            .find(sees.0)
            .and_then(|(_, patient)| people.get(patient).ok());
        let drawing = match memory {
            Some(memory) if is_shown(options, panel) && size != UVec2::ZERO => {
                let percept = &mut *percept;
                let is_resized = lay_out(
                    percept,
                    photo,
                    size,
                    options,
                    &readiness,
                    &mut images,
                    (&mut worn, &mut target),
                );
                let sight = sight_of(percept, transform, &projection);
                let is_photo = percept.photo.is_some();
                let taken_with = (options.threshold, options.exposure, memory.voxel_m);
                // Voxels of another size are another memory.
                percept.forget_voxels |= percept.taken_with.2 != taken_with.2;
                let mut has_changed =
                    is_resized || percept.is_outdated || taken_with != percept.taken_with;
                if !is_photo {
                    has_changed |= sight != percept.sight
                        || changes.touch(layers)
                        || is_recolored
                        || look.has_changed(&camera, &mut percept.look);
                }
                percept.sight = sight;
                percept.taken_with = taken_with;
                // Until it has been asked for.
                percept.is_outdated = has_changed;
                if percept.is_new && percept.stage == Stage::Wanted {
                    percept.origin = percept.sight.pose.translation.into();
                }
                if (has_changed || percept.stage == Stage::Wanted) && !is_photo {
                    let (origin, known) = (percept.origin, &percept.known_movers);
                    let knows = |name| known.contains(&name);
                    percept.moved = changes.movers().seen_by(layers, origin, knows);
                }
                let quiet = readiness.quiet_frames() >= QUIET_FRAMES;
                drive(percept, has_changed, quiet) && !is_photo
            }
            _ => false,
        };
        if camera.is_active != drawing {
            camera.is_active = drawing;
        }
    }
}

/// Gives a view its size and its photograph; says whether it has another picture of the size that it had.
fn lay_out(
    percept: &mut Percept,
    photo: Option<&Photograph>,
    size: UVec2,
    options: &ViewOptions,
    readiness: &Readiness,
    images: &mut Assets<Image>,
    (worn, target): (&mut Worn, &mut RenderTarget),
) -> bool {
    let scale = match photo {
        Some(_) => 1,
        None => supersampling(size, options),
    };
    let is_same_photo = match (photo, &percept.photo) {
        (Some(photo), Some(laid)) => Arc::ptr_eq(&photo.0, &laid.photo),
        (photo, laid) => photo.is_none() && laid.is_none(),
    };
    let is_resized = percept.size != size || percept.scale != scale;
    if !is_resized && is_same_photo {
        return false;
    }
    percept.size = size;
    percept.scale = scale;
    match photo {
        None => {
            percept.photo = None;
            let picture = images.add(picture_image(size * scale));
            worn.draw_into(picture, scale as f32, target);
        }
        Some(photo) => {
            let (colour, vergence, smaller_deg) = photo_images(&photo.0, size);
            percept.photo = Some(LaidOut {
                photo: photo.0.clone(),
                colour: images.add(colour),
                vergence: images.add(vergence),
                tan_half: (0.5 * smaller_deg.to_radians()).tan(),
            });
        }
    }
    if is_resized {
        percept.stage = Stage::Wanted;
        percept.waited = 0;
        readiness.restart();
    }
    !is_resized
}

/// From where and how wide a view looks now.
fn sight_of(percept: &Percept, transform: &GlobalTransform, projection: &Projection) -> Sight {
    let size = percept.size.as_vec2();
    let aspect = size.x / size.y;
    let half = match (&percept.photo, projection) {
        (Some(laid), _) => Vec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0)) * laid.tan_half,
        (None, Projection::Perspective(lens)) => {
            let up = (0.5 * lens.fov).tan();
            Vec2::new(up * aspect, up)
        }
        // An eye has no other projection; what such a camera draws is taken for one of 60°.
        (None, _) => {
            warn_once!("a camera that sees as an eye does must be perspective");
            let up = (0.5 * 60f32.to_radians()).tan();
            Vec2::new(up * aspect, up)
        }
    };
    let near_m = match projection {
        Projection::Perspective(lens) => lens.near,
        _ => NEAR_M,
    };
    Sight {
        pose: transform.to_isometry(),
        half,
        near_m,
    }
}

/// The next step of a view's capture; says whether its camera draws in this frame.
fn drive(percept: &mut Percept, has_changed: bool, quiet: bool) -> bool {
    match percept.stage {
        // The camera draws twice: once so that its pipelines are asked for, once for the capture.
        Stage::Wanted if quiet => percept.ask(),
        Stage::Wanted => percept.waited += 1,
        Stage::Asked if (has_changed || percept.is_unread) && percept.is_recorded() => {
            percept.ask()
        }
        Stage::Asked => percept.captured_half = percept.sight.half,
        Stage::Done if has_changed => {
            percept.is_unfinished = !quiet;
            percept.ask();
        }
        Stage::Done if percept.is_unfinished && quiet => {
            percept.is_unfinished = false;
            percept.ask();
        }
        Stage::Done => {}
    }
    match percept.stage {
        Stage::Wanted => percept.waited <= 2,
        // Until it is recorded: its pipelines may be late. The answer takes longer.
        Stage::Asked => !percept.is_recorded(),
        Stage::Done => false,
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
    // Its first picture has nothing to be copied from.
    image.copy_on_resize = false;
    image
}

/// What of an eye decides what it sees.
type SeeingEye<'a> = (
    &'a Eye,
    &'a Gaze,
    &'a Pupil,
    &'a Accommodation,
    &'a Effective<Refraction>,
    &'a Cornea,
    &'a Effective<Iris>,
    &'a Effective<Lids>,
    Option<Ref<'a, VisualField>>,
    Option<&'a OcularMedia>,
);

/// What of a person decides what her eyes see.
type Seer<'a> = (&'a Eyelids, &'a SharpnessField, &'a GazeController);

/// The parts of a camera that its frame is made from.
type Framing<'a> = (
    &'a SeesAs,
    &'a Worn,
    Option<&'a Panel>,
    &'a ViewOptions,
    &'a mut Percept,
    &'a mut PerceptFrame,
);

/// The frame of every view: what the passes are to do, if anything.
pub(super) fn perceive(
    clock: Res<SimulationClock>,
    readiness: Res<Readiness>,
    finder: EyeFinder,
    eyes: Query<SeeingEye>,
    people: Query<Seer>,
    mut views: Query<Framing>,
) {
    let quiet = readiness.quiet_frames() >= QUIET_FRAMES;
    for (sees, worn, panel, options, mut percept, mut frame) in &mut views {
        let Some(target) = worn.image() else {
            *frame = PerceptFrame::default();
            continue;
        };
        let found = finder
            .find(sees.0)
            .and_then(|(eye, patient)| Some((eyes.get(eye).ok()?, people.get(patient).ok()?)));
        let into = Some((target.clone(), worn.size(), found.is_none()));
        if percept.drawn_into != into {
            percept.drawn_into = into;
            percept.shown = None;
        }
        let visible = is_shown(options, panel) && worn.size() != UVec2::ZERO;
        let Some((eye, person)) = found else {
            if finder.find(sees.0).is_some() {
                warn_once!(
                    "somebody is seen through who is not whole: an eye needs a Cornea and an Iris, as a patient file gives them"
                );
            }
            // Who sees again sees anew.
            percept.begin_scene();
            *frame = PerceptFrame {
                blank: visible && percept.shown.is_none(),
                target: target.clone(),
                ..PerceptFrame::default()
            };
            percept.shown = visible.then(Default::default);
            continue;
        };
        let shows = Shows {
            visible,
            size: worn.size(),
            moved: clock.moved,
            quiet,
        };
        *frame = frame_of(&mut percept, &shows, options, eye, person, target);
    }
}

/// What of panel and clock decides a frame.
struct Shows {
    visible: bool,
    size: UVec2,
    moved: bool,
    quiet: bool,
}

fn frame_of(
    percept: &mut Percept,
    shows: &Shows,
    options: &ViewOptions,
    (eye, gaze, pupil, accommodation, refraction, cornea, iris, own_lids, field, media): <SeeingEye<'_> as bevy::ecs::query::QueryData>::Item<'_, '_>,
    (lids, memory, controller): <Seer<'_> as bevy::ecs::query::QueryData>::Item<'_, '_>,
    target: &Handle<Image>,
) -> PerceptFrame {
    if percept.lifetime != memory.lifetime() {
        percept.lifetime = memory.lifetime();
        percept.forget = true;
        percept.shown = None;
    }
    update_field_map(percept, field.as_ref());
    let size = percept.captured.size;
    // Until a panel of another size has its own capture, it shows the old one.
    let stands_in = percept.stage == Stage::Wanted
        && percept.captured.serial == percept.serial
        && size != UVec2::ZERO
        && size != shows.size
        && !percept.is_new;
    // What has changed but in size is captured and shown in the same frame.
    let follows = percept.stage == Stage::Asked && size == shows.size && !percept.is_new;
    let (drawn, half) = if stands_in {
        (size, percept.captured_half)
    } else {
        (shows.size, percept.sight.half)
    };
    let mut uniform = static_uniform(percept, drawn, half, options);
    uniform.target_size = shows.size.as_vec2().to_array();
    uniform.fixation = gaze.direction().as_vec3().to_array();
    uniform.focus_vergence_d = accommodation.response_d as f32;
    uniform.refraction_d = refraction.0.spherical_equivalent_d() as f32;
    let entrance_mm = pupil.diameter_mm * cornea.pupil_magnification(iris.0.depth_mm);
    uniform.pupil_m = (entrance_mm * 1e-3) as f32;
    let aperture = lids.aperture * own_lids.0.opening;
    let edges = lid_edges(eye, cornea, iris.0.depth_mm, gaze, aperture);
    uniform.upper_lid_mm = edges.upper.height_mm as f32;
    uniform.upper_lid_ahead_mm = edges.upper.ahead_mm as f32;
    uniform.lower_lid_mm = edges.lower.height_mm as f32;
    uniform.lower_lid_ahead_mm = edges.lower.ahead_mm as f32;
    uniform.epoch = u32::from(memory.clock().epoch());
    uniform.starve_steps = memory.clock().starve_steps();
    uniform.rebase_steps = memory.rebase_steps();
    uniform.coc_cap_rad = memory.blur_cap_rad as f32;
    uniform.voxel_size_m = memory.voxel_m as f32;
    if options.marker && !stands_in {
        place_marker(&mut uniform, gaze, shows.size);
    }
    if let Some(field) = field.filter(|field| !field.is_whole()) {
        loss_numbers(&mut uniform, &field);
    }

    let visible = shows.visible;
    if uniform.rebase_steps != FORGET && !(visible && percept.stage == Stage::Done) {
        // Nobody will shift the old keys now, and unshifted they would read as perfectly sharp.
        percept.forget = true;
    }
    if percept.forget {
        uniform.rebase_steps = FORGET;
    }
    let captured = percept.stage == Stage::Done && size == shows.size;
    let is_asked = visible && percept.stage == Stage::Asked && !percept.is_recorded();
    let capture = is_asked.then(|| CaptureRequest {
        serial: percept.serial,
        source: match &percept.photo {
            Some(laid) => CaptureSource::Photo {
                colour: laid.colour.clone(),
                vergence: laid.vergence.clone(),
            },
            None => CaptureSource::Scene,
        },
        forget: percept.asked.forget,
        moved: percept.asked.moved.clone(),
    });
    if !shows.quiet {
        // A pass whose pipeline is not built yet is skipped, so what was asked for may not be shown.
        percept.shown = None;
    }
    let first = percept.shown.is_none();
    // During a saccade vision is suppressed, and behind closed lids there is none. A new view is looked
    // at once all the same, or its voxels that an older view left unseen would stand between those that
    // it saw.
    let seeing = aperture > SEEING_APERTURE && (!controller.state().in_saccade || first);
    let media = media
        .filter(|media| !media.is_clear())
        .map(|media| percept.media_uniform(media, &uniform));
    let changed = percept.shown != Some((uniform, media)) || capture.is_some();
    let frame = PerceptFrame {
        visible,
        update: visible
            && (captured || follows)
            && (shows.moved || first || capture.is_some())
            && seeing,
        present: visible && (captured || stands_in || follows) && (changed || percept.forget),
        forget: (captured || follows) && percept.forget,
        uniform,
        capture,
        field_loss: percept.field.clone(),
        media,
        blank: false,
        target: target.clone(),
        returned: percept.returned.clone(),
    };
    if frame.present {
        percept.shown = Some((uniform, media));
        percept.forget = false;
    }
    frame
}

fn static_uniform(
    percept: &Percept,
    size: UVec2,
    half: Vec2,
    options: &ViewOptions,
) -> PerceptUniform {
    let pose = &percept.sight.pose;
    let pixels = pixels_per_radian(size.x, half.x);
    let photo = percept.photo.is_some();
    // A picture of a scene holds what the camera's exposure leaves; a photograph is shown as it is.
    let exposure = if photo { 1.0 } else { options.exposure };
    let eye = Vec3::from(pose.translation) - percept.origin;
    PerceptUniform {
        right: (pose.rotation * Vec3::X).to_array(),
        tan_half_fov_x: half.x,
        up: (pose.rotation * Vec3::Y).to_array(),
        tan_half_fov_y: half.y,
        back: (pose.rotation * Vec3::Z).to_array(),
        near_m: percept.sight.near_m,
        eye_m: eye.to_array(),
        size: size.to_array(),
        supersampling: percept.scale,
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

fn place_marker(uniform: &mut PerceptUniform, gaze: &Gaze, size: UVec2) {
    let [x, y, z] = gaze.direction().as_vec3().to_array();
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

/// What clouded media do to the light of a view with these numbers.
fn media_uniform(media: &OcularMedia, uniform: &PerceptUniform) -> MediaUniform {
    let veil = Veil::new(media.straylight, media.pigment);
    // The last is one texel, which says no more than the one before.
    let last = mip_levels(uniform.size[0], uniform.size[1]).saturating_sub(2);
    let first = FIRST_VEIL_LEVEL.min(last);
    let (weights, rest) = veil.weights(
        uniform.pixels_per_radian.into(),
        uniform.size,
        first as usize,
        last as usize,
    );
    MediaUniform {
        weights: std::array::from_fn(|row| {
            std::array::from_fn(|column| weights[4 * row + column] as f32)
        }),
        transmittance: media.transmittance().to_array(),
        scattered: veil.scattered() as f32,
        rest: rest as f32,
        first_level: first,
        last_level: last,
        unused: 0,
    }
}

/// What a lost field adds beyond what is not seen (Nießner 2013, section 3: the penalty).
fn loss_numbers(uniform: &mut PerceptUniform, field: &VisualField) {
    // The healthy slope is one minute of arc in E2; the uniform adds what exceeds it.
    let slope = uniform.neural_floor_rad / uniform.eccentricity_e2_rad;
    uniform.eccentricity_penalty = (field.eccentricity_factor() as f32 - 1.0).max(0.0) * slope;
    uniform.loss_blur_rad = LOSS_BLUR_DEG.to_radians();
    uniform.loss_darkening = LOSS_DARKENING;
    uniform.loss_desaturation = LOSS_DESATURATION;
}

fn update_field_map(percept: &mut Percept, field: Option<&Ref<VisualField>>) {
    let Some(field) = field.filter(|field| !field.is_whole()) else {
        percept.field = None;
        return;
    };
    if percept.field.as_ref().is_some_and(|map| *map.of == **field) {
        return;
    }
    percept.field = Some(FieldMap {
        of: Arc::new((**field).clone()),
        side: FIELD_SIDE,
        seen: Arc::new(field_texels(field)),
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
        let field = crate::conditions::glaucoma::glaucoma_field(
            crate::conditions::GlaucomaStage::Moderate,
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
