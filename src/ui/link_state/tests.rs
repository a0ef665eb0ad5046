use super::*;
use crate::anatomy::{IrisColor, Laterality};
use crate::conditions::{Cataract, Glaucoma, GlaucomaStage};
use crate::patients::EyeFile;
use crate::patients::PupilSetting;
use proptest::prelude::*;

fn read(link: &str) -> LinkState {
    let (state, refused) = LinkState::parse(link);
    assert!(refused.is_empty(), "{link}: {refused:?}");
    state
}

fn refusals(link: &str) -> Vec<String> {
    LinkState::parse(link).1
}

#[test]
fn an_empty_link_is_the_usual_state_and_old_links_still_work() {
    for link in ["", "#", "https://example.org/eye/", "v=1"] {
        assert_eq!(read(link), LinkState::default(), "{link:?}");
    }
    assert_eq!(LinkState::default().patient.name, "Healthy, brown");
    // The first notation had these three keys and no version.
    let old = read("#patient=glaucoma-moderate&scene=chart&seed=7");
    assert_eq!(
        old.patient.glaucoma,
        Some(Glaucoma::from(GlaucomaStage::Moderate))
    );
    assert_eq!((old.scene, old.seed), (BuiltIn::Chart, 7));
}

#[test]
fn a_link_is_short_and_readable() {
    let mut state = LinkState::default();
    assert_eq!(
        state.to_fragment(),
        "v=1&patient=healthy-brown&scene=room&seed=1"
    );
    state.patient = load_patient("myope-3d").expect("a preset");
    state.patient.sphere_d = -4.5;
    state.patient.pupil = PupilSetting::Fixed(5.0);
    state.patient.pupil_decentration_mm = [0.3, -0.1];
    state.patient.seed = 9;
    state.shown = [false, true];
    state.gaze = LinkGaze::Fixed {
        azimuth_deg: 13.0,
        elevation_deg: -14.5,
        distance_m: 0.6,
    };
    let text = state.to_fragment();
    for part in [
        "patient=myope-3d",
        "sphere_d=-4.5",
        "pupil=Fixed(5)",
        "pupil_decentration_mm=(0.3,-0.1)",
        "patient_seed=9",
        "&seed=1",
        "panels=view",
        "gaze=13,-14.5,0.6",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    assert_eq!(read(&text), state);
    assert_eq!(read(&format!("http://localhost:8080/x/#{text}")), state);
}

#[test]
fn what_cannot_be_obeyed_is_said_and_the_rest_is_obeyed() {
    for (link, parts) in [
        ("patient=nobody", &["nobody", "healthy-brown, "][..]),
        ("scene=kitchen", &["kitchen", "room, chart"]),
        ("seed=-1", &["seed", "-1", "whole number"]),
        ("v=2", &["version 2", "newer"]),
        ("v=x", &["\"x\""]),
        ("panels=all", &["all", "both, eye, view or none"]),
        ("gaze=1,2", &["1,2", "13,-14.5,0.6"]),
        ("gaze=1,2,0", &["gaze"]),
        ("gaze=80,-80,1", &["gaze", "55"]),
        ("gaze=45,40,1", &["gaze", "55"]),
        ("gaze=1,2,0.001", &["gaze", "0.02"]),
        ("gaze=NaN,2,1", &["gaze"]),
        ("orbit=90,0,93", &["orbit", "-85 to 85"]),
        ("pupil_mm=12", &["pupil_mm", "12", "1 to 9"]),
        ("speed=NaN", &["speed", "0.05 to 4"]),
        ("marker=yes", &["on or off"]),
        ("paused_at_s=-1", &["0 to 3600"]),
        ("colour=red", &["\"colour\"", "not known"]),
        ("age_years=300", &["age_years", "300", "1 to 110"]),
        ("age_years=old", &["age_years", "old"]),
        ("iris_color=Purple", &["iris_color", "Purple", "Brown"]),
        ("name=%1b[31m", &["name", "control"]),
        ("sphere_d=NaN", &["sphere_d", "NaN"]),
        ("redness=0.1", &["redness twice", "last"]),
    ] {
        let held = if link.starts_with("pupil_mm") {
            ""
        } else {
            "&pupil_mm=3"
        };
        let wanted = format!("{link}&redness=0.5{held}");
        let (state, refused) = LinkState::parse(&wanted);
        assert_eq!(refused.len(), 1, "{wanted}: {refused:?}");
        for part in parts {
            assert!(refused[0].contains(part), "{part} is not in {refused:?}");
        }
        assert!(refused[0].ends_with('.') && !refused[0].contains('\n'));
        assert_eq!(state.patient.redness, 0.5, "{wanted}");
        let held_mm = (!held.is_empty()).then_some(3.0);
        assert_eq!(state.held_pupil_mm, held_mm, "{wanted}");
    }
    assert_eq!(refusals(&"x".repeat(LONGEST + 1)).len(), 1);
}

#[test]
fn fields_that_are_sound_only_together_are_judged_together() {
    // A limbus of 6.5 mm needs a wider cornea than the usual one.
    assert!(!refusals("cornea_p=1.3&limbus_radius_mm=6.5").is_empty());
    let wide = read("cornea_radius_mm=9&cornea_p=1&limbus_radius_mm=6.5");
    assert_eq!(wide.patient.limbus_radius_mm, 6.5);
}

#[test]
fn one_fault_costs_nothing_else_of_a_link() {
    for link in [
        "right=(sphere_d:-40)&left=(sphere_d:-40)",
        "scleral_radius_mm=12.5&cornea_radius_mm=6&cornea_p=0.2&limbus_radius_mm=6.5",
        "cataract=(nuclear:8,cortical:inf)",
    ] {
        let (state, refused) = LinkState::parse(&format!("{link}&age_years=61&sphere_d=-2"));
        if refused.is_empty() {
            continue;
        }
        let kept = (state.patient.age_years, state.patient.sphere_d);
        assert_eq!(kept, (61.0, -2.0), "{link}: {refused:?}");
    }
    assert!(!refusals("right=(sphere_d:-40)&left=(sphere_d:-40)").is_empty());
    assert!(!refusals("cataract=(nuclear:8,cortical:inf)").is_empty());
}

fn patients() -> impl Strategy<Value = PatientFile> {
    let colours = prop_oneof![
        Just(IrisColor::Blue),
        Just(IrisColor::Green),
        Just(IrisColor::Brown)
    ];
    let pupils = prop_oneof![
        Just(PupilSetting::Auto),
        (1.0..=9.0).prop_map(PupilSetting::Fixed)
    ];
    let stages = prop_oneof![
        Just(None),
        Just(Some(GlaucomaStage::Early)),
        Just(Some(GlaucomaStage::Severe))
    ];
    let eyes = prop_oneof![Just(Laterality::OD), Just(Laterality::OS)];
    (
        (0..PRESETS.len(), "[^\\p{Cc}]{0,20}", any::<u64>(), eyes),
        (1.0..=110.0, -20.0..=20.0, proptest::option::of(0.0..=0.5)),
        (colours, pupils, stages, [-1.0..=1.0, -1.0..=1.0]),
    )
        .prop_map(
            |((preset, name, seed, eye), numbers, choices)| PatientFile {
                name,
                seed,
                eye,
                age_years: numbers.0,
                sphere_d: numbers.1,
                stroma_melanin_fraction: numbers.2,
                iris_color: choices.0,
                pupil: choices.1,
                glaucoma: choices.2.map(Glaucoma::from),
                cataract: numbers.2.map(|share| Cataract::nuclear(10.0 * share)),
                left: EyeFile {
                    sphere_d: numbers.2.map(|share| -20.0 * share),
                    ..EyeFile::default()
                },
                pupil_decentration_mm: choices.3,
                ..load_patient(PRESETS[preset].name).expect("a preset")
            },
        )
}

proptest! {
    #[test]
    fn every_state_survives_its_link(
        patient in patients(),
        seed in any::<u64>(),
        shown in any::<[bool; 2]>(),
        hundredths in (-3800i32..3800, -3800i32..3800, 2i32..100_000),
        fixed in any::<bool>(),
        paused in proptest::option::of(0u32..3_600_000),
    ) {
        let gaze = LinkGaze::Fixed {
            azimuth_deg: f64::from(hundredths.0) / 100.0,
            elevation_deg: f64::from(hundredths.1) / 100.0,
            distance_m: f64::from(hundredths.2) / 100.0,
        };
        let state = LinkState {
            patient,
            scene: BuiltIn::ALL[usize::from(fixed)],
            seed,
            shown,
            gaze: if fixed { gaze } else { LinkGaze::Follow },
            held_pupil_mm: fixed.then_some(f64::from(hundredths.2 % 800 + 100) / 100.0),
            light: PanelLight::of(["window", "scene", "overcast"][hundredths.0.unsigned_abs() as usize % 3]).expect("a light"),
            orbit: EyeOrbit { azimuth_deg: hundredths.0 as f32 / 100.0, ..EyeOrbit::default() },
            speed: 0.25,
            marker: fixed,
            paused_at_s: paused.map(|ms| f64::from(ms) / 1000.0),
        };
        let text = state.to_fragment();
        let (again, refused) = LinkState::parse(&text);
        prop_assert!(refused.is_empty(), "{}: {:?}", text, refused);
        // The orbit is kept to a tenth of a degree.
        prop_assert!((again.orbit.azimuth_deg - state.orbit.azimuth_deg).abs() <= 0.051);
        let same = LinkState { orbit: state.orbit, ..again.clone() };
        prop_assert_eq!(same, state);
        prop_assert_eq!(again.to_fragment(), text);
    }

    #[test]
    fn no_text_makes_it_fail(text in "\\PC{0,200}", keyed in "(seed|gaze|name|pupil|orbit|sphere_d)=[^&]{0,40}") {
        for link in [text.clone(), keyed.clone(), format!("{text}&{keyed}")] {
            let (state, _) = LinkState::parse(&link);
            prop_assert!(state.patient.check("x").is_ok());
            let again = LinkState::parse(&state.to_fragment()).0;
            prop_assert_eq!(again.seed, state.seed);
        }
    }
}
