//! The blur that is drawn, read from the panel of the running app: across depth edges against the
//! f64 reference, and of a star against optics.

mod astigmatism;
mod edges;
mod stars;

use crate::percept_gpu::{photo, photo_session};
use crate::stage::{look, open, patient, settle, without_blinks};
use bevy::math::UVec2;
use half::f16;
use image::{DynamicImage, GrayImage, Luma, RgbaImage};
use ocularium::lab::headless::{Headless, Which};
use ocularium::optics::defocus::{PowerVector, astigmatic_blur};
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::percept::gather::{
    Elongated, View, angle_between, combined_blur, neural_blur, reference_gather, view_ray,
};
use ocularium::percept::gpu_data::PerceptUniform;
use ocularium::scene::model::srgb_to_linear;
use ocularium::scene::photo::PhotoOptions;
use ocularium::stage::SessionCommand;

/// Pixels along each side of the view, and of the photograph that fills it: each texel is a pixel.
const SIDE: u32 = 164;
/// View pixels a radian, so that 2 to 30 mrad are 1.4 to 21 pixels.
const PIXELS_PER_RADIAN: f64 = 700.0;
/// Vergence of white in the photograph's distances, D; black is infinitely far.
const NEAR_D: f32 = 2.0;

/// A grey photograph and its distances.
struct Photograph {
    grey: GrayImage,
    near: GrayImage,
}

impl Photograph {
    /// Grey and nearness of every pixel.
    fn new(pixel: impl Fn(u32, u32) -> (u8, bool)) -> Self {
        let grey = GrayImage::from_fn(SIDE, SIDE, |x, y| Luma([pixel(x, y).0]));
        let near = GrayImage::from_fn(SIDE, SIDE, |x, y| Luma([255 * u8::from(pixel(x, y).1)]));
        Self { grey, near }
    }

    /// An app that shows it, without the eye's panel.
    fn open(&self) -> Headless {
        let half = (0.5 * f64::from(SIDE) / PIXELS_PER_RADIAN).atan();
        let options = PhotoOptions {
            near_m: 1.0 / NEAR_D,
            vertical_fov_deg: (2.0 * half).to_degrees() as f32,
            ..PhotoOptions::default()
        };
        let image = DynamicImage::ImageLuma8(self.grey.clone());
        let scene = photo(&image, Some(&self.near), &options);
        let session = photo_session(scene, patient("healthy-brown"));
        let size = UVec2::splat(SIDE);
        let mut headless = open(session, UVec2::splat(16), size, [false, true]);
        settle(&mut headless);
        headless
    }

    fn linear(&self) -> Vec<f64> {
        let radiance = |p: &Luma<u8>| f64::from(srgb_to_linear(p.0[0]));
        self.grey.pixels().map(radiance).collect()
    }

    fn vergence_d(&self) -> Vec<f32> {
        let near = |p: &Luma<u8>| if p.0[0] > 0 { NEAR_D } else { 0.0 };
        self.near.pixels().map(near).collect()
    }

    /// Blur (pixels) of every pixel for an eye that is focused on infinity but for its refraction, and its
    /// elongation.
    fn blur_px(&self, eye: Eye) -> (Vec<f32>, Vec<f32>) {
        let healthy = PerceptUniform::default();
        let (floor, e2) = (
            f64::from(healthy.neural_floor_rad),
            f64::from(healthy.eccentricity_e2_rad),
        );
        let half = 0.5 * f64::from(SIDE) / PIXELS_PER_RADIAN;
        let pixels = self.vergence_d().into_iter().enumerate();
        let blur = pixels.map(|(index, vergence)| {
            let place = [index as u32 % SIDE, index as u32 / SIDE].map(|i| f64::from(i) + 0.5);
            let ray = view_ray(place, [f64::from(SIDE); 2], [half; 2]);
            let neural = neural_blur(angle_between(ray, [0.0, 0.0, -1.0]), floor, e2);
            let error = eye.refraction().plus_sphere(vergence.into());
            let (pupil, astigmatism) = (eye.pupil_mm * 1e-3, error.astigmatism_d());
            let [defocus, elongation] = astigmatic_blur(pupil, error.m_d, astigmatism);
            let all = combined_blur(defocus, neural);
            let share = (defocus / all).powi(2);
            (
                (all * PIXELS_PER_RADIAN) as f32,
                (share * elongation) as f32,
            )
        });
        blur.unzip()
    }

    /// The linear radiance that the reference sees.
    fn reference(&self, eye: Eye) -> Vec<f64> {
        // The view is kept in half floats.
        let stored = |v: f64| [f16::from_f64(v).to_f32(); 3];
        let radiance: Vec<[f32; 3]> = self.linear().into_iter().map(stored).collect();
        let (blur_px, elongation) = self.blur_px(eye);
        let axis_rad = -0.5 * {
            let seen = eye.refraction().in_view();
            seen.j45_d.atan2(seen.j0_d)
        };
        let seen = reference_gather(&View {
            width: SIDE as usize,
            height: SIDE as usize,
            radiance: &radiance,
            vergence_d: &self.vergence_d(),
            blur_px: &blur_px,
            astigmatism: (eye.cylinder_d != 0.0).then_some(Elongated {
                elongation: &elongation,
                axis_rad,
            }),
        });
        seen.into_iter().map(|rgb| rgb[1]).collect()
    }
}

/// Linear radiance of a grey that is shown: the output's curve is the identity below 0.6, and above
/// it a shoulder, 1 − 0.16/(x − 0.2), of which this is the inverse.
fn linear(code: u8) -> f64 {
    let shown = f64::from(srgb_to_linear(code));
    if shown <= 0.6 {
        shown
    } else {
        0.16 / (1.0 - shown) + 0.2
    }
}

/// An eye without accommodation.
#[derive(Clone, Copy, Debug)]
struct Eye {
    pupil_mm: f64,
    sphere_d: f64,
    cylinder_d: f64,
    axis_deg: f64,
}

const NEUTRAL: Eye = Eye {
    pupil_mm: 4.0,
    sphere_d: 0.0,
    cylinder_d: 0.0,
    axis_deg: 0.0,
};

impl Eye {
    fn refraction(self) -> PowerVector {
        let axis = self.axis_deg.to_radians();
        PowerVector::from_sphere_cylinder(self.sphere_d, self.cylinder_d, axis)
    }

    fn file(self) -> PatientFile {
        PatientFile {
            pupil: PupilSetting::Fixed(self.pupil_mm),
            sphere_d: self.sphere_d,
            cylinder_d: self.cylinder_d,
            axis_deg: self.axis_deg,
            accommodation_amplitude_d: Some(0.0),
            blur_cap_arcmin: 600.0,
            ..patient("healthy-brown")
        }
    }

    /// What this eye, looking straight ahead, is shown.
    fn draw(self, headless: &mut Headless) -> RgbaImage {
        headless.command(SessionCommand::Patient(Box::new(self.file())));
        headless.go_to(0.0);
        settle(headless);
        without_blinks(headless);
        look(headless, 0.0, 0.0, f64::INFINITY);
        headless.go_to(0.01);
        headless.go_to(0.5);
        let state = headless.state();
        assert_eq!((state.lid_aperture, state.accommodation_d), (1.0, 0.0));
        headless
            .panel(Which::View)
            .unwrap_or_else(|error| panic!("{error}"))
    }
}
