//! What a capture leaves on the GPU.

use super::super::gpu_data::{PerceptUniform, TILE, mip_levels};
use super::super::resources::{STORAGE, buffer, uniform_buffer};
use bevy::math::UVec2;
use bevy::render::render_resource::{
    Buffer, Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
    TextureView, TextureViewDescriptor,
};
use bevy::render::renderer::RenderDevice;

/// A static view, and all that has its size.
pub(in crate::percept) struct ViewImages {
    pub(in crate::percept) size: UVec2,
    /// The numbers with which it was captured.
    pub(in crate::percept) data: PerceptUniform,
    pub(in crate::percept) uniform: Buffer,
    pub(in crate::percept) colour: Texture,
    pub(in crate::percept) colour_view: TextureView,
    pub(in crate::percept) vergence_view: TextureView,
    pub(in crate::percept) vergence: Texture,
    pub(in crate::percept) luma: Buffer,
    pub(in crate::percept) strengths: Buffer,
    pub(in crate::percept) pixel_slot: Buffer,
    pub(in crate::percept) blur_px: Buffer,
    pub(in crate::percept) tile_near: Buffer,
}

impl ViewImages {
    /// A view to be captured with these numbers.
    pub(in crate::percept) fn new(device: &RenderDevice, data: PerceptUniform) -> Self {
        let size = UVec2::from(data.size);
        let texture = |label, format, levels, usage| {
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d {
                    width: size.x,
                    height: size.y,
                    depth_or_array_layers: 1,
                },
                mip_level_count: levels,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let colour = texture(
            "view_colour",
            TextureFormat::Rgba16Float,
            mip_levels(size.x, size.y),
            TextureUsages::COPY_SRC,
        );
        let vergence = texture(
            "view_vergence",
            TextureFormat::R32Float,
            1,
            TextureUsages::COPY_SRC,
        );
        let words = u64::from(size.x) * u64::from(size.y) * 4;
        let tiles = size.map(|side| side.div_ceil(TILE));
        Self {
            size,
            data,
            uniform: uniform_buffer(device, "percept_capture"),
            colour_view: colour.create_view(&TextureViewDescriptor::default()),
            colour,
            vergence_view: vergence.create_view(&TextureViewDescriptor::default()),
            vergence,
            luma: buffer(device, "luma", words, STORAGE),
            strengths: buffer(device, "strengths", words, STORAGE),
            pixel_slot: buffer(device, "pixel_slot", words, STORAGE),
            blur_px: buffer(device, "blur_px", words, STORAGE),
            tile_near: buffer(
                device,
                "tile_near",
                u64::from(tiles.x) * u64::from(tiles.y) * 8,
                STORAGE,
            ),
        }
    }
}

/// One level of a texture.
pub(in crate::percept) fn one_level(texture: &Texture, level: u32) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        base_mip_level: level,
        mip_level_count: Some(1),
        ..TextureViewDescriptor::default()
    })
}
