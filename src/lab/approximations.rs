//! Error against time: what the library approximates, by every method and setting, against an exact
//! reference in f64.
//!
//! Enters: an [`Effort`], a [`Stopwatch`]. Leaves: a [`Task`] for each thing that is approximated, its
//! rows as CSV ([`task_csv`], [`joint_csv`]), as a page ([`report`]) and as a plot ([`plot()`]), and
//! what was asked of the library beside what was found ([`requirements`]).
//!
//! Every reference is exact to rounding, or its own error is far below all that is compared with it,
//! and stands in [`Task::reference`]: light traced forward, quadratures, real rays, many nodes.
//! Times ([`timing`]) are of one thread, in one run, so that ratios hold on any machine.
//! Free of Bevy; the irradiance of the iris, which the picture reads from a table, is `lab::irradiance`.

mod blur;
mod colour;
mod glare;
mod imaging;
pub mod pareto;
mod plot;
mod published_table;
mod requirements;
mod rows;
mod scattering;
mod tear;
pub mod timing;
pub mod two_point;

pub use plot::plot;
pub use requirements::{Requirement, TableSize, requirements, tables_at_run_time};
pub use rows::{ErrorRow, Task, joint_csv, report, task_csv};
pub use timing::Stopwatch;

use std::time::Duration;
use two_point::Incidence;

/// How much work is put into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Random pairs of the two-point problem; a tenth of them at its rim.
    pub pairs: usize,
    /// Random cases of what is cheap.
    pub cases: usize,
    /// Random irises, each with a reference that takes milliseconds.
    pub irises: usize,
    /// Most random walks of an iris.
    pub walks: u32,
    /// Largest grid of the Fourier optics.
    pub grid: usize,
    /// Leaves out tables that take seconds to make.
    pub quick: bool,
    /// Warm-up of a round of a method.
    pub warm_up: Duration,
    /// Measurement of a round of a method.
    pub measurement: Duration,
}

impl Effort {
    /// Three quarters of a minute.
    pub const QUICK: Self = Self {
        pairs: 100_000,
        cases: 20_000,
        irises: 64,
        walks: 10_000,
        grid: 512,
        quick: true,
        warm_up: Duration::from_millis(10),
        measurement: Duration::from_millis(40),
    };
    /// A few minutes.
    pub const FULL: Self = Self {
        pairs: 1_000_000,
        cases: 200_000,
        irises: 256,
        walks: 100_000,
        grid: 1024,
        quick: false,
        warm_up: Duration::from_millis(50),
        measurement: Duration::from_millis(150),
    };

    /// A stopwatch of this effort.
    pub fn stopwatch(&self) -> Stopwatch {
        Stopwatch::new(self.warm_up, self.measurement)
    }
}

/// Measures every task.
pub fn measure(effort: &Effort, stopwatch: &Stopwatch) -> Vec<Task> {
    let tables = two_point::Tables::new(effort.quick);
    let domain = two_point::measure(stopwatch, &tables, Incidence::Domain, effort.pairs);
    let light = two_point::measure_light(stopwatch, &tables, effort.pairs / 10);
    let rim = two_point::measure(stopwatch, &tables, Incidence::Rim, effort.pairs / 10);
    let sizes: Vec<usize> = [64, 128, 256, 512, 1024]
        .into_iter()
        .filter(|&size| size <= effort.grid)
        .collect();
    vec![
        domain,
        light,
        rim,
        colour::wavelengths(stopwatch, effort.cases / 10),
        colour::table(stopwatch, effort.cases),
        scattering::reflectance(stopwatch, effort.irises, effort.walks),
        scattering::segment(stopwatch, effort.cases / 10),
        tear::measure(stopwatch, effort.cases),
        blur::measure(stopwatch, 9, 21),
        glare::energy(stopwatch, effort.cases / 100),
        glare::equations(stopwatch, effort.cases),
        imaging::grid(stopwatch, &sizes),
        imaging::rays(stopwatch),
    ]
}

#[cfg(test)]
mod tests;
