//! GGX microfacets: the normal distribution of Walter et al. 2007 (equation 33) and the
//! height-correlated Smith visibility of Heitz 2014 (equation 99).
//!
//! In: cosines and the roughness parameter `alpha` (above 0) of those papers. Out: the factors of
//! the specular lobe `ndf × visibility × Fresnel`.
//!
//! Twin: `shaders/lib/microfacet.wgsl`.

use core::f64::consts::PI;

/// Density of microfacet normals (sr⁻¹) at `cos_half`, the cosine between the normal and the half
/// vector. Its integral over projected solid angle is 1.
pub fn ggx_ndf(cos_half: f64, alpha: f64) -> f64 {
    if cos_half <= 0.0 {
        return 0.0;
    }
    let c = cos_half.min(1.0);
    let a = alpha * alpha;
    // (1 − c)(1 + c) keeps the sine of a small angle, which c²(α² − 1) + 1 loses.
    let spread = (1.0 - c) * (1.0 + c) + a * c * c;
    a / (PI * spread * spread)
}

/// `G₂ / (4 cos_view cos_light)`, height-correlated.
pub fn ggx_visibility_smith(cos_view: f64, cos_light: f64, alpha: f64) -> f64 {
    if cos_view <= 0.0 || cos_light <= 0.0 {
        return 0.0;
    }
    let a = alpha * alpha;
    let view = cos_light * (cos_view * cos_view * (1.0 - a) + a).sqrt();
    let light = cos_view * (cos_light * cos_light * (1.0 - a) + a).sqrt();
    0.5 / (view + light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_is_normalised() {
        // ∫ D(h) cos h dω = 2π ∫ D c dc, substituting c² = 1 − s with s = e^u to resolve the peak.
        for alpha in [0.02, 0.1, 0.5, 1.0] {
            let steps = 200_000;
            let (low, high) = (1e-12_f64.ln(), 0.0);
            let h = (high - low) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| {
                    let s = (low + (f64::from(i) + 0.5) * h).exp();
                    PI * ggx_ndf((1.0 - s).sqrt(), alpha) * s * h
                })
                .sum();
            // Midpoint rule on a smooth integrand, and s < 1e-12 left out of a peak as wide as α².
            assert!((sum - 1.0).abs() < 1e-7, "alpha {alpha}: {sum}");
        }
    }

    #[test]
    fn visibility_with_masking_only_keeps_all_energy() {
        // The weak white furnace (Heitz 2014): ∫ D(h) G₁(v)/(4 cos v) dl = 1, which holds with
        // G₂ replaced by G₁(v) = 2 cos v/(cos v + sqrt(cos² v + α² sin² v)); our visibility with the
        // light along the normal reduces to G₁(v)/(4 cos v) because G₁ is 1 there.
        for alpha in [0.05, 0.3, 0.9] {
            for cos_view in [0.05, 0.4, 1.0_f64] {
                let a = alpha * alpha;
                let root = (cos_view * cos_view + a * (1.0 - cos_view * cos_view)).sqrt();
                let expected = 2.0 * cos_view / (cos_view + root) / (4.0 * cos_view);
                let got = ggx_visibility_smith(cos_view, 1.0, alpha);
                assert!((got - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn it_is_reciprocal_and_dark_below_the_horizon() {
        assert_eq!(
            ggx_visibility_smith(0.3, 0.8, 0.2),
            ggx_visibility_smith(0.8, 0.3, 0.2)
        );
        assert_eq!(ggx_visibility_smith(0.0, 0.8, 0.2), 0.0);
        assert_eq!(ggx_visibility_smith(0.8, -0.1, 0.2), 0.0);
        assert_eq!(ggx_ndf(-0.5, 0.2), 0.0);
        assert!(ggx_ndf(1.0, 0.02).is_finite());
    }
}
