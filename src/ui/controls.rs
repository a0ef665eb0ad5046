//! The controls.

mod anatomy;
mod chosen;

use super::pictures::bars;
use super::state::{Controlled, GazeMode, UiState};
use super::{OwnScene, Request, Saved};
use crate::anatomy::{PUPIL_RANGE_MM, USUAL_PUPIL_MM};
use crate::appearance::EyeOrbit;
use crate::motion::MotionCommand;
use crate::stage::{PanelLight, SessionCommand};
use bevy_egui::egui::{self, Ui};

/// The title, and the button that puts the controls away: it must not scroll away with them.
pub fn head(ui: &mut Ui, state: &mut UiState) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.heading("Ocularium");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let side = if state.touch { 40.0 } else { 24.0 };
            if bars(ui, side, "Put the controls away (H)", state) {
                state.toggle_controls = true;
            }
        });
    });
}

/// Draws every control.
pub fn draw(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled, own: &mut OwnScene) {
    chosen::patient(ui, state, controlled);
    chosen::scene(ui, state, controlled);
    chosen::placement(ui, state, controlled, own);
    chosen::files(ui, state, controlled);
    time(ui, state, controlled);
    gaze(ui, state, controlled);
    pupil(ui, state, controlled);
    // Below what is used while time runs, which has to be in reach on a telephone.
    anatomy::anatomy(ui, state, controlled);
    panels(ui, state, controlled);
    numbers(ui, controlled);
    ledger(ui, state);
    ui.add_space(6.0);
    ui.weak("Drag the eye to walk around it, scroll or pinch to come nearer, double-click for the front. Click in the view to look there, drag it to turn the head.");
    if !state.touch {
        ui.weak("Space pause · . step · R restart · W A S D or arrows walk · 1 2 B panels · M marker · H controls.");
    }
}

fn time(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.separator();
    ui.horizontal(|ui| {
        let label = if controlled.clock.paused {
            "▶ Run"
        } else {
            "⏸ Pause"
        };
        if ui.button(label).clicked() {
            controlled.clock.paused = !controlled.clock.paused;
        }
        if ui
            .button("Step")
            .on_hover_text("one sixtieth of a second, then pause")
            .clicked()
        {
            controlled.clock.paused = true;
            controlled.clock.steps += 1;
        }
        if ui.button("Restart").clicked() {
            let seed = state
                .seed
                .trim()
                .parse()
                .unwrap_or_else(|_| controlled.seed());
            controlled
                .session_commands
                .write(SessionCommand::Restart(seed));
        }
    });
    ui.horizontal(|ui| {
        ui.label("Seed");
        let field = ui.add(egui::TextEdit::singleline(&mut state.seed).desired_width(90.0));
        state.places.insert("seed", field.rect);
        super::touch::raise_keyboard(&field);
        let valid = state.seed.trim().parse::<u64>();
        if field.lost_focus()
            && let Ok(seed) = valid
            && seed != controlled.seed()
        {
            controlled
                .session_commands
                .write(SessionCommand::Restart(seed));
        }
    });
    if state.seed.trim().parse::<u64>().is_err() {
        // Below the field: beside it there is no room for it, and the pictures would have to make some.
        ui.colored_label(
            ui.visuals().error_fg_color,
            "The seed is a whole number from 0 to 18446744073709551615.",
        );
    }
    let slider = ui.add(
        egui::Slider::new(&mut controlled.clock.speed, 0.05..=4.0)
            .logarithmic(true)
            .suffix("×")
            .text("speed"),
    );
    state.places.insert("speed", slider.rect);
}

fn gaze(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.separator();
    let before = state.gaze;
    ui.horizontal(|ui| {
        ui.label("Gaze");
        ui.selectable_value(&mut state.gaze, GazeMode::Auto, "auto");
        ui.selectable_value(&mut state.gaze, GazeMode::Follow, "follow pointer");
        ui.selectable_value(&mut state.gaze, GazeMode::Fixed, "fixed");
    });
    if state.gaze != before {
        if let Some(controller) = controlled.view.controller() {
            let now = controller.state();
            state.fixed_at = (
                now.fixation_azimuth_rad,
                now.fixation_elevation_rad,
                now.fixation_distance_m,
            );
        }
        let command = MotionCommand::Gaze(state.gaze_command());
        controlled.motion_commands.write(command);
    }
    ui.horizontal(|ui| {
        if ui.button("Blink").clicked() {
            controlled.motion_commands.write(MotionCommand::Blink);
        }
        let mut marker = controlled.view.options().marker;
        if ui.checkbox(&mut marker, "show where it looks").changed() {
            controlled.set_marker(marker);
        }
    });
}

fn pupil(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let now = controlled
        .view
        .controller()
        .map_or(USUAL_PUPIL_MM, |controller| controller.state().pupil_mm);
    let mut held = state.held_pupil_mm.is_some();
    let mut diameter = state.held_pupil_mm.unwrap_or(now);
    ui.horizontal(|ui| {
        ui.label("Pupil");
        ui.checkbox(&mut held, "hold at");
        // The number beside it must not be pushed out.
        let number = if state.touch { 84.0 } else { 66.0 };
        ui.spacing_mut().slider_width = (ui.available_width() - number).clamp(40.0, 130.0);
        let slider = egui::Slider::new(&mut diameter, PUPIL_RANGE_MM.0..=PUPIL_RANGE_MM.1)
            .suffix(" mm")
            .fixed_decimals(1);
        ui.add_enabled(held, slider);
    });
    let wanted = held.then_some(diameter);
    if wanted != state.held_pupil_mm {
        state.held_pupil_mm = wanted;
        controlled
            .motion_commands
            .write(MotionCommand::Pupil(wanted));
    }
}

fn panels(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Show");
        let mut shown = controlled.panels.shown();
        ui.checkbox(&mut shown[0], "the eye");
        ui.checkbox(&mut shown[1], "its view");
        controlled.panels.show(shown);
    });
    ui.horizontal(|ui| {
        ui.label("Save PNG");
        let shown = controlled.panels.shown();
        for (name, saved, can) in [
            ("eye", Saved::Eye, shown[0]),
            ("view", Saved::View, shown[1]),
            ("both", Saved::Both, shown == [true; 2]),
        ] {
            let button = ui.add_enabled(can, egui::Button::new(name));
            state.places.insert(
                match saved {
                    Saved::Eye => "save eye",
                    Saved::View => "save view",
                    Saved::Both => "save both",
                },
                button.rect,
            );
            if button.clicked() {
                controlled.requests.write(Request::Save(saved));
            }
        }
    });
    ui.horizontal(|ui| {
        ui.label("Eye from");
        for (name, azimuth_deg) in [("front", 0.0), ("30°", 30.0), ("60°", 60.0)] {
            if ui.button(name).clicked() {
                controlled.view.set_orbit(EyeOrbit {
                    azimuth_deg,
                    ..EyeOrbit::default()
                });
            }
        }
    });
    ui.horizontal(|ui| {
        ui.label("Light");
        let lit = controlled.view.light();
        let response = egui::ComboBox::from_id_salt("light")
            .selected_text(lit.name())
            .show_ui(ui, |ui| {
                for light in PanelLight::ALL {
                    let label = ui.selectable_label(lit == light, light.name());
                    if label.on_hover_text(light.description()).clicked() {
                        controlled.view.set_light(light);
                    }
                }
            });
        state.places.insert("light", response.response.rect);
    });
}

fn numbers(ui: &mut Ui, controlled: &Controlled) {
    let Some(controller) = controlled.view.controller() else {
        return;
    };
    let state = controller.state();
    ui.separator();
    egui::Grid::new("numbers").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.weak(name);
            ui.monospace(value);
            ui.end_row();
        };
        row("time", format!("{:.2} s", state.time_s));
        row(
            "gaze",
            format!(
                "{:+.1}° {:+.1}°",
                state.gaze_azimuth_rad.to_degrees(),
                state.gaze_elevation_rad.to_degrees()
            ),
        );
        row("fixates at", distance(state.fixation_distance_m));
        row("lens", format!("{:.2} D", state.accommodation_d));
        row("pupil", format!("{:.2} mm", state.pupil_mm));
        row("fixations", state.fixation_index.to_string());
        row("blinks", state.blink_epoch.to_string());
        row(
            "candidates",
            controlled
                .view
                .percept()
                .map_or(0, |percept| percept.captured().corners.len())
                .to_string(),
        );
    });
}

fn distance(distance_m: f64) -> String {
    if distance_m.is_infinite() {
        "infinity".into()
    } else if distance_m < 1.0 {
        format!("{:.0} cm", distance_m * 100.0)
    } else {
        format!("{distance_m:.2} m")
    }
}

fn ledger(ui: &mut Ui, state: &UiState) {
    ui.separator();
    egui::CollapsingHeader::new("Work in the last second")
        .default_open(false)
        .show(ui, |ui| {
            ui.weak(format!("{:.1} ms between frames", state.frame_ms));
            egui::Grid::new("ledger").num_columns(2).show(ui, |ui| {
                for (name, count) in state.work.entries() {
                    ui.weak(name.replace('_', " "));
                    ui.monospace(count.to_string());
                    ui.end_row();
                }
            });
        });
}
