//! Modulation transfer of the eye's optics: the mean of living eyes, the diffraction limit, and a
//! schematic eye by its traced wavefront.
//!
//! Leaves: one row a pupil and frequency.

use super::{NullReasons, known};
use crate::optics::reference::mean_mtf::{MEAN_MTF_PUPIL_RANGE_MM, diffraction_mtf, mean_mtf};
use crate::optics::reference::psf::{Mtf, PsfError, PsfGrid, PupilFunction};
use crate::optics::reference::wavefront::{ObjectPoint, trace_wavefront};
use crate::optics::schematic_eye::{GREEN_NM, SchematicEye};
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "Watson 2013, J. Vision 13(6):18 (mean_mtf: best-corrected eyes, white light, radial mean)",
    "Born & Wolf, Principles of Optics, section 9.5 (diffraction_mtf)",
    "Escudero-Sanz & Navarro 1999, J. Opt. Soc. Am. A 16, 1881 (traced_mtf: on the axis, 543 nm)",
    "Goodman, Introduction to Fourier Optics, chapter 6 (from the wavefront to the transfer)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "pupil_diameter_mm is that of the entrance pupil. Modulations run from 0 to 1.",
    "mean_mtf holds for pupils of 2 to 6 mm. It is of white light at its best correction, and \
     leaves out scatter (see the table glare).",
    "diffraction_mtf and traced_mtf are at 543 nm. traced_mtf is the transfer of the eye as \
     published; traced_best_focus_mtf with its defocus (Zernike c20) corrected, which leaves the \
     least RMS of the wavefront; both without the Stiles-Crawford effect. The pupil's pixels cost \
     4e-4 at most.",
];

const FREQUENCIES_CPD: [f64; 13] = [
    0.0, 1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0,
];
/// Pixels a side of the grid of visual angle.
const SIZE: usize = 1024;
/// Its width (arcmin) is a multiple of this, so that it has a sample at every half cycle a degree and
/// nothing is interpolated.
const HALF_CYCLE_ARCMIN: f64 = 120.0;
/// c20, by the OSA's single index.
const DEFOCUS: usize = 4;

/// Modulation at one pupil and frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MtfRow {
    /// Diameter of the entrance pupil (mm).
    pub pupil_diameter_mm: f64,
    /// Spatial frequency (cycles/degree).
    pub frequency_cpd: f64,
    /// Mean of living eyes.
    pub mean_mtf: Option<f64>,
    /// A perfect eye.
    pub diffraction_mtf: f64,
    /// The schematic eye as it is.
    pub traced_mtf: Option<f64>,
    /// The schematic eye with its defocus corrected.
    pub traced_best_focus_mtf: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// Pixel (arcmin) of the widest such grid that still holds all of the transfer, with two pixels and
/// more to λ/D: the wider, the finer it samples the pupil.
fn pixel_arcmin(pupil_mm: f64) -> f64 {
    let widest = 60.0 * (0.5e-6 * GREEN_NM / pupil_mm).to_degrees();
    let narrowest = HALF_CYCLE_ARCMIN / SIZE as f64;
    narrowest * (widest / narrowest).floor().max(1.0)
}

/// The traced eye's transfer at one pupil, as it is and with its defocus corrected.
fn traced(pupil_mm: f64) -> Option<[Result<Mtf, PsfError>; 2]> {
    let eye = SchematicEye::escudero_navarro(GREEN_NM);
    let wave = trace_wavefront(&eye, pupil_mm, ObjectPoint::default()).ok()?;
    let mut corrected = wave.coefficients_um;
    corrected[DEFOCUS] = 0.0;
    Some([wave.coefficients_um, corrected].map(|coefficients_um| {
        let grid = PsfGrid::new(SIZE, pixel_arcmin(pupil_mm))?;
        let psf = grid.psf(&PupilFunction {
            coefficients_um: &coefficients_um,
            diameter_mm: pupil_mm,
            wavelength_nm: GREEN_NM,
            stiles_crawford: 0.0,
        })?;
        Ok(grid.mtf(&psf))
    }))
}

/// All frequencies at each of these pupils (mm; beyond 7.9 mm the grid does not hold the traced transfer).
/// The eye is round, so one orientation stands for all.
pub fn rows(pupils_mm: &[f64]) -> Vec<MtfRow> {
    let mut rows = Vec::with_capacity(pupils_mm.len() * FREQUENCIES_CPD.len());
    for &pupil_mm in pupils_mm {
        let traced = traced(pupil_mm);
        rows.extend(FREQUENCIES_CPD.map(|frequency_cpd| row(pupil_mm, frequency_cpd, &traced)));
    }
    rows
}

fn row(pupil_mm: f64, frequency_cpd: f64, traced: &Option<[Result<Mtf, PsfError>; 2]>) -> MtfRow {
    let mut null_reasons = NullReasons::new();
    let (low, high) = MEAN_MTF_PUPIL_RANGE_MM;
    let in_fit = (low..=high).contains(&pupil_mm);
    let mean = known(
        &mut null_reasons,
        "mean_mtf",
        in_fit.then(|| mean_mtf(frequency_cpd, pupil_mm)),
        "the fit is of pupils of 2 to 6 mm",
    );
    let mut of = |key, which: usize| match traced {
        Some(found) => match &found[which] {
            Ok(mtf) => known(&mut null_reasons, key, Some(mtf.at(frequency_cpd, 0.0)), ""),
            Err(error) => known(&mut null_reasons, key, None, &error.to_string()),
        },
        None => known(
            &mut null_reasons,
            key,
            None,
            "rays of this pupil do not pass the eye",
        ),
    };
    MtfRow {
        pupil_diameter_mm: pupil_mm,
        frequency_cpd,
        mean_mtf: mean,
        diffraction_mtf: diffraction_mtf(frequency_cpd, pupil_mm, GREEN_NM),
        traced_mtf: of("traced_mtf", 0),
        traced_best_focus_mtf: of("traced_best_focus_mtf", 1),
        null_reasons,
    }
}
