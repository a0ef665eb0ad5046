//! What was asked of the library, beside what a run found.

use super::rows::{ErrorRow, Task};
use super::two_point::{
    ALGORITHM_1, GROUPED, GROUPED_SLICE, LIGHT_TASK, POLISHED, RIM_TASK, SEARCH, SOLVER, TABLE,
    TASK, setting,
};
use crate::optics::fermat::FERMAT_STEPS;
use crate::optics::refraction_function::domain::RefractionEye;
use crate::optics::refraction_function::{RefractionFunction, RefractionSize};
use crate::tissue::iris_reflectance::IRIS_TABLE;
use crate::tissue::spectrum::Spectrum;
use serde::{Deserialize, Serialize};

/// One number that was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// What it is.
    pub name: String,
    /// What was found; `None` where it was not measured.
    pub found: Option<f64>,
    /// The limit.
    pub limit: f64,
    /// Whether the limit is the least that will do; otherwise it is the most.
    pub at_least: bool,
    /// Whether it was kept.
    pub met: bool,
}

impl Requirement {
    fn new(name: &str, found: Option<f64>, limit: f64, at_least: bool) -> Self {
        let met = found.is_some_and(|found| {
            if at_least {
                found >= limit
            } else {
                found <= limit
            }
        });
        Self {
            name: name.to_owned(),
            found,
            limit,
            at_least,
            met,
        }
    }
}

impl core::fmt::Display for Requirement {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let found = self
            .found
            .map_or_else(|| "not measured".to_owned(), |found| format!("{found:.3e}"));
        write!(
            f,
            "{}: {found} (asked: {} {:.3e}){}",
            self.name,
            if self.at_least { "at least" } else { "at most" },
            self.limit,
            if self.met { "" } else { " NOT MET" }
        )
    }
}

/// A table that the library's functions read at run time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableSize {
    /// What it holds.
    pub name: String,
    /// Its bytes.
    pub bytes: usize,
}

/// The tables of `optics` and `tissue` at the sizes that ship, the larger refraction function among
/// them. Without the pictures and Fourier grids that a caller makes.
pub fn tables_at_run_time() -> Vec<TableSize> {
    let table = |name: &str, bytes: usize| TableSize {
        name: name.to_owned(),
        bytes,
    };
    let function = |size| RefractionFunction::new(RefractionEye::default(), size).bytes();
    vec![
        table("refraction function", function(RefractionSize::LARGE)),
        table(
            "refraction function, small",
            function(RefractionSize::SMALL),
        ),
        // Observer and illuminant, and the weights that are made of them.
        table(
            "observer, illuminant and weights",
            7 * size_of::<Spectrum>(),
        ),
        table(
            "iris colours, half floats",
            2 * IRIS_TABLE[0] * IRIS_TABLE[1] * 8,
        ),
        table("tear film: wavelengths and weights", 64),
    ]
}

/// What issue 3 asks, by the rows of a run.
pub fn requirements(tasks: &[Task]) -> Vec<Requirement> {
    let find = |task: &str, method: &str, parameter: &str| -> Option<&ErrorRow> {
        tasks
            .iter()
            .find(|one| one.name == task)?
            .row(method, parameter)
    };
    let steps = FERMAT_STEPS.to_string();
    let paper = find(TASK, ALGORITHM_1, "20");
    let solver = find(TASK, SOLVER, &steps);
    let [small, large] = [RefractionSize::SMALL, RefractionSize::LARGE].map(setting);
    let table = |size: &str| find(TASK, TABLE, size);
    let lit_solver = find(LIGHT_TASK, SOLVER, &steps);
    let lit = |size: &str| find(LIGHT_TASK, GROUPED_SLICE, size);
    let grouped = |size: &str| find(TASK, GROUPED, size);
    let ratio = |above: Option<&ErrorRow>, below: Option<&ErrorRow>, of: fn(&ErrorRow) -> f64| {
        Some(of(above?) / of(below?).max(f64::MIN_POSITIVE))
    };
    let time: fn(&ErrorRow) -> f64 = |row| row.ns_per_call;
    let largest = |row: Option<&ErrorRow>| row.map(|row| row.err_max);
    let bytes = |row: Option<&ErrorRow>| row.map(|row| row.bytes as f64);
    let core: usize = tables_at_run_time().iter().map(|table| table.bytes).sum();
    let least = |name, found, limit| Requirement::new(name, found, limit, true);
    let most = |name, found, limit| Requirement::new(name, found, limit, false);
    vec![
        least(
            "solver: times faster than Algorithm 1",
            ratio(paper, solver, time),
            20.0,
        ),
        least(
            "solver: times smaller largest error than Algorithm 1",
            ratio(paper, solver, |row| row.err_max),
            100.0,
        ),
        least(
            "small refraction function, in groups: times faster than the solver",
            ratio(solver, grouped(&small), time),
            10.0,
        ),
        least(
            "large refraction function, in groups: times faster than the solver",
            ratio(solver, grouped(&large), time),
            10.0,
        ),
        least(
            "small refraction function, in groups of one light: times faster than the solver",
            ratio(lit_solver, lit(&small), time),
            10.0,
        ),
        least(
            "large refraction function, in groups of one light: times faster than the solver",
            ratio(lit_solver, lit(&large), time),
            10.0,
        ),
        most(
            "small refraction function: bytes",
            bytes(table(&small)),
            12e3,
        ),
        most(
            "small refraction function: largest error, mm",
            largest(table(&small)),
            0.02,
        ),
        most(
            "small refraction function, polished: largest error, mm",
            largest(find(TASK, POLISHED, &small)),
            1e-4,
        ),
        most(
            "large refraction function: bytes",
            bytes(table(&large)),
            300e3,
        ),
        most(
            "large refraction function: largest error, mm",
            largest(table(&large)),
            1e-3,
        ),
        most(
            "large refraction function, polished: largest error, mm",
            largest(find(TASK, POLISHED, &large)),
            1e-4,
        ),
        most("solver: largest error, mm", largest(solver), 1e-10),
        most(
            "solver: largest error at the rim, mm",
            largest(find(RIM_TASK, SOLVER, &steps)),
            1e-10,
        ),
        most(
            "solver with search: largest error at the rim, mm",
            largest(find(RIM_TASK, SEARCH, "all steps")),
            1e-10,
        ),
        most("tables of the core, bytes", Some(core as f64), 1e6),
    ]
}
