//! The window's controls: plain functions of (&mut Ui, &mut state), drawn with egui.
//!
//! Enters: the state of session, clock and motion. Leaves: commands to them;
//! nothing is changed behind their backs.

mod controls;
mod pictures;
mod strip;

use crate::anatomy::PRESETS;
use crate::app::{Panels, Session, SessionCommand, SimulationClock};
use crate::appearance::EyeOrbit;
use crate::ledger::{Work, WorkLedger};
use crate::motion::{Motion, MotionCommand};
use crate::percept::{Percept, ViewOptions};
use crate::readiness::Readiness;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::winit::{UpdateMode, WinitSettings};
use bevy_egui::egui::{self, LayerId, UiBuilder};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, EguiTextureHandle, EguiUserTextures};
use std::time::Duration;

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

/// What the controls remember.
#[derive(Resource)]
pub struct UiState {
    /// Is the side panel open?
    pub controls_open: bool,
    /// Who directs gaze.
    pub gaze: GazeMode,
    /// Pupil held by hand, mm.
    pub held_pupil_mm: Option<f64>,
    /// The seed as typed.
    pub seed: String,
    /// Index of the built-in patient that is shown, if it is one.
    pub preset: Option<usize>,
    /// What went wrong last, for the user.
    pub message: Option<String>,
    /// Rectangles of eye and view in points, where they are shown.
    pub rectangles: [Option<egui::Rect>; 2],
    last_work: Work,
    work: Work,
    work_clock_s: f64,
    frame_ms: f64,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            controls_open: true,
            gaze: GazeMode::Auto,
            held_pupil_mm: None,
            seed: "1".into(),
            preset: None,
            message: None,
            rectangles: [None; 2],
            last_work: Work::default(),
            work: Work::default(),
            work_clock_s: 0.0,
            frame_ms: 0.0,
        }
    }
}

/// Everything that the controls read and command.
#[derive(SystemParam)]
pub struct Controlled<'w> {
    session: Res<'w, Session>,
    clock: ResMut<'w, SimulationClock>,
    panels: ResMut<'w, Panels>,
    images: ResMut<'w, Assets<Image>>,
    orbit: ResMut<'w, EyeOrbit>,
    options: ResMut<'w, ViewOptions>,
    motion: Option<Res<'w, Motion>>,
    percept: Res<'w, Percept>,
    ledger: Res<'w, WorkLedger>,
    session_commands: MessageWriter<'w, SessionCommand>,
    motion_commands: MessageWriter<'w, MotionCommand>,
}

/// The window's controls.
pub struct UiPlugin;

impl Plugin for UiPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<UiState>()
            .add_systems(Startup, register_pictures)
            .add_systems(
                Update,
                (keyboard, save_power, choose_quality).before(crate::app::EyeSystems::Sense),
            )
            .add_systems(EguiPrimaryContextPass, draw);
    }
}

fn register_pictures(
    panels: Res<Panels>,
    session: Res<Session>,
    mut state: ResMut<UiState>,
    mut textures: ResMut<EguiUserTextures>,
) {
    for panel in [&panels.eye, &panels.view] {
        textures.add_image(EguiTextureHandle::Strong(panel.image.clone()));
    }
    state.seed = session.seed.to_string();
    state.preset = PRESETS.iter().position(|preset| {
        crate::anatomy::load_patient(preset.name).is_ok_and(|patient| patient == session.patient)
    });
}

/// Space: pause. R: restart. H: hide the controls. 1, 2, B: eye, view, both. Period: one step. M: marker.
fn keyboard(
    keys: Res<ButtonInput<KeyCode>>,
    mut contexts: EguiContexts,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
) {
    // Keys that are typed into a field are not commands.
    if contexts
        .ctx_mut()
        .is_ok_and(|context| context.egui_wants_keyboard_input())
    {
        return;
    }
    let clock = &mut controlled.clock;
    if keys.just_pressed(KeyCode::Space) {
        clock.paused = !clock.paused;
    }
    if keys.just_pressed(KeyCode::Period) {
        clock.paused = true;
        clock.steps += 1;
    }
    if keys.just_pressed(KeyCode::KeyR) {
        let seed = controlled.session.seed;
        controlled
            .session_commands
            .write(SessionCommand::Restart(seed));
    }
    if keys.just_pressed(KeyCode::KeyH) {
        state.controls_open = !state.controls_open;
    }
    if keys.just_pressed(KeyCode::KeyM) {
        controlled.options.marker = !controlled.options.marker;
    }
    for (key, shown) in [
        (KeyCode::Digit1, [true, false]),
        (KeyCode::Digit2, [false, true]),
        (KeyCode::KeyB, [true, true]),
    ] {
        if keys.just_pressed(key) {
            [
                controlled.panels.eye.visible,
                controlled.panels.view.visible,
            ] = shown;
        }
    }
}

/// Four samples a pixel where the machine draws them quickly, one where it does not.
fn choose_quality(
    time: Res<Time<Real>>,
    clock: Res<SimulationClock>,
    adapter: Option<Res<bevy::render::renderer::RenderAdapterInfo>>,
    mut quality: ResMut<crate::appearance::EyeQuality>,
    mut options: ResMut<ViewOptions>,
    mut fast_frames: Local<u32>,
    mut decided: Local<bool>,
) {
    use bevy::prelude::Msaa;
    if *decided {
        return;
    }
    // A browser does not say what draws, so it starts plain and earns its samples.
    let hardware = adapter.is_some_and(|adapter| {
        matches!(
            adapter.device_type,
            wgpu_types::DeviceType::DiscreteGpu | wgpu_types::DeviceType::IntegratedGpu
        )
    });
    if hardware {
        *decided = true;
        return;
    }
    quality.set_if_neq(crate::appearance::EyeQuality { msaa: Msaa::Off });
    if options.supersampling != 1 {
        options.supersampling = 1;
    }
    if clock.ready && !clock.paused {
        *fast_frames = if time.delta_secs() < 0.024 {
            *fast_frames + 1
        } else {
            0
        };
        if *fast_frames > 90 {
            *decided = true;
            quality.msaa = Msaa::Sample4;
            options.supersampling = ViewOptions::default().supersampling;
        }
    }
}

/// While nothing moves, the window waits for input instead of drawing.
fn save_power(
    clock: Res<SimulationClock>,
    panels: Res<Panels>,
    percept: Res<Percept>,
    readiness: Res<Readiness>,
    winit: Option<ResMut<WinitSettings>>,
    mut calm_frames: Local<u32>,
) {
    let Some(mut winit) = winit else { return };
    // A panel that was resized or shown a moment ago still has to be captured and drawn.
    let busy = !clock.ready
        || !clock.paused
        || clock.steps > 0
        || readiness.quiet_frames() < 5
        || (panels.view.visible
            && (!percept.is_captured() || percept.captured().size != panels.view.size));
    *calm_frames = if busy { 0 } else { *calm_frames + 1 };
    let mode = if *calm_frames > 10 {
        UpdateMode::reactive_low_power(Duration::from_secs(5))
    } else {
        UpdateMode::Continuous
    };
    if winit.focused_mode != mode {
        winit.focused_mode = mode;
        winit.unfocused_mode = mode;
    }
}

fn draw(
    mut contexts: EguiContexts,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
    time: Res<Time<Real>>,
    mut styled: Local<bool>,
) -> Result {
    let pictures = [
        contexts.image_id(&controlled.panels.eye.image),
        contexts.image_id(&controlled.panels.view.image),
    ];
    let context = contexts.ctx_mut()?.clone();
    if !*styled {
        *styled = true;
        style(&context);
    }
    measure(&mut state, &controlled, &time);
    let mut root = egui::Ui::new(
        context.clone(),
        "root".into(),
        UiBuilder::new()
            .layer_id(LayerId::background())
            .max_rect(context.viewport_rect()),
    );
    if state.controls_open {
        egui::Panel::right("controls")
            .resizable(true)
            .default_size(250.0)
            .show(&mut root, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| {
                    controls::draw(ui, &mut state, &mut controlled);
                });
            });
    }
    egui::Panel::bottom("strip")
        .resizable(true)
        .default_size(112.0)
        .show(&mut root, |ui| strip::draw(ui, &controlled));
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE.fill(egui::Color32::from_rgb(12, 12, 13)))
        .show(&mut root, |ui| {
            pictures::draw(ui, &mut state, &mut controlled, pictures);
        });
    Ok(())
}

fn style(context: &egui::Context) {
    context.set_visuals(egui::Visuals::dark());
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.interaction.selectable_labels = false;
    });
}

/// Work of the last second and a smoothed time of a frame.
fn measure(state: &mut UiState, controlled: &Controlled, time: &Time<Real>) {
    let ms = time.delta_secs_f64() * 1e3;
    state.frame_ms += 0.1 * (ms - state.frame_ms);
    let now = time.elapsed_secs_f64();
    if now - state.work_clock_s >= 1.0 {
        let work = controlled.ledger.read();
        state.work = work.since(state.last_work);
        state.last_work = work;
        state.work_clock_s = now;
    }
}
