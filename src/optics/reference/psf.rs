//! Point spread and modulation transfer of a wavefront, by Fourier optics.
//!
//! In: a wave aberration as Zernike coefficients (µm), the pupil's diameter (mm), a wavelength (nm) and
//! a grid of visual angle. Out: a [`Psf`] with energy 1 and the [`Mtf`] it makes.
//!
//! The amplitude at visual angle θ is `Σ A(x) exp(2πi (W(x) − x·θ)/λ)` over the pupil (Goodman,
//! Introduction to Fourier Optics, chapter 6), so that a wave that slopes by θ moves the image to +θ.
//! A is 1, or falls off as the Stiles–Crawford effect does, and pixels that the pupil's edge crosses
//! count by the area within. The grid is given in visual angle and the pupil's pixels follow the
//! wavelength, so that the spreads of several colours add up pixel by pixel.

pub use super::mean_mtf::diffraction_mtf;
use super::zernike::{ZERNIKE_COUNT, zernike_slopes, zernike_sum};
use core::f64::consts::{PI, TAU};
use glam::DVec2;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;
use thiserror::Error;

/// Steepness ρ (mm⁻²) of the Stiles–Crawford effect at 550 nm, in `η = 10^(−ρ r²)` (Applegate &
/// Lakshminarayanan 1993).
pub const STILES_CRAWFORD: f64 = 0.041;
/// Subdivisions a side of a pixel that the pupil's edge crosses.
const EDGE_SUBDIVISION: i32 = 8;
/// Fewest pixels across a pupil.
const FEWEST_ACROSS: f64 = 16.0;
/// One minute of arc (rad).
const ARCMIN: f64 = PI / 10_800.0;

/// Why a spread cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PsfError {
    /// The grid's side is not a power of two from 32 to 4096.
    #[error("a grid of {0} pixels is not a power of two from 32 to 4096")]
    Size(usize),
    /// The pupil, the wavelength, the pixel or a coefficient is not a positive, finite number in
    /// range (pupil 0.1 to 10 mm, wavelength 300 to 1100 nm).
    #[error("{field} is {value}, out of range")]
    OutOfRange {
        /// Which.
        field: &'static str,
        /// What it was.
        value: f64,
    },
    /// The pixel is wider than half of λ/D, the finest detail of the image.
    #[error("pixels must not be wider than {0:.4} arcmin for this pupil and wavelength")]
    Coarse(f64),
    /// The pupil covers too few of the grid's pixels.
    #[error("the pupil needs pixels of at least {0:.4} arcmin on this grid")]
    Fine(f64),
    /// The wave changes by more than half a wavelength between pixels of the pupil, so that the image
    /// would fold over the edge of the grid.
    #[error("the blur is {0:.1} arcmin wide and does not fit the grid")]
    Wide(f64),
}

/// What light passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilFunction<'a> {
    /// Wave aberration (µm); piston has no effect.
    pub coefficients_um: &'a [f64; ZERNIKE_COUNT],
    /// Diameter of the unit pupil (mm).
    pub diameter_mm: f64,
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// ρ of the Stiles–Crawford effect about the pupil's centre (mm⁻²): 0 for none,
    /// [`STILES_CRAWFORD`] for an average eye.
    pub stiles_crawford: f64,
}

/// A square grid of visual angle, ready to transform.
pub struct PsfGrid {
    size: usize,
    arcmin_per_pixel: f64,
    fft: Arc<dyn Fft<f64>>,
}

/// A point spread on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Psf {
    /// Pixels a side; the centre is pixel `size/2`.
    pub size: usize,
    /// Visual angle of a pixel.
    pub arcmin_per_pixel: f64,
    /// Share of the energy in each pixel, rows from y = −size/2 up, columns from x = −size/2.
    pub values: Vec<f64>,
    /// Highest value over that of the same pupil without aberrations.
    pub strehl: f64,
    /// Energy of the pixelled pupil over that of the pupil: pixels at the edge pass the square of the
    /// area within them.
    edge_energy: f64,
}

/// A modulation transfer function on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Mtf {
    /// Samples a side; zero frequency is sample `size/2`.
    pub size: usize,
    /// Spatial frequency between samples (cycles/degree).
    pub cycles_per_degree: f64,
    /// Modulation, 0 to 1, in rows as [`Psf::values`].
    pub values: Vec<f64>,
}

/// Sums over the pixels of a pupil.
#[derive(Default)]
struct PupilSums {
    /// Of the amplitude: the peak of the image without aberrations is its square.
    amplitude: f64,
    /// Of the energy that the pupil passes.
    energy: f64,
    /// Of the energy that its pixels pass.
    pixelled_energy: f64,
}

fn in_range(field: &'static str, value: f64, low: f64, high: f64) -> Result<(), PsfError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(PsfError::OutOfRange { field, value })
    }
}

impl PsfGrid {
    /// A grid of `size` × `size` pixels of `arcmin_per_pixel`.
    pub fn new(size: usize, arcmin_per_pixel: f64) -> Result<Self, PsfError> {
        if !size.is_power_of_two() || !(32..=4096).contains(&size) {
            return Err(PsfError::Size(size));
        }
        in_range("the pixel", arcmin_per_pixel, 1e-4, 60.0)?;
        Ok(Self {
            size,
            arcmin_per_pixel,
            fft: FftPlanner::new().plan_fft_forward(size),
        })
    }

    /// The grid of `size` pixels on which this pupil and wavelength have four pixels to λ/D: twice as
    /// fine as need be.
    pub fn for_pupil(size: usize, diameter_mm: f64, wavelength_nm: f64) -> Result<Self, PsfError> {
        in_range("the pupil", diameter_mm, 0.1, 10.0)?;
        in_range("the wavelength", wavelength_nm, 300.0, 1100.0)?;
        Self::new(size, 0.25e-6 * wavelength_nm / diameter_mm / ARCMIN)
    }

    /// The point spread of one wavelength.
    pub fn psf(&self, pupil: &PupilFunction) -> Result<Psf, PsfError> {
        let pixel_mm = self.pupil_pixel_mm(pupil)?;
        let (mut field, sums) = self.pupil_field(pupil, pixel_mm);
        self.transform(&mut field, self.rows_of_pupil(pupil, pixel_mm));
        // Parseval: the sum of |field|² is size² times the pupil's energy.
        let total: f64 = field.iter().map(|z| z.norm_sqr()).sum();
        let mut psf = Psf {
            size: self.size,
            arcmin_per_pixel: self.arcmin_per_pixel,
            values: self.centred(&field, |z| z.norm_sqr() / total),
            strehl: 0.0,
            edge_energy: sums.pixelled_energy / sums.energy,
        };
        let peak = psf.values.iter().copied().fold(0.0, f64::max);
        psf.strehl = peak * total / (sums.amplitude * sums.amplitude);
        Ok(psf)
    }

    /// The point spread of a mixture: pupils, each with the share of the light that it gets (relative;
    /// shares that are not positive count as none). `strehl` is that of the mixture against the same
    /// without aberrations.
    pub fn polychromatic_psf(&self, parts: &[(PupilFunction, f64)]) -> Result<Psf, PsfError> {
        let total: f64 = parts.iter().map(|(_, share)| share.max(0.0)).sum();
        in_range("the light", total, f64::MIN_POSITIVE, f64::MAX)?;
        let mut sum = Psf {
            size: self.size,
            arcmin_per_pixel: self.arcmin_per_pixel,
            values: vec![0.0; self.size * self.size],
            strehl: 0.0,
            edge_energy: 0.0,
        };
        let mut perfect_peak = 0.0;
        for (pupil, share) in parts.iter().filter(|(_, share)| *share > 0.0) {
            let part = self.psf(pupil)?;
            let share = share / total;
            let peak = part.values.iter().copied().fold(0.0, f64::max);
            perfect_peak += share * peak / part.strehl;
            sum.edge_energy += share * part.edge_energy;
            for (sum, value) in sum.values.iter_mut().zip(&part.values) {
                *sum += share * value;
            }
        }
        sum.strehl = sum.values.iter().copied().fold(0.0, f64::max) / perfect_peak;
        Ok(sum)
    }

    /// The modulation transfer function of a point spread made on this grid.
    pub fn mtf(&self, psf: &Psf) -> Mtf {
        let half = self.size / 2;
        let mut field = vec![Complex64::default(); self.size * self.size];
        for (i, row) in psf.values.chunks_exact(self.size).enumerate() {
            for (j, value) in row.iter().enumerate() {
                let (i, j) = ((i + half) % self.size, (j + half) % self.size);
                // The transform transposes.
                field[j * self.size + i].re = *value;
            }
        }
        self.transform(&mut field, 0..self.size);
        // The cusp at zero frequency is rounded off by the pixels of the pupil, the rest is not: the
        // whole is scaled by the pupil's true energy, and zero set to 1.
        let scale = psf.edge_energy / field[0].norm();
        let mut mtf = Mtf {
            size: self.size,
            cycles_per_degree: 60.0 / (self.size as f64 * self.arcmin_per_pixel),
            values: self.centred(&field, |z| z.norm() * scale),
        };
        mtf.values[half * self.size + half] = 1.0;
        mtf
    }

    /// Width of a pixel of the pupil (mm): λ over the grid's angle.
    fn pupil_pixel_mm(&self, pupil: &PupilFunction) -> Result<f64, PsfError> {
        in_range("the pupil", pupil.diameter_mm, 0.1, 10.0)?;
        in_range("the wavelength", pupil.wavelength_nm, 300.0, 1100.0)?;
        in_range(
            "the Stiles–Crawford effect",
            pupil.stiles_crawford,
            0.0,
            1.0,
        )?;
        for c in pupil.coefficients_um {
            in_range("a coefficient", *c, -1e4, 1e4)?;
        }
        let wavelength_mm = 1e-6 * pupil.wavelength_nm;
        let grid_angle = self.size as f64 * self.arcmin_per_pixel * ARCMIN;
        let pixel_mm = wavelength_mm / grid_angle;
        let across = pupil.diameter_mm / pixel_mm;
        let half = 0.5 * self.size as f64;
        // Rounding of the two ratios.
        if across > half * (1.0 + 1e-12) {
            return Err(PsfError::Coarse(
                0.5 * wavelength_mm / pupil.diameter_mm / ARCMIN,
            ));
        }
        if across < FEWEST_ACROSS {
            let least = FEWEST_ACROSS * wavelength_mm / pupil.diameter_mm;
            return Err(PsfError::Fine(least / self.size as f64 / ARCMIN));
        }
        // Slopes of the wave are angles: the widest must lie on the grid.
        let radius = 0.5 * pupil.diameter_mm;
        let steepest = (0..96)
            .map(|i| {
                let ring = [1.0, 0.7, 0.4][i % 3];
                let p = ring * DVec2::from_angle(TAU * i as f64 / 96.0);
                let slope: DVec2 = zernike_slopes(p)
                    .into_iter()
                    .zip(pupil.coefficients_um)
                    .map(|(slope, c)| *c * slope)
                    .sum();
                slope.abs().max_element()
            })
            .fold(0.0, f64::max)
            * 1e-3
            / radius;
        if steepest > 0.5 * grid_angle {
            return Err(PsfError::Wide(2.0 * steepest / ARCMIN));
        }
        Ok(pixel_mm)
    }

    /// Rows of the grid that hold part of the pupil, counted from the wrapped origin.
    fn rows_of_pupil(&self, pupil: &PupilFunction, pixel_mm: f64) -> core::ops::Range<usize> {
        // Wrapped rows are not contiguous; what matters is how many of each half are filled.
        let reach = (0.5 * pupil.diameter_mm / pixel_mm).ceil() as usize + 1;
        0..(2 * reach + 1).min(self.size)
    }

    /// The complex amplitude over the pupil. Rows are stored from the pupil's lowest, so that the empty
    /// ones come last: a shift of rows changes phases of the image, not its intensity.
    fn pupil_field(&self, pupil: &PupilFunction, pixel_mm: f64) -> (Vec<Complex64>, PupilSums) {
        let size = self.size;
        let unit = 2.0 * pixel_mm / pupil.diameter_mm;
        let reach = (1.0 / unit).ceil() as i32 + 1;
        let radius = 0.5 * pupil.diameter_mm;
        let to_phase = TAU / (1e-3 * pupil.wavelength_nm);
        // Amplitude is the root of the efficiency.
        let falloff = -0.5 * pupil.stiles_crawford * core::f64::consts::LN_10 * radius * radius;
        let mut field = vec![Complex64::default(); size * size];
        let mut sums = PupilSums::default();
        // Rows along y, because the transform transposes.
        for i in -reach..=reach {
            for j in -reach..=reach {
                let p = unit * DVec2::new(f64::from(i), f64::from(j));
                let area = covered(p, unit);
                if area == 0.0 {
                    continue;
                }
                let clear = (falloff * p.length_squared()).exp();
                let amplitude = area * clear;
                // Just outside the edge the polynomials go on.
                let phase = to_phase * zernike_sum(pupil.coefficients_um, p);
                sums.amplitude += amplitude;
                sums.energy += area * clear * clear;
                sums.pixelled_energy += amplitude * amplitude;
                let row = (i + reach) as usize;
                let column = j.rem_euclid(size as i32) as usize;
                field[row * size + column] = Complex64::from_polar(amplitude, phase);
            }
        }
        (field, sums)
    }

    /// Two-dimensional transform in place; rows outside `filled` are known to be empty. Transposes.
    fn transform(&self, field: &mut Vec<Complex64>, filled: core::ops::Range<usize>) {
        let size = self.size;
        let rows = filled.start * size..filled.end * size;
        let mut scratch = vec![Complex64::default(); self.fft.get_inplace_scratch_len()];
        self.fft
            .process_with_scratch(&mut field[rows], &mut scratch);
        let mut turned = vec![Complex64::default(); size * size];
        // In blocks, so that both sides stay in the cache.
        const BLOCK: usize = 16;
        for row_block in (filled.start..filled.end).step_by(BLOCK) {
            for column_block in (0..size).step_by(BLOCK) {
                for i in row_block..(row_block + BLOCK).min(filled.end) {
                    for j in column_block..column_block + BLOCK {
                        turned[j * size + i] = field[i * size + j];
                    }
                }
            }
        }
        self.fft.process_with_scratch(&mut turned, &mut scratch);
        *field = turned;
    }

    /// Values with the origin in the middle.
    fn centred(&self, field: &[Complex64], value: impl Fn(&Complex64) -> f64) -> Vec<f64> {
        let (size, half) = (self.size, self.size / 2);
        let mut out = Vec::with_capacity(size * size);
        for i in 0..size {
            let row = &field[((i + half) % size) * size..][..size];
            out.extend(row[half..].iter().map(&value));
            out.extend(row[..half].iter().map(&value));
        }
        out
    }
}

/// Share of a pixel of side `unit` about `p` that lies in the unit disc.
fn covered(p: DVec2, unit: f64) -> f64 {
    let (r, reach) = (p.length(), unit * core::f64::consts::FRAC_1_SQRT_2);
    if r + reach <= 1.0 {
        return 1.0;
    }
    if r - reach >= 1.0 {
        return 0.0;
    }
    let mut inside = 0;
    let step = unit / f64::from(EDGE_SUBDIVISION);
    let first = 0.5 * f64::from(1 - EDGE_SUBDIVISION);
    for i in 0..EDGE_SUBDIVISION {
        for j in 0..EDGE_SUBDIVISION {
            let offset = DVec2::new(f64::from(i) + first, f64::from(j) + first);
            inside += i32::from((p + step * offset).length_squared() <= 1.0);
        }
    }
    f64::from(inside) / f64::from(EDGE_SUBDIVISION * EDGE_SUBDIVISION)
}

impl Psf {
    /// Share of the energy within `radius_arcmin` of the centre of the grid, by whole pixels.
    pub fn encircled(&self, radius_arcmin: f64) -> f64 {
        let half = (self.size / 2) as f64;
        let limit = (radius_arcmin / self.arcmin_per_pixel).powi(2);
        self.values
            .chunks_exact(self.size)
            .enumerate()
            .flat_map(|(i, row)| {
                row.iter().enumerate().filter_map(move |(j, value)| {
                    let r2 = (i as f64 - half).powi(2) + (j as f64 - half).powi(2);
                    (r2 <= limit).then_some(value)
                })
            })
            .sum()
    }
}

impl Mtf {
    /// Modulation at a spatial frequency (cycles/degree along x and y), between samples bilinear; 0
    /// beyond the grid and for what is not a number.
    pub fn at(&self, x_cpd: f64, y_cpd: f64) -> f64 {
        let half = (self.size / 2) as f64;
        let (x, y) = (
            x_cpd / self.cycles_per_degree + half,
            y_cpd / self.cycles_per_degree + half,
        );
        let last = (self.size - 1) as f64;
        if !(0.0..last).contains(&x) || !(0.0..last).contains(&y) {
            return 0.0;
        }
        let (i, j) = (y as usize, x as usize);
        let (v, u) = (y - i as f64, x - j as f64);
        let value = |i: usize, j: usize| self.values[i * self.size + j];
        (1.0 - v) * ((1.0 - u) * value(i, j) + u * value(i, j + 1))
            + v * ((1.0 - u) * value(i + 1, j) + u * value(i + 1, j + 1))
    }

    /// Mean modulation over all orientations at `cpd` cycles/degree.
    pub fn radial(&self, cpd: f64) -> f64 {
        (0..64)
            .map(|i| {
                let v = cpd * DVec2::from_angle(PI * f64::from(i) / 64.0);
                self.at(v.x, v.y)
            })
            .sum::<f64>()
            / 64.0
    }
}

#[cfg(test)]
mod tests;
