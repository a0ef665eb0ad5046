//! The scene on the stage, and the camera before it.

use super::Stage;
use super::head::Seat;
use crate::frame::Panel;
use crate::percept::NEAR_M;
use crate::percept::{Percept, ViewOptions};
use crate::scene::catalog::LoadedScene;
use crate::scene::model::SceneModel;
use crate::scene::photo_view::Photograph;
use crate::scene::spawn::{
    SCENE_LAYER, SceneAssets, ScenePart, ambient, anisotropy, mean_luminance, spawn_model,
};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{ClearColorConfig, Exposure};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use std::sync::Arc;
use wgpu_types::DeviceType;

/// Brightness of the picture against its mean luminance: the mean becomes this shade of grey.
const MIDDLE_GREY: f32 = 0.30;

/// The scene that is to be looked at; a change of it changes the stage.
#[derive(Resource)]
pub(super) struct Wanted(pub(super) Arc<LoadedScene>);

/// What scenes are made with.
#[derive(SystemParam)]
pub(super) struct Scenery<'w, 's> {
    adapter: Option<Res<'w, RenderAdapterInfo>>,
    old: Query<'w, 's, Entity, With<ScenePart>>,
    views: Query<
        'w,
        's,
        (
            &'static mut Camera,
            &'static mut Percept,
            &'static mut ViewOptions,
        ),
    >,
    assets: SceneAssets<'w>,
}

impl Scenery<'_, '_> {
    /// Puts the stage's scene before its view in place of the one that was there.
    pub(super) fn put(&mut self, stage: &Stage, commands: &mut Commands) {
        for entity in &self.old {
            // What a node carries goes with it.
            commands.entity(entity).try_despawn();
        }
        let Ok((mut camera, mut percept, mut options)) = self.views.get_mut(stage.view) else {
            return;
        };
        percept.begin_scene();
        match &*stage.scene {
            LoadedScene::Model(model) => {
                options.exposure = MIDDLE_GREY;
                camera.clear_color = background(model);
                let device = self
                    .adapter
                    .as_ref()
                    .map_or(DeviceType::Other, |adapter| adapter.device_type);
                spawn_model(model, anisotropy(device), commands, &mut self.assets);
                commands
                    .entity(stage.view)
                    .insert(standing_in(model))
                    .remove::<Photograph>();
            }
            LoadedScene::Photo(photo) => {
                commands.entity(stage.view).insert((
                    Photograph {
                        photo: photo.clone(),
                        taken_from: Isometry3d::IDENTITY,
                    },
                    Seat::default(),
                    RenderLayers::layer(SCENE_LAYER),
                ));
            }
        }
    }
}

/// What is where nothing is, in the unit of the picture.
fn background(model: &SceneModel) -> ClearColorConfig {
    let [r, g, b] = model.background.map(|c| c / mean_luminance(model));
    ClearColorConfig::Custom(Color::linear_rgb(r, g, b))
}

/// Where a model's eye is, in its light.
fn standing_in(model: &SceneModel) -> impl Bundle + use<> {
    let (color, brightness) = ambient(model);
    // Bevy's exposure is 1 / (1.2 · 2^EV): choose it so that the picture holds luminance itself
    // over the mean, which half floats resolve.
    let unit = mean_luminance(model);
    (
        Exposure {
            ev100: (unit / 1.2).log2(),
        },
        AmbientLight {
            color,
            brightness,
            ..default()
        },
        // One tap of four texels: a browser may run on a software rasteriser, and cannot say so.
        #[cfg(target_arch = "wasm32")]
        bevy::light::ShadowFilteringMethod::Hardware2x2,
        Seat(seat(model)),
        RenderLayers::layer(SCENE_LAYER),
    )
}

/// Where a model puts the eye.
pub(super) fn seat(model: &SceneModel) -> Transform {
    Transform::from_translation(Vec3::from(model.eye.position_m))
        .looking_to(Vec3::from(model.eye.forward), Vec3::from(model.eye.up))
}

/// The scene's angle spans the smaller side of the view.
pub(super) fn fit_field(stage: Res<Stage>, mut views: Query<(&Panel, &mut Projection)>) {
    let LoadedScene::Model(model) = &*stage.scene else {
        return;
    };
    let Ok((panel, mut projection)) = views.get_mut(stage.view) else {
        return;
    };
    let half = (0.5 * model.eye.vertical_fov_deg.to_radians()).tan();
    let aspect = panel.size.x as f32 / panel.size.y as f32;
    let fov = 2.0 * (half / aspect.min(1.0)).atan();
    let is_there = matches!(&*projection, Projection::Perspective(now) if now.fov == fov && now.near == NEAR_M);
    if !is_there {
        *projection = Projection::Perspective(PerspectiveProjection {
            fov,
            near: NEAR_M,
            far: 1000.0,
            ..default()
        });
    }
}
