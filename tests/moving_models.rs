//! A model's own animation, as the view shows it: each moment against the same file with its nodes put there.

use crate::people::difference;
use crate::percept_gpu::photo_session;
use crate::stage::{open, patient, settle, turn, without_blinks};
use bevy::math::{Quat, UVec2};
use image::RgbaImage;
use ocularium::lab::headless::{Headless, Which};
use ocularium::patients::PupilSetting;
use ocularium::scene::catalog::LoadedScene;
use ocularium::scene::gltf_file::{Beside, load_gltf_among};
use ocularium::scene::model::SceneModel;
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;

const SIDE: u32 = 128;

/// Where things are: those that an animation moves, at a time within its first second.
struct Moment {
    arm_m: [f32; 3],
    arm_turn: Quat,
    /// It turns inside out and back.
    card_scale: [f32; 3],
    joint_turn: Quat,
    weight: f32,
}

fn moment(time_s: f32) -> Moment {
    Moment {
        arm_m: [-0.7, 0.5 * time_s, -3.0],
        arm_turn: Quat::from_rotation_z(time_s * FRAC_PI_2),
        card_scale: [1.0 - 2.0 * time_s, -0.6, 1.0],
        joint_turn: Quat::from_rotation_z(-time_s * FRAC_PI_2),
        weight: time_s,
    }
}

/// Numbers one after the other, and where each run of them begins.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views
            .push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        let mut accessor = json!({"bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": kind});
        if kind == "VEC3" {
            accessor["min"] = json!([-9, -9, -9]);
            accessor["max"] = json!([9, 9, 9]);
        }
        if kind == "SCALAR" && component == 5126 {
            accessor["min"] = json!([0]);
            accessor["max"] = json!([2]);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(kind, 5126, values.len() / width, &bytes)
    }
}

/// A card and a lamp on an arm, a strip in a mirror that bends at its middle joint, and a card that grows and
/// tilts by a shape; with its animation, or still at a moment; shining by themselves, or in the lamp's light.
fn file(at: Option<&Moment>, is_lit: bool) -> (Value, Vec<u8>) {
    let mut buffer = Buffer::default();
    let card = buffer.floats(
        "VEC3",
        3,
        &[
            -0.3, -0.3, 0.0, 0.3, -0.3, 0.0, 0.3, 0.3, 0.0, -0.3, 0.3, 0.0,
        ],
    );
    let corners = buffer.add("SCALAR", 5121, 6, &[0, 1, 2, 0, 2, 3]);
    // Three rows of two vertices, from below to above; each row held more by the upper joint.
    let rows: Vec<f32> = [-0.6f32, 0.0, 0.6]
        .iter()
        .flat_map(|y| [-0.15, *y, 0.0, 0.15, *y, 0.0])
        .collect();
    let strip = buffer.floats("VEC3", 3, &rows);
    let ladder = buffer.add("SCALAR", 5121, 12, &[0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4]);
    let joints = buffer.add("VEC4", 5121, 6, &[0, 1, 0, 0].repeat(6));
    let shares = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
    let shares: Vec<f32> = shares
        .iter()
        .flat_map(|[low, high]| [*low, *high, 0.0, 0.0].repeat(2))
        .collect();
    let shares = buffer.floats("VEC4", 4, &shares);
    // The strip as it was bound: both joints without a turn, the lower one 0.6 m below.
    let unit = |y: f32| {
        let mut matrix = [0.0f32; 16];
        for k in 0..4 {
            matrix[5 * k] = 1.0;
        }
        matrix[13] = y;
        matrix
    };
    let binds = buffer.floats("MAT4", 16, &[unit(0.6), unit(0.0)].concat());
    let shape = buffer.floats(
        "VEC3",
        3,
        &[-0.2, 0.0, 0.0, 0.2, 0.0, 0.0, 0.2, 0.3, 0.4, -0.2, 0.3, 0.4],
    );
    let material = |[r, g, b]: [f64; 3]| {
        let surface =
            json!({"baseColorFactor": [r, g, b, 1], "metallicFactor": 0, "roughnessFactor": 1});
        let extensions = if is_lit {
            json!({})
        } else {
            json!({"KHR_materials_unlit": {}})
        };
        json!({"pbrMetallicRoughness": surface, "extensions": extensions})
    };
    let rest = moment(0.0);
    let still = at.unwrap_or(&rest);
    let mut json = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit", "KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 900.0}]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 8, 5, 6]}],
        "nodes": [
            {"name": "arm", "translation": still.arm_m, "rotation": still.arm_turn.to_array(), "children": [1, 7]},
            {"name": "card", "mesh": 0, "translation": [0.3, 0.0, 0.0], "scale": still.card_scale},
            {"name": "strip", "mesh": 1, "skin": 0},
            {"name": "low", "translation": [-0.8, -0.6, -3.0], "children": [4]},
            {"name": "high", "translation": [0.0, 0.6, 0.0], "rotation": still.joint_turn.to_array()},
            {"name": "shaped", "mesh": 2, "translation": [0.0, -0.8, -3.0], "weights": [still.weight]},
            {"name": "eye", "camera": 0},
            {"name": "lamp", "rotation": Quat::from_rotation_x(-0.6).to_array(), "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "mirror", "scale": [-1.0, 1.0, 1.0], "children": [2, 3]}
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
        "skins": [{"joints": [3, 4], "inverseBindMatrices": binds}],
        "materials": [material([1.0, 0.1, 0.1]), material([0.1, 1.0, 0.1]), material([0.1, 0.1, 1.0])],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": card}, "indices": corners, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": strip, "JOINTS_0": joints, "WEIGHTS_0": shares}, "indices": ladder, "material": 1}]},
            {"primitives": [{"attributes": {"POSITION": card}, "indices": corners, "material": 2, "targets": [{"POSITION": shape}]}]}
        ]
    });
    if at.is_none() {
        let times = buffer.floats("SCALAR", 1, &[0.0, 1.0, 2.0]);
        let [start, end] = [moment(0.0), moment(1.0)];
        let through = |first: &[f32], last: &[f32]| [first, last, first].concat();
        let moves = buffer.floats("VEC3", 3, &through(&start.arm_m, &end.arm_m));
        let turns = |from: Quat, to: Quat| through(&from.to_array(), &to.to_array());
        let arm = buffer.floats("VEC4", 4, &turns(start.arm_turn, end.arm_turn));
        let bends = buffer.floats("VEC4", 4, &turns(start.joint_turn, end.joint_turn));
        let scales = buffer.floats("VEC3", 3, &through(&start.card_scale, &end.card_scale));
        let weights = buffer.floats("SCALAR", 1, &[0.0, 1.0, 0.0]);
        let channel = |sampler: usize, node: usize, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
        let samplers = [moves, arm, bends, weights, scales]
            .map(|output| json!({"input": times, "output": output}));
        json["animations"] = json!([{
            "name": "wave",
            "samplers": samplers,
            "channels": [channel(0, 0, "translation"), channel(1, 0, "rotation"), channel(2, 4, "rotation"), channel(4, 1, "scale"), channel(3, 5, "weights")]
        }]);
    }
    json["buffers"] = json!([{"uri": "a.bin", "byteLength": buffer.bytes.len()}]);
    json["bufferViews"] = json!(buffer.views);
    json["accessors"] = json!(buffer.accessors);
    (json, buffer.bytes)
}

fn model(at: Option<&Moment>, is_lit: bool) -> SceneModel {
    read(file(at, is_lit))
}

fn read((json, bytes): (Value, Vec<u8>)) -> SceneModel {
    let beside = [("a.bin".to_owned(), bytes)];
    let text = json.to_string();
    let read = load_gltf_among(text.as_bytes(), "wave.gltf", Beside::Files(&beside), None);
    let mut model = read.unwrap_or_else(|error| panic!("{error}"));
    // Another moment, in which more of the sky is hidden, would be exposed otherwise.
    model.mean_luminance_cd_m2 = 130.0;
    model
}

fn opened(model: SceneModel) -> Headless {
    let mut who = patient("healthy-blue");
    who.pupil = PupilSetting::Fixed(1.0);
    let session = photo_session(LoadedScene::Model(Box::new(model)), who);
    let mut headless = open(session, UVec2::splat(16), UVec2::splat(SIDE), [false, true]);
    settle(&mut headless);
    without_blinks(&mut headless);
    headless
}

fn seen_at(headless: &mut Headless, time_s: f64) -> RgbaImage {
    headless.go_to(time_s);
    settle(headless);
    headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Shining by itself everything is where it should be; in the light of a lamp that moves too, it faces where it
/// should.
#[test]
fn each_moment_of_an_animation_is_where_its_key_frames_put_it() {
    let _turn = turn();
    for is_lit in [false, true] {
        let moving = model(None, is_lit);
        assert!(moving.remarks.is_empty(), "{:?}", moving.remarks);
        assert_eq!(
            moving.motion.as_ref().map(|motion| motion.lights.len()),
            Some(1)
        );
        let mut moving = opened(moving);
        let mut pictures = Vec::new();
        for time_s in [0.0, 0.6, 1.0] {
            let mut still = opened(model(Some(&moment(time_s)), is_lit));
            // In the very frame of that time.
            moving.go_to(time_s.into());
            let now = moving
                .panel(Which::View)
                .unwrap_or_else(|error| panic!("{error}"));
            pictures.push((now, seen_at(&mut still, time_s.into())));
        }
        for (index, (found, wanted)) in pictures.iter().enumerate() {
            // Positions in the other order of sums: a pixel here and there along an edge.
            let error = difference(found, wanted);
            assert!(error < 0.1, "lit {is_lit}, moment {index}: {error} codes");
            // Every other moment is another picture.
            for (other, _) in pictures.iter().filter(|(other, _)| other != found) {
                let error = difference(other, wanted);
                assert!(error > 2.0, "lit {is_lit}, moment {index}: {error} codes");
            }
        }
        // Its end is its beginning.
        let again = seen_at(&mut moving, 2.6);
        let error = difference(&again, &pictures[1].1);
        assert!(error < 0.1, "lit {is_lit}: {error} codes");
    }
}

#[test]
fn a_moving_model_is_captured_as_it_moves_and_not_when_time_stands() {
    let _turn = turn();
    // Another shape, or one that is turned inside out, is another mesh, which takes a frame more to be there.
    let (mut json, bytes) = file(None, false);
    let channels = json["animations"][0]["channels"].as_array_mut();
    channels.expect("channels").truncate(3);
    let mut headless = opened(read((json, bytes)));
    headless.go_to(0.3);
    settle(&mut headless);
    let before = headless.work();
    for _ in 0..10 {
        headless.stand_still();
    }
    assert_eq!(
        headless.work().since(before).view_captures,
        0,
        "time stands"
    );
    let before = headless.work();
    for step in 1..=5 {
        headless.go_to(0.3 + 0.1 * f64::from(step));
        settle(&mut headless);
    }
    assert_eq!(headless.work().since(before).view_captures, 5);
    // A shape is there a frame after it was asked for, and a picture before everything is built is taken again.
    let mut headless = opened(model(None, false));
    let before = headless.work();
    for step in 1..=5 {
        headless.go_to(0.1 * f64::from(step));
        settle(&mut headless);
    }
    let captures = headless.work().since(before).view_captures;
    assert!((5..=15).contains(&captures), "{captures}");
    // The same nodes without key frames are still.
    let mut headless = opened(model(Some(&moment(0.3)), false));
    let before = headless.work();
    for step in 1..=5 {
        headless.go_to(0.1 * f64::from(step));
        settle(&mut headless);
    }
    assert_eq!(headless.work().since(before).view_captures, 0);
}
