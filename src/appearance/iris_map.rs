//! A seeded iris: stromal thickness, border pigment and surface relief over the whole annulus.
//!
//! In: [`IrisMapSettings`] and a size in texels. Out: an [`IrisMap`] over the angle fraction `u`
//! (one turn, wraps) and the radial fraction `v` (0 at the pupil's edge, 1 at the iris root).
//! Because `v` is the fraction of the *local* width, the relief stretches with the pupil as the
//! tissue does.
//!
//! Sources. Structures and where they lie: Hogan, Alvarado and Weddell, "Histology of the Human
//! Eye" (1971), as summarised by François et al., "Image-based modeling of the human eye" (2007),
//! section on the iris: two zones parted by the collarette, crypts of Fuchs on both sides of it,
//! contraction furrows midway to the root, small crypts at the root, the pupillary ruff. Global
//! thickness: François' figure 5, that is Pavlin, Harasiewicz and Foster (1992): ID1 0.372 mm half
//! a millimetre from the root, ID2 0.457 mm two millimetres from it, ID3 0.645 mm at the thickest
//! place near the pupil.
//!
//! How. The stroma is built the way it is: strands are laid one by one into a height field. A
//! common flow makes neighbours crowd into trabeculae and part again, crypts push the strands
//! aside, so each opening is bordered by the very fibres that it displaced, and a deep layer of
//! fine strands shows on its floor.

use crate::frame::mips::{Level, chain};
use core::f32::consts::TAU;

use serde::{Deserialize, Serialize};

mod canvas;
mod layout;
mod pigment;
mod strands;
mod stroma;
#[cfg(test)]
mod tests;

use canvas::{Canvas, Grid};
use layout::Layout;
pub use stroma::IrisStroma;

use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{lerp, value_noise};

/// Pupil radius, mm, at which widths in millimetres are laid out.
pub const DESIGN_PUPIL_RADIUS_MM: f32 = 1.75;
/// Radius of the iris root, mm.
pub const ROOT_RADIUS_MM: f32 = 5.85;
/// Width of the annulus at the design pupil, mm.
pub const DESIGN_WIDTH_MM: f32 = ROOT_RADIUS_MM - DESIGN_PUPIL_RADIUS_MM;
/// The thinnest stroma a map holds, mm.
pub const MIN_THICKNESS_MM: f32 = 0.03;
/// The thickest stroma a map holds, mm: ID3 plus about one of its standard deviations.
pub const MAX_THICKNESS_MM: f32 = 0.78;

/// Depth of the contraction furrows at the design pupil, mm.
const FURROW_MM: f32 = 0.045;
/// How much of a thickness difference shows at the front: openings also indent from behind.
const RELIEF_SHARE: f32 = 0.38;
/// How much stouter than its neighbours a stout place of the stroma is, as a power of the strands laid there: calibrated
/// to how much the lightness of irises varies in photographs (`measure looks`).
const CONTRAST: f32 = 2.0;

/// What kind of iris to grow. Values out of range are brought to the nearest legal one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IrisMapSettings {
    /// Which individual: every seed is another iris.
    pub seed: u32,
    /// Mean place of the collarette, fraction of the width, 0.2–0.5.
    pub collarette_radius: f32,
    /// How far the collarette zig-zags, 0 (nearly round) – 1.
    pub collarette_irregularity: f32,
    /// How open the stroma is, 0 (no crypts) – 1 (lacunar).
    pub crypt_density: f32,
    /// Strands of the middle layer round the ciliary zone, 60–1200; other layers follow it.
    pub fibre_count: u32,
    /// How much the strands wave, 0 – 1; high in eyes with a wide pupil.
    pub waviness: f32,
    /// Contraction furrows, 0–8.
    pub furrow_count: u32,
    /// Pigment gathered round the collarette, 0 – 1.
    pub central_heterochromia: f32,
    /// Density of the melanin of that ring in that of freckles, 0–1; no less than the border layer's own.
    pub ring_melanin: f32,
    /// Freckles on the border layer, 0–80.
    pub freckle_count: u32,
    /// Density of the border layer's own melanin in that of freckles and of another colour's sector, 0–1.
    pub own_melanin: f32,
    /// Middle, as a fraction of a turn, and half-width of a sector as dense as a brown iris's; no width: none.
    pub sector: [f32; 2],
    /// How much the anterior border layer mats the strands over, 0 (blue, bare trabeculae) – 1
    /// (dark brown, velvet).
    pub border_layer_cover: f32,
}

impl Default for IrisMapSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            collarette_radius: 0.33,
            collarette_irregularity: 0.6,
            crypt_density: 0.5,
            fibre_count: 420,
            waviness: 0.5,
            furrow_count: 4,
            central_heterochromia: 0.3,
            ring_melanin: 0.0,
            freckle_count: 5,
            own_melanin: 1.0,
            sector: [0.0; 2],
            border_layer_cover: 0.15,
        }
    }
}

fn unit_or(value: f32, fallback: f32) -> f32 {
    if value.is_finite() {
        value.clamp(0.0, 1.0)
    } else {
        fallback
    }
}

impl IrisMapSettings {
    /// The same settings with every field inside its documented range; a field that is not a
    /// number takes its default.
    #[must_use]
    pub fn clamped(&self) -> Self {
        let default = Self::default();
        let collarette_radius = if self.collarette_radius.is_finite() {
            self.collarette_radius.clamp(0.2, 0.5)
        } else {
            default.collarette_radius
        };
        Self {
            seed: self.seed,
            collarette_radius,
            collarette_irregularity: unit_or(
                self.collarette_irregularity,
                default.collarette_irregularity,
            ),
            crypt_density: unit_or(self.crypt_density, default.crypt_density),
            fibre_count: self.fibre_count.clamp(60, 1200),
            waviness: unit_or(self.waviness, default.waviness),
            furrow_count: self.furrow_count.min(8),
            central_heterochromia: unit_or(
                self.central_heterochromia,
                default.central_heterochromia,
            ),
            ring_melanin: unit_or(self.ring_melanin, default.ring_melanin),
            freckle_count: self.freckle_count.min(80),
            own_melanin: unit_or(self.own_melanin, default.own_melanin),
            sector: self.sector.map(|turns| unit_or(turns, 0.0)),
            border_layer_cover: unit_or(self.border_layer_cover, default.border_layer_cover),
        }
    }

    /// The same stroma, bare.
    fn without_pigment(&self) -> Self {
        Self {
            central_heterochromia: 0.0,
            ring_melanin: 0.0,
            freckle_count: 0,
            own_melanin: 0.0,
            sector: [0.0; 2],
            border_layer_cover: 0.0,
            ..self.clone()
        }
    }
}

/// One place on the iris.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IrisTexel {
    /// Stromal thickness, mm, [`MIN_THICKNESS_MM`]–[`MAX_THICKNESS_MM`].
    pub thickness_mm: f32,
    /// Relative melanin density of the anterior border layer, 0–1; the patient's colour scales it.
    pub border_melanin: f32,
    /// Front surface above the smooth mean surface without the furrows, mm, positive towards the cornea, about
    /// −0.6 to 0.4.
    pub height_mm: f32,
    /// How deep the contraction furrows fold the surface at the design pupil, mm; negative between them.
    pub furrow_mm: f32,
}

/// The baked map: rows from the pupil's edge outwards, each row one turn.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisMap {
    /// Texels along the angle; texel `i` is centred on `u = (i + 0.5) / width`.
    pub width: usize,
    /// Texels along the radius; texel `j` is centred on `v = (j + 0.5) / height`.
    pub height: usize,
    /// `thickness_mm, border_melanin, height_mm, furrow_mm`, row after row: upload as RGBA floats.
    pub texels: Vec<[f32; 4]>,
}

impl IrisMap {
    /// Grows the iris of `settings` on `width` (angle, at least 16) by `height` (radius, at least
    /// 8) texels; sizes are clamped to 8192. The same settings and size give the same map.
    #[must_use]
    pub fn new(settings: &IrisMapSettings, width: usize, height: usize) -> Self {
        IrisStroma::new(settings, width, height).pigmented(settings)
    }

    /// The bilinear value at angle fraction `u` (any number of turns) and radial fraction `v`
    /// (clamped to 0–1).
    #[must_use]
    pub fn sample(&self, u: f32, v: f32) -> IrisTexel {
        let x = (u - u.floor()) * self.width as f32 - 0.5;
        let y = (v.clamp(0.0, 1.0) * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        let (left, top) = (x.floor(), y.floor());
        let column = |offset: i64| (left as i64 + offset).rem_euclid(self.width as i64) as usize;
        let row = |offset: usize| (top as usize + offset).min(self.height - 1);
        let at = |i: usize, j: usize| self.texels[j * self.width + i];
        let mut mixed = [0.0; 4];
        for (channel, value) in mixed.iter_mut().enumerate() {
            let upper = lerp(
                at(column(0), row(0))[channel],
                at(column(1), row(0))[channel],
                x - left,
            );
            let lower = lerp(
                at(column(0), row(1))[channel],
                at(column(1), row(1))[channel],
                x - left,
            );
            *value = lerp(upper, lower, y - top);
        }
        IrisTexel {
            thickness_mm: mixed[0],
            border_melanin: mixed[1],
            height_mm: mixed[2],
            furrow_mm: mixed[3],
        }
    }

    /// Its levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> Vec<Level<4>> {
        chain((self.width, self.height), self.texels.clone())
    }
}

/// Mean stromal thickness, mm, at radial fraction `v`: through ID3 at its thickest place near the
/// pupil, ID2 2 mm and ID1 0.5 mm from the root (of a 4.1 mm wide iris), thinning to both rims.
#[must_use]
pub fn mean_thickness_mm(v: f32) -> f32 {
    const KNOTS: [(f32, f32); 5] = [
        (0.0, 0.40),
        (0.16, 0.645),
        (1.0 - 2.0 / DESIGN_WIDTH_MM, 0.457),
        (1.0 - 0.5 / DESIGN_WIDTH_MM, 0.372),
        (1.0, 0.30),
    ];
    let v = v.clamp(0.0, 1.0);
    let upper = KNOTS
        .iter()
        .position(|knot| v <= knot.0)
        .unwrap_or(4)
        .max(1);
    let (start, end) = (KNOTS[upper - 1], KNOTS[upper]);
    let t = (v - start.0) / (end.0 - start.0);
    // Half linear, half eased: no kink that would show as a ring.
    lerp(start.1, end.1, 0.5 * t + 0.5 * smoothstep(0.0, 1.0, t))
}

/// Local radius, mm, at radial fraction `v` of the design pupil.
fn radius_mm(v: f32) -> f32 {
    DESIGN_PUPIL_RADIUS_MM + DESIGN_WIDTH_MM * v
}

/// Turns per millimetre of arc at radial fraction `v`.
fn turns_per_mm(v: f32) -> f32 {
    1.0 / (TAU * radius_mm(v))
}

/// Mean of each row and its neighbours, at least 0.05.
fn zone_means(values: &[f32], grid: Grid) -> Vec<f32> {
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let rows: Vec<f32> = values.chunks(grid.width).map(mean).collect();
    let reach = (grid.height / 14).max(1);
    let around = |j: usize| j.saturating_sub(reach)..(j + reach + 1).min(grid.height);
    (0..grid.height)
        .map(|j| mean(&rows[around(j)]).max(0.05))
        .collect()
}

/// Scales relative relief so that each zone's mean is the published one, keeping local detail.
fn scale_to_profile(surface: &Canvas, layout: &Layout) -> Vec<f32> {
    let grid = surface.grid;
    let mut thickness = surface.relief.clone();
    let means = zone_means(&thickness, grid);
    for (j, (row, mean)) in thickness.chunks_mut(grid.width).zip(means).enumerate() {
        // Where all of it is stout nothing stands out.
        let profile = mean_thickness_mm(grid.v(j));
        let contrast = lerp(CONTRAST, 1.0, smoothstep(0.4, 0.62, profile));
        for value in row {
            let relative = (*value / mean).max(0.0);
            // Openings are as thin as they were laid.
            let solid = smoothstep(0.45, 0.85, relative);
            *value = lerp(relative, relative.powf(contrast), solid);
        }
    }
    let means = zone_means(&thickness, grid);
    for (j, row) in thickness.chunks_mut(grid.width).enumerate() {
        let profile = mean_thickness_mm(grid.v(j));
        for (i, value) in row.iter_mut().enumerate() {
            let groove = 1.0 - 0.10 * layout.furrow[j * grid.width + i].max(0.0);
            *value = soft_limit(profile / means[j] * *value * groove);
        }
    }
    thickness
}

/// Bends what exceeds 0.6 mm smoothly under [`MAX_THICKNESS_MM`].
fn soft_limit(thickness_mm: f32) -> f32 {
    const KNEE_MM: f32 = 0.6;
    let limited = if thickness_mm > KNEE_MM {
        let room = MAX_THICKNESS_MM - KNEE_MM;
        let excess = thickness_mm - KNEE_MM;
        KNEE_MM + room * excess / (room + excess)
    } else {
        thickness_mm
    };
    limited.clamp(MIN_THICKNESS_MM, MAX_THICKNESS_MM)
}

/// The front surface above the smooth mean surface, mm. A thin cellular layer rounds the strands
/// off. Furrows, which are folds, are kept apart.
fn front_surface(thickness: &[f32], grid: Grid) -> Vec<f32> {
    let mut relief = thickness.to_vec();
    canvas::blur(&mut relief, grid, 0.05, 0.05);
    for (index, value) in relief.iter_mut().enumerate() {
        let sharp = lerp(*value, thickness[index], 0.3);
        let v = grid.v(index / grid.width);
        *value = RELIEF_SHARE * (sharp - mean_thickness_mm(v));
    }
    relief
}

fn texel_at(
    seed: u32,
    thickness: &[f32],
    melanin: &[f32],
    (relief, furrow): (&[f32], f32),
    grid: Grid,
    index: usize,
) -> [f32; 4] {
    let (u, v) = (grid.u(index % grid.width), grid.v(index / grid.width));
    let ruff = ruff_at(seed, u, v);
    [
        lerp(thickness[index], MIN_THICKNESS_MM, ruff).max(MIN_THICKNESS_MM),
        lerp(melanin[index], 1.0, ruff).clamp(0.0, 1.0),
        // The ruff is a rounded rim of epithelium that rolls round the edge from behind.
        lerp(relief[index], -0.05 + 0.04 * ruff, ruff),
        furrow * (1.0 - ruff),
    ]
}

/// The ruff's coverage: a rim of about 0.1 mm, scalloped into uneven beads.
fn ruff_at(seed: u32, u: f32, v: f32) -> f32 {
    if v > 0.08 {
        return 0.0;
    }
    let seed = seed ^ 0x7f4a;
    let warp = 0.8 * value_noise(u * 40.0, 40, seed ^ 5);
    // Uneven beads, some of them missing.
    let size = 0.5 + 0.5 * value_noise(u * 29.0, 29, seed ^ 2);
    let bead = ((u * 84.0 + 2.6 * warp) * TAU).cos() * 1.6 * size;
    let girth = 0.024
        + 0.009 * value_noise(u * 13.0, 13, seed)
        + 0.007 * value_noise(u * 57.0, 57, seed ^ 1);
    let edge = (girth + 0.003 * bead).max(0.008);
    smoothstep(edge + 0.008, edge - 0.008, v)
}
