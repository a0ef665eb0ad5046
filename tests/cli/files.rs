//! Files, folders and signals as they come: pipes and devices, depth pictures, two runs at once.

use super::{Files, misused, program, refused, render_refused, run, said, text};
use crate::stage::turn;
use std::fs;
use std::time::{Duration, Instant};

/// A file of `tests/data`.
pub fn data(name: &str) -> String {
    format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

pub fn succeeds(arguments: &[&str]) {
    let output = run(arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn a_photograph_stands_where_it_is_put() {
    let page = data("page.png");
    for (arguments, part) in [
        (&["--at", "0m"][..], "above 0"),
        (&["--at", "5mm"], "nearer than 2 cm"),
        (&["--at", "near"], "not a length"),
        (&["--span", "200deg"], "1 to 120"),
        (&["--span", "21"], "not a height"),
        (&["--depth-unit", "mm"], "--depth"),
    ] {
        misused(
            &[&["render", "--out", "x", "--scene", &page], arguments].concat(),
            part,
        );
    }
    for (arguments, part) in [
        (&["--at", "0.4m", "--depth", &page][..], "--at"),
        (&["--at", "inf", "--span", "21cm"], "must be an angle"),
        (&["--at", "0.05m", "--span", "2m"], "must be 1° to 120°"),
        (
            &["--depth", &page, "--depth-unit", "cm", "--depth-near", "1m"],
            "inverse only",
        ),
        (
            &["--depth", "/no/depth.png"],
            "The depth image \"/no/depth.png\" does not exist",
        ),
    ] {
        render_refused(&[&["--scene", &page], arguments].concat(), &[part]);
    }
    render_refused(&["--at", "1m"], &["\"room\"", "photograph"]);
}

/// Where the eye looks first and how its lens stands, in a view of the page.
#[test]
fn the_lens_goes_to_the_page() {
    let _turn = turn();
    let files = Files::new();
    let first_row = |patient: &str, extra: &[&str]| {
        let out = files.name("page");
        let page = data("page.png");
        let fixed = [
            "render",
            "--patient",
            patient,
            "--scene",
            &page,
            "--panel",
            "view",
            "--size",
            "64x48",
            "--seconds",
            "0.1",
            "--fps",
            "10",
            "--out",
            &out,
        ];
        succeeds(&[&fixed, extra].concat());
        let trace = fs::read_to_string(files.path("page/trace.csv")).expect("a trace");
        let row = trace.lines().nth(1).expect("a row").to_owned();
        let fields: Vec<f64> = row
            .split(',')
            .map(|field| field.parse().expect("a number"))
            .collect();
        (fields[8], fields[5])
    };
    let near = ["--at", "0.4m", "--span", "21cm"];
    let (distance_m, young_d) = first_row("healthy-brown", &near);
    assert!((distance_m - 0.4).abs() < 1e-6, "{distance_m} m");
    let (_, old_d) = first_row("presbyope-60", &near);
    // 2.5 D are asked for; at 60 years half a dioptre is left.
    assert!(young_d > 1.8 && old_d < 0.8, "{young_d} and {old_d} D");
    assert!((first_row("healthy-brown", &[]).0 - 3.0).abs() < 1e-5);
}

#[test]
fn an_eye_without_corners_looks_at_what_is_ahead_and_about() {
    let _turn = turn();
    let files = Files::new();
    let mut wall = image::RgbImage::from_pixel(64, 48, image::Rgb([150, 150, 150]));
    looks_about(&files, "wall", &wall);
    // A single spot is no place to stay for ever.
    wall.put_pixel(30, 20, image::Rgb([0, 0, 0]));
    looks_about(&files, "spot", &wall);
}

fn looks_about(files: &Files, name: &str, picture: &image::RgbImage) {
    let wall = files.name(&format!("{name}.png"));
    picture.save(&wall).expect("saved");
    let out = files.name(&format!("out-{name}"));
    succeeds(&[
        "render",
        "--scene",
        &wall,
        "--at",
        "1m",
        "--panel",
        "view",
        "--size",
        "64x48",
        "--seconds",
        "4",
        "--fps",
        "5",
        "--seed",
        "2",
        "--out",
        &out,
    ]);
    let trace = fs::read_to_string(files.path(&format!("out-{name}/trace.csv"))).expect("a trace");
    let mut places = std::collections::BTreeSet::new();
    for row in trace.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let distance_m: f64 = fields[8].parse().expect("a number");
        assert!((distance_m - 1.0).abs() < 1e-5, "{row}");
        places.insert(fields[9].to_owned());
    }
    assert!(places.len() >= 4, "it looked at {} places", places.len());
}

#[test]
fn depth_pictures_as_tools_write_them() {
    let _turn = turn();
    let files = Files::new();
    let checks = data("depth/checks.png");
    let render = |depth: &str, extra: &[&str]| {
        let out = files.name("out");
        let depth = data(&format!("depth/{depth}"));
        let fixed = [
            "render",
            "--scene",
            &checks,
            "--depth",
            &depth,
            "--panel",
            "view",
            "--size",
            "96x64",
            "--seconds",
            "0.1",
            "--fps",
            "10",
            "--patient",
            "myope-3d",
            "--out",
            &out,
        ];
        succeeds(&[&fixed, extra].concat());
        let report = fs::read_to_string(files.path("out/report.json")).expect("a report");
        let frame = image::open(files.path("out/frame_00000.png"))
            .expect("a frame")
            .to_rgb8();
        (frame, report)
    };
    let (grey, _) = render("inverse_grey8.png", &["--depth-near", "0.35m"]);
    let (rgb, _) = render("inverse_grey_as_rgb8.png", &["--depth-near", "0.35m"]);
    assert_eq!(grey, rgb);
    let mean_off = |a: &image::RgbImage, b: &image::RgbImage| {
        let sum: u64 = a
            .as_raw()
            .iter()
            .zip(b.as_raw())
            .map(|(a, b)| u64::from(a.abs_diff(*b)))
            .sum();
        sum as f64 / a.as_raw().len() as f64
    };
    let (millimetres, _) = render("millimetres_16.png", &["--depth-unit", "mm"]);
    let (guessed, report) = render("millimetres_16.png", &[]);
    assert_eq!(millimetres, guessed);
    assert!(report.contains("read as millimetres"), "{report}");
    // 8-bit codes are 0.01 D apart: a tenth of a pixel of blur. White at 0.5 m is another picture.
    let (other, report) = render("inverse_grey8.png", &[]);
    assert!(report.contains("read as inverse"), "{report}");
    let (same, wrong) = (mean_off(&grey, &millimetres), mean_off(&grey, &other));
    assert!(same < 0.5 && wrong > 2.0 * same, "{same} and {wrong} codes");
}

#[test]
fn marks_of_editors_pass_and_control_characters_do_not() {
    let files = Files::new();
    let marked = files.write("marked.ron", b"\xef\xbb\xbf(name: \"Ann\")");
    assert!(said(&["check", &marked]).contains("sound"));
    let coloured = files.write("coloured.ron", b"(name: \"\x1b[31mAnn\")");
    refused(&["check", &coloured], &["coloured.ron", "name", "control"]);
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_refused_at_once() {
    let files = Files::new();
    let pipe = files.name("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo").success());
    for path in ["/dev/zero", &pipe] {
        refused(&["check", path], &[path, "pipe or a device"]);
        refused(
            &["features", path, "--threshold", "9"],
            &[path, "pipe or a device"],
        );
        render_refused(&["--scene", path], &[path, "pipe or a device"]);
    }
}

#[cfg(unix)]
#[test]
fn a_run_that_is_ended_leaves_its_trace_and_keeps_others_out() {
    let _turn = turn();
    let files = Files::new();
    let out = files.name("out");
    let long = [
        "render",
        "--out",
        &out,
        "--size",
        "64x32",
        "--seconds",
        "3000",
        "--fps",
        "20",
    ];
    // Of a longer run before; who stops this one may want it.
    let longer = files.path("out/frame_50000.png");
    for signal in ["-TERM", "-HUP"] {
        fs::create_dir_all(&out).expect("a folder");
        fs::write(&longer, "a picture").expect("written");
        fs::write(
            files.path("out/report.json"),
            r#"{"version": "0.1.0", "fps": 20, "frames": 60000}"#,
        )
        .expect("written");
        let mut running = program(&long)
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("it starts");
        let started = Instant::now();
        while !files.path("out/frame_00002.png").exists() {
            assert!(started.elapsed() < Duration::from_secs(240), "no frame");
            std::thread::sleep(Duration::from_millis(50));
        }
        refused(&long, &["cannot write", "another run"]);
        let pid = running.id().to_string();
        let sent = std::process::Command::new("kill")
            .args([signal, &pid])
            .status();
        assert!(sent.expect("kill").success());
        let status = running.wait().expect("it ends");
        assert_eq!(status.code(), Some(130), "{signal}");
        let trace = fs::read_to_string(files.path("out/trace.csv")).expect("a trace");
        assert!(trace.lines().count() >= 4);
        assert!(
            fs::read_to_string(files.path("out/report.json"))
                .expect("a report")
                .contains("\"interrupted\": true")
        );
        assert!(longer.exists(), "a frame of the longer run is gone");
        let report = fs::read_to_string(files.path("out/report.json")).expect("a report");
        assert!(
            report.contains("1 more frame of an earlier run"),
            "{report}"
        );
        assert!(!files.path("out/.ocularium-lock").exists());
        fs::remove_dir_all(&out).expect("removed");
    }
}

#[test]
fn an_interrupted_bench_keeps_nothing_and_says_so() {
    let _turn = turn();
    let files = Files::new();
    let out = files.name("bench");
    let running = program(&["bench", "--quick", "--out", &out])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    while !files.path("bench/.ocularium-lock").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_secs(2));
    refused(
        &["bench", "--quick", "--out", &out],
        &["cannot write", "another run"],
    );
    let sent = std::process::Command::new("kill")
        .args(["-TERM", &running.id().to_string()])
        .status();
    assert!(sent.expect("kill").success());
    let output = running.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    assert!(text(&output.stderr).contains("nothing was kept"));
    assert_eq!(fs::read_dir(&out).expect("the folder").count(), 0);
}

/// A name that is not UTF-8 is a name all the same.
#[cfg(target_os = "linux")]
#[test]
fn paths_need_not_be_utf_8() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let _turn = turn();
    let files = Files::new();
    let odd = |name: &[u8]| files.path("x").with_file_name(OsStr::from_bytes(name));
    let (patient, scene) = (odd(b"ann\xff.ron"), odd(b"page\xe9.png"));
    fs::write(&patient, "(name: \"Ann\")").expect("written");
    fs::copy(data("page.png"), &scene).expect("copied");
    let depth = odd(b"depth\xe9.png");
    fs::copy(data("page.png"), &depth).expect("copied");
    let (out, table) = (odd(b"out\xfe"), odd(b"mtf\xfe.json"));
    let run = |arguments: &[&OsStr]| {
        let mut command = program(&[]);
        let output = command.args(arguments).output().expect("it starts");
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let plain = OsStr::new;
    assert!(run(&[plain("check"), patient.as_os_str()]).contains("is sound: Ann"));
    let features = [
        plain("features"),
        scene.as_os_str(),
        plain("--threshold"),
        plain("200"),
    ];
    assert!(run(&features).starts_with("x,y,score"));
    run(&[
        plain("render"),
        plain("--patient"),
        patient.as_os_str(),
        plain("--scene"),
        scene.as_os_str(),
        plain("--depth"),
        depth.as_os_str(),
        plain("--panel"),
        plain("view"),
        plain("--size"),
        plain("32x32"),
        plain("--seconds"),
        plain("0.1"),
        plain("--out"),
        out.as_os_str(),
    ]);
    assert!(out.join("report.json").is_file());
    run(&[
        plain("measure"),
        plain("glare"),
        plain("--out"),
        table.as_os_str(),
    ]);
    assert!(table.is_file());
    let error = program(&["check"])
        .arg(odd(b"no\xff.ron"))
        .output()
        .expect("it starts");
    assert_eq!(error.status.code(), Some(1));
    assert!(text(&error.stderr).contains("cannot read patient file"));
}

#[test]
fn a_view_without_anything_in_it_is_said() {
    let _turn = turn();
    let files = Files::new();
    let model = |looks: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0,1]}}],
            "nodes":[{{"mesh":0}},{{"camera":0{looks}}}],
            "cameras":[{{"type":"perspective","perspective":{{"yfov":0.9,"znear":0.01}}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "buffers":[{{"byteLength":36,"uri":"tri.bin"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,-2],"max":[1,1,-2]}}]}}"#
        )
    };
    let corners = [-1.0f32, -1.0, -2.0, 1.0, -1.0, -2.0, 0.0, 1.0, -2.0];
    let corners: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(files.path("tri.bin"), corners).expect("written");
    // A camera looks along its own −z: at the triangle, or, turned about, away from it.
    for (name, turned, is_said) in [
        ("at.gltf", "", false),
        ("away.gltf", r#","rotation":[0,1,0,0]"#, true),
    ] {
        fs::write(files.path(name), model(turned)).expect("written");
        let (scene, out) = (files.name(name), files.name("out"));
        let output = run(&[
            "render",
            "--scene",
            &scene,
            "--panel",
            "view",
            "--size",
            "48x48",
            "--seconds",
            "0.1",
            "--out",
            &out,
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let report = fs::read_to_string(files.path("out/report.json")).expect("a report");
        for said in [text(&output.stderr), report] {
            assert_eq!(said.contains("is in the view"), is_said, "{name}: {said}");
        }
    }
}

/// Whoever plays a film does not lose it.
#[test]
fn a_film_of_somebody_elses_is_shown_and_not_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    let film = folder.path().join("film");
    fs::create_dir(&film).expect("a folder");
    for index in 0..3u8 {
        let picture = image::RgbImage::from_pixel(32, 24, image::Rgb([80 * index, 90, 30]));
        let name = format!("frame_{index:05}.png");
        picture.save(film.join(name)).expect("saved");
    }
    let before = fs::read(film.join("frame_00000.png")).expect("read");
    let film = film.display().to_string();
    let render = |scene: &str, rest: &[&str]| -> Vec<String> {
        let small = ["--panel", "view", "--size", "32x24", "--seconds", "0.1"];
        let all = [&["render", "--scene", scene][..], &small, rest].concat();
        all.into_iter().map(str::to_owned).collect()
    };
    fn as_texts(all: &[String]) -> Vec<&str> {
        all.iter().map(String::as_str).collect()
    }
    refused(
        &as_texts(&render(&film, &["--out", &film])),
        &["film", "the folder of the scene"],
    );
    // Nor by another run.
    refused(
        &as_texts(&render("chart", &["--out", &film])),
        &["frame_00000.png", "no report"],
    );
    assert_eq!(
        fs::read(format!("{film}/frame_00000.png")).expect("read"),
        before
    );
    // And it is seen, once and again.
    let out = folder.path().join("out").display().to_string();
    let _turn = turn();
    for _ in 0..2 {
        succeeds(&as_texts(&render(
            &film,
            &["--scene-fps", "30", "--out", &out],
        )));
    }
    misused(
        &as_texts(&render(&film, &["--scene-fps", "0", "--out", &out])),
        "0.1 to 240",
    );
    let still = data("page.png");
    refused(
        &[
            "render",
            "--scene",
            &still,
            "--scene-fps",
            "5",
            "--out",
            &out,
        ],
        &["--scene-fps", "page.png"],
    );
}
