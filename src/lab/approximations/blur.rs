//! The blur of a point: the simple angle and its form with spherical aberration, against real rays.

use super::rows::Task;
use super::timing::Stopwatch;
use crate::optics::defocus::{defocus_blur_angle, vergence_of_distance};
use crate::optics::reference::paraxial::{Meridian, paraxial};
use crate::optics::reference::traced_blur::{aberrated_blur_disc, traced_blur};
use crate::optics::reference::wavefront::{ObjectPoint, trace_wavefront};
use crate::optics::schematic_eye::{SODIUM_NM, SchematicEye};

struct Case<'a> {
    eye: &'a SchematicEye,
    pupil_mm: f64,
    distance_m: f64,
    /// Vergence of the point at the cornea and at the entrance pupil (D).
    at_cornea_d: f64,
    at_pupil_d: f64,
    /// Paraxial focus, counted from both, and the one of least RMS aberration (D).
    focus_at_cornea_d: f64,
    focus_d: f64,
    best_focus_d: f64,
    c40_um: f64,
    c60_um: f64,
    /// Diameter of the disc of the same RMS radius (rad).
    traced: f64,
}

fn cases<'a>(eyes: &'a [SchematicEye], pupils: u32, distances: u32) -> Vec<Case<'a>> {
    let mut out = Vec::new();
    for eye in eyes {
        let constants = paraxial(eye, Meridian::Vertical);
        for i in 0..pupils {
            let pupil_mm = 2.0 + 4.0 * f64::from(i) / f64::from(pupils - 1);
            let Ok(wave) = trace_wavefront(eye, pupil_mm, ObjectPoint::default()) else {
                continue;
            };
            for j in 0..distances {
                // Even in dioptres, from infinity to 10 cm.
                let distance_m = f64::from(distances - 1) / (10.0 * f64::from(j));
                let Some(blur) = traced_blur(eye, pupil_mm, distance_m) else {
                    continue;
                };
                let at_cornea = vergence_of_distance(distance_m);
                let depth_m = 1e-3 * constants.entrance_pupil.z_mm;
                out.push(Case {
                    eye,
                    pupil_mm,
                    distance_m,
                    at_cornea_d: at_cornea,
                    at_pupil_d: at_cornea / (1.0 + depth_m * at_cornea),
                    focus_at_cornea_d: -constants.refraction_d,
                    focus_d: -constants.refraction_at_entrance_pupil_d(),
                    best_focus_d: -wave.power_vector().m_d,
                    c40_um: wave.coefficients_um[12],
                    c60_um: wave.coefficients_um[24],
                    traced: blur.rms_disc_rad,
                });
            }
        }
    }
    out
}

/// Measures every form on a grid of pupils and distances, each this many.
pub fn measure(stopwatch: &Stopwatch, pupils: u32, distances: u32) -> Task {
    let eyes = [0.0, 2.0, 5.0].map(|d| SchematicEye::navarro(d, SODIUM_NM));
    let cases = cases(&eyes, pupils.max(2), distances.max(2));
    let arcmin = |angle: f64| angle.to_degrees() * 60.0;
    let error = |case: &Case, angle: f64| arcmin(angle - case.traced);
    let simple = "simple angle";
    let rows = vec![
        stopwatch.row(
            (simple, "from the cornea", 0),
            &cases,
            |c| defocus_blur_angle(1e-3 * c.pupil_mm, c.at_cornea_d, c.focus_at_cornea_d, 0.0),
            error,
        ),
        stopwatch.row(
            (simple, "from the pupil", 0),
            &cases,
            |c| defocus_blur_angle(1e-3 * c.pupil_mm, c.at_pupil_d, c.focus_d, 0.0),
            error,
        ),
        stopwatch.row(
            (simple, "from the best focus", 0),
            &cases,
            |c| defocus_blur_angle(1e-3 * c.pupil_mm, c.at_pupil_d, c.best_focus_d, 0.0),
            error,
        ),
        stopwatch.row(
            ("with spherical aberration", "c40 and c60", 0),
            &cases,
            |c| {
                aberrated_blur_disc(
                    0.5 * c.pupil_mm,
                    c.at_pupil_d - c.focus_d,
                    c.c40_um,
                    c.c60_um,
                )
            },
            error,
        ),
        stopwatch.row(
            ("traced", "48 rays", 0),
            &cases,
            |c| traced_blur(c.eye, c.pupil_mm, c.distance_m).map_or(f64::NAN, |b| b.rms_disc_rad),
            error,
        ),
    ];
    Task {
        name: "blur-disc".to_owned(),
        title: "The blur of a point".to_owned(),
        call: "diameter of the disc of the same RMS radius, one distance and pupil".to_owned(),
        domain: format!(
            "{} cases: Navarro's eye accommodated by 0, 2 and 5 D; pupils of 2 to 6 mm; points from 10 cm \
             to infinity, even in dioptres",
            cases.len()
        ),
        reference: "rays through 48 zones of the pupil".to_owned(),
        unit: "arcmin".to_owned(),
        rows,
    }
}
