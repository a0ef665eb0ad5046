//! The view as it is blurred: retinal blur in angles, the Gaussian gather, and the lids.
//!
//! Enters: linear radiance, vergence and a blur diameter for every pixel. Leaves: the linear radiance
//! that is seen. [`reference_gather`] is the f64 reference over every pixel of each kernel, against
//! which the taps of `shaders/view/present/gather.wgsl` are measured; the functions above it are the twins of
//! `shaders/lib/retinal_blur.wgsl`, `gaussian_disc.wgsl` and `eyelid_view.wgsl`.
//!
//! Nießner et al. 2013, section 5, blur by a Gaussian whose deviation follows each pixel's circle of
//! confusion. Here σ = d/4: a uniform disc of diameter d has the variance d²/16 along each axis, so
//! the Gaussian is as wide as the disc that it stands for.
//!
//! A nearer tap reaches only as far as its own blur does (sharp near edges do not bleed onto far
//! blur), and blurred nearer surfaces are laid over what is behind them with the coverage that their
//! own Gaussians give (near blur spreads over far sharpness).

use super::gather_ellipse::ellipse_variances;
use crate::optics::smoothstep::smoothstep;

/// Deviations at which the window of the taps reaches zero.
pub const GAUSSIAN_WINDOW: f64 = 3.4;
/// The Gaussian there, which the window subtracts: e^(−3.4²/2).
pub const GAUSSIAN_WINDOW_EDGE: f64 = 0.003_088_715_4;
/// Variance of the windowed Gaussian, over its deviation squared.
pub const GAUSSIAN_WINDOW_VARIANCE: f64 = 0.967_417_605;
/// Most pairs of texels along each side.
pub const GAUSSIAN_PAIRS_MAX: u32 = 6;
/// Radius, in the largest σ around, within which nearer surfaces spread over farther ones.
pub const SPREAD_RADIUS: f64 = 2.4;
/// Largest σ (pixels) that four bilinear taps make.
pub const SMALL_DISC_SIGMA_PX: f64 = 0.7;
/// Blur diameter (pixels) under which a pixel is copied.
pub const COPY_DIAMETER_PX: f64 = 0.5;
/// Largest σ (pixels) with which nearer surfaces spread over farther ones: 2.4 σ is one tile.
pub const SPREAD_SIGMA_MAX_PX: f64 = 6.7;

/// Blur (rad) that the healthy retina adds at an eccentricity (rad): `floor_rad` at the fovea,
/// growing in proportion and doubled at `e2_rad`.
pub fn neural_blur(eccentricity_rad: f64, floor_rad: f64, e2_rad: f64) -> f64 {
    floor_rad * (1.0 + eccentricity_rad / e2_rad)
}

/// Independent blurs together: variances add.
pub fn combined_blur(a_rad: f64, b_rad: f64) -> f64 {
    (a_rad * a_rad + b_rad * b_rad).sqrt()
}

/// Unit direction, in the view's frame (+x right, +y up, looking along −z), of a place in pixels
/// from the image's top left corner.
pub fn view_ray(place_px: [f64; 2], size_px: [f64; 2], tan_half_fov: [f64; 2]) -> [f64; 3] {
    let x = (2.0 * place_px[0] / size_px[0] - 1.0) * tan_half_fov[0];
    let y = (1.0 - 2.0 * place_px[1] / size_px[1]) * tan_half_fov[1];
    let length = (x * x + y * y + 1.0).sqrt();
    [x / length, y / length, -1.0 / length]
}

/// Angle (rad) between unit vectors, exact for small angles.
pub fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord2: f64 = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum();
    2.0 * (0.5 * chord2.sqrt()).min(1.0).asin()
}

/// Place (rad) of a direction in the visual field around the fixation, as perimetry draws it: the
/// length is the eccentricity, +x right and +y up.
pub fn perimetric_angles(direction: [f64; 3], fixation: [f64; 3]) -> [f64; 2] {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
    let across = (fixation[2] * fixation[2] + fixation[0] * fixation[0])
        .sqrt()
        .max(1e-12);
    let right = [-fixation[2] / across, 0.0, fixation[0] / across];
    let up = [
        right[1] * fixation[2] - right[2] * fixation[1],
        right[2] * fixation[0] - right[0] * fixation[2],
        right[0] * fixation[1] - right[1] * fixation[0],
    ];
    let (x, y) = (dot(direction, right), dot(direction, up));
    let scale = angle_between(direction, fixation) / x.hypot(y).max(1e-12);
    [x * scale, y * scale]
}

/// Weight in the window of a place where the Gaussian has this value.
pub fn gaussian_window(gaussian: f64) -> f64 {
    (gaussian - GAUSSIAN_WINDOW_EDGE).max(0.0)
}

/// The Gaussian of this deviation at a distance (texels), by what it is multiplied one texel
/// further, and by what that factor is multiplied.
pub fn gaussian_steps(distance: f64, deviation: f64) -> [f64; 3] {
    let inverse2 = 1.0 / (deviation * deviation);
    [0.5 * distance * distance, distance + 0.5, 1.0].map(|x| (-inverse2 * x).exp())
}

/// Deviation (texels of the level) of the window such that window and level together have
/// `sigma_px`. A level of the mips, each the one before under (1, 3, 3, 1)/8, has the variance
/// (4^level − 1)/4.
pub fn gaussian_disc_deviation(sigma_px: f64, level: f64) -> f64 {
    let inverse2 = (-2.0 * level).exp2();
    let whole = sigma_px * sigma_px * inverse2;
    let own = (whole - 0.25 * (1.0 - inverse2)).max(0.15 * whole);
    (own / GAUSSIAN_WINDOW_VARIANCE).sqrt()
}

/// Pairs of texels along each side that such a window covers.
pub fn gaussian_disc_pairs(deviation: f64) -> u32 {
    (GAUSSIAN_WINDOW * deviation).clamp(1.0, 1e4).ceil() as u32
}

/// Mip level: the finest on which no more pairs than these are needed.
pub fn gaussian_disc_level(sigma_px: f64, pairs: u32) -> f64 {
    let first = (sigma_px.max(1.0).log2().floor() - 1.0).max(0.0);
    let fits =
        |level: &f64| gaussian_disc_pairs(gaussian_disc_deviation(sigma_px, *level)) <= pairs;
    let levels = [first, first + 1.0, first + 2.0];
    levels.into_iter().find(fits).unwrap_or(first + 3.0)
}

/// Pairs along each side that a budget of taps allows.
pub fn gaussian_disc_budget(max_taps: u32) -> u32 {
    max_taps.isqrt().clamp(4, GAUSSIAN_PAIRS_MAX)
}

/// Taps that a blur of this σ (pixels) takes: 0 (a copy), 4, or a square.
pub fn gaussian_disc_taps(sigma_px: f64, max_taps: u32) -> u32 {
    if sigma_px < 0.25 * COPY_DIAMETER_PX {
        return 0;
    }
    if sigma_px <= SMALL_DISC_SIGMA_PX {
        return 4;
    }
    let level = gaussian_disc_level(sigma_px, gaussian_disc_budget(max_taps));
    gaussian_disc_pairs(gaussian_disc_deviation(sigma_px, level)).pow(2)
}

/// Taps with which nearer surfaces of this σ (pixels) spread over farther ones.
pub fn spread_taps(sigma_px: f64, max_taps: u32) -> u32 {
    (20 + (1.5 * sigma_px).min(1e4) as u32).min(max_taps.max(20))
}

/// Mip level whose texel is the spacing of those taps.
pub fn spread_level(sigma_px: f64, taps: u32) -> f64 {
    let spacing = SPREAD_RADIUS * sigma_px * (std::f64::consts::PI / f64::from(taps.max(1))).sqrt();
    (spacing.max(1.0).log2() + 0.6).floor().max(0.0)
}

/// How far the anterior edge of a lid's margin stands before the posterior one, mm.
const LID_MARGIN_MM: f64 = 2.0;

/// Share of a disc of radius 1 that lies below a line at this height.
pub fn disc_below(height: f64) -> f64 {
    let u = height.clamp(-1.0, 1.0);
    0.5 + (u.asin() + u * (1.0 - u * u).sqrt()) / std::f64::consts::PI
}

/// Share of the light of a direction that passes between the lids to a pupil of this radius (mm): the
/// direction rises by `slope`; `upper` and `lower` are the posterior edges of the margins, mm up and
/// ahead of the pupil's middle ([`crate::appearance::lid_edges`]).
pub fn eyelid_transmission(slope: f64, upper: [f64; 2], lower: [f64; 2], pupil_mm: f64) -> f64 {
    let r = pupil_mm.max(0.05);
    let thick = LID_MARGIN_MM * slope;
    let above = (upper[0] - upper[1] * slope - thick.max(0.0)) / r;
    let below = (lower[0] - lower[1] * slope - thick.min(0.0)) / r;
    (disc_below(above) - disc_below(below)).max(0.0)
}

/// 0 where a tap lies at the pixel's vergence (D) or behind it, 1 where it is clearly nearer.
pub fn nearness(tap_vergence_d: f64, vergence_d: f64) -> f64 {
    smoothstep(
        0.05,
        0.15,
        (tap_vergence_d - vergence_d) / (tap_vergence_d + 0.2),
    )
}

/// A view to be blurred, row by row.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear radiance.
    pub radiance: &'a [[f32; 3]],
    /// Vergence along the ray, D.
    pub vergence_d: &'a [f32],
    /// Blur diameter, pixels.
    pub blur_px: &'a [f32],
    /// How blur is longer than wide, where it has a direction.
    pub astigmatism: Option<Elongated<'a>>,
}

/// Blur of an astigmatic eye.
#[derive(Clone, Copy, Debug)]
pub struct Elongated<'a> {
    /// Elongation of every pixel's blur, −1 to 1 ([`crate::optics::defocus::astigmatic_blur`]).
    pub elongation: &'a [f32],
    /// Direction of the minus cylinder's axis in the image: from its columns towards its rows, which run
    /// down, rad.
    pub axis_rad: f64,
}

/// A blur: its deviations, pixels², along an axis of the image and across it.
#[derive(Clone, Copy)]
struct Kernel {
    variances: [f64; 2],
    axis: [f64; 2],
}

impl Kernel {
    fn exponent(&self, dx: f64, dy: f64) -> f64 {
        let along = dx * self.axis[0] + dy * self.axis[1];
        let across = dx * self.axis[1] - dy * self.axis[0];
        -0.5 * (along * along / self.variances[0] + across * across / self.variances[1])
    }

    /// The Gaussian at an offset, 1 in its middle.
    fn at(&self, dx: f64, dy: f64) -> f64 {
        self.exponent(dx, dy).exp()
    }

    /// Its integral over all pixels.
    fn area(&self) -> f64 {
        std::f64::consts::TAU * (self.variances[0] * self.variances[1]).sqrt()
    }

    fn longest_px(&self) -> f64 {
        self.variances[0].max(self.variances[1]).sqrt()
    }
}

impl View<'_> {
    fn is_consistent(&self) -> bool {
        let pixels = self.width.checked_mul(self.height);
        let elongation = self.astigmatism.map(|of| of.elongation.len());
        [
            self.radiance.len(),
            self.vergence_d.len(),
            self.blur_px.len(),
            elongation.unwrap_or(self.blur_px.len()),
        ]
        .iter()
        .all(|n| Some(*n) == pixels)
    }

    fn sigma_px(&self, at: usize) -> f64 {
        0.25 * f64::from(self.blur_px[at])
    }

    /// A pixel's blur; each deviation at least `least_px`.
    fn kernel(&self, at: usize, least_px: f64) -> Kernel {
        let elongation = self.astigmatism.map_or(0.0, |of| of.elongation[at].into());
        let (sin, cos) = self.astigmatism.map_or(0.0, |of| of.axis_rad).sin_cos();
        let variances = ellipse_variances(self.blur_px[at].into(), elongation);
        Kernel {
            variances: variances.map(|variance| variance.max(least_px * least_px)),
            axis: [cos, sin],
        }
    }

    /// Calls `visit(pixel, [dx, dy])` for every place within a radius, pixels beyond the border being the
    /// border's own.
    fn around(&self, x: usize, y: usize, radius_px: f64, mut visit: impl FnMut(usize, [f64; 2])) {
        let reach = radius_px.ceil() as isize;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let distance2 = (dx * dx + dy * dy) as f64;
                if distance2 <= radius_px * radius_px {
                    let column = x.saturating_add_signed(dx).min(self.width - 1);
                    let row = y.saturating_add_signed(dy).min(self.height - 1);
                    visit(row * self.width + column, [dx as f64, dy as f64]);
                }
            }
        }
    }
}

/// What is seen of a view, in f64, over every pixel of every kernel; empty when the view's slices do
/// not have one entry a pixel. Slow: for tests and error images.
pub fn reference_gather(view: &View<'_>) -> Vec<[f64; 3]> {
    if !view.is_consistent() {
        return Vec::new();
    }
    let mut seen = Vec::with_capacity(view.radiance.len());
    for y in 0..view.height {
        for x in 0..view.width {
            let own = gather_own(view, x, y);
            seen.push(spread_near(view, x, y, own));
        }
    }
    seen
}

/// Mean under the pixel's own Gaussian, nearer pixels reaching only as far as their own blur.
fn gather_own(view: &View<'_>, x: usize, y: usize) -> [f64; 3] {
    let at = y * view.width + x;
    let centre = view.radiance[at].map(f64::from);
    let own = view.kernel(at, 1e-9);
    if own.longest_px() < 0.25 * COPY_DIAMETER_PX {
        return centre;
    }
    let vergence = f64::from(view.vergence_d[at]);
    // The pixel itself always counts a little, so that the sum of weights is never zero.
    let (mut sum, mut total) = (centre.map(|c| 1e-3 * c), 1e-3);
    view.around(x, y, 5.0 * own.longest_px(), |tap, [dx, dy]| {
        let mut weight = own.at(dx, dy);
        let near = nearness(f64::from(view.vergence_d[tap]), vergence);
        if near > 0.0 && (dx, dy) != (0.0, 0.0) {
            let mut reach = view.kernel(tap, 0.0);
            for (narrow, wide) in reach.variances.iter_mut().zip(own.variances) {
                *narrow = narrow.clamp(0.09_f64.min(wide), wide);
            }
            weight += (reach.at(dx, dy) - weight) * near;
        }
        for (s, c) in sum.iter_mut().zip(view.radiance[tap]) {
            *s += weight * f64::from(c);
        }
        total += weight;
    });
    sum.map(|s| s / total)
}

/// Nearer blurred pixels laid over a pixel, each spreading its light over its own Gaussian.
fn spread_near(view: &View<'_>, x: usize, y: usize, own: [f64; 3]) -> [f64; 3] {
    let at = y * view.width + x;
    let vergence = f64::from(view.vergence_d[at]);
    let sigma = view.sigma_px(at).max(0.5);
    let radius = SPREAD_RADIUS * SPREAD_SIGMA_MAX_PX;
    let (mut covered, mut alpha) = ([0.0; 3], 0.0);
    view.around(x, y, radius, |tap, [dx, dy]| {
        let near = nearness(f64::from(view.vergence_d[tap]), vergence);
        if near > 0.0 && view.sigma_px(tap) > sigma {
            let kernel = view.kernel(tap, 1e-9);
            let weight = near * kernel.at(dx, dy) / kernel.area();
            for (s, c) in covered.iter_mut().zip(view.radiance[tap]) {
                *s += weight * f64::from(c);
            }
            alpha += weight;
        }
    });
    let cover = alpha.min(1.0);
    std::array::from_fn(|i| own[i] + (covered[i] / alpha.max(1e-12) - own[i]) * cover)
}

#[cfg(test)]
mod tests;
