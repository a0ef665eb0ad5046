use super::*;
use image::{Luma, Rgb, RgbImage, Rgba, RgbaImage};
use moxcms::ColorProfile;
use proptest::prelude::*;

/// 420 sub-sampled, sequential, one scan a component: as some cameras and scanners write them.
const CHANNEL_BY_CHANNEL: &[u8] = include_bytes!("../../../tests/data/channel_by_channel.jpg");
const INTERLEAVED: &[u8] = include_bytes!("../../../tests/data/interleaved.jpg");

/// A house of no symmetry: each corner has a colour of its own.
fn corners() -> RgbImage {
    RgbImage::from_fn(48, 32, |x, y| match (x < 24, y < 16) {
        (true, true) => Rgb([220, 40, 40]),
        (false, true) => Rgb([40, 200, 40]),
        (true, false) => Rgb([40, 60, 220]),
        (false, false) => Rgb([230, 230, 60]),
    })
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A JPEG with an Exif orientation (TIFF tag 0x0112) in its first segment.
fn turned_jpeg(orientation: u8) -> Vec<u8> {
    let stored = match orientation {
        5..=8 => RgbImage::from_fn(32, 48, |x, y| *corners().get_pixel(y, x)),
        _ => corners(),
    };
    let mut jpeg = encoded(&stored.into(), ImageFormat::Jpeg);
    let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    let mut segment = vec![0xff, 0xe1];
    segment.extend((exif.len() as u16 + 2).to_be_bytes());
    segment.extend(exif);
    jpeg.splice(2..2, segment);
    jpeg
}

fn decode(bytes: &[u8]) -> PictureFile {
    decode_picture(bytes, "p", 1, Meaning::Colour).unwrap()
}

fn code(picture: &PictureFile, x: u32, y: u32) -> [u16; 3] {
    let rgba = picture.image.to_rgba16();
    let Rgba([r, g, b, _]) = *rgba.get_pixel(x, y);
    [r, g, b]
}

#[test]
fn all_eight_orientations_and_the_invalid_one_are_obeyed() {
    // What the upper left corner shows once the stored picture is turned (Exif 2.3, tag 274).
    for (orientation, quadrant) in [
        (0, 0),
        (1, 0),
        (2, 1),
        (3, 3),
        (4, 2),
        (5, 0),
        (6, 1),
        (7, 3),
        (8, 2),
    ] {
        let picture = decode(&turned_jpeg(orientation));
        assert_eq!(
            (picture.image.width(), picture.image.height()),
            (48, 32),
            "{orientation}"
        );
        let wanted = [(8, 8), (40, 8), (8, 24), (40, 24)][quadrant];
        let Rgb(wanted) = *corners().get_pixel(wanted.0, wanted.1);
        let found = code(&picture, 8, 8).map(|c| (c / 257) as u8);
        let off = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max();
        assert!(off < Some(12), "{orientation}: {found:?}, not {wanted:?}");
    }
}

#[test]
fn channels_that_follow_one_another_are_no_stripes() {
    assert!(jpeg::inspect(CHANNEL_BY_CHANNEL).channels_follow_one_another);
    assert!(!jpeg::inspect(INTERLEAVED).channels_follow_one_another);
    let (one, other) = (decode(CHANNEL_BY_CHANNEL), decode(INTERLEAVED));
    let pairs = one
        .image
        .to_rgb8()
        .into_raw()
        .into_iter()
        .zip(other.image.to_rgb8().into_raw());
    let (sum, count) = pairs.fold((0u64, 0u64), |(sum, count), (a, b)| {
        (sum + u64::from(a.abs_diff(b)), count + 1)
    });
    // The same coefficients; two decoders that interpolate colour differently.
    let mean = sum as f64 / count as f64;
    assert!(mean < 2.0, "{mean} codes");
    // Taken for interleaved, as it was read before, it is green stripes, tens of codes off.
    let striped = image::load_from_memory(CHANNEL_BY_CHANNEL)
        .unwrap()
        .to_rgb8();
    let other = other.image.to_rgb8();
    let pairs = striped.as_raw().iter().zip(other.as_raw());
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    assert!(
        sum / count > 10,
        "{} codes: the usual decoder reads it now",
        sum / count
    );
}

#[test]
fn a_file_that_is_cut_off_is_shown_with_a_remark() {
    // Large and busy enough for the cut to fall into the picture, not into the headers before it.
    let busy = RgbImage::from_fn(256, 192, |x, y| {
        Rgb([((x * 7) ^ (y * 3)) as u8, (x * y) as u8, (255 - x) as u8])
    });
    let whole = encoded(&busy.into(), ImageFormat::Jpeg);
    assert!(decode(&whole).remarks.is_empty());
    let half = &whole[..whole.len() / 2];
    let picture = decode_picture(half, "half.jpg", 1, Meaning::Colour).unwrap();
    // Its upper part is what it was.
    assert_eq!(code(&picture, 20, 20), code(&decode(&whole), 20, 20));
    assert!(picture.remarks[0].contains("half.jpg") && picture.remarks[0].contains("cut off"));
    assert!(!jpeg::inspect(half).is_whole && jpeg::inspect(&whole).is_whole);
}

#[test]
fn sixteen_bits_stay_and_other_formats_are_read() {
    let deep = image::ImageBuffer::from_fn(16, 16, |x, _| Luma([1000 + x as u16]));
    let picture = decode(&encoded(&DynamicImage::ImageLuma16(deep), ImageFormat::Png));
    assert_eq!(code(&picture, 3, 0), [1003; 3]);
    let plain: DynamicImage = corners().into();
    for format in [
        ImageFormat::WebP,
        ImageFormat::Gif,
        ImageFormat::Tiff,
        ImageFormat::Bmp,
    ] {
        let found = code(&decode(&encoded(&plain, format)), 40, 24);
        let off = found
            .map(|c| c / 257)
            .iter()
            .zip([230u16, 230, 60])
            .map(|(a, b)| a.abs_diff(b))
            .max();
        assert!(off <= Some(8), "{format:?}: {found:?}");
    }
}

#[test]
fn formats_that_are_not_read_are_named() {
    for (start, name) in [
        (&b"\0\0\0\x1cftypavif\0\0\0\0"[..], "AVIF"),
        (b"\0\0\0\x18ftypheic\0\0\0\0", "HEIC"),
        (b"%PDF-1.7", "PDF"),
        (b"<?xml version=\"1.0\"?><svg/>", "SVG"),
        (b"\xff\x0a\x00", "JPEG XL"),
        (b"8BPS\0\x01", "Photoshop"),
    ] {
        let error = decode_picture(start, "x", 1, Meaning::Colour)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(name) && error.contains("PNG or JPEG"),
            "{error}"
        );
    }
}

/// A PNG of one colour with these settings of its header.
fn png_with(rgb: [u8; 3], set: impl Fn(&mut png::Info)) -> Vec<u8> {
    let mut info = png::Info::with_size(2, 2);
    info.color_type = png::ColorType::Rgb;
    info.bit_depth = png::BitDepth::Eight;
    set(&mut info);
    let mut bytes = Vec::new();
    let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&rgb.repeat(4)).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn colour_profiles_are_converted_and_broken_ones_are_said() {
    // Display P3's red within sRGB: P3 (200, 100, 50) is sRGB (213.2, 95.8, 35.4) by its matrices.
    let p3 = ColorProfile::new_display_p3().encode().unwrap();
    let picture = decode(&png_with([200, 100, 50], |info| {
        info.icc_profile = Some(p3.clone().into())
    }));
    assert!(picture.remarks.is_empty());
    let found = code(&picture, 0, 0).map(|c| f64::from(c) / 257.0);
    for (found, wanted) in found.iter().zip(display_p3_to_srgb([200.0, 100.0, 50.0])) {
        assert!((found - wanted).abs() < 0.6, "{found} {wanted}");
    }
    // Linear codes: 128 of 255 is half the light, sRGB's code 188.
    let linear = png_with([128; 3], |info| {
        info.source_gamma = Some(png::ScaledFloat::new(1.0));
    });
    let found = code(&decode(&linear), 0, 0).map(|c| f64::from(c) / 257.0);
    assert!(
        found.iter().all(|code| (code - 188.0).abs() < 0.6),
        "{found:?}"
    );
    // The gamma that is written beside sRGB changes nothing.
    let usual = png_with([128; 3], |info| {
        info.source_gamma = Some(png::ScaledFloat::new(0.45455));
    });
    assert_eq!(code(&decode(&usual), 0, 0), [128 * 257; 3]);
    let broken = png_with([9; 3], |info| {
        info.icc_profile = Some(vec![7u8; 200].into())
    });
    let picture = decode(&broken);
    assert!(
        picture.remarks[0].contains("broken"),
        "{:?}",
        picture.remarks
    );
    assert_eq!(code(&picture, 0, 0), [9 * 257; 3]);
    // A grey profile: linear greys with half of the light, and their transparency.
    let grey = ColorProfile::new_gray_with_gamma(1.0).encode().unwrap();
    let mut info = png::Info::with_size(1, 1);
    info.color_type = png::ColorType::GrayscaleAlpha;
    info.bit_depth = png::BitDepth::Eight;
    info.icc_profile = Some(grey.into());
    let mut bytes = Vec::new();
    let mut writer = png::Encoder::with_info(&mut bytes, info)
        .unwrap()
        .write_header()
        .unwrap();
    writer.write_image_data(&[128, 77]).unwrap();
    writer.finish().unwrap();
    let picture = decode(&bytes);
    assert!(picture.remarks.is_empty(), "{:?}", picture.remarks);
    let found = code(&picture, 0, 0).map(|c| f64::from(c) / 257.0);
    assert!(
        found.iter().all(|code| (code - 188.0).abs() < 0.6),
        "{found:?}"
    );
    assert_eq!(picture.image.to_rgba8().get_pixel(0, 0).0[3], 77);
    // Measurements are no colours.
    let data = decode_picture(&linear, "d", 1, Meaning::Data).unwrap();
    assert_eq!(code(&data, 0, 0), [128 * 257; 3]);
}

/// SMPTE EG 432-1's primaries to IEC 61966-2-1's, both with D65 and sRGB's curve; codes 0–255.
fn display_p3_to_srgb(p3: [f64; 3]) -> [f64; 3] {
    let linear = p3.map(|code| {
        let c: f64 = code / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    });
    // The product of the two published matrices.
    let rows = [
        [1.224_940_18, -0.224_940_18, 0.0],
        [-0.042_056_95, 1.042_056_95, 0.0],
        [-0.019_637_55, -0.078_636_05, 1.098_273_60],
    ];
    rows.map(|row| {
        let c: f64 = row.iter().zip(linear).map(|(a, b)| a * b).sum();
        255.0
            * if c <= 0.003_130_8 {
                12.92 * c
            } else {
                1.055 * c.powf(1.0 / 2.4) - 0.055
            }
    })
}

#[test]
fn transparency_and_palettes_survive() {
    let clear = RgbaImage::from_pixel(16, 16, Rgba([10, 20, 30, 0]));
    let picture = decode(&encoded(&clear.into(), ImageFormat::Png));
    assert_eq!(picture.image.to_rgba8().get_pixel(0, 0).0[3], 0);
}

#[test]
fn inks_come_out_as_the_picture_they_were_made_from() {
    let control = decode(include_bytes!("../../../tests/data/cmyk/rgb_control.png"));
    let control = control.image.to_rgb8();
    for bytes in [
        &include_bytes!("../../../tests/data/cmyk/cmyk_transform0.jpg")[..],
        include_bytes!("../../../tests/data/cmyk/ycck_transform2.jpg"),
    ] {
        let found = decode(bytes).image.to_rgb8();
        assert_eq!(found.dimensions(), control.dimensions());
        let off = |other: &RgbImage| {
            let pairs = found.as_raw().iter().zip(other.as_raw());
            pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>() as f64
                / found.as_raw().len() as f64
        };
        assert!(off(&control) < 3.0, "{}", off(&control));
        // As Adobe stores them, inverted.
        let mut inverted = control.clone();
        image::imageops::invert(&mut inverted);
        assert!(off(&inverted) > 30.0);
    }
}

proptest! {
    #[test]
    fn damaged_files_never_panic(which in 0usize..3, at in 0usize..4000, value: u8, cut in 0usize..1500) {
        let p3 = ColorProfile::new_display_p3().encode().unwrap();
        let mut bytes = match which {
            0 => CHANNEL_BY_CHANNEL.to_vec(),
            1 => turned_jpeg(6),
            // The profile itself is damaged, not the chunk that carries it.
            _ => {
                let mut icc = p3;
                let at = at % icc.len();
                icc[at] = value;
                icc.truncate(icc.len() - cut.min(icc.len()));
                png_with([200, 100, 50], |info| info.icc_profile = Some(icc.clone().into()))
            }
        };
        if which < 2 {
            let at = at % bytes.len();
            bytes[at] = value;
            bytes.truncate(bytes.len().saturating_sub(cut));
        }
        let _ = decode_picture(&bytes, "p", 1, Meaning::Colour);
    }
}

#[test]
fn what_shines_through_stands_on_white() {
    let rgba = |pixel: [u16; 4]| {
        let image = ImageBuffer::from_pixel(1, 1, image::Rgba(pixel));
        on_white(DynamicImage::ImageRgba16(image)).get_pixel(0, 0).0
    };
    assert_eq!(rgba([12, 3456, 65535, 65535]), [12, 3456, 65535]);
    assert_eq!(rgba([0, 0, 0, 0]), [65535; 3]);
    // A third of black over two thirds of white.
    assert_eq!(rgba([0, 0, 0, 21845]), [43690; 3]);
}
