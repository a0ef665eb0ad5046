//! The skin profile of a lid: one column of the lid mesh.
//!
//! In: a margin point, the border vertex on the orbital skin that the column ends at, the
//! [`LidPose`] and the globe's radius along a direction. Out: points that run from under the lid over
//! the margin, the lash line, the tarsal plate and the lid fold to the border,
//! tangent to the face there, and how much sky each of them sees. Globe frame, mm.

use glam::Vec3;

use super::lids::{Lid, LidPose, MARGIN_CLEARANCE_MM, MarginPoint, REST_RADIUS_MM};
use super::shading::skin_shade::MARGIN_MM;
use crate::optics::smoothstep::smoothstep;

/// Rows from deep under the lid to the lash line.
pub const EDGE_ROWS: usize = 8;
/// Rows of skin from the lash line to the orbital border (which is not one of them).
pub const SKIN_ROWS: usize = 20;
/// Rows of a lid column.
pub const ROWS: usize = EDGE_ROWS + SKIN_ROWS;
/// The row of the anterior edge, where lashes grow (row 3 is the posterior edge, on the globe).
pub const ANTERIOR_ROW: usize = 6;

/// Sideways slide (mm, away from the fissure) and share of the lid's thickness of the edge rows; the
/// first two follow the globe under the lid.
const EDGE: [[f32; 2]; EDGE_ROWS] = [
    [3.5, 0.0],
    [1.4, 0.0],
    [0.18, 0.015],
    [0.0, 0.08],
    [0.0, 0.42],
    [0.03, 0.84],
    [0.13, 0.97],
    [0.45, 1.03],
];

/// Thickness of a lid's edge at the corners, mm (a choice).
const CANTHUS_MM: f32 = 0.7;

/// One column of the lid mesh.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Which margin it hangs from.
    pub lid: Lid,
    /// Where along the margin, 0 medial … 1 lateral.
    pub t: f32,
}

impl Column {
    /// 1 in the middle of the upper lid, 0 on the lower lid and at the canthi, smooth.
    /// A lowered lid is smooth towards the canthi.
    pub fn fold_weight(&self, lowered: f32) -> f32 {
        let (medial, lateral) = (0.2 + 0.3 * lowered, 0.9 - 0.35 * lowered);
        match self.lid {
            Lid::Upper => {
                smoothstep(0.03, medial, self.t) * (1.0 - smoothstep(lateral, 1.0, self.t))
            }
            Lid::Lower => 0.0,
        }
    }

    fn lower_weight(&self) -> f32 {
        match self.lid {
            Lid::Lower => smoothstep(0.05, 0.25, self.t) * (1.0 - smoothstep(0.8, 0.97, self.t)),
            Lid::Upper => 0.0,
        }
    }

    /// 0 at the canthi, where the margin turns round, 1 elsewhere, over the share `turn` of the margin.
    pub fn inside_weight(&self, turn: f32) -> f32 {
        smoothstep(0.0, turn, self.t) * (1.0 - smoothstep(1.0 - turn, 1.0, self.t))
    }

    /// How far (mm) the anterior edge leans over the fissure: an open upper lid hides its margin.
    fn lean_mm(&self, aperture: f32) -> f32 {
        match self.lid {
            Lid::Upper => {
                0.55 * smoothstep(0.02, 0.5, aperture)
                    * smoothstep(0.04, 0.3, self.t)
                    * (1.0 - smoothstep(0.85, 1.0, self.t))
            }
            Lid::Lower => 0.0,
        }
    }

    /// Thickness of the lid's edge, mm.
    pub fn thickness_mm(&self) -> f32 {
        CANTHUS_MM
            + (MARGIN_MM as f32 - CANTHUS_MM)
                * (smoothstep(0.0, 0.26, self.t) * (1.0 - smoothstep(0.85, 1.0, self.t)))
    }
}

/// Where a column starts and ends.
#[derive(Clone, Copy, Debug)]
pub struct ColumnFrame {
    /// The margin point.
    pub margin: MarginPoint,
    /// Unit tangent of the globe away from the fissure.
    pub away: Vec3,
    /// The column's vertex on the orbital border, mm.
    pub border: Vec3,
    /// Unit tangent of the face across the border, outwards.
    pub border_tangent: Vec3,
}

/// `distance` mm along the great circle from `direction` towards the tangent `along`, at `radius`.
pub fn slide(direction: Vec3, along: Vec3, distance: f32, radius: f32) -> Vec3 {
    let (s, c) = (distance / radius).sin_cos();
    direction * c + along * s
}

/// How far up a lid's edge a row lies: nearly 1 at its posterior corner, on the globe, 0 from beyond the anterior one on.
pub fn edge_share(row: usize) -> f32 {
    EDGE.get(row)
        .map_or(0.0, |[_, share]| (1.0 - share).max(0.0))
}

/// Fills one column: `points` and `light` (1 open to the sky … 0 buried) of [`ROWS`] rows.
pub fn column_profile(
    column: &Column,
    frame: &ColumnFrame,
    pose: &LidPose,
    globe_radius: &dyn Fn(Vec3) -> f32,
    points: &mut [Vec3],
    light: &mut [f32],
) {
    let n = frame.margin.direction;
    let thickness = column.thickness_mm();
    let lift = frame.margin.lift_mm;
    let lowered = pose.lowered();
    let lean = column.lean_mm(pose.aperture_of(Lid::Upper));
    for (row, [distance, share]) in EDGE.into_iter().enumerate() {
        let distance = distance - lean * share.min(1.0);
        let at = slide(n, frame.away, distance, REST_RADIUS_MM + lift).normalize();
        // Under the lid the sheet returns to the globe, so no light shows past the edge.
        let off = if row < 2 {
            lift * (1.0 - distance / 3.6)
        } else {
            lift + MARGIN_CLEARANCE_MM
        };
        points[row] = at * (globe_radius(at) + off.max(0.02) + share * thickness);
        light[row] = [0.2, 0.35, 0.6, 0.75, 0.85, 0.92, 0.96, 1.0][row];
    }
    let path = SkinPath::new(column, frame, points[EDGE_ROWS - 1], pose, globe_radius);
    let fold = Fold::new(column, &path, lowered);
    // The rows' places along the path, between its ends.
    let mut along = [0.0; SKIN_ROWS + 2];
    let mut bases = [points[EDGE_ROWS - 1]; SKIN_ROWS + 2];
    for k in 0..SKIN_ROWS {
        along[k + 1] = fold.row_mm(k) / path.length;
        bases[k + 1] = path.at(along[k + 1]);
    }
    (along[SKIN_ROWS + 1], bases[SKIN_ROWS + 1]) = (1.0, frame.border);
    for k in 0..SKIN_ROWS {
        let (v, base) = (along[k + 1], bases[k + 1]);
        let (a, before, after) = (v * path.length, v - along[k], along[k + 2] - v);
        // The derivative of the parabola through a row and its neighbours.
        let up = ((base - bases[k]) * (after * after) + (bases[k + 2] - base) * (before * before))
            .normalize_or_zero();
        let outwards = base.normalize_or_zero();
        let out = (outwards - up * up.dot(outwards)).normalize_or_zero();
        let fade = 1.0 - smoothstep(0.75, 1.0, v);
        points[EDGE_ROWS + k] = base + (out * fold.push_mm(a) - up * fold.overhang_mm(a)) * fade;
        light[EDGE_ROWS + k] = fold.light(a);
    }
}

/// The smooth skin line from the lash line to the border, before folds.
struct SkinPath<'a> {
    /// Unit vectors towards its start and across it towards its end, and the angle between start and end, rad.
    from: Vec3,
    across: Vec3,
    angle: f32,
    /// Height of the start over the globe, and distance of the end from its centre, mm.
    excess: f32,
    end: f32,
    length: f32,
    power: f32,
    thickness: f32,
    start_fix: Vec3,
    end_fix: Vec3,
    globe_radius: &'a dyn Fn(Vec3) -> f32,
}

impl<'a> SkinPath<'a> {
    fn new(
        column: &Column,
        frame: &ColumnFrame,
        start: Vec3,
        pose: &LidPose,
        globe_radius: &'a dyn Fn(Vec3) -> f32,
    ) -> Self {
        let end = frame.border;
        let angle = start.angle_between(end);
        let length = (angle * 0.5 * (start.length() + end.length()))
            .hypot(end.length() - start.length())
            .max(1.0);
        let (from, to) = (start.normalize_or_zero(), end.normalize_or_zero());
        let mut path = Self {
            from,
            across: (to - from * from.dot(to)).normalize_or_zero(),
            angle: from.angle_between(to),
            excess: start.length() - globe_radius(from),
            end: end.length(),
            length,
            // Skin under tension cuts the corner above the globe; below, it runs straight to the cheek.
            power: 1.4 + 0.9 * pose.lowered() - 0.15 * column.lower_weight(),
            thickness: column.thickness_mm(),
            start_fix: Vec3::ZERO,
            end_fix: Vec3::ZERO,
            globe_radius,
        };
        let step = 0.02;
        let first = (path.raw(step) - path.raw(0.0)) / step;
        let last = (path.raw(1.0) - path.raw(1.0 - step)) / step;
        // At a canthus the skin makes straight for the border.
        let chord = (end - start).normalize_or_zero();
        let leave = chord
            .lerp(frame.away, column.inside_weight(0.12))
            .normalize_or_zero();
        path.start_fix = leave * first.length() - first;
        path.end_fix = frame.border_tangent * last.length() - last;
        path
    }

    fn raw(&self, v: f32) -> Vec3 {
        let (sine, cosine) = (v * self.angle).sin_cos();
        let at = self.from * cosine + self.across * sine;
        let low = (self.globe_radius)(at) + self.excess;
        at * (low + (self.end - low) * v.powf(self.power))
    }

    fn at(&self, v: f32) -> Vec3 {
        let v = v.clamp(0.0, 1.0);
        // Cubic Hermite corrections: the path leaves along the lid and arrives along the face.
        let p = self.raw(v)
            + self.start_fix * (v * (1.0 - v) * (1.0 - v))
            + self.end_fix * (v * v * (v - 1.0));
        let reach = p.length().max(1e-6);
        let direction = p / reach;
        let floor = (self.globe_radius)(direction) + 0.85 * self.thickness;
        direction * reach.max(floor)
    }
}

/// The lid fold of one column: where it lies, how deep, and the rows that draw it.
struct Fold {
    upper: f32,
    lower: f32,
    crease_mm: f32,
    length: f32,
    scale: f32,
    depth: f32,
    width: f32,
    bulge: f32,
}

impl Fold {
    fn new(column: &Column, path: &SkinPath, lowered: f32) -> Self {
        let length = path.length;
        let scale = (length / 8.0).clamp(0.2, 1.0);
        // The crease is pinned to the levator: the lid slides out from under it.
        let crease = (2.6 + 5.6 * lowered).min(0.62 * length);
        let upper = column.fold_weight(lowered);
        Self {
            upper,
            lower: column.lower_weight(),
            crease_mm: crease.max(1.3 * scale),
            length,
            scale,
            depth: upper * scale * (0.62 - 0.42 * smoothstep(0.0, 0.65, lowered)),
            width: 0.62 + 0.5 * smoothstep(0.0, 0.7, lowered),
            bulge: upper * scale * (0.85 - 0.78 * smoothstep(0.0, 0.65, lowered)),
        }
    }

    /// Distance of skin row `k` from the lash line, mm.
    fn row_mm(&self, k: usize) -> f32 {
        const TARSAL: [f32; 6] = [0.14, 0.3, 0.48, 0.66, 0.84, 1.0];
        const CREASE: [f32; 9] = [-0.5, -0.24, -0.05, 0.12, 0.28, 0.48, 0.75, 1.1, 1.6];
        const ABOVE: [f32; 5] = [0.16, 0.34, 0.52, 0.7, 0.86];
        let near = self.crease_mm - 0.9 * self.scale;
        let far = self.crease_mm + 1.6 * self.scale;
        let folded = match k {
            0..6 => near * TARSAL[k],
            6..15 => self.crease_mm + CREASE[k - 6] * self.scale,
            _ => far + (self.length - far) * ABOVE[(k - 15).min(4)],
        };
        let even = self.length * ((k + 1) as f32 / (SKIN_ROWS + 1) as f32).powf(1.25);
        even + (folded - even) * self.upper
    }

    fn past_crease(&self, a: f32) -> f32 {
        (a - self.crease_mm) / self.scale
    }

    /// Displacement along the outward normal, mm.
    fn push_mm(&self, a: f32) -> f32 {
        let mut push = 0.0;
        // A fold is an upper lid's, a roll a lower one's.
        if self.upper > 0.0 {
            let c = self.past_crease(a);
            push -= self.depth * bell(c / self.width);
            push += self.bulge
                * smoothstep(-0.1, 0.6 + 0.9 * self.width, c)
                * bell((c - 0.75).max(0.0) / 3.0);
        }
        if self.lower > 0.0 {
            push += self.lower * (0.2 * bell((a - 2.8) / 1.8) - 0.18 * bell((a - 5.2) / 1.2));
        }
        push
    }

    /// How far the fold hangs down over the crease, mm.
    fn overhang_mm(&self, a: f32) -> f32 {
        if self.upper <= 0.0 {
            return 0.0;
        }
        let c = self.past_crease(a);
        0.45 * self.bulge * smoothstep(-0.1, 0.7, c) * bell((c - 0.7).max(0.0) / 1.2)
    }

    fn light(&self, a: f32) -> f32 {
        let c = self.past_crease(a);
        let crease = 0.9 * self.depth * bell(c / (1.1 * self.width));
        let under = 0.06 * self.lower * bell((a - 5.2) / 1.1);
        (1.0 - crease - under).clamp(0.05, 1.0)
    }
}

/// exp(−x²); nothing is left of it from 5 on.
fn bell(x: f32) -> f32 {
    if x.abs() < 5.0 { (-x * x).exp() } else { 0.0 }
}
