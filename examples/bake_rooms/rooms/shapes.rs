//! Procedural solids for the built-in scenes.
//!
//! Enters: sizes in metres. Leaves: a [`Shape`], triangles with unit normals, texture coordinates
//! and linear tints, which [`Shape::mesh`] turns into a [`SceneMesh`].

use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3};
use ocularium::scene::model::SceneMesh;
use std::f32::consts::{PI, TAU};

/// Triangles under construction.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Positions, m.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v down.
    pub uvs: Vec<Vec2>,
    /// Linear colour multipliers.
    pub tints: Vec<Vec3>,
    /// Triangles, counter-clockwise from the front.
    pub indices: Vec<u32>,
}

impl Shape {
    fn push(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.tints.push(Vec3::ONE);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle unless two of its corners coincide, which happens at poles.
    fn triangle(&mut self, a: u32, b: u32, c: u32) {
        let [p, q, r] = [a, b, c].map(|i| self.positions[i as usize]);
        if (q - p).cross(r - p).length_squared() > 1e-20 {
            self.indices.extend([a, b, c]);
        }
    }

    /// A lattice of quads over `(columns + 1) · (rows + 1)` vertices that were pushed row by row
    /// from `first`.
    fn lattice(&mut self, first: u32, columns: u32, rows: u32) {
        for row in 0..rows {
            for column in 0..columns {
                let a = first + row * (columns + 1) + column;
                let (b, c) = (a + 1, a + columns + 1);
                self.triangle(a, b, c + 1);
                self.triangle(a, c + 1, c);
            }
        }
    }

    /// A flat rectangle from `origin` along `u` (texture right) and `v` (texture up), front side
    /// at `u × v`, split into cells of at most `cell` metres.
    pub fn sheet(origin: Vec3, u: Vec3, v: Vec3, cell: f32) -> Self {
        let mut shape = Self::default();
        let (columns, rows) = (cells(u.length(), cell), cells(v.length(), cell));
        let normal = u.cross(v).normalize_or(Vec3::Y);
        for row in 0..=rows {
            for column in 0..=columns {
                let (s, t) = (column as f32 / columns as f32, row as f32 / rows as f32);
                shape.push(origin + u * s + v * t, normal, Vec2::new(s, 1.0 - t));
            }
        }
        shape.lattice(0, columns, rows);
        shape
    }

    /// An upright picture of `width × height` metres centred on the origin, facing +z.
    pub fn picture(width: f32, height: f32) -> Self {
        let corner = Vec3::new(-width / 2.0, -height / 2.0, 0.0);
        Self::sheet(
            corner,
            Vec3::X * width,
            Vec3::Y * height,
            0.25 * width.max(height),
        )
    }

    /// A box with rounded edges centred on the origin; texture coordinates are metres on each
    /// face. `cell` is the largest vertex distance on the flats.
    pub fn rounded_box(size: Vec3, radius: f32, cell: f32) -> Self {
        let mut shape = Self::default();
        let half = size / 2.0;
        let radius = radius.min(half.min_element());
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                shape.box_face(half, radius, cell, axis, sign);
            }
        }
        shape
    }

    fn box_face(&mut self, half: Vec3, radius: f32, cell: f32, axis: usize, sign: f32) {
        let (ua, va) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = self.positions.len() as u32;
        let (us, vs) = (
            bevelled(half[ua], radius, cell),
            bevelled(half[va], radius, cell),
        );
        for &v in &vs {
            for &u in &us {
                let mut p = Vec3::ZERO;
                p[axis] = sign * half[axis];
                p[ua] = sign * u;
                p[va] = v;
                let core = p.clamp(-(half - radius), half - radius);
                let normal = (p - core).normalize_or(Vec3::AXES[axis] * sign);
                let position = if radius > 0.0 {
                    core + normal * radius
                } else {
                    p
                };
                // Side faces keep y upright so that wood grain and text do not turn.
                let uv = match axis {
                    0 => Vec2::new(-sign * position.z, -position.y),
                    1 => Vec2::new(position.x, sign * position.z),
                    _ => Vec2::new(sign * position.x, -position.y),
                };
                self.push(position, normal, uv);
            }
        }
        self.lattice(first, us.len() as u32 - 1, vs.len() as u32 - 1);
    }

    /// A solid of revolution about y. `profile` lists (radius, height) from bottom to top along
    /// the outside; corners sharper than 40° stay sharp.
    pub fn lathe(profile: &[(f32, f32)], sides: u32) -> Self {
        let mut shape = Self::default();
        let points: Vec<Vec2> = profile.iter().map(|&(r, y)| Vec2::new(r, y)).collect();
        let outward = |i: usize| {
            let along = (points[i + 1] - points[i]).normalize_or(Vec2::Y);
            Vec2::new(along.y, -along.x)
        };
        let total: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let mut travelled = 0.0;
        for i in 0..points.len().saturating_sub(1) {
            let own = outward(i);
            let soften = |other: Vec2| {
                if own.dot(other) > 0.766 {
                    (own + other).normalize_or(own)
                } else {
                    own
                }
            };
            let below = if i > 0 { soften(outward(i - 1)) } else { own };
            let above = if i + 2 < points.len() {
                soften(outward(i + 1))
            } else {
                own
            };
            let first = shape.positions.len() as u32;
            for (end, normal) in [(i, below), (i + 1, above)] {
                let distance = if end == i {
                    0.0
                } else {
                    points[i].distance(points[i + 1])
                };
                let v = 1.0 - (travelled + distance) / total.max(1e-9);
                for side in 0..=sides {
                    let angle = TAU * side as f32 / sides as f32;
                    let spoke = Vec3::new(angle.sin(), 0.0, angle.cos());
                    shape.push(
                        spoke * points[end].x + Vec3::Y * points[end].y,
                        (spoke * normal.x + Vec3::Y * normal.y).normalize_or(Vec3::Y),
                        Vec2::new(side as f32 / sides as f32, v),
                    );
                }
            }
            travelled += points[i].distance(points[i + 1]);
            shape.lattice(first, sides, 1);
        }
        shape
    }

    /// An ellipsoid centred on the origin.
    pub fn ellipsoid(radii: Vec3, sides: u32) -> Self {
        let rings = (sides / 2).max(4);
        let profile: Vec<(f32, f32)> = (0..=rings)
            .map(|ring| {
                let angle = PI * ring as f32 / rings as f32;
                (angle.sin().max(0.0), -angle.cos())
            })
            .collect();
        Self::lathe(&profile, sides).moved(Affine3A::from_scale(radii))
    }

    /// A round tube through `path` with a radius at each point, ends closed by domes.
    pub fn tube(path: &[Vec3], radii: &[f32], sides: u32) -> Self {
        let mut shape = Self::default();
        let tangent = |i: usize| {
            (path[(i + 1).min(path.len() - 1)] - path[i.saturating_sub(1)]).normalize_or(Vec3::Y)
        };
        let mut side = tangent(0).any_orthonormal_vector();
        let last = path.len() - 1;
        let mut rings: Vec<(Vec3, Vec3, f32, f32)> = Vec::new();
        let dome = [(1.0f32, 0.0f32), (0.7, 0.7), (0.0, 1.0)];
        for &(shrink, rise) in dome.iter().rev() {
            let (axis, radius) = (tangent(0), radii[0]);
            rings.push((path[0] - axis * radius * rise, axis, radius * shrink, -rise));
        }
        for i in 1..last {
            rings.push((path[i], tangent(i), radii[i], 0.0));
        }
        for &(shrink, rise) in &dome {
            let (axis, radius) = (tangent(last), radii[last]);
            rings.push((
                path[last] + axis * radius * rise,
                axis,
                radius * shrink,
                rise,
            ));
        }
        let count = rings.len();
        for (row, (centre, axis, radius, lean)) in rings.into_iter().enumerate() {
            side = (side - axis * side.dot(axis)).normalize_or(axis.any_orthonormal_vector());
            let other = axis.cross(side);
            for k in 0..=sides {
                let angle = TAU * k as f32 / sides as f32;
                let spoke = side * angle.cos() + other * angle.sin();
                let normal = (spoke * (1.0 - lean.abs()) + axis * lean).normalize_or(spoke);
                let uv = Vec2::new(k as f32 / sides as f32, 1.0 - row as f32 / count as f32);
                shape.push(centre + spoke * radius, normal, uv);
            }
        }
        shape.lattice(0, sides, count as u32 - 1);
        shape
    }

    /// A leaf or petal: a pointed blade of `length × width` along +y that droops towards +z.
    pub fn blade(length: f32, width: f32, droop: f32, tip: f32) -> Self {
        let mut shape = Self::default();
        let rows = 5;
        for row in 0..=rows {
            let t = row as f32 / rows as f32;
            let angle = droop * t;
            let spine = if droop.abs() < 1e-3 {
                Vec3::Y * length * t
            } else {
                Vec3::new(0.0, angle.sin(), 1.0 - angle.cos()) * (length / droop)
            };
            let half = 0.5 * width * ((PI * t.powf(tip)).sin() + 0.04);
            let normal = Vec3::new(0.0, -angle.sin(), angle.cos());
            for column in 0..=2u8 {
                let s = f32::from(column) - 1.0;
                // The blade is folded along its midrib.
                let fold = normal * (s.abs() * half * 0.35);
                let tilted = (normal - Vec3::X * (s * 0.33)).normalize_or(normal);
                let uv = Vec2::new(0.5 + 0.5 * s, 1.0 - t);
                shape.push(spine + Vec3::X * (s * half) + fold, tilted, uv);
            }
        }
        shape.lattice(0, 2, rows);
        shape
    }

    /// A hanging curtain in the xy plane from `(0, 0)` to `(width, height)`, folds along y.
    pub fn curtain(width: f32, height: f32, folds: f32, depth: f32) -> Self {
        let mut shape = Self::default();
        let (columns, rows) = ((folds * 10.0) as u32, 8);
        for row in 0..=rows {
            let t = row as f32 / rows as f32;
            for column in 0..=columns {
                let s = column as f32 / columns as f32;
                // Folds are pinched together at the rail and open towards the hem.
                let swing = depth * (1.0 - 0.55 * t);
                let phase = TAU * folds * s + 0.6 * (5.0 * s + 2.0 * t).sin();
                let slope = swing * phase.cos() * TAU * folds / width;
                let normal = Vec3::new(-slope, 0.0, 1.0).normalize();
                let position = Vec3::new(width * s, height * t, swing * phase.sin());
                shape.push(position, normal, Vec2::new(width * s, -height * t));
            }
        }
        shape.lattice(0, columns, rows);
        shape
    }

    /// Moves, turns and scales; normals stay perpendicular under unequal scales.
    #[must_use]
    pub fn moved(mut self, by: Affine3A) -> Self {
        let normal_matrix: Mat3A = by.matrix3.inverse().transpose();
        for position in &mut self.positions {
            *position = by.transform_point3(*position);
        }
        for normal in &mut self.normals {
            *normal = (normal_matrix * *normal).normalize_or(Vec3::Y);
        }
        self
    }

    /// Moves by a vector, m.
    #[must_use]
    pub fn at(self, x: f32, y: f32, z: f32) -> Self {
        self.moved(Affine3A::from_translation(Vec3::new(x, y, z)))
    }

    /// Turns about the origin.
    #[must_use]
    pub fn turned(self, rotation: Quat) -> Self {
        self.moved(Affine3A::from_quat(rotation))
    }

    /// Multiplies all tints by a linear colour.
    #[must_use]
    pub fn tinted(mut self, color: [f32; 3]) -> Self {
        for tint in &mut self.tints {
            *tint *= Vec3::from(color);
        }
        self
    }

    /// Multiplies texture coordinates: with metre coordinates, repeats per metre.
    #[must_use]
    pub fn uv_scaled(mut self, u: f32, v: f32) -> Self {
        for uv in &mut self.uvs {
            *uv *= Vec2::new(u, v);
        }
        self
    }

    /// Swaps u and v, which turns a grain by 90°.
    #[must_use]
    pub fn uv_turned(mut self) -> Self {
        for uv in &mut self.uvs {
            *uv = Vec2::new(uv.y, uv.x);
        }
        self
    }

    /// Maps all coordinates into one rectangle `[u0, v0, u1, v1]` of an atlas, from 0–1.
    #[must_use]
    pub fn uv_into(mut self, [u0, v0, u1, v1]: [f32; 4]) -> Self {
        for uv in &mut self.uvs {
            *uv = Vec2::new(u0 + (u1 - u0) * uv.x, v0 + (v1 - v0) * uv.y);
        }
        self
    }

    /// Adds another shape to this one.
    pub fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.tints.extend(other.tints);
        self.indices.extend(other.indices.iter().map(|i| i + first));
    }

    /// The sum of several shapes.
    pub fn joined(shapes: impl IntoIterator<Item = Self>) -> Self {
        shapes.into_iter().fold(Self::default(), |mut sum, shape| {
            sum.append(shape);
            sum
        })
    }

    /// The finished mesh.
    pub fn mesh(self, name: &str, material: usize) -> SceneMesh {
        SceneMesh {
            second_uvs: None,
            name: name.into(),
            positions: self.positions.into_iter().map(Into::into).collect(),
            normals: self.normals.into_iter().map(Into::into).collect(),
            uvs: Some(self.uvs.into_iter().map(Into::into).collect()),
            colors: Some(self.tints.iter().map(|t| [t.x, t.y, t.z, 1.0]).collect()),
            indices: self.indices,
            material,
        }
    }
}

/// Number of cells of at most `cell` metres along `length`.
fn cells(length: f32, cell: f32) -> u32 {
    (length / cell).ceil().clamp(1.0, 200.0) as u32
}

/// Coordinates across one face of a rounded box: a bevel, the flat, a bevel. The
/// bevel's points lie where equal angles of the quarter circle (45°, 22.5°) meet the square box.
fn bevelled(half: f32, radius: f32, cell: f32) -> Vec<f32> {
    let flat = half - radius;
    let mut coordinates = Vec::new();
    // A fine edge needs no round section: shading alone makes it look round.
    let bevel: &[f32] = if radius > 0.008 {
        &[1.0, 0.414_213_56]
    } else {
        &[1.0]
    };
    if radius > 0.0 {
        coordinates.extend(bevel.iter().map(|t| -flat - radius * t));
    }
    // A fully round edge has no flat part, only its middle line.
    let steps = if flat > 1e-6 {
        cells(2.0 * flat, cell)
    } else {
        0
    };
    for step in 0..=steps {
        coordinates.push(-flat + 2.0 * flat * step as f32 / steps.max(1) as f32);
    }
    if radius > 0.0 {
        coordinates.extend(bevel.iter().rev().map(|t| flat + radius * t));
    }
    coordinates
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Enclosed volume by the divergence theorem; positive only if faces point outwards.
    fn volume(shape: &Shape) -> f32 {
        let corner = |i: u32| shape.positions[i as usize];
        shape.indices.chunks(3).fold(0.0, |sum, t| {
            sum + corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0
        })
    }

    fn check(shape: Shape, expected_volume: f32, tolerance: f32) {
        assert!((volume(&shape) - expected_volume).abs() < tolerance * expected_volume);
        for triangle in shape.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| triangle[k] as usize);
            let face = (shape.positions[b] - shape.positions[a])
                .cross(shape.positions[c] - shape.positions[a]);
            let normal = shape.normals[a] + shape.normals[b] + shape.normals[c];
            assert!(face.dot(normal) > 0.0, "a normal points inwards");
        }
        assert_eq!(shape.mesh("t", 0).fault(1), None);
    }

    #[test]
    fn solids_are_closed_face_outwards_and_have_their_volume() {
        check(
            Shape::rounded_box(Vec3::new(1.0, 2.0, 3.0), 0.0, 0.3),
            6.0,
            1e-4,
        );
        // Steiner's formula for a 1 m box rounded by 0.1 m; two bevel steps lie inside it.
        let core = 0.8f32;
        let rounded = core.powi(3)
            + 6.0 * core * core * 0.1
            + 12.0 * core * PI * 0.01 / 4.0
            + 4.0 / 3.0 * PI * 0.001;
        check(Shape::rounded_box(Vec3::ONE, 0.1, 0.3), rounded, 5e-3);
        let radii = Vec3::new(0.1, 0.2, 0.3);
        check(Shape::ellipsoid(radii, 48), 4.0 / 3.0 * PI * 0.006, 1e-2);
        check(
            Shape::lathe(&[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)], 64),
            2.0 * PI,
            5e-3,
        );
        let path = [Vec3::ZERO, Vec3::Y, Vec3::Y * 2.0];
        check(
            Shape::tube(&path, &[0.1; 3], 32),
            PI * 0.02 + 4.0 / 3.0 * PI * 1e-3,
            0.02,
        );
    }

    #[test]
    fn a_fully_round_box_is_a_sphere_like_solid() {
        let ball = Shape::rounded_box(Vec3::ONE, 0.5, 0.3);
        for position in &ball.positions {
            assert!((position.length() - 0.5).abs() < 1e-5);
        }
        assert_eq!(ball.mesh("ball", 0).fault(1), None);
    }
}
