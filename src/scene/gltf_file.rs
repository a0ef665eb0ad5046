//! Scenes from glTF 2.0 files (`.gltf`, `.glb`).
//!
//! Enters: a file or its bytes. Leaves: a [`SceneModel`] in world space. Taken from the file:
//! triangles, strips and fans of the default scene with their nodes' transforms, skins and morphs at
//! rest, normals (flat ones where there are none, as the specification demands), textures by two sets of
//! coordinates a material, unlit materials, vertex colours, `KHR_lights_punctual`, the first perspective
//! camera as the right eye. Emission 1 in a file is [`EMISSION_CD_M2`]. Points, lines and animations are
//! left out.
//!
//! Every accessor is checked against its buffer before it is read, so that no file can cause a
//! panic or a read beyond its data.

use super::model::{EyePlacement, SceneError, SceneMesh, SceneModel, UNLIT_WHITE_CD_M2};
use super::trace::Tracer;
use crate::input_file::one_clause;
use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::Dimensions;
use gltf::{Accessor, Document, Primitive, Semantic, buffer, mesh::Mode};
use std::collections::{HashMap, HashSet};

mod accessors;
mod beside;
mod blends;
mod coordinates;
mod extras;
mod framing;
mod lights;
mod pose;
mod refusals;
mod surfaces;

pub use beside::Beside;
use beside::read_buffers;
use coordinates::{Layout, UvMap};
use extras::Surroundings;
use framing::{frame, odd_size};
use lights::{default_lights, read_light};
use pose::{Pose, joint_matrices, morph_vertices, skin_vertices};
use refusals::{check_extensions, compression_used, unread};
use surfaces::Surfaces;

/// Largest number of triangles that is accepted.
pub const MAX_TRIANGLES: usize = 20_000_000;
/// Luminance of an emissive factor of 1, cd/m²: that of white in the default lights.
pub const EMISSION_CD_M2: f32 = UNLIT_WHITE_CD_M2;

/// Largest mean luminance of a view, cd/m²: that of the sun's disc, and the pupil's model ends there.
const BRIGHTEST_CD_M2: f64 = 1e9;
const MAX_NODES: usize = 1_000_000;
const MAX_NODE_DEPTH: usize = 256;

/// Loads a `.gltf` or `.glb` file from memory, and what it names from `beside`; `unit_m` metres are one
/// unit of the file (`None`: one, as the specification says, and a scene of odd size is remarked on).
pub fn load_gltf_among(
    bytes: &[u8],
    source_name: &str,
    beside: Beside,
    unit_m: Option<f32>,
) -> Result<SceneModel, SceneError> {
    // Some editors begin a file with this mark.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.is_empty() {
        return Err(SceneError::Empty {
            source_name: source_name.into(),
        });
    }
    load(bytes, source_name, beside, unit_m)
}

/// What the parts of the loader share.
struct Source<'a> {
    name: &'a str,
    beside: Beside<'a>,
    buffers: Vec<buffer::Data>,
    /// Accessors without data, whose elements are zeros.
    blank: HashSet<usize>,
    /// Whether whole numbers are shares of their range only where an accessor says so.
    quantised: bool,
}

impl Source<'_> {
    fn malformed(&self, reason: impl Into<String>) -> SceneError {
        malformed(self.name, reason)
    }

    fn content(&self, reason: impl Into<String>) -> SceneError {
        SceneError::Content {
            source_name: self.name.into(),
            reason: reason.into(),
        }
    }

    /// The bytes of a buffer view, if they lie inside their buffer.
    fn view(&self, view: &buffer::View) -> Result<&[u8], SceneError> {
        let data = self
            .buffers
            .get(view.buffer().index())
            .map_or(&[][..], |d| &d[..]);
        view.offset()
            .checked_add(view.length())
            .and_then(|end| data.get(view.offset()..end))
            .ok_or_else(|| {
                self.malformed(format!(
                    "buffer view {} reaches beyond its buffer",
                    view.index()
                ))
            })
    }
}

fn malformed(name: &str, reason: impl Into<String>) -> SceneError {
    SceneError::Malformed {
        source_name: name.into(),
        kind: "glTF file",
        reason: reason.into(),
    }
}

fn load(
    bytes: &[u8],
    name: &str,
    beside: Beside,
    unit_m: Option<f32>,
) -> Result<SceneModel, SceneError> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes)
        .map_err(|error| malformed(name, one_clause(&error)))?;
    let mut json = document.into_json();
    check_extensions(&json, name)?;
    let compression = compression_used(&json, name);
    let unread = unread(&json, name);
    let quantised = json
        .extensions_used
        .iter()
        .any(|name| name == "KHR_mesh_quantization");
    // Read here ([`accessors`]), though the library does not know it.
    json.extensions_required
        .retain(|name| name != "KHR_mesh_quantization");
    // The library's validation looks accessors up before it knows that they exist.
    let known = json.accessors.len();
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let named = primitives.flat_map(|primitive| {
        let targets = primitive.targets.iter().flatten();
        let targets = targets.flat_map(|to| [&to.positions, &to.normals, &to.tangents]);
        let own = primitive.attributes.values().chain(&primitive.indices);
        own.chain(targets.flatten())
    });
    if let Some(missing) = named
        .map(|index| index.value())
        .find(|&index| index >= known)
    {
        return Err(malformed(
            name,
            format!("a mesh names accessor {missing}, of which there are {known}"),
        ));
    }
    // An accessor without data is all zeros, which the library's validation does not know.
    let mut blank = HashSet::new();
    if !json.buffer_views.is_empty() {
        for (index, accessor) in json.accessors.iter_mut().enumerate() {
            if accessor.buffer_view.is_none() {
                accessor.buffer_view = Some(gltf::json::Index::new(0));
                accessor.byte_offset = None;
                blank.insert(index);
            }
        }
    }
    let document = gltf::Document::from_json(json)
        .map_err(|error| compression.unwrap_or_else(|| malformed(name, one_clause(&error))))?;
    let buffers = read_buffers(&document, blob, name, beside)?;
    let source = Source {
        name,
        beside,
        buffers,
        blank,
        quantised,
    };
    let Surfaces {
        mut materials,
        textures,
        remarks: damaged,
    } = surfaces::read(&document, &source)?;
    materials.push(super::model::SceneMaterial::default());
    let mut scene = SceneModel {
        name: name.into(),
        materials,
        textures,
        background: [120.0, 140.0, 165.0],
        ..Default::default()
    };
    let root = Mat4::from_scale(Vec3::splat(unit_m.unwrap_or(1.0)));
    scene.remarks = left_out(&document, name);
    scene.remarks.extend(unread);
    scene.remarks.extend(damaged);
    let camera = walk(&document, &source, root, &mut scene)?;
    if let Some(root) = root_of(&document) {
        let surroundings: Surroundings = extras::read(root.extras(), "scene", &source)?;
        surroundings.apply(&mut scene, &source)?;
    }
    if scene.triangle_count() == 0 {
        return Err(source.content("it has no meshes with triangles"));
    }
    scene.eye = camera.unwrap_or_else(|| frame(&scene));
    if scene.lights.is_empty() {
        scene.lights = default_lights(&scene.eye);
    }
    scene.validate()?;
    blends::settle(&mut scene);
    if unit_m.is_none() {
        scene.remarks.extend(odd_size(&scene));
    }
    if scene.mean_luminance_cd_m2 == 0.0 {
        scene.mean_luminance_cd_m2 = Tracer::new(&scene).mean_luminance_cd_m2(24);
    }
    let brightness = scene.mean_luminance_cd_m2;
    if !(0.0..=BRIGHTEST_CD_M2).contains(&brightness) {
        return Err(source.content(format!(
            "its lamps make it {brightness:.1e} cd/m² bright, but it may have at most {BRIGHTEST_CD_M2:.0e}, as the \
             sun's disc has: lamps are in candela and lux"
        )));
    }
    Ok(scene)
}

/// The scene that is shown.
fn root_of(document: &Document) -> Option<gltf::Scene<'_>> {
    document
        .default_scene()
        .or_else(|| document.scenes().next())
}

/// Adds every node's meshes and lights to the scene; returns the first camera.
fn walk(
    document: &Document,
    source: &Source,
    base: Mat4,
    scene: &mut SceneModel,
) -> Result<Option<EyePlacement>, SceneError> {
    // A file without a scene shows all the nodes that are nobody's children.
    let mut stack: Vec<_> = match root_of(document) {
        Some(root) => root.nodes().map(|node| (node, base, 0)).collect(),
        None => {
            let children: Vec<usize> = document
                .nodes()
                .flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>())
                .collect();
            let roots = document.nodes().filter(|n| !children.contains(&n.index()));
            roots.map(|node| (node, base, 0)).collect()
        }
    };
    stack.reverse();
    // All places first: a skin's joints may come after its mesh.
    let mut placed: Vec<(gltf::Node, Mat4)> = Vec::new();
    while let Some((node, parent, depth)) = stack.pop() {
        if depth > MAX_NODE_DEPTH || placed.len() >= MAX_NODES {
            return Err(source.malformed("its nodes form a loop or are nested too deeply"));
        }
        let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        let children: Vec<_> = node.children().collect();
        placed.push((node, world));
        stack.extend(
            children
                .into_iter()
                .rev()
                .map(|child| (child, world, depth + 1)),
        );
    }
    let places: HashMap<usize, Mat4> = placed
        .iter()
        .map(|(node, world)| (node.index(), *world))
        .collect();
    let mut camera = None;
    for (node, world) in placed {
        let joints = node
            .skin()
            .map(|skin| joint_matrices(&skin, &places, source))
            .transpose()?;
        if let Some(mesh) = node.mesh() {
            let name = mesh
                .name()
                .or(node.name())
                .map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
            for primitive in mesh.primitives() {
                let weights = node.weights().or(mesh.weights()).unwrap_or(&[]);
                let pose = Pose {
                    world,
                    joints: joints.as_deref(),
                    weights,
                };
                if let Some(part) = read_primitive(&primitive, &name, &pose, source, scene)? {
                    scene.meshes.push(part);
                }
                if scene.triangle_count() > MAX_TRIANGLES {
                    return Err(
                        source.content(format!("it has more than {MAX_TRIANGLES} triangles"))
                    );
                }
            }
        }
        if let (None, Some(lens)) = (&camera, node.camera()) {
            if matches!(lens.projection(), gltf::camera::Projection::Orthographic(_)) {
                scene.remarks.push(format!(
                    "\"{}\": its camera {} is orthographic, which no eye is, and was passed over.",
                    source.name,
                    lens.index()
                ));
            } else {
                scene.remarks.extend(odd_angle(&lens, source.name));
                camera = Some(
                    eye_of_camera(&lens, world)
                        .ok_or_else(|| source.content("its camera has no usable orientation"))?,
                );
            }
        }
        if let Some(light) = node.light() {
            let own = extras::read(light.extras(), "light", source)?;
            scene.lights.extend(read_light(&light, world, &own));
        }
    }
    Ok(camera)
}

/// One primitive as a world-space mesh; `None` for points and lines.
fn read_primitive(
    primitive: &Primitive,
    name: &str,
    pose: &Pose,
    source: &Source,
    scene: &SceneModel,
) -> Result<Option<SceneMesh>, SceneError> {
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
    place(&mut mesh, normals, world);
    match mesh.fault(scene.materials.len()) {
        Some(fault) => Err(source.content(fault)),
        None => Ok(Some(mesh)),
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

/// Moves a mesh into the world and gives it unit normals: the file's, or flat ones.
fn place(mesh: &mut SceneMesh, normals: Option<Vec<[f32; 3]>>, world: Mat4) {
    for position in &mut mesh.positions {
        *position = world.transform_point3((*position).into()).into();
    }
    let linear = Mat3::from_mat4(world);
    if linear.determinant() < 0.0 {
        mesh.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    }
    let face_normal = |mesh: &SceneMesh, t: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.positions[t[k] as usize]));
        (b - a).cross(c - a).normalize_or(Vec3::Y)
    };
    let Some(normals) = normals.filter(|n| n.len() == mesh.positions.len()) else {
        let order = std::mem::take(&mut mesh.indices);
        mesh.normals = order
            .chunks_exact(3)
            .flat_map(|t| [face_normal(mesh, t).into(); 3])
            .collect();
        mesh.positions = order.iter().map(|&i| mesh.positions[i as usize]).collect();
        let pick2 = |all: &Vec<[f32; 2]>| order.iter().map(|&i| all[i as usize]).collect();
        let pick4 = |all: &Vec<[f32; 4]>| order.iter().map(|&i| all[i as usize]).collect();
        mesh.uvs = mesh.uvs.as_ref().map(pick2);
        mesh.second_uvs = mesh.second_uvs.as_ref().map(pick2);
        mesh.colors = mesh.colors.as_ref().map(pick4);
        mesh.indices = (0..order.len() as u32).collect();
        return;
    };
    // The cofactor matrix is the inverse transpose up to scale, and exists for flat scales too.
    let cofactor = Mat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    );
    let side = linear.determinant().signum();
    let moved = normals
        .iter()
        .map(|&n| (cofactor * Vec3::from(n) * side).normalize_or_zero());
    mesh.normals = moved.map(Into::into).collect();
    // Zero or non-finite normals in the file give way to their triangle's own.
    for t in mesh.indices.chunks_exact(3) {
        for &i in t {
            if mesh.normals[i as usize] == [0.0; 3] {
                mesh.normals[i as usize] = face_normal(mesh, t).into();
            }
        }
    }
    let unused = |n: &mut [f32; 3]| *n = if *n == [0.0; 3] { [0.0, 1.0, 0.0] } else { *n };
    mesh.normals.iter_mut().for_each(unused);
}

fn eye_of_camera(camera: &gltf::Camera, world: Mat4) -> Option<EyePlacement> {
    let position = world.w_axis.truncate();
    let forward = (-world.z_axis.truncate()).try_normalize()?;
    let up = (world.y_axis.truncate() - forward * world.y_axis.truncate().dot(forward))
        .try_normalize()?;
    let (vertical, aspect) = match camera.projection() {
        gltf::camera::Projection::Perspective(p) => (p.yfov(), p.aspect_ratio().unwrap_or(1.0)),
        gltf::camera::Projection::Orthographic(_) => return None,
    };
    let vertical = vertical.clamp(CAMERA_RAD[0], CAMERA_RAD[1]);
    let horizontal = 2.0 * ((0.5 * vertical).tan() * aspect.clamp(0.1, 10.0)).atan();
    position.is_finite().then(|| EyePlacement {
        position_m: position.into(),
        forward: forward.into(),
        up: up.into(),
        vertical_fov_deg: vertical.to_degrees(),
        horizontal_fov_deg: horizontal.to_degrees(),
    })
}

/// Vertical angles of a camera that are shown, rad: 1° to 149°.
const CAMERA_RAD: [f32; 2] = [0.02, 2.6];

/// A remark on a camera whose angle is not one.
fn odd_angle(camera: &gltf::Camera, name: &str) -> Option<String> {
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
        return None;
    };
    let [least, most] = CAMERA_RAD;
    (!(least..=most).contains(&lens.yfov())).then(|| {
        format!(
            "\"{name}\": its camera {} has a vertical angle (yfov) of {}, and is shown with the nearest of {least} to \
             {most} rad.",
            camera.index(),
            lens.yfov()
        )
    })
}

/// What of a file is not shown as it is meant, one sentence each.
fn left_out(document: &Document, name: &str) -> Vec<String> {
    let mut remarks = Vec::new();
    if document.animations().next().is_some() {
        remarks.push(format!(
            "\"{name}\": its animations are not played; it rests."
        ));
    }
    let is_spot = |light: gltf::khr_lights_punctual::Light| {
        matches!(light.kind(), gltf::khr_lights_punctual::Kind::Spot { .. })
    };
    if document.lights().into_iter().flatten().any(is_spot) {
        remarks.push(format!(
            "\"{name}\": its spot lights shine all around, without their cones."
        ));
    }
    if let Some(material) = document.materials().find(|m| Layout::of(m).too_many) {
        remarks.push(format!(
            "\"{name}\": the textures of material \"{}\" lie in three or more ways; the third lies as the first.",
            one_clause(&material.name().unwrap_or("unnamed"))
        ));
    }
    remarks
}

#[cfg(test)]
mod tests;
