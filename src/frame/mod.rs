//! What every frame stands on: the clock, the order of work, panels, shaders, readiness, the ledger.
//!
//! Enters: real time, or a time that somebody sets. Leaves: the simulation's time, and the stages of a
//! frame ([`EyeSystems`]): Sense → Decide → Move → Perceive → Show.

pub mod clock;
pub mod ledger;
pub(crate) mod mips;
pub mod panel;
pub(crate) mod picture;
pub mod readiness;
pub mod shaders;

pub use clock::{Drive, SimulationClock};
pub use panel::Panel;

use bevy::light::cluster::GlobalClusterSettings;
use bevy::pbr::PbrPlugin;
use bevy::prelude::*;
#[cfg(not(target_arch = "wasm32"))]
use bevy::render::settings::Backends;
use bevy::render::settings::WgpuSettings;

/// The stages of a frame, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EyeSystems {
    /// What has come in: commands, candidates, the clock, conditions.
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

/// The part of [`EyeSystems::Sense`] in which an app carries out what its user asks; anatomy is worked
/// out from what it leaves.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EyeCommands;

/// Shaders, readiness, ledger, clock, and the order of a frame.
pub struct FramePlugin;

impl Plugin for FramePlugin {
    fn build(&self, app: &mut App) {
        use EyeSystems::{Decide, Move, Perceive, Sense, Show};
        app.add_plugins((shaders::ShadersPlugin, readiness::ReadinessPlugin))
            .init_resource::<SimulationClock>()
            .init_resource::<ledger::WorkLedger>()
            .configure_sets(Update, (Sense, Decide, Move, Perceive, Show).chain())
            .configure_sets(Update, EyeCommands.in_set(Sense))
            .add_systems(
                Update,
                clock::advance_clock.in_set(Sense).after(EyeCommands),
            );
        let ledger = app.world().resource::<ledger::WorkLedger>().clone();
        if let Some(render_app) = app.get_sub_app_mut(bevy::render::RenderApp) {
            render_app.insert_resource(ledger);
        }
    }
}

/// How meshes are drawn: no deferred shading, whose lighting pipeline a program's start is spared (the prepass keeps
/// the one that copies ids for it).
pub fn mesh_settings() -> PbrPlugin {
    PbrPlugin {
        add_default_deferred_lighting_plugin: false,
        ..default()
    }
}

/// Has the processor say which of a scene's few lights shine where, and not a device, which does it in passes of its
/// own for every camera.
pub fn cluster_lights_on_the_processor(settings: Option<ResMut<GlobalClusterSettings>>) {
    if let Some(mut settings) = settings {
        settings.gpu_clustering = None;
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
