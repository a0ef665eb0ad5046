//! The two pictures side by side, with what the pointer does in them.

use super::{Controlled, GazeMode, UiState};
use crate::appearance::EyeOrbit;
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use bevy::math::{UVec2, Vec2};
use bevy_egui::egui::{self, Rect, Sense, TextureId, Ui, pos2, vec2};

/// Gap between the pictures, points.
const GAP: f32 = 2.0;

/// Draws the pictures that are shown and gives their panels the size in which they are shown.
pub fn draw(
    ui: &mut Ui,
    state: &mut UiState,
    controlled: &mut Controlled,
    pictures: [Option<TextureId>; 2],
) {
    let area = ui.available_rect_before_wrap();
    let shown = [
        controlled.panels.eye.visible,
        controlled.panels.view.visible,
    ];
    state.rectangles = rectangles(area, shown);
    if shown == [false, false] {
        ui.centered_and_justified(|ui| {
            ui.weak("Both panels are hidden: nothing is drawn. Press B.")
        });
        return;
    }
    let scale = ui.ctx().pixels_per_point();
    if let Some(rectangle) = state.rectangles[0] {
        resize(
            &mut controlled.panels.eye,
            &mut controlled.images,
            rectangle,
            scale,
        );
        eye(ui, controlled, pictures[0], rectangle);
    }
    if let Some(rectangle) = state.rectangles[1] {
        resize(
            &mut controlled.panels.view,
            &mut controlled.images,
            rectangle,
            scale,
        );
        view(ui, state, controlled, pictures[1], rectangle);
    }
}

fn rectangles(area: Rect, shown: [bool; 2]) -> [Option<Rect>; 2] {
    let whole = (area.width() > 8.0 && area.height() > 8.0).then_some(area);
    match shown {
        [true, true] => {
            // Side by side, or one above the other in a tall window.
            let (first, second) = if area.width() >= area.height() {
                let middle = area.center().x;
                (
                    Rect::from_min_max(area.min, pos2(middle - GAP * 0.5, area.max.y)),
                    Rect::from_min_max(pos2(middle + GAP * 0.5, area.min.y), area.max),
                )
            } else {
                let middle = area.center().y;
                (
                    Rect::from_min_max(area.min, pos2(area.max.x, middle - GAP * 0.5)),
                    Rect::from_min_max(pos2(area.min.x, middle + GAP * 0.5), area.max),
                )
            };
            [whole.map(|_| first), whole.map(|_| second)]
        }
        [eye, view] => [whole.filter(|_| eye), whole.filter(|_| view)],
    }
}

fn resize(
    panel: &mut crate::app::Panel,
    images: &mut bevy::asset::Assets<bevy::image::Image>,
    rectangle: Rect,
    scale: f32,
) {
    let size = UVec2::new(
        (rectangle.width() * scale).round() as u32,
        (rectangle.height() * scale).round() as u32,
    );
    panel.resize(images, size);
}

fn paint(ui: &Ui, picture: Option<TextureId>, rectangle: Rect) {
    if let Some(picture) = picture {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter()
            .image(picture, rectangle, whole, egui::Color32::WHITE);
    }
}

fn eye(ui: &mut Ui, controlled: &mut Controlled, picture: Option<TextureId>, rectangle: Rect) {
    let response = ui.interact(rectangle, "eye".into(), Sense::click_and_drag());
    paint(ui, picture, rectangle);
    let mut orbit = *controlled.orbit;
    if response.dragged() {
        let drag = response.drag_delta();
        // The eye turns with the pointer, so the camera goes the other way; seen from in front
        // the patient's right is on the left.
        orbit.azimuth_deg += drag.x * 0.35;
        orbit.elevation_deg += drag.y * 0.35;
    }
    if response.hovered() {
        let scroll =
            ui.input(|input| input.smooth_scroll_delta.y + 120.0 * (input.zoom_delta() - 1.0));
        orbit.distance_mm *= (-scroll * 0.002).exp();
    }
    if response.double_clicked() {
        orbit = EyeOrbit::default();
    }
    let orbit = orbit.clamped();
    if orbit != *controlled.orbit {
        *controlled.orbit = orbit;
    }
}

fn view(
    ui: &mut Ui,
    state: &mut UiState,
    controlled: &mut Controlled,
    picture: Option<TextureId>,
    rectangle: Rect,
) {
    let response = ui.interact(rectangle, "view".into(), Sense::click_and_drag());
    paint(ui, picture, rectangle);
    if !controlled.clock.ready {
        ui.painter().text(
            rectangle.center_bottom() - vec2(0.0, 18.0),
            egui::Align2::CENTER_CENTER,
            "preparing the view…",
            egui::FontId::proportional(13.0),
            ui.visuals().weak_text_color(),
        );
        return;
    }
    let target = |at: egui::Pos2| {
        let share = (at - rectangle.min) / rectangle.size();
        let size = controlled.panels.view.size.as_vec2();
        controlled
            .percept
            .look_at(Vec2::new(share.x * size.x, share.y * size.y))
    };
    let command = if response.clicked() {
        response.interact_pointer_pos().map(|at| {
            let (azimuth_rad, elevation_rad, distance_m) = target(at);
            match state.gaze {
                GazeMode::Auto => GazeCommand::LookOnce {
                    azimuth_rad,
                    elevation_rad,
                    distance_m,
                },
                _ => GazeCommand::Fixed {
                    azimuth_rad,
                    elevation_rad,
                    distance_m,
                },
            }
        })
    } else if state.gaze == GazeMode::Follow && ui.input(|input| input.pointer.is_moving()) {
        response.hover_pos().map(|at| {
            let (azimuth_rad, elevation_rad, distance_m) = target(at);
            GazeCommand::Follow {
                azimuth_rad,
                elevation_rad,
                distance_m,
            }
        })
    } else {
        None
    };
    if let Some(command) = command {
        controlled
            .motion_commands
            .write(MotionCommand::Gaze(command));
    }
}
