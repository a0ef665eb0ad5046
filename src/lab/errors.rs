//! Error against time of what the picture approximates, for `ocularium bench`.
//!
//! Leaves: rows of method, size, time of a call and error against an exact f64 reference, and a
//! log–log plot of them. One thread; the time is the best of several rounds, because whatever else
//! the machine does can only lengthen it.

use crate::appearance::light_table::{LAMPS, LightTableSettings, look_up};
use crate::optics::caustic::caustic_irradiance_at;
use crate::optics::fermat::descent::{DescentSettings, fermat_gradient_descent};
use crate::optics::fermat::{FERMAT_STEPS, FermatSource, fermat_entry, fermat_solve};
use glam::{DVec2, DVec3};
use plotters::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Corneal surface (R, p), index behind it, iris plane and limbus of the reference eye.
const SURFACE: DVec2 = DVec2::new(7.8, 0.75);
const INDEX: f64 = 1.336;
const IRIS_Z_MM: f64 = 3.6;
const LIMBUS_MM: f64 = 5.85;
/// Rounds of which the fastest counts.
const ROUNDS: usize = 5;

/// One method at one setting.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorRow {
    /// What is approximated.
    pub task: &'static str,
    /// How.
    pub method: &'static str,
    /// Its setting: steps, gradients or texels along a side.
    pub parameter: u32,
    /// Bytes of tables.
    pub bytes: usize,
    /// Nanoseconds of a call.
    pub ns_per_call: f64,
    /// Largest error.
    pub err_max: f64,
    /// The error that 999 of 1000 calls do not exceed.
    pub err_p999: f64,
    /// Root mean square error.
    pub err_rms: f64,
    /// Unit of the errors.
    pub unit: &'static str,
}

/// A place of the iris and a direction towards a light, whose light enters inside the limbus.
struct Pair {
    point: DVec3,
    light: DVec3,
    entry: DVec3,
}

fn pairs(count: usize) -> Vec<Pair> {
    let mut random = Pcg64::seed_from_u64(11);
    let mut out = Vec::with_capacity(count);
    while out.len() < count {
        let (r, turn) = (
            5.5 * f64::sqrt(random.random()),
            random.random_range(0.0..std::f64::consts::TAU),
        );
        let angle: f64 = random.random_range(0.0..60f64.to_radians());
        let point = DVec3::new(r * turn.cos(), r * turn.sin(), IRIS_Z_MM);
        let light = DVec3::new(angle.sin(), 0.0, -angle.cos());
        let exact = fermat_solve(point, light, SURFACE, INDEX, 40, 1e-30);
        if exact.faces_light && exact.entry.truncate().length() < LIMBUS_MM {
            out.push(Pair {
                point,
                light,
                entry: exact.entry,
            });
        }
    }
    out
}

fn row(
    task: &'static str,
    method: &'static str,
    (parameter, bytes): (u32, usize),
    unit: &'static str,
    ns_per_call: f64,
    mut errors: Vec<f64>,
) -> ErrorRow {
    errors.sort_by(f64::total_cmp);
    let last = errors.len() - 1;
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    ErrorRow {
        task,
        method,
        parameter,
        bytes,
        ns_per_call,
        err_max: errors[last],
        err_p999: errors[last * 999 / 1000],
        err_rms: (squares / errors.len() as f64).sqrt(),
        unit,
    }
}

/// Nanoseconds of a call of `run` on each of `items`.
fn time<T, R>(items: &[T], mut run: impl FnMut(&T) -> R) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let at = Instant::now();
            for item in items {
                black_box(run(black_box(item)));
            }
            at.elapsed().as_secs_f64() * 1e9 / items.len() as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// The two-point problem: the paper's descent against Newton's method, in mm at the cornea.
fn two_point(pairs: &[Pair]) -> Vec<ErrorRow> {
    const TASK: &str = "two-point problem";
    let mut rows = Vec::new();
    for planes in [2, 5, 20] {
        let settings = DescentSettings {
            planes,
            ..DescentSettings::default()
        };
        let run = |pair: &Pair| {
            fermat_gradient_descent(
                pair.point,
                &FermatSource::distant(pair.light),
                SURFACE,
                INDEX,
                settings,
            )
            .0
        };
        let errors = pairs
            .iter()
            .map(|pair| run(pair).distance(pair.entry))
            .collect();
        rows.push(row(
            TASK,
            "Algorithm 1",
            (planes, 0),
            "mm",
            time(pairs, run),
            errors,
        ));
    }
    for steps in [1, 2, 3, FERMAT_STEPS] {
        let run =
            |pair: &Pair| fermat_entry(pair.point, pair.light, SURFACE, INDEX, steps).truncate();
        let errors = pairs
            .iter()
            .map(|pair| run(pair).distance(pair.entry))
            .collect();
        rows.push(row(
            TASK,
            "Newton",
            (steps, 0),
            "mm",
            time(pairs, run),
            errors,
        ));
    }
    rows
}

/// Irradiance of the iris: the solver against look-ups in tables of several sizes.
fn irradiance(pairs: &[Pair]) -> Vec<ErrorRow> {
    const TASK: &str = "irradiance of the iris";
    let light = DVec3::new(40f64.to_radians().sin(), 0.0, -(40f64.to_radians().cos()));
    let settings = LightTableSettings {
        surface: SURFACE,
        index: INDEX,
        iris_z: IRIS_Z_MM,
        root_mm: LIMBUS_MM + 0.2,
        limbus_mm: LIMBUS_MM,
        lamps: [light; LAMPS],
    };
    let places: Vec<DVec2> = pairs.iter().map(|pair| pair.point.truncate()).collect();
    let exact: Vec<f64> = places
        .iter()
        .map(|&place| settings.exact(0, place).irradiance(LIMBUS_MM))
        .collect();
    let error = |found: Vec<f64>| -> Vec<f64> {
        found
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a - b).abs())
            .collect()
    };
    let mut rows = Vec::new();
    for side in [8usize, 16, 32, 40, 64, 128] {
        let texels = settings.texels_of(side);
        let run = |place: &DVec2| look_up(&texels, &settings, 0, *place).irradiance(LIMBUS_MM);
        let found = places.iter().map(run).collect();
        // Half floats on the GPU.
        let bytes = side * side * LAMPS * 8;
        rows.push(row(
            TASK,
            "table",
            (side as u32, bytes),
            "of the lamp's",
            time(&places, run),
            error(found),
        ));
    }
    let run = |place: &DVec2| {
        let point = place.extend(IRIS_Z_MM);
        let entry = fermat_entry(point, light, SURFACE, INDEX, FERMAT_STEPS).truncate();
        caustic_irradiance_at(entry, light, SURFACE, INDEX, IRIS_Z_MM)
    };
    let found = places.iter().map(|place| {
        let entry = fermat_entry(place.extend(IRIS_Z_MM), light, SURFACE, INDEX, FERMAT_STEPS);
        crate::appearance::light_table::IrisLight {
            unbounded_irradiance: run(place),
            entry_radius_mm: entry.truncate().truncate().length(),
            ..Default::default()
        }
        .irradiance(LIMBUS_MM)
    });
    let errors = error(found.collect());
    rows.push(row(
        TASK,
        "solved at every pixel",
        (FERMAT_STEPS, 0),
        "of the lamp's",
        time(&places, run),
        errors,
    ));
    rows
}

/// Measures every approximation on `count` random pairs.
pub fn measure(count: usize) -> Vec<ErrorRow> {
    let pairs = pairs(count);
    let mut rows = two_point(&pairs);
    rows.extend(irradiance(&pairs));
    rows
}

/// The rows as CSV.
pub fn csv(rows: &[ErrorRow]) -> String {
    let mut text =
        String::from("task,method,parameter,bytes,ns_per_call,err_max,err_p999,err_rms,unit\n");
    for r in rows {
        text += &format!(
            "{},{},{},{},{:.1},{:.3e},{:.3e},{:.3e},{}\n",
            r.task,
            r.method,
            r.parameter,
            r.bytes,
            r.ns_per_call,
            r.err_max,
            r.err_p999,
            r.err_rms,
            r.unit
        );
    }
    text
}

/// Log–log plot of root mean square error against time.
pub fn plot(rows: &[ErrorRow]) -> Result<String, Box<dyn std::error::Error>> {
    // What is exact to rounding is drawn at this floor.
    const FLOOR: f64 = 1e-12;
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (760, 420)).into_drawing_area();
        area.fill(&WHITE)?;
        let times = rows.iter().map(|row| row.ns_per_call);
        let (low, high) = times.fold((f64::INFINITY, 0.0f64), |(a, b), t| (a.min(t), b.max(t)));
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .x_label_area_size(38)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (low * 0.5..high * 4.0).log_scale(),
                (FLOOR * 0.5..1.0).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("nanoseconds a call, one thread")
            .y_desc("root mean square error (mm, or share of the lamp)")
            .draw()?;
        for (index, row) in rows.iter().enumerate() {
            let color = Palette99::pick(if row.task.starts_with("two") { 0 } else { 2 }).to_rgba();
            let place = (row.ns_per_call, row.err_rms.max(FLOOR));
            chart.draw_series([Circle::new(place, 4, color.filled())])?;
            let label = format!("{} {}", row.method, row.parameter);
            let lifted = (
                place.0 * 1.12,
                place.1 * if index % 2 == 0 { 1.5 } else { 0.6 },
            );
            chart.draw_series([Text::new(label, lifted, ("sans-serif", 12).into_font())])?;
        }
        area.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newton_beats_the_descent_and_tables_gain_with_size() {
        let rows = measure(400);
        let find = |method: &str, parameter: u32| {
            rows.iter()
                .find(|row| row.method == method && row.parameter == parameter)
                .expect(method)
        };
        // The paper's descent stops at its step length; Newton goes on to rounding.
        assert!(find("Newton", FERMAT_STEPS).err_rms < 1e-3 * find("Algorithm 1", 20).err_rms);
        // Bilinear: a quarter of the error for twice the side, give or take the limbus.
        assert!(find("table", 64).err_rms < 0.5 * find("table", 32).err_rms);
        assert!(
            rows.iter()
                .all(|row| row.err_max.is_finite() && row.ns_per_call > 0.0)
        );
        assert_eq!(csv(&rows).lines().count(), rows.len() + 1);
    }
}
