//! What every pass of the views is: a shader with the layout of what it reads and writes, a pipeline for
//! each form of it, and how it is recorded.
//!
//! The places of a layout are counted as they are listed, as the bindings in the pass's WGSL are; numbers
//! stand there alone. A pass for an eye that has lost some of its field is another pipeline than one for
//! an eye that has not: the healthy one holds none of the other's code, and the other is built only where
//! it is needed. What such a form reads in addition has a group of its own.

use super::gpu_data::{MediaUniform, PerceptUniform};
use crate::frame::ledger::WorkLedger;
use bevy::asset::Handle;
use bevy::render::render_resource::binding_types::{texture_2d, uniform_buffer_sized};
use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
    BindGroupLayoutEntry, BindGroupLayoutEntryBuilder, Buffer, CachedComputePipelineId,
    CachedRenderPipelineId, ColorTargetState, ColorWrites, CommandEncoder, ComputePassDescriptor,
    ComputePipelineDescriptor, FragmentState, PipelineCache, RenderPassDescriptor, RenderPipeline,
    RenderPipelineDescriptor, Sampler, ShaderStages, SpecializedComputePipeline,
    SpecializedComputePipelines, SpecializedRenderPipeline, SpecializedRenderPipelines,
    TextureFormat, TextureSampleType, TextureView, VertexState,
};
use bevy::render::renderer::RenderDevice;
use bevy::shader::{Shader, ShaderDefVal};
use std::borrow::Cow;
use std::num::NonZeroU64;

/// What an eye has that a healthy one has not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Effects {
    /// Some of the visual field is lost.
    pub(super) field_loss: bool,
    /// The media scatter or colour the light.
    pub(super) media: bool,
    /// Blur has a direction.
    pub(super) astigmatism: bool,
}

impl Effects {
    /// Those that are in both.
    fn and(self, other: Self) -> Self {
        Self {
            field_loss: self.field_loss && other.field_loss,
            media: self.media && other.media,
            astigmatism: self.astigmatism && other.astigmatism,
        }
    }

    /// What the shader is told: its effects, and in which group each has what it reads.
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let present = [(self.field_loss, "FIELD_LOSS"), (self.media, "MEDIA")]
            .into_iter()
            .filter(|(has, _)| *has);
        (1u32..)
            .zip(present)
            .flat_map(|(group, (_, name))| {
                [
                    name.into(),
                    ShaderDefVal::UInt(format!("{name}_GROUP"), group),
                ]
            })
            .chain(self.astigmatism.then(|| "ASTIGMATISM".into()))
            .collect()
    }

    /// The layouts of the effects' groups, in their order.
    fn layouts(self, stage: ShaderStages) -> Vec<BindGroupLayoutDescriptor> {
        let texture = || texture_2d(TextureSampleType::Float { filterable: true });
        let mut layouts = Vec::new();
        if self.field_loss {
            let field = texture_2d(TextureSampleType::Float { filterable: false });
            layouts.push(BindGroupLayoutDescriptor::new(
                "field_loss",
                &BindGroupLayoutEntries::sequential(stage, (field,)),
            ));
        }
        if self.media {
            layouts.push(BindGroupLayoutDescriptor::new(
                "media",
                &BindGroupLayoutEntries::sequential(stage, (texture(), numbers::<MediaUniform>())),
            ));
        }
        layouts
    }
}

/// What the effects of a view read: the map of its field; the veil over it, and the numbers of that. Blur that
/// has a direction reads nothing more.
#[derive(Clone, Copy, Default)]
pub(super) struct EffectInputs<'a> {
    pub(super) field: Option<&'a TextureView>,
    pub(super) media: Option<(&'a TextureView, &'a Buffer)>,
    pub(super) astigmatism: bool,
}

impl EffectInputs<'_> {
    fn effects(&self) -> Effects {
        Effects {
            field_loss: self.field.is_some(),
            media: self.media.is_some(),
            astigmatism: self.astigmatism,
        }
    }

    /// The groups of these effects, in the order of [`Effects::layouts`].
    fn groups(&self, of: Effects, stage: ShaderStages, recorder: &Recorder) -> Vec<BindGroup> {
        let layouts = of.layouts(stage);
        let mut layouts = layouts.iter();
        let mut groups = Vec::new();
        if let (true, Some(field)) = (of.field_loss, self.field)
            && let Some(layout) = layouts.next()
        {
            groups.push(recorder.bind(layout, &BindGroupEntries::sequential((field,))));
        }
        if let (true, Some((veil, numbers))) = (of.media, self.media)
            && let Some(layout) = layouts.next()
        {
            let entries = BindGroupEntries::sequential((veil, numbers.as_entire_binding()));
            groups.push(recorder.bind(layout, &entries));
        }
        groups
    }
}

/// A uniform buffer that holds one `N`.
pub(super) fn numbers<N>() -> BindGroupLayoutEntryBuilder {
    uniform_buffer_sized(false, NonZeroU64::new(size_of::<N>() as u64))
}

/// The numbers that every pass of a view reads.
pub(super) fn view_numbers() -> BindGroupLayoutEntryBuilder {
    numbers::<PerceptUniform>()
}

/// What every pass is recorded with.
pub(super) struct Recorder<'a> {
    pub(super) encoder: &'a mut CommandEncoder,
    pub(super) device: &'a RenderDevice,
    pub(super) cache: &'a PipelineCache,
    pub(super) ledger: &'a WorkLedger,
    pub(super) sampler: &'a Sampler,
}

impl Recorder<'_> {
    fn bind(&self, layout: &BindGroupLayoutDescriptor, entries: &[BindGroupEntry]) -> BindGroup {
        let layout = self.cache.get_bind_group_layout(layout);
        self.device.create_bind_group(None, &layout, entries)
    }
}

/// A shader's entry point, and what stands in its first group.
struct Program {
    name: &'static str,
    shader: Handle<Shader>,
    layout: BindGroupLayoutDescriptor,
    /// The effects for which it has another form.
    knows: Effects,
    stage: ShaderStages,
}

impl Program {
    fn new(
        name: &'static str,
        shader: Handle<Shader>,
        knows: Effects,
        layout: &[BindGroupLayoutEntry],
        stage: ShaderStages,
    ) -> Self {
        Self {
            name,
            shader,
            layout: BindGroupLayoutDescriptor::new(name, layout),
            knows,
            stage,
        }
    }

    /// Its own group, and those of the effects that it knows.
    fn bind(
        &self,
        recorder: &Recorder,
        inputs: &EffectInputs,
        entries: &[BindGroupEntry],
    ) -> Vec<BindGroup> {
        let mut groups = vec![recorder.bind(&self.layout, entries)];
        groups.extend(inputs.groups(inputs.effects().and(self.knows), self.stage, recorder));
        groups
    }

    fn layouts(&self, effects: Effects) -> Vec<BindGroupLayoutDescriptor> {
        let mut layouts = vec![self.layout.clone()];
        layouts.extend(effects.layouts(self.stage));
        layouts
    }
}

/// A compute pass.
pub(super) struct ComputePass {
    program: Program,
    forms: SpecializedComputePipelines<Program>,
}

impl SpecializedComputePipeline for Program {
    type Key = Effects;

    fn specialize(&self, effects: Effects) -> ComputePipelineDescriptor {
        ComputePipelineDescriptor {
            label: Some(Cow::Borrowed(self.name)),
            layout: self.layouts(effects),
            shader: self.shader.clone(),
            shader_defs: effects.shader_defs(),
            entry_point: Some(Cow::Borrowed(self.name)),
            zero_initialize_workgroup_memory: true,
            ..ComputePipelineDescriptor::default()
        }
    }
}

impl ComputePass {
    /// The pass of this entry point; the layout is listed in the order of its bindings.
    pub(super) fn new(
        name: &'static str,
        shader: Handle<Shader>,
        knows: Effects,
        layout: &[BindGroupLayoutEntry],
    ) -> Self {
        Self {
            program: Program::new(name, shader, knows, layout, ShaderStages::COMPUTE),
            forms: SpecializedComputePipelines::default(),
        }
    }

    fn form(&mut self, cache: &PipelineCache, effects: Effects) -> CachedComputePipelineId {
        let key = effects.and(self.program.knows);
        self.forms.specialize(cache, &self.program, key)
    }

    /// Asks for the form for these effects; says whether it is built.
    pub(super) fn is_ready(&mut self, cache: &PipelineCache, effects: Effects) -> bool {
        let id = self.form(cache, effects);
        cache.get_compute_pipeline(id).is_some()
    }

    /// Records it over these groups of invocations; says whether its pipeline was there.
    pub(super) fn run(
        &mut self,
        recorder: &mut Recorder,
        inputs: &EffectInputs,
        entries: &[BindGroupEntry],
        groups: [u32; 2],
    ) -> bool {
        let id = self.form(recorder.cache, inputs.effects());
        let Some(pipeline) = recorder.cache.get_compute_pipeline(id) else {
            return false;
        };
        let bound_groups = self.program.bind(recorder, inputs, entries);
        let mut pass = recorder
            .encoder
            .begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        for (group, bound) in (0u32..).zip(&bound_groups) {
            pass.set_bind_group(group, bound, &[]);
        }
        pass.dispatch_workgroups(groups[0], groups[1], 1);
        true
    }
}

/// A pass that draws over a whole target: the vertex entry point `fullscreen` and a fragment's.
pub(super) struct DrawPass {
    program: DrawProgram,
    forms: SpecializedRenderPipelines<DrawProgram>,
}

/// [`Program`], of a pass that draws.
struct DrawProgram(Program);

impl SpecializedRenderPipeline for DrawProgram {
    type Key = (Effects, TextureFormat);

    fn specialize(&self, (effects, format): Self::Key) -> RenderPipelineDescriptor {
        let program = &self.0;
        RenderPipelineDescriptor {
            label: Some(Cow::Borrowed(program.name)),
            layout: program.layouts(effects),
            vertex: VertexState {
                shader: program.shader.clone(),
                shader_defs: effects.shader_defs(),
                entry_point: Some("fullscreen".into()),
                buffers: Vec::new(),
            },
            fragment: Some(FragmentState {
                shader: program.shader.clone(),
                shader_defs: effects.shader_defs(),
                entry_point: Some(Cow::Borrowed(program.name)),
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
            }),
            ..RenderPipelineDescriptor::default()
        }
    }
}

impl DrawPass {
    /// The pass of this entry point; the layout is listed in the order of its bindings.
    pub(super) fn new(
        name: &'static str,
        shader: Handle<Shader>,
        knows: Effects,
        layout: &[BindGroupLayoutEntry],
    ) -> Self {
        Self {
            program: DrawProgram(Program::new(
                name,
                shader,
                knows,
                layout,
                ShaderStages::FRAGMENT,
            )),
            forms: SpecializedRenderPipelines::default(),
        }
    }

    fn form(
        &mut self,
        cache: &PipelineCache,
        key: (Effects, TextureFormat),
    ) -> CachedRenderPipelineId {
        let key = (key.0.and(self.program.0.knows), key.1);
        self.forms.specialize(cache, &self.program, key)
    }

    /// Asks for the form for these effects and a target of this format; says whether it is built.
    pub(super) fn is_ready(
        &mut self,
        cache: &PipelineCache,
        effects: Effects,
        format: TextureFormat,
    ) -> bool {
        let id = self.form(cache, (effects, format));
        cache.get_render_pipeline(id).is_some()
    }

    /// Records it; says whether its pipeline was there.
    pub(super) fn draw(
        &mut self,
        recorder: &mut Recorder,
        inputs: &EffectInputs,
        entries: &[BindGroupEntry],
        format: TextureFormat,
        target: &RenderPassDescriptor,
    ) -> bool {
        let id = self.form(recorder.cache, (inputs.effects(), format));
        let Some(pipeline): Option<&RenderPipeline> = recorder.cache.get_render_pipeline(id) else {
            return false;
        };
        let bound_groups = self.program.0.bind(recorder, inputs, entries);
        let mut pass = recorder.encoder.begin_render_pass(target);
        pass.set_pipeline(pipeline);
        for (group, bound) in (0u32..).zip(&bound_groups) {
            pass.set_bind_group(group, bound, &[]);
        }
        pass.draw(0..3, 0..1);
        true
    }
}
