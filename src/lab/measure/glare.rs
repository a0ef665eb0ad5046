//! Scatter in the eye's media: the CIE's total glare function ([`crate::optics::glare`]).
//!
//! In: an eye's age, pigmentation and clouded media. Leaves: the function by angle for a grid of ages and
//! pigmentations and for that eye, and its integrals.

use super::{MeasuredEye, NullReasons, known};
use crate::optics::glare::{Glare, Veil, glare_age_adjusted, glare_general, glare_stiles_holladay};
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
    "media_spread_per_sr: what clouded media scatter beyond that, of the light that enters, through a pupil of \
     3.5 mm; 0 where they are clear. measured_straylight_log: the straylight of the whole eye as a straylight \
     meter finds it, which compares with the light that the media leave where it is.",
    "The CIE 146 equations are stated from 0.1 degrees (general) and 1 to 30 degrees (age-adjusted, \
     Stiles-Holladay).",
    "spread_per_sr, normalised_spread_per_sr, straylight_log and integrals are of the clear eye of that age and \
     pigment, of the patient too; the patient's own pupil changes nothing here.",
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
    /// What clouded media add (sr⁻¹).
    pub media_spread_per_sr: f64,
    /// log10 of the whole eye's straylight parameter as it is measured (deg² sr⁻¹).
    pub measured_straylight_log: f64,
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
        let added = match of {
            "patient" => eye.media_straylight_deg2_per_sr,
            _ => 0.0,
        };
        let eye = (of, age_years, pigment);
        let veil = Veil::new(added, pigment);
        rows.extend(ANGLES_DEG.map(|angle_deg| row(eye, glare, &veil, angle_deg)));
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

fn row(
    (of, age_years, pigment): (&'static str, f64, f64),
    glare: Glare,
    veil: &Veil,
    angle_deg: f64,
) -> GlareRow {
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
    // Against the light that stays, as a meter compares.
    let beside_direct = veil.spread(angle) / (1.0 - veil.scattered());
    let whole = glare.spread(angle) + beside_direct;
    GlareRow {
        of,
        age_years,
        pigment,
        angle_deg,
        spread_per_sr: glare.spread(angle),
        normalised_spread_per_sr: glare.normalised().spread(angle),
        straylight_log: glare.log_straylight(angle),
        media_spread_per_sr: veil.spread(angle),
        measured_straylight_log: (angle_deg * angle_deg * whole).log10(),
        cie_146_general_per_sr: stated("cie_146_general_per_sr", 0.1, 100.0, general),
        cie_146_age_adjusted_per_sr: stated("cie_146_age_adjusted_per_sr", 1.0, 30.0, adjusted),
        stiles_holladay_per_sr: stated("stiles_holladay_per_sr", 1.0, 30.0, classical),
        null_reasons,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::OcularMedia;

    /// At 7°, where straylight is stated, the whole eye's is the healthy one and what the media add.
    #[test]
    fn clouded_media_are_measured_as_a_meter_does() {
        let media = OcularMedia {
            straylight: 40.0,
            ..OcularMedia::healthy(65.0, 0.5)
        };
        let eye = MeasuredEye {
            age_years: 65.0,
            glare_pigment: 0.5,
            media_straylight_deg2_per_sr: 40.0,
            ..MeasuredEye::default()
        };
        let rows = table(&eye).rows;
        let at = |of: &str, angle_deg: f64| {
            rows.iter()
                .find(|row| row.of == of && row.angle_deg == angle_deg)
                .expect("a row")
        };
        let off = at("patient", 7.0).measured_straylight_log - media.log_straylight();
        assert!(off.abs() < 1e-9, "{off}");
        // Of 65 years and the same pigment, clear.
        let clear = rows
            .iter()
            .find(|row| (row.age_years, row.pigment, row.angle_deg) == (65.0, 0.5, 7.0))
            .expect("a row");
        assert_eq!(clear.of, "grid");
        assert_eq!(clear.media_spread_per_sr, 0.0);
        assert!((clear.measured_straylight_log - clear.straylight_log).abs() < 1e-9);
        assert!(clear.measured_straylight_log < at("patient", 7.0).measured_straylight_log - 0.4);
    }
}
