//! The capture: a camera's picture, or a photograph, becomes the static view.
//!
//! Once a view: its colour with mips, its vergence, its corners, and the copies for the CPU. When that is
//! is decided in [`when`]; [`sight`] notices what has changed before a camera.

pub mod fast;
mod readback;
pub(super) mod sight;
mod view_images;
pub(super) mod when;

pub(super) use readback::{Readback, Staging};
pub(super) use view_images::{ViewImages, one_level};

use super::frame::CaptureSource;
use super::gpu_data::{
    CANDIDATE_CAPACITY, FEATURE_COUNTERS, PhotoUniform, WORKGROUP, pixel_groups,
};
use super::pass::{ComputePass, EffectInputs, Effects, Recorder, numbers, view_numbers};
use super::resources::{STORAGE, buffer};
use crate::frame::shaders;
use bevy::math::UVec2;
use bevy::render::render_resource::binding_types::{
    storage_buffer_read_only_sized, storage_buffer_sized, texture_2d, texture_depth_2d,
    texture_storage_2d,
};
use bevy::render::render_resource::{
    BindGroupEntries, BindGroupLayoutEntries, Buffer, BufferInitDescriptor, BufferUsages,
    PipelineCache, ShaderStages, StorageTextureAccess, Texture, TextureFormat, TextureSampleType,
    TextureView,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};

/// The passes of a capture.
pub(super) struct CapturePasses {
    scene: ComputePass,
    photo: ComputePass,
    downsample: ComputePass,
    /// Strengths, then their histogram, then the list.
    features: [ComputePass; 3],
}

impl Default for CapturePasses {
    fn default() -> Self {
        let texel = || texture_2d(TextureSampleType::Float { filterable: false });
        let writes = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
        let colour = || writes(TextureFormat::Rgba16Float);
        let reads = || storage_buffer_read_only_sized(false, None);
        let changes = || storage_buffer_sized(false, None);
        let pass =
            |name, shader, layout: &[_]| ComputePass::new(name, shader, Effects::default(), layout);
        let stage = ShaderStages::COMPUTE;
        let vergence = || writes(TextureFormat::R32Float);
        let scene = BindGroupLayoutEntries::sequential(
            stage,
            (
                view_numbers(),
                texel(),
                texture_depth_2d(),
                colour(),
                vergence(),
                changes(),
            ),
        );
        let photo = BindGroupLayoutEntries::sequential(
            stage,
            (
                view_numbers(),
                texel(),
                texel(),
                colour(),
                vergence(),
                changes(),
                numbers::<PhotoUniform>(),
            ),
        );
        let features = BindGroupLayoutEntries::sequential(
            stage,
            (
                view_numbers(),
                reads(),
                changes(),
                changes(),
                changes(),
                texel(),
            ),
        );
        Self {
            scene: pass("capture_scene", shaders::CAPTURE_SCENE, &scene),
            photo: pass("capture_photo", shaders::CAPTURE_PHOTO, &photo),
            downsample: pass(
                "downsample",
                shaders::DOWNSAMPLE,
                &BindGroupLayoutEntries::sequential(stage, (texel(), colour())),
            ),
            features: ["fast_strength", "count_corners", "append_corners"]
                .map(|name| pass(name, shaders::FEATURES, &features)),
        }
    }
}

/// Where a capture takes its picture from, on the device.
pub(super) enum Source<'a> {
    /// A camera's colour and depth, and the factor of its exposure that the colour holds.
    Scene(&'a TextureView, &'a TextureView, f32),
    /// A photograph's colour and vergence, and where the view is in its frame.
    Photo(&'a TextureView, &'a TextureView, PhotoUniform),
}

impl Source<'_> {
    /// What its picture has of each cd/m²; a photograph's values are taken as they are.
    pub(super) fn exposure(&self) -> f32 {
        match self {
            Self::Scene(.., exposure) => *exposure,
            Self::Photo(..) => 1.0,
        }
    }
}

/// The corners of a view: their counters and their list.
pub(super) struct Corners {
    pub(super) counters: Buffer,
    pub(super) candidates: Buffer,
}

impl Corners {
    pub(super) fn new(device: &RenderDevice) -> Self {
        let candidates = u64::from(CANDIDATE_CAPACITY) * 16;
        Self {
            counters: buffer(
                device,
                "feature_counters",
                FEATURE_COUNTERS as u64 * 4,
                STORAGE,
            ),
            candidates: buffer(device, "candidates", candidates, STORAGE),
        }
    }
}

impl CapturePasses {
    /// Asks for all that this capture needs; says whether they are built.
    pub(super) fn are_ready(&mut self, cache: &PipelineCache, source: &CaptureSource) -> bool {
        let plain = Effects::default();
        let first = match source {
            CaptureSource::Scene => &mut self.scene,
            CaptureSource::Photo { .. } => &mut self.photo,
        };
        // Every one is asked for, so that they are built together.
        let mut is_ready = first.is_ready(cache, plain) & self.downsample.is_ready(cache, plain);
        for pass in &mut self.features {
            is_ready &= pass.is_ready(cache, plain);
        }
        is_ready
    }

    /// The picture and its mips.
    pub(super) fn take(&mut self, source: &Source, view: &ViewImages, recorder: &mut Recorder) {
        let plain = EffectInputs::default();
        let size = view.size;
        let pixels = pixel_groups(size.x, size.y, WORKGROUP);
        let finest = one_level(&view.colour, 0);
        let (uniform, luma) = (
            view.uniform.as_entire_binding(),
            view.luma.as_entire_binding(),
        );
        let vergence_view = &view.vergence_view;
        match *source {
            Source::Scene(colour, depth, _) => {
                let entries = BindGroupEntries::sequential((
                    uniform,
                    colour,
                    depth,
                    &finest,
                    vergence_view,
                    luma,
                ));
                self.scene.run(recorder, &plain, &entries, pixels);
            }
            Source::Photo(colour, vergence, numbers) => {
                let place = recorder
                    .device
                    .create_buffer_with_data(&BufferInitDescriptor {
                        label: Some("photograph"),
                        contents: bytemuck::bytes_of(&numbers),
                        usage: BufferUsages::UNIFORM,
                    });
                let entries = BindGroupEntries::sequential((
                    uniform,
                    colour,
                    vergence,
                    &finest,
                    vergence_view,
                    luma,
                    place.as_entire_binding(),
                ));
                self.photo.run(recorder, &plain, &entries, pixels);
            }
        }
        self.fill_mips(&view.colour, recorder);
        recorder.ledger.view_captures(1);
    }

    /// All levels of a texture from its first.
    pub(super) fn fill_mips(&mut self, texture: &Texture, recorder: &mut Recorder) {
        let size = UVec2::new(texture.width(), texture.height());
        for level in 1..texture.mip_level_count() {
            let (finer, coarser) = (one_level(texture, level - 1), one_level(texture, level));
            let entries = BindGroupEntries::sequential((&finer, &coarser));
            let texels = size.map(|side| (side >> level).max(1));
            let groups = pixel_groups(texels.x, texels.y, WORKGROUP);
            self.downsample
                .run(recorder, &EffectInputs::default(), &entries, groups);
        }
    }

    /// The corners of what was taken.
    pub(super) fn find_corners(
        &mut self,
        view: &ViewImages,
        corners: &Corners,
        queue: &RenderQueue,
        recorder: &mut Recorder,
    ) {
        queue.write_buffer(&corners.counters, 0, &[0; FEATURE_COUNTERS * 4]);
        let entries = BindGroupEntries::sequential((
            view.uniform.as_entire_binding(),
            view.luma.as_entire_binding(),
            view.strengths.as_entire_binding(),
            corners.counters.as_entire_binding(),
            corners.candidates.as_entire_binding(),
            &view.vergence_view,
        ));
        let groups = pixel_groups(view.size.x, view.size.y, WORKGROUP);
        for pass in &mut self.features {
            pass.run(recorder, &EffectInputs::default(), &entries, groups);
        }
        recorder.ledger.feature_passes(1);
    }
}
