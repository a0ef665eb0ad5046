//! From a spectrum to linear sRGB.
//!
//! In: reflectances at the [`SAMPLES`] wavelengths 380, 390 … 780 nm. Out: linear sRGB as the CIE
//! 1931 2° observer sees them under D65, scaled so that a perfect reflector is (1, 1, 1).
//!
//! Tables: CIE 1931 2° standard observer and standard illuminant D65, every second row of the 5 nm
//! tables of CIE 15:2004 (T.4 and T.1); compared entry by entry with the CIE's 1 nm tables of 2019
//! (DOI 10.25039/CIE.DS.xvudnb9b) as the library colour-science ships them, they differ by the
//! rounding to six places, D65 not at all.
//! The matrix is IEC 61966-2-1's. For smooth spectra [`super::wavelengths`] needs a fifth as many
//! samples.

use std::sync::LazyLock;

/// Number of wavelengths in a spectrum.
pub const SAMPLES: usize = 41;
/// First wavelength (nm).
pub const FIRST_NM: f64 = 380.0;
/// Distance of the wavelengths (nm).
pub const STEP_NM: f64 = 10.0;

/// A quantity at 380, 390 … 780 nm.
pub type Spectrum = [f64; SAMPLES];

/// x̄ of the CIE 1931 2° observer.
#[rustfmt::skip]
const OBSERVER_X: Spectrum = [
    0.001368, 0.004243, 0.01431, 0.04351, 0.13438, 0.2839, 0.34828, 0.3362, 0.2908, 0.19536,
    0.09564, 0.03201, 0.0049, 0.0093, 0.06327, 0.1655, 0.2904, 0.43345, 0.5945, 0.7621,
    0.9163, 1.0263, 1.0622, 1.0026, 0.85445, 0.6424, 0.4479, 0.2835, 0.1649, 0.0874,
    0.04677, 0.0227, 0.011359, 0.00579, 0.002899, 0.00144, 0.00069, 0.000332, 0.000166, 0.000083,
    0.000042,
];
/// ȳ of the CIE 1931 2° observer.
#[rustfmt::skip]
const OBSERVER_Y: Spectrum = [
    0.000039, 0.00012, 0.000396, 0.00121, 0.004, 0.0116, 0.023, 0.038, 0.06, 0.09098,
    0.13902, 0.20802, 0.323, 0.503, 0.71, 0.862, 0.954, 0.99495, 0.995, 0.952,
    0.87, 0.757, 0.631, 0.503, 0.381, 0.265, 0.175, 0.107, 0.061, 0.032,
    0.017, 0.00821, 0.004102, 0.002091, 0.001047, 0.00052, 0.000249, 0.00012, 0.00006, 0.00003,
    0.000015,
];
/// z̄ of the CIE 1931 2° observer.
#[rustfmt::skip]
const OBSERVER_Z: Spectrum = [
    0.00645, 0.02005, 0.06785, 0.2074, 0.6456, 1.3856, 1.74706, 1.77211, 1.6692, 1.28764,
    0.81295, 0.46518, 0.272, 0.1582, 0.07825, 0.04216, 0.0203, 0.00875, 0.0039, 0.0021,
    0.00165, 0.0011, 0.0008, 0.00034, 0.00019, 0.00005, 0.00002, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.0,
];
/// Relative power of standard illuminant D65.
#[rustfmt::skip]
const D65: Spectrum = [
    49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861,
    115.923, 108.811, 109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342,
    95.788, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778,
    78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856, 75.087, 63.5927, 46.4182, 66.8054,
    63.3828,
];

/// Linear sRGB from XYZ (IEC 61966-2-1).
const SRGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// Weight of each wavelength in the observer's three functions together under D65, D65 (x̄ + ȳ +
/// z̄): positive, and large where colour is decided.
pub(super) fn colour_weight() -> Spectrum {
    core::array::from_fn(|i| D65[i] * (OBSERVER_X[i] + OBSERVER_Y[i] + OBSERVER_Z[i]))
}

/// Weights of each wavelength in red, green and blue; each row sums to 1.
pub(super) static WEIGHTS: LazyLock<[Spectrum; 3]> = LazyLock::new(|| {
    SRGB_FROM_XYZ.map(|[x, y, z]| {
        let mut weights: Spectrum = core::array::from_fn(|i| {
            D65[i] * (x * OBSERVER_X[i] + y * OBSERVER_Y[i] + z * OBSERVER_Z[i])
        });
        let white: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= white;
        }
        weights
    })
});

/// A spectrum from a function of the wavelength in nm.
pub fn spectrum_from(f: impl Fn(f64) -> f64) -> Spectrum {
    core::array::from_fn(|i| f(FIRST_NM + STEP_NM * i as f64))
}

/// Linear sRGB of a reflectance spectrum under D65; 1 at every wavelength gives (1, 1, 1). A
/// colour outside the sRGB gamut has a negative channel.
pub fn spectrum_to_linear_srgb(reflectance: &Spectrum) -> [f64; 3] {
    WEIGHTS
        .each_ref()
        .map(|weights| weights.iter().zip(reflectance).map(|(w, r)| w * r).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observer_sums_to_equal_energy_white() {
        // CIE 15: each function sums to 106.857 over 1 nm, so to 10.6857 here; the coarse grid is
        // off by 1e-3.
        for function in [OBSERVER_X, OBSERVER_Y, OBSERVER_Z] {
            let sum: f64 = function.iter().sum();
            assert!((sum / 10.6857 - 1.0).abs() < 1e-3, "{sum}");
        }
    }

    #[test]
    fn d65_has_its_published_white_point() {
        let sum = |f: Spectrum| f.iter().zip(D65).map(|(f, d)| f * d).sum::<f64>();
        let y = sum(OBSERVER_Y);
        // X 0.95047, Z 1.08883 by the 1 nm tables; 10 nm keeps them to 1e-3.
        assert!((sum(OBSERVER_X) / y - 0.95047).abs() < 1e-3);
        assert!((sum(OBSERVER_Z) / y - 1.08883).abs() < 1e-3);
    }

    #[test]
    fn a_perfect_reflector_is_white_and_grey_is_grey() {
        for level in [0.0, 0.18, 1.0] {
            for channel in spectrum_to_linear_srgb(&[level; SAMPLES]) {
                assert!((channel - level).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn monochromatic_lights_have_their_hues() {
        let line = |nm: f64| {
            spectrum_to_linear_srgb(&spectrum_from(|l| {
                f64::from(u8::from((l - nm).abs() < 5.0))
            }))
        };
        let [r, g, b] = line(450.0);
        assert!(b > 0.0 && b > r && b > g && g < 0.0);
        let [r, g, b] = line(530.0);
        assert!(g > 0.0 && r < 0.0 && b < 0.0);
        let [r, g, b] = line(640.0);
        assert!(r > 0.0 && g < 0.0 && b.abs() < r);
    }
}
