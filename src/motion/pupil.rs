//! The pupil: its size for a light level, its near response and its unrest.
//!
//! What enters: luminance, field, age, the lens' response and a seed. What leaves: a diameter in
//! mm, 1–9. The size is the unified formula of Watson and Yellott (2012); constriction is three
//! times as fast as dilation; hippus is a seeded sum of sines with the spectrum of pink noise, so
//! it is a function of time like everything else.

use std::f64::consts::TAU;

use super::random;
use crate::anatomy::PUPIL_RANGE_MM;

/// Time constant of constriction, s: a reflex of 2.1 mm then peaks at the measured 5.15 mm/s.
pub const CONSTRICTION_TIME_CONSTANT_S: f64 = 0.4;
/// Time constant of dilation, s: three times slower (Pamplona, Oliveira and Baranoski 2009).
pub const DILATION_TIME_CONSTANT_S: f64 = 3.0 * CONSTRICTION_TIME_CONSTANT_S;
/// Latency of the light reflex, s (0.212 ± 0.010).
pub const LIGHT_REFLEX_LATENCY_S: f64 = 0.212;

/// What sets the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PupilMode {
    /// This diameter exactly, mm, 1–9: no reflex, near response or unrest.
    Manual(f64),
    /// Watson and Yellott's formula.
    Auto {
        /// Mean luminance of the adapting field, cd/m², ≥ 0.
        luminance_cd_m2: f64,
        /// Area of the adapting field, deg², > 0.
        field_deg2: f64,
        /// Whether both eyes see it; one eye alone counts a tenth.
        both_eyes: bool,
    },
}

/// Watson and Yellott's (2012) unified formula: diameter in mm for a luminance in cd/m², a field
/// area in deg² and an age. Their age effect was fitted from 20 to 83 years; ages beyond are taken
/// at the nearer end. Zero or unusable light gives the dark-adapted pupil.
#[must_use]
pub fn unified_diameter_mm(
    luminance_cd_m2: f64,
    field_deg2: f64,
    age_years: f64,
    both_eyes: bool,
) -> f64 {
    let attenuation = if both_eyes { 1.0 } else { 0.1 };
    let flux = (luminance_cd_m2 * field_deg2 * attenuation).max(0.0);
    let x = (flux / 846.0).powf(0.41);
    // x/(x + 2) written so that an endless flux gives 1.
    let share = if x.is_finite() { x / (x + 2.0) } else { 1.0 };
    let young = 7.75 - 5.75 * share;
    young + (age_years.clamp(20.0, 83.0) - 28.58) * (0.021323 - 0.0095623 * young)
}

/// The diameter that a mode settles on, mm, with the near response taken off.
#[must_use]
pub fn steady_diameter_mm(
    mode: PupilMode,
    age_years: f64,
    accommodation_d: f64,
    near_response_mm_per_d: f64,
) -> f64 {
    let diameter = match mode {
        PupilMode::Manual(diameter_mm) => diameter_mm,
        PupilMode::Auto {
            luminance_cd_m2,
            field_deg2,
            both_eyes,
        } => {
            unified_diameter_mm(luminance_cd_m2, field_deg2, age_years, both_eyes)
                - near_response_mm_per_d * accommodation_d
        }
    };
    diameter.clamp(PUPIL_RANGE_MM.0, PUPIL_RANGE_MM.1)
}

/// The time constant of a change of diameter, s.
#[must_use]
pub fn time_constant_s(from_mm: f64, to_mm: f64) -> f64 {
    if to_mm < from_mm {
        CONSTRICTION_TIME_CONSTANT_S
    } else {
        DILATION_TIME_CONSTANT_S
    }
}

const HIPPUS_SINES: usize = 12;

/// Pupillary unrest: a sum of sines of equal amplitude at log-spaced frequencies from 0.05 to
/// 2 Hz, so every octave has the same power (pink), with seeded phases and jittered frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hippus {
    sines: [(f64, f64); HIPPUS_SINES],
}

impl Hippus {
    /// The unrest of this seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut rng = random::stream(seed, "hippus", 0);
        let mut sines = [(0.0, 0.0); HIPPUS_SINES];
        for (i, sine) in sines.iter_mut().enumerate() {
            let place = (i as f64 + random::uniform(&mut rng)) / HIPPUS_SINES as f64;
            let frequency_hz = 0.05 * 40.0_f64.powf(place);
            *sine = (TAU * frequency_hz, TAU * random::uniform(&mut rng));
        }
        Self { sines }
    }

    /// The unrest at time `t` in s, with unit root mean square over a long time.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let amplitude = (2.0 / HIPPUS_SINES as f64).sqrt();
        amplitude
            * self
                .sines
                .iter()
                .map(|(angular, phase)| (angular * t + phase).sin())
                .sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unified_formula_gives_the_published_example() {
        // Watson and Yellott's worked example: 1 cd/m², 900 deg², 45 years, two eyes → 5.240.
        let diameter = unified_diameter_mm(1.0, 900.0, 45.0, true);
        assert!((diameter - 5.240).abs() < 5e-4, "{diameter}");
        // One eye sees a tenth of the light: the same as a tenth of the luminance.
        assert_eq!(
            unified_diameter_mm(10.0, 900.0, 45.0, false),
            unified_diameter_mm(1.0, 900.0, 45.0, true)
        );
    }

    #[test]
    fn the_pupil_shrinks_with_light_and_age_and_stays_in_range() {
        let mut last = f64::INFINITY;
        for exponent in -6..=9 {
            let diameter = unified_diameter_mm(10.0_f64.powi(exponent), 3600.0, 30.0, true);
            assert!(diameter < last && (1.0..9.0).contains(&diameter));
            last = diameter;
        }
        assert!(
            unified_diameter_mm(1.0, 900.0, 80.0, true)
                < unified_diameter_mm(1.0, 900.0, 20.0, true)
        );
        for luminance in [0.0, f64::MAX, f64::INFINITY] {
            assert!(unified_diameter_mm(luminance, 3600.0, 30.0, true).is_finite());
        }
        let auto = PupilMode::Auto {
            luminance_cd_m2: 1e5,
            field_deg2: 3600.0,
            both_eyes: true,
        };
        assert_eq!(steady_diameter_mm(auto, 20.0, 10.0, 1.0), 1.0);
        assert_eq!(
            steady_diameter_mm(PupilMode::Manual(4.0), 20.0, 9.0, 1.0),
            4.0
        );
    }

    #[test]
    fn constriction_is_three_times_faster_and_peaks_as_measured() {
        assert_eq!(time_constant_s(4.0, 6.0), 3.0 * time_constant_s(6.0, 4.0));
        // A reflex of 2.1 mm: first velocity of an exponential, within the measured ± 0.99.
        let peak: f64 = 2.1 / time_constant_s(6.0, 3.9);
        assert!((peak - 5.15).abs() < 0.99, "{peak}");
    }

    #[test]
    fn unrest_has_unit_power_and_differs_by_seed() {
        let hippus = Hippus::new(5);
        let count = 400_000;
        let power = (0..count)
            .map(|i| hippus.at(f64::from(i) * 0.05).powi(2))
            .sum::<f64>()
            / f64::from(count);
        // Over 20,000 s the cross terms of sines at least 0.01 Hz apart average out below 1 %.
        assert!((power - 1.0).abs() < 0.02, "{power}");
        assert_ne!(hippus.at(1.0), Hippus::new(6).at(1.0));
        assert_eq!(hippus.at(1.0), Hippus::new(5).at(1.0));
    }
}
