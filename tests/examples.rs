//! The examples, run as they stand, without a window.

use crate::stage::{alone, mean};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program of an example, which `cargo test` has built.
fn example(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_BIN_EXE_ocularium"))
        .parent()
        .expect("a folder");
    folder
        .join("examples")
        .join(name)
        .with_extension(std::env::consts::EXE_EXTENSION)
}

fn pictures(name: &str) -> Vec<image::RgbaImage> {
    let out = tempfile::tempdir().expect("a folder");
    let said = Command::new(example(name))
        .args(["--frames", "3", "--fps", "2", "--size", "320x160", "--out"])
        .arg(out.path())
        .output()
        .unwrap_or_else(|error| panic!("{name}: {error}; cargo test builds the examples"));
    assert!(
        said.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&said.stderr)
    );
    (0..3)
        .map(|frame| {
            let file = out.path().join(format!("frame_{frame:05}.png"));
            image::open(file).expect("a frame").to_rgba8()
        })
        .collect()
}

/// Mean over the pixels of one half of how far two pictures are apart.
fn apart(one: &image::RgbaImage, other: &image::RgbaImage) -> f64 {
    let differences = one
        .as_raw()
        .iter()
        .zip(other.as_raw())
        .map(|(a, b)| f64::from(a.abs_diff(*b)));
    differences.sum::<f64>() / one.as_raw().len() as f64
}

#[test]
fn every_example_shows_something_that_moves() {
    let _alone = alone();
    for name in ["sees_as", "eye_in_my_scene"] {
        let frames = pictures(name);
        assert!(mean(&frames[0]) > 10.0, "{name} is dark");
        assert!(apart(&frames[0], &frames[2]) > 0.5, "{name} stands still");
    }
}

#[test]
fn two_patients_see_the_same_room_differently() {
    let _alone = alone();
    let frames = pictures("two_patients");
    let half = |left: u32| image::imageops::crop_imm(&frames[2], left, 0, 160, 160).to_image();
    let (before, after) = (half(0), half(160));
    assert!(mean(&before) > 10.0 && mean(&after) > 5.0);
    assert!(apart(&before, &after) > 2.0, "both see alike");
}

#[test]
fn a_wrong_command_line_is_said() {
    let said = Command::new(example("sees_as"))
        .args(["--frames", "none"])
        .output()
        .expect("it runs");
    assert_eq!(said.status.code(), Some(2));
    let text = String::from_utf8_lossy(&said.stderr);
    assert!(text.contains("--frames \"none\""), "{text}");
}

#[test]
#[cfg(all(unix, not(target_os = "macos")))]
fn without_a_display_a_sentence_is_said() {
    let said = Command::new(example("two_patients"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap_or_else(|error| panic!("{error}; cargo test builds the examples"));
    let sentence = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(1), "{sentence}");
    assert!(
        sentence.contains("no display")
            && sentence.contains("--frames")
            && !sentence.contains("panicked"),
        "{sentence}"
    );
}
