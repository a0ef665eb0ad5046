//! The globe's meshes: a sphere of directions, dense in front, pushed out to the
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

/// Reach of the limbus' soft edge outside its radius, mm (`shaders/lib/limbus.wgsl`).
const LIMBAL_REACH_MM: f64 = 0.34;

/// Builds the meshes of cornea (with the limbus) and sclera in the eye frame, mm; they share a ring.
pub fn globe_meshes(shape: &GlobeShape) -> [Mesh; 2] {
    let sine = (shape.limbus_radius_mm() + LIMBAL_REACH_MM) / shape.sclera_radius_mm();
    let border = sine.clamp(0.1, 0.9).asin() as f32;
    let all = rings();
    let cornea = all.iter().copied().filter(|&angle| angle < border - 0.005);
    let sclera = all.iter().copied().filter(|&angle| angle > border + 0.005);
    [
        ring_mesh(shape, &cornea.chain([border]).collect::<Vec<_>>()),
        ring_mesh(
            shape,
            &std::iter::once(border).chain(sclera).collect::<Vec<_>>(),
        ),
    ]
}

fn ring_mesh(shape: &GlobeShape, rings: &[f32]) -> Mesh {
    let mut positions = Vec::with_capacity(rings.len() * (SECTORS as usize + 1));
    let mut normals = Vec::with_capacity(positions.capacity());
    for &angle in rings {
        for sector in 0..=SECTORS {
            let turn = sector as f32 / SECTORS as f32 * std::f32::consts::TAU;
            let direction = Vec3::new(
                angle.sin() * turn.cos(),
                angle.sin() * turn.sin(),
                -angle.cos(),
            );
            let radius = shape.radius_along(direction.as_dvec3()) as f32;
            positions.push((direction * radius).to_array());
            // Exact normals, so that the two meshes agree along their border.
            normals.push(
                shape
                    .normal_along(direction.as_dvec3())
                    .as_vec3()
                    .to_array(),
            );
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
