//! Materials of others' own kinds, watched as Bevy's own is.

use super::sight::{SceneChanges, modified, notice};
use super::when::drive_captures;
use bevy::asset::AssetEvent;
use bevy::camera::visibility::RenderLayers;
use bevy::prelude::*;

/// Adds kinds of materials to what views watch.
pub trait WatchMaterial {
    /// Has a view taken again when a material of this kind that it may see changes, or a mesh is given one or
    /// another one. A texture that is written to is noticed if its material is marked as changed too.
    fn watch_material<M: Material>(&mut self) -> &mut Self;
}

impl WatchMaterial for App {
    fn watch_material<M: Material>(&mut self) -> &mut Self {
        let watch = watch::<M>.after(notice).before(drive_captures);
        self.add_systems(PostUpdate, watch)
    }
}

fn watch<M: Material>(
    mut changes: ResMut<SceneChanges>,
    mut events: MessageReader<AssetEvent<M>>,
    drawn: Query<(Ref<MeshMaterial3d<M>>, Option<&RenderLayers>)>,
) {
    let materials = modified(&mut events);
    for (material, layers) in &drawn {
        if material.is_changed() || materials.contains(&material.id()) {
            changes.add(layers);
        }
    }
}
