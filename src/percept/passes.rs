//! The passes of the views in the render world.
//!
//! Enters: the [`PerceptFrame`] of every camera that sees as somebody does, extracted once a frame,
//! and, in the frame of a capture, that camera's colour and depth. Leaves: the picture in its
//! target, and, once a capture, the list of corners and the map of vergence for the CPU.

use super::frame::{CaptureSource, PerceptFrame};
use super::gpu_data::{
    FEATURE_COUNTERS, FORGET, MediaUniform, PerceptUniform, TILE, VEIL_SCALE, WORKGROUP,
    mip_levels, pixel_groups, slot_groups,
};
use super::hand_on;
use super::movers::MoverData;
use super::pipelines::{Effects, Pass, Pipelines};
use super::readback::Staging;
use super::resources::{PerceptGpu, VeilGpu, View, ViewGpu, make_room, table_is_new};
use super::sees_as::Presents;
use crate::frame::ledger::WorkLedger;
use bevy::core_pipeline::schedule::camera_driver;
use bevy::core_pipeline::{Core2d, Core2dSystems, Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponentPlugin;
use bevy::render::render_asset::{RenderAssets, prepare_assets};
use bevy::render::render_resource::BindingResource::{
    self, Sampler as BindSampler, TextureView as BindView,
};
use bevy::render::render_resource::{
    AddressMode, Buffer, BufferInitDescriptor, BufferUsages, CommandEncoder, ComputePassDescriptor,
    Extent3d, FilterMode, LoadOp, MipmapFilterMode, Operations, PipelineCache,
    RenderPassColorAttachment, RenderPassDescriptor, Sampler, SamplerDescriptor, StoreOp,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor,
};
use bevy::render::renderer::{RenderContext, RenderDevice, RenderGraph, RenderQueue, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::{ViewDepthTexture, ViewTarget};
use bevy::render::{Render, RenderApp, RenderSystems};
use std::sync::Arc;

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
pub fn build_render(app: &mut App) {
    app.add_plugins((
        ExtractComponentPlugin::<PerceptFrame>::default(),
        ExtractComponentPlugin::<Presents>::default(),
    ));
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .init_resource::<PerceptGpu>()
        .init_resource::<Pipelines>()
        .add_systems(
            Render,
            (
                prepare
                    .in_set(RenderSystems::Prepare)
                    .after(prepare_assets::<GpuImage>),
                collect.in_set(RenderSystems::Cleanup),
            ),
        )
        .add_systems(RenderGraph, draw_views.before(camera_driver))
        .add_systems(
            Core3d,
            capture_scene.in_set(Core3dSystems::EarlyPostProcess),
        )
        .add_systems(
            Core2d,
            hand_on::hand_on.in_set(Core2dSystems::EarlyPostProcess),
        );
}

/// Makes the lasting resources of every view, and uploads its uniform and, where it has lost some, its
/// field.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn prepare(
    frames: Query<(Entity, &PerceptFrame)>,
    mut gpu: ResMut<PerceptGpu>,
    images: Res<RenderAssets<GpuImage>>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
) {
    let gpu = &mut *gpu;
    gpu.views.retain(|entity, _| frames.contains(*entity));
    for (entity, frame) in &frames {
        if !frame.visible {
            continue;
        }
        if frame.capture.is_none() {
            // Who stands still needs one.
            if let Some(view) = gpu.views.get_mut(&entity) {
                view.spare = None;
            }
        }
        gpu.sampler.get_or_insert_with(|| view_sampler(&device));
        let view = gpu
            .views
            .entry(entity)
            .or_insert_with(|| ViewGpu::new(&device));
        // Whoever lays out the window may have given the panel another size after the frame's numbers
        // were made; its new image is empty.
        let target = images
            .get(&frame.target)
            .map(|image| &image.texture_descriptor);
        view.target = target.map_or(UVec2::ZERO, |target| {
            UVec2::new(target.size.width, target.size.height)
        });
        view.format = target.map_or(view.format, |target| target.format);
        pipelines.are_ready(&cache, FRAME_PASSES, frame.effects(), view.format);
        if frame.media.is_some() {
            pipelines.are_ready(&cache, &[Pass::Veil], Effects::default(), view.format);
        }
        upload_field(view, frame, &device, &queue, &ledger);
        view.present =
            frame.present || (view.presented != UVec2::ZERO && view.presented != view.target);
        if frame.update || view.present {
            let mut uniform = frame.uniform;
            uniform.slot_mask = view.table.as_ref().map_or(0, |table| table.slots - 1);
            uniform.target_size = view.target.as_vec2().to_array();
            queue.write_buffer(&view.uniform, 0, bytemuck::bytes_of(&uniform));
            ledger.bytes_uploaded(size_of::<PerceptUniform>() as u64);
        }
    }
}

fn view_sampler(device: &RenderDevice) -> Sampler {
    device.create_sampler(&SamplerDescriptor {
        label: Some("view_sampler"),
        address_mode_u: AddressMode::ClampToEdge,
        address_mode_v: AddressMode::ClampToEdge,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: MipmapFilterMode::Nearest,
        ..SamplerDescriptor::default()
    })
}

/// The visual field of an eye that has lost some of it, as a texture.
fn upload_field(
    view: &mut ViewGpu,
    frame: &PerceptFrame,
    device: &RenderDevice,
    queue: &RenderQueue,
    ledger: &WorkLedger,
) {
    let Some(field) = &frame.field_loss else {
        view.field = None;
        return;
    };
    let is_there = |(seen, _): &(Arc<Vec<f32>>, TextureView)| Arc::ptr_eq(seen, &field.seen);
    if view.field.as_ref().is_some_and(is_there) {
        return;
    }
    let texture = device.create_texture_with_data(
        queue,
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
    view.field = Some((
        field.seen.clone(),
        texture.create_view(&TextureViewDescriptor::default()),
    ));
}

/// What every pass is recorded with.
struct Recorder<'a> {
    encoder: &'a mut CommandEncoder,
    device: &'a RenderDevice,
    cache: &'a PipelineCache,
    pipelines: &'a Pipelines,
    ledger: &'a WorkLedger,
    sampler: &'a Sampler,
}

impl Recorder<'_> {
    /// Runs one compute pass; says whether its pipeline was there.
    fn run(&mut self, pass: Pass, effects: Effects, bound: &[Bound<'_>], groups: [u32; 2]) -> bool {
        let found = self
            .pipelines
            .compute(self.device, self.cache, pass, effects, bound);
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

/// After a camera that sees as somebody does has drawn: its colour and depth become the static view.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn capture_scene(
    view: ViewQuery<(Entity, &ViewTarget, &ViewDepthTexture, &PerceptFrame)>,
    mut gpu: ResMut<PerceptGpu>,
    images: Res<RenderAssets<GpuImage>>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
    mut ctx: RenderContext,
) {
    let (entity, target, depth, frame) = view.into_inner();
    ledger.scene_passes(1);
    let gpu = &mut *gpu;
    let (Some(view), Some(sampler)) = (gpu.views.get_mut(&entity), &gpu.sampler) else {
        return;
    };
    let Some(request) = frame.capture.as_ref() else {
        return;
    };
    if !matches!(request.source, CaptureSource::Scene) || request.serial == view.captured {
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
        ledger: &ledger,
        sampler,
    };
    if capture(
        frame,
        view,
        &queue,
        &mut recorder,
        Pass::CaptureScene,
        &source,
    ) {
        show_captured(frame, view, &queue, &images, &mut recorder);
    }
}

/// What has just been captured is shown at once, where it was asked for.
fn show_captured(
    frame: &PerceptFrame,
    view: &mut ViewGpu,
    queue: &RenderQueue,
    images: &RenderAssets<GpuImage>,
    recorder: &mut Recorder<'_>,
) {
    if !frame.present {
        return;
    }
    // The table may be another one than when the frame was prepared.
    let mut uniform = frame.uniform;
    uniform.slot_mask = view.table.as_ref().map_or(0, |table| table.slots - 1);
    uniform.target_size = view.target.as_vec2().to_array();
    queue.write_buffer(&view.uniform, 0, bytemuck::bytes_of(&uniform));
    spread_veil(frame, view, queue, recorder);
    if show(frame, view, images, recorder) {
        view.presented = view.target;
    }
}

/// Everything that a new view needs once: capture, mips, corners, slots, and the copies for the CPU.
/// Says whether it was recorded.
fn capture(
    frame: &PerceptFrame,
    gpu: &mut ViewGpu,
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
        .chain([pass, Pass::GrowTable, Pass::ForgetLeft])
        .collect();
    let format = gpu.format;
    if !recorder
        .pipelines
        .are_ready(recorder.cache, &needed, Effects::default(), format)
    {
        return false;
    }
    let size = UVec2::from(frame.uniform.size);
    let old = make_room(gpu, recorder.device, size, request.forget);
    let Some(table) = &gpu.table else {
        return false;
    };
    let (counters, candidates) = (&gpu.feature_counters, &gpu.candidates);
    let mut data = frame.uniform;
    data.slot_mask = table.slots - 1;
    data.rebase_steps = FORGET;
    data.table_slots_old = old.as_ref().map_or(0, |old| old.slots);
    let view = match gpu.spare.take() {
        Some(spare) if spare.size == size => View { data, ..spare },
        _ => View::new(recorder.device, data),
    };
    let uniform = &view.uniform;
    queue.write_buffer(uniform, 0, bytemuck::bytes_of(&data));

    let movers = movers_buffer(recorder.device, &request.moved.here);
    let mut run =
        |pass, bound: &[Bound<'_>], groups| recorder.run(pass, Effects::default(), bound, groups);
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
        (5, table.keys.as_entire_binding()),
        (6, table.counters.as_entire_binding()),
        (13, movers.as_entire_binding()),
    ];
    run(Pass::AssignSlots, &bound, pixels);
    if let Some(before) = gpu.view.as_ref().filter(|_| !request.moved.left.is_empty()) {
        // In the table as it is now.
        let data = PerceptUniform {
            slot_mask: data.slot_mask,
            ..before.data
        };
        queue.write_buffer(&before.uniform, 0, bytemuck::bytes_of(&data));
        let left = movers_buffer(recorder.device, &request.moved.left);
        let bound = [
            (0, before.uniform.as_entire_binding()),
            (1, BindView(&before.vergence_view)),
            (3, table.tag.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
            (13, left.as_entire_binding()),
        ];
        let groups = pixel_groups(before.size.x, before.size.y, WORKGROUP);
        recorder.run(Pass::ForgetLeft, Effects::default(), &bound, groups);
    }

    // While an answer is on its way the next one has to wait: the eye chooses among what it saw before.
    if !gpu.readback.busy() {
        gpu.readback.start(Staging::copy(
            recorder.device,
            recorder.encoder,
            request.serial,
            size,
            counters,
            candidates,
            &table.counters,
            &view.vergence,
        ));
        gpu.unread = 0;
    } else {
        gpu.unread += 1;
    }
    gpu.occupied = gpu.occupied.saturating_add(size.x * size.y);
    gpu.captured = request.serial;
    gpu.spare = gpu.view.replace(view);
    frame.returned.note_recorded(request.serial);
    recorder.ledger.view_captures(1);
    recorder.ledger.feature_passes(1);
    true
}

/// What has moved, behind the number of it.
fn movers_buffer(device: &RenderDevice, movers: &[MoverData]) -> Buffer {
    let mut bytes = vec![0; 32];
    bytes[..4].copy_from_slice(&(movers.len() as u32).to_le_bytes());
    bytes.extend_from_slice(bytemuck::cast_slice(movers));
    // The list has room for one where there is none.
    bytes.resize(bytes.len().max(32 + size_of::<MoverData>()), 0);
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("movers"),
        contents: &bytes,
        usage: BufferUsages::STORAGE,
    })
}

/// The frames' own work: photographs' captures, field updates, pictures.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it touches"
)]
fn draw_views(
    frames: Query<(Entity, &PerceptFrame)>,
    mut gpu: ResMut<PerceptGpu>,
    images: Res<RenderAssets<GpuImage>>,
    pipelines: Res<Pipelines>,
    cache: Res<PipelineCache>,
    queue: Res<RenderQueue>,
    ledger: Res<WorkLedger>,
    mut ctx: RenderContext,
) {
    for (_, frame) in frames.iter().filter(|(_, frame)| frame.blank) {
        if let Some(target) = images.get(&frame.target) {
            blank(ctx.command_encoder(), &target.texture_view);
        }
    }
    let device = ctx.render_device().clone();
    let gpu = &mut *gpu;
    let Some(sampler) = &gpu.sampler else { return };
    let mut recorder = Recorder {
        encoder: ctx.command_encoder(),
        device: &device,
        cache: &cache,
        pipelines: &pipelines,
        ledger: &ledger,
        sampler,
    };
    for (entity, frame) in &frames {
        let Some(view) = gpu.views.get_mut(&entity).filter(|_| frame.visible) else {
            continue;
        };
        match &frame.capture {
            Some(request) if request.serial != view.captured => {
                // What a camera draws is captured, and shown, after it has drawn.
                if let CaptureSource::Photo { colour, vergence } = &request.source
                    && let (Some(colour), Some(vergence)) =
                        (images.get(colour), images.get(vergence))
                {
                    let source = [
                        (1, BindView(&colour.texture_view)),
                        (3, BindView(&vergence.texture_view)),
                    ];
                    let pass = Pass::CapturePhoto;
                    if capture(frame, view, &queue, &mut recorder, pass, &source) {
                        show_captured(frame, view, &queue, &images, &mut recorder);
                    }
                }
            }
            _ => {
                spread_veil(frame, view, &queue, &mut recorder);
                if show(frame, view, &images, &mut recorder) {
                    view.presented = view.target;
                }
            }
        }
    }
}

/// Nothing but black.
fn blank(encoder: &mut CommandEncoder, target: &TextureView) {
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

/// Is the veil of this frame's media over the view that is there?
fn veil_is_there(frame: &PerceptFrame, gpu: &ViewGpu) -> bool {
    let wanted = frame.media.map(|media| (gpu.captured, media));
    gpu.veil.as_ref().is_some_and(|veil| veil.of == wanted)
}

/// Spreads the veil of clouded media over the view, where it is not there yet.
fn spread_veil(
    frame: &PerceptFrame,
    gpu: &mut ViewGpu,
    queue: &RenderQueue,
    recorder: &mut Recorder<'_>,
) {
    let (Some(media), Some(view)) = (&frame.media, &gpu.view) else {
        gpu.veil = None;
        return;
    };
    if veil_is_there(frame, gpu) {
        return;
    }
    let mut veil = match gpu.veil.take() {
        Some(veil) if veil.size == view.size => veil,
        _ => VeilGpu::new(recorder.device, view.size),
    };
    queue.write_buffer(&veil.uniform, 0, bytemuck::bytes_of(media));
    let bound = [
        (0, view.uniform.as_entire_binding()),
        (1, BindView(&view.colour_view)),
        (2, BindSampler(recorder.sampler)),
        (3, veil.uniform.as_entire_binding()),
        (4, BindView(&veil.view)),
    ];
    let small = view.size.map(|side| side.div_ceil(VEIL_SCALE));
    let groups = pixel_groups(small.x, small.y, WORKGROUP);
    if recorder.run(Pass::Veil, Effects::default(), &bound, groups) {
        veil.of = Some((gpu.captured, *media));
        recorder.ledger.veil_passes(1);
        recorder
            .ledger
            .bytes_uploaded(size_of::<MediaUniform>() as u64);
    }
    gpu.veil = Some(veil);
}

/// Field update and picture of one frame; says whether the picture was drawn.
fn show(
    frame: &PerceptFrame,
    gpu: &ViewGpu,
    images: &RenderAssets<GpuImage>,
    recorder: &mut Recorder<'_>,
) -> bool {
    let effects = frame.effects();
    let (Some(view), Some(table), Some(target)) =
        (&gpu.view, &gpu.table, images.get(&frame.target))
    else {
        return false;
    };
    let (uniform, ledger) = (&gpu.uniform, recorder.ledger);
    let field = gpu.field.as_ref().map(|(_, view)| view);
    if view.size != UVec2::from(frame.uniform.size) || effects.field_loss != field.is_some() {
        return false;
    }
    let pixels = u64::from(view.size.x) * u64::from(view.size.y);
    let field_at = |at| field.map(|field| (at, BindView(field)));
    if frame.uniform.rebase_steps != FORGET || frame.forget {
        let bound = [
            (0, uniform.as_entire_binding()),
            (5, table.keys.as_entire_binding()),
        ];
        recorder.run(
            Pass::Rebase,
            Effects::default(),
            &bound,
            slot_groups(table.slots),
        );
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
        if recorder.run(Pass::UpdateField, effects, &bound, groups) {
            ledger.field_updates(1);
            ledger.field_pixels(pixels);
        }
    }
    if !gpu.present || (effects.media && !veil_is_there(frame, gpu)) {
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
        effects,
        &bound,
        pixel_groups(view.size.x, view.size.y, TILE),
    );
    let mut bound = vec![
        (0, uniform.as_entire_binding()),
        (1, BindView(&view.colour_view)),
        (2, BindSampler(recorder.sampler)),
        (3, view.blur_px.as_entire_binding()),
        (4, view.tile_near.as_entire_binding()),
    ];
    bound.extend(field_at(5));
    if let Some(veil) = gpu.veil.as_ref().filter(|_| effects.media) {
        bound.push((6, BindView(&veil.view)));
        bound.push((7, veil.uniform.as_entire_binding()));
    }
    let found =
        recorder
            .pipelines
            .present(recorder.device, recorder.cache, effects, gpu.format, &bound);
    let Some((pipeline, bindings)) = found else {
        return false;
    };
    let mut pass = recorder.encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("present"),
        color_attachments: &[Some(onto_black(&target.texture_view))],
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
    if effects.field_loss {
        ledger.field_loss_passes(1);
    }
    true
}

/// Hands finished copies to the main world.
fn collect(mut gpu: ResMut<PerceptGpu>, frames: Query<&PerceptFrame>) {
    for (entity, view) in &mut gpu.views {
        if let Some(capture) = view.readback.take_finished() {
            // Each capture that nobody has read since may have added a voxel a pixel.
            let since = capture.size.element_product().saturating_mul(view.unread);
            view.occupied = capture.occupied.saturating_add(since);
            if let Ok(frame) = frames.get(*entity) {
                frame.returned.give(capture);
            }
        }
    }
}
