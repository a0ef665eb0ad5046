//! The clear media of an eye: what cornea and lens take of light and what they send back of it.
//!
//! In: age. Out: diffuse reflectances as linear sRGB; the lens's own density is that of van de Kraats and van Norren (2007,
//! Applied Optics 46, REFERENCE-face). Both tissues are clear because what scatters in them is small and orderly, and
//! neither is quite clear: a pupil is never black, and before a dark iris the cornea is a bluish haze.

use super::spectrum::{spectrum_from, spectrum_to_linear_srgb};

fn rayleigh(nm: f64) -> f64 {
    (400.0 / wavelength(nm)).powi(4)
}

fn wavelength(nm: f64) -> f64 {
    if nm.is_nan() {
        550.0
    } else {
        nm.clamp(300.0, 700.0)
    }
}

fn years(age: f64) -> f64 {
    if age.is_nan() {
        30.0
    } else {
        age.clamp(0.0, 100.0)
    }
}

/// Optical density (decimal logarithm) of a lens of this age at a wavelength: what of the media's grows with age or absorbs. Ages are
/// clamped to 0 to 100 years, wavelengths to 300 to 700 nm; what is not a number counts as 30 years and as 550 nm.
fn lens_density(nm: f64, age_years: f64) -> f64 {
    let (nm, square) = (wavelength(nm), years(age_years).powi(2));
    let bell = |height: f64, width: f64, at: f64| height * (-(width * (nm - at)).powi(2)).exp();
    3.1e-5 * square * rayleigh(nm)
        + bell(151.5, 0.057, 273.0)
        + (0.998 - 6.3e-5 * square) * bell(2.13, 0.029, 370.0)
        + (0.059 + 1.86e-4 * square) * bell(11.95, 0.021, 325.0)
        + (0.016 + 1.32e-4 * square) * bell(1.43, 0.008, 325.0)
}

/// Share of what a cornea scatters that comes back out of the eye (a choice: a young pupil then has a luminance of 0.014 to 0.015
/// of white, most of it what tears mirror, where photographs have 0.009, 0 to 0.043).
const CORNEA_RETURNS: f64 = 0.02;

/// Diffuse reflectance (linear sRGB) of a cornea: of what it scatters, 1 − 10^(−21·10⁸ λ⁻⁴) of the light (van den Berg and Tan
/// 1994, REFERENCE), a share.
pub fn cornea_backscatter() -> [f64; 3] {
    let scattered =
        spectrum_from(|nm| CORNEA_RETURNS * (1.0 - 10f64.powf(-21e8 / wavelength(nm).powi(4))));
    spectrum_to_linear_srgb(&scattered).map(|channel| channel.clamp(0.0, 1.0))
}

/// What a lens of 20 years sends back at 550 nm, and over how many years that grows by a factor e: scatter rises exponentially with
/// age (Cook 1994); about fivefold from 20 to 75 (a choice: what Scheimpflug cameras print are units of their own).
const YOUNG_LENS: f64 = 0.0008;
const LENS_GROWS_YEARS: f64 = 34.0;

/// Diffuse reflectance (linear sRGB) of a clear lens of this age, 0 to 100 years: particles of about a wavelength scatter by its inverse
/// square, and half of the lens is crossed twice, so that all of its density dims what comes back.
pub fn lens_backscatter(age_years: f64) -> [f64; 3] {
    let grown = YOUNG_LENS * ((years(age_years) - 20.0) / LENS_GROWS_YEARS).exp();
    let returned =
        spectrum_from(|nm| grown * (550.0 / nm).powi(2) * 10f64.powf(-lens_density(nm, age_years)));
    spectrum_to_linear_srgb(&returned).map(|channel| channel.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all media, for small fields: what they scatter besides, and a constant.
    fn media_density(nm: f64, age_years: f64) -> f64 {
        0.446 * rayleigh(nm) + lens_density(nm, age_years) + 0.111
    }

    #[test]
    fn the_media_are_as_dense_as_printed() {
        // Transmittances at 450, 550 and 650 nm worked out for the reference, to two digits.
        for (age, printed) in [(20.0, [0.36, 0.57, 0.67]), (80.0, [0.10, 0.46, 0.62])] {
            for (nm, printed) in [450.0, 550.0, 650.0].into_iter().zip(printed) {
                let passed = 10f64.powf(-media_density(nm, age));
                assert!((passed - printed).abs() < 0.006, "{nm} {age}: {passed}");
            }
        }
    }

    #[test]
    fn a_young_pupil_is_bluish_black_and_an_old_one_grey() {
        let cornea = cornea_backscatter();
        let [young, old] = [25.0, 75.0].map(lens_backscatter);
        println!("cornea {cornea:.4?}, lens at 25 {young:.4?}, at 75 {old:.4?}");
        assert!(cornea[2] > 2.0 * cornea[0]);
        let pupil = |lens: [f64; 3]| [0, 1, 2].map(|c| cornea[c] + lens[c]);
        let (young, old) = (pupil(young), pupil(old));
        // Photographs: luminance 0 to 0.043 of the display's white, 0.009 in the middle.
        assert!(young[1] < 0.009 && young[2] > 1.15 * young[0], "{young:?}");
        assert!(old[1] > 1.5 * young[1] && old[1] < 0.02, "{old:?}");
        // It yellows: blue grows least.
        assert!(old[2] / young[2] < old[0] / young[0]);
    }

    #[test]
    fn always_a_colour() {
        for age in [f64::NAN, f64::NEG_INFINITY, -3.0, 0.0, 100.0, 1e9] {
            assert!(
                lens_backscatter(age)
                    .iter()
                    .all(|c| (0.0..=1.0).contains(c))
            );
            for nm in [f64::NAN, 0.0, 300.0, 1e9] {
                assert!(media_density(nm, age).is_finite());
            }
        }
    }
}
