//! What is rendered: the same for the same seed at every frame rate, both panels on one clock, the
//! pictures as they were approved, and something to see for every legal patient.

mod artists;
mod foreshortening;
mod golden;

use crate::stage::{
    command, engine, foresee, look, luma_at, mean, open, patient, session, settle, statistics,
    turn, without_blinks,
};
use bevy::math::UVec2;
use image::RgbaImage;
use ocularium::anatomy::Laterality;
use ocularium::appearance::{EyeOrbit, EyeQuality, EyeShading};
use ocularium::lab::headless::{Headless, Which};
use ocularium::lab::image_difference::{Difference, difference_picture};
use ocularium::lab::render::{PanelChoice, RenderRequest, render};
use ocularium::motion::MotionCommand;
use ocularium::motion::engine::GazeCommand;
use ocularium::motion::trace::{HEADER, TraceRow};
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::percept::ViewOptions;
use ocularium::stage::SessionCommand;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Millimetres from the middle of the eye's panel to its edge, at the pupil: the camera stands
/// 95 mm + 1.5 mm before it and shows 12.5° to each side.
const HALF_WIDTH_MM: f64 = 21.4;

fn picture(headless: &Headless, which: Which) -> RgbaImage {
    headless
        .panel(which)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn request(out: &Path) -> RenderRequest {
    RenderRequest {
        head_path: None,
        panels: PanelChoice::Both,
        size: UVec2::new(128, 64),
        seconds: 0.8,
        fps: 10.0,
        quality: EyeQuality::default(),
        orbit: EyeOrbit::default(),
        options: ViewOptions::default(),
        out: out.to_owned(),
        arguments: Vec::new(),
    }
}

#[test]
fn the_same_seed_writes_the_same_trace() {
    let _turn = turn();
    let traces = [7, 7, 8].map(|seed| {
        let folder = tempfile::tempdir().expect("a folder");
        let request = request(folder.path());
        let session = session(patient("healthy-brown"), seed);
        let report = render(session, &request, &AtomicBool::new(false), |_, _| {})
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((report.frames, report.interrupted), (8, false));
        assert!(
            report.candidates > 0,
            "the eye has something to choose from"
        );
        for frame in 0..8 {
            let path = folder.path().join(format!("frame_{frame:05}.png"));
            let size = image::open(&path).expect("a PNG").to_rgb8().dimensions();
            assert_eq!(size, (128, 64));
        }
        std::fs::read_to_string(folder.path().join("trace.csv")).expect("a trace")
    });
    assert_eq!(traces[0], traces[1]);
    assert_ne!(traces[0], traces[2], "another seed, another life");
    // With more that may be looked at, and with less, it looks elsewhere.
    let found = [5, 80].map(|threshold| {
        let folder = tempfile::tempdir().expect("a folder");
        let request = RenderRequest {
            options: ViewOptions {
                threshold,
                ..ViewOptions::default()
            },
            ..request(folder.path())
        };
        let session = session(patient("healthy-brown"), 7);
        render(session, &request, &AtomicBool::new(false), |_, _| {})
            .unwrap_or_else(|error| panic!("{error}"))
            .candidates
    });
    assert!(found[0] > 2 * found[1], "{found:?} corners");
    let mut lines = traces[0].lines();
    assert_eq!(lines.next(), Some(HEADER));
    let times: Vec<&str> = lines.filter_map(|line| line.split(',').next()).collect();
    let expected: Vec<String> = (0..8)
        .map(|k| format!("{:.9}", f64::from(k) / 10.0))
        .collect();
    assert_eq!(times, expected);
}

#[test]
fn a_fast_picture_is_nearly_a_full_one() {
    let _turn = turn();
    let full = EyeQuality::default();
    let fast_iris = EyeQuality {
        shading: EyeShading::Fast,
        ..full
    };
    let [fast, fast_iris, full] = [EyeQuality::PLAIN, fast_iris, full].map(|quality| {
        let folder = tempfile::tempdir().expect("a folder");
        let request = RenderRequest {
            panels: PanelChoice::Eye,
            size: UVec2::splat(160),
            seconds: 0.1,
            quality,
            ..request(folder.path())
        };
        let session = session(patient("healthy-brown"), 7);
        let report = render(session, &request, &AtomicBool::new(false), |_, _| {})
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(report.quality, Some(quality.shading.name()));
        let picture = image::open(folder.path().join("frame_00000.png"));
        picture.expect("a PNG").to_rgb8()
    });
    let apart = |picture: &image::RgbImage| {
        let off = picture.iter().zip(full.iter());
        let off: u64 = off.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        off as f64 / picture.len() as f64
    };
    let [samples, iris] = [apart(&fast), apart(&fast_iris)];
    println!("fast is {samples:.3} code values off full, its iris alone {iris:.4}");
    // Another iris, a tenth of the picture, by its march alone; with one sample in place of four lashes and edges too.
    assert!(iris > 1e-3 && iris < 0.2, "{iris}");
    assert!(samples > 5.0 * iris && samples < 4.0, "{samples} {iris}");
}

/// Every number of a row.
fn numbers(row: &TraceRow) -> [f64; 14] {
    [
        row.time_s,
        row.gaze_azimuth_deg,
        row.gaze_elevation_deg,
        row.gaze_torsion_deg,
        row.pupil_mm,
        row.accommodation_d,
        row.lid_aperture,
        f64::from(u8::from(row.blinking)),
        row.fixation_distance_m,
        row.fixation_azimuth_deg,
        row.fixation_elevation_deg,
        f64::from(u8::from(row.in_saccade)),
        row.fixation_index as f64,
        row.blink_epoch as f64,
    ]
}

/// Restarts with a seed and runs 3 s; the rows of every sixth of a second.
fn run(headless: &mut Headless, seed: u64, fps: u32) -> Vec<TraceRow> {
    headless.command(SessionCommand::Restart(seed));
    let mut rows = Vec::new();
    for frame in 0..=3 * fps {
        headless.go_to(f64::from(frame) / f64::from(fps));
        if frame % (fps / 6) == 0 {
            rows.push(TraceRow::from(&headless.state()));
        }
    }
    rows
}

fn differ(a: &[TraceRow], b: &[TraceRow]) -> Option<String> {
    assert_eq!(a.len(), b.len());
    let apart = |p: f64, q: f64| p != q && ((p - q).is_nan() || (p - q).abs() > 1e-6);
    let row = a.iter().zip(b).find(|(a, b)| {
        let mut pairs = numbers(a).into_iter().zip(numbers(b));
        pairs.any(|(p, q)| apart(p, q))
    })?;
    Some(format!("{row:?}"))
}

#[test]
fn the_frame_rate_does_not_change_the_life_of_the_eye() {
    let _turn = turn();
    let mut headless = open(
        session(patient("healthy-brown"), 11),
        UVec2::splat(16),
        UVec2::splat(96),
        [false, true],
    );
    settle(&mut headless);
    let slow = run(&mut headless, 11, 30);
    let last = slow.last().expect("rows");
    assert!(last.fixation_index >= 3, "the eye looked about: {last:?}");
    for fps in [60, 144] {
        let fast = run(&mut headless, 11, fps);
        assert_eq!(differ(&slow, &fast), None, "{fps} frames/s");
    }
    assert!(
        differ(&slow, &run(&mut headless, 12, 30)).is_some(),
        "another seed, another life"
    );
}

/// Pixels within `radius_mm` of where the middle of the pupil is seen (the camera straight ahead).
fn around_pupil(size: u32, gaze_rad: [f64; 2], radius_mm: f64) -> impl Fn(u32, u32) -> bool {
    let scale = f64::from(size) / (2.0 * HALF_WIDTH_MM);
    // The pupil's image lies about 9.3 mm before the centre of rotation; who looks at the patient
    // has the patient's right on the left.
    let x = 0.5 * f64::from(size) - 9.3 * scale * gaze_rad[0].sin() * gaze_rad[1].cos();
    let y = 0.5 * f64::from(size) - 9.3 * scale * gaze_rad[1].sin();
    move |px, py| {
        let (dx, dy) = (f64::from(px) + 0.5 - x, f64::from(py) + 0.5 - y);
        dx.hypot(dy) <= radius_mm * scale
    }
}

/// Middle value of the luma there: a highlight or a lash does not decide it.
fn median(picture: &RgbaImage, chosen: impl Fn(u32, u32) -> bool) -> f64 {
    let mut values: Vec<f64> = picture
        .enumerate_pixels()
        .filter(|(x, y, _)| chosen(*x, *y))
        .map(|(x, y, _)| luma_at(picture, x, y))
        .collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn both_panels_follow_one_clock() {
    let _turn = turn();
    let size = UVec2::splat(160);
    let mut headless = open(session(patient("healthy-blue"), 3), size, size, [true; 2]);
    look(&mut headless, 0.0, 0.0, 3.0);
    headless.go_to(0.1);
    headless.go_to(1.0);
    a_blink_closes_the_lids_and_darkens_the_view(&mut headless);
    without_blinks(&mut headless);
    command(&mut headless, GazeCommand::Auto);
    a_saccade_turns_the_globe_and_moves_the_fixation(&mut headless);
}

fn a_blink_closes_the_lids_and_darkens_the_view(headless: &mut Headless) {
    // The next spontaneous blink that closes the lids; a closure lasts 8.3 ms.
    let mut future = engine(headless);
    let closed = foresee(&mut future, 1.2, 120.0, 0.004, |s| s.lid_aperture == 0.0);
    let iris = around_pupil(160, [0.0; 2], 5.0);
    let pupil = || around_pupil(160, [0.0; 2], 1.0);

    headless.go_to(closed.time_s - 0.12);
    assert!(!headless.state().blinking);
    let [open_eye, lit] = [Which::Eye, Which::View].map(|which| picture(headless, which));
    assert!(
        mean(&lit) > 40.0,
        "an open view has a mean of {}",
        mean(&lit)
    );
    assert!(
        median(&open_eye, pupil()) < 50.0,
        "{}",
        median(&open_eye, pupil())
    );

    headless.go_to(closed.time_s);
    let state = headless.state();
    assert_eq!((state.lid_aperture, state.blinking), (0.0, true));
    let [closed_eye, dark] = [Which::Eye, Which::View].map(|which| picture(headless, which));
    // A little red light comes through the lids.
    assert!(
        mean(&dark) < 8.0,
        "a closed view has a mean of {}",
        mean(&dark)
    );
    let change = difference_picture(&open_eye, &closed_eye);
    // The difference picture is eight times as strong: 15 steps of 255 and more.
    assert!(
        statistics(&change, iris).0 > 120.0,
        "the lids cover the iris"
    );
    let shown = median(&closed_eye, pupil());
    assert!(
        shown > median(&open_eye, pupil()) + 25.0,
        "the pupil shows through: {shown}"
    );

    // The next blink cannot begin before this time.
    headless.go_to(closed.time_s + 0.15);
    assert!(!headless.state().blinking);
    assert!(
        mean(&picture(headless, Which::View)) > 40.0,
        "the view is lit again"
    );
}

fn a_saccade_turns_the_globe_and_moves_the_fixation(headless: &mut Headless) {
    let from_s = headless.state().time_s;
    let mut future = engine(headless);
    // The command to look about is obeyed in the next frame: foresee from there.
    headless.go_to(from_s + 0.01);
    future
        .command(from_s + 0.01, GazeCommand::Auto)
        .expect("a sound command");
    let departure = foresee(&mut future, from_s + 0.02, 60.0, 0.001, |s| {
        let across = s.fixation_azimuth_rad - s.gaze_azimuth_rad;
        let up = s.fixation_elevation_rad - s.gaze_elevation_rad;
        s.in_saccade && !s.blinking && across.hypot(up) > 5f64.to_radians()
    });
    let moments = [-0.01, 0.015, 0.12].map(|after_s| {
        headless.go_to(departure.time_s + after_s);
        let frame = headless.frame().clone();
        (headless.state(), frame, picture(headless, Which::Eye))
    });
    for (state, frame, _) in &moments {
        let (azimuth, elevation) = (state.gaze_azimuth_rad, state.gaze_elevation_rad);
        let gaze = [
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            -azimuth.cos() * elevation.cos(),
        ];
        for (shown, expected) in frame.uniform.fixation.iter().zip(gaze) {
            // The uniform is the state's direction, rounded to f32.
            assert!((f64::from(*shown) - expected).abs() < 1e-6, "{state:?}");
        }
    }
    let [before, during, after] = &moments;
    assert!(!before.0.in_saccade && during.0.in_saccade && !after.0.in_saccade);
    assert!(!during.1.update, "vision is suppressed in flight");
    for (earlier, later) in [(before, during), (during, after)] {
        assert_ne!(earlier.1.uniform.fixation, later.1.uniform.fixation);
        let change = Difference::between(&earlier.2, &later.2).expect("one size");
        // Found: 2.2 in flight and 6.4 after it; 0 where nothing turned.
        assert!(change.mean > 1.0, "the globe turned: {change:?}");
    }
    // It turned to where the fixation is.
    let gaze = [after.0.gaze_azimuth_rad, after.0.gaze_elevation_rad];
    let shown = median(&after.2, around_pupil(160, gaze, 1.0));
    assert!(
        shown < 50.0,
        "no pupil where the eye looks: {shown} at {gaze:?}"
    );
}

/// A patient, a gaze (°) and a place of the camera (°).
type Extreme = (&'static str, fn(&mut PatientFile), [f64; 2], [f32; 2]);

const EXTREMES: [Extreme; 9] = [
    (
        "pupil 1 mm",
        |p| p.pupil = PupilSetting::Fixed(1.0),
        [0.0, 0.0],
        [0.0, 0.0],
    ),
    (
        "pupil 9 mm",
        |p| p.pupil = PupilSetting::Fixed(9.0),
        [0.0, 0.0],
        [0.0, 0.0],
    ),
    ("-20 D", |p| p.sphere_d = -20.0, [5.0, 5.0], [0.0, 0.0]),
    ("+20 D", |p| p.sphere_d = 20.0, [-5.0, -5.0], [0.0, 0.0]),
    ("far right and up", |_| (), [50.0, 40.0], [0.0, 0.0]),
    ("far left and down", |_| (), [-50.0, -45.0], [0.0, 0.0]),
    ("from the right", |_| (), [0.0, 0.0], [85.0, 0.0]),
    (
        "from the left",
        |p| p.cornea_p = 0.2,
        [0.0, 0.0],
        [-85.0, 0.0],
    ),
    ("from above", |p| p.skin_tone = 1.0, [0.0, 0.0], [0.0, 80.0]),
];

#[test]
fn every_legal_patient_and_viewpoint_has_a_picture() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let mut headless = open(session(patient("healthy-blue"), 5), size, size, [true; 2]);
    let mut dark_pixels = Vec::new();
    for (name, change, gaze, orbit) in EXTREMES {
        let mut file = patient("healthy-blue");
        change(&mut file);
        file.check(name).unwrap_or_else(|error| panic!("{error}"));
        headless.command(SessionCommand::Patient(Box::new(file)));
        headless.go_to(0.0);
        settle(&mut headless);
        without_blinks(&mut headless);
        headless.set_orbit(EyeOrbit {
            azimuth_deg: orbit[0],
            elevation_deg: orbit[1],
            ..EyeOrbit::default()
        });
        look(&mut headless, gaze[0], gaze[1], 1.0);
        headless.go_to(0.01);
        headless.go_to(1.0);
        let eye = picture(&headless, Which::Eye);
        check_lit(name, "eye", &eye);
        check_lit(name, "view", &picture(&headless, Which::View));
        // What is not a number comes out black; nothing of an eye in a lit room is.
        let black = eye.pixels().filter(|p| p.0[..3] == [0; 3]).count();
        assert!(black <= 18, "{name}: {black} of 9216 pixels are black");
        let iris = around_pupil(96, [0.0; 2], 4.5);
        let dark = |(x, y, _): &(u32, u32, _)| iris(*x, *y) && luma_at(&eye, *x, *y) < 40.0;
        dark_pixels.push(eye.enumerate_pixels().filter(dark).count());
    }
    // 16 mm² and more are dark at 9 mm between the lids, and 1 mm² at 1 mm.
    assert!(dark_pixels[1] > 4 * dark_pixels[0] + 20, "{dark_pixels:?}");
    closed_lids_have_a_picture(&mut headless);
}

fn closed_lids_have_a_picture(headless: &mut Headless) {
    headless.set_orbit(EyeOrbit::default());
    headless.world().write_message(MotionCommand::Blink);
    headless.go_to(2.0);
    // A voluntary blink is closed from 77.6 to 91 ms.
    headless.go_to(2.084);
    assert_eq!(headless.state().lid_aperture, 0.0);
    check_lit("lids closed", "eye", &picture(headless, Which::Eye));
    assert!(mean(&picture(headless, Which::View)) < 8.0);
    assert!(headless.percept().is_captured());
}

fn check_lit(name: &str, panel: &str, picture: &RgbaImage) {
    let (mean, deviation) = statistics(picture, |_, _| true);
    assert!(
        mean > 12.0,
        "{name}: the {panel} is dark, with a mean of {mean}"
    );
    assert!(
        mean < 240.0,
        "{name}: the {panel} is white, with a mean of {mean}"
    );
    assert!(
        deviation > 6.0,
        "{name}: the {panel} is uniform, with a deviation of {deviation}"
    );
}

/// Skin must surround a left eye as it does a right one: its mesh is mirrored, and so is its winding.
#[test]
fn a_left_eye_lies_in_skin_like_a_right_one() {
    let _turn = turn();
    for eye in [Laterality::OD, Laterality::OS] {
        let patient = PatientFile {
            eye,
            ..patient("healthy-blue")
        };
        let headless = open(
            session(patient, 3),
            UVec2::splat(128),
            UVec2::splat(16),
            [true, false],
        );
        let drawn = picture(&headless, Which::Eye);
        for (x, y) in [(30, 100), (98, 100), (20, 40), (108, 40)] {
            let pixel = drawn.get_pixel(x, y);
            // The backdrop is grey; skin is bright and redder than blue.
            assert!(
                pixel[0] > 90 && pixel[0] > pixel[2] + 15,
                "{eye:?} at {x}, {y}: {pixel:?}"
            );
        }
    }
}
