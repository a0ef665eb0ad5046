//! What the view's passes keep on the GPU between frames: the view's textures and buffers, and the
//! voxel table of the sharpness field.

use super::gpu_data::{TABLE_COUNTERS, TILE, mip_levels, table_slots};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, Sampler, Texture, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
};
use bevy::render::renderer::RenderDevice;

/// The voxel table: one tag, home and key a slot.
pub(super) struct Table {
    pub(super) slots: u32,
    pub(super) tag: Buffer,
    pub(super) home: Buffer,
    pub(super) keys: Buffer,
    pub(super) counters: Buffer,
}
/// Everything of one view's size.
pub(super) struct View {
    pub(super) size: UVec2,
    pub(super) colour: Texture,
    pub(super) colour_view: TextureView,
    pub(super) vergence_view: TextureView,
    pub(super) vergence: Texture,
    pub(super) luma: Buffer,
    pub(super) strengths: Buffer,
    pub(super) pixel_slot: Buffer,
    pub(super) blur_px: Buffer,
    pub(super) tile_near: Buffer,
}
/// What the passes keep between frames.
#[derive(Resource, Default)]
pub struct PerceptGpu {
    pub(super) uniform: Option<Buffer>,
    pub(super) sampler: Option<Sampler>,
    pub(super) feature_counters: Option<Buffer>,
    pub(super) candidates: Option<Buffer>,
    pub(super) view: Option<View>,
    pub(super) table: Option<Table>,
    pub(super) field: Option<(u64, TextureView)>,
    /// Is the picture drawn in this frame, how large is the panel's image, and how large was the one
    /// that was drawn last?
    pub(super) present: bool,
    pub(super) target: UVec2,
    pub(super) presented: UVec2,
    pub(super) captured: u64,
    pub(super) occupied: u32,
}
pub(super) fn buffer(
    device: &RenderDevice,
    label: &'static str,
    bytes: u64,
    usage: BufferUsages,
) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some(label),
        size: bytes.max(16),
        usage,
        mapped_at_creation: false,
    })
}
pub(super) const STORAGE: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::COPY_SRC)
    .union(BufferUsages::COPY_DST);

impl Table {
    pub(super) fn new(device: &RenderDevice, slots: u32) -> Self {
        let words = u64::from(slots) * 4;
        Self {
            slots,
            tag: buffer(device, "voxel_tag", words, STORAGE),
            home: buffer(device, "voxel_home", words, STORAGE),
            keys: buffer(device, "sharpness_keys", words, STORAGE),
            counters: buffer(device, "table_counters", TABLE_COUNTERS as u64 * 4, STORAGE),
        }
    }
}
impl View {
    pub(super) fn new(device: &RenderDevice, size: UVec2) -> Self {
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
            TextureUsages::empty(),
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

    pub(super) fn level(&self, level: u32) -> TextureView {
        self.colour.create_view(&TextureViewDescriptor {
            base_mip_level: level,
            mip_level_count: Some(1),
            ..TextureViewDescriptor::default()
        })
    }
}
pub(super) fn table_is_new(gpu: &PerceptGpu) -> bool {
    gpu.occupied == 0
}
/// A table with room for another view; the old one, if its voxels have to move into it.
pub(super) fn make_room(
    gpu: &mut PerceptGpu,
    device: &RenderDevice,
    size: UVec2,
    forget: bool,
) -> Option<Table> {
    if forget {
        gpu.table = None;
        gpu.occupied = 0;
    }
    let slots = table_slots(gpu.occupied, size.x * size.y);
    match gpu.table.take() {
        Some(table) if table.slots >= slots => {
            gpu.table = Some(table);
            None
        }
        old => {
            gpu.table = Some(Table::new(device, slots));
            old
        }
    }
}
