//! The reference for light scattered any number of times: random walks in a stack of layers.
//!
//! In: plane-parallel homogeneous layers from the front ([`Layer`], any mixture of phase functions,
//! matched indices at every boundary), how the light comes in, a number of walks and a seed. Out:
//! what the stack reflects, passes and absorbs, each with its own standard error, and the reflected
//! light by the number of times it was scattered.
//!
//! **Method.** Depth is counted in optical depths, so that a step is −ln ξ whatever the layers and
//! no boundary stops it (boundaries are index-matched; without extinction a layer is not there).
//! At a collision the layer's share of absorption is taken from the walk's weight and booked
//! (Prahl et al. 1989; Wang, Jacques & Zheng 1995); only the cosine to the normal is followed, as
//! nothing depends on place or azimuth. A weight below [`ROULETTE_WEIGHT`] is doubled or ended by
//! the toss of a coin, and what is won or lost is booked to the layer's absorption: right in the
//! mean, and every walk's books still add up to 1, so reflected, passed and absorbed light do too.
//!
//! The standard errors come from the walks' own scatter: results of different walks are
//! independent, so (Σ w² − (Σ w)²/n)/(n (n − 1)) is the variance of the mean.

use super::layers::Layer;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Orders of scattering that are counted one by one: 1 to this, and the rest together.
pub const ORDERS: usize = 16;
/// Weight at which the coin is tossed.
pub const ROULETTE_WEIGHT: f64 = 0.01;
/// A walk is given up after so many collisions and what it still carries counted as
/// [`RandomWalk::unfinished`]; only in a bottomless layer without absorption does that happen.
pub const MAX_COLLISIONS: u32 = 100_000;

/// How light comes to the front of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Illumination {
    /// A beam at this cosine to the normal (clamped to 1e-6…1; what is not a number counts as 1).
    Beam(f64),
    /// From the whole hemisphere with equal radiance.
    Diffuse,
}

/// A mean and how sure it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean over the walks.
    pub mean: f64,
    /// Standard error of the mean (one standard deviation).
    pub standard_error: f64,
}

/// What becomes of the light, as shares of what comes in.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomWalk {
    /// Reflected after one scattering or more.
    pub reflectance: Estimate,
    /// Passed, scattered or not.
    pub transmittance: Estimate,
    /// Passed without scattering.
    pub direct_transmittance: Estimate,
    /// Absorbed in each layer.
    pub absorbed: Vec<Estimate>,
    /// Reflected after 1, 2 … [`ORDERS`] scatterings, and after more.
    pub reflected_by_order: [Estimate; ORDERS + 1],
    /// Neither, because the walk was given up ([`MAX_COLLISIONS`]).
    pub unfinished: f64,
    /// Collisions in all walks together.
    pub collisions: u64,
}

impl RandomWalk {
    /// Reflected, passed, absorbed and unfinished light together: 1, to rounding.
    pub fn total(&self) -> f64 {
        let absorbed: f64 = self.absorbed.iter().map(|layer| layer.mean).sum();
        self.reflectance.mean + self.transmittance.mean + absorbed + self.unfinished
    }
}

/// Sums of a result and of its square.
#[derive(Clone, Copy, Default)]
struct Tally {
    sum: f64,
    squares: f64,
}

impl Tally {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.squares += value * value;
    }

    fn estimate(self, walks: f64) -> Estimate {
        let mean = self.sum / walks;
        // Not below 0 by rounding where all walks agree.
        let variance = (self.squares / walks - mean * mean).max(0.0) / (walks - 1.0);
        Estimate {
            mean,
            standard_error: variance.sqrt(),
        }
    }
}

/// What the inner loop needs of a layer, and its books.
struct Stratum {
    /// Optical depth of its far side.
    end: f64,
    albedo: f64,
    phase: super::phase::PhaseMix,
    absorbed: Tally,
    /// Absorbed in the walk under way.
    now: f64,
}

/// Sends `walks` (2 or more; fewer count as 2) photons into the stack. The same seed gives the same
/// numbers everywhere. Numbers of the layers are clamped as in [`super::layers`].
pub fn random_walk(
    layers: &[Layer],
    illumination: Illumination,
    walks: u32,
    seed: u64,
) -> RandomWalk {
    walk_and_look(layers, illumination, 0.0, walks, seed).0
}

/// What of the same walks is reflected in directions whose cosine to the normal is `least` or more.
pub fn random_walk_within(
    layers: &[Layer],
    illumination: Illumination,
    least: f64,
    walks: u32,
    seed: u64,
) -> Estimate {
    walk_and_look(layers, illumination, least, walks, seed).1
}

fn walk_and_look(
    layers: &[Layer],
    illumination: Illumination,
    least: f64,
    walks: u32,
    seed: u64,
) -> (RandomWalk, Estimate) {
    let mut within = Tally::default();
    let walks = walks.max(2);
    let mut depth = 0.0;
    let mut strata: Vec<Stratum> = layers
        .iter()
        .map(|layer| {
            let layer = layer.clamped();
            depth += layer.optical_depth();
            Stratum {
                end: depth,
                albedo: layer.albedo(),
                phase: layer.phase,
                absorbed: Tally::default(),
                now: 0.0,
            }
        })
        .collect();
    let whole = depth;
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (mut reflected, mut passed, mut direct) =
        (Tally::default(), Tally::default(), Tally::default());
    let mut by_order = [Tally::default(); ORDERS + 1];
    let (mut unfinished, mut collisions) = (0.0, 0_u64);

    for _ in 0..walks {
        let mut cos = match illumination {
            Illumination::Beam(cos) if cos.is_nan() => 1.0,
            Illumination::Beam(cos) => cos.clamp(1e-6, 1.0),
            // Radiance times cosine: µ = √ξ.
            Illumination::Diffuse => (1.0 - rng.random::<f64>()).sqrt(),
        };
        let (mut depth, mut weight, mut order, mut stratum) = (0.0, 1.0, 0_u32, 0_usize);
        loop {
            // 1 − ξ is never 0.
            depth -= cos * (1.0 - rng.random::<f64>()).ln();
            if depth < 0.0 {
                reflected.add(weight);
                if -cos >= least {
                    within.add(weight);
                }
                by_order[(order as usize - 1).min(ORDERS)].add(weight);
                break;
            }
            if depth >= whole {
                passed.add(weight);
                if order == 0 {
                    direct.add(weight);
                }
                break;
            }
            while depth >= strata[stratum].end {
                stratum += 1;
            }
            while stratum > 0 && depth < strata[stratum - 1].end {
                stratum -= 1;
            }
            let here = &mut strata[stratum];
            order += 1;
            let scattered = weight * here.albedo;
            here.now += weight - scattered;
            weight = scattered;
            if weight < ROULETTE_WEIGHT {
                if weight == 0.0 {
                    break;
                }
                if rng.random::<bool>() {
                    here.now -= weight;
                    weight += weight;
                } else {
                    here.now += weight;
                    break;
                }
            }
            if order == MAX_COLLISIONS {
                unfinished += weight;
                break;
            }
            cos = turned(cos, here.phase.sample(rng.random()), &here.phase, &mut rng);
        }
        collisions += u64::from(order);
        for stratum in &mut strata {
            stratum.absorbed.add(stratum.now);
            stratum.now = 0.0;
        }
    }

    let n = f64::from(walks);
    let walked = RandomWalk {
        reflectance: reflected.estimate(n),
        transmittance: passed.estimate(n),
        direct_transmittance: direct.estimate(n),
        absorbed: strata.iter().map(|s| s.absorbed.estimate(n)).collect(),
        reflected_by_order: by_order.map(|order| order.estimate(n)),
        unfinished: unfinished / n,
        collisions,
    };
    (walked, within.estimate(n))
}

/// Cosine to the normal after scattering by an angle with the cosine `by`, at a random azimuth.
fn turned(cos: f64, by: f64, phase: &super::phase::PhaseMix, rng: &mut Pcg64Mcg) -> f64 {
    if phase.isotropic_share() == 1.0 {
        // No direction is remembered.
        return by;
    }
    let sines = ((1.0 - cos * cos) * (1.0 - by * by)).max(0.0).sqrt();
    let azimuth = core::f64::consts::PI * rng.random::<f64>();
    (cos * by + sines * azimuth.cos()).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests;
