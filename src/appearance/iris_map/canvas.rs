//! The height field that strands are laid into.
//!
//! In: strands (a path, a girth in millimetres, a height). Out: relative relief per texel and the
//! tag of the strand that lies on top there.

use super::{DESIGN_WIDTH_MM, turns_per_mm};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{lerp, value_noise};

/// The narrowest strand that the texels can carry without breaking into dashes.
const MIN_HALF_TEXELS: f32 = 1.3;

/// Size of a map and the place of its texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
}

impl Grid {
    pub fn len(self) -> usize {
        self.width * self.height
    }

    pub fn u(self, column: usize) -> f32 {
        (column as f32 + 0.5) / self.width as f32
    }

    pub fn v(self, row: usize) -> f32 {
        (row as f32 + 0.5) / self.height as f32
    }

    /// The rows whose centres lie between two radial fractions.
    pub fn rows(self, from: f32, to: f32) -> core::ops::Range<usize> {
        let at = |v: f32| {
            (v * self.height as f32 - 0.5)
                .ceil()
                .clamp(0.0, self.height as f32)
        };
        let start = at(from) as usize;
        start..(at(to) as usize).max(start)
    }

    pub fn wrap_column(self, column: i64) -> usize {
        column.rem_euclid(self.width as i64) as usize
    }
}

/// One strand: where it starts and ends, how thick and how high it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strand {
    pub v: [f32; 2],
    pub half_width_mm: f32,
    /// Relief of its crest, relative (1 = the highest trabeculae).
    pub crest: f32,
    /// Radial fractions over which it thins out and sinks, at the inner and the outer end.
    pub taper: [f32; 2],
    /// A number in 0–1 that names the strand.
    pub tag: f32,
    pub seed: u32,
}

/// Relief and strand tags over a grid.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    pub grid: Grid,
    pub relief: Vec<f32>,
    pub tag: Vec<f32>,
}

impl Canvas {
    pub fn new(grid: Grid, relief: f32) -> Self {
        Self {
            grid,
            relief: vec![relief; grid.len()],
            tag: vec![0.5; grid.len()],
        }
    }

    /// Lays a strand that follows `path(v)`, turns, from `strand.v[0]` to `strand.v[1]`.
    pub fn lay(&mut self, strand: &Strand, path: impl Fn(f32) -> f32) {
        // The path is smooth: a few rows apart is enough, in between a straight line.
        let step = (self.grid.height / 128).max(1);
        let rows = self.grid.rows(strand.v[0], strand.v[1]);
        let (mut from, mut here) = (rows.start, None);
        while from < rows.end {
            let to = (from + step).min(rows.end);
            let start = here.unwrap_or_else(|| path(self.grid.v(from)));
            let end = path(self.grid.v(to));
            for row in from..to {
                let t = (row - from) as f32 / (to - from) as f32;
                self.lay_row(strand, row, lerp(start, end, t));
            }
            here = Some(end);
            from = to;
        }
    }

    fn lay_row(&mut self, strand: &Strand, row: usize, u: f32) {
        let v = self.grid.v(row);
        let end = smoothstep(0.0, strand.taper[0].max(1e-4), v - strand.v[0])
            * smoothstep(0.0, strand.taper[1].max(1e-4), strand.v[1] - v);
        let girth = 1.0 + 0.3 * value_noise(v * 9.0, 0, strand.seed);
        let crest = strand.crest * (1.0 + 0.10 * value_noise(v * 7.0 + 31.0, 0, strand.seed));
        let width = self.grid.width as f32;
        let half = strand.half_width_mm * girth * (0.35 + 0.65 * end) * turns_per_mm(v) * width;
        // Thinner than a texel: keep the texel, lose contrast instead.
        let strength = end * (half / MIN_HALF_TEXELS).min(1.0);
        let half = half.max(MIN_HALF_TEXELS);
        let centre = u * width - 0.5;
        let (first, last) = (
            (centre - half).ceil() as i64,
            (centre + half).floor() as i64,
        );
        for column in first..=last {
            let across = (column as f32 - centre) / half;
            let index = row * self.grid.width + self.grid.wrap_column(column);
            self.raise(index, crest, across * across, strength, strand.tag);
        }
    }

    /// Lays a band that runs round the iris along `path(u)`, with a crest and half-width along it.
    pub fn lay_ring(
        &mut self,
        tag: f32,
        path: impl Fn(f32) -> f32,
        shape: impl Fn(f32) -> (f32, f32),
    ) {
        for column in 0..self.grid.width {
            let u = self.grid.u(column);
            let (crest, half_width_mm) = shape(u);
            let half = half_width_mm / DESIGN_WIDTH_MM * self.grid.height as f32;
            let strength = (half / MIN_HALF_TEXELS).min(1.0);
            let half = half.max(MIN_HALF_TEXELS);
            let centre = path(u) * self.grid.height as f32 - 0.5;
            let first = (centre - half).ceil().max(0.0) as usize;
            let last = ((centre + half).floor() as usize).min(self.grid.height - 1);
            for row in first..=last {
                let across = (row as f32 - centre) / half;
                let index = row * self.grid.width + column;
                self.raise(index, crest, across * across, strength, tag);
            }
        }
    }

    fn raise(&mut self, index: usize, crest: f32, across2: f32, strength: f32, tag: f32) {
        let top = crest * (1.0 - 0.22 * across2);
        let old = self.relief[index];
        if top > old {
            // Translucent edges: full cover only along the axis.
            let inside = (1.0 - across2).max(0.0);
            let cover = inside * (2.0 - inside) * strength;
            self.relief[index] = lerp(old, top, cover);
            if cover > 0.4 {
                self.tag[index] = tag;
            }
        }
    }
}

/// A slowly varying field: `f(u, v)` at every fourth texel each way, bilinear in between.
pub(super) fn slow_field(grid: Grid, f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    const STEP: usize = 4;
    let (columns, rows) = (grid.width.div_ceil(STEP), grid.height / STEP + 2);
    let coarse: Vec<f32> = (0..columns * rows)
        .map(|k| {
            f(
                (k % columns) as f32 / columns as f32,
                (k / columns * STEP) as f32 / grid.height as f32,
            )
        })
        .collect();
    let mut field = Vec::with_capacity(grid.len());
    for j in 0..grid.height {
        let y = (j as f32 + 0.5) / STEP as f32;
        let (top, ty) = (y as usize, y.fract());
        let row = |offset: usize, column: usize| coarse[(top + offset) * columns + column];
        for i in 0..grid.width {
            let x = grid.u(i) * columns as f32;
            let (left, tx) = (x as usize % columns, x.fract());
            let right = (left + 1) % columns;
            let above = lerp(row(0, left), row(0, right), tx);
            field.push(lerp(above, lerp(row(1, left), row(1, right), tx), ty));
        }
    }
    field
}

/// One binomial pass (1 2 1) both ways: takes out the steps of strands that cross the texels
/// aslant.
pub(super) fn soften(values: &mut [f32], grid: Grid) {
    for line in values.chunks_mut(grid.width) {
        let (first, mut before) = (line[0], line[grid.width - 1]);
        for i in 0..grid.width {
            let here = line[i];
            let after = if i + 1 < grid.width {
                line[i + 1]
            } else {
                first
            };
            line[i] = 0.25 * (before + after) + 0.5 * here;
            before = here;
        }
    }
    let mut before = values[..grid.width].to_vec();
    for j in 0..grid.height {
        let below = (j + 1).min(grid.height - 1) * grid.width;
        for (i, above) in before.iter_mut().enumerate() {
            let index = j * grid.width + i;
            let here = values[index];
            values[index] = 0.25 * (*above + values[below + i]) + 0.5 * here;
            *above = here;
        }
    }
}

/// Three box passes (nearly a Gaussian) of the given total widths in millimetres, wrapped along
/// the angle, clamped along the radius.
pub(super) fn blur(values: &mut [f32], grid: Grid, along_angle_mm: f32, along_radius_mm: f32) {
    let mut line = vec![0.0; grid.width.max(grid.height)];
    for row in 0..grid.height {
        let reach = along_angle_mm * turns_per_mm(grid.v(row)) * grid.width as f32 / 6.0;
        let slice = &mut values[row * grid.width..(row + 1) * grid.width];
        for _ in 0..3 {
            line[..grid.width].copy_from_slice(slice);
            box_wrapped(&line[..grid.width], slice, reach.round() as usize);
        }
    }
    let reach = (along_radius_mm / DESIGN_WIDTH_MM * grid.height as f32 / 6.0).round() as usize;
    for _ in 0..3 {
        box_rows(values, grid, reach);
    }
}

fn box_wrapped(source: &[f32], target: &mut [f32], reach: usize) {
    let count = source.len();
    let reach = reach.min((count - 1) / 2);
    let scale = 1.0 / (2 * reach + 1) as f32;
    let mut sum =
        source[count - reach..].iter().sum::<f32>() + source[..=reach].iter().sum::<f32>();
    for index in 0..count {
        target[index] = sum * scale;
        sum += source[(index + reach + 1) % count] - source[(index + count - reach) % count];
    }
}

fn box_rows(values: &mut [f32], grid: Grid, reach: usize) {
    if reach == 0 {
        return;
    }
    let source = values.to_vec();
    let row = |j: isize| {
        let j = j.clamp(0, grid.height as isize - 1) as usize;
        &source[j * grid.width..(j + 1) * grid.width]
    };
    let reach = reach as isize;
    let mut sum = vec![0.0_f32; grid.width];
    for j in -reach..=reach {
        sum.iter_mut().zip(row(j)).for_each(|(s, r)| *s += r);
    }
    let scale = 1.0 / (2 * reach + 1) as f32;
    for (j, target) in values.chunks_mut(grid.width).enumerate() {
        let (enter, leave) = (row(j as isize + reach + 1), row(j as isize - reach));
        for i in 0..grid.width {
            target[i] = sum[i] * scale;
            sum[i] += enter[i] - leave[i];
        }
    }
}
