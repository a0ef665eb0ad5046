//! What the passes of the views keep on the GPU between frames.

use super::capture::{Corners, Readback, ViewImages};
use super::field::Memory;
use super::gpu_data::PerceptUniform;
use super::present::VeilGpu;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::render_resource::{Buffer, BufferDescriptor, BufferUsages, Sampler, TextureView};
use bevy::render::renderer::RenderDevice;
use std::sync::Arc;

/// What the passes of one camera's view keep between frames.
pub(super) struct ViewGpu {
    /// Numbers of the frame that is shown.
    pub(super) uniform: Buffer,
    pub(super) corners: Corners,
    pub(super) view: Option<ViewImages>,
    /// The view before it, of the same size, to be captured into next: whoever walks needs both in turn.
    pub(super) spare: Option<ViewImages>,
    pub(super) memory: Memory,
    pub(super) field: Option<(Arc<Vec<f32>>, TextureView)>,
    /// Is the picture drawn in this frame, how large is the target's image, and how large was the one that
    /// was drawn last?
    pub(super) present: bool,
    pub(super) target: UVec2,
    pub(super) presented: UVec2,
    pub(super) captured: u64,
    pub(super) veil: Option<VeilGpu>,
    pub(super) readback: Readback,
    /// Captures recorded since the one that the read-back holds.
    pub(super) unread: u32,
}

impl ViewGpu {
    pub(super) fn new(device: &RenderDevice) -> Self {
        Self {
            uniform: uniform_buffer(device, "percept"),
            corners: Corners::new(device),
            view: None,
            spare: None,
            memory: Memory::default(),
            field: None,
            present: false,
            target: UVec2::ZERO,
            presented: UVec2::ZERO,
            captured: 0,
            veil: None,
            readback: Readback::default(),
            unread: 0,
        }
    }
}

/// What the passes keep between frames, by the camera's entity in the render world.
#[derive(Resource, Default)]
pub(super) struct PerceptGpu {
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
