//! A star is drawn as wide as pupil times defocus, and with all its light.
//!
//! The model stands a Gaussian for the pupil's disc, of the same variance: for a disc of diameter d
//! both have the second moment d²/8 about the middle. Half of a disc's light lies within d/√8, half
//! of that Gaussian's within 0.833 of it, d √(ln 2/8); this is what is asked of the picture.
//! A star here is one pixel, the hardest that can be drawn: light of a single texel.

use super::linear;
use crate::stage::{look, open, patient, settle, turn, without_blinks};
use bevy::math::UVec2;
use ocularium::lab::headless::{Headless, Which};
use ocularium::motion::MotionCommand;
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::percept::gather::{combined_blur, neural_blur};
use ocularium::percept::gpu_data::PerceptUniform;
use ocularium::scene::catalog::LoadedScene;
use ocularium::scene::model::{EyePlacement, SceneMaterial, SceneMesh, SceneModel};
use ocularium::stage::{Session, SessionCommand};
use std::sync::Arc;

/// Pixels along a side of the view, and the angle that they span.
pub const PIXELS: u32 = 240;
const SIDE: u32 = PIXELS;
const FIELD_DEG: f32 = 6.0;
/// Distance of the stars, m: a thousandth of a dioptre from infinity.
const FAR_M: f32 = 900.0;
/// The same, D.
pub const FAR_D: f64 = 1.0 / 900.0;
/// Linear light of the middle of a star's disc: well below the knee of the output transform, and
/// high enough that a code value is a few thousandths of it.
pub const PEAK: f64 = 0.5;
/// Of the luminance over the mean, what is shown of it.
const MIDDLE_GREY: f64 = 0.3;

const PUPILS_MM: [f64; 5] = [2.0, 3.0, 4.0, 5.0, 6.0];
const DEFOCI_D: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];

/// Shows a patient who looks straight ahead into the distance, and answers with the linear light of
/// every pixel of the view.
pub fn view_of(headless: &mut Headless, patient: PatientFile) -> Vec<f64> {
    headless.command(SessionCommand::Patient(Box::new(patient)));
    headless.go_to(0.0);
    settle(headless);
    without_blinks(headless);
    look(headless, 0.0, 0.0, f64::INFINITY);
    headless.go_to(0.01);
    headless.go_to(3.0);
    // A blink, so that nothing seen on the way there is remembered.
    headless.world().write_message(MotionCommand::Blink);
    for time_s in [3.05, 3.084, 3.15, 3.5] {
        headless.go_to(time_s);
    }
    let view = headless.panel(Which::View);
    let view = view.unwrap_or_else(|error| panic!("{error}"));
    view.pixels().map(|pixel| linear(pixel.0[1])).collect()
}

fn half_field() -> f64 {
    f64::from((0.5 * FIELD_DEG.to_radians()).tan())
}

/// Places of the four stars of a case, pixels: every case has them on other texels of the mips.
pub fn places(case: u32) -> [UVec2; 4] {
    [(60, 60), (180, 60), (60, 180), (180, 180)].map(|(x, y)| {
        let step = x / 60 + y / 30 + 7 * case;
        UVec2::new(x + (5 * step) % 16, y + (11 * step) % 16) - 8
    })
}

/// Eccentricity of a place's middle from straight ahead, rad.
fn eccentricity(place: UVec2) -> f64 {
    let off = |p: u32| (f64::from(p) + 0.5 - 0.5 * f64::from(SIDE)) / (0.5 * f64::from(SIDE));
    (half_field() * off(place.x).hypot(off(place.y))).atan()
}

pub fn pixels_per_rad() -> f64 {
    f64::from(SIDE) / (2.0 * half_field())
}

/// Diameter of the retina's blur at a place, pixels.
pub fn neural_px(place: UVec2) -> f64 {
    let retina = PerceptUniform::default();
    let neural = neural_blur(
        eccentricity(place),
        f64::from(retina.neural_floor_rad),
        f64::from(retina.eccentricity_e2_rad),
    );
    neural * pixels_per_rad()
}

/// Diameter of the blur that is claimed, pixels: the pupil's disc, and the retina's.
fn claimed_px(pupil_mm: f64, defocus_d: f64, place: UVec2) -> f64 {
    let defocus = 1e-3 * pupil_mm * (defocus_d - FAR_D);
    combined_blur(defocus * pixels_per_rad(), neural_px(place))
}

/// Stars of one pixel each before a black sky, as bright as makes their discs [`PEAK`].
pub fn sky(places: [UVec2; 4], diameter_px: f64) -> LoadedScene {
    let luminance = light(diameter_px) / MIDDLE_GREY;
    let star = |place: UVec2| {
        let at = |p: u32, d: f64| {
            let off = (f64::from(p) + 0.5 + d) / (0.5 * f64::from(SIDE)) - 1.0;
            (off * half_field()) as f32 * FAR_M
        };
        // The quad covers the centres of all texels of its pixel and no others.
        let corner = |dx: f64, dy: f64| [at(place.x, dx), -at(place.y, dy), -FAR_M];
        let d = 0.45;
        SceneMesh {
            name: "star".into(),
            positions: vec![corner(-d, -d), corner(-d, d), corner(d, d), corner(d, -d)],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..SceneMesh::default()
        }
    };
    LoadedScene::Model(Box::new(SceneModel {
        name: "stars".into(),
        meshes: places.map(star).to_vec(),
        materials: vec![SceneMaterial {
            base_color: [0.0, 0.0, 0.0, 1.0],
            emissive: [luminance as f32; 3],
            ..SceneMaterial::default()
        }],
        eye: EyePlacement {
            vertical_fov_deg: FIELD_DEG,
            horizontal_fov_deg: FIELD_DEG,
            ..EyePlacement::default()
        },
        mean_luminance_cd_m2: 1.0,
        ..SceneModel::default()
    }))
}

/// Light (pixels of linear light) of a star whose Gaussian reaches [`PEAK`].
fn light(diameter_px: f64) -> f64 {
    PEAK * std::f64::consts::TAU * (0.25 * diameter_px).powi(2)
}

/// What is measured of a star.
#[derive(Clone, Copy, Debug)]
struct Star {
    light: f64,
    /// Root of the second moment about the centroid, pixels.
    rms_px: f64,
    /// Radius about the centroid that holds half of the light, pixels.
    half_px: f64,
    /// From where the star is to the centroid, pixels.
    shift_px: f64,
}

/// Measures the light around a place: pixels of `value(x, y)` within 56 pixels.
fn measure(place: UVec2, value: impl Fn(u32, u32) -> f64) -> Star {
    let reach = 56;
    let mut pixels = Vec::new();
    for y in place.y.saturating_sub(reach)..(place.y + reach).min(SIDE) {
        for x in place.x.saturating_sub(reach)..(place.x + reach).min(SIDE) {
            let off = [x, y].map(f64::from);
            pixels.push((
                off[0] - f64::from(place.x),
                off[1] - f64::from(place.y),
                value(x, y),
            ));
        }
    }
    let light: f64 = pixels.iter().map(|p| p.2).sum();
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| {
        pixels.iter().map(|p| p.2 * f(p)).sum::<f64>() / light
    };
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let square = mean(&|p| (p.0 - x).powi(2) + (p.1 - y).powi(2));
    // Pixels are squares: each is cut into 8 × 8, so that the radius moves on smoothly.
    let mut parts: Vec<(f64, f64)> = pixels
        .iter()
        .flat_map(|p| {
            (0..64).map(move |k| {
                let cut = |i: i32| (f64::from(i) + 0.5) / 8.0 - 0.5;
                let (dx, dy) = (p.0 - x + cut(k % 8), p.1 - y + cut(k / 8));
                (dx.hypot(dy), p.2 / 64.0)
            })
        })
        .collect();
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut within = 0.0;
    let half = parts.iter().find(|(_, part)| {
        within += part;
        within >= 0.5 * light
    });
    Star {
        light,
        rms_px: square.sqrt(),
        half_px: half.map_or(0.0, |part| part.0),
        shift_px: x.hypot(y),
    }
}

/// The star that is claimed, measured in the same way.
fn claimed(place: UVec2, diameter_px: f64) -> Star {
    let variance = (0.25 * diameter_px).powi(2);
    measure(place, |x, y| {
        let (dx, dy) = (
            f64::from(x) - f64::from(place.x),
            f64::from(y) - f64::from(place.y),
        );
        PEAK * (-0.5 * (dx * dx + dy * dy) / variance).exp()
    })
}

fn myope(pupil_mm: f64, defocus_d: f64) -> PatientFile {
    PatientFile {
        pupil: PupilSetting::Fixed(pupil_mm),
        sphere_d: -defocus_d,
        ..patient("healthy-blue")
    }
}

/// Second moment, 50 % radius and light of what is drawn against what is claimed, less 1.
fn off(view: &[f64], place: UVec2, diameter_px: f64, light: f64) -> [f64; 3] {
    let drawn = measure(place, |x, y| view[(y * SIDE + x) as usize]);
    let claim = claimed(place, diameter_px);
    assert!(
        drawn.shift_px < 0.01 * diameter_px,
        "at {place} a star is drawn {} pixels away",
        drawn.shift_px
    );
    [
        drawn.rms_px / claim.rms_px - 1.0,
        drawn.half_px / claim.half_px - 1.0,
        drawn.light / light - 1.0,
    ]
}

#[test]
fn a_star_is_as_wide_as_pupil_times_defocus() {
    let _turn = turn();
    let session = Session::new(myope(4.0, 3.0), sky(places(0), 10.0), 1);
    let mut headless = open(session, UVec2::splat(16), UVec2::splat(SIDE), [false, true]);
    let mut worst = [0.0_f64; 3];
    for case in 0..25 {
        let (pupil_mm, defocus_d) = (PUPILS_MM[case / 5], DEFOCI_D[case % 5]);
        let places = places(case as u32);
        let brightness = claimed_px(pupil_mm, defocus_d, places[0]);
        let scene = Arc::new(sky(places, brightness));
        headless.command(SessionCommand::Scene(scene));
        let view = view_of(&mut headless, myope(pupil_mm, defocus_d));
        for place in places {
            let diameter_px = claimed_px(pupil_mm, defocus_d, place);
            let off = off(&view, place, diameter_px, light(brightness));
            (0..3).for_each(|i| worst[i] = worst[i].max(off[i].abs()));
            assert!(
                off[0].abs() < 0.02 && off[1].abs() < 0.02 && off[2].abs() < 0.005,
                "{pupil_mm} mm, {defocus_d} D, {place}: off by {off:?}"
            );
        }
        if (pupil_mm, defocus_d) == (4.0, 3.0) {
            // 12 mrad.
            let arcmin = |px: f64| (px / pixels_per_rad()).to_degrees() * 60.0;
            let star = measure(places[0], |x, y| view[(y * SIDE + x) as usize]);
            let width = arcmin(8f64.sqrt() * star.rms_px);
            assert!((width / 41.25 - 1.0).abs() < 0.02, "{width}′");
            for (pupil_mm, defocus_d) in [(4.3, 3.0), (4.0, 3.25)] {
                let view = view_of(&mut headless, myope(pupil_mm, defocus_d));
                let diameter_px = claimed_px(4.0, 3.0, places[0]);
                let off = off(&view, places[0], diameter_px, light(brightness));
                assert!(off[0] > 0.05 && off[1] > 0.05, "{off:?} is not refused");
            }
        }
    }
    println!("second moment, 50 % radius and light off by at most {worst:.4?}");
}
