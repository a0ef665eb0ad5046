//! The side panel.

use super::{Controlled, GazeMode, UiState};
use crate::anatomy::{PRESETS, load_patient};
use crate::app::SessionCommand;
use crate::appearance::EyeOrbit;
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::scene::catalog::{BuiltIn, LoadedScene};
use bevy_egui::egui::{self, Ui};
use std::sync::Arc;

/// Draws every control.
pub fn draw(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.add_space(4.0);
    ui.heading("Ocularium");
    if let Some(message) = state.message.clone() {
        ui.colored_label(ui.visuals().error_fg_color, message);
        if ui.small_button("dismiss").clicked() {
            state.message = None;
        }
    }
    patient(ui, state, controlled);
    scene(ui, state, controlled);
    time(ui, state, controlled);
    gaze(ui, state, controlled);
    pupil(ui, state, controlled);
    panels(ui, controlled);
    numbers(ui, controlled);
    ledger(ui, state);
    ui.add_space(6.0);
    ui.weak("Space pause · . step · R restart · 1 2 B panels · M marker · H hide this. Drag the eye to walk around it, scroll to come nearer, double-click for the front. Click in the view to look there.");
}

fn patient(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let shown = controlled.session.patient.name.clone();
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.label("Patient");
        egui::ComboBox::from_id_salt("patient")
            .selected_text(shown)
            .width(150.0)
            .show_ui(ui, |ui| {
                for (index, preset) in PRESETS.iter().enumerate() {
                    if ui
                        .selectable_label(state.preset == Some(index), preset.name)
                        .clicked()
                    {
                        chosen = Some(index);
                    }
                }
            });
    });
    if !controlled.session.patient.description.is_empty() {
        ui.weak(controlled.session.patient.description.as_str());
    }
    if let Some(index) = chosen {
        match load_patient(PRESETS[index].name) {
            Ok(patient) => {
                state.preset = Some(index);
                state.held_pupil_mm = None;
                controlled.motion_commands.write(MotionCommand::Pupil(None));
                controlled
                    .session_commands
                    .write(SessionCommand::Patient(Box::new(patient)));
            }
            Err(error) => state.message = Some(error.to_string()),
        }
    }
}

fn scene(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.label("Scene");
        egui::ComboBox::from_id_salt("scene")
            .selected_text(controlled.session.scene.name())
            .width(150.0)
            .show_ui(ui, |ui| {
                for scene in BuiltIn::ALL {
                    let current = controlled.session.scene.name() == scene.name();
                    if ui.selectable_label(current, scene.name()).clicked() {
                        chosen = Some(scene);
                    }
                }
            });
    });
    if let Some(scene) = chosen {
        match scene.build() {
            Ok(model) => {
                controlled
                    .session_commands
                    .write(SessionCommand::Scene(Arc::new(LoadedScene::Model(
                        Box::new(model),
                    ))));
            }
            Err(error) => state.message = Some(error.to_string()),
        }
    }
}

fn time(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.separator();
    let clock = &mut controlled.clock;
    ui.horizontal(|ui| {
        let label = if clock.paused { "▶ Run" } else { "⏸ Pause" };
        if ui.button(label).clicked() {
            clock.paused = !clock.paused;
        }
        if ui
            .button("Step")
            .on_hover_text("one sixtieth of a second, then pause")
            .clicked()
        {
            clock.paused = true;
            clock.steps += 1;
        }
        if ui.button("Restart").clicked() {
            let seed = state.seed.trim().parse().unwrap_or(controlled.session.seed);
            controlled
                .session_commands
                .write(SessionCommand::Restart(seed));
        }
    });
    ui.horizontal(|ui| {
        ui.label("Seed");
        let field = ui.add(egui::TextEdit::singleline(&mut state.seed).desired_width(90.0));
        let valid = state.seed.trim().parse::<u64>();
        if valid.is_err() {
            ui.colored_label(ui.visuals().error_fg_color, "a whole number from 0");
        }
        if field.lost_focus()
            && let Ok(seed) = valid
            && seed != controlled.session.seed
        {
            controlled
                .session_commands
                .write(SessionCommand::Restart(seed));
        }
    });
    ui.add(
        egui::Slider::new(&mut clock.speed, 0.05..=4.0)
            .logarithmic(true)
            .suffix("×")
            .text("speed"),
    );
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
    if state.gaze != before
        && let Some(motion) = &controlled.motion
    {
        let command = match state.gaze {
            GazeMode::Auto => GazeCommand::Auto,
            GazeMode::Follow | GazeMode::Fixed => GazeCommand::Fixed {
                azimuth_rad: motion.state.fixation_azimuth_rad,
                elevation_rad: motion.state.fixation_elevation_rad,
                distance_m: motion.state.fixation_distance_m,
            },
        };
        controlled
            .motion_commands
            .write(MotionCommand::Gaze(command));
    }
    ui.horizontal(|ui| {
        if ui.button("Blink").clicked() {
            controlled.motion_commands.write(MotionCommand::Blink);
        }
        ui.checkbox(&mut controlled.options.marker, "show where it looks");
    });
}

fn pupil(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let now = controlled
        .motion
        .as_ref()
        .map_or(4.0, |motion| motion.state.pupil_mm);
    let mut held = state.held_pupil_mm.is_some();
    let mut diameter = state.held_pupil_mm.unwrap_or(now);
    ui.horizontal(|ui| {
        ui.label("Pupil");
        ui.checkbox(&mut held, "hold at");
        let slider = egui::Slider::new(&mut diameter, 1.0..=9.0)
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

fn panels(ui: &mut Ui, controlled: &mut Controlled) {
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Show");
        ui.checkbox(&mut controlled.panels.eye.visible, "the eye");
        ui.checkbox(&mut controlled.panels.view.visible, "its view");
    });
    ui.horizontal(|ui| {
        ui.label("Eye from");
        for (name, azimuth_deg) in [("front", 0.0), ("30°", 30.0), ("60°", 60.0)] {
            if ui.button(name).clicked() {
                *controlled.orbit = EyeOrbit {
                    azimuth_deg,
                    ..EyeOrbit::default()
                };
            }
        }
    });
}

fn numbers(ui: &mut Ui, controlled: &Controlled) {
    let Some(motion) = &controlled.motion else {
        return;
    };
    let state = &motion.state;
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
            controlled.percept.captured().corners.len().to_string(),
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
