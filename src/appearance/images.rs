//! Tissue maps as textures: half floats with their mip chain; and the same read in f64.

use bevy::asset::RenderAssetUsages;
use bevy::image::{Image, ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use glam::DVec2;
use half::f16;
use half::slice::HalfFloatSliceExt as _;

/// One level of a map.
pub type Level = crate::frame::mips::Level<4>;

/// Makes a filtered RGBA16F texture of these levels, the finest first; `wrap` repeats it in u.
pub fn map_image(levels: &[Level], wrap: bool) -> Image {
    let count = levels
        .iter()
        .map(|(_, _, texels)| texels.len())
        .sum::<usize>();
    let mut data = Vec::with_capacity(8 * count);
    let mut halves = Vec::new();
    for (_, _, texels) in levels {
        let values = texels.as_flattened();
        halves.resize(values.len(), f16::ZERO);
        halves.convert_from_f32_slice(values);
        // Little-endian, as every target is.
        data.extend_from_slice(bytemuck::cast_slice(halves.reinterpret_cast()));
    }
    image_of(levels, data, TextureFormat::Rgba16Float, wrap)
}

/// Colours of an RGBA16F picture that was read back; what is not a whole texel at its end is left out.
pub(super) fn f16_texels(data: &[u8]) -> Vec<[f32; 3]> {
    let texels = data.chunks_exact(8);
    let value = |bytes: &[u8], at: usize| {
        let value = f16::from_le_bytes([bytes[at], bytes[at + 1]]).to_f32();
        // What is brighter than they hold is as bright as they hold; what is no number is dark.
        value.max(0.0).min(f16::MAX.to_f32())
    };
    texels
        .map(|bytes| [0, 2, 4].map(|at| value(bytes, at)))
        .collect()
}

/// The same as RGBA8 of numbers within `±range`, which stand as 0 to 1: half the bytes, and a software rasteriser reads it in
/// half the time.
pub fn byte_map_image(levels: &[Level], range: f32, wrap: bool) -> Image {
    let values = levels.iter().flat_map(|(_, _, texels)| texels).flatten();
    let data =
        values.map(|value| ((0.5 + 0.5 * value / range).clamp(0.0, 1.0) * 255.0).round() as u8);
    let data = data.collect();
    image_of(levels, data, TextureFormat::Rgba8Unorm, wrap)
}

fn image_of(levels: &[Level], data: Vec<u8>, format: TextureFormat, wrap: bool) -> Image {
    let (width, height) = levels.first().map_or((1, 1), |level| (level.0, level.1));
    let mut image = Image::new_uninit(
        Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        format,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels.len().max(1) as u32;
    image.texture_descriptor.usage =
        TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: if wrap {
            ImageAddressMode::Repeat
        } else {
            ImageAddressMode::ClampToEdge
        },
        address_mode_v: ImageAddressMode::ClampToEdge,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        // Levels differ little between neighbours here, and blending two of them doubles the cost.
        mipmap_filter: ImageFilterMode::Nearest,
        ..ImageSamplerDescriptor::default()
    });
    image
}

/// The texels of [`map_image`] as a texture unit reads them, in f64: what `textureSampleLevel` of that
/// image with its own sampler means.
#[derive(Clone, Debug)]
pub struct MapView {
    levels: Vec<(usize, usize, Vec<[f64; 4]>)>,
    wrap: bool,
}

impl MapView {
    /// The same levels and wrap as the image's; the texels are rounded to half floats as there.
    pub fn new(levels: &[Level], wrap: bool) -> Self {
        let rounded = |texel: &[f32; 4]| texel.map(|value| f16::from_f32(value).to_f64());
        let levels = levels
            .iter()
            .map(|(w, h, texels)| {
                let texels = texels.iter().map(rounded).collect();
                (*w as usize, *h as usize, texels)
            })
            .collect();
        Self { levels, wrap }
    }

    /// Width and height of the finest level.
    pub fn size(&self) -> DVec2 {
        let (width, height) = self.levels.first().map_or((1, 1), |(w, h, _)| (*w, *h));
        DVec2::new(width as f64, height as f64)
    }

    /// Bilinear within the level nearest to `lod`.
    pub fn sample(&self, uv: DVec2, lod: f64) -> [f64; 4] {
        let level = (lod + 0.5).floor().max(0.0) as usize;
        let Some((width, height, texels)) = self.levels.get(level.min(self.levels.len() - 1))
        else {
            return [0.0; 4];
        };
        let at = uv * DVec2::new(*width as f64, *height as f64) - 0.5;
        let corner = at.floor();
        let f = at - corner;
        let texel = |dx: f64, dy: f64| {
            let last = *width as f64 - 1.0;
            let x = if self.wrap {
                (corner.x + dx).rem_euclid(*width as f64)
            } else {
                (corner.x + dx).clamp(0.0, last)
            };
            let y = (corner.y + dy).clamp(0.0, *height as f64 - 1.0);
            texels[y as usize * width + x as usize]
        };
        let (a, b, c, d) = (
            texel(0.0, 0.0),
            texel(1.0, 0.0),
            texel(0.0, 1.0),
            texel(1.0, 1.0),
        );
        core::array::from_fn(|i| {
            let top = a[i] + (b[i] - a[i]) * f.x;
            let bottom = c[i] + (d[i] - c[i]) * f.x;
            top + (bottom - top) * f.y
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::mips::chain;

    #[test]
    fn a_view_reads_between_texels_and_around_the_seam() {
        let texels = vec![[0.0; 4], [1.0; 4], [2.0; 4], [3.0; 4]];
        let level = (4, 1, texels);
        let at = |wrap, u| {
            MapView::new(std::slice::from_ref(&level), wrap).sample(DVec2::new(u, 0.5), 0.0)[0]
        };
        // Texels stand at 1/8, 3/8 …; sums of quarters are exact.
        assert_eq!(at(true, 0.375), 1.0);
        assert_eq!(at(true, 0.4375), 1.25);
        assert_eq!((at(true, 0.0), at(true, 1.0)), (1.5, 1.5));
        assert_eq!((at(false, 0.0), at(false, 1.0)), (0.0, 3.0));
    }

    #[test]
    fn the_image_holds_every_level() {
        let chain = chain((8, 4), vec![[0.25; 4]; 32]);
        let image = map_image(&chain, true);
        assert_eq!(
            image.data.map(|data| data.len()),
            Some((32 + 8 + 2 + 1) * 8)
        );
        assert_eq!(image.texture_descriptor.mip_level_count, 4);
    }
}
