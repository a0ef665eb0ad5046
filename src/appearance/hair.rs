//! Hairs as tapered ribbons that face the camera.
//!
//! In: the centre line of each hair and its radius at the root. Out: one mesh with a fixed topology:
//! for each point of a line two vertices, root first, which [`hair_ribbon`](super::shading::hair_shade::hair_ribbon)
//! draws apart to the hair's width from wherever it is seen. A round hair looks the same, for it is shaded by its direction
//! alone (Kajiya and Kay 1989). Any length unit; the eye uses mm.

use super::region_parts;
use glam::Vec3;

/// Vertices at each point of a line: the ribbon's two edges.
pub const EDGES: usize = 2;

/// Many hairs, posed: all of a vertex but its half width.
#[derive(Clone, Debug, Default)]
pub struct HairMesh {
    /// Points of the centre lines, each [`EDGES`] times.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors from each hair's root to its tip.
    pub chords: Vec<[f32; 3]>,
    /// Unit vectors along the hair, towards its tip.
    pub along: Vec<[f32; 3]>,
}

/// How finely hairs are divided: as finely as skin, and more coarsely yet where a hair is far thinner than a pixel.
pub const LEVELS: usize = region_parts::LEVELS + 1;

/// Pixels for each millimetre from which the next finer level is drawn: below the last a hair covers less than a tenth of a pixel, so that half as many
/// of twice the width look like them.
pub const PIXELS_A_MM: [f32; LEVELS - 1] = {
    let [fine, coarse] = region_parts::PIXELS_A_MM;
    [fine, coarse, 1.0]
};

/// A level of division of some hairs: how many points each has, and of how many one is drawn, which is as many times as wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HairLevel {
    /// Points along a hair (2 or more).
    pub points: usize,
    /// Of so many hairs (1 or more) one is drawn.
    pub one_of: usize,
}

impl HairLevel {
    /// So many points, and one of so many hairs.
    pub const fn new(points: usize, one_of: usize) -> Self {
        Self { points, one_of }
    }
}

/// What of a mesh of hairs does not move.
#[derive(Clone, Debug, Default)]
pub struct HairStrips {
    /// Triangles.
    pub indices: Vec<u32>,
    /// Root (0) to tip (1) for each vertex.
    pub parameter: Vec<f32>,
    /// Half of the width at each vertex, negative on one of the two edges: a tenth is left at the tip.
    pub half_widths_mm: Vec<f32>,
}

impl HairStrips {
    /// Of hairs of these radii (mm) at the root.
    pub fn new(radii: impl Iterator<Item = f32>, level: HairLevel) -> Self {
        let HairLevel { points, one_of } = level;
        let along = |point: usize| point as f32 / (points - 1) as f32;
        let mut own = Self::default();
        for (hair, radius) in radii.step_by(one_of).enumerate() {
            let wide = radius * one_of as f32;
            for point in 0..points {
                let s = along(point);
                let half_width = wide * (0.1 + 0.9 * (1.0 - s * s.sqrt()));
                own.half_widths_mm.extend([-half_width, half_width]);
                own.parameter.extend([s; EDGES]);
            }
            for point in 0..points - 1 {
                let first = ((hair * points + point) * EDGES) as u32;
                let [a, b, c, d] = [0, 1, 3, 2].map(|corner| first + corner);
                own.indices.extend([a, b, c, a, c, d]);
            }
        }
        own
    }
}

impl HairMesh {
    /// Empties the mesh and keeps its memory.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.chords.clear();
        self.along.clear();
    }

    /// Adds one hair along `line` (2 points or more).
    pub fn push(&mut self, line: &[Vec3]) {
        let last = line.len().saturating_sub(1);
        let along = |point: usize| {
            (line[(point + 1).min(last)] - line[point.saturating_sub(1)]).normalize_or(Vec3::NEG_Z)
        };
        if line.is_empty() {
            return;
        }
        let chord = (line[last] - line[0]).normalize_or(along(0));
        for (point, at) in line.iter().enumerate() {
            for _ in 0..EDGES {
                self.positions.push(at.to_array());
                self.chords.push(chord.to_array());
                self.along.push(along(point).to_array());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::shading::hair_shade::hair_ribbon;

    const POINTS: usize = 8;

    #[test]
    fn a_hair_has_the_asked_length_and_taper() {
        let line: [Vec3; POINTS] =
            std::array::from_fn(|i| Vec3::new(0.0, i as f32, 0.1 * (i * i) as f32));
        let mut mesh = HairMesh::default();
        mesh.push(&line);
        assert_eq!(mesh.positions.len(), POINTS * EDGES);
        for (vertex, position) in mesh.positions.iter().enumerate() {
            assert_eq!(Vec3::from(*position), line[vertex / EDGES]);
        }
        let strips = HairStrips::new([0.06, 0.03].into_iter(), HairLevel::new(POINTS, 1));
        let widths = &strips.half_widths_mm;
        assert_eq!(widths.len(), 2 * POINTS * EDGES);
        assert_eq!(widths[..2], [-0.06, 0.06]);
        assert!((widths[POINTS * EDGES - 1] - 0.006).abs() < 1e-6);
        assert_eq!(widths[POINTS * EDGES + 1], 0.03);
        let s = &strips.parameter;
        assert_eq!(
            (s[0], s[POINTS * EDGES - 1], s[POINTS * EDGES]),
            (0.0, 1.0, 0.0)
        );
        let mut used = strips.indices.clone();
        used.sort_unstable();
        used.dedup();
        assert!(used.into_iter().eq(0..(2 * POINTS * EDGES) as u32));
    }

    #[test]
    fn a_ribbon_is_as_wide_as_its_hair_from_every_side_and_never_twists() {
        // A lash: it leaves downwards and curls up, so from the front it points at the camera somewhere.
        let line: [Vec3; POINTS] = std::array::from_fn(|i| {
            let angle = -0.26 + 1.2 * i as f32 / (POINTS - 1) as f32;
            let (sin, cos) = angle.sin_cos();
            Vec3::new(0.1 * i as f32, sin, -cos) * (1.0 + i as f32)
        });
        let mut mesh = HairMesh::default();
        mesh.push(&line);
        for (azimuth, elevation) in [(0.0, 0.0), (0.6, 0.0), (-1.2, 0.4), (2.9, -0.8), (0.0, 1.5)] {
            let (azimuth, elevation): (f32, f32) = (azimuth, elevation);
            let camera = 200.0
                * Vec3::new(
                    azimuth.sin() * elevation.cos(),
                    elevation.sin(),
                    -azimuth.cos() * elevation.cos(),
                );
            for point in 0..POINTS {
                let vertex = point * EDGES;
                let [at, chord, along] =
                    [&mesh.positions, &mesh.chords, &mesh.along].map(|of| Vec3::from(of[vertex]));
                let edge = |half_width: f64| {
                    hair_ribbon(
                        at.as_dvec3(),
                        along.as_dvec3(),
                        chord.as_dvec3(),
                        camera.as_dvec3(),
                        half_width,
                    )
                };
                let wide = edge(0.05) - edge(-0.05);
                let view = (camera - at).normalize().as_dvec3();
                assert!((wide.length() - 0.1).abs() < 1e-9);
                // Both directions are of single precision.
                assert!(wide.dot(view).abs() < 1e-8 && wide.dot(along.as_dvec3()).abs() < 1e-8);
                // Both edges stay on their sides of the hair as it is seen.
                assert!(wide.dot(chord.as_dvec3().cross(view)) >= 0.0);
            }
        }
    }
}
