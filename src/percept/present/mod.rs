//! The picture: the blur that is shown, the veil of clouded media, and the gather (Nießner et al. 2013,
//! section 5).

pub mod gather;
pub(super) mod hand_on;
pub(super) mod perceive;
pub mod veil;

use super::capture::ViewImages;
use super::field::Table;
use super::frame::PerceptFrame;
use super::gpu_data::{MediaUniform, TILE, VEIL_SCALE, WORKGROUP, pixel_groups};
use super::pass::{ComputePass, DrawPass, EffectInputs, Effects, Recorder, numbers, view_numbers};
use super::resources::buffer;
use crate::frame::shaders;
use bevy::color::LinearRgba;
use bevy::math::UVec2;
use bevy::render::render_resource::binding_types::{
    sampler, storage_buffer_read_only_sized, storage_buffer_sized, texture_2d, texture_storage_2d,
};
use bevy::render::render_resource::{
    BindGroupEntries, BindGroupLayoutEntries, Buffer, BufferUsages, CommandEncoder, Extent3d,
    LoadOp, Operations, PipelineCache, RenderPassColorAttachment, RenderPassDescriptor,
    SamplerBindingType, ShaderStages, StorageTextureAccess, StoreOp, TextureDescriptor,
    TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView,
    TextureViewDescriptor,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;

/// The passes of the picture.
pub(super) struct PresentPasses {
    read_blur: ComputePass,
    veil: ComputePass,
    gather: DrawPass,
}

impl Default for PresentPasses {
    fn default() -> Self {
        let texel = || texture_2d(TextureSampleType::Float { filterable: false });
        let smooth = || texture_2d(TextureSampleType::Float { filterable: true });
        let reads = || storage_buffer_read_only_sized(false, None);
        let changes = || storage_buffer_sized(false, None);
        let filtering = || sampler(SamplerBindingType::Filtering);
        let plain = Effects::default();
        let loss = Effects {
            field_loss: true,
            ..plain
        };
        Self {
            read_blur: ComputePass::new(
                "read_blur",
                shaders::READ_BLUR,
                loss,
                &BindGroupLayoutEntries::sequential(
                    ShaderStages::COMPUTE,
                    (
                        view_numbers(),
                        texel(),
                        reads(),
                        changes(),
                        changes(),
                        changes(),
                    ),
                ),
            ),
            veil: ComputePass::new(
                "spread_veil",
                shaders::VEIL,
                plain,
                &BindGroupLayoutEntries::sequential(
                    ShaderStages::COMPUTE,
                    (
                        view_numbers(),
                        smooth(),
                        filtering(),
                        numbers::<MediaUniform>(),
                        texture_storage_2d(
                            TextureFormat::Rgba16Float,
                            StorageTextureAccess::WriteOnly,
                        ),
                    ),
                ),
            ),
            gather: DrawPass::new(
                "present",
                shaders::GATHER,
                Effects {
                    field_loss: true,
                    media: true,
                },
                &BindGroupLayoutEntries::sequential(
                    ShaderStages::FRAGMENT,
                    (view_numbers(), smooth(), filtering(), reads(), reads()),
                ),
            ),
        }
    }
}

impl PresentPasses {
    /// Asks for what a view with these effects needs, into a target of this format; says whether it is built.
    pub(super) fn is_ready(
        &mut self,
        cache: &PipelineCache,
        effects: Effects,
        format: TextureFormat,
    ) -> bool {
        let mut is_ready = self.read_blur.is_ready(cache, effects);
        is_ready &= self.gather.is_ready(cache, effects, format);
        if effects.media {
            is_ready &= self.veil.is_ready(cache, effects);
        }
        is_ready
    }

    /// Spreads the veil of clouded media over the view of a capture, where it is not there yet.
    pub(super) fn spread_veil(
        &mut self,
        frame: &PerceptFrame,
        (view, captured): (Option<&ViewImages>, u64),
        there: &mut Option<VeilGpu>,
        queue: &RenderQueue,
        recorder: &mut Recorder,
    ) {
        let (Some(media), Some(view)) = (&frame.media, view) else {
            *there = None;
            return;
        };
        if there
            .as_ref()
            .is_some_and(|veil| veil.is_of(captured, media))
        {
            return;
        }
        let mut veil = match there.take() {
            Some(veil) if veil.size == view.size => veil,
            _ => VeilGpu::new(recorder.device, view.size),
        };
        queue.write_buffer(&veil.uniform, 0, bytemuck::bytes_of(media));
        let entries = BindGroupEntries::sequential((
            view.uniform.as_entire_binding(),
            &view.colour_view,
            recorder.sampler,
            veil.uniform.as_entire_binding(),
            &veil.view,
        ));
        let small = view.size.map(|side| side.div_ceil(VEIL_SCALE));
        let groups = pixel_groups(small.x, small.y, WORKGROUP);
        if self
            .veil
            .run(recorder, &EffectInputs::default(), &entries, groups)
        {
            veil.of = Some((captured, *media));
            recorder.ledger.veil_passes(1);
            recorder
                .ledger
                .bytes_uploaded(size_of::<MediaUniform>() as u64);
        }
        *there = Some(veil);
    }

    /// Draws the picture; says whether it was drawn.
    pub(super) fn draw(
        &mut self,
        uniform: &Buffer,
        view: &ViewImages,
        table: &Table,
        inputs: &EffectInputs,
        target: &GpuImage,
        recorder: &mut Recorder,
    ) -> bool {
        let entries = BindGroupEntries::sequential((
            uniform.as_entire_binding(),
            &view.vergence_view,
            view.pixel_slot.as_entire_binding(),
            table.keys.as_entire_binding(),
            view.blur_px.as_entire_binding(),
            view.tile_near.as_entire_binding(),
        ));
        let tiles = pixel_groups(view.size.x, view.size.y, TILE);
        self.read_blur.run(recorder, inputs, &entries, tiles);
        let entries = BindGroupEntries::sequential((
            uniform.as_entire_binding(),
            &view.colour_view,
            recorder.sampler,
            view.blur_px.as_entire_binding(),
            view.tile_near.as_entire_binding(),
        ));
        let onto = RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(onto_black(&target.texture_view))],
            ..RenderPassDescriptor::default()
        };
        let format = target.texture_descriptor.format;
        if !self.gather.draw(recorder, inputs, &entries, format, &onto) {
            return false;
        }
        let size = target.texture_descriptor.size;
        recorder.ledger.view_passes(1);
        recorder
            .ledger
            .view_pixels(u64::from(size.width) * u64::from(size.height));
        if inputs.field.is_some() {
            recorder.ledger.field_loss_passes(1);
        }
        true
    }
}

/// Nothing but black.
pub(super) fn blank(encoder: &mut CommandEncoder, target: &TextureView) {
    encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("view_of_nobody"),
        color_attachments: &[Some(onto_black(target))],
        ..RenderPassDescriptor::default()
    });
}

/// A target that is black before anything is drawn into it.
fn onto_black(view: &TextureView) -> RenderPassColorAttachment<'_> {
    RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: Operations {
            load: LoadOp::Clear(LinearRgba::BLACK.into()),
            store: StoreOp::Store,
        },
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
    /// Is it of these media over the view of this capture?
    pub(super) fn is_of(&self, captured: u64, media: &MediaUniform) -> bool {
        self.of.as_ref() == Some(&(captured, *media))
    }

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
