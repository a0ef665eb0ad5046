//! Walking through a scene: W A S D or the arrow keys, and turning the head by dragging the view.

use super::Controlled;
use bevy::prelude::*;
use bevy_egui::EguiContexts;

/// Speed of walking, m/s: an unhurried person's.
const WALK_M_S: f32 = 1.2;
/// Speed of turning by keys, degrees a second.
const TURN_DEG_S: f32 = 60.0;

/// Moves the head while keys are held.
pub(super) fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time<Real>>,
    mut contexts: EguiContexts,
    mut controlled: Controlled,
) {
    if contexts
        .ctx_mut()
        .is_ok_and(|context| context.egui_wants_keyboard_input())
    {
        return;
    }
    let held = |one: KeyCode, other: KeyCode| f32::from(u8::from(keys.any_pressed([one, other])));
    let forwards = held(KeyCode::KeyW, KeyCode::ArrowUp) - held(KeyCode::KeyS, KeyCode::ArrowDown);
    let aside = held(KeyCode::KeyD, KeyCode::KeyD) - held(KeyCode::KeyA, KeyCode::KeyA);
    let turn = held(KeyCode::ArrowRight, KeyCode::ArrowRight)
        - held(KeyCode::ArrowLeft, KeyCode::ArrowLeft);
    if (forwards, aside, turn) == (0.0, 0.0, 0.0) {
        return;
    }
    // A frame that took long is no leap.
    let passed_s = time.delta_secs().min(0.1);
    let mut head = controlled.view.head();
    head.yaw_deg += turn * TURN_DEG_S * passed_s;
    head.walk(aside * WALK_M_S * passed_s, forwards * WALK_M_S * passed_s);
    controlled.view.set_head(head);
}
