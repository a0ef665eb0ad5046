//! The globe's meshes: a sphere of directions, dense in front, pushed out to the
//! surface of sclera and cornea. The shader refines it: every pixel of the
//! cornea is traced exactly, so the mesh only has to cover the right pixels.

use super::shading::limbus::{clear_cornea_mm, limbal_reach_mm};
use crate::optics::globe::GlobeShape;
use bevy::asset::RenderAssetUsages;
use bevy::math::Vec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};

/// Vertices of a ring from the limbus outwards. Rasterisers shade whole blocks of pixels for each triangle that touches them (2×2
/// on a GPU, 4×4 on software), so no triangle is smaller than an outline needs: between 64 places the chords of a circle of
/// 6 mm lie 7 µm within it, a quarter of a pixel where 40 mm fill 1280.
const SECTORS: u32 = 64;
/// Rings of the clear cornea, the outermost of [`SECTORS`] and each as much smaller as it is narrower.
const CORNEA_RINGS: u32 = 10;
/// Rings between the limbus' two borders, where the surface bends most.
const LIMBUS_RINGS: u32 = 6;
/// Angle between rings of the sclera, and where the last one is, degrees: what lies further back is in no picture (a camera stands
/// up to 85° and an eye turns up to 45° aside, and behind 75° of the head's front there is the orbit).
const SCLERA_STEP_DEG: f32 = 4.0;
const BACK_DEG: f32 = 150.0;

/// How much smaller than the clear cornea its mesh is, mm: as far from the mesh, whose facets lie 7 µm below it, a view at 8 degrees to
/// the surface meets it. At 2 degrees 4 per cent of white are taken for cornea.
const WITHIN_MM: f64 = 0.05;

/// Angle from the axis (rad) at which the globe is `mm` from it, on its front.
fn angle_at(shape: &GlobeShape, mm: f64) -> f64 {
    let (mut below, mut above) = (0.0, core::f64::consts::FRAC_PI_2);
    for _ in 0..40 {
        let angle: f64 = 0.5 * (below + above);
        if shape.radius_at(angle.cos()) * angle.sin() < mm {
            below = angle;
        } else {
            above = angle;
        }
    }
    0.5 * (below + above)
}

/// A ring of the globe: its angle from the axis (rad), and how many vertices it has.
type Ring = (f32, u32);

/// Builds the meshes of cornea (where nothing else is seen), limbus and sclera in the eye frame, mm; neighbours share a ring.
pub fn globe_meshes(shape: &GlobeShape) -> [Mesh; 3] {
    let limbus_mm = shape.limbus_radius_mm();
    let sine = (limbus_mm + limbal_reach_mm()) / shape.sclera_radius_mm();
    let outer = sine.clamp(0.1, 0.9).asin() as f32;
    let inner = angle_at(shape, clear_cornea_mm(limbus_mm) - WITHIN_MM) as f32;
    let cornea = (0..=CORNEA_RINGS).map(|i| {
        let share = i as f32 / CORNEA_RINGS as f32;
        (inner * share, (SECTORS * i).div_ceil(CORNEA_RINGS).max(1))
    });
    let limbus = (0..=LIMBUS_RINGS).map(|i| {
        let share = i as f32 / LIMBUS_RINGS as f32;
        (inner + (outer - inner) * share, SECTORS)
    });
    let steps = ((BACK_DEG.to_radians() - outer) / SCLERA_STEP_DEG.to_radians()).ceil();
    let step = (BACK_DEG.to_radians() - outer) / steps;
    let sclera = (0..=steps as u32).map(|i| (outer + step * i as f32, SECTORS));
    [
        ring_mesh(shape, &cornea.collect::<Vec<_>>()),
        ring_mesh(shape, &limbus.collect::<Vec<_>>()),
        ring_mesh(shape, &sclera.collect::<Vec<_>>()),
    ]
}

/// Triangles between two rings about one axis, of `inner` and `outer` vertices that begin at these indices and at the same turn:
/// each step goes along the ring that is behind.
fn stitch((inner, from): (u32, u32), (outer, to): (u32, u32), indices: &mut Vec<u32>) {
    let (mut i, mut o) = (0, 0);
    while i < inner || o < outer {
        let (a, b) = (from + i % inner, to + o % outer);
        // Whose next vertex comes first; a ring of one is a point.
        if o < outer && (i == inner || inner == 1 || (o + 1) * inner <= (i + 1) * outer) {
            indices.extend([a, to + (o + 1) % outer, b]);
            o += 1;
        } else {
            if inner > 1 {
                indices.extend([a, from + (i + 1) % inner, b]);
            }
            i += 1;
        }
    }
}

fn ring_mesh(shape: &GlobeShape, rings: &[Ring]) -> Mesh {
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut indices = Vec::new();
    let mut before = None;
    for &(angle, count) in rings {
        let own = (count, positions.len() as u32);
        for sector in 0..count {
            let turn = sector as f32 / count as f32 * core::f32::consts::TAU;
            let direction = Vec3::new(
                angle.sin() * turn.cos(),
                angle.sin() * turn.sin(),
                -angle.cos(),
            );
            let radius = shape.radius_along(direction.as_dvec3()) as f32;
            positions.push((direction * radius).to_array());
            // Exact normals, so that neighbouring meshes agree along their border.
            let normal = shape.normal_along(direction.as_dvec3());
            normals.push(normal.as_vec3().to_array());
        }
        if let Some(before) = before.replace(own) {
            stitch(before, own, &mut indices);
        }
    }
    let count = positions.len();
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[0.0f32; 4]; count])
    .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0f32; 4]; count])
    .with_inserted_indices(Indices::U32(indices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Vertices and triangles.
    type Part = (Vec<Vec3>, Vec<[usize; 3]>);

    /// The meshes of an eye.
    fn built() -> (GlobeShape, Vec<Part>) {
        let shape = GlobeShape::default();
        let parts = globe_meshes(&shape).map(|mesh| {
            let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
            let Some(bevy::mesh::VertexAttributeValues::Float32x3(positions)) = positions else {
                panic!("positions are three floats");
            };
            let positions = positions.iter().map(|p| Vec3::from_array(*p)).collect();
            let corners: Vec<usize> = mesh.indices().into_iter().flat_map(Indices::iter).collect();
            let triangles = corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
            (positions, triangles)
        });
        (shape, parts.into())
    }

    /// Every edge inside a part belongs to two triangles, and what has one lies on a ring that its neighbour has too: there is no
    /// crack, and nothing twice.
    #[test]
    fn the_parts_close_and_face_outwards() {
        let (_, parts) = built();
        let key = |p: Vec3| (p * 1e4).round().as_ivec3().to_array();
        let mut open: BTreeMap<_, u32> = BTreeMap::new();
        for (positions, triangles) in &parts {
            let mut edges: BTreeMap<_, u32> = BTreeMap::new();
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| positions[corner]);
                let middle = (a + b + c) / 3.0;
                assert!((b - a).cross(c - a).dot(middle) > 0.0, "{a} {b} {c}");
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    let ends = [key(positions[corners[from]]), key(positions[corners[to]])];
                    let ends = if ends[0] < ends[1] {
                        ends
                    } else {
                        [ends[1], ends[0]]
                    };
                    *edges.entry(ends).or_default() += 1;
                }
            }
            assert!(edges.values().all(|&count| count <= 2));
            for (ends, _) in edges.iter().filter(|(_, count)| **count == 1) {
                *open.entry(*ends).or_default() += 1;
            }
        }
        let alone = open.values().filter(|&&count| count == 1).count();
        assert_eq!(
            alone, SECTORS as usize,
            "only the last ring at the back is open"
        );
    }

    /// The cornea's outline: no place of its mesh lies further behind the surface than an eighth of the pixel of a picture in
    /// which 40 mm fill 320, and none before it.
    #[test]
    fn facets_follow_the_surface() {
        let (shape, parts) = built();
        let mut deepest = [0.0_f32; 3];
        for (part, (positions, triangles)) in parts.iter().enumerate() {
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| positions[corner]);
                for p in [
                    (a + b) / 2.0,
                    (b + c) / 2.0,
                    (c + a) / 2.0,
                    (a + b + c) / 3.0,
                ] {
                    let behind = shape.radius_along(p.as_dvec3()) as f32 - p.length();
                    // Where cornea and sclera meet the globe is hollow.
                    assert!(part == 1 || behind > -1e-4, "{p}: {behind} mm");
                    deepest[part] = deepest[part].max(behind.abs());
                }
            }
        }
        let pixel_mm = 40.0 / 320.0;
        assert!(
            deepest[0] < pixel_mm / 8.0 && deepest[1] < pixel_mm / 8.0,
            "{deepest:?}"
        );
        // The white is behind lids wherever its outline is.
        assert!(deepest[2] < pixel_mm / 2.0, "{deepest:?}");
    }
}
