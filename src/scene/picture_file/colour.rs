//! From the colour space that a file names to sRGB.
//!
//! Enters: a picture, its ICC profile or a PNG's `cICP`, `gAMA` and `cHRM`. Leaves: the same picture
//! with sRGB codes; what lies outside sRGB is clipped to it, as on a display. Conversion is `moxcms`',
//! in 16 bits wherever anything is converted, so that dark codes do not fall together.

use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
use moxcms::{
    Chromaticity, CicpColorPrimaries, CicpProfile, ColorPrimaries, ColorProfile, DataColorSpace,
    Layout, MatrixCoefficients, ToneReprCurve, TransferCharacteristics, TransformOptions, XyY,
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
    let points = (format == ImageFormat::Png)
        .then(|| png_code_points(bytes, remark))
        .flatten();
    let source = match profile {
        // The third edition of PNG puts the code points before the profile (4.3).
        _ if points.is_some() => points,
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
        // A grey picture in a colour space: its greys are those of the three channels alike.
        DataColorSpace::Rgb => {}
        DataColorSpace::Gray if grey => {}
        _ => {
            remark(
                "its colour profile is not one for its channels and was ignored; sRGB is assumed.",
            );
            return image;
        }
    }
    converted(&image, &source).unwrap_or_else(|| {
        remark("its colour profile cannot be used and was ignored; sRGB is assumed.");
        image
    })
}

/// Does a file that gave no profile have one? Then it cannot be unpacked.
pub fn announces_profile(bytes: &[u8], format: ImageFormat) -> bool {
    match format {
        ImageFormat::Png => super::png_chunks(bytes).any(|(kind, _)| kind == b"iCCP"),
        // Its name stands at the head of an application's segment.
        ImageFormat::Jpeg => bytes[..bytes.len().min(1 << 20)]
            .windows(12)
            .any(|name| name == b"ICC_PROFILE\0"),
        _ => false,
    }
}

/// `None` where the profile lacks what a conversion needs.
fn converted(image: &DynamicImage, source: &ColorProfile) -> Option<DynamicImage> {
    let (layout, from) = match source.color_space {
        DataColorSpace::Gray => (Layout::GrayAlpha, image.to_luma_alpha16().into_raw()),
        _ => (Layout::Rgba, image.to_rgba16().into_raw()),
    };
    let options = TransformOptions {
        prefer_fixed_point: false,
        ..TransformOptions::default()
    };
    let srgb = ColorProfile::new_srgb();
    let transform = source
        .create_transform_16bit(layout, &srgb, Layout::Rgba, options)
        .ok()?;
    let mut to = vec![0u16; image.width() as usize * image.height() as usize * 4];
    transform.transform(&from, &mut to).ok()?;
    ImageBuffer::<Rgba<u16>, _>::from_raw(image.width(), image.height(), to)
        .map(DynamicImage::ImageRgba16)
}

/// The colour space of a PNG's `cICP` (ITU-T H.273's code points), if it can be shown.
fn png_code_points(bytes: &[u8], remark: &mut dyn FnMut(&str)) -> Option<ColorProfile> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let points = reader.info().coding_independent_code_points?;
    let transfer = TransferCharacteristics::try_from(points.transfer_function).ok();
    if let Some(TransferCharacteristics::Smpte2084 | TransferCharacteristics::Hlg) = transfer {
        remark(
            "its brightness is coded for an HDR display, which is not read: save it as SDR to see it right.",
        );
        return None;
    }
    let profile = transfer.zip(CicpColorPrimaries::try_from(points.color_primaries).ok());
    let usable = profile.filter(|(transfer, primaries)| {
        use CicpColorPrimaries as P;
        use TransferCharacteristics as T;
        !matches!(transfer, T::Reserved | T::Unspecified)
            && !matches!(primaries, P::Reserved | P::Unspecified)
            && points.matrix_coefficients == 0
            && points.is_video_full_range_image
    });
    let Some((transfer_characteristics, color_primaries)) = usable else {
        remark("its colour code points (cICP) cannot be used and were ignored.");
        return None;
    };
    Some(ColorProfile::new_from_cicp(CicpProfile {
        color_primaries,
        transfer_characteristics,
        matrix_coefficients: MatrixCoefficients::Identity,
        full_range: true,
    }))
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
