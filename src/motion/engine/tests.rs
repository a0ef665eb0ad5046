//! Tests of the engine: independence of the frame rate, laws of timing, commands and extremes.

use super::*;
use crate::anatomy::Laterality;
use crate::conditions::GlaucomaStage;
use crate::motion::trace::{TraceRow, write_trace};
use proptest::prelude::*;

pub(super) fn candidates() -> Vec<Candidate> {
    (-10..=10)
        .flat_map(|x| {
            (-6..=6).map(move |y| Candidate {
                azimuth_rad: (f64::from(x) * 3.1).to_radians(),
                elevation_rad: (f64::from(y) * 3.3).to_radians(),
                score: f64::from((x * 5 + y * 3_i32).rem_euclid(7)),
                distance_m: 0.3 * 1.6_f64.powi((x + 2 * y).rem_euclid(8)),
            })
        })
        .collect()
}

pub(super) fn engine(settings: OculomotorSettings) -> Oculomotor {
    let mut engine = Oculomotor::new(settings).unwrap();
    engine.set_candidates(candidates());
    engine
}

pub(super) fn seeded(seed: u64) -> Oculomotor {
    engine(OculomotorSettings {
        seed,
        ..Default::default()
    })
}

/// Commands of every kind, so the invariance holds for them too.
fn tell(engine: &mut Oculomotor) {
    let point = |azimuth_rad: f64| (azimuth_rad, -0.1, 0.7);
    let (azimuth_rad, elevation_rad, distance_m) = point(0.4);
    let commands = [
        (
            1.3,
            GazeCommand::LookOnce {
                azimuth_rad,
                elevation_rad,
                distance_m,
            },
        ),
        (
            3.05,
            GazeCommand::Fixed {
                azimuth_rad: -0.3,
                elevation_rad,
                distance_m,
            },
        ),
        (
            4.0,
            GazeCommand::Follow {
                azimuth_rad: -0.28,
                elevation_rad,
                distance_m,
            },
        ),
        (
            4.4,
            GazeCommand::Follow {
                azimuth_rad: 0.3,
                elevation_rad,
                distance_m: 3.0,
            },
        ),
        (
            4.5,
            GazeCommand::Follow {
                azimuth_rad: 0.31,
                elevation_rad,
                distance_m: 3.0,
            },
        ),
        (6.0, GazeCommand::Auto),
    ];
    for (t, command) in commands {
        engine.command(t, command).unwrap();
    }
    engine.blink_now(2.0).unwrap();
}

pub(super) fn difference(a: &OculomotorState, b: &OculomotorState) -> f64 {
    let numbers = |s: &OculomotorState| {
        [
            s.gaze_azimuth_rad,
            s.gaze_elevation_rad,
            s.gaze_torsion_rad,
            s.gaze_velocity_rad_s,
            s.fixation_azimuth_rad,
            s.fixation_elevation_rad,
            s.fixation_distance_m,
            s.accommodation_d,
            s.pupil_mm,
            s.lid_aperture,
            s.fixation_index as f64,
            s.blink_epoch as f64,
        ]
    };
    numbers(a)
        .iter()
        .zip(numbers(b))
        .map(|(x, y)| if *x == y { 0.0 } else { (x - y).abs() })
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    /// The same values at common times for 30, 60 and 144 Hz, a random walk of steps with dt = 0
    /// among them, and one step of 10 s.
    #[test]
    fn the_frame_rate_does_not_matter(
        seed in any::<u64>(),
        paper in any::<bool>(),
        steps in prop::collection::vec(prop_oneof![Just(0.0), 0.0..0.3_f64], 1..60),
    ) {
        let settings = OculomotorSettings {
            seed,
            fixation_timing: if paper { FixationTiming::Niessner } else { FixationTiming::Physiological },
            ..Default::default()
        };
        let at_once = |t: f64| {
            let mut engine = engine(settings.clone());
            tell(&mut engine);
            engine.advance_to(t);
            engine.state()
        };
        for rate in [30_u32, 60, 144] {
            let mut stepped = engine(settings.clone());
            tell(&mut stepped);
            for frame in 0..=10 * rate {
                stepped.advance_to(f64::from(frame) / f64::from(rate));
                if frame % (2 * rate) == 0 {
                    let state = stepped.state();
                    prop_assert!(difference(&state, &at_once(state.time_s)) < 1e-9);
                }
            }
        }
        let mut stepped = engine(settings.clone());
        tell(&mut stepped);
        let mut t = 0.0;
        for step in steps {
            t += step;
            stepped.advance_to(t);
        }
        prop_assert!(difference(&stepped.state(), &at_once(t)) < 1e-9);
        stepped.advance_to(t + 10.0);
        prop_assert!(difference(&stepped.state(), &at_once(t + 10.0)) < 1e-9);
    }

    /// Whatever comes in, finite numbers in their ranges come out.
    #[test]
    fn nothing_but_usable_numbers_leaves(
        seed in any::<u64>(),
        azimuth_rad in prop_oneof![Just(f64::NAN), -4.0..4.0_f64],
        distance_m in prop_oneof![Just(f64::INFINITY), Just(0.001), -1.0..3.0_f64],
        score in prop_oneof![Just(f64::INFINITY), Just(0.0), -1.0..1.0_f64],
        steps in prop::collection::vec(prop_oneof![Just(0.0), Just(10.0), Just(f64::NAN), 0.0..1.0_f64], 1..30),
    ) {
        let mut engine = seeded(seed);
        engine.set_candidates(vec![
            Candidate { azimuth_rad, elevation_rad: 0.1, score, distance_m },
            Candidate { azimuth_rad: 0.1, elevation_rad: azimuth_rad, score: 1.0, distance_m: 0.001 },
        ]);
        let command = GazeCommand::Follow { azimuth_rad, elevation_rad: 0.2, distance_m };
        let refused = azimuth_rad.is_nan() || azimuth_rad.abs() > std::f64::consts::PI || distance_m <= 0.0;
        prop_assert_eq!(engine.command(0.5, command).is_err(), refused);
        let mut t = 0.0;
        for step in steps {
            engine.advance_to(t + step);
            t = engine.time_s();
            let s = engine.state();
            for value in [s.gaze_azimuth_rad, s.gaze_elevation_rad, s.gaze_torsion_rad, s.gaze_velocity_rad_s] {
                prop_assert!(value.is_finite());
            }
            prop_assert!((0.0..=1.0).contains(&s.lid_aperture));
            prop_assert!((1.0..=9.0).contains(&s.pupil_mm));
            prop_assert!((0.0..=25.0).contains(&s.accommodation_d));
            prop_assert!(s.fixation_distance_m > 0.0);
        }
    }
}

fn trace(seed: u64, rate: u32, seconds: u32) -> Vec<u8> {
    let mut engine = seeded(seed);
    let rows: Vec<TraceRow> = (0..=rate * seconds)
        .map(|frame| {
            engine.advance_to(f64::from(frame) / f64::from(rate));
            TraceRow::from(&engine.state())
        })
        .collect();
    let mut out = Vec::new();
    write_trace(&rows, &mut out).unwrap();
    out
}

#[test]
fn the_same_seed_writes_the_same_bytes_and_another_does_not() {
    assert_eq!(trace(7, 60, 10), trace(7, 60, 10));
    assert_ne!(trace(7, 60, 10), trace(8, 60, 10));
    let mut reset = seeded(8);
    reset.advance_to(3.0);
    reset.reset(7);
    reset.advance_to(5.0);
    let mut fresh = seeded(7);
    fresh.advance_to(5.0);
    assert_eq!(difference(&reset.state(), &fresh.state()), 0.0);
}

#[test]
fn gaze_never_jumps_and_arrives_within_a_thousandth_of_a_degree() {
    let mut engine = seeded(3);
    tell(&mut engine);
    let step = 0.000_5;
    let mut last: Option<OculomotorState> = None;
    for i in 0..20_000 {
        engine.advance_to(f64::from(i) * step);
        let state = engine.state();
        if let Some(last) = last {
            let gaze =
                |s: &OculomotorState| GazeAngles::new(s.gaze_azimuth_rad, s.gaze_elevation_rad);
            let moved = gaze(&last).angle_to(gaze(&state));
            // 502 °/s is the asymptote of the main sequence.
            assert!(
                moved <= 502.0_f64.to_radians() * step * 1.0001,
                "{moved} at {i}"
            );
            // Twice the mean speed bounds a jump of the lens or the pupil in half a millisecond.
            assert!((state.accommodation_d - last.accommodation_d).abs() < 0.1);
            assert!((state.pupil_mm - last.pupil_mm).abs() < 0.02);
            assert!((state.lid_aperture - last.lid_aperture).abs() < 30.0 * step);
        }
        last = Some(state);
    }
    for record in engine.fixations() {
        let mut again = seeded(3);
        tell(&mut again);
        if record.end_s.is_finite() && record.end_s > record.start_s {
            again.advance_to(record.start_s);
            let s = again.state();
            let target = GazeAngles::new(record.azimuth_rad, record.elevation_rad);
            let gaze = GazeAngles::new(s.gaze_azimuth_rad, s.gaze_elevation_rad);
            assert!(gaze.angle_to(target).to_degrees() < 1e-3);
        }
    }
}

#[test]
fn fixations_of_people_and_of_the_paper_last_as_they_should() {
    for (timing, shortest, longest, mean) in [
        (FixationTiming::Physiological, 0.1, 3.0, 0.28),
        (FixationTiming::Niessner, 0.01, 0.1, 0.055),
    ] {
        let mut engine = engine(OculomotorSettings {
            fixation_timing: timing,
            ..Default::default()
        });
        let (mut durations, mut seen) = (Vec::new(), 0);
        for second in 1..=300 {
            engine.advance_to(f64::from(second));
            for record in engine.fixations() {
                if record.index >= seen && record.end_s.is_finite() && record.index > 0 {
                    durations.push(record.end_s - record.start_s);
                    seen = record.index + 1;
                }
            }
        }
        let average = durations.iter().sum::<f64>() / durations.len() as f64;
        for duration in &durations {
            assert!(
                *duration >= shortest - 1e-9 && *duration <= longest,
                "{duration}"
            );
        }
        println!(
            "{timing:?}: {} fixations, mean {average:.4} s",
            durations.len()
        );
        // About 800 fixations of spread 0.11 s: four standard errors are 0.016 s.
        assert!((average - mean).abs() < 0.02, "{average}");
    }
}

#[test]
fn without_candidates_the_eye_rests_and_a_lost_field_slows_it() {
    let mut alone = Oculomotor::new(OculomotorSettings::default()).unwrap();
    alone.advance_to(10.0);
    assert_eq!(alone.state().fixation_index, 0);
    assert_eq!(alone.state().fixation_distance_m, f64::INFINITY);
    let moves = |field: Option<VisualField>| {
        let mut engine = seeded(6);
        engine.set_visual_field(field);
        engine.advance_to(60.0);
        engine.state().fixation_index
    };
    let severe =
        crate::conditions::glaucoma::glaucoma_field(GlaucomaStage::Severe, Laterality::OD, 50.0);
    let (healthy, sick) = (moves(None), moves(Some(severe)));
    println!("fixations in 60 s: healthy {healthy}, severe {sick}");
    assert!(sick < healthy * 9 / 10 && sick > 20, "{sick} of {healthy}");
}
