//! Straylight of clouded media beyond that of a healthy eye: its spread, its energy, and its kernel as a
//! sum of bells.
//!
//! Enters: the straylight parameter that clouding adds (deg² sr⁻¹ at 7°). Leaves: a spread function
//! that keeps all light: what is scattered is taken from what is not. Scatterers add in intensity,
//! and the angular law stays that of the CIE function's wide terms at every severity (van den Berg
//! and IJspeert 1995): one shape, scaled. The parameter is what a meter finds, what is scattered over
//! what is not, so the share of all light is `E s / (1 + E s)`, where `E` is the energy of a unit.
//!
//! **As a sum of levels.** A law near θ⁻² is a sum of bells an octave apart, such as the mips of a picture
//! are under a spline. In the stereographic projection about the view's axis, `u = 2 tan(θ/2)`, every
//! place has one scale in all directions, `s(u) = 1 + u²/4`; a solid angle is `d²u/s²`, and
//! `4 sin²(γ/2) = |u − v|² / (s(u) s(v))` for the angle γ between two places. So a law of γ⁻² is a bell
//! that is the same everywhere over `L/s`, times the `s` of the place where it is seen: lights aside
//! have the veil that a light in the middle has. What such a light becomes on each level is followed
//! step by step; the levels' weights are fitted to the function from 0.7 to 35° by non-negative least
//! squares of relative errors (Lee and Seung's multiplicative steps, 2001).

use super::Glare;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::DVec2;

/// Angle at which the added straylight is given, rad.
const STATED_AT_RAD: f64 = 7.0 * core::f64::consts::PI / 180.0;
/// Angles between which a kernel is fitted, how many, and in how many steps. Where texels are coarse it
/// begins at two of them.
const FITTED_RAD: (f64, f64) = (0.7 * PI / 180.0, 35.0 * PI / 180.0);
const FIRST_TEXELS: f64 = 2.0;
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

/// Stereographic place of a place in tangents from the middle of a view: `2 tan(θ/2)` for `tan θ`.
pub fn stereographic(tangents: DVec2) -> DVec2 {
    2.0 * tangents / (1.0 + (1.0 + tangents.length_squared()).sqrt())
}

/// The picture in which a veil is spread: the view in the stereographic projection, half as fine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VeilSource {
    /// Texels, over the whole view and what the projection adds at its corners.
    pub size: [u32; 2],
    /// Texels a unit of the projection, which is a radian in the middle.
    pub texels_per_radian: f64,
}

impl VeilSource {
    /// That of a picture of this size with `pixels_per_radian` (positive) at its middle.
    pub fn new(pixels_per_radian: f64, size_px: [u32; 2]) -> Self {
        let texels_per_radian = 0.5 * pixels_per_radian;
        let size = size_px.map(|side| {
            let edge = 0.5 * f64::from(side.max(1)) / pixels_per_radian;
            let half = stereographic(DVec2::new(edge, 0.0)).x;
            ((2.0 * half * texels_per_radian).ceil() as u32).max(1)
        });
        Self {
            size,
            texels_per_radian,
        }
    }

    /// Last level that says more than its one texel does.
    pub fn last_level(&self) -> usize {
        let levels = self.size[0].max(self.size[1]).ilog2() as usize;
        levels.saturating_sub(1).min(VEIL_LEVELS - 1)
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

/// Samples along each axis of a texel of the source, as `shaders/view/present/veil_source.wgsl` takes them.
const SOURCE_SAMPLES: usize = 4;

/// What a light in the middle of a picture of `side` pixels becomes along one axis on each level of the
/// source, `count` texels long, up to `last`.
fn levels_along(side: usize, count: usize, pixels_per_texel: f64, last: usize) -> Vec<Vec<f64>> {
    let mut pixels = vec![0.0; side];
    for middle in [(side - 1) / 2, side / 2] {
        pixels[middle] += 0.5;
    }
    // Read from the picture's first mip, where there is one.
    let finest = if side > 1 { halved(&pixels) } else { pixels };
    let scale = finest.len() as f64 / side as f64;
    let read = |at: f64| {
        let (low, f) = (at.floor(), at - at.floor());
        let texel = |at: f64| finest[at.clamp(0.0, finest.len() as f64 - 1.0) as usize];
        texel(low) * (1.0 - f) + texel(low + 1.0) * f
    };
    let source = (0..count).map(|texel| {
        (0..SOURCE_SAMPLES)
            .map(|k| {
                let part = (k as f64 + 0.5) / SOURCE_SAMPLES as f64;
                let off = (texel as f64 + part - 0.5 * count as f64) * pixels_per_texel;
                read((0.5 * side as f64 + off) * scale - 0.5)
            })
            .sum::<f64>()
            / SOURCE_SAMPLES as f64
    });
    let mut levels: Vec<Vec<f64>> = vec![source.collect()];
    for _ in 0..last {
        let next = halved(levels.last().expect("one"));
        levels.push(next);
    }
    levels
}

/// What `shaders/view/present/veil.wgsl` reads of a level along one axis at a share of it, 0 to 1.
fn read_along(texels: &[f64], share: f64) -> f64 {
    let count = texels.len() as f64;
    let at = share * count - 0.5;
    let base = at.floor() - 3.0;
    (0..8)
        .map(|k| {
            let texel = base + f64::from(k);
            if (0.0..count).contains(&texel) {
                0.5 * cubic_spline(0.5 * (texel - at)) * texels[texel as usize]
            } else {
                0.0
            }
        })
        .sum()
}

/// Rings in which what is scattered less than is fitted is summed.
const NEAR_RINGS: usize = 32;

/// Where scattered light goes in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VeilKernel {
    /// Shares of it on the levels of the source. With `near` they are 1 at most; what they lack goes to what
    /// lies around the picture.
    pub weights: [f64; VEIL_LEVELS],
    /// Share of it that is scattered too little to leave its place.
    pub near: f64,
}

/// What clouded media scatter beyond a healthy eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veil {
    with: Glare,
    without: Glare,
    /// Straylight at 7° of the shape as it stands, deg² sr⁻¹.
    unit: f64,
    /// What is added to all of the light, deg² sr⁻¹ at 7°: of what is asked the share that belongs to the light that stays.
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
        // A straylight meter compares what is scattered with a light of its own that goes through the same media: what it
        // finds is relative to the light that they leave where it is (compensation comparison: Franssen, Coppens and van
        // den Berg 2006, Invest. Ophthalmol. Vis. Sci. 47, 768).
        let over_direct = energy * asked;
        let scattered = over_direct / (1.0 + over_direct);
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

    /// How the scattered light is spread over a picture of this size with `pixels_per_radian` at its middle.
    /// How much is scattered does not change it.
    pub fn kernel(&self, pixels_per_radian: f64, size_px: [u32; 2]) -> VeilKernel {
        let mut weights = [0.0; VEIL_LEVELS];
        if self.added == 0.0 {
            return VeilKernel { weights, near: 1.0 };
        }
        let source = VeilSource::new(pixels_per_radian, size_px);
        let last = source.last_level();
        let axes = [0, 1].map(|axis| {
            let side = size_px[axis].max(1) as usize;
            levels_along(side, source.size[axis] as usize, 2.0, last)
        });
        // What a level is at this place from the middle, as a mean over the directions in which the
        // picture goes so far.
        let at_level = |level: usize, u: f64| {
            let (mut sum, mut count) = (0.0, 0.0);
            for part in 0..8 {
                let angle = (f64::from(part) + 0.5) / 8.0 * FRAC_PI_2;
                let (sine, cosine) = angle.sin_cos();
                let share = [u * cosine, u * sine];
                let share: [f64; 2] = core::array::from_fn(|axis| {
                    0.5 + share[axis] * source.texels_per_radian / f64::from(source.size[axis])
                });
                if share[0].max(share[1]) < 1.0 {
                    sum += read_along(&axes[0][level], share[0])
                        * read_along(&axes[1][level], share[1]);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                let seen_at = 1.0 + 0.25 * u * u;
                seen_at * sum / count * pixels_per_radian * pixels_per_radian
            } else {
                0.0
            }
        };
        let first = FITTED_RAD.0.max(FIRST_TEXELS / source.texels_per_radian);
        // Each level over the function, at every angle.
        let rows: Vec<[f64; VEIL_LEVELS]> = (0..FITTED_ANGLES)
            .map(|i| {
                let share = i as f64 / (FITTED_ANGLES - 1) as f64;
                let theta = first * (FITTED_RAD.1.max(first) / first).powf(share);
                let u = 2.0 * (0.5 * theta).tan();
                let wanted = self.spread(theta) / self.scattered;
                core::array::from_fn(|level| {
                    if level <= last {
                        at_level(level, u) / wanted
                    } else {
                        0.0
                    }
                })
            })
            // Beyond the picture nothing is fitted.
            .filter(|row: &[f64; VEIL_LEVELS]| row.iter().any(|level| *level > 0.0))
            .collect();
        // A first guess: an octave of rings each, as in a law of θ⁻².
        for (level, weight) in weights.iter_mut().enumerate().take(last + 1) {
            *weight = 0.1;
            let sigma = SIGMA_TEXELS * 2f64.powi(level as i32) / source.texels_per_radian;
            // A level far wider than what is fitted has no say.
            if sigma > 4.0 {
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
        // What is scattered by less than that, and not drawn so, stays where it is.
        let step = first / NEAR_RINGS as f64;
        let drawn: f64 = (0..NEAR_RINGS)
            .map(|ring| {
                let theta = (ring as f64 + 0.5) * step;
                let u = 2.0 * (0.5 * theta).tan();
                let bells = weights.iter().enumerate().take(last + 1);
                let radiance: f64 = bells.map(|(level, w)| w * at_level(level, u)).sum();
                radiance * TAU * theta.sin() * step
            })
            .sum();
        let near = (self.energy_within(first) / self.scattered - drawn).clamp(0.0, 1.0);
        // No more than there is, should a picture be so coarse that its levels fit badly.
        let share = (weights.iter().sum::<f64>() + near).max(1.0);
        VeilKernel {
            weights: weights.map(|weight| weight / share),
            near: near / share,
        }
    }
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

    /// At every severity what a meter finds is what was asked.
    #[test]
    fn scattered_over_direct_light_is_the_straylight_that_was_asked() {
        for log_s in [0.5, 1.0, 1.4, 1.7, 2.0, 2.2, 2.5] {
            let asked = 10f64.powf(log_s);
            for pigment in [0.0, 0.5, 1.2] {
                let veil = Veil::new(asked, pigment);
                let direct = 1.0 - veil.scattered();
                let found = 49.0 * veil.spread(7f64.to_radians()) / direct;
                assert!((found / asked - 1.0).abs() < 1e-12, "{log_s}: {found}");
            }
        }
    }

    #[test]
    fn no_light_is_made_or_lost() {
        for straylight in [0.0, 0.5, 13.0, 90.0, 1e6, f64::NAN, -3.0, f64::INFINITY] {
            for pigment in [0.0, 0.5, 1.2] {
                let veil = Veil::new(straylight, pigment);
                let scattered = veil.scattered();
                assert!((0.0..=1.0).contains(&scattered));
                assert!((veil.energy_within(FRAC_PI_2) - scattered).abs() < 1e-9);
                let VeilKernel { weights, near } = veil.kernel(600.0, [640, 480]);
                let all = weights.iter().chain([&near]);
                assert!(all.clone().all(|share| share.is_finite() && *share >= 0.0));
                assert!(all.sum::<f64>() <= 1.0 + 1e-12);
            }
        }
    }

    /// What the levels of a picture hold is at least what the function has as far as the picture goes, and never
    /// more than there is. (Bells that reach past the picture hold some of what lies there, which the shader
    /// takes back.)
    #[test]
    fn the_kernel_has_the_energy_of_the_function() {
        let veil = Veil::new(10.0, 0.5);
        for (scale, size) in [
            (533.0, [640, 640]),
            (533.0, [480, 360]),
            (250.0, [320, 240]),
            (64.0, [100, 60]),
            (53.0, [320, 320]),
            (5000.0, [640, 480]),
        ] {
            let kernel = veil.kernel(scale, size);
            let held = kernel.near + kernel.weights.iter().sum::<f64>();
            let within = |angle: f64| veil.energy_within(angle) / veil.scattered();
            let side = 0.5 * f64::from(size[0].min(size[1]));
            let least = within((side / scale).atan().min(FITTED_RAD.1));
            println!(
                "{scale} {size:?}: {held:.3}, at least {least:.3}, near {:.3}",
                kernel.near
            );
            assert!(held > least - 0.03 && held < 1.0 + 1e-12, "{held}");
            assert!(kernel.near < within(FITTED_RAD.0.max(4.0 / scale)) + 1e-12);
        }
    }

    #[test]
    fn how_much_is_scattered_does_not_change_how_it_is_spread() {
        let of = |straylight| Veil::new(straylight, 0.5).kernel(500.0, [320, 240]).weights;
        for (little, much) in of(0.5).iter().zip(of(50.0)) {
            assert!((little - much).abs() < 1e-9, "{little} {much}");
        }
    }

    #[test]
    fn lights_aside_have_the_veil_of_one_in_the_middle() {
        // The bell of the middle, moved: exact for a law of the chord's inverse square, and the function
        // is near one. What is left of it over the whole of a wide view.
        let veil = Veil::new(10.0, 0.5);
        let place = |deg: f64| 2.0 * (0.5 * deg.to_radians()).tan();
        let scale = |u: f64| 1.0 + 0.25 * u * u;
        let mut worst = 0.0_f64;
        for light in [10.0, 20.0, 30.0, 40.0] {
            for seen in [-40.0, -20.0, -5.0, 0.0, 5.0, 35.0] {
                let angle = f64::to_radians(light - seen).abs();
                if !(1.0..=35.0).contains(&angle.to_degrees()) {
                    continue;
                }
                let (v, u) = (place(light), place(seen));
                // The function's middle, read at the same distance in the projection.
                let middle = 2.0 * (0.5 * (u - v).abs()).atan();
                let drawn = veil.spread(middle) / scale(u - v) * scale(u) * scale(v);
                worst = worst.max((drawn / veil.spread(angle) - 1.0).abs());
            }
        }
        println!("{worst}");
        assert!(worst < 0.04, "{worst}");
    }

    #[test]
    fn a_light_in_the_middle_keeps_its_light_on_every_level() {
        for side in [1, 2, 7, 64, 101, 640] {
            let levels = levels_along(side, side.div_ceil(2), 2.0, 3);
            for (level, line) in levels.iter().enumerate() {
                let sum: f64 = line.iter().sum::<f64>() * side as f64 / line.len() as f64;
                // The ends of a short picture stand for more of it.
                if side > 64 {
                    assert!((sum - 1.0).abs() < 2e-2, "{side} {level}: {sum}");
                }
                assert!(sum.is_finite());
            }
        }
    }

    #[test]
    fn a_source_holds_the_whole_view() {
        for (scale, size) in [(600.0, [640, 480]), (100.0, [1, 1]), (50.0, [4000, 30])] {
            let source = VeilSource::new(scale, size);
            for (texels, pixels) in source.size.into_iter().zip(size) {
                let half = 0.5 * f64::from(texels) / source.texels_per_radian;
                let edge = (0.5 * f64::from(pixels) / scale).atan();
                assert!(half >= 2.0 * (0.5 * edge).tan() - 1e-12);
            }
            assert!(source.last_level() < VEIL_LEVELS);
        }
    }
}
