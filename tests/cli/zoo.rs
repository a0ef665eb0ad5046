//! Broken and odd files: each is shown or refused in one sentence, never a crash, a wait or half a folder.

use super::{Files, glb, program, text};
use crate::stage::turn;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A small frame takes seconds on software; a loop without end takes this long.
const LONGEST: Duration = Duration::from_secs(60);

/// What became of a file.
#[derive(Debug, PartialEq)]
enum Fate {
    /// Exit 0 and all files; this was said.
    Shown(String),
    /// Exit 1, this one sentence, and no folder.
    Refused(String),
}

/// Runs a command that writes into `out`; anything but a [`Fate`] is said.
fn fate(command: &mut Command, out: &Path, longest: Duration) -> Result<Fate, String> {
    let mut running = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let started = Instant::now();
    while running.try_wait().expect("a state").is_none() {
        if started.elapsed() > longest {
            running.kill().expect("it can be ended");
            running.wait().expect("it ends");
            return Err(format!("still running after {longest:?}"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = running.wait_with_output().expect("it ended");
    let errors = text(&output.stderr);
    match output.status.code() {
        Some(0) => {
            let whole = |name| fs::metadata(out.join(name)).is_ok_and(|file| file.len() > 0);
            if ["frame_00000.png", "trace.csv", "report.json"]
                .iter()
                .all(whole)
            {
                Ok(Fate::Shown(errors))
            } else {
                Err(format!("exit 0 without its files: {errors}"))
            }
        }
        Some(1) if errors.lines().count() != 1 => Err(format!("not one sentence: {errors}")),
        Some(1) if out.exists() => Err(format!("refused, but it left its folder: {errors}")),
        Some(1) => Ok(Fate::Refused(errors)),
        other => Err(format!("exit {other:?}: {errors}")),
    }
}

#[cfg(unix)]
#[test]
fn crashes_waits_and_halves_are_found() {
    let files = Files::new();
    let out = files.path("out");
    let of = |script: &str| {
        let longest = Duration::from_millis(300);
        fate(Command::new("sh").args(["-c", script]), &out, longest)
    };
    let one = Ok(Fate::Refused("one\n".into()));
    assert_eq!(of("echo one >&2; exit 1"), one);
    for (script, part) in [
        ("exit 101", "101"),
        ("kill -SEGV $$", "None"),
        ("sleep 9", "still running"),
        ("exit 0", "without its files"),
        ("exit 1", "not one sentence"),
        ("echo one >&2; echo two >&2; exit 1", "not one sentence"),
    ] {
        let said = of(script).expect_err(script);
        assert!(said.contains(part), "{script}: {said}");
    }
    fs::create_dir(&out).expect("made");
    let said = of("echo one >&2; exit 1").expect_err("a folder is left");
    assert!(said.contains("left its folder"), "{said}");
}

/// A glTF of one triangle, all in one file, with these parts of its JSON replaced.
fn model(replaced: &[(&str, &str)]) -> Vec<u8> {
    let mut json = String::from(
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "buffers":[{"byteLength":42}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,-2],"max":[1,1,-2]},
        {"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]}"#,
    );
    for (from, to) in replaced {
        assert!(json.contains(from), "no {from}");
        json = json.replace(from, to);
    }
    let corners = [-1.0f32, -1.0, -2.0, 1.0, -1.0, -2.0, 0.0, 1.0, -2.0];
    let mut blob = corners.map(f32::to_le_bytes).concat();
    blob.extend([0u16, 1, 2].map(u16::to_le_bytes).concat());
    blob.extend([0, 0]);
    glb(&json, &blob)
}

/// The same with an animation of one channel, which moves this.
fn moved(node: &str) -> Vec<u8> {
    let asset = r#""asset":{"version":"2.0"}"#;
    let animation = format!(
        r#"{asset},"animations":[{{"samplers":[{{"input":1,"output":0}}],"channels":[{{"sampler":0,"target":{{{node}"path":"translation"}}}}]}}]"#
    );
    model(&[(asset, &animation)])
}

/// What is to become of a file: it is shown, shown with a remark, or refused; with a part of what is
/// said of it.
#[derive(Clone, Copy)]
enum Due {
    Shown,
    Remarked(&'static str),
    Refused(&'static str),
}
use Due::{Refused, Remarked, Shown};

impl Due {
    fn is_met_by(self, fate: &Result<Fate, String>, name: &str) -> bool {
        match (self, fate) {
            (Shown, Ok(Fate::Shown(said))) => !said.contains("ocularium: "),
            (Remarked(part), Ok(Fate::Shown(said))) => {
                said.contains("ocularium: ") && said.contains(part)
            }
            (Refused(part), Ok(Fate::Refused(said))) => said.contains(part) && said.contains(name),
            _ => false,
        }
    }
}

/// Models: file, what is in it, and what is to become of it.
fn models() -> Vec<(&'static str, Vec<u8>, Due)> {
    let whole = model(&[]);
    let node = r#""nodes":[{"mesh":0}]"#;
    let mut far = whole.clone();
    let last_index = far.len() - 4;
    far[last_index] = 200;
    let mut not_finite = whole.clone();
    let first_corner = not_finite.len() - 44;
    not_finite[first_corner..first_corner + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let chain: String = (1..4000)
        .map(|n| format!(r#"{{"children":[{n}]}},"#))
        .collect();
    let chain = format!(r#""nodes":[{chain}{{"mesh":0}}]"#);
    vec![
        ("whole.glb", whole.clone(), Shown),
        (
            "no_mesh.glb",
            model(&[(node, r#""nodes":[{"mesh":7}]"#)]),
            Refused("out of bounds"),
        ),
        (
            "no_accessor.glb",
            model(&[(r#""POSITION":0"#, r#""POSITION":9"#)]),
            Refused("accessor 9"),
        ),
        ("cut_in_header.glb", whole[..10].to_vec(), Refused("cut off")),
        ("cut_in_json.glb", whole[..200].to_vec(), Refused("cut off")),
        ("cut_in_data.glb", whole[..whole.len() - 20].to_vec(), Refused("cut off")),
        ("index_far.glb", far, Refused("index 200")),
        ("not_finite.glb", not_finite, Refused("not a finite number")),
        (
            "cycle.glb",
            model(&[(node, r#""nodes":[{"mesh":0,"children":[1]},{"children":[0]}]"#)]),
            Refused("loop"),
        ),
        ("own_child.glb", model(&[(node, r#""nodes":[{"mesh":0,"children":[0]}]"#)]), Refused("loop")),
        ("moves_nobody.glb", moved(""), Shown),
        ("moves_a_missing_node.glb", moved(r#""node":77,"#), Refused("moves node 77")),
        ("deep.glb", model(&[(node, &chain)]), Refused("deep")),
        ("no_node.glb", model(&[(r#""scenes":[{"nodes":[0]}]"#, r#""scenes":[{"nodes":[7]}]"#)]), Refused("out of bounds")),
        ("many.glb", model(&[(r#""count":3"#, r#""count":4294967295"#)]), Refused("accessor 0")),
        ("count_overflows.glb", model(&[(r#""count":3"#, r#""count":18446744073709551615"#)]), Refused("accessor 0")),
        ("view_beyond.glb", model(&[(r#""byteOffset":36"#, r#""byteOffset":4000000000"#)]), Refused("buffer view 1")),
        ("buffer_beyond.glb", model(&[(r#""byteLength":42"#, r#""byteLength":4000000000"#)]), Refused("4000000000")),
        (
            "many_sparse.glb",
            model(&[(
                r#""max":[1,1,-2]"#,
                r#""max":[1,1,-2],"sparse":{"count":4000000000,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}}"#,
            )]),
            Refused("accessor 0"),
        ),
        ("flat.glb", model(&[(node, r#""nodes":[{"mesh":0,"scale":[0,0,0]}]"#)]), Remarked("is in the view")),
        ("huge.glb", model(&[(node, r#""nodes":[{"mesh":0,"scale":[1e38,1e38,1e38]}]"#)]), Remarked("2.0e38 m wide")),
        (
            "missing_buffer.gltf",
            br#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"none.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#.to_vec(),
            Refused("none.bin"),
        ),
        ("brackets.gltf", vec![b'['; 1 << 20], Refused("glTF file")),
    ]
}

/// A PNG's bytes of 32 × 32 pixels.
fn png() -> Vec<u8> {
    let picture = image::RgbImage::from_fn(32, 32, |x, y| {
        image::Rgb([(x * 8) as u8, (y * 8) as u8, 99])
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("written");
    bytes.into_inner()
}

/// Pictures, as [`models`].
fn pictures() -> Vec<(&'static str, Vec<u8>, Due)> {
    let whole = png();
    let page = include_bytes!("../data/interleaved.jpg");
    let mut marker = page.to_vec();
    marker[4] = 0xff;
    let mut wrong_sum = whole.clone();
    // The header's check sum: after 8 bytes of signature, 8 of length and name, and 13 of header.
    wrong_sum[29] ^= 1;
    let mut gigantic = whole.clone();
    gigantic[16..20].copy_from_slice(&0x7fff_ffffu32.to_be_bytes());
    // The check sum of that header, so that its size is what is refused.
    gigantic[29..33].copy_from_slice(&0xe3a4_7219u32.to_be_bytes());
    let tiff = |next: u32| {
        let mut bytes = b"II*\0\x08\0\0\0\0\0".to_vec();
        bytes.extend(next.to_le_bytes());
        bytes
    };
    vec![
        ("whole.png", whole.clone(), Shown),
        ("picture.txt", whole.clone(), Shown),
        ("marker.jpg", marker, Refused("JPEG")),
        ("wrong_sum.png", wrong_sum, Refused("PNG")),
        ("gigantic.png", gigantic, Refused("2147483647")),
        (
            "cut.png",
            whole[..whole.len() / 2].to_vec(),
            Refused("cut off"),
        ),
        (
            "cut.jpg",
            page[..page.len() / 2].to_vec(),
            Remarked("cut off"),
        ),
        ("cut_in_header.jpg", page[..100].to_vec(), Refused("JPEG")),
        (
            "no_frame.gif",
            b"GIF89a\x20\0\x20\0\0\0\0;".to_vec(),
            Refused("GIF"),
        ),
        (
            "text.png",
            b"This is no picture.\n".to_vec(),
            Refused("no known picture format"),
        ),
        ("empty.png", Vec::new(), Refused("is empty")),
        ("nothing.bmp", b"BM".to_vec(), Refused("cut off")),
        ("own_successor.tif", tiff(8), Refused("TIFF")),
        (
            "header.webp",
            b"RIFF\x04\0\0\0WEBP".to_vec(),
            Refused("cut off"),
        ),
        (
            "zeros.png",
            vec![0; 4096],
            Refused("no known picture format"),
        ),
        (
            "new\nline.png",
            b"This is no picture.\n".to_vec(),
            Refused("no known picture format"),
        ),
    ]
}

#[test]
fn broken_and_odd_files_are_shown_or_refused() {
    let _turn = turn();
    let files = Files::new();
    let mut wrong = Vec::new();
    for (name, bytes, due) in models().into_iter().chain(pictures()) {
        let (scene, out) = (files.write(name, &bytes), files.name("out"));
        let mut command = program(&["render", "--panel", "view", "--size", "32x32", "--seconds"]);
        command.args(["0.1", "--scene", &scene, "--out", &out]);
        let found = fate(&mut command, Path::new(&out), LONGEST);
        let stem = name.rsplit('\n').next().expect("a name");
        if !due.is_met_by(&found, stem) {
            wrong.push(format!("{name:?}: {found:?}"));
        }
        // Where it was shown; a refused one has left none.
        let _ = fs::remove_dir_all(&out);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn broken_patients_are_refused() {
    let files = Files::new();
    let nested = |open: &str| open.repeat(300_000).into_bytes();
    for (name, bytes) in [
        ("brackets.ron", nested("(")),
        ("lists.ron", nested("[")),
        ("number.ron", b"(age_years: 1e999)".to_vec()),
        ("comment.ron", b"/* ( */ /* ".to_vec()),
        ("zeros.ron", vec![0; 4096]),
        (
            "field.ron",
            format!("({}: 1)", "x".repeat(8000)).into_bytes(),
        ),
        (
            "value.ron",
            format!("(iris_color: {})", "X".repeat(5000)).into_bytes(),
        ),
        (
            "name.ron",
            format!("(name: \"{}\u{7}\")", "x".repeat(6000)).into_bytes(),
        ),
    ] {
        let path = files.write(name, &bytes);
        let found = fate(
            &mut program(&["check", &path]),
            &files.path("none"),
            LONGEST,
        );
        assert!(
            matches!(&found, Ok(Fate::Refused(said)) if said.contains(name) && said.len() < 1200),
            "{name}: {found:?}"
        );
    }
}
