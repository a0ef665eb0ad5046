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
        (b"\0\0\0\x18ftypmif1\0\0\0\0heicmif1", "HEIC"),
        (b"\0\0\0\x18ftypmif1\0\0\0\0mif1avif", "AVIF"),
        // Beyond the box's end stands something else.
        (b"\0\0\0\x14ftypmif1\0\0\0\0mif1avif", "HEIC"),
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

/// sRGB codes (0–255, clipped) of linear light by a published matrix to linear sRGB.
fn srgb_codes(matrix: [[f64; 3]; 3], linear: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| {
        let c: f64 = row.iter().zip(linear).map(|(a, b)| a * b).sum();
        let c = c.clamp(0.0, 1.0);
        255.0
            * if c <= 0.003_130_8 {
                12.92 * c
            } else {
                1.055 * c.powf(1.0 / 2.4) - 0.055
            }
    })
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
    let matrix = [
        [1.224_940_18, -0.224_940_18, 0.0],
        [-0.042_056_95, 1.042_056_95, 0.0],
        [-0.019_637_55, -0.078_636_05, 1.098_273_60],
    ];
    srgb_codes(matrix, linear)
}

/// Adobe RGB (1998), 4.3.4 and 4.3.6: gamma 563/256, its matrix to XYZ times sRGB's from XYZ.
fn adobe_to_srgb(adobe: [f64; 3]) -> [f64; 3] {
    let matrix = [
        [1.398_355_74, -0.398_355_74, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -0.042_932_89, 1.042_932_89],
    ];
    srgb_codes(matrix, adobe.map(|code| (code / 255.0).powf(563.0 / 256.0)))
}

/// ROMM RGB (ISO 22028-2): D50, gamma 1.8 with a foot below 16/512; its matrix to XYZ, Bradford's to D65, sRGB's.
fn pro_photo_to_srgb(romm: [f64; 3]) -> [f64; 3] {
    let linear = romm.map(|code| {
        let c: f64 = code / 255.0;
        if c < 0.031_25 { c / 16.0 } else { c.powf(1.8) }
    });
    let matrix = [
        [2.034_267, -0.727_524, -0.306_743],
        [-0.228_833, 1.231_753, -0.002_920],
        [-0.008_569, -0.153_286, 1.161_855],
    ];
    srgb_codes(matrix, linear)
}

fn near_codes(picture: &PictureFile, wanted: [f64; 3], within: f64, what: &str) {
    assert!(picture.remarks.is_empty(), "{what}: {:?}", picture.remarks);
    let found = code(picture, 0, 0).map(|c| f64::from(c) / 257.0);
    for (found_one, wanted_one) in found.iter().zip(wanted) {
        assert!(
            (found_one - wanted_one).abs() < within,
            "{what}: {found:?} in place of {wanted:?}"
        );
    }
}

#[test]
fn photographers_colour_spaces_are_converted() {
    // Within sRGB, and one outside it, which is clipped.
    for rgb in [[180, 120, 90], [60, 90, 160], [128; 3], [10, 240, 20]] {
        let codes = rgb.map(f64::from);
        let with_profile = |profile: ColorProfile| {
            let icc = profile.encode().unwrap();
            decode(&png_with(rgb, |info| {
                info.icc_profile = Some(icc.clone().into())
            }))
        };
        // The profiles hold 16-bit numbers; a code's share of 255 is what that leaves.
        let adobe = adobe_to_srgb(codes);
        let by_profile = with_profile(ColorProfile::new_adobe_rgb());
        near_codes(&by_profile, adobe, 0.6, "Adobe RGB");
        let romm = pro_photo_to_srgb(codes);
        let by_profile = with_profile(ColorProfile::new_pro_photo_rgb());
        near_codes(&by_profile, romm, 0.6, "ProPhoto RGB");
        // The same space by the chunks that a PNG has for it.
        let place = |x: u32, y: u32| {
            let share = |n: u32| png::ScaledFloat::from_scaled(n);
            (share(x), share(y))
        };
        let by_chunks = decode(&png_with(rgb, |info| {
            info.source_gamma = Some(png::ScaledFloat::from_scaled(45_471));
            info.source_chromaticities = Some(png::SourceChromaticities {
                white: place(31_270, 32_900),
                red: place(64_000, 33_000),
                green: place(21_000, 71_000),
                blue: place(15_000, 6_000),
            });
        }));
        near_codes(&by_chunks, adobe, 0.6, "gAMA and cHRM");
        if rgb != [128; 3] {
            let off =
                |other: [f64; 3]| (other[0] - codes[0]).abs().max((other[2] - codes[2]).abs());
            assert!(off(adobe) > 3.0 && off(romm) > 3.0, "nothing to convert");
        }
    }
}

#[test]
fn profiles_that_cannot_be_unpacked_are_said() {
    let plain = png_with([9; 3], |_| {});
    // A name, method 0, and what is no zlib; and a chunk whose sum is wrong, which readers pass over.
    let unpacked = with_chunk(&plain, b"iCCP", b"profile\0\0nonsense");
    let mut summed = unpacked.clone();
    summed[33 + 8 + 17] ^= 1;
    // The first of two parts, the second of which is not there.
    let mut jpeg = turned_jpeg(1);
    let part = b"\xff\xe2\0\x18ICC_PROFILE\0\x01\x02profile.";
    jpeg.splice(2..2, part.iter().copied());
    for bytes in [unpacked, summed, jpeg] {
        let picture = decode(&bytes);
        assert!(
            picture.remarks.len() == 1 && picture.remarks[0].contains("profile is broken"),
            "{:?}",
            picture.remarks
        );
        let data = decode_picture(&bytes, "d", 1, Meaning::Data).unwrap();
        assert!(data.remarks.is_empty(), "{:?}", data.remarks);
    }
    assert!(decode(&plain).remarks.is_empty());
}

/// A PNG with a chunk put in after its header.
fn with_chunk(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
    chunk.extend(kind);
    chunk.extend(data);
    // CRC-32 of PNG, appendix D.
    let sum = chunk[4..].iter().fold(u32::MAX, |mut sum, byte| {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 {
                0xedb8_8320 ^ (sum >> 1)
            } else {
                sum >> 1
            };
        }
        sum
    });
    chunk.extend((!sum).to_be_bytes());
    let mut bytes = png.to_vec();
    bytes.splice(33..33, chunk);
    bytes
}

#[test]
fn code_points_say_the_colour_space_before_all_else() {
    let rgb = [200, 100, 50];
    let adobe = ColorProfile::new_adobe_rgb().encode().unwrap();
    let png = png_with(rgb, |info| info.icc_profile = Some(adobe.clone().into()));
    // Display P3 is (12, 13), whatever profile stands beside it.
    let p3 = decode(&with_chunk(&png, b"cICP", &[12, 13, 0, 1]));
    near_codes(&p3, display_p3_to_srgb(rgb.map(f64::from)), 0.6, "cICP");
    let srgb = decode(&with_chunk(&png, b"cICP", &[1, 13, 0, 1]));
    near_codes(&srgb, rgb.map(f64::from), 0.6, "cICP of sRGB");
    // BT.2100 PQ and HLG, and what cannot be: said, and what else is there is taken.
    for (points, part) in [
        ([9, 16, 0, 1], "HDR"),
        ([9, 18, 0, 1], "HDR"),
        ([2, 13, 0, 1], "ignored"),
        ([12, 13, 0, 0], "ignored"),
        ([99, 250, 0, 1], "ignored"),
    ] {
        let picture = decode(&with_chunk(&png, b"cICP", &points));
        assert!(picture.remarks[0].contains(part), "{:?}", picture.remarks);
        let without = PictureFile {
            remarks: Vec::new(),
            ..picture
        };
        near_codes(
            &without,
            adobe_to_srgb(rgb.map(f64::from)),
            0.6,
            "beside cICP",
        );
    }
    // What the decoder refuses the whole file for, and a browser does not.
    let odd = with_chunk(&png_with(rgb, |_| {}), b"cICP", &[1, 13, 5, 1]);
    let picture = decode(&odd);
    assert!(
        picture.remarks[0].contains("broken"),
        "{:?}",
        picture.remarks
    );
    assert_eq!(code(&picture, 0, 0), rgb.map(|code| u16::from(code) * 257));
}

#[test]
fn transparency_and_palettes_survive() {
    let clear = RgbaImage::from_pixel(16, 16, Rgba([10, 20, 30, 0]));
    let picture = decode(&encoded(&clear.into(), ImageFormat::Png));
    assert_eq!(picture.image.to_rgba8().get_pixel(0, 0).0[3], 0);

    // Four of sixteen colours, one of them half transparent, two pixels a byte.
    let mut info = png::Info::with_size(4, 1);
    info.color_type = png::ColorType::Indexed;
    info.bit_depth = png::BitDepth::Four;
    info.palette = Some(vec![10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120].into());
    info.trns = Some(vec![255, 128].into());
    let mut bytes = Vec::new();
    let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[0x01, 0x32]).unwrap();
    writer.finish().unwrap();
    let rgba = decode(&bytes).image.to_rgba8();
    assert_eq!(
        rgba.into_raw(),
        [
            10, 20, 30, 255, 40, 50, 60, 128, 100, 110, 120, 255, 70, 80, 90, 255
        ]
    );
}

#[test]
fn animated_and_interlaced_pictures_show_their_default_image() {
    // Red is shown where nothing moves; green and blue are the animation.
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 16);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_animated(2, 0).unwrap();
    encoder.set_sep_def_img(true).unwrap();
    let mut writer = encoder.write_header().unwrap();
    for colour in [[200, 0, 0], [0, 200, 0], [0, 0, 200]] {
        writer.write_image_data(&colour.repeat(256)).unwrap();
    }
    writer.finish().unwrap();
    assert_eq!(
        decode(&bytes).image.to_rgb8().get_pixel(9, 9).0,
        [200, 0, 0]
    );

    let mut bytes = Vec::new();
    let mut encoder = image::codecs::gif::GifEncoder::new(&mut bytes);
    for colour in [[255, 0, 0], [0, 255, 0]] {
        let Rgb([r, g, b]) = Rgb(colour);
        let frame = RgbaImage::from_pixel(16, 16, Rgba([r, g, b, 255]));
        encoder.encode_frame(image::Frame::new(frame)).unwrap();
    }
    drop(encoder);
    assert_eq!(
        decode(&bytes).image.to_rgb8().get_pixel(9, 9).0,
        [255, 0, 0]
    );

    // Adam7: the same picture in seven passes.
    let interlaced = include_bytes!("../../../tests/data/interlaced.png");
    assert_eq!(interlaced[28], 1, "the header's interlace method");
    let found = decode(interlaced).image.to_rgb8();
    assert_eq!(found.dimensions(), (21, 13));
    for (x, y, pixel) in found.enumerate_pixels() {
        assert_eq!(
            pixel.0,
            [(12 * x) as u8, (19 * y) as u8, (x * y) as u8],
            "{x}, {y}"
        );
    }
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
