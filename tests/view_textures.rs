//! Textures as the view shows them.

use crate::stage::{luma_at, open, session, statistics, turn};
use bevy::math::UVec2;
use image::RgbaImage;
use ocularium::lab::headless::Which;
use ocularium::patients::{PatientFile, PupilSetting};

/// Lumas of a part of a picture: the darkest and the mean.
fn darkest_and_mean(picture: &RgbaImage, [left, top, right, bottom]: [u32; 4]) -> (f64, f64) {
    let chosen = |x, y| (left..right).contains(&x) && (top..bottom).contains(&y);
    let darkest = picture
        .enumerate_pixels()
        .filter(|(x, y, _)| chosen(*x, *y))
        .map(|(x, y, _)| luma_at(picture, x, y))
        .fold(f64::MAX, f64::min);
    (darkest, statistics(picture, chosen).0)
}

#[test]
fn a_blank_place_of_the_telephone_is_blank() {
    let _turn = turn();
    // Short-sighted, so that the telephone is sharp without a word to the lens; a narrow pupil.
    let near = PatientFile {
        sphere_d: -3.3,
        pupil: PupilSetting::Fixed(1.0),
        blur_cap_arcmin: 10.0,
        ..PatientFile::default()
    };
    let size = UVec2::splat(640);
    let headless = open(session(near, 1), UVec2::splat(16), size, [false, true]);
    let view = headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"));
    // Right of the words "Sharp near and far?", where the screen is white but for a slight gradient
    // of 2 codes over this height; one texel of the header or of the frame behind is 100 darker.
    let (darkest, mean) = darkest_and_mean(&view, [133, 372, 158, 426]);
    assert!(mean > 150.0, "not on the screen: {mean}");
    assert!(mean - darkest < 10.0, "{darkest} in {mean}");
    // The same look at the words finds them.
    let (darkest, mean) = darkest_and_mean(&view, [30, 372, 118, 426]);
    assert!(mean > 150.0 && mean - darkest > 60.0, "{darkest} in {mean}");
}
