//! The link of what is shown: read when the app starts or the link changes, and written as things change.

use super::link_state::GAZE_NEAREST_M;
use super::link_state::{LinkGaze, LinkState};
use super::state::{Controlled, GazeMode, Shown, UiState};
use crate::anatomy::gaze::GazeAngles;
use crate::frame::SimulationClock;
use crate::motion::MotionCommand;
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::stage::{Restarted, Session, SessionCommand};
use bevy::prelude::*;

/// What the link says that the session does not hold; obeyed once when the app starts.
#[derive(Resource, Clone, Debug, Default)]
pub struct StartState(pub LinkState);

/// A time at which the clock is to stand still once it can run, s.
#[derive(Resource, Default)]
pub(super) struct StandStill(Option<f64>);

/// The session that a link asks for.
///
/// # Errors
/// One sentence where the built-in scene cannot be built.
pub fn session_of(state: &LinkState) -> Result<Session, String> {
    let model = state.scene.build().map_err(|error| error.to_string())?;
    let scene = LoadedScene::Model(Box::new(model));
    Ok(Session::new(state.patient.clone(), scene, state.seed))
}

/// The built-in scene that is shown, if it is one.
pub(super) fn built_in(scene: &LoadedScene) -> Option<BuiltIn> {
    BuiltIn::ALL.into_iter().find(
        |built_in| matches!(scene, LoadedScene::Model(model) if model.name == built_in.name()),
    )
}

/// Is this a scene of the user's own?
pub fn is_own(scene: &LoadedScene) -> bool {
    built_in(scene).is_none()
}

/// What is shown now, as a link says it. A user's own scene is left out.
pub(super) fn current(state: &UiState, app: &Shown) -> LinkState {
    let clock = &app.clock;
    let (azimuth_rad, elevation_rad, distance_m) = state.fixed_at;
    // What is looked at may be farther aside than the eye turns.
    let at = GazeAngles::new(azimuth_rad, elevation_rad).within_range();
    LinkState {
        patient: app.patient().unwrap_or_default(),
        scene: built_in(&app.stage.scene).unwrap_or(BuiltIn::Room),
        seed: app.seed(),
        shown: app.panels.shown(),
        gaze: match state.gaze {
            GazeMode::Auto => LinkGaze::Auto,
            GazeMode::Follow => LinkGaze::Follow,
            GazeMode::Fixed => LinkGaze::Fixed {
                azimuth_deg: at.azimuth_rad.to_degrees(),
                elevation_deg: at.elevation_rad.to_degrees(),
                distance_m: distance_m.max(GAZE_NEAREST_M),
            },
        },
        held_pupil_mm: state.held_pupil_mm,
        orbit: app.view.orbit(),
        light: app.view.light(),
        speed: clock.speed,
        marker: app.view.options().marker,
        paused_at_s: clock.paused.then_some(clock.time_s),
    }
}

/// Makes everything but patient, scene and seed as a link says.
fn adopt(
    wanted: &LinkState,
    state: &mut UiState,
    controlled: &mut Controlled,
    still: &mut StandStill,
) {
    controlled.panels.show(wanted.shown);
    controlled.view.set_orbit(wanted.orbit);
    controlled.view.set_light(wanted.light);
    controlled.set_marker(wanted.marker);
    controlled.clock.speed = wanted.speed;
    controlled.clock.paused = wanted.paused_at_s.is_some();
    still.0 = wanted.paused_at_s;
    state.seed = wanted.seed.to_string();
    state.held_pupil_mm = wanted.held_pupil_mm;
    let pupil = MotionCommand::Pupil(wanted.held_pupil_mm);
    controlled.motion_commands.write(pupil);
    state.gaze = match wanted.gaze {
        LinkGaze::Auto => GazeMode::Auto,
        LinkGaze::Follow => GazeMode::Follow,
        LinkGaze::Fixed {
            azimuth_deg,
            elevation_deg,
            distance_m,
        } => {
            state.fixed_at = (
                azimuth_deg.to_radians(),
                elevation_deg.to_radians(),
                distance_m,
            );
            GazeMode::Fixed
        }
    };
}

/// Obeys the link with which the app was started.
pub(super) fn start(
    start: Res<StartState>,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
    mut still: ResMut<StandStill>,
) {
    adopt(&start.0, &mut state, &mut controlled, &mut still);
}

/// After every restart gaze goes where the controls say, and a clock that is to stand still does.
pub(super) fn keep_promises(
    mut restarted: MessageReader<Restarted>,
    mut state: ResMut<UiState>,
    mut clock: ResMut<SimulationClock>,
    mut still: ResMut<StandStill>,
    mut motion_commands: MessageWriter<MotionCommand>,
    mut has_begun: Local<bool>,
) {
    let begins = restarted.read().count() > 0 || !std::mem::replace(&mut *has_begun, true);
    if begins && state.gaze != GazeMode::Auto {
        // Who follows the pointer stays where it was until it moves.
        state.followed = None;
        motion_commands.write(MotionCommand::Gaze(state.gaze_command()));
    }
    if clock.ready
        && let Some(time_s) = still.0.take()
    {
        clock.time_s = time_s;
    }
}

/// Shows another link's state in the running app.
#[cfg_attr(
    not(target_arch = "wasm32"),
    expect(dead_code, reason = "only a page's link changes")
)]
fn show_link(link: &str, state: &mut UiState, controlled: &mut Controlled, still: &mut StandStill) {
    let (wanted, refused) = LinkState::parse(link);
    state.message = (!refused.is_empty()).then(|| refused.join("\n"));
    if controlled.patient().as_ref() != Some(&wanted.patient) {
        let patient = Box::new(wanted.patient.clone());
        controlled
            .session_commands
            .write(SessionCommand::Patient(patient));
    }
    if built_in(&controlled.stage.scene) != Some(wanted.scene) {
        controlled.show_built_in(wanted.scene, state);
    }
    controlled
        .session_commands
        .write(SessionCommand::Restart(wanted.seed));
    adopt(&wanted, state, controlled, still);
}

/// The link that was written last.
#[cfg(target_arch = "wasm32")]
#[derive(Resource, Default)]
pub(super) struct Written(Option<String>);

/// Obeys the page's link where somebody else has written it.
#[cfg(target_arch = "wasm32")]
pub(super) fn read_page(
    mut written: ResMut<Written>,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
    mut still: ResMut<StandStill>,
) {
    let there = super::host::fragment();
    if written.0.as_ref().is_some_and(|ours| *ours != there) {
        show_link(&there, &mut state, &mut controlled, &mut still);
        // Whoever reads it has it; what of it could not be obeyed goes with the next writing.
        written.0 = Some(there);
    }
}

/// Writes the page's link where what is shown has changed.
#[cfg(target_arch = "wasm32")]
pub(super) fn write_page(
    mut written: ResMut<Written>,
    state: Res<UiState>,
    app: Shown,
    still: Res<StandStill>,
    commands: Res<Messages<SessionCommand>>,
    mut last: Local<String>,
) {
    // What is still on its way would be lost.
    if still.0.is_some() || !commands.is_empty() {
        return;
    }
    let wanted = current(&state, &app).to_fragment();
    if *last != wanted {
        super::host::replace_fragment(&wanted);
        // As the browser gives it back, so that its own encoding is no change.
        written.0 = Some(super::host::fragment());
        *last = wanted;
    }
}

/// The fragment of what the app shows, where a user's own scene is not the reason that there is none.
#[cfg(not(target_arch = "wasm32"))]
pub fn link_of(world: &mut World) -> Option<String> {
    use bevy::ecs::system::SystemState;
    let mut parts: SystemState<(Res<UiState>, Shown)> = SystemState::new(world);
    let (state, app) = parts.get_mut(world).ok()?;
    Some(current(&state, &app).to_fragment())
}
