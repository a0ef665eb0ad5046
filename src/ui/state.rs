//! What the controls remember, and everything that they read and command.

use crate::frame::SimulationClock;
use crate::frame::ledger::{Work, WorkLedger};
use crate::motion::engine::GazeCommand;
use crate::motion::{GazeController, MotionCommand};
use crate::patients::{PRESETS, load_patient};
use crate::patients::{PatientFile, PatientReader};
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::stage::{Panels, SessionCommand, Stage, StageView};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Who directs gaze.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GazeMode {
    /// The eye looks about by itself.
    #[default]
    Auto,
    /// It follows the pointer over the view.
    Follow,
    /// It stays where it was last sent.
    Fixed,
}

/// A direction and a distance to look at: rad to the right, rad up, m.
pub type Place = (f64, f64, f64);

/// What the controls remember.
#[derive(Resource)]
pub struct UiState {
    /// Are the controls shown? `None`: where there is room for them.
    pub controls_open: Option<bool>,
    /// The controls are to be shown, or put away, from the next frame.
    pub toggle_controls: bool,
    /// Who directs gaze.
    pub gaze: GazeMode,
    /// Where gaze stays while it is fixed.
    pub fixed_at: Place,
    /// Where the pointer was when gaze followed it last.
    pub followed: Option<egui::Pos2>,
    /// Pupil held by hand, mm.
    pub held_pupil_mm: Option<f64>,
    /// The seed as typed.
    pub seed: String,
    /// In which fields a patient with a built-in one's name differs from it.
    pub changes: String,
    /// Is there nothing of the scene in the view?
    pub nothing_in_view: bool,
    /// Titles of the built-in patients.
    pub titles: Vec<String>,
    /// What went wrong last, for the user.
    pub message: Option<String>,
    /// What went well last, for the user, and from when it is shown, s of real time.
    pub notice: Option<(String, Option<f64>)>,
    /// Rectangles of eye and view in the controls' points, where they are shown.
    pub rectangles: [Option<egui::Rect>; 2],
    /// Rectangles of controls in their points by name, for tests that press them.
    pub places: BTreeMap<&'static str, egui::Rect>,
    /// Is it drawn for fingers?
    pub touch: bool,
    /// The window's points in one of the controls'.
    pub zoom: f32,
    /// Zoom for a window of this size, before the user changes it.
    pub fitted_zoom: f32,
    /// Work of the last second.
    pub work: Work,
    /// Milliseconds between frames, smoothed.
    pub frame_ms: f64,
    last_work: Work,
    work_clock_s: f64,
}

impl Default for UiState {
    fn default() -> Self {
        let title = |name: &str| load_patient(name).map_or(name.into(), |patient| patient.name);
        Self {
            controls_open: None,
            zoom: 1.0,
            fitted_zoom: 1.0,
            toggle_controls: false,
            gaze: GazeMode::Auto,
            fixed_at: (0.0, 0.0, f64::INFINITY),
            followed: None,
            held_pupil_mm: None,
            seed: "1".into(),
            changes: String::new(),
            nothing_in_view: false,
            titles: PRESETS.iter().map(|preset| title(preset.name)).collect(),
            message: None,
            notice: None,
            rectangles: [None; 2],
            places: BTreeMap::new(),
            touch: crate::ui::host::is_touch(),
            work: Work::default(),
            frame_ms: 0.0,
            last_work: Work::default(),
            work_clock_s: 0.0,
        }
    }
}

/// Describes the patient anew when it is another.
pub(super) fn describe_patient(
    app: Shown,
    mut state: ResMut<UiState>,
    mut described: Local<Option<PatientFile>>,
) {
    let patient = app.patient();
    if *described == patient {
        return;
    }
    let (_, changes) = super::link_state::changes(&patient.clone().unwrap_or_default());
    *described = patient;
    let is_renamed = changes.iter().any(|(field, _)| field == "name");
    let changes: Vec<_> = changes
        .iter()
        .filter(|_| !is_renamed)
        .map(|(field, value)| format!("{field} {value}"))
        .collect();
    state.changes = changes.join(", ");
}

/// Looks whether there is something in the view, whenever it was captured anew.
pub(super) fn look_for_something(
    view: StageView,
    stage: Res<Stage>,
    mut state: ResMut<UiState>,
    mut serial: Local<u64>,
) {
    let Some(percept) = view.percept() else {
        return;
    };
    let captured = percept.captured();
    if *serial != captured.serial {
        *serial = captured.serial;
        state.nothing_in_view = captured.is_empty() && !stage.scene.is_far();
    }
}

/// Everything that the controls read and command.
#[derive(SystemParam)]
pub struct Controlled<'w, 's> {
    pub(super) stage: Res<'w, Stage>,
    pub(super) clock: ResMut<'w, SimulationClock>,
    pub(super) panels: Panels<'w, 's>,
    pub(super) images: ResMut<'w, Assets<Image>>,
    pub(super) view: StageView<'w, 's>,
    pub(super) patients: PatientReader<'w, 's>,
    pub(super) ledger: Res<'w, WorkLedger>,
    pub(super) session_commands: MessageWriter<'w, SessionCommand>,
    pub(super) motion_commands: MessageWriter<'w, MotionCommand>,
    pub(super) requests: MessageWriter<'w, super::Request>,
}

/// What of the app a link says, beside what the controls remember.
#[derive(SystemParam)]
pub(super) struct Shown<'w, 's> {
    pub(super) stage: Res<'w, Stage>,
    pub(super) clock: Res<'w, SimulationClock>,
    pub(super) panels: Panels<'w, 's>,
    pub(super) view: StageView<'w, 's>,
    patients: PatientReader<'w, 's>,
}

impl Shown<'_, '_> {
    /// The patient as a file would say; `None` before she is there.
    pub(super) fn patient(&self) -> Option<PatientFile> {
        self.patients.file(self.stage.patient)
    }

    /// Seed of every random choice.
    pub(super) fn seed(&self) -> u64 {
        self.view.controller().map_or(1, GazeController::seed)
    }
}

impl Controlled<'_, '_> {
    /// The patient as a file would say; `None` before she is there.
    pub(super) fn patient(&self) -> Option<PatientFile> {
        self.patients.file(self.stage.patient)
    }

    /// Seed of every random choice.
    pub(super) fn seed(&self) -> u64 {
        self.view.controller().map_or(1, GazeController::seed)
    }

    /// Shows or hides the mark where the eye looks.
    pub(super) fn set_marker(&mut self, marker: bool) {
        let options = self.view.options();
        self.view
            .set_options(crate::percept::ViewOptions { marker, ..options });
    }
}

impl Controlled<'_, '_> {
    /// Shows a built-in scene, or tells why it cannot be built.
    pub(super) fn show_built_in(&mut self, scene: BuiltIn, state: &mut UiState) {
        match scene.build() {
            Ok(model) => self.show_scene(LoadedScene::Model(Box::new(model))),
            Err(error) => state.message = Some(error.to_string()),
        }
    }

    /// Shows a scene.
    pub(super) fn show_scene(&mut self, scene: LoadedScene) {
        self.session_commands
            .write(SessionCommand::Scene(Arc::new(scene)));
    }
}

impl UiState {
    /// Tells the user something that needs no answer.
    pub(super) fn notify(&mut self, sentence: String) {
        self.notice = Some((sentence, None));
    }

    /// Work of the last second and a smoothed time of a frame.
    pub(super) fn measure(&mut self, ledger: &WorkLedger, time: &Time<Real>) {
        let ms = time.delta_secs_f64() * 1e3;
        self.frame_ms += 0.1 * (ms - self.frame_ms);
        let now = time.elapsed_secs_f64();
        if now - self.work_clock_s >= 1.0 {
            let work = ledger.read();
            self.work = work.since(self.last_work);
            self.last_work = work;
            self.work_clock_s = now;
        }
    }

    /// The command that keeps gaze where the controls say it is.
    pub(super) fn gaze_command(&self) -> GazeCommand {
        let (azimuth_rad, elevation_rad, distance_m) = self.fixed_at;
        match self.gaze {
            GazeMode::Auto => GazeCommand::Auto,
            GazeMode::Follow | GazeMode::Fixed => GazeCommand::Fixed {
                azimuth_rad,
                elevation_rad,
                distance_m,
            },
        }
    }
}
