//! The oculomotor engine as a Bevy plugin: it reads the clock and moves the eyes of every person.

use super::attention::Candidate;
use super::engine::{GazeCommand, Oculomotor, OculomotorState};
use super::settings::{MotionError, OculomotorSettings, PupilMode};
use super::trace::TraceRow;
use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::{
    Accommodation, Adaptation, Cornea, Effective, Eye, EyeFinder, EyeOf, Eyelids, Eyes, Gaze, Iris,
    Laterality, Lens, PUPIL_RANGE_MM, Patient, Pupil, PupilControl, Refraction, VisualField,
};
use crate::frame::{EyeSystems, SimulationClock};
use crate::optics::accommodation::hofstetter_amplitude_d;
use bevy::prelude::*;
use std::collections::VecDeque;

/// Seconds of trace that are kept for a strip.
const STRIP_S: f64 = 12.0;

/// Solid angle, in square degrees, of the field that drives the pupil: a room all around.
const ADAPTING_FIELD_DEG2: f64 = 900.0;

/// Where a person could look: on her entity, written by her view when it has searched it.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Candidates {
    /// The list.
    pub list: Vec<Candidate>,
    /// Distance of what lies straight ahead, m, above 0, may be infinite; 0 while unknown.
    pub ahead_distance_m: f64,
}

/// What a user asks of gaze, lids and pupils; everybody in the world obeys. One person is told by the
/// methods of her [`GazeController`].
#[derive(Message, Clone, Debug)]
pub enum MotionCommand {
    /// Gaze.
    Gaze(GazeCommand),
    /// Blink now.
    Blink,
    /// Hold the entrance pupil at this diameter, mm, or let it follow light.
    Pupil(Option<f64>),
}

/// What moves a person's eyes and lids: her oculomotor engine, and what it has done.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque, Component)]
pub struct GazeController {
    /// The engine of the leading eye, which the other follows.
    engine: Oculomotor,
    state: OculomotorState,
    strip: VecDeque<TraceRow>,
    fresh: bool,
    /// Why it last kept its settings: said once.
    refused: Option<String>,
}

impl Default for GazeController {
    fn default() -> Self {
        Self::new(OculomotorSettings::default()).unwrap_or_else(|error| {
            // The defaults are in range, as a test shows.
            unreachable!("{error}")
        })
    }
}

impl GazeController {
    /// A controller with these settings. Age, amplitude, far point and light are then kept as the
    /// person's components say.
    ///
    /// # Errors
    /// [`MotionError`] when a setting is out of range.
    pub fn new(settings: OculomotorSettings) -> Result<Self, MotionError> {
        let engine = Oculomotor::new(settings)?;
        Ok(Self {
            state: engine.state(),
            engine,
            strip: VecDeque::new(),
            fresh: true,
            refused: None,
        })
    }

    /// A controller whose random choices come from this seed.
    pub fn with_seed(seed: u64) -> Self {
        let mut controller = Self::default();
        controller.restart(seed);
        controller
    }

    /// The engine, to be asked about the future.
    pub fn engine(&self) -> &Oculomotor {
        &self.engine
    }

    /// Gaze, pupil, lens and lids of the leading eye at the clock's time. The pupil is the entrance
    /// pupil.
    pub fn state(&self) -> &OculomotorState {
        &self.state
    }

    /// The last seconds of it.
    pub fn strip(&self) -> &VecDeque<TraceRow> {
        &self.strip
    }

    /// Seed of every random choice.
    pub fn seed(&self) -> u64 {
        self.engine.settings().seed
    }

    /// Starts again at time 0 with this seed.
    pub fn restart(&mut self, seed: u64) {
        self.strip.clear();
        self.engine.reset(seed);
        self.fresh = true;
    }

    /// Changes how the eyes move from now on.
    ///
    /// # Errors
    /// [`MotionError`] when a setting is out of range; the old ones stay.
    pub fn set_settings(&mut self, settings: OculomotorSettings) -> Result<(), MotionError> {
        self.engine.set_settings(settings)
    }

    /// Tells the eyes at a time (s) where to look.
    ///
    /// # Errors
    /// [`MotionError`] when the time or an angle is not finite or a distance is not above 0.
    pub fn command(&mut self, time_s: f64, command: GazeCommand) -> Result<(), MotionError> {
        self.engine.command(time_s, command)
    }

    /// A voluntary blink at a time (s).
    ///
    /// # Errors
    /// [`MotionError`] when the time is not finite.
    pub fn blink(&mut self, time_s: f64) -> Result<(), MotionError> {
        self.engine.blink_now(time_s)
    }

    fn advance(&mut self, clock: &SimulationClock) {
        if clock.ready {
            self.engine.advance_to(clock.time_s);
        }
        self.state = self.engine.state();
        if !clock.moved {
            return;
        }
        self.strip.push_back(TraceRow::from(&self.state));
        let before = clock.time_s - STRIP_S;
        while self.strip.front().is_some_and(|row| row.time_s < before) {
            self.strip.pop_front();
        }
    }
}

/// Adds the engine.
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Candidates>()
            .add_message::<MotionCommand>()
            .add_systems(Update, give_controllers.in_set(EyeSystems::Sense))
            .add_systems(
                Update,
                (hold_pupils, decide).chain().in_set(EyeSystems::Decide),
            )
            .add_systems(Update, move_eyes.in_set(EyeSystems::Move));
    }
}

/// Everybody moves, each by her own seed.
fn give_controllers(
    still: Query<(Entity, &Patient), Without<GazeController>>,
    mut commands: Commands,
) {
    for (entity, patient) in &still {
        commands.entity(entity).insert((
            GazeController::with_seed(patient.seed),
            Candidates::default(),
        ));
    }
}

/// What of a leading eye its engine works with.
type LeadingEye<'a> = (
    Option<&'a Lens>,
    &'a Effective<Refraction>,
    Option<Ref<'a, VisualField>>,
);

/// The engine's settings with what a person's components say; one that she has not says what is usual.
fn settings_of(
    now: &OculomotorSettings,
    patient: &Patient,
    control: Option<&PupilControl>,
    adaptation: Option<&Adaptation>,
    lens: Option<&Lens>,
    refraction: &Refraction,
) -> OculomotorSettings {
    let control = control.copied().unwrap_or_default();
    let adaptation = adaptation.copied().unwrap_or_default();
    let lens = lens.copied().unwrap_or_default();
    OculomotorSettings {
        age_years: patient.age_years,
        accommodation_amplitude_d: lens
            .amplitude_d
            .unwrap_or_else(|| hofstetter_amplitude_d(patient.age_years)),
        far_point_d: -refraction.spherical_equivalent_d(),
        pupil: match control.diameter_mm() {
            Some(diameter_mm) => PupilMode::Manual(diameter_mm),
            None => PupilMode::Auto {
                luminance_cd_m2: adaptation.luminance_cd_m2,
                field_deg2: ADAPTING_FIELD_DEG2,
                both_eyes: true,
            },
        },
        ..now.clone()
    }
}

/// Holds pupils, or lets them go.
fn hold_pupils(mut asked: MessageReader<MotionCommand>, mut pupils: Query<&mut PupilControl>) {
    for command in asked.read() {
        if let MotionCommand::Pupil(held_mm) = command {
            let held_mm = *held_mm;
            let (smallest, largest) = PUPIL_RANGE_MM;
            if let Some(diameter_mm) = held_mm
                && !(smallest..=largest).contains(&diameter_mm)
            {
                warn!(
                    "a pupil of {diameter_mm} mm is not held: {smallest} to {largest} mm are allowed"
                );
                continue;
            }
            for mut control in &mut pupils {
                if control.held_mm != held_mm {
                    control.held_mm = held_mm;
                }
            }
        }
    }
}

/// What of a person her engine works with.
type Mover<'a> = (
    Entity,
    &'a mut GazeController,
    Option<Ref<'a, Candidates>>,
    Ref<'a, Patient>,
    Option<&'a PupilControl>,
    Option<&'a Adaptation>,
);

/// Hands the engines what is new: anatomy, light, candidates, the user's commands.
fn decide(
    clock: Res<SimulationClock>,
    mut asked: MessageReader<MotionCommand>,
    mut movers: Query<Mover>,
    finder: EyeFinder,
    eyes: Query<LeadingEye>,
) {
    let commands: Vec<_> = asked.read().cloned().collect();
    for (entity, mut controller, candidates, patient, control, adaptation) in &mut movers {
        let Some((lens, refraction, field)) =
            finder.find(entity).and_then(|(eye, _)| eyes.get(eye).ok())
        else {
            continue;
        };
        let controller = &mut *controller;
        let fresh = std::mem::take(&mut controller.fresh);
        let now = controller.engine.settings();
        let wanted = settings_of(now, &patient, control, adaptation, lens, &refraction.0);
        if fresh || wanted != *now {
            let why = controller.engine.set_settings(wanted).err();
            let why = why.map(|error| error.to_string());
            if let Some(error) = &why
                && controller.refused != why
            {
                warn!("{} keeps how she moves: {error}", patient.name);
            }
            controller.refused = why;
            if fresh {
                let seed = controller.seed();
                controller.engine.reset(seed);
            }
        }
        match field {
            Some(field) if fresh || field.is_changed() || patient.is_changed() => {
                let lost = (!field.is_whole()).then(|| (*field).clone());
                controller.engine.set_visual_field(lost);
            }
            Some(_) => {}
            // Whose field is gone has a whole one.
            None => controller.engine.set_visual_field(None),
        }
        if let Some(candidates) = candidates
            && (fresh || candidates.is_changed())
        {
            controller
                .engine
                .set_ahead_distance(candidates.ahead_distance_m);
            controller.engine.set_candidates(candidates.list.clone());
        }
        for command in &commands {
            let outcome = match command {
                MotionCommand::Gaze(gaze) => controller.engine.command(clock.time_s, *gaze),
                MotionCommand::Blink => controller.engine.blink_now(clock.time_s),
                MotionCommand::Pupil(_) => Ok(()),
            };
            if let Err(error) = outcome {
                warn!("the eye ignores a command: {error}");
            }
        }
    }
}

/// What moves of an eye.
type Moving<'a> = (
    &'a Eye,
    &'a EyeOf,
    &'a Cornea,
    &'a Effective<Iris>,
    &'a mut Gaze,
    &'a mut Pupil,
    &'a mut Accommodation,
);

/// Moves the engines to the clock's time, and lids and eyes to their poses.
fn move_eyes(
    clock: Res<SimulationClock>,
    mut people: Query<(&mut GazeController, &mut Eyelids, &Patient), With<Eyes>>,
    mut eyes: Query<Moving>,
) {
    for (mut controller, mut lids, _) in &mut people {
        // What moves in every frame is no news to anybody.
        controller.bypass_change_detection().advance(&clock);
        let state = &controller.state;
        lids.set_if_neq(Eyelids {
            aperture: state.lid_aperture,
            blinking: state.blinking,
            blink_epoch: state.blink_epoch,
        });
    }
    for (eye, owner, cornea, iris, mut gaze, mut pupil, mut accommodation) in &mut eyes {
        let Ok((controller, _, patient)) = people.get(owner.0) else {
            continue;
        };
        let state = &controller.state;
        gaze.set_if_neq(gaze_of(state, eye.laterality, patient));
        // Both pupils are driven alike; the hole is what the cornea magnifies to this diameter.
        pupil.set_if_neq(Pupil {
            diameter_mm: state.pupil_mm / cornea.pupil_magnification(iris.0.depth_mm),
        });
        accommodation.set_if_neq(Accommodation {
            response_d: state.accommodation_d,
        });
    }
}

/// Where one eye looks: the leading one as its engine says, the other at the same point.
fn gaze_of(state: &OculomotorState, eye: Laterality, patient: &Patient) -> Gaze {
    let leading = Gaze {
        azimuth_rad: state.gaze_azimuth_rad,
        elevation_rad: state.gaze_elevation_rad,
        torsion_rad: state.gaze_torsion_rad,
    };
    if eye == patient.leading {
        return leading;
    }
    // From the leading eye to this one, in units of the fixated point's distance.
    let aside = eye.temporal_sign() * patient.interpupillary_mm * 1e-3 * state.vergence_per_m;
    let towards = leading.direction() - bevy::math::DVec3::X * aside;
    Gaze::towards(GazeAngles::of(towards).within_range())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_eyes_look_at_the_same_point() {
        let patient = Patient::default();
        let state = OculomotorState {
            gaze_azimuth_rad: 0.2,
            gaze_elevation_rad: -0.1,
            vergence_per_m: 1.0 / 0.4,
            ..*GazeController::default().state()
        };
        let [right, left] = Laterality::BOTH.map(|eye| gaze_of(&state, eye, &patient));
        let point = right.direction() * 0.4;
        // The left eye stands 63 mm to the left.
        let from_left = point + bevy::math::DVec3::X * 0.063;
        assert!((from_left.normalize() - left.direction()).length() < 1e-12);
        assert!(left.azimuth_rad > right.azimuth_rad + 0.1, "they converge");
        let far = OculomotorState {
            vergence_per_m: 0.0,
            ..state
        };
        let parallel = gaze_of(&far, Laterality::OS, &patient);
        assert!((parallel.direction() - right.direction()).length() < 1e-12);
    }
}
