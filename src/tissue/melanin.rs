//! Absorption by melanin and scattering by collagen: equations 10 to 14 of François et al. 2007.
//!
//! In: a wavelength in nm (the visible range), volume fractions. Out: coefficients in mm⁻¹.

/// The pheomelanin constant of equation 11 as printed by François (and by Donner & Jensen 2006), in
/// mm⁻¹ nm^4.75. The default here: with it the fractions that eumelanin needs to make an iris brown
/// make it green, hazel and amber as pheomelanin.
pub const PHEOMELANIN_FRANCOIS: f64 = 2.9e14;

/// The same constant as Jacques' data give it: 2.9e14 cm⁻¹ nm^4.75, ten times less. With it, the
/// fractions that make a hazel iris leave it blue-grey.
pub const PHEOMELANIN_JACQUES: f64 = 2.9e13;

/// Equation 10: absorption of eumelanin (mm⁻¹), a fit to Jacques & McAuliffe 1991.
pub fn eumelanin_absorption(wavelength_nm: f64) -> f64 {
    6.6e10 * wavelength_nm.powf(-3.33)
}

/// Equation 11: absorption of pheomelanin (mm⁻¹), a fit to Sarna & Swartz 1998. `constant` is
/// [`PHEOMELANIN_FRANCOIS`] or [`PHEOMELANIN_JACQUES`].
pub fn pheomelanin_absorption(wavelength_nm: f64, constant: f64) -> f64 {
    constant * wavelength_nm.powf(-4.75)
}

/// Equation 12: absorption (mm⁻¹) of tissue without pigment, after Jacques 1998 for skin.
pub fn baseline_absorption(wavelength_nm: f64) -> f64 {
    0.0244 + 8.53 * (-(wavelength_nm - 154.0) / 66.2).exp()
}

/// Equation 13: absorption (mm⁻¹) of tissue with the volume fraction `melanin_fraction` of melanin,
/// of which `eumelanin_ratio` is eumelanin; both 0 to 1. (The paper's "σ_pm λ" reads σ_pm(λ).)
pub fn tissue_absorption(wavelength_nm: f64, melanin_fraction: f64, eumelanin_ratio: f64) -> f64 {
    TissueCoefficients::at(wavelength_nm).absorption(melanin_fraction, eumelanin_ratio)
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
            mie_scattering: mie_scattering(wavelength_nm),
            rayleigh_scattering: rayleigh_scattering(wavelength_nm),
        }
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
    14.74 * wavelength_nm.powf(-0.22)
}

/// The Rayleigh term of equation 14 (mm⁻¹): thin fibrils, blue.
pub fn rayleigh_scattering(wavelength_nm: f64) -> f64 {
    2.2e11 * wavelength_nm.powi(-4)
}

/// Equation 14: scattering (mm⁻¹) of the dermis, after Donner & Jensen 2006, who give it as the
/// reduced coefficient σ_s(1 − g): used with isotropic scattering.
pub fn dermis_scattering(wavelength_nm: f64) -> f64 {
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
    fn jacques_constant_is_a_tenth() {
        let ratio = pheomelanin_absorption(600.0, PHEOMELANIN_FRANCOIS)
            / pheomelanin_absorption(600.0, PHEOMELANIN_JACQUES);
        assert!((ratio - 10.0).abs() < 1e-12);
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
