//! What of a scene moves by itself: nodes, and what they carry, bend and shape, along key frames.
//!
//! Enters: a time. Leaves: the place of every node and the weights of its meshes' shapes. Key frames and
//! their interpolation are those of glTF 2.0 (3.11 and appendix C).

use glam::{Mat4, Quat, Vec3};

/// What is nearer to a key frame than this is at it, s: sums of frame times differ in their last digits.
const TOLERANCE_S: f64 = 1e-6;

/// Everything that moves, and along what.
#[derive(Debug, Clone, Default)]
pub struct SceneMotion {
    /// The nodes that move, and those that carry them; whoever carries comes first.
    pub nodes: Vec<SceneNode>,
    /// Meshes that follow nodes.
    pub meshes: Vec<MovingMesh>,
    /// What bends meshes.
    pub skins: Vec<SceneSkin>,
    /// Lights that nodes carry: indices of the light and of the node.
    pub lights: Vec<(usize, usize)>,
    /// Its course.
    pub animation: SceneAnimation,
}

/// A place that may move, in that of its parent.
#[derive(Debug, Clone, Default)]
pub struct SceneNode {
    /// Name for messages.
    pub name: String,
    /// The index of the node that carries it.
    pub parent: Option<usize>,
    /// Where it is at time 0.
    pub pose: NodePose,
    /// Weights of the shapes of its mesh at time 0.
    pub weights: Vec<f32>,
}

/// Where a node is in its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodePose {
    /// Offset, m.
    pub translation: Vec3,
    /// Turn, of unit length.
    pub rotation: Quat,
    /// Size along its own axes.
    pub scale: Vec3,
}

impl Default for NodePose {
    fn default() -> Self {
        Self {
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
        }
    }
}

impl NodePose {
    /// Its parent's coordinates from its own.
    pub fn matrix(&self) -> Mat4 {
        Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// A mesh as it is before nodes, joints and shapes move it. Attributes have the order of those of the
/// [`SceneMesh`](super::model::SceneMesh) that it replaces, whose positions are those at time 0.
#[derive(Debug, Clone, Default)]
pub struct MovingMesh {
    /// Index of the mesh.
    pub mesh: usize,
    /// The node that carries it.
    pub node: usize,
    /// Positions in the node's frame, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals in the node's frame.
    pub normals: Vec<[f32; 3]>,
    /// Its triangles have vertices of their own, and normals that follow from them.
    pub is_flat: bool,
    /// What bends it; its node then carries it no more.
    pub held: Option<Held>,
    /// The shapes that it takes by the weights of its node.
    pub shapes: Vec<Shape>,
}

impl MovingMesh {
    /// Normals of vertices of which each three are a triangle.
    pub fn flat_normals(positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut normals = vec![[0.0, 1.0, 0.0]; positions.len()];
        for (corners, normals) in positions.chunks_exact(3).zip(normals.chunks_exact_mut(3)) {
            let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(corners[k]));
            normals.fill((b - a).cross(c - a).normalize_or(Vec3::Y).into());
        }
        normals
    }

    /// The least and the greatest corner of a box that holds it in every mixture of its shapes with weights
    /// from 0 to 1, in its own frame, m.
    pub fn extent(&self) -> [Vec3; 2] {
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for (vertex, at) in self.positions.iter().enumerate() {
            let (mut least, mut most) = (Vec3::from(*at), Vec3::from(*at));
            for shape in &self.shapes {
                let by = shape.positions.get(vertex).copied().unwrap_or_default();
                least += Vec3::from(by).min(Vec3::ZERO);
                most += Vec3::from(by).max(Vec3::ZERO);
            }
            (low, high) = (low.min(least), high.max(most));
        }
        [low, high]
    }

    /// Positions (m) and unit normals with these weights of its shapes.
    pub fn shape(&self, weights: &[f32]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        let (mut positions, mut normals) = (self.positions.clone(), self.normals.clone());
        let add = |to: &mut [[f32; 3]], by: &[[f32; 3]], weight: f32| {
            for (to, by) in to.iter_mut().zip(by) {
                *to = std::array::from_fn(|k| to[k] + weight * by[k]);
            }
        };
        for (shape, weight) in self.shapes.iter().zip(weights) {
            if *weight != 0.0 {
                add(&mut positions, &shape.positions, *weight);
                add(&mut normals, &shape.normals, *weight);
            }
        }
        if self.is_flat {
            normals = Self::flat_normals(&positions);
        } else if !self.shapes.is_empty() {
            for normal in &mut normals {
                *normal = Vec3::from(*normal).normalize_or(Vec3::Y).into();
            }
        }
        (positions, normals)
    }
}

/// How a skin holds a mesh.
#[derive(Debug, Clone, Default)]
pub struct Held {
    /// Index of the skin.
    pub skin: usize,
    /// Of each vertex, four of the skin's joints.
    pub joints: Vec<[u16; 4]>,
    /// Their shares; they add up to 1.
    pub weights: Vec<[f32; 4]>,
}

/// What a weight of 1 adds to each vertex.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// To positions, m.
    pub positions: Vec<[f32; 3]>,
    /// To normals.
    pub normals: Vec<[f32; 3]>,
}

/// Joints that bend meshes.
#[derive(Debug, Clone, Default)]
pub struct SceneSkin {
    /// Indices of their nodes.
    pub joints: Vec<usize>,
    /// From a mesh as it is stored to each joint's frame.
    pub inverse_bind: Vec<Mat4>,
}

/// A course of nodes that begins anew at its end.
#[derive(Debug, Clone, Default)]
pub struct SceneAnimation {
    /// Its name, for messages.
    pub name: String,
    /// What moves.
    pub channels: Vec<Channel>,
    /// Time of the last key frame, s.
    pub duration_s: f64,
}

/// One property of one node over time.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Index of the node.
    pub node: usize,
    /// The property.
    pub property: Property,
    /// Its values.
    pub keys: Keys,
}

/// What of a node an animation changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// [`NodePose::translation`].
    Translation,
    /// [`NodePose::rotation`].
    Rotation,
    /// [`NodePose::scale`].
    Scale,
    /// [`SceneNode::weights`].
    Weights,
}

/// How values between two key frames are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// They are those of the earlier one.
    Step,
    /// Along a straight line; rotations along the shorter arc.
    Linear,
    /// By a cubic Hermite spline with the tangents that stand around each value.
    CubicSpline,
}

/// Values at times.
#[derive(Debug, Clone)]
pub struct Keys {
    times_s: Vec<f32>,
    /// `width` numbers a key frame; with [`Interpolation::CubicSpline`] three times as many: tangent before, value,
    /// tangent after.
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

impl Keys {
    /// Key frames of `width` numbers each.
    ///
    /// # Errors
    /// The end of a sentence: times that do not rise from 0 on, another number of values than of times,
    /// numbers that are not finite.
    pub fn new(
        times_s: Vec<f32>,
        values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
    ) -> Result<Self, String> {
        // A NaN is after nothing.
        let follow = |pair: &[f32]| pair[1] > pair[0];
        if let Some(at) = times_s.windows(2).position(|pair| !follow(pair)) {
            return Err(format!(
                "key frame {} is at {} s, which is not after {} s",
                at + 1,
                times_s[at + 1],
                times_s[at]
            ));
        }
        let is_time = |time: &f32| time.is_finite() && *time >= 0.0;
        if let Some(time) = times_s.iter().find(|time| !is_time(time)) {
            return Err(format!("a key frame is at {time} s, but times begin at 0"));
        }
        let each = width
            * if interpolation == Interpolation::CubicSpline {
                3
            } else {
                1
            };
        if times_s.is_empty() || values.len() != times_s.len() * each {
            return Err(format!(
                "it has {} numbers for {} key frames of {each}",
                values.len(),
                times_s.len()
            ));
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err("a value of it is not a finite number".into());
        }
        Ok(Self {
            times_s,
            values,
            width,
            interpolation,
        })
    }

    /// Time of the last key frame, s.
    pub fn end_s(&self) -> f64 {
        self.times_s.last().map_or(0.0, |time| f64::from(*time))
    }

    /// Numbers of a value.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The value of a key frame.
    fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::CubicSpline => self.part(key, 1),
            _ => self.part(key, 0),
        }
    }

    fn part(&self, key: usize, part: usize) -> &[f32] {
        let parts = if self.interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        };
        let from = (key * parts + part) * self.width;
        &self.values[from..from + self.width]
    }

    /// The key frame before a time, the one after it, their distance (s) and the share of it that has passed; a
    /// time beyond the ends is at the end.
    fn around(&self, time_s: f64) -> (usize, usize, f32, f32) {
        let after = self
            .times_s
            .partition_point(|time| f64::from(*time) <= time_s + TOLERANCE_S);
        let last = self.times_s.len() - 1;
        if after == 0 {
            return (0, 0, 0.0, 0.0);
        }
        if after > last {
            return (last, last, 0.0, 0.0);
        }
        let [from, to] = [after - 1, after].map(|key| f64::from(self.times_s[key]));
        let share = ((time_s - from) / (to - from)).clamp(0.0, 1.0);
        (after - 1, after, (to - from) as f32, share as f32)
    }

    /// The value at a time, number by number.
    pub fn at(&self, time_s: f64) -> Vec<f32> {
        let (from, to, span_s, t) = self.around(time_s);
        let (a, b) = (self.value(from), self.value(to));
        let mix = |weigh: &dyn Fn(usize) -> f32| (0..self.width).map(weigh).collect();
        match self.interpolation {
            _ if from == to => a.to_vec(),
            Interpolation::Step => a.to_vec(),
            Interpolation::Linear => mix(&|k| a[k] + t * (b[k] - a[k])),
            Interpolation::CubicSpline => {
                let (out_of, into) = (self.part(from, 2), self.part(to, 0));
                let (t2, t3) = (t * t, t * t * t);
                // glTF 2.0, appendix C.5.
                mix(&|k| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[k]
                        + span_s * (t3 - 2.0 * t2 + t) * out_of[k]
                        + (3.0 * t2 - 2.0 * t3) * b[k]
                        + span_s * (t3 - t2) * into[k]
                })
            }
        }
    }

    /// The rotation at a time, of unit length; none where four zeros say nothing.
    fn rotation_at(&self, time_s: f64) -> Quat {
        self.unit_rotation_at(time_s).unwrap_or(Quat::IDENTITY)
    }

    fn unit_rotation_at(&self, time_s: f64) -> Option<Quat> {
        let unit = |v: &[f32]| {
            let v = Quat::from_slice(v);
            let length = v.length();
            (length.is_finite() && length > 1e-12).then(|| v / length)
        };
        if self.interpolation != Interpolation::Linear {
            return unit(&self.at(time_s));
        }
        let (from, to, _, t) = self.around(time_s);
        // Bevy's and the specification's both take the shorter arc.
        Some(unit(self.value(from))?.slerp(unit(self.value(to))?, t))
    }
}

impl SceneMotion {
    /// May a node be turned inside out, itself or by what carries it?
    pub fn may_mirror(&self, node: usize) -> bool {
        let chain = std::iter::successors(Some(node), |node| self.nodes[*node].parent);
        let scaled: Vec<usize> = chain.collect();
        self.animation.channels.iter().any(|channel| {
            channel.property == Property::Scale
                && scaled.contains(&channel.node)
                && channel.keys.values.iter().any(|value| *value < 0.0)
        })
    }
}

impl SceneAnimation {
    /// Where in its course it is at a time, s.
    pub fn course_s(&self, time_s: f64) -> f64 {
        if self.duration_s > 0.0 {
            (time_s + TOLERANCE_S).rem_euclid(self.duration_s)
        } else {
            0.0
        }
    }

    /// Sets what moves to where it is at a time (s, any): places and weights by node.
    pub fn pose(
        &self,
        time_s: f64,
        mut place: impl FnMut(usize, &dyn Fn(&mut NodePose)),
        mut weigh: impl FnMut(usize, &[f32]),
    ) {
        let course_s = self.course_s(time_s);
        for channel in &self.channels {
            let vector = || Vec3::from_slice(&channel.keys.at(course_s));
            match channel.property {
                Property::Translation => {
                    let translation = vector();
                    place(channel.node, &|pose| pose.translation = translation);
                }
                Property::Scale => {
                    let scale = vector();
                    place(channel.node, &|pose| pose.scale = scale);
                }
                Property::Rotation => {
                    let rotation = channel.keys.rotation_at(course_s);
                    place(channel.node, &|pose| pose.rotation = rotation);
                }
                Property::Weights => weigh(channel.node, &channel.keys.at(course_s)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f32::consts::FRAC_PI_2;

    fn keys(values: Vec<f32>, width: usize, interpolation: Interpolation) -> Keys {
        Keys::new(vec![1.0, 2.0, 4.0], values, width, interpolation).expect("sound key frames")
    }

    #[test]
    fn steps_wait_lines_are_straight_and_ends_hold() {
        let values = vec![0.0, 10.0, 30.0];
        let (step, line) = (
            keys(values.clone(), 1, Interpolation::Step),
            keys(values, 1, Interpolation::Linear),
        );
        for (time, stepped, straight) in [
            (-1.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (1.25, 0.0, 2.5),
            (2.0, 10.0, 10.0),
            (3.0, 10.0, 20.0),
            (9.0, 30.0, 30.0),
        ] {
            assert_eq!(step.at(time), [stepped]);
            assert_eq!(line.at(time), [straight]);
        }
    }

    /// A Hermite spline with the tangents of a cubic is that cubic.
    #[test]
    fn a_cubic_spline_follows_a_cubic() {
        let f = |t: f32| 0.5 * t * t * t - 2.0 * t * t + t - 3.0;
        let slope = |t: f32| 1.5 * t * t - 4.0 * t + 1.0;
        let values = [1.0, 2.0, 4.0].map(|t| [slope(t), f(t), slope(t)]).concat();
        let spline = keys(values, 1, Interpolation::CubicSpline);
        for n in 0..=30 {
            let t = 1.0 + n as f32 / 10.0;
            let found = spline.at(t.into())[0];
            // Single precision of numbers below 10.
            assert!((found - f(t)).abs() < 5e-6, "{found} at {t}, not {}", f(t));
        }
        // One parameter away: tangents that are not scaled by the span would miss it.
        assert!(
            (spline.at(3.0)[0] - (0.5 * (f(2.0) + f(4.0)) + 0.125 * (slope(2.0) - slope(4.0))))
                .abs()
                > 0.1
        );
    }

    #[test]
    fn rotations_take_the_shorter_arc_at_constant_speed() {
        let quarter = Quat::from_rotation_y(FRAC_PI_2);
        // The same turn, written with the other sign.
        let values = [Quat::IDENTITY, -quarter, quarter]
            .map(|q| q.to_array())
            .concat();
        let turned = keys(values, 4, Interpolation::Linear);
        for n in 0..=10 {
            let share = n as f32 / 10.0;
            let found = turned.rotation_at(1.0 + f64::from(share));
            let wanted = Quat::from_rotation_y(share * FRAC_PI_2);
            // Single precision of the arc's cosine.
            assert!(found.angle_between(wanted) < 1e-3, "{found} at {share}");
        }
        assert!(turned.rotation_at(3.0).angle_between(quarter) < 1e-3);
        let none = Keys::new(vec![0.0], vec![0.0; 4], 4, Interpolation::Step).expect("finite");
        assert_eq!(none.rotation_at(0.0), Quat::IDENTITY);
    }

    #[test]
    fn key_frames_that_make_no_course_are_refused() {
        let keys = |times: &[f32], values: &[f32]| {
            Keys::new(times.to_vec(), values.to_vec(), 1, Interpolation::Linear)
        };
        for (times, values, part) in [
            (&[0.0, 0.0][..], &[1.0, 2.0][..], "not after 0 s"),
            (&[0.0, f32::NAN], &[1.0, 2.0], "not after"),
            (&[-1.0, 0.0], &[1.0, 2.0], "-1 s"),
            (&[f32::NAN], &[1.0], "NaN s"),
            (&[0.0, 1.0], &[1.0], "1 numbers for 2"),
            (&[], &[], "0 numbers"),
            (&[0.0], &[f32::INFINITY], "finite"),
        ] {
            let said = keys(times, values).expect_err("no course");
            assert!(said.contains(part), "{said}");
        }
    }

    proptest! {
        #[test]
        fn whatever_the_time_values_are_finite(
            time in prop_oneof![any::<f64>().prop_filter("finite", |t| t.is_finite()), -5.0..20.0],
            values in prop::collection::vec(-1e6f32..1e6, 36),
        ) {
            let cubic = Keys::new(vec![0.5, 0.6, 7.0], values, 4, Interpolation::CubicSpline).expect("sound");
            let animation = SceneAnimation {
                duration_s: cubic.end_s(),
                channels: [Property::Rotation, Property::Weights]
                    .map(|property| Channel { node: 0, property, keys: cubic.clone() })
                    .into(),
                ..SceneAnimation::default()
            };
            let (mut pose, mut weights) = (NodePose::default(), Vec::new());
            animation.pose(time, |_, set| set(&mut pose), |_, found| weights = found.to_vec());
            prop_assert!(pose.matrix().is_finite() && weights.iter().all(|w| w.is_finite()));
        }
    }
}
