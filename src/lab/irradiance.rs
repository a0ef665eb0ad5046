//! Error against time of the light on the iris: the table that the picture reads, by its size, and the
//! solver at every pixel.
//!
//! Enters: a stopwatch, a number of places. Leaves: a [`Task`] beside those of
//! [`super::approximations`], from which it stands apart because the table is the picture's.

use super::approximations::{ErrorRow, Stopwatch, Task};
use crate::appearance::images::MapView;
use crate::appearance::light_table::{IrisLight, LightTableSettings, LightTableSize, iris_light};
use crate::optics::caustic::caustic_irradiance_at;
use crate::optics::fermat::{FERMAT_STEPS, fermat_entry};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Corneal surface (R, p), index behind it, iris plane and limbus of the reference eye.
const SURFACE: DVec2 = DVec2::new(7.8, 0.75);
const INDEX: f64 = 1.336;
const IRIS_Z_MM: f64 = 3.6;
const LIMBUS_MM: f64 = 5.85;
/// Radius of the part of the iris that is compared.
const IRIS_MM: f64 = 5.5;
/// Where the lamp stands (degrees from the axis).
const LAMP_DEG: f64 = 40.0;

/// A place of the iris and its exact irradiance.
struct Place {
    at: DVec2,
    exact: f64,
}

/// Measures every size on `count` places.
pub fn measure(stopwatch: &Stopwatch, count: usize) -> Task {
    let (sin, cos) = LAMP_DEG.to_radians().sin_cos();
    let light = DVec3::new(sin, 0.0, -cos);
    let settings = LightTableSettings {
        surface: SURFACE,
        index: INDEX,
        iris_z: IRIS_Z_MM,
        root_mm: LIMBUS_MM + 0.2,
        limbus_mm: LIMBUS_MM,
    };
    let mut random = Pcg64::seed_from_u64(21);
    let places: Vec<Place> = (0..count)
        .map(|_| {
            let radius = IRIS_MM * random.random::<f64>().sqrt();
            let turn = random.random_range(0.0..core::f64::consts::TAU);
            let at = radius * DVec2::from_angle(turn);
            Place {
                at,
                exact: settings.exact(light, at).irradiance(LIMBUS_MM),
            }
        })
        .collect();
    let error = |place: &Place, found: f64| found - place.exact;
    let mut rows: Vec<ErrorRow> = Vec::new();
    for [along, obliquities] in [
        [8, 8],
        [16, 16],
        [32, 32],
        [56, 16],
        [56, 32],
        [56, 64],
        [96, 64],
    ] {
        let size = LightTableSize { along, obliquities };
        let table = MapView::new(&[settings.table(size)], false);
        let run =
            |place: &Place| iris_light(&table, light, place.at, settings.root_mm, LIMBUS_MM).w;
        let method = ("table", format!("{along}×{obliquities}"), size.bytes());
        rows.push(stopwatch.row(method, &places, run, error));
    }
    let solve = |place: &Place| {
        let point = place.at.extend(IRIS_Z_MM);
        let entry = fermat_entry(point, light, SURFACE, INDEX, FERMAT_STEPS).truncate();
        IrisLight {
            unbounded_irradiance: caustic_irradiance_at(entry, light, SURFACE, INDEX, IRIS_Z_MM),
            entry_radius_mm: entry.truncate().length(),
            ..IrisLight::default()
        }
        .irradiance(LIMBUS_MM)
    };
    rows.push(stopwatch.row(
        ("solved at every pixel", FERMAT_STEPS, 0),
        &places,
        solve,
        error,
    ));
    Task {
        name: "irradiance".to_owned(),
        title: "Light on the iris".to_owned(),
        call: "irradiance of one place by one lamp".to_owned(),
        domain: format!(
            "{count} seeded places within 5.5 mm of the axis; a distant lamp at {LAMP_DEG}°; cornea R 7.8 \
             mm, p 0.75, index 1.336; iris plane 3.6 mm deep; limbus 5.85 mm and soft"
        ),
        reference: "the solver with twice the steps and the caustic's Jacobian".to_owned(),
        unit: "of the lamp's".to_owned(),
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_table_gains_with_its_size_and_the_solver_is_exact() {
        let short = Duration::from_micros(300);
        let stopwatch = Stopwatch::new(short, short);
        let task = measure(&stopwatch, 1_000);
        let rms =
            |method: &str, parameter: &str| task.row(method, parameter).expect(parameter).err_rms;
        let sizes = ["8×8", "16×16", "32×32"].map(|size| rms("table", size));
        // Bilinear: a quarter of the error for twice the side, give or take the limbus.
        assert!(sizes.is_sorted_by(|a, b| *b < 0.5 * a), "{sizes:?}");
        // The reference goes on to the last digit.
        assert!(rms("solved at every pixel", "6") < 1e-9);
        assert!(task.rows.iter().all(|row| row.ns_per_call > 0.0));
    }
}
