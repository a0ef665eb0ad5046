//! Pictures that follow one another: a folder of them, several files, or an animated GIF, PNG or WebP.
//!
//! Enters: files. Leaves: a [`PhotoScene`] whose picture changes with time ([`PictureCourse`]), from its
//! first to its last and again from the first.

use super::model::{SceneError, luminance, srgb16_to_linear};
use super::photo::{MIN_SIDE_PX, PhotoOptions, PhotoScene, WHITE_CD_M2, load_photo_bytes};
use super::picture_file::{Meaning, READABLE, animated_pictures, decode_picture, on_white};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pictures a second where neither a file nor the user says how many.
const USUAL_FPS: f64 = 25.0;
/// What is nearer to a picture's beginning than this is in it, s.
const TOLERANCE_S: f64 = 1e-6;
/// Largest number of texels of all pictures together: 768 MiB of colours.
pub const MAX_COURSE_TEXELS: u64 = 128 << 20;
/// Endings of files that are taken for pictures where a folder holds other things too.
const ENDINGS: [&str; 8] = ["png", "jpg", "jpeg", "webp", "bmp", "tif", "tiff", "gif"];

/// Pictures over time, all of one size.
#[derive(Debug, Clone, Default)]
pub struct PictureCourse {
    /// At least two.
    pub pictures: Vec<CoursePicture>,
}

/// One of them.
#[derive(Debug, Clone, Default)]
pub struct CoursePicture {
    /// When the next one takes its place, s from the first one's beginning.
    pub until_s: f64,
    /// Row-major sRGB-encoded RGB of 16 bits, top row first.
    pub rgb16_srgb: Vec<u16>,
    /// Mean luminance with white at [`WHITE_CD_M2`], cd/m².
    pub mean_luminance_cd_m2: f64,
}

impl PictureCourse {
    /// Time from the first picture's beginning to the last one's end, s.
    pub fn duration_s(&self) -> f64 {
        self.pictures.last().map_or(0.0, |picture| picture.until_s)
    }

    /// The picture that is seen at a time (s, from 0).
    pub fn index_at(&self, time_s: f64) -> usize {
        let duration_s = self.duration_s();
        if duration_s <= 0.0 {
            return 0;
        }
        // The sums of a file's times and a frame's own differ in their last digits.
        let passed_s = (time_s + TOLERANCE_S).rem_euclid(duration_s);
        let index = self
            .pictures
            .partition_point(|picture| picture.until_s <= passed_s);
        index.min(self.pictures.len() - 1)
    }
}

/// Mean luminance of a picture with white at [`WHITE_CD_M2`], cd/m².
pub fn mean_luminance_cd_m2(rgb16_srgb: &[u16]) -> f64 {
    let light = |rgb: &[u16]| luminance([0, 1, 2].map(|k| srgb16_to_linear(rgb[k])));
    let total: f64 = rgb16_srgb
        .chunks_exact(3)
        .map(|rgb| f64::from(light(rgb)))
        .sum();
    WHITE_CD_M2 * total / (rgb16_srgb.len() / 3).max(1) as f64
}

/// Loads a photograph, or pictures that follow one another, from memory: names and bytes in the order in
/// which they are seen. A single file that moves by itself does; `depth`, bytes and name, is that of all.
///
/// # Errors
/// One sentence that names the file at fault.
pub fn load_pictures(
    files: &[(String, &[u8])],
    source_name: &str,
    depth: Option<(&[u8], &str)>,
    options: &PhotoOptions,
) -> Result<PhotoScene, SceneError> {
    let Some(((first_name, first), later)) = files.split_first() else {
        return Err(SceneError::Empty {
            source_name: source_name.into(),
        });
    };
    let mut scene = load_photo_bytes(first, first_name, depth, options)?;
    scene.name = source_name.into();
    let shown_s = options.fps.map(|fps| 1.0 / f64::from(fps));
    let mut until_s = 0.0;
    let mut take = |rgb16_srgb: Vec<u16>, seconds: f64| {
        until_s += seconds;
        CoursePicture {
            until_s,
            mean_luminance_cd_m2: mean_luminance_cd_m2(&rgb16_srgb),
            rgb16_srgb,
        }
    };
    let mut pictures = Vec::new();
    if later.is_empty() {
        let texels = u64::from(scene.width) * u64::from(scene.height);
        let most = (MAX_COURSE_TEXELS / texels.max(1)) as usize;
        let found = animated_pictures(first, first_name, most)?;
        let mut left_out = 0;
        if found.is_cut {
            let count = found.pictures.len();
            scene.remarks.push(format!(
                "\"{source_name}\" is cut off or damaged: only its first {} whole.",
                if count == 1 {
                    "picture is".into()
                } else {
                    format!("{count} pictures are")
                }
            ));
        }
        for (image, seconds) in found.pictures {
            let rgb = on_white(image);
            if rgb.dimensions() == (scene.width, scene.height) {
                pictures.push(take(rgb.into_raw(), shown_s.unwrap_or(seconds)));
            } else {
                left_out += 1;
            }
        }
        if left_out > 0 {
            scene.remarks.push(format!(
                "\"{source_name}\": {left_out} of its pictures have another size than the first and are left out."
            ));
        }
    } else {
        check_extent((scene.width, scene.height), files.len(), source_name)?;
        let each_s = shown_s.unwrap_or(1.0 / USUAL_FPS);
        pictures.push(take(scene.rgb16_srgb.clone(), each_s));
        for (name, bytes) in later {
            let picture = decode_picture(bytes, name, MIN_SIDE_PX, Meaning::Colour)?;
            let rgb = on_white(picture.image);
            if rgb.dimensions() != (scene.width, scene.height) {
                return Err(SceneError::Content {
                    source_name: name.clone(),
                    reason: format!(
                        "it is {}×{} pixels, but the pictures before it are {}×{}",
                        rgb.width(),
                        rgb.height(),
                        scene.width,
                        scene.height
                    ),
                });
            }
            pictures.push(take(rgb.into_raw(), each_s));
        }
    }
    if pictures.len() > 1 {
        // A PNG may have another picture for those who cannot let it move.
        scene.rgb16_srgb.clone_from(&pictures[0].rgb16_srgb);
        scene.mean_luminance_cd_m2 = pictures[0].mean_luminance_cd_m2;
        scene.course = Some(Arc::new(PictureCourse { pictures }));
    }
    Ok(scene)
}

/// Are so many pictures of this size within what is kept?
///
/// # Errors
/// A sentence that says how many would be.
pub fn check_extent(
    (width, height): (u32, u32),
    count: usize,
    source_name: &str,
) -> Result<(), SceneError> {
    let texels = u64::from(width) * u64::from(height);
    let most = MAX_COURSE_TEXELS / texels.max(1);
    if count as u64 <= most {
        return Ok(());
    }
    Err(SceneError::Content {
        source_name: source_name.into(),
        reason: format!(
            "it has {count} pictures of {width}×{height}, but at most {most} of that size are kept: take fewer or \
             smaller ones"
        ),
    })
}

/// The pictures in a folder, in the order of their names, numbers by their values.
///
/// # Errors
/// A sentence where it cannot be read or has none.
pub fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let unreadable = |error: std::io::Error| SceneError::Unreadable {
        kind: "folder",
        path: folder.into(),
        reason: error.to_string(),
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_lowercase());
        let is_hidden = path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !is_hidden && path.is_file() && ending.is_some_and(|ending| ENDINGS.contains(&&*ending))
        {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(SceneError::Content {
            source_name: folder.display().to_string(),
            reason: format!("it is a folder without a {READABLE}"),
        });
    }
    found.sort_by(|a, b| by_number(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(found)
}

/// The order of names in which `frame9` comes before `frame10`.
pub fn by_number(a: &str, b: &str) -> std::cmp::Ordering {
    natord::compare(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::gif::GifEncoder;
    use image::{Delay, Frame, Rgb, RgbImage, Rgba, RgbaImage};
    use std::io::Cursor;

    fn png(width: u32, height: u32, shade: u8) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        RgbImage::from_pixel(width, height, Rgb([shade; 3]))
            .write_to(&mut bytes, image::ImageFormat::Png)
            .expect("a PNG");
        bytes.into_inner()
    }

    /// An animated GIF of these shades, and for how long (ms) each is seen.
    fn gif(pictures: &[(u8, u32)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = GifEncoder::new(&mut bytes);
        for (shade, ms) in pictures {
            let picture = RgbaImage::from_pixel(20, 16, Rgba([*shade, *shade, *shade, 255]));
            let delay = Delay::from_numer_denom_ms(*ms, 1);
            encoder
                .encode_frame(Frame::from_parts(picture, 0, 0, delay))
                .expect("a GIF");
        }
        drop(encoder);
        bytes
    }

    fn shades(scene: &PhotoScene) -> Vec<(u16, f64)> {
        let course = scene.course.as_ref().expect("several pictures");
        let shade = |picture: &CoursePicture| (picture.rgb16_srgb[0] / 257, picture.until_s);
        course.pictures.iter().map(shade).collect()
    }

    #[test]
    fn a_moving_file_that_is_cut_off_is_seen_with_a_remark() {
        let whole = include_bytes!("../../tests/data/three_seconds.gif");
        let of = |bytes: &[u8]| {
            let files = [("a.gif".to_owned(), bytes)];
            load_pictures(&files, "a.gif", None, &PhotoOptions::default()).expect("pictures")
        };
        assert!(
            of(whole)
                .remarks
                .iter()
                .all(|remark| !remark.contains("cut"))
        );
        let cut = of(&whole[..whole.len() * 3 / 4]);
        assert!(
            cut.remarks.iter().any(|remark| remark.contains("cut off")),
            "{:?}",
            cut.remarks
        );
    }

    #[test]
    fn files_follow_one_another_at_the_rate_that_was_asked_for() {
        let files: Vec<Vec<u8>> = [10, 20, 30].map(|shade| png(20, 16, shade)).into();
        let named: Vec<(String, &[u8])> = files
            .iter()
            .map(|file| ("f.png".into(), &file[..]))
            .collect();
        let options = PhotoOptions {
            fps: Some(4.0),
            ..PhotoOptions::default()
        };
        let scene = load_pictures(&named, "frames", None, &options).expect("three pictures");
        assert_eq!(shades(&scene), [(10, 0.25), (20, 0.5), (30, 0.75)]);
        let course = scene.course.as_ref().expect("several pictures");
        for (time, index) in [
            (0.0, 0),
            (0.25, 1),
            (0.74, 2),
            (0.75, 0),
            (0.75e9 + 0.3, 1),
            (-0.1, 2),
        ] {
            assert_eq!(course.index_at(time), index, "at {time}");
        }
        assert!(course.pictures[2].mean_luminance_cd_m2 > course.pictures[0].mean_luminance_cd_m2);
        // At equal rates each frame has its picture, for laps.
        let course = PictureCourse {
            pictures: (1..=60)
                .scan(0.0, |until_s, _| {
                    *until_s += 1.0 / 25.0;
                    Some(CoursePicture {
                        until_s: *until_s,
                        ..CoursePicture::default()
                    })
                })
                .collect(),
        };
        for frame in 0..6000 {
            assert_eq!(
                course.index_at(frame as f64 / 25.0),
                frame % 60,
                "frame {frame}"
            );
        }
        // One alone stands still.
        let one = load_pictures(&named[..1], "f.png", None, &options).expect("a photograph");
        assert!(one.course.is_none());
    }

    #[test]
    fn a_moving_gif_keeps_its_own_times_and_hurries_as_browsers_let_it() {
        let file = gif(&[(0, 200), (255, 50), (0, 0)]);
        let files = [("a.gif".to_owned(), &file[..])];
        let scene = load_pictures(&files, "a.gif", None, &PhotoOptions::default()).expect("a GIF");
        let found = shades(&scene);
        let wanted = [(0, 0.2), (255, 0.25), (0, 0.35)];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!(
                found.0 == wanted.0 && (found.1 - wanted.1).abs() < 1e-9,
                "{found:?}"
            );
        }
        assert_eq!(found.len(), 3);
        let still = gif(&[(9, 100)]);
        let files = [("a.gif".to_owned(), &still[..])];
        let scene = load_pictures(&files, "a.gif", None, &PhotoOptions::default()).expect("a GIF");
        assert!(scene.course.is_none());
    }

    #[test]
    fn pictures_that_do_not_go_together_are_refused_by_name() {
        let (one, other) = (png(20, 16, 1), png(16, 16, 2));
        let files = [
            ("a.png".to_owned(), &one[..]),
            ("b.png".to_owned(), &other[..]),
        ];
        let said = load_pictures(&files, "frames", None, &PhotoOptions::default());
        let said = said.expect_err("two sizes").to_string();
        assert!(
            said.contains("b.png") && said.contains("16×16") && said.contains("20×16"),
            "{said}"
        );
        let large = png(8192, 8192, 1);
        let files: Vec<(String, &[u8])> = (0..3).map(|_| ("c.png".into(), &large[..])).collect();
        let said = load_pictures(&files, "frames", None, &PhotoOptions::default());
        let said = said.expect_err("too many").to_string();
        assert!(
            said.contains("3 pictures") && said.contains("at most 2"),
            "{said}"
        );
        let files = [
            ("a.png".to_owned(), &one[..]),
            ("b.png".to_owned(), &b"hello"[..]),
        ];
        let said = load_pictures(&files, "frames", None, &PhotoOptions::default());
        assert!(said.expect_err("no picture").to_string().contains("b.png"));
    }

    #[test]
    fn a_folders_pictures_come_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in [
            "f10.png",
            "f9.PNG",
            "notes.txt",
            ".f1.png",
            "f11.jpg",
            "trace.csv",
        ] {
            std::fs::write(folder.path().join(name), b"x").expect("written");
        }
        let found = pictures_in(folder.path()).expect("pictures");
        let names: Vec<_> = found.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, ["f9.PNG", "f10.png", "f11.jpg"]);
        let empty = tempfile::tempdir().expect("a folder");
        let said = pictures_in(empty.path())
            .expect_err("no pictures")
            .to_string();
        assert!(said.contains("a folder without a PNG"), "{said}");
    }
}
