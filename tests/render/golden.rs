//! Crops of the picture as they were approved, and controls one small step away that are refused.
//!
//! One moment: seed 7, half a second after the eye was told to look at the chart on the wall, its
//! pupil held at 4 mm. `OCULARIUM_BLESS=1` approves what is drawn.

use super::picture;
use crate::stage::{look, luma_at, open, patient, session, settle, turn, without_blinks};
use bevy::math::UVec2;
use image::imageops::crop_imm;
use image::{Rgba, RgbaImage};
use ocularium::anatomy::IrisColor;
use ocularium::appearance::{EyeLight, Studio};
use ocularium::lab::headless::{Headless, Which};
use ocularium::lab::image_difference::{Difference, Limits, difference_picture};
use ocularium::lab::render::encode_png;
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::stage::SessionCommand;
use std::path::{Path, PathBuf};

const EYE_SIZE: u32 = 720;
const VIEW_SIZE: u32 = 640;

/// Drawn again, in the same process or another, a crop differs by nothing at all: measured on Mesa
/// 22.3's llvmpipe. The limits are for another version's roundings: one code value at one pixel of
/// twenty; two at one of a thousand, for the sum of a few roundings; and at single pixels one sample
/// of four that falls on the other side of a black and white edge, 255/4.
const LIMITS: Limits = Limits {
    mean: 0.05,
    percentile_999: 2,
    max: 64,
};

/// Where the pupil is seen in the eye's panel: its middle, its radius and the iris's, pixels.
const PUPIL_AT: [f64; 2] = [377.0, 330.0];
const PUPIL_RADIUS: f64 = 39.0;
const IRIS_RADIUS: f64 = 96.0;
/// Luma over which a pixel of the cornea is a reflection: the iris stays under 190.
const REFLECTION_LUMA: f64 = 200.0;

/// The eye's panel and the view's.
type Drawn = [RgbaImage; 2];

/// A part of a panel.
struct Crop {
    name: &'static str,
    panel: Which,
    /// Column and row of its corner, width and height.
    at: [u32; 4],
}

const fn crop(name: &'static str, panel: Which, at: [u32; 4]) -> Crop {
    Crop { name, panel, at }
}

const CROPS: [Crop; 7] = [
    crop("iris", Which::Eye, [270, 230, 210, 190]),
    crop("pupil", Which::Eye, [325, 280, 100, 100]),
    crop("reflection", Which::Eye, [320, 275, 60, 60]),
    crop("lid-margin", Which::Eye, [250, 420, 220, 70]),
    crop("canthus", Which::Eye, [500, 310, 150, 110]),
    crop("view-centre", Which::View, [200, 120, 190, 150]),
    crop("view-edge", Which::View, [0, 300, 160, 150]),
];

impl Crop {
    fn of(&self, [eye, view]: &Drawn) -> RgbaImage {
        let [x, y, width, height] = self.at;
        let panel = if self.panel == Which::Eye { eye } else { view };
        crop_imm(panel, x, y, width, height).to_image()
    }
}

/// What is drawn at the approved moment.
#[derive(Clone)]
struct Moment {
    patient: PatientFile,
    gaze_deg: [f64; 2],
    /// Turn of the window about the vertical.
    lamp_deg: f32,
}

impl Default for Moment {
    fn default() -> Self {
        let mut patient = patient("healthy-blue");
        patient.pupil = PupilSetting::Fixed(4.0);
        Self {
            patient,
            gaze_deg: [-5.4, 11.1],
            lamp_deg: 0.0,
        }
    }
}

impl Moment {
    fn draw(&self, headless: &mut Headless) -> Drawn {
        let studio = Studio {
            turn_deg: self.lamp_deg,
            ..Studio::default()
        };
        let model = headless.stage().model;
        headless
            .world()
            .entity_mut(model)
            .insert(EyeLight::Studio(studio));
        headless.command(SessionCommand::Patient(Box::new(self.patient.clone())));
        // Only what is seen has a past; the eye is drawn once, at the end.
        headless.show([false, true]);
        headless.go_to(0.0);
        settle(headless);
        without_blinks(headless);
        look(headless, self.gaze_deg[0], self.gaze_deg[1], 6.2);
        for time_s in [0.01, 0.25, 0.5] {
            headless.go_to(time_s);
        }
        headless.show([true; 2]);
        settle(headless);
        [Which::Eye, Which::View].map(|which| picture(headless, which))
    }
}

/// A change, and the crops that must refuse it.
type Control = (&'static str, fn(&mut Moment), &'static [&'static str]);

const EYE_CROPS: &[&str] = &["iris", "pupil", "reflection", "lid-margin", "canthus"];

const CONTROLS: [Control; 5] = [
    (
        "pupil +0.3 mm",
        |m| m.patient.pupil = PupilSetting::Fixed(4.3),
        &["iris", "pupil", "reflection", "view-edge"],
    ),
    ("window turned 5°", |m| m.lamp_deg = 5.0, EYE_CROPS),
    (
        "green for blue",
        |m| m.patient.iris_color = IrisColor::Green,
        &["iris", "pupil", "reflection"],
    ),
    (
        "-0.25 D",
        |m| m.patient.sphere_d = -0.25,
        &["view-centre", "view-edge"],
    ),
    (
        "gaze 1°",
        |m| m.gaze_deg[0] += 1.0,
        &[
            "iris",
            "pupil",
            "reflection",
            "lid-margin",
            "canthus",
            "view-centre",
        ],
    ),
];

/// A defect painted into the eye's panel, and the crops that must refuse it.
type Defect = (&'static str, fn(&mut RgbaImage), &'static [&'static str]);

const DEFECTS: [Defect; 3] = [
    (
        "pupil painted over",
        |eye| repaint(eye, |radius, _| radius <= PUPIL_RADIUS + 1.0, mean_of_iris),
        &["iris", "pupil", "reflection"],
    ),
    (
        "reflections removed",
        |eye| {
            let bright = |radius, luma| radius < IRIS_RADIUS && luma > REFLECTION_LUMA;
            repaint(eye, bright, mean_of_iris);
        },
        &["iris", "pupil", "reflection"],
    ),
    (
        "iris made grey",
        |eye| {
            let on_iris = |radius, _| radius > PUPIL_RADIUS && radius < IRIS_RADIUS;
            repaint(eye, on_iris, |_, luma| [luma.round() as u8; 3]);
        },
        &["iris", "pupil", "reflection"],
    ),
];

/// Gives the pixels that `chosen` takes by distance from the pupil's middle and luma a colour.
fn repaint(
    eye: &mut RgbaImage,
    chosen: impl Fn(f64, f64) -> bool,
    colour: impl Fn(&RgbaImage, f64) -> [u8; 3],
) {
    let old = eye.clone();
    let mut painted = 0;
    for (x, y, pixel) in eye.enumerate_pixels_mut() {
        let (across, down) = (f64::from(x) - PUPIL_AT[0], f64::from(y) - PUPIL_AT[1]);
        let luma = luma_at(&old, x, y);
        if chosen(across.hypot(down), luma) {
            let [r, g, b] = colour(&old, luma);
            *pixel = Rgba([r, g, b, 255]);
            painted += 1;
        }
    }
    assert!(painted > 100, "only {painted} pixels were painted");
}

/// A colour of the iris, whatever the luma there was.
fn mean_of_iris(eye: &RgbaImage, _: f64) -> [u8; 3] {
    let below = PUPIL_AT[1] + 0.5 * (PUPIL_RADIUS + IRIS_RADIUS);
    let pixel = eye.get_pixel(PUPIL_AT[0] as u32, below as u32);
    [pixel[0], pixel[1], pixel[2]]
}

fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.png"))
}

fn golden(crop: &Crop) -> RgbaImage {
    let path = golden_path(crop.name);
    image::open(&path)
        .unwrap_or_else(|error| panic!("{}: {error}; OCULARIUM_BLESS=1 writes it", path.display()))
        .to_rgba8()
}

fn save(path: &Path, picture: &RgbaImage) {
    let folder = path.parent().expect("a folder");
    std::fs::create_dir_all(folder).expect("a folder for pictures");
    std::fs::write(path, encode_png(picture).expect("a PNG")).expect("a written picture");
}

/// How far a crop is from what was approved.
fn difference(crop: &Crop, drawn: &Drawn) -> Difference {
    Difference::between(&golden(crop), &crop.of(drawn))
        .unwrap_or_else(|| panic!("{} was approved at another size", crop.name))
}

/// Are all crops the approved ones? Leaves what differs, and the difference.
fn assert_approved(drawn: &Drawn, adapter: &str) {
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("out/golden");
    let mut refused = Vec::new();
    for crop in &CROPS {
        let found = difference(crop, drawn);
        if !found.keeps(&LIMITS) {
            let (old, new) = (golden(crop), crop.of(drawn));
            save(&out.join(format!("{}-actual.png", crop.name)), &new);
            let apart = difference_picture(&old, &new);
            save(&out.join(format!("{}-difference.png", crop.name)), &apart);
            refused.push(format!("{}: {found:?}", crop.name));
        }
    }
    assert!(
        refused.is_empty(),
        "on {adapter}, {LIMITS:?} exceeded; see {}: {refused:#?}",
        out.display()
    );
}

/// Do the crops that a change concerns refuse it?
fn assert_refused(name: &str, drawn: &Drawn, by: &[&str]) {
    for crop in &CROPS {
        let found = difference(crop, drawn);
        let (mean, high, max) = (found.mean, found.percentile_999, found.max);
        println!("{name:20} {:12} {mean:7.3} {high:4} {max:4}", crop.name);
        assert!(
            !by.contains(&crop.name) || !found.keeps(&LIMITS),
            "{name}: {} does not refuse {found:?}",
            crop.name
        );
    }
}

#[test]
fn the_crops_are_the_approved_ones_and_refuse_what_is_one_step_away() {
    let _turn = turn();
    let sizes = [EYE_SIZE, VIEW_SIZE].map(UVec2::splat);
    let session = session(patient("healthy-brown"), 7);
    let mut headless = open(session, sizes[0], sizes[1], [true; 2]);
    let drawn = Moment::default().draw(&mut headless);
    if std::env::var_os("OCULARIUM_BLESS").is_some_and(|value| value == "1") {
        for crop in &CROPS {
            save(&golden_path(crop.name), &crop.of(&drawn));
        }
    }
    assert_approved(&drawn, &headless.adapter());
    for (name, paint, by) in DEFECTS {
        let mut defective = drawn.clone();
        paint(&mut defective[0]);
        assert_refused(name, &defective, by);
    }
    for (name, change, by) in CONTROLS {
        let mut moment = Moment::default();
        change(&mut moment);
        assert_refused(name, &moment.draw(&mut headless), by);
    }
    // The changes were refused for what they are, not for what the ones before left behind.
    let again = Moment::default().draw(&mut headless);
    assert_approved(&again, &headless.adapter());
    let names = CONTROLS.map(|control| control.2).concat();
    assert!(CROPS.iter().all(|crop| names.contains(&crop.name)));
}
