//! What the view's passes keep on the GPU between frames: the view's textures and buffers, and the
//! voxel table of the sharpness field.

use super::gpu_data::{
    CANDIDATE_CAPACITY, FEATURE_COUNTERS, MediaUniform, PerceptUniform, TABLE_COUNTERS, TILE,
    VEIL_SCALE, mip_levels, table_slots,
};
use super::readback::Readback;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::render_resource::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, Sampler, Texture, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
};
use bevy::render::renderer::RenderDevice;
use std::sync::Arc;

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
    /// The numbers with which it was captured.
    pub(super) data: PerceptUniform,
    pub(super) uniform: Buffer,
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
/// What the passes of one camera's view keep between frames.
pub(super) struct ViewGpu {
    /// Numbers of the frame that is shown.
    pub(super) uniform: Buffer,
    pub(super) feature_counters: Buffer,
    pub(super) candidates: Buffer,
    pub(super) view: Option<View>,
    /// The view before it, of the same size, to be captured into next: whoever walks needs both in turn.
    pub(super) spare: Option<View>,
    pub(super) table: Option<Table>,
    pub(super) field: Option<(Arc<Vec<f32>>, TextureView)>,
    /// Is the picture drawn in this frame, how large is the target's image and of what format, and how
    /// large was the one that was drawn last?
    pub(super) present: bool,
    pub(super) target: UVec2,
    pub(super) format: TextureFormat,
    pub(super) presented: UVec2,
    pub(super) captured: u64,
    /// Voxels in the table at most.
    pub(super) occupied: u32,
    pub(super) veil: Option<VeilGpu>,
    pub(super) readback: Readback,
    /// Captures recorded since the one that the read-back holds.
    pub(super) unread: u32,
}

impl ViewGpu {
    pub(super) fn new(device: &RenderDevice) -> Self {
        Self {
            uniform: uniform_buffer(device, "percept"),
            feature_counters: buffer(
                device,
                "feature_counters",
                FEATURE_COUNTERS as u64 * 4,
                STORAGE,
            ),
            candidates: buffer(
                device,
                "candidates",
                u64::from(CANDIDATE_CAPACITY) * 16,
                STORAGE,
            ),
            view: None,
            spare: None,
            table: None,
            field: None,
            present: false,
            target: UVec2::ZERO,
            format: TextureFormat::Rgba8UnormSrgb,
            presented: UVec2::ZERO,
            captured: 0,
            occupied: 0,
            veil: None,
            readback: Readback::default(),
            unread: 0,
        }
    }
}

/// The veil over one view.
pub(super) struct VeilGpu {
    pub(super) size: UVec2,
    pub(super) view: TextureView,
    pub(super) uniform: Buffer,
    /// Which capture it is of, and what media.
    pub(super) of: Option<(u64, MediaUniform)>,
}

impl VeilGpu {
    /// A veil for a view of this size, pixels.
    pub(super) fn new(device: &RenderDevice, size: UVec2) -> Self {
        let small = size.map(|side| side.div_ceil(VEIL_SCALE));
        let texture = device.create_texture(&TextureDescriptor {
            label: Some("veil"),
            size: Extent3d {
                width: small.x,
                height: small.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::Rgba16Float,
            usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self {
            size,
            view: texture.create_view(&TextureViewDescriptor::default()),
            uniform: buffer(
                device,
                "media",
                size_of::<MediaUniform>() as u64,
                BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            ),
            of: None,
        }
    }
}

/// What the passes keep between frames, by the camera's entity in the render world.
#[derive(Resource, Default)]
pub struct PerceptGpu {
    pub(super) sampler: Option<Sampler>,
    pub(super) views: HashMap<Entity, ViewGpu>,
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
/// A buffer for the numbers of a pass.
pub(super) fn uniform_buffer(device: &RenderDevice, label: &'static str) -> Buffer {
    buffer(
        device,
        label,
        size_of::<PerceptUniform>() as u64,
        BufferUsages::UNIFORM | BufferUsages::COPY_DST,
    )
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
    /// A view to be captured with these numbers.
    pub(super) fn new(device: &RenderDevice, data: PerceptUniform) -> Self {
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

    pub(super) fn level(&self, level: u32) -> TextureView {
        self.colour.create_view(&TextureViewDescriptor {
            base_mip_level: level,
            mip_level_count: Some(1),
            ..TextureViewDescriptor::default()
        })
    }
}
pub(super) fn table_is_new(gpu: &ViewGpu) -> bool {
    gpu.occupied == 0
}
/// Slots of a memory above which it begins anew rather than grow: 12 bytes each, so 200 MB.
const MOST_SLOTS: u32 = 1 << 24;
/// A table with room for another view; the old one, if its voxels have to move into it.
pub(super) fn make_room(
    gpu: &mut ViewGpu,
    device: &RenderDevice,
    size: UVec2,
    forget: bool,
) -> Option<Table> {
    if forget {
        gpu.table = None;
        gpu.occupied = 0;
    }
    let slots = table_slots(gpu.occupied, size.x * size.y);
    if slots > MOST_SLOTS && gpu.table.is_some() {
        // Who walks on and on forgets where she began.
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
