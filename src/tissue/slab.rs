//! Light in one homogeneous layer, in closed form.
//!
//! In: coefficients (mm⁻¹), thickness (mm). Out: what returns and passes after any number of
//! scatterings; what does after one is in [`super::layers`].
//!
//! [`slab_two_flux`] is the quick estimate: the two-flux equations of Kubelka & Munk with K = 2 σ_a and S = ¾
//! σ_s′ (van Gemert & Star 1987, for σ_a ≪ σ_s′), diffuse light in and out. It is within 0.023 of
//! the true albedo up to an optical depth of 4 (see the tests; [`super::many_flux`] is the truth);
//! single scattering alone misses a third of a pale iris's light.
//!
//! Numbers are clamped as in [`super::layers`]: nothing gives a result that is not finite.

use super::layers::clamped;

/// Reflectance and transmittance of a layer for diffuse light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoFlux {
    /// Fraction returned, 0 to 1.
    pub reflectance: f64,
    /// Fraction passed, 0 to 1; the rest is absorbed.
    pub transmittance: f64,
}

impl TwoFlux {
    /// This layer on top of `below`, with all reflections between them.
    pub fn over(self, below: Self) -> Self {
        let between = 1.0 / (1.0 - self.reflectance * below.reflectance).max(1e-12);
        Self {
            reflectance: self.reflectance
                + self.transmittance.powi(2) * below.reflectance * between,
            transmittance: self.transmittance * below.transmittance * between,
        }
    }
}

/// The two-flux layer: `absorption` σ_a and reduced scattering σ_s′ in mm⁻¹, `thickness` in mm.
pub fn slab_two_flux(absorption: f64, reduced_scattering: f64, thickness: f64) -> TwoFlux {
    let (k, s) = (
        2.0 * clamped(absorption),
        0.75 * clamped(reduced_scattering),
    );
    let thickness = clamped(thickness);
    let kappa = (k * (k + 2.0 * s)).sqrt();
    // tanh(κ d)/κ, finite where κ vanishes and where κ d is large.
    let depth = if kappa * thickness > 1e-6 {
        (kappa * thickness).tanh() / kappa
    } else {
        thickness
    };
    let denominator = (k + s) * depth + 1.0;
    TwoFlux {
        reflectance: s * depth / denominator,
        transmittance: 1.0 / ((kappa * thickness).cosh() * denominator),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_flux_has_its_textbook_limits() {
        // No absorption: R = S d/(1 + S d), T = 1 − R.
        let pure = slab_two_flux(0.0, 4.0, 0.5);
        assert!((pure.reflectance - 1.5 / 2.5).abs() < 1e-15);
        assert!((pure.transmittance - 1.0 / 2.5).abs() < 1e-15);
        // No scattering: T = e^{−K d}.
        let clear = slab_two_flux(1.5, 0.0, 0.5);
        assert!(clear.reflectance == 0.0 && (clear.transmittance - (-1.5_f64).exp()).abs() < 1e-15);
        // Deep: R∞ = 1 + K/S − √(K²/S² + 2K/S).
        let q = 2.0 * 0.5 / (0.75 * 6.0);
        let deep = slab_two_flux(0.5, 6.0, 1e6);
        assert!((deep.reflectance - (1.0 + q - f64::sqrt(q * q + 2.0 * q))).abs() < 1e-14);
        assert_eq!(deep.transmittance, 0.0);
        assert_eq!(
            slab_two_flux(0.0, 0.0, 0.0),
            TwoFlux {
                reflectance: 0.0,
                transmittance: 1.0
            }
        );
    }

    #[test]
    fn stacking_two_halves_is_the_whole() {
        let half = slab_two_flux(0.7, 5.0, 0.2);
        let whole = slab_two_flux(0.7, 5.0, 0.4);
        let stacked = half.over(half);
        assert!((stacked.reflectance - whole.reflectance).abs() < 1e-14);
        assert!((stacked.transmittance - whole.transmittance).abs() < 1e-14);
    }

    #[test]
    fn two_flux_is_close_to_the_truth() {
        use crate::tissue::layers::Layer;
        use crate::tissue::many_flux::stack_many_flux;
        use crate::tissue::phase::PhaseMix;
        let mut worst: f64 = 0.0;
        for scattering in [1.0, 3.0, 10.0] {
            for absorption in [0.01, 0.3, 1.0, 5.0] {
                let layer = Layer {
                    absorption,
                    scattering,
                    thickness_mm: 0.4,
                    phase: PhaseMix::ISOTROPIC,
                };
                let truth = stack_many_flux::<8>(&[layer]).reflectance;
                let flux = slab_two_flux(absorption, scattering, 0.4).reflectance;
                println!("σs′ {scattering} σa {absorption}: {truth:.4}, two-flux {flux:.4}");
                worst = worst.max((truth - flux).abs());
            }
        }
        println!("two-flux is off by at most {worst:.4}");
        assert!(worst < 0.023, "{worst}");
    }

    #[test]
    fn nonsense_gives_numbers() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e300];
        for a in odd {
            for b in odd {
                for c in odd {
                    let flux = slab_two_flux(a, b, c);
                    for share in [flux.reflectance, flux.transmittance] {
                        assert!((0.0..=1.0).contains(&share), "{a} {b} {c}: {flux:?}");
                    }
                }
            }
        }
    }
}
