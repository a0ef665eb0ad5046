//! Tests of the choice of targets: laws of amplitude, returns and lost fields.

use super::*;
use crate::anatomy::Laterality;
use crate::conditions::GlaucomaStage;

const SETTINGS: AttentionSettings = AttentionSettings {
    minimal_distance_rad: 0.017_453,
    first_sigma_rad: 0.087_266,
    return_delay_s: 1.5,
};

fn candidate(azimuth_deg: f64, elevation_deg: f64) -> Candidate {
    Candidate {
        azimuth_rad: azimuth_deg.to_radians(),
        elevation_rad: elevation_deg.to_radians(),
        score: 1.0,
        distance_m: 2.0,
    }
}

/// A list over 90° × 60° with uneven scores.
fn grid(spacing_deg: f64) -> Vec<Candidate> {
    let (across, up) = ((45.0 / spacing_deg) as i32, (30.0 / spacing_deg) as i32);
    (-across..=across)
        .flat_map(|x| {
            (-up..=up).map(move |y| Candidate {
                score: f64::from((x * 7 + y * 13_i32).rem_euclid(10)),
                ..candidate(f64::from(x) * spacing_deg, f64::from(y) * spacing_deg)
            })
        })
        .collect()
}

fn dense() -> Vec<Candidate> {
    grid(1.0)
}

struct Walk {
    amplitudes_deg: Vec<f64>,
    steps: usize,
}

fn walk(candidates: &[Candidate], field: Option<&VisualField>, count: u64) -> Walk {
    let mut current = GazeAngles::default();
    let mut path: Vec<GazeAngles> = Vec::new();
    let mut amplitudes_deg = Vec::new();
    for n in 0..count {
        let history: Vec<Visit> = path
            .iter()
            .rev()
            .take(12)
            .enumerate()
            .map(|(i, gaze)| Visit {
                gaze: *gaze,
                left_ago_s: 0.3 * (i as f64 + 1.0),
            })
            .collect();
        let mut rng = random::stream(11, "choice", n);
        if let Some(i) = choose_next(candidates, current, &history, field, &SETTINGS, &mut rng) {
            let next = candidates[i].gaze();
            amplitudes_deg.push(current.angle_to(next).to_degrees());
            path.push(current);
            current = next;
        }
    }
    Walk {
        amplitudes_deg,
        steps: count as usize,
    }
}

fn share_below(amplitudes: &[f64], limit: f64) -> f64 {
    amplitudes.iter().filter(|a| **a < limit).count() as f64 / amplitudes.len() as f64
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn amplitudes_are_those_of_a_natural_task() {
    let walk = walk(&dense(), None, 2_500);
    let (five, fifteen) = (
        share_below(&walk.amplitudes_deg, 5.0),
        share_below(&walk.amplitudes_deg, 15.0),
    );
    println!("under 5°: {five:.3}, under 15°: {fifteen:.3}");
    // Four standard errors of 2,500 draws are 0.04; bins at the edges add a little.
    assert!((five - 0.53).abs() < 0.05, "{five}");
    assert!((fifteen - 0.83).abs() < 0.05, "{fifteen}");
    let smallest = walk.amplitudes_deg.iter().copied().fold(f64::MAX, f64::min);
    assert!(smallest >= 0.999, "{smallest}");
    assert_eq!(walk.amplitudes_deg.len(), walk.steps);
}

#[test]
fn the_normal_quantiles_are_right() {
    for ((_, share), z) in AMPLITUDE_QUANTILES.iter().zip(AMPLITUDE_Z) {
        assert!((normal_cdf(z) - share).abs() < 1e-5);
    }
    assert!((normal_cdf(-1.96) - 0.024_997_9).abs() < 1e-6);
    for minimal in [0.1, 1.0, 4.0] {
        let law = AmplitudeLaw::new(minimal);
        assert!((law.below(5.0) - 0.53).abs() < 1e-5);
        assert!((law.below(15.0) - 0.83).abs() < 1e-5);
    }
}

#[test]
fn the_first_target_is_near_the_centre() {
    let candidates = dense();
    let angles: Vec<f64> = (0..4_000)
        .map(|n| {
            let mut rng = random::stream(5, "first", n);
            let current = GazeAngles::default();
            let i = choose_first(&candidates, current, None, &SETTINGS, &mut rng).unwrap();
            current.angle_to(candidates[i].gaze()).to_degrees()
        })
        .collect();
    // The radius of a bivariate Gaussian of 5° has the mean 5·√(π/2) = 6.27°.
    assert!((mean(&angles) - 6.27).abs() < 0.25, "{}", mean(&angles));
    // Even when all are far away one is drawn.
    let far = [candidate(54.0, 0.0)];
    let tight = AttentionSettings {
        first_sigma_rad: 0.01,
        ..SETTINGS
    };
    let mut rng = random::stream(5, "first", 0);
    assert_eq!(
        choose_first(&far, GazeAngles::default(), None, &tight, &mut rng),
        Some(0)
    );
}

#[test]
fn returns_are_delayed_and_not_banned() {
    let candidates = [candidate(0.0, 0.0), candidate(10.0, 0.0)];
    let current = candidates[1].gaze();
    let return_after = |left_ago_s: f64| {
        let history = [Visit {
            gaze: candidates[0].gaze(),
            left_ago_s,
        }];
        let mut rng = random::stream(1, "choice", 0);
        choose_next(&candidates, current, &history, None, &SETTINGS, &mut rng)
    };
    assert_eq!(return_after(0.3), None);
    assert_eq!(return_after(1.49), None);
    assert_eq!(return_after(1.6), Some(0));
    // One delay after the delay: 1 − 1/e.
    let attraction = attraction_after(3.0, SETTINGS.return_delay_s);
    assert!((attraction - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
}

#[test]
fn a_lost_region_is_never_chosen() {
    let field =
        crate::conditions::glaucoma::glaucoma_field(GlaucomaStage::Severe, Laterality::OD, 50.0);
    let candidates = grid(2.5);
    let current = GazeAngles::new(0.1, -0.05);
    let mut chosen = 0;
    for n in 0..1_500 {
        let mut rng = random::stream(3, "choice", n);
        if let Some(i) = choose_next(&candidates, current, &[], Some(&field), &SETTINGS, &mut rng) {
            let place = current.field_position_of(candidates[i].gaze());
            assert!(field.seen(place.azimuth_rad, place.elevation_rad) >= NOTICED_AT_LEAST);
            chosen += 1;
        }
    }
    assert!(chosen > 400, "{chosen}");
}

/// Free viewing with the worse eye: amplitude −13 % (published), paths shorter and slower. Ours is
/// not tuned to the number; the direction must emerge from the lost field.
#[test]
fn glaucoma_shortens_and_slows_the_path() {
    let candidates = grid(2.5);
    let healthy_field = VisualField::normal(Laterality::OD, 50.0);
    let healthy = walk(&candidates, Some(&healthy_field), 1_000);
    let mut last = mean(&healthy.amplitudes_deg);
    let mut last_moves = healthy.amplitudes_deg.len();
    println!(
        "healthy {last:.2}°, moves {last_moves} of {}",
        healthy.steps
    );
    for stage in [GlaucomaStage::Moderate, GlaucomaStage::Severe] {
        let field = crate::conditions::glaucoma::glaucoma_field(stage, Laterality::OD, 50.0);
        let sick = walk(&candidates, Some(&field), 1_000);
        let amplitude = mean(&sick.amplitudes_deg);
        println!(
            "{stage:?} {amplitude:.2}°, moves {}",
            sick.amplitudes_deg.len()
        );
        assert!(amplitude < 0.95 * last, "{amplitude} against {last}");
        assert!(sick.amplitudes_deg.len() < last_moves);
        (last, last_moves) = (amplitude, sick.amplitudes_deg.len());
    }
}

#[test]
fn empty_single_and_hostile_lists_are_survived() {
    let mut rng = random::stream(1, "choice", 0);
    let ahead = GazeAngles::default();
    assert_eq!(choose_first(&[], ahead, None, &SETTINGS, &mut rng), None);
    assert_eq!(
        choose_next(&[], ahead, &[], None, &SETTINGS, &mut rng),
        None
    );
    let here = [candidate(0.1, 0.0)];
    assert_eq!(
        choose_next(&here, ahead, &[], None, &SETTINGS, &mut rng),
        None
    );
    let dull = [Candidate {
        score: 0.0,
        ..candidate(5.0, 0.0)
    }];
    assert_eq!(
        choose_next(&dull, ahead, &[], None, &SETTINGS, &mut rng),
        Some(0)
    );
    for (azimuth, score, distance) in [
        (f64::NAN, 1.0, 1.0),
        (0.0, f64::NAN, 1.0),
        (0.0, -1.0, 1.0),
        (0.0, 1.0, 0.0),
        (0.0, 1.0, f64::NAN),
    ] {
        let bad = Candidate {
            azimuth_rad: azimuth,
            elevation_rad: 0.0,
            score,
            distance_m: distance,
        };
        assert!(!bad.is_valid());
    }
    assert!(
        Candidate {
            distance_m: f64::INFINITY,
            ..candidate(1.0, 1.0)
        }
        .is_valid()
    );
}
