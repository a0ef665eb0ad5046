//! The skin around one eye: lids that blink and follow gaze, margins, corners, tear meniscus.
//!
//! In: a [`LidPose`] and the globe's radius along a direction. Out: positions, normals and light of one
//! fixed triangle mesh. Outside the orbital border it is the cut CC0 face refined by Catmull–Clark with
//! its blend shapes (`face_cage`); inside, the face's coarse lids are replaced by columns that run from
//! the border to the margin and under it (`lids`), tangent to the face at the border. Two small grids
//! fill the corners (`canthus`). Frame: globe frame, mm, right eye (mirror x for the left).

use glam::Vec3;
use std::collections::HashSet;

use super::canthus::{
    CORNER_COLUMNS, CORNER_ROWS, Corner, MENISCUS_POINTS, MENISCUS_STATIONS, corner_grid,
    corner_light, corner_tissue, meniscus_strip,
};
pub use super::face_cage::FaceError;
use super::face_cage::{BorderVertex, Cage, Shape};
use super::lid_profile::{ANTERIOR_ROW, Column, ColumnFrame, ROWS, column_profile, edge_share};
pub use super::lids::LidPose;
use super::lids::{Fissure, Lid, MarginPoint};
use super::region_parts::{COLUMN_STEP, CORNER_STEP, LEVELS, ROWS_OF, RegionParts};
use crate::optics::smoothstep::smoothstep;

/// Points of each margin polyline in [`PosedRegion`].
pub const MARGIN_POINTS: usize = 33;

/// How much like a lower lid's the skin over an upper tarsus is, where the lower one's muscle shows fully (a choice: on photographs
/// only lower lids were measured).
const PRETARSAL_SHARE: f32 = 0.55;

/// How much of flesh's colour the skin has where the lids end in the corners (a choice).
const CORNER_FLUSH: f32 = 0.45;

/// The region's mesh at rest.
#[derive(Clone, Debug)]
pub struct EyeRegion {
    cage: Cage,
    fissure: Fissure,
    /// At each level, which columns of the lids it has and its quads.
    divisions: [Division; LEVELS],
    meniscus_quads: Vec<[u32; 4]>,
    meniscus_indices: Vec<u32>,
    tissue: Vec<[f32; 4]>,
    rest: Vec<[f32; 3]>,
    parts: [RegionParts; LEVELS],
}

/// What of a region one level of division has.
#[derive(Clone, Debug, Default)]
struct Division {
    /// The columns of the lids, of all of them.
    columns: Vec<usize>,
    /// Quads of face, lids and corners.
    quads: Vec<[u32; 4]>,
}

/// A posed region. Reuse it: its buffers keep their size.
#[derive(Clone, Debug, Default)]
pub struct PosedRegion {
    /// Positions, mm.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, outwards.
    pub normals: Vec<[f32; 3]>,
    /// Share of the sky that reaches the vertex, 0 … 1: dark in the fold and under the lids.
    pub light: Vec<f32>,
    /// Posterior edge of the upper margin, medial to lateral, [`MARGIN_POINTS`] points, mm.
    pub upper_margin: Vec<Vec3>,
    /// Posterior edge of the lower margin.
    pub lower_margin: Vec<Vec3>,
    /// Anterior edge of the upper margin, where lashes grow.
    pub upper_lash_line: Vec<Vec3>,
    /// Anterior edge of the lower margin.
    pub lower_lash_line: Vec<Vec3>,
    /// Tear meniscus, lower strip then upper, mm.
    pub meniscus_positions: Vec<[f32; 3]>,
    /// Unit normals of the meniscus.
    pub meniscus_normals: Vec<[f32; 3]>,
    points: Vec<Vec3>,
    scratch: Vec<Vec3>,
}

impl PosedRegion {
    /// How far each place of the meniscus lies below the upper lid's, mm: a vertex' tissue weights.
    pub fn meniscus_gaps(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        let half = self.meniscus_positions.len() / 2;
        let (lower, upper) = self.meniscus_positions.split_at(half);
        let both = lower.iter().chain(upper);
        both.zip(upper.iter().cycle())
            .map(|(own, above)| [(above[1] - own[1]).max(0.0), 0.0, 0.0, 0.0])
    }
}

impl EyeRegion {
    /// Reads and refines the shipped face.
    ///
    /// # Errors
    /// When the shipped files are not what [`FaceError`] says they must be.
    pub fn load() -> Result<Self, FaceError> {
        let cage = Cage::load()?;
        let meniscus_quads = meniscus_quads();
        let mut region = Self {
            divisions: Default::default(),
            meniscus_indices: triangles(&meniscus_quads).flatten().collect(),
            meniscus_quads,
            tissue: Vec::new(),
            rest: Vec::new(),
            parts: Default::default(),
            fissure: Fissure::default(),
            cage,
        };
        region.tissue = region.tissue_weights();
        for level in 0..LEVELS {
            let columns = region.columns_of(level);
            let quads = region.quads_of(level, &columns);
            let [face, corners] = [0, 1].map(|k| triangles(&quads[k]).collect::<Vec<_>>());
            let wet = |vertex: u32| region.tissue[vertex as usize][0] > 0.0;
            region.parts[level] = RegionParts::new(&face, &corners, wet);
            region.divisions[level] = Division {
                columns,
                quads: quads.concat(),
            };
        }
        let closed = LidPose {
            aperture: 0.25,
            ..LidPose::default()
        };
        let mut posed = PosedRegion::default();
        region.pose(&closed, &|_| 11.5, &mut posed);
        region.rest = posed.positions;
        Ok(region)
    }

    /// Its triangles as finely divided as it is, counter-clockwise from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        triangles(&self.divisions[0].quads)
    }

    /// Its meshes, divided this finely (0 to [`LEVELS`] − 1, the finest first).
    pub fn parts(&self, level: usize) -> &RegionParts {
        &self.parts[level.min(LEVELS - 1)]
    }

    /// Triangles of the tear meniscus.
    pub fn meniscus_indices(&self) -> &[u32] {
        &self.meniscus_indices
    }

    /// Positions with the lids nearly closed, mm: where to evaluate solid noise so that it sticks.
    pub fn rest(&self) -> &[[f32; 3]] {
        &self.rest
    }

    /// For each vertex, 0 … 1: how near the margin's posterior edge, thin translucent lid, caruncle and canthus, brow.
    pub fn tissue(&self) -> &[[f32; 4]] {
        &self.tissue
    }

    fn lid_start(&self) -> usize {
        self.cage.positions.len()
    }

    fn corner_start(&self, corner: Corner) -> usize {
        let lids = self.lid_start() + self.cage.border.len() * ROWS;
        match corner {
            Corner::Medial => lids,
            Corner::Lateral => lids + CORNER_COLUMNS * CORNER_ROWS,
        }
    }

    fn vertex_count(&self) -> usize {
        self.corner_start(Corner::Lateral) + CORNER_COLUMNS * CORNER_ROWS
    }

    /// The columns of a level, round the fissure: those that end at vertices which the face has there.
    fn columns_of(&self, level: usize) -> Vec<usize> {
        let kept: HashSet<u32> = self.cage.quads_of(level).into_iter().flatten().collect();
        let border = &self.cage.border;
        let ends = |border: &BorderVertex| kept.contains(&border.index);
        let first = border.iter().position(ends).unwrap_or(0);
        let around = (first..first + border.len()).step_by(COLUMN_STEP[level]);
        around.map(|column| column % border.len()).collect()
    }

    /// The quads of face and lids, and those of the corners; counter-clockwise from outside.
    fn quads_of(&self, level: usize, columns: &[usize]) -> [Vec<[u32; 4]>; 2] {
        let mut face = self.cage.quads_of(level);
        let at = |column: usize, row: usize| {
            if row == ROWS {
                self.cage.border[column].index
            } else {
                (self.lid_start() + column * ROWS + row) as u32
            }
        };
        for (k, &here) in columns.iter().enumerate() {
            let next = columns[(k + 1) % columns.len()];
            face.extend(ROWS_OF[level].windows(2).map(|rows| {
                let [from, to] = [rows[0], rows[1]];
                [at(here, from), at(here, to), at(next, to), at(next, from)]
            }));
        }
        let mut corners = Vec::new();
        let step = CORNER_STEP[level];
        for corner in [Corner::Medial, Corner::Lateral] {
            let at =
                |c: usize, r: usize| (self.corner_start(corner) + r * CORNER_COLUMNS + c) as u32;
            for c in (0..CORNER_COLUMNS - 1).step_by(step) {
                for r in (0..CORNER_ROWS - 1).step_by(step) {
                    let mut quad = [
                        at(c, r),
                        at(c, r + step),
                        at(c + step, r + step),
                        at(c + step, r),
                    ];
                    if corner == Corner::Lateral {
                        quad.swap(1, 3);
                    }
                    corners.push(quad);
                }
            }
        }
        [face, corners]
    }

    fn tissue_weights(&self) -> Vec<[f32; 4]> {
        let mut out: Vec<[f32; 4]> = self
            .cage
            .positions
            .iter()
            .map(|p| [0.0, preseptal_weight(*p), 0.0, brow_weight(*p)])
            .collect();
        for border in &self.cage.border {
            let t = border.column.t;
            let corner = (1.0 - smoothstep(0.0, 0.12, t)).max(0.6 * smoothstep(0.95, 1.0, t));
            let beyond = preseptal_weight(self.cage.positions[border.index as usize]);
            for row in 0..ROWS {
                let along = (row as f32 - ANTERIOR_ROW as f32) / (ROWS - ANTERIOR_ROW) as f32;
                // Over the tarsus an upper lid's skin shows less of what lies below it.
                let lid = match border.column.lid {
                    Lid::Upper => PRETARSAL_SHARE,
                    Lid::Lower => 1.0,
                };
                let thin = lid + (beyond - lid) * smoothstep(0.25, 1.0, along);
                let pink = CORNER_FLUSH * corner * (1.0 - smoothstep(0.0, 0.35, along));
                out.push([edge_share(row), thin, pink, 0.0]);
            }
        }
        for corner in [Corner::Medial, Corner::Lateral] {
            for r in 0..CORNER_ROWS {
                for c in 0..CORNER_COLUMNS {
                    let [caruncle, red] = corner_tissue(corner, c, r);
                    out.push([1.0, 0.0, caruncle.max(0.9 * red), 0.0]);
                }
            }
        }
        out
    }

    /// Poses the region over a globe whose radius (mm) along a unit vector is `globe_radius`.
    pub fn pose(&self, pose: &LidPose, globe_radius: &dyn Fn(Vec3) -> f32, out: &mut PosedRegion) {
        self.pose_level(0, pose, globe_radius, out);
    }

    /// The same for the vertices that a level has (0 to [`LEVELS`] − 1, the finest first); where the others stand is not said.
    pub fn pose_level(
        &self,
        level: usize,
        pose: &LidPose,
        globe_radius: &dyn Fn(Vec3) -> f32,
        out: &mut PosedRegion,
    ) {
        let division = &self.divisions[level.min(LEVELS - 1)];
        let pose = pose.clamped();
        let count = self.vertex_count();
        out.points.clear();
        out.points.extend_from_slice(&self.cage.positions);
        out.points.resize(count, Vec3::ZERO);
        out.light.clear();
        out.light.resize(count, 1.0);
        self.pose_face(&pose, &mut out.points);
        self.pose_lids(&division.columns, &pose, globe_radius, out);
        for corner in [Corner::Medial, Corner::Lateral] {
            let start = self.corner_start(corner);
            let end = start + CORNER_COLUMNS * CORNER_ROWS;
            corner_grid(
                corner,
                &self.fissure,
                &pose,
                globe_radius,
                &mut out.points[start..end],
            );
            for (at, light) in out.light[start..end].iter_mut().enumerate() {
                *light = corner_light(corner, at % CORNER_COLUMNS, at / CORNER_COLUMNS);
            }
        }
        write_normals(
            &out.points,
            &division.quads,
            &mut out.scratch,
            &mut out.normals,
        );
        out.positions.clear();
        out.positions
            .extend(out.points.iter().map(|p| p.to_array()));
        self.pose_meniscus(&pose, globe_radius, out);
    }

    fn pose_face(&self, pose: &LidPose, points: &mut [Vec3]) {
        let up = pose.gaze_elevation_rad / 0.6;
        let right = pose.gaze_azimuth_rad / 0.6;
        let weights = [
            (Shape::Blink, 0.5 * pose.lowered()),
            (Shape::LookUp, up.max(0.0)),
            (Shape::LookDown, (-up).max(0.0)),
            (Shape::LookIn, (-right).max(0.0)),
            (Shape::LookOut, right.max(0.0)),
            (Shape::Squint, 0.8 * pose.squint),
            (Shape::Wide, 2.5 * (pose.aperture - 1.0).max(0.0)),
        ];
        for (shape, weight) in weights.into_iter().filter(|(_, w)| *w > 1e-4) {
            for &(v, offset) in &self.cage.shapes[shape as usize] {
                points[v as usize] += offset * weight;
            }
        }
    }

    fn pose_lids(
        &self,
        kept: &[usize],
        pose: &LidPose,
        globe_radius: &dyn Fn(Vec3) -> f32,
        out: &mut PosedRegion,
    ) {
        let columns: Vec<Column> = self.cage.border.iter().map(|b| b.column).collect();
        let margins: Vec<MarginPoint> = columns
            .iter()
            .map(|c| self.fissure.margin(c.lid, c.t, pose))
            .collect();
        let borders: Vec<Vec3> = self
            .cage
            .border
            .iter()
            .map(|b| out.points[b.index as usize])
            .collect();
        let away = away_tangents(&columns, &margins);
        let start = self.lid_start();
        for &j in kept {
            let border = &self.cage.border[j];
            // The inner neighbour was cut away; it rides with its border vertex.
            let rest = self.cage.positions[border.index as usize];
            let inner = border.inner + (borders[j] - rest);
            let frame = ColumnFrame {
                margin: margins[j],
                away: away[j],
                border: borders[j],
                border_tangent: (out.points[border.outer as usize] - inner).normalize_or_zero(),
            };
            let rows = start + j * ROWS..start + (j + 1) * ROWS;
            let (points, light) = (&mut out.points[rows.clone()], &mut out.light[rows]);
            column_profile(&columns[j], &frame, pose, globe_radius, points, light);
        }
        let anterior = |j: &usize| (columns[*j], out.points[start + j * ROWS + ANTERIOR_ROW]);
        let edge: Vec<(Column, Vec3)> = kept.iter().map(anterior).collect();
        resample(&edge, Lid::Upper, &mut out.upper_lash_line);
        resample(&edge, Lid::Lower, &mut out.lower_lash_line);
        for (lid, line) in [
            (Lid::Upper, &mut out.upper_margin),
            (Lid::Lower, &mut out.lower_margin),
        ] {
            line.clear();
            line.extend((0..MARGIN_POINTS).map(|i| {
                let t = i as f32 / (MARGIN_POINTS - 1) as f32;
                self.fissure.margin(lid, t, pose).position(globe_radius)
            }));
        }
    }

    fn pose_meniscus(
        &self,
        pose: &LidPose,
        globe_radius: &dyn Fn(Vec3) -> f32,
        out: &mut PosedRegion,
    ) {
        let size = MENISCUS_STATIONS * MENISCUS_POINTS;
        out.points.clear();
        out.points.resize(2 * size, Vec3::ZERO);
        let (lower, upper) = out.points.split_at_mut(size);
        meniscus_strip(Lid::Lower, &self.fissure, pose, globe_radius, lower);
        meniscus_strip(Lid::Upper, &self.fissure, pose, globe_radius, upper);
        write_normals(
            &out.points,
            &self.meniscus_quads,
            &mut out.scratch,
            &mut out.meniscus_normals,
        );
        out.meniscus_positions.clear();
        out.meniscus_positions
            .extend(out.points.iter().map(|p| p.to_array()));
    }
}

/// Two triangles of each quad.
fn triangles(quads: &[[u32; 4]]) -> impl Iterator<Item = [u32; 3]> {
    quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
}

/// Unit tangents of the globe at each margin point, away from the fissure; at the canthi, where the
/// margin turns round, straight to the side.
fn away_tangents(columns: &[Column], margins: &[MarginPoint]) -> Vec<Vec3> {
    let n = columns.len();
    let flat = |v: Vec3, normal: Vec3| (v - normal * v.dot(normal)).normalize_or_zero();
    let mut away: Vec<Vec3> = (0..n)
        .map(|j| {
            let normal = margins[j].direction;
            let sideways = flat(
                if columns[j].t < 0.5 {
                    Vec3::NEG_X
                } else {
                    Vec3::X
                },
                normal,
            );
            let along = margins[(j + 1) % n].direction - margins[(j + n - 1) % n].direction;
            let across = flat(normal.cross(along), normal);
            let up = if columns[j].lid == Lid::Upper {
                1.0
            } else {
                -1.0
            };
            let across = if across.y * up < 0.0 { -across } else { across };
            let middle = columns[j].inside_weight(0.07);
            flat(sideways * (1.0 - middle) + across * middle, normal)
        })
        .collect();
    for _ in 0..3 {
        let old = away.clone();
        for j in 0..n {
            let sum = old[(j + n - 1) % n] + old[j] * 2.0 + old[(j + 1) % n];
            away[j] = flat(sum, margins[j].direction);
        }
    }
    away
}

/// A row of the lid mesh as a polyline of [`MARGIN_POINTS`] equal steps of `t`, medial to lateral.
fn resample(row: &[(Column, Vec3)], lid: Lid, out: &mut Vec<Vec3>) {
    let mut chain: Vec<(f32, Vec3)> = row
        .iter()
        .filter(|(c, _)| c.lid == lid || c.t <= 0.0 || c.t >= 1.0)
        .map(|(c, point)| (c.t, *point))
        .collect();
    chain.sort_by(|a, b| a.0.total_cmp(&b.0));
    out.clear();
    for i in 0..MARGIN_POINTS {
        let t = i as f32 / (MARGIN_POINTS - 1) as f32;
        let k = chain.partition_point(|c| c.0 < t).clamp(1, chain.len() - 1);
        let (a, b) = (chain[k - 1], chain[k]);
        out.push(a.1.lerp(b.1, ((t - a.0) / (b.0 - a.0).max(1e-6)).clamp(0.0, 1.0)));
    }
}

/// Vertex normals weighted by the areas of the quads about a vertex; one without area looks along the patient's gaze.
fn write_normals(
    points: &[Vec3],
    quads: &[[u32; 4]],
    scratch: &mut Vec<Vec3>,
    out: &mut Vec<[f32; 3]>,
) {
    scratch.clear();
    scratch.resize(points.len(), Vec3::ZERO);
    for quad in quads {
        let [a, b, c, d] = quad.map(|vertex| points[vertex as usize]);
        // The sum of the normals of its two triangles, whichever way it is halved.
        let normal = (c - a).cross(d - b);
        for &vertex in quad {
            scratch[vertex as usize] += normal;
        }
    }
    out.clear();
    out.extend(
        scratch
            .iter()
            .map(|n| n.try_normalize().unwrap_or(Vec3::NEG_Z).to_array()),
    );
}

fn meniscus_quads() -> Vec<[u32; 4]> {
    let mut out = Vec::new();
    for strip in 0..2 {
        let at =
            |i: usize, k: usize| ((strip * MENISCUS_STATIONS + i) * MENISCUS_POINTS + k) as u32;
        for i in 0..MENISCUS_STATIONS - 1 {
            for k in 0..MENISCUS_POINTS - 1 {
                let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
                // The strips mirror each other, and both must face outwards.
                out.push(if strip == 0 {
                    [a, b, c, d]
                } else {
                    [a, d, c, b]
                });
            }
        }
    }
    out
}

/// How much skin of the face beyond the lids, at rest at `p` (mm), is like theirs: as far as the orbital septum reaches
/// below the muscle, to the rim of the orbit.
fn preseptal_weight(p: Vec3) -> f32 {
    // Half of the orbit's opening: 40 mm wide and 33 high, its middle a little towards the temple.
    let (x, y) = (p.x - 2.0, p.y + 1.0);
    let across = x / if x < 0.0 { 19.0 } else { 24.0 };
    let along = y / if y < 0.0 { 15.5 } else { 17.5 };
    0.7 * (1.0 - smoothstep(0.5, 1.0, across.hypot(along)))
}

/// Brow density at a resting skin point: an arch over the orbital rim, thinning to the temple.
fn brow_weight(p: Vec3) -> f32 {
    let s = (p.x + 17.0) / 42.0;
    if !(0.0..=1.0).contains(&s) || p.z > 8.0 {
        return 0.0;
    }
    let line = 18.2 + 4.0 * (s * 1.25).min(1.0) - 7.0 * (s - 0.72).max(0.0);
    let half = 4.0 * (1.0 - 0.7 * s);
    smoothstep(0.0, 0.06, s)
        * (1.0 - smoothstep(0.85, 1.0, s))
        * (1.0 - smoothstep(0.55, 1.0, ((p.y - line) / half).abs()))
}

#[cfg(test)]
mod tests;
