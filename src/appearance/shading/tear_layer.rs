//! The tear film as it lies over the eye since the lids last opened. Head frame, mm, s.
//! Twin: `shaders/lib/tear_layer.wgsl`.
//!
//! A blink lays the film down. Its lipid then drifts up, at 2.25 ln(1.05/t) mm/s until 1.05 s have passed (fitted to Owens
//! and Phillips 2001, REFERENCE-face); its waves ride along and come back alike after every blink. Where the film is
//! thinnest it breaks first, some time after the lids opened that is the eye's own
//! ([`crate::anatomy::Cornea::tear_breakup_s`]).

use crate::optics::smoothstep::smoothstep;
use glam::DVec2;

/// How long the lipid drifts up after a blink, s.
pub const TEAR_DRIFT_S: f64 = 1.05;
/// How much thicker and thinner than its mean the lipid is, as a share (a choice: 20 to 120 nm are seen over one eye).
const LIPID_WAVES: f64 = 0.35;
/// How far the surface of a settled film is tilted, rad, and how many times that more one that was just laid down, over how
/// many seconds it calms (choices: the wobble of a reflection after a blink).
const TEAR_TILT: f64 = 0.0016;
const TEAR_FRESH_TILT: f64 = 4.0;
const TEAR_CALMS_S: f64 = 0.35;
/// How far (rad) the surface spreads what it mirrors where the film has broken: the cornea's own is rough.
pub const BROKEN_BLUR: f64 = 0.16;

/// The film at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TearLayer {
    /// Thickness of its lipid, nm.
    pub lipid_nm: f64,
    /// Tilt of its surface, rad.
    pub tilt: DVec2,
    /// Share of it that has broken.
    pub broken: f64,
}

/// Half of the tag of a globe's mesh: the age of its film.
const AGE_CODES: f64 = 65535.0;
/// Steps of an age that differ enough to be drawn anew.
const AGE_STEPS: f64 = 400.0;

/// The code of an age, s, 0 to 100: in steps of 4 ms when it was just laid down and of 1.5 % of itself later.
pub fn tear_age_code(age_s: f64) -> u32 {
    let age = if age_s.is_nan() {
        0.0
    } else {
        age_s.clamp(0.0, 100.0)
    };
    let step = ((4.0 * age).ln_1p() / 6.0 * AGE_STEPS).round() / AGE_STEPS;
    (step.min(1.0) * AGE_CODES).round() as u32
}

/// Age (s) of the film in the tag of a globe's mesh, whose other half is the pupil.
pub fn tear_age(tag: u32) -> f64 {
    0.25 * (6.0 * f64::from(tag >> 16) / AGE_CODES).exp_m1()
}

/// How far up (mm) the lipid has drifted.
pub fn tear_drift(age: f64) -> f64 {
    let t = age.clamp(1e-3, TEAR_DRIFT_S);
    2.25 * t * (1.0 + (TEAR_DRIFT_S / t).ln())
}

/// The film at a `place` of this `age`, whose lipid is so thick in the mean and which begins to break after so long (s);
/// `own` (rad) makes its waves those of this eye.
pub fn tear_layer(place: DVec2, age: f64, lipid_nm: f64, breakup_s: f64, own: f64) -> TearLayer {
    let q = DVec2::new(place.x, place.y - tear_drift(age));
    let warp = DVec2::new((0.9 * q.y + own).sin(), (0.7 * q.x - 1.7 * own).sin());
    let along = 1.3 * q.x + 0.6 * q.y + 0.9 * warp.x + own;
    let across = 2.1 * q.y - 0.8 * q.x + 1.1 * warp.y + 2.0 * own;
    let small = 3.7 * q.x + 2.9 * q.y + 1.5 * (warp.x + warp.y);
    let waves = 0.45 * along.sin() + 0.35 * across.sin() + 0.2 * small.sin();
    let fresh = TEAR_TILT * (1.0 + TEAR_FRESH_TILT * (-age / TEAR_CALMS_S).exp());
    // The thinnest places break first, where they stand.
    let thin = 0.5
        + 0.3 * (1.9 * place.x + 1.3 * warp.y + own).sin()
        + 0.2 * (2.7 * place.y - 0.9 * place.x + 3.0 * own).sin();
    let breaks = breakup_s * (1.0 + 2.5 * thin);
    let broken = smoothstep(1.0, 1.25, age / breaks.max(0.1));
    TearLayer {
        lipid_nm: lipid_nm * (1.0 + LIPID_WAVES * waves) * (1.0 - broken),
        tilt: fresh * DVec2::new(along.cos(), across.cos()),
        broken,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lipid_drifts_as_it_was_filmed() {
        // 7.34 mm/s after 40 ms, nothing from 1.05 s on, 2 mm in between.
        let speed = |t: f64| (tear_drift(t + 1e-5) - tear_drift(t - 1e-5)) / 2e-5;
        assert!((speed(0.04) - 7.34).abs() < 0.05, "{}", speed(0.04));
        assert!(speed(1.06).abs() < 1e-9 && speed(1.04) < 0.03);
        assert!((tear_drift(2.0) - tear_drift(0.04) - 2.0).abs() < 0.03);
    }

    #[test]
    fn a_film_breaks_when_it_is_said_to_and_not_before() {
        let places =
            || (0..40_000).map(|i| DVec2::new(f64::from(i % 200), f64::from(i / 200)) * 0.06 - 6.0);
        let broken = |age: f64, own: f64| {
            places()
                .map(|p| tear_layer(p, age, 55.0, 6.0, own).broken)
                .sum::<f64>()
                / 40_000.0
        };
        for own in [0.0, 1.0, 4.4] {
            assert_eq!(broken(6.0, own), 0.0);
            assert!(broken(9.0, own) > 0.001, "{}", broken(9.0, own));
            assert!(broken(40.0, own) > 0.99);
            let mean = places()
                .map(|p| tear_layer(p, 3.0, 55.0, 6.0, own).lipid_nm)
                .sum::<f64>()
                / 40_000.0;
            assert!((mean - 55.0).abs() < 3.0, "{mean}");
        }
    }

    #[test]
    fn an_age_comes_back_from_its_tag() {
        for age in [0.0, 0.01, 0.3, 1.0, 5.0, 40.0, 100.0] {
            let back = tear_age(tear_age_code(age) << 16 | 0x1234);
            assert!((back - age).abs() <= 0.004 + 0.01 * age, "{age} {back}");
        }
        assert_eq!(tear_age_code(f64::NAN), 0);
        assert_eq!(tear_age_code(1e9), tear_age_code(100.0));
    }
}
