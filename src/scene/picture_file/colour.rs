//! From the colour space that a file names to sRGB.
//!
//! Enters: a picture, its ICC profile or a PNG's `cICP`, `gAMA` and `cHRM`. Leaves: the same picture
//! with sRGB codes; what lies outside sRGB is clipped to it, as on a display. Conversion is `moxcms`',
//! in 16 bits wherever anything is converted, so that dark codes do not fall together.

use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
use moxcms::{
    Chromaticity, ColorPrimaries, ColorProfile, DataColorSpace, Layout, ToneReprCurve,
    TransformOptions, XyY,
};
use std::io::Cursor;

/// Converts; `remark` gets a clause for what is ignored or assumed.
pub fn to_srgb(
    image: DynamicImage,
    format: ImageFormat,
    bytes: &[u8],
    profile: Option<&[u8]>,
    remark: &mut dyn FnMut(&str),
) -> DynamicImage {
    let source = match profile {
        Some(icc) => match ColorProfile::new_from_slice(icc) {
            Ok(profile) => Some(profile),
            Err(_) => {
                remark("its colour profile is broken and was ignored; sRGB is assumed.");
                None
            }
        },
        None if format == ImageFormat::Png => png_colorimetry(bytes),
        None => None,
    };
    let Some(source) = source else {
        return image;
    };
    let grey = !image.color().has_color();
    match source.color_space {
        DataColorSpace::Rgb if !grey => convert(image, &source, remark),
        DataColorSpace::Gray if grey => convert_grey(image, &source, remark),
        // A grey picture in a colour space: its greys are those of the three channels alike.
        DataColorSpace::Rgb => convert(image, &source, remark),
        _ => {
            remark("its colour profile is not one for red, green and blue and was ignored.");
            image
        }
    }
}

const UNUSABLE: &str = "its colour profile cannot be used and was ignored; sRGB is assumed.";

fn convert(
    image: DynamicImage,
    source: &ColorProfile,
    remark: &mut dyn FnMut(&str),
) -> DynamicImage {
    let options = TransformOptions {
        prefer_fixed_point: false,
        ..TransformOptions::default()
    };
    let srgb = ColorProfile::new_srgb();
    let Ok(transform) = source.create_transform_16bit(Layout::Rgba, &srgb, Layout::Rgba, options)
    else {
        remark(UNUSABLE);
        return image;
    };
    let rgba = image.to_rgba16();
    let (width, height) = rgba.dimensions();
    let from = rgba.into_raw();
    let mut to = vec![0u16; from.len()];
    let buffer = match transform.transform(&from, &mut to) {
        Ok(()) => ImageBuffer::<Rgba<u16>, _>::from_raw(width, height, to),
        Err(_) => None,
    };
    buffer.map_or_else(
        || {
            remark(UNUSABLE);
            image
        },
        DynamicImage::ImageRgba16,
    )
}

fn convert_grey(
    image: DynamicImage,
    source: &ColorProfile,
    remark: &mut dyn FnMut(&str),
) -> DynamicImage {
    let options = TransformOptions::default();
    let srgb = ColorProfile::new_srgb();
    let Ok(transform) = source.create_transform_16bit(Layout::Gray, &srgb, Layout::Rgb, options)
    else {
        remark(UNUSABLE);
        return image;
    };
    let grey = image.to_luma_alpha16();
    let (width, height) = grey.dimensions();
    let from: Vec<u16> = grey.pixels().map(|pixel| pixel.0[0]).collect();
    let mut to = vec![0u16; from.len() * 3];
    if transform.transform(&from, &mut to).is_err() {
        remark(UNUSABLE);
        return image;
    }
    let pixels = grey
        .pixels()
        .zip(to.chunks_exact(3))
        .flat_map(|(grey, rgb)| [rgb[0], rgb[1], rgb[2], grey.0[1]])
        .collect();
    ImageBuffer::<Rgba<u16>, _>::from_raw(width, height, pixels)
        .map_or(image, DynamicImage::ImageRgba16)
}

/// The colour space that a PNG's own chunks describe, if it is not sRGB (PNG, third edition, 4.3).
fn png_colorimetry(bytes: &[u8]) -> Option<ColorProfile> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() || (info.gama_chunk.is_none() && info.chrm_chunk.is_none()) {
        return None;
    }
    let mut profile = ColorProfile::new_srgb();
    if let Some(gamma) = info.gama_chunk {
        // The chunk holds the encoding exponent; sRGB's own is written as 1/2.2.
        let encoding = gamma.into_value();
        if !(0.05..=5.0).contains(&encoding) {
            return None;
        }
        if (encoding - 0.45455).abs() > 1e-4 {
            let curve = Some(ToneReprCurve::Parametric(vec![1.0 / encoding]));
            profile.red_trc = curve.clone();
            profile.green_trc = curve.clone();
            profile.blue_trc = curve;
        } else if info.chrm_chunk.is_none() {
            return None;
        }
    }
    if let Some(chunk) = info.chrm_chunk {
        let place = |(x, y): (png::ScaledFloat, png::ScaledFloat)| {
            let (x, y) = (x.into_value(), y.into_value());
            (x > 0.0 && y > 0.01 && x + y <= 1.0001).then(|| Chromaticity::new(x, y))
        };
        let white = place(chunk.white)?;
        profile.update_rgb_colorimetry(
            XyY {
                x: f64::from(white.x),
                y: f64::from(white.y),
                yb: 1.0,
            },
            ColorPrimaries {
                red: place(chunk.red)?,
                green: place(chunk.green)?,
                blue: place(chunk.blue)?,
            },
        );
    }
    profile.cicp = None;
    Some(profile)
}
