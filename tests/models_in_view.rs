//! What a model's file says of light and surfaces, as the view shows it.

use crate::percept_gpu::photo_session;
use crate::stage::{open, patient, settle, turn, without_blinks};
use bevy::math::UVec2;
use ocularium::lab::headless::{Headless, Which};
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::scene::catalog::LoadedScene;
use ocularium::scene::gltf_file::{Beside, load_gltf_among};
use ocularium::scene::model::{SceneModel, UNLIT_WHITE_CD_M2, srgb_to_linear};
use ocularium::stage::{Session, SessionCommand};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

/// Of the luminance over the mean, what is shown of it.
const MIDDLE_GREY: f64 = 0.3;

/// A file of `tests/data/gltf`, as JSON.
fn file(name: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join(name)).expect("a test file");
    serde_json::from_str(&text).expect("JSON")
}

fn model(json: &Value) -> SceneModel {
    load_gltf_among(
        json.to_string().as_bytes(),
        "test.gltf",
        Beside::Files(&[]),
        None,
    )
    .unwrap_or_else(|error| panic!("{error}"))
}

fn app() -> Headless {
    let model = model(&file("quad_control.gltf"));
    let eye = PatientFile {
        pupil: PupilSetting::Fixed(2.0),
        ..patient("healthy-blue")
    };
    let session = Session::new(eye, LoadedScene::Model(Box::new(model)), 1);
    open(session, UVec2::splat(16), UVec2::splat(64), [false, true])
}

/// The linear colour in the middle of the view, where each file has its quad.
fn middle(headless: &mut Headless, model: SceneModel) -> [f64; 3] {
    let scene = Arc::new(LoadedScene::Model(Box::new(model)));
    headless.command(SessionCommand::Scene(scene));
    headless.go_to(0.0);
    settle(headless);
    without_blinks(headless);
    let view = headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"));
    let [r, g, b, _] = view.get_pixel(32, 32).0;
    [r, g, b].map(|code| f64::from(srgb_to_linear(code)))
}

/// A file whose only material is this.
fn with_material(name: &str, material: Value) -> Value {
    let mut json = file(name);
    json["materials"] = json!([material]);
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    json["extensionsUsed"] = json!([
        "KHR_materials_unlit",
        "KHR_materials_emissive_strength",
        "KHR_texture_transform"
    ]);
    json
}

fn assert_near(found: [f64; 3], wanted: [f64; 3], what: &str) {
    for (found, wanted) in found.iter().zip(wanted) {
        // A code of 255 is at most 0.009 of linear light, and the eye's own blur changes nothing here.
        assert!(
            (found - wanted).abs() < 0.005,
            "{what}: {found} in place of {wanted}"
        );
    }
}

#[test]
fn what_shines_has_the_luminance_that_its_file_says() {
    let _turn = turn();
    let mut headless = app();
    let black = json!({"baseColorFactor": [0, 0, 0, 1], "roughnessFactor": 1, "metallicFactor": 1});
    for (strength, factor) in [(1.0, [1.0, 0.5, 0.25]), (10.0, [0.6, 1.0, 0.1])] {
        let emission = with_material(
            "quad_control.gltf",
            json!({
            "pbrMetallicRoughness": black, "emissiveFactor": factor,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}}),
        );
        let mut model = model(&emission);
        // White of this strength is as bright as the mean.
        model.mean_luminance_cd_m2 = strength * f64::from(UNLIT_WHITE_CD_M2);
        let seen = middle(&mut headless, model);
        assert_near(seen, factor.map(|f| MIDDLE_GREY * f), "emission");
    }
    // An unlit surface has its colour whatever shines on it; a lit one has not.
    let colour = json!({"baseColorFactor": [0.2, 0.5, 0.9, 1]});
    let mut lit = model(&with_material(
        "quad_control.gltf",
        json!({"pbrMetallicRoughness": colour}),
    ));
    let mut unlit = model(&with_material(
        "quad_control.gltf",
        json!({
        "pbrMetallicRoughness": colour, "extensions": {"KHR_materials_unlit": {}}}),
    ));
    lit.mean_luminance_cd_m2 = f64::from(UNLIT_WHITE_CD_M2);
    unlit.mean_luminance_cd_m2 = f64::from(UNLIT_WHITE_CD_M2);
    let wanted = [0.2, 0.5, 0.9].map(|f| MIDDLE_GREY * f);
    assert_near(middle(&mut headless, unlit.clone()), wanted, "unlit");
    unlit.lights.clear();
    assert_near(middle(&mut headless, unlit), wanted, "unlit in the dark");
    lit.lights.clear();
    assert_near(middle(&mut headless, lit), [0.0; 3], "lit in the dark");
}

#[test]
fn each_texture_lies_as_it_says() {
    let _turn = turn();
    let mut headless = app();
    // Green in its last quarter and red elsewhere: as base colour, and as emission over a base colour
    // that lies otherwise.
    let mut json = file("texture_transform.gltf");
    let base = json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].clone();
    let is_green = |[r, g, _]: [f64; 3]| g > 0.1 && r < 0.02;
    assert!(is_green(middle(&mut headless, model(&json))));
    let moved = with_material(
        "texture_transform.gltf",
        json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "baseColorTexture": {"index": base["index"]}},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": base}),
    );
    let read = model(&moved);
    assert!(read.meshes[0].second_uvs.is_some());
    let seen = middle(&mut headless, read);
    assert!(is_green(seen), "{seen:?}");
    // Without its own place it lies as the base colour does, where the middle is red.
    let mut plain = moved.clone();
    plain["materials"][0]["emissiveTexture"] = json!({"index": base["index"]});
    let seen = middle(&mut headless, model(&plain));
    assert!(!is_green(seen), "{seen:?}");
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] =
        json!({"index": base["index"]});
    let seen = middle(&mut headless, model(&json));
    assert!(!is_green(seen), "{seen:?}");
}

#[test]
fn a_sun_closes_the_pupil_and_blanks_nothing() {
    let _turn = turn();
    let scene = model(&file("sun_68300_lux.gltf"));
    let session = photo_session(LoadedScene::Model(Box::new(scene)), patient("healthy-blue"));
    let mut headless = open(session, UVec2::splat(16), UVec2::splat(64), [false, true]);
    settle(&mut headless);
    without_blinks(&mut headless);
    headless.go_to(0.5);
    let pupil_mm = headless.state().pupil_mm;
    assert!(pupil_mm < 2.5, "{pupil_mm} mm");
    assert!(!headless.percept().captured().is_empty());
    let view = headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"));
    // The quad, neither black nor blank, and not the sky beside it.
    let luma = |x: u32, y: u32| {
        view.get_pixel(x, y)
            .0
            .iter()
            .take(3)
            .map(|c| u32::from(*c))
            .sum::<u32>()
            / 3
    };
    assert!((100..252).contains(&luma(32, 32)), "{}", luma(32, 32));
    assert!(
        luma(32, 32).abs_diff(luma(2, 2)) > 30,
        "{} beside {}",
        luma(32, 32),
        luma(2, 2)
    );
}
