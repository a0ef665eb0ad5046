//! The two-point problem of François et al. 2007: the paper's Algorithm 1, our solver, and
//! precomputed refraction functions, the paper's and ours.

use super::published_table::PublishedTable;
use super::rows::{ErrorRow, Task};
use super::timing::{Stopwatch, WORKING_SET};
use crate::optics::conicoid::{conicoid_normal, conicoid_sag};
use crate::optics::fermat::{FERMAT_STEPS, FermatSource, fermat_solve, fermat_solve_surely};
use crate::optics::reference::descent::{DescentSettings, fermat_gradient_descent};
use crate::optics::refraction_function::domain::{EXIT_INCIDENCE_DEG, RefractionEye};
use crate::optics::refraction_function::polynomial::RefractionPolynomial;
use crate::optics::refraction_function::spline::Order;
use crate::optics::refraction_function::{RefractionFunction, RefractionSize, RefractionSlice};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::hint::black_box;

/// Name of the task on the refraction function's domain.
pub const TASK: &str = "two-point";
/// Name of the task with one light for many places.
pub const LIGHT_TASK: &str = "two-point-light";
/// Name of the task on what lies outside of it.
pub const RIM_TASK: &str = "two-point-rim";
/// The paper's own solver.
pub const ALGORITHM_1: &str = "Algorithm 1";
/// Ours.
pub const SOLVER: &str = "solver";
/// Ours with its search for what Newton's method misses.
pub const SEARCH: &str = "solver with search";
/// Our refraction function.
pub const TABLE: &str = "refraction function";
/// The same, many pairs by one call.
pub const GROUPED: &str = "in groups";
/// The same with a step of Newton's method.
pub const POLISHED: &str = "polished";
/// Our refraction function with the light fixed.
pub const SLICE: &str = "one light";
/// The same, many places by one call.
pub const GROUPED_SLICE: &str = "one light in groups";
/// The same with a step of Newton's method.
pub const POLISHED_SLICE: &str = "one light polished";
/// Our refraction function with the paper's kind of interpolation.
pub const LINEAR: &str = "linear";
/// The same coordinates with one polynomial in place of cells.
pub const POLYNOMIAL: &str = "polynomial";
/// The paper's refraction function.
pub const PUBLISHED: &str = "as published";

/// A place of the iris, a distant light, and the point of the cornea that joins them.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// On the iris plane (mm).
    pub place: DVec2,
    /// Unit direction towards the light.
    pub light: DVec3,
    /// `K` (mm).
    pub entry: DVec3,
}

/// The obliquities (degrees) of the lights of [`LIGHT_TASK`]; times are those of the first.
const LIGHTS_DEG: [f64; 6] = [45.0, 5.0, 20.0, 60.0, 75.0, 85.0];

/// Which exit incidences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Incidence {
    /// Up to the refraction function's limit.
    Domain,
    /// From there to grazing.
    Rim,
}

/// Seeded random pairs, traced forward by Snell's law from `K` to the iris, so that no solver decides
/// which pairs there are or where their `K` lies: `K` uniform over the limbus' disc, light uniform
/// over the directions of the hemisphere that meet the cornea there at these incidences, the place
/// within the limbus. Pairs behind a fold, whose light reaches the place by a shorter way too, are
/// left out; there are some at the rim only.
pub fn pairs(eye: &RefractionEye, incidence: Incidence, count: usize, seed: u64) -> Vec<Pair> {
    let mut random = Pcg64::seed_from_u64(seed);
    let limit = EXIT_INCIDENCE_DEG.to_radians().cos();
    let (least, most) = match incidence {
        Incidence::Domain => (limit, 1.0),
        Incidence::Rim => (0.0, limit),
    };
    let mut out = Vec::with_capacity(count);
    while out.len() < count {
        let radius = eye.limbus_mm * random.random::<f64>().sqrt();
        let turn = DVec2::from_angle(random.random_range(0.0..core::f64::consts::TAU));
        let k = radius * turn;
        let entry = k.extend(conicoid_sag(radius, eye.surface.x, eye.surface.y));
        let normal = conicoid_normal(entry, eye.surface.x, eye.surface.y);
        let cos = least + (most - least) * random.random::<f64>();
        let (s, c) = random.random_range(0.0..core::f64::consts::TAU).sin_cos();
        let side = normal.any_orthonormal_vector();
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let light = (cos * normal + sin * (c * side + s * normal.cross(side))).normalize();
        let landing = eye.land(k, light);
        let inside = light.z < 0.0
            && landing.ray_z > 0.03
            && landing.point.length() <= eye.limbus_mm
            && eye.stretch(k, light).is_finite();
        if inside {
            out.push(Pair {
                place: landing.point,
                light,
                entry,
            });
        }
    }
    out
}

/// The paper's descent with at most `planes` tangent planes.
fn algorithm_1(eye: &RefractionEye, pair: &Pair, planes: u32) -> DVec3 {
    let settings = DescentSettings {
        planes,
        ..DescentSettings::default()
    };
    let point = pair.place.extend(eye.iris_z_mm);
    let source = FermatSource::distant(pair.light);
    fermat_gradient_descent(point, &source, eye.surface, eye.index, settings).0
}

/// The tables that are compared, made once for both tasks.
pub struct Tables {
    eye: RefractionEye,
    ours: Vec<(String, RefractionFunction)>,
    linear: Vec<(String, RefractionFunction)>,
    polynomials: Vec<(String, RefractionPolynomial)>,
    published: Vec<(String, PublishedTable)>,
}

impl Tables {
    /// Computes all of them for François' eye; the paper's largest (3 MB, seconds) unless `quick`.
    pub fn new(quick: bool) -> Self {
        let eye = RefractionEye::default();
        let size = |grid: [usize; 3]| RefractionSize {
            grid,
            order: Order::Quadratic,
        };
        let sizes = [
            size([9, 5, 9]),
            size([13, 7, 12]),
            RefractionSize::SMALL,
            size([24, 13, 30]),
            MIDDLE,
            RefractionSize::LARGE,
            size([52, 32, 110]),
        ];
        let mut layouts = vec![(10, 100), (100, 250), (10, 2500)];
        if !quick {
            layouts.push((100, 2500));
        }
        Self {
            eye,
            ours: sizes
                .map(|size| (setting(size), RefractionFunction::new(eye, size)))
                .into(),
            linear: SIZES_OF_ALL
                .map(|size| RefractionSize {
                    order: Order::Linear,
                    ..size
                })
                .map(|size| (setting(size), RefractionFunction::new(eye, size)))
                .into(),
            polynomials: [[6, 4, 6], [9, 5, 9], [14, 8, 14]]
                .map(|size| {
                    let [t, b, w] = size;
                    (format!("{t}×{b}×{w}"), RefractionPolynomial::new(eye, size))
                })
                .into(),
            published: layouts
                .into_iter()
                .map(|(radii, directions)| {
                    let table = PublishedTable::new(&eye, radii, directions);
                    (format!("{radii}×{directions}"), table)
                })
                .collect(),
        }
    }
}

/// Between the two that ship.
const MIDDLE: RefractionSize = RefractionSize {
    grid: [32, 18, 50],
    order: Order::Quadratic,
};

/// Sizes at which every form of the refraction function is measured; the others tell how the error
/// falls.
const SIZES_OF_ALL: [RefractionSize; 3] = [RefractionSize::SMALL, MIDDLE, RefractionSize::LARGE];

/// The setting of a table of this size in [`Task::row`].
pub fn setting(size: RefractionSize) -> String {
    let [t, b, w] = size.grid;
    format!("{t}×{b}×{w}")
}

/// Measures every method on `count` pairs.
pub fn measure(stopwatch: &Stopwatch, tables: &Tables, incidence: Incidence, count: usize) -> Task {
    let eye = &tables.eye;
    let pairs = pairs(eye, incidence, count, 11);
    let error = |pair: &Pair, entry: DVec3| entry.distance(pair.entry);
    let lifted = |pair: &Pair, k: DVec2| {
        let sag = conicoid_sag(k.length(), eye.surface.x, eye.surface.y);
        error(pair, k.extend(sag))
    };
    let mut rows: Vec<ErrorRow> = Vec::new();
    for planes in [2, 5, 20] {
        let run = |pair: &Pair| algorithm_1(eye, pair, planes);
        rows.push(stopwatch.row((ALGORITHM_1, planes, 0), &pairs, run, error));
    }
    for steps in 0..=FERMAT_STEPS {
        let run = |pair: &Pair| {
            let point = pair.place.extend(eye.iris_z_mm);
            fermat_solve(point, pair.light, eye.surface, eye.index, steps, 1e-26).entry
        };
        rows.push(stopwatch.row((SOLVER, steps, 0), &pairs, run, error));
    }
    let run = |pair: &Pair| {
        let point = pair.place.extend(eye.iris_z_mm);
        let source = FermatSource::distant(pair.light);
        fermat_solve_surely(point, &source, eye.surface, eye.index)
            .map_or(DVec3::NAN, |found| found.entry)
    };
    rows.push(stopwatch.row((SEARCH, "all steps", 0), &pairs, run, error));
    for (name, table) in &tables.published {
        let run = |pair: &Pair| table.entry(pair.place, pair.light);
        rows.push(stopwatch.row((PUBLISHED, name, table.bytes()), &pairs, run, error));
    }
    // The rim is outside of the tables' domain: how their error falls is of no account there.
    let among =
        |name: &String, sizes: &[RefractionSize]| sizes.iter().any(|size| setting(*size) == *name);
    let ships = [RefractionSize::SMALL, RefractionSize::LARGE];
    let every = |name: &String| incidence == Incidence::Domain || among(name, &ships);
    let some = |name: &String| every(name) && among(name, &SIZES_OF_ALL);
    for (name, table) in tables.ours.iter().filter(|(name, _)| every(name)) {
        let run = |pair: &Pair| table.entry(pair.place, pair.light);
        rows.push(stopwatch.row((TABLE, name, table.bytes()), &pairs, run, lifted));
    }
    let asked: Vec<(DVec2, DVec3)> = pairs.iter().map(|pair| (pair.place, pair.light)).collect();
    let mut found = vec![DVec2::ZERO; pairs.len()];
    for (name, table) in tables.ours.iter().filter(|(name, _)| some(name)) {
        table.entries(&asked, &mut found);
        let errors = pairs.iter().zip(&found).map(|(pair, k)| lifted(pair, *k));
        let errors = errors.collect();
        let few = &asked[..asked.len().min(WORKING_SET)];
        let ns = stopwatch.ns_per_case(few.len(), || {
            table.entries(black_box(few), &mut found);
            black_box(&mut found);
        });
        rows.push(ErrorRow::new(GROUPED, name, table.bytes(), ns, errors));
    }
    for (name, table) in tables.linear.iter().filter(|(name, _)| some(name)) {
        let run = |pair: &Pair| table.entry(pair.place, pair.light);
        rows.push(stopwatch.row((LINEAR, name, table.bytes()), &pairs, run, lifted));
    }
    for (name, polynomial) in &tables.polynomials {
        let run = |pair: &Pair| polynomial.entry(pair.place, pair.light);
        rows.push(stopwatch.row((POLYNOMIAL, name, polynomial.bytes()), &pairs, run, lifted));
    }
    for (name, table) in tables.ours.iter().filter(|(name, _)| every(name)) {
        let run = |pair: &Pair| table.polished_entry(pair.place, pair.light);
        rows.push(stopwatch.row((POLISHED, name, table.bytes()), &pairs, run, lifted));
    }
    let (name, title, range) = match incidence {
        Incidence::Domain => (TASK, "The two-point problem", "up to 80°"),
        Incidence::Rim => (
            RIM_TASK,
            "The two-point problem at the rim",
            "80 to 90° and in front of any fold",
        ),
    };
    Task {
        name: name.to_owned(),
        title: title.to_owned(),
        call: "K for one place of the iris and one distant light".to_owned(),
        domain: format!(
            "{count} seeded random pairs: cornea R 7.8 mm, p 0.75, index 1.336; iris plane 3.6 mm deep; \
             P and K within the limbus (5.85 mm); lights of the hemisphere; exit incidence {range}; \
             K uniform over the limbus"
        ),
        reference: "Snell's law traced forward from K (distance at K in space)".to_owned(),
        unit: "mm".to_owned(),
        rows,
    }
}

/// A pair of one of several lights.
struct Lit {
    pair: Pair,
    light: usize,
}

/// Pairs of the domain for the lights of [`LIGHTS_DEG`], `count` of each, one light after another.
fn lit(eye: &RefractionEye, count: usize) -> Vec<Lit> {
    let mut random = Pcg64::seed_from_u64(22);
    let mut out = Vec::with_capacity(count * LIGHTS_DEG.len());
    for (index, degrees) in LIGHTS_DEG.into_iter().enumerate() {
        let light = light_at(degrees);
        let whole = out.len() + count;
        while out.len() < whole {
            let radius = eye.limbus_mm * random.random::<f64>().sqrt();
            let turn = random.random_range(0.0..core::f64::consts::TAU);
            let k = radius * DVec2::from_angle(turn);
            let landing = eye.land(k, light);
            if eye.is_in_domain(k, light) && landing.point.length() <= eye.limbus_mm {
                let pair = Pair {
                    place: landing.point,
                    light,
                    entry: k.extend(conicoid_sag(radius, eye.surface.x, eye.surface.y)),
                };
                out.push(Lit { pair, light: index });
            }
        }
    }
    out
}

/// A light at this obliquity, in a direction that no grid prefers.
fn light_at(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (y, x) = 0.7_f64.sin_cos();
    DVec3::new(x * sin, y * sin, -cos)
}

/// Measures what many places of one light cost: the refraction function with the light fixed, beside
/// the function itself and the solver; `count` places a light.
pub fn measure_light(stopwatch: &Stopwatch, tables: &Tables, count: usize) -> Task {
    let eye = &tables.eye;
    let cases = lit(eye, count);
    let places: Vec<DVec2> = cases.iter().map(|case| case.pair.place).collect();
    let error = |case: &Lit, entry: DVec3| entry.distance(case.pair.entry);
    let lifted = |case: &Lit, k: DVec2| {
        let sag = conicoid_sag(k.length(), eye.surface.x, eye.surface.y);
        error(case, k.extend(sag))
    };
    let sizes = SIZES_OF_ALL.map(setting);
    let ours = || tables.ours.iter().filter(|(name, _)| sizes.contains(name));
    let mut rows: Vec<ErrorRow> = Vec::new();
    for steps in [2, 3, FERMAT_STEPS] {
        let run = |case: &Lit| {
            let (point, light) = (case.pair.place.extend(eye.iris_z_mm), case.pair.light);
            fermat_solve(point, light, eye.surface, eye.index, steps, 1e-26).entry
        };
        rows.push(stopwatch.row((SOLVER, steps, 0), &cases, run, error));
    }
    for (name, table) in ours() {
        let run = |case: &Lit| table.entry(case.pair.place, case.pair.light);
        rows.push(stopwatch.row((TABLE, name, table.bytes()), &cases, run, lifted));
    }
    for (name, table) in ours() {
        let slices: Vec<RefractionSlice> = LIGHTS_DEG
            .iter()
            .map(|degrees| table.towards(light_at(*degrees)))
            .collect();
        let bytes = size_of_val(slices[0].values()) + size_of_val(slices[0].frame());
        let run = |case: &Lit| slices[case.light].entry(case.pair.place);
        rows.push(stopwatch.row((SLICE, name, bytes), &cases, run, lifted));
        let mut entries = vec![DVec2::ZERO; count];
        let mut errors = Vec::with_capacity(cases.len());
        for (light, slice) in slices.iter().enumerate() {
            slice.entries(&places[light * count..][..count], &mut entries);
            let pairs = &cases[light * count..][..count];
            errors.extend(pairs.iter().zip(&entries).map(|(case, k)| lifted(case, *k)));
        }
        let few = &places[..count.min(WORKING_SET)];
        let ns = stopwatch.ns_per_case(few.len(), || {
            slices[0].entries(black_box(few), &mut entries);
            black_box(&mut entries);
        });
        rows.push(ErrorRow::new(GROUPED_SLICE, name, bytes, ns, errors));
        let run = |case: &Lit| {
            let k = slices[case.light].entry(case.pair.place);
            table.polish(k, case.pair.place, case.pair.light)
        };
        rows.push(stopwatch.row((POLISHED_SLICE, name, bytes), &cases, run, lifted));
    }
    Task {
        name: LIGHT_TASK.to_owned(),
        title: "The two-point problem for one light".to_owned(),
        call: "K for one of many places with the same distant light; fixing the light is not in it"
            .to_owned(),
        domain: format!(
            "{count} seeded places of each of {} lights, 5 to 85° from the axis; the rest as in {TASK}; \
             times at 45°",
            LIGHTS_DEG.len()
        ),
        reference: "Snell's law traced forward from K (distance at K in space)".to_owned(),
        unit: "mm".to_owned(),
        rows,
    }
}
