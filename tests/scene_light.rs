//! The light of the scene at the eye that looks at it: what it mirrors, and what its pupil answers to.

use crate::stage::{open, patient, session, settle, turn, without_blinks};
use bevy::math::{DVec2, DVec3, UVec2, Vec3};
use bevy::prelude::Mut;
use image::RgbaImage;
use ocularium::anatomy::Adaptation;
use ocularium::appearance::shading::surroundings::surroundings_uv;
use ocularium::appearance::surroundings::Surroundings;
use ocularium::appearance::{EyeLight, EyeOrbit, EyeSurroundings};
use ocularium::lab::headless::{Headless, Which};
use ocularium::optics::output::srgb_decode;
use ocularium::optics::tear_film::tear_film_rgb;
use ocularium::scene::catalog::LoadedScene;
use ocularium::stage::{Head, PanelLight};
use std::sync::Arc;

fn around(headless: &mut Headless) -> Arc<Surroundings> {
    let model = headless.stage().model;
    let own = headless.world().get::<EyeSurroundings>(model);
    own.expect("its scene is around it").0.clone()
}

#[test]
fn a_pupil_answers_to_the_light_where_the_head_is() {
    let _turn = turn();
    let size = UVec2::splat(32);
    let mut headless = open(
        session(patient("healthy-brown"), 1),
        size,
        size,
        [false, true],
    );
    settle(&mut headless);
    let light = |headless: &mut Headless| {
        let person = headless.stage().patient;
        let own = headless.world().get::<Adaptation>(person);
        own.expect("somebody").luminance_cd_m2
    };
    let LoadedScene::Model(room) = &*headless.stage().scene.clone() else {
        panic!("a room")
    };
    let at_seat = light(&mut headless);
    assert_eq!(at_seat, room.mean_luminance_cd_m2);
    // Turned to the window on the left, then to the floor, and back.
    let mut turned = |yaw_deg: f32, pitch_deg: f32, time_s: f64| {
        headless.set_head(Head {
            yaw_deg,
            pitch_deg,
            ..Head::default()
        });
        headless.go_to(time_s);
        headless.go_to(time_s + 0.05);
        light(&mut headless)
    };
    let window = turned(-70.0, 0.0, 0.1);
    let floor = turned(0.0, -70.0, 0.2);
    assert!(window > 1.2 * at_seat, "{window} of {at_seat}");
    assert!(floor < 0.9 * at_seat, "{floor} of {at_seat}");
    assert_eq!(turned(0.0, 0.0, 0.3), at_seat);
}

/// Linear light of the middle of a picture, as a mean over a disc.
fn middle(picture: &RgbaImage, radius_px: f64) -> DVec3 {
    let center = DVec2::new(f64::from(picture.width()), f64::from(picture.height())) * 0.5;
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        if (DVec2::new(f64::from(x), f64::from(y)) + 0.5).distance(center) < radius_px {
            let [r, g, b, _] = pixel.0.map(|code| srgb_decode(f64::from(code) / 255.0));
            sum += DVec3::new(r, g, b);
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn a_cornea_mirrors_the_room_that_its_eye_sees() {
    let _turn = turn();
    let mut brown = patient("healthy-brown");
    // The cornea faces the camera.
    brown.angle_alpha_deg = [0.0, 0.0];
    brown.lipid_thickness_nm = 0.0;
    let mut asked = session(brown, 1);
    asked.light = PanelLight::Scene;
    let side = 512u32;
    let mut headless = open(asked, UVec2::splat(side), UVec2::splat(32), [true, false]);
    without_blinks(&mut headless);
    let distance_mm = 60.0f32;
    headless.set_orbit(EyeOrbit {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
        distance_mm,
    });
    look_ahead(&mut headless);
    settle(&mut headless);
    headless.go_to(0.02);
    let lit = headless.panel(Which::Eye).expect("a picture");
    let found = around(&mut headless);
    // The same light without anything to be mirrored.
    let mut dark = (*found).clone();
    for level in &mut dark.levels {
        level.2.fill([0.0, 0.0, 0.0, 1.0]);
    }
    for lamp in &mut dark.lamps {
        lamp.hole = -1.0;
    }
    let model = headless.stage().model;
    headless.world().entity_mut(model).insert((
        EyeSurroundings(Arc::new(dark)),
        // So that nobody replaces it.
        EyeLight::Surroundings,
    ));
    headless.go_to(0.04);
    headless.finish_frame();
    headless.go_to(0.06);
    let unlit = headless.panel(Which::Eye).expect("a picture");
    // A disc of the middle, well within the pupil, and what its normals mirror: the camera is far away against it.
    let fov = eye_fov(&mut headless);
    let px_per_mm = f64::from(side) / (2.0 * (0.5 * fov).tan() * f64::from(distance_mm));
    let radius_mm = 0.7;
    let seen = middle(&lit, radius_mm * px_per_mm) - middle(&unlit, radius_mm * px_per_mm);
    let (mut mirrored, mut count) = (DVec3::ZERO, 0.0);
    let levels = &found.levels[0];
    for i in -40i32..=40 {
        for j in -40i32..=40 {
            let at = DVec2::new(f64::from(i), f64::from(j)) / 40.0 * radius_mm;
            if at.length() > radius_mm {
                continue;
            }
            let n = (at / 7.8).extend(-1.0).normalize();
            let v = (DVec3::new(0.0, 0.0, -f64::from(distance_mm)) - at.extend(0.0)).normalize();
            let d = 2.0 * n.dot(v) * n - v;
            let uv = surroundings_uv(d) * f64::from(levels.0);
            let texel = levels.2[uv.y as usize * levels.0 as usize + uv.x as usize];
            let radiance = DVec3::new(texel[0].into(), texel[1].into(), texel[2].into());
            mirrored += tear_film_rgb(n.dot(v), 1.48, 1.337, 0.0) * radiance;
            count += 1.0;
        }
    }
    let expected = mirrored / count * f64::from(found.exposure);
    println!("seen {seen:.5}, expected {expected:.5}");
    for channel in 0..3 {
        let ratio = seen[channel] / expected[channel];
        assert!((ratio - 1.0).abs() < 0.1, "{seen} for {expected}");
    }
    // A control: somebody who looks the other way has another room before him.
    headless.set_head(Head {
        yaw_deg: 120.0,
        place_m: Vec3::ZERO,
        ..Head::default()
    });
    for step in 0..4 {
        headless.go_to(0.1 + 0.05 * f64::from(step));
        headless.finish_frame();
    }
    let other = middle(
        &headless.panel(Which::Eye).expect("a picture"),
        radius_mm * px_per_mm,
    ) - middle(&unlit, radius_mm * px_per_mm);
    assert!(
        (other / expected - 1.0).abs().max_element() > 0.2,
        "{other}"
    );
}

/// Fixates far ahead, so that the eye does not turn.
fn look_ahead(headless: &mut Headless) {
    crate::stage::look(headless, 0.0, 0.0, 1000.0);
}

/// The vertical angle of the eye's camera, rad.
fn eye_fov(headless: &mut Headless) -> f64 {
    let eye = headless.stage().eye;
    let projection = headless.world().get_mut::<bevy::camera::Projection>(eye);
    let found = projection.map(
        |projection: Mut<bevy::camera::Projection>| match &*projection {
            bevy::camera::Projection::Perspective(own) => f64::from(own.fov),
            _ => panic!("a perspective"),
        },
    );
    found.expect("a camera")
}
