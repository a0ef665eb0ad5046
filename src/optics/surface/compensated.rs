//! Sums and products of f64 with their rounding errors kept, for the few places where a difference
//! of nearly equal numbers decides whether a ray hits.
//!
//! In: f64. Out: unevaluated sums `hi + lo` of about 106 bits. The error-free transformations are
//! Knuth's sum and Dekker's product with Veltkamp's splitting (Dekker 1971, Numer. Math. 18, 224);
//! the pair arithmetic is the textbook one, with a relative error of a few 2⁻¹⁰⁴. A fused
//! multiply–add would do in one operation what the splitting does in seventeen, but without a target
//! feature it is a call into a software library, slower than these.

use core::ops::{Add, Mul, Neg, Sub};

/// 2²⁷ + 1 splits 53 bits into 26 and 26.
const SPLITTER: f64 = 134_217_729.0;

/// An unevaluated sum `hi + lo` with `|lo|` at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    hi: f64,
    lo: f64,
}

/// `a + b`, exactly.
fn exact_sum(a: f64, b: f64) -> Pair {
    let hi = a + b;
    let b_share = hi - a;
    let lo = (a - (hi - b_share)) + (b - b_share);
    Pair { hi, lo }
}

/// `a + b`, exactly, where `|a| ≥ |b|`.
fn exact_sum_ordered(a: f64, b: f64) -> Pair {
    let hi = a + b;
    Pair {
        hi,
        lo: b - (hi - a),
    }
}

fn split(a: f64) -> (f64, f64) {
    let scaled = SPLITTER * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// `a · b`, exactly, as long as nothing overflows (above 1e292) or underflows.
pub(super) fn product(a: f64, b: f64) -> Pair {
    let hi = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let lo = ((a_high * b_high - hi) + a_high * b_low + a_low * b_high) + a_low * b_low;
    Pair { hi, lo }
}

impl Pair {
    /// The nearest f64.
    pub(super) fn value(self) -> f64 {
        self.hi + self.lo
    }
}

impl From<f64> for Pair {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Neg for Pair {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Add for Pair {
    type Output = Self;

    /// The careful sum: both tails are added with their errors, so that cancellation of the heads
    /// loses nothing.
    fn add(self, other: Self) -> Self {
        let heads = exact_sum(self.hi, other.hi);
        let tails = exact_sum(self.lo, other.lo);
        let once = exact_sum_ordered(heads.hi, heads.lo + tails.hi);
        exact_sum_ordered(once.hi, once.lo + tails.lo)
    }
}

impl Sub for Pair {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Pair {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let heads = product(self.hi, other.hi);
        exact_sum_ordered(
            heads.hi,
            heads.lo + (self.hi * other.lo + self.lo * other.hi),
        )
    }
}
