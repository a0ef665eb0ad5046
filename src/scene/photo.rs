//! A photograph as a scene: an image, a depth for each of its pixels and a field of view.
//!
//! Enters: a PNG or JPEG file, optionally a grey 8- or 16-bit depth image. Leaves: a
//! [`PhotoScene`].
//!
//! Depth convention: a depth image is linear in vergence, as stereo disparity is. Its value `g`
//! (0–1, that is code/255 or code/65535) means `1/depth = 1/far + g · (1/near − 1/far)`: white is
//! near, black is far. By default near is 0.5 m and far is infinity. A depth image of another size
//! is resampled linearly in vergence. Without one, the whole photograph stands at 3 m.

use super::model::{SceneError, luminance, srgb_to_linear};
use image::{DynamicImage, ImageReader, Limits, imageops};
use std::io::Cursor;
use std::path::Path;

/// Largest width or height of an image, texels: the largest texture of a common GPU.
pub const MAX_SIDE_PX: u32 = 16_384;
/// Smallest width or height of a photograph, texels: the corner detector needs a 7-texel circle
/// with room around it.
pub const MIN_SIDE_PX: u32 = 16;
/// Largest number of texels of an image: 256 MiB as RGBA.
pub const MAX_TEXELS: u64 = 64 << 20;
/// Luminance given to a photograph's white, cd/m²: a bright display.
pub const WHITE_CD_M2: f64 = 250.0;

/// A photograph with depth.
#[derive(Debug, Clone)]
pub struct PhotoScene {
    /// File name for lists and reports.
    pub name: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major sRGB-encoded RGBA, top row first; alpha is 255.
    pub rgba8_srgb: Vec<u8>,
    /// Distance from the eye, m.
    pub depth_m: PhotoDepth,
    /// Vertical extent of the photograph as seen from the eye, degrees.
    pub vertical_fov_deg: f32,
    /// Mean luminance with white at [`WHITE_CD_M2`], cd/m².
    pub mean_luminance_cd_m2: f64,
}

/// Distances in a photograph, m.
#[derive(Debug, Clone, PartialEq)]
pub enum PhotoDepth {
    /// One distance everywhere.
    Constant(f32),
    /// One distance a pixel, row-major; infinity is allowed.
    Map(Vec<f32>),
}

/// What a photograph does not say itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoOptions {
    /// Distance of white in the depth image, m, above 0.
    pub near_m: f32,
    /// Distance of black in the depth image, m, above `near_m`; infinity is allowed.
    pub far_m: f32,
    /// Distance of the whole photograph when there is no depth image, m, above 0.
    pub flat_depth_m: f32,
    /// Vertical field of view, degrees, 1–120.
    pub vertical_fov_deg: f32,
}

impl Default for PhotoOptions {
    fn default() -> Self {
        Self {
            near_m: 0.5,
            far_m: f32::INFINITY,
            flat_depth_m: 3.0,
            vertical_fov_deg: 50.0,
        }
    }
}

impl PhotoOptions {
    fn check(&self, source_name: &str) -> Result<(), SceneError> {
        let fault = |field: &str, value: f32, range: &str| {
            Err(SceneError::Content {
                source_name: source_name.into(),
                reason: format!("{field} is {value}, but must be {range}"),
            })
        };
        if !(self.near_m > 0.0 && self.near_m.is_finite()) {
            return fault("near_m", self.near_m, "a finite distance above 0 m");
        }
        if self.far_m.is_nan() || self.far_m <= self.near_m {
            return fault("far_m", self.far_m, "greater than near_m");
        }
        if self.flat_depth_m.is_nan() || self.flat_depth_m <= 0.0 {
            return fault("flat_depth_m", self.flat_depth_m, "above 0 m");
        }
        if !(1.0..=120.0).contains(&self.vertical_fov_deg) {
            return fault("vertical_fov_deg", self.vertical_fov_deg, "1 to 120");
        }
        Ok(())
    }

    /// Distance for a depth image's value `g` in 0–1, m.
    pub fn depth_m(&self, g: f32) -> f32 {
        let far_d = 1.0 / self.far_m;
        let vergence_d = far_d + g * (1.0 / self.near_m - far_d);
        if vergence_d > 0.0 {
            1.0 / vergence_d
        } else {
            f32::INFINITY
        }
    }
}

impl PhotoScene {
    /// Distance of one pixel, m.
    pub fn depth_at_m(&self, x: u32, y: u32) -> f32 {
        match &self.depth_m {
            PhotoDepth::Constant(distance) => *distance,
            PhotoDepth::Map(map) => map[y as usize * self.width as usize + x as usize],
        }
    }
}

/// Reads a whole file, with the sentence for each way in which that fails.
pub fn read_file(path: &Path) -> Result<Vec<u8>, SceneError> {
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => SceneError::Missing { path: path.into() },
        _ => SceneError::Unreadable {
            path: path.into(),
            reason: error.to_string(),
        },
    })?;
    if bytes.is_empty() {
        return Err(SceneError::Empty {
            source_name: path.display().to_string(),
        });
    }
    Ok(bytes)
}

/// Loads a photograph and, where given, its depth image.
pub fn load_photo(
    path: &Path,
    depth: Option<&Path>,
    options: &PhotoOptions,
) -> Result<PhotoScene, SceneError> {
    let photo = read_file(path)?;
    let depth_file = depth.map(read_file).transpose()?;
    let depth_name = depth.map(|d| d.display().to_string()).unwrap_or_default();
    let depth = depth_file
        .as_deref()
        .map(|bytes| (bytes, depth_name.as_str()));
    load_photo_bytes(&photo, &path.display().to_string(), depth, options)
}

/// Loads a photograph from memory; `depth` is the depth file's bytes and name.
pub fn load_photo_bytes(
    bytes: &[u8],
    source_name: &str,
    depth: Option<(&[u8], &str)>,
    options: &PhotoOptions,
) -> Result<PhotoScene, SceneError> {
    options.check(source_name)?;
    let photo = decode_image(bytes, source_name, MIN_SIDE_PX)?;
    let mut rgba = photo.into_rgba8();
    // A photograph hides nothing: transparent parts stand on white, as paper would show them.
    for pixel in rgba.pixels_mut() {
        let alpha = u16::from(pixel.0[3]);
        for channel in &mut pixel.0[..3] {
            *channel = ((u16::from(*channel) * alpha + 255 * (255 - alpha)) / 255) as u8;
        }
        pixel.0[3] = 255;
    }
    let (width, height) = rgba.dimensions();
    let depth_m = match depth {
        Some((bytes, name)) => PhotoDepth::Map(read_depth(bytes, name, (width, height), options)?),
        None => PhotoDepth::Constant(options.flat_depth_m),
    };
    let total: f64 = rgba
        .pixels()
        .map(|p| f64::from(luminance([0, 1, 2].map(|k| srgb_to_linear(p.0[k])))))
        .sum();
    Ok(PhotoScene {
        name: source_name.into(),
        width,
        height,
        mean_luminance_cd_m2: WHITE_CD_M2 * total / (f64::from(width) * f64::from(height)),
        rgba8_srgb: rgba.into_raw(),
        depth_m,
        vertical_fov_deg: options.vertical_fov_deg,
    })
}

fn read_depth(
    bytes: &[u8],
    name: &str,
    size: (u32, u32),
    options: &PhotoOptions,
) -> Result<Vec<f32>, SceneError> {
    let image = decode_image(bytes, name, 1)?;
    if image.color().has_color() {
        return Err(SceneError::Malformed {
            source_name: name.into(),
            kind: "depth image",
            reason: "it is in colour, but must be an 8- or 16-bit grey PNG (white is near)".into(),
        });
    }
    let mut grey = image.into_luma16();
    if grey.dimensions() != size {
        grey = imageops::resize(&grey, size.0, size.1, imageops::FilterType::Triangle);
    }
    Ok(grey
        .pixels()
        .map(|p| options.depth_m(f32::from(p.0[0]) / 65535.0))
        .collect())
}

/// Decodes a PNG or JPEG file within this module's limits and with at least `min_side` texels
/// each way.
pub fn decode_image(
    bytes: &[u8],
    source_name: &str,
    min_side: u32,
) -> Result<DynamicImage, SceneError> {
    let malformed = |reason: String| SceneError::Malformed {
        source_name: source_name.into(),
        kind: "PNG or JPEG image",
        reason,
    };
    if bytes.is_empty() {
        return Err(SceneError::Empty {
            source_name: source_name.into(),
        });
    }
    let open = || {
        ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| malformed(error.to_string()))
    };
    let reader = open()?;
    if reader.format().is_none() {
        return Err(malformed("its content is neither PNG nor JPEG".into()));
    }
    let (width, height) = reader
        .into_dimensions()
        .map_err(|e| malformed(one_clause(&e)))?;
    if width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(malformed(format!(
            "it is {width}×{height} pixels, but neither side may exceed {MAX_SIDE_PX}"
        )));
    }
    if width < min_side || height < min_side {
        return Err(malformed(format!(
            "it is {width}×{height} pixels, but both sides must be at least {min_side}"
        )));
    }
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(malformed(format!(
            "it is {width}×{height} pixels, but may have at most {MAX_TEXELS} in all"
        )));
    }
    let mut reader = open()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE_PX);
    limits.max_image_height = Some(MAX_SIDE_PX);
    // 16-bit RGBA of the largest image that is let through, and a decoder's own buffers.
    limits.max_alloc = Some(MAX_TEXELS * 8 + (64 << 20));
    reader.limits(limits);
    reader
        .decode()
        .map_err(|error| malformed(one_clause(&error)))
}

/// A library's message as part of a sentence: one line, no full stop.
pub fn one_clause(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageFormat, Luma, Rgb, RgbImage};
    use proptest::prelude::*;

    fn png(image: &DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn grey_photo(width: u32, height: u32, value: u8) -> Vec<u8> {
        png(&RgbImage::from_pixel(width, height, Rgb([value; 3])).into())
    }

    fn load(bytes: &[u8]) -> Result<PhotoScene, SceneError> {
        load_photo_bytes(bytes, "photo.png", None, &PhotoOptions::default())
    }

    #[test]
    fn a_photo_keeps_its_pixels_and_stands_at_three_metres() {
        let photo = load(&grey_photo(32, 16, 188)).unwrap();
        assert_eq!((photo.width, photo.height), (32, 16));
        assert_eq!(&photo.rgba8_srgb[..4], &[188, 188, 188, 255]);
        assert_eq!(photo.depth_m, PhotoDepth::Constant(3.0));
        // Code 188 is 50.3 % of white's light.
        assert!((photo.mean_luminance_cd_m2 / WHITE_CD_M2 - 0.5029).abs() < 1e-3);
    }

    #[test]
    fn depth_is_linear_in_dioptres_and_white_is_near() {
        let options = PhotoOptions {
            near_m: 0.25,
            far_m: 4.0,
            ..Default::default()
        };
        assert!((options.depth_m(1.0) - 0.25).abs() < 1e-6);
        assert!((options.depth_m(0.0) - 4.0).abs() < 1e-5);
        // Half-way between 0.25 D and 4 D is 2.125 D.
        assert!((options.depth_m(0.5) - 1.0 / 2.125).abs() < 1e-6);
        assert_eq!(PhotoOptions::default().depth_m(0.0), f32::INFINITY);
        let ramp = GrayImage::from_fn(16, 16, |x, _| Luma([if x < 8 { 255 } else { 0 }]));
        let depth = png(&ramp.into());
        // The photograph is twice as large, so the depth image is resampled.
        let photo = load_photo_bytes(
            &grey_photo(32, 32, 99),
            "p",
            Some((&depth, "d")),
            &PhotoOptions::default(),
        )
        .unwrap();
        assert!((photo.depth_at_m(0, 0) - 0.5).abs() < 1e-6);
        assert_eq!(photo.depth_at_m(31, 31), f32::INFINITY);
        let sixteen = image::ImageBuffer::from_pixel(32, 32, Luma([65535u16 / 5]));
        let depth = png(&DynamicImage::ImageLuma16(sixteen));
        let photo = load_photo_bytes(
            &grey_photo(32, 32, 99),
            "p",
            Some((&depth, "d")),
            &PhotoOptions::default(),
        )
        .unwrap();
        assert!((photo.depth_at_m(5, 5) - 2.5).abs() < 1e-5, "0.2 of 2 D");
    }

    #[test]
    fn each_bad_file_gets_its_own_sentence() {
        let cases: [(Vec<u8>, &str); 6] = [
            (Vec::new(), "is empty"),
            (b"just some text".to_vec(), "neither PNG nor JPEG"),
            (grey_photo(1, 1, 9), "1×1"),
            (grey_photo(20_000, 16, 9), "20000×16"),
            (grey_photo(64, 64, 9)[..60].to_vec(), "not a usable"),
            (grey_photo(16_384, 4_200, 9), "in all"),
        ];
        for (bytes, part) in cases {
            let message = load(&bytes).unwrap_err().to_string();
            assert!(
                message.contains(part) && message.contains("photo.png"),
                "{message}"
            );
            assert!(
                message.ends_with('.') && !message.contains('\n'),
                "{message}"
            );
        }
        let missing = load_photo(Path::new("/no/such.png"), None, &PhotoOptions::default());
        assert_eq!(
            missing.unwrap_err().to_string(),
            "The scene file \"/no/such.png\" does not exist."
        );
        let colour = grey_photo(16, 16, 9);
        let result = load_photo_bytes(
            &colour,
            "p",
            Some((&colour, "d.png")),
            &PhotoOptions::default(),
        );
        assert!(result.unwrap_err().to_string().contains("in colour"));
    }

    #[test]
    fn impossible_options_are_refused_by_name() {
        for (options, field) in [
            (
                PhotoOptions {
                    near_m: 0.0,
                    ..Default::default()
                },
                "near_m",
            ),
            (
                PhotoOptions {
                    far_m: 0.4,
                    ..Default::default()
                },
                "far_m",
            ),
            (
                PhotoOptions {
                    far_m: f32::NAN,
                    ..Default::default()
                },
                "far_m",
            ),
            (
                PhotoOptions {
                    flat_depth_m: -1.0,
                    ..Default::default()
                },
                "flat_depth_m",
            ),
            (
                PhotoOptions {
                    vertical_fov_deg: 180.0,
                    ..Default::default()
                },
                "vertical_fov_deg",
            ),
        ] {
            let error = load_photo_bytes(&grey_photo(16, 16, 9), "p", None, &options).unwrap_err();
            assert!(error.to_string().contains(field), "{error}");
        }
    }

    proptest! {
        #[test]
        fn truncated_or_damaged_files_never_panic(cut in 0usize..400, at in 0usize..400, value: u8) {
            let noisy = RgbImage::from_fn(24, 24, |x, y| Rgb([((x * 37) ^ (y * 91)) as u8, x as u8, y as u8]));
            let mut bytes = png(&noisy.into());
            let at = at.min(bytes.len() - 1);
            bytes[at] = value;
            bytes.truncate(bytes.len().saturating_sub(cut));
            let _ = load(&bytes);
        }
    }
}
