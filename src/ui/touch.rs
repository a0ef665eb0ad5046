//! Fingers: taps that are shorter than a frame, and the keyboard of a telephone.

use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiInput, egui};

/// A press is a click however long it lasted. Pressing and letting go are a frame apart at least, and a
/// frame may take seconds: by the clock every tap of a slow machine would be a rest, which clicks
/// nothing and keeps sliders from moving.
pub(super) fn take_slow_taps(context: &egui::Context) {
    context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
}

/// A tap that begins and ends between two frames would never be over a button, as the pointer is gone
/// when egui looks: it goes a frame later.
pub(super) fn keep_short_taps(
    mut inputs: Query<&mut EguiInput>,
    mut redraw: MessageWriter<RequestRedraw>,
    mut held_back: Local<bool>,
) {
    for mut input in &mut inputs {
        if std::mem::take(&mut *held_back) {
            input.events.insert(0, egui::Event::PointerGone);
        }
        *held_back = hold_back_leave(&mut input.events);
        if *held_back {
            redraw.write(RequestRedraw);
        }
    }
}

/// Takes the pointer's leaving out of events in which it was pressed before; says whether it was there.
fn hold_back_leave(events: &mut Vec<egui::Event>) -> bool {
    let pressed = events
        .iter()
        .position(|event| matches!(event, egui::Event::PointerButton { pressed: true, .. }));
    let left = events
        .iter()
        .rposition(|event| matches!(event, egui::Event::PointerGone));
    match (pressed, left) {
        (Some(pressed), Some(left)) if pressed < left => {
            events.remove(left);
            true
        }
        _ => false,
    }
}

/// Brings up a telephone's keyboard when a field is touched, and puts it away when it is left.
pub(super) fn raise_keyboard(field: &egui::Response) {
    #[cfg(target_arch = "wasm32")]
    if crate::ui::host::is_telephone() {
        if field.gained_focus() {
            bevy_egui::text_agent::update_text_agent(true);
        } else if field.lost_focus() {
            bevy_egui::text_agent::update_text_agent(false);
        }
    }
    #[cfg(not(target_arch = "wasm32"))]
    let _ = field;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn button(pressed: bool) -> egui::Event {
        egui::Event::PointerButton {
            pos: egui::Pos2::ZERO,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        }
    }

    #[test]
    fn only_a_tap_within_one_frame_is_held() {
        // Other events may follow in the same frame.
        let other = egui::Event::WindowFocused(true);
        let gone = egui::Event::PointerGone;
        let mut tap = vec![button(true), button(false), gone, other];
        assert!(hold_back_leave(&mut tap));
        assert_eq!(tap.len(), 3);
        let mut end_of_drag = vec![button(false), egui::Event::PointerGone];
        assert!(!hold_back_leave(&mut end_of_drag));
        assert_eq!(end_of_drag.len(), 2);
        let mut two_taps = vec![egui::Event::PointerGone, button(true)];
        assert!(!hold_back_leave(&mut two_taps));
        assert!(!hold_back_leave(&mut Vec::new()));
    }

    #[test]
    fn a_tap_presses_a_button_at_any_frame_rate() {
        assert_eq!(clicks_of_taps(0.01, true), 4);
        assert_eq!(clicks_of_taps(3.0, true), 4);
        // What egui does by itself: only taps within one frame are quick enough.
        assert_eq!(clicks_of_taps(3.0, false), 2);
    }

    /// Clicks that two taps within a frame and two over two frames make, frames taking so long.
    fn clicks_of_taps(frame_s: f64, slow_taps: bool) -> i32 {
        let mut app = App::new();
        app.add_message::<RequestRedraw>()
            .add_systems(Update, keep_short_taps);
        let entity = app.world_mut().spawn(EguiInput::default()).id();
        let context = egui::Context::default();
        if slow_taps {
            take_slow_taps(&context);
        }
        let mut time_s = 0.0;
        let at = egui::pos2(20.0, 12.0);
        let mut clicks = 0;
        let mut frame = |events: Vec<egui::Event>| {
            app.world_mut().get_mut::<EguiInput>(entity).unwrap().events = events;
            app.update();
            let mut input = app.world_mut().get_mut::<EguiInput>(entity).unwrap();
            let input = std::mem::take(&mut input.0);
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(100.0, 60.0));
            let mut ui_frame = |ui: &mut egui::Ui| {
                let place = egui::Rect::from_min_size(egui::pos2(2.0, 2.0), egui::vec2(60.0, 40.0));
                clicks += i32::from(ui.put(place, egui::Button::new("press")).clicked());
            };
            time_s += frame_s;
            let input = egui::RawInput {
                screen_rect: Some(screen),
                time: Some(time_s),
                ..input
            };
            let _ = context.run_ui(input, &mut ui_frame);
        };
        let [mut down, mut up] = [true, false].map(button);
        for event in [&mut down, &mut up] {
            if let egui::Event::PointerButton { pos, .. } = event {
                *pos = at;
            }
        }
        let down = vec![egui::Event::PointerMoved(at), down];
        // As bevy_egui ends every frame's events.
        let up = vec![
            up,
            egui::Event::PointerGone,
            egui::Event::WindowFocused(true),
        ];
        frame(Vec::new());
        for _ in 0..2 {
            frame([down.clone(), up.clone()].concat());
            frame(Vec::new());
        }
        for _ in 0..2 {
            frame(down.clone());
            frame(up.clone());
            frame(Vec::new());
        }
        clicks
    }
}
