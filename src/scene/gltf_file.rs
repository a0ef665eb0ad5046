//! Scenes from glTF 2.0 files (`.gltf`, `.glb`).
//!
//! Enters: a file or its bytes. Leaves: a [`SceneModel`] in world space. Taken from the file:
//! triangles, strips and fans of the default scene with their nodes' transforms, normals (flat
//! ones where there are none, as the specification demands), the first two texture uses a material
//! has, vertex colours, `KHR_lights_punctual`, the first camera as the right eye. Emission 1 in a
//! file is [`EMISSION_CD_M2`]. Points and lines, skins, morphs and animations are left out.
//!
//! Every accessor is checked against its buffer before it is read, so that no file can cause a
//! panic or a read beyond its data.

use super::model::{EyePlacement, SceneError, SceneLight, SceneMesh, SceneModel};
use super::photo::{one_clause, read_file};
use super::trace::Tracer;
use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, Primitive, Semantic, buffer, mesh::Mode};
use std::f32::consts::PI;
use std::path::Path;

mod surfaces;

/// Largest number of triangles that is accepted.
pub const MAX_TRIANGLES: usize = 20_000_000;
/// Luminance of an emissive factor of 1, cd/m²: that of white in the default lights.
pub const EMISSION_CD_M2: f32 = 150.0;

const MAX_NODES: usize = 1_000_000;
const MAX_NODE_DEPTH: usize = 256;

/// Loads a `.gltf` or `.glb` file and the buffers and images beside it.
pub fn load_gltf(path: &Path) -> Result<SceneModel, SceneError> {
    let bytes = read_file(path)?;
    load(
        &bytes,
        &path.display().to_string(),
        Some(path.parent().unwrap_or(Path::new("."))),
    )
}

/// Loads a self-contained file from memory, as in the browser.
pub fn load_gltf_bytes(bytes: &[u8], source_name: &str) -> Result<SceneModel, SceneError> {
    if bytes.is_empty() {
        return Err(SceneError::Empty {
            source_name: source_name.into(),
        });
    }
    load(bytes, source_name, None)
}

/// What the parts of the loader share.
struct Source<'a> {
    name: &'a str,
    base: Option<&'a Path>,
    buffers: Vec<buffer::Data>,
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

    /// Checks that an accessor has one of the given forms and lies inside its data.
    fn check(
        &self,
        accessor: &Accessor,
        what: &str,
        forms: &[(Dimensions, DataType)],
    ) -> Result<(), SceneError> {
        let fault = |reason: &str| {
            Err(self.malformed(format!("accessor {} ({what}) {reason}", accessor.index())))
        };
        if !forms.contains(&(accessor.dimensions(), accessor.data_type())) {
            return fault("has a type that is not allowed there");
        }
        if accessor.sparse().is_some() {
            return fault("is sparse, which is not supported");
        }
        let Some(view) = accessor.view() else {
            return fault("has no data");
        };
        if accessor.count() == 0 {
            return fault("has no elements");
        }
        let length = self.view(&view)?.len();
        let stride = view.stride().unwrap_or(accessor.size());
        let end = (accessor.count() - 1)
            .checked_mul(stride)
            .and_then(|n| n.checked_add(accessor.offset()))
            .and_then(|n| n.checked_add(accessor.size()));
        if stride < accessor.size() || end.is_none_or(|end| end > length) {
            return fault("reaches beyond its buffer view");
        }
        Ok(())
    }
}

fn malformed(name: &str, reason: impl Into<String>) -> SceneError {
    SceneError::Malformed {
        source_name: name.into(),
        kind: "glTF file",
        reason: reason.into(),
    }
}

fn load(bytes: &[u8], name: &str, base: Option<&Path>) -> Result<SceneModel, SceneError> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes)
        .map_err(|error| malformed(name, one_clause(&error)))?;
    let json = document.into_json();
    // The library's validation looks accessors up before it knows that they exist.
    let known = json.accessors.len();
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let named =
        primitives.flat_map(|primitive| primitive.attributes.values().chain(&primitive.indices));
    if let Some(missing) = named
        .map(|index| index.value())
        .find(|&index| index >= known)
    {
        return Err(malformed(
            name,
            format!("a mesh names accessor {missing}, of which there are {known}"),
        ));
    }
    let document =
        gltf::Document::from_json(json).map_err(|error| malformed(name, one_clause(&error)))?;
    let buffers = gltf::import_buffers(&document, base, blob)
        .map_err(|error| malformed(name, one_clause(&error)))?;
    let source = Source {
        name,
        base,
        buffers,
    };
    let (mut materials, textures) = surfaces::read(&document, &source)?;
    materials.push(super::model::SceneMaterial::default());
    let mut scene = SceneModel {
        name: name.into(),
        materials,
        textures,
        background: [120.0, 140.0, 165.0],
        ..Default::default()
    };
    let camera = walk(&document, &source, &mut scene)?;
    if scene.triangle_count() == 0 {
        return Err(source.content("it has no meshes with triangles"));
    }
    scene.eye = camera.unwrap_or_else(|| frame(&scene));
    if scene.lights.is_empty() {
        scene.lights = default_lights(&scene.eye);
    }
    scene.validate()?;
    scene.mean_luminance_cd_m2 = Tracer::new(&scene).mean_luminance_cd_m2(24);
    Ok(scene)
}

/// Adds every node's meshes and lights to the scene; returns the first camera.
fn walk(
    document: &Document,
    source: &Source,
    scene: &mut SceneModel,
) -> Result<Option<EyePlacement>, SceneError> {
    let root = document
        .default_scene()
        .or_else(|| document.scenes().next());
    // A file without a scene shows all the nodes that are nobody's children.
    let mut stack: Vec<_> = match root {
        Some(root) => root.nodes().map(|node| (node, Mat4::IDENTITY, 0)).collect(),
        None => {
            let children: Vec<usize> = document
                .nodes()
                .flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>())
                .collect();
            let roots = document.nodes().filter(|n| !children.contains(&n.index()));
            roots.map(|node| (node, Mat4::IDENTITY, 0)).collect()
        }
    };
    stack.reverse();
    let (mut camera, mut visited) = (None, 0);
    while let Some((node, parent, depth)) = stack.pop() {
        visited += 1;
        if depth > MAX_NODE_DEPTH || visited > MAX_NODES {
            return Err(source.malformed("its nodes form a loop or are nested too deeply"));
        }
        let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        if let Some(mesh) = node.mesh() {
            let name = mesh
                .name()
                .or(node.name())
                .map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
            for primitive in mesh.primitives() {
                if let Some(part) = read_primitive(&primitive, &name, world, source, scene)? {
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
            camera = Some(
                eye_of_camera(&lens, world)
                    .ok_or_else(|| source.content("its camera has no usable orientation"))?,
            );
        }
        scene
            .lights
            .extend(node.light().and_then(|light| read_light(&light, world)));
        let children: Vec<_> = node.children().collect();
        stack.extend(
            children
                .into_iter()
                .rev()
                .map(|child| (child, world, depth + 1)),
        );
    }
    Ok(camera)
}

/// One primitive as a world-space mesh; `None` for points and lines.
fn read_primitive(
    primitive: &Primitive,
    name: &str,
    world: Mat4,
    source: &Source,
    scene: &SceneModel,
) -> Result<Option<SceneMesh>, SceneError> {
    use DataType::{F32, U8, U16, U32};
    use Dimensions::{Scalar, Vec2, Vec3 as Three, Vec4};
    if !matches!(
        primitive.mode(),
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
    ) {
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        return Err(source.content(format!("mesh \"{name}\" has no positions")));
    };
    source.check(&positions, "positions", &[(Three, F32)])?;
    let material = primitive
        .material()
        .index()
        .unwrap_or(scene.materials.len() - 1);
    let uv_set = primitive
        .material()
        .pbr_metallic_roughness()
        .base_color_texture()
        .map_or(0, |t| t.tex_coord());
    let uv_forms = [(Vec2, F32), (Vec2, U8), (Vec2, U16)];
    let color_forms = [
        (Three, F32),
        (Three, U8),
        (Three, U16),
        (Vec4, F32),
        (Vec4, U8),
        (Vec4, U16),
    ];
    for (semantic, what, forms) in [
        (Semantic::Normals, "normals", &[(Three, F32)][..]),
        (
            Semantic::TexCoords(uv_set),
            "texture coordinates",
            &uv_forms,
        ),
        (Semantic::Colors(0), "colours", &color_forms),
    ] {
        if let Some(accessor) = primitive.get(&semantic) {
            source.check(&accessor, what, forms)?;
        }
    }
    if let Some(accessor) = primitive.indices() {
        source.check(
            &accessor,
            "indices",
            &[(Scalar, U8), (Scalar, U16), (Scalar, U32)],
        )?;
    }
    let reader = primitive.reader(|b| source.buffers.get(b.index()).map(|d| &d[..]));
    let positions: Vec<[f32; 3]> = reader.read_positions().into_iter().flatten().collect();
    let order: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..positions.len() as u32).collect(),
    };
    let normals: Option<Vec<[f32; 3]>> = reader.read_normals().map(Iterator::collect);
    let textured = scene.materials[material].textures().next().is_some();
    let uvs = reader
        .read_tex_coords(uv_set)
        .map(|t| t.into_f32().collect());
    let mut mesh = SceneMesh {
        name: name.into(),
        uvs: uvs.or_else(|| textured.then(|| vec![[0.0; 2]; positions.len()])),
        colors: reader.read_colors(0).map(|c| c.into_rgba_f32().collect()),
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
        // An eye has perspective; an orthographic camera only says where to stand.
        gltf::camera::Projection::Orthographic(_) => (0.7, 1.0),
    };
    let vertical = vertical.clamp(0.02, 2.6);
    let horizontal = 2.0 * ((0.5 * vertical).tan() * aspect.clamp(0.1, 10.0)).atan();
    position.is_finite().then(|| EyePlacement {
        position_m: position.into(),
        forward: forward.into(),
        up: up.into(),
        vertical_fov_deg: vertical.to_degrees(),
        horizontal_fov_deg: horizontal.to_degrees(),
    })
}

/// An eye in front of the scene (at +z), at the height of its middle, so far away that the nearer
/// side fills 70 % of the view.
fn frame(scene: &SceneModel) -> EyePlacement {
    let eye = EyePlacement::default();
    let Some((low, high)) = scene.bounds() else {
        return eye;
    };
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    let half = (high - low) / 2.0;
    let spread = half.x.max(half.y).max(0.1 * half.z).max(1e-3);
    let distance = spread / (0.7 * (0.5 * eye.vertical_fov_deg.to_radians()).tan());
    let centre = (low + high) / 2.0;
    let position = Vec3::new(centre.x, centre.y, high.z + distance);
    EyePlacement {
        position_m: position.into(),
        ..eye
    }
}

/// A key light over the viewer's left shoulder and light from everywhere; white is about
/// [`EMISSION_CD_M2`].
fn default_lights(eye: &EyePlacement) -> Vec<SceneLight> {
    let (forward, up) = (Vec3::from(eye.forward), Vec3::from(eye.up));
    let direction = forward + 0.6 * forward.cross(up) - 0.9 * up;
    vec![
        SceneLight::Directional {
            direction: direction.normalize().into(),
            color: [1.0, 0.97, 0.92],
            illuminance_lux: 400.0,
            shadows: true,
        },
        SceneLight::Ambient {
            color: [0.92, 0.96, 1.0],
            brightness: 60.0,
        },
    ]
}

/// A light of `KHR_lights_punctual`: candela for points, lux for the sun. A spot shines all
/// around, with the intensity of its axis.
fn read_light(light: &gltf::khr_lights_punctual::Light, world: Mat4) -> Option<SceneLight> {
    use gltf::khr_lights_punctual::Kind;
    let (color, intensity) = (light.color(), light.intensity());
    let is_usable =
        intensity.is_finite() && intensity >= 0.0 && color.iter().all(|c| c.is_finite());
    match light.kind() {
        _ if !is_usable => None,
        Kind::Directional => Some(SceneLight::Directional {
            direction: (-world.z_axis.truncate()).try_normalize()?.into(),
            color,
            illuminance_lux: intensity,
            shadows: true,
        }),
        Kind::Point | Kind::Spot { .. } => Some(SceneLight::Point {
            position: world.w_axis.truncate().into(),
            color,
            intensity_lm: intensity * 4.0 * PI,
            range: light
                .range()
                .filter(|r| r.is_finite() && *r > 0.0)
                .unwrap_or(100.0),
            shadows: false,
        }),
    }
}

#[cfg(test)]
mod tests;
