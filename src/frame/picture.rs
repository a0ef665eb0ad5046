//! Pictures of panels, put together and encoded: for `render` and for what is saved by hand.

use image::{ExtendedColorType, ImageEncoder, RgbaImage, codecs::png::PngEncoder, imageops};

/// PNG bytes of an opaque picture.
pub fn encode_png(picture: &RgbaImage) -> Result<Vec<u8>, image::ImageError> {
    let rgb = image::DynamicImage::ImageRgba8(picture.clone()).to_rgb8();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(
        &rgb,
        rgb.width(),
        rgb.height(),
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// Two pictures side by side, aligned at their tops; black where the lower one ends.
pub fn side_by_side(left: &RgbaImage, right: &RgbaImage) -> RgbaImage {
    let height = left.height().max(right.height());
    let black = image::Rgba([0, 0, 0, 255]);
    let mut both = RgbaImage::from_pixel(left.width() + right.width(), height, black);
    imageops::replace(&mut both, left, 0, 0);
    imageops::replace(&mut both, right, i64::from(left.width()), 0);
    both
}

/// A picture from rows of RGBA that a GPU has padded to `padded` bytes; `None` where they are too few.
pub fn from_padded_rows(width: u32, height: u32, padded: usize, bytes: &[u8]) -> Option<RgbaImage> {
    let row = width as usize * 4;
    if padded < row || bytes.len() < padded * height as usize {
        return None;
    }
    let pixels = bytes
        .chunks_exact(padded)
        .take(height as usize)
        .flat_map(|line| &line[..row])
        .copied()
        .collect();
    RgbaImage::from_raw(width, height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    #[test]
    fn rows_lose_their_padding_and_pictures_stand_side_by_side() {
        let bytes: Vec<u8> = (0..=255).cycle().take(2 * 256).collect();
        let narrow = from_padded_rows(2, 2, 256, &bytes).expect("two rows");
        assert_eq!(narrow.get_pixel(1, 1), &Rgba([4, 5, 6, 7]));
        assert_eq!(from_padded_rows(2, 3, 256, &bytes), None);
        assert_eq!(from_padded_rows(65, 1, 256, &bytes), None);
        let both = side_by_side(&narrow, &RgbaImage::from_pixel(1, 3, Rgba([9; 4])));
        assert_eq!(both.dimensions(), (3, 3));
        assert_eq!(both.get_pixel(2, 2), &Rgba([9; 4]));
        assert_eq!(both.get_pixel(0, 2), &Rgba([0, 0, 0, 255]));
        let again = image::load_from_memory(&encode_png(&both).expect("a PNG"));
        assert_eq!(again.expect("read").to_rgb8().get_pixel(2, 2).0, [9; 3]);
    }
}
