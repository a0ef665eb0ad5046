//! A depth picture: the distance of every pixel of a photograph.
//!
//! Enters: a picture file whose grey codes mean distances ([`DepthUnit`]). Leaves: distances in metres
//! at the photograph's size, resampled linearly in vergence (1/m), and a remark on how the codes were
//! read where that was not said. Greys may be stored as RGB or RGBA with equal channels, as many tools
//! write them.

use super::model::SceneError;
use super::photo::PhotoOptions;
use super::picture_file::{Meaning, decode_picture};
use image::{DynamicImage, ImageBuffer, Luma, imageops};
use std::collections::VecDeque;

/// What a code of a depth picture means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthUnit {
    /// A distance in millimetres; 0 is no measurement.
    Millimetres,
    /// A distance in centimetres; 0 is no measurement.
    Centimetres,
    /// A distance in metres; 0 is no measurement.
    Metres,
    /// A vergence in thousandths of a dioptre; 0 is infinitely far.
    Dioptres,
    /// A share of the vergence between far (black) and near (white), as disparity is.
    Inverse,
}

/// A 16-bit picture without a code above this holds no near things if white is near, so it is taken
/// for millimetres when nobody says what it is: a third of the range, 21.8 m.
const LARGEST_MILLIMETRE_CODE: u16 = 21_845;

/// Distances (m, row-major, infinity allowed) of a photograph of this size, and a remark if the
/// meaning of the codes had to be guessed.
pub fn read_depth(
    bytes: &[u8],
    name: &str,
    size: (u32, u32),
    options: &PhotoOptions,
) -> Result<(Vec<f32>, Vec<String>), SceneError> {
    let fault = |reason: String| SceneError::Malformed {
        source_name: name.into(),
        kind: "depth image",
        reason,
    };
    let picture = decode_picture(bytes, name, 1, Meaning::Data)?;
    let mut remarks = picture.remarks;
    let (codes, full) = grey_codes(&picture.image).ok_or_else(|| {
        fault("it is in colour, but must be grey (8 or 16 bits, or RGB with equal channels)".into())
    })?;
    let unit = options.depth_unit.unwrap_or_else(|| {
        let largest = codes.pixels().map(|code| code.0[0]).max().unwrap_or(0);
        let (unit, reading) = if full == u16::MAX && (1..=LARGEST_MILLIMETRE_CODE).contains(&largest)
        {
            (DepthUnit::Millimetres, "millimetres, 0 no measurement".to_owned())
        } else {
            let (near, far) = (options.near_m, options.far_m);
            let far = if far.is_finite() { format!("{far} m") } else { "infinitely far".into() };
            (DepthUnit::Inverse, format!("inverse, white {near} m, black {far}"))
        };
        remarks.push(format!(
            "The depth image \"{name}\" was read as {reading}; if that is wrong, say what it is (--depth-unit, or \"Its depth\" among the controls)."
        ));
        unit
    });
    let reach = match unit {
        DepthUnit::Millimetres => Some("millimetres they reach no farther than 0.255 m"),
        DepthUnit::Dioptres => Some("thousandths of a dioptre they come no nearer than 3.9 m"),
        DepthUnit::Centimetres | DepthUnit::Metres | DepthUnit::Inverse => None,
    };
    if let (Some(reach), 255) = (reach, full) {
        remarks.push(format!(
            "The depth image \"{name}\" has codes of 8 bits: as {reach}."
        ));
    }
    let vergence = |code: u16| match unit {
        DepthUnit::Millimetres => measured(code, 1e-3),
        DepthUnit::Centimetres => measured(code, 1e-2),
        DepthUnit::Metres => measured(code, 1.0),
        DepthUnit::Dioptres => f32::from(code) * 1e-3,
        DepthUnit::Inverse => {
            let far_d = 1.0 / options.far_m;
            far_d + f32::from(code) / f32::from(full) * (1.0 / options.near_m - far_d)
        }
    };
    let mut map = ImageBuffer::<Luma<f32>, _>::new(codes.width(), codes.height());
    for (to, from) in map.pixels_mut().zip(codes.pixels()) {
        to.0[0] = vergence(from.0[0]);
    }
    if !fill_from_neighbours(&mut map) {
        return Err(fault("every pixel is 0, which is no measurement".into()));
    }
    let (own, its) = (
        map.width() as f32 / map.height() as f32,
        size.0 as f32 / size.1 as f32,
    );
    if (own / its - 1.0).abs() > 0.03 {
        remarks.push(format!(
            "The depth image \"{name}\" is {}×{} pixels and the photograph {}×{}: it is stretched to that shape; perhaps \
             one of them lies on its side.",
            map.width(), map.height(), size.0, size.1
        ));
    }
    let nearest_d = map
        .pixels()
        .map(|vergence| vergence.0[0])
        .fold(0.0, f32::max);
    if nearest_d > 50.0 {
        remarks.push(format!(
            "The nearest place of the depth image \"{name}\" is {:.1} mm away: is its unit another?",
            1e3 / nearest_d
        ));
    }
    if map.dimensions() != size {
        map = resized(map, size);
    }
    let distances = map.pixels().map(|vergence| distance_m(vergence.0[0]));
    Ok((distances.collect(), remarks))
}

/// Resampled linearly. `image` takes numbers for shares of 1 and clips them, so they are made such.
fn resized(
    mut map: ImageBuffer<Luma<f32>, Vec<f32>>,
    (width, height): (u32, u32),
) -> ImageBuffer<Luma<f32>, Vec<f32>> {
    let largest = map.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    map.iter_mut().for_each(|value| *value /= largest);
    let mut map = imageops::resize(&map, width, height, imageops::FilterType::Triangle);
    map.iter_mut().for_each(|value| *value *= largest);
    map
}

/// Vergence of a measured distance, 1/m; NaN for none.
fn measured(code: u16, unit_m: f32) -> f32 {
    if code == 0 {
        f32::NAN
    } else {
        1.0 / (f32::from(code) * unit_m)
    }
}

fn distance_m(vergence_d: f32) -> f32 {
    if vergence_d > 0.0 {
        1.0 / vergence_d
    } else {
        f32::INFINITY
    }
}

/// Grey codes, of 8 or 16 bits.
type Codes = ImageBuffer<Luma<u16>, Vec<u16>>;

/// The grey codes and the largest possible one; `None` where channels differ.
fn grey_codes(image: &DynamicImage) -> Option<(Codes, u16)> {
    let eight_bits = matches!(
        image,
        DynamicImage::ImageLuma8(_)
            | DynamicImage::ImageLumaA8(_)
            | DynamicImage::ImageRgb8(_)
            | DynamicImage::ImageRgba8(_)
    );
    let full = if eight_bits { 255 } else { u16::MAX };
    let rgb = image.to_rgb16();
    let grey = rgb.pixels().all(|p| p.0[0] == p.0[1] && p.0[1] == p.0[2]);
    let scale = u16::MAX / full;
    let codes = rgb.pixels().map(|pixel| pixel.0[0] / scale).collect();
    let codes = ImageBuffer::from_raw(rgb.width(), rgb.height(), codes)?;
    grey.then_some((codes, full))
}

/// Gives every pixel without a measurement (NaN) that of the nearest one, by steps along rows and
/// columns; false where there is none at all.
fn fill_from_neighbours(map: &mut ImageBuffer<Luma<f32>, Vec<f32>>) -> bool {
    let (width, height) = map.dimensions();
    let at = |x: u32, y: u32| (y * width + x) as usize;
    let values: &mut [f32] = map;
    if !values.iter().any(|value| value.is_nan()) {
        return true;
    }
    let mut front: VecDeque<(u32, u32)> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|&(x, y)| !values[at(x, y)].is_nan())
        .collect();
    if front.is_empty() {
        return false;
    }
    while let Some((x, y)) = front.pop_front() {
        let value = values[at(x, y)];
        let beside = [
            (x.wrapping_sub(1), y),
            (x + 1, y),
            (x, y.wrapping_sub(1)),
            (x, y + 1),
        ];
        for (x, y) in beside {
            if x < width && y < height && values[at(x, y)].is_nan() {
                values[at(x, y)] = value;
                front.push_back((x, y));
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn png(image: &DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn sixteen(codes: [u16; 4]) -> Vec<u8> {
        png(&DynamicImage::ImageLuma16(
            ImageBuffer::from_raw(4, 1, codes.to_vec()).unwrap(),
        ))
    }

    fn read(bytes: &[u8], unit: Option<DepthUnit>) -> (Vec<f32>, Vec<String>) {
        let options = PhotoOptions {
            depth_unit: unit,
            ..PhotoOptions::default()
        };
        read_depth(bytes, "d.png", (4, 1), &options).unwrap()
    }

    #[test]
    fn units_are_what_they_say_and_holes_take_their_neighbours() {
        let near = |found: &[f32], wanted: [f32; 4]| {
            let same = |(a, b): (&f32, f32)| a == &b || (a / b - 1.0).abs() < 1e-6;
            assert!(found.iter().zip(wanted).all(same), "{found:?}");
        };
        let bytes = sixteen([350, 0, 0, 3000]);
        near(
            &read(&bytes, Some(DepthUnit::Millimetres)).0,
            [0.35, 0.35, 3.0, 3.0],
        );
        near(
            &read(&bytes, Some(DepthUnit::Centimetres)).0,
            [3.5, 3.5, 30.0, 30.0],
        );
        near(
            &read(&bytes, Some(DepthUnit::Metres)).0,
            [350.0, 350.0, 3000.0, 3000.0],
        );
        let inf = f32::INFINITY;
        near(
            &read(&bytes, Some(DepthUnit::Dioptres)).0,
            [1.0 / 0.35, inf, inf, 1.0 / 3.0],
        );
        let (found, remarks) = read(&bytes, Some(DepthUnit::Inverse));
        assert!(remarks.is_empty());
        near(&found, [65535.0 / 700.0, inf, inf, 65535.0 / 6000.0]);
    }

    #[test]
    fn a_reading_that_nobody_asked_for_is_said() {
        let (found, remarks) = read(&sixteen([350, 500, 0, 3000]), None);
        assert!((found[0] - 0.35).abs() < 1e-6 && remarks[0].contains("millimetres"));
        let (found, remarks) = read(&sixteen([65535, 500, 0, 3000]), None);
        assert!((found[0] - 0.5).abs() < 1e-6 && remarks[0].contains("white 0.5 m"));
        let grey =
            DynamicImage::ImageLuma8(ImageBuffer::from_raw(4, 1, vec![255, 128, 9, 0]).unwrap());
        let (found, remarks) = read(&png(&grey), None);
        assert!((found[0] - 0.5).abs() < 1e-6 && remarks.len() == 1);
        // The same greys as RGBA and as RGB of 16 bits.
        for same in [
            DynamicImage::ImageRgba8(grey.to_rgba8()),
            DynamicImage::ImageRgb16(grey.to_rgb16()),
        ] {
            assert_eq!(read(&png(&same), None).0, found);
        }
    }

    #[test]
    fn codes_too_short_for_their_unit_are_said() {
        let grey =
            DynamicImage::ImageLuma8(ImageBuffer::from_raw(4, 1, vec![255, 128, 99, 70]).unwrap());
        for (unit, wanted) in [
            (DepthUnit::Millimetres, Some((0, 0.255, "0.255 m"))),
            (DepthUnit::Dioptres, Some((0, 1.0 / 0.255, "3.9 m"))),
            (DepthUnit::Centimetres, None),
            (DepthUnit::Metres, None),
            (DepthUnit::Inverse, None),
        ] {
            let (found, remarks) = read(&png(&grey), Some(unit));
            match wanted {
                Some((at, reach_m, part)) => {
                    assert!((found[at] / reach_m - 1.0).abs() < 1e-6, "{found:?}");
                    assert!(remarks[0].contains(part), "{remarks:?}");
                }
                None => assert!(remarks.is_empty(), "{remarks:?}"),
            }
            assert!(
                read(&sixteen([25500, 12800, 900, 700]), Some(unit))
                    .1
                    .is_empty()
            );
        }
    }

    #[test]
    fn another_shape_and_odd_distances_are_said() {
        let options = PhotoOptions {
            depth_unit: Some(DepthUnit::Millimetres),
            ..PhotoOptions::default()
        };
        let said = |codes: [u16; 4], size: (u32, u32)| {
            read_depth(&sixteen(codes), "d.png", size, &options)
                .unwrap()
                .1
        };
        assert!(said([900; 4], (4, 1)).is_empty() && said([900; 4], (80, 20)).is_empty());
        // The photograph is upright, its depth image lies on its side.
        let remarks = said([900; 4], (1, 4));
        assert!(
            remarks[0].contains("4×1") && remarks[0].contains("1×4"),
            "{remarks:?}"
        );
        let remarks = said([2, 900, 900, 900], (4, 1));
        assert!(remarks[0].contains("2.0 mm away"), "{remarks:?}");
    }

    #[test]
    fn what_is_no_depth_is_refused() {
        let options = PhotoOptions::default();
        let colour = DynamicImage::ImageRgb8(ImageBuffer::from_raw(1, 1, vec![1, 2, 3]).unwrap());
        let error = read_depth(&png(&colour), "d.png", (1, 1), &options).unwrap_err();
        assert!(error.to_string().contains("in colour"), "{error}");
        let options = PhotoOptions {
            depth_unit: Some(DepthUnit::Millimetres),
            ..options
        };
        let error = read_depth(&sixteen([0; 4]), "d.png", (4, 1), &options).unwrap_err();
        assert!(error.to_string().contains("every pixel is 0"), "{error}");
    }
}
