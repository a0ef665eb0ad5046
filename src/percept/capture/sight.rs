//! Whether anything that a camera might see has changed.
//!
//! Enters: Bevy's own record of changes to meshes, materials, textures, lights and their places, and eyes.
//! Leaves: the render layers that were touched in this frame. A shadow may fall in from outside of
//! the picture, so a change anywhere on a camera's layers counts. Eyes, which are never at rest, cast
//! none: one that changes counts where it is in the picture.

use super::super::field::movers::Movers;
use crate::appearance::model::{EyePart, eye_bounds};
use crate::appearance::{EyeModel, EyeParts};
use bevy::asset::AssetEvent;
use bevy::camera::primitives::{Aabb, Frustum, Sphere};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{ClearColorConfig, Exposure};
use bevy::light::{EnvironmentMapLight, GlobalAmbientLight, Skybox};
use bevy::math::Affine3A;
use bevy::mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::pbr::DistanceFog;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::render::view::ColorGrading;

/// The layers on which something has changed in this frame.
#[derive(Resource, Default, Debug)]
pub struct SceneChanges {
    touched: Option<RenderLayers>,
    everywhere: bool,
    /// Was there light from everywhere in the last frame?
    has_ambient: bool,
    /// Eyes that have changed, with their layers: where they are, and where they were.
    eyes: Vec<(RenderLayers, Sphere)>,
    /// Where eyes were last seen to change.
    known_eyes: HashMap<Entity, Sphere>,
    /// Layers of everything that was there.
    known: HashMap<Entity, RenderLayers>,
    /// What has moved.
    movers: Movers,
    /// Layers of meshes in shapes of Bevy's morph targets.
    morphed: Option<RenderLayers>,
}

impl SceneChanges {
    /// Has something changed that a camera of these layers may see, which has this frustum?
    pub fn touch(&self, layers: Option<&RenderLayers>, frustum: impl FnOnce() -> Frustum) -> bool {
        let all = RenderLayers::default();
        let layers = layers.unwrap_or(&all);
        let touched = self.touched.as_ref();
        if self.everywhere || touched.is_some_and(|touched| touched.intersects(layers)) {
            return true;
        }
        let own = self.eyes.iter().filter(|(own, _)| own.intersects(layers));
        let mut own = own.map(|(_, bounds)| bounds).peekable();
        own.peek().is_some() && {
            let frustum = frustum();
            own.any(|bounds| frustum.intersects_sphere(bounds, true))
        }
    }

    /// Are there meshes on these layers that Bevy's morph targets shape?
    pub(in crate::percept) fn has_morphs(&self, layers: Option<&RenderLayers>) -> bool {
        let all = RenderLayers::default();
        let morphed = self.morphed.as_ref();
        morphed.is_some_and(|morphed| morphed.intersects(layers.unwrap_or(&all)))
    }

    /// What has moved.
    pub(in crate::percept) fn movers(&self) -> &Movers {
        &self.movers
    }

    fn add(&mut self, layers: Option<&RenderLayers>) {
        let layers = layers.cloned().unwrap_or_default();
        self.touched = Some(match self.touched.take() {
            None => layers,
            Some(touched) => touched.union(&layers),
        });
    }
}

/// Whatever can be seen.
type Seen = Or<(
    With<Mesh3d>,
    With<PointLight>,
    With<DirectionalLight>,
    With<SpotLight>,
)>;

/// A change of it that Bevy records on its entity.
type Altered = Or<(
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
    Changed<RenderLayers>,
    Changed<Mesh3d>,
    Changed<MeshMaterial3d<StandardMaterial>>,
    Or<(
        Changed<PointLight>,
        Changed<DirectionalLight>,
        Changed<SpotLight>,
    )>,
)>;

/// A change of an eye's part that its model does not tell of. (Its place changes whenever the eye moves, and Bevy marks a mesh as
/// another one whenever its vertices do.)
type PartAltered = Or<(Changed<InheritedVisibility>, Changed<RenderLayers>)>;

/// Something, and the layers that it is on.
type Layered<'a> = (Entity, Option<&'a RenderLayers>);

/// An eye that may look otherwise than before.
type EyeAltered = (
    With<EyeModel>,
    Or<(Changed<EyeParts>, Changed<GlobalTransform>)>,
);

/// What of a camera, beside its place and lens, decides what it draws.
#[derive(bevy::ecs::query::QueryData)]
pub(in crate::percept) struct CameraLook {
    exposure: Option<Ref<'static, Exposure>>,
    ambient: Option<Ref<'static, AmbientLight>>,
    fog: Option<Ref<'static, DistanceFog>>,
    sky: Option<Ref<'static, Skybox>>,
    environment: Option<Ref<'static, EnvironmentMapLight>>,
    grading: Option<Ref<'static, ColorGrading>>,
}

/// What a camera had of it, and before what colour it drew.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::percept) struct Look {
    has: [bool; 6],
    background: Option<LinearRgba>,
}

impl CameraLookItem<'_, '_> {
    /// Does the camera draw otherwise than it did when this was last asked?
    pub(in crate::percept) fn has_changed(&self, camera: &Camera, before: &mut Look) -> bool {
        fn state<T>(part: &Option<Ref<T>>) -> (bool, bool) {
            let changed = part.as_ref().is_some_and(|part| part.is_changed());
            (part.is_some(), changed)
        }
        let parts = [
            state(&self.exposure),
            state(&self.ambient),
            state(&self.fog),
            state(&self.sky),
            state(&self.environment),
            state(&self.grading),
        ];
        let now = Look {
            has: parts.map(|(has, _)| has),
            background: match camera.clear_color {
                ClearColorConfig::Custom(color) => Some(color.into()),
                _ => None,
            },
        };
        let is_other = parts.iter().any(|(_, changed)| *changed) || now != *before;
        *before = now;
        is_other
    }
}

/// Lights and meshes that are gone.
#[derive(bevy::ecs::system::SystemParam)]
pub(in crate::percept) struct Gone<'w, 's> {
    meshes: RemovedComponents<'w, 's, Mesh3d>,
    points: RemovedComponents<'w, 's, PointLight>,
    suns: RemovedComponents<'w, 's, DirectionalLight>,
    spots: RemovedComponents<'w, 's, SpotLight>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    eyes: RemovedComponents<'w, 's, EyeModel>,
}

/// What meshes are drawn with.
#[derive(bevy::ecs::system::SystemParam)]
pub(in crate::percept) struct Surfaces<'w, 's> {
    meshes: MessageReader<'w, 's, AssetEvent<Mesh>>,
    materials: MessageReader<'w, 's, AssetEvent<StandardMaterial>>,
    images: MessageReader<'w, 's, AssetEvent<Image>>,
    standard: Res<'w, Assets<StandardMaterial>>,
}

type Drawn<'a> = (
    &'a Mesh3d,
    Option<&'a MeshMaterial3d<StandardMaterial>>,
    Option<&'a RenderLayers>,
);

/// A mesh that may be somewhere else.
type Movable = (With<Mesh3d>, Changed<GlobalTransform>);

/// Where it is.
type Placed<'a> = (
    Entity,
    &'a GlobalTransform,
    Option<&'a Aabb>,
    Option<&'a RenderLayers>,
    Has<EyePart>,
);

/// Where joints are, and what they hold of meshes.
#[derive(bevy::ecs::system::SystemParam)]
pub(in crate::percept) struct Skeletons<'w, 's> {
    joints: Query<'w, 's, Ref<'static, GlobalTransform>>,
    meshes: Res<'w, Assets<Mesh>>,
    binds: Res<'w, Assets<SkinnedMeshInverseBindposes>>,
}

impl Skeletons<'_, '_> {
    fn have_moved(&self, skin: &SkinnedMesh) -> bool {
        let has_moved = |joint: &Entity| {
            self.joints
                .get(*joint)
                .is_ok_and(|place| place.is_changed())
        };
        skin.joints.iter().any(has_moved)
    }

    /// Takes in where the limbs of a mesh are, as far as they have moved or are not known yet.
    fn place_limbs(
        &self,
        (entity, mesh, skin, layers): (Entity, &Mesh3d, &SkinnedMesh, Option<&RenderLayers>),
        movers: &mut Movers,
    ) {
        let (Some(mesh), Some(binds)) = (
            self.meshes.get(&mesh.0),
            self.binds.get(&skin.inverse_bindposes),
        ) else {
            return;
        };
        for (index, held) in mesh
            .skinned_mesh_bounds()
            .into_iter()
            .flat_map(|bounds| bounds.iter())
        {
            let at = usize::from(index.0);
            let part = (entity, Some(index.0));
            let (Some(joint), Some(bind)) = (skin.joints.get(at), binds.get(at)) else {
                continue;
            };
            let Ok(place) = self.joints.get(*joint) else {
                continue;
            };
            if place.is_changed() || !movers.knows(part) {
                let place = place.affine() * Affine3A::from_mat4(*bind);
                let shape = Some((held.center, held.half_size));
                movers.place(part, &place.into(), shape, layers);
            }
        }
    }
}

/// Notices what has changed since the last frame.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads and makes"
)]
pub(in crate::percept) fn notice(
    mut changes: ResMut<SceneChanges>,
    altered: Query<Layered, (Seen, Altered, Without<EyePart>)>,
    altered_parts: Query<Layered, (With<EyePart>, PartAltered)>,
    unaltered: Query<Layered, Seen>,
    skinned: Query<(Entity, &Mesh3d, &SkinnedMesh, Option<&RenderLayers>)>,
    skeletons: Skeletons,
    morphed: Query<(Ref<MeshMorphWeights>, Option<&RenderLayers>)>,
    weights: Query<(), Changed<MorphWeights>>,
    eyes: Query<(Entity, &GlobalTransform, Option<&RenderLayers>), EyeAltered>,
    placed: Query<Placed, Movable>,
    ambient: Option<Res<GlobalAmbientLight>>,
    drawn: Query<Drawn, Without<EyePart>>,
    mut gone: Gone,
    mut surfaces: Surfaces,
) {
    let changes = &mut *changes;
    changes.touched = None;
    changes.movers.begin();
    for (entity, place, shape, layers, is_part) in &placed {
        // An eye turns on the spot all the time, and is nowhere else for that.
        if is_part && changes.movers.only_turns(entity, place) {
            continue;
        }
        let shape = shape.map(|shape| (shape.center.into(), shape.half_extents.into()));
        changes.movers.place((entity, None), place, shape, layers);
    }
    // What has lost its layers is on the usual one now.
    let bare: Vec<_> = gone.layers.read().collect();
    let gone_eyes: Vec<_> = gone.eyes.read().collect();
    let altered = altered.iter().chain(&altered_parts);
    for (entity, layers) in altered.chain(unaltered.iter_many(bare)) {
        changes.add(layers);
        let now = layers.cloned().unwrap_or_default();
        // Who sees the layers that it was on sees it go.
        if let Some(before) = changes.known.insert(entity, now.clone())
            && before != now
        {
            changes.add(Some(&before));
        }
    }
    let gone = (gone.meshes.read())
        .chain(gone.points.read())
        .chain(gone.suns.read())
        .chain(gone.spots.read());
    for entity in gone {
        changes.movers.forget(entity);
        // One that has been given another mesh since is altered, and counted above.
        if let Some(layers) = changes.known.remove(&entity) {
            changes.add(Some(&layers));
        }
    }
    for (entity, mesh, skin, layers) in &skinned {
        if skeletons.have_moved(skin) {
            changes.add(layers);
        }
        skeletons.place_limbs((entity, mesh, skin, layers), &mut changes.movers);
    }
    changes.morphed = None;
    for (morph, layers) in &morphed {
        let own = layers.cloned().unwrap_or_default();
        changes.morphed = Some(match changes.morphed.take() {
            Some(others) => others.union(&own),
            None => own,
        });
        let follows = match &*morph {
            MeshMorphWeights::Reference(entity) => weights.contains(*entity),
            MeshMorphWeights::Value { .. } => false,
        };
        if follows || morph.is_changed() {
            changes.add(layers);
        }
    }
    // Eyes are drawn with materials of their own.
    changes.eyes.clear();
    for entity in gone_eyes {
        changes.known_eyes.remove(&entity);
    }
    for (entity, place, layers) in &eyes {
        let now = eye_bounds(place);
        let before = changes.known_eyes.insert(entity, now);
        for bounds in [Some(now), before].into_iter().flatten() {
            changes
                .eyes
                .push((layers.cloned().unwrap_or_default(), bounds));
        }
    }
    let had_ambient = std::mem::replace(&mut changes.has_ambient, ambient.is_some());
    changes.everywhere = ambient.map_or(had_ambient, |ambient| ambient.is_changed());
    redrawn(changes, &drawn, &mut surfaces);
}

/// The ids of assets that were changed in place.
fn modified<A: Asset>(events: &mut MessageReader<AssetEvent<A>>) -> HashSet<AssetId<A>> {
    events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id }
            | AssetEvent::Modified { id }
            | AssetEvent::LoadedWithDependencies { id } => Some(*id),
            _ => None,
        })
        .collect()
}

/// Meshes, materials and textures that were changed in place.
fn redrawn(
    changes: &mut SceneChanges,
    drawn: &Query<Drawn, Without<EyePart>>,
    surfaces: &mut Surfaces,
) {
    let meshes = modified(&mut surfaces.meshes);
    let mut materials = modified(&mut surfaces.materials);
    let mut images: HashSet<AssetId<Image>> = HashSet::default();
    for event in surfaces.images.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                images.insert(*id);
            }
            // A sky or an environment that comes late is on no material.
            AssetEvent::LoadedWithDependencies { .. } => changes.everywhere = true,
            _ => {}
        }
    }
    if !images.is_empty() {
        let shows = |texture: &Option<Handle<Image>>| {
            texture
                .as_ref()
                .is_some_and(|texture| images.contains(&texture.id()))
        };
        let textured = surfaces.standard.iter().filter(|(_, material)| {
            [
                &material.base_color_texture,
                &material.emissive_texture,
                &material.metallic_roughness_texture,
                &material.normal_map_texture,
                &material.occlusion_texture,
                &material.depth_map,
            ]
            .into_iter()
            .any(shows)
        });
        materials.extend(textured.map(|(id, _)| id));
    }
    if meshes.is_empty() && materials.is_empty() {
        return;
    }
    for (mesh, material, layers) in drawn {
        if meshes.contains(&mesh.id())
            || material.is_some_and(|material| materials.contains(&material.id()))
        {
            changes.add(layers);
        }
    }
}
