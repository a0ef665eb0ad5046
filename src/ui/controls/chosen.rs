//! What is shown: patient, scene, how a user's own scene stands, files and link.

use super::super::link::built_in;
use super::super::own_files::Placement;
use super::super::state::{Controlled, UiState};
use super::super::{OwnScene, Request, preset_shown};
use crate::motion::MotionCommand;
use crate::patients::{PRESETS, load_patient};
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::scene::depth_file::DepthUnit;
use crate::scene::photo::{PhotoDepth, PhotoOptions, PhotoScene};
use crate::stage::SessionCommand;
use bevy_egui::egui::{self, Ui};
use std::sync::Arc;

/// The list of patients, by their titles.
pub fn patient(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let Some(shown) = controlled.patient() else {
        return;
    };
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.label("Patient");
        let list = egui::ComboBox::from_id_salt("patient")
            .selected_text(shown.name.as_str())
            .width((ui.available_width() - 12.0).max(80.0))
            .truncate()
            .show_ui(ui, |ui| {
                let shown = preset_shown(&shown);
                for (index, title) in state.titles.iter().enumerate() {
                    if ui.selectable_label(shown == Some(index), title).clicked() {
                        chosen = Some(index);
                    }
                }
            });
        state.places.insert("patients", list.response.rect);
    });
    if !shown.description.is_empty() {
        ui.weak(shown.description.as_str());
    }
    if !state.changes.is_empty() {
        ui.label(format!("Changed: {}", state.changes));
    }
    let Some(preset) = chosen.and_then(|index| PRESETS.get(index)) else {
        return;
    };
    match load_patient(preset.name) {
        Ok(patient) => {
            state.held_pupil_mm = None;
            controlled.motion_commands.write(MotionCommand::Pupil(None));
            controlled
                .session_commands
                .write(SessionCommand::Patient(Box::new(patient)));
        }
        Err(error) => state.message = Some(error.to_string()),
    }
}

/// The list of scenes, by their titles, and what there is to know about how a user's own was read.
pub fn scene(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let shown = built_in(&controlled.stage.scene);
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.label("Scene");
        let title = match shown {
            Some(scene) => scene.title().to_owned(),
            None => file_name(controlled.stage.scene.name()),
        };
        egui::ComboBox::from_id_salt("scene")
            .selected_text(title)
            .width((ui.available_width() - 12.0).max(80.0))
            .truncate()
            .show_ui(ui, |ui| {
                for scene in BuiltIn::ALL {
                    let label = ui.selectable_label(shown == Some(scene), scene.title());
                    if label.on_hover_text(scene.description()).clicked() {
                        chosen = Some(scene);
                    }
                }
            });
    });
    for remark in controlled.stage.scene.remarks() {
        ui.weak(remark);
    }
    if controlled.clock.ready && state.nothing_in_view {
        ui.colored_label(
            ui.visuals().warn_fg_color,
            "Nothing of it that has a distance is in the view: the eye looks past it, sees its back or its edge, looks through it, or has it nearer than 2 cm.",
        );
    }
    if let Some(scene) = chosen {
        controlled.show_built_in(scene, state);
    }
}

fn file_name(path: &str) -> String {
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_owned()
}

/// Distance and height of a photograph, the unit of a model.
pub fn placement(
    ui: &mut Ui,
    state: &mut UiState,
    controlled: &mut Controlled,
    own: &mut OwnScene,
) {
    // Another scene is another allocation.
    let scene_id = Arc::as_ptr(&controlled.stage.scene).addr();
    match &*Arc::clone(&controlled.stage.scene) {
        LoadedScene::Photo(photo) => {
            if let Some(stood) = photograph(ui, state, photo, scene_id) {
                controlled.show_scene(LoadedScene::Photo(Arc::new(stood)));
            }
            if photo.depth_m.constant_m().is_none() && own.files.is_some() {
                let asked = depth(ui, state, own.placement.photo, scene_id);
                if let Some(asked) = asked {
                    controlled.requests.write(Request::ReadAgain(Placement {
                        photo: PhotoOptions {
                            vertical_fov_deg: photo.vertical_fov_deg,
                            ..asked
                        },
                        ..own.placement
                    }));
                }
            }
        }
        LoadedScene::Model(_)
            if own.files.is_some() && built_in(&controlled.stage.scene).is_none() =>
        {
            ui.horizontal_wrapped(|ui| {
                ui.label("Its unit");
                for (name, unit_m) in [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254)] {
                    let shown = own.placement.unit_m.unwrap_or(1.0) == unit_m;
                    let label = ui.selectable_label(shown, name);
                    if name == "cm" {
                        state.places.insert("unit cm", label.rect);
                    }
                    if label.clicked() {
                        controlled.requests.write(Request::ReadAgain(Placement {
                            unit_m: Some(unit_m),
                            ..own.placement
                        }));
                    }
                }
            });
        }
        LoadedScene::Model(_) => {}
    }
}

/// Where a photograph stands; the photograph anew where a slider has moved it and is let go.
fn photograph(
    ui: &mut Ui,
    state: &mut UiState,
    photo: &PhotoScene,
    scene_id: usize,
) -> Option<PhotoScene> {
    let stands = (photo.depth_m.constant_m(), photo.vertical_fov_deg);
    // Another photograph begins where it stands itself.
    let id = egui::Id::new(("photo placement", scene_id));
    let mut wanted = ui.data(|data| data.get_temp(id)).unwrap_or(stands);
    let mut settled = false;
    let mut slide = |name: &'static str, slider: egui::Slider| {
        // What stands elsewhere than a slider reaches stays there until it is moved.
        let slider = ui.add(slider.clamping(egui::SliderClamping::Edits).text(name));
        state.places.insert(name, slider.rect);
        settled |= slider.drag_stopped() || slider.lost_focus();
    };
    if let Some(distance_m) = &mut wanted.0 {
        let slider = egui::Slider::new(distance_m, 0.1..=100.0);
        slide("away", slider.logarithmic(true).suffix(" m"));
    }
    let slider = egui::Slider::new(&mut wanted.1, 1.0..=120.0);
    slide("high", slider.suffix("°"));
    ui.data_mut(|data| data.insert_temp(id, wanted));
    if !settled || wanted == stands {
        return None;
    }
    let mut stood = photo.clone();
    if let Some(distance_m) = wanted.0 {
        stood.depth_m = PhotoDepth::Constant(distance_m);
    }
    stood.vertical_fov_deg = wanted.1;
    Some(stood)
}

/// What the codes of a photograph's depth image mean; another reading where one is chosen, or a slider
/// has been moved and is let go.
fn depth(
    ui: &mut Ui,
    state: &mut UiState,
    read: PhotoOptions,
    scene_id: usize,
) -> Option<PhotoOptions> {
    let id = egui::Id::new(("depth image", scene_id));
    let mut wanted = ui.data(|data| data.get_temp(id)).unwrap_or(read);
    let mut settled = false;
    ui.horizontal_wrapped(|ui| {
        ui.label("Its depth");
        for (name, unit) in [
            ("m", DepthUnit::Metres),
            ("cm", DepthUnit::Centimetres),
            ("mm", DepthUnit::Millimetres),
            ("dioptre", DepthUnit::Dioptres),
            ("inverse", DepthUnit::Inverse),
        ] {
            let label = ui.selectable_label(wanted.depth_unit == Some(unit), name);
            if unit == DepthUnit::Inverse {
                state.places.insert("inverse", label.rect);
            }
            if label.clicked() {
                wanted.depth_unit = Some(unit);
                settled = true;
            }
        }
    });
    if wanted.depth_unit == Some(DepthUnit::Inverse) {
        let mut slide = |name: &'static str, distance_m: &mut f32, range| {
            let slider = egui::Slider::new(distance_m, range).logarithmic(true);
            let slider = ui.add(slider.largest_finite(1000.0).suffix(" m").text(name));
            state.places.insert(name, slider.rect);
            settled |= slider.drag_stopped() || slider.lost_focus();
        };
        slide("white", &mut wanted.near_m, 0.05..=10.0);
        let beyond = wanted.near_m * 1.01;
        wanted.far_m = wanted.far_m.max(beyond);
        slide("black", &mut wanted.far_m, beyond..=f32::INFINITY);
    }
    ui.data_mut(|data| data.insert_temp(id, wanted));
    (settled && wanted != read).then_some(wanted)
}

/// Own files, what becomes of them, and the link.
pub fn files(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    ui.horizontal_wrapped(|ui| {
        let open = ui.button("Open own file…").on_hover_text(
            "A photograph (with its depth image, if there is one), several pictures that follow one another, a glTF model, or a patient file. It stays on this machine.",
        );
        state.places.insert("open", open.rect);
        if open.clicked() {
            controlled.requests.write(Request::ChooseFiles);
        }
        let copy = ui.button("Copy link").on_hover_text(if cfg!(target_arch = "wasm32") {
            "The address of this page as it is shown now"
        } else {
            "A command line that shows this; its link opens in a browser too"
        });
        state.places.insert("copy", copy.rect);
        if copy.clicked() {
            controlled.requests.write(Request::CopyLink);
        }
    });
    if cfg!(target_arch = "wasm32") {
        ui.weak("Your files stay on this machine: nothing is uploaded.");
    }
}
