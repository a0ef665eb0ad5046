//! Is everything built that a frame needs? A frame drawn before its pipelines
//! are there is not a frame, so capture and clock wait for this.

use bevy::app::{App, Plugin};
use bevy::prelude::{IntoScheduleConfigs, Res, Resource};
use bevy::render::render_resource::{CachedPipelineState, PipelineCache};
use bevy::render::{Render, RenderApp, RenderSystems};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

#[derive(Default)]
struct Shared {
    frames: AtomicUsize,
    quiet_frames: AtomicUsize,
    errors: Mutex<Vec<String>>,
}

/// What the render world knows about its pipelines; cloning shares it.
#[derive(Resource, Clone, Default)]
pub struct Readiness(Arc<Shared>);

impl Readiness {
    /// Frames in a row in which no pipeline was waiting or being built.
    pub fn quiet_frames(&self) -> usize {
        self.0.quiet_frames.load(Ordering::Relaxed)
    }

    /// Frames that the render world has finished.
    pub fn frames(&self) -> usize {
        self.0.frames.load(Ordering::Relaxed)
    }

    /// Something new is about to be drawn: wait again.
    pub fn restart(&self) {
        self.0.quiet_frames.store(0, Ordering::Relaxed);
    }

    /// What went wrong in building pipelines, if anything did.
    pub fn errors(&self) -> Vec<String> {
        self.0
            .errors
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// Keeps [`Readiness`] up to date.
pub struct ReadinessPlugin;

impl Plugin for ReadinessPlugin {
    fn build(&self, app: &mut App) {
        let readiness = Readiness::default();
        app.insert_resource(readiness.clone());
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .insert_resource(readiness)
                .add_systems(Render, watch.in_set(RenderSystems::Cleanup));
        }
    }
}

fn watch(readiness: Res<Readiness>, cache: Res<PipelineCache>) {
    let mut errors = Vec::new();
    let mut building = cache.waiting_pipelines().count();
    for pipeline in cache.pipelines() {
        match &pipeline.state {
            CachedPipelineState::Err(error) if !is_waiting(error) => {
                errors.push(error.to_string());
            }
            CachedPipelineState::Ok(_) => {}
            _ => building += 1,
        }
    }
    *readiness
        .0
        .errors
        .lock()
        .unwrap_or_else(PoisonError::into_inner) = errors;
    readiness.0.frames.fetch_add(1, Ordering::Relaxed);
    if building == 0 {
        readiness.0.quiet_frames.fetch_add(1, Ordering::Relaxed);
    } else {
        readiness.restart();
    }
}

/// Shaders and imports that have not arrived yet are not errors.
fn is_waiting(error: &bevy::shader::ShaderCacheError) -> bool {
    use bevy::shader::ShaderCacheError::{ShaderImportNotYetAvailable, ShaderNotLoaded};
    matches!(error, ShaderNotLoaded(_) | ShaderImportNotYetAvailable)
}
