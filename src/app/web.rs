//! The app in a browser: what the page's link asks for, and what the page is told.

use super::windowed;
use crate::frame::SimulationClock;
use crate::patients::PatientReader;
use crate::scene::catalog::LoadedScene;
use crate::stage::{Stage, StageView};
use crate::ui::link_state::LinkState;
use crate::ui::{UiState, host, session_of};
use bevy::prelude::*;
use wasm_bindgen::JsValue;

unsafe extern "C" {
    /// Registers the types that Bevy's crates have to register. The linker makes it; in a module that never calls it
    /// the linker has every exported function call it first, which every handle that the page hands over would pay
    /// for: a twelfth of the start, and a part of every frame.
    fn __wasm_call_ctors();
}

/// Runs the app with what the page's link says ([`LinkState`]).
pub fn run() {
    // SAFETY: the linker's own function, without arguments, called once and before what it prepares is used.
    unsafe { __wasm_call_ctors() };
    console_error_panic_hook::set_once();
    let (start, refused) = LinkState::parse(&host::fragment());
    match session_of(&start) {
        Ok(session) => {
            let mut app = windowed::windowed_app(session, start);
            app.world_mut().resource_mut::<UiState>().message =
                (!refused.is_empty()).then(|| refused.join("\n"));
            app.add_systems(Last, publish_state);
            app.run();
        }
        Err(message) => set_global("oculariumError", &JsValue::from_str(&message)),
    }
}

fn set_global(name: &str, value: &JsValue) {
    if let Some(window) = web_sys::window() {
        // Setting a property of the page's window cannot fail.
        let _ = js_sys::Reflect::set(&window, &JsValue::from_str(name), value);
    }
}

/// Four times a second the page learns where things are and how they move.
fn publish_state(
    clock: Res<SimulationClock>,
    stage: Res<Stage>,
    view: StageView,
    patients: PatientReader,
    ui: Res<UiState>,
    readiness: Res<crate::frame::readiness::Readiness>,
    time: Res<Time<Real>>,
    mut last_s: Local<f64>,
    mut announced: Local<bool>,
    mut live_frames: Local<u32>,
) {
    let (Some(controller), Some(patient)) = (view.controller(), patients.file(stage.patient))
    else {
        return;
    };
    if let Some(error) = readiness.errors().first() {
        set_global("oculariumError", &JsValue::from_str(error));
    }
    if clock.ready && clock.time_s > 0.0 {
        *live_frames += 1;
    }
    let now = time.elapsed_secs_f64();
    if now - *last_s < 0.25 && (*announced || *live_frames < 3) {
        return;
    }
    *last_s = now;
    let in_page = |r: bevy_egui::egui::Rect| {
        let [x, y, w, h] = [r.min.x, r.min.y, r.width(), r.height()].map(|side| side * ui.zoom);
        serde_json::json!([x, y, w, h])
    };
    let rectangle = |index: usize| ui.rectangles[index].map_or(serde_json::Value::Null, in_page);
    let places: serde_json::Map<_, _> = ui
        .places
        .iter()
        .map(|(name, place)| ((*name).to_owned(), in_page(*place)))
        .collect();
    // Distance of a photograph's middle, and its height.
    let photograph = match &*stage.scene {
        LoadedScene::Photo(photo) => {
            let middle_m = photo.depth_at_m(photo.width / 2, photo.height / 2);
            serde_json::json!([middle_m, photo.vertical_fov_deg])
        }
        LoadedScene::Model(_) => serde_json::Value::Null,
    };
    let picture = match &*stage.scene {
        LoadedScene::Photo(photo) => photo.picture_at(clock.time_s),
        LoadedScene::Model(_) => 0,
    };
    let model_width_m = match &*stage.scene {
        LoadedScene::Model(model) => model.bounds().map(|(low, high)| high[0] - low[0]),
        LoadedScene::Photo(_) => None,
    };
    let (state, orbit, head) = (controller.state(), view.orbit(), view.head());
    let message = serde_json::json!({
        "time_s": clock.time_s,
        "paused": clock.paused,
        "gaze_azimuth_deg": state.gaze_azimuth_rad.to_degrees(),
        "gaze_elevation_deg": state.gaze_elevation_rad.to_degrees(),
        "pupil_mm": state.pupil_mm,
        "accommodation_d": state.accommodation_d,
        "lid_aperture": state.lid_aperture,
        "fixations": state.fixation_index,
        "patient": patient.name,
        "sphere_d": patient.sphere_d,
        "scene": stage.scene.name(),
        "photograph": photograph,
        "picture": picture,
        "model_width_m": model_width_m,
        "seed": controller.seed().to_string(),
        "speed": clock.speed,
        "orbit": [orbit.azimuth_deg, orbit.elevation_deg, orbit.distance_mm],
        "head": [head.place_m.x, head.place_m.y, head.place_m.z, head.yaw_deg, head.pitch_deg],
        "message": ui.message,
        "notice": ui.notice.as_ref().map(|(sentence, _)| sentence),
        "places": places,
        "panels": { "eye": rectangle(0), "view": rectangle(1) },
    });
    set_global("oculariumState", &JsValue::from_str(&message.to_string()));
    // Three frames after time began, the picture on screen is a live one.
    if *live_frames >= 3 && !*announced {
        *announced = true;
        set_global("oculariumReady", &JsValue::TRUE);
        if let Some(root) = web_sys::window()
            .and_then(|window| window.document())
            .and_then(|document| document.document_element())
        {
            // The page reads this attribute; an element always takes one.
            let _ = root.set_attribute("data-ready", "true");
        }
    }
}

/// Tells the page what stops the app.
pub(super) fn fail(sentence: &str) {
    set_global("oculariumError", &JsValue::from_str(sentence));
}
