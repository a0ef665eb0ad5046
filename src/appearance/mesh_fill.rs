//! Posed lids, hairs and margins into meshes and uniforms.

use super::brow::Brow;
use super::face_region::{EyeRegion, LidPose, PosedRegion};
use super::hair::{HairMesh, HairStrips};
use super::materials::{LID_HALF_SPAN_MM, LID_SAMPLES, LidMargins};
use crate::optics::globe::GlobeShape;
use bevy::asset::RenderAssetUsages;
use bevy::math::Vec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};

pub(super) fn empty_mesh() -> Mesh {
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0f32; 3]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0f32, 0.0, -1.0]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[0.0f32, 0.0, 0.0, 1.0]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0f32; 4]; 3])
    .with_inserted_indices(Indices::U32(vec![0, 1, 2]))
}
/// Puts a pose into a mesh; what does not move (`rest`, indices) only the first time. The region
/// is a right eye's; `mirror` = −1 makes it a left one's.
pub(super) fn fill_mesh(
    mesh: &mut Mesh,
    positions: impl ExactSizeIterator<Item = [f32; 3]>,
    normals: impl Iterator<Item = [f32; 3]>,
    tissue: Vec<[f32; 4]>,
    rest: impl FnOnce() -> Vec<[f32; 4]>,
    indices: &[u32],
    mirror: f32,
) {
    let first_time = mesh.count_vertices() != positions.len();
    let turned = |v: [f32; 3]| [mirror * v[0], v[1], v[2]];
    let positions: Vec<[f32; 3]> = positions.map(turned).collect();
    let normals: Vec<[f32; 3]> = normals.map(turned).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, tissue);
    if first_time {
        mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, rest());
        let mut indices = indices.to_vec();
        if mirror < 0.0 {
            // A mirror image winds the other way.
            for triangle in indices.chunks_exact_mut(3) {
                triangle.swap(1, 2);
            }
        }
        mesh.insert_indices(Indices::U32(indices));
    }
}
/// Puts posed hairs into a mesh: the normals hold each hair's chord, the weights each vertex' direction and place along the hair,
/// the resting place its half width.
pub(super) fn fill_hair(mesh: &mut Mesh, hair: &HairMesh, strips: &HairStrips, mirror: f32) {
    let along = hair.along.iter().zip(&strips.parameter);
    let along = along.map(|(d, place)| [mirror * d[0], d[1], d[2], *place]);
    let half_widths = strips.half_widths_mm.iter();
    let rest = || half_widths.map(|w| [*w, 0.0, 0.0, 1.0]).collect();
    fill_mesh(
        mesh,
        hair.positions.iter().copied(),
        hair.chords.iter().copied(),
        along.collect(),
        rest,
        &strips.indices,
        mirror,
    );
}
/// The brow rides on skin that hardly moves, so it is posed once for each level, with the lids open.
pub(super) fn fill_brow(
    mesh: &mut Mesh,
    brow: &Brow,
    level: usize,
    region: &EyeRegion,
    shape: &GlobeShape,
    mirror: f32,
) {
    let mut posed = PosedRegion::default();
    let radius = |direction: Vec3| shape.radius_along(direction.as_dvec3()) as f32;
    region.pose(&LidPose::default(), &radius, &mut posed);
    let mut hair = HairMesh::default();
    brow.pose(&posed, level, &mut hair);
    if !hair.positions.is_empty() {
        fill_hair(mesh, &hair, &brow.strips(level), mirror);
    }
}
/// Heights of the margins at fixed x, for the shader's lid shadow.
pub(super) fn lid_margins(upper: &[Vec3], lower: &[Vec3], mirror: f32) -> LidMargins {
    let sample = |margin: &[Vec3]| {
        core::array::from_fn(|i| {
            let across = i as f32 / (LID_SAMPLES - 1) as f32 * 2.0 - 1.0;
            height_at(margin, mirror * across * LID_HALF_SPAN_MM)
        })
    };
    LidMargins::new(sample(upper), sample(lower))
}
/// Height of a polyline at x, its ends extended flat; x may run either way.
pub(super) fn height_at(margin: &[Vec3], x: f32) -> f32 {
    let mut nearest = (f32::INFINITY, 0.0);
    for pair in margin.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let span = b.x - a.x;
        let s = if span.abs() > 1e-6 {
            ((x - a.x) / span).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let at = a.lerp(b, s);
        let off = (at.x - x).abs();
        if off < nearest.0 {
            nearest = (off, at.y);
        }
    }
    nearest.1
}
