//! Blinks: when they come and how the lid moves.
//!
//! What enters: a rate law and random numbers. What leaves: intervals in s and the aperture (1 as
//! far open as before the blink, 0 closed) as a C² curve of time. The down-phase is a quintic:
//! its peak velocity is 1.875 of its mean one, which gives the main sequence of lids, V ≈ 28.6·A
//! per second at 66 ms. The up-phase is the same curve 1.4
//! times slower. Intervals are log-normal.

use rand::Rng;

use super::random;

/// How much slower the lid rises than it falls.
pub const OPENING_RATIO: f64 = 1.4;
/// Spread of the logarithm of blink intervals.
const INTERVAL_SIGMA: f64 = 0.77;
/// Cardoso's normal law of the rate, Hz (Cardoso 2016, table 3.1).
const CARDOSO_RATE_HZ: (f64, f64) = (0.1339, 0.1605);
/// The slowest rate that is taken from Cardoso's law, Hz: one blink in 50 s.
const CARDOSO_SLOWEST_HZ: f64 = 0.02;

/// The law that times spontaneous blinks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BlinkRate {
    /// 17 a minute: log-normal intervals with µ = 0.96.
    #[default]
    Rest,
    /// 26 a minute in conversation: µ = 0.54.
    Talk,
    /// 4.5 a minute in reading: µ = 2.29.
    Read,
    /// Cardoso's normal law of the rate. It would be negative one time in five, so it is cut off
    /// at one blink in 50 s by drawing again.
    Cardoso,
    /// Log-normal intervals of this mean rate a minute, > 0 and ≤ 60.
    PerMinute(f64),
    /// No spontaneous blinks.
    None,
}

impl BlinkRate {
    /// Draws the interval between the starts of two blinks, s, or `None` for [`BlinkRate::None`].
    pub fn draw_interval_s(self, rng: &mut impl Rng) -> Option<f64> {
        let mu = match self {
            Self::Rest => 0.96,
            Self::Talk => 0.54,
            Self::Read => 2.29,
            // The mean of a log-normal law is exp(µ + σ²/2).
            Self::PerMinute(rate) => (60.0 / rate).ln() - 0.5 * INTERVAL_SIGMA.powi(2),
            Self::Cardoso => return Some(1.0 / draw_cardoso_rate_hz(rng)),
            Self::None => return None,
        };
        Some(random::log_normal(rng, mu, INTERVAL_SIGMA))
    }
}

fn draw_cardoso_rate_hz(rng: &mut impl Rng) -> f64 {
    loop {
        let rate = CARDOSO_RATE_HZ.0 + CARDOSO_RATE_HZ.1 * random::normal(rng);
        if rate >= CARDOSO_SLOWEST_HZ {
            return rate;
        }
    }
}

/// One blink: the lid falls, rests and rises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blink {
    /// Time at which the lid begins to fall, s.
    pub start_s: f64,
    /// Duration of the fall, s.
    pub closing_s: f64,
    /// Duration of closure, s.
    pub closed_s: f64,
    /// Duration of the rise, s.
    pub opening_s: f64,
    /// Share of the aperture that is covered at the deepest point: 1 for a full blink.
    pub depth: f64,
}

impl Blink {
    /// A spontaneous blink: 66 ms down, 8.3 ms closed. `depth` in (0, 1], 1 a full one.
    #[must_use]
    pub fn spontaneous(start_s: f64, depth: f64) -> Self {
        Self::new(start_s, 0.066, 0.0083, depth)
    }

    /// A voluntary blink: 77.6 ms down, 13.4 ms closed, always full.
    #[must_use]
    pub fn voluntary(start_s: f64) -> Self {
        Self::new(start_s, 0.0776, 0.0134, 1.0)
    }

    fn new(start_s: f64, closing_s: f64, closed_s: f64, depth: f64) -> Self {
        Self {
            start_s,
            closing_s,
            closed_s,
            opening_s: closing_s * OPENING_RATIO,
            depth,
        }
    }

    /// Time at which the lid has come down, s.
    #[must_use]
    pub fn closed_from_s(&self) -> f64 {
        self.start_s + self.closing_s
    }

    /// Time at which the lid is back, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.closed_from_s() + self.closed_s + self.opening_s
    }

    /// Whether this blink covers the pupil altogether.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.depth >= 1.0
    }

    /// The aperture at time `t` in s: 1 outside the blink, exactly 0 while a full one is closed.
    #[must_use]
    pub fn aperture(&self, t: f64) -> f64 {
        let opening_from = self.closed_from_s() + self.closed_s;
        let covered = if t <= self.start_s || t >= self.end_s() {
            0.0
        } else if t < self.closed_from_s() {
            quintic((t - self.start_s) / self.closing_s)
        } else if t <= opening_from {
            1.0
        } else {
            1.0 - quintic((t - opening_from) / self.opening_s)
        };
        1.0 - self.depth * covered
    }
}

/// 10 u³ − 15 u⁴ + 6 u⁵ on [0, 1]: velocity and acceleration vanish at both ends.
fn quintic(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_down_phase_is_on_the_main_sequence_of_lids() {
        // REFERENCE: 30.6° in 66 ms peaks at 875 °/s, so V/A = 28.6 per second. The quintic's
        // 1.875/0.066 = 28.41 is within 1 %.
        let blink = Blink::spontaneous(0.0, 1.0);
        let step = 1e-6;
        let peak = (1..66_000)
            .map(|i| {
                let t = f64::from(i) * step;
                (blink.aperture(t - step) - blink.aperture(t)) / step
            })
            .fold(0.0, f64::max);
        assert!((peak - 1.875 / 0.066).abs() < 1e-3, "{peak}");
        assert!((peak / 28.6 - 1.0).abs() < 0.01);
        assert!((peak * 30.6 / 875.0 - 1.0).abs() < 0.01);
    }

    #[test]
    fn the_lid_closes_fully_stays_and_opens_slower_without_a_jump_of_velocity() {
        for blink in [Blink::spontaneous(1.0, 1.0), Blink::voluntary(1.0)] {
            assert_eq!(blink.aperture(1.0), 1.0);
            assert_eq!(blink.aperture(blink.closed_from_s()), 0.0);
            assert_eq!(blink.aperture(blink.closed_from_s() + blink.closed_s), 0.0);
            assert_eq!(blink.aperture(blink.end_s()), 1.0);
            assert!((0.066..=0.0776).contains(&blink.closing_s));
            assert!(blink.opening_s >= 1.4 * blink.closing_s - 1e-12);
            // The largest acceleration of the quintic is 5.77/T²: velocity over 1 µs cannot
            // change by more.
            let step = 1e-6;
            let limit = 5.78 / blink.closing_s.powi(2) * step + 1e-8;
            let velocity = |t: f64| (blink.aperture(t + step) - blink.aperture(t)) / step;
            let mut t = 0.99;
            while t < blink.end_s() + 0.01 {
                let jump = (velocity(t + step) - velocity(t)).abs();
                assert!(jump <= limit, "{jump} at {t}");
                t += 11.0 * step;
            }
        }
    }

    #[test]
    fn a_partial_blink_stops_half_way() {
        let blink = Blink::spontaneous(0.0, 0.5);
        assert!(!blink.is_full());
        assert_eq!(blink.aperture(0.07), 0.5);
    }

    #[test]
    fn the_rates_are_the_published_ones() {
        // exp(µ + σ²/2): 17, 26 and 4.5 a minute; four standard errors of 40,000 intervals.
        let count = 40_000_u64;
        let spread = (INTERVAL_SIGMA.powi(2).exp() - 1.0).sqrt();
        for (rate, per_minute) in [
            (BlinkRate::Rest, 17.0),
            (BlinkRate::Talk, 26.0),
            (BlinkRate::Read, 4.5),
            (BlinkRate::PerMinute(40.0), 40.0),
        ] {
            let mean = (0..count)
                .filter_map(|n| rate.draw_interval_s(&mut random::stream(1, "blink", n)))
                .sum::<f64>()
                / count as f64;
            let tolerance = 4.0 * spread / (count as f64).sqrt() + 0.01;
            assert!(
                (60.0 / mean / per_minute - 1.0).abs() < tolerance,
                "{rate:?}: {}",
                60.0 / mean
            );
        }
        let mut rng = random::stream(1, "blink", 0);
        assert_eq!(BlinkRate::None.draw_interval_s(&mut rng), None);
    }

    #[test]
    fn cardosos_law_never_gives_a_negative_interval() {
        for n in 0..5_000 {
            let interval = BlinkRate::Cardoso
                .draw_interval_s(&mut random::stream(2, "blink", n))
                .unwrap();
            assert!(interval > 0.0 && interval <= 50.0, "{interval}");
        }
    }
}
