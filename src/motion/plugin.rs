//! The oculomotor engine as a Bevy plugin: it reads the clock and writes the patient.

use super::engine::{Candidate, GazeCommand, Oculomotor, OculomotorState};
use super::settings::{OculomotorSettings, PupilMode};
use super::trace::TraceRow;
use crate::anatomy::{Eyelids, GazeController, Lens, PatientFile, Pupil};
use crate::app::session::PatientMarker;
use crate::app::{EyeSystems, Session, SimulationClock};
use crate::percept::visual_field::VisualField;
use crate::scene::catalog::LoadedScene;
use bevy::prelude::*;
use std::collections::VecDeque;

/// Seconds of trace that the window keeps for its strip.
const STRIP_S: f64 = 12.0;

/// Solid angle, in square degrees, of the field that drives the pupil: a room all around.
const ADAPTING_FIELD_DEG2: f64 = 900.0;

/// Where the eye could look in this view; set by the percept when candidates arrive.
#[derive(Resource, Default)]
pub struct Candidates {
    /// The list.
    pub list: Vec<Candidate>,
    /// Distance of what lies straight ahead, m, above 0, may be infinite; 0 while unknown.
    pub ahead_distance_m: f64,
    /// Counts new lists.
    pub version: u64,
}

/// What the user asks of gaze and lids.
#[derive(Message, Clone, Debug)]
pub enum MotionCommand {
    /// Gaze.
    Gaze(GazeCommand),
    /// Blink now.
    Blink,
    /// Hold the pupil at this diameter, mm, or let it follow light.
    Pupil(Option<f64>),
}

/// The engine that moves the patient.
#[derive(Resource)]
pub struct Motion {
    /// The engine.
    pub engine: Oculomotor,
    /// Its state at the clock's time.
    pub state: OculomotorState,
    /// The last seconds of it, for the strip.
    pub strip: VecDeque<TraceRow>,
    /// Pupil held by the user, mm.
    pub held_pupil_mm: Option<f64>,
    candidates_version: u64,
    restarts: u64,
}

/// Adds the engine.
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Candidates>()
            .add_message::<MotionCommand>()
            .add_systems(Startup, start)
            .add_systems(Update, decide.in_set(EyeSystems::Decide))
            .add_systems(Update, move_patient.in_set(EyeSystems::Move));
    }
}

/// The settings of a session's patient; `held_pupil_mm` overrides the file's pupil.
pub fn settings(session: &Session, held_pupil_mm: Option<f64>) -> OculomotorSettings {
    let patient: &PatientFile = &session.patient;
    OculomotorSettings {
        seed: session.seed,
        accommodation_amplitude_d: patient.amplitude_d(),
        far_point_d: -patient.spherical_equivalent_d(),
        pupil: match held_pupil_mm.or(patient.pupil.diameter_mm()) {
            Some(diameter_mm) => PupilMode::Manual(diameter_mm),
            None => PupilMode::Auto {
                luminance_cd_m2: mean_luminance(&session.scene),
                field_deg2: ADAPTING_FIELD_DEG2,
                both_eyes: true,
            },
        },
        ..OculomotorSettings::for_age(patient.age_years)
    }
}

fn mean_luminance(scene: &LoadedScene) -> f64 {
    match scene {
        LoadedScene::Model(model) => model.mean_luminance_cd_m2,
        LoadedScene::Photo(photo) => photo.mean_luminance_cd_m2,
    }
}

/// The visual field of this patient, if it has lost anything.
pub fn visual_field(patient: &PatientFile) -> Option<VisualField> {
    patient
        .glaucoma
        .map(|stage| VisualField::glaucoma(stage, patient.eye, patient.age_years))
}

fn start(session: Res<Session>, mut commands: Commands) {
    match Oculomotor::new(settings(&session, None)) {
        Ok(mut engine) => {
            engine.set_visual_field(visual_field(&session.patient));
            let state = engine.state();
            commands.insert_resource(Motion {
                engine,
                state,
                strip: VecDeque::new(),
                held_pupil_mm: None,
                candidates_version: 0,
                restarts: 0,
            });
        }
        // The patient file was checked; a refusal here is a defect worth hearing about.
        Err(error) => error!("the eye cannot move: {error}"),
    }
}

/// Hands the engine what is new: session, candidates, the user's commands.
fn decide(
    session: Res<Session>,
    clock: Res<SimulationClock>,
    candidates: Res<Candidates>,
    motion: Option<ResMut<Motion>>,
    mut asked: MessageReader<MotionCommand>,
) {
    let Some(mut motion) = motion else { return };
    if motion.restarts != session.restarts {
        motion.restarts = session.restarts;
        motion.strip.clear();
        motion.candidates_version = 0;
        refresh(&mut motion, &session);
        let seed = session.seed;
        motion.engine.reset(seed);
    }
    if motion.candidates_version != candidates.version {
        motion.candidates_version = candidates.version;
        motion
            .engine
            .set_ahead_distance(candidates.ahead_distance_m);
        motion.engine.set_candidates(candidates.list.clone());
    }
    for command in asked.read() {
        let outcome = match command {
            MotionCommand::Gaze(gaze) => motion.engine.command(clock.time_s, *gaze),
            MotionCommand::Blink => motion.engine.blink_now(clock.time_s),
            MotionCommand::Pupil(held) => {
                motion.held_pupil_mm = *held;
                refresh(&mut motion, &session);
                Ok(())
            }
        };
        if let Err(error) = outcome {
            warn!("the eye ignores a command: {error}");
        }
    }
}

fn refresh(motion: &mut Motion, session: &Session) {
    let settings = settings(session, motion.held_pupil_mm);
    if let Err(error) = motion.engine.set_settings(settings) {
        warn!("the eye keeps its settings: {error}");
    }
    motion
        .engine
        .set_visual_field(visual_field(&session.patient));
}

/// Moves the engine to the clock's time and the patient to the engine's pose.
fn move_patient(
    clock: Res<SimulationClock>,
    motion: Option<ResMut<Motion>>,
    mut patient: Query<
        (&mut GazeController, &mut Pupil, &mut Lens, &mut Eyelids),
        With<PatientMarker>,
    >,
) {
    let Some(mut motion) = motion else { return };
    if clock.ready {
        motion.engine.advance_to(clock.time_s);
    }
    let state = motion.engine.state();
    motion.state = state;
    if clock.moved {
        motion.strip.push_back(TraceRow::from(&state));
        while motion
            .strip
            .front()
            .is_some_and(|row| row.time_s < clock.time_s - STRIP_S)
        {
            motion.strip.pop_front();
        }
    }
    let Ok((mut gaze, mut pupil, mut lens, mut lids)) = patient.single_mut() else {
        return;
    };
    gaze.set_if_neq(GazeController {
        azimuth_rad: state.gaze_azimuth_rad,
        elevation_rad: state.gaze_elevation_rad,
        torsion_rad: state.gaze_torsion_rad,
        fixation_azimuth_rad: state.fixation_azimuth_rad,
        fixation_elevation_rad: state.fixation_elevation_rad,
        fixation_distance_m: state.fixation_distance_m,
        in_saccade: state.in_saccade,
        fixation_index: state.fixation_index,
    });
    if pupil.diameter_mm != state.pupil_mm {
        pupil.diameter_mm = state.pupil_mm;
    }
    if lens.accommodation_d != state.accommodation_d {
        lens.accommodation_d = state.accommodation_d;
    }
    if lids.aperture != state.lid_aperture || lids.blinking != state.blinking {
        lids.aperture = state.lid_aperture;
        lids.blinking = state.blinking;
        lids.blink_epoch = state.blink_epoch;
    }
}
