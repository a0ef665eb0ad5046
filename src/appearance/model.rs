//! An eye in the world, seen from outside: where it stands, and what it is made of ([`super::build`] makes it).
//!
//! Enters: [`EyeModel`] on an entity with a place of its own. Leaves: the parts of that eye as
//! children: globe, lids, lashes, tears and brow as meshes with materials. Their space is the head's,
//! in millimetres, with the globe's centre at the entity; the entity's own space is in metres.

use super::brow::Brow;
use super::build::MadeOf;
use super::eye_camera::EyeShading;
use super::face_region::{EyeRegion, LidPose, PosedRegion};
use super::hair::HairMesh;
use super::lashes::Lashes;
use super::lighting::Lit;
use super::materials::{GlobeMaterial, HairMaterial, LidMargins, MeniscusMaterial, SkinMaterial};
use super::studio::Studio;
use super::surroundings::Surroundings;
use super::tissue_maps::{LastStromas, TissueMaps};
use crate::anatomy::{Laterality, Look, OcularMedia, Refraction};
use crate::optics::globe::GlobeShape;
use bevy::camera::primitives::Sphere;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::reflect::ReflectComponent;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::sync::Arc;

/// Metres in the unit of the eye's meshes.
pub const METRES_A_MM: f32 = 1e-3;

/// Shows this eye, or the leading eye of this person, where the entity stands: the globe's centre of
/// rotation is its origin, the patient's right is +x, and the face looks along −z.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
#[require(Transform, Visibility, EyeLight, EyeDetail, EyeParts)]
pub struct EyeModel(#[entities] pub Entity);

/// What lights an eye.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub enum EyeLight {
    /// The lights of the world that it stands in: the eight strongest that shine on it, and the rest as
    /// surroundings.
    #[default]
    World,
    /// A studio of its own.
    Studio(Studio),
    /// What its [`EyeSurroundings`] say.
    Surroundings,
}

/// What surrounds an eye whose [`EyeLight`] is [`EyeLight::Surroundings`]: a map of what it mirrors and the light of it, from
/// wherever one likes.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct EyeSurroundings(#[reflect(ignore, default = "nothing_around")] pub Arc<Surroundings>);

fn nothing_around() -> Arc<Surroundings> {
    Arc::new(Surroundings::even(Vec3::ZERO))
}

/// How fine the maps of an eye's tissues are; another fineness builds the eye anew.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
pub struct EyeDetail {
    /// As fine as a large picture shows, or half as fine.
    pub fine: bool,
}

impl Default for EyeDetail {
    fn default() -> Self {
        Self { fine: true }
    }
}

/// The parts of one eye in the world. `Changed` when the next picture of it differs from the last.
#[derive(Component, Default, Reflect)]
#[reflect(Component, from_reflect = false)]
pub struct EyeParts {
    /// Counts how often it was built anew.
    #[reflect(ignore)]
    pub(super) built: u64,
    /// The eye that is shown.
    #[reflect(ignore)]
    pub(super) eye: Option<Entity>,
    #[reflect(ignore)]
    pub(super) made_of: Option<MadeOf>,
    /// Which of the kinds of its materials it has: with an arcus, with wrinkles.
    #[reflect(ignore)]
    pub(super) kinds: Option<[bool; 2]>,
    /// Its images, which outlast what does not change them.
    #[reflect(ignore)]
    pub(super) maps: TissueMaps,
    #[reflect(ignore)]
    pub(super) layers: RenderLayers,
    /// How finely its skin is divided; see [`super::region_parts`].
    #[reflect(ignore)]
    pub(super) level: usize,
    /// How finely its hairs are divided; see [`super::hair`].
    #[reflect(ignore)]
    pub(super) hair_level: usize,
    #[reflect(ignore)]
    pub(super) lashes: Option<Lashes>,
    /// And at which level its mesh has it.
    #[reflect(ignore)]
    pub(super) brow: Option<Brow>,
    #[reflect(ignore)]
    pub(super) brow_level: Option<usize>,
    #[reflect(ignore)]
    pub(super) posed: PosedRegion,
    #[reflect(ignore)]
    pub(super) hair: HairMesh,
    #[reflect(ignore)]
    pub(super) pose: Option<LidPose>,
    #[reflect(ignore)]
    pub(super) shape: Option<GlobeShape>,
    #[reflect(ignore)]
    pub(super) lids: LidMargins,
    #[reflect(ignore)]
    pub(super) head_from_eye: Option<Quat>,
    #[reflect(ignore)]
    pub(super) pupil_radius_mm: f32,
    /// When its lids last opened, s of the simulation; and what its globe's meshes carry ([`super::pose::globe_tag`]).
    #[reflect(ignore)]
    pub(super) tears_from_s: Option<f64>,
    #[reflect(ignore)]
    pub(super) tag: Option<u32>,
    #[reflect(ignore)]
    pub(super) lit: Option<Lit>,
    #[reflect(ignore)]
    pub(super) media: Option<OcularMedia>,
    /// The refraction and the accommodation (in [`super::pose::FOCUS_STEPS`]) that its lens has.
    #[reflect(ignore)]
    pub(super) focus: Option<(Refraction, i32)>,
    #[reflect(ignore)]
    pub(super) look: Option<Look>,
    /// How its iris is computed.
    #[reflect(ignore)]
    pub(super) shading: EyeShading,
    #[reflect(ignore)]
    pub(super) globe: Vec<(Entity, Handle<GlobeMaterial>)>,
    #[reflect(ignore)]
    pub(super) skin: Handle<Mesh>,
    #[reflect(ignore)]
    pub(super) margin: Handle<Mesh>,
    /// Of the skin and of the lid margins.
    #[reflect(ignore)]
    pub(super) skin_materials: [Handle<SkinMaterial>; 2],
    #[reflect(ignore)]
    pub(super) conjunctiva_mesh: Handle<Mesh>,
    #[reflect(ignore)]
    pub(super) lash_mesh: Handle<Mesh>,
    #[reflect(ignore)]
    pub(super) brow_mesh: Handle<Mesh>,
    #[reflect(ignore)]
    pub(super) hair_material: Handle<HairMaterial>,
    #[reflect(ignore)]
    pub(super) meniscus_mesh: Handle<Mesh>,
    #[reflect(ignore)]
    pub(super) meniscus_material: Handle<MeniscusMaterial>,
}

impl EyeParts {
    /// How often it was built anew.
    pub fn built(&self) -> u64 {
        self.built
    }
}

/// Marks what belongs to an eye in the world: a child of its [`EyeModel`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component)]
pub struct EyePart;

/// The face about every eye, read once.
#[derive(Resource)]
pub struct FaceRegion(pub(super) Option<EyeRegion>);

impl FromWorld for FaceRegion {
    fn from_world(_: &mut World) -> Self {
        Self(
            EyeRegion::load()
                .inspect_err(|error| error!("the face cannot be built: {error}"))
                .ok(),
        )
    }
}

/// The box about what an eye's parts fill at any time, mm.
pub(super) const FILLED_MM: (Vec3, Vec3) =
    (Vec3::new(-45.0, -40.0, -35.0), Vec3::new(45.0, 40.0, 15.0));

/// What the parts of a model that stands there fill at any time, m.
pub(crate) fn eye_bounds(place: &GlobalTransform) -> Sphere {
    let (low, high) = FILLED_MM;
    let middle = place.transform_point(0.5 * (low + high) * METRES_A_MM);
    let reach = 0.5 * (high - low).length() * METRES_A_MM;
    Sphere {
        center: middle.into(),
        radius: reach * place.scale().abs().max_element(),
    }
}

/// The stores of the eyes' meshes, maps and materials.
#[derive(SystemParam)]
pub struct EyeAssets<'w> {
    pub(super) meshes: ResMut<'w, Assets<Mesh>>,
    pub(super) images: ResMut<'w, Assets<Image>>,
    pub(super) globes: ResMut<'w, Assets<GlobeMaterial>>,
    pub(super) skins: ResMut<'w, Assets<SkinMaterial>>,
    pub(super) hairs: ResMut<'w, Assets<HairMaterial>>,
    pub(super) tears: ResMut<'w, Assets<MeniscusMaterial>>,
    pub(super) stromas: ResMut<'w, LastStromas>,
}

/// +1 for the right eye, −1 for the left one, whose region is mirrored.
pub(super) fn side(laterality: Laterality) -> f32 {
    laterality.temporal_sign() as f32
}

/// Takes the parts of an eye away with its model.
pub(super) fn take_parts_away(
    removed: On<Remove, EyeModel>,
    children: Query<&Children>,
    parts: Query<(), With<EyePart>>,
    mut commands: Commands,
) {
    for child in children.iter_descendants(removed.entity) {
        if parts.contains(child) {
            commands.entity(child).try_despawn();
        }
    }
    // Whoever is given a model again begins anew.
    commands
        .entity(removed.entity)
        .queue_silenced(|mut model: EntityWorldMut| {
            if !model.contains::<EyeModel>() {
                model.remove::<EyeParts>();
            }
        });
}
