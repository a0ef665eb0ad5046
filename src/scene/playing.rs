//! A scene's own motion, played.
//!
//! Enters: the simulation's time. Leaves: the places of the scene's nodes, and its meshes in their shapes.
//!
//! Shapes are added up here and not by Bevy's morph targets: those of Bevy 0.19 take hold one frame after a
//! mesh has come into sight, and a view takes its picture in the first.

use super::model::SceneMesh;
use super::motion::{MovingMesh, NodePose, SceneMotion};
use super::spawn::ScenePart;
use crate::frame::SimulationClock;
use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use std::sync::Arc;

/// A scene that moves by itself, from time 0 on and again from its end.
#[derive(Component, Clone, Debug)]
pub struct PlayingScene {
    motion: Arc<SceneMotion>,
    nodes: Vec<Entity>,
    /// Meshes that take shapes, by their places in [`SceneMotion::meshes`], and with which weights.
    shaped: Vec<(usize, Handle<Mesh>, Vec<f32>)>,
}

/// A scene that moves, while it is spawned.
pub(super) struct Rig {
    playing: PlayingScene,
    skins: Vec<Handle<SkinnedMeshInverseBindposes>>,
}

impl Rig {
    /// Spawns the nodes of a scene that moves.
    pub(super) fn spawn(
        motion: &Arc<SceneMotion>,
        commands: &mut Commands,
        skins: &mut Assets<SkinnedMeshInverseBindposes>,
    ) -> Self {
        let mut nodes: Vec<Entity> = Vec::with_capacity(motion.nodes.len());
        for node in &motion.nodes {
            let place = (ScenePart, transform(&node.pose), Visibility::default());
            let mut entity = commands.spawn(place);
            if let Some(parent) = node.parent {
                entity.insert(ChildOf(nodes[parent]));
            }
            nodes.push(entity.id());
        }
        let binds = motion.skins.iter();
        Self {
            skins: binds
                .map(|skin| skins.add(skin.inverse_bind.clone()))
                .collect(),
            playing: PlayingScene {
                motion: motion.clone(),
                nodes,
                shaped: Vec::new(),
            },
        }
    }

    fn weights(&self, moving: &MovingMesh) -> &[f32] {
        &self.playing.motion.nodes[moving.node].weights
    }

    /// A mesh as it is at time 0 before nodes and joints move it.
    pub(super) fn unmoved(&self, mesh: &SceneMesh, moving: &MovingMesh) -> SceneMesh {
        let (positions, normals) = moving.shape(self.weights(moving));
        SceneMesh {
            positions,
            normals,
            ..mesh.clone()
        }
    }

    /// The same with its joints, and as one that is given other shapes.
    pub(super) fn bend(&self, mut mesh: Mesh, moving: &MovingMesh) -> Mesh {
        if let Some(held) = &moving.held {
            let joints = VertexAttributeValues::Uint16x4(held.joints.clone());
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, held.weights.clone());
        }
        if !moving.shapes.is_empty() {
            mesh.asset_usage = RenderAssetUsages::default();
        }
        mesh
    }

    /// Hangs a mesh on what moves it.
    pub(super) fn hang(
        &mut self,
        moving: &MovingMesh,
        mesh: Handle<Mesh>,
        entity: &mut EntityCommands,
    ) {
        let motion = &self.playing.motion;
        match &moving.held {
            Some(held) => {
                let joints = motion.skins[held.skin].joints.iter();
                entity.insert(SkinnedMesh {
                    inverse_bindposes: self.skins[held.skin].clone(),
                    joints: joints.map(|joint| self.playing.nodes[*joint]).collect(),
                });
            }
            None => {
                entity.insert(ChildOf(self.playing.nodes[moving.node]));
                let shaped = moving.shapes.iter().flat_map(|shape| {
                    let both = shape.positions.iter().zip(&moving.positions);
                    both.map(|(by, at)| Vec3::from(*by) + Vec3::from(*at))
                });
                let corners = moving.positions.iter().map(|corner| Vec3::from(*corner));
                if let Some(box_of_it) = Aabb::enclosing(corners.chain(shaped)) {
                    entity.insert(box_of_it);
                }
            }
        }
        let at = motion
            .meshes
            .iter()
            .position(|known| known.mesh == moving.mesh);
        if let Some(at) = at.filter(|_| !moving.shapes.is_empty()) {
            let weights = self.weights(moving).to_vec();
            self.playing.shaped.push((at, mesh, weights));
        }
    }

    /// Hangs a light on the node that carries it, if one does; both shine along their own −z.
    pub(super) fn carry(&self, light: usize, entity: &mut EntityCommands) {
        let mut carried = self.playing.motion.lights.iter();
        if let Some((_, node)) = carried.find(|(carried, _)| *carried == light) {
            entity.insert((ChildOf(self.playing.nodes[*node]), Transform::IDENTITY));
        }
    }

    /// Lets the scene begin.
    pub(super) fn begin(self, commands: &mut Commands) {
        commands.spawn((ScenePart, self.playing));
    }
}

fn transform(pose: &NodePose) -> Transform {
    Transform {
        translation: pose.translation,
        rotation: pose.rotation,
        scale: pose.scale,
    }
}

/// Moves scenes to where they are at this time.
pub fn play(
    clock: Res<SimulationClock>,
    mut played_s: Local<Option<f64>>,
    mut scenes: Query<&mut PlayingScene>,
    mut nodes: Query<&mut Transform>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let is_later = *played_s != Some(clock.time_s);
    *played_s = Some(clock.time_s);
    for mut scene in &mut scenes {
        if !is_later && !scene.is_added() {
            continue;
        }
        let scene = &mut *scene;
        let mut weighed: Vec<(usize, Vec<f32>)> = Vec::new();
        scene.motion.animation.pose(
            clock.time_s,
            |node, set| {
                let Ok(mut place) = nodes.get_mut(scene.nodes[node]) else {
                    return;
                };
                let mut pose = NodePose {
                    translation: place.translation,
                    rotation: place.rotation,
                    scale: place.scale,
                };
                set(&mut pose);
                place.set_if_neq(transform(&pose));
            },
            |node, weights| weighed.push((node, weights.to_vec())),
        );
        for (at, mesh, weights) in &mut scene.shaped {
            let moving = &scene.motion.meshes[*at];
            let Some((_, now)) = weighed.iter().find(|(node, _)| *node == moving.node) else {
                continue;
            };
            if now == weights {
                continue;
            }
            weights.clone_from(now);
            if let Some(mut mesh) = meshes.get_mut(&*mesh) {
                let (positions, normals) = moving.shape(now);
                mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
                mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
            }
        }
    }
}
