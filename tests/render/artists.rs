//! An artist's choices change how an eye looks, each of them, and nothing of what it sees.

use crate::stage::{look, open, patient, session, settle, turn, without_blinks};
use bevy::math::UVec2;
use image::RgbaImage;
use ocularium::appearance::EyeOrbit;
use ocularium::lab::headless::{Headless, Which};
use ocularium::lab::image_difference::Difference;
use ocularium::patients::{FIELDS, PatientFile, PupilSetting};
use ocularium::stage::SessionCommand;

/// The pictures of somebody who is like this from now on, at the moment that it is.
fn pictures(headless: &mut Headless, file: PatientFile) -> [RgbaImage; 2] {
    headless.command(SessionCommand::Change(Box::new(file)));
    settle(headless);
    [Which::Eye, Which::View].map(|which| headless.panel(which).expect("a picture"))
}

#[test]
fn every_choice_of_an_artist_shows_in_the_eye_and_not_in_the_view() {
    let _turn = turn();
    let usual = PatientFile {
        pupil: PupilSetting::Fixed(4.0),
        ..patient("healthy-blue")
    };
    let mut headless = open(
        session(usual.clone(), 5),
        UVec2::splat(200),
        UVec2::splat(48),
        [true, true],
    );
    headless.set_orbit(EyeOrbit {
        // From where the window is mirrored at the limbus.
        azimuth_deg: 50.0,
        distance_mm: 55.0,
        ..EyeOrbit::default()
    });
    settle(&mut headless);
    without_blinks(&mut headless);
    look(&mut headless, 0.0, 0.0, 4.0);
    headless.go_to(0.01);
    headless.go_to(1.0);
    let [eye, view] = pictures(&mut headless, usual.clone());
    let fields: Vec<_> = FIELDS
        .iter()
        .filter(|f| f.name.starts_with("look_"))
        .collect();
    assert_eq!(fields.len(), 21);
    for field in fields {
        for value in [field.range.0, field.range.1] {
            if (field.get)(&usual) == Some(value) {
                continue;
            }
            let mut other = usual.clone();
            (field.set)(&mut other, value);
            let [changed, same] = pictures(&mut headless, other);
            let difference = Difference::between(&eye, &changed).expect("one size");
            assert!(
                difference.max > 3,
                "{} at {value}: {difference:?}",
                field.name
            );
            // Nothing that is not a number: black, or white, would cover much of it.
            let odd = changed
                .pixels()
                .filter(|p| p.0[0] == 0 && p.0[1] == 0 && p.0[2] == 0);
            assert!(odd.count() < 40, "{} at {value} leaves holes", field.name);
            assert_eq!(same, view, "{} at {value} changes what is seen", field.name);
        }
    }
    // And back.
    assert_eq!(pictures(&mut headless, usual)[0], eye);
}
