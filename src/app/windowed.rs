//! The app in a window, or in a browser's canvas.

use super::{FramePlugin, Session, add_ocularium};
use crate::ui::UiPlugin;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy_egui::{EguiGlobalSettings, EguiPlugin, PrimaryEguiContext};

/// The window could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display.
    #[error(
        "there is no display to open a window on; `ocularium render --out DIR` works without one"
    )]
    NoDisplay,
    /// The window ended with an error.
    #[error("the window closed with an error")]
    Failed,
}

/// The app with its window, not yet running.
pub fn windowed_app(session: Session) -> App {
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
                filter: "error,ocularium=info,bevy_winit=error".into(),
                ..default()
            })
            .set(RenderPlugin {
                render_creation: super::device_settings().into(),
                ..default()
            }),
    )
    .add_plugins(EguiPlugin::default());
    app.world_mut()
        .resource_mut::<EguiGlobalSettings>()
        .auto_create_primary_context = false;
    add_ocularium(
        &mut app,
        FramePlugin {
            session,
            sizes: [UVec2::new(512, 620); 2],
            shown: [true; 2],
        },
    );
    #[cfg(target_arch = "wasm32")]
    app.insert_resource(bevy::light::DirectionalLightShadowMap { size: 1024 });
    app.insert_resource(ClearColor(Color::linear_rgb(0.003, 0.003, 0.0035)))
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

/// Opens the window and runs until it is closed.
pub fn run(session: Session) -> Result<(), WindowError> {
    #[cfg(all(unix, not(target_os = "macos"), not(target_arch = "wasm32")))]
    if !has_display() {
        return Err(WindowError::NoDisplay);
    }
    match windowed_app(session).run() {
        AppExit::Success => Ok(()),
        AppExit::Error(_) => Err(WindowError::Failed),
    }
}

#[cfg(all(unix, not(target_os = "macos"), not(target_arch = "wasm32")))]
fn has_display() -> bool {
    std::env::var_os("DISPLAY").is_some_and(|display| !display.is_empty())
}
