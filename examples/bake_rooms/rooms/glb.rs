//! A [`SceneModel`] as a binary glTF 2.0 file.
//!
//! Enters: a scene whose meshes have positions, normals, texture coordinates and colours. Leaves: the
//! bytes of a file that `scene::gltf_file` reads. Vertices are quantised (`KHR_mesh_quantization`):
//! positions to 1/65535 of their mesh's extent, normals to 1/2048, colours to 1/4096; coarser ones would
//! show by a code here and there. Texture coordinates stay `f32`. Of a picture that lies on a ground
//! (`scene::room::grounds`) only the texels that differ from it are stored, as the colour of an ink and
//! how much of it there is.

use super::prints::inks_of;
use glam::{Mat4, Vec3};
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use ocularium::scene::gltf_file::EMISSION_CD_M2;
use ocularium::scene::model::{
    Alpha, SceneLight, SceneMaterial, SceneMesh, SceneModel, SceneTexture, Wrap,
};
use ocularium::scene::paint::hex;
use ocularium::scene::room::grounds::ground;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::error::Error;
use std::f32::consts::PI;

const SHORT: u32 = 5122;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const FLOAT: u32 = 5126;

/// Parts of the binary chunk, each a buffer view.
#[derive(Clone, Copy)]
enum Part {
    Positions,
    Normals,
    Coordinates,
    Colors,
    Indices,
}

/// Bytes from one vertex to the next in the first four of [`Part`].
const STRIDES: [usize; 4] = [8; 4];

#[derive(Default)]
struct File {
    parts: [Vec<u8>; 5],
    accessors: Vec<Value>,
    pictures: Vec<Vec<u8>>,
}

/// The file's bytes.
pub fn write(scene: &SceneModel) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut file = File::default();
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let (json, node) = file.mesh(scene, mesh, meshes.len())?;
        meshes.push(json);
        nodes.push(node);
    }
    for (index, texture) in scene.textures.iter().enumerate() {
        let of = |material: &&SceneMaterial| material.base_color_texture == Some(index);
        let material = scene.materials.iter().find(of);
        let below = material.and_then(|material| ground(&material.name));
        let inks = material.map_or(&[][..], |material| inks_of(&material.name));
        file.pictures.push(match below {
            Some(below) => png_of(&ink(texture, &below.texture(false), inks))?,
            None if material.is_some_and(|material| material.name == "painting") => {
                jpeg_of(texture)?
            }
            None => png_of(texture)?,
        });
    }
    let mut lights = Vec::new();
    let mut ambient = Value::Null;
    for light in &scene.lights {
        match light_json(light) {
            (json, None) => ambient = json,
            (json, Some(place)) => {
                nodes.push(json!({
                    "matrix": place.to_cols_array().map(short),
                    "extensions": { "KHR_lights_punctual": { "light": lights.len() } },
                }));
                lights.push(json);
            }
        }
    }
    let eye = &scene.eye;
    let (forward, up) = (Vec3::from(eye.forward), Vec3::from(eye.up));
    let place = Mat4::from_cols(
        forward.cross(up).extend(0.0),
        up.extend(0.0),
        (-forward).extend(0.0),
        Vec3::from(eye.position_m).extend(1.0),
    );
    let [width, height] = [eye.horizontal_fov_deg, eye.vertical_fov_deg]
        .map(|angle| (0.5 * angle.to_radians()).tan());
    nodes.push(
        json!({ "name": "right eye", "matrix": place.to_cols_array().map(short), "camera": 0 }),
    );
    let (views, binary) = file.binary();
    let first_picture = file.parts.len();
    let root = json!({
        "asset": { "version": "2.0", "generator": "cargo run --release --example bake_rooms" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "extensions": { "KHR_lights_punctual": { "lights": lights } },
        "scene": 0,
        "scenes": [{
            "name": scene.name,
            "nodes": (0..nodes.len()).collect::<Vec<_>>(),
            "extras": { "ocularium": {
                "ambient": ambient,
                "background_cd_m2": scene.background.map(short),
                "mean_luminance_cd_m2": scene.mean_luminance_cd_m2,
            } },
        }],
        "nodes": nodes,
        "cameras": [{
            "type": "perspective",
            "perspective": {
                "yfov": short(eye.vertical_fov_deg.to_radians()),
                "aspectRatio": short(width / height),
                "znear": 0.02,
            },
        }],
        "meshes": meshes,
        "materials": scene.materials.iter().map(material_json).collect::<Vec<_>>(),
        "textures": scene.textures.iter().enumerate().map(|(index, texture)| json!({
            "source": index,
            "sampler": usize::from(texture.wrap[0] == Wrap::Repeat),
        })).collect::<Vec<_>>(),
        "samplers": [{ "wrapS": 33071, "wrapT": 33071 }, { "wrapS": 10497, "wrapT": 10497 }],
        "images": file.pictures.iter().enumerate().map(|(index, picture)| json!({
            "mimeType": if picture.starts_with(b"\x89PNG") { "image/png" } else { "image/jpeg" },
            "bufferView": first_picture + index,
        })).collect::<Vec<_>>(),
        "accessors": file.accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
    });
    Ok(container(serde_json::to_vec(&root)?, binary))
}

impl File {
    /// A mesh and its node.
    fn mesh(
        &mut self,
        scene: &SceneModel,
        mesh: &SceneMesh,
        index: usize,
    ) -> Result<(Value, Value), Box<dyn Error>> {
        let (low, high) = SceneModel {
            meshes: vec![mesh.clone()],
            ..SceneModel::default()
        }
        .bounds()
        .ok_or("a mesh is empty")?;
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        let step = grid_step(low, high);
        let place = |p: &[f32; 3]| ((Vec3::from(*p) - low) / step).round();
        let places: Vec<Vec3> = mesh.positions.iter().map(place).collect();
        let most = places.iter().fold(Vec3::ZERO, |most, p| most.max(*p));
        let mut attributes = Map::new();
        let count = places.len();
        let corners: Vec<u8> = places
            .iter()
            .flat_map(|p| p.to_array().map(|c| c as u16))
            .flat_map(u16::to_le_bytes)
            .collect();
        let accessor = self.accessor(Part::Positions, UNSIGNED_SHORT, 3, count, &corners);
        self.accessors[accessor]["min"] = json!([0, 0, 0]);
        self.accessors[accessor]["max"] = json!(most.to_array().map(|c| c as u16));
        attributes.insert("POSITION".into(), accessor.into());
        let normals = mesh.normals.iter().flatten();
        let code = |c: &f32| (16.0 * (c * 32767.0 / 16.0).round()).min(32767.0) as i16;
        let normals: Vec<u8> = normals.flat_map(|c| code(c).to_le_bytes()).collect();
        let accessor = self.accessor(Part::Normals, SHORT, 3, count, &normals);
        attributes.insert("NORMAL".into(), accessor.into());
        let textured = scene.materials[mesh.material].textures().next().is_some();
        if let Some(uvs) = mesh.uvs.as_ref().filter(|_| textured) {
            let bytes: Vec<u8> = uvs.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
            let accessor = self.accessor(Part::Coordinates, FLOAT, 2, count, &bytes);
            attributes.insert("TEXCOORD_0".into(), accessor.into());
        }
        let colors = mesh.colors.as_ref();
        if let Some(colors) = colors.filter(|all| all.iter().any(|c| *c != [1.0; 4])) {
            let channels = || colors.iter().flat_map(|c| &c[..3]);
            if channels().any(|c| *c > 1.0) {
                return Err(format!("mesh \"{}\" has a colour above 1", mesh.name).into());
            }
            let code = |c: &f32| (16.0 * (c * 65535.0 / 16.0).round()).min(65535.0) as u16;
            let bytes: Vec<u8> = channels().flat_map(|c| code(c).to_le_bytes()).collect();
            let accessor = self.accessor(Part::Colors, UNSIGNED_SHORT, 3, count, &bytes);
            attributes.insert("COLOR_0".into(), accessor.into());
        }
        let indices: Vec<u16> = mesh
            .indices
            .iter()
            .map(|&i| u16::try_from(i))
            .collect::<Result<_, _>>()?;
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(Part::Indices, UNSIGNED_SHORT, 1, indices.len(), &bytes);
        let json = json!({
            "name": mesh.name,
            "primitives": [{ "attributes": attributes, "indices": indices, "material": mesh.material }],
        });
        let node = json!({
            "mesh": index,
            "translation": low.to_array().map(short),
            "scale": Vec3::splat(step).to_array().map(short),
        });
        Ok((json, node))
    }

    /// Appends `count` elements to a part; returns the accessor's index.
    fn accessor(
        &mut self,
        part: Part,
        component: u32,
        width: usize,
        count: usize,
        elements: &[u8],
    ) -> usize {
        let bytes = &mut self.parts[part as usize];
        let mut accessor = json!({
            "bufferView": part as usize,
            "byteOffset": bytes.len(),
            "componentType": component,
            "count": count,
            "type": if width == 1 { "SCALAR".into() } else { format!("VEC{width}") },
        });
        if matches!(part, Part::Normals | Part::Colors) {
            accessor["normalized"] = true.into();
        }
        let size = elements.len() / count.max(1);
        let stride = STRIDES.get(part as usize).copied().unwrap_or(size);
        for element in elements.chunks_exact(size.max(1)) {
            bytes.extend_from_slice(element);
            bytes.resize(bytes.len() + stride - size, 0);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// All buffer views and the bytes that they show.
    fn binary(&self) -> (Vec<Value>, Vec<u8>) {
        let (mut views, mut binary) = (Vec::new(), Vec::new());
        for (index, part) in self.parts.iter().chain(&self.pictures).enumerate() {
            let mut view =
                json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": part.len().max(1) });
            if let Some(stride) = STRIDES.get(index) {
                view["byteStride"] = (*stride).into();
            }
            views.push(view);
            binary.extend_from_slice(part);
            // An empty part still has a byte to show.
            binary.resize(
                (binary.len() + usize::from(part.is_empty())).next_multiple_of(4),
                0,
            );
        }
        (views, binary)
    }
}

/// The grid of the positions of a mesh between two corners, m.
pub fn grid_step(low: Vec3, high: Vec3) -> f32 {
    (high - low).max_element() / 65535.0
}

/// A number with as few digits as tell it apart from its neighbours.
pub fn short(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// What a factor must be for `times(factor)` to be `wanted` to the last bit, if there is one.
fn solve(wanted: f32, guess: f32, times: impl Fn(f32) -> f32) -> f32 {
    [guess, guess.next_up(), guess.next_down()]
        .into_iter()
        .find(|&factor| times(factor) == wanted)
        .unwrap_or(guess)
}

/// A light and its place; ambient light has none.
fn light_json(light: &SceneLight) -> (Value, Option<Mat4>) {
    match *light {
        SceneLight::Ambient { color, brightness } => {
            let color = color.map(short);
            (
                json!({ "color": color, "brightness_cd_m2": short(brightness) }),
                None,
            )
        }
        SceneLight::Directional {
            direction,
            color,
            illuminance_lux,
            shadows,
        } => {
            let back = -Vec3::from(direction);
            let (right, up) = back.any_orthonormal_pair();
            let place = Mat4::from_cols(
                right.extend(0.0),
                up.extend(0.0),
                back.extend(0.0),
                Vec3::ZERO.extend(1.0),
            );
            let json = json!({
                "type": "directional",
                "color": color.map(short),
                "intensity": short(illuminance_lux),
                "extras": { "ocularium": { "shadows": shadows } },
            });
            (json, Some(place))
        }
        SceneLight::Point {
            position,
            color,
            intensity_lm,
            range,
            shadows,
        } => {
            let candela = solve(intensity_lm, intensity_lm / (4.0 * PI), |cd| cd * 4.0 * PI);
            let json = json!({
                "type": "point",
                "color": color.map(short),
                "intensity": short(candela),
                "range": short(range),
                "extras": { "ocularium": { "shadows": shadows } },
            });
            (json, Some(Mat4::from_translation(position.into())))
        }
    }
}

fn material_json(material: &SceneMaterial) -> Value {
    let mut surface = json!({
        "baseColorFactor": material.base_color.map(short),
        "metallicFactor": short(material.metallic),
        "roughnessFactor": short(material.roughness),
    });
    if let Some(index) = material.base_color_texture {
        surface["baseColorTexture"] = json!({ "index": index });
    }
    let mut json = json!({ "name": material.name, "pbrMetallicRoughness": surface });
    let brightest = material.emissive.into_iter().fold(0.0, f32::max);
    if brightest > 0.0 {
        let strength = solve(brightest, brightest / EMISSION_CD_M2, |s| {
            s * EMISSION_CD_M2
        });
        json["emissiveFactor"] = json!(material.emissive.map(|e| short(e / brightest)));
        json["extensions"] =
            json!({ "KHR_materials_emissive_strength": { "emissiveStrength": short(strength) } });
    }
    if let Some(index) = material.emissive_texture {
        json["emissiveTexture"] = json!({ "index": index });
    }
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask(cut_off) => {
            json["alphaMode"] = "MASK".into();
            json["alphaCutoff"] = short(cut_off).into();
        }
        Alpha::Blend => json["alphaMode"] = "BLEND".into(),
    }
    if material.double_sided {
        json["doubleSided"] = true.into();
    }
    json
}

/// The texels of a picture that are not its ground's, the others transparent; a single transparent texel
/// of the mean colour where there are none.
fn ink(picture: &SceneTexture, ground: &SceneTexture, inks: &[u32]) -> SceneTexture {
    // As many shares of each ink as a palette has room for.
    let tries = [120.0, 80.0, 60.0, 45.0].map(|levels| ink_in(picture, ground, inks, levels));
    let few = |ink: &&SceneTexture| palette_of(ink).len() <= PALETTE;
    let ink = tries.iter().find(few).unwrap_or(&tries[0]).clone();
    if ink.rgba8.iter().any(|value| *value > 0) {
        return ink;
    }
    let texels = picture.rgba8.chunks_exact(4).filter(|texel| texel[3] > 0);
    let (sum, count) = texels.fold(([0u64; 3], 0), |(sum, count), texel| {
        ([0, 1, 2].map(|k| sum[k] + u64::from(texel[k])), count + 1)
    });
    let [r, g, b] = sum.map(|channel| (channel / count.max(1)) as u8);
    SceneTexture {
        width: 1,
        height: 1,
        rgba8: vec![r, g, b, 0],
        ..ink
    }
}

/// [`ink`] in `levels` shares of each ink; what is no mixture of an ink and the ground is opaque.
fn ink_in(
    picture: &SceneTexture,
    ground: &SceneTexture,
    inks: &[u32],
    levels: f32,
) -> SceneTexture {
    let inks: Vec<[f32; 3]> = inks
        .iter()
        .map(|&code| hex(code).map(|c| (c * 255.0).round()))
        .collect();
    let mut ink = picture.clone();
    let below = ground.rgba8.chunks_exact(4);
    for (texel, below) in ink.rgba8.chunks_exact_mut(4).zip(below) {
        if texel == below {
            texel.fill(0);
            continue;
        }
        let [there, under] =
            [&*texel, below].map(|t| Vec3::from([0, 1, 2].map(|k| f32::from(t[k]))));
        let fits = inks.iter().find_map(|&color| {
            let way = Vec3::from(color) - under;
            let share = (there - under).dot(way) / way.length_squared().max(1.0);
            let share = (share.clamp(0.0, 1.0) * levels).round() / levels;
            let off = (under + way * share - there).abs().max_element();
            (off <= 1.2 + 0.5 * way.length() / levels).then_some((color, share))
        });
        if let Some((color, share)) = fits {
            texel[..3].copy_from_slice(&color.map(|c| c as u8));
            texel[3] = (share * 255.0).round() as u8;
            if share == 0.0 {
                texel.fill(0);
            }
        }
    }
    ink
}

/// Colours of a PNG file's palette at most.
const PALETTE: usize = 256;

/// The colours of a picture, in order.
fn palette_of(picture: &SceneTexture) -> Vec<&[u8]> {
    let colors: BTreeSet<&[u8]> = picture.rgba8.chunks_exact(4).collect();
    colors.into_iter().collect()
}

/// A picture without an edge that matters.
fn jpeg_of(picture: &SceneTexture) -> Result<Vec<u8>, Box<dyn Error>> {
    let texels = picture.rgba8.chunks_exact(4);
    let rgb: Vec<u8> = texels.flat_map(|t| [t[0], t[1], t[2]]).collect();
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, 95).write_image(
        &rgb,
        picture.width,
        picture.height,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

/// The smaller of two PNG files: with the colours as they are, or by a palette where 256 are enough.
fn png_of(picture: &SceneTexture) -> Result<Vec<u8>, Box<dyn Error>> {
    let texels = || picture.rgba8.chunks_exact(4);
    let opaque = texels().all(|texel| texel[3] == 255);
    let (kind, bytes) = if opaque {
        (
            png::ColorType::Rgb,
            texels().flat_map(|t| [t[0], t[1], t[2]]).collect(),
        )
    } else {
        (png::ColorType::Rgba, picture.rgba8.clone())
    };
    let plain = encode(picture, kind, &bytes, None, png::Filter::Adaptive)?;
    let palette = palette_of(picture);
    if palette.len() > PALETTE {
        return Ok(plain);
    }
    let codes: Vec<u8> = texels()
        .map(|texel| palette.binary_search(&texel).map(|code| code as u8))
        .collect::<Result<_, _>>()
        .map_err(|_| "a colour is not in its palette")?;
    let indexed = encode(
        picture,
        png::ColorType::Indexed,
        &codes,
        Some(&palette),
        png::Filter::NoFilter,
    )?;
    Ok(if indexed.len() < plain.len() {
        indexed
    } else {
        plain
    })
}

fn encode(
    picture: &SceneTexture,
    kind: png::ColorType,
    bytes: &[u8],
    palette: Option<&[&[u8]]>,
    filter: png::Filter,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, picture.width, picture.height);
    encoder.set_color(kind);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_deflate_compression(png::DeflateCompression::Level(9));
    encoder.set_filter(filter);
    if let Some(palette) = palette {
        encoder.set_palette(
            palette
                .iter()
                .flat_map(|c| [c[0], c[1], c[2]])
                .collect::<Vec<u8>>(),
        );
        encoder.set_trns(palette.iter().map(|c| c[3]).collect::<Vec<u8>>());
    }
    encoder.write_header()?.write_image_data(bytes)?;
    Ok(file)
}

/// A GLB container (glTF 2.0, 4.4).
/// The parts of a binary glTF file, put together.
pub fn container(mut json: Vec<u8>, binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = b"glTF".to_vec();
    for word in [2, total as u32, json.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}
