//! Longitudinal chromatic aberration of the eye as a change of refraction with wavelength.
//!
//! In: vacuum wavelength (nm). Out: chromatic difference of refraction (D).
//!
//! The chromatic eye of Thibos, Ye, Zhang & Bradley 1992 (Appl. Opt. 31, 3594), their fit:
//! `R(λ) = 1.68524 − 0.63346/(λ − 0.21410)`, λ in µm, for an eye that is emmetropic at 589 nm. The
//! constant alone depends on the wavelength in focus; 1.7312 puts it at 580 nm. It is a mean of
//! observers, fitted over the visible range; below 400 nm the hyperbola is an extrapolation.

use crate::optics::media::{LONGEST_NM, REFERENCE_NM, SHORTEST_NM};

/// Pole of the hyperbola (µm).
const CHROMATIC_POLE_UM: f64 = 0.214_10;
/// Strength of the hyperbola (D µm).
const CHROMATIC_STRENGTH: f64 = 0.633_46;
/// Constant (D) for an eye in focus at [`CHROMATIC_FOCUS_NM`].
const CHROMATIC_CONSTANT_D: f64 = 1.7312;

/// The wavelength (nm) at which [`chromatic_difference`] vanishes.
pub const CHROMATIC_FOCUS_NM: f64 =
    1e3 * (CHROMATIC_POLE_UM + CHROMATIC_STRENGTH / CHROMATIC_CONSTANT_D);

/// Chromatic difference of refraction (D) at `wavelength_nm` for an eye that is emmetropic at
/// [`CHROMATIC_FOCUS_NM`]: negative (myopic) in the blue, positive (hyperopic) in the red, so that
/// it adds to the spectacle refraction of [`crate::optics::defocus`]. Wavelengths are limited to 380 to
/// 780 nm; what is not a number counts as 555 nm.
pub fn chromatic_difference(wavelength_nm: f64) -> f64 {
    let wavelength = if wavelength_nm.is_nan() {
        REFERENCE_NM
    } else {
        wavelength_nm.clamp(SHORTEST_NM, LONGEST_NM)
    };
    CHROMATIC_CONSTANT_D - CHROMATIC_STRENGTH / (1e-3 * wavelength - CHROMATIC_POLE_UM)
}

/// The same for an eye that is emmetropic at `focus_nm`.
pub fn chromatic_difference_from(wavelength_nm: f64, focus_nm: f64) -> f64 {
    chromatic_difference(wavelength_nm) - chromatic_difference(focus_nm)
}

/// The wavelength (nm) that an eye emmetropic at [`CHROMATIC_FOCUS_NM`] has in focus when its
/// refraction is off by `difference_d`: the inverse of [`chromatic_difference`], limited to 380 to
/// 780 nm.
pub fn chromatic_wavelength(difference_d: f64) -> f64 {
    let room = CHROMATIC_CONSTANT_D - difference_d;
    if room.is_nan() {
        return CHROMATIC_FOCUS_NM;
    }
    // From above the constant no wavelength is long enough.
    if room <= 0.0 {
        return LONGEST_NM;
    }
    (1e3 * (CHROMATIC_POLE_UM + CHROMATIC_STRENGTH / room)).clamp(SHORTEST_NM, LONGEST_NM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn it_has_the_values_of_the_chromatic_eye() {
        // REFERENCE: zero at 580 nm.
        assert!((CHROMATIC_FOCUS_NM - 580.0).abs() < 0.1);
        assert!(chromatic_difference(CHROMATIC_FOCUS_NM).abs() < 1e-14);
        // The constant 1.68524 of Thibos 1992 has its zero at 589.99 nm.
        let thibos = |l: f64| 1.68524 - 0.63346 / (1e-3 * l - 0.21410);
        for l in [400.0, 450.0, 500.0, 555.0, 589.0, 632.8, 700.0] {
            let difference = chromatic_difference_from(l, 589.99);
            assert!((difference - thibos(l)).abs() < 2e-5, "{l}");
        }
        // "Approximately 2 D between 400 and 700 nm" (2.1 D in the paper's Fig. 2).
        let span = chromatic_difference(700.0) - chromatic_difference(400.0);
        assert!((span - 2.1).abs() < 0.1, "{span}");
    }

    #[test]
    fn water_explains_it() {
        // An independent oracle: the paper's reduced eye, one surface of radius 5.55 mm in front of
        // water, R(λ) = (n_D − n(λ))/(r n_D) in dioptres (its equation 4), here with the aqueous of
        // the Cauchy fits. It is a different medium with other data: 15 % of the span.
        use crate::optics::media::Medium;
        let (radius_m, n_d) = (5.55e-3, Medium::Tears.index(589.0));
        for l in [420.0, 450.0, 500.0, 650.0, 700.0] {
            let reduced = (n_d - Medium::Tears.index(l)) / (radius_m * n_d);
            let got = chromatic_difference_from(l, 589.0);
            println!("{l}: {got:.3} against {reduced:.3}");
            assert!(
                (got - reduced).abs() < 0.15 * got.abs().max(0.3),
                "{l}: {got} {reduced}"
            );
        }
    }

    #[test]
    fn the_inverse_inverts_and_rises() {
        let mut last = f64::NEG_INFINITY;
        for nm in 380..=780 {
            let l = f64::from(nm);
            let d = chromatic_difference(l);
            assert!(d > last);
            last = d;
            // 1e-16 of 1.7 D, over a slope of at least 2e-3 D/nm.
            assert!((chromatic_wavelength(d) - l).abs() < 1e-11);
        }
        assert_eq!(chromatic_wavelength(2.0), LONGEST_NM);
        assert_eq!(chromatic_wavelength(-20.0), SHORTEST_NM);
    }

    proptest! {
        #[test]
        fn nothing_is_ever_infinite(l in prop::num::f64::ANY, d in prop::num::f64::ANY) {
            prop_assert!((-2.2..=0.7).contains(&chromatic_difference(l)));
            prop_assert!((380.0..=780.0).contains(&chromatic_wavelength(d)));
        }
    }
}
