//! The scene of the examples: a floor, three walls, a shelf of boxes at several distances, and two lights.
//!
//! Enters: nothing. Leaves: a plain glTF 2.0 file, as any program writes it and Bevy's own loader reads it
//! (which knows nothing of the quantised vertices of the built-in scenes).

use super::glb::{FLOAT, UNSIGNED_SHORT, container, short};
use bevy::color::{Color, ColorToComponents};
use glam::{Mat3, Quat, Vec3, Vec3Swizzles};
use serde_json::{Value, json};
use std::error::Error;
use std::f32::consts::{FRAC_PI_2, PI};

/// Where it lies among the assets.
pub const PATH: &str = "examples/clinic.glb";

/// A unit cube about the origin: each corner's place, its face's normal, and each triangle's corners.
fn cube() -> (Vec<Vec3>, Vec<Vec3>, Vec<u16>) {
    let (mut places, mut normals, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for normal in [axis, -axis] {
            let side = normal.zxy();
            let up = normal.cross(side);
            let first = places.len() as u16;
            for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                places.push(0.5 * normal + x * side + y * up);
                normals.push(normal);
            }
            corners.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
    }
    (places, normals, corners)
}

/// A box of one colour: where its middle is, its size, how it is turned about the vertical, its colour.
struct Block {
    place: Vec3,
    size: Vec3,
    turn: f32,
    color: Color,
}

fn blocks() -> Vec<Block> {
    let wall = |place, turn, color| Block {
        place,
        size: Vec3::new(8.0, 3.0, 0.1),
        turn,
        color,
    };
    let mut blocks = vec![
        Block {
            place: Vec3::new(0.0, -0.05, 0.0),
            size: Vec3::new(8.0, 0.1, 8.0),
            turn: 0.0,
            color: Color::srgb(0.45, 0.33, 0.22),
        },
        wall(Vec3::new(0.0, 1.5, -4.0), 0.0, Color::srgb(0.55, 0.65, 0.6)),
    ];
    let cream = Color::srgb(0.7, 0.68, 0.6);
    blocks.extend([-3.0, 3.0].map(|x| wall(Vec3::new(x, 1.5, 0.0), FRAC_PI_2, cream)));
    blocks.extend((0..40_u8).map(|index| {
        let (column, row) = (f32::from(index % 8), f32::from(index / 8));
        Block {
            place: Vec3::new(0.35 * (column - 3.5), 0.3 + 0.35 * row, -3.5 + 0.9 * row),
            size: Vec3::new(0.12, 0.3, 0.12) * (1.0 - 0.12 * row),
            turn: 0.0,
            color: Color::hsl(f32::from(index) * 47.0 % 360.0, 0.6, 0.45),
        }
    }));
    blocks
}

/// The file's bytes.
pub fn write() -> Result<Vec<u8>, Box<dyn Error>> {
    let (places, normals, corners) = cube();
    let vertices: Vec<u8> = places
        .iter()
        .chain(&normals)
        .flat_map(|v| v.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let corner_bytes: Vec<u8> = corners
        .iter()
        .flat_map(|corner| corner.to_le_bytes())
        .collect();
    let half = 12 * places.len();
    let blocks = blocks();
    let material = |block: &Block| {
        json!({ "pbrMetallicRoughness": {
            "baseColorFactor": block.color.to_linear().to_f32_array().map(short),
            "metallicFactor": 0.0,
            "roughnessFactor": 0.5,
        } })
    };
    let mut nodes: Vec<Value> = blocks
        .iter()
        .enumerate()
        .map(|(index, block)| {
            json!({
                "mesh": index,
                "translation": block.place.to_array().map(short),
                "rotation": Quat::from_rotation_y(block.turn).to_array().map(short),
                "scale": block.size.to_array().map(short),
            })
        })
        .collect();
    // Lights shine along -z of their nodes.
    let away = Vec3::new(-0.3, 1.0, -0.6).normalize();
    let across = Vec3::Y.cross(away).normalize();
    let sun = Quat::from_mat3(&Mat3::from_cols(across, away.cross(across), away));
    let lamps = [
        (Vec3::new(1.2, 2.6, 0.5), Quat::IDENTITY),
        (Vec3::ZERO, sun),
    ];
    nodes.extend(lamps.into_iter().enumerate().map(|(light, (place, turn))| {
        json!({
            "translation": place.to_array().map(short),
            "rotation": turn.to_array().map(short),
            "extensions": { "KHR_lights_punctual": { "light": light } },
        })
    }));
    let accessor = |view: usize, kind: u32, count: usize, shape: &str| json!({ "bufferView": view, "componentType": kind, "count": count, "type": shape });
    let mut positions = accessor(0, FLOAT, places.len(), "VEC3");
    positions["min"] = json!([-0.5, -0.5, -0.5]);
    positions["max"] = json!([0.5, 0.5, 0.5]);
    let root = json!({
        "asset": { "version": "2.0", "generator": "cargo run --release --example bake_rooms" },
        "extensionsUsed": ["KHR_lights_punctual"],
        // 120,000 lm in all directions, and 400 lx.
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": short(120_000.0 / (4.0 * PI)), "range": 12.0 },
            { "type": "directional", "intensity": 400.0 },
        ] } },
        "scene": 0,
        "scenes": [{ "name": "clinic", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": (0..blocks.len()).map(|material| json!({ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": material,
        }] })).collect::<Vec<_>>(),
        "materials": blocks.iter().map(material).collect::<Vec<_>>(),
        "accessors": [
            positions,
            accessor(1, FLOAT, normals.len(), "VEC3"),
            accessor(2, UNSIGNED_SHORT, corners.len(), "SCALAR"),
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": half, "target": 34962 },
            { "buffer": 0, "byteOffset": half, "byteLength": half, "target": 34962 },
            { "buffer": 0, "byteOffset": 2 * half, "byteLength": corner_bytes.len(), "target": 34963 },
        ],
        "buffers": [{ "byteLength": 2 * half + corner_bytes.len() }],
    });
    let binary = [vertices, corner_bytes].concat();
    Ok(container(serde_json::to_vec(&root)?, binary))
}
