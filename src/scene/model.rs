//! A scene as plain data.
//!
//! Frame: world metres, y up, right-handed. Positions and normals are already in world space, so a
//! mesh needs no transform. Photometry is absolute: emission in cd/m², illuminance in lux, flux in
//! lumens; one white matt surface (albedo 1) under illuminance `E` has luminance `E / π`.

use super::motion::SceneMotion;
use crate::frame::mips::halved;
use crate::optics::output::{srgb_decode, srgb_encode};
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

/// Everything a renderer needs to show a scene from one eye.
#[derive(Debug, Clone, Default)]
pub struct SceneModel {
    /// Name for lists and reports.
    pub name: String,
    /// Triangle meshes in world space.
    pub meshes: Vec<SceneMesh>,
    /// Materials, indexed by [`SceneMesh::material`].
    pub materials: Vec<SceneMaterial>,
    /// Textures, indexed by the materials.
    pub textures: Vec<SceneTexture>,
    /// Light sources.
    pub lights: Vec<SceneLight>,
    /// Where the right eye is and where the head faces.
    pub eye: EyePlacement,
    /// Luminance where no surface is, linear sRGB in cd/m².
    pub background: [f32; 3],
    /// Mean luminance of the view from [`SceneModel::eye`], cd/m²; it drives the pupil.
    pub mean_luminance_cd_m2: f64,
    /// What moves by itself; all else of the scene is as it is at time 0.
    pub motion: Option<Arc<SceneMotion>>,
    /// What a user should know about how the file was read, one sentence each.
    pub remarks: Vec<String>,
}

/// Triangles that share one material.
#[derive(Debug, Clone, Default)]
pub struct SceneMesh {
    /// Name, unique enough to point a user at it.
    pub name: String,
    /// Vertex positions, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals, one per position.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v down as in glTF; present whenever the material has a texture.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The coordinates of those textures that lie otherwise ([`SceneMaterial::on_second_uvs`]).
    pub second_uvs: Option<Vec<[f32; 2]>>,
    /// Linear RGBA that multiplies the base colour; the built-in scenes carry baked ambient
    /// occlusion here.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Three indices a triangle, counter-clockwise from the front.
    pub indices: Vec<u32>,
    /// Index into [`SceneModel::materials`].
    pub material: usize,
}

/// How texels below full opacity are treated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Alpha {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Drawn where alpha is at least this cut-off, 0–1.
    Mask(f32),
    /// Blended over what is behind.
    Blend,
}

/// Luminance of an unlit white, cd/m²: of white paper in a room lit by the usual lights.
pub const UNLIT_WHITE_CD_M2: f32 = 150.0;

/// Which textures lie by [`SceneMesh::second_uvs`]; a base colour always lies by the first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OnSecondUvs {
    /// The emissive texture.
    pub emissive: bool,
    /// The texture of metallic and roughness.
    pub metallic_roughness: bool,
    /// The normal map.
    pub normal: bool,
}

/// A metallic-roughness surface.
#[derive(Debug, Clone)]
pub struct SceneMaterial {
    /// Name for messages.
    pub name: String,
    /// Linear RGBA, multiplies the texture.
    pub base_color: [f32; 4],
    /// 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// Perceptual roughness, 0–1.
    pub roughness: f32,
    /// Emitted luminance, linear sRGB in cd/m², multiplies the emissive texture.
    pub emissive: [f32; 3],
    /// Index of an sRGB texture.
    pub base_color_texture: Option<usize>,
    /// Index of an sRGB texture.
    pub emissive_texture: Option<usize>,
    /// Index of a linear texture (roughness in G, metallic in B).
    pub metallic_roughness_texture: Option<usize>,
    /// Index of a linear tangent-space normal map, y up as in glTF.
    pub normal_texture: Option<usize>,
    /// Which of the textures have coordinates of their own.
    pub on_second_uvs: OnSecondUvs,
    /// Shines by itself with its base colour, white being [`UNLIT_WHITE_CD_M2`], and in no other light.
    pub unlit: bool,
    /// Treatment of alpha.
    pub alpha: Alpha,
    /// Whether back faces are drawn too.
    pub double_sided: bool,
}

impl Default for SceneMaterial {
    fn default() -> Self {
        Self {
            name: "default".into(),
            base_color: [0.8, 0.8, 0.8, 1.0],
            metallic: 0.0,
            roughness: 0.8,
            emissive: [0.0; 3],
            base_color_texture: None,
            emissive_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            on_second_uvs: OnSecondUvs::default(),
            unlit: false,
            alpha: Alpha::Opaque,
            double_sided: false,
        }
    }
}

/// What lies beyond the edge of an image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The edge's own texels.
    #[default]
    Clamp,
    /// The image again.
    Repeat,
    /// The image again, every other time mirrored.
    Mirror,
}

/// An 8-bit image.
#[derive(Debug, Clone, Default)]
pub struct SceneTexture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major RGBA, top row first, `4 · width · height` bytes.
    pub rgba8: Vec<u8>,
    /// Whether the colour channels are sRGB-encoded (alpha never is).
    pub srgb: bool,
    /// What coordinates outside 0–1 show, along u and v.
    pub wrap: [Wrap; 2],
}

impl SceneTexture {
    /// The full mip chain after level 0, each `(width, height, rgba8)`, averaged in linear light so
    /// that distant text keeps its luminance.
    pub fn mip_levels(&self) -> Vec<(u32, u32, Vec<u8>)> {
        let is_code = |channel: usize| self.srgb && channel < 3;
        let mut size = (self.width as usize, self.height as usize);
        let light = |texel: &[u8]| -> [f32; 4] {
            std::array::from_fn(|channel| match is_code(channel) {
                true => srgb_to_linear(texel[channel]),
                false => f32::from(texel[channel]) / 255.0,
            })
        };
        let code = |texel: &[f32; 4]| -> [u8; 4] {
            std::array::from_fn(|channel| match is_code(channel) {
                true => linear_to_srgb(texel[channel]),
                false => (texel[channel] * 255.0).round() as u8,
            })
        };
        let mut levels = Vec::new();
        let mut texels: Vec<[f32; 4]> = Vec::new();
        while size != (1, 1) {
            (size, texels) = match levels.is_empty() {
                true => halved(size, |i| light(&self.rgba8[4 * i..])),
                false => halved(size, |i| texels[i]),
            };
            let codes = texels.iter().flat_map(code).collect();
            levels.push((size.0 as u32, size.1 as u32, codes));
        }
        levels
    }
}

/// A light source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SceneLight {
    /// Equal luminous intensity in all directions.
    Point {
        /// World position, m.
        position: [f32; 3],
        /// Linear colour, brightest channel 1.
        color: [f32; 3],
        /// Luminous flux, lm.
        intensity_lm: f32,
        /// Distance beyond which it may be ignored, m.
        range: f32,
        /// Whether it casts shadows.
        shadows: bool,
    },
    /// Parallel light, as from the sun.
    Directional {
        /// Unit direction in which the light travels.
        direction: [f32; 3],
        /// Linear colour, brightest channel 1.
        color: [f32; 3],
        /// Illuminance on a surface facing it, lx.
        illuminance_lux: f32,
        /// Whether it casts shadows.
        shadows: bool,
    },
    /// Light from everywhere.
    Ambient {
        /// Linear colour, brightest channel 1.
        color: [f32; 3],
        /// Luminance of a white matt unoccluded surface in this light alone, cd/m².
        brightness: f32,
    },
}

/// The right eye in the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyePlacement {
    /// Position of the right eye, m.
    pub position_m: [f32; 3],
    /// Unit direction in which the head faces.
    pub forward: [f32; 3],
    /// Unit direction to the top of the head, perpendicular to `forward`.
    pub up: [f32; 3],
    /// Vertical extent of the view for which the scene was composed, degrees.
    pub vertical_fov_deg: f32,
    /// Horizontal extent of that view, degrees.
    pub horizontal_fov_deg: f32,
}

impl Default for EyePlacement {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            forward: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov_deg: 50.0,
            horizontal_fov_deg: 50.0,
        }
    }
}

impl SceneModel {
    /// Number of triangles in all meshes.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.indices.len() / 3).sum()
    }

    /// Smallest and largest corner of all positions, m; `None` for a scene without vertices.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let mut positions = self.meshes.iter().flat_map(|mesh| &mesh.positions);
        let first = *positions.next()?;
        Some(positions.fold((first, first), |(low, high), p| {
            (
                std::array::from_fn(|i| low[i].min(p[i])),
                std::array::from_fn(|i| high[i].max(p[i])),
            )
        }))
    }

    /// Checks every invariant that a renderer relies on: finite positions, unit normals, one
    /// normal (and coordinate, and colour) a vertex, indices and references in range.
    pub fn validate(&self) -> Result<(), SceneError> {
        let content = |reason: String| SceneError::Content {
            source_name: self.name.clone(),
            reason,
        };
        if self.triangle_count() == 0 {
            return Err(content("it has no triangles".into()));
        }
        for mesh in &self.meshes {
            mesh.fault(self.materials.len())
                .map_or(Ok(()), |fault| Err(content(fault)))?;
            let material = &self.materials[mesh.material];
            if material.textures().next().is_some() && mesh.uvs.is_none() {
                let name = &mesh.name;
                return Err(content(format!(
                    "mesh \"{name}\" has a texture but no texture coordinates"
                )));
            }
        }
        for material in &self.materials {
            if let Some(index) = material.textures().find(|&i| i >= self.textures.len()) {
                let name = &material.name;
                return Err(content(format!(
                    "material \"{name}\" names texture {index}, of which there are {}",
                    self.textures.len()
                )));
            }
        }
        Ok(())
    }
}

impl SceneMaterial {
    /// The indices of all textures that the material uses.
    pub fn textures(&self) -> impl Iterator<Item = usize> {
        [
            self.base_color_texture,
            self.emissive_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
        ]
        .into_iter()
        .flatten()
    }
}

impl SceneMesh {
    /// What is wrong with this mesh, if anything, as the end of a sentence.
    pub fn fault(&self, material_count: usize) -> Option<String> {
        let (name, count) = (&self.name, self.positions.len());
        let is_finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
        if let Some(vertex) = self.positions.iter().position(|p| !is_finite(p)) {
            return Some(format!(
                "mesh \"{name}\" has a position that is not a finite number at vertex {vertex}"
            ));
        }
        if self.normals.len() != count
            || [&self.uvs, &self.second_uvs]
                .into_iter()
                .flatten()
                .any(|uvs| uvs.len() != count)
            || self.colors.as_ref().is_some_and(|c| c.len() != count)
        {
            return Some(format!(
                "mesh \"{name}\" has attributes of different lengths"
            ));
        }
        let length = |n: &[f32; 3]| n.iter().map(|c| c * c).sum::<f32>().sqrt();
        // A NaN length fails this comparison too.
        let unit = |n: &[f32; 3]| (length(n) - 1.0).abs() < 1e-3;
        if let Some(vertex) = self.normals.iter().position(|n| !unit(n)) {
            return Some(format!(
                "mesh \"{name}\" has a normal that is not of unit length at vertex {vertex}"
            ));
        }
        if let Some(index) = self.indices.iter().find(|&&i| i as usize >= count) {
            return Some(format!(
                "mesh \"{name}\" has the index {index}, but only {count} vertices"
            ));
        }
        if !self.indices.len().is_multiple_of(3) || self.material >= material_count {
            return Some(format!(
                "mesh \"{name}\" has an incomplete triangle or no material"
            ));
        }
        let coordinates = self.uvs.iter().chain(&self.second_uvs).flatten().flatten();
        let colors = self.colors.iter().flatten().flatten();
        if coordinates.chain(colors).any(|value| !value.is_finite()) {
            return Some(format!(
                "mesh \"{name}\" has a texture coordinate or colour that is not a finite number"
            ));
        }
        None
    }
}

/// Why a scene cannot be shown: one sentence that names the file and the fault.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum SceneError {
    /// There is no such file.
    #[error("The {kind} \"{}\" does not exist.", path.display())]
    Missing {
        /// `scene file`, `depth image`.
        kind: &'static str,
        /// The path as given.
        path: PathBuf,
    },
    /// The system refuses to read it.
    #[error("The {kind} \"{}\" cannot be read: {reason}.", path.display())]
    Unreadable {
        /// `scene file`, `depth image`.
        kind: &'static str,
        /// The path as given.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// It has zero bytes.
    #[error("\"{source_name}\" is empty.")]
    Empty {
        /// The path as given.
        source_name: String,
    },
    /// It is not what its kind demands, or it is cut short.
    #[error("\"{source_name}\" is not a usable {kind}: {reason}.")]
    Malformed {
        /// The path as given.
        source_name: String,
        /// `glTF file`, `PNG or JPEG image`.
        kind: &'static str,
        /// The fault.
        reason: String,
    },
    /// It is well-formed, but what it holds cannot be shown.
    #[error("The scene \"{source_name}\" cannot be shown: {reason}.")]
    Content {
        /// The path as given.
        source_name: String,
        /// The fault.
        reason: String,
    },
    /// Neither a built-in scene nor a file.
    #[error(
        "There is no scene \"{name}\"; the built-in ones are {known}, and a file can be given instead: a glTF model (.gltf, .glb) or a photograph (.png, .jpg, .webp, .gif, .tif, .bmp), or a folder of pictures that follow one another{end}"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// A full stop, or a question for the name that it is like.
        end: String,
        /// The names that exist.
        known: String,
    },
}

/// One sRGB byte as linear light, 0–1 (IEC 61966-2-1).
pub fn srgb_to_linear(value: u8) -> f32 {
    // There are only 256 answers, and scenes ask for millions.
    static ANSWERS: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|value| srgb_decode(value as f64 / 255.0) as f32));
    ANSWERS[usize::from(value)]
}

/// One sRGB code of 16 bits as linear light, 0–1 (IEC 61966-2-1).
pub fn srgb16_to_linear(value: u16) -> f32 {
    static ANSWERS: LazyLock<Vec<f32>> = LazyLock::new(|| {
        (0..=u16::MAX)
            .map(|value| srgb_decode(f64::from(value) / 65_535.0) as f32)
            .collect()
    });
    ANSWERS[usize::from(value)]
}

/// Linear light as an sRGB byte, clamped to 0–1 (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f32) -> u8 {
    // Mip levels ask for millions.
    static CODES: LazyLock<SrgbCodes> = LazyLock::new(SrgbCodes::new);
    CODES.of(linear)
}

/// [`encode_srgb`] by looking it up.
struct SrgbCodes {
    /// The least light of each code but 0.
    least: [f32; 255],
    /// The code of the light `n / 4096`.
    guesses: Vec<u8>,
}

impl SrgbCodes {
    fn new() -> Self {
        let mut least = [0.0; 255];
        for (below, least) in (0..=254u8).zip(&mut least) {
            // Floats of one sign are ordered as their bits.
            let (mut low, mut high) = (0.0f32.to_bits(), 1.0f32.to_bits());
            while high - low > 1 {
                let middle = low.midpoint(high);
                if encode_srgb(f32::from_bits(middle)) > below {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            *least = f32::from_bits(high);
        }
        let guesses = (0..=4096u16).map(|n| encode_srgb(f32::from(n) / 4096.0));
        Self {
            least,
            guesses: guesses.collect(),
        }
    }

    fn of(&self, linear: f32) -> u8 {
        let clamped = linear.clamp(0.0, 1.0);
        let mut code = self.guesses[(clamped * 4096.0) as usize];
        while code < 255 && clamped >= self.least[usize::from(code)] {
            code += 1;
        }
        code
    }
}

fn encode_srgb(linear: f32) -> u8 {
    (srgb_encode(linear.into()) * 255.0).round() as u8
}

/// Luminance of a linear sRGB colour (Rec. 709 weights).
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_every_byte_and_meets_known_values() {
        for value in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(value)), value);
        }
        for value in (0..=100_000).map(|n| n as f32 / 99_999.0) {
            assert_eq!(
                linear_to_srgb(value),
                encode_srgb(value.min(1.0)),
                "{value}"
            );
        }
        assert_eq!([-1.0, f32::NAN, 2.0].map(linear_to_srgb), [0, 0, 255]);
        for value in 0..=255u8 {
            let wide = srgb16_to_linear(u16::from(value) * 257);
            assert!((wide - srgb_to_linear(value)).abs() < 3e-7, "{value}");
        }
        // IEC 61966-2-1: middle grey 0.2140 at code 127.5; 188 is half the light.
        assert!((srgb_to_linear(188) - 0.5029).abs() < 1e-3);
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn mips_average_light_not_codes() {
        let texture = SceneTexture {
            width: 2,
            height: 1,
            rgba8: vec![0, 0, 0, 255, 255, 255, 255, 255],
            srgb: true,
            wrap: [Wrap::Clamp; 2],
        };
        let levels = texture.mip_levels();
        assert_eq!(levels.len(), 1);
        // Half of white's light is code 188, not 128.
        assert_eq!(levels[0].2, vec![188, 188, 188, 255]);
    }

    #[test]
    fn validation_names_the_mesh_and_the_vertex() {
        let mut model = SceneModel {
            name: "t".into(),
            meshes: vec![SceneMesh {
                name: "tri".into(),
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                normals: vec![[0.0, 0.0, 1.0]; 3],
                indices: vec![0, 1, 2],
                ..Default::default()
            }],
            materials: vec![SceneMaterial::default()],
            ..Default::default()
        };
        assert_eq!(model.validate(), Ok(()));
        model.meshes[0].positions[1][2] = f32::NAN;
        let message = model.validate().unwrap_err().to_string();
        assert!(
            message.contains("\"tri\"") && message.contains("vertex 1"),
            "{message}"
        );
        model.meshes[0].positions[1][2] = 0.0;
        model.meshes[0].indices[2] = 3;
        let message = model.validate().unwrap_err().to_string();
        assert!(message.contains("index 3"), "{message}");
        model.meshes[0].indices[2] = 2;
        model.materials[0].base_color_texture = Some(0);
        assert!(model.validate().is_err());
    }
}
