//! The baked rooms are what their generator builds.

#[path = "../examples/bake_rooms/rooms/mod.rs"]
mod generator;

use bevy::math::Vec3;
use generator::glb::{self, grid_step};
use ocularium::scene::catalog::BuiltIn;
use ocularium::scene::model::{SceneMaterial, SceneMesh, SceneModel, SceneTexture};

fn largest<'a, const N: usize>(
    found: impl IntoIterator<Item = &'a [f32; N]>,
    wanted: impl IntoIterator<Item = &'a [f32; N]>,
) -> f32 {
    let pairs = found.into_iter().zip(wanted);
    pairs
        .flat_map(|(a, b)| std::array::from_fn::<f32, N, _>(|k| (a[k] - b[k]).abs()))
        .fold(0.0, f32::max)
}

fn check_mesh(found: &SceneMesh, wanted: &SceneMesh, textured: bool) {
    let name = &wanted.name;
    assert_eq!((&found.name, found.material), (name, wanted.material));
    assert!(found.indices == wanted.indices, "{name}");
    assert_eq!(found.positions.len(), wanted.positions.len(), "{name}");
    let all = wanted.positions.iter().map(|p| Vec3::from(*p));
    let (low, high) = all.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let off = largest(&found.positions, &wanted.positions);
    let step = grid_step(low, high);
    // And the rounding of `f32` at the mesh's place.
    let rounding = 3e-7 * low.abs().max(high.abs()).max_element();
    assert!(
        off <= 0.5 * step + rounding,
        "{name}: {off} m, step {step} m"
    );
    let off = largest(&found.normals, &wanted.normals);
    assert!(off <= 1.0 / 2047.0, "{name}: normals off by {off}");
    assert_eq!(found.uvs.is_some(), textured, "{name}");
    if textured {
        assert!(found.uvs == wanted.uvs, "{name}");
    }
    let white = vec![[1.0; 4]; wanted.positions.len()];
    let [colors, baked] = [found, wanted].map(|mesh| mesh.colors.as_ref().unwrap_or(&white));
    let off = largest(colors, baked);
    assert!(off <= 8.1 / 65535.0, "{name}: colours off by {off}");
}

fn check_material(found: &SceneMaterial, wanted: &SceneMaterial) {
    let name = &wanted.name;
    let facts = |m: &SceneMaterial| {
        (
            (m.name.clone(), m.base_color, m.metallic, m.roughness),
            (m.emissive, m.alpha, m.double_sided, m.unlit),
            (m.base_color_texture.is_some(), m.emissive_texture),
            m.normal_texture,
        )
    };
    let [mut found, wanted] = [facts(found), facts(wanted)];
    let off = largest([&found.1.0], [&wanted.1.0]);
    assert!(off <= 1e-4, "{name}: emission off by {off} cd/m²");
    found.1.0 = wanted.1.0;
    // Textures are numbered anew.
    assert_eq!(found.2.1.is_some(), wanted.2.1.is_some(), "{name}");
    found.2.1 = wanted.2.1;
    assert_eq!(found, wanted);
}

/// The mean and the largest difference of two textures, codes.
fn difference(found: &SceneTexture, wanted: &SceneTexture) -> (f64, u8) {
    let pairs = || found.rgba8.iter().zip(&wanted.rgba8);
    let off = pairs().map(|(a, b)| a.abs_diff(*b));
    let sum: f64 = off.clone().map(f64::from).sum();
    (sum / wanted.rgba8.len() as f64, off.max().unwrap_or(0))
}

fn check_scene(found: &SceneModel, wanted: &SceneModel) {
    assert_eq!(
        (&found.name, &found.remarks),
        (&wanted.name, &wanted.remarks)
    );
    assert_eq!(found.background, wanted.background);
    // The last digits of sines are the machine's.
    let off = found.mean_luminance_cd_m2 / wanted.mean_luminance_cd_m2 - 1.0;
    assert!(off.abs() < 1e-6, "mean luminance off by {off}");
    let [eye, other] = [found.eye, wanted.eye].map(|eye| {
        [
            eye.position_m,
            eye.forward,
            eye.up,
            [
                eye.vertical_fov_deg / 50.0,
                eye.horizontal_fov_deg / 50.0,
                0.0,
            ],
        ]
    });
    assert!(largest(&eye, &other) < 1e-6, "{eye:?} and {other:?}");
    assert_eq!(found.lights.len(), wanted.lights.len());
    for light in &wanted.lights {
        let alike = |other| format!("{other:.5?}") == format!("{light:.5?}");
        assert!(
            found.lights.iter().any(alike),
            "{light:?} in {:?}",
            found.lights
        );
    }
    assert_eq!(found.meshes.len(), wanted.meshes.len());
    for (mesh, other) in found.meshes.iter().zip(&wanted.meshes) {
        let textured = wanted.materials[other.material].textures().next().is_some();
        check_mesh(mesh, other, textured);
    }
    // The reader adds one for meshes without.
    assert_eq!(found.materials.len(), wanted.materials.len() + 1);
    for (material, other) in found.materials.iter().zip(&wanted.materials) {
        check_material(material, other);
        let [Some(texture), Some(original)] =
            [(found, material), (wanted, other)].map(|(scene, material)| {
                material
                    .base_color_texture
                    .map(|index| &scene.textures[index])
            })
        else {
            continue;
        };
        let sizes = [texture, original].map(|t| (t.width, t.height, t.srgb, t.wrap));
        assert_eq!(sizes[0], sizes[1], "{}", other.name);
        let (mean, most) = difference(texture, original);
        // A painting is a JPEG; ink comes in shares of a sixtieth and more; all else is exact.
        let limits = match &*other.name {
            "painting" => (0.5, 15),
            "letter" | "book spines" | "telephone screen" | "eye chart" | "dial" => (0.1, 5),
            _ => (0.0, 0),
        };
        assert!(
            mean <= limits.0 && most <= limits.1,
            "{}: {mean}, {most}",
            other.name
        );
    }
}

#[test]
fn the_examples_clinic_is_what_its_generator_writes() {
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let found = std::fs::read(assets.join(generator::clinic::PATH)).expect("the baked file");
    assert!(
        found == generator::clinic::write().expect("a file"),
        "clinic.glb is not what `cargo run --release --example bake_rooms` writes now"
    );
}

#[test]
fn the_baked_rooms_are_what_their_generator_builds() {
    for (scene, (name, build)) in BuiltIn::ALL.into_iter().zip(generator::ALL) {
        assert_eq!(scene.name(), name);
        let wanted = build().expect("a generated room");
        let found = scene.build().expect("a baked room");
        check_scene(&found, &wanted);
        // A comparison that sees one vertex of the floor a fifth of a millimetre off; it panics here.
        let mut moved = wanted.clone();
        moved.meshes[0].positions[0][1] += 2e-4;
        let seen = std::panic::catch_unwind(|| check_scene(&found, &moved));
        assert!(seen.is_err(), "a moved vertex goes unseen");
        let path = format!("{}/assets/scenes/{name}.glb", env!("CARGO_MANIFEST_DIR"));
        let file = std::fs::read(path).expect("the baked file");
        let written = glb::write(&wanted).expect("a file");
        assert!(
            written.len().abs_diff(file.len()) < file.len() / 1000,
            "{name}.glb is not what `cargo run --release --example bake_rooms` writes now"
        );
    }
}
