//! Drawing as finely as the machine can, and not at all while nothing moves.

use crate::appearance::EyeQuality;
use crate::frame::SimulationClock;
use crate::frame::readiness::Readiness;
use crate::percept::ViewOptions;
use crate::stage::{Head, Panels, StageView};
use bevy::prelude::*;
use bevy::winit::{UpdateMode, WinitSettings};
use std::time::Duration;

/// Four samples a pixel and the full iris where the machine draws them quickly, one and the fast iris where it does not.
pub(super) fn choose_quality(
    time: Res<Time<Real>>,
    clock: Res<SimulationClock>,
    adapter: Option<Res<bevy::render::renderer::RenderAdapterInfo>>,
    mut view: StageView,
    mut fast_frames: Local<u32>,
    mut decided: Local<bool>,
) {
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
    view.set_quality(EyeQuality::PLAIN);
    let options = view.options();
    view.set_options(ViewOptions {
        supersampling: 1,
        ..options
    });
    if clock.ready && !clock.paused {
        *fast_frames = if time.delta_secs() < 0.024 {
            *fast_frames + 1
        } else {
            0
        };
        if *fast_frames > 90 {
            *decided = true;
            view.set_quality(EyeQuality::default());
            view.set_options(ViewOptions {
                supersampling: ViewOptions::default().supersampling,
                ..options
            });
        }
    }
}

/// While nothing moves, the window waits for input instead of drawing.
pub(super) fn save_power(
    clock: Res<SimulationClock>,
    panels: Panels,
    view: StageView,
    readiness: Res<Readiness>,
    (own, saving): (Res<super::OwnScene>, Res<super::save::Saving>),
    winit: Option<ResMut<WinitSettings>>,
    (mut calm_frames, mut last_head): (Local<u32>, Local<Head>),
) {
    let Some(mut winit) = winit else { return };
    let walking = std::mem::replace(&mut *last_head, view.head()) != view.head();
    // A panel that was resized or shown a moment ago still has to be captured and drawn.
    let busy = !clock.ready
        || !clock.paused
        || clock.steps > 0
        || own.is_busy()
        || saving.is_busy()
        || readiness.quiet_frames() < 5
        || walking
        || (panels.view().visible
            && view.percept().is_none_or(|percept| {
                !percept.is_captured() || percept.captured().size != panels.view().size
            }));
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
