//! The blur of a point by real rays through Navarro's eye, beside the simple formula
//! ([`crate::optics::reference::traced_blur`]).
//!
//! Leaves: one row a distance, pupil and accommodation, blurs in minutes of arc.

use super::{NullReasons, known};
use crate::optics::defocus::vergence_of_distance;
use crate::optics::reference::paraxial::{Meridian, paraxial};
use crate::optics::reference::traced_blur::{BlurRow, aberrated_blur_disc, blur_table};
use crate::optics::reference::wavefront::{ObjectPoint, trace_wavefront};
use crate::optics::schematic_eye::{SODIUM_NM, SchematicEye};
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "Navarro, Santamaría & Bescós 1985, J. Opt. Soc. Am. A 2, 1273 (the eye, at 589.3 nm)",
    "Demers 2004 and Nießner et al. 2013 (the circle of confusion; as an angle, A |1/D - 1/P|)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "Angles are visual angles. distance_m counts from the cornea; pupil_diameter_mm is that of the \
     entrance pupil; accommodation_d is what is asked of the eye.",
    "traced_extent_arcmin: smallest circle about the chief ray that holds every ray. \
     traced_rms_disc_arcmin: uniform disc of the same RMS radius (for pure defocus, the same).",
    "simple_arcmin: pupil times |1/D - 1/P| at the entrance pupil, P the paraxial focus. \
     simple_at_cornea_arcmin: the same with distances from the cornea. simple_best_focus_arcmin: P \
     where the wavefront has the least RMS over this pupil.",
    "spherical_aberration_arcmin: the closed form with the eye's Zernike coefficients c40 and c60.",
    "ratio: traced_rms_disc over simple.",
];

const DISTANCES_M: [f64; 9] = [0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 20.0, f64::INFINITY];
const PUPILS_MM: [f64; 7] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
const ACCOMMODATIONS_D: [f64; 4] = [0.0, 2.0, 5.0, 8.0];

/// Blur of one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlurDiscRow {
    /// Accommodation asked of the eye (D).
    pub accommodation_d: f64,
    /// Diameter of the entrance pupil (mm).
    pub pupil_diameter_mm: f64,
    /// Distance of the point from the cornea (m).
    pub distance_m: Option<f64>,
    /// Its reciprocal (D).
    pub vergence_d: f64,
    /// Diameter of the smallest circle that holds every ray (arcmin).
    pub traced_extent_arcmin: Option<f64>,
    /// Diameter of the disc of the same RMS radius (arcmin).
    pub traced_rms_disc_arcmin: Option<f64>,
    /// The simple formula at the entrance pupil (arcmin).
    pub simple_arcmin: Option<f64>,
    /// The simple formula at the cornea (arcmin).
    pub simple_at_cornea_arcmin: Option<f64>,
    /// The simple formula about the focus of least RMS aberration (arcmin).
    pub simple_best_focus_arcmin: Option<f64>,
    /// The closed form with spherical aberration (arcmin).
    pub spherical_aberration_arcmin: Option<f64>,
    /// Traced over simple, by RMS width.
    pub ratio: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// Minutes of arc of an angle in radians.
fn arcmin(angle_rad: f64) -> f64 {
    angle_rad.to_degrees() * 60.0
}

/// All combinations.
pub fn rows() -> Vec<BlurDiscRow> {
    let mut rows = Vec::new();
    for accommodation_d in ACCOMMODATIONS_D {
        let eye = SchematicEye::navarro(accommodation_d, SODIUM_NM);
        let constants = paraxial(&eye, Meridian::Vertical);
        let (pupil_z_mm, focus_d) = (
            constants.entrance_pupil.z_mm,
            -constants.refraction_at_entrance_pupil_d(),
        );
        for pupil_mm in PUPILS_MM {
            let wave = trace_wavefront(&eye, pupil_mm, ObjectPoint::default()).ok();
            // c40 and c60 by the OSA's single index.
            let aberrations = wave.map(|wave| [12, 24].map(|j: usize| wave.coefficients_um[j]));
            let closed_form = |distance_m: f64| {
                let [c40, c60] = aberrations?;
                let at_cornea_d = vergence_of_distance(distance_m);
                let at_pupil_d = at_cornea_d / (1.0 + 1e-3 * pupil_z_mm * at_cornea_d);
                let defocus_d = at_pupil_d - focus_d;
                Some(arcmin(aberrated_blur_disc(
                    0.5 * pupil_mm,
                    defocus_d,
                    c40,
                    c60,
                )))
            };
            let found = blur_table(&DISTANCES_M, &[pupil_mm], &[accommodation_d]);
            rows.extend(found.iter().map(|of| row(of, closed_form(of.distance_m))));
        }
    }
    rows
}

fn row(of: &BlurRow, closed_form_arcmin: Option<f64>) -> BlurDiscRow {
    let mut null_reasons = NullReasons::new();
    let distance = of.distance_m;
    let distance_m = known(
        &mut null_reasons,
        "distance_m",
        Some(distance),
        "infinitely far",
    );
    let ratio = known(
        &mut null_reasons,
        "ratio",
        of.ratio(),
        "there is less than a quarter of an arc minute of simple blur, or no trace",
    );
    let mut traced = |key, angle: Option<f64>| {
        let reason = "rays of this pupil do not reach the retina";
        known(&mut null_reasons, key, angle.map(arcmin), reason)
    };
    BlurDiscRow {
        accommodation_d: of.accommodation_d,
        pupil_diameter_mm: of.pupil_diameter_mm,
        distance_m,
        vergence_d: vergence_of_distance(distance),
        traced_extent_arcmin: traced("traced_extent_arcmin", of.blur.map(|b| b.extent_rad)),
        traced_rms_disc_arcmin: traced("traced_rms_disc_arcmin", of.blur.map(|b| b.rms_disc_rad)),
        simple_arcmin: traced("simple_arcmin", of.blur.map(|b| b.simple_rad)),
        simple_at_cornea_arcmin: traced(
            "simple_at_cornea_arcmin",
            of.blur.map(|b| b.simple_at_cornea_rad),
        ),
        simple_best_focus_arcmin: traced(
            "simple_best_focus_arcmin",
            of.blur.map(|b| b.simple_best_focus_rad),
        ),
        spherical_aberration_arcmin: known(
            &mut null_reasons,
            "spherical_aberration_arcmin",
            closed_form_arcmin,
            "the wavefront of this pupil cannot be traced",
        ),
        ratio,
        null_reasons,
    }
}
