//! Soft bodies for the built-in scenes: hands, a head, clothes.
//!
//! Enters: a signed distance function in metres, negative inside. Leaves: its zero surface as a
//! [`Shape`], by naive surface nets (Gibson 1998, "Constrained elastic surface nets"): one vertex
//! in each lattice cell that the surface crosses, at the mean of the edge crossings, then one
//! Newton step onto the surface.

use super::shapes::Shape;
use glam::{Quat, UVec3, Vec2, Vec3};

/// Distance to a capsule whose radius runs from `ra` at `a` to `rb` at `b`, m (exact for equal
/// radii, a bound within the taper's slope otherwise).
pub fn capsule(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    let axis = b - a;
    let t = ((p - a).dot(axis) / axis.length_squared().max(1e-12)).clamp(0.0, 1.0);
    (p - a - axis * t).length() - (ra + (rb - ra) * t)
}

/// Approximate distance to an ellipsoid, exact on its surface, m.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = p - centre;
    let scaled = (q / radii).length();
    let gradient = (q / (radii * radii)).length();
    if gradient < 1e-9 {
        -radii.min_element()
    } else {
        scaled * (scaled - 1.0) / gradient
    }
}

/// Distance to a turned box with half extents `half` and rounding `radius`, m.
pub fn soft_box(p: Vec3, centre: Vec3, turn: Quat, half: Vec3, radius: f32) -> f32 {
    let q = (turn.inverse() * (p - centre)).abs() - (half - radius);
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - radius
}

/// Union of two distances, blended over `k` metres.
pub fn blend(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// `a` without `b`, blended over `k` metres.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    -blend(-a, b, k)
}

/// The zero surface of `distance` inside the box `low`–`high`, on a lattice of `cell` metres. The
/// surface must not leave the box, or it stays open there.
pub fn skin(distance: &dyn Fn(Vec3) -> f32, low: Vec3, high: Vec3, cell: f32) -> Shape {
    let count = ((high - low) / cell).ceil().max(Vec3::ONE).as_uvec3() + UVec3::ONE;
    let index = |p: UVec3| (p.x + count.x * (p.y + count.y * p.z)) as usize;
    let place = |p: UVec3| low + p.as_vec3() * cell;
    let mut field = Vec::with_capacity(index(count - UVec3::ONE) + 1);
    for z in 0..count.z {
        for y in 0..count.y {
            for x in 0..count.x {
                field.push(distance(place(UVec3::new(x, y, z))));
            }
        }
    }
    let mut shape = Shape::default();
    let mut vertex_of = vec![u32::MAX; field.len()];
    for z in 0..count.z - 1 {
        for y in 0..count.y - 1 {
            for x in 0..count.x - 1 {
                let p = UVec3::new(x, y, z);
                let value = |corner: UVec3| field[index(p + corner)];
                if let Some(offset) = crossing_mean(&value) {
                    vertex_of[index(p)] = shape.positions.len() as u32;
                    add_vertex(&mut shape, distance, place(p) + offset * cell, cell);
                }
            }
        }
    }
    for z in 1..count.z - 1 {
        for y in 1..count.y - 1 {
            for x in 1..count.x - 1 {
                let p = UVec3::new(x, y, z);
                for axis in 0..3 {
                    let (here, next) = (field[index(p)], field[index(p + UVec3::AXES[axis])]);
                    if (here < 0.0) != (next < 0.0) {
                        let (u, v) = (UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]);
                        let ring = [p, p - u, p - u - v, p - v].map(|q| vertex_of[index(q)]);
                        add_quad(&mut shape, ring, here < 0.0);
                    }
                }
            }
        }
    }
    shape
}

/// Mean of the points where a cell's twelve edges cross zero, in cell units.
fn crossing_mean(value: &dyn Fn(UVec3) -> f32) -> Option<Vec3> {
    let (mut sum, mut crossings) = (Vec3::ZERO, 0.0f32);
    for axis in 0..3 {
        let (u, v) = (UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]);
        for start in [UVec3::ZERO, u, v, u + v] {
            let (a, b) = (value(start), value(start + UVec3::AXES[axis]));
            if (a < 0.0) != (b < 0.0) {
                sum += start.as_vec3() + Vec3::AXES[axis] * (a / (a - b));
                crossings += 1.0;
            }
        }
    }
    (crossings > 0.0).then(|| sum / crossings)
}

fn add_vertex(shape: &mut Shape, distance: &dyn Fn(Vec3) -> f32, start: Vec3, cell: f32) {
    let h = cell * 0.2;
    let slope = |p: Vec3| {
        Vec3::from_array(std::array::from_fn(|axis| {
            let step = Vec3::AXES[axis] * h;
            (distance(p + step) - distance(p - step)) / (2.0 * h)
        }))
    };
    let gradient = slope(start);
    let step = distance(start) / gradient.length_squared().max(0.1);
    let position = start - (gradient * step).clamp_length_max(0.5 * cell);
    shape.positions.push(position);
    shape.normals.push(slope(position).normalize_or(Vec3::Y));
    shape
        .uvs
        .push(Vec2::new(position.x + position.z, -position.y));
    shape.tints.push(Vec3::ONE);
}

fn add_quad(shape: &mut Shape, ring: [u32; 4], forward: bool) {
    if ring.contains(&u32::MAX) {
        return;
    }
    let [a, b, c, d] = ring;
    for [i, j, k] in [[a, b, c], [a, c, d]] {
        let corners = if forward { [i, j, k] } else { [i, k, j] };
        let [p, q, r] = corners.map(|n| shape.positions[n as usize]);
        if (q - p).cross(r - p).length_squared() > 1e-20 {
            shape.indices.extend(corners);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn a_sphere_has_its_radius_volume_and_outward_normals() {
        let sphere = |p: Vec3| p.length() - 0.1;
        let shape = skin(&sphere, Vec3::splat(-0.13), Vec3::splat(0.13), 0.01);
        for (position, normal) in shape.positions.iter().zip(&shape.normals) {
            assert!((position.length() - 0.1).abs() < 2e-4);
            assert!(normal.dot(position.normalize()) > 0.99);
        }
        let volume: f32 = shape
            .indices
            .chunks(3)
            .map(|t| {
                let [a, b, c] = [0, 1, 2].map(|k| shape.positions[t[k] as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        let exact = 4.0 / 3.0 * PI * 1e-3;
        assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");
    }

    #[test]
    fn distances_are_zero_on_their_surfaces() {
        assert!(capsule(Vec3::new(0.2, 0.5, 0.0), Vec3::ZERO, Vec3::Y, 0.2, 0.2).abs() < 1e-6);
        let radii = Vec3::new(0.1, 0.2, 0.3);
        assert!(ellipsoid(Vec3::new(0.0, 0.2, 0.0), Vec3::ZERO, radii).abs() < 1e-6);
        assert!(ellipsoid(Vec3::ZERO, Vec3::ZERO, radii) < 0.0);
        let p = Vec3::new(1.0, 0.3, 0.2);
        assert!(soft_box(p, Vec3::ZERO, Quat::IDENTITY, Vec3::ONE, 0.1).abs() < 1e-6);
        assert!(blend(0.0, 0.0, 0.1) < 0.0 && carve(-1.0, -0.5, 0.1) > 0.0);
    }
}
