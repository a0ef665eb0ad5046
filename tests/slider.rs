//! A slider that is drawn along.

use crate::people::difference;
use crate::stage::{open, patient, session, settle, turn};
use bevy::math::UVec2;
use ocularium::lab::headless::Which;
use ocularium::stage::SessionCommand;
use std::time::Instant;

/// Each change of an iris' melanin is seen in the very next frame, for which of the eye's images only those that hang on it are made:
/// of the stroma's and of its kind the table of colours, of the border layer's the iris' map too.
#[test]
fn another_melanin_shows_at_once() {
    let _turn = turn();
    let (eye, view) = (UVec2::splat(96), UVec2::splat(16));
    let session = session(patient("healthy-brown"), 3);
    let mut headless = open(session, eye, view, [true, false]);
    settle(&mut headless);
    headless.set_orbit(ocularium::appearance::EyeOrbit {
        distance_mm: 35.0,
        ..Default::default()
    });
    let mut time_s = 0.5;
    headless.go_to(time_s);
    for field in 0..3 {
        let mut times = Vec::new();
        for step in 0..5 {
            let value = Some([0.001, 0.9, 0.01, 0.5, 0.05][step]);
            let mut file = patient("healthy-brown");
            match field {
                0 => file.stroma_melanin_fraction = value.map(|v| 0.5 * v),
                1 => file.eumelanin_ratio = value,
                _ => file.border_layer_melanin_fraction = value.map(|v| 0.5 * v),
            }
            let was = headless.panel(Which::Eye).expect("a picture");
            let before = headless.work();
            headless.command(SessionCommand::Change(Box::new(file)));
            time_s += 0.001;
            let from = Instant::now();
            headless.go_to(time_s);
            headless.finish_frame();
            times.push(from.elapsed().as_secs_f64() * 1e3);
            let bytes = headless.work().since(before).bytes_uploaded;
            let is_table_alone = (10_000..1_000_000).contains(&bytes);
            assert_eq!(is_table_alone, field < 2, "{field}: {bytes}");
            let now = headless.panel(Which::Eye).expect("a picture");
            let changed = difference(&was, &now);
            assert!(changed > 0.3, "{field}, {step}: {changed}");
            // In a millisecond nothing else changes by as much.
            time_s += 0.001;
            headless.go_to(time_s);
            let rest = difference(&now, &headless.panel(Which::Eye).expect("a picture"));
            assert!(rest < 0.1, "{field}, {step}: {rest}");
        }
        println!("{field}: {times:?} ms");
    }
}
