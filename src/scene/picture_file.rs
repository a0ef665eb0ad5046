//! Picture files as people have them: turned, in another colour space, cut off, or in a format that is
//! not read.
//!
//! Enters: a file's bytes. Leaves: a [`PictureFile`]: the picture upright, its colours converted to sRGB
//! ([`colour`]), and remarks on what was done or left out; or the sentence that says which format the
//! file is and what to save it as.

mod colour;
mod jpeg;

use super::catalog::other_format;
use super::model::SceneError;
use super::photo::{MAX_SIDE_PX, MAX_TEXELS};
use crate::input_file::one_clause;
use image::codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{
    AnimationDecoder, DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageFormat,
    ImageReader, Limits, Rgb,
};
use std::io::Cursor;

/// The formats that are read, for sentences.
pub const READABLE: &str = "PNG, JPEG, WebP, GIF, TIFF or BMP image";

/// A decoded picture.
#[derive(Debug, Clone)]
pub struct PictureFile {
    /// The picture, upright.
    pub image: DynamicImage,
    /// What a user should know about how the file was read, one sentence each.
    pub remarks: Vec<String>,
}

/// What the numbers of a picture mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// Colours: they are converted to sRGB by the file's colour profile.
    Colour,
    /// Measurements, such as distances: they stay as they are.
    Data,
}

/// Decodes a file within this program's limits and with at least `min_side` pixels each way.
pub fn decode_picture(
    bytes: &[u8],
    source_name: &str,
    min_side: u32,
    meaning: Meaning,
) -> Result<PictureFile, SceneError> {
    if bytes.is_empty() {
        return Err(SceneError::Empty {
            source_name: source_name.into(),
        });
    }
    let error = match decode_as_it_is(bytes, source_name, min_side, meaning) {
        Err(error) => error,
        picture => return picture,
    };
    // One bad chunk beside the picture, and the decoder refuses it all.
    let alone = png_picture_alone(bytes)
        .and_then(|png| decode_as_it_is(&png, source_name, min_side, meaning).ok());
    let Some(mut picture) = alone else {
        // A camera's raw picture, for one, passes for a TIFF.
        return Err(match (other_format(source_name), error) {
            (Some(reason), SceneError::Malformed { .. }) => malformed(source_name, reason),
            (_, error) => error,
        });
    };
    picture.remarks.push(format!(
        "\"{source_name}\": what its file says beside the picture, such as its colour space, is broken \
         and was ignored."
    ));
    Ok(picture)
}

fn malformed(source_name: &str, reason: String) -> SceneError {
    SceneError::Malformed {
        source_name: source_name.into(),
        kind: READABLE,
        reason,
    }
}

fn decode_as_it_is(
    bytes: &[u8],
    source_name: &str,
    min_side: u32,
    meaning: Meaning,
) -> Result<PictureFile, SceneError> {
    let malformed = |reason: String| malformed(source_name, reason);
    let format = readable_format(bytes).map_err(malformed)?;
    if let Some(announced) = png_size(bytes) {
        // The decoder would speak of memory.
        check_size(announced, min_side).map_err(malformed)?;
    }
    let mut decoder = ImageReader::with_format(Cursor::new(bytes), format)
        .into_decoder()
        .map_err(|error| malformed(fault(&error)))?;
    check_size(decoder.dimensions(), min_side).map_err(malformed)?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE_PX);
    limits.max_image_height = Some(MAX_SIDE_PX);
    // 16-bit RGBA of the largest image that is let through, and a decoder's own buffers.
    limits.max_alloc = Some(MAX_TEXELS * 8 + (64 << 20));
    decoder
        .set_limits(limits)
        .map_err(|error| malformed(fault(&error)))?;
    let mut remarks = Vec::new();
    // A turn that cannot be read is none, as with the invalid value 0.
    let turn = decoder.orientation().ok();
    let profile = decoder.icc_profile().ok().flatten();
    if meaning == Meaning::Colour && profile.is_none() && colour::announces_profile(bytes, format) {
        remarks.push(format!(
            "\"{source_name}\": its colour profile is broken and was ignored; sRGB is assumed."
        ));
    }
    let mut image = match format {
        ImageFormat::Jpeg => {
            let facts = jpeg::inspect(bytes);
            if !facts.is_whole {
                remarks.push(format!(
                    "\"{source_name}\" is cut off: its lower part may be missing."
                ));
            }
            if facts.channels_follow_one_another {
                jpeg::decode_channel_by_channel(bytes).map_err(malformed)?
            } else {
                DynamicImage::from_decoder(decoder).map_err(|e| malformed(fault(&e)))?
            }
        }
        _ => DynamicImage::from_decoder(decoder).map_err(|e| malformed(fault(&e)))?,
    };
    if let Some(turn) = turn {
        image.apply_orientation(turn);
    }
    if meaning == Meaning::Colour {
        image = colour::to_srgb(image, format, bytes, profile.as_deref(), &mut |remark| {
            remarks.push(format!("\"{source_name}\": {remark}"));
        });
    }
    Ok(PictureFile { image, remarks })
}

/// How long the browsers show a picture of which a file says that it passes at once, s.
const HURRIED_S: f64 = 0.1;
/// What they take for that, s.
const AT_ONCE_S: f64 = 0.01;

/// The pictures of a file that moves by itself.
#[derive(Debug, Default)]
pub struct Animation {
    /// Each with the seconds for which it is shown; none of a file that does not move.
    pub pictures: Vec<(DynamicImage, f64)>,
    /// Does the file break off after the last of them?
    pub is_cut: bool,
}

/// The pictures of a file that moves by itself, upright and in sRGB, and for how long each is seen (s); none of
/// a file that does not.
///
/// # Errors
/// One sentence on pictures that are damaged, or more than `most`.
pub fn animated_pictures(
    bytes: &[u8],
    source_name: &str,
    most: usize,
) -> Result<Animation, SceneError> {
    let damaged = |error: ImageError| malformed(source_name, fault(&error));
    let source = Cursor::new(bytes);
    let format = readable_format(bytes).map_err(|reason| malformed(source_name, reason))?;
    let (profile, frames) = match format {
        ImageFormat::Gif => (
            None,
            GifDecoder::new(source).map_err(damaged)?.into_frames(),
        ),
        ImageFormat::Png => {
            let mut decoder = PngDecoder::new(source).map_err(damaged)?;
            if !decoder.is_apng().unwrap_or(false) {
                return Ok(Animation::default());
            }
            let profile = decoder.icc_profile().ok().flatten();
            (profile, decoder.apng().map_err(damaged)?.into_frames())
        }
        ImageFormat::WebP => {
            let mut decoder = WebPDecoder::new(source).map_err(damaged)?;
            if !decoder.has_animation() {
                return Ok(Animation::default());
            }
            (decoder.icc_profile().ok().flatten(), decoder.into_frames())
        }
        _ => return Ok(Animation::default()),
    };
    let (mut pictures, mut is_cut) = (Vec::new(), false);
    for frame in frames {
        let frame = match frame {
            Ok(frame) => frame,
            // Of a file that is cut off what is whole is seen.
            Err(_) if !pictures.is_empty() => {
                is_cut = true;
                break;
            }
            Err(error) => return Err(damaged(error)),
        };
        if pictures.len() == most {
            return Err(SceneError::Content {
                source_name: source_name.into(),
                reason: format!(
                    "it has more than {most} pictures, the most of their size that are kept: take fewer or smaller ones"
                ),
            });
        }
        let (ms, parts) = frame.delay().numer_denom_ms();
        let seconds = f64::from(ms) / f64::from(parts.max(1)) / 1000.0;
        let seconds = if seconds > AT_ONCE_S {
            seconds
        } else {
            HURRIED_S
        };
        let image = DynamicImage::ImageRgba8(frame.into_buffer());
        let image = colour::to_srgb(image, format, bytes, profile.as_deref(), &mut |_| {});
        pictures.push((image, seconds));
    }
    Ok(Animation { pictures, is_cut })
}

/// A PNG without its ancillary chunks, but for transparency; `None` of other files, and of chunks that
/// do not follow one another.
fn png_picture_alone(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut alone = PNG_SIGNATURE.to_vec();
    let mut read = alone.len();
    for (kind, chunk) in png_chunks(bytes) {
        // Critical chunks begin with a capital letter.
        if kind[0].is_ascii_uppercase() || kind == b"tRNS" {
            alone.extend(chunk);
        }
        read += chunk.len();
    }
    (read == bytes.len()).then_some(alone)
}

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The chunks of a PNG, as kind and whole chunk, as far as they follow one another; none of other files.
fn png_chunks(bytes: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    let mut rest = bytes.strip_prefix(PNG_SIGNATURE).unwrap_or_default();
    std::iter::from_fn(move || {
        let length = u32::from_be_bytes(*rest.first_chunk()?) as usize;
        let (chunk, after) = rest.split_at_checked(length.checked_add(12)?)?;
        rest = after;
        Some((&chunk[4..8], chunk))
    })
}

/// Why a picture is not decoded, in a user's words.
fn fault(error: &ImageError) -> String {
    let clause = one_clause(error);
    match error {
        _ if clause.starts_with("it is cut off") => clause,
        ImageError::Limits(_) => clause,
        ImageError::Unsupported(_) => {
            "it is stored in a way that is not read: save it again as PNG or JPEG".into()
        }
        _ => "its data are damaged or cut off".into(),
    }
}

/// Width and height in the header of a PNG.
fn png_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let side = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_be_bytes([four[0], four[1], four[2], four[3]]))
    };
    let is_png = bytes.starts_with(b"\x89PNG") && bytes.get(12..16) == Some(b"IHDR");
    is_png.then(|| Some((side(16)?, side(20)?))).flatten()
}

fn check_size((width, height): (u32, u32), min_side: u32) -> Result<(), String> {
    if width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(format!(
            "it is {width}×{height} pixels, but neither side may exceed {MAX_SIDE_PX}"
        ));
    }
    if width < min_side || height < min_side {
        return Err(format!(
            "it is {width}×{height} pixels, but both sides must be at least {min_side}"
        ));
    }
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(format!(
            "it is {width}×{height} pixels, but may have at most {MAX_TEXELS} in all"
        ));
    }
    Ok(())
}

/// The format that the file's first bytes show, if it is one that is read; else what to do about it.
fn readable_format(bytes: &[u8]) -> Result<ImageFormat, String> {
    use ImageFormat::{Bmp, Gif, Jpeg, Png, Tiff, WebP};
    match image::guess_format(bytes) {
        Ok(format @ (Png | Jpeg | WebP | Gif | Tiff | Bmp)) => Ok(format),
        other => Err(foreign_format(bytes).map_or_else(
            || match other.ok().and_then(|format| format.extensions_str().first().copied()) {
                Some(extension) => format!(
                    "it is a picture in another format (.{extension}), which is not read: save it as PNG or JPEG"
                ),
                None => "its content is of no known picture format".into(),
            },
            |name| format!("it is {name}, which is not read: save it as PNG or JPEG"),
        )),
    }
}

/// The picture format of a file that is not read, with its article.
pub fn foreign_format(bytes: &[u8]) -> Option<&'static str> {
    // ISO base media files name their brand after `ftyp`.
    if bytes.get(4..8) == Some(b"ftyp") {
        let end = bytes
            .first_chunk()
            .map_or(0, |four| u32::from_be_bytes(*four)) as usize;
        // The major brand may be that of any such file; which it is say the compatible ones.
        let compatible = bytes.get(16..end.min(bytes.len())).unwrap_or_default();
        let is_avif = compatible
            .chunks_exact(4)
            .any(|b| b == b"avif" || b == b"avis");
        return match bytes.get(8..12)? {
            b"avif" | b"avis" => Some("an AVIF picture"),
            b"mif1" | b"msf1" if is_avif => Some("an AVIF picture"),
            b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"mif1" | b"msf1" => {
                Some("a HEIC picture")
            }
            b"crx " => Some("a camera's raw picture (CR3)"),
            _ => Some("a video"),
        };
    }
    let starts: [(&[u8], &str); 13] = [
        (b"\xff\x0a", "a JPEG XL picture"),
        (b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
        (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
        (b"\xff\x4f\xff\x51", "a JPEG 2000 picture"),
        (b"8BPS", "a Photoshop document"),
        (b"%PDF", "a PDF document"),
        (b"<svg", "an SVG drawing"),
        (b"#?RADIANCE", "a Radiance HDR picture"),
        (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
        (b"DDS ", "a DDS texture"),
        (b"\xabKTX ", "a KTX texture"),
        (b"qoif", "a QOI picture"),
        (b"\0\0\x01\0", "an icon (ICO)"),
    ];
    let known = starts
        .iter()
        .find(|(start, _)| bytes.starts_with(start))
        .map(|(_, name)| *name);
    let head = &bytes[..bytes.len().min(512)];
    known.or_else(|| {
        head.windows(4)
            .any(|four| four == b"<svg")
            .then_some("an SVG drawing")
    })
}

/// A picture without transparency: what shines through stands on white, as paper would show it.
pub fn on_white(image: DynamicImage) -> ImageBuffer<Rgb<u16>, Vec<u16>> {
    let rgba = image.into_rgba16();
    let (width, height) = rgba.dimensions();
    let white = u32::from(u16::MAX);
    let over = |code: u16, alpha: u16| {
        let (code, alpha) = (u32::from(code), u32::from(alpha));
        ((code * alpha + white * (white - alpha) + white / 2) / white) as u16
    };
    let mut rgb = ImageBuffer::new(width, height);
    for (to, from) in rgb.pixels_mut().zip(rgba.pixels()) {
        *to = Rgb([0, 1, 2].map(|channel| over(from.0[channel], from.0[3])));
    }
    rgb
}

#[cfg(test)]
mod tests;
