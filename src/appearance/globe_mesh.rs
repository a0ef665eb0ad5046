//! The globe's mesh: a sphere of directions, dense in front, pushed out to the
//! surface of sclera and cornea. The shader refines it: every pixel of the
//! cornea is traced exactly, so the mesh only has to cover the right pixels.

use crate::optics::globe::GlobeShape;
use bevy::asset::RenderAssetUsages;
use bevy::math::Vec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};

const SECTORS: u32 = 96;

/// Angles from the corneal axis (rad) of the mesh's rings: fine where the cornea
/// rises out of the sclera, coarse at the back.
fn rings() -> Vec<f32> {
    let front = (0..=36).map(|i| i as f32 * 1.0);
    let middle = (1..=27).map(|i| 36.0 + i as f32 * 2.0);
    let back = (1..=15).map(|i| 90.0 + i as f32 * 6.0);
    front
        .chain(middle)
        .chain(back)
        .map(f32::to_radians)
        .collect()
}

/// Builds the mesh in the eye frame, mm.
pub fn globe_mesh(shape: &GlobeShape) -> Mesh {
    let rings = rings();
    let mut positions = Vec::with_capacity(rings.len() * (SECTORS as usize + 1));
    for &angle in &rings {
        for sector in 0..=SECTORS {
            let turn = sector as f32 / SECTORS as f32 * std::f32::consts::TAU;
            let direction = Vec3::new(
                angle.sin() * turn.cos(),
                angle.sin() * turn.sin(),
                -angle.cos(),
            );
            let radius = shape.radius_along(direction.as_dvec3()) as f32;
            positions.push((direction * radius).to_array());
        }
    }
    let row = SECTORS + 1;
    let mut indices = Vec::new();
    for ring in 0..rings.len() as u32 - 1 {
        for sector in 0..SECTORS {
            let a = ring * row + sector;
            let (b, c, d) = (a + 1, a + row, a + row + 1);
            indices.extend([a, b, c, b, d, c]);
        }
    }
    let count = positions.len();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[0.0f32; 4]; count])
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0f32; 4]; count])
        .with_inserted_indices(Indices::U32(indices));
    mesh.compute_smooth_normals();
    mesh
}
