//! The view's passes in the render world.
//!
//! Enters: [`PerceptFrame`], extracted once a frame, and, in the frame of a
//! capture, the scene camera's colour and depth. Leaves: the view's panel, and,
//! once a capture, the list of corners and the map of vergence for the CPU.

use super::frame::{CaptureSource, PerceptFrame, PerceptReturn, SceneCamera};
use super::gpu_data::{
    CANDIDATE_CAPACITY, FEATURE_COUNTERS, FORGET, PerceptUniform, TILE, WORKGROUP, mip_levels,
    pixel_groups, slot_groups,
};
use super::pipelines::{Pass, Pipelines};
use super::readback::{Readback, Staging};
use super::resources::{PerceptGpu, STORAGE, View, buffer, make_room, table_is_new};
use crate::ledger::WorkLedger;
use bevy::core_pipeline::schedule::camera_driver;
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::extract_resource::ExtractResourcePlugin;
use bevy::render::render_asset::{RenderAssets, prepare_assets};
use bevy::render::render_resource::BindingResource::{
    self, Sampler as BindSampler, TextureView as BindView,
};
use bevy::render::render_resource::{
    AddressMode, BufferUsages, CommandEncoder, ComputePassDescriptor, Extent3d, FilterMode, LoadOp,
    MipmapFilterMode, Operations, PipelineCache, RenderPassColorAttachment, RenderPassDescriptor,
    SamplerDescriptor, StoreOp, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
    TextureViewDescriptor,
};
use bevy::render::renderer::{RenderContext, RenderDevice, RenderGraph, RenderQueue, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::{ViewDepthTexture, ViewTarget};
use bevy::render::{Render, RenderApp, RenderSystems};

/// What a healthy frame needs, and what a capture needs.
const FRAME_PASSES: &[Pass] = &[
    Pass::UpdateField,
    Pass::ReadBlur,
    Pass::Present,
    Pass::Rebase,
];
const CAPTURE_PASSES: &[Pass] = &[
    Pass::Downsample,
    Pass::FastStrength,
    Pass::CountCorners,
    Pass::AppendCorners,
    Pass::AssignSlots,
    Pass::Rebase,
];

/// Adds the passes to the render world.
pub fn build_render(app: &mut App, returned: PerceptReturn) {
    app.add_plugins(ExtractResourcePlugin::<PerceptFrame>::default());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .insert_resource(returned)
        .init_resource::<PerceptGpu>()
        .init_resource::<Pipelines>()
        .init_resource::<Readback>()
        .add_systems(
            Render,
            (
                prepare
                    .in_set(RenderSystems::Prepare)
                    .after(prepare_assets::<GpuImage>),
                collect.in_set(RenderSystems::Cleanup),
            ),
        )
        .add_systems(RenderGraph, draw_view.before(camera_driver))
        .add_systems(Core3d, capture_scene.in_set(Core3dSystems::PostProcess));
}

/// Makes the lasting resources, uploads the uniform and, for a patient with glaucoma, the field.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn prepare(
    frame: Option<Res<PerceptFrame>>,
    mut gpu: ResMut<PerceptGpu>,
    images: Res<RenderAssets<GpuImage>>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
) {
    let Some(frame) = frame else { return };
    if !frame.visible {
        return;
    }
    pipelines.are_ready(&cache, FRAME_PASSES, frame.glaucoma.is_some());
    if gpu.sampler.is_none() {
        gpu.sampler = Some(device.create_sampler(&SamplerDescriptor {
            label: Some("view_sampler"),
            address_mode_u: AddressMode::ClampToEdge,
            address_mode_v: AddressMode::ClampToEdge,
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            mipmap_filter: MipmapFilterMode::Nearest,
            ..SamplerDescriptor::default()
        }));
        gpu.uniform = Some(buffer(
            &device,
            "percept",
            size_of::<PerceptUniform>() as u64,
            BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        ));
        gpu.feature_counters = Some(buffer(
            &device,
            "feature_counters",
            FEATURE_COUNTERS as u64 * 4,
            STORAGE,
        ));
        gpu.candidates = Some(buffer(
            &device,
            "candidates",
            u64::from(CANDIDATE_CAPACITY) * 16,
            STORAGE,
        ));
    }
    if let Some(field) = &frame.glaucoma
        && gpu
            .field
            .as_ref()
            .is_none_or(|(version, _)| *version != field.version)
    {
        let texture = device.create_texture_with_data(
            &queue,
            &TextureDescriptor {
                label: Some("visual_field"),
                size: Extent3d {
                    width: field.side,
                    height: field.side,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TextureFormat::R32Float,
                usage: TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            bevy::render::render_resource::TextureDataOrder::default(),
            bytemuck::cast_slice(&field.seen),
        );
        ledger.bytes_uploaded(field.seen.len() as u64 * 4);
        gpu.field = Some((
            field.version,
            texture.create_view(&TextureViewDescriptor::default()),
        ));
    }
    if frame.glaucoma.is_none() {
        gpu.field = None;
    }
    // Whoever lays out the window may have given the panel another size after the frame's numbers were
    // made; its new image is empty.
    let target = images.get(&frame.target).map_or(UVec2::ZERO, |target| {
        let size = target.texture_descriptor.size;
        UVec2::new(size.width, size.height)
    });
    gpu.target = target;
    gpu.present = frame.present || (gpu.presented != UVec2::ZERO && gpu.presented != target);
    if frame.capture.is_some() || frame.update || gpu.present {
        let mut uniform = frame.uniform;
        uniform.slot_mask = gpu.table.as_ref().map_or(0, |table| table.slots - 1);
        uniform.target_size = target.as_vec2().to_array();
        if let Some(buffer) = &gpu.uniform {
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&uniform));
            ledger.bytes_uploaded(size_of::<PerceptUniform>() as u64);
        }
    }
}

/// What every pass is recorded with.
struct Recorder<'a> {
    encoder: &'a mut CommandEncoder,
    device: &'a RenderDevice,
    cache: &'a PipelineCache,
    pipelines: &'a Pipelines,
}

impl Recorder<'_> {
    /// Runs one compute pass; says whether its pipeline was there.
    fn run(&mut self, pass: Pass, glaucoma: bool, bound: &[Bound<'_>], groups: [u32; 2]) -> bool {
        let found = self
            .pipelines
            .compute(self.device, self.cache, pass, glaucoma, bound);
        let Some((pipeline, bindings)) = found else {
            return false;
        };
        let mut compute = self
            .encoder
            .begin_compute_pass(&ComputePassDescriptor::default());
        compute.set_pipeline(pipeline);
        compute.set_bind_group(0, &bindings, &[]);
        compute.dispatch_workgroups(groups[0], groups[1], 1);
        true
    }
}

/// A resource at a binding.
type Bound<'a> = (u32, BindingResource<'a>);

/// After the scene camera has drawn: its colour and depth become the static view.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn capture_scene(
    view: ViewQuery<(&ViewTarget, &ViewDepthTexture, &SceneCamera)>,
    frame: Option<Res<PerceptFrame>>,
    returned: Res<PerceptReturn>,
    mut gpu: ResMut<PerceptGpu>,
    mut readback: ResMut<Readback>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
    mut ctx: RenderContext,
) {
    let (target, depth, _) = view.into_inner();
    ledger.scene_passes(1);
    let Some(frame) = frame else { return };
    let Some(request) = frame.capture.as_ref() else {
        return;
    };
    if !matches!(request.source, CaptureSource::Scene) || request.serial == gpu.captured {
        return;
    }
    let device = ctx.render_device().clone();
    let source = [
        (1, BindView(target.main_texture_view())),
        (2, BindView(depth.view())),
    ];
    let mut recorder = Recorder {
        encoder: ctx.command_encoder(),
        device: &device,
        cache: &cache,
        pipelines: &pipelines,
    };
    let gpu = &mut *gpu;
    if capture(
        &frame,
        gpu,
        &mut readback,
        &queue,
        &mut recorder,
        Pass::CaptureScene,
        &source,
    ) {
        returned.note_recorded(request.serial);
        ledger.view_captures(1);
        ledger.feature_passes(1);
    }
}

/// Everything that a new view needs once: capture, mips, corners, slots, and the copies for the CPU.
/// Says whether it was recorded.
fn capture(
    frame: &PerceptFrame,
    gpu: &mut PerceptGpu,
    readback: &mut Readback,
    queue: &RenderQueue,
    recorder: &mut Recorder<'_>,
    pass: Pass,
    source: &[Bound<'_>],
) -> bool {
    let Some(request) = frame.capture.as_ref() else {
        return false;
    };
    let needed: Vec<Pass> = CAPTURE_PASSES
        .iter()
        .copied()
        .chain([pass, Pass::GrowTable])
        .collect();
    if readback.busy() || !recorder.pipelines.are_ready(recorder.cache, &needed, false) {
        return false;
    }
    let size = UVec2::from(frame.uniform.size);
    let view = View::new(recorder.device, size);
    let old = make_room(gpu, recorder.device, size, request.forget);
    let (Some(uniform), Some(counters), Some(candidates), Some(table)) = (
        &gpu.uniform,
        &gpu.feature_counters,
        &gpu.candidates,
        &gpu.table,
    ) else {
        return false;
    };
    let mut data = frame.uniform;
    data.slot_mask = table.slots - 1;
    data.rebase_steps = FORGET;
    data.table_slots_old = old.as_ref().map_or(0, |old| old.slots);
    queue.write_buffer(uniform, 0, bytemuck::bytes_of(&data));

    let mut run = |pass, bound: &[Bound<'_>], groups| recorder.run(pass, false, bound, groups);
    let pixels = pixel_groups(size.x, size.y, WORKGROUP);
    let first = view.level(0);
    let mut bound = vec![
        (0, uniform.as_entire_binding()),
        (4, BindView(&first)),
        (5, BindView(&view.vergence_view)),
        (6, view.luma.as_entire_binding()),
    ];
    bound.extend(source.iter().cloned());
    run(pass, &bound, pixels);
    for level in 1..mip_levels(size.x, size.y) {
        let (finer, coarser) = (view.level(level - 1), view.level(level));
        let groups = pixel_groups(
            (size.x >> level).max(1),
            (size.y >> level).max(1),
            WORKGROUP,
        );
        run(
            Pass::Downsample,
            &[(7, BindView(&finer)), (8, BindView(&coarser))],
            groups,
        );
    }
    queue.write_buffer(counters, 0, &[0; FEATURE_COUNTERS * 4]);
    let bound = [
        (0, uniform.as_entire_binding()),
        (1, view.luma.as_entire_binding()),
        (2, view.strengths.as_entire_binding()),
        (3, counters.as_entire_binding()),
        (4, candidates.as_entire_binding()),
        (5, BindView(&view.vergence_view)),
    ];
    for pass in [Pass::FastStrength, Pass::CountCorners, Pass::AppendCorners] {
        run(pass, &bound, pixels);
    }
    if old.is_some() || request.forget || table_is_new(gpu) {
        let keys = [
            (0, uniform.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
        ];
        run(Pass::Rebase, &keys, slot_groups(table.slots));
    }
    if let Some(old) = &old {
        let bound = [
            (0, uniform.as_entire_binding()),
            (3, table.tag.as_entire_binding()),
            (4, table.home.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
            (6, table.counters.as_entire_binding()),
            (9, old.tag.as_entire_binding()),
            (10, old.home.as_entire_binding()),
            (11, old.keys.as_entire_binding()),
        ];
        run(Pass::GrowTable, &bound, slot_groups(old.slots));
    }
    let bound = [
        (0, uniform.as_entire_binding()),
        (1, BindView(&view.vergence_view)),
        (2, view.pixel_slot.as_entire_binding()),
        (3, table.tag.as_entire_binding()),
        (4, table.home.as_entire_binding()),
        (6, table.counters.as_entire_binding()),
    ];
    run(Pass::AssignSlots, &bound, pixels);

    readback.start(Staging::copy(
        recorder.device,
        recorder.encoder,
        request.serial,
        size,
        counters,
        candidates,
        &table.counters,
        &view.vergence,
    ));
    gpu.captured = request.serial;
    gpu.view = Some(view);
    true
}

/// The frame's own work: photograph capture, field update, picture.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn draw_view(
    frame: Option<Res<PerceptFrame>>,
    returned: Res<PerceptReturn>,
    mut gpu: ResMut<PerceptGpu>,
    mut readback: ResMut<Readback>,
    images: Res<RenderAssets<GpuImage>>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
    mut ctx: RenderContext,
) {
    let Some(frame) = frame else { return };
    if !frame.visible {
        return;
    }
    let device = ctx.render_device().clone();
    if let Some(request) = &frame.capture
        && let CaptureSource::Photo { colour, vergence } = &request.source
        && request.serial != gpu.captured
        && let (Some(colour), Some(vergence)) = (images.get(colour), images.get(vergence))
    {
        let source = [
            (1, BindView(&colour.texture_view)),
            (3, BindView(&vergence.texture_view)),
        ];
        let mut recorder = Recorder {
            encoder: ctx.command_encoder(),
            device: &device,
            cache: &cache,
            pipelines: &pipelines,
        };
        let gpu = &mut *gpu;
        if capture(
            &frame,
            gpu,
            &mut readback,
            &queue,
            &mut recorder,
            Pass::CapturePhoto,
            &source,
        ) {
            returned.note_recorded(request.serial);
            ledger.view_captures(1);
            ledger.feature_passes(1);
        }
        // The uniform was the capture's; the picture comes with the next frame.
        return;
    }
    let mut recorder = Recorder {
        encoder: ctx.command_encoder(),
        device: &device,
        cache: &cache,
        pipelines: &pipelines,
    };
    if show(&frame, &gpu, &images, &ledger, &mut recorder) {
        gpu.presented = gpu.target;
    }
}

/// Field update and picture of one frame; says whether the picture was drawn.
fn show(
    frame: &PerceptFrame,
    gpu: &PerceptGpu,
    images: &RenderAssets<GpuImage>,
    ledger: &WorkLedger,
    recorder: &mut Recorder<'_>,
) -> bool {
    let glaucoma = frame.glaucoma.is_some();
    let (Some(view), Some(table), Some(uniform), Some(sampler), Some(target)) = (
        &gpu.view,
        &gpu.table,
        &gpu.uniform,
        &gpu.sampler,
        images.get(&frame.target),
    ) else {
        return false;
    };
    let field = gpu.field.as_ref().map(|(_, view)| view);
    if view.size != UVec2::from(frame.uniform.size) || glaucoma != field.is_some() {
        return false;
    }
    let pixels = u64::from(view.size.x) * u64::from(view.size.y);
    let field_at = |at| field.map(|field| (at, BindView(field)));
    if frame.uniform.rebase_steps != FORGET || frame.forget {
        let bound = [
            (0, uniform.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
        ];
        recorder.run(Pass::Rebase, false, &bound, slot_groups(table.slots));
    }
    if frame.update {
        let mut bound = vec![
            (0, uniform.as_entire_binding()),
            (1, BindView(&view.vergence_view)),
            (2, view.pixel_slot.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
        ];
        bound.extend(field_at(12));
        let groups = pixel_groups(view.size.x, view.size.y, WORKGROUP);
        if recorder.run(Pass::UpdateField, glaucoma, &bound, groups) {
            ledger.field_updates(1);
            ledger.field_pixels(pixels);
        }
    }
    if !gpu.present {
        return false;
    }
    let mut bound = vec![
        (0, uniform.as_entire_binding()),
        (1, BindView(&view.vergence_view)),
        (2, view.pixel_slot.as_entire_binding()),
        (5, table.keys.as_entire_binding()),
        (7, view.blur_px.as_entire_binding()),
        (8, view.tile_near.as_entire_binding()),
    ];
    bound.extend(field_at(12));
    recorder.run(
        Pass::ReadBlur,
        glaucoma,
        &bound,
        pixel_groups(view.size.x, view.size.y, TILE),
    );
    let mut bound = vec![
        (0, uniform.as_entire_binding()),
        (1, BindView(&view.colour_view)),
        (2, BindSampler(sampler)),
        (3, view.blur_px.as_entire_binding()),
        (4, view.tile_near.as_entire_binding()),
    ];
    bound.extend(field_at(5));
    let found = recorder
        .pipelines
        .present(recorder.device, recorder.cache, glaucoma, &bound);
    let Some((pipeline, bindings)) = found else {
        return false;
    };
    let mut pass = recorder.encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("present"),
        color_attachments: &[Some(RenderPassColorAttachment {
            view: &target.texture_view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                load: LoadOp::Clear(LinearRgba::BLACK.into()),
                store: StoreOp::Store,
            },
        })],
        ..RenderPassDescriptor::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.draw(0..3, 0..1);
    ledger.view_passes(1);
    ledger.view_pixels(
        u64::from(target.texture_descriptor.size.width)
            * u64::from(target.texture_descriptor.size.height),
    );
    if glaucoma {
        ledger.glaucoma_passes(1);
    }
    true
}

/// Hands finished copies to the main world.
fn collect(
    mut readback: ResMut<Readback>,
    mut gpu: ResMut<PerceptGpu>,
    returned: Res<PerceptReturn>,
) {
    if let Some(capture) = readback.take_finished() {
        gpu.occupied = capture.occupied;
        returned.give(capture);
    }
}
