//! The passes of the view as pipelines: layout, shader and entry point of each,
//! kept in step with `shaders/view/*.wgsl`.
//!
//! A pass for an eye that has lost some of its field is another pipeline than one for an eye that has
//! not: the healthy one holds none of the other's code, and the other is built only where it is needed.

use super::gpu_data::{MediaUniform, PerceptUniform};
use crate::frame::shaders;
use bevy::asset::Handle;
use bevy::platform::collections::HashMap;
use bevy::prelude::Resource;
use bevy::render::render_resource::{
    BindGroup, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingResource,
    BindingType, BufferBindingType, BufferSize, CachedComputePipelineId, CachedRenderPipelineId,
    ColorTargetState, ColorWrites, ComputePipeline, ComputePipelineDescriptor, FragmentState,
    PipelineCache, RenderPipeline, RenderPipelineDescriptor, SamplerBindingType, ShaderStages,
    StorageTextureAccess, TextureFormat, TextureSampleType, TextureViewDimension, VertexState,
};
use bevy::render::renderer::RenderDevice;
use bevy::shader::{Shader, ShaderDefVal};
use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

/// The passes of the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pass {
    /// Colour and depth of a scene become the static view.
    CaptureScene,
    /// A photograph with vergence becomes the static view.
    CapturePhoto,
    /// One level of the view's mip chain.
    Downsample,
    /// FAST strength of every pixel.
    FastStrength,
    /// Histogram of the corners' scores.
    CountCorners,
    /// List of the corners.
    AppendCorners,
    /// The voxel of every pixel.
    AssignSlots,
    /// What moved away is forgotten where it was.
    ForgetLeft,
    /// An old table into a larger one.
    GrowTable,
    /// Keys back to epoch 0, or forgotten.
    Rebase,
    /// One atomicMin a pixel.
    UpdateField,
    /// The blur to show, and the tiles' extremes.
    ReadBlur,
    /// The veil of clouded media.
    Veil,
    /// The picture.
    Present,
}

/// What an eye has that a healthy one has not. Each form of a pass is a pipeline of its own: the healthy
/// one holds none of the others' code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Effects {
    /// Some of the visual field is lost.
    pub field_loss: bool,
    /// The media scatter or colour the light.
    pub media: bool,
}

/// What is bound at a place.
#[derive(Clone, Copy)]
enum Slot {
    Uniform,
    Media,
    Texture { filterable: bool },
    Depth,
    StorageTexture(TextureFormat),
    Buffer { writable: bool },
    Sampler,
}

const TEXEL: Slot = Slot::Texture { filterable: false };
const WRITE: Slot = Slot::Buffer { writable: true };
const READ: Slot = Slot::Buffer { writable: false };

impl Pass {
    fn shader(self) -> Handle<Shader> {
        match self {
            Self::CaptureScene | Self::CapturePhoto | Self::Downsample => shaders::CAPTURE,
            Self::FastStrength | Self::CountCorners | Self::AppendCorners => shaders::FEATURES,
            Self::Present => shaders::GATHER,
            Self::Veil => shaders::VEIL,
            _ => shaders::FIELD,
        }
    }

    fn entry_point(self) -> &'static str {
        match self {
            Self::CaptureScene => "capture_scene",
            Self::CapturePhoto => "capture_photo",
            Self::Downsample => "downsample",
            Self::FastStrength => "fast_strength",
            Self::CountCorners => "count_corners",
            Self::AppendCorners => "append_corners",
            Self::AssignSlots => "assign_slots",
            Self::ForgetLeft => "forget_left",
            Self::GrowTable => "grow_table",
            Self::Rebase => "rebase",
            Self::UpdateField => "update_field",
            Self::ReadBlur => "read_blur",
            Self::Veil => "spread_veil",
            Self::Present => "present",
        }
    }

    /// Of these effects those for which this pass has another form.
    fn known(self, effects: Effects) -> Effects {
        let knows_field = matches!(self, Self::UpdateField | Self::ReadBlur | Self::Present);
        Effects {
            field_loss: effects.field_loss && knows_field,
            media: effects.media && self == Self::Present,
        }
    }

    fn slots(self, effects: Effects) -> Vec<(u32, Slot)> {
        let rgba = Slot::StorageTexture(TextureFormat::Rgba16Float);
        let mut slots = match self {
            Self::CaptureScene => vec![
                (0, Slot::Uniform),
                (1, TEXEL),
                (2, Slot::Depth),
                (4, rgba),
                (5, Slot::StorageTexture(TextureFormat::R32Float)),
                (6, WRITE),
            ],
            Self::CapturePhoto => vec![
                (0, Slot::Uniform),
                (1, TEXEL),
                (3, TEXEL),
                (4, rgba),
                (5, Slot::StorageTexture(TextureFormat::R32Float)),
                (6, WRITE),
            ],
            Self::Downsample => vec![(7, TEXEL), (8, rgba)],
            Self::FastStrength | Self::CountCorners | Self::AppendCorners => vec![
                (0, Slot::Uniform),
                (1, READ),
                (2, WRITE),
                (3, WRITE),
                (4, WRITE),
                (5, TEXEL),
            ],
            Self::AssignSlots => vec![
                (0, Slot::Uniform),
                (1, TEXEL),
                (2, WRITE),
                (3, WRITE),
                (4, WRITE),
                (5, WRITE),
                (6, WRITE),
                (13, READ),
            ],
            Self::ForgetLeft => vec![
                (0, Slot::Uniform),
                (1, TEXEL),
                (3, WRITE),
                (5, WRITE),
                (13, READ),
            ],
            Self::GrowTable => vec![
                (0, Slot::Uniform),
                (3, WRITE),
                (4, WRITE),
                (5, WRITE),
                (6, WRITE),
                (9, READ),
                (10, READ),
                (11, READ),
            ],
            Self::Rebase => vec![(0, Slot::Uniform), (5, WRITE)],
            Self::UpdateField => vec![(0, Slot::Uniform), (1, TEXEL), (2, WRITE), (5, WRITE)],
            Self::ReadBlur => vec![
                (0, Slot::Uniform),
                (1, TEXEL),
                (2, WRITE),
                (5, WRITE),
                (7, WRITE),
                (8, WRITE),
            ],
            Self::Veil => vec![
                (0, Slot::Uniform),
                (1, Slot::Texture { filterable: true }),
                (2, Slot::Sampler),
                (3, Slot::Media),
                (4, rgba),
            ],
            Self::Present => vec![
                (0, Slot::Uniform),
                (1, Slot::Texture { filterable: true }),
                (2, Slot::Sampler),
                (3, READ),
                (4, READ),
            ],
        };
        if effects.field_loss {
            slots.push((if self == Self::Present { 5 } else { 12 }, TEXEL));
        }
        if effects.media {
            slots.extend([(6, Slot::Texture { filterable: true }), (7, Slot::Media)]);
        }
        slots
    }

    fn layout(self, effects: Effects) -> BindGroupLayoutDescriptor {
        let visibility = if self == Self::Present {
            ShaderStages::FRAGMENT
        } else {
            ShaderStages::COMPUTE
        };
        let entries: Vec<BindGroupLayoutEntry> = self
            .slots(effects)
            .into_iter()
            .map(|(binding, slot)| BindGroupLayoutEntry {
                binding,
                visibility,
                ty: slot.binding_type(),
                count: None,
            })
            .collect();
        BindGroupLayoutDescriptor::new(self.entry_point(), &entries)
    }
}

impl Slot {
    fn binding_type(self) -> BindingType {
        let texture = |sample_type| BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let uniform = |bytes: usize| BindingType::Buffer {
            ty: BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: BufferSize::new(bytes as u64),
        };
        match self {
            Self::Uniform => uniform(size_of::<PerceptUniform>()),
            Self::Media => uniform(size_of::<MediaUniform>()),
            Self::Texture { filterable } => texture(TextureSampleType::Float { filterable }),
            Self::Depth => texture(TextureSampleType::Depth),
            Self::StorageTexture(format) => BindingType::StorageTexture {
                access: StorageTextureAccess::WriteOnly,
                format,
                view_dimension: TextureViewDimension::D2,
            },
            Self::Buffer { writable } => BindingType::Buffer {
                ty: BufferBindingType::Storage {
                    read_only: !writable,
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            Self::Sampler => BindingType::Sampler(SamplerBindingType::Filtering),
        }
    }
}

#[derive(Clone, Copy)]
enum Id {
    Compute(CachedComputePipelineId),
    Render(CachedRenderPipelineId),
}

struct Queued {
    layout: BindGroupLayoutDescriptor,
    id: Id,
}

/// A pass, its form, and the format that `present` draws.
type Key = (Pass, Effects, TextureFormat);

/// The pipelines that were asked for so far.
#[derive(Resource, Default)]
pub struct Pipelines(Mutex<HashMap<Key, Queued>>);

/// One key for each form that there is.
fn key_of(pass: Pass, effects: Effects, format: TextureFormat) -> Key {
    let format = match pass {
        Pass::Present => format,
        _ => TextureFormat::Rgba8UnormSrgb,
    };
    (pass, pass.known(effects), format)
}

impl Pipelines {
    /// Which passes exist, and in which form.
    pub fn keys(&self) -> Vec<(Pass, Effects)> {
        let queued = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        queued
            .keys()
            .map(|(pass, effects, _)| (*pass, *effects))
            .collect()
    }

    /// Asks for a pass, so that it is built before it is needed.
    fn get(&self, cache: &PipelineCache, key: Key) -> (BindGroupLayoutDescriptor, Id) {
        let mut queued = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = queued.entry(key).or_insert_with(|| queue(cache, key));
        (found.layout.clone(), found.id)
    }

    /// The compute pipeline of a pass once it is built, with these resources bound.
    pub fn compute<'a>(
        &self,
        device: &RenderDevice,
        cache: &'a PipelineCache,
        pass: Pass,
        effects: Effects,
        bound: &[(u32, BindingResource<'_>)],
    ) -> Option<(&'a ComputePipeline, BindGroup)> {
        let key = key_of(pass, effects, TextureFormat::Rgba8UnormSrgb);
        let (layout, id) = self.get(cache, key);
        let Id::Compute(id) = id else { return None };
        Some((
            cache.get_compute_pipeline(id)?,
            bind(device, cache, &layout, bound),
        ))
    }

    /// The picture's pipeline for a target of this format once it is built, with these resources bound.
    pub fn present<'a>(
        &self,
        device: &RenderDevice,
        cache: &'a PipelineCache,
        effects: Effects,
        format: TextureFormat,
        bound: &[(u32, BindingResource<'_>)],
    ) -> Option<(&'a RenderPipeline, BindGroup)> {
        let (layout, id) = self.get(cache, key_of(Pass::Present, effects, format));
        let Id::Render(id) = id else { return None };
        Some((
            cache.get_render_pipeline(id)?,
            bind(device, cache, &layout, bound),
        ))
    }

    /// Are these passes all built?
    pub fn are_ready(
        &self,
        cache: &PipelineCache,
        passes: &[Pass],
        effects: Effects,
        format: TextureFormat,
    ) -> bool {
        // Every one is asked for, so that they are built together.
        let missing =
            passes.iter().filter(
                |&&pass| match self.get(cache, key_of(pass, effects, format)).1 {
                    Id::Compute(id) => cache.get_compute_pipeline(id).is_none(),
                    Id::Render(id) => cache.get_render_pipeline(id).is_none(),
                },
            );
        missing.count() == 0
    }
}

fn bind(
    device: &RenderDevice,
    cache: &PipelineCache,
    layout: &BindGroupLayoutDescriptor,
    bound: &[(u32, BindingResource<'_>)],
) -> BindGroup {
    let entries: Vec<BindGroupEntry<'_>> = bound
        .iter()
        .map(|(binding, resource)| BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect();
    device.create_bind_group(None, &cache.get_bind_group_layout(layout), &entries)
}

fn queue(cache: &PipelineCache, (pass, effects, format): Key) -> Queued {
    let layout = pass.layout(effects);
    let shader_defs: Vec<ShaderDefVal> =
        [(effects.field_loss, "FIELD_LOSS"), (effects.media, "MEDIA")]
            .into_iter()
            .filter(|(has, _)| *has)
            .map(|(_, name)| name.into())
            .collect();
    let label = Some(Cow::Borrowed(pass.entry_point()));
    let entry_point = Some(Cow::Borrowed(pass.entry_point()));
    let id = if pass == Pass::Present {
        Id::Render(cache.queue_render_pipeline(RenderPipelineDescriptor {
            label,
            layout: vec![layout.clone()],
            vertex: VertexState {
                shader: pass.shader(),
                shader_defs: shader_defs.clone(),
                entry_point: Some("fullscreen".into()),
                buffers: Vec::new(),
            },
            fragment: Some(FragmentState {
                shader: pass.shader(),
                shader_defs,
                entry_point,
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
            }),
            ..RenderPipelineDescriptor::default()
        }))
    } else {
        Id::Compute(cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label,
            layout: vec![layout.clone()],
            shader: pass.shader(),
            shader_defs,
            entry_point,
            zero_initialize_workgroup_memory: true,
            ..ComputePipelineDescriptor::default()
        }))
    };
    Queued { layout, id }
}
