//! The eye seen from outside.
//!
//! Enters: the patient's components ([`crate::anatomy`]). Leaves: a globe, lids,
//! lashes and tears as meshes with materials of their own, lit by a studio, and
//! a camera that circles them and draws into the eye's panel. Refraction and
//! iris follow François et al. 2007; the lids follow the targets of the CC0 face
//! in `assets/face`.
//!
//! What did not change is not drawn: the camera is awake only in frames in
//! which pose, patient, size or viewpoint differ from what was last drawn.

pub mod brow;
pub mod canthus;
pub mod eye_camera;
pub mod face_cage;
pub mod face_region;
pub mod globe_mesh;
pub mod hair;
pub mod images;
pub mod iris_map;
pub mod lashes;
pub mod lid_profile;
pub mod lids;
pub mod light_table;
pub mod lighting;
pub mod materials;
mod mesh_fill;
pub mod noise;
pub mod parts;
pub mod sclera_map;
pub mod shading;
pub mod skin_map;
pub mod subdivide;
mod tissue_maps;

pub use eye_camera::{EyeCamera, EyeOrbit, EyeQuality};
pub use materials::{GlobeMaterial, HairMaterial, MeniscusMaterial, SkinMaterial, Studio};
pub use parts::EyeParts;

use crate::app::{EyeSystems, Panels};
use bevy::pbr::MaterialPlugin;
use bevy::prelude::*;

/// The eye as meshes, materials and a camera.
pub struct AppearancePlugin;

impl Plugin for AppearancePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<GlobeMaterial>::default(),
            MaterialPlugin::<SkinMaterial>::default(),
            MaterialPlugin::<HairMaterial>::default(),
            MaterialPlugin::<MeniscusMaterial>::default(),
        ))
        .init_resource::<EyeOrbit>()
        .init_resource::<EyeQuality>()
        .init_resource::<EyeParts>()
        .init_resource::<Studio>()
        .add_systems(
            Update,
            (
                parts::build_eye,
                lighting::light_eye,
                parts::move_eye,
                parts::move_lids,
                eye_camera::aim_camera,
                eye_camera::wake_camera,
            )
                .chain()
                .in_set(EyeSystems::Show)
                .run_if(resource_exists::<Panels>),
        );
        eye_camera::build_render(app);
    }
}
