//! A handful of broken and odd files: each is shown or gets one sentence, and leaves nothing half-done.

use super::{Files, program, text};
use crate::stage::alone;
use std::fs;
use std::time::{Duration, Instant};

/// What has to come of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Shown,
    Refused(&'static str),
}
use Fate::{Refused, Shown};

fn data(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// A model of one triangle, with this text in place of that.
fn model(from: &str, to: &str) -> Vec<u8> {
    let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAADAAACAPwAAAAAAAADAAAAAAAAAgD8AAADA"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,-2],"max":[1,1,-2]}]}"#;
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1).into_bytes()
}

fn zoo() -> Vec<(&'static str, Vec<u8>, Fate)> {
    let (page, photo) = (data("page.png"), data("interleaved.jpg"));
    let mut wrong_sum = page.clone();
    wrong_sum[30] ^= 0x55;
    let mut marker = photo.clone();
    marker[4] = 0xff;
    vec![
        ("sound.gltf", model("{", "{"), Shown),
        ("empty.glb", Vec::new(), Refused("is empty")),
        ("magic.glb", b"glTF".to_vec(), Refused("glTF")),
        (
            "half.gltf",
            model("{", "{")[..200].to_vec(),
            Refused("glTF"),
        ),
        (
            "loop.gltf",
            model(r#"{"mesh":0}"#, r#"{"mesh":0,"children":[0]}"#),
            Refused("loop"),
        ),
        (
            "no-such-mesh.gltf",
            model(r#"{"mesh":0}"#, r#"{"mesh":7}"#),
            Refused("glTF"),
        ),
        (
            "no-such-accessor.gltf",
            model(r#""POSITION":0"#, r#""POSITION":9"#),
            Refused("accessor 9"),
        ),
        (
            "huge-count.gltf",
            model(r#""count":3"#, r#""count":4294967295"#),
            Refused("glTF"),
        ),
        (
            "short-buffer.gltf",
            model(r#""byteLength":36,"uri""#, r#""byteLength":3600,"uri""#),
            Refused("of 3600 announced"),
        ),
        (
            "beyond.gltf",
            model(
                r#"{"buffer":0,"byteLength":36}"#,
                r#"{"buffer":0,"byteOffset":20,"byteLength":36}"#,
            ),
            Refused("beyond"),
        ),
        (
            "flat.gltf",
            model(
                "AAAAAAAAAAAAAADAAACAPwAAAAAAAADAAAAAAAAAgD8AAADA",
                "AAAAAAAAAAAAAADAAAAAAAAAAAAAAADAAAAAAAAAAAAAAADA",
            ),
            Shown,
        ),
        (
            "not-numbers.gltf",
            model("AAAAAAAAAAAAAADA", "AADAfwAAwH8AAMB/"),
            Refused("not-numbers.gltf"),
        ),
        ("wrong-sum.png", wrong_sum, Refused("wrong-sum.png")),
        (
            "half.png",
            page[..page.len() / 2].to_vec(),
            Refused("half.png"),
        ),
        ("half.jpg", photo[..photo.len() / 2].to_vec(), Shown),
        ("marker.jpg", marker, Refused("marker.jpg")),
        (
            "text.png",
            b"no picture at all".to_vec(),
            Refused("no known picture format"),
        ),
        (
            "no-frames.gif",
            b"GIF89a\x20\x00\x20\x00\x00\x00\x00;".to_vec(),
            Refused("no-frames.gif"),
        ),
        ("page.txt", page, Shown),
    ]
}

#[test]
fn a_zoo_of_broken_files_does_no_harm() {
    let _alone = alone();
    for (name, bytes, fate) in zoo() {
        let files = Files::new();
        fs::write(files.path(name), bytes).expect("written");
        let (scene, out) = (files.name(name), files.name("out"));
        let started = Instant::now();
        let output = program(&[
            "render",
            "--scene",
            &scene,
            "--panel",
            "view",
            "--size",
            "32x32",
            "--seconds",
            "0.1",
            "--out",
            &out,
        ])
        .output()
        .expect("it starts");
        assert!(started.elapsed() < Duration::from_secs(60), "{name}");
        let said = text(&output.stderr);
        match fate {
            Shown => {
                assert!(output.status.success(), "{name}: {said}");
                assert!(files.path("out/report.json").is_file(), "{name}");
            }
            Refused(part) => {
                assert_eq!(output.status.code(), Some(1), "{name}: {said}");
                let is_sentence = said.starts_with("ocularium: ") && said.lines().count() == 1;
                assert!(is_sentence && said.len() < 600, "{name}: {said}");
                assert!(said.contains(part), "{name}: {part} is not in {said}");
                assert!(!files.path("out").exists(), "{name} left a folder");
            }
        }
    }
}
