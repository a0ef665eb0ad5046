//! Accommodation: the lens as a first-order servo with limits.
//!
//! What enters: the distance of the fixated point, the far point and the amplitude. What leaves:
//! the response above the relaxed state in dioptres, and the exponential that carries the lens
//! there. The amplitude of an age is Hofstetter's (1950); relaxation has the
//! measured peak velocity 1.39 x + 1.12 D/s, which depends on where the lens starts (x, in D) and
//! not on how far it has to go.

/// A first-order approach `to + (from − to)·e^(−(t − start)/τ)`: the closed curve of the lens and
/// of the pupil between two events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Time at which the approach begins, s. Before it the value is `from`.
    pub start_s: f64,
    /// Value at the start.
    pub from: f64,
    /// Value that is approached.
    pub to: f64,
    /// Time constant, s; 0 means at once.
    pub time_constant_s: f64,
}

impl Approach {
    /// A value that rests.
    #[must_use]
    pub const fn rest(value: f64) -> Self {
        Self {
            start_s: 0.0,
            from: value,
            to: value,
            time_constant_s: 0.0,
        }
    }

    /// The value at time `t` in s.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let elapsed = t - self.start_s;
        if elapsed < 0.0 {
            return self.from;
        }
        if self.time_constant_s <= 0.0 {
            return self.to;
        }
        self.to + (self.from - self.to) * (-elapsed / self.time_constant_s).exp()
    }

    /// A new approach that leaves from where this one stands at `t`, so the value never jumps.
    #[must_use]
    pub fn turn_to(&self, t: f64, to: f64, time_constant_s: f64) -> Self {
        Self {
            start_s: t,
            from: self.at(t),
            to,
            time_constant_s,
        }
    }
}

/// The vergence of a point at `distance_m` (> 0, infinity gives 0), in D.
#[must_use]
pub fn demand_d(distance_m: f64) -> f64 {
    if distance_m > 0.0 {
        1.0 / distance_m
    } else {
        f64::INFINITY
    }
}

/// The lens' steady response above its relaxed state, D.
///
/// `lag` is the share of the wanted response that is missing (0 exact, 0.1 typical of a young
/// eye); the result stays within 0 and `amplitude_d` for every distance, 1 mm included.
#[must_use]
pub fn steady_response_d(distance_m: f64, far_point_d: f64, amplitude_d: f64, lag: f64) -> f64 {
    ((demand_d(distance_m) - far_point_d) * (1.0 - lag)).clamp(0.0, amplitude_d)
}

/// Time constant of a step of the lens, s.
///
/// Focusing nearer takes `near_time_constant_s`. Relaxing from x has the initial velocity
/// 1.39 x + 1.12 D/s whatever the step, so the time constant is the step over that velocity; it is
/// kept within 0.1 and 0.6 s (a choice of this model), so that a tiny step is no jump.
#[must_use]
pub fn step_time_constant_s(from_d: f64, to_d: f64, near_time_constant_s: f64) -> f64 {
    if to_d >= from_d {
        near_time_constant_s
    } else {
        ((from_d - to_d) / (1.39 * from_d + 1.12)).clamp(0.1, 0.6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_response_is_the_demand_beyond_the_far_point_within_the_lens() {
        assert_eq!(steady_response_d(0.5, 0.0, 10.0, 0.0), 2.0);
        assert_eq!(steady_response_d(f64::INFINITY, 0.0, 10.0, 0.0), 0.0);
        // A myope of −3 D reads at 33 cm with a relaxed lens, and cannot relax below it.
        assert!(steady_response_d(1.0 / 3.0, 3.0, 10.0, 0.0).abs() < 1e-12);
        assert_eq!(steady_response_d(6.0, 3.0, 10.0, 0.0), 0.0);
        // A hyperope of +2 D accommodates even for the horizon.
        assert_eq!(steady_response_d(f64::INFINITY, -2.0, 10.0, 0.0), 2.0);
        assert_eq!(steady_response_d(0.001, 0.0, 0.5, 0.0), 0.5);
        assert!((steady_response_d(0.5, 0.0, 10.0, 0.1) - 1.8).abs() < 1e-12);
        for distance in [0.0, -1.0] {
            assert_eq!(steady_response_d(distance, 0.0, 4.0, 0.0), 4.0);
        }
    }

    #[test]
    fn relaxation_starts_at_the_published_velocity() {
        // From 3 D: 1.39·3 + 1.12 = 5.29 D/s for any step whose constant lies in the range.
        for step in [0.6, 1.0, 2.0, 3.0] {
            let lens = Approach::rest(3.0).turn_to(
                0.0,
                3.0 - step,
                step_time_constant_s(3.0, 3.0 - step, 0.25),
            );
            let velocity = (lens.at(0.0) - lens.at(1e-7)) / 1e-7;
            assert!((velocity - 5.29).abs() < 1e-4, "{velocity}");
        }
    }

    #[test]
    fn an_approach_reaches_63_percent_in_one_constant_and_never_jumps() {
        let lens = Approach::rest(0.0).turn_to(1.0, 2.0, 0.25);
        assert_eq!(lens.at(0.5), 0.0);
        let expected = 2.0 * (1.0 - (-1.0_f64).exp());
        assert!((lens.at(1.25) - expected).abs() < 1e-12);
        let back = lens.turn_to(1.25, 0.0, 0.4);
        assert!((back.at(1.25) - expected).abs() < 1e-12);
        assert_eq!(Approach::rest(1.0).turn_to(2.0, 3.0, 0.0).at(2.0), 3.0);
    }
}
