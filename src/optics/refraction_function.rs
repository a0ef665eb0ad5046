//! The refraction function of François et al. 2007, section 5.1: for a place of the iris and the
//! direction of a distant light, the point of the cornea through which that light arrives, without
//! iteration.
//!
//! In: an eye, a place of its iris plane (mm), a direction. Out: the entry point `K` (x and y, mm).
//!
//! `f(P, ω) → K` (equation 15; the paper, too, stores `K`). The paper interpolates samples linearly
//! in the radius of `P` and in `ω`; here values stand on a grid in coordinates that undo the map's
//! steep rim ([`domain`]), as coefficients of quadratic B-splines, so that the error falls with the
//! cube of the spacing, and each is two 16-bit numbers. [`RefractionFunction::towards`] fixes the
//! light and leaves a table of two coordinates. [`RefractionFunction::polish`] adds one Newton step.
//!
//! **Domain**: `P` and `K` within the limbus, lights of the hemisphere in front of the eye, exit
//! incidence up to 80°. Its errors there, and beyond, are measured by `ocularium bench` and
//! `ocularium measure refraction-function`, and stand in `docs/performance.md`.

pub mod domain;
mod fill;
pub mod polynomial;
mod slice;
pub mod spline;

use domain::{FRAME, RefractionEye, frame_a, frame_place};
use fill::{complete, extend};
use glam::{DVec2, DVec3, Vec2};
pub use slice::RefractionSlice;
use spline::{Order, lane_weights, least, prefilter, sites, weights};

/// Size of a refraction function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefractionSize {
    /// Coefficients along the light's obliquity, across its azimuth, and along it; each at least 3.
    pub grid: [usize; 3],
    /// Order of the interpolation.
    pub order: Order,
}

impl RefractionSize {
    /// Within 12 KB.
    pub const SMALL: Self = Self {
        grid: [16, 10, 17],
        order: Order::Quadratic,
    };
    /// Within 300 KB.
    pub const LARGE: Self = Self {
        grid: [40, 24, 77],
        order: Order::Quadratic,
    };
}

/// How much denser the grid is at grazing obliquities than along the axis.
const GRADING: f32 = 1.5;
/// The grid starts a little outside of the domain, in the rim of grazing light.
const LOWEST_W: f32 = -0.05;
/// Look-ups that [`RefractionFunction::entries`] does at once.
const LANES: usize = 16;
/// A frame, filled up to three vectors of four numbers.
const PADDED_FRAME: usize = 12;
/// Nodes that a row of taps may read past the last.
const PADDING: usize = 2;

/// A precomputed refraction function.
#[derive(Clone, Debug)]
pub struct RefractionFunction {
    eye: RefractionEye,
    size: RefractionSize,
    frames: Vec<[f32; PADDED_FRAME]>,
    /// Along (high half) and across (low half) the azimuth, 16 bits each.
    values: Vec<u32>,
    /// Millimetres of one of the values' numbers, which [`unpack`] gives times 2¹⁶.
    step_mm: f32,
    /// The grid's greatest obliquity, as tan(θ/2).
    greatest: f32,
}

impl RefractionFunction {
    /// Computes the function of an eye; 30 ms for [`RefractionSize::LARGE`]. Grid sizes below 3
    /// count as 3.
    pub fn new(eye: RefractionEye, size: RefractionSize) -> Self {
        let grid = size.grid.map(|count| count.max(3));
        let size = RefractionSize { grid, ..size };
        let [nt, nb, nw] = grid;
        let axes = grid.map(|count| sites(size.order, count));
        let greatest = eye.greatest_half_tangent();
        let half_tangents: Vec<f64> = axes[0].iter().map(|&x| greatest * ungrade(x)).collect();
        let frames: Vec<_> = half_tangents.iter().map(|&t| eye.frame(t)).collect();
        let mut values = Vec::with_capacity(nt * nb * nw);
        for (&t, frame) in half_tangents.iter().zip(&frames) {
            let light = RefractionEye::light(t);
            let mut sheet: Vec<Vec<Option<DVec2>>> = Vec::with_capacity(nb);
            for &beta in &axes[1] {
                let place_of = |x: f64| {
                    let w = f64::from(LOWEST_W) + x * (1.0 - f64::from(LOWEST_W));
                    DVec2::new(frame_a(frame, w, beta), beta * frame[0])
                };
                let mut column: Vec<Option<DVec2>> = axes[2]
                    .iter()
                    .map(|&x| eye.solve(place_of(x), light))
                    .collect();
                extend(&mut column, |node, near| {
                    eye.continued(place_of(axes[2][node]), light, near)
                });
                sheet.push(column);
            }
            values.extend(complete(&sheet, &axes[2], eye.limbus_mm));
        }
        let frame_numbers: Vec<f64> = frames.iter().flatten().copied().collect();
        let frames = prefilter(size.order, &frame_numbers, [1, nt, FRAME]);
        let mut numbers: Vec<f64> = values.iter().flat_map(|k| [k.x, k.y]).collect();
        numbers = prefilter(size.order, &numbers, [1, nt, nb * nw * 2]);
        numbers = prefilter(size.order, &numbers, [nt, nb, nw * 2]);
        numbers = prefilter(size.order, &numbers, [nt * nb, nw, 2]);
        let largest = numbers.iter().fold(1.0_f64, |most, v| most.max(v.abs()));
        let step = largest / f64::from(i16::MAX);
        let mut values: Vec<u32> = numbers
            .as_chunks::<2>()
            .0
            .iter()
            .map(|pair| pack(pair.map(|v| (v / step).round() as i16)))
            .collect();
        values.extend([0; PADDING]);
        Self {
            eye,
            size,
            frames: frames
                .chunks_exact(FRAME)
                .map(|frame| core::array::from_fn(|i| frame.get(i).map_or(0.0, |v| *v as f32)))
                .collect(),
            values,
            step_mm: (step / 65_536.0) as f32,
            greatest: greatest as f32,
        }
    }

    /// The eye that it was made for.
    pub fn eye(&self) -> &RefractionEye {
        &self.eye
    }

    /// The greatest angle (radians) between the axis and a light for which it was made.
    pub fn greatest_obliquity(&self) -> f64 {
        2.0 * f64::from(self.greatest).atan()
    }

    /// Bytes of the tables.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.frames[..])
    }

    /// The entry point `K` (x, y in mm) of the light from the unit direction `light` (towards the
    /// light) that reaches `place` (mm) on the iris plane. Finite for all finite arguments; outside
    /// of the domain it extrapolates.
    #[inline]
    pub fn entry(&self, place: DVec2, light: DVec3) -> DVec2 {
        let [entry] = match self.size.order {
            Order::Linear => self.look::<2, 1>(&[(place, light)]),
            Order::Quadratic => self.look::<3, 1>(&[(place, light)]),
        };
        entry
    }

    /// [`Self::entry`] of many pairs of a place and a light, into `entries`: sixteen at a time, so that
    /// no look-up waits for the roots and quotients of the one before. Stops at the shorter of the
    /// two slices.
    pub fn entries(&self, pairs: &[(DVec2, DVec3)], entries: &mut [DVec2]) {
        let count = pairs.len().min(entries.len());
        let (pairs, entries) = (&pairs[..count], &mut entries[..count]);
        let (groups, rest) = pairs.as_chunks::<LANES>();
        let (groups_out, rest_out) = entries.as_chunks_mut::<LANES>();
        for (pairs, out) in groups.iter().zip(groups_out) {
            *out = match self.size.order {
                Order::Linear => self.look::<2, LANES>(pairs),
                Order::Quadratic => self.look::<3, LANES>(pairs),
            };
        }
        for ((place, light), out) in rest.iter().zip(rest_out) {
            *out = self.entry(*place, *light);
        }
    }

    /// `L` look-ups with `N` taps a coordinate, stage by stage and without branches, so that the
    /// compiler does a stage of several look-ups in one instruction.
    #[inline]
    fn look<const N: usize, const L: usize>(&self, pairs: &[(DVec2, DVec3); L]) -> [DVec2; L] {
        let [nt, nb, nw] = self.size.grid;
        let scale = 1.0 / self.greatest;
        let (mut along_x, mut along_y) = ([0.0_f32; L], [0.0_f32; L]);
        let (mut a, mut b, mut obliquity) = ([0.0_f32; L], [0.0_f32; L], [0.0_f32; L]);
        for l in 0..L {
            let (place, light) = pairs[l];
            // On the axis any azimuth will do; this makes it +x.
            let (x, y) = (light.x as f32 + 1e-9, light.y as f32);
            let squared = x * x + y * y;
            let inverse = 1.0 / squared.sqrt();
            along_x[l] = x * inverse;
            along_y[l] = y * inverse;
            let half_tangent = squared * inverse / (1.0 - light.z as f32);
            let (px, py) = (place.x as f32, place.y as f32);
            a[l] = px * along_x[l] + py * along_y[l];
            b[l] = py * along_x[l] - px * along_y[l];
            obliquity[l] = grade(least(half_tangent * scale, 1.0));
        }
        let (rows, by_t) = lane_weights::<N, L>(&obliquity, nt);
        let mut frames = [[0.0_f32; L]; FRAME];
        for l in 0..L {
            let mut frame = [0.0_f32; PADDED_FRAME];
            for (i, row) in self.frames[rows[l]..rows[l] + N].iter().enumerate() {
                for (sum, value) in frame.iter_mut().zip(row) {
                    *sum += by_t[i][l] * value;
                }
            }
            for (lanes, value) in frames.iter_mut().zip(frame) {
                lanes[l] = value;
            }
        }
        let (mut across, mut beta) = ([0.0_f32; L], [0.0_f32; L]);
        for l in 0..L {
            let frame = core::array::from_fn(|i| frames[i][l]);
            let (w, share) = frame_place(&frame, a[l], b[l].abs());
            across[l] = (w - LOWEST_W) * (1.0 / (1.0 - LOWEST_W));
            beta[l] = share;
        }
        let (columns, by_b) = lane_weights::<N, L>(&beta, nb);
        let (nodes, by_w) = lane_weights::<N, L>(&across, nw);
        let mut entries = [DVec2::ZERO; L];
        for l in 0..L {
            // Four nodes at once, of which the last has no weight.
            let (mut sums_a, mut sums_b) = ([0.0_f32; 4], [0.0_f32; 4]);
            let first = (rows[l] * nb + columns[l]) * nw + nodes[l];
            for (i, by_t) in by_t.iter().enumerate() {
                for (j, by_b) in by_b.iter().enumerate() {
                    let first = first + (i * nb + j) * nw;
                    let taps: &[u32; 4] = self.values[first..first + 4]
                        .try_into()
                        .expect("four nodes");
                    let weight = by_t[l] * by_b[l];
                    for m in 0..4 {
                        let [a, b] = unpack(taps[m]);
                        sums_a[m] += weight * a;
                        sums_b[m] += weight * b;
                    }
                }
            }
            let mut k = [0.0_f32; 2];
            for m in 0..N {
                k[0] += by_w[m][l] * sums_a[m];
                k[1] += by_w[m][l] * sums_b[m];
            }
            let ka = k[0] * self.step_mm;
            let kb = k[1] * self.step_mm * 1.0_f32.copysign(b[l]);
            entries[l] = DVec2::new(
                f64::from(ka * along_x[l] - kb * along_y[l]),
                f64::from(ka * along_y[l] + kb * along_x[l]),
            );
        }
        entries
    }

    /// The function for one light: half the work of a look-up is done once.
    pub fn towards(&self, light: DVec3) -> RefractionSlice {
        match self.size.order {
            Order::Linear => self.slice::<2>(light),
            Order::Quadratic => self.slice::<3>(light),
        }
    }

    fn slice<const N: usize>(&self, light: DVec3) -> RefractionSlice {
        let [nt, nb, nw] = self.size.grid;
        let across = Vec2::new(light.x as f32 + 1e-9, light.y as f32);
        let sine = across.length();
        let along = across / sine;
        let half_tangent = sine / (1.0 - light.z as f32);
        let (row, by_t) = weights::<N>(grade((half_tangent / self.greatest).min(1.0)), nt);
        let mut frame = [0.0; FRAME];
        let mut values = vec![[0.0_f32; 2]; nb * nw + PADDING];
        for (i, weight) in by_t.iter().enumerate() {
            for (sum, value) in frame.iter_mut().zip(&self.frames[row + i]) {
                *sum += weight * value;
            }
            let sheet = &self.values[(row + i) * nb * nw..][..nb * nw];
            for (sum, value) in values.iter_mut().zip(sheet) {
                let [a, b] = unpack(*value);
                sum[0] += weight * self.step_mm * a;
                sum[1] += weight * self.step_mm * b;
            }
        }
        RefractionSlice {
            order: self.size.order,
            grid: [nb, nw],
            along,
            frame,
            values,
        }
    }

    /// [`Self::entry`] and one step of Newton's method on Snell's law.
    #[inline]
    pub fn polished_entry(&self, place: DVec2, light: DVec3) -> DVec2 {
        self.polish(self.entry(place, light), place, light)
    }

    /// One step of Newton's method on Snell's law, from any nearby entry point.
    #[inline]
    pub fn polish(&self, entry: DVec2, place: DVec2, light: DVec3) -> DVec2 {
        entry + self.eye.newton_step(entry, place, light)
    }
}

/// Two 16-bit numbers in one word.
fn pack([a, b]: [i16; 2]) -> u32 {
    u32::from(a.cast_unsigned()) << 16 | u32::from(b.cast_unsigned())
}

/// The two numbers, each times 2¹⁶: shifting them to the top half keeps the sign for nothing.
#[inline(always)]
fn unpack(word: u32) -> [f32; 2] {
    [word & 0xffff_0000, word << 16].map(|half| half.cast_signed() as f32)
}

/// The grid's first coordinate, denser towards 90°.
#[inline]
fn grade(half_tangent: f32) -> f32 {
    half_tangent * (1.0 + GRADING * half_tangent) * (1.0 / (1.0 + GRADING))
}

/// The inverse of [`grade`].
fn ungrade(x: f64) -> f64 {
    let g = f64::from(GRADING);
    ((1.0 + 4.0 * g * (1.0 + g) * x).sqrt() - 1.0) / (2.0 * g)
}

#[cfg(test)]
mod tests;
