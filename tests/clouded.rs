//! Clouded lenses in both panels: as grey and yellow from outside, and as yellow inside, as their media say.

use crate::stage::{look, open, patient, session, settle, turn, without_blinks};
use bevy::math::UVec2;
use bevy::math::Vec3;
use image::RgbaImage;
use ocularium::anatomy::{Eye, Laterality, OcularMedia};
use ocularium::conditions::{Cataract, Glaucoma};
use ocularium::lab::headless::{Headless, Which};
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::stage::{PanelLight, Session};

const SIDE: u32 = 400;

/// Somebody of 60 years whose wide pupils stand, looking at one place, by a window.
fn opened() -> Headless {
    opened_in("window")
}

/// The same in this light.
fn opened_in(light: &str) -> Headless {
    let file = PatientFile {
        age_years: 60.0,
        pupil: PupilSetting::Fixed(7.0),
        ..patient("healthy-blue")
    };
    let asked = Session {
        light: PanelLight::of(light).expect("a light"),
        ..session(file, 3)
    };
    let mut headless = open(asked, UVec2::splat(SIDE), UVec2::splat(160), [true; 2]);
    settle(&mut headless);
    without_blinks(&mut headless);
    look(&mut headless, 0.0, 0.0, 3.0);
    headless.go_to(0.5);
    headless.go_to(3.0);
    headless
}

/// Clouds the right eye, and shows it in both panels.
fn clouded(headless: &mut Headless, cataract: Option<Cataract>) -> ([RgbaImage; 2], OcularMedia) {
    let world = headless.world();
    let mut eyes = world.query::<(bevy::prelude::Entity, &Eye)>();
    let eye = eyes
        .iter(world)
        .find(|(_, eye)| eye.laterality == Laterality::OD)
        .map(|(entity, _)| entity)
        .expect("a right eye");
    let mut entity = world.entity_mut(eye);
    match cataract {
        Some(cataract) => entity.insert(cataract),
        None => entity.remove::<Cataract>(),
    };
    for _ in 0..8 {
        headless.stand_still();
        headless.finish_frame();
    }
    settle(headless);
    let media = *headless.world().get::<OcularMedia>(eye).expect("media");
    let pictures = [Which::Eye, Which::View].map(|which| headless.panel(which).expect("a picture"));
    (pictures, media)
}

fn linear(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Mean linear colour of a square about a place.
fn color_at(picture: &RgbaImage, [x, y]: [u32; 2], half: u32) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for j in y - half..=y + half {
        for i in x - half..=x + half {
            let pixel = picture.get_pixel(i, j);
            for (sum, code) in sum.iter_mut().zip(&pixel.0) {
                *sum += linear(*code);
            }
        }
    }
    let count = f64::from((2 * half + 1).pow(2));
    sum.map(|sum| sum / count)
}

/// The darkest place near the middle of the eye's picture: the pupil.
fn pupil(picture: &RgbaImage) -> [u32; 2] {
    let near = || SIDE / 2 - 40..SIDE / 2 + 40;
    near()
        .flat_map(|x| near().map(move |y| [x, y]))
        .min_by(|a, b| {
            let light = |at: &[u32; 2]| color_at(picture, *at, 8).iter().sum::<f64>();
            light(a).total_cmp(&light(b))
        })
        .expect("a place")
}

/// The middle of what is dark near the middle of the eye's picture: of the pupil.
fn middle_of_the_dark(picture: &RgbaImage) -> [u32; 2] {
    let near = || SIDE / 2 - 50..SIDE / 2 + 50;
    let dark: Vec<[u32; 2]> = near()
        .flat_map(|x| near().map(move |y| [x, y]))
        // A fiftieth of what a white card before the face has (3 times 1.2).
        .filter(|at| color_at(picture, *at, 0).iter().sum::<f64>() < 0.071)
        .collect();
    assert!(dark.len() > 1000, "a pupil of {} pixels", dark.len());
    [0, 1].map(|axis| dark.iter().map(|at| at[axis]).sum::<u32>() / dark.len() as u32)
}

#[test]
fn the_fundus_shines_through_a_clear_lens_and_clouds_stand_dark_before_it() {
    let _turn = turn();
    let shown = |light: &str, cataract| {
        let mut headless = opened_in(light);
        let ([picture, _], _) = clouded(&mut headless, cataract);
        picture
    };
    // The pupil is found where its room is dark: by a window it mirrors somebody, and an iris has dark places in the lids' shade.
    let (by_window, by_penlight) = (shown("window", None), shown("penlight", None));
    let [x, y] = middle_of_the_dark(&by_penlight);
    // Beside the lamp's own images.
    let place = [x - 12, y + 12];
    let of = |picture: &RgbaImage| color_at(picture, place, 3);
    let window = of(&by_window);
    let reflex = of(&shown("coaxial", None));
    let aside = of(&by_penlight);
    let plaque = of(&shown(
        "coaxial",
        Some(Cataract::posterior_subcapsular(5.9)),
    ));
    println!(
        "window {window:.4?}, along the axis {reflex:.4?}, aside {aside:.4?}, behind a cloud {plaque:.4?}"
    );
    let [red, green, blue] = reflex;
    assert!(red > 2.0 * green && green > blue, "{reflex:?}");
    assert!(red > 10.0 * window[0].max(aside[0]), "{window:?} {aside:?}");
    assert!(plaque[0] < 0.6 * red, "{plaque:?}");
}

#[test]
fn a_clouded_nucleus_is_grey_then_yellow_in_the_pupil() {
    let _turn = turn();
    let mut headless = opened();
    let ([healthy, _], _) = clouded(&mut headless, None);
    let place = pupil(&healthy);
    let shown = |headless: &mut Headless, cataract| {
        let ([picture, _], media) = clouded(headless, cataract);
        (color_at(&picture, place, 8), media)
    };
    let (clear, _) = shown(&mut headless, None);
    let mut before = clear;
    for grade in [2.5, 4.0, 5.5, 6.9] {
        let (color, _) = shown(&mut headless, Some(Cataract::nuclear(grade)));
        println!(
            "{grade}: {color:.4?}, blue over red {:.3}",
            color[2] / color[0]
        );
        assert!(color[0] > before[0], "{grade}: no lighter than before");
        before = color;
    }
    // A brunescent lens is browner than a grey one.
    let (grey, _) = shown(&mut headless, Some(Cataract::nuclear(2.5)));
    assert!(before[2] / before[0] < 0.8 * (grey[2] / grey[0]));
    // A cloud at the capsule before a clear nucleus, and the same behind a brown one.
    let (cloud, _) = shown(&mut headless, Some(Cataract::posterior_subcapsular(5.0)));
    assert!(cloud[1] > 1.8 * clear[1], "{cloud:?} against {clear:?}");
    let both = Cataract {
        nuclear: 6.9,
        ..Cataract::posterior_subcapsular(5.0)
    };
    let (both, media) = shown(&mut headless, Some(both));
    println!("cloud {cloud:.4?}, behind a brown nucleus {both:.4?}");
    assert!(both[2] / both[0] < cloud[2] / cloud[0]);
    assert!(media.capsule_color().z < 0.5 * media.capsule_color().x);
    let (again, _) = shown(&mut headless, None);
    assert!((again[1] - clear[1]).abs() < 2e-3, "{again:?} {clear:?}");
}

#[test]
fn the_view_is_as_yellow_as_the_lens() {
    let _turn = turn();
    let mut headless = opened();
    let mean = |picture: &RgbaImage| color_at(picture, [80, 80], 70);
    let ([_, clear], _) = clouded(&mut headless, None);
    let clear = mean(&clear);
    // No straylight, and no short sight: the colour alone. What the output transform does to bright
    // colours is in both.
    let world = headless.world();
    let mut eyes = world.query::<(&Eye, &mut OcularMedia)>();
    let mut transmittance = Vec3::ONE;
    for (eye, mut media) in eyes.iter_mut(world) {
        if eye.laterality == Laterality::OD {
            media.nuclear_density = 0.5;
            transmittance = media.transmittance();
        }
    }
    for _ in 0..8 {
        headless.stand_still();
        headless.finish_frame();
    }
    settle(&mut headless);
    let yellow = mean(&headless.panel(Which::View).expect("a picture"));
    let found = [0, 1, 2].map(|k| yellow[k] / clear[k]);
    println!("{found:.3?} of {transmittance:.3}");
    // The shoulder takes from what is bright, so a part of it comes out lighter than in proportion.
    for (found, wanted) in found.into_iter().zip(transmittance.to_array()) {
        assert!(
            (found / f64::from(wanted) - 1.0).abs() < 0.12,
            "{found} for {wanted}"
        );
    }
    assert!(found[2] < 0.6 * found[0], "blue goes first");
}

/// Clouded media scatter light before the retina, and what sees nothing sees no veil either.
#[test]
fn a_blind_field_sees_no_veil() {
    let _turn = turn();
    let mut headless = opened();
    let mean = |picture: &RgbaImage| {
        let [w, h] = [picture.width() / 2, picture.height() / 2];
        color_at(picture, [w, h], 70)[1]
    };
    let ([_, whole], _) = clouded(&mut headless, None);
    let world = headless.world();
    let mut eyes = world.query::<(bevy::prelude::Entity, &Eye)>();
    let eyes: Vec<_> = eyes.iter(world).map(|(entity, _)| entity).collect();
    for eye in eyes {
        world
            .entity_mut(eye)
            .insert(Glaucoma::mean_deviation(-30.0));
    }
    let ([_, blind], _) = clouded(&mut headless, None);
    let ([_, veiled], media) = clouded(&mut headless, Some(Cataract::posterior_subcapsular(5.0)));
    assert!(media.straylight_through(6.0) > 10.0);
    let [whole, blind, veiled] = [whole, blind, veiled].map(|picture| mean(&picture));
    println!("{whole:.4} whole, {blind:.4} blind, {veiled:.4} with a veil");
    assert!(blind < 0.2 * whole && veiled < 0.25 * whole);
    // The veil lifts what is dark, by no more than the mean of the picture that is left.
    assert!(veiled < 1.5 * blind + 0.01, "{veiled} for {blind}");
}
