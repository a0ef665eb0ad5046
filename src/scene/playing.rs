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
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use std::sync::Arc;

/// A scene that moves by itself, from time 0 on and again from its end.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque, Component)]
pub struct PlayingScene {
    motion: Arc<SceneMotion>,
    nodes: Vec<Entity>,
    /// Meshes that are made anew as they move.
    remade: Vec<Remade>,
}

/// A mesh that takes shapes, or is turned inside out by a scale below 0.
#[derive(Clone, Debug)]
struct Remade {
    /// Its place in [`SceneMotion::meshes`].
    at: usize,
    entity: Entity,
    mesh: Handle<Mesh>,
    /// The weights of its shapes, as it is.
    weights: Vec<f32>,
    /// Whether it is turned inside out, as it is.
    is_mirrored: bool,
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
                remade: Vec::new(),
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
            // What each joint holds keeps its sharpness as it moves; of a mesh that none holds there is nothing.
            let _ = mesh.generate_skinned_mesh_bounds();
        }
        if self.is_remade(moving) {
            mesh.asset_usage = RenderAssetUsages::default();
        }
        mesh
    }

    fn is_remade(&self, moving: &MovingMesh) -> bool {
        !moving.shapes.is_empty() || self.playing.motion.may_mirror(moving.node)
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
                if let Some(box_of_it) = Aabb::enclosing(moving.extent()) {
                    entity.insert(box_of_it);
                }
            }
        }
        let found = motion
            .meshes
            .iter()
            .position(|known| known.mesh == moving.mesh);
        if let Some(at) = found.filter(|_| self.is_remade(moving)) {
            let remade = Remade {
                at,
                entity: entity.id(),
                mesh,
                weights: self.weights(moving).to_vec(),
                is_mirrored: is_mirrored(motion, moving.node, |node| motion.nodes[node].pose.scale),
            };
            self.playing.remade.push(remade);
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
    mut drawn: Query<&mut Mesh3d>,
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
        let (motion, entities) = (&scene.motion, &scene.nodes);
        let scale_of = |node: usize| {
            nodes
                .get(entities[node])
                .map_or(Vec3::ONE, |place| place.scale)
        };
        for remade in &mut scene.remade {
            let moving = &motion.meshes[remade.at];
            let is_mirrored = is_mirrored(motion, moving.node, scale_of);
            let found = weighed.iter().find(|(node, _)| *node == moving.node);
            let weights = found.map_or(&remade.weights, |(_, now)| now).clone();
            if weights == remade.weights && is_mirrored == remade.is_mirrored {
                continue;
            }
            let Some(mut mesh) = meshes.get_mut(&remade.mesh) else {
                continue;
            };
            // Whoever looks is told in this frame; that the mesh is another is known a frame later.
            if let Ok(mut drawn) = drawn.get_mut(remade.entity) {
                drawn.set_changed();
            }
            if weights != remade.weights {
                let (positions, normals) = moving.shape(&weights);
                mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
                mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
                remade.weights = weights;
            }
            if is_mirrored != remade.is_mirrored {
                turn_round(&mut mesh);
                remade.is_mirrored = is_mirrored;
            }
        }
    }
}

/// Is a node mirrored by its own scale and those of what carries it?
fn is_mirrored(motion: &SceneMotion, node: usize, scale_of: impl Fn(usize) -> Vec3) -> bool {
    let chain = std::iter::successors(Some(node), |node| motion.nodes[*node].parent);
    let mirrors = chain.filter(|node| scale_of(*node).element_product() < 0.0);
    mirrors.count() % 2 == 1
}

/// Lets triangles go round the other way: what is outside of a mirrored mesh would be culled (glTF 2.0,
/// 3.7.4).
fn turn_round(mesh: &mut Mesh) {
    if let Some(Indices::U32(indices)) = mesh.indices_mut() {
        indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    }
}
