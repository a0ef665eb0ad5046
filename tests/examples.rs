//! The examples, run as they stand, without a window.

use crate::stage::{mean, turn};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

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

fn pictures(name: &str, count: usize, size: &str) -> Vec<image::RgbaImage> {
    let out = tempfile::tempdir().expect("a folder");
    let said = Command::new(example(name))
        .env("BEVY_ASSET_ROOT", env!("CARGO_MANIFEST_DIR"))
        .args(["--frames", &count.to_string()])
        .args(["--fps", "2", "--size", size, "--out"])
        .arg(out.path())
        .output()
        .unwrap_or_else(|error| panic!("{name}: {error}; cargo test builds the examples"));
    assert!(
        said.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&said.stderr)
    );
    (0..count)
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
    let _turn = turn();
    for name in ["sees_as", "eye_in_my_scene"] {
        let frames = pictures(name, 3, "320x160");
        assert!(mean(&frames[0]) > 10.0, "{name} is dark");
        assert!(apart(&frames[0], &frames[2]) > 0.5, "{name} stands still");
    }
}

/// Root mean square step of brightness between neighbouring pixels over the mean brightness: blur makes one large
/// step many small ones.
fn contrast(picture: &image::RgbaImage) -> f64 {
    let grey = image::imageops::grayscale(picture);
    let (mut steps, mut sum) = (0.0, 0.0);
    for (x, y, pixel) in grey.enumerate_pixels() {
        sum += f64::from(pixel[0]);
        if x > 0 {
            steps += f64::from(pixel[0].abs_diff(grey.get_pixel(x - 1, y)[0])).powi(2);
        }
    }
    let count = grey.len() as f64;
    (steps / count).sqrt() / (sum / count)
}

/// Somebody who grows short-sighted by 3 D loses the room's edges as she forgets how sharp they were.
#[test]
fn whoever_grows_short_sighted_loses_the_edges() {
    let _turn = turn();
    let found: Vec<f64> = pictures("sees_as", 6, "960x480")
        .iter()
        .map(contrast)
        .collect();
    // 3 D through a pupil of 3 mm are 31′, three of these pixels.
    assert!(found[5] < 0.7 * found[0], "{found:?}");
}

/// In the middle of the left half an eye stands: a dark pupil, blue around it, and white beside the blue. In the
/// right half is what it sees, yellower and paler as the lens clouds over.
#[test]
fn the_eye_stands_in_the_scene_and_sees_it() {
    let _turn = turn();
    let frames = pictures("eye_in_my_scene", 5, "640x160");
    let picture = &frames[0];
    let count = |is: fn([f64; 3]) -> bool| {
        let middle = image::imageops::crop_imm(picture, 60, 20, 200, 120).to_image();
        middle
            .pixels()
            .filter(|pixel| is([pixel[0], pixel[1], pixel[2]].map(f64::from)))
            .count()
    };
    let dark = count(|[r, g, b]| r.max(g).max(b) < 30.0);
    let blue = count(|[r, _, b]| b > 1.1 * r && b > 50.0);
    let white = count(|[r, g, b]| r > 100.0 && b > 0.6 * r && (r - g).abs() < 0.25 * r);
    assert!(
        dark > 50 && blue > 200 && white > 200,
        "{dark} dark, {blue} blue, {white} white"
    );
    let seen = [0, 4].map(|at| image::imageops::crop_imm(&frames[at], 320, 0, 320, 160).to_image());
    let blue_to_red = seen.each_ref().map(|picture| {
        let [red, _, blue] = [0, 1, 2].map(|channel| {
            let values = picture.pixels().map(|pixel| f64::from(pixel[channel]));
            values.sum::<f64>()
        });
        blue / red
    });
    let [clear, clouded] = [&seen[0], &seen[1]].map(contrast);
    println!("contrast {clear} to {clouded}, blue to red {blue_to_red:?}");
    assert!(mean(&seen[0]) > 10.0 && clouded < 0.97 * clear);
    assert!(blue_to_red[1] < 0.95 * blue_to_red[0]);
}

#[test]
fn two_patients_see_the_same_room_differently() {
    let _turn = turn();
    let frames = pictures("two_patients", 3, "320x160");
    let half = |left: u32| image::imageops::crop_imm(&frames[2], left, 0, 160, 160).to_image();
    let (before, after) = (half(0), half(160));
    assert!(mean(&before) > 10.0 && mean(&after) > 5.0);
    assert!(apart(&before, &after) > 2.0, "both see alike");
    // What is lost is dim and blurred.
    assert!(
        contrast(&after) < 0.9 * contrast(&before) && mean(&after) < mean(&before),
        "{} and {}, {} and {}",
        contrast(&before),
        contrast(&after),
        mean(&before),
        mean(&after)
    );
}

/// The examples' scene is a file, which Bevy's own loader reads. Where it is not there a sentence says so, and
/// nothing is written.
#[test]
fn a_scene_that_is_not_there_is_said() {
    let _turn = turn();
    let out = tempfile::tempdir().expect("a folder");
    let elsewhere = tempfile::tempdir().expect("a folder");
    let said = Command::new(example("sees_as"))
        .env("BEVY_ASSET_ROOT", elsewhere.path())
        .args(["--frames", "1", "--size", "64x64", "--out"])
        .arg(out.path().join("frames"))
        .output()
        .expect("it runs");
    let sentence = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(1), "{sentence}");
    assert!(
        sentence.contains("clinic.glb") && !sentence.contains("panicked"),
        "{sentence}"
    );
    assert!(!out.path().join("frames/frame_00000.png").exists());
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

/// Ctrl-C ends a recording after the frame in work, with a report of what is there; another, shorter one says
/// what it takes away of somebody's longer film.
#[test]
#[cfg(unix)]
fn a_recording_that_is_stopped_leaves_whole_files_and_says_so() {
    let _turn = turn();
    let out = tempfile::tempdir().expect("a folder");
    let started = |frames: &str| {
        Command::new(example("sees_as"))
            .env("BEVY_ASSET_ROOT", env!("CARGO_MANIFEST_DIR"))
            .args(["--frames", frames, "--size", "64x64", "--out"])
            .arg(out.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    let mut running = started("100000");
    let second = out.path().join("frame_00001.png");
    let begun = Instant::now();
    while !second.exists() {
        assert!(begun.elapsed() < Duration::from_secs(240), "no frame");
        std::thread::sleep(Duration::from_millis(50));
    }
    let sent = Command::new("kill")
        .args(["-INT", &running.id().to_string()])
        .status();
    assert!(sent.expect("kill is there").success());
    let begun = Instant::now();
    while running.try_wait().expect("it is there").is_none() {
        if begun.elapsed() > Duration::from_secs(240) {
            running.kill().expect("it is killed");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let ended = running.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("interrupted"), "{said}");
    let report = || {
        let text = std::fs::read_to_string(out.path().join("report.json")).expect("a report");
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON")
    };
    let stopped = report();
    assert_eq!(stopped["interrupted"], true);
    let frames = stopped["frames"].as_u64().expect("a number");
    assert!(
        frames >= 2
            && out
                .path()
                .join(format!("frame_{:05}.png", frames - 1))
                .exists()
    );

    std::fs::write(out.path().join("trace.csv"), "time_s").expect("written");
    let ended = started("1").wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    let gone = format!(
        "its frames beyond these ({}) and its trace.csv were removed",
        frames - 1
    );
    assert!(ended.status.success() && said.contains(&gone), "{said}");
    assert_eq!(report()["interrupted"], false);
}
