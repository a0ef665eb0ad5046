//! The picture: the blur that is shown, the veil of clouded media, and the gather (Nießner et al. 2013,
//! section 5).

pub mod gather;
pub mod gather_ellipse;
pub(super) mod hand_on;
pub(super) mod perceive;
pub mod veil;
mod veil_passes;

pub(super) use veil_passes::VeilGpu;
use veil_passes::VeilPasses;

use super::capture::ViewImages;
use super::field::Table;
use super::gpu_data::{TILE, pixel_groups};
use super::pass::{ComputePass, DrawPass, EffectInputs, Effects, Recorder, view_numbers};
use crate::frame::shaders;
use bevy::color::LinearRgba;
use bevy::render::render_resource::binding_types::{
    sampler, storage_buffer_read_only_sized, storage_buffer_sized, texture_2d,
};
use bevy::render::render_resource::{
    BindGroupEntries, BindGroupLayoutEntries, Buffer, CommandEncoder, LoadOp, Operations,
    PipelineCache, RenderPassColorAttachment, RenderPassDescriptor, SamplerBindingType,
    ShaderStages, StoreOp, TextureFormat, TextureSampleType, TextureView,
};
use bevy::render::texture::GpuImage;

/// The passes of the picture.
pub(super) struct PresentPasses {
    read_blur: ComputePass,
    pub(super) veil: VeilPasses,
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
        let blurs = Effects {
            field_loss: true,
            astigmatism: true,
            ..plain
        };
        Self {
            read_blur: ComputePass::new(
                "read_blur",
                shaders::READ_BLUR,
                blurs,
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
            veil: VeilPasses::default(),
            gather: DrawPass::new(
                "present",
                shaders::GATHER,
                Effects {
                    field_loss: true,
                    media: true,
                    astigmatism: true,
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
            is_ready &= self.veil.is_ready(cache);
        }
        is_ready
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
