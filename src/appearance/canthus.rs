//! The soft tissue between the lids at their corners, and the tear meniscus along the margins.
//!
//! In: points of the posed margins and the globe's radius. Out: small grids of points. The medial
//! grid carries the plica semilunaris (a crescent fold where the conjunctiva leaves the globe) and the
//! caruncle (a lobed mound of modified skin, about 5 × 3 mm); the lateral one closes the outer corner.
//! Frame: globe frame, mm, right eye.

use glam::Vec3;

use super::lids::{Fissure, Lid, LidPose, MARGIN_CLEARANCE_MM};
use crate::optics::smoothstep::smoothstep;

/// Columns of a corner grid, along the margins.
pub const CORNER_COLUMNS: usize = 19;
/// Rows of a corner grid, from the lower to the upper lid.
pub const CORNER_ROWS: usize = 17;
/// Stations of the tear meniscus along each margin.
pub const MENISCUS_STATIONS: usize = 65;
/// Points across the meniscus.
pub const MENISCUS_POINTS: usize = 5;

/// How far a corner grid, a thin sheet of conjunctiva, stands off the globe at least, mm.
pub const EDGE_MM: f32 = 0.012;

/// Which corner of the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// At the nose, with plica and caruncle.
    Medial,
    /// At the temple.
    Lateral,
}

impl Corner {
    /// Margin parameter of grid column `c`: 0 of the grid is the canthus.
    fn t(self, c: usize) -> f32 {
        let s = c as f32 / (CORNER_COLUMNS - 1) as f32;
        match self {
            Self::Medial => 0.27 * s,
            Self::Lateral => 1.0 - 0.17 * s,
        }
    }
}

/// Caruncle weight (0 … 1) and conjunctival redness at a grid point, for the skin shader.
pub fn corner_tissue(corner: Corner, column: usize, row: usize) -> [f32; 2] {
    let s = column as f32 / (CORNER_COLUMNS - 1) as f32;
    let q = row as f32 / (CORNER_ROWS - 1) as f32;
    match corner {
        Corner::Medial => [
            (mound(s, q) * 1.25 + 0.45 * ridge(s, q)).min(1.0),
            1.0 - smoothstep(0.2, 1.0, s),
        ],
        Corner::Lateral => [0.0, 0.8 * (1.0 - smoothstep(0.1, 1.0, s))],
    }
}

/// Caruncle: 1 at its top, with a few lobes; its flanks are steep.
fn mound(s: f32, q: f32) -> f32 {
    let squared = from_caruncle(s, q);
    let lobes = 1.0 + 0.13 * (s * 21.0 + 1.3 * (q * 7.0).sin()).sin() * (q * 12.0 + 1.0).sin();
    (-squared * squared.sqrt()).exp() * lobes
}

/// Squared distance from the caruncle's middle, of its own size.
fn from_caruncle(s: f32, q: f32) -> f32 {
    let (ds, dq) = ((s - 0.38) / 0.235, (q - 0.46) / 0.4);
    ds * ds + dq * dq
}

/// The furrow around the caruncle, 1 where it is deepest; it ends at the plica, beyond which the white begins.
fn furrow(s: f32, q: f32) -> f32 {
    let off = (from_caruncle(s, q).sqrt() - 1.45) / 0.38;
    (-off * off).exp() * (1.0 - smoothstep(-0.15, 0.05, s - bow(q)))
}

/// Share of the sky that reaches a place of the medial corner: little gets into its furrows.
pub fn corner_light(corner: Corner, column: usize, row: usize) -> f32 {
    let s = column as f32 / (CORNER_COLUMNS - 1) as f32;
    let q = row as f32 / (CORNER_ROWS - 1) as f32;
    match corner {
        Corner::Medial => {
            let open = 0.9 + 0.1 * mound(s, q) - 0.5 * furrow(s, q) * (1.0 - 0.6 * ridge(s, q));
            // Between the lids, where they meet, it is dark.
            open * (0.55 + 0.45 * smoothstep(0.0, 0.3, s))
        }
        Corner::Lateral => 0.85,
    }
}

/// Where the plica's crest is: a crescent whose horns point away from the nose.
fn bow(q: f32) -> f32 {
    0.54 + 0.34 * (2.0 * q - 0.9).powi(2)
}

/// The plica.
fn ridge(s: f32, q: f32) -> f32 {
    let bow = bow(q);
    let side = (s - bow) / if s > bow { 0.15 } else { 0.17 };
    // Its free edge is uneven.
    let crest = 0.8 + 0.2 * (q * 13.0 + 2.0 * (q * 5.0).sin()).sin();
    crest * (-side * side).exp()
}

/// One corner grid, row by row from the lower to the upper lid ([`CORNER_ROWS`] × [`CORNER_COLUMNS`]).
pub fn corner_grid(
    corner: Corner,
    fissure: &Fissure,
    pose: &LidPose,
    globe_radius: &dyn Fn(Vec3) -> f32,
    out: &mut [Vec3],
) {
    // Lids that close come down over it.
    let shut = 1.0 - smoothstep(0.0, 0.3, pose.aperture_of(Lid::Upper));
    for c in 0..CORNER_COLUMNS {
        let t = corner.t(c);
        let s = c as f32 / (CORNER_COLUMNS - 1) as f32;
        let upper = fissure.margin(Lid::Upper, t, pose);
        let lower = fissure.margin(Lid::Lower, t, pose);
        let gap = upper.direction.distance(lower.direction) * 11.5;
        // The mounds are soft: closing lids press them flat.
        let room = smoothstep(0.0, 2.2, gap);
        for r in 0..CORNER_ROWS {
            let q = r as f32 / (CORNER_ROWS - 1) as f32;
            // A little beyond the margins on both sides, so that the edge is hidden by the lids.
            let reach = -0.3 + 1.6 * q;
            let direction =
                (lower.direction + (upper.direction - lower.direction) * reach).normalize_or_zero();
            let edge =
                lower.lift_mm + (upper.lift_mm - lower.lift_mm) * q - 0.7 * (1.0 - room) * shut;
            // It leaves the globe as the margins do, lies deeper than they, and rises to them where they
            // meet.
            let share = 0.4 + 0.6 * (1.0 - smoothstep(0.0, 0.5, s));
            let floor = edge * share;
            let rise = (2.0 * q - 1.0).abs().powi(3);
            let mut off = floor + (edge - 0.02 - floor) * rise;
            if corner == Corner::Medial {
                let raised = 1.5 * mound(s, q) + 0.42 * ridge(s, q) - 0.45 * furrow(s, q);
                off += room * raised * (1.0 - rise);
            }
            // The sheet comes down onto the globe and goes on as what covers it.
            off += (EDGE_MM - off) * smoothstep(0.7, 1.0, s);
            // Its very edge dips under the surface: from aside nobody looks below it.
            let off = if c + 1 == CORNER_COLUMNS {
                -EDGE_MM
            } else {
                off.max(EDGE_MM)
            };
            out[r * CORNER_COLUMNS + c] = direction * (globe_radius(direction) + off);
        }
    }
}

/// One tear meniscus: [`MENISCUS_STATIONS`] × [`MENISCUS_POINTS`] points from the globe to the margin,
/// a concave strip about 0.25 mm high that thins out where the lids nearly touch.
pub fn meniscus_strip(
    lid: Lid,
    fissure: &Fissure,
    pose: &LidPose,
    globe_radius: &dyn Fn(Vec3) -> f32,
    out: &mut [Vec3],
) {
    let height: f32 = match lid {
        Lid::Upper => 0.2,
        Lid::Lower => 0.3,
    };
    for i in 0..MENISCUS_STATIONS {
        let t = 0.2 + 0.76 * i as f32 / (MENISCUS_STATIONS - 1) as f32;
        let (own, other) = match lid {
            Lid::Upper => (Lid::Upper, Lid::Lower),
            Lid::Lower => (Lid::Lower, Lid::Upper),
        };
        let margin = fissure.margin(own, t, pose);
        let across = fissure.margin(other, t, pose).direction - margin.direction;
        let gap = across.length() * 11.5;
        let inwards = across.normalize_or_zero();
        let ends = smoothstep(0.0, 0.08, t - 0.2) * (1.0 - smoothstep(0.9, 0.96, t));
        let reach = height.min(0.4 * gap) * ends.max(0.02);
        for k in 0..MENISCUS_POINTS {
            let s = k as f32 / (MENISCUS_POINTS - 1) as f32;
            // From the globe (s = 0) to the margin (s = 1), sagging towards their corner.
            let (along, off) = ((1.0 - s).powf(1.7) * reach, s.powf(1.7) * reach);
            let direction = (margin.direction + inwards * (along / 11.5)).normalize_or_zero();
            let lift = margin.lift_mm * smoothstep(0.0, 0.6, s) + MARGIN_CLEARANCE_MM * s;
            out[i * MENISCUS_POINTS + k] =
                direction * (globe_radius(direction) + 0.01 + lift + off);
        }
    }
}
