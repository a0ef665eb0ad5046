//! The view of one camera in the main world: its state, and what comes back of its captures.

use super::capture::sight::Look;
use super::field::movers::{Moved, MoverData};
use super::frame::{CaptureResult, FieldMap, PerceptReturn};
use super::gpu_data::{MediaUniform, PerceptUniform};
use super::places::{candidates_of, direction_of, distance_m, from_the_other_eye};
use super::sees_as::{SeesAs, Worn};
use crate::anatomy::{Adaptation, EyeFinder, Patient};
use crate::frame::readiness::Readiness;
use crate::frame::{Panel, SimulationClock};
use crate::motion::{Candidates, GazeController};
use crate::scene::photo::PhotoScene;
use bevy::ecs::reflect::ReflectComponent;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Near plane of a view's camera, m: a page held before the eye is still drawn.
pub const NEAR_M: f32 = 0.02;
/// Frames without a pipeline under way after which what is drawn is whole.
pub(super) const QUIET_FRAMES: usize = 3;
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
pub(super) enum Stage {
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
pub(super) struct Asked {
    /// Forget everything that was remembered?
    pub(super) forget: bool,
    /// What has moved.
    pub(super) moved: Moved,
}

/// A photograph as it was laid out for a view.
#[derive(Debug)]
pub(super) struct LaidOut {
    pub(super) photo: Arc<PhotoScene>,
    /// Which of its pictures.
    pub(super) picture: usize,
    pub(super) taken_from: Isometry3d,
    pub(super) colour: Handle<Image>,
    pub(super) vergence: Handle<Image>,
    /// Tangent of half the angle that the view's smaller side spans.
    pub(super) tan_half: f32,
}

/// From where, and how wide, a view looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sight {
    /// World from camera, without its scale.
    pub(super) pose: Isometry3d,
    /// Tangents of half the field.
    pub(super) half: Vec2,
    /// Near plane, m.
    pub(super) near_m: f32,
}

/// The state of the view of one camera.
#[derive(Component, Debug, Reflect)]
#[reflect(Component, from_reflect = false)]
pub struct Percept {
    /// Which view this is, in the order in which they were made.
    #[reflect(ignore)]
    pub(super) born: u64,
    #[reflect(ignore)]
    pub(super) stage: Stage,
    #[reflect(ignore)]
    pub(super) serial: u64,
    #[reflect(ignore)]
    pub(super) size: UVec2,
    #[reflect(ignore)]
    pub(super) scale: u32,
    #[reflect(ignore)]
    pub(super) waited: u32,
    /// What Bevy will draw the scene into for captures, while it draws into a small picture.
    #[reflect(ignore)]
    pub(super) full_picture: Option<Handle<Image>>,
    /// The camera draws once more before the capture that was asked for last: see [`activate_for_morphs`](super::capture).
    #[reflect(ignore)]
    pub(super) is_rehearsal: bool,
    /// What is seen is another scene: nothing remembered applies, and time waits for it.
    #[reflect(ignore)]
    pub(super) is_new: bool,
    /// Captured while something was not built yet: to be captured again.
    #[reflect(ignore)]
    pub(super) is_unfinished: bool,
    /// Captured while the answer to an earlier capture was on its way: its own will not come.
    #[reflect(ignore)]
    pub(super) is_unread: bool,
    #[reflect(ignore)]
    pub(super) forget: bool,
    #[reflect(ignore)]
    pub(super) lifetime: u64,
    /// Asked for by [`Percept::take_again`].
    #[reflect(ignore)]
    pub(super) is_outdated: bool,
    /// The voxels of the memory are divided otherwise than those of the next capture.
    #[reflect(ignore)]
    pub(super) forget_voxels: bool,
    /// What was asked for last.
    #[reflect(ignore)]
    pub(super) asked: Asked,
    /// What has moved in it as it is to be captured next, and by name that of which it keeps something.
    #[reflect(ignore)]
    pub(super) moved: Moved,
    #[reflect(ignore)]
    pub(super) known_movers: HashSet<u32>,
    /// Who knows where she may look in it.
    #[reflect(ignore)]
    pub(super) reported_to: Option<Entity>,
    /// How its camera drew it.
    #[reflect(ignore)]
    pub(super) look: Look,
    /// Threshold, exposure and edge of a voxel with which it was captured.
    #[reflect(ignore)]
    pub(super) taken_with: (u8, f32, f64),
    /// The target that was drawn into last, and whether as nobody's view.
    #[reflect(ignore)]
    pub(super) drawn_into: Option<(Handle<Image>, UVec2, bool)>,
    #[reflect(ignore)]
    pub(super) photo: Option<LaidOut>,
    #[reflect(ignore)]
    pub(super) sight: Sight,
    /// Where the eye was when the memory began: the origin of its voxels, m.
    #[reflect(ignore)]
    pub(super) origin: Vec3,
    #[reflect(ignore)]
    pub(super) field: Option<FieldMap>,
    /// How clouded media spread light, and of which pigment (its bits) in a view of what size that is.
    #[reflect(ignore)]
    pub(super) spread: Option<(SpreadOf, MediaUniform)>,
    /// What a nucleus of this density lets through, linear sRGB.
    #[reflect(ignore)]
    pub(super) colour: Option<(f64, [f32; 3])>,
    #[reflect(ignore)]
    pub(super) shown: Option<(PerceptUniform, Option<MediaUniform>)>,
    /// Has the eye looked at this view since it was new? What is merely drawn again, as where another
    /// form of a pass is being built, is not looked at again while time stands still.
    #[reflect(ignore)]
    pub(super) has_looked: bool,
    #[reflect(ignore)]
    pub(super) captured: CaptureResult,
    #[reflect(ignore)]
    pub(super) captured_half: Vec2,
    #[reflect(ignore)]
    pub(super) returned: PerceptReturn,
}

/// On what it depends where clouded media spread light: the pigment's bits, the picture's size and scale.
pub(super) type SpreadOf = (u64, [u32; 2], f32);

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
            full_picture: None,
            is_rehearsal: false,
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
            reported_to: None,
            look: Look::default(),
            taken_with: (0, 0.0, 0.0),
            drawn_into: None,
            photo: None,
            sight: Sight::default(),
            origin: Vec3::ZERO,
            field: None,
            spread: None,
            colour: None,
            shown: None,
            has_looked: false,
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
        self.moved = Moved::default();
    }

    /// Shows, and looks at, the view as a new one.
    pub(super) fn show_anew(&mut self) {
        self.shown = None;
        self.has_looked = false;
    }

    /// Takes the picture again, for a change that nobody else notices: of a texture of a material of one's own, say.
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
    pub(super) fn ask(&mut self) {
        self.stage = Stage::Asked;
        self.serial += 1;
        self.is_outdated = false;
        self.asked = Asked {
            forget: self.is_new || self.forget_voxels,
            moved: self.moved.clone(),
        };
        self.forget_voxels = false;
        // What it left behind is forgotten once.
        self.moved.left = Arc::default();
        // From now on the memory keeps something of each of these under its name, and of no other.
        self.known_movers = self.moved.here.iter().map(MoverData::name).collect();
        self.is_unread = false;
        self.waited = 0;
        self.captured_half = self.sight.half;
    }

    /// Has the capture that was asked for last been recorded?
    pub(super) fn is_recorded(&self) -> bool {
        self.returned.recorded() >= self.serial
    }
}

/// What comes back to a view, and to whom it is reported.
type Receiving<'a> = (
    &'a SeesAs,
    &'a Worn,
    &'a ViewOptions,
    &'a mut Percept,
    Option<&'a Panel>,
);

/// Takes in finished captures: candidates and light for the eye, distances for the user's pointer.
pub(super) fn receive(
    mut views: Query<Receiving>,
    mut people: Query<(
        &GazeController,
        &Patient,
        &mut Adaptation,
        Option<&mut Candidates>,
    )>,
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
        if percept.returned.take_lost() {
            // It is asked for again.
            percept.is_unread = percept.stage == Stage::Asked && percept.is_recorded();
        }
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
                percept.show_anew();
            }
            *has_come = true;
            is_news = true;
        }
        let found = finder.find(sees.0);
        // A camera that sees as another now has news for her.
        if let Some((eye, patient)) = found
            && (is_news || (percept.reported_to != Some(patient) && !percept.is_new))
            && first.get(&patient) == Some(&own)
            && let Ok((controller, person, mut adaptation, candidates)) = people.get_mut(patient)
        {
            percept.reported_to = Some(patient);
            if adaptation.is_measured {
                let luminance_cd_m2 = match &percept.photo {
                    Some(laid) => laid.photo.mean_luminance_cd_m2,
                    None => f64::from(percept.captured.mean_luminance),
                };
                adaptation.set_if_neq(Adaptation {
                    luminance_cd_m2,
                    ..*adaptation
                });
            }
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
pub(super) fn is_shown(options: &ViewOptions, panel: Option<&Panel>) -> bool {
    options.is_shown && panel.is_none_or(|panel| panel.visible)
}
