//! The views in the render world: what each frame runs, of the passes of `capture`, `field` and `present`.
//!
//! Enters: the [`PerceptFrame`] of every camera that sees as somebody does, extracted once a frame,
//! and, in the frame of a capture, that camera's colour and depth. Leaves: the picture in its
//! target, and, once a capture, the list of corners and the map of vergence for the CPU.

use super::capture::{CapturePasses, Source, Staging, ViewImages};
use super::field::FieldPasses;
use super::frame::{CaptureSource, PerceptFrame};
use super::gpu_data::{FORGET, PerceptUniform};
use super::pass::{EffectInputs, Recorder};
use super::present::{PresentPasses, blank, hand_on};
use super::resources::{PerceptGpu, ViewGpu};
use super::sees_as::Presents;
use crate::frame::ledger::WorkLedger;
use bevy::core_pipeline::schedule::camera_driver;
use bevy::core_pipeline::{Core2d, Core2dSystems, Core3d, Core3dSystems};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::extract_component::ExtractComponentPlugin;
use bevy::render::render_asset::{RenderAssets, prepare_assets};
use bevy::render::render_resource::{
    AddressMode, Extent3d, FilterMode, MipmapFilterMode, PipelineCache, Sampler, SamplerDescriptor,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor,
};
use bevy::render::renderer::{RenderContext, RenderDevice, RenderGraph, RenderQueue, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::{ViewDepthTexture, ViewTarget};
use bevy::render::{Render, RenderApp, RenderSystems};
use std::sync::Arc;

/// The passes of all views.
#[derive(Resource, Default)]
struct Passes {
    capture: CapturePasses,
    field: FieldPasses,
    present: PresentPasses,
}

/// What the systems of the passes work with.
#[derive(SystemParam)]
struct Work<'w> {
    gpu: ResMut<'w, PerceptGpu>,
    passes: ResMut<'w, Passes>,
    images: Res<'w, RenderAssets<GpuImage>>,
    cache: Res<'w, PipelineCache>,
    queue: Res<'w, RenderQueue>,
    ledger: Res<'w, WorkLedger>,
}

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
        .init_resource::<Passes>()
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
fn prepare(frames: Query<(Entity, &PerceptFrame)>, mut work: Work, device: Res<RenderDevice>) {
    let (gpu, passes) = (&mut *work.gpu, &mut *work.passes);
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
        let target = work
            .images
            .get(&frame.target)
            .map(|image| &image.texture_descriptor);
        view.target = target.map_or(UVec2::ZERO, |target| {
            UVec2::new(target.size.width, target.size.height)
        });
        // Asked for now, so that they are built when they are needed.
        let effects = frame.effects();
        passes.field.frame_is_ready(&work.cache, effects);
        let format = target.map_or(TextureFormat::Rgba8UnormSrgb, |target| target.format);
        passes.present.is_ready(&work.cache, effects, format);
        upload_field(view, frame, &device, &work.queue, &work.ledger);
        view.present =
            frame.present || (view.presented != UVec2::ZERO && view.presented != view.target);
        if frame.update || view.present {
            write_numbers(view, frame, &work.queue);
            work.ledger
                .bytes_uploaded(size_of::<PerceptUniform>() as u64);
        }
    }
}

/// The numbers of a frame, with what only its view on the device knows.
fn write_numbers(view: &ViewGpu, frame: &PerceptFrame, queue: &RenderQueue) {
    let numbers = PerceptUniform {
        slot_mask: view.memory.slot_mask(),
        target_size: view.target.as_vec2().to_array(),
        ..frame.uniform
    };
    queue.write_buffer(&view.uniform, 0, bytemuck::bytes_of(&numbers));
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

/// After a camera that sees as somebody does has drawn: its colour and depth become the static view.
fn capture_scene(
    view: ViewQuery<(
        Entity,
        &ViewTarget,
        &ViewDepthTexture,
        &ExtractedCamera,
        &PerceptFrame,
    )>,
    mut work: Work,
    mut ctx: RenderContext,
) {
    let (entity, target, depth, camera, frame) = view.into_inner();
    work.ledger.scene_passes(1);
    let (gpu, passes) = (&mut *work.gpu, &mut *work.passes);
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
    let source = Source::Scene(target.main_texture_view(), depth.view(), camera.exposure);
    let mut recorder = Recorder {
        encoder: ctx.command_encoder(),
        device: &device,
        cache: &work.cache,
        ledger: &work.ledger,
        sampler,
    };
    if capture(frame, view, passes, &source, &work.queue, &mut recorder) {
        show_captured(
            frame,
            view,
            passes,
            &work.queue,
            &work.images,
            &mut recorder,
        );
    }
}

/// What has just been captured is shown at once, where it was asked for.
fn show_captured(
    frame: &PerceptFrame,
    view: &mut ViewGpu,
    passes: &mut Passes,
    queue: &RenderQueue,
    images: &RenderAssets<GpuImage>,
    recorder: &mut Recorder<'_>,
) {
    if !frame.present {
        return;
    }
    // The table may be another one than when the frame was prepared.
    write_numbers(view, frame, queue);
    if show(frame, view, passes, queue, images, recorder) {
        view.presented = view.target;
    }
}

/// Everything that a new view needs once: its picture, corners and voxels, and the copies for the CPU.
/// Says whether it was recorded.
fn capture(
    frame: &PerceptFrame,
    gpu: &mut ViewGpu,
    passes: &mut Passes,
    source: &Source,
    queue: &RenderQueue,
    recorder: &mut Recorder,
) -> bool {
    let Some(request) = frame.capture.as_ref() else {
        return false;
    };
    // All are asked for at once.
    if !(passes.capture.are_ready(recorder.cache, &request.source)
        & passes.field.capture_is_ready(recorder.cache))
    {
        return false;
    }
    let size = UVec2::from(frame.uniform.size);
    let old = gpu
        .memory
        .make_room(recorder.device, size.element_product(), request.forget);
    let mut data = frame.uniform;
    data.slot_mask = gpu.memory.slot_mask();
    data.rebase_steps = FORGET;
    data.table_slots_old = old.as_ref().map_or(0, |old| old.slots);
    let view = match gpu.spare.take() {
        Some(spare) if spare.size == size => ViewImages { data, ..spare },
        _ => ViewImages::new(recorder.device, data),
    };
    queue.write_buffer(&view.uniform, 0, bytemuck::bytes_of(&data));
    passes.capture.take(source, &view, recorder);
    passes
        .capture
        .find_corners(&view, &gpu.corners, queue, recorder);
    passes.field.assign(
        request,
        &gpu.memory,
        old.as_ref(),
        (&view, gpu.view.as_ref()),
        queue,
        recorder,
    );
    let Some(table) = &gpu.memory.table else {
        return false;
    };
    // While an answer is on its way the next one has to wait: the eye chooses among what it saw before.
    if gpu.readback.busy() {
        gpu.unread += 1;
    } else {
        gpu.readback.start(Staging::copy(
            recorder,
            (request.serial, source.exposure()),
            &view,
            (&gpu.corners.counters, &gpu.corners.candidates),
            &table.counters,
        ));
        gpu.unread = 0;
    }
    gpu.memory.occupied = gpu.memory.occupied.saturating_add(size.element_product());
    gpu.captured = request.serial;
    gpu.spare = gpu.view.replace(view);
    frame.returned.note_recorded(request.serial);
    true
}

/// The frames' own work: photographs' captures, field updates, pictures.
fn draw_views(frames: Query<(Entity, &PerceptFrame)>, mut work: Work, mut ctx: RenderContext) {
    for (_, frame) in frames.iter().filter(|(_, frame)| frame.blank) {
        if let Some(target) = work.images.get(&frame.target) {
            blank(ctx.command_encoder(), &target.texture_view);
        }
    }
    let device = ctx.render_device().clone();
    let (gpu, passes) = (&mut *work.gpu, &mut *work.passes);
    let Some(sampler) = &gpu.sampler else { return };
    let mut recorder = Recorder {
        encoder: ctx.command_encoder(),
        device: &device,
        cache: &work.cache,
        ledger: &work.ledger,
        sampler,
    };
    for (entity, frame) in &frames {
        let Some(view) = gpu.views.get_mut(&entity).filter(|_| frame.visible) else {
            continue;
        };
        match &frame.capture {
            Some(request) if request.serial != view.captured => {
                // What a camera draws is captured, and shown, after it has drawn.
                if let CaptureSource::Photo {
                    colour,
                    vergence,
                    numbers,
                } = &request.source
                    && let (Some(colour), Some(vergence)) =
                        (work.images.get(colour), work.images.get(vergence))
                {
                    let source =
                        Source::Photo(&colour.texture_view, &vergence.texture_view, *numbers);
                    if capture(frame, view, passes, &source, &work.queue, &mut recorder) {
                        show_captured(
                            frame,
                            view,
                            passes,
                            &work.queue,
                            &work.images,
                            &mut recorder,
                        );
                    }
                }
            }
            _ => {
                if show(
                    frame,
                    view,
                    passes,
                    &work.queue,
                    &work.images,
                    &mut recorder,
                ) {
                    view.presented = view.target;
                }
            }
        }
    }
}

/// Veil, field update and picture of one frame; says whether the picture was drawn.
fn show(
    frame: &PerceptFrame,
    gpu: &mut ViewGpu,
    passes: &mut Passes,
    queue: &RenderQueue,
    images: &RenderAssets<GpuImage>,
    recorder: &mut Recorder,
) -> bool {
    let of = (gpu.view.as_ref(), gpu.captured);
    passes.present.veil.run(
        frame,
        of,
        &mut gpu.veil,
        &mut passes.capture,
        queue,
        recorder,
    );
    let (Some(view), Some(table), Some(target)) =
        (&gpu.view, &gpu.memory.table, images.get(&frame.target))
    else {
        return false;
    };
    let veil = frame.media.as_ref().and_then(|media| {
        let veil = gpu.veil.as_ref()?;
        veil.is_of(gpu.captured, media)
            .then_some((&veil.view, &veil.uniform))
    });
    let inputs = EffectInputs {
        field: gpu.field.as_ref().map(|(_, view)| view),
        media: veil,
        astigmatism: frame.effects().astigmatism,
    };
    let effects = frame.effects();
    if view.size != UVec2::from(frame.uniform.size) || effects.field_loss != inputs.field.is_some()
    {
        return false;
    }
    if frame.uniform.rebase_steps != FORGET || frame.forget {
        passes.field.shift_keys(&gpu.uniform, table, recorder);
    }
    if frame.update {
        passes
            .field
            .update(&gpu.uniform, view, table, &inputs, recorder);
    }
    if !gpu.present || effects.media != inputs.media.is_some() {
        return false;
    }
    passes
        .present
        .draw(&gpu.uniform, view, table, &inputs, target, recorder)
}

/// Hands finished copies to the main world.
fn collect(mut gpu: ResMut<PerceptGpu>, frames: Query<&PerceptFrame>) {
    for (entity, view) in &mut gpu.views {
        let Some(arrived) = view.readback.take_finished() else {
            continue;
        };
        let frame = frames.get(*entity);
        let Some(capture) = arrived else {
            if let Ok(frame) = frame {
                frame.returned.lose();
            }
            continue;
        };
        // Each capture that nobody has read since may have added a voxel a pixel.
        let since = capture.size.element_product().saturating_mul(view.unread);
        view.memory.occupied = capture.occupied.saturating_add(since);
        if let Ok(frame) = frame {
            frame.returned.give(capture);
        }
    }
}
