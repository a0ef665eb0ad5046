//! What the tests that draw share: one app at a time, sessions, and waiting until a view is there.

use bevy::math::UVec2;
use image::RgbaImage;
use ocularium::frame::SimulationClock;
use ocularium::frame::readiness::Readiness;
use ocularium::lab::headless::Headless;
use ocularium::lab::headless::Which;
use ocularium::motion::MotionCommand;
use ocularium::motion::engine::{GazeCommand, Oculomotor, OculomotorState};
use ocularium::patients::{PatientFile, load_patient};
use ocularium::scene::catalog::{BuiltIn, LoadedScene};
use ocularium::stage::{PanelLight, Session};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};

/// How many apps draw at once, at most: what one does on a single thread leaves the software device to another;
/// more only slow each other down.
const MOST_AT_ONCE: usize = 2;

/// One of the places for an app that draws.
pub struct Turn(());

static DRAWING: (Mutex<usize>, Condvar) = (Mutex::new(0), Condvar::new());

/// Waits for a place: hold this while drawing.
pub fn turn() -> Turn {
    let (count, freed) = &DRAWING;
    let count = count.lock().unwrap_or_else(PoisonError::into_inner);
    let mut count = freed
        .wait_while(count, |count| *count >= MOST_AT_ONCE)
        .unwrap_or_else(PoisonError::into_inner);
    *count += 1;
    Turn(())
}

impl Drop for Turn {
    fn drop(&mut self) {
        let (count, freed) = &DRAWING;
        *count.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        freed.notify_one();
    }
}

/// A built-in patient.
pub fn patient(name: &str) -> PatientFile {
    load_patient(name).expect("a built-in patient")
}

/// A patient in the furnished room, which is built once.
pub fn session(patient: PatientFile, seed: u64) -> Session {
    static ROOM: OnceLock<Arc<LoadedScene>> = OnceLock::new();
    let room = ROOM.get_or_init(|| {
        let model = BuiltIn::Room.build().expect("the built-in room");
        Arc::new(LoadedScene::Model(Box::new(model)))
    });
    Session {
        patient,
        scene: room.clone(),
        seed,
        light: PanelLight::default(),
    }
}

/// An app that has drawn its first frame.
pub fn open(session: Session, eye: UVec2, view: UVec2, shown: [bool; 2]) -> Headless {
    Headless::new(session, [eye, view], shown).unwrap_or_else(|error| panic!("{error}"))
}

/// Draws without moving the clock until what is shown is built and the view is captured.
pub fn settle(headless: &mut Headless) {
    for _ in 0..500 {
        headless.stand_still();
        headless.finish_frame();
        let world = headless.world();
        let readiness = world.resource::<Readiness>();
        let errors = readiness.errors();
        assert!(errors.is_empty(), "{errors:?}");
        let built = readiness.quiet_frames() >= 5;
        let ready = world.resource::<SimulationClock>().ready;
        let percept = headless.percept();
        let captured =
            percept.is_captured() && percept.captured().size == headless.size(Which::View);
        if built && ready && (captured || !headless.is_shown(Which::View)) {
            headless.stand_still();
            return;
        }
    }
    panic!("the view was not captured within 500 frames");
}

/// Keeps spontaneous blinks away, so that pictures at fixed times show open lids.
pub fn without_blinks(headless: &mut Headless) {
    let mut controller = headless.controller_mut();
    let mut settings = controller.engine().settings().clone();
    settings.blinks = false;
    controller.set_settings(settings).expect("sound settings");
}

/// Commands a gaze in degrees, which the next frame obeys.
pub fn look(headless: &mut Headless, azimuth_deg: f64, elevation_deg: f64, distance_m: f64) {
    command(
        headless,
        GazeCommand::Fixed {
            azimuth_rad: azimuth_deg.to_radians(),
            elevation_rad: elevation_deg.to_radians(),
            distance_m,
        },
    );
}

/// Commands a gaze.
pub fn command(headless: &mut Headless, gaze: GazeCommand) {
    headless.world().write_message(MotionCommand::Gaze(gaze));
}

/// The engine as it is, to be asked about the future without drawing it.
pub fn engine(headless: &Headless) -> Oculomotor {
    headless.controller().engine().clone()
}

/// First time after `from_s` at which the engine's state satisfies `wanted`, by steps of `step_s`
/// and for at most `within_s`.
pub fn foresee(
    engine: &mut Oculomotor,
    from_s: f64,
    within_s: f64,
    step_s: f64,
    wanted: impl Fn(&OculomotorState) -> bool,
) -> OculomotorState {
    let steps = (within_s / step_s) as u64;
    for step in 0..steps {
        engine.advance_to(from_s + step as f64 * step_s);
        let state = engine.state();
        if wanted(&state) {
            return state;
        }
    }
    panic!("nothing of the kind happens within {within_s} s");
}

/// Rec. 709 luma of a pixel's code values, 0 to 255.
pub fn luma_at(picture: &RgbaImage, x: u32, y: u32) -> f64 {
    let [r, g, b, _] = picture.get_pixel(x, y).0.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Mean and standard deviation of the luma of the pixels that `chosen` takes.
pub fn statistics(picture: &RgbaImage, chosen: impl Fn(u32, u32) -> bool) -> (f64, f64) {
    let values: Vec<f64> = picture
        .enumerate_pixels()
        .filter(|(x, y, _)| chosen(*x, *y))
        .map(|(x, y, _)| luma_at(picture, x, y))
        .collect();
    assert!(!values.is_empty(), "no pixel was chosen");
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    (mean, variance.sqrt())
}

/// Mean luma of the whole picture.
pub fn mean(picture: &RgbaImage) -> f64 {
    statistics(picture, |_, _| true).0
}
