//! What moves along an animation (glTF 2.0, 3.7.2, 3.7.3.3).
//!
//! Enters: nodes that are placed as they are at time 0. Leaves: a [`SceneMotion`] with those alone that move or
//! carry what does.

use super::super::model::{SceneError, SceneMesh};
use super::super::motion::{Held, MovingMesh, NodePose, SceneMotion, SceneNode, SceneSkin, Shape};
use super::course::Course;
use super::{Source, accessors};
use crate::input_file::one_clause;
use glam::{Mat4, Vec3};
use gltf::{Node, Primitive, Semantic};
use std::collections::{HashMap, HashSet};

/// Most joints of a skin, and most shapes of a mesh, that Bevy moves.
const MOST: usize = 256;

/// A node in the scene: itself, where it is, whose child it is, and whether it moves.
pub(super) struct Placed<'a> {
    pub node: Node<'a>,
    pub world: Mat4,
    pub parent: Option<usize>,
    pub moves: bool,
}

/// Gathers what moves while a scene is read.
pub(super) struct Gathered {
    motion: SceneMotion,
    /// Indices of nodes by the file's.
    nodes: HashMap<usize, usize>,
    /// Indices of skins by the file's.
    skins: HashMap<usize, usize>,
    /// What a user should know.
    pub remarks: Vec<String>,
}

impl Gathered {
    /// Nodes that move, those that carry them, and all joints of skins that do.
    pub(super) fn new(
        placed: &[Placed],
        course: Course,
        unit_m: f32,
        source: &Source,
    ) -> Result<Self, SceneError> {
        let by_index: HashMap<usize, &Placed> = placed
            .iter()
            .map(|place| (place.node.index(), place))
            .collect();
        let mut needed = HashSet::new();
        let mut need = |node: usize| {
            let mut next = Some(node);
            while let Some(node) = next.filter(|node| needed.insert(*node)) {
                next = by_index.get(&node).and_then(|place| place.parent);
            }
        };
        let is_moved = |joint: &Node| {
            by_index
                .get(&joint.index())
                .is_some_and(|place| place.moves)
        };
        let mut skins: Vec<gltf::Skin> = Vec::new();
        for place in placed {
            if place.moves {
                need(place.node.index());
            }
            if let Some(skin) = place.node.skin()
                // Shapes may move where joints rest.
                && (place.moves || skin.joints().any(|joint| is_moved(&joint)))
            {
                // A mesh's own node has the weights of its shapes; a skin may hold the meshes of several.
                need(place.node.index());
                if skins.iter().all(|known| known.index() != skin.index()) {
                    skin.joints().for_each(|joint| need(joint.index()));
                    skins.push(skin);
                }
            }
        }
        let mut gathered = Self {
            motion: SceneMotion::default(),
            nodes: HashMap::new(),
            skins: HashMap::new(),
            remarks: Vec::new(),
        };
        if needed.is_empty() {
            return Ok(gathered);
        }
        gathered.motion.nodes.push(SceneNode {
            name: "unit".into(),
            pose: NodePose {
                scale: Vec3::splat(unit_m),
                ..NodePose::default()
            },
            ..SceneNode::default()
        });
        // Whoever carries comes first here too.
        for place in placed
            .iter()
            .filter(|place| needed.contains(&place.node.index()))
        {
            let node = &place.node;
            let carrier = place
                .parent
                .and_then(|parent| gathered.nodes.get(&parent).copied());
            gathered
                .nodes
                .insert(node.index(), gathered.motion.nodes.len());
            gathered.motion.nodes.push(SceneNode {
                name: node.name().unwrap_or_default().to_owned(),
                parent: Some(carrier.unwrap_or(0)),
                pose: course.pose_of(node),
                weights: course.weights_of(node),
            });
        }
        for skin in skins {
            gathered.add_skin(&skin, source)?;
        }
        gathered.motion.animation = course.animation;
        let nodes = &gathered.nodes;
        // What lies outside of the scene that is shown moves nothing in it.
        gathered.motion.animation.channels.retain_mut(|channel| {
            nodes.get(&channel.node).is_some_and(|node| {
                channel.node = *node;
                true
            })
        });
        Ok(gathered)
    }

    fn add_skin(&mut self, skin: &gltf::Skin, source: &Source) -> Result<(), SceneError> {
        let joints: Vec<usize> = skin
            .joints()
            .filter_map(|joint| self.nodes.get(&joint.index()).copied())
            .collect();
        let count = skin.joints().count();
        if joints.len() != count || count > MOST {
            self.remarks.push(format!(
                "\"{}\": skin {} has {count} joints, more than {MOST} or some outside of the scene: it and what it holds rest.",
                source.name,
                skin.index()
            ));
            return Ok(());
        }
        let bind = skin
            .inverse_bind_matrices()
            .map(|accessor| {
                accessors::read::<16>(source, &accessor, "inverse bind matrices", false)
            })
            .transpose()?
            .unwrap_or_default();
        let inverse_bind = (0..count)
            .map(|at| bind.get(at).map_or(Mat4::IDENTITY, Mat4::from_cols_array))
            .collect();
        self.skins.insert(skin.index(), self.motion.skins.len());
        self.motion.skins.push(SceneSkin {
            joints,
            inverse_bind,
        });
        Ok(())
    }

    /// Takes in a mesh that moves; `order` says which of the file's vertices each of its is, where that is not
    /// the same.
    pub(super) fn add_mesh(
        &mut self,
        place: &Placed,
        primitive: &Primitive,
        (index, mesh): (usize, &SceneMesh),
        order: Option<&[u32]>,
        source: &Source,
    ) -> Result<(), SceneError> {
        let node = &place.node;
        // What has no joints hangs on its node, whatever skin that has.
        let is_held = primitive.get(&Semantic::Joints(0)).is_some();
        let own = node.skin().filter(|_| is_held);
        let skin = own
            .as_ref()
            .and_then(|skin| self.skins.get(&skin.index()).copied());
        let (Some(&carrier), true) = (
            self.nodes.get(&node.index()),
            // A skin that rests leaves its mesh where it is.
            skin.is_some() || (place.moves && own.is_none()),
        ) else {
            return Ok(());
        };
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let positions = accessors::read::<3>(source, &positions, "positions", false)?;
        let count = positions.len();
        let pick = |all: Vec<[f32; 3]>| picked(all, order);
        let normals = primitive
            .get(&Semantic::Normals)
            .map(|accessor| accessors::read::<3>(source, &accessor, "normals", true))
            .transpose()?
            .filter(|normals| normals.len() == count);
        let positions = pick(positions);
        let normals = match normals {
            Some(normals) => pick(normals)
                .into_iter()
                .map(|normal| Vec3::from(normal).normalize_or(Vec3::Y).into())
                .collect(),
            None => MovingMesh::flat_normals(&positions),
        };
        let mut shapes = Vec::new();
        for target in primitive.morph_targets().take(MOST) {
            let read = |accessor: Option<gltf::Accessor>| -> Result<_, SceneError> {
                let read = accessor
                    .map(|a| accessors::read::<3>(source, &a, "morph target", false))
                    .transpose()?
                    .filter(|by| by.len() == count && by.iter().flatten().all(|x| x.is_finite()));
                Ok(pick(read.unwrap_or_else(|| vec![[0.0; 3]; count])))
            };
            shapes.push(Shape {
                positions: read(target.positions())?,
                normals: read(target.normals())?,
            });
        }
        if primitive.morph_targets().count() > MOST {
            self.remarks.push(format!(
                "\"{}\": mesh \"{}\" has more than {MOST} shapes; the rest of them is left out.",
                source.name,
                one_clause(&mesh.name)
            ));
        }
        let held = match skin {
            Some(skin) => {
                let joints = self.motion.skins[skin].joints.len();
                let (joints, weights) = strongest(primitive, count, joints, source)?;
                Some(Held {
                    skin,
                    joints: picked(joints, order),
                    weights: picked(weights, order),
                })
            }
            None => None,
        };
        self.motion.meshes.push(MovingMesh {
            mesh: index,
            node: carrier,
            positions,
            normals,
            is_flat: order.is_some(),
            held,
            shapes,
        });
        Ok(())
    }

    /// A light that a node carries.
    pub(super) fn add_light(&mut self, place: &Placed, light: usize) {
        if let (true, Some(node)) = (place.moves, self.nodes.get(&place.node.index())) {
            self.motion.lights.push((light, *node));
        }
    }

    /// What moves, if anything does.
    pub(super) fn finish(self) -> Option<SceneMotion> {
        let moves = !self.motion.meshes.is_empty() || !self.motion.lights.is_empty();
        (moves && !self.motion.animation.channels.is_empty()).then_some(self.motion)
    }
}

fn picked<T: Copy>(all: Vec<T>, order: Option<&[u32]>) -> Vec<T> {
    match order {
        Some(order) => order.iter().map(|&i| all[i as usize]).collect(),
        None => all,
    }
}

/// Four joints of each vertex, and their shares.
type Four = (Vec<[u16; 4]>, Vec<[f32; 4]>);

/// The four joints that hold each vertex most.
fn strongest(
    primitive: &Primitive,
    count: usize,
    joints: usize,
    source: &Source,
) -> Result<Four, SceneError> {
    let mut held: Vec<Vec<(f32, u16)>> = vec![Vec::new(); count];
    for set in 0.. {
        let (Some(names), Some(shares)) = (
            primitive.get(&Semantic::Joints(set)),
            primitive.get(&Semantic::Weights(set)),
        ) else {
            break;
        };
        let names = accessors::read::<4>(source, &names, "joints", false)?;
        let shares = accessors::read::<4>(source, &shares, "weights", true)?;
        for (held, (names, shares)) in held.iter_mut().zip(names.iter().zip(&shares)) {
            let both = shares.iter().zip(names);
            held.extend(
                both.filter(|(share, name)| **share > 0.0 && (**name as usize) < joints)
                    .map(|(share, name)| (*share, *name as u16)),
            );
        }
    }
    let four = held.into_iter().map(|mut held| {
        held.sort_by(|a, b| b.0.total_cmp(&a.0));
        held.resize(4, (0.0, 0));
        let sum: f32 = held.iter().map(|(share, _)| share).sum();
        let share = |k: usize| {
            if sum > 0.0 {
                held[k].0 / sum
            } else {
                // Held by nothing: where the first joint is.
                f32::from(u8::from(k == 0))
            }
        };
        (
            std::array::from_fn(|k| held[k].1),
            std::array::from_fn(share),
        )
    });
    Ok(four.unzip())
}
