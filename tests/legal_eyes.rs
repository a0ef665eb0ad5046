//! Eyes at the ends of what a patient file allows, from anywhere: no pixel that is no number.
//!
//! A few of them each time; `OCULARIUM_EYES=10000 cargo test --release --test integration -- legal_eyes` draws as many as asked.

use bevy::math::DVec3;
use bevy::prelude::*;
use ocularium::appearance::{EyeCamera, EyeOrbit, EyeQuality, StudioLight};
use ocularium::lab::headless::Headless;
use ocularium::patients::{FIELDS, PRESETS, PatientFile, load_patient};
use ocularium::scene::catalog::{BuiltIn, LoadedScene};
use ocularium::stage::{PanelLight, Session, SessionCommand};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

const SIDE: u32 = 96;

/// A patient whose numbers are anywhere in their ranges, often at an end, and who passes the check.
fn legal_patient(rng: &mut impl Rng) -> PatientFile {
    let preset = PRESETS.choose(rng).expect("there are presets");
    let mut file = load_patient(preset.name).expect("a preset is legal");
    for field in FIELDS {
        if rng.random_bool(0.65) {
            continue;
        }
        let (low, high) = field.range;
        let value = match rng.random_range(0..4) {
            0 => low,
            1 => high,
            _ => rng.random_range(low..=high),
        };
        let mut other = file.clone();
        (field.set)(&mut other, value);
        if other.check("ann.ron").is_ok() {
            file = other;
        }
    }
    file
}

/// Pixels that are no radiance: not a number, not finite, or less than nothing.
fn wrong_pixels(headless: &Headless, image: &Handle<Image>) -> Vec<(usize, DVec3)> {
    let drawn = headless.radiances(image).expect("a picture");
    let is_wrong = |c: &DVec3| !c.is_finite() || c.min_element() < 0.0;
    drawn
        .into_iter()
        .enumerate()
        .filter(|(_, c)| is_wrong(c))
        .collect()
}

#[test]
fn no_legal_eye_has_a_pixel_that_is_no_number() {
    let wanted = std::env::var("OCULARIUM_EYES").ok();
    let wanted: u32 = wanted.and_then(|n| n.parse().ok()).unwrap_or(8);
    let mut rng = Pcg64::seed_from_u64(20_261_129);
    let lights = [
        StudioLight::Window,
        StudioLight::Ring,
        StudioLight::Coaxial,
        StudioLight::Penlight,
    ];
    for (at, light) in lights.into_iter().enumerate() {
        let scene = LoadedScene::Model(Box::new(BuiltIn::Chart.build().expect("a scene")));
        let session = Session {
            light: PanelLight::Studio(light),
            ..Session::new(legal_patient(&mut rng), scene, 1)
        };
        let (mut headless, image) =
            Headless::with_radiance(session, UVec2::splat(SIDE)).expect("a device");
        let own = (wanted + lights.len() as u32 - 1 - at as u32) / lights.len() as u32;
        for number in 0..own {
            let quality = [EyeQuality::default(), EyeQuality::PLAIN][number as usize % 2];
            headless.set_quality(quality);
            let patient = legal_patient(&mut rng);
            let orbit = EyeOrbit {
                azimuth_deg: rng.random_range(-85.0..=85.0),
                elevation_deg: rng.random_range(-80.0..=80.0),
                distance_mm: *[35.0, 45.0, 93.0, 400.0].choose(&mut rng).expect("some"),
            };
            let said = ron::to_string(&patient).expect("a patient is written");
            headless.command(SessionCommand::Patient(Box::new(patient)));
            headless.set_orbit(orbit);
            headless.go_to(0.05);
            headless.warm_up().expect("a picture");
            headless.go_to(rng.random_range(0.1..3.0));
            let wrong = wrong_pixels(&headless, &image);
            assert!(
                wrong.is_empty(),
                "{} pixels, the first {:?}: {light:?} {quality:?} {orbit:?} {said}",
                wrong.len(),
                wrong.first()
            );
        }
    }
}

/// Nearer than an orbit goes: a camera of somebody's own, ten and six millimetres before the cornea.
#[test]
fn no_eye_has_one_before_a_camera_that_nearly_touches_it() {
    let scene = LoadedScene::Model(Box::new(BuiltIn::Chart.build().expect("a scene")));
    let patient = load_patient("healthy-blue").expect("a preset is legal");
    let session = Session {
        light: PanelLight::Studio(StudioLight::Ring),
        ..Session::new(patient, scene, 1)
    };
    let (mut headless, image) =
        Headless::with_radiance(session, UVec2::splat(SIDE)).expect("a device");
    headless.set_quality(EyeQuality::default());
    let camera = headless.stage().eye;
    for (azimuth_deg, elevation_deg) in [(0.0, 0.0), (-30.0, 10.0), (60.0, -20.0), (85.0, 40.0)] {
        headless.set_orbit(EyeOrbit {
            azimuth_deg,
            elevation_deg,
            distance_mm: 35.0,
        });
        headless.go_to(0.05);
        headless.warm_up().expect("a picture");
        // It no longer follows its orbit.
        let own = headless.world().entity_mut(camera).take::<EyeCamera>();
        let own = own.expect("a camera before an eye");
        let mut camera_of = headless.world().get_mut::<Camera>(camera).expect("it");
        camera_of.is_active = true;
        let mut last = headless.radiances(&image).expect("a picture");
        for forward_mm in [25.0, 4.0] {
            let mut place = headless.world().get_mut::<Transform>(camera).expect("it");
            let forward = place.forward();
            place.translation += forward * 1e-3 * forward_mm;
            headless.go_to(0.1);
            headless.finish_frame();
            let wrong = wrong_pixels(&headless, &image);
            assert!(wrong.is_empty(), "{azimuth_deg}: {:?}", wrong.first());
            let seen = headless.radiances(&image).expect("a picture");
            assert!(seen.iter().any(|c| c.max_element() > 0.01), "{azimuth_deg}");
            assert_ne!(seen, last, "{azimuth_deg}, {forward_mm} mm nearer");
            last = seen;
        }
        headless.world().entity_mut(camera).insert(own);
    }
}
