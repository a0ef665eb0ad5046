//! Scenes from glTF 2.0 files (`.gltf`, `.glb`).
//!
//! Enters: a file or its bytes. Leaves: a [`SceneModel`] in world space. Taken from the file:
//! triangles, strips and fans of the default scene with their nodes' transforms, skins and morphs, the first
//! animation of these, normals (flat ones where there are none, as the specification demands), textures by two sets of
//! coordinates a material, unlit materials, vertex colours, `KHR_lights_punctual`, the first perspective
//! camera as the right eye. Emission 1 in a file is [`EMISSION_CD_M2`]. Points and lines are left out.
//!
//! Every accessor is checked against its buffer before it is read, so that no file can cause a
//! panic or a read beyond its data.

use super::model::{EyePlacement, SceneError, SceneModel, UNLIT_WHITE_CD_M2};
use super::trace::Tracer;
use crate::input_file::one_clause;
use glam::{Mat4, Vec3};
use gltf::{Document, buffer};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

mod accessors;
mod beside;
mod blends;
mod coordinates;
mod course;
mod extras;
mod framing;
mod lights;
mod moving;
mod pose;
mod primitives;
mod refusals;
mod surfaces;

pub use beside::Beside;
use beside::read_buffers;
use coordinates::Layout;
use course::{Course, read_course};
use extras::Surroundings;
use framing::{eye_of_camera, frame, odd_angle, odd_size};
use lights::{default_lights, read_light};
use moving::{Gathered, Placed};
use pose::{Pose, joint_matrices};
use primitives::read_primitive;
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
    let (mut json, blob) = parse(bytes, name)?;
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
    let nodes = json.nodes.len();
    let moved = json
        .animations
        .iter()
        .flat_map(|animation| &animation.channels);
    if let Some(missing) = moved
        .map(|channel| channel.target.node.value())
        .find(|&node| node >= nodes)
    {
        return Err(malformed(
            name,
            format!("an animation moves node {missing}, of which there are {nodes}"),
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
    scene.remarks = left_out(&document, name);
    scene.remarks.extend(unread);
    scene.remarks.extend(damaged);
    let camera = walk(&document, &source, unit_m.unwrap_or(1.0), &mut scene)?;
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

/// A file's description, and the data beside it.
fn parse(bytes: &[u8], name: &str) -> Result<(gltf::json::Root, Option<Vec<u8>>), SceneError> {
    let error = match gltf::Gltf::from_slice_without_validation(bytes) {
        Ok(gltf::Gltf { document, blob }) => return Ok((document.into_json(), blob)),
        Err(error) => malformed(name, one_clause(&error)),
    };
    // A channel that names no node moves none (glTF 2.0, 3.11); the library demands one.
    let apart = gltf::Glb::from_slice(bytes);
    let (text, blob) = match &apart {
        Ok(glb) => (&*glb.json, glb.bin.as_ref().map(|bin| bin.to_vec())),
        Err(_) => (bytes, None),
    };
    let Ok(mut json) = serde_json::from_slice::<serde_json::Value>(text) else {
        return Err(error);
    };
    let animations = json
        .get_mut("animations")
        .and_then(|all| all.as_array_mut());
    for animation in animations.into_iter().flatten() {
        if let Some(channels) = animation
            .get_mut("channels")
            .and_then(|all| all.as_array_mut())
        {
            channels.retain(|channel| channel["target"]["node"].is_u64());
        }
    }
    let root = serde_json::from_value(json).map_err(|_| error)?;
    Ok((root, blob))
}

/// The scene that is shown.
fn root_of(document: &Document) -> Option<gltf::Scene<'_>> {
    document
        .default_scene()
        .or_else(|| document.scenes().next())
}

/// Every node of the scene, where it is at time 0; whoever carries comes before what it carries.
fn place_nodes<'a>(
    document: &'a Document,
    source: &Source,
    base: Mat4,
    course: &Course,
) -> Result<Vec<Placed<'a>>, SceneError> {
    // A file without a scene shows all the nodes that are nobody's children.
    let mut stack: Vec<_> = match root_of(document) {
        Some(root) => root.nodes().map(|node| (node, None, 0)).collect(),
        None => {
            let children: HashSet<usize> = document
                .nodes()
                .flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>())
                .collect();
            let roots = document.nodes().filter(|n| !children.contains(&n.index()));
            roots.map(|node| (node, None, 0)).collect()
        }
    };
    stack.reverse();
    let mut placed: Vec<Placed> = Vec::new();
    while let Some((node, parent, depth)) = stack.pop() {
        if depth > MAX_NODE_DEPTH || placed.len() >= MAX_NODES {
            return Err(source.malformed("its nodes form a loop or are nested too deeply"));
        }
        let carrier: Option<&Placed> = parent.map(|at: usize| &placed[at]);
        let at = placed.len();
        let children: Vec<_> = node.children().collect();
        stack.extend(
            children
                .into_iter()
                .rev()
                .map(|child| (child, Some(at), depth + 1)),
        );
        placed.push(Placed {
            world: carrier.map_or(base, |place| place.world) * course.place_of(&node),
            moves: course.moves(&node) || carrier.is_some_and(|place| place.moves),
            parent: carrier.map(|place| place.node.index()),
            node,
        });
    }
    Ok(placed)
}

/// Adds every node's meshes and lights to the scene; returns the first camera.
fn walk(
    document: &Document,
    source: &Source,
    unit_m: f32,
    scene: &mut SceneModel,
) -> Result<Option<EyePlacement>, SceneError> {
    let mut course = read_course(document, source);
    scene.remarks.append(&mut course.remarks);
    // All places first: a skin's joints may come after its mesh.
    let base = Mat4::from_scale(Vec3::splat(unit_m));
    let placed = place_nodes(document, source, base, &course)?;
    let places: HashMap<usize, Mat4> = placed
        .iter()
        .map(|place| (place.node.index(), place.world))
        .collect();
    let weights: Vec<Vec<f32>> = placed
        .iter()
        .map(|place| course.weights_of(&place.node))
        .collect();
    let mut moving = Gathered::new(&placed, course, unit_m, source)?;
    let mut camera = None;
    for (place, weights) in placed.iter().zip(&weights) {
        add_meshes(place, weights, &places, source, scene, &mut moving)?;
        if let (None, Some(lens)) = (&camera, place.node.camera()) {
            if matches!(lens.projection(), gltf::camera::Projection::Orthographic(_)) {
                scene.remarks.push(format!(
                    "\"{}\": its camera {} is orthographic, which no eye is, and was passed over.",
                    source.name,
                    lens.index()
                ));
            } else {
                scene.remarks.extend(odd_angle(&lens, source.name));
                camera = Some(
                    eye_of_camera(&lens, place.world)
                        .ok_or_else(|| source.content("its camera has no usable orientation"))?,
                );
                if place.moves {
                    scene.remarks.push(format!(
                        "\"{}\": its camera moves in the file; the eye stays where that is at the beginning.",
                        source.name
                    ));
                }
            }
        }
        if let Some(light) = place.node.light() {
            let own = extras::read(light.extras(), "light", source)?;
            if let Some(light) = read_light(&light, place.world, &own) {
                moving.add_light(place, scene.lights.len());
                scene.lights.push(light);
            }
        }
    }
    scene.remarks.append(&mut moving.remarks);
    scene.motion = moving.finish().map(Arc::new);
    Ok(camera)
}

/// Adds a node's meshes to the scene.
fn add_meshes(
    place: &Placed,
    weights: &[f32],
    places: &HashMap<usize, Mat4>,
    source: &Source,
    scene: &mut SceneModel,
    moving: &mut Gathered,
) -> Result<(), SceneError> {
    let Some(mesh) = place.node.mesh() else {
        return Ok(());
    };
    let joints = place
        .node
        .skin()
        .map(|skin| joint_matrices(&skin, places, source))
        .transpose()?;
    let name = mesh
        .name()
        .or(place.node.name())
        .map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
    for primitive in mesh.primitives() {
        let pose = Pose {
            world: place.world,
            joints: joints.as_deref(),
            weights,
        };
        if let Some((part, order)) = read_primitive(&primitive, &name, &pose, source, scene)? {
            let index = scene.meshes.len();
            moving.add_mesh(place, &primitive, (index, &part), order.as_deref(), source)?;
            scene.meshes.push(part);
        }
        if scene.triangle_count() > MAX_TRIANGLES {
            return Err(source.content(format!("it has more than {MAX_TRIANGLES} triangles")));
        }
    }
    Ok(())
}

/// What of a file is not shown as it is meant, one sentence each.
fn left_out(document: &Document, name: &str) -> Vec<String> {
    let mut remarks = Vec::new();
    let animations = document.animations().count();
    if animations > 1
        && let Some(played) = course::played(document)
    {
        let called = played
            .name()
            .map_or_else(String::new, |name| format!(" (\"{}\")", one_clause(&name)));
        remarks.push(format!(
            "\"{name}\": of its {animations} animations number {}{called} is played.",
            played.index() + 1
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
