//! Time of a call, by criterion.
//!
//! Enters: cases and what to do with one. Leaves: nanoseconds of a call, the median of criterion's
//! samples; the smallest of [`ROUNDS`] such medians, because whatever else the machine does can only
//! lengthen it. One thread. At most [`WORKING_SET`] cases are taken in turn, so that they stay in the
//! second-level cache and the branch predictor does not learn them by heart; calls are independent,
//! so that a processor may overlap them as it does in a loop over pixels.
//!
//! Criterion reports on stdout and stderr and cannot be told not to: whoever minds measures in a
//! process of its own (`lab::bench`).

use super::rows::ErrorRow;
use criterion::Criterion;
use serde::Deserialize;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Most cases that are timed in turn; of the two-point problem's 64 bytes they make 128 KB.
pub const WORKING_SET: usize = 2_000;
/// Times that a method is measured.
pub const ROUNDS: u32 = 3;
/// Samples of a measurement: criterion's least.
const SAMPLES: usize = 10;
/// Resamples for criterion's own confidence intervals: its least without a warning.
const RESAMPLES: usize = 1_001;

/// A time that criterion did not leave behind.
#[derive(Debug, thiserror::Error)]
#[error("criterion left no time in {path}: {reason}")]
pub struct TimingError {
    path: String,
    reason: String,
}

/// What is read back of criterion's `estimates.json`.
#[derive(Deserialize)]
struct Estimates {
    median: PointEstimate,
}

#[derive(Deserialize)]
struct PointEstimate {
    point_estimate: f64,
}

/// Criterion with a folder of its own, which goes with it.
pub struct Stopwatch {
    criterion: Criterion,
    folder: PathBuf,
    timed: u32,
}

impl Stopwatch {
    /// A stopwatch that warms up and measures for so long a round, and keeps criterion's files in
    /// `folder` (made when needed, removed in the end) meanwhile.
    pub fn new(folder: &Path, warm_up: Duration, measurement: Duration) -> Self {
        Self {
            criterion: Criterion::default()
                .without_plots()
                .with_output_color(false)
                .output_directory(folder)
                .sample_size(SAMPLES)
                .nresamples(RESAMPLES)
                .warm_up_time(warm_up)
                .measurement_time(measurement),
            folder: folder.to_owned(),
            timed: 0,
        }
    }

    /// Nanoseconds of a call of `run` on each of the first [`WORKING_SET`] of `cases` in turn; `name` is
    /// for criterion's report.
    pub fn ns_per_call<C, R>(
        &mut self,
        name: &str,
        cases: &[C],
        mut run: impl FnMut(&C) -> R,
    ) -> Result<f64, TimingError> {
        let cases = &cases[..cases.len().min(WORKING_SET)];
        let mut least = f64::INFINITY;
        for _ in 0..ROUNDS {
            least = least.min(self.round(name, cases, &mut run)?);
        }
        Ok(least)
    }

    /// Criterion's median.
    fn round<C, R>(
        &mut self,
        name: &str,
        cases: &[C],
        mut run: impl FnMut(&C) -> R,
    ) -> Result<f64, TimingError> {
        self.timed += 1;
        // Also the name of a folder.
        let plain: String = name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .take(50)
            .collect();
        let name = format!("{}-{plain}", self.timed);
        let mut next = 0;
        self.criterion.bench_function(&name, |bencher| {
            bencher.iter(|| {
                let case = &cases[next];
                next += 1;
                if next == cases.len() {
                    next = 0;
                }
                run(black_box(case))
            });
        });
        let path = self.folder.join(&name).join("new").join("estimates.json");
        let failed = |reason: String| TimingError {
            path: path.display().to_string(),
            reason,
        };
        let text = std::fs::read(&path).map_err(|error| failed(error.to_string()))?;
        let estimates: Estimates =
            serde_json::from_slice(&text).map_err(|error| failed(error.to_string()))?;
        Ok(estimates.median.point_estimate)
    }

    /// As [`Self::ns_per_call`] for a method that does many cases at once: nanoseconds of a case, where
    /// `run` does `cases` of them.
    pub fn ns_per_case(
        &mut self,
        name: &str,
        cases: usize,
        mut run: impl FnMut(),
    ) -> Result<f64, TimingError> {
        let ns = self.ns_per_call(name, &[()], |()| run())?;
        Ok(ns / cases.max(1) as f64)
    }

    /// A method's row: its error on every case, its time on the first of them.
    pub fn row<C, R>(
        &mut self,
        (method, parameter, bytes): (&str, impl ToString, usize),
        cases: &[C],
        run: impl Fn(&C) -> R,
        error: impl Fn(&C, R) -> f64,
    ) -> Result<ErrorRow, TimingError> {
        let errors = cases.iter().map(|case| error(case, run(case))).collect();
        let name = format!("{method} {}", parameter.to_string());
        let ns = self.ns_per_call(&name, cases, run)?;
        Ok(ErrorRow::new(method, parameter, bytes, ns, errors))
    }
}

impl Drop for Stopwatch {
    fn drop(&mut self) {
        // Of no use to anybody by now.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
