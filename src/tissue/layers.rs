//! Light scattered once in a stack of homogeneous layers, in closed form: no march.
//!
//! In: layers from the front (coefficients in mm⁻¹, thickness in mm, phase function) or one layer's
//! numbers for three colours, cosines to the layers' normal. Out: what passes straight on, and
//! what is scattered exactly once into a direction in front (reflected) or behind (transmitted).
//!
//! Everything rests on one integral. Along a straight segment in a homogeneous layer the optical
//! depth of the way in plus the way out changes linearly, from `a` to `b`, so that the mean of
//! what gets through is
//!
//! M(a, b) = ∫₀¹ e^(−a(1−t) − b t) dt = e^(−min(a, b)) (1 − e^(−|a−b|))/|a−b|,
//!
//! ([`mean_transmittance`]): no division where the extinction vanishes, none where way in and way
//! out are equally dense, no overflow where they are not. Reflection by a layer is Chandrasekhar's
//! single scattering (Radiative Transfer, 1960, §17), transmission his counterpart.
//!
//! [`layer_mean_transmittance`] has a twin in `shaders/lib/layers.wgsl`, one colour a channel. The phase function is one number
//! for fixed directions ([`super::phase`]).
//!
//! **Range.** Coefficients and lengths from 0 to [`LARGEST`]; outside they are clamped and what is
//! not a number counts as 0. A cosine of 0 or less means that the ray does not cross the layer: the
//! result is 0. A cosine below [`GRAZING_COS`] is treated as that.

use super::phase::PhaseMix;
use glam::DVec3;

/// Largest coefficient (mm⁻¹) and length (mm) that is computed.
pub const LARGEST: f64 = 1e9;
/// Smallest cosine to the normal that is computed: 0.2 arc seconds from grazing.
pub const GRAZING_COS: f64 = 1e-6;

/// One homogeneous layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Absorption coefficient σ_a (mm⁻¹).
    pub absorption: f64,
    /// Scattering coefficient σ_s (mm⁻¹).
    pub scattering: f64,
    /// Thickness (mm).
    pub thickness_mm: f64,
    /// Where scattered light goes.
    pub phase: PhaseMix,
}

/// `v` within 0 and [`LARGEST`]; what is not a number counts as 0.
pub(super) fn clamped(v: f64) -> f64 {
    if v.is_nan() {
        0.0
    } else {
        v.clamp(0.0, LARGEST)
    }
}

/// [`clamped`] for three colours.
#[cfg(test)]
pub(super) fn clamped_rgb(v: DVec3) -> DVec3 {
    v.map(clamped)
}

/// A cosine within [`GRAZING_COS`] and 1, or none where the ray does not cross the layer.
fn crossing(cos: f64) -> Option<f64> {
    (cos > 0.0).then(|| cos.clamp(GRAZING_COS, 1.0))
}

impl Layer {
    /// The layer with its numbers clamped to their range.
    pub fn clamped(self) -> Self {
        Self {
            absorption: clamped(self.absorption),
            scattering: clamped(self.scattering),
            thickness_mm: clamped(self.thickness_mm),
            phase: self.phase,
        }
    }

    /// Extinction coefficient (mm⁻¹): absorption and scattering.
    pub fn extinction(&self) -> f64 {
        self.absorption + self.scattering
    }

    /// Share of the extinction that scatters, 0 to 1; 0 where there is no extinction.
    pub fn albedo(&self) -> f64 {
        let extinction = self.extinction();
        if extinction > 0.0 {
            self.scattering / extinction
        } else {
            0.0
        }
    }

    /// Optical depth across the layer.
    pub fn optical_depth(&self) -> f64 {
        self.extinction() * self.thickness_mm
    }
}

/// Mean of e^(−depth) along a segment whose optical depth changes linearly from `start` to `end`
/// (0 or more; less counts as 0). Relative error of a few 1e-16 of the depths.
pub fn mean_transmittance(start: f64, end: f64) -> f64 {
    let (start, end) = (start.max(0.0), end.max(0.0));
    let (low, difference) = (start.min(end), (start - end).abs());
    let share = if difference > 0.0 {
        -(-difference).exp_m1() / difference
    } else if difference == 0.0 {
        1.0
    } else {
        // ∞ − ∞: both ends are in the dark.
        return 0.0;
    };
    (-low).exp() * share
}

/// [`mean_transmittance`] of three colours. ∫ σ_s e^(−depth) ds along a segment of `length` mm is this times σ_s `length`:
/// with the phase function (sr⁻¹) and the irradiance across the beam, the radiance that it scatters towards the eye.
pub fn layer_mean_transmittance(start: DVec3, end: DVec3) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|i| {
        mean_transmittance(start[i], end[i])
    }))
}

/// What one layer adds to the reflected BRDF by single scattering, but for the phase function
/// (sr⁻¹): light enters the stack at `cos_in` and leaves at `cos_out` to the normal, `above` is the
/// optical depth (along the normal) of the layers in front.
#[cfg(test)]
pub(crate) fn layer_reflect_once(
    above: DVec3,
    extinction: DVec3,
    scattering: DVec3,
    thickness: f64,
    cos_in: f64,
    cos_out: f64,
) -> DVec3 {
    let (Some(cos_in), Some(cos_out)) = (crossing(cos_in), crossing(cos_out)) else {
        return DVec3::ZERO;
    };
    let (above, thickness) = (clamped_rgb(above), clamped(thickness));
    let (extinction, scattering) = (clamped_rgb(extinction), clamped_rgb(scattering));
    let slant = 1.0 / cos_in + 1.0 / cos_out;
    let mean = layer_mean_transmittance(above * slant, (above + extinction * thickness) * slant);
    scattering * thickness * mean / (cos_in * cos_out)
}

/// Optical depth across a stack.
pub fn stack_optical_depth(layers: &[Layer]) -> f64 {
    layers.iter().map(|l| l.clamped().optical_depth()).sum()
}

/// Share of a beam that crosses the stack straight on at `cos` to the normal (Beer and Lambert).
pub fn stack_transmittance(layers: &[Layer], cos: f64) -> f64 {
    crossing(cos).map_or(0.0, |cos| (-stack_optical_depth(layers) / cos).exp())
}

/// BRDF (sr⁻¹) of a stack over black for light scattered once: light enters at `cos_in` and leaves
/// at `cos_out` to the normal, turned by an angle with the cosine `cos_scatter` (−1 where it goes
/// back the way it came). Exact.
pub fn stack_reflect_once(layers: &[Layer], cos_in: f64, cos_out: f64, cos_scatter: f64) -> f64 {
    let (Some(cos_in), Some(cos_out)) = (crossing(cos_in), crossing(cos_out)) else {
        return 0.0;
    };
    let slant = 1.0 / cos_in + 1.0 / cos_out;
    let (mut depth, mut sum) = (0.0, 0.0);
    for layer in layers {
        let layer = layer.clamped();
        let behind = depth + layer.optical_depth() * slant;
        if layer.scattering > 0.0 {
            sum += layer.scattering
                * layer.thickness_mm
                * layer.phase.value(cos_scatter)
                * mean_transmittance(depth, behind);
        }
        depth = behind;
    }
    sum / (cos_in * cos_out)
}

/// Gauss–Legendre rule for 0…1, 16 points; symmetric, so half of it: distance from ½ and weight.
#[rustfmt::skip]
const HALF_RULE: [(f64, f64); 8] = [
    (0.047_506_254_918_818_72, 0.094_725_305_227_534_25),
    (0.140_801_775_389_629_46, 0.091_301_707_522_461_79),
    (0.229_008_388_828_613_7, 0.084_578_259_697_501_27),
    (0.308_938_122_201_321_9, 0.074_797_994_408_288_37),
    (0.377_702_204_177_501_5, 0.062_314_485_627_766_94),
    (0.432_815_601_193_915_9, 0.047_579_255_841_246_39),
    (0.472_287_511_536_616_3, 0.031_126_761_969_323_946),
    (0.494_700_467_495_824_97, 0.013_576_229_705_877_047),
];

/// ∫₀¹ f(µ) dµ for f like e^(−τ/µ), which leaves 0 flat: Gauss–Legendre in √µ.
fn over_cosines(f: impl Fn(f64) -> f64) -> f64 {
    let at = |root: f64, weight: f64| 2.0 * root * weight * f(root * root);
    HALF_RULE
        .iter()
        .map(|(off, weight)| at(0.5 + off, *weight) + at(0.5 - off, *weight))
        .sum()
}

/// Share of diffuse light that the stack returns after exactly one scattering. Only isotropic
/// scattering has this closed form: the layers' phase functions are taken as isotropic, their
/// coefficients as reduced ones. Within 1e-6.
///
/// Light enters at all cosines µ₀ and leaves at all µ: 4 ∫∫ π BRDF µ µ₀ dµ dµ₀, of which a layer
/// from optical depth `a` to `b` makes σ_s d ∫∫ M(a s, b s) dµ dµ₀ with s = 1/µ + 1/µ₀.
pub fn stack_diffuse_reflectance_once(layers: &[Layer]) -> f64 {
    let (mut depth, mut sum) = (0.0, 0.0);
    for layer in layers {
        let layer = layer.clamped();
        let behind = depth + layer.optical_depth();
        if layer.scattering > 0.0 {
            let mean = over_cosines(|cos_in| {
                over_cosines(|cos_out| {
                    let slant = 1.0 / cos_in + 1.0 / cos_out;
                    mean_transmittance(depth * slant, behind * slant)
                })
            });
            sum += layer.scattering * layer.thickness_mm * mean;
        }
        depth = behind;
    }
    sum
}

#[cfg(test)]
mod tests;
