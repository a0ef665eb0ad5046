//! A photograph as a scene: an image, a depth for each of its pixels and a field of view.
//!
//! Enters: a picture file ([`picture_file`](super::picture_file)), optionally a depth image
//! ([`depth_file`](super::depth_file)). Leaves: a [`PhotoScene`].
//!
//! Without a depth image, the whole photograph stands at one distance, 3 m unless told otherwise.

use super::depth_file::{DepthUnit, read_depth};
use super::model::SceneError;
use super::picture_file::{Meaning, decode_picture, on_white};
use super::pictures::{PictureCourse, mean_luminance_cd_m2};
use crate::input_file::read_input_file;
use std::path::Path;
use std::sync::Arc;

/// Largest width or height of an image, texels: the largest texture of a common GPU.
pub const MAX_SIDE_PX: u32 = 16_384;
/// Smallest width or height of a photograph, texels: the corner detector needs a 7-texel circle
/// with room around it.
pub const MIN_SIDE_PX: u32 = 16;
/// Largest number of texels of an image: 256 MiB as RGBA.
pub const MAX_TEXELS: u64 = 64 << 20;
/// Largest file that is read, bytes.
pub const MAX_FILE_BYTES: u64 = 4 << 30;
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
    /// Row-major sRGB-encoded RGB of 16 bits, top row first.
    pub rgb16_srgb: Vec<u16>,
    /// Distance from the eye, m.
    pub depth_m: PhotoDepth,
    /// Vertical extent of the photograph as seen from the eye, degrees.
    pub vertical_fov_deg: f32,
    /// Mean luminance with white at [`WHITE_CD_M2`], cd/m².
    pub mean_luminance_cd_m2: f64,
    /// The pictures that take one another's place, of which the one above is the first.
    pub course: Option<Arc<PictureCourse>>,
    /// What a user should know about how the files were read, one sentence each.
    pub remarks: Vec<String>,
}

/// Distances in a photograph, m.
#[derive(Debug, Clone, PartialEq)]
pub enum PhotoDepth {
    /// One distance everywhere.
    Constant(f32),
    /// One distance a pixel, row-major; infinity is allowed.
    Map(Vec<f32>),
}

impl PhotoDepth {
    /// The distance, where it is the same everywhere.
    pub fn constant_m(&self) -> Option<f32> {
        match self {
            Self::Constant(distance_m) => Some(*distance_m),
            Self::Map(_) => None,
        }
    }

    /// Is all of it infinitely far away?
    pub fn is_far(&self) -> bool {
        match self {
            Self::Constant(distance_m) => distance_m.is_infinite(),
            Self::Map(map) => map.iter().all(|distance_m| distance_m.is_infinite()),
        }
    }
}

/// What a photograph does not say itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoOptions {
    /// What the depth image's codes mean; `None` reads them as [`read_depth`] finds likely.
    pub depth_unit: Option<DepthUnit>,
    /// Distance of white in the depth image, m, above 0.
    pub near_m: f32,
    /// Distance of black in the depth image, m, above `near_m`; infinity is allowed.
    pub far_m: f32,
    /// Distance of the whole photograph when there is no depth image, m, above 0.
    pub flat_depth_m: f32,
    /// Vertical field of view, degrees, 1–120.
    pub vertical_fov_deg: f32,
    /// Pictures a second of several, 0.1–240; `None`: as a moving file says, or 25.
    pub fps: Option<f32>,
}

impl Default for PhotoOptions {
    fn default() -> Self {
        Self {
            depth_unit: None,
            near_m: 0.5,
            far_m: f32::INFINITY,
            flat_depth_m: 3.0,
            vertical_fov_deg: 50.0,
            fps: None,
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
        if let Some(fps) = self.fps.filter(|fps| !(0.1..=240.0).contains(fps)) {
            return fault("fps", fps, "0.1 to 240");
        }
        Ok(())
    }
}

impl PhotoScene {
    /// Which of its pictures is seen at a time (s, from 0); 0 where it has but one.
    pub fn picture_at(&self, time_s: f64) -> usize {
        self.course
            .as_ref()
            .map_or(0, |course| course.index_at(time_s))
    }

    /// Row-major sRGB-encoded RGB of 16 bits of one of its pictures; of the first where there is no such.
    pub fn picture(&self, index: usize) -> &[u16] {
        let course = self.course.as_ref();
        let picture = course.and_then(|course| course.pictures.get(index));
        picture.map_or(&self.rgb16_srgb, |picture| &picture.rgb16_srgb)
    }

    /// Mean luminance of one of its pictures, cd/m².
    pub fn picture_luminance_cd_m2(&self, index: usize) -> f64 {
        let course = self.course.as_ref();
        let picture = course.and_then(|course| course.pictures.get(index));
        picture.map_or(self.mean_luminance_cd_m2, |picture| {
            picture.mean_luminance_cd_m2
        })
    }

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
    read_named_file(path, "scene file")
}

/// [`read_file`] of a file that sentences call `kind`.
pub fn read_named_file(path: &Path, kind: &'static str) -> Result<Vec<u8>, SceneError> {
    let bytes = read_input_file(path, MAX_FILE_BYTES).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => SceneError::Missing {
            kind,
            path: path.into(),
        },
        _ => SceneError::Unreadable {
            kind,
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

/// Loads a photograph from memory; `depth` is the depth file's bytes and name.
pub fn load_photo_bytes(
    bytes: &[u8],
    source_name: &str,
    depth: Option<(&[u8], &str)>,
    options: &PhotoOptions,
) -> Result<PhotoScene, SceneError> {
    options.check(source_name)?;
    let picture = decode_picture(bytes, source_name, MIN_SIDE_PX, Meaning::Colour)?;
    let mut remarks = picture.remarks;
    let rgb = on_white(picture.image);
    let (width, height) = rgb.dimensions();
    let rgb16_srgb = rgb.into_raw();
    let depth_m = match depth {
        Some((bytes, name)) => {
            let (map, said) = read_depth(bytes, name, (width, height), options)?;
            remarks.extend(said);
            PhotoDepth::Map(map)
        }
        None => PhotoDepth::Constant(options.flat_depth_m),
    };
    Ok(PhotoScene {
        name: source_name.into(),
        width,
        height,
        mean_luminance_cd_m2: mean_luminance_cd_m2(&rgb16_srgb),
        rgb16_srgb,
        depth_m,
        vertical_fov_deg: options.vertical_fov_deg,
        course: None,
        remarks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage};
    use proptest::prelude::*;
    use std::io::Cursor;

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
        assert_eq!(&photo.rgb16_srgb[..3], &[188 * 257; 3]);
        assert_eq!(photo.depth_m, PhotoDepth::Constant(3.0));
        // Code 188 is 50.3 % of white's light.
        assert!((photo.mean_luminance_cd_m2 / WHITE_CD_M2 - 0.5029).abs() < 1e-3);
    }

    #[test]
    fn depth_is_linear_in_dioptres_and_white_is_near() {
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
        let sixteen = image::ImageBuffer::from_pixel(32, 32, Luma([65535u16 / 5 * 2]));
        let depth = png(&DynamicImage::ImageLuma16(sixteen));
        let photo = load_photo_bytes(
            &grey_photo(32, 32, 99),
            "p",
            Some((&depth, "d")),
            &PhotoOptions::default(),
        )
        .unwrap();
        assert!((photo.depth_at_m(5, 5) - 1.25).abs() < 1e-5, "0.4 of 2 D");
    }

    #[test]
    fn each_bad_file_gets_its_own_sentence() {
        let cases: [(Vec<u8>, &str); 6] = [
            (Vec::new(), "is empty"),
            (b"just some text".to_vec(), "no known picture format"),
            (grey_photo(1, 1, 9), "1×1"),
            (grey_photo(20_000, 16, 9), "20000×16"),
            (grey_photo(64, 64, 9)[..60].to_vec(), "cut off"),
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
        let missing = read_file(Path::new("/no/such.png"));
        assert_eq!(
            missing.unwrap_err().to_string(),
            "The scene file \"/no/such.png\" does not exist."
        );
        let colour = png(&RgbImage::from_pixel(16, 16, Rgb([9, 10, 9])).into());
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
