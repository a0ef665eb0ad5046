//! Modulation transfer of the eye's optics: the diffraction limit, and the mean eye at its best
//! correction.
//!
//! In: spatial frequency (cycles per degree), pupil diameter (mm), wavelength (nm). Out: the
//! modulation that passes, 0 to 1.
//!
//! The mean eye is Watson 2013 (J. Vision 13(6):18), fitted to the wavefronts of 200 eyes corrected
//! for white light: `M(u, d) = (1 + (u/u₁)²)^−0.62 √D(u, d, 555 nm)` with
//! `u₁ = 21.95 − 5.512 d + 0.3922 d²`, for pupils of 2 to 6 mm. It is the radial mean, and leaves out
//! scatter ([`crate::optics::glare`]). For pupils up to 4 mm the fit exceeds the diffraction limit at low
//! frequencies, by 0.0065 at most (2 mm, 1.3 c/deg).
//!
//! `D = (2/π)(arccos û − û √(1 − û²))`, `û = u/u₀`, is the incoherent transfer of a circular pupil
//! (Born & Wolf, section 9.5), `u₀ = d π 10⁶/(180 λ)` its cut-off.

use core::f64::consts::{FRAC_2_PI, PI};

/// Pupil diameters (mm) that the mean eye was fitted to; what lies outside counts as the nearer one.
pub const MEAN_MTF_PUPIL_RANGE_MM: (f64, f64) = (2.0, 6.0);
/// Wavelength (nm) of the mean eye's diffraction.
const MEAN_MTF_NM: f64 = 555.0;

/// The highest frequency (cycles per degree) that a pupil of `pupil_mm` passes at `wavelength_nm`;
/// 0 for a pupil that is not positive, or a wavelength that is not.
pub fn diffraction_cutoff_cpd(pupil_mm: f64, wavelength_nm: f64) -> f64 {
    if pupil_mm > 0.0 && wavelength_nm > 0.0 {
        // The quotient of extremes may still overflow.
        (pupil_mm * 1e6 * (PI / 180.0) / wavelength_nm).min(f64::MAX)
    } else {
        0.0
    }
}

/// Modulation transfer of an aberration-free circular pupil; exact. The sign of the frequency does
/// not matter; 0 beyond the cut-off, for a closed pupil and for a frequency that is not a number.
pub fn diffraction_mtf(frequency_cpd: f64, pupil_mm: f64, wavelength_nm: f64) -> f64 {
    let u = frequency_cpd.abs() / diffraction_cutoff_cpd(pupil_mm, wavelength_nm);
    if u < 1.0 {
        let root = ((1.0 - u) * (1.0 + u)).sqrt();
        // The arctangent keeps the digits that arccos loses near the cut-off.
        FRAC_2_PI * (root.atan2(u) - u * root)
    } else {
        0.0
    }
}

/// Mean radial modulation transfer of best-corrected eyes in white light. The pupil is limited to 2
/// to 6 mm, one that is not a number counts as 3 mm; frequencies as for [`diffraction_mtf`].
pub fn mean_mtf(frequency_cpd: f64, pupil_mm: f64) -> f64 {
    let (smallest, largest) = MEAN_MTF_PUPIL_RANGE_MM;
    let d = if pupil_mm.is_nan() {
        3.0
    } else {
        pupil_mm.clamp(smallest, largest)
    };
    let limit = diffraction_mtf(frequency_cpd, d, MEAN_MTF_NM);
    if limit <= 0.0 {
        return 0.0;
    }
    let u = frequency_cpd / (21.95 + d * (0.3922 * d - 5.512));
    (1.0 + u * u).powf(-0.62) * limit.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_cutoff_is_the_textbook_one() {
        // 3 mm at 555 nm: d/λ = 5405 cycles per radian, 94.3 per degree.
        assert!((diffraction_cutoff_cpd(3.0, 555.0) - 3e-3 / 555e-9 * PI / 180.0).abs() < 1e-12);
        assert!((diffraction_cutoff_cpd(3.0, 555.0) - 94.34).abs() < 5e-3);
        assert_eq!(diffraction_cutoff_cpd(f64::NAN, 555.0), 0.0);
        assert_eq!(diffraction_cutoff_cpd(3.0, 0.0), 0.0);
    }

    #[test]
    fn diffraction_is_the_overlap_of_two_pupils() {
        // Known points: û = ½ gives (2/π)(π/3 − √3/4) = 0.39100.
        let at = |u: f64| diffraction_mtf(u * diffraction_cutoff_cpd(4.0, 550.0), 4.0, 550.0);
        assert_eq!(at(0.0), 1.0);
        assert!((at(0.5) - FRAC_2_PI * (PI / 3.0 - 0.75_f64.sqrt() / 2.0)).abs() < 1e-15);
        assert!((at(0.5) - 0.39100).abs() < 5e-6);
        assert_eq!(at(1.0), 0.0);
        // The autocorrelation of a disc, by slices of the two shifted discs: 2 ∫ 2 √(1 − x²) dx from
        // û to 1 over π; the midpoint rule's error at the edge falls as n^−1.5.
        for u in [0.1, 0.37, 0.8, 0.99] {
            let n = 100_000;
            let h = (1.0 - u) / f64::from(n);
            let area: f64 = (0..n)
                .map(|i| (1.0 - (u + (f64::from(i) + 0.5) * h).powi(2)).sqrt() * h)
                .sum();
            assert!((at(u) - 4.0 * area / PI).abs() < 1e-8, "{u}");
        }
    }

    #[test]
    fn the_mean_eye_has_watsons_values() {
        // The formula by hand for 3 mm and 11.9 c/deg: u₁ = 8.9438, (1 + 1.7703)^−0.62 = 0.53167,
        // û = 0.12614, D = 0.83984; 0.4872. Others who apply it print 0.49.
        let got = mean_mtf(11.9, 3.0);
        assert!((got - 0.4872).abs() < 1e-4, "{got}");
        assert_eq!(mean_mtf(0.0, 4.0), 1.0);
        assert_eq!(mean_mtf(95.0, 3.0), 0.0);
        // Aberrations make wide pupils worse, by a factor of three from 2 to 6 mm at 10 c/deg.
        let at = |d| mean_mtf(10.0, d);
        println!(
            "10 c/deg: {:.3} {:.3} {:.3} {:.3}",
            at(2.0),
            at(3.0),
            at(4.0),
            at(6.0)
        );
        assert!(at(2.0) > at(4.0) && at(4.0) > at(6.0));
        assert!((3.0..3.4).contains(&(at(2.0) / at(6.0))));
    }

    #[test]
    fn the_mean_eye_hardly_exceeds_diffraction() {
        let mut most = (0.0, 0.0, 0.0);
        for i in 0..=40 {
            let d = 2.0 + 0.1 * f64::from(i);
            for j in 1..2000 {
                let u = 0.1 * f64::from(j);
                let excess = mean_mtf(u, d) - diffraction_mtf(u, d, 555.0);
                if excess > most.0 {
                    most = (excess, d, u);
                }
            }
        }
        println!("{most:?}");
        // A property of the published fit, not of eyes: √D falls half as fast as D.
        assert!(
            (0.006..0.0066).contains(&most.0) && most.1 == 2.0,
            "{most:?}"
        );
        // At 6 mm the mean eye is far below the limit.
        assert!(mean_mtf(20.0, 6.0) < 0.15 * diffraction_mtf(20.0, 6.0, 555.0));
    }

    proptest! {
        #[test]
        fn it_falls_with_frequency(d in 0.0..10.0_f64, u in 0.0..300.0_f64, more in 0.01..10.0_f64) {
            prop_assert!(mean_mtf(u + more, d) <= mean_mtf(u, d));
            prop_assert!(diffraction_mtf(u + more, d, 555.0) <= diffraction_mtf(u, d, 555.0));
        }

        #[test]
        fn it_is_always_a_fraction(
            u in prop::num::f64::ANY, d in prop::num::f64::ANY, nm in prop::num::f64::ANY,
        ) {
            prop_assert!((0.0..=1.0).contains(&mean_mtf(u, d)));
            prop_assert!((0.0..=1.0).contains(&diffraction_mtf(u, d, nm)));
        }
    }
}
