//! The Stiles–Crawford effect: light through the rim of the pupil looks dimmer, because cones are
//! aimed at a point near its centre.
//!
//! In: a point of the pupil (mm from its centre). Out: relative luminous efficiency.
//!
//! `η = 10^(−ρ r²)` with r the distance (mm) from the peak (Stiles & Crawford 1933, in Stiles's
//! form). The peak is 0.51 mm nasal and 0.20 mm superior on average, with standard deviations of
//! 0.72 and 0.64 mm between eyes (Applegate & Lakshminarayanan 1993, J. Opt. Soc. Am. A 10, 1611,
//! who find ρ = 0.047 ± 0.013 horizontally and 0.053 ± 0.012 vertically); ρ = 0.041 mm⁻² at 550 nm
//! is the usual choice for apodising wavefronts. It holds for foveal cones in photopic light; rods
//! have almost none. As an amplitude, for diffraction, it is √η.

use core::f64::consts::{LN_10, PI};
use glam::DVec2;

/// ρ (mm⁻²) at 550 nm.
pub const STILES_CRAWFORD_RHO: f64 = 0.041;
/// The mean peak (mm): x nasal, y superior.
pub const STILES_CRAWFORD_PEAK_MM: DVec2 = DVec2::new(0.51, 0.20);

/// Relative efficiency, 0 to 1, of light that enters the pupil at `pupil_point_mm`, with the peak at
/// `peak_mm` and the steepness `rho` (mm⁻², not negative): 1 at the peak. What is not a number gives
/// 0.
pub fn stiles_crawford_efficiency(pupil_point_mm: DVec2, peak_mm: DVec2, rho: f64) -> f64 {
    let exponent = -rho.max(0.0) * LN_10 * pupil_point_mm.distance_squared(peak_mm);
    if exponent.is_nan() {
        0.0
    } else {
        exponent.exp()
    }
}

/// The amplitude of the same light, √η: what multiplies the pupil function in a diffraction
/// integral.
pub fn stiles_crawford_amplitude(pupil_point_mm: DVec2, peak_mm: DVec2, rho: f64) -> f64 {
    stiles_crawford_efficiency(pupil_point_mm, peak_mm, 0.5 * rho)
}

/// Share of the light through a pupil of `pupil_mm` that counts, for a peak at its centre: the mean
/// of η, `(1 − 10^(−ρ a²))/(ρ a² ln 10)` with a the radius. 1 for a closed pupil. An effective
/// troland is a troland times this.
pub fn stiles_crawford_share(pupil_mm: f64, rho: f64) -> f64 {
    let x = rho.max(0.0) * LN_10 * (0.5 * pupil_mm.max(0.0)).powi(2);
    if x == f64::INFINITY {
        0.0
    } else if x > 0.0 {
        -(-x).exp_m1() / x
    } else {
        1.0
    }
}

/// Area (mm²) of the pupil without a Stiles–Crawford effect that would look as bright.
pub fn stiles_crawford_effective_area_mm2(pupil_mm: f64, rho: f64) -> f64 {
    PI * (0.5 * pupil_mm.max(0.0)).powi(2) * stiles_crawford_share(pupil_mm, rho)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_point_three_millimetres_off_counts_less_than_half() {
        let peak = STILES_CRAWFORD_PEAK_MM;
        let at = |x: f64, y: f64| {
            stiles_crawford_efficiency(DVec2::new(x, y), peak, STILES_CRAWFORD_RHO)
        };
        assert_eq!(at(0.51, 0.20), 1.0);
        // 10^(−0.041 · 9).
        assert!((at(3.51, 0.20) - 0.427_56).abs() < 5e-6);
        let amplitude = stiles_crawford_amplitude(DVec2::ZERO, peak, STILES_CRAWFORD_RHO);
        assert!((amplitude.powi(2) - at(0.0, 0.0)).abs() < 1e-15);
    }

    #[test]
    fn the_effective_troland_is_moon_and_spencers() {
        // Moon & Spencer 1944 (J. Opt. Soc. Am. 34, 319): 1 − 0.0106 d² + 0.0000416 d⁴, d in mm,
        // fitted to data of ρ near 0.037 (the slope is ρ ln 10/8). Up to 4 mm the fourth powers
        // differ by 3.3e-5 d⁴ = 0.0085.
        for d in [1.0, 2.0, 3.0, 4.0_f64] {
            let classical = 1.0 - 0.0106 * d * d + 0.000_041_6 * d.powi(4);
            let got = stiles_crawford_share(d, 0.0106 * 8.0 / LN_10);
            assert!((got - classical).abs() < 0.009, "{d}: {got} {classical}");
            let usual = stiles_crawford_share(d, STILES_CRAWFORD_RHO);
            println!("{d} mm: {usual:.4}, classical {classical:.4}");
            assert!((usual - classical).abs() < 0.012);
        }
    }

    #[test]
    fn the_share_is_the_mean_over_the_pupil() {
        // The midpoint rule in r²: its error is (ρ a² ln 10/n)²/24.
        for (d, rho) in [(2.0, 0.041), (8.0, 0.041), (6.0, 0.12)] {
            let n = 10_000;
            let mean: f64 = (0..n)
                .map(|i| {
                    let r = 0.5 * d * ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
                    stiles_crawford_efficiency(DVec2::new(r, 0.0), DVec2::ZERO, rho)
                })
                .sum::<f64>()
                / f64::from(n);
            assert!((mean - stiles_crawford_share(d, rho)).abs() < 1e-8);
        }
        assert_eq!(stiles_crawford_share(0.0, 0.041), 1.0);
        assert!((stiles_crawford_effective_area_mm2(3.0, 0.0) - PI * 2.25).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn it_is_always_a_fraction(
            x in prop::num::f64::ANY, y in prop::num::f64::ANY, rho in prop::num::f64::ANY,
        ) {
            let efficiency =
                stiles_crawford_efficiency(DVec2::new(x, y), STILES_CRAWFORD_PEAK_MM, rho);
            prop_assert!((0.0..=1.0).contains(&efficiency));
            prop_assert!((0.0..=1.0).contains(&stiles_crawford_share(x, rho)));
        }
    }
}
