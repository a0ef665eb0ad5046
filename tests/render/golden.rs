//! The pictures as they were approved, and the proof that another patient is refused.

use super::picture;
use crate::stage::{alone, look, open, patient, session, settle, without_blinks};
use bevy::math::UVec2;
use image::RgbaImage;
use ocularium::anatomy::PatientFile;
use ocularium::app::SessionCommand;
use ocularium::lab::headless::{Headless, Which};
use ocularium::lab::image_difference::{Difference, Limits, difference_picture};
use ocularium::lab::render::encode_png;
use std::path::{Path, PathBuf};

/// Approved pictures of one moment: 160 × 160, seed 7, half a second after the eye was told to
/// look at the letter. On one device they are equal but for the order of atomics; another one may
/// round otherwise along edges.
const LIMITS: Limits = Limits {
    mean: 1.5,
    percentile_99: 20,
};

fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.png"))
}

fn pictures_of(headless: &mut Headless, patient: PatientFile) -> [(&'static str, RgbaImage); 2] {
    headless.command(SessionCommand::Patient(Box::new(patient)));
    headless.go_to(0.0);
    settle(headless);
    without_blinks(headless);
    look(headless, 13.0, -14.5, 0.6);
    for time_s in [0.01, 0.25, 0.5] {
        headless.go_to(time_s);
    }
    [
        ("eye", picture(headless, Which::Eye)),
        ("view", picture(headless, Which::View)),
    ]
}

/// Is the picture the approved one? Leaves the picture and the difference where it is not.
fn keeps(name: &str, actual: &RgbaImage) -> Result<(), String> {
    let path = golden_path(name);
    let golden = image::open(&path)
        .map_err(|error| format!("{}: {error}; OCULARIUM_BLESS=1 writes it", path.display()))?
        .to_rgba8();
    let difference = Difference::between(&golden, actual).ok_or("another size")?;
    if difference.keeps(&LIMITS) {
        return Ok(());
    }
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("out/golden");
    save(&out.join(format!("{name}-actual.png")), actual);
    save(
        &out.join(format!("{name}-difference.png")),
        &difference_picture(&golden, actual),
    );
    Err(format!(
        "{name}: {difference:?} exceeds {LIMITS:?}; see {}",
        out.display()
    ))
}

fn save(path: &Path, picture: &RgbaImage) {
    let folder = path.parent().expect("a folder");
    std::fs::create_dir_all(folder).expect("a folder for pictures");
    std::fs::write(path, encode_png(picture).expect("a PNG")).expect("a written picture");
}

#[test]
fn the_pictures_are_the_approved_ones() {
    let _alone = alone();
    let size = UVec2::splat(160);
    let mut headless = open(session(patient("healthy-brown"), 7), size, size, [true; 2]);
    let approved = pictures_of(&mut headless, patient("healthy-blue"));
    if std::env::var_os("OCULARIUM_BLESS").is_some_and(|value| value == "1") {
        for (name, actual) in &approved {
            save(&golden_path(name), actual);
        }
    }
    // A green iris and 3 D of myopia are within no limits.
    let other = pictures_of(&mut headless, patient("myope-3d"));
    for (name, actual) in &other {
        let golden = image::open(golden_path(name)).map(|golden| golden.to_rgba8());
        if let Ok(golden) = golden {
            let difference = Difference::between(&golden, actual).expect("one size");
            assert!(
                !difference.keeps(&LIMITS),
                "{name} of another patient: {difference:?}"
            );
        }
    }
    for (name, actual) in &approved {
        keeps(name, actual).unwrap_or_else(|why| panic!("{why}"));
    }
}
