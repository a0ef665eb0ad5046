//! The drawn iris beside paths of light in f64 through the same eye.

use ocularium::appearance::{EyeShading, StudioLight};
use ocularium::lab::iris_picture::{IrisPaths, IrisStage};
use ocularium::prelude::Patient;

/// A brown eye from 30° aside in a window's light, and by a lamp before it.
#[test]
fn the_iris_is_drawn_as_light_goes_through_it() {
    let patient = Patient::preset("healthy-brown");
    for (light, limits) in [
        (StudioLight::Window, [1.25, 1.1]),
        (StudioLight::Penlight, [1.25, 1.1]),
    ] {
        let mut stage = IrisStage::new(&patient, light).expect("a device");
        for (shading, most) in [EyeShading::Fast, EyeShading::Full].into_iter().zip(limits) {
            stage.look_from(30.0).expect("a picture");
            let (picture, drawn) = stage.picture(shading).expect("a picture");
            let paths = IrisPaths::of(&picture);
            let found = paths.beside(&drawn, shading);
            println!("{}, {}: {found:?}", light.name(), shading.name());
            assert!(found.pixels > 5000, "{found:?}");
            // The target is of half floats: of a highlight a hundred times as bright as the iris a twentieth of the iris is lost.
            assert!(found.rounding_percent < 1.0, "{found:?}");
            assert!(
                found.place_px < 0.5 && found.rms_percent < most,
                "{found:?}"
            );
            if light == StudioLight::Window {
                // From a degree and a half further aside it is another picture.
                stage.look_from(31.5).expect("a picture");
                let (_, other) = stage.picture(shading).expect("a picture");
                let found = paths.beside(&other, shading);
                assert!(
                    found.place_px > 0.5 && found.rms_percent > most,
                    "{found:?}"
                );
            }
        }
    }
}

/// From 60° ridges stand before each other: what few steps go past, and what is read sharper than a slanted pixel is, shows there. Before steps
/// were shares of a fibre 2.6 and 2.2 % were off.
#[test]
fn from_far_aside_no_ridge_is_gone_past() {
    let patient = Patient::preset("healthy-brown");
    let mut stage = IrisStage::new(&patient, StudioLight::Window).expect("a device");
    stage.look_from(60.0).expect("a picture");
    for (shading, most) in [(EyeShading::Fast, 1.9), (EyeShading::Full, 1.6)] {
        let (picture, drawn) = stage.picture(shading).expect("a picture");
        let found = IrisPaths::of(&picture).beside(&drawn, shading);
        println!("{}: {found:?}", shading.name());
        assert!(found.pixels > 3000, "{found:?}");
        assert!(
            found.place_px < 0.3 && found.rms_percent < most,
            "{found:?}"
        );
    }
}

/// Sixty-four steps and segments everywhere, in place of a few by what a pixel shows, change the picture, and by next to nothing. How
/// much longer they take is for bench to say.
#[test]
fn few_steps_are_as_good_as_many() {
    use ocularium::lab::eye_frames::fixed_steps;
    let _turn = crate::stage::turn();
    let session = || {
        Ok(crate::stage::session(
            crate::stage::patient("healthy-brown"),
            3,
        ))
    };
    let found = fixed_steps(session, 30.0, 4).expect("a device");
    println!("{found:?}");
    assert!(
        found.full_rms_share > 1e-5 && found.full_rms_share < 0.01,
        "{found:?}"
    );
    assert!(
        found.fast_rms_share > found.full_rms_share && found.fast_rms_share < 0.01,
        "{found:?}"
    );
}
