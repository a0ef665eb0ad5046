//! The view's pipeline in the real app, on photographs whose every pixel is known: corners and
//! vergences as they come back, memory of what was seen sharply, and what glaucoma takes.

use crate::stage::{engine, look, luma_at, open, patient, settle, turn, without_blinks};
use bevy::math::{UVec2, Vec2};
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, RgbaImage};
use ocularium::anatomy::Laterality;
use ocularium::conditions::glaucoma::LEAST_MEAN_DEVIATION_DB;
use ocularium::conditions::{Glaucoma, GlaucomaStage};
use ocularium::lab::headless::{Headless, Which};
use ocularium::motion::MotionCommand;
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::percept::fast::{self, Corner};
use ocularium::percept::gather::{perimetric_angles, view_ray};
use ocularium::percept::gpu_data::CANDIDATE_CAPACITY;
use ocularium::scene::catalog::{LoadedScene, SceneSource};
use ocularium::scene::photo::{PhotoOptions, load_photo_bytes};
use ocularium::stage::{Session, SessionCommand};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::io::Cursor;
use std::sync::Arc;

fn png(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).expect("PNG");
    bytes.into_inner()
}

/// Noise over plates of different grey: corners of every strength.
fn plates(width: u32, height: u32, seed: u64) -> GrayImage {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut image = GrayImage::from_pixel(width, height, Luma([110]));
    for _ in 0..60 {
        let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
        let (w, h) = (rng.random_range(4..24), rng.random_range(4..24));
        let grey = rng.random_range(0..=255u8);
        for row in y..(y + h).min(height) {
            for column in x..(x + w).min(width) {
                image.put_pixel(column, row, Luma([grey]));
            }
        }
    }
    for pixel in image.pixels_mut() {
        let grey = i32::from(pixel.0[0]) + rng.random_range(-25..=25);
        pixel.0[0] = grey.clamp(0, 255) as u8;
    }
    image
}

pub fn photo_session(scene: LoadedScene, patient: PatientFile) -> Session {
    Session::new(patient, scene, 5)
}

/// A photograph that fills a square view of 160 pixels, and its distances.
pub fn photo(
    image: &DynamicImage,
    depth: Option<&GrayImage>,
    options: &PhotoOptions,
) -> LoadedScene {
    let depth = depth.map(|depth| png(&DynamicImage::ImageLuma8(depth.clone())));
    let depth = depth.as_deref().map(|bytes| (bytes, "depth.png"));
    let scene = load_photo_bytes(&png(image), "photo.png", depth, options);
    LoadedScene::Photo(Arc::new(scene.expect("a sound photograph")))
}

#[test]
fn corners_and_vergences_of_a_photograph_are_exact() {
    let _turn = turn();
    let (width, height) = (160, 96);
    let folder = tempfile::tempdir().expect("a folder");
    let (photo, depth) = (
        folder.path().join("photo.png"),
        folder.path().join("depth.png"),
    );
    // Grey, so that the luma is a whole number and half floats cannot move it past a half.
    let grey = plates(width, height, 3);
    DynamicImage::ImageLuma8(grey.clone())
        .to_rgb8()
        .save(&photo)
        .expect("saved");
    let mut rng = Pcg64::seed_from_u64(4);
    let codes = ImageBuffer::from_fn(width, height, |_, _| Luma([rng.random::<u16>()]));
    DynamicImage::ImageLuma16(codes.clone())
        .save(&depth)
        .expect("saved");
    let name = photo.display().to_string();
    let scene = SceneSource::resolve(&name, Some(&depth)).unwrap_or_else(|error| panic!("{error}"));
    let LoadedScene::Photo(loaded) = &scene else {
        panic!("a photograph")
    };
    let loaded = loaded.clone();

    let session = photo_session(scene, patient("healthy-brown"));
    // The view has the photograph's size, so that each pixel is one texel.
    let view = UVec2::new(width, height);
    let mut headless = open(session, UVec2::splat(16), view, [false, true]);
    settle(&mut headless);
    let captured = headless.percept().captured().clone();
    assert_eq!(captured.size, view);

    for (index, vergence) in captured.vergence_d.iter().enumerate() {
        let (x, y) = (index as u32 % width, index as u32 / width);
        let exact = 1.0 / loaded.depth_at_m(x, y);
        // One rounding of a quotient; black is infinitely far.
        assert!(
            (vergence - exact).abs() <= 1e-6 * exact,
            "{x}, {y}: {vergence} and {exact}"
        );
        // White is 0.5 m, linear in dioptres: two quotients of f32.
        let code = f32::from(codes.get_pixel(x, y).0[0]) / 65_535.0;
        assert!(
            (vergence - 2.0 * code).abs() < 2e-6,
            "{x}, {y}: {vergence} for {code}"
        );
    }
    for [x, y, _, bits] in &captured.corners {
        let at = (y * width + x) as usize;
        assert_eq!(f32::from_bits(*bits), captured.vergence_d[at]);
    }

    let luma: Vec<u8> = DynamicImage::ImageLuma8(grey)
        .to_rgb8()
        .pixels()
        .map(|p| fast::luma_of_srgb8(p.0))
        .collect();
    let (columns, rows) = (width as usize, height as usize);
    let expected = fast::detect(&luma, columns, rows, 20, true).expect("sizes agree");
    assert!(expected.len() > 100 && expected.len() < CANDIDATE_CAPACITY as usize);
    let found: Vec<Corner> = captured
        .corners
        .iter()
        .map(|[x, y, score, _]| Corner {
            x: *x,
            y: *y,
            score: *score as u8,
        })
        .collect();
    let apart = found.iter().zip(&expected).find(|(a, b)| a != b);
    assert_eq!(apart, None, "the GPU's corner first, the CPU's second");
    assert_eq!(found.len(), expected.len());
    assert_eq!(captured.found as usize, expected.len());
    let other = fast::detect(&luma, columns, rows, 21, true).expect("sizes agree");
    assert_ne!(found, other, "another threshold finds other corners");
}

/// Mean squared difference of neighbouring pixels within 16 pixels of a place.
fn sharpness(picture: &RgbaImage, place: UVec2) -> f64 {
    let mut sum = 0.0;
    for y in place.y - 16..place.y + 16 {
        for x in place.x - 16..place.x + 16 {
            let here = luma_at(picture, x, y);
            sum += (luma_at(picture, x + 1, y) - here).powi(2);
            sum += (luma_at(picture, x, y + 1) - here).powi(2);
        }
    }
    sum / (32.0 * 32.0)
}

/// A running app on photographs, and its time.
struct Run {
    headless: Headless,
    time_s: f64,
}

impl Run {
    fn step(&mut self, seconds: f64) {
        self.time_s += seconds;
        self.headless.go_to(self.time_s);
    }

    fn view(&self) -> RgbaImage {
        self.headless
            .panel(Which::View)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Looks at a place of the view until eye and lens have come to rest.
    fn fixate(&mut self, place: UVec2) {
        let middle = place.as_vec2() + Vec2::splat(0.5);
        let (azimuth, elevation, distance_m) = self.headless.percept().look_at(middle);
        look(
            &mut self.headless,
            azimuth.to_degrees(),
            elevation.to_degrees(),
            distance_m,
        );
        for _ in 0..8 {
            self.step(0.25);
        }
        let gaze = self.headless.state();
        assert!((gaze.gaze_azimuth_rad - azimuth).abs() < 1e-6, "{gaze:?}");
    }

    fn blink(&mut self) {
        let before = self.headless.state().blink_epoch;
        self.headless.world().write_message(MotionCommand::Blink);
        // Down, closed, and up again: 0.2 s.
        for _ in 0..5 {
            self.step(0.05);
        }
        let state = self.headless.state();
        assert_eq!((state.blink_epoch, state.blinking), (before + 1, false));
    }
}

#[test]
fn what_was_seen_sharply_stays_until_a_blink_and_what_glaucoma_takes_is_missing() {
    let _turn = turn();
    // The left half stands at 0.25 m (4 D), the right half infinitely far; 20° are 160 pixels, so
    // that 4 D through 6 mm blur a point over 11 pixels.
    let image = DynamicImage::ImageLuma8(plates(160, 160, 9));
    let depth = GrayImage::from_fn(160, 160, |x, _| Luma([if x < 80 { 255 } else { 0 }]));
    let options = PhotoOptions {
        near_m: 0.25,
        vertical_fov_deg: 20.0,
        ..PhotoOptions::default()
    };
    let mut file = patient("healthy-blue");
    file.pupil = PupilSetting::Fixed(6.0);
    let session = photo_session(photo(&image, Some(&depth), &options), file);
    let size = UVec2::splat(160);
    let mut run = Run {
        headless: open(session, UVec2::splat(16), size, [false, true]),
        time_s: 0.0,
    };
    settle(&mut run.headless);
    memory_lasts_until_a_blink(&mut run);
    glaucoma_takes_the_lost_field(&mut run);
}

fn memory_lasts_until_a_blink(run: &mut Run) {
    without_blinks(&mut run.headless);
    let (near, far) = (UVec2::new(40, 80), UVec2::new(120, 80));
    for (first, last) in [(near, far), (far, near)] {
        run.fixate(first);
        run.fixate(last);
        let remembered = run.view();
        run.blink();
        let after = run.view();
        let lost = sharpness(&remembered, first) / sharpness(&after, first);
        // A Gaussian of 2.7 pixels leaves less than a tenth of a pixel's noise.
        assert!(
            lost > 3.0,
            "{first}: only {lost} times as sharp before the blink"
        );
        let kept = sharpness(&remembered, last) / sharpness(&after, last);
        assert!(
            (0.7..1.4).contains(&kept),
            "{last}: what is fixated stays sharp, {kept}"
        );
    }
}

fn glaucoma_takes_the_lost_field(run: &mut Run) {
    // One even colour: blur leaves it as it is, lost light and lost colour do not.
    let even = RgbImage::from_pixel(160, 160, Rgb([210, 130, 70]));
    let scene = photo(
        &DynamicImage::ImageRgb8(even),
        None,
        &PhotoOptions::default(),
    );
    run.headless.command(SessionCommand::Scene(Arc::new(scene)));
    settle(&mut run.headless);
    let glaucoma = patient("glaucoma-moderate");
    let (eye, age_years, stage) = (glaucoma.eye, glaucoma.age_years, glaucoma.glaucoma);
    assert_eq!(eye, Laterality::OD);
    let healthy = PatientFile {
        glaucoma: None,
        ..glaucoma.clone()
    };
    let blind = PatientFile {
        glaucoma: Some(Glaucoma::mean_deviation(LEAST_MEAN_DEVIATION_DB)),
        ..glaucoma.clone()
    };
    let tunnel = PatientFile {
        glaucoma: Some(GlaucomaStage::Severe.into()),
        ..glaucoma.clone()
    };
    let [whole, lost, tunnel, blind] = [healthy, glaucoma, tunnel, blind].map(|file| {
        run.headless
            .command(SessionCommand::Patient(Box::new(file)));
        run.headless.go_to(0.0);
        settle(&mut run.headless);
        without_blinks(&mut run.headless);
        look(&mut run.headless, 0.0, 0.0, 3.0);
        run.headless.go_to(0.01);
        run.headless.go_to(1.0);
        let ahead = engine(&run.headless).state();
        assert!(ahead.gaze_azimuth_rad.hypot(ahead.gaze_elevation_rad) < 1e-9);
        run.view()
    });
    let field =
        ocularium::conditions::glaucoma::glaucoma_field(stage.expect("glaucoma"), eye, age_years);
    let half = 25f64.to_radians().tan();
    // Means over what is lost, what is kept, and the four quadrants: (sum, count) each.
    let mut darker = [[0.0_f64; 2]; 6];
    let mut missing = [0.0_f64; 4];
    for (x, y, _) in whole.enumerate_pixels() {
        let place = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let ray = view_ray(place, [160.0; 2], [half; 2]);
        let angles = perimetric_angles(ray, [0.0, 0.0, -1.0]);
        let seen = field.seen(angles[0], angles[1]);
        let step = luma_at(&whole, x, y) - luma_at(&lost, x, y);
        let quadrant = usize::from(angles[0] > 0.0) + 2 * usize::from(angles[1] > 0.0);
        missing[quadrant] += 1.0 - seen;
        let mut add = |class: usize| {
            darker[class][0] += step;
            darker[class][1] += 1.0;
        };
        add(2 + quadrant);
        match seen {
            s if s < 0.2 => add(0),
            s if s > 0.97 => add(1),
            _ => {}
        }
    }
    assert!(darker[0][1] > 500.0 && darker[1][1] > 500.0, "{darker:?}");
    let means = darker.map(|[sum, count]| sum / count);
    // 28 % of the light are 14 % of the code value, some 18 steps; the tone curve takes a part.
    assert!(means[0] > 6.0, "{means:?}");
    assert!(means[1].abs() < 1.5, "{means:?}");
    let most = |values: &[f64]| {
        let best = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        best.map(|(index, _)| index)
    };
    assert_eq!(most(&means[2..]), most(&missing), "{means:?} {missing:?}");
    // Where nothing is left there is nothing to fill in from.
    let mean = |picture: &RgbaImage| {
        let pixels = picture.enumerate_pixels();
        pixels.map(|(x, y, _)| luma_at(picture, x, y)).sum::<f64>() / f64::from(160 * 160)
    };
    let lights = [&whole, &lost, &tunnel, &blind].map(mean);
    println!("healthy, moderate, severe, blind: {lights:.1?}");
    assert!(
        lights[2] > 0.6 * lights[0] && lights[2] < lights[1],
        "{lights:?}"
    );
    // A fifteenth of the light, and that blurred.
    assert!(lights[3] < 0.29 * lights[0], "{lights:?}");
}
