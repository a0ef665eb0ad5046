//! The refraction function with its light fixed: a table of two coordinates.

use super::domain::{FRAME, frame_place};
use super::spline::{Order, lane_weights};
use super::{LANES, LOWEST_W};
use glam::{DVec2, Vec2};

/// A refraction function for one light: its entry points by place alone, as a small table.
#[derive(Clone, Debug)]
pub struct RefractionSlice {
    pub(super) order: Order,
    pub(super) grid: [usize; 2],
    pub(super) along: Vec2,
    pub(super) frame: [f32; FRAME],
    pub(super) values: Vec<[f32; 2]>,
}

impl RefractionSlice {
    /// The coordinates' coefficients, see [`domain`].
    pub fn frame(&self) -> &[f32; FRAME] {
        &self.frame
    }

    /// Coefficients (along and across the azimuth, mm), row by row.
    pub fn values(&self) -> &[[f32; 2]] {
        &self.values[..self.grid[0] * self.grid[1]]
    }

    /// The entry point `K` (x, y in mm) of the light that reaches `place` (mm).
    #[inline]
    pub fn entry(&self, place: DVec2) -> DVec2 {
        let [entry] = match self.order {
            Order::Linear => self.look::<2, 1>(&[place]),
            Order::Quadratic => self.look::<3, 1>(&[place]),
        };
        entry
    }

    /// [`Self::entry`] of many places, into `entries`, sixteen at a time. Stops at the shorter of
    /// the two slices.
    pub fn entries(&self, places: &[DVec2], entries: &mut [DVec2]) {
        let count = places.len().min(entries.len());
        let (groups, rest) = places[..count].as_chunks::<LANES>();
        let (groups_out, rest_out) = entries[..count].as_chunks_mut::<LANES>();
        for (places, out) in groups.iter().zip(groups_out) {
            *out = match self.order {
                Order::Linear => self.look::<2, LANES>(places),
                Order::Quadratic => self.look::<3, LANES>(places),
            };
        }
        for (place, out) in rest.iter().zip(rest_out) {
            *out = self.entry(*place);
        }
    }

    #[inline]
    fn look<const N: usize, const L: usize>(&self, places: &[DVec2; L]) -> [DVec2; L] {
        let [nb, nw] = self.grid;
        let (mut across, mut beta, mut side) = ([0.0_f32; L], [0.0_f32; L], [0.0_f32; L]);
        for l in 0..L {
            let (x, y) = (places[l].x as f32, places[l].y as f32);
            let a = x * self.along.x + y * self.along.y;
            side[l] = y * self.along.x - x * self.along.y;
            let (w, share) = frame_place(&self.frame, a, side[l].abs());
            across[l] = (w - LOWEST_W) * (1.0 / (1.0 - LOWEST_W));
            beta[l] = share;
        }
        let (columns, by_b) = lane_weights::<N, L>(&beta, nb);
        let (nodes, by_w) = lane_weights::<N, L>(&across, nw);
        let mut entries = [DVec2::ZERO; L];
        for l in 0..L {
            let first = columns[l] * nw + nodes[l];
            let mut k = [0.0_f32; 2];
            for (j, by_b) in by_b.iter().enumerate() {
                let taps: &[[f32; 2]; N] = self.values[first + j * nw..first + j * nw + N]
                    .try_into()
                    .expect("N nodes");
                for m in 0..N {
                    let weight = by_b[l] * by_w[m][l];
                    k[0] += weight * taps[m][0];
                    k[1] += weight * taps[m][1];
                }
            }
            let kb = k[1] * 1.0_f32.copysign(side[l]);
            entries[l] = DVec2::new(
                f64::from(k[0] * self.along.x - kb * self.along.y),
                f64::from(k[0] * self.along.y + kb * self.along.x),
            );
        }
        entries
    }
}
