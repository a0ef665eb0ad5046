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
    let shown = controlled.panels.shown();
    state.rectangles = rectangles(area, shown);
    if shown == [false, false] {
        ui.centered_and_justified(|ui| {
            ui.weak("Both panels are hidden: nothing is drawn. Press B, or choose one among the controls.")
        });
        return;
    }
    // Points times this are the pixels of the screen that the window is on now.
    let scale = ui.ctx().pixels_per_point();
    if let Some(rectangle) = state.rectangles[0] {
        resize(
            &mut controlled.panels.eye_mut(),
            &mut controlled.images,
            rectangle,
            scale,
        );
        eye(ui, controlled, pictures[0], rectangle);
    }
    if let Some(rectangle) = state.rectangles[1] {
        resize(
            &mut controlled.panels.view_mut(),
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
    panel: &mut crate::frame::Panel,
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
    // A drag only: where a click may be meant too, a finger that rests before it moves is no drag.
    let response = ui.interact(rectangle, "eye".into(), Sense::drag());
    paint(ui, picture, rectangle);
    let mut orbit = controlled.view.orbit();
    // Two fingers pinch; where they go together is not a drag of one.
    let pinched = ui.input(|input| input.multi_touch());
    if let Some(pinch) = pinched {
        if rectangle.contains(pinch.center_pos) {
            orbit.distance_mm /= pinch.zoom_delta.clamp(0.5, 2.0);
        }
    } else if response.dragged() {
        let drag = response.drag_delta();
        // The eye turns with the pointer, so the camera goes the other way; seen from in front
        // the patient's right is on the left.
        orbit.azimuth_deg += drag.x * 0.35;
        orbit.elevation_deg += drag.y * 0.35;
    } else if response.hovered() {
        let (scroll, zoom) = ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
        orbit.distance_mm *= (-scroll * 0.002).exp() / zoom.clamp(0.5, 2.0);
    }
    let is_double_click = ui.input(|input| {
        input
            .pointer
            .button_double_clicked(egui::PointerButton::Primary)
    });
    if is_double_click && response.contains_pointer() {
        orbit = EyeOrbit::default();
    }
    controlled.view.set_orbit(orbit);
}

/// Seconds for which it is told what went well.
const NOTICE_S: f64 = 8.0;

/// What went wrong, until it is dismissed, and what went well, for a while: over the pictures, so that
/// nothing moves under the pointer, and at their lower edge, where the eye is not.
pub fn notices(ui: &mut Ui, state: &mut UiState, now_s: f64) {
    if let Some((_, from_s)) = &mut state.notice
        && now_s - *from_s.get_or_insert(now_s) > NOTICE_S
    {
        state.notice = None;
    }
    if state.message.is_none() && state.notice.is_none() {
        return;
    }
    let area = ui.max_rect();
    egui::Area::new("notices".into())
        .pivot(egui::Align2::LEFT_BOTTOM)
        .fixed_pos(area.left_bottom() + vec2(8.0, -8.0))
        .show(ui.ctx(), |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width((area.width() - 84.0).clamp(120.0, 460.0));
                if let Some((notice, _)) = state.notice.clone()
                    && ui
                        .add(egui::Label::new(notice).sense(Sense::click()))
                        .clicked()
                {
                    state.notice = None;
                }
                if let Some(message) = state.message.clone() {
                    egui::ScrollArea::vertical()
                        .max_height((area.height() - 96.0).max(60.0))
                        .show(ui, |ui| {
                            for sentence in message.lines() {
                                ui.colored_label(ui.visuals().error_fg_color, sentence);
                            }
                        });
                    if ui.button("Dismiss").clicked() {
                        state.message = None;
                    }
                }
            });
        });
}

/// The button that brings the controls; a telephone has no key for that.
pub fn open_button(ui: &mut Ui, state: &mut UiState) {
    let side = if state.touch { 44.0 } else { 30.0 };
    let corner = ui.max_rect().right_top() + vec2(-side - 8.0, 8.0);
    egui::Area::new("open controls".into())
        .fixed_pos(corner)
        .show(ui.ctx(), |ui| {
            if bars(ui, side, "Show the controls (H)", state) {
                state.toggle_controls = true;
            }
        });
}

/// A square button with three bars.
pub fn bars(ui: &mut Ui, side: f32, hint: &str, state: &mut UiState) -> bool {
    let (rectangle, response) = ui.allocate_exact_size(vec2(side, side), Sense::click());
    state.places.insert("controls", rectangle);
    let visuals = ui.style().interact(&response);
    let painter = ui.painter();
    painter.rect_filled(rectangle, 5.0, visuals.weak_bg_fill.gamma_multiply(0.85));
    for step in [-1.0, 0.0, 1.0] {
        let y = rectangle.center().y + step * side * 0.2;
        let x = rectangle.x_range().shrink(side * 0.24);
        painter.hline(x, y, egui::Stroke::new(2.0, visuals.text_color()));
    }
    response.on_hover_text(hint).clicked()
}

/// The view goes with the pointer: `share` of its width and height.
fn turn_head(controlled: &mut Controlled, share: egui::Vec2) {
    let Some(percept) = controlled.view.percept() else {
        return;
    };
    let angles = 2.0 * Vec2::new(percept.half_field().x.atan(), percept.half_field().y.atan());
    let mut head = controlled.view.head();
    head.yaw_deg -= (share.x * angles.x).to_degrees();
    head.pitch_deg += (share.y * angles.y).to_degrees();
    controlled.view.set_head(head);
}

/// What happens with a file that hovers over the window, or is being read.
pub fn own_file(ui: &mut Ui, reading: bool) {
    let area = ui.max_rect();
    let sentence = if reading {
        "Reading…"
    } else {
        "Drop a photograph, a model or a patient file: it stays on this machine."
    };
    let painter = ui.ctx().layer_painter(egui::LayerId::new(
        egui::Order::Foreground,
        "own file".into(),
    ));
    painter.rect_filled(area, 0.0, egui::Color32::from_black_alpha(150));
    let colour = egui::Color32::from_gray(225);
    let text = painter.layout(
        sentence.into(),
        egui::FontId::proportional(16.0),
        colour,
        area.width() - 32.0,
    );
    painter.galley(area.center() - 0.5 * text.size(), text, colour);
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
        // On a ground of its own: behind it is whatever was seen before.
        let text = ui.painter().layout_no_wrap(
            "preparing the view…".into(),
            egui::FontId::proportional(13.0),
            ui.visuals().text_color(),
        );
        let place =
            rectangle.center_bottom() - vec2(0.5 * text.size().x, 18.0 + 0.5 * text.size().y);
        let ground = Rect::from_min_size(place, text.size()).expand(5.0);
        ui.painter()
            .rect_filled(ground, 4.0, egui::Color32::from_black_alpha(170));
        ui.painter().galley(place, text, ui.visuals().text_color());
        return;
    }
    // A second finger is a pinch, and no place to look at.
    if ui.input(|input| input.multi_touch().is_some()) {
        return;
    }
    if response.dragged() {
        turn_head(controlled, response.drag_delta() / rectangle.size());
    }
    let target = |at: egui::Pos2| {
        let share = (at - rectangle.min) / rectangle.size();
        let size = controlled.panels.view().size.as_vec2();
        let percept = controlled.view.percept()?;
        Some(percept.look_at(Vec2::new(share.x * size.x, share.y * size.y)))
    };
    let command = if response.clicked() {
        let at = response.interact_pointer_pos().and_then(target);
        at.map(|(azimuth_rad, elevation_rad, distance_m)| {
            if state.gaze == GazeMode::Auto {
                return GazeCommand::LookOnce {
                    azimuth_rad,
                    elevation_rad,
                    distance_m,
                };
            }
            state.fixed_at = (azimuth_rad, elevation_rad, distance_m);
            state.gaze_command()
        })
    } else if state.gaze == GazeMode::Follow {
        // egui knows a moving pointer only by several frames a tenth of a second.
        let moved = response
            .hover_pos()
            .filter(|at| state.followed != Some(*at));
        let place = moved.and_then(|at| {
            state.followed = Some(at);
            target(at)
        });
        place.map(|(azimuth_rad, elevation_rad, distance_m)| {
            state.fixed_at = (azimuth_rad, elevation_rad, distance_m);
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
