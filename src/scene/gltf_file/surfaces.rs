//! Materials and textures of a glTF file.

use super::super::model::{Alpha, SceneError, SceneMaterial, SceneTexture, Wrap};
use super::super::picture_file::{Meaning, decode_picture};
use super::coordinates::Layout;
use super::{EMISSION_CD_M2, Source};
use gltf::texture::WrappingMode;
use gltf::{Document, Texture, image};
use std::collections::HashMap;

/// Largest sum of texels over all textures: 1 GiB as RGBA.
const MAX_TOTAL_TEXELS: u64 = 256 << 20;

/// Textures read so far, by image, encoding and what lies beyond their edges.
#[derive(Default)]
struct Shelf {
    textures: Vec<SceneTexture>,
    place: HashMap<(usize, bool, [Wrap; 2]), usize>,
    texels: u64,
    remarks: Vec<String>,
}

/// What a file says of its surfaces.
pub(super) struct Surfaces {
    /// All materials, in the file's order.
    pub(super) materials: Vec<SceneMaterial>,
    /// The textures that they use.
    pub(super) textures: Vec<SceneTexture>,
    /// What is to be said of these.
    pub(super) remarks: Vec<String>,
}

/// The surfaces of a document.
pub(super) fn read(document: &Document, source: &Source) -> Result<Surfaces, SceneError> {
    let mut shelf = Shelf::default();
    let materials = document
        .materials()
        .map(|material| read_material(&material, source, &mut shelf))
        .collect::<Result<_, _>>()?;
    Ok(Surfaces {
        materials,
        textures: shelf.textures,
        remarks: shelf.remarks,
    })
}

fn read_material(
    material: &gltf::Material,
    source: &Source,
    shelf: &mut Shelf,
) -> Result<SceneMaterial, SceneError> {
    let surface = material.pbr_metallic_roughness();
    let mut texture = |texture: Option<Texture>, srgb: bool| {
        texture.map(|t| shelf.read(&t, srgb, source)).transpose()
    };
    let finite = |value: f32, low: f32, high: f32| {
        if value.is_finite() {
            value.clamp(low, high)
        } else {
            low
        }
    };
    let strength = finite(material.emissive_strength().unwrap_or(1.0), 0.0, 1e6);
    let read = SceneMaterial {
        name: material.name().unwrap_or("unnamed").into(),
        base_color: surface.base_color_factor().map(|c| finite(c, 0.0, 1.0)),
        metallic: finite(surface.metallic_factor(), 0.0, 1.0),
        roughness: finite(surface.roughness_factor(), 0.0, 1.0),
        emissive: material
            .emissive_factor()
            .map(|e| finite(e, 0.0, 1e4) * strength * EMISSION_CD_M2),
        base_color_texture: texture(surface.base_color_texture().map(|t| t.texture()), true)?,
        emissive_texture: texture(material.emissive_texture().map(|t| t.texture()), true)?,
        metallic_roughness_texture: texture(
            surface.metallic_roughness_texture().map(|t| t.texture()),
            false,
        )?,
        normal_texture: texture(material.normal_texture().map(|t| t.texture()), false)?,
        alpha: match material.alpha_mode() {
            gltf::material::AlphaMode::Opaque => Alpha::Opaque,
            gltf::material::AlphaMode::Mask => {
                Alpha::Mask(finite(material.alpha_cutoff().unwrap_or(0.5), 0.0, 1.0))
            }
            gltf::material::AlphaMode::Blend => Alpha::Blend,
        },
        on_second_uvs: Layout::of(material).on_second,
        unlit: material.unlit(),
        double_sided: material.double_sided(),
    };
    Ok(read)
}

impl Shelf {
    fn read(
        &mut self,
        texture: &Texture,
        srgb: bool,
        source: &Source,
    ) -> Result<usize, SceneError> {
        let image = texture.source();
        let sampler = texture.sampler();
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
        });
        let key = (image.index(), srgb, wrap);
        if let Some(&index) = self.place.get(&key) {
            return Ok(index);
        }
        let name = format!("{} (image {})", source.name, image.index());
        // The specification has textures ignore their colour profiles (glTF 2.0, 3.8.1).
        let decode = |bytes: &[u8]| decode_picture(bytes, &name, 1, Meaning::Data);
        let decoded = match image.source() {
            image::Source::View { view, .. } => decode(source.view(&view)?)?,
            image::Source::Uri { uri, .. } => {
                decode(&source.beside.read(uri, source.name, "texture")?)?
            }
        };
        self.remarks.extend(decoded.remarks);
        let rgba = decoded.image.into_rgba8();
        self.texels += u64::from(rgba.width()) * u64::from(rgba.height());
        if self.texels > MAX_TOTAL_TEXELS {
            return Err(source.content(format!(
                "its textures have more than {MAX_TOTAL_TEXELS} texels in all"
            )));
        }
        self.textures.push(SceneTexture {
            width: rgba.width(),
            height: rgba.height(),
            rgba8: rgba.into_raw(),
            srgb,
            wrap,
        });
        self.place.insert(key, self.textures.len() - 1);
        Ok(self.textures.len() - 1)
    }
}
