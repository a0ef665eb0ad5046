//! A file's animation (glTF 2.0, 3.11): its key frames, and where they put nodes at time 0.
//!
//! A file's first animation that moves anything is the one that is played.

use super::super::model::SceneError;
use super::super::motion::{Channel, Interpolation, Keys, NodePose, Property, SceneAnimation};
use super::{Source, accessors};
use crate::input_file::one_clause;
use glam::{Mat4, Quat};
use gltf::accessor::DataType;
use gltf::json::validation::Checked;
use gltf::{Document, Node, animation};
use std::collections::HashMap;

/// A file's animation: what it moves, by the file's own numbers of nodes.
pub(super) struct Course {
    pub(super) animation: SceneAnimation,
    poses: HashMap<usize, NodePose>,
    weights: HashMap<usize, Vec<f32>>,
    /// What of it is not played, one sentence each.
    pub(super) remarks: Vec<String>,
}

impl Course {
    /// Where a node is in its parent at time 0.
    pub(super) fn place_of(&self, node: &Node) -> Mat4 {
        match self.poses.get(&node.index()) {
            Some(pose) => pose.matrix(),
            None => Mat4::from_cols_array_2d(&node.transform().matrix()),
        }
    }

    /// The same as offset, turn and size.
    pub(super) fn pose_of(&self, node: &Node) -> NodePose {
        let known = self.poses.get(&node.index()).copied();
        known.unwrap_or_else(|| pose_of(node))
    }

    /// Weights of the shapes of a node's mesh at time 0.
    pub(super) fn weights_of(&self, node: &Node) -> Vec<f32> {
        let rest = || {
            let own = node.weights();
            own.or_else(|| node.mesh()?.weights())
                .unwrap_or(&[])
                .to_vec()
        };
        let known = self.weights.get(&node.index()).cloned();
        known.unwrap_or_else(rest)
    }

    /// Does it move this node by itself?
    pub(super) fn moves(&self, node: &Node) -> bool {
        let node = node.index();
        self.animation.duration_s > 0.0
            && (self.poses.contains_key(&node) || self.weights.contains_key(&node))
    }
}

/// The animation that is played: the first that moves anything.
pub(super) fn played(document: &Document) -> Option<animation::Animation<'_>> {
    let mut all = document.animations();
    all.find(|animation| animation.channels().next().is_some())
}

/// Reads the animation that is played, if there is one.
pub(super) fn read_course(document: &Document, source: &Source) -> Course {
    let mut course = Course {
        animation: SceneAnimation::default(),
        poses: HashMap::new(),
        weights: HashMap::new(),
        remarks: Vec::new(),
    };
    let Some(found) = played(document) else {
        return course;
    };
    let name = found
        .name()
        .map_or_else(|| "animation 0".to_owned(), one_clause_of);
    for channel in found.channels() {
        // The reader stops the program where it is asked for a target that glTF has no name for.
        let read = if has_known_target(document, &found, &channel) {
            read_channel(&channel, source)
        } else {
            Err("what it moves is none of translation, rotation, scale and weights".into())
        };
        match read {
            Ok(read) => course.animation.channels.push(read),
            // What is wrong with how a thing moves keeps nobody from seeing it.
            Err(fault) => course.remarks.push(format!(
                "\"{}\": channel {} of its animation \"{name}\" is not played: {fault}.",
                source.name,
                channel.index()
            )),
        }
    }
    let ends = course
        .animation
        .channels
        .iter()
        .map(|channel| channel.keys.end_s());
    course.animation.duration_s = ends.fold(0.0, f64::max);
    course.animation.name = name;
    for channel in &course.animation.channels {
        let node = document.nodes().nth(channel.node);
        if let (Some(node), true) = (node, channel.property != Property::Weights) {
            course.poses.insert(channel.node, pose_of(&node));
        }
    }
    let Course {
        animation,
        poses,
        weights,
        ..
    } = &mut course;
    animation.pose(
        0.0,
        |node, set| set(poses.entry(node).or_default()),
        |node, now| {
            weights.insert(node, now.to_vec());
        },
    );
    course
}

fn has_known_target(
    document: &Document,
    of: &animation::Animation,
    channel: &animation::Channel,
) -> bool {
    let animation = document.as_json().animations.get(of.index());
    let known = animation.and_then(|own| own.channels.get(channel.index()));
    known.is_some_and(|known| matches!(known.target.path, Checked::Valid(_)))
}

fn one_clause_of(name: &str) -> String {
    one_clause(&name)
}

/// Where a node is in its parent, animations aside.
fn pose_of(node: &Node) -> NodePose {
    let (translation, rotation, scale) = node.transform().decomposed();
    let rotation = Quat::from_array(rotation);
    NodePose {
        translation: translation.into(),
        rotation: if rotation.length_squared() > 1e-12 {
            rotation.normalize()
        } else {
            Quat::IDENTITY
        },
        scale: scale.into(),
    }
}

/// One channel, or what is wrong with it.
fn read_channel(channel: &animation::Channel, source: &Source) -> Result<Channel, String> {
    let (sampler, target) = (channel.sampler(), channel.target());
    let node = target.node();
    let (property, width) = match target.property() {
        animation::Property::Translation => (Property::Translation, 3),
        animation::Property::Rotation => (Property::Rotation, 4),
        animation::Property::Scale => (Property::Scale, 3),
        animation::Property::MorphTargetWeights => {
            let mesh = node.mesh();
            let primitive = mesh.as_ref().and_then(|mesh| mesh.primitives().next());
            (
                Property::Weights,
                primitive.map_or(0, |p| p.morph_targets().count()),
            )
        }
    };
    if width == 0 {
        return Err("it weights morph targets, and its mesh has none".into());
    }
    let times = sampler.input();
    if times.data_type() != DataType::F32 {
        return Err(format!(
            "accessor {} (times of key frames) holds whole numbers, where glTF has seconds as floats",
            times.index()
        ));
    }
    let times =
        accessors::read::<1>(source, &times, "times of key frames", false).map_err(reason)?;
    let (output, what) = (sampler.output(), "values of key frames");
    let values = match property {
        Property::Weights => accessors::read::<1>(source, &output, what, true).map(|v| v.concat()),
        Property::Rotation => accessors::read::<4>(source, &output, what, true).map(|v| v.concat()),
        Property::Translation | Property::Scale => {
            accessors::read::<3>(source, &output, what, false).map(|v| v.concat())
        }
    }
    .map_err(reason)?;
    let interpolation = match sampler.interpolation() {
        animation::Interpolation::Linear => Interpolation::Linear,
        animation::Interpolation::Step => Interpolation::Step,
        animation::Interpolation::CubicSpline => Interpolation::CubicSpline,
    };
    let keys = Keys::new(times.concat(), values, width, interpolation)?;
    Ok(Channel {
        node: node.index(),
        property,
        keys,
    })
}

/// What is wrong, without the file's name, which stands before it.
fn reason(error: SceneError) -> String {
    match error {
        SceneError::Malformed { reason, .. } => reason,
        other => other.to_string(),
    }
}
