//! The app in a window, or in a browser's canvas.

mod lost;

use crate::OculariumPlugins;
use crate::frame::{device_settings, mesh_settings};
use crate::stage::{Session, StagePlugin};
#[cfg(not(target_arch = "wasm32"))]
use crate::ui::UiState;
use crate::ui::link_state::LinkState;
use crate::ui::{StartState, UiPlugin};
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::error_handler::RenderErrorHandler;
use bevy_egui::{EguiGlobalSettings, EguiPlugin, PrimaryEguiContext};

/// The window could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display.
    #[error(
        "there is no display to open a window on{0}; `ocularium render --out DIR` works without one"
    )]
    NoDisplay(String),
    /// The graphics device went away.
    #[error("the graphics device was lost ({reason})")]
    DeviceLost {
        /// What the system said.
        reason: String,
        /// What was shown, as a link says it.
        link: Option<String>,
        /// The name of the scene, where it is not built in.
        own_scene: Option<String>,
    },
    /// Drawing failed.
    #[error("drawing failed: {0}")]
    Drawing(String),
    /// Ctrl-C, or a signal that means the same.
    #[error("interrupted")]
    Interrupted,
    /// The window ended with an error.
    #[error("the window closed with an error")]
    Failed,
}

/// Exit status after Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// The app with its window, not yet running; `start` says what the session does not hold.
pub fn windowed_app(session: Session, start: LinkState) -> App {
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: "Ocularium".into(),
                    name: Some("ocularium".into()),
                    resolution: (1280, 760).into(),
                    canvas: Some("#ocularium".into()),
                    fit_canvas_to_parent: true,
                    prevent_default_event_handling: true,
                    ..default()
                }),
                ..default()
            })
            .set(LogPlugin {
                // A file dialog that cannot be opened is told in the window.
                filter: "error,ocularium=info,bevy_winit=error,rfd=off".into(),
                ..default()
            })
            .set(RenderPlugin {
                render_creation: device_settings().into(),
                ..default()
            })
            .set(mesh_settings()),
    )
    .add_plugins(EguiPlugin::default());
    app.world_mut()
        .resource_mut::<EguiGlobalSettings>()
        .auto_create_primary_context = false;
    app.add_plugins((
        OculariumPlugins,
        StagePlugin {
            session,
            sizes: [UVec2::new(512, 620); 2],
            shown: [true; 2],
        },
    ));
    #[cfg(target_arch = "wasm32")]
    app.insert_resource(bevy::light::DirectionalLightShadowMap { size: 1024 });
    app.insert_resource(ClearColor(Color::linear_rgb(0.003, 0.003, 0.0035)))
        .insert_resource(StartState(start))
        .insert_resource(RenderErrorHandler(lost::on_render_error))
        .add_plugins(UiPlugin)
        .add_systems(Startup, |mut commands: Commands| {
            commands.spawn((
                PrimaryEguiContext,
                Camera2d,
                bevy::camera::visibility::RenderLayers::none(),
            ));
        });
    app
}

/// Opens the window and runs until it is closed; `said` is told in it at first, and `own` is what the
/// session's scene was read from.
#[cfg(not(target_arch = "wasm32"))]
pub fn run(
    session: Session,
    start: LinkState,
    said: &[String],
    own: crate::ui::OwnScene,
) -> Result<(), WindowError> {
    #[cfg(all(unix, not(target_os = "macos")))]
    if let Some(reason) = crate::lab::display::display_fault() {
        return Err(WindowError::NoDisplay(reason));
    }
    // Bevy leaves signals alone where Ctrl-C is ignored, as scripts have it for what they start beside them;
    // SIGTERM would then end the program at once. Where no handler can be set the window has none.
    let asked = std::sync::atomic::AtomicBool::new(false);
    let _ = ctrlc::set_handler(move || {
        if asked.swap(true, std::sync::atomic::Ordering::Relaxed) {
            // Whoever asks twice does not want to wait for a frame.
            crate::lab::bench::leave(i32::from(INTERRUPTED));
        }
        bevy::app::TerminalCtrlCHandlerPlugin::gracefully_exit();
    });
    let mut app = windowed_app(session, start);
    app.insert_resource(own);
    if !said.is_empty() {
        app.world_mut().resource_mut::<UiState>().message = Some(said.join("\n"));
    }
    let exit = app.run();
    match (lost::take(), exit) {
        (Some(error), _) => Err(error),
        (None, AppExit::Success) => Ok(()),
        // What Bevy's own handler of signals says.
        (None, AppExit::Error(code)) if code.get() == INTERRUPTED => Err(WindowError::Interrupted),
        (None, AppExit::Error(_)) => Err(WindowError::Failed),
    }
}
