//! Absorption by melanin and scattering by collagen: equations 10 to 14 of François et al. 2007.
//!
//! In: a wavelength in nm, volume fractions. Out: coefficients in mm⁻¹.
//!
//! **Where they come from.** François copies Donner & Jensen 2006 (A Spectral BSSRDF for Shading
//! Human Skin) to the digit; these take equations 10 and 12 from Jacques' summary of skin optics
//! (Oregon Medical Laser Center News, January 1998, in cm⁻¹), and fit equation 11 to Sarna & Swartz. Equation 14 is their reduced
//! scattering of the *epidermis*; they halve it for the dermis.
//!
//! **Range.** Wavelengths are clamped to 350…1,100 nm, where equation 12 was measured; what is not
//! a number counts as 550 nm. Fractions are taken as they come: 0 to 1.

/// The pheomelanin constant of equation 11 as printed by François and by Donner & Jensen, in
/// mm⁻¹ nm^4.75.
///
/// Sarna & Swartz's extinction, as Jacques read it off their figure, is 2.96e13 λ^−4.75 cm⁻¹ for
/// 1 mg/mL of pheomelanin and 7.5e9 λ^−3.33 for eumelanin (400 to 700 nm). Equation 10 is thus
/// 88 mg/mL of eumelanin, and as much pheomelanin has 2.6e14 λ^−4.75 mm⁻¹: the printed constant is
/// right per millimetre, within 11 %, if melanosomes hold as much of the one as of the other.
pub const PHEOMELANIN_FRANCOIS: f64 = 2.9e14;

/// A tenth of it, the constant read as cm⁻¹ nm^4.75: melanosomes with only 10 mg/mL of pheomelanin.
/// With it, the fractions that make a hazel iris leave it blue-grey.
pub const PHEOMELANIN_DILUTE: f64 = 2.9e13;

use super::blood::iris_blood_absorption;
use super::spectrum::{FIRST_NM, SAMPLES, STEP_NM, Spectrum};
use super::wavelengths::Wavelengths;

/// A wavelength (nm) within the range of the data.
fn within_range(wavelength_nm: f64) -> f64 {
    if wavelength_nm.is_nan() {
        550.0
    } else {
        wavelength_nm.clamp(350.0, 1100.0)
    }
}

/// Equation 10: absorption of eumelanin (mm⁻¹), a fit to Jacques & McAuliffe 1991.
pub fn eumelanin_absorption(wavelength_nm: f64) -> f64 {
    6.6e10 * within_range(wavelength_nm).powf(-3.33)
}

/// Equation 11: absorption of pheomelanin (mm⁻¹), a fit to Sarna & Swartz 1998. `constant` is
/// [`PHEOMELANIN_FRANCOIS`] or [`PHEOMELANIN_DILUTE`].
pub fn pheomelanin_absorption(wavelength_nm: f64, constant: f64) -> f64 {
    constant * within_range(wavelength_nm).powf(-4.75)
}

/// Equation 12: absorption (mm⁻¹) of tissue without pigment, after Jacques 1998 for skin.
pub fn baseline_absorption(wavelength_nm: f64) -> f64 {
    0.0244 + 8.53 * (-(within_range(wavelength_nm) - 154.0) / 66.2).exp()
}

/// Equation 13: absorption (mm⁻¹) of tissue with the volume fraction `melanin_fraction` of melanin,
/// of which `eumelanin_ratio` is eumelanin; both 0 to 1. (The paper's "σ_pm λ" reads σ_pm(λ).)
pub fn tissue_absorption(wavelength_nm: f64, melanin_fraction: f64, eumelanin_ratio: f64) -> f64 {
    TissueCoefficients::at(wavelength_nm).absorption(melanin_fraction, eumelanin_ratio)
}

/// A spectrum between its samples along lines, beyond them the last.
fn between_samples(spectrum: &Spectrum, wavelength_nm: f64) -> f64 {
    let place = ((wavelength_nm - FIRST_NM) / STEP_NM).clamp(0.0, (SAMPLES - 1) as f64);
    let below = (place as usize).min(SAMPLES - 2);
    let part = place - below as f64;
    spectrum[below] + part * (spectrum[below + 1] - spectrum[below])
}

/// All coefficients of equations 10 to 14 at one wavelength, so that powers are taken once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TissueCoefficients {
    /// Equation 10 (mm⁻¹).
    pub eumelanin_absorption: f64,
    /// Equation 11 (mm⁻¹) with [`PHEOMELANIN_FRANCOIS`].
    pub pheomelanin_absorption: f64,
    /// Equation 12 (mm⁻¹).
    pub baseline_absorption: f64,
    /// Blood in the vessels of an iris (mm⁻¹), for a volume of one: [`iris_blood_absorption`], between its samples along lines.
    pub blood_absorption: f64,
    /// First term of equation 14 (mm⁻¹).
    pub mie_scattering: f64,
    /// Second term of equation 14 (mm⁻¹).
    pub rayleigh_scattering: f64,
}

impl TissueCoefficients {
    /// The coefficients at a wavelength in nm.
    pub fn at(wavelength_nm: f64) -> Self {
        Self {
            eumelanin_absorption: eumelanin_absorption(wavelength_nm),
            pheomelanin_absorption: pheomelanin_absorption(wavelength_nm, PHEOMELANIN_FRANCOIS),
            baseline_absorption: baseline_absorption(wavelength_nm),
            blood_absorption: between_samples(iris_blood_absorption(), within_range(wavelength_nm)),
            mie_scattering: mie_scattering(wavelength_nm),
            rayleigh_scattering: rayleigh_scattering(wavelength_nm),
        }
    }

    /// The coefficients at few wavelengths, those of blood as [`Wavelengths::nearest`] has them, not below 0.
    pub fn few<const N: usize>(few: &Wavelengths<N>) -> [Self; N] {
        let blood = few.nearest(iris_blood_absorption());
        core::array::from_fn(|i| Self {
            blood_absorption: blood[i].max(0.0),
            ..Self::at(few.nm[i])
        })
    }

    /// Equation 13 (mm⁻¹): as [`tissue_absorption`].
    pub fn absorption(&self, melanin_fraction: f64, eumelanin_ratio: f64) -> f64 {
        let melanin = eumelanin_ratio * self.eumelanin_absorption
            + (1.0 - eumelanin_ratio) * self.pheomelanin_absorption;
        melanin_fraction * melanin + (1.0 - melanin_fraction) * self.baseline_absorption
    }
}

/// The Mie term of equation 14 (mm⁻¹): thick bundles of collagen, nearly without colour.
pub fn mie_scattering(wavelength_nm: f64) -> f64 {
    14.74 * within_range(wavelength_nm).powf(-0.22)
}

/// The Rayleigh term of equation 14 (mm⁻¹): thin fibrils, blue.
pub fn rayleigh_scattering(wavelength_nm: f64) -> f64 {
    2.2e11 * within_range(wavelength_nm).powi(-4)
}

/// Equation 14: reduced scattering σ_s (1 − g) (mm⁻¹) of the epidermis after Donner & Jensen 2006,
/// twice that of their dermis: used with isotropic scattering.
pub fn skin_scattering(wavelength_nm: f64) -> f64 {
    mie_scattering(wavelength_nm) + rayleigh_scattering(wavelength_nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_laws_at_500_nm_by_logarithm() {
        // 500^−3.33 = 10^(−3.33 · 2.698970004) etc., worked out by hand.
        let close = |got: f64, expected: f64| {
            assert!((got / expected - 1.0).abs() < 1e-4, "{got} {expected}")
        };
        close(eumelanin_absorption(500.0), 67.9177);
        close(pheomelanin_absorption(500.0, PHEOMELANIN_FRANCOIS), 43.8822);
        close(baseline_absorption(500.0), 0.0244 + 8.53 * 0.005_372_48);
        close(mie_scattering(500.0), 3.755_97);
        close(rayleigh_scattering(500.0), 3.52);
    }

    #[test]
    fn equations_at_four_wavelengths() {
        // λ, equations 10, 11, 12 and the two terms of 14, by a separate program.
        for row in [
            [400.0, 142.786, 126.652, 0.231942, 3.94498, 8.59375],
            [500.0, 67.9163, 43.8824, 0.0702217, 3.75599, 3.52],
            [600.0, 37.0084, 18.4578, 0.0345167, 3.60831, 1.69753],
            [700.0, 22.1497, 8.87528, 0.0266336, 3.488, 0.916285],
        ] {
            let [nm, em, pm, base, mie, rayleigh] = row;
            let tissue = TissueCoefficients::at(nm);
            for (got, expected) in [
                (tissue.eumelanin_absorption, em),
                (tissue.pheomelanin_absorption, pm),
                (tissue.baseline_absorption, base),
                (tissue.mie_scattering, mie),
                (tissue.rayleigh_scattering, rayleigh),
                (skin_scattering(nm), mie + rayleigh),
            ] {
                // The rows have six digits.
                assert!(
                    (got / expected - 1.0).abs() < 1e-5,
                    "{nm}: {got} {expected}"
                );
            }
        }
    }

    /// Extinction of eumelanin and of pheomelanin, cm⁻¹ for 1 mg/mL, at wavelengths in nm: Sarna &
    /// Swartz, read off their figure by Jacques (omlc.org/spectra/melanin/extcoeff.html).
    const MEASURED: [(f64, f64, f64); 7] = [
        (400.0, 14.64, 12.11),
        (450.0, 10.74, 7.99),
        (500.0, 8.14, 5.08),
        (550.0, 5.79, 3.00),
        (600.0, 4.30, 1.61),
        (650.0, 3.18, 1.21),
        (700.0, 2.42, 0.80),
    ];

    #[test]
    fn equations_10_and_11_are_the_measured_melanins() {
        // 88 mg/mL of either, 10 mm to a cm.
        let concentration = 88.0 / 10.0;
        for (nm, eumelanin, pheomelanin) in MEASURED {
            let eu = eumelanin_absorption(nm) / (concentration * eumelanin);
            let pheo =
                pheomelanin_absorption(nm, PHEOMELANIN_FRANCOIS) / (concentration * pheomelanin);
            // The power laws are straight lines through curves.
            assert!((eu - 1.0).abs() < 0.12, "{nm}: {eu}");
            assert!((pheo - 1.0).abs() < 0.35, "{nm}: {pheo}");
        }
        // Read per centimetre, equation 11 is off by ten.
        let dilute = pheomelanin_absorption(500.0, PHEOMELANIN_DILUTE);
        assert!((0.09..0.12).contains(&(dilute / (concentration * 5.08))));
    }

    #[test]
    fn equations_10_and_12_are_jacques_in_other_units() {
        for nm in [400.0_f64, 550.0, 700.0] {
            let melanosome = 6.6e11 * nm.powf(-3.33) / 10.0;
            let skin = (0.244 + 85.3 * (-(nm - 154.0) / 66.2).exp()) / 10.0;
            assert!((eumelanin_absorption(nm) / melanosome - 1.0).abs() < 1e-14);
            assert!((baseline_absorption(nm) / skin - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn senseless_wavelengths_give_numbers() {
        for nm in [
            f64::NAN,
            0.0,
            -5.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e-300,
        ] {
            let tissue = TissueCoefficients::at(nm);
            for value in [tissue.absorption(0.3, 0.5), skin_scattering(nm)] {
                assert!(value.is_finite() && value > 0.0);
            }
        }
    }

    #[test]
    fn mixtures_have_their_pure_ends() {
        for wavelength in [380.0, 550.0, 780.0] {
            assert_eq!(
                tissue_absorption(wavelength, 0.0, 0.3),
                baseline_absorption(wavelength)
            );
            assert_eq!(
                tissue_absorption(wavelength, 1.0, 1.0),
                eumelanin_absorption(wavelength)
            );
            let pheo = pheomelanin_absorption(wavelength, PHEOMELANIN_FRANCOIS);
            assert_eq!(tissue_absorption(wavelength, 1.0, 0.0), pheo);
        }
    }

    #[test]
    fn everything_is_stronger_in_the_blue() {
        let spectra: [fn(f64) -> f64; 4] = [
            eumelanin_absorption,
            baseline_absorption,
            mie_scattering,
            rayleigh_scattering,
        ];
        for spectrum in spectra {
            assert!(spectrum(450.0) > spectrum(550.0) && spectrum(550.0) > spectrum(650.0));
        }
    }
}
