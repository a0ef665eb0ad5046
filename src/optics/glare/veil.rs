//! Straylight of clouded media beyond that of a healthy eye: its spread, its energy, and its kernel as a
//! sum of Gaussians.
//!
//! Enters: the straylight parameter that clouding adds (deg² sr⁻¹ at 7°). Leaves: a spread function
//! that keeps all light: what is scattered is taken from what is not. Scatterers add in intensity,
//! and the angular law stays that of the CIE function's wide terms at every severity (van den Berg
//! and IJspeert 1995): one shape, scaled. Beyond a scattered share of a half light is scattered
//! more than once, which the share `1 − e^(−E s)` stands for.
//!
//! **As Gaussians.** A law near θ⁻² is a sum of Gaussians an octave apart, each with the energy of
//! one octave of rings; its ripple is 0.9 %.

use super::Glare;
use core::f64::consts::{FRAC_PI_2, TAU};

/// Angle at which the added straylight is given, rad.
const STATED_AT_RAD: f64 = 7.0 * core::f64::consts::PI / 180.0;
/// Gaussians that a kernel may have.
pub const VEIL_LEVELS: usize = 16;
/// Sigma of a mip level under a cubic B-spline, texels of that level: the (1, 3, 3, 1)/8 mips have a
/// variance of a quarter, the spline of a third.
pub const VEIL_SIGMA_TEXELS: f64 = 0.763_762_6;

/// What clouded media scatter beyond a healthy eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veil {
    with: Glare,
    without: Glare,
    /// Straylight at 7° of the shape as it stands, deg² sr⁻¹.
    unit: f64,
    /// What is added, multiple scattering counted, deg² sr⁻¹ at 7°.
    added: f64,
    scattered: f64,
}

impl Veil {
    /// Media that add `straylight` (deg² sr⁻¹ at 7°, 0 and more; what is not a number counts as 0) in an
    /// eye of this pigmentation (0 to 1.2).
    pub fn new(straylight: f64, pigment: f64) -> Self {
        let part = |wide: f64| Glare {
            core: 0.0,
            wide,
            ..Glare::with_age_factor(0.0, pigment)
        };
        let (with, without) = (part(1.0), part(0.0));
        let unit = with.straylight(STATED_AT_RAD) - without.straylight(STATED_AT_RAD);
        let whole = with.energy_within(FRAC_PI_2) - without.energy_within(FRAC_PI_2);
        let energy = whole / unit;
        let asked = if straylight > 0.0 && straylight.is_finite() {
            straylight
        } else {
            0.0
        };
        let scattered = -(-energy * asked).exp_m1();
        Self {
            with,
            without,
            unit,
            added: scattered / energy,
            scattered,
        }
    }

    /// Share of the light that is scattered, 0 to 1.
    pub fn scattered(&self) -> f64 {
        self.scattered
    }

    /// Scattered light per steradian at `theta_rad` from the source, sr⁻¹.
    pub fn spread(&self, theta_rad: f64) -> f64 {
        self.added / self.unit * (self.with.spread(theta_rad) - self.without.spread(theta_rad))
    }

    /// Scattered light within the cone of half-angle `theta_rad`.
    pub fn energy_within(&self, theta_rad: f64) -> f64 {
        let energy = self.with.energy_within(theta_rad) - self.without.energy_within(theta_rad);
        self.added / self.unit * energy
    }

    /// The kernel for a picture of `pixels_per_radian` at its middle, as weights of its mip levels from
    /// `first` to `last` under a cubic B-spline, and what remains for the picture's mean.
    ///
    /// A level's texel at the angle θ from the middle counts with its solid angle, cos³ θ; so the
    /// veil of a source in the middle is right as far as the picture goes, and a uniform picture stays
    /// what it is there.
    pub fn weights(
        &self,
        pixels_per_radian: f64,
        first: usize,
        last: usize,
    ) -> ([f64; VEIL_LEVELS], f64) {
        let mut weights = [0.0; VEIL_LEVELS];
        let mut kept = 0.0;
        let last = last.min(VEIL_LEVELS - 1);
        for (level, weight) in weights.iter_mut().enumerate().take(last + 1).skip(first) {
            let sigma = VEIL_SIGMA_TEXELS * 2f64.powi(level as i32) / pixels_per_radian;
            // Half of a Gaussian's light lies within 1.18 sigma.
            let middle = 1.177_41 * sigma;
            let (from, to) = (middle / 2f64.sqrt(), middle * 2f64.sqrt());
            *weight = self.ring(from, to);
            kept += *weight * mean_solid_angle(sigma);
        }
        (weights, (self.scattered - kept).max(0.0))
    }

    /// ∫ f(θ) 2π r dr over tangents from `from` to `to`, by Gauss's rule of three points on eight parts.
    fn ring(&self, from: f64, to: f64) -> f64 {
        const PARTS: usize = 8;
        let step = (to - from) / PARTS as f64;
        let mut sum = 0.0;
        for part in 0..PARTS {
            let middle = from + (part as f64 + 0.5) * step;
            for (at, weight) in [
                (-0.774_596_669_241_483, 5.0),
                (0.0, 8.0),
                (0.774_596_669_241_483, 5.0),
            ] {
                let r = middle + 0.5 * step * at;
                sum += weight / 18.0 * step * TAU * r * self.spread(r.atan());
            }
        }
        sum
    }
}

/// Mean of cos³ θ over a Gaussian of this sigma in tangents about the middle.
fn mean_solid_angle(sigma: f64) -> f64 {
    // By equal shares of its light.
    const SHARES: usize = 64;
    let shares = (0..SHARES).map(|i| {
        let outside = 1.0 - (i as f64 + 0.5) / SHARES as f64;
        let r_squared = -2.0 * sigma * sigma * outside.ln();
        (1.0 + r_squared).powf(-1.5)
    });
    shares.sum::<f64>() / SHARES as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_adds_the_straylight_that_it_is_given_while_that_is_little() {
        let veil = Veil::new(0.01, 0.5);
        let at = |deg: f64| deg * deg * veil.spread(deg.to_radians());
        assert!((at(7.0) / 0.01 - 1.0).abs() < 1e-3);
        // The shape of the wide terms: by quadrature of the published function.
        assert!(
            (at(1.0) / at(7.0) - 1.91).abs() < 0.02,
            "{}",
            at(1.0) / at(7.0)
        );
        assert!((at(28.0) / at(7.0) - 1.11).abs() < 0.02);
        // Beyond 1°, 0.0093 of the light for each deg² sr⁻¹.
        let beyond = veil.scattered() - veil.energy_within(1f64.to_radians());
        assert!((beyond / 0.01 - 0.0093).abs() < 2e-4, "{}", beyond / 0.01);
    }

    #[test]
    fn no_light_is_made_or_lost() {
        for straylight in [0.0, 0.5, 13.0, 90.0, 1e6, f64::NAN, -3.0, f64::INFINITY] {
            for pigment in [0.0, 0.5, 1.2] {
                let veil = Veil::new(straylight, pigment);
                let scattered = veil.scattered();
                assert!((0.0..=1.0).contains(&scattered));
                assert!((veil.energy_within(FRAC_PI_2) - scattered).abs() < 1e-9);
                let (weights, rest) = veil.weights(600.0, 3, 9);
                assert!(
                    weights
                        .iter()
                        .all(|weight| weight.is_finite() && *weight >= 0.0)
                );
                assert!(rest >= 0.0 && rest <= scattered + 1e-12);
            }
        }
    }

    /// The sum of Gaussians against the function that it stands for, from 1 to 30°.
    #[test]
    fn gaussians_an_octave_apart_are_the_kernel() {
        let pixels_per_radian = 640.0 / (2.0 * 30f64.to_radians().tan());
        for pigment in [0.0, 0.5, 1.2] {
            let veil = Veil::new(13.0, pigment);
            let (weights, _) = veil.weights(pixels_per_radian, 3, 12);
            let mut worst = 0.0_f64;
            for tenths in 10..=300 {
                let theta = f64::from(tenths).to_radians() / 10.0;
                let r = theta.tan();
                let sum: f64 = weights
                    .iter()
                    .enumerate()
                    .map(|(level, weight)| {
                        let sigma = VEIL_SIGMA_TEXELS * 2f64.powi(level as i32) / pixels_per_radian;
                        weight / (TAU * sigma * sigma) * (-0.5 * (r / sigma).powi(2)).exp()
                    })
                    .sum();
                worst = worst.max((sum / veil.spread(theta) - 1.0).abs());
            }
            println!("pigment {pigment}: within {:.2} %", worst * 100.0);
            // Ripple, and what the law's own bend within an octave adds.
            assert!(worst < 0.05, "pigment {pigment}: {worst}");
        }
    }
}
