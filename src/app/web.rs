//! The app in a browser: what the page's link asks for, and what the page is told.

use super::{Session, SimulationClock, windowed};
use crate::anatomy::{PRESETS, load_patient, preset};
use crate::motion::Motion;
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::ui::UiState;
use bevy::prelude::*;
use wasm_bindgen::JsValue;

/// Runs the app; the link's fragment may name `patient`, `scene` and `seed`, as in
/// `#patient=glaucoma-moderate&scene=room&seed=7`.
pub fn run() {
    console_error_panic_hook::set_once();
    let fragment = web_sys::window()
        .and_then(|window| window.location().hash().ok())
        .unwrap_or_default();
    match session(&fragment) {
        Ok((session, message)) => {
            let mut app = windowed::windowed_app(session);
            app.world_mut().resource_mut::<UiState>().message = message;
            app.add_systems(Last, tell_page);
            app.run();
        }
        Err(message) => tell("oculariumError", &JsValue::from_str(&message)),
    }
}

/// The session of a link, and what the user should know about what it asked for in vain.
fn session(fragment: &str) -> Result<(Session, Option<String>), String> {
    let value = |name: &str| {
        fragment
            .trim_start_matches('#')
            .split('&')
            .filter_map(|pair| pair.split_once('='))
            .find(|(key, _)| *key == name)
            .map(|(_, value)| value.to_owned())
    };
    let mut refused = Vec::new();
    let wanted = value("patient").unwrap_or_else(|| "healthy-brown".into());
    let name = preset(&wanted).map_or_else(
        || {
            let known: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
            refused.push(format!(
                "The link names no known patient ({wanted:?}); there are {}.",
                known.join(", ")
            ));
            "healthy-brown"
        },
        |preset| preset.name,
    );
    let patient = load_patient(name).map_err(|error| error.to_string())?;
    let wanted = value("scene").unwrap_or_else(|| BuiltIn::Room.name().into());
    let known = BuiltIn::ALL
        .into_iter()
        .find(|scene| scene.name() == wanted);
    let scene = known.unwrap_or_else(|| {
        let known: Vec<_> = BuiltIn::ALL.iter().map(|scene| scene.name()).collect();
        refused.push(format!(
            "The link names no known scene ({wanted:?}); there are {}.",
            known.join(", ")
        ));
        BuiltIn::Room
    });
    let model = scene.build().map_err(|error| error.to_string())?;
    let seed = value("seed").map_or(1, |seed| {
        seed.parse().unwrap_or_else(|_| {
            refused.push(format!(
                "The link's seed {seed:?} is not a whole number from 0."
            ));
            1
        })
    });
    let session = Session::new(patient, LoadedScene::Model(Box::new(model)), seed);
    Ok((session, (!refused.is_empty()).then(|| refused.join(" "))))
}

fn tell(name: &str, value: &JsValue) {
    if let Some(window) = web_sys::window() {
        // Setting a property of the page's window cannot fail.
        let _ = js_sys::Reflect::set(&window, &JsValue::from_str(name), value);
    }
}

/// Four times a second the page learns where things are and how they move.
fn tell_page(
    clock: Res<SimulationClock>,
    motion: Option<Res<Motion>>,
    ui: Res<UiState>,
    readiness: Res<crate::readiness::Readiness>,
    time: Res<Time<Real>>,
    mut last_s: Local<f64>,
    mut announced: Local<bool>,
    mut live_frames: Local<u32>,
) {
    let Some(motion) = motion else { return };
    if let Some(error) = readiness.errors().first() {
        tell("oculariumError", &JsValue::from_str(error));
    }
    if clock.ready && clock.time_s > 0.0 {
        *live_frames += 1;
    }
    let now = time.elapsed_secs_f64();
    if now - *last_s < 0.25 && (*announced || *live_frames < 3) {
        return;
    }
    *last_s = now;
    let rectangle = |index: usize| {
        ui.rectangles[index].map_or(serde_json::Value::Null, |r| {
            serde_json::json!([r.min.x, r.min.y, r.width(), r.height()])
        })
    };
    let state = &motion.state;
    let message = serde_json::json!({
        "time_s": clock.time_s,
        "paused": clock.paused,
        "gaze_azimuth_deg": state.gaze_azimuth_rad.to_degrees(),
        "gaze_elevation_deg": state.gaze_elevation_rad.to_degrees(),
        "pupil_mm": state.pupil_mm,
        "accommodation_d": state.accommodation_d,
        "lid_aperture": state.lid_aperture,
        "fixations": state.fixation_index,
        "panels": { "eye": rectangle(0), "view": rectangle(1) },
    });
    tell("oculariumState", &JsValue::from_str(&message.to_string()));
    // Three frames after time began, the picture on screen is a live one.
    if *live_frames >= 3 && !*announced {
        *announced = true;
        tell("oculariumReady", &JsValue::TRUE);
        if let Some(root) = web_sys::window()
            .and_then(|window| window.document())
            .and_then(|document| document.document_element())
        {
            // The page reads this attribute; an element always takes one.
            let _ = root.set_attribute("data-ready", "true");
        }
    }
}
