//! Skins and morphs at rest (glTF 2.0, 3.7.2.2 and 3.7.3.3).

use super::super::model::SceneError;
use super::{Source, accessors};
use glam::Mat4;
use gltf::{Primitive, Semantic};
use std::collections::HashMap;

/// How a mesh stands: at rest.
pub(super) struct Pose<'a> {
    /// Its node's place.
    pub world: Mat4,
    /// The matrix of each joint of its skin, from the mesh to the world; its node's place then does
    /// not matter (glTF 2.0, 3.7.3.3).
    pub joints: Option<&'a [Mat4]>,
    /// Weights of its morph targets.
    pub weights: &'a [f32],
}

pub(super) fn joint_matrices(
    skin: &gltf::Skin,
    places: &HashMap<usize, Mat4>,
    source: &Source,
) -> Result<Vec<Mat4>, SceneError> {
    let inverse = skin
        .inverse_bind_matrices()
        .map(|accessor| accessors::read::<16>(source, &accessor, "inverse bind matrices", false))
        .transpose()?;
    let matrix = |(at, joint): (usize, gltf::Node)| {
        let world = places
            .get(&joint.index())
            .copied()
            .unwrap_or(Mat4::IDENTITY);
        let bind = inverse.as_ref().and_then(|all| all.get(at));
        world * bind.map_or(Mat4::IDENTITY, Mat4::from_cols_array)
    };
    Ok(skin.joints().enumerate().map(matrix).collect())
}

/// Moves positions and normals from the mesh to the world by the joints that hold each vertex.
pub(super) fn skin_vertices(
    primitive: &Primitive,
    joints: &[Mat4],
    source: &Source,
    positions: &mut [[f32; 3]],
    normals: Option<&mut Vec<[f32; 3]>>,
) -> Result<bool, SceneError> {
    let mut matrices = vec![Mat4::ZERO; positions.len()];
    let mut sums = vec![0.0_f32; positions.len()];
    let mut skinned = false;
    // Four joints a set; exporters write as many sets as they need.
    for set in 0.. {
        let (Some(held), Some(weights)) = (
            primitive.get(&Semantic::Joints(set)),
            primitive.get(&Semantic::Weights(set)),
        ) else {
            break;
        };
        skinned = true;
        let held = accessors::read::<4>(source, &held, "joints", false)?;
        let weights = accessors::read::<4>(source, &weights, "weights", true)?;
        if held.len() != positions.len() || weights.len() != positions.len() {
            return Err(
                source.malformed("a mesh has other numbers of joints and weights than of vertices")
            );
        }
        for (vertex, (held, weights)) in held.iter().zip(&weights).enumerate() {
            for (&joint, &weight) in held.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
                let Some(&matrix) = joints.get(joint as usize) else {
                    return Err(source.malformed(format!(
                        "vertex {vertex} of a mesh is held by joint {joint}, of which there are {}",
                        joints.len()
                    )));
                };
                matrices[vertex] += matrix * weight;
                sums[vertex] += weight;
            }
        }
    }
    if !skinned {
        return Ok(false);
    }
    for (matrix, sum) in matrices.iter_mut().zip(sums) {
        *matrix *= if sum > 0.0 { 1.0 / sum } else { 0.0 };
    }
    for (position, matrix) in positions.iter_mut().zip(&matrices) {
        *position = matrix.transform_point3((*position).into()).into();
    }
    for (normal, matrix) in normals.into_iter().flatten().zip(&matrices) {
        let turned = matrix.transform_vector3((*normal).into());
        *normal = turned.normalize_or_zero().into();
    }
    Ok(true)
}

/// Adds the weighted displacements of a primitive's morph targets.
pub(super) fn morph_vertices(
    primitive: &Primitive,
    weights: &[f32],
    source: &Source,
    positions: &mut [[f32; 3]],
    mut normals: Option<&mut Vec<[f32; 3]>>,
) -> Result<(), SceneError> {
    let add = |to: &mut [[f32; 3]], by: Vec<[f32; 3]>, weight: f32| {
        for (to, by) in to.iter_mut().zip(by) {
            *to = std::array::from_fn(|k| to[k] + weight * by[k]);
        }
    };
    for (target, &weight) in primitive.morph_targets().zip(weights) {
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        if let Some(accessor) = target.positions() {
            let by = accessors::read::<3>(source, &accessor, "morph target", false)?;
            add(positions, by, weight);
        }
        if let (Some(normals), Some(accessor)) = (normals.as_deref_mut(), target.normals()) {
            let by = accessors::read::<3>(source, &accessor, "morph target's normals", false)?;
            add(normals, by, weight);
        }
    }
    Ok(())
}
