//! Glare: its energy within a cone by quadrature and in closed form, and the simplified equations.

use super::rows::{ErrorRow, Task};
use super::timing::Stopwatch;
use crate::optics::glare::{
    Glare, glare_age_adjusted, glare_general, glare_small_angle, glare_stiles_holladay,
};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Where the quadrature begins (rad); further in the function is flat to 1e-8.
const CENTRE: f64 = 1e-8;

struct Cone {
    glare: Glare,
    theta: f64,
    exact: f64,
}

/// `∫ f dω` within `theta` by Simpson's rule in ln θ with this many intervals (an even number).
fn simpson(glare: Glare, theta: f64, intervals: u32) -> f64 {
    let step = (theta / CENTRE).ln() / f64::from(intervals);
    let mut sum = 0.0;
    for i in 0..=intervals {
        let t = CENTRE * (step * f64::from(i)).exp();
        let weight = match i {
            0 => 1.0,
            i if i == intervals => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        sum += weight * glare.spread(t) * t.sin() * t;
    }
    PI * CENTRE * CENTRE * glare.spread(0.0) + TAU * sum * step / 3.0
}

/// The energy within a cone; `count` eyes and angles.
pub fn energy(stopwatch: &Stopwatch, count: usize) -> Task {
    let mut random = Pcg64::seed_from_u64(18);
    let cases: Vec<Cone> = (0..count)
        .map(|_| {
            let glare = Glare::new(
                random.random_range(20.0..80.0),
                random.random_range(0.0..1.2),
            );
            // 1 second of arc to a right angle, even in the logarithm.
            let least = (1.0_f64 / 3600.0).to_radians();
            let theta = least * (FRAC_PI_2 / least).powf(random.random());
            Cone {
                glare,
                theta,
                exact: simpson(glare, theta, 8192),
            }
        })
        .collect();
    let error = |cone: &Cone, energy: f64| energy - cone.exact;
    let mut rows: Vec<ErrorRow> = Vec::new();
    for intervals in [8, 16, 32, 64, 128, 256, 1024] {
        let run = |cone: &Cone| simpson(cone.glare, cone.theta, intervals);
        rows.push(stopwatch.row(("quadrature", intervals, 0), &cases, run, error));
    }
    let run = |cone: &Cone| cone.glare.energy_within(cone.theta);
    rows.push(stopwatch.row(("closed form", "exact", 0), &cases, run, error));
    Task {
        name: "glare-energy".to_owned(),
        title: "Glare within a cone".to_owned(),
        call: "energy within one angle".to_owned(),
        domain: format!(
            "{count} seeded eyes of 20 to 80 years and pigment 0 to 1.2; cones of 1 second of arc to 90°"
        ),
        reference: "Simpson's rule in ln θ with 8192 intervals".to_owned(),
        unit: "of the light".to_owned(),
        rows,
    }
}

struct Angle {
    age: f64,
    pigment: f64,
    theta: f64,
    exact: f64,
}

/// The simplified equations where all of them are stated, 1 to 30°; `count` eyes and angles.
pub fn equations(stopwatch: &Stopwatch, count: usize) -> Task {
    let mut random = Pcg64::seed_from_u64(19);
    let cases: Vec<Angle> = (0..count)
        .map(|_| {
            let age = random.random_range(20.0..80.0);
            let pigment = random.random_range(0.0..1.2);
            let theta = 30.0_f64.powf(random.random::<f64>()).to_radians();
            Angle {
                age,
                pigment,
                theta,
                exact: Glare::new(age, pigment).spread(theta),
            }
        })
        .collect();
    let error = |at: &Angle, spread: f64| spread / at.exact - 1.0;
    let equation = "equation";
    let rows = vec![
        stopwatch.row(
            (equation, "Stiles–Holladay", 0),
            &cases,
            |at| glare_stiles_holladay(at.theta),
            error,
        ),
        stopwatch.row(
            (equation, "age-adjusted", 0),
            &cases,
            |at| glare_age_adjusted(at.theta, at.age),
            error,
        ),
        stopwatch.row(
            (equation, "small angles", 0),
            &cases,
            |at| glare_small_angle(at.theta, at.age),
            error,
        ),
        stopwatch.row(
            (equation, "general", 0),
            &cases,
            |at| glare_general(at.theta, at.age, at.pigment),
            error,
        ),
        stopwatch.row(
            (equation, "total", 0),
            &cases,
            |at| Glare::new(at.age, at.pigment).spread(at.theta),
            error,
        ),
    ];
    Task {
        name: "glare-equations".to_owned(),
        title: "The CIE's glare equations".to_owned(),
        call: "one eye at one angle".to_owned(),
        domain: format!(
            "{count} seeded eyes of 20 to 80 years and pigment 0 to 1.2; 1 to 30°, even in the logarithm"
        ),
        reference: "the total function of CIE 135/1-1999".to_owned(),
        unit: "relative".to_owned(),
        rows,
    }
}
