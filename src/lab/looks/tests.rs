//! Drawn pictures whose numbers are known.

use super::*;
use image::Rgba;

#[test]
fn skin_that_varies_is_measured() {
    // Stripes of a wavelength of 0.8 D in a*, and dots of a hundredth of D in L*, on a slope of light.
    let made = |stripes: f64, dots: f64| {
        let linear = (0..1024 * 1024).map(|i| {
            let at = place(i, 1024);
            let slope = 1.0 + at.y / 4096.0;
            let wave = stripes * (at.x * core::f64::consts::TAU / (1.6 * 205.0)).sin();
            // As the patches lie.
            let cell = ((at - DVec2::new(184.0, 860.5)) / 4.1).floor();
            let dot = if (cell.x + cell.y).rem_euclid(2.0) < 1.0 {
                dots
            } else {
                -dots
            };
            0.3 * slope * (1.0 + dot) * DVec3::new(1.0 + wave, 1.0 - wave, 1.0)
        });
        let picture = Picture {
            size: 1024,
            linear: linear.collect(),
            open: vec![true; 1024 * 1024],
            center: DVec2::splat(512.0),
            pupil_px: 60.0,
            limbus_px: 205.0,
            nose: 1.0,
        };
        skin_varies(&picture)
    };
    let (flat, smooth) = made(0.0, 0.0);
    assert!(flat.max_element() < 0.1 && smooth < 0.3, "{flat} {smooth}");
    let (striped, _) = made(0.03, 0.0);
    assert!(striped.y > 1.0 && striped.y > 2.0 * striped.x, "{striped}");
    let (even, dotted) = made(0.0, 0.05);
    // L* of 1.05 and 0.95 times a luminance of 0.33 are 1.2 from their mean.
    assert!(
        even.max_element() < 0.1 && (dotted - 1.2).abs() < 0.3,
        "{even} {dotted}"
    );
}

/// A drawn eye: grey pupil, iris and white of known sizes, with a soft limbus and vessels.
fn drawn(limbus_px: f64, soft: f64, vessels: u32) -> RgbaImage {
    RgbaImage::from_fn(512, 512, |x, y| {
        let off = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - 256.0;
        let r = off.length() / limbus_px;
        let t = ((r - 1.0) / soft + 0.5).clamp(0.0, 1.0);
        let mut v = 0.1 + 0.4 * t;
        if r < 0.3 {
            v = 0.005;
        }
        let angle = off.y.atan2(off.x);
        let wave = (angle * f64::from(vessels)).sin();
        let blood = if r > 1.2 && wave > 0.96 { 0.8 } else { 1.0 };
        let c = linear_to_srgb(DVec3::new(v, v * blood, v)) * 255.0;
        Rgba([c.x.round() as u8, c.y.round() as u8, c.z.round() as u8, 255])
    })
}

#[test]
fn what_is_drawn_is_what_is_measured() {
    let picture = Picture::new(&drawn(120.0, 0.2, 40), 120.0, 1.0, |_| true);
    assert!(picture.center.distance(DVec2::splat(256.0)) < 0.5);
    assert!((picture.pupil_px / 36.0 - 1.0).abs() < 0.02);
    // 10 to 90 % of a linear step 0.2 wide.
    let width_of = |picture: &Picture| {
        let [from, to] = limbal_step(picture);
        to - from
    };
    let width = width_of(&picture);
    assert!((width - 0.16).abs() < 0.021, "{width}");
    let middle = limbal_step(&picture).iter().sum::<f64>() / 2.0;
    assert!((middle - 1.0).abs() < 0.011, "{middle}");
    let sharp = Picture::new(&drawn(120.0, 0.05, 40), 120.0, 1.0, |_| true);
    assert!(width_of(&sharp) < 0.07);
    // A pupil beside the middle and less light on one side change nothing of it.
    let mut uneven = drawn(120.0, 0.2, 0);
    for (x, y, pixel) in uneven.enumerate_pixels_mut() {
        let off = DVec2::new(f64::from(x), f64::from(y)) - 256.0;
        if x < 256 {
            let [red, green, blue, _] = pixel.0.map(|code| code / 5 * 4);
            *pixel = Rgba([red, green, blue, 255]);
        }
        if off.distance(DVec2::new(7.0, -2.0)) < 40.0 {
            *pixel = Rgba([10, 10, 10, 255]);
        }
    }
    let beside = Picture::new(&uneven, 120.0, 1.0, |_| true);
    assert!((width_of(&beside) - width).abs() < 0.006);
    let (crossings, contrast) = super::vessels(&picture);
    // 40 a turn: 40/2π a radian, of a radius of half a diameter times 1.35 and 1.5.
    let expected = 40.0 / core::f64::consts::TAU * 2.0 / 1.425;
    assert!(
        (crossings / expected - 1.0).abs() < 0.15,
        "{crossings} {expected}"
    );
    assert!((contrast - 0.2).abs() < 0.03, "{contrast}");
    // Lids that are shut leave nothing to be measured, nor does a pupil that fills the cornea a limbus; one of half of it is as wide.
    let shut = Picture::new(&drawn(120.0, 0.2, 40), 120.0, 1.0, |_| false);
    let (_, nothing) = rows(&shut);
    let of_eye = |row: &&LookRow| !row.quantity.starts_with("skin");
    assert!(nothing.iter().filter(of_eye).all(|row| row.ours.is_none()));
    for share in [0.6, 0.95] {
        let mut wide = drawn(120.0, 0.2, 40);
        for (x, y, pixel) in wide.enumerate_pixels_mut() {
            let off = DVec2::new(f64::from(x), f64::from(y)) - 256.0;
            if off.length() < share * 120.0 {
                *pixel = Rgba([10, 10, 10, 255]);
            }
        }
        let wide = Picture::new(&wide, 120.0, 1.0, |_| true);
        assert!((wide.pupil_px / 120.0 - share).abs() < 0.01, "{share}");
        let [from, to] = limbal_step(&wide);
        assert_eq!(from.is_nan() && to.is_nan(), share > 0.9);
        assert!(share > 0.9 || (to - from - width).abs() < 0.011);
    }
    assert_eq!(
        super::vessels(&Picture::new(&drawn(120.0, 0.2, 0), 120.0, 1.0, |_| true)).0,
        0.0
    );
}
