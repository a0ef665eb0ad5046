//! The drawn iris beside paths of light in f64 through the same eye.

use ocularium::appearance::StudioLight;
use ocularium::lab::iris_picture::{IrisStage, compare};
use ocularium::prelude::Patient;

/// A brown eye from 30° aside in a window's light, and by a lamp before it.
#[test]
fn the_iris_is_drawn_as_light_goes_through_it() {
    let patient = Patient::preset("healthy-brown");
    for (light, most) in [(StudioLight::Window, 2.0), (StudioLight::Penlight, 3.0)] {
        let mut stage = IrisStage::new(&patient, light).expect("a device");
        let (picture, drawn) = stage.picture(30.0).expect("a picture");
        let found = compare(&picture, &drawn);
        println!("{}: {found:?}", light.name());
        assert!(found.pixels > 5000, "{found:?}");
        // The target is of half floats: of a highlight a hundred times as bright as the iris a twentieth of the iris is lost.
        assert!(found.rounding_percent < 1.0, "{found:?}");
        assert!(
            found.place_px < 0.5 && found.rms_percent < most,
            "{found:?}"
        );
        if light == StudioLight::Window {
            // From a degree and a half further aside it is another picture.
            let (_, other) = stage.picture(31.5).expect("a picture");
            let found = compare(&picture, &other);
            assert!(
                found.place_px > 0.5 && found.rms_percent > most,
                "{found:?}"
            );
        }
    }
}

/// Sixty-four steps of the relief everywhere, in place of a few by what a pixel shows, change the picture, and by next to nothing.
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
    let found = fixed_steps(session, 0.0, 4).expect("a device");
    println!("{found:?}");
    assert!(
        found.rms_share > 1e-5 && found.rms_share < 0.02,
        "{found:?}"
    );
}
