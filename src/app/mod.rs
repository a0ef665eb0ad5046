//! The app: one clock, one session, two panels, put together from the plugins.
//!
//! Enters: a [`Session`] (patient, scene, seed). Leaves: a Bevy app that runs
//! in a window, in a browser or without either. Frames go Sense → Decide →
//! Move → Perceive → Show ([`EyeSystems`]).

pub mod clock;
#[cfg(feature = "app")]
pub mod host;
#[cfg(feature = "app")]
pub mod link;
pub mod own_files;
pub mod panels;
pub mod picture;
pub mod session;

#[cfg(all(feature = "app", not(target_arch = "wasm32")))]
pub mod cli;
#[cfg(all(feature = "app", target_arch = "wasm32"))]
pub mod web;
#[cfg(feature = "app")]
pub mod windowed;

pub use clock::{Drive, SimulationClock};
pub use panels::{Panel, Panels};
pub use session::{Session, SessionCommand};

use bevy::prelude::*;
#[cfg(not(target_arch = "wasm32"))]
use bevy::render::settings::Backends;
use bevy::render::settings::WgpuSettings;

/// The stages of a frame, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EyeSystems {
    /// What has come in: commands, candidates, the clock.
    Sense,
    /// Where to look next.
    Decide,
    /// Gaze, lids, pupil and lens go to their places at this time.
    Move,
    /// Blur, field and conditions.
    Perceive,
    /// Transforms, uniforms and panels.
    Show,
}

/// Clock, session, and the order of a frame.
pub struct FramePlugin {
    /// What is shown at first.
    pub session: Session,
    /// Sizes of the panels in pixels (eye, view).
    pub sizes: [UVec2; 2],
    /// Which panels are shown at first (eye, view).
    pub shown: [bool; 2],
}

impl Plugin for FramePlugin {
    fn build(&self, app: &mut App) {
        use EyeSystems::{Decide, Move, Perceive, Sense, Show};
        let panels = {
            let mut images = app.world_mut().resource_mut::<Assets<Image>>();
            Panels::new(&mut images, self.sizes[0], self.sizes[1], self.shown)
        };
        app.insert_resource(panels)
            .insert_resource(self.session.clone())
            .init_resource::<SimulationClock>()
            .init_resource::<crate::ledger::WorkLedger>()
            .add_message::<SessionCommand>()
            .configure_sets(Update, (Sense, Decide, Move, Perceive, Show).chain())
            .add_systems(Startup, session::spawn_patient)
            .add_systems(
                Update,
                (session::obey, clock::advance_clock).chain().in_set(Sense),
            );
        let ledger = app.world().resource::<crate::ledger::WorkLedger>().clone();
        if let Some(render_app) = app.get_sub_app_mut(bevy::render::RenderApp) {
            render_app.insert_resource(ledger);
        }
    }
}

/// How devices are chosen: Vulkan, Metal, DirectX 12 or WebGPU, unless `WGPU_BACKEND` says otherwise.
pub fn device_settings() -> WgpuSettings {
    let settings = WgpuSettings::default();
    #[cfg(not(target_arch = "wasm32"))]
    let settings = WgpuSettings {
        backends: Some(Backends::from_env().unwrap_or(Backends::PRIMARY)),
        ..settings
    };
    settings
}

/// Adds everything that draws and moves the eye; what remains is a window, or none.
pub fn add_ocularium(app: &mut App, frame: FramePlugin) {
    app.add_plugins((
        crate::shaders::ShadersPlugin,
        crate::readiness::ReadinessPlugin,
        frame,
        crate::motion::MotionPlugin,
        crate::percept::PerceptPlugin,
        crate::appearance::AppearancePlugin,
    ));
}
