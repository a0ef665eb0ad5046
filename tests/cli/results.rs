//! What the program leaves when all goes well: corners as CSV, whole files, and no complaint when
//! its reader goes away.

use super::{Files, program, run, said, text};
use crate::stage::turn;
use image::{DynamicImage, GrayImage, Luma, Rgb, RgbImage};
use ocularium::percept::fast;
use std::fs;
use std::process::Stdio;

/// Corners of a picture by the library, as the program prints them.
fn expected(luma: &[u8], width: u32, height: u32, threshold: u8, suppress: bool) -> String {
    let corners = fast::detect(luma, width as usize, height as usize, threshold, suppress);
    let mut csv = String::from("x,y,score\n");
    for corner in corners.expect("sizes agree") {
        csv += &format!("{},{},{}\n", corner.x, corner.y, corner.score);
    }
    csv
}

/// Names the first line that differs, not all of them.
fn same_corners(found: &str, expected: &str, of: &str) {
    let first = found.lines().zip(expected.lines()).find(|(a, b)| a != b);
    assert_eq!(first, None, "{of}");
    assert_eq!(found.lines().count(), expected.lines().count(), "{of}");
}

#[test]
fn features_prints_the_corners() {
    let files = Files::new();
    let grey = GrayImage::from_fn(60, 44, |x, y| {
        let plate = if (x / 9 + y / 7) % 2 == 0 { 40 } else { 190 };
        Luma([plate + ((x * 29) ^ (y * 53)) as u8 % 32])
    });
    grey.save(files.path("grey.png")).expect("saved");
    let colour = DynamicImage::ImageRgb8(RgbImage::from_fn(60, 44, |x, y| {
        let [v] = grey.get_pixel(x, y).0;
        Rgb([v, ((x * 97) ^ (y * 31)) as u8, 255 - v])
    }));
    colour.save(files.path("colour.png")).expect("saved");
    // Rec. 709 luma of each colour, rounded to nearest.
    let luma: Vec<u8> = colour
        .to_rgb8()
        .pixels()
        .map(|p| fast::luma_of_srgb8(p.0))
        .collect();
    for (name, luma) in [("grey.png", grey.into_raw()), ("colour.png", luma)] {
        let path = files.name(name);
        for threshold in ["0", "20", "60", "255"] {
            let t = threshold.parse().expect("a number");
            let all = said(&["features", &path, "--threshold", threshold, "--no-nms"]);
            same_corners(
                &all,
                &expected(&luma, 60, 44, t, false),
                &format!("{name} at {t}, all"),
            );
            let best = said(&["features", &path, "--threshold", threshold]);
            same_corners(
                &best,
                &expected(&luma, 60, 44, t, true),
                &format!("{name} at {t}"),
            );
            if threshold == "20" {
                assert!(
                    best.len() > 100 && best.len() < all.len(),
                    "{name} has corners"
                );
            }
        }
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let files = Files::new();
    // 10,000 corners and more: far beyond what a pipe holds.
    let path = files.picture("noise.png", 400, 400);
    let lists: [&[&str]; 3] = [
        &["features", &path, "--threshold", "0", "--no-nms"],
        &["patients"],
        &["check", "myope-3d"],
    ];
    for arguments in lists {
        let mut child = program(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(text(&output.stderr), "", "{arguments:?}");
        assert!(
            output.status.success(),
            "{arguments:?}: {:?}",
            output.status
        );
    }
}

#[test]
fn render_leaves_whole_files_and_nothing_else() {
    let _turn = turn();
    let files = Files::new();
    let out = files.name("deep/out");
    let arguments = [
        "render",
        "--out",
        &out,
        "--size",
        "64x32",
        "--seconds",
        "0.1",
        "--fps",
        "20",
        "--eye",
        "os",
    ];
    let output = run(&arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut names: Vec<String> = fs::read_dir(&out)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("a name")
        })
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "frame_00000.png",
            "frame_00001.png",
            "report.json",
            "trace.csv"
        ]
    );
    let trace = fs::read_to_string(files.path("deep/out/trace.csv")).expect("a trace");
    assert_eq!(trace.lines().count(), 3);
    let report = fs::read(files.path("deep/out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    assert_eq!((&report["frames"], &report["seed"]), (&2.into(), &1.into()));
    assert_eq!(report["size_px"], serde_json::json!([64, 32]));
    assert_eq!(
        (&report["eye"], &report["light"]),
        (&"OS".into(), &"window".into())
    );
    assert_eq!(
        (&report["orbit_deg"], &report["distance_mm"]),
        (&serde_json::json!([0.0, 0.0]), &93.0.into())
    );
    // The first frame was there before the clock began; one that was drawn has a time.
    assert!(report["frame_ms_median"].as_f64().expect("a time") > 0.0);
    assert_eq!(report["frame_ms_mean"], report["frame_ms_max"]);
    // A shorter run leaves no frame of the longer one, and says so.
    let output = run(&[&arguments[..6], &["0.05"][..], &arguments[7..]].concat());
    let said = text(&output.stderr);
    assert!(
        output.status.success() && said.contains("an earlier run"),
        "{said}"
    );
    assert!(!files.path("deep/out/frame_00001.png").exists());
    let report = fs::read(files.path("deep/out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    assert_eq!(report["frame_ms_median"], serde_json::Value::Null);
    assert_eq!(report["removed_frames"], 1);
    // Nor does one after a run that was killed, which left no report, but its lock.
    let left = files.path("deep/out/frame_00007.png");
    fs::write(&left, "a picture").expect("written");
    fs::write(files.path("deep/out/.ocularium-lock"), "8").expect("written");
    // What it has not written is not its own.
    let own = files.path("deep/out/frame_00090.png");
    fs::write(&own, "mine").expect("written");
    fs::remove_file(files.path("deep/out/report.json")).expect("removed");
    let output = run(&[&arguments[..6], &["0.05"][..], &arguments[7..]].concat());
    assert!(output.status.success() && !left.exists() && own.exists());
    assert!(!files.path("deep/out/.ocularium-lock").exists());
}

/// The way of a head that comes with the program moves the view, from where the scene puts it.
#[test]
fn a_head_path_moves_the_view() {
    let _turn = turn();
    let files = Files::new();
    let out = files.name("out");
    let frames = |path: &[&str]| {
        let arguments = [
            "render",
            "--panel",
            "view",
            "--size",
            "64x64",
            "--seconds",
            "2",
            "--fps",
            "1",
            "--seed",
            "2",
            "--out",
            &out,
        ];
        let output = run(&[&arguments[..], path].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        [0, 1].map(|frame| {
            let picture = files.path(&format!("out/frame_{frame:05}.png"));
            image::open(picture).expect("a frame").to_rgb8().into_raw()
        })
    };
    let apart = |one: &[u8], other: &[u8]| {
        let sum: u64 = one
            .iter()
            .zip(other)
            .map(|(a, b)| u64::from(a.abs_diff(*b)))
            .sum();
        sum as f64 / one.len() as f64
    };
    let ([start, walked], [stood, later]) = (frames(&["--head-path", "walk"]), frames(&[]));
    // Of an eye that is not in the picture nothing is said.
    let report = fs::read(files.path("out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let null = serde_json::Value::Null;
    assert_eq!((&report["light"], &report["orbit_deg"]), (&null, &null));
    assert_eq!(report["threshold"], 20);
    let (begins, ends) = (apart(&start, &stood), apart(&walked, &later));
    assert!(
        begins < 0.5 && ends > 5.0,
        "{begins} at the beginning, {ends} after a second"
    );
}
