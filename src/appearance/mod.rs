//! The eye seen from outside.
//!
//! Enters: an [`EyeModel`] in the world, and the components of the eye that it shows
//! ([`crate::anatomy`]). Leaves: globe, lids, lashes and tears as meshes with materials of their own,
//! lit by the world's lights or by a studio, and cameras that circle an eye and draw into a panel.
//! Refraction and iris follow François et al. 2007; the lids follow the targets of the CC0 face in
//! `assets/face`.
//!
//! What did not change is not drawn: an eye camera is awake only in frames in which pose, patient,
//! size or viewpoint differ from what was last drawn.

mod brow;
mod build;
mod canthus;
#[doc(hidden)] // for this crate's own tests, as the modules below
pub mod eye_camera;
mod face_cage;
mod face_region;
mod globe_mesh;
mod hair;
#[doc(hidden)]
pub mod illumination;
#[doc(hidden)]
pub mod images;
#[doc(hidden)]
pub mod iris_map;
mod lashes;
mod levels;
pub(crate) mod lid_edges;
mod lid_profile;
mod lids;
#[doc(hidden)]
pub mod light_table;
mod lighting;
mod look_uniform;
#[doc(hidden)]
pub mod materials;
mod mesh_fill;
pub(crate) mod model;
mod pose;
mod probe;
mod region_parts;
#[doc(hidden)]
pub mod sclera_map;
#[doc(hidden)]
pub mod shading;
mod skin_map;
pub(crate) mod studio;
mod studio_room;
mod subdivide;
#[doc(hidden)]
pub mod surroundings;
mod tissue_maps;

pub use eye_camera::{EyeCamera, EyeOrbit, EyeQuality, EyeShading, eye_camera};
pub use illumination::Lamp;
pub use materials::{GlobeMaterial, HairMaterial, MeniscusMaterial, SkinMaterial};
pub use model::{EyeDetail, EyeLight, EyeModel, EyeParts, EyeSurroundings};
pub use probe::{EyeProbe, Probed};
pub use studio::{Studio, StudioLight};

use crate::frame::EyeSystems;
use bevy::pbr::MaterialPlugin;
use bevy::prelude::*;

/// Eyes as meshes, materials and cameras.
pub struct AppearancePlugin;

impl Plugin for AppearancePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<GlobeMaterial>::default(),
            MaterialPlugin::<SkinMaterial>::default(),
            MaterialPlugin::<HairMaterial>::default(),
            MaterialPlugin::<MeniscusMaterial>::default(),
        ))
        .register_type::<EyeModel>()
        .register_type::<EyeDetail>()
        .register_type::<EyeLight>()
        .register_type::<EyeSurroundings>()
        .register_type::<EyeProbe>()
        .register_type::<EyeCamera>()
        .register_type::<EyeOrbit>()
        .register_type::<EyeQuality>()
        .init_resource::<model::FaceRegion>()
        .init_resource::<tissue_maps::LastStromas>()
        .add_observer(model::take_parts_away)
        .add_observer(probe::end_probe)
        .add_observer(probe::end_probed)
        .add_systems(
            Update,
            (
                probe::take_probes.run_if(any_with_component::<EyeProbe>),
                lighting::light_eyes,
                build::build_eyes,
                pose::move_eyes,
                pose::age_tears,
                levels::choose_levels,
                pose::move_lids,
                pose::cloud_lenses,
                pose::focus_lenses,
                pose::apply_looks,
                eye_camera::choose_shading,
                eye_camera::aim_cameras,
                eye_camera::wake_cameras,
            )
                .chain()
                .in_set(EyeSystems::Show),
        );
        eye_camera::build_render(app);
    }
}
