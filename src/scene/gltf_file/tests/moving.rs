//! What moves along an animation, and animations that cannot be.

use super::*;

/// A quad on a node that moves to the right by 2 in one second, its file's unit and its key frames' times.
fn moving(times: [f32; 2], path: &str) -> Vec<u8> {
    let places = match path {
        "rotation" => vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8],
        _ => vec![1.0, 1.0, 1.0, 3.0, 1.0, 1.0],
    };
    let width = places.len() / 2;
    let kind = if width == 4 { "VEC4" } else { "VEC3" };
    let mut json: serde_json::Value = serde_json::from_str(&quad_json(
        r#"{"mesh":0,"translation":[1,1,1]}"#,
        5,
        5121,
        4,
        4,
    ))
    .unwrap();
    json["nodes"] = serde_json::json!([
        {"name": "carrier", "children": [1], "translation": [0, 5, 0]},
        {"name": "quad", "mesh": 0, "translation": [9, 9, 9]},
        {"name": "still"}
    ]);
    json["scenes"][0]["nodes"] = serde_json::json!([0, 2]);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(serde_json::json!({"buffer": 0, "byteOffset": 52, "byteLength": 8}));
    views.push(serde_json::json!({"buffer": 0, "byteOffset": 60, "byteLength": 8 * width}));
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(serde_json::json!({"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}));
    accessors.push(
        serde_json::json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": kind}),
    );
    json["animations"] = serde_json::json!([{"name": "slide",
        "samplers": [{"input": 2, "output": 3}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": path}}]}]);
    json["buffers"][0]["byteLength"] = (60 + 8 * width).into();
    let blob = [
        floats(&CORNERS),
        vec![0, 1, 2, 3],
        floats(&times),
        floats(&places),
    ]
    .concat();
    glb(&json.to_string(), &blob)
}

#[test]
fn what_moves_begins_where_its_animation_does_and_nothing_else_is_kept() {
    let scene = load_gltf_among(
        &moving([0.0, 1.0], "translation"),
        "a.glb",
        Beside::Files(&[]),
        Some(0.01),
    );
    let scene = scene.unwrap();
    // The node's own place, 9, is not that of time 0.
    let (low, high) = scene.bounds().unwrap();
    assert!(
        (Vec3::from(low) - 0.01 * Vec3::new(1.0, 6.0, 1.0)).length() < 1e-6,
        "{low:?}"
    );
    assert!(
        (Vec3::from(high) - 0.01 * Vec3::new(2.0, 7.0, 1.0)).length() < 1e-6,
        "{high:?}"
    );
    let motion = scene.motion.unwrap();
    let names: Vec<&str> = motion.nodes.iter().map(|node| &*node.name).collect();
    assert_eq!(names, ["unit", "carrier", "quad"]);
    assert_eq!(motion.animation.duration_s, 1.0);
    let [mesh] = &motion.meshes[..] else {
        panic!("one mesh moves")
    };
    assert_eq!((mesh.mesh, mesh.node), (0, 2));
    // In its own frame, in the order of the drawn one's corners, facing +z.
    let drawn = &scene.meshes[0];
    for ((own, world), normal) in mesh
        .positions
        .iter()
        .zip(&drawn.positions)
        .zip(&mesh.normals)
    {
        let placed = 0.01 * (Vec3::from(*own) + Vec3::new(1.0, 6.0, 1.0));
        assert!((placed - Vec3::from(*world)).length() < 1e-6);
        assert_eq!(*normal, [0.0, 0.0, 1.0]);
    }
    assert!(
        load_gltf_bytes(&strip(r#"{"mesh":0}"#), "a.glb")
            .unwrap()
            .motion
            .is_none()
    );
}

#[test]
fn key_frames_that_make_no_course_are_not_played_and_said() {
    for (file, part) in [
        (moving([1.0, 1.0], "translation"), "not after 1 s"),
        (moving([-1.0, 1.0], "translation"), "-1 s"),
        (moving([0.0, f32::NAN], "translation"), "NaN"),
        (
            moving([0.0, 1.0], "colour"),
            "none of translation, rotation",
        ),
    ] {
        let scene = load_gltf_bytes(&file, "a.glb").unwrap();
        assert!(scene.motion.is_none());
        let text = scene.remarks.join(" ");
        assert!(
            text.contains("channel 0 of its animation \"slide\"") && text.contains(part),
            "{text}"
        );
    }
    // A rotation is four numbers.
    let bent = moving([0.0, 1.0], "translation")
        .iter()
        .fold(Vec::new(), |mut all, byte| {
            all.push(*byte);
            if all.ends_with(b"\"path\":\"translation\"") {
                let at = all.len() - b"translation\"".len();
                all.splice(at.., b"rotation\"   ".iter().copied());
            }
            all
        });
    let scene = load_gltf_bytes(&bent, "a.glb").unwrap();
    let text = scene.remarks.join(" ");
    assert!(
        scene.motion.is_none()
            && text.contains("(values of key frames) has a type that is not allowed"),
        "{text}"
    );
    // A mesh without morphs has nothing that could be weighted.
    let scene = load_gltf_bytes(&moving([0.0, 1.0], "weights"), "a.glb").unwrap();
    let text = scene.remarks.join(" ");
    assert!(
        scene.motion.is_none() && text.contains("its mesh has none"),
        "{text}"
    );
    assert!(
        load_gltf_bytes(&moving([0.0, 1.0], "rotation"), "a.glb")
            .unwrap()
            .motion
            .is_some()
    );
}

#[test]
fn a_skin_moves_every_mesh_that_it_holds() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join("skin_a.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let nodes = json["nodes"].as_array_mut().unwrap();
    let held = nodes
        .iter()
        .find(|node| node.get("skin").is_some())
        .unwrap()
        .clone();
    nodes.push(held);
    let second = nodes.len() - 1;
    json["scenes"][0]["nodes"]
        .as_array_mut()
        .unwrap()
        .push(second.into());
    let joint = json["skins"][0]["joints"][0].clone();
    // Times 0 and 1, and two places.
    let numbers = floats(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let buffer = json["buffers"].as_array().unwrap().len();
    let views = json["bufferViews"].as_array().unwrap().len();
    let accessors = json["accessors"].as_array().unwrap().len();
    let mut push =
        |list: &str, value: serde_json::Value| json[list].as_array_mut().unwrap().push(value);
    push(
        "buffers",
        serde_json::json!({"uri": "moves.bin", "byteLength": 32}),
    );
    push(
        "bufferViews",
        serde_json::json!({"buffer": buffer, "byteLength": 8}),
    );
    push(
        "bufferViews",
        serde_json::json!({"buffer": buffer, "byteOffset": 8, "byteLength": 24}),
    );
    push(
        "accessors",
        serde_json::json!({"bufferView": views, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}),
    );
    push(
        "accessors",
        serde_json::json!({"bufferView": views + 1, "componentType": 5126, "count": 2, "type": "VEC3"}),
    );
    json["animations"] = serde_json::json!([{
        "samplers": [{"input": accessors, "output": accessors + 1}],
        "channels": [{"sampler": 0, "target": {"node": joint, "path": "translation"}}]}]);
    let beside = [("moves.bin".to_owned(), numbers)];
    let text = json.to_string();
    let scene = load_gltf_among(text.as_bytes(), "a.gltf", Beside::Files(&beside), None).unwrap();
    let motion = scene.motion.expect("a joint moves");
    assert_eq!(
        (motion.skins.len(), motion.meshes.len()),
        (1, scene.meshes.len())
    );
    assert!(motion.meshes.len() >= 2 && motion.meshes.iter().all(|mesh| mesh.held.is_some()));
}
