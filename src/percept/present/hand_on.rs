//! From a view's own picture to the window, or the part of a target, that its camera draws into.

use super::super::sees_as::Presents;
use bevy::core_pipeline::blit::{BlitPipeline, BlitPipelineKey};
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    Extent3d, LoadOp, Operations, Origin3d, PipelineCache, RenderPassColorAttachment,
    RenderPassDescriptor, SpecializedRenderPipelines, StoreOp, TexelCopyTextureInfo,
};
use bevy::render::renderer::{RenderContext, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::ViewTarget;

/// Copies the picture to its place; draws it there where the target has another format.
pub(in crate::percept) fn hand_on(
    view: ViewQuery<(&ViewTarget, &ExtractedCamera, &Presents)>,
    images: Res<RenderAssets<GpuImage>>,
    blit: Res<BlitPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<BlitPipeline>>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (target, camera, presents) = view.into_inner();
    let Some(image) = images.get(&presents.0) else {
        return;
    };
    let (from, to) = (&image.texture, target.main_texture());
    let viewport = camera.viewport.as_ref();
    let corner = viewport.map_or(UVec2::ZERO, |viewport| viewport.physical_position);
    let room = UVec2::new(to.width(), to.height()).saturating_sub(corner);
    let size = UVec2::new(from.width(), from.height()).min(room);
    if size.min_element() == 0 {
        return;
    }
    if from.format() == to.format() {
        let place = TexelCopyTextureInfo {
            origin: Origin3d {
                x: corner.x,
                y: corner.y,
                z: 0,
            },
            ..to.as_image_copy()
        };
        let extent = Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        };
        ctx.command_encoder()
            .copy_texture_to_texture(from.as_image_copy(), place, extent);
        return;
    }
    let key = BlitPipelineKey {
        target_format: to.format(),
        blend_state: None,
        samples: 1,
        source_space: None,
    };
    let id = pipelines.specialize(&cache, &blit, key);
    let Some(pipeline) = cache.get_render_pipeline(id) else {
        return;
    };
    let bindings = blit.create_bind_group(ctx.render_device(), &image.texture_view, &cache);
    let mut pass = ctx
        .command_encoder()
        .begin_render_pass(&RenderPassDescriptor {
            label: Some("hand_on"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: target.main_texture_view(),
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Load,
                    store: StoreOp::Store,
                },
            })],
            ..RenderPassDescriptor::default()
        });
    pass.set_viewport(
        corner.x as f32,
        corner.y as f32,
        size.x as f32,
        size.y as f32,
        0.0,
        1.0,
    );
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.draw(0..3, 0..1);
}
