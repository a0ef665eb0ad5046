//! Images of a point: the grid of the Fourier optics, and the rays of a wavefront.

use super::rows::{ErrorRow, Task};
use super::timing::Stopwatch;
use crate::optics::reference::mean_mtf::{diffraction_cutoff_cpd, diffraction_mtf};
use crate::optics::reference::psf::{Psf, PsfError, PsfGrid, PupilFunction};
use crate::optics::reference::wavefront::fit::solve;
use crate::optics::reference::wavefront::{
    ObjectPoint, Wavefront, WavefrontSample, trace_wavefront,
};
use crate::optics::reference::zernike::{ZERNIKE_COUNT, zernike_sum, zernike_values};
use crate::optics::schematic_eye::{SODIUM_NM, SchematicEye};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

const WAVELENGTH_NM: f64 = 555.0;
const NO_ABERRATION: [f64; ZERNIKE_COUNT] = [0.0; ZERNIKE_COUNT];
/// Spatial frequencies, as shares of the cut-off, at which modulation is compared.
const FREQUENCIES: u32 = 200;

fn clear_pupil(diameter_mm: f64) -> PupilFunction<'static> {
    PupilFunction {
        coefficients_um: &NO_ABERRATION,
        diameter_mm,
        wavelength_nm: WAVELENGTH_NM,
        stiles_crawford: 0.0,
    }
}

fn spread(grid: &PsfGrid, diameter_mm: f64) -> Option<Psf> {
    grid.psf(&clear_pupil(diameter_mm)).ok()
}

/// Errors of the modulation along both axes and the diagonal.
fn modulation_errors(grid: &PsfGrid, diameter_mm: f64) -> Vec<f64> {
    let Some(psf) = spread(grid, diameter_mm) else {
        return Vec::new();
    };
    let mtf = grid.mtf(&psf);
    let cutoff = diffraction_cutoff_cpd(diameter_mm, WAVELENGTH_NM);
    let mut errors = Vec::new();
    for i in 0..FREQUENCIES {
        let cpd = cutoff * f64::from(i) / f64::from(FREQUENCIES);
        let exact = diffraction_mtf(cpd, diameter_mm, WAVELENGTH_NM);
        let slant = cpd * core::f64::consts::FRAC_1_SQRT_2;
        for found in [mtf.at(cpd, 0.0), mtf.at(0.0, cpd), mtf.at(slant, slant)] {
            errors.push(found - exact);
        }
    }
    errors
}

/// The grid's size; `sizes` are powers of two from 64. Grids that the library refuses are left out.
pub fn grid(stopwatch: &Stopwatch, sizes: &[usize]) -> Task {
    let pupils = [2.0, 3.0, 4.0, 6.0];
    let mut rows: Vec<ErrorRow> = Vec::new();
    for &size in sizes {
        let made: Result<Vec<(f64, PsfGrid)>, PsfError> = pupils
            .iter()
            .map(|&pupil| Ok((pupil, PsfGrid::for_pupil(size, pupil, WAVELENGTH_NM)?)))
            .collect();
        let Ok(grids) = made else { continue };
        let errors = grids
            .iter()
            .flat_map(|(pupil, grid)| modulation_errors(grid, *pupil))
            .collect();
        let ns = stopwatch.ns_per_call(&grids, |(pupil, grid)| {
            spread(grid, *pupil).map(|psf| grid.mtf(&psf))
        });
        // The spread and the modulation.
        let bytes = 2 * size * size * size_of::<f64>();
        rows.push(ErrorRow::new("grid", size, bytes, ns, errors));
    }
    Task {
        name: "modulation".to_owned(),
        title: "Modulation transfer on a grid".to_owned(),
        call: "point spread and modulation transfer of one pupil; the bytes are theirs".to_owned(),
        domain: format!(
            "pupils of 2, 3, 4 and 6 mm without aberrations at 555 nm; {FREQUENCIES} frequencies to the \
             cut-off along both axes and a diagonal; bilinear between samples"
        ),
        reference: "the closed form of diffraction".to_owned(),
        unit: "modulation".to_owned(),
        rows,
    }
}

struct Eye {
    wave: Wavefront,
    /// The rays in a random order.
    rays: Vec<WavefrontSample>,
}

/// Least squares over the first rays, all alike.
fn fitted(rays: &[WavefrontSample]) -> [f64; ZERNIKE_COUNT] {
    let mut a = [[0.0; ZERNIKE_COUNT]; ZERNIKE_COUNT];
    let mut b = [0.0; ZERNIKE_COUNT];
    for ray in rays {
        let z = zernike_values(ray.pupil);
        for i in 0..ZERNIKE_COUNT {
            b[i] += z[i] * ray.aberration_um;
            for j in 0..=i {
                a[i][j] += z[i] * z[j];
            }
        }
    }
    solve(a, b)
}

/// Error of the fitted surface at every traced ray.
fn surface_errors(eye: &Eye, coefficients: &[f64; ZERNIKE_COUNT]) -> Vec<f64> {
    let samples = &eye.wave.samples;
    samples
        .iter()
        .map(|ray| zernike_sum(coefficients, ray.pupil) - ray.aberration_um)
        .collect()
}

/// The number of rays of a wavefront.
pub fn rays(stopwatch: &Stopwatch) -> Task {
    let schematic = SchematicEye::navarro(0.0, SODIUM_NM);
    let mut random = Pcg64::seed_from_u64(20);
    let fields = [0.0, 5.0, 10.0, 20.0_f64].map(|azimuth| ObjectPoint {
        azimuth: azimuth.to_radians(),
        ..ObjectPoint::default()
    });
    let mut eyes = Vec::new();
    let mut traced = Vec::new();
    for field in fields {
        for pupil in [2.0, 3.0, 4.0, 6.0] {
            if let Ok(wave) = trace_wavefront(&schematic, pupil, field) {
                let mut rays = wave.samples.clone();
                rays.shuffle(&mut random);
                eyes.push(Eye { wave, rays });
                traced.push((pupil, field));
            }
        }
    }
    let whole = stopwatch.ns_per_call(&traced, |(pupil, field)| {
        trace_wavefront(&schematic, *pupil, *field)
    });
    let mut fits = Vec::new();
    for count in [32, 48, 64, 96, 128, 192] {
        let run = |eye: &Eye| fitted(&eye.rays[..count.min(eye.rays.len())]);
        let errors: Vec<f64> = eyes
            .iter()
            .flat_map(|eye| surface_errors(eye, &run(eye)))
            .collect();
        fits.push((count, stopwatch.ns_per_call(&eyes, run), errors));
    }
    // What is left of the whole without its fit is the tracing of 192 rays.
    let fit = fits.last().map_or(0.0, |(_, ns, _)| *ns);
    let ray = (whole - fit).max(0.0) / 192.0;
    let mut rows: Vec<ErrorRow> = fits
        .into_iter()
        .map(|(count, ns, errors)| {
            let ns = ns + ray * count as f64;
            ErrorRow::new("random rays", count, 0, ns, errors)
        })
        .collect();
    let errors = eyes
        .iter()
        .flat_map(|eye| surface_errors(eye, &eye.wave.coefficients_um))
        .collect();
    rows.push(ErrorRow::new("rays on rings", 192, 0, whole, errors));
    Task {
        name: "wavefront".to_owned(),
        title: "Rays of a wavefront".to_owned(),
        call: "28 coefficients; fewer random rays are charged their share of the time to trace 192"
            .to_owned(),
        domain: "Navarro's relaxed eye; pupils of 2, 3, 4 and 6 mm; 0 to 20° off the axis"
            .to_owned(),
        reference: "the optical path of each of 192 rays".to_owned(),
        unit: "µm".to_owned(),
        rows,
    }
}
