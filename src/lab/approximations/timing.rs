//! Time of a call.
//!
//! Enters: cases and what to do with one. Leaves: nanoseconds of a call: the smallest of [`ROUNDS`]
//! medians over [`SAMPLES`] samples, because whatever else the machine does can only lengthen it. A
//! sample is a batch of calls, long against the clock's resolution. One thread. At most [`WORKING_SET`]
//! cases are taken in turn, so that they stay in the second-level cache and the branch predictor does
//! not learn them by heart; calls are independent, so that a processor may overlap them as it does in a
//! loop over pixels.

use super::rows::ErrorRow;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Most cases that are timed in turn; of the two-point problem's 64 bytes they make 128 KB.
pub const WORKING_SET: usize = 2_000;
/// Times that a method is measured.
pub const ROUNDS: u32 = 3;
/// Samples of a round.
pub const SAMPLES: u32 = 11;

/// How long a round of a method warms up and measures.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    warm_up: Duration,
    measurement: Duration,
}

impl Stopwatch {
    /// A stopwatch that warms up and measures for so long a round.
    pub fn new(warm_up: Duration, measurement: Duration) -> Self {
        Self {
            warm_up,
            measurement,
        }
    }

    /// Nanoseconds of a call of `run` on each of the first [`WORKING_SET`] of `cases` in turn.
    pub fn ns_per_call<C, R>(&self, cases: &[C], mut run: impl FnMut(&C) -> R) -> f64 {
        let cases = &cases[..cases.len().min(WORKING_SET)];
        let mut order = cases.iter().cycle();
        let mut batch = |calls: u64| {
            let at = Instant::now();
            for case in order.by_ref().take(calls as usize) {
                black_box(run(black_box(case)));
            }
            at.elapsed()
        };
        let mut least = f64::INFINITY;
        for _ in 0..ROUNDS {
            let calls = self.warmed_up(&mut batch);
            let mut samples: Vec<f64> = (0..SAMPLES)
                .map(|_| batch(calls).as_secs_f64() * 1e9 / calls as f64)
                .collect();
            samples.sort_by(f64::total_cmp);
            least = least.min(samples[samples.len() / 2]);
        }
        least
    }

    /// Warms up; returns the calls of a sample, at least one, so that all samples last as long as asked.
    fn warmed_up(&self, batch: &mut impl FnMut(u64) -> Duration) -> u64 {
        let (mut calls, mut done, mut spent) = (1, 0, Duration::ZERO);
        while spent < self.warm_up || done == 0 {
            spent += batch(calls);
            done += calls;
            calls *= 2;
        }
        let seconds = (spent.as_secs_f64() / done as f64).max(1e-10);
        let sample = self.measurement.as_secs_f64() / f64::from(SAMPLES);
        (sample / seconds).ceil().clamp(1.0, 1e9) as u64
    }

    /// As [`Self::ns_per_call`] for a method that does many cases at once: nanoseconds of a case, where
    /// `run` does `cases` of them.
    pub fn ns_per_case(&self, cases: usize, mut run: impl FnMut()) -> f64 {
        self.ns_per_call(&[()], |()| run()) / cases.max(1) as f64
    }

    /// A method's row: its error on every case, its time on the first of them.
    pub fn row<C, R>(
        &self,
        (method, parameter, bytes): (&str, impl ToString, usize),
        cases: &[C],
        run: impl Fn(&C) -> R,
        error: impl Fn(&C, R) -> f64,
    ) -> ErrorRow {
        let errors = cases.iter().map(|case| error(case, run(case))).collect();
        let ns = self.ns_per_call(cases, run);
        ErrorRow::new(method, parameter, bytes, ns, errors)
    }
}
