//! Photographs by the program: as they stand, turned, and as old and young eyes see them.

use super::files::{data, succeeds};
use super::{Files, said};
use crate::stage::turn;
use image::{ImageBuffer, Luma, Rgb, RgbImage, imageops};
use ocularium::scene::model::srgb_to_linear;
use std::fs;

/// The last frame of a patient's view of a page, as linear light, and the pupil (mm) in it.
fn page(patient: &str, at: &str) -> (ImageBuffer<Luma<f32>, Vec<f32>>, f64) {
    let files = Files::new();
    let out = files.name("out");
    succeeds(&[
        "render",
        "--patient",
        patient,
        "--scene",
        &data("page.png"),
        "--at",
        at,
        "--span",
        "29.4deg",
        "--panel",
        "view",
        "--size",
        "480x360",
        "--seconds",
        "1",
        "--fps",
        "5",
        "--seed",
        "1",
        "--out",
        &out,
    ]);
    let frame = image::open(files.path("out/frame_00004.png"))
        .expect("a frame")
        .to_rgb8();
    let light = frame
        .pixels()
        .map(|pixel| srgb_to_linear(pixel.0[1]))
        .collect();
    let trace = fs::read_to_string(files.path("out/trace.csv")).expect("a trace");
    let row: Vec<&str> = trace.lines().last().expect("a row").split(',').collect();
    assert_eq!(
        (row[6], row[7]),
        ("1.000000000", "0"),
        "the lids are not open"
    );
    let light = ImageBuffer::from_vec(480, 360, light).expect("a light a pixel");
    (light, row[4].parse().expect("a pupil"))
}

/// Standard deviation of what lies off the picture's edge, as a share of its mean.
fn contrast(light: &ImageBuffer<Luma<f32>, Vec<f32>>) -> f64 {
    let values: Vec<f64> = (30..330)
        .flat_map(|y| (30..450).map(move |x| (x, y)))
        .map(|(x, y)| f64::from(light.get_pixel(x, y).0[0]))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (square / values.len() as f64).sqrt() / mean
}

/// What the page's white loses to its letters.
fn ink(light: &ImageBuffer<Luma<f32>, Vec<f32>>) -> f64 {
    let white = light.iter().copied().fold(0.0, f32::max);
    light.iter().map(|&here| f64::from(white - here)).sum()
}

#[test]
fn a_page_at_reading_distance_is_for_the_young() {
    let _turn = turn();
    let (young, _) = page("healthy-blue", "0.4m");
    let (old, pupil_mm) = page("presbyope-60", "0.4m");
    let (far, _) = page("presbyope-60", "3m");
    // Far off, it is as sharp to the old as near to the young: the pixels are the same, and so is the angle.
    let ratio = contrast(&far) / contrast(&young);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    // Blur spreads ink and takes none away.
    let kept = ink(&old) / ink(&young);
    assert!((kept - 1.0).abs() < 0.005, "{kept} of the ink");
    // Sixty years leave half a dioptre of the 2.5 that 0.4 m asks for. A disc of 2 D times the pupil has a
    // standard deviation of a quarter of its width. The page is as high as the view, 29.4°.
    let error = |defocus_d: f64| {
        let half_height = (0.5 * 29.4f64.to_radians()).tan();
        let sigma_px = 0.25 * defocus_d * pupil_mm * 1e-3 * 180.0 / half_height;
        let blurred = blurred(&young, sigma_px);
        // Among the letters, within 8° of where it looks: farther out the retina's own coarseness adds to the
        // old eye's blur, while the young one's view is too coarse itself to show it.
        let squares = (150..330).flat_map(|x| (90..270).map(move |y| (x, y)));
        let squares = squares.map(|(x, y)| blurred.get_pixel(x, y).0[0] - old.get_pixel(x, y).0[0]);
        let squares = squares.map(|off| f64::from(off).powi(2)).sum::<f64>();
        (squares / (180.0 * 180.0)).sqrt()
    };
    // A code is 0.01 of linear light near white; a quarter of a dioptre is another picture.
    let (found, less, more) = (error(2.0), error(1.75), error(2.25));
    assert!(
        found < 0.004 && found < 0.5 * less.min(more),
        "{less}, {found}, {more}"
    );
}

/// Light under a Gaussian, on a picture that goes on at its edges.
fn blurred(
    light: &ImageBuffer<Luma<f32>, Vec<f32>>,
    sigma_px: f64,
) -> ImageBuffer<Luma<f32>, Vec<f32>> {
    let reach = (4.0 * sigma_px).ceil() as i64;
    let weight = |d: i64| (-0.5 * (d as f64 / sigma_px).powi(2)).exp();
    let total: f64 = (-reach..=reach).map(weight).sum();
    let pass = |from: &ImageBuffer<Luma<f32>, Vec<f32>>, along: (i64, i64)| {
        let (width, height) = from.dimensions();
        let at = |x: i64, y: i64| {
            let (x, y) = (
                x.clamp(0, i64::from(width) - 1),
                y.clamp(0, i64::from(height) - 1),
            );
            f64::from(from.get_pixel(x as u32, y as u32).0[0])
        };
        ImageBuffer::from_fn(width, height, |x, y| {
            let (x, y) = (i64::from(x), i64::from(y));
            let sum: f64 = (-reach..=reach)
                .map(|d| weight(d) * at(x + d * along.0, y + d * along.1))
                .sum();
            Luma([(sum / total) as f32])
        })
    };
    pass(&pass(light, (1, 0)), (0, 1))
}

#[test]
fn a_photograph_is_shown_as_it_is() {
    let _turn = turn();
    let files = Files::new();
    // Up to white and to the fullest colours: a display's picture has no room for a scene's highlights.
    let colours = [
        [255, 255, 255],
        [250, 250, 250],
        [230, 230, 230],
        [128, 128, 128],
        [0, 0, 0],
        [255, 0, 0],
        [0, 255, 0],
        [255, 240, 10],
    ];
    let plates = RgbImage::from_fn(160, 80, |x, y| {
        Rgb(colours[(x / 40 + 4 * (y / 40)) as usize])
    });
    plates.save(files.path("plates.png")).expect("saved");
    let out = files.name("out");
    succeeds(&[
        "render",
        "--patient",
        "healthy-blue",
        "--scene",
        &files.name("plates.png"),
        "--panel",
        "view",
        "--size",
        "160x80",
        "--seconds",
        "0.1",
        "--fps",
        "10",
        "--out",
        &out,
    ]);
    let frame = image::open(files.path("out/frame_00000.png"))
        .expect("a frame")
        .to_rgb8();
    for (index, wanted) in colours.into_iter().enumerate() {
        let place = (20 + 40 * (index as u32 % 4), 20 + 40 * (index as u32 / 4));
        let found = frame.get_pixel(place.0, place.1).0;
        let off = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max();
        assert!(off <= Some(1), "{found:?} in place of {wanted:?}");
    }
}

/// Flags of every corner another, so that no turn is like another.
fn flags() -> RgbImage {
    RgbImage::from_fn(60, 40, |x, y| match (x < 30, y < 20) {
        (true, true) => Rgb([((x * 29) ^ (y * 53)) as u8, 40, 40]),
        (false, true) => Rgb([40, if (x / 6 + y / 5) % 2 == 0 { 220 } else { 30 }, 40]),
        (true, false) => Rgb([40, 60, if x % 12 < 6 { 240 } else { 90 }]),
        (false, false) => Rgb([230, 230, if y % 10 < 5 { 200 } else { 0 }]),
    })
}

/// A PNG that says in its Exif how it is to be turned (TIFF tag 0x0112).
fn saved(image: &RgbImage, orientation: u8) -> Vec<u8> {
    let mut info = png::Info::with_size(image.width(), image.height());
    info.color_type = png::ColorType::Rgb;
    info.bit_depth = png::BitDepth::Eight;
    let mut exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    info.exif_metadata = Some(exif.into());
    let mut bytes = Vec::new();
    let encoder = png::Encoder::with_info(&mut bytes, info).expect("a sound header");
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(image.as_raw()).expect("pixels");
    writer.finish().expect("the end");
    bytes
}

#[test]
fn every_command_turns_a_photograph_as_it_says() {
    let _turn = turn();
    let files = Files::new();
    let upright = flags();
    let mut seen = Vec::new();
    // What is stored shows `upright` once it is turned as Exif 2.3 (tag 274) says.
    for (orientation, stored) in [
        (1, upright.clone()),
        (3, imageops::rotate180(&upright)),
        (6, imageops::rotate270(&upright)),
        (
            7,
            imageops::rotate180(&imageops::rotate270(&imageops::flip_horizontal(&upright))),
        ),
    ] {
        let path = files.write(&format!("{orientation}.png"), &saved(&stored, orientation));
        let corners = said(&["features", &path, "--threshold", "20"]);
        assert!(corners.lines().count() > 20, "{corners}");
        let out = files.name(&format!("out-{orientation}"));
        succeeds(&[
            "render",
            "--scene",
            &path,
            "--panel",
            "view",
            "--size",
            "60x40",
            "--seconds",
            "0.1",
            "--fps",
            "10",
            "--out",
            &out,
        ]);
        let frame = fs::read(files.path(&format!("out-{orientation}/frame_00000.png")));
        seen.push((orientation, corners, frame.expect("a frame")));
    }
    let (_, corners, frame) = &seen[0];
    for (orientation, other_corners, other_frame) in &seen[1..] {
        assert!(
            corners == other_corners,
            "corners, orientation {orientation}"
        );
        assert!(frame == other_frame, "the view, orientation {orientation}");
    }
    // Stored alike and turned otherwise, it is another.
    let path = files.write("wrong.png", &saved(&imageops::rotate270(&upright), 8));
    assert!(*corners != said(&["features", &path, "--threshold", "20"]));
}
