//! A head that moves while its eye jumps: what was seen sharply stays so, though far away every step finds other voxels.

use crate::stage::{look, luma_at, open, patient, session, settle, turn, without_blinks};
use bevy::math::{UVec2, Vec3};
use core::ops::Range;
use image::RgbaImage;
use ocularium::lab::headless::{Headless, Which};
use ocularium::patients::PatientFile;
use ocularium::stage::Head;

const SIDE: u32 = 192;

/// Mean squared difference of neighbouring pixels of these columns, but for the picture's top and bottom.
fn detail_of(picture: &RgbaImage, columns: Range<u32>) -> f64 {
    let rows = SIDE / 6..SIDE - SIDE / 6;
    let mut sum = 0.0;
    for y in rows.clone() {
        for x in columns.clone() {
            let here = luma_at(picture, x, y);
            sum += (luma_at(picture, x + 1, y) - here).powi(2);
            sum += (luma_at(picture, x, y + 1) - here).powi(2);
        }
    }
    sum / f64::from((rows.len() * columns.len()) as u32)
}

/// The same of the picture's middle.
fn detail(picture: &RgbaImage) -> f64 {
    detail_of(picture, SIDE / 6..SIDE - SIDE / 6)
}

fn view(headless: &Headless) -> RgbaImage {
    headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// What is seen by an eye that jumps while its head takes this step, and when it has come to rest there.
fn stepped(headless: &mut Headless, time_s: &mut f64, azimuth_deg: f64, step: Head) -> [f64; 2] {
    let mut go = |headless: &mut Headless, seconds: f64| {
        *time_s += seconds;
        headless.go_to(*time_s);
    };
    look(headless, azimuth_deg, 4.0, 3.0);
    for _ in 0..200 {
        go(headless, 0.005);
        if headless.state().in_saccade {
            break;
        }
    }
    headless.set_head(step);
    go(headless, 0.005);
    assert!(headless.state().in_saccade);
    let jumping = detail(&view(headless));
    for _ in 0..10 {
        go(headless, 0.2);
    }
    [jumping, detail(&view(headless))]
}

#[test]
fn what_was_seen_stays_sharp_while_head_and_eye_move() {
    let _turn = turn();
    let file = PatientFile {
        // Cells much smaller than a pixel of what is farther than a few centimetres.
        voxel_mm: 1.0,
        ..patient("healthy-brown")
    };
    let size = UVec2::splat(SIDE);
    let mut headless = open(session(file, 5), UVec2::splat(16), size, [false, true]);
    settle(&mut headless);
    without_blinks(&mut headless);
    look(&mut headless, 0.0, 0.0, 3.0);
    let mut time_s = 0.0;
    for _ in 0..10 {
        time_s += 0.2;
        headless.go_to(time_s);
    }
    let mut share = |azimuth_deg: f64, step: Head| {
        let [jumping, rested] = stepped(&mut headless, &mut time_s, azimuth_deg, step);
        println!("{step:?}: {jumping:.1} of {rested:.1}");
        jumping / rested
    };
    let steps = [
        Head {
            place_m: Vec3::new(0.02, 0.0, 0.0),
            ..Head::default()
        },
        Head {
            place_m: Vec3::new(0.02, 0.01, 0.10),
            ..Head::default()
        },
        Head {
            place_m: Vec3::new(0.02, 0.01, 0.10),
            yaw_deg: 1.0,
            ..Head::default()
        },
    ];
    for (i, step) in steps.into_iter().enumerate() {
        let kept = share(if i % 2 == 0 { 12.0 } else { -8.0 }, step);
        assert!((0.8..1.2).contains(&kept), "{step:?}: {kept}");
    }
    // Of what was not seen before nothing is remembered.
    let elsewhere = Head {
        yaw_deg: 55.0,
        ..steps[2]
    };
    let kept = share(10.0, elsewhere);
    assert!(kept < 0.3, "{kept}");
}

/// A head that turns slowly, by less than a pixel from one capture to the next: what comes in at the border of the view is as blurred as
/// after one quick turn.
#[test]
fn what_comes_into_view_was_not_seen() {
    let _turn = turn();
    let size = UVec2::splat(SIDE);
    let border = |turns: u32| {
        let file = PatientFile {
            voxel_mm: 1.0,
            ..patient("healthy-brown")
        };
        let mut headless = open(session(file, 5), UVec2::splat(16), size, [false, true]);
        settle(&mut headless);
        without_blinks(&mut headless);
        // The border is sharp, and the eye then looks away from it.
        for (i, azimuth_deg) in [(0.0, 22.0), (1.0, -15.0)] {
            look(&mut headless, azimuth_deg, 0.0, 3.0);
            headless.go_to(i + 0.5);
            headless.go_to(i + 1.0);
        }
        for turn in 1..=turns {
            headless.set_head(Head {
                yaw_deg: 8.0 * turn as f32 / turns as f32,
                ..Head::default()
            });
            headless.go_to(2.0 + 0.4 * f64::from(turn) / f64::from(turns));
        }
        // 8° of 50 are some 30 columns.
        detail_of(&view(&headless), SIDE - 20..SIDE - 2)
    };
    let [quick, slow] = [1, 40].map(border);
    println!("{quick} {slow}");
    // Were the border's own sharpness handed on beyond it, it would be 6 % more.
    assert!((slow / quick - 1.0).abs() < 0.02, "{quick} {slow}");
}
