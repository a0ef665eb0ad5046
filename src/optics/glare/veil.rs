//! Straylight of clouded media beyond that of a healthy eye: its spread, its energy, and its kernel as a
//! sum of bells.
//!
//! Enters: the straylight parameter that clouding adds (deg² sr⁻¹ at 7°). Leaves: a spread function
//! that keeps all light: what is scattered is taken from what is not. Scatterers add in intensity,
//! and the angular law stays that of the CIE function's wide terms at every severity (van den Berg
//! and IJspeert 1995): one shape, scaled. Beyond a scattered share of a half light is scattered
//! more than once, which the share `1 − e^(−E s)` stands for.
//!
//! **As a sum of levels.** A law near θ⁻² is a sum of bells an octave apart, such as the mips of a picture
//! are under a spline. What a light in the middle of the picture becomes on each level is followed
//! step by step; the levels' weights are fitted to the function from 0.7 to 35° by non-negative least
//! squares of relative errors (Lee and Seung's multiplicative steps, 2001).

use super::Glare;
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Angle at which the added straylight is given, rad.
const STATED_AT_RAD: f64 = 7.0 * core::f64::consts::PI / 180.0;
/// Angles between which a kernel is fitted, how many, and in how many steps.
const FITTED_RAD: (f64, f64) = (0.7 * PI / 180.0, 35.0 * PI / 180.0);
const FITTED_ANGLES: usize = 64;
const FIT_STEPS: usize = 400;
/// Gaussians that a kernel may have.
pub const VEIL_LEVELS: usize = 16;
/// Sigma of a mip level under the wide spline, texels of that level: the (1, 3, 3, 1)/8 mips have a
/// variance of a quarter, a cubic B-spline twice as wide as a texel's of four thirds.
const SIGMA_TEXELS: f64 = 1.258_305_7;
/// The cubic B-spline, of which those at whole distances sum to 1.
pub fn cubic_spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (4.0 - 3.0 * x * x * (2.0 - x)) / 6.0
    } else {
        (2.0 - x).max(0.0).powi(3) / 6.0
    }
}

/// One step of a picture's mips along one axis: the box that halves it under (1, 2, 1)/4, as
/// `shaders/view/capture/downsample.wgsl` takes it.
fn halved(source: &[f64]) -> Vec<f64> {
    let (n, m) = (source.len(), (source.len() / 2).max(1));
    let read = |at: isize| source[at.clamp(0, n as isize - 1) as usize];
    (0..m)
        .map(|i| {
            let weights = if n == 1 {
                [0.0, 1.0, 0.0, 0.0, 0.0]
            } else {
                let whole = n as f64;
                let [a, b, c] = if n == 2 * m {
                    [0.5, 0.5, 0.0]
                } else {
                    [(m - i) as f64, m as f64, (i + 1) as f64].map(|part| part / whole)
                };
                [
                    0.25 * a,
                    0.5 * a + 0.25 * b,
                    0.25 * a + 0.5 * b + 0.25 * c,
                    0.25 * b + 0.5 * c,
                    0.25 * c,
                ]
            };
            (0..5)
                .map(|k| weights[k] * read(2 * i as isize - 1 + k as isize))
                .sum()
        })
        .collect()
}

/// What `shaders/view/present/veil.wgsl` reads along one axis of a light in the middle, from a level whose texels
/// these are, at each of `side` pixels; `tan_half` is the tangent of half the field.
fn read_along(texels: &[f64], side: usize, tan_half: f64) -> Vec<f64> {
    let count = texels.len() as f64;
    let read = |at: f64| texels[at.clamp(0.0, count - 1.0) as usize];
    (0..side)
        .map(|pixel| {
            let at = (pixel as f64 + 0.5) / side as f64 * count - 0.5;
            let base = at.floor() - 3.0;
            let (sum, whole) = (0..8).fold((0.0, 0.0), |(sum, whole), k| {
                let texel = base + f64::from(k);
                // Each texel counts with the solid angle that it has.
                let tangent = (2.0 * (texel + 0.5) / count - 1.0) * tan_half;
                let share = (1.0 + tangent * tangent).powf(-1.5);
                let weight = share * cubic_spline(0.5 * (texel - at));
                (sum + weight * read(texel), whole + weight)
            });
            sum / whole
        })
        .collect()
}

/// What a light in the middle of a picture of this side becomes along one axis on the levels up to
/// `last`, a pixel.
fn levels_along(side: usize, last: usize, tan_half: f64) -> Vec<Vec<f64>> {
    let mut texels = vec![0.0; side];
    for middle in [(side - 1) / 2, side / 2] {
        texels[middle] += 0.5;
    }
    (0..=last)
        .map(|level| {
            if level > 0 {
                texels = halved(&texels);
            }
            read_along(&texels, side, tan_half)
        })
        .collect()
}

/// What clouded media scatter beyond a healthy eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veil {
    with: Glare,
    without: Glare,
    /// Straylight at 7° of the shape as it stands, deg² sr⁻¹.
    unit: f64,
    /// What is added, multiple scattering counted, deg² sr⁻¹ at 7°.
    added: f64,
    scattered: f64,
}

impl Veil {
    /// Media that add `straylight` (deg² sr⁻¹ at 7°, 0 and more; what is not a number counts as 0) in an
    /// eye of this pigmentation (0 to 1.2).
    pub fn new(straylight: f64, pigment: f64) -> Self {
        let part = |wide: f64| Glare {
            core: 0.0,
            wide,
            ..Glare::with_age_factor(0.0, pigment)
        };
        let (with, without) = (part(1.0), part(0.0));
        let unit = with.straylight(STATED_AT_RAD) - without.straylight(STATED_AT_RAD);
        let whole = with.energy_within(FRAC_PI_2) - without.energy_within(FRAC_PI_2);
        let energy = whole / unit;
        let asked = if straylight > 0.0 && straylight.is_finite() {
            straylight
        } else {
            0.0
        };
        let scattered = -(-energy * asked).exp_m1();
        Self {
            with,
            without,
            unit,
            added: scattered / energy,
            scattered,
        }
    }

    /// Share of the light that is scattered, 0 to 1.
    pub fn scattered(&self) -> f64 {
        self.scattered
    }

    /// Scattered light per steradian at `theta_rad` from the source, sr⁻¹.
    pub fn spread(&self, theta_rad: f64) -> f64 {
        self.added / self.unit * (self.with.spread(theta_rad) - self.without.spread(theta_rad))
    }

    /// Scattered light within the cone of half-angle `theta_rad`.
    pub fn energy_within(&self, theta_rad: f64) -> f64 {
        let energy = self.with.energy_within(theta_rad) - self.without.energy_within(theta_rad);
        self.added / self.unit * energy
    }

    /// The kernel for a picture of this size and `pixels_per_radian` at its middle, as shares of the light
    /// on its mip levels from `first` to `last` under a cubic B-spline of twice their texels, and what
    /// remains for what lies around it; together they are [`Self::scattered`].
    ///
    /// A level is read as a mean in which a texel at the angle θ from the middle counts with its solid
    /// angle, cos³ θ: so a uniform picture stays what it is everywhere, and a veil in the middle is
    /// right as far as the picture goes. At the angle θ an angle takes 1/cos² θ as many texels outwards
    /// and 1/cos θ aside, which is met in the mean, by reading levels 1.5 log₂(1/cos θ) coarser.
    pub fn weights(
        &self,
        pixels_per_radian: f64,
        size_px: [u32; 2],
        first: usize,
        last: usize,
    ) -> ([f64; VEIL_LEVELS], f64) {
        let last = last.min(VEIL_LEVELS - 1);
        let first = first.min(last);
        let mut weights = [0.0; VEIL_LEVELS];
        if self.added == 0.0 {
            return (weights, 0.0);
        }
        let sigma = |level: usize| SIGMA_TEXELS * 2f64.powi(level as i32) / pixels_per_radian;
        let sides = size_px.map(|side| side.max(1) as usize);
        let axes =
            sides.map(|side| levels_along(side, last, 0.5 * side as f64 / pixels_per_radian));
        // What a level is at this tangent from the middle, as a mean over the directions in which the
        // picture goes so far.
        let at_level = |level: usize, r: f64| {
            let (mut sum, mut count) = (0.0, 0.0);
            for part in 0..8 {
                let angle = (f64::from(part) + 0.5) / 8.0 * FRAC_PI_2;
                let (sine, cosine) = angle.sin_cos();
                let read = |axis: usize, along: f64| {
                    let at = 0.5 * sides[axis] as f64 + along * pixels_per_radian - 0.5;
                    let (low, f) = (at.floor().max(0.0) as usize, at.fract().max(0.0));
                    let line = &axes[axis][level];
                    Some(line.get(low)? * (1.0 - f) + line.get(low + 1)? * f)
                };
                if let (Some(x), Some(y)) = (read(0, r * cosine), read(1, r * sine)) {
                    sum += x * y;
                    count += 1.0;
                }
            }
            if count > 0.0 {
                sum / count * pixels_per_radian * pixels_per_radian
            } else {
                0.0
            }
        };
        // Each level over the function, at every angle.
        let rows: Vec<[f64; VEIL_LEVELS]> = (0..FITTED_ANGLES)
            .map(|i| {
                let share = i as f64 / (FITTED_ANGLES - 1) as f64;
                let theta = FITTED_RAD.0 * (FITTED_RAD.1 / FITTED_RAD.0).powf(share);
                let (r, wanted) = (theta.tan(), self.spread(theta));
                let coarser = coarser_at(r);
                core::array::from_fn(|level| {
                    if (first..=last).contains(&level) {
                        let next = (level + 1).min(last);
                        let own = (1.0 - coarser) * at_level(level, r);
                        (own + coarser * at_level(next, r)) / wanted
                    } else {
                        0.0
                    }
                })
            })
            // Beyond the picture nothing is fitted.
            .filter(|row: &[f64; VEIL_LEVELS]| row.iter().any(|level| *level > 0.0))
            .collect();
        // A first guess: an octave of rings each, as in a law of θ⁻².
        for (level, weight) in weights.iter_mut().enumerate().take(last + 1).skip(first) {
            *weight = self.added * core::f64::consts::LN_2 * TAU * (PI / 180.0).powi(2);
            // A level far wider than what is fitted has no say.
            if sigma(level) > 4.0 {
                *weight = 0.0;
            }
        }
        for _ in 0..FIT_STEPS {
            let found: Vec<f64> = rows
                .iter()
                .map(|row| row.iter().zip(&weights).map(|(a, w)| a * w).sum())
                .collect();
            for (level, weight) in weights.iter_mut().enumerate() {
                let up: f64 = rows.iter().map(|row| row[level]).sum();
                let down: f64 = rows.iter().zip(&found).map(|(row, f)| row[level] * f).sum();
                if down > 0.0 {
                    *weight *= up / down;
                }
            }
        }
        let kept: f64 = weights[first..=last].iter().sum();
        // No more than there is, should a picture be so coarse that its levels fit badly.
        let share = (self.scattered / kept.max(f64::MIN_POSITIVE)).min(1.0);
        for weight in &mut weights {
            *weight *= share;
        }
        (weights, (self.scattered - kept * share).max(0.0))
    }
}

/// How many levels coarser a place at this tangent from the middle is read: there an angle takes
/// 1/cos² θ as many texels outwards and 1/cos θ aside.
fn coarser_at(tangent: f64) -> f64 {
    (0.75 * (1.0 + tangent * tangent).log2()).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_adds_the_straylight_that_it_is_given_while_that_is_little() {
        let veil = Veil::new(0.01, 0.5);
        let at = |deg: f64| deg * deg * veil.spread(deg.to_radians());
        assert!((at(7.0) / 0.01 - 1.0).abs() < 1e-3);
        // Beyond 1°, 0.0093 of the light for each deg² sr⁻¹.
        let beyond = veil.scattered() - veil.energy_within(1f64.to_radians());
        assert!((beyond / 0.01 - 0.0093).abs() < 2e-4, "{}", beyond / 0.01);
    }

    #[test]
    fn no_light_is_made_or_lost() {
        for straylight in [0.0, 0.5, 13.0, 90.0, 1e6, f64::NAN, -3.0, f64::INFINITY] {
            for pigment in [0.0, 0.5, 1.2] {
                let veil = Veil::new(straylight, pigment);
                let scattered = veil.scattered();
                assert!((0.0..=1.0).contains(&scattered));
                assert!((veil.energy_within(FRAC_PI_2) - scattered).abs() < 1e-9);
                let (weights, rest) = veil.weights(600.0, [640, 480], 1, 8);
                assert!(
                    weights
                        .iter()
                        .all(|weight| weight.is_finite() && *weight >= 0.0)
                );
                assert!(rest >= 0.0 && rest <= scattered + 1e-12);
                let whole = weights.iter().sum::<f64>() + rest;
                assert!((whole - scattered).abs() < 1e-12, "{whole} of {scattered}");
            }
        }
    }

    #[test]
    fn a_light_in_the_middle_keeps_its_light_on_every_level() {
        for side in [1, 2, 7, 64, 101, 640] {
            // Far from where a pixel's solid angle matters.
            for (level, line) in levels_along(side, 4, 1e-6).iter().enumerate() {
                let sum: f64 = line.iter().sum();
                // The ends of a short picture stand for more of it.
                if side > 64 {
                    assert!((sum - 1.0).abs() < 2e-2, "{side} {level}: {sum}");
                }
                assert!(sum.is_finite());
            }
        }
    }
}
