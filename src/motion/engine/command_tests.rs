//! Tests of what the engine does when it is told something: gaze, blinks, lens, light, settings.

use super::tests::{candidates, difference, engine, seeded};
use super::*;
use crate::motion::settings::BlinkRate;

#[test]
fn a_command_waits_for_latency_and_refractory_time() {
    let quiet = OculomotorSettings {
        saccades: false,
        ..Default::default()
    };
    let mut engine = engine(quiet);
    engine.advance_to(1.0);
    let look = |azimuth_rad| GazeCommand::LookOnce {
        azimuth_rad,
        elevation_rad: 0.0,
        distance_m: 1.0,
    };
    engine.command(1.0, look(0.3)).unwrap();
    engine.advance_to(1.189);
    assert_eq!(engine.state().fixation_index, 0);
    engine.advance_to(1.191);
    assert_eq!(engine.state().fixation_index, 1);
    // A second one in flight waits until the eye has landed and rested.
    engine.command(1.2, look(-0.3)).unwrap();
    engine.advance_to(3.0);
    let records = engine.fixations();
    let (first, second) = (records[1], records[2]);
    assert!(first.end_s - first.start_s >= 0.1 - 1e-9);
    assert!(first.end_s >= 1.2 + 0.19 - 1e-9);
    assert!((second.azimuth_rad + 0.3).abs() < 1e-12);
    assert_eq!(engine.state().fixation_index, 2);
}

#[test]
fn fixed_stays_look_once_goes_on_and_the_start_can_be_set() {
    let fixed = GazeCommand::Fixed {
        azimuth_rad: 0.5,
        elevation_rad: 0.1,
        distance_m: 0.5,
    };
    let mut engine = seeded(4);
    engine.command(0.0, fixed).unwrap();
    engine.advance_to(0.0);
    let state = engine.state();
    assert_eq!(
        (state.gaze_azimuth_rad, state.gaze_elevation_rad),
        (0.5, 0.1)
    );
    assert!((state.accommodation_d - 2.0).abs() < 1e-12);
    engine.advance_to(20.0);
    assert_eq!(engine.state().gaze_azimuth_rad, 0.5);
    assert_eq!(engine.state().fixation_index, 0);
    engine.command(20.0, GazeCommand::Auto).unwrap();
    engine.advance_to(25.0);
    assert!(engine.state().fixation_index > 5);
    // Candidates that come after a first command leave its pose alone.
    let mut told = seeded(4);
    let look = GazeCommand::LookOnce {
        azimuth_rad: 0.2,
        elevation_rad: 0.0,
        distance_m: 1.0,
    };
    told.command(0.0, look).unwrap();
    told.set_candidates(candidates());
    told.advance_to(0.0);
    assert_eq!(told.state().gaze_azimuth_rad, 0.2);
    let mut once = seeded(4);
    let look = GazeCommand::LookOnce {
        azimuth_rad: 2.0,
        elevation_rad: 0.0,
        distance_m: 1.0,
    };
    once.command(2.0, look).unwrap();
    once.advance_to(10.0);
    let reached = once
        .fixations()
        .iter()
        .any(|r| (r.azimuth_rad - crate::anatomy::gaze::OCULOMOTOR_RANGE_RAD).abs() < 1e-12);
    assert!(reached, "clamped to the eye's reach");
    assert!(once.state().fixation_index > 10);
}

#[test]
fn following_glides_when_near_and_jumps_when_far() {
    let mut engine = seeded(2);
    let follow = |degrees: f64| GazeCommand::Follow {
        azimuth_rad: degrees.to_radians(),
        elevation_rad: 0.0,
        distance_m: 1.0,
    };
    engine.command(0.0, follow(0.0)).unwrap();
    engine.command(1.0, follow(2.0)).unwrap();
    engine.advance_to(2.5);
    let state = engine.state();
    assert_eq!(state.fixation_index, 0, "no saccade over 2°");
    assert!((state.gaze_azimuth_rad.to_degrees() - 2.0).abs() < 1e-3);
    engine.command(3.0, follow(15.0)).unwrap();
    engine.advance_to(3.6);
    let state = engine.state();
    assert_eq!(state.fixation_index, 1, "one saccade over 13°");
    assert!((state.gaze_azimuth_rad.to_degrees() - 15.0).abs() < 1e-3);
    // A ramp of 8 °/s sent at 60 Hz is followed within the lag of delay and plant, 1.6°.
    for frame in 0..180 {
        let t = 4.0 + f64::from(frame) / 60.0;
        engine.command(t, follow(15.0 - 8.0 * (t - 4.0))).unwrap();
        engine.advance_to(t);
        let behind = engine.state().gaze_azimuth_rad.to_degrees() - (15.0 - 8.0 * (t - 4.0));
        assert!(behind < 1.7 && behind > -0.1, "{behind} at {t}");
    }
    assert_eq!(engine.state().fixation_index, 1);
}

#[test]
fn blinks_close_count_and_obey() {
    let mut settings = OculomotorSettings {
        blink_rate: BlinkRate::None,
        ..Default::default()
    };
    let mut engine = engine(settings.clone());
    engine.blink_now(1.0).unwrap();
    engine.blink_now(1.05).unwrap();
    engine.advance_to(1.0);
    assert!(!engine.state().blinking);
    engine.advance_to(1.05);
    assert!(engine.state().blinking);
    assert_eq!(engine.state().blink_epoch, 0);
    engine.advance_to(1.08);
    assert_eq!(
        (engine.state().lid_aperture, engine.state().blink_epoch),
        (0.0, 1)
    );
    engine.advance_to(30.0);
    let state = engine.state();
    assert_eq!(
        (state.lid_aperture, state.blinking, state.blink_epoch),
        (1.0, false, 1)
    );
    // Partial ones never count.
    settings.blink_rate = BlinkRate::PerMinute(60.0);
    settings.partial_blink_fraction = 1.0;
    engine.set_settings(settings.clone()).unwrap();
    let mut lowest = 1.0_f64;
    for frame in 0..6_000 {
        engine.advance_to(30.0 + f64::from(frame) * 0.01);
        lowest = lowest.min(engine.state().lid_aperture);
    }
    assert!(lowest > 0.1 && lowest < 0.6, "{lowest}");
    assert_eq!(engine.state().blink_epoch, 1);
    settings.partial_blink_fraction = 0.0;
    engine.set_settings(settings).unwrap();
    engine.advance_to(690.0);
    // About 600 blinks of one a second; the log-normal law has a spread of 0.9 of its mean.
    let blinks = engine.state().blink_epoch as f64;
    assert!((blinks - 600.0).abs() < 100.0, "{blinks}");
}

#[test]
fn the_lens_follows_the_fixation_after_its_latency_within_its_limits() {
    let quiet = OculomotorSettings {
        saccades: false,
        accommodation_amplitude_d: 3.0,
        far_point_d: 1.0,
        ..Default::default()
    };
    let mut engine = engine(quiet);
    engine.set_candidates(Vec::new());
    let fixed = |distance_m| GazeCommand::Fixed {
        azimuth_rad: 0.1,
        elevation_rad: 0.0,
        distance_m,
    };
    engine.command(1.0, fixed(1.0 / 3.0)).unwrap();
    engine.advance_to(1.329);
    assert_eq!(engine.state().accommodation_d, 0.0);
    // One time constant after the latency: (3 − 1)·(1 − 1/e).
    engine.advance_to(1.33 + 0.25);
    let expected = 2.0 * (1.0 - (-1.0_f64).exp());
    assert!((engine.state().accommodation_d - expected).abs() < 1e-9);
    let before_mm = engine.state().pupil_mm;
    engine.command(2.0, fixed(0.001)).unwrap();
    engine.advance_to(8.0);
    assert!(
        (engine.state().accommodation_d - 3.0).abs() < 1e-6,
        "the amplitude is the limit"
    );
    assert!(engine.state().pupil_mm < before_mm + 0.3);
    engine.command(8.0, fixed(f64::INFINITY)).unwrap();
    engine.advance_to(15.0);
    assert!(engine.state().accommodation_d < 1e-4);
}

#[test]
fn settings_change_without_a_jump_and_bad_ones_are_refused() {
    let mut engine = seeded(9);
    engine.advance_to(4.0);
    let before = engine.state();
    let manual = OculomotorSettings {
        seed: 10,
        pupil: PupilMode::Manual(7.0),
        far_point_d: 3.0,
        accommodation_amplitude_d: 1.0,
        ..Default::default()
    };
    engine.set_settings(manual.clone()).unwrap();
    assert!(difference(&before, &engine.state()) < 1e-12);
    engine.advance_to(20.0);
    assert!((engine.state().pupil_mm - 7.0).abs() < 1e-4);
    assert!(engine.state().accommodation_d <= 1.0);
    let bad = OculomotorSettings {
        age_years: f64::NAN,
        ..manual.clone()
    };
    assert!(engine.set_settings(bad.clone()).is_err());
    assert_eq!(engine.settings(), &manual);
    assert!(Oculomotor::new(bad).is_err());
    assert!(engine.blink_now(f64::NAN).is_err());
    assert!(engine.command(f64::INFINITY, GazeCommand::Auto).is_err());
}

/// Switching automatic saccades while a commanded one waits for its latency must not lose it.
#[test]
fn a_change_of_settings_keeps_the_command_that_waits() {
    let mut engine = seeded(9);
    engine.advance_to(1.0);
    let fixed = GazeCommand::Fixed {
        azimuth_rad: 0.25,
        elevation_rad: -0.1,
        distance_m: 1.0,
    };
    engine.command(1.0, fixed).unwrap();
    engine.advance_to(1.01);
    for saccades in [false, true] {
        let settings = OculomotorSettings {
            saccades,
            ..engine.settings().clone()
        };
        engine.set_settings(settings).unwrap();
    }
    engine.advance_to(5.0);
    assert_eq!(engine.state().gaze_azimuth_rad, 0.25);
}

#[test]
fn light_constricts_after_the_latency_of_the_reflex() {
    let dim = |luminance_cd_m2| OculomotorSettings {
        pupil: PupilMode::Auto {
            luminance_cd_m2,
            field_deg2: 900.0,
            both_eyes: true,
        },
        hippus_rms_mm: 0.0,
        saccades: false,
        ..Default::default()
    };
    let mut engine = Oculomotor::new(dim(0.1)).unwrap();
    engine.advance_to(1.0);
    let wide = engine.state().pupil_mm;
    engine.set_settings(dim(1000.0)).unwrap();
    engine.advance_to(1.211);
    assert_eq!(engine.state().pupil_mm, wide);
    engine.advance_to(1.3);
    assert!(engine.state().pupil_mm < wide - 0.2);
    engine.advance_to(10.0);
    let narrow = crate::motion::pupil::unified_diameter_mm(1000.0, 900.0, 30.0, true);
    assert!((engine.state().pupil_mm - narrow).abs() < 1e-6);
}
