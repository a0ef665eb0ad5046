//! The view from inside: what this eye sees of the scene.
//!
//! Enters: the patient's components and a scene. Leaves: the view's panel, and
//! the candidates among which the eye chooses where to look. After Nießner et
//! al. 2013: FAST corners (section 3), defocus for every pixel (section 3), the
//! sharpness field (section 4), a Gaussian gather (section 5); glaucoma limits
//! the choice and adds blur with distance from the fixation (section 3).
//!
//! The head is still, so the view is static: colour, distance, corners and the
//! voxel of every pixel are found once, when scene or size change. A frame then
//! costs one `atomicMin` and one gather a pixel, and nothing at all while
//! neither clock nor lids move.

pub mod attention;
pub mod fast;
pub mod frame;
pub mod gather;
pub mod gpu_data;
pub mod passes;
pub mod pipelines;
pub mod places;
pub mod readback;
mod resources;
pub mod sharpness_field;
pub mod view;
pub mod visual_field;
pub mod work;

pub use frame::{PerceptFrame, PerceptReturn, SceneCamera};
pub use view::{Percept, ViewOptions};

use crate::app::{EyeSystems, Panels};
use bevy::prelude::*;

/// The view as a plugin.
pub struct PerceptPlugin;

impl Plugin for PerceptPlugin {
    fn build(&self, app: &mut App) {
        let returned = PerceptReturn::default();
        app.insert_resource(returned.clone())
            .init_resource::<Percept>()
            .init_resource::<ViewOptions>()
            .add_plugins(bevy::render::extract_component::ExtractComponentPlugin::<
                SceneCamera,
            >::default())
            .add_systems(
                Update,
                (view::load_scene, view::receive)
                    .chain()
                    .before(crate::app::session::obey)
                    .in_set(EyeSystems::Sense)
                    .run_if(resource_exists::<Panels>),
            )
            .add_systems(
                Update,
                (view::drive_capture, view::perceive)
                    .chain()
                    .in_set(EyeSystems::Perceive)
                    .run_if(resource_exists::<Panels>),
            );
        passes::build_render(app, returned);
    }
}
