//! What the oculomotor engine can be told, and the check that keeps nonsense out of it.
//!
//! What enters: a user's numbers. What leaves: the same numbers, known to be finite and in range,
//! or a [`MotionError`] that names the field, the value and the allowed range.

use rand::Rng;
use thiserror::Error;

use super::random;
use crate::anatomy::{PUPIL_RANGE_MM, PUPIL_RANGE_WITH_UNIT};
use crate::motion::attention::AttentionSettings;
use crate::optics::accommodation::hofstetter_amplitude_d;

pub use super::blink::BlinkRate;
pub use super::pupil::PupilMode;

/// Why the engine refuses a setting or a command.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MotionError {
    /// A number lies outside what the model can do.
    #[error("{field} is {value}, but must be {allowed}")]
    OutOfRange {
        /// The setting's or the command's field.
        field: &'static str,
        /// What was given.
        value: f64,
        /// The range in words, with units.
        allowed: &'static str,
    },
}

/// How long fixations last.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum FixationTiming {
    /// Ex-Gaussian durations (µ 180, σ 40, τ 100 ms) above the refractory time, with the
    /// latencies of saccade and lens.
    #[default]
    Physiological,
    /// As in Nießner et al. (2013), section 3: 10–100 ms between features, evenly spread, no
    /// latencies, and a lens that follows within [`NIESSNER_LENS_TIME_CONSTANT_S`]. The saccades
    /// in between keep their human speed, since the globe is seen to turn.
    Niessner,
}

/// Time constant of the lens under [`FixationTiming::Niessner`], s: the paper sets the focal plane
/// at once, and 10 ms is the shortest of its fixations.
pub const NIESSNER_LENS_TIME_CONSTANT_S: f64 = 0.01;

impl FixationTiming {
    /// Draws a fixation's duration, s, never shorter than `refractory_s` for people.
    pub fn draw_duration_s(self, refractory_s: f64, rng: &mut impl Rng) -> f64 {
        match self {
            Self::Physiological => random::ex_gaussian(rng, 0.18, 0.04, 0.1).max(refractory_s),
            Self::Niessner => random::uniform_between(rng, 0.01, 0.1),
        }
    }
}

/// Everything that the engine can be told. Angles are in degrees because people set them.
#[derive(Clone, Debug, PartialEq)]
pub struct OculomotorSettings {
    /// Seed of every random choice.
    pub seed: u64,
    /// Whether the eye looks around by itself. Commands are obeyed either way.
    pub saccades: bool,
    /// Whether spontaneous blinks come. [`super::engine::Oculomotor::blink_now`] works either way.
    pub blinks: bool,
    /// The law of fixation durations.
    pub fixation_timing: FixationTiming,
    /// The law of blink intervals.
    pub blink_rate: BlinkRate,
    /// Share of spontaneous blinks that stop half-way, 0–1.
    pub partial_blink_fraction: f64,
    /// Age in years, 0–120; acts on the pupil. The amplitude is set on its own.
    pub age_years: f64,
    /// Largest response of the lens, D, 0–25; see [`hofstetter_amplitude_d`].
    pub accommodation_amplitude_d: f64,
    /// Vergence that is sharp with a relaxed lens, D, −25 to 25: a myope of −3 D has 3,
    /// a hyperope of +2 D has −2.
    pub far_point_d: f64,
    /// Share of the wanted response that the lens leaves out, 0–0.5.
    pub accommodation_lag: f64,
    /// Time constant of focusing nearer, s, 0.05–2.
    pub accommodation_time_constant_s: f64,
    /// Time from the choice of a target to the start of the lens, s, 0–1. It runs beside the
    /// saccade's latency, not after it.
    pub accommodation_latency_s: f64,
    /// What sets the pupil.
    pub pupil: PupilMode,
    /// Constriction with accommodation, mm/D, 0–1 (in the twenties).
    pub near_response_mm_per_d: f64,
    /// Root mean square of pupillary unrest, mm, 0–0.5.
    pub hippus_rms_mm: f64,
    /// Time from a command or a choice to the saccade, s, 0–1 (people: 0.18–0.20).
    pub latency_s: f64,
    /// Shortest time between two saccades, s, 0–1 (people: 0.1–0.2).
    pub refractory_s: f64,
    /// Nießner's minimal distance to what was looked at before, °, 0.1–4.
    pub minimal_saccade_deg: f64,
    /// Spread of the bivariate Gaussian that draws the first fixation, °, 0.5–60.
    pub first_fixation_sigma_deg: f64,
    /// Time before what was looked at becomes attractive again, s, 0–60. Returns are delayed by
    /// it and never banned (Wilming et al. 2013).
    pub return_delay_s: f64,
    /// Error beyond which following jumps instead of gliding, °, 0.5–20.
    pub catch_up_deg: f64,
    /// Time constant of gliding after a followed target, s, 0.02–1.
    pub pursuit_time_constant_s: f64,
}

impl Default for OculomotorSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            saccades: true,
            blinks: true,
            fixation_timing: FixationTiming::Physiological,
            blink_rate: BlinkRate::Rest,
            partial_blink_fraction: 0.2,
            age_years: 30.0,
            accommodation_amplitude_d: hofstetter_amplitude_d(30.0),
            far_point_d: 0.0,
            accommodation_lag: 0.0,
            accommodation_time_constant_s: 0.25,
            accommodation_latency_s: 0.33,
            pupil: PupilMode::Auto {
                luminance_cd_m2: 100.0,
                field_deg2: 3600.0,
                both_eyes: true,
            },
            near_response_mm_per_d: 0.2,
            hippus_rms_mm: 0.08,
            latency_s: 0.19,
            refractory_s: 0.1,
            minimal_saccade_deg: 1.0,
            first_fixation_sigma_deg: 5.0,
            return_delay_s: 1.5,
            catch_up_deg: 3.0,
            pursuit_time_constant_s: 0.1,
        }
    }
}

impl OculomotorSettings {
    /// The defaults for an age, with Hofstetter's mean amplitude.
    #[must_use]
    pub fn for_age(age_years: f64) -> Self {
        Self {
            age_years,
            accommodation_amplitude_d: hofstetter_amplitude_d(age_years),
            ..Self::default()
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`MotionError::OutOfRange`] for the first field that is not finite or out of its range.
    pub fn check(&self) -> Result<(), MotionError> {
        let ranges = [
            (
                "partial_blink_fraction",
                self.partial_blink_fraction,
                0.0,
                1.0,
                "0 to 1",
            ),
            ("age_years", self.age_years, 0.0, 120.0, "0 to 120 years"),
            (
                "accommodation_amplitude_d",
                self.accommodation_amplitude_d,
                0.0,
                25.0,
                "0 to 25 D",
            ),
            ("far_point_d", self.far_point_d, -25.0, 25.0, "-25 to 25 D"),
            (
                "accommodation_lag",
                self.accommodation_lag,
                0.0,
                0.5,
                "0 to 0.5",
            ),
            (
                "accommodation_time_constant_s",
                self.accommodation_time_constant_s,
                0.05,
                2.0,
                "0.05 to 2 s",
            ),
            (
                "accommodation_latency_s",
                self.accommodation_latency_s,
                0.0,
                1.0,
                "0 to 1 s",
            ),
            (
                "near_response_mm_per_d",
                self.near_response_mm_per_d,
                0.0,
                1.0,
                "0 to 1 mm/D",
            ),
            ("hippus_rms_mm", self.hippus_rms_mm, 0.0, 0.5, "0 to 0.5 mm"),
            ("latency_s", self.latency_s, 0.0, 1.0, "0 to 1 s"),
            ("refractory_s", self.refractory_s, 0.0, 1.0, "0 to 1 s"),
            (
                "minimal_saccade_deg",
                self.minimal_saccade_deg,
                0.1,
                4.0,
                "0.1 to 4 degrees",
            ),
            (
                "first_fixation_sigma_deg",
                self.first_fixation_sigma_deg,
                0.5,
                60.0,
                "0.5 to 60 degrees",
            ),
            (
                "return_delay_s",
                self.return_delay_s,
                0.0,
                60.0,
                "0 to 60 s",
            ),
            (
                "catch_up_deg",
                self.catch_up_deg,
                0.5,
                20.0,
                "0.5 to 20 degrees",
            ),
            (
                "pursuit_time_constant_s",
                self.pursuit_time_constant_s,
                0.02,
                1.0,
                "0.02 to 1 s",
            ),
        ];
        for (field, value, low, high, allowed) in ranges {
            within(field, value, low, high, allowed)?;
        }
        self.check_rates()
    }

    fn check_rates(&self) -> Result<(), MotionError> {
        if let BlinkRate::PerMinute(rate) = self.blink_rate {
            within("blink_rate", rate, 0.01, 60.0, "0.01 to 60 a minute")?;
        }
        match self.pupil {
            PupilMode::Manual(mm) => {
                let (low, high) = PUPIL_RANGE_MM;
                within("pupil", mm, low, high, PUPIL_RANGE_WITH_UNIT)
            }
            PupilMode::Auto {
                luminance_cd_m2,
                field_deg2,
                ..
            } => {
                within(
                    "luminance_cd_m2",
                    luminance_cd_m2,
                    0.0,
                    1e9,
                    "0 to 1e9 cd/m²",
                )?;
                within(
                    "field_deg2",
                    field_deg2,
                    1e-6,
                    41_253.0,
                    "1e-6 to 41253 deg²",
                )
            }
        }
    }

    /// The part that the choice of targets needs.
    #[must_use]
    pub fn attention(&self) -> AttentionSettings {
        AttentionSettings {
            minimal_distance_rad: self.minimal_saccade_deg.to_radians(),
            first_sigma_rad: self.first_fixation_sigma_deg.to_radians(),
            return_delay_s: self.return_delay_s,
        }
    }

    /// Latency of a commanded saccade, s: none as in the paper.
    pub(super) fn command_latency_s(&self) -> f64 {
        match self.fixation_timing {
            FixationTiming::Physiological => self.latency_s,
            FixationTiming::Niessner => 0.0,
        }
    }

    /// Shortest time between two saccades under the timing in use, s.
    pub(super) fn refractory_in_use_s(&self) -> f64 {
        match self.fixation_timing {
            FixationTiming::Physiological => self.refractory_s,
            FixationTiming::Niessner => 0.01,
        }
    }

    /// Latency of the lens under the timing in use, s.
    pub(super) fn lens_latency_s(&self) -> f64 {
        match self.fixation_timing {
            FixationTiming::Physiological => self.accommodation_latency_s,
            FixationTiming::Niessner => 0.0,
        }
    }
}

/// Refuses what is not finite or outside `low ..= high`.
pub(super) fn within(
    field: &'static str,
    value: f64,
    low: f64,
    high: f64,
    allowed: &'static str,
) -> Result<(), MotionError> {
    // A NaN is in no range.
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(MotionError::OutOfRange {
            field,
            value,
            allowed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Spoil = fn(&mut OculomotorSettings, f64);

    #[test]
    fn defaults_pass_and_every_number_is_checked() {
        assert_eq!(OculomotorSettings::default().check(), Ok(()));
        assert_eq!(OculomotorSettings::for_age(70.0).check(), Ok(()));
        let spoils: [Spoil; 20] = [
            |s, v| s.partial_blink_fraction = v,
            |s, v| s.age_years = v,
            |s, v| s.accommodation_amplitude_d = v,
            |s, v| s.far_point_d = v,
            |s, v| s.accommodation_lag = v,
            |s, v| s.accommodation_time_constant_s = v,
            |s, v| s.accommodation_latency_s = v,
            |s, v| s.near_response_mm_per_d = v,
            |s, v| s.hippus_rms_mm = v,
            |s, v| s.latency_s = v,
            |s, v| s.refractory_s = v,
            |s, v| s.minimal_saccade_deg = v,
            |s, v| s.first_fixation_sigma_deg = v,
            |s, v| s.return_delay_s = v,
            |s, v| s.catch_up_deg = v,
            |s, v| s.pursuit_time_constant_s = v,
            |s, v| s.blink_rate = BlinkRate::PerMinute(v),
            |s, v| s.pupil = PupilMode::Manual(v),
            |s, v| s.pupil = auto(v, 100.0),
            |s, v| s.pupil = auto(100.0, v),
        ];
        for (i, spoil) in spoils.iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, -1e3, 1e12] {
                let mut settings = OculomotorSettings::default();
                spoil(&mut settings, value);
                assert!(settings.check().is_err(), "field {i} took {value}");
            }
        }
    }

    fn auto(luminance_cd_m2: f64, field_deg2: f64) -> PupilMode {
        PupilMode::Auto {
            luminance_cd_m2,
            field_deg2,
            both_eyes: true,
        }
    }

    #[test]
    fn the_message_names_field_value_and_range() {
        let settings = OculomotorSettings {
            pupil: PupilMode::Manual(12.0),
            ..Default::default()
        };
        let message = settings.check().unwrap_err().to_string();
        assert_eq!(message, "pupil is 12, but must be 1 to 9 mm");
    }

    #[test]
    fn the_paper_s_fixations_last_10_to_100_ms_and_people_s_follow_the_ex_gaussian() {
        let count = 20_000_u64;
        let mut sum = 0.0;
        for n in 0..count {
            let rng = &mut random::stream(1, "fixation", n);
            let paper = FixationTiming::Niessner.draw_duration_s(0.1, rng);
            assert!((0.01..0.1).contains(&paper));
            let human = FixationTiming::Physiological.draw_duration_s(0.1, rng);
            assert!(human >= 0.1);
            sum += human;
        }
        // µ + τ = 0.28 s; the floor at 0.1 s moves the mean by less than 1 ms.
        assert!((sum / count as f64 - 0.28).abs() < 0.004);
    }
}
