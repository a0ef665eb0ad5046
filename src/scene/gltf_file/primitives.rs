//! One primitive of a mesh: its triangles, where they are, and their normals (glTF 2.0, 3.7.2).

use super::super::model::{SceneError, SceneMesh, SceneModel};
use super::coordinates::{Layout, UvMap};
use super::pose::{Pose, morph_vertices, skin_vertices};
use super::{Source, accessors};
use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::Dimensions;
use gltf::mesh::Mode;
use gltf::{Accessor, Primitive, Semantic};

/// A mesh, and which of the file's vertices each of its is where that is not the same.
pub(super) type Ordered = (SceneMesh, Option<Vec<u32>>);

/// One primitive as a world-space mesh; `None` for points and lines.
pub(super) fn read_primitive(
    primitive: &Primitive,
    name: &str,
    pose: &Pose,
    source: &Source,
    scene: &SceneModel,
) -> Result<Option<Ordered>, SceneError> {
    if !matches!(
        primitive.mode(),
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
    ) {
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        return Err(source.content(format!("mesh \"{name}\" has no positions")));
    };
    let mut positions = accessors::read::<3>(source, &positions, "positions", false)?;
    let material = primitive
        .material()
        .index()
        .unwrap_or(scene.materials.len() - 1);
    let layout = Layout::of(&primitive.material());
    let order: Vec<u32> = match primitive.indices() {
        Some(accessor) => accessors::read_indices(source, &accessor)?,
        None => (0..positions.len() as u32).collect(),
    };
    let mut normals = primitive
        .get(&Semantic::Normals)
        .map(|accessor| accessors::read::<3>(source, &accessor, "normals", true))
        .transpose()?;
    let coordinates = |map: UvMap| -> Result<Option<Vec<[f32; 2]>>, SceneError> {
        let Some(accessor) = primitive.get(&Semantic::TexCoords(map.set)) else {
            return Ok(None);
        };
        let mut uvs =
            accessors::read::<2>(source, &accessor, "texture coordinates", !source.quantised)?;
        map.apply(&mut uvs);
        Ok(Some(uvs))
    };
    let uvs = coordinates(layout.first)?;
    let second_uvs = match layout.second {
        Some(map) => coordinates(map)?.or_else(|| Some(vec![[0.0; 2]; positions.len()])),
        None => None,
    };
    let colors = primitive
        .get(&Semantic::Colors(0))
        .map(|accessor| read_colors(source, &accessor))
        .transpose()?;
    morph_vertices(
        primitive,
        pose.weights,
        source,
        &mut positions,
        normals.as_mut(),
    )?;
    let skinned = match pose.joints {
        Some(joints) => skin_vertices(primitive, joints, source, &mut positions, normals.as_mut())?,
        None => false,
    };
    let world = if skinned { Mat4::IDENTITY } else { pose.world };
    let textured = scene.materials[material].textures().next().is_some();
    let mut mesh = SceneMesh {
        name: name.into(),
        uvs: uvs.or_else(|| textured.then(|| vec![[0.0; 2]; positions.len()])),
        second_uvs,
        colors,
        normals: vec![[0.0, 1.0, 0.0]; positions.len()],
        indices: triangles(primitive.mode(), &order),
        positions,
        material,
    };
    if let Some(fault) = mesh.fault(scene.materials.len()) {
        return Err(source.content(fault));
    }
    // The node's own place says which side is outside, also of what joints hold (glTF 2.0, 3.7.4).
    let order = place(&mut mesh, normals, world, handedness(pose.world));
    match mesh.fault(scene.materials.len()) {
        Some(fault) => Err(source.content(fault)),
        None => Ok(Some((mesh, order))),
    }
}

fn read_colors(source: &Source, accessor: &Accessor) -> Result<Vec<[f32; 4]>, SceneError> {
    if accessor.dimensions() == Dimensions::Vec3 {
        let rgb = accessors::read::<3>(source, accessor, "colours", true)?;
        return Ok(rgb.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect());
    }
    accessors::read::<4>(source, accessor, "colours", true)
}

/// Strips and fans as separate triangles; a trailing incomplete one is dropped.
fn triangles(mode: Mode, order: &[u32]) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| {
                if i % 2 == 0 {
                    [t[0], t[1], t[2]]
                } else {
                    [t[1], t[0], t[2]]
                }
            };
            order.windows(3).enumerate().flat_map(turned).collect()
        }
        Mode::TriangleFan => order
            .windows(2)
            .skip(1)
            .flat_map(|edge| [order[0], edge[0], edge[1]])
            .collect(),
        _ => order[..order.len() - order.len() % 3].to_vec(),
    }
}

/// −1 of a place that mirrors, else 1.
fn handedness(place: Mat4) -> f32 {
    if Mat3::from_mat4(place).determinant() < 0.0 {
        -1.0
    } else {
        1.0
    }
}

/// Moves a mesh into the world and gives it unit normals: the file's, or flat ones, for which each triangle
/// has vertices of its own; then returns which each was. Triangles go round the other way where `winding`
/// is −1.
fn place(
    mesh: &mut SceneMesh,
    normals: Option<Vec<[f32; 3]>>,
    world: Mat4,
    winding: f32,
) -> Option<Vec<u32>> {
    for position in &mut mesh.positions {
        *position = world.transform_point3((*position).into()).into();
    }
    let linear = Mat3::from_mat4(world);
    let side = handedness(world);
    let normals = normals.filter(|n| n.len() == mesh.positions.len());
    let order = normals.is_none().then(|| flatten(mesh));
    // The cofactor matrix is the inverse transpose up to scale, and exists for flat scales too.
    let cofactor = Mat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    );
    let moved = normals.into_iter().flatten().map(|n| {
        let n = (cofactor * Vec3::from(n) * side).normalize_or_zero();
        n.into()
    });
    mesh.normals = moved.collect();
    mesh.normals.resize(mesh.positions.len(), [0.0; 3]);
    // Where the file has none, or zeros, or what is no number, they are their triangle's own.
    for t in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.positions[t[k] as usize]));
        let own = (winding * (b - a).cross(c - a)).normalize_or(Vec3::Y);
        for &i in t {
            if mesh.normals[i as usize] == [0.0; 3] {
                mesh.normals[i as usize] = own.into();
            }
        }
    }
    let unused = |n: &mut [f32; 3]| *n = if *n == [0.0; 3] { [0.0, 1.0, 0.0] } else { *n };
    mesh.normals.iter_mut().for_each(unused);
    if winding < 0.0 {
        mesh.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    }
    order
}

/// Gives each triangle vertices of its own; returns which each was.
fn flatten(mesh: &mut SceneMesh) -> Vec<u32> {
    fn pick<const N: usize>(all: &[[f32; N]], order: &[u32]) -> Vec<[f32; N]> {
        order.iter().map(|&i| all[i as usize]).collect()
    }
    let order = std::mem::take(&mut mesh.indices);
    mesh.positions = pick(&mesh.positions, &order);
    mesh.uvs = mesh.uvs.as_ref().map(|uvs| pick(uvs, &order));
    mesh.second_uvs = mesh.second_uvs.as_ref().map(|uvs| pick(uvs, &order));
    mesh.colors = mesh.colors.as_ref().map(|colors| pick(colors, &order));
    mesh.indices = (0..order.len() as u32).collect();
    order
}
