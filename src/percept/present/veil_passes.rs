//! The veil of clouded media over a view: its source, the levels of that, and what is spread from them.

use super::super::capture::{CapturePasses, ViewImages, one_level};
use super::super::frame::PerceptFrame;
use super::super::gpu_data::{MediaUniform, VEIL_SCALE, WORKGROUP, mip_levels, pixel_groups};
use super::super::pass::{ComputePass, EffectInputs, Effects, Recorder, numbers, view_numbers};
use super::super::resources::buffer;
use crate::frame::shaders;
use bevy::math::UVec2;
use bevy::render::render_resource::binding_types::{sampler, texture_2d, texture_storage_2d};
use bevy::render::render_resource::{
    BindGroupEntries, BindGroupLayoutEntries, Buffer, BufferUsages, Extent3d, PipelineCache,
    SamplerBindingType, ShaderStages, StorageTextureAccess, Texture, TextureDescriptor,
    TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView,
    TextureViewDescriptor,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};

/// The passes of a veil.
pub(in crate::percept) struct VeilPasses {
    source: ComputePass,
    spread: ComputePass,
}

impl Default for VeilPasses {
    fn default() -> Self {
        let pass = |name, shader| {
            let layout = BindGroupLayoutEntries::sequential(
                ShaderStages::COMPUTE,
                (
                    view_numbers(),
                    texture_2d(TextureSampleType::Float { filterable: true }),
                    sampler(SamplerBindingType::Filtering),
                    numbers::<MediaUniform>(),
                    texture_storage_2d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly),
                ),
            );
            ComputePass::new(name, shader, Effects::default(), &layout)
        };
        Self {
            source: pass("project_source", shaders::VEIL_SOURCE),
            spread: pass("spread_veil", shaders::VEIL),
        }
    }
}

impl VeilPasses {
    /// Asks for both; says whether they are built.
    pub(in crate::percept) fn is_ready(&mut self, cache: &PipelineCache) -> bool {
        let plain = Effects::default();
        self.source.is_ready(cache, plain) & self.spread.is_ready(cache, plain)
    }

    /// Spreads the veil over the view of a capture, where it is not there yet. How much light is
    /// scattered does not matter to it.
    pub(in crate::percept) fn run(
        &mut self,
        frame: &PerceptFrame,
        (view, captured): (Option<&ViewImages>, u64),
        there: &mut Option<VeilGpu>,
        capture: &mut CapturePasses,
        queue: &RenderQueue,
        recorder: &mut Recorder,
    ) {
        let (Some(media), Some(view)) = (&frame.media, view) else {
            *there = None;
            return;
        };
        let mut veil = match there.take() {
            Some(veil) if veil.size == view.size && veil.source_size == media.source_size => veil,
            _ => VeilGpu::new(recorder.device, view.size, media.source_size),
        };
        if veil.media != Some(*media) {
            queue.write_buffer(&veil.uniform, 0, bytemuck::bytes_of(media));
            let bytes = size_of::<MediaUniform>() as u64;
            recorder.ledger.bytes_uploaded(bytes);
            veil.media = Some(*media);
        }
        if !veil.is_of(captured, media) && self.spread(view, &veil, capture, recorder) {
            veil.of = Some((captured, media.weights));
            recorder.ledger.veil_passes(1);
        }
        *there = Some(veil);
    }

    fn spread(
        &mut self,
        view: &ViewImages,
        veil: &VeilGpu,
        capture: &mut CapturePasses,
        recorder: &mut Recorder,
    ) -> bool {
        if !self.is_ready(recorder.cache) {
            return false;
        }
        let plain = EffectInputs::default();
        let finest = one_level(&veil.source, 0);
        let entries = BindGroupEntries::sequential((
            view.uniform.as_entire_binding(),
            &view.colour_view,
            recorder.sampler,
            veil.uniform.as_entire_binding(),
            &finest,
        ));
        let [x, y] = veil.source_size;
        self.source
            .run(recorder, &plain, &entries, pixel_groups(x, y, WORKGROUP));
        capture.fill_mips(&veil.source, recorder);
        let levels = veil.source.create_view(&TextureViewDescriptor::default());
        let entries = BindGroupEntries::sequential((
            view.uniform.as_entire_binding(),
            &levels,
            recorder.sampler,
            veil.uniform.as_entire_binding(),
            &veil.view,
        ));
        let small = view.size.map(|side| side.div_ceil(VEIL_SCALE));
        let groups = pixel_groups(small.x, small.y, WORKGROUP);
        self.spread.run(recorder, &plain, &entries, groups)
    }
}

/// The veil over one view.
pub(in crate::percept) struct VeilGpu {
    size: UVec2,
    source_size: [u32; 2],
    source: Texture,
    pub(in crate::percept) view: TextureView,
    pub(in crate::percept) uniform: Buffer,
    /// What the uniform holds.
    media: Option<MediaUniform>,
    /// Which capture it is of, and how its light is spread.
    of: Option<(u64, [[f32; 4]; 4])>,
}

impl VeilGpu {
    /// Is it of these media over the view of this capture?
    pub(in crate::percept) fn is_of(&self, captured: u64, media: &MediaUniform) -> bool {
        self.of == Some((captured, media.weights))
    }

    /// A veil for a view of this size, pixels.
    fn new(device: &RenderDevice, size: UVec2, source_size: [u32; 2]) -> Self {
        let texture = |label, [width, height]: [u32; 2], levels| {
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: levels,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TextureFormat::Rgba16Float,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let small = size.map(|side| side.div_ceil(VEIL_SCALE)).to_array();
        let levels = mip_levels(source_size[0], source_size[1]);
        Self {
            size,
            source_size,
            source: texture("veil_source", source_size, levels),
            view: texture("veil", small, 1).create_view(&TextureViewDescriptor::default()),
            uniform: buffer(
                device,
                "media",
                size_of::<MediaUniform>() as u64,
                BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            ),
            media: None,
            of: None,
        }
    }
}
