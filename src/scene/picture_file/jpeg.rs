//! What a JPEG file's markers say before it is decoded (ITU-T T.81, annex B).

use crate::input_file::one_clause;
use image::{DynamicImage, GrayImage, RgbImage};
use jpeg_decoder::{Decoder, PixelFormat};

/// Facts about a JPEG file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JpegFacts {
    /// It has an end marker.
    pub is_whole: bool,
    /// It is sequential, and its first scan has fewer components than the picture: the channels come
    /// one after the other.
    pub channels_follow_one_another: bool,
}

/// Reads the markers. A file that is no JPEG, or damaged, counts as cut off.
pub fn inspect(bytes: &[u8]) -> JpegFacts {
    let mut facts = JpegFacts {
        is_whole: false,
        channels_follow_one_another: false,
    };
    let (mut at, mut sequential, mut components, mut scans) = (2, false, 0, 0);
    while let Some(marker) = next_marker(bytes, &mut at) {
        match marker {
            0xd9 => {
                facts.is_whole = scans > 0;
                return facts;
            }
            // Restarts and the like stand alone.
            0x01 | 0xd0..=0xd8 => continue,
            _ => {}
        }
        let Some(length) = bytes.get(at..at + 2) else {
            break;
        };
        let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
        match marker {
            0xc0..=0xcf if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => {
                sequential = matches!(marker, 0xc0 | 0xc1);
                components = bytes.get(at + 7).copied().unwrap_or(0);
            }
            0xda => {
                let in_scan = bytes.get(at + 2).copied().unwrap_or(0);
                if scans == 0 {
                    facts.channels_follow_one_another = sequential && in_scan < components;
                }
                scans += 1;
            }
            _ => {}
        }
        at += length.max(2);
    }
    facts
}

/// The next marker after `at`, which then stands behind it; entropy-coded data, where 0xff is followed
/// by zero, is passed over.
fn next_marker(bytes: &[u8], at: &mut usize) -> Option<u8> {
    loop {
        let pair = bytes.get(*at..*at + 2)?;
        *at += 1;
        if pair[0] == 0xff && !matches!(pair[1], 0x00 | 0xff) {
            *at += 1;
            return Some(pair[1]);
        }
    }
}

/// Decodes a picture whose channels follow one another.
pub fn decode_channel_by_channel(bytes: &[u8]) -> Result<DynamicImage, String> {
    let mut decoder = Decoder::new(bytes);
    let pixels = decoder.decode().map_err(|error| one_clause(&error))?;
    let info = decoder.info().ok_or("it has no header")?;
    let (width, height) = (u32::from(info.width), u32::from(info.height));
    let unusual =
        || "its channels follow one another, which is read in grey and colour only: save it anew";
    match info.pixel_format {
        PixelFormat::L8 => GrayImage::from_raw(width, height, pixels).map(Into::into),
        PixelFormat::RGB24 => RgbImage::from_raw(width, height, pixels).map(Into::into),
        _ => None,
    }
    .ok_or_else(|| unusual().into())
}
