//! Scatter in the eye's media: the CIE's total glare function ([`crate::optics::glare`]).
//!
//! In: an eye's age and pigmentation. Leaves: the function by angle for a grid of ages and
//! pigmentations and for that eye, and its integrals.

use super::{MeasuredEye, NullReasons, known};
use crate::optics::glare::{Glare, glare_age_adjusted, glare_general, glare_stiles_holladay};
use core::f64::consts::FRAC_PI_2;
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "CIE 135/1-1999, Vos & van den Berg, Report on disability glare, complete equation (spread)",
    "CIE 146:2002 (cie_146_general, cie_146_age_adjusted)",
    "Stiles & Holladay, 10/angle² (stiles_holladay)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "spread_per_sr: equivalent veiling luminance (cd/m²) per lux at the eye, that is the share of \
     the light per steradian; as published, it holds a little more light than enters. \
     normalised_spread_per_sr is scaled to hold exactly 1 within the hemisphere.",
    "pigment: 0 very dark eyes, 0.5 brown, 1 green, 1.2 light blue.",
    "straylight_log: decimal logarithm of angle² (degrees²) times spread (1/sr).",
    "The CIE 146 equations are stated from 0.1 degrees (general) and 1 to 30 degrees (age-adjusted, \
     Stiles-Holladay).",
    "integrals: energy of the hemisphere is relative to the light that enters; shares are of the \
     hemisphere's light, and do not depend on normalisation.",
];

const AGES_YEARS: [f64; 5] = [20.0, 35.0, 50.0, 65.0, 80.0];
const PIGMENTS: [f64; 4] = [0.0, 0.5, 1.0, 1.2];
const ANGLES_DEG: [f64; 17] = [
    0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 60.0, 90.0,
];

/// The function at one angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlareRow {
    /// `grid`, or `patient`.
    pub of: &'static str,
    /// Age (years).
    pub age_years: f64,
    /// Pigmentation.
    pub pigment: f64,
    /// Angle from the source (degrees).
    pub angle_deg: f64,
    /// As published (sr⁻¹).
    pub spread_per_sr: f64,
    /// With all light kept (sr⁻¹).
    pub normalised_spread_per_sr: f64,
    /// log10 of the straylight parameter (deg² sr⁻¹).
    pub straylight_log: f64,
    /// CIE 146 general (sr⁻¹).
    pub cie_146_general_per_sr: Option<f64>,
    /// CIE 146 age-adjusted Stiles–Holladay (sr⁻¹).
    pub cie_146_age_adjusted_per_sr: Option<f64>,
    /// Stiles–Holladay (sr⁻¹).
    pub stiles_holladay_per_sr: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// Integrals of the function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlareIntegral {
    /// `grid`, or `patient`.
    pub of: &'static str,
    /// Age (years).
    pub age_years: f64,
    /// Pigmentation.
    pub pigment: f64,
    /// Light within the hemisphere as published, relative to what enters.
    pub hemisphere_energy: f64,
    /// The same when normalised.
    pub normalised_hemisphere_energy: f64,
    /// Share of the hemisphere's light beyond 0.1°.
    pub share_beyond_0_1_deg: f64,
    /// Beyond 1°.
    pub share_beyond_1_deg: f64,
    /// Beyond 10°.
    pub share_beyond_10_deg: f64,
    /// Half-angle of the cone with half of the light (arcmin).
    pub half_energy_radius_arcmin: f64,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlareTable {
    /// The function by angle.
    pub rows: Vec<GlareRow>,
    /// Its integrals.
    pub integrals: Vec<GlareIntegral>,
}

/// The grid, then the patient.
pub fn table(eye: &MeasuredEye) -> GlareTable {
    let grid = AGES_YEARS
        .iter()
        .flat_map(|&age| PIGMENTS.iter().map(move |&pigment| ("grid", age, pigment)));
    let patient = ("patient", eye.age_years, eye.glare_pigment);
    let (mut rows, mut integrals) = (Vec::new(), Vec::new());
    for (of, age_years, pigment) in grid.chain([patient]) {
        let glare = Glare::new(age_years, pigment);
        rows.extend(ANGLES_DEG.map(|angle_deg| row(of, age_years, pigment, glare, angle_deg)));
        integrals.push(GlareIntegral {
            of,
            age_years,
            pigment,
            hemisphere_energy: glare.energy_within(FRAC_PI_2),
            normalised_hemisphere_energy: glare.normalised().energy_within(FRAC_PI_2),
            share_beyond_0_1_deg: glare.share_outside(0.1_f64.to_radians()),
            share_beyond_1_deg: glare.share_outside(1.0_f64.to_radians()),
            share_beyond_10_deg: glare.share_outside(10.0_f64.to_radians()),
            half_energy_radius_arcmin: 60.0 * glare.radius_of_share(0.5).to_degrees(),
        });
    }
    GlareTable { rows, integrals }
}

fn row(of: &'static str, age_years: f64, pigment: f64, glare: Glare, angle_deg: f64) -> GlareRow {
    let angle = angle_deg.to_radians();
    let mut null_reasons = NullReasons::new();
    let mut stated = |key, low: f64, high: f64, value: f64| {
        let value = (low..=high).contains(&angle_deg).then_some(value);
        let reason = "outside of the angles for which it is stated";
        known(&mut null_reasons, key, value, reason)
    };
    let general = glare_general(angle, age_years, pigment);
    let adjusted = glare_age_adjusted(angle, age_years);
    let classical = glare_stiles_holladay(angle);
    GlareRow {
        of,
        age_years,
        pigment,
        angle_deg,
        spread_per_sr: glare.spread(angle),
        normalised_spread_per_sr: glare.normalised().spread(angle),
        straylight_log: glare.log_straylight(angle),
        cie_146_general_per_sr: stated("cie_146_general_per_sr", 0.1, 100.0, general),
        cie_146_age_adjusted_per_sr: stated("cie_146_age_adjusted_per_sr", 1.0, 30.0, adjusted),
        stiles_holladay_per_sr: stated("stiles_holladay_per_sr", 1.0, 30.0, classical),
        null_reasons,
    }
}
