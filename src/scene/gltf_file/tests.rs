use super::super::photo::read_file;
use super::*;
use crate::scene::model::{SceneLight, SceneMesh};
use proptest::prelude::*;
use std::f32::consts::PI;
use std::path::Path;

mod moving;

fn load_gltf(path: &Path, unit_m: Option<f32>) -> Result<SceneModel, SceneError> {
    let bytes = read_file(path)?;
    let folder = path.parent().expect("a folder");
    let name = path.display().to_string();
    load_gltf_among(&bytes, &name, Beside::Folder(folder), unit_m)
}

fn load_gltf_bytes(bytes: &[u8], name: &str) -> Result<SceneModel, SceneError> {
    load_gltf_among(bytes, name, Beside::Files(&[]), None)
}

/// A GLB file from JSON and a binary chunk.
fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
    let pad = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, blob) = (pad(json.as_bytes().to_vec(), b' '), pad(blob.to_vec(), 0));
    let total = 12 + 8 + json.len() + 8 + blob.len();
    let mut file = b"glTF".to_vec();
    file.extend([2u32, total as u32].map(u32::to_le_bytes).concat());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", blob)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A unit quad in z = 0 with four positions and a strip of `indices`.
fn quad_json(
    node: &str,
    mode: u32,
    index_type: u32,
    index_count: usize,
    index_bytes: usize,
) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{node}],
        "meshes":[{{"name":"quad","primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}}]}}],
        "buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":{index_bytes}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":{index_type},"count":{index_count},"type":"SCALAR"}}]}}"#,
        48 + index_bytes
    )
}

const CORNERS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];

fn strip(node: &str) -> Vec<u8> {
    let blob = [floats(&CORNERS), vec![0, 1, 2, 3]].concat();
    glb(&quad_json(node, 5, 5121, 4, 4), &blob)
}

fn message(bytes: &[u8]) -> String {
    let text = load_gltf_bytes(bytes, "a.glb").unwrap_err().to_string();
    assert!(
        text.contains("a.glb") && text.ends_with('.') && !text.contains('\n'),
        "{text}"
    );
    text
}

fn area(scene: &SceneModel) -> f32 {
    let mesh = &scene.meshes[0];
    let corner = |i: u32| Vec3::from(mesh.positions[i as usize]);
    let doubled = |t: &[u32]| {
        (corner(t[1]) - corner(t[0]))
            .cross(corner(t[2]) - corner(t[0]))
            .length()
    };
    mesh.indices.chunks(3).map(|t| 0.5 * doubled(t)).sum()
}

#[test]
fn strips_fans_and_all_index_widths_give_the_same_quad() {
    let fan = [0u16, 1, 3, 2]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect::<Vec<_>>();
    let list = [0u32, 1, 2, 2, 1, 3]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect::<Vec<_>>();
    let node = r#"{"mesh":0}"#;
    let files = [
        strip(node),
        glb(
            &quad_json(node, 6, 5123, 4, 8),
            &[floats(&CORNERS), fan].concat(),
        ),
        glb(
            &quad_json(node, 4, 5125, 6, 24),
            &[floats(&CORNERS), list].concat(),
        ),
    ];
    for file in files {
        let scene = load_gltf_bytes(&file, "quad.glb").unwrap();
        assert_eq!(scene.triangle_count(), 2);
        assert!((area(&scene) - 1.0).abs() < 1e-6);
        // No normals in the file: flat ones, facing +z as the winding says.
        assert!(
            scene.meshes[0]
                .normals
                .iter()
                .all(|n| (n[2] - 1.0).abs() < 1e-6)
        );
        assert!(scene.mean_luminance_cd_m2 > 0.0 && !scene.lights.is_empty());
    }
}

#[test]
fn node_transforms_and_mirrors_are_applied() {
    let scene = load_gltf_bytes(
        &strip(r#"{"mesh":0,"translation":[5,6,7],"scale":[-2,3,1]}"#),
        "m.glb",
    )
    .unwrap();
    assert!((area(&scene) - 6.0).abs() < 1e-5);
    assert_eq!(scene.bounds(), Some(([3.0, 6.0, 7.0], [5.0, 9.0, 7.0])));
    // The mirror swaps the winding, so the quad still faces +z.
    assert!(scene.meshes[0].normals.iter().all(|n| n[2] > 0.99));
}

#[test]
fn without_a_camera_the_scene_fills_seventy_per_cent_of_the_view() {
    let scene = load_gltf_bytes(&strip(r#"{"mesh":0}"#), "quad.glb").unwrap();
    let eye = Vec3::from(scene.eye.position_m);
    assert!((eye - Vec3::new(0.5, 0.5, eye.z)).length() < 1e-6);
    let filled = 0.5 / eye.z / (25.0f32.to_radians()).tan();
    assert!((filled - 0.7).abs() < 1e-4, "{filled}");
}

#[test]
fn the_first_camera_becomes_the_eye_and_lights_keep_their_units() {
    let json = quad_json(r#"{"mesh":0},{"camera":0,"translation":[0,1,2],"rotation":[0,1,0,0]},
        {"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[0,3,0]}"#, 5, 5121, 4, 4)
        .replace(r#""nodes":[0]"#, r#""nodes":[0,1,2]"#)
        .replacen('{', r#"{"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1,"aspectRatio":1.5}}],
        "extensionsUsed":["KHR_lights_punctual"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":10,"color":[1,0.5,0.2]}]}},"#, 1);
    let scene = load_gltf_bytes(
        &glb(&json, &[floats(&CORNERS), vec![0, 1, 2, 3]].concat()),
        "c.glb",
    )
    .unwrap();
    assert_eq!(scene.eye.position_m, [0.0, 1.0, 2.0]);
    // Half a turn about y: the camera's −z becomes +z.
    assert!((Vec3::from(scene.eye.forward) - Vec3::Z).length() < 1e-6);
    assert!((scene.eye.vertical_fov_deg - 0.8f32.to_degrees()).abs() < 1e-4);
    let horizontal = 2.0 * (0.4f32.tan() * 1.5).atan();
    assert!((scene.eye.horizontal_fov_deg - horizontal.to_degrees()).abs() < 1e-3);
    match scene.lights[..] {
        [
            SceneLight::Point {
                position,
                intensity_lm,
                ..
            },
        ] => {
            assert_eq!(position, [0.0, 3.0, 0.0]);
            assert!((intensity_lm - 40.0 * PI).abs() < 1e-3, "10 cd all around");
        }
        _ => panic!("{:?}", scene.lights),
    }
}

#[test]
fn inline_textures_are_decoded_and_shared() {
    // A 1×1 red PNG.
    let red = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8DwHwAFBQIAX8jx0gAAAABJRU5ErkJggg==";
    let json = quad_json(r#"{"mesh":0}"#, 5, 5121, 4, 4)
        .replace(r#""mode":5"#, r#""mode":5,"material":0"#)
        .replacen('{', &format!(r#"{{"images":[{{"uri":"data:image/png;base64,{red}"}}],"textures":[{{"source":0}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}},"emissiveTexture":{{"index":0}},
        "normalTexture":{{"index":0}},"alphaMode":"MASK","alphaCutoff":0.3,"doubleSided":true}}],"#), 1);
    let scene = load_gltf_bytes(
        &glb(&json, &[floats(&CORNERS), vec![0, 1, 2, 3]].concat()),
        "t.glb",
    )
    .unwrap();
    let material = &scene.materials[0];
    assert_eq!(
        (
            material.base_color_texture,
            material.emissive_texture,
            material.normal_texture
        ),
        (Some(0), Some(0), Some(1))
    );
    assert_eq!(
        (material.alpha, material.double_sided),
        (super::super::model::Alpha::Mask(0.3), true)
    );
    assert_eq!(
        (
            scene.textures[0].width,
            scene.textures[0].srgb,
            scene.textures[1].srgb
        ),
        (1, true, false)
    );
}

#[test]
fn each_bad_file_gets_its_own_sentence() {
    let node = r#"{"mesh":0}"#;
    assert!(message(b"hello, this is not a model").contains("glTF file"));
    assert!(message(&strip(node)[..200]).contains("glTF file"));
    assert!(message(&[]).contains("is empty"));
    let no_mesh = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[]}],"scene":0}"#;
    assert!(message(no_mesh).contains("no meshes"));
    let mut corners = CORNERS;
    corners[7] = f32::NAN;
    let bad = glb(
        &quad_json(node, 5, 5121, 4, 4),
        &[floats(&corners), vec![0, 1, 2, 3]].concat(),
    );
    let text = message(&bad);
    assert!(
        text.contains("\"quad\"") && text.contains("vertex 2"),
        "{text}"
    );
    let bad = glb(
        &quad_json(node, 5, 5121, 4, 4),
        &[floats(&CORNERS), vec![0, 1, 2, 9]].concat(),
    );
    assert!(message(&bad).contains("index 9"));
    let bad = glb(
        &quad_json(node, 5, 5121, 4000, 4),
        &[floats(&CORNERS), vec![0, 1, 2, 3]].concat(),
    );
    assert!(message(&bad).contains("beyond"));
    let bad = glb(
        &quad_json(node, 5, 5126, 4, 16),
        &[floats(&CORNERS), vec![0; 16]].concat(),
    );
    assert!(message(&bad).contains("accessor 1") || message(&bad).contains("glTF file"));
    let cycle = strip(r#"{"mesh":0,"children":[0]}"#);
    assert!(message(&cycle).contains("loop"));
    let huge = strip(r#"{"mesh":0,"scale":[1e38,1e38,1e38],"translation":[3.4e38,3.4e38,0]}"#);
    assert!(message(&huge).contains("finite"));
    let elsewhere = strip(node);
    let text = String::from_utf8_lossy(&elsewhere[20..]).into_owned();
    let json = text
        .split("BIN")
        .next()
        .unwrap()
        .trim_end_matches(|c| c != '}')
        .replace(r#""byteLength":52"#, r#""byteLength":52,"uri":"q.bin""#);
    assert!(message(json.as_bytes()).contains("glTF file"));
    let error = load_gltf(Path::new("/no/such.glb"), None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "The scene file \"/no/such.glb\" does not exist."
    );
}

proptest! {
    #[test]
    fn truncated_or_damaged_files_never_panic(cut in 0usize..1200, at in 0usize..1200, value: u8) {
        let mut file = strip(r#"{"mesh":0}"#);
        let at = at.min(file.len() - 1);
        file[at] = value;
        file.truncate(file.len().saturating_sub(cut % 7 * cut));
        let _ = load_gltf_bytes(&file, "damaged.glb");
    }
}

/// A file of `tests/data/gltf`.
fn case(name: &str, unit_m: Option<f32>) -> Result<SceneModel, SceneError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    load_gltf(&folder.join(name), unit_m)
}

/// Largest distance between the corners of two scenes' triangles, m.
fn apart(one: &SceneModel, other: &SceneModel) -> f32 {
    let corners = |scene: &SceneModel| -> Vec<Vec3> {
        let mesh = &scene.meshes[0];
        let mut all: Vec<Vec3> = mesh
            .indices
            .iter()
            .map(|&index| mesh.positions[index as usize].into())
            .collect();
        all.sort_by(|a, b| {
            a.to_array()
                .map(|c| c.to_bits())
                .cmp(&b.to_array().map(|c| c.to_bits()))
        });
        all.dedup();
        all
    };
    let (one, other) = (corners(one), corners(other));
    assert_eq!(one.len(), other.len());
    one.iter()
        .zip(&other)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f32::max)
}

#[test]
fn what_exporters_write_is_the_control() {
    let control = case("quad_control.gltf", None).unwrap();
    assert!(control.remarks.is_empty());
    for (name, unit_m) in [
        ("morph_without_buffer_view.gltf", None),
        ("sparse_position.gltf", None),
        ("mirrored.gltf", None),
        ("quantised.gltf", None),
        ("in_millimetres.gltf", Some(0.001)),
    ] {
        let scene = case(name, unit_m).unwrap();
        // A rounding of 0.0001 or 0.001 in single precision, at 3 m.
        assert!(
            apart(&control, &scene) < 1e-6,
            "{name}: {} m",
            apart(&control, &scene)
        );
        assert!(
            scene.meshes[0]
                .normals
                .iter()
                .all(|n| Vec3::from(*n).distance(Vec3::Z) < 1e-5),
            "{name}"
        );
        assert!(scene.remarks.is_empty(), "{name}");
    }
    // Sparse data over zeros: the accessor has no data of its own.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join("sparse_position.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    let scene = load_gltf_bytes(json.to_string().as_bytes(), "sparse").unwrap();
    let zeros = scene.meshes[0]
        .positions
        .iter()
        .filter(|p| **p == [0.0; 3])
        .count();
    assert_eq!(zeros, 2, "two of four corners are replaced");
    // Sparse data that were not applied, or a unit that is not known, are another scene.
    let large = case("in_millimetres.gltf", None).unwrap();
    assert!(apart(&control, &large) > 100.0);
    assert!(large.remarks[0].contains("2000 m") && large.remarks[0].contains("--scene-unit"));
}

#[test]
fn joints_move_a_skin_and_its_own_node_does_not() {
    let control = case("skin_control.gltf", None).unwrap();
    for name in ["skin_a.gltf", "skin_b.gltf"] {
        assert!(apart(&control, &case(name, None).unwrap()) < 1e-6, "{name}");
    }
    // One parameter away: the joint a tenth of a metre farther.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join("skin_a.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["nodes"][1]["translation"] = serde_json::json!([1.1, 0, 0]);
    let moved = load_gltf_bytes(json.to_string().as_bytes(), "moved").unwrap();
    assert!((apart(&control, &moved) - 0.1).abs() < 1e-6);
}

#[test]
fn every_set_of_joints_moves_a_skin_and_a_joint_that_is_not_there_is_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join("skin_a.gltf")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    // The same joints and weights in a second set hold each vertex as one set does.
    let mut twice = json.clone();
    let attributes = &mut twice["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = attributes["JOINTS_0"].clone();
    attributes["WEIGHTS_1"] = attributes["WEIGHTS_0"].clone();
    let control = case("skin_control.gltf", None).unwrap();
    let scene = load_gltf_bytes(twice.to_string().as_bytes(), "twice").unwrap();
    assert!(apart(&control, &scene) < 1e-6);
    // A skin without its joints.
    let mut none = json;
    none["skins"][0]["joints"] = serde_json::json!([]);
    none["skins"][0]
        .as_object_mut()
        .unwrap()
        .remove("inverseBindMatrices");
    let error = load_gltf_bytes(none.to_string().as_bytes(), "none")
        .unwrap_err()
        .to_string();
    assert!(error.contains("joint 0, of which there are 0"), "{error}");
}

#[test]
fn a_mark_before_the_text_is_passed_over() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read(folder.join("quad_control.gltf")).unwrap();
    let marked = [b"\xef\xbb\xbf".to_vec(), text].concat();
    let scene = load_gltf_bytes(&marked, "marked").unwrap();
    assert!(apart(&case("quad_control.gltf", None).unwrap(), &scene) < 1e-9);
}

#[test]
fn morphs_stand_at_rest() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf");
    let text = std::fs::read_to_string(folder.join("quad_control.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    // Half of a displacement by its own positions: 1.5 times as large and as far.
    json["meshes"][0]["primitives"][0]["targets"] = serde_json::json!([{"POSITION": 0}]);
    json["meshes"][0]["weights"] = serde_json::json!([0.5]);
    let scene = load_gltf_bytes(json.to_string().as_bytes(), "morph").unwrap();
    let (low, high) = scene.bounds().unwrap();
    assert_eq!((low, high), ([-1.5, -1.5, -4.5], [1.5, 1.5, -4.5]));
    // A target that names no accessor is refused, as any other.
    json["meshes"][0]["primitives"][0]["targets"] = serde_json::json!([{"POSITION": 99}]);
    let error = load_gltf_bytes(json.to_string().as_bytes(), "morph").unwrap_err();
    assert!(error.to_string().contains("accessor 99"), "{error}");
}

#[test]
fn extensions_are_read_or_named() {
    let bright = case("emissive_strength_10.gltf", None).unwrap();
    assert_eq!(bright.materials[0].emissive, [10.0 * EMISSION_CD_M2; 3]);
    let uvs = case("texture_transform.gltf", None).unwrap().meshes[0]
        .uvs
        .clone()
        .unwrap();
    // An offset and a scale of a half: the last quarter of the picture.
    assert!(
        uvs.iter().flatten().all(|c| (0.5..=1.0).contains(c)),
        "{uvs:?}"
    );
    let second = case("orthographic_first.gltf", None).unwrap();
    assert!((second.eye.vertical_fov_deg - 0.9f32.to_degrees()).abs() < 1e-3);
    assert_eq!(second.eye.position_m, [0.0, 0.0, 1.0]);
    assert!(second.remarks[0].contains("orthographic"));
    for (name, what) in [
        ("needs_KHR_draco_mesh_compression.gltf", "Draco"),
        ("needs_EXT_meshopt_compression.gltf", "meshopt"),
    ] {
        let error = case(name, None).unwrap_err().to_string();
        assert!(
            error.contains(what) && error.contains("export it again"),
            "{error}"
        );
    }
    // A texture that is only there compressed has no image to name, which is invalid without its extension.
    let basis = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_texture_basisu"],
        "textures":[{"extensions":{"KHR_texture_basisu":{"source":0}}}]}"#;
    for bytes in [basis.as_bytes().to_vec(), glb(basis, &[])] {
        let error = message(&bytes);
        assert!(
            error.contains("KTX2") && error.contains("export it again"),
            "{error}"
        );
    }
    let sun = case("sun_68300_lux.gltf", None).unwrap();
    // A matt grey of about a half in 68,300 lx: E ρ / π is 10,000 cd/m², diluted by what is around.
    assert!(
        sun.mean_luminance_cd_m2 > 1000.0,
        "{}",
        sun.mean_luminance_cd_m2
    );
}

#[test]
fn small_things_and_floors_are_framed() {
    let eye_of = |half: [f32; 3]| {
        let scene = SceneModel {
            meshes: vec![SceneMesh {
                positions: vec![half.map(|c| -c), half],
                ..SceneMesh::default()
            }],
            ..SceneModel::default()
        };
        frame(&scene)
    };
    let dot = eye_of([0.005, 0.005, 0.005]);
    assert!(dot.position_m[2] - 0.005 >= 0.02, "{dot:?}");
    let floor = eye_of([2.0, 0.0, 2.0]);
    assert!(
        floor.position_m[1] > 0.5 && floor.forward[1] < -0.4,
        "{floor:?}"
    );
}

#[test]
fn a_buffer_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let text = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"far%20away.bin"}]}"#;
    std::fs::write(&path, text).unwrap();
    let error = load_gltf(&path, None).unwrap_err().to_string();
    assert!(
        error.contains("far away.bin") && error.len() < 400,
        "{error}"
    );
}

#[test]
fn what_is_called_translucent_and_is_not_has_a_distance() {
    use crate::scene::model::{Alpha, SceneMaterial, SceneTexture};
    // Alphas of a texture, of the material, of a vertex: what the material is in truth.
    let of_texture = |texels: &[u8], factor: f32, vertex: f32, shown: f32| {
        let mut scene = SceneModel {
            name: "s.glb".into(),
            textures: vec![SceneTexture {
                width: texels.len() as u32,
                height: 1,
                rgba8: texels.iter().flat_map(|&a| [9, 9, 9, a]).collect(),
                ..SceneTexture::default()
            }],
            materials: vec![SceneMaterial {
                name: "pane".into(),
                base_color: [1.0, 1.0, 1.0, factor],
                base_color_texture: (!texels.is_empty()).then_some(0),
                alpha: Alpha::Blend,
                ..SceneMaterial::default()
            }],
            // A square that shows the left part of the texture.
            meshes: vec![SceneMesh {
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
                uvs: Some(vec![[0.0, 0.0], [shown, 0.0], [0.0, 1.0], [shown, 1.0]]),
                indices: vec![0, 1, 2, 2, 1, 3],
                colors: Some(vec![[1.0, 1.0, 1.0, vertex]; 4]),
                ..SceneMesh::default()
            }],
            ..SceneModel::default()
        };
        blends::settle(&mut scene);
        (scene.materials[0].alpha, scene.remarks)
    };
    let settled = |texels: &[u8], factor, vertex| of_texture(texels, factor, vertex, 1.0);
    let opaque = (Alpha::Opaque, Vec::new());
    assert_eq!(settled(&[], 1.0, 1.0), opaque);
    assert_eq!(settled(&[255, 250], 1.0, 1.0), opaque);
    // A leaf: whole, nothing, and an edge between them.
    let leaf = [255, 255, 255, 255, 255, 128, 0, 0];
    assert_eq!(settled(&leaf, 1.0, 1.0), (Alpha::Mask(0.5), Vec::new()));
    for (texels, factor, vertex) in [
        (&[255, 255, 128, 100, 0, 0][..], 1.0, 1.0),
        (&[255], 0.5, 1.0),
        (&[], 0.5, 1.0),
        (&leaf, 1.0, 0.5),
    ] {
        let (alpha, remarks) = settled(texels, factor, vertex);
        assert_eq!(alpha, Alpha::Blend, "{texels:?} {factor} {vertex}");
        assert!(remarks[0].contains("pane") && remarks[0].contains("no distance"));
    }
    // In an atlas, glass that is a quarter of the texels is all of a pane; and a poster has none of it.
    let atlas = [150, 150, 255, 255, 255, 255, 255, 255];
    assert_eq!(of_texture(&atlas, 1.0, 1.0, 0.25).0, Alpha::Blend);
    let atlas = [255, 255, 150, 150, 150, 150, 0, 0];
    assert_eq!(of_texture(&atlas, 1.0, 1.0, 0.25), opaque);
}

#[test]
fn lamps_beyond_the_sun_are_refused() {
    let lamp = |intensity: &str| {
        let json = quad_json(
            r#"{"mesh":0},{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[0,0,2]}"#,
            5,
            5121,
            4,
            4,
        );
        let json = json.replace(r#""nodes":[0]"#, r#""nodes":[0,1]"#).replacen(
            '{',
            &format!(
                r#"{{"extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":
                {{"lights":[{{"type":"point","intensity":{intensity}}}]}}}},"#
            ),
            1,
        );
        let blob = [floats(&CORNERS), vec![0, 1, 2, 3]].concat();
        load_gltf_bytes(&glb(&json, &blob), "a.glb")
    };
    assert!(lamp("1e6").is_ok());
    for intensity in ["1e13", "1e30"] {
        let error = lamp(intensity).unwrap_err().to_string();
        assert!(error.contains("cd/m² bright"), "{error}");
    }
}

#[test]
fn extras_say_what_gltf_has_no_words_for() {
    let scene = |extras: &str, shadows: &str| {
        let nodes = r#"{"mesh":0},{"extensions":{"KHR_lights_punctual":{"light":0}}}"#;
        let json = quad_json(nodes, 5, 5121, 4, 4)
            .replace(r#""nodes":[0]"#, &format!(r#""nodes":[0,1],"extras":{extras}"#))
            .replacen(
                '{',
                &format!(
                    r#"{{"extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":
                    {{"lights":[{{"type":"directional","intensity":300,"extras":{shadows}}}]}}}},"#
                ),
                1,
            );
        let blob = [floats(&CORNERS), vec![0, 1, 2, 3]].concat();
        load_gltf_bytes(&glb(&json, &blob), "a.glb")
    };
    let found = scene(
        r#"{"ocularium":{"ambient":{"color":[1,0.5,0.25],"brightness_cd_m2":40},
        "background_cd_m2":[1,2,3],"mean_luminance_cd_m2":77.5}}"#,
        r#"{"ocularium":{"shadows":false}}"#,
    )
    .unwrap();
    assert_eq!(found.background, [1.0, 2.0, 3.0]);
    assert_eq!(found.mean_luminance_cd_m2, 77.5);
    let ambient = SceneLight::Ambient {
        color: [1.0, 0.5, 0.25],
        brightness: 40.0,
    };
    assert_eq!(found.lights[1], ambient);
    let casts = |scene: &SceneModel| match scene.lights[0] {
        SceneLight::Directional { shadows, .. } => shadows,
        _ => panic!("another light"),
    };
    assert!(!casts(&found));
    // What others keep there is theirs.
    let plain = scene(r#""a note""#, r#"{"blender":{"shadows":false}}"#).unwrap();
    assert!(casts(&plain) && plain.lights.len() == 1 && plain.mean_luminance_cd_m2 > 0.0);
    for (extras, fault) in [
        (r#"{"background_cd_m2":[1,2]}"#, "invalid length 2"),
        (
            r#"{"background_cd_m2":[1,-2,3]}"#,
            "background_cd_m2 is -2.0e0",
        ),
        (r#"{"mean_luminance_cd_m2":1e20}"#, "must be 0 to 1e9"),
        (r#"{"sky":1}"#, "unknown field"),
    ] {
        let error = scene(&format!(r#"{{"ocularium":{extras}}}"#), "{}").unwrap_err();
        let error = error.to_string();
        assert!(error.contains(fault) && error.contains("extras"), "{error}");
    }
}
