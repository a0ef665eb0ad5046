//! Phase functions: into which directions a scattering event sends light.
//!
//! In: the cosine of the scattering angle (1 straight on, −1 straight back), the mean cosine g, or
//! a random number. Out: the share of scattered light per steradian (each function integrates to 1
//! over the sphere), or a drawn cosine.
//!
//! Henyey & Greenstein 1941 for bundles of collagen and cells, Rayleigh for fibrils much thinner
//! than a wavelength (unpolarised light), and mixtures of the two with an isotropic part.
//! [`phase_rayleigh`] and [`phase_henyey_greenstein`] have twins in `shaders/lib/phase.wgsl`.
//!
//! **Range.** Cosines are clamped to −1…1, mean cosines to ±[`MAX_MEAN_COSINE`] (at ±1 the function
//! is a delta function, which has no value); what is not a number counts as 0. In that range every
//! result is finite.

use core::f64::consts::PI;

/// Isotropic scattering, 1/(4π) sr⁻¹.
pub const PHASE_ISOTROPIC: f64 = 0.25 / PI;

/// Largest |g| that is computed, 1 − 2⁻¹³, a number that `f32` holds exactly too: a cone of light
/// half of which lies within 0.012°.
pub const MAX_MEAN_COSINE: f64 = 1.0 - 1.0 / 8192.0;

/// `v` within ±`limit`; what is not a number counts as 0.
fn within(v: f64, limit: f64) -> f64 {
    if v.is_nan() {
        0.0
    } else {
        v.clamp(-limit, limit)
    }
}

/// A random number within 0…1; what is not a number counts as ½.
fn share(xi: f64) -> f64 {
    if xi.is_nan() { 0.5 } else { xi.clamp(0.0, 1.0) }
}

/// Rayleigh's phase function (sr⁻¹) for unpolarised light: 3 (1 + cos²)/(16 π).
pub fn phase_rayleigh(cos: f64) -> f64 {
    let cos = within(cos, 1.0);
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Henyey & Greenstein's phase function (sr⁻¹), mean cosine `g`.
///
/// (1 − g²)/(4π (1 + g² − 2 g cos)^{3/2}), written with 1 ∓ g and 1 ∓ cos so that nothing cancels
/// where g goes to ±1: the relative error is a few roundings of the arguments given.
pub fn phase_henyey_greenstein(cos: f64, g: f64) -> f64 {
    let (cos, g) = (within(cos, 1.0), within(g, MAX_MEAN_COSINE));
    let (along, size) = (if g < 0.0 { -cos } else { cos }, g.abs());
    let less = 1.0 - size;
    let squared = less * less + 2.0 * size * (1.0 - along);
    PHASE_ISOTROPIC * less * (1.0 + size) / (squared * squared.sqrt())
}

/// Phase function (sr⁻¹) of a mixture: the share `rayleigh` of the events follows Rayleigh, the
/// share `isotropic` knows no direction, the rest follows Henyey & Greenstein with mean cosine `g`.
/// Shares are those of scattering coefficients, 0 to 1 together ([`PhaseMix::new`] sees to it).
pub fn phase_mix(cos: f64, rayleigh: f64, isotropic: f64, g: f64) -> f64 {
    rayleigh * phase_rayleigh(cos)
        + isotropic * PHASE_ISOTROPIC
        + (1.0 - rayleigh - isotropic) * phase_henyey_greenstein(cos, g)
}

/// Cosine of the scattering angle after Rayleigh for the random number `xi`, 0 (back) to 1
/// (straight on): the inverse of the distribution function, exactly.
///
/// ξ = ½ + (3 cos + cos³)/8 is a depressed cubic with one real root, u − 1/u with
/// u³ = q + √(q² + 1), q = 4ξ − 2; taken for |q|, where the sum under the root does not cancel.
pub fn sample_rayleigh(xi: f64) -> f64 {
    let q = 4.0 * share(xi) - 2.0;
    let size = q.abs();
    let u = (size + (size * size + 1.0).sqrt()).cbrt();
    (u - 1.0 / u).clamp(0.0, 1.0).copysign(q)
}

/// 1 − cosine of the scattering angle after Henyey & Greenstein for the random number `xi`, 0
/// (back) to 1 (straight on), with mean cosine `g`.
///
/// The usual inverse, [1 + g² − ((1 − g²)/(1 − g + 2 g ξ))²]/(2 g), loses every digit as g goes to
/// 0 and the small angles as g goes to 1. It factors into
///
/// 1 − cos = 2 (1 − ξ) (1 − g)² (1 + g ξ)/(1 − g + 2 g ξ)²,
///
/// a product of positive numbers for g ≥ 0, which loses nothing anywhere; for g < 0 forwards and
/// backwards change places.
pub fn sample_henyey_greenstein_versine(g: f64, xi: f64) -> f64 {
    let (g, xi) = (within(g, MAX_MEAN_COSINE), share(xi));
    if g < 0.0 {
        2.0 - versine(-g, 1.0 - xi, xi)
    } else {
        versine(g, xi, 1.0 - xi)
    }
}

/// 1 − cos for 0 ≤ g < 1, `xi` and what it lacks to 1.
fn versine(g: f64, xi: f64, rest: f64) -> f64 {
    let less = 1.0 - g;
    let ratio = less / (less + 2.0 * g * xi);
    2.0 * rest * ratio * ratio * (1.0 + g * xi)
}

/// Cosine of the scattering angle after Henyey & Greenstein; see
/// [`sample_henyey_greenstein_versine`].
pub fn sample_henyey_greenstein(g: f64, xi: f64) -> f64 {
    (1.0 - sample_henyey_greenstein_versine(g, xi)).clamp(-1.0, 1.0)
}

/// A mixture of phase functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseMix {
    rayleigh: f64,
    isotropic: f64,
    mean_cosine: f64,
}

impl PhaseMix {
    /// The same in all directions.
    pub const ISOTROPIC: Self = Self {
        rayleigh: 0.0,
        isotropic: 1.0,
        mean_cosine: 0.0,
    };
    /// Particles much smaller than the wavelength.
    pub const RAYLEIGH: Self = Self {
        rayleigh: 1.0,
        isotropic: 0.0,
        mean_cosine: 0.0,
    };

    /// Henyey & Greenstein alone, mean cosine −1 to 1 (clamped to ±[`MAX_MEAN_COSINE`]).
    pub fn henyey_greenstein(mean_cosine: f64) -> Self {
        Self::new(0.0, 0.0, mean_cosine)
    }

    /// Shares of the scattering events that follow Rayleigh and that know no direction; the rest
    /// follows Henyey & Greenstein with `mean_cosine`. Shares are clamped to 0…1 and, where they
    /// pass 1 together, the isotropic one gives way; what is not a number counts as 0.
    pub fn new(rayleigh_share: f64, isotropic_share: f64, mean_cosine: f64) -> Self {
        let rayleigh = within(rayleigh_share, 1.0).max(0.0);
        Self {
            rayleigh,
            isotropic: within(isotropic_share, 1.0).clamp(0.0, 1.0 - rayleigh),
            mean_cosine: within(mean_cosine, MAX_MEAN_COSINE),
        }
    }

    /// Share of Rayleigh's phase function, 0 to 1.
    pub fn rayleigh_share(&self) -> f64 {
        self.rayleigh
    }

    /// Share of the isotropic phase function, 0 to 1.
    pub fn isotropic_share(&self) -> f64 {
        self.isotropic
    }

    /// Mean cosine of the Henyey–Greenstein part.
    pub fn henyey_greenstein_cosine(&self) -> f64 {
        self.mean_cosine
    }

    /// The mixture's value (sr⁻¹) at the cosine of the scattering angle.
    pub fn value(&self, cos: f64) -> f64 {
        phase_mix(cos, self.rayleigh, self.isotropic, self.mean_cosine)
    }

    /// Mean cosine of the scattering angle, the g of reduced scattering σ_s′ = σ_s (1 − g): only
    /// the Henyey–Greenstein part has one.
    pub fn mean_cosine(&self) -> f64 {
        (1.0 - self.rayleigh - self.isotropic) * self.mean_cosine
    }

    /// Cosine of the scattering angle for one random number: which part scatters and where to. The
    /// number is stretched again after the choice, so one is enough.
    pub fn sample(&self, xi: f64) -> f64 {
        let xi = share(xi);
        if xi < self.rayleigh {
            return sample_rayleigh(xi / self.rayleigh);
        }
        let (xi, isotropic) = (xi - self.rayleigh, self.isotropic);
        if xi < isotropic {
            return 2.0 * (xi / isotropic) - 1.0;
        }
        let rest = 1.0 - self.rayleigh - isotropic;
        if rest > 0.0 {
            sample_henyey_greenstein(self.mean_cosine, (xi - isotropic) / rest)
        } else {
            // Only ξ = 1 itself comes here: straight on in either of the other two.
            1.0
        }
    }
}

#[cfg(test)]
mod tests;
