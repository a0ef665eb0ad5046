//! The program itself: what it prints, how it ends, and one sentence for every bad input.

mod files;
mod measure;
mod pictures;
mod results;
mod zoo;

use image::{Rgb, RgbImage};
use ocularium::patients::PRESETS;
use ocularium::scene::catalog::BuiltIn;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ocularium"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> Output {
    program(arguments).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// The program's standard output where all went well.
fn said(arguments: &[&str]) -> String {
    let output = run(arguments);
    let errors = text(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    assert_eq!(errors, "", "{arguments:?}");
    text(&output.stdout)
}

/// Exit 1 and one sentence that holds all of `parts`.
fn refused(arguments: &[&str], parts: &[&str]) {
    let output = run(arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
    let lines: Vec<&str> = errors
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {errors}");
    assert!(
        lines[0].starts_with("ocularium: "),
        "{arguments:?}: {errors}"
    );
    for part in parts {
        assert!(
            lines[0].contains(part),
            "{arguments:?}: no {part:?} in {errors}"
        );
    }
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
}

/// Exit 2 and a message about the command line that holds `part`.
fn misused(arguments: &[&str], part: &str) {
    let output = run(arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert!(
        errors.contains("error: ") && errors.contains(part),
        "{arguments:?}: {errors}"
    );
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
}

/// A folder with files to be refused.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn name(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn write(&self, name: &str, bytes: &[u8]) -> String {
        fs::write(self.path(name), bytes).expect("written");
        self.name(name)
    }

    fn picture(&self, name: &str, width: u32, height: u32) -> String {
        let image = RgbImage::from_fn(width, height, |x, y| {
            Rgb([((x * 37) ^ (y * 91)) as u8, (x * 11) as u8, (y * 13) as u8])
        });
        image.save(self.path(name)).expect("saved");
        self.name(name)
    }
}

/// `render` into a folder that must not be there afterwards.
fn render_refused(arguments: &[&str], parts: &[&str]) {
    let files = Files::new();
    let out = files.name("out");
    refused(&[&["render", "--out", &out], arguments].concat(), parts);
    assert!(
        !Path::new(&out).exists(),
        "{arguments:?} left something behind"
    );
}

#[test]
fn it_says_what_it_is_and_what_it_has() {
    let help = said(&["--help"]);
    for word in [
        "render", "features", "bench", "patients", "scenes", "check", "--seed",
    ] {
        assert!(help.contains(word), "no {word} in {help}");
    }
    for command in ["render", "features", "bench", "patients", "scenes", "check"] {
        assert!(
            said(&[command, "--help"]).contains("Usage: ocularium"),
            "{command}"
        );
    }
    assert_eq!(
        said(&["--version"]),
        format!("ocularium {}\n", env!("CARGO_PKG_VERSION"))
    );

    let patients = said(&["patients"]);
    assert_eq!(patients.lines().count(), PRESETS.len());
    for (line, preset) in patients.lines().zip(PRESETS) {
        let (name, description) = line.split_once(' ').expect("name and description");
        assert_eq!(name, preset.name);
        assert!(!description.trim().is_empty(), "{line}");
    }
    let scenes = said(&["scenes"]);
    let names: Vec<&str> = scenes
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert_eq!(names, BuiltIn::ALL.map(BuiltIn::name));
}

#[test]
fn patients_are_checked_field_by_field() {
    let files = Files::new();
    let sound = files.write("ann.ron", b"(name: \"Ann\", age_years: 40, sphere_d: -1.5)");
    let faulty = files.write("late.ron", b"// A walk.\n[(time_s: 1.0), (time_s: 0.5)]");
    refused(
        &["check", &faulty],
        &["head path", "late.ron", "[2].time_s = 0.5"],
    );
    render_refused(&["--patient", &faulty], &["late.ron", "--head-path"]);
    let path = files.write(
        "path.ron",
        b"[(time_s: 0.0), (time_s: 2.5, forward_m: 1.0)]",
    );
    assert_eq!(
        said(&["check", &path]),
        format!("{path} is sound: a head path of 2 moments, 2.5 s long.\n")
    );
    let line = said(&["check", &sound]);
    assert!(
        line.contains("sound") && line.contains("Ann") && line.contains("40"),
        "{line}"
    );
    for preset in PRESETS {
        assert!(
            said(&["check", preset.name]).contains("sound"),
            "{}",
            preset.name
        );
    }

    let known = ["healthy-brown", "myope-3d", "glaucoma-moderate"];
    refused(
        &["check", "nobody"],
        &[&["\"nobody\""], &known[..]].concat(),
    );
    render_refused(
        &["--patient", "nobody"],
        &[&["\"nobody\""], &known[..]].concat(),
    );
    let cases: [(&str, &[u8], &[&str]); 9] = [
        (
            "colour.ron",
            b"(eye_color: Blue)",
            &["eye_color", "iris_color"],
        ),
        (
            "age.ron",
            b"(age_years: 300.0)",
            &["age_years", "300", "1 to 110"],
        ),
        (
            "nan.ron",
            b"(sphere_d: NaN)",
            &["sphere_d", "NaN", "-20 to 20"],
        ),
        (
            "pupil.ron",
            b"(pupil: Fixed(0.5))",
            &["pupil", "0.5", "1 to 9"],
        ),
        (
            "shape.ron",
            b"(cornea_p: 1.5, cornea_radius_mm: 6.0)",
            &["cornea_p", "limbus"],
        ),
        ("kind.ron", b"(iris_color: Purple)", &["Purple", "Brown"]),
        ("empty.ron", b"", &["empty.ron", "empty"]),
        ("cut.ron", b"(name: \"An", &["cut.ron:1:"]),
        (
            "binary.ron",
            &[0xff, 0xfe, 0x00, 0x80],
            &["binary.ron", "UTF-8"],
        ),
    ];
    for (name, bytes, parts) in cases {
        let path = files.write(name, bytes);
        let parts = [&[name], parts].concat();
        refused(&["check", &path], &parts);
        render_refused(&["--patient", &path], &parts);
    }
    refused(&["check", &files.name("none.ron")], &["none.ron"]);
    refused(
        &["check", &files.0.path().display().to_string()],
        &["patient"],
    );
}

#[test]
fn bad_images_are_refused_by_name() {
    let files = Files::new();
    let whole = fs::read(files.picture("whole.png", 64, 64)).expect("read");
    let cases: [(String, &str); 7] = [
        (files.name("missing.png"), "does not exist"),
        (files.write("empty.png", b""), "is empty"),
        (
            files.write("truncated.png", &whole[..whole.len() / 2]),
            "PNG, JPEG",
        ),
        (files.write("header.png", &whole[..20]), "PNG, JPEG"),
        (
            files.write("text.png", b"not an image at all"),
            "no known picture format",
        ),
        (files.picture("dot.png", 1, 1), "1×1"),
        (files.picture("wide.png", 20_000, 8), "20000×8"),
    ];
    for (path, part) in &cases {
        refused(&["features", path, "--threshold", "20"], &[path, part]);
        render_refused(&["--scene", path], &[path, part]);
        // The same as the depth of a good photograph; a depth image may be small.
        if *part != "1×1" {
            let photo = files.name("whole.png");
            render_refused(&["--scene", &photo, "--depth", path], &[path, part]);
        }
    }
    render_refused(
        &[
            "--scene",
            &files.name("whole.png"),
            "--depth",
            &files.name("whole.png"),
        ],
        &["in colour"],
    );
    render_refused(
        &["--depth", &files.name("whole.png")],
        &["depth image", "built-in scene"],
    );
}

/// A GLB file from JSON and a binary chunk.
fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + blob.len();
    let mut file = b"glTF".to_vec();
    file.extend([2u32, total as u32].map(u32::to_le_bytes).concat());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", blob)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// One triangle at these positions.
fn triangle(positions: [f32; 9]) -> Vec<u8> {
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"name":"tile","primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
    glb(json, &positions.map(f32::to_le_bytes).concat())
}

#[test]
fn bad_scenes_are_refused_by_name() {
    let files = Files::new();
    render_refused(&["--scene", "kitchen"], &["\"kitchen\"", "room", "chart"]);
    let nan = triangle([0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, f32::NAN, -1.0]);
    let good = triangle([0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, 1.0, -1.0]);
    let cases: [(String, &str); 8] = [
        (
            files.write("hollow.gltf", br#"{"asset":{"version":"2.0"}}"#),
            "mesh",
        ),
        (
            files.write("hollow.glb", &glb(r#"{"asset":{"version":"2.0"}}"#, &[])),
            "mesh",
        ),
        (files.write("nan.glb", &nan), "not a finite number"),
        (files.write("cut.glb", &good[..good.len() - 20]), "glTF"),
        (files.write("json.gltf", b"{\"asset\":"), "glTF"),
        (files.write("empty.glb", b""), "is empty"),
        (files.write("notes.txt", b"hello"), "glTF"),
        (files.name("missing.glb"), "does not exist"),
    ];
    for (path, part) in &cases {
        render_refused(&["--scene", path], &[path, part]);
    }
}

#[test]
fn folders_that_cannot_be_written_are_refused() {
    let files = Files::new();
    let file = files.write("file", b"precious");
    let below = files.name("file/out");
    refused(
        &["render", "--out", &below, "--size", "32x16"],
        &["cannot write", &below],
    );
    refused(
        &["render", "--out", &file, "--size", "32x16"],
        &["cannot write", &file],
    );
    refused(
        &["bench", "--quick", "--out", &below],
        &["cannot write", &below],
    );
    assert_eq!(fs::read(&file).expect("still there"), b"precious");
    if cfg!(target_os = "linux") {
        // Nobody can make a folder there, not even root.
        refused(
            &["render", "--out", "/proc/ocularium"],
            &["cannot write", "/proc/ocularium"],
        );
    }
}

#[test]
fn nonsense_on_the_command_line_ends_with_2() {
    let files = Files::new();
    let out = files.name("out");
    let cases: [(&str, &[&str]); 5] = [
        (
            "--size",
            &[
                "0x0", "0x480", "-640x320", "15x16", "16x8193", "640", "axb", "640x", "",
            ],
        ),
        (
            "--seconds",
            &["0", "-1", "3601", "nan", "inf", "-inf", "soon", "0x1"],
        ),
        ("--fps", &["0", "-24", "1001", "nan", "inf", "fast"]),
        ("--orbit", &["86,0", "0,81", "0", "nan,0", "left"]),
        ("--distance", &["34", "1001", "nan", "-50"]),
    ];
    for (option, values) in cases {
        for value in values {
            misused(
                &["render", "--out", &out, &format!("{option}={value}")],
                option,
            );
        }
    }
    misused(&["render", "--out", &out, "--threshold=256"], "--threshold");
    misused(&["render", "--out", &out, "--seed=-1"], "--seed");
    misused(&["render", "--out", &out, "--panel=nose"], "--panel");
    misused(&["render"], "--out");
    misused(&["features", "a.png"], "--threshold");
    misused(&["features", "a.png", "--threshold=-1"], "--threshold");
    misused(&["check"], "<FILE>");
    misused(&["dance"], "dance");
    // Sides that are legal but leave half a panel too small.
    let output = run(&["render", "--out", &out, "--size", "16x16"]);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(
        errors.contains("8x16") && errors.lines().count() == 1,
        "{errors}"
    );
    assert!(!Path::new(&out).exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_display_where_nothing_answers_gets_a_sentence() {
    let output = program(&[])
        .env("DISPLAY", ":7777")
        .output()
        .expect("the program starts");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    // A machine without a display may lack the libraries as well.
    let reason = errors.contains("nothing answers there") || errors.contains("cannot be loaded");
    assert!(errors.contains("no display") && reason, "{errors}");
}
