//! The view from inside: what an eye sees of the world before it.
//!
//! Enters: a camera with [`SeesAs`], and the components of the eye that it sees as. Leaves: the
//! camera's picture, and the candidates among which the eye chooses where to look. After Nießner et
//! al. 2013: FAST corners (section 3), defocus for every pixel (section 3), the sharpness field
//! (section 4), a Gaussian gather (section 5); a lost field limits the choice and adds blur with
//! distance from the fixation (section 3).
//!
//! Colour, distance, corners and the voxel of every pixel are found when the camera or anything in
//! its sight has changed, and not otherwise. A frame then costs one `atomicMin` and one gather a
//! pixel, and nothing at all while neither clock nor lids move.

mod capture;
mod field;
mod frame;
#[doc(hidden)] // for this crate's own tests, as the modules below
pub mod gpu_data;
mod pass;
pub(crate) mod places;
mod present;
mod render;
mod resources;
mod sees_as;
mod view;

pub use capture::fast;
pub use capture::sight::SceneChanges;
pub use field::SharpnessField;
#[doc(hidden)]
pub use field::sharpness_field;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use frame::PerceptFrame;
#[doc(hidden)]
pub use present::{gather, gather_ellipse, veil};
pub use sees_as::SeesAs;
pub use view::{NEAR_M, Percept, ViewOptions};

use crate::frame::EyeSystems;
use bevy::camera::CameraUpdateSystems;
use bevy::prelude::*;

/// The views as a plugin.
pub struct PerceptPlugin;

impl Plugin for PerceptPlugin {
    fn build(&self, app: &mut App) {
        // Whoever has eyes remembers what they saw.
        app.register_required_components::<crate::anatomy::Patient, SharpnessField>();
        app.init_resource::<SceneChanges>()
            .register_type::<SeesAs>()
            .register_type::<ViewOptions>()
            .register_type::<SharpnessField>()
            .add_observer(sees_as::despawn_presenters)
            .add_systems(
                Update,
                view::receive
                    .in_set(EyeSystems::Sense)
                    .before(crate::frame::EyeCommands),
            )
            .add_systems(Update, field::remember.in_set(EyeSystems::Perceive))
            // Where cameras stand is known when transforms have come down to them, and what they draw
            // must be known before Bevy looks which of them do.
            .add_systems(
                PostUpdate,
                (
                    sees_as::detach,
                    sees_as::attach,
                    sees_as::follow_changes,
                    sees_as::measure_targets,
                    capture::sight::notice,
                    capture::when::drive_captures,
                    present::perceive::perceive,
                    capture::when::activate_for_morphs,
                )
                    .chain()
                    .after(TransformSystems::Propagate)
                    .before(CameraUpdateSystems),
            );
        render::build_render(app);
    }
}
