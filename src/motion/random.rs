//! Random numbers that do not depend on the order in which they are asked for.
//!
//! What enters: a seed, the name of a stream and the number of an event in that stream.
//! What leaves: a generator that is the same whenever and wherever that event is processed, so a
//! blink that is drawn later never changes the fixation that is drawn next. The distributions are
//! those of the oculomotor literature: normal, log-normal, exponential and ex-Gaussian.

use std::f64::consts::TAU;

use rand::Rng;
use rand_pcg::Pcg64;

/// The generator for event `number` of the stream `name` under `seed`.
///
/// The key is mixed by SplitMix64 (Steele, Lea and Flood 2014), because neighbouring PCG states
/// are correlated; the name picks PCG's own stream constant.
#[must_use]
pub fn stream(seed: u64, name: &str, number: u64) -> Pcg64 {
    // FNV-1a: stable across platforms and releases, unlike the standard library's hasher.
    let name_hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let low = split_mix(seed ^ split_mix(number ^ name_hash));
    let high = split_mix(low ^ number.rotate_left(32));
    Pcg64::new(
        (u128::from(high) << 64) | u128::from(low),
        u128::from(split_mix(name_hash)),
    )
}

fn split_mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A uniform number in [0, 1), with all 53 bits of an `f64`.
pub fn uniform(rng: &mut impl Rng) -> f64 {
    const ULP: f64 = 1.0 / (1_u64 << 53) as f64;
    (rng.next_u64() >> 11) as f64 * ULP
}

/// A uniform number in [low, high).
pub fn uniform_between(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

/// A standard normal number (Box and Muller 1958).
pub fn normal(rng: &mut impl Rng) -> f64 {
    // 1 − u lies in (0, 1], so the logarithm is finite.
    let radius = (-2.0 * (1.0 - uniform(rng)).ln()).sqrt();
    radius * (TAU * uniform(rng)).cos()
}

/// A log-normal number exp(µ + σ z).
pub fn log_normal(rng: &mut impl Rng, mu: f64, sigma: f64) -> f64 {
    (mu + sigma * normal(rng)).exp()
}

/// An exponential number of the given mean.
pub fn exponential(rng: &mut impl Rng, mean: f64) -> f64 {
    -mean * (1.0 - uniform(rng)).ln()
}

/// An ex-Gaussian number: a normal one plus an exponential one of mean `tau`, the usual law of
/// fixation durations. It can be negative; the caller sets the floor.
pub fn ex_gaussian(rng: &mut impl Rng, mu: f64, sigma: f64, tau: f64) -> f64 {
    mu + sigma * normal(rng) + exponential(rng, tau)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_key_gives_the_same_numbers_and_every_part_of_it_counts() {
        let first = |seed, name, number| stream(seed, name, number).next_u64();
        assert_eq!(first(7, "blink", 3), first(7, "blink", 3));
        let keys = [
            first(7, "blink", 3),
            first(8, "blink", 3),
            first(7, "choice", 3),
            first(7, "blink", 4),
        ];
        for (i, a) in keys.iter().enumerate() {
            for b in &keys[i + 1..] {
                assert_ne!(a, b);
            }
        }
    }

    /// The first number of neighbouring events must be independent: mean and lag-one correlation
    /// of 20,000 of them lie within four standard errors.
    #[test]
    fn neighbouring_events_are_uncorrelated() {
        let count = 20_000_u64;
        let draws: Vec<f64> = (0..count)
            .map(|n| uniform(&mut stream(1, "fixation", n)))
            .collect();
        let mean = draws.iter().sum::<f64>() / count as f64;
        let standard_error = (1.0_f64 / 12.0 / count as f64).sqrt();
        assert!((mean - 0.5).abs() < 4.0 * standard_error, "mean {mean}");
        let correlation = draws
            .windows(2)
            .map(|w| (w[0] - 0.5) * (w[1] - 0.5) * 12.0)
            .sum::<f64>()
            / count as f64;
        assert!(
            correlation.abs() < 4.0 / (count as f64).sqrt(),
            "{correlation}"
        );
    }

    /// Moments against the closed forms, within four standard errors of 40,000 draws.
    #[test]
    fn the_distributions_have_their_published_moments() {
        let count = 40_000_u64;
        let moments = |draw: &dyn Fn(&mut Pcg64) -> f64| {
            let values: Vec<f64> = (0..count).map(|n| draw(&mut stream(3, "m", n))).collect();
            let mean = values.iter().sum::<f64>() / count as f64;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count as f64;
            (mean, variance)
        };
        let (mean, variance) = moments(&|rng| ex_gaussian(rng, 0.18, 0.04, 0.1));
        let expected = 0.04_f64.powi(2) + 0.1_f64.powi(2);
        assert!((mean - 0.28).abs() < 4.0 * (expected / count as f64).sqrt());
        // The exponential's kurtosis of 9 makes the variance noisy: 8/n under the root.
        assert!((variance / expected - 1.0).abs() < 4.0 * (8.0 / count as f64).sqrt());
        let (mean, variance) = moments(&|rng| normal(rng));
        assert!(mean.abs() < 4.0 / (count as f64).sqrt());
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / count as f64).sqrt());
        let (mean, _) = moments(&|rng| log_normal(rng, 0.96, 0.77));
        let expected = (0.96_f64 + 0.5 * 0.77 * 0.77).exp();
        let deviation = expected * ((0.77_f64 * 0.77).exp() - 1.0).sqrt();
        assert!((mean - expected).abs() < 4.0 * deviation / (count as f64).sqrt());
    }
}
