//! Hairs as thin tapered tubes with three sides.
//!
//! In: the centre line of each hair and its radius at the root. Out: one mesh with a fixed topology:
//! for each point of a line a ring of [`SIDES`] vertices, root first. Any length unit; the eye uses mm.

use glam::Vec3;

/// Vertices around a ring.
pub const SIDES: usize = 3;

/// Many hairs, posed.
#[derive(Clone, Debug, Default)]
pub struct HairMesh {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, away from the hair's axis.
    pub normals: Vec<[f32; 3]>,
}

/// Triangles of `hairs` hairs of so many rings (2 or more), counter-clockwise from outside.
pub fn hair_indices(hairs: usize, rings: usize) -> Vec<u32> {
    let mut out = Vec::with_capacity(hairs * (rings - 1) * SIDES * 6);
    for h in 0..hairs {
        let at = |ring: usize, side: usize| ((h * rings + ring) * SIDES + side % SIDES) as u32;
        for ring in 0..rings - 1 {
            for side in 0..SIDES {
                let [a, b] = [at(ring, side), at(ring, side + 1)];
                let [c, d] = [at(ring + 1, side + 1), at(ring + 1, side)];
                out.extend([a, b, c, a, c, d]);
            }
        }
    }
    out
}

/// Root (0) to tip (1) for each vertex of `hairs` hairs of so many rings (2 or more).
pub fn hair_parameter(hairs: usize, rings: usize) -> Vec<f32> {
    (0..hairs * rings * SIDES)
        .map(|i| (i / SIDES % rings) as f32 / (rings - 1) as f32)
        .collect()
}

impl HairMesh {
    /// Empties the mesh and keeps its memory.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.normals.clear();
    }

    /// Adds one hair along `line` (2 points or more), `radius` at the root, a fifth of it at the tip.
    pub fn push(&mut self, line: &[Vec3], radius: f32) {
        let last = line.len().saturating_sub(1);
        let mut side = Vec3::ZERO;
        for ring in 0..line.len() {
            let along = (line[(ring + 1).min(last)] - line[ring.saturating_sub(1)])
                .normalize_or(Vec3::NEG_Z);
            // Carried along the hair, so that the tube does not twist.
            side = (side - along * side.dot(along))
                .try_normalize()
                .unwrap_or_else(|| along.any_orthonormal_vector());
            let other = along.cross(side);
            let s = ring as f32 / last.max(1) as f32;
            let thick = radius * (0.2 + 0.8 * (1.0 - s * s));
            for k in 0..SIDES {
                let (sin, cos) = (std::f32::consts::TAU * k as f32 / SIDES as f32).sin_cos();
                let normal = side * cos + other * sin;
                self.positions
                    .push((line[ring] + normal * thick).to_array());
                self.normals.push(normal.to_array());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RINGS: usize = 8;

    #[test]
    fn a_hair_has_the_asked_length_taper_and_outward_triangles() {
        let line: [Vec3; RINGS] =
            std::array::from_fn(|i| Vec3::new(0.0, i as f32, 0.1 * (i * i) as f32));
        let mut mesh = HairMesh::default();
        mesh.push(&line, 0.06);
        assert_eq!(mesh.positions.len(), RINGS * SIDES);
        let width = |ring: usize| Vec3::from(mesh.positions[ring * SIDES]).distance(line[ring]);
        assert!((width(0) - 0.06).abs() < 1e-6 && (width(RINGS - 1) - 0.012).abs() < 1e-6);
        for t in hair_indices(1, RINGS).chunks(3) {
            let p = |k: usize| Vec3::from(mesh.positions[t[k] as usize]);
            let face = (p(1) - p(0)).cross(p(2) - p(0));
            let outward = (0..3)
                .map(|k| Vec3::from(mesh.normals[t[k] as usize]))
                .sum::<Vec3>();
            assert!(face.dot(outward) > 0.0);
        }
        let s = hair_parameter(2, RINGS);
        assert_eq!(
            (s[0], s[RINGS * SIDES - 1], s[RINGS * SIDES]),
            (0.0, 1.0, 0.0)
        );
    }
}
