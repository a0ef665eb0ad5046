//! The head before a scene: where it is, and paths that it walks.
//!
//! Enters: a path file (RON), or whoever moves [`Head`]. Leaves: the place of the camera that sees.

use super::Stage;
use crate::anatomy::{Laterality, Patient};
use crate::frame::SimulationClock;
use crate::input_file::notation::{self, Fault, FaultKind};
use crate::input_file::read_input_file;
use crate::scene::catalog::LoadedScene;
use bevy::prelude::*;
use serde::Deserialize;
use std::path::Path;

/// Farthest that a head goes from where the scene puts it, m along each axis.
pub const FARTHEST_M: f32 = 100.0;
/// Farthest that a head bends up or down, degrees.
pub const STEEPEST_DEG: f32 = 80.0;
/// Largest file of a path, bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Where the head is and faces, against where the scene puts it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Head {
    /// Metres to the right, up and forwards, along the directions in which the scene puts it.
    pub place_m: Vec3,
    /// Turned to the right, degrees.
    pub yaw_deg: f32,
    /// Bent up, degrees, −80 to 80.
    pub pitch_deg: f32,
}

impl Head {
    /// The same head within its bounds.
    pub fn clamped(self) -> Self {
        let place_m = self
            .place_m
            .clamp(Vec3::splat(-FARTHEST_M), Vec3::splat(FARTHEST_M));
        Self {
            place_m: if place_m.is_finite() {
                place_m
            } else {
                Vec3::ZERO
            },
            yaw_deg: if self.yaw_deg.is_finite() {
                self.yaw_deg % 360.0
            } else {
                0.0
            },
            pitch_deg: if self.pitch_deg.is_finite() {
                self.pitch_deg.clamp(-STEEPEST_DEG, STEEPEST_DEG)
            } else {
                0.0
            },
        }
    }

    /// Walks by so many metres to the right and forwards, as the head faces.
    pub fn walk(&mut self, right_m: f32, forwards_m: f32) {
        let (sine, cosine) = self.yaw_deg.to_radians().sin_cos();
        self.place_m += Vec3::new(
            right_m * cosine + forwards_m * sine,
            0.0,
            forwards_m * cosine - right_m * sine,
        );
        *self = self.clamped();
    }

    /// In the frame in which the scene puts the head: x right, y up, −z forwards.
    fn transform(&self) -> Transform {
        Transform {
            translation: self.place_m * Vec3::new(1.0, 1.0, -1.0),
            rotation: Quat::from_rotation_y(-self.yaw_deg.to_radians())
                * Quat::from_rotation_x(self.pitch_deg.to_radians()),
            scale: Vec3::ONE,
        }
    }
}

/// Where the scene puts the head.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Seat(pub Transform);

/// One moment of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Reflect)]
#[serde(deny_unknown_fields)]
pub struct HeadKey {
    /// Time, s, 0 to 3600, above that of the key before.
    pub time_s: f64,
    /// To the right, m, −100 to 100.
    #[serde(default)]
    pub right_m: f64,
    /// Up, m, −100 to 100.
    #[serde(default)]
    pub up_m: f64,
    /// Forwards, m, −100 to 100.
    #[serde(default)]
    pub forward_m: f64,
    /// Turned to the right, degrees, −360 to 360.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Bent up, degrees, −80 to 80.
    #[serde(default)]
    pub pitch_deg: f64,
}

/// Farthest that a key is, m along each axis, and most that it turns, degrees.
const FARTHEST_KEY_M: f64 = FARTHEST_M as f64;
const MOST_TURN_DEG: f64 = 360.0;
/// Latest that a key is, s.
const LATEST_S: f64 = 3600.0;

impl HeadKey {
    fn values(&self) -> [f32; 5] {
        [
            self.right_m,
            self.up_m,
            self.forward_m,
            self.yaw_deg,
            self.pitch_deg,
        ]
        .map(|value| value as f32)
    }

    /// Its numbers with their ranges.
    fn numbers(&self) -> [(&'static str, f64, f64, f64); 6] {
        let place = |name, value| (name, value, -FARTHEST_KEY_M, FARTHEST_KEY_M);
        let steepest = f64::from(STEEPEST_DEG);
        [
            ("time_s", self.time_s, 0.0, LATEST_S),
            place("right_m", self.right_m),
            place("up_m", self.up_m),
            place("forward_m", self.forward_m),
            ("yaw_deg", self.yaw_deg, -MOST_TURN_DEG, MOST_TURN_DEG),
            ("pitch_deg", self.pitch_deg, -steepest, steepest),
        ]
    }
}

/// A way that a head goes; on the camera that sees it moves [`Head`] with the clock.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct HeadPath(Vec<HeadKey>);

/// The path that comes with the program, and its text.
const BUILT_IN: (&str, &str) = ("walk", include_str!("../../assets/head_paths/walk.ron"));

/// Why a path could not be read.
#[derive(Debug, thiserror::Error)]
#[error("head path {file}:{}{reason}", if reason.starts_with(|c: char| c.is_ascii_digit()) { "" } else { " " })]
pub struct HeadPathError {
    file: String,
    reason: String,
    is_list: bool,
}

impl HeadPathError {
    /// Is the file a list, as a path is?
    pub fn is_list(&self) -> bool {
        self.is_list
    }
}

/// Does this text begin a list, after its comments?
pub(crate) fn begins_list(text: &str) -> bool {
    text.lines()
        .map(str::trim_start)
        .find(|line| !line.is_empty() && !line.starts_with("//"))
        .is_some_and(|line| line.starts_with('['))
}

/// What is wrong in a path's text.
fn clause(fault: &Fault) -> String {
    let field = fault.field();
    let name = fault.path.last().map_or("", String::as_str);
    let number = HeadKey::default()
        .numbers()
        .into_iter()
        .find(|(own, ..)| *own == name);
    let reason = match (&fault.kind, number) {
        (FaultKind::Value { found }, Some((_, _, low, high))) => {
            notation::not_allowed(&field, found, &format!("a number, {low} to {high}"))
        }
        (FaultKind::Notation(clause), _) => clause.clone(),
        (FaultKind::UnknownField { found, known }, _) => format!(
            "unknown field {found:?} in {field}; the fields of a moment are {}",
            known.join(", ")
        ),
        (FaultKind::Twice { field: twice }, _) => format!("{twice} is given twice in {field}"),
        (FaultKind::Missing { field: missing }, _) => format!("{missing} is missing in {field}"),
        _ => "it must be a list such as [(time_s: 0.0), (time_s: 2.0, forward_m: 1.0, yaw_deg: 20.0)]".into(),
    };
    format!("{}:{}: {reason}", fault.line, fault.column)
}

impl HeadPath {
    /// Reads a path from a file. Where there is none of this name, `walk` and `walk.ron` are the walk that
    /// comes with the program.
    ///
    /// # Errors
    /// One sentence that names the file and what is wrong in it.
    pub fn load(path: &Path) -> Result<Self, HeadPathError> {
        let file = path.display().to_string();
        let refused = |reason: String| HeadPathError {
            file: file.clone(),
            reason,
            is_list: false,
        };
        let (name, text) = BUILT_IN;
        let is_built_in = path == Path::new(name) || path == Path::new(name).with_extension("ron");
        if is_built_in && !path.is_file() {
            return Self::parse(text).map_err(refused);
        }
        let bytes = read_input_file(path, MAX_FILE_BYTES).map_err(|error| {
            refused(match error.kind() {
                std::io::ErrorKind::NotFound => {
                    format!("it does not exist; the path that comes with the program is {name}")
                }
                _ => error.to_string(),
            })
        })?;
        let text = String::from_utf8(bytes).map_err(|_| refused("it is not UTF-8 text".into()))?;
        Self::parse(&text).map_err(|reason| HeadPathError {
            is_list: begins_list(&text),
            ..refused(reason)
        })
    }

    /// Reads a path from RON text: a list of keys.
    ///
    /// # Errors
    /// A clause about what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let keys: Vec<HeadKey> = notation::read(text).map_err(|fault| clause(&fault))?;
        if keys.is_empty() {
            return Err("it has no moments".into());
        }
        let mut before_s = -1.0;
        for (index, key) in keys.iter().enumerate() {
            let place = index + 1;
            // A NaN is in no range.
            if let Some((name, value, low, high)) = key
                .numbers()
                .into_iter()
                .find(|(_, value, low, high)| !(low..=high).contains(&value))
            {
                return Err(format!(
                    "[{place}].{name} = {value} is out of range; allowed: {low} to {high}"
                ));
            }
            if key.time_s <= before_s {
                return Err(format!(
                    "[{place}].time_s = {} must come after that of the moment before, {before_s}",
                    key.time_s
                ));
            }
            before_s = key.time_s;
        }
        Ok(Self(keys))
    }

    /// How many moments it names, 1 and more.
    pub fn moments(&self) -> usize {
        self.0.len()
    }

    /// When its last moment is, s.
    pub fn end_s(&self) -> f64 {
        self.0.last().map_or(0.0, |key| key.time_s)
    }

    /// Where the head is at a time: on a smooth curve through the keys, and at rest before the first and
    /// after the last.
    pub fn at(&self, time_s: f64) -> Head {
        let after = self.0.partition_point(|key| key.time_s <= time_s);
        let values = match (after.checked_sub(1), self.0.get(after)) {
            (None, Some(first)) => first.values(),
            (Some(last), None) => self.0[last].values(),
            (Some(from), Some(_)) => self.between(from, time_s),
            (None, None) => [0.0; 5],
        };
        let [right, up, forwards, yaw_deg, pitch_deg] = values;
        Head {
            place_m: Vec3::new(right, up, forwards),
            yaw_deg,
            pitch_deg,
        }
        .clamped()
    }

    /// The monotone cubic between two keys (Fritsch and Butland 1984): it goes beyond neither, starts and ends at rest, and rests
    /// where a key has what its neighbour has.
    fn between(&self, from: usize, time_s: f64) -> [f32; 5] {
        let keys = &self.0;
        let (a, b) = (&keys[from], &keys[from + 1]);
        let span_s = (b.time_s - a.time_s) as f32;
        let u = ((time_s - a.time_s) / (b.time_s - a.time_s)) as f32;
        // Rise a second from one key to the next, and how long it takes.
        let rise = |at: usize, channel: usize| {
            let span_s = (keys[at + 1].time_s - keys[at].time_s) as f32;
            let rise = keys[at + 1].values()[channel] - keys[at].values()[channel];
            (rise / span_s, span_s)
        };
        let slope = |at: usize, channel: usize| -> f32 {
            if at == 0 || at + 1 == keys.len() {
                return 0.0;
            }
            let ((before, before_s), (after, after_s)) = (rise(at - 1, channel), rise(at, channel));
            if before * after <= 0.0 {
                return 0.0;
            }
            // The harmonic mean, the shorter side counting more.
            let (w, v) = (2.0 * after_s + before_s, after_s + 2.0 * before_s);
            (w + v) / (w / before + v / after)
        };
        let (u2, u3) = (u * u, u * u * u);
        std::array::from_fn(|channel| {
            let (p, q) = (a.values()[channel], b.values()[channel]);
            let [m, n] = [from, from + 1].map(|at| span_s * slope(at, channel));
            (2.0 * u3 - 3.0 * u2 + 1.0) * p
                + (u3 - 2.0 * u2 + u) * m
                + (3.0 * u2 - 2.0 * u3) * q
                + (u3 - u2) * n
        })
    }
}

/// A head on a path goes with the clock.
pub(super) fn follow_path(clock: Res<SimulationClock>, mut heads: Query<(&HeadPath, &mut Head)>) {
    for (path, mut head) in &mut heads {
        head.set_if_neq(path.at(clock.time_s));
    }
}

/// Puts the camera that sees where the head is: a scene is seen by its right eye, or by the left one, if that leads, as far
/// to the left of it as the eyes are apart. A photograph is as it was taken, whichever eye looks at it.
pub(super) fn place_head(
    stage: Res<Stage>,
    people: Query<&Patient>,
    mut heads: Query<(&Head, &Seat, &mut Transform)>,
) {
    let Ok((head, seat, mut transform)) = heads.get_mut(stage.view) else {
        return;
    };
    let aside_m = match (&*stage.scene, people.get(stage.patient)) {
        (LoadedScene::Model(_), Ok(person)) if person.leading == Laterality::OS => {
            -person.interpupillary_mm * 1e-3
        }
        _ => 0.0,
    };
    let mut place = seat.0;
    if *head != Head::default() {
        place = place * head.transform();
    }
    if aside_m != 0.0 {
        place = place * Transform::from_xyz(aside_m as f32, 0.0, 0.0);
    }
    transform.set_if_neq(place);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_goes_through_its_keys_and_rests_at_its_ends() {
        let text = "[(time_s: 1.0), (time_s: 2.0, forward_m: 1.0, yaw_deg: 30.0), (time_s: 4.0, right_m: 2.0)]";
        let path = HeadPath::parse(text).expect("sound");
        assert_eq!(path.at(0.0), Head::default());
        assert_eq!(path.at(1.0), Head::default());
        let middle = path.at(2.0);
        assert_eq!((middle.place_m, middle.yaw_deg), (Vec3::Z, 30.0));
        assert_eq!(path.at(9.0).place_m, Vec3::X * 2.0);
        assert_eq!(path.at(f64::INFINITY).place_m, Vec3::X * 2.0);
        // No step, and no jump of the slope at a key.
        let place = |t: f64| path.at(t).place_m;
        let slope = |t: f64| (place(t + 1e-3) - place(t - 1e-3)) / 2e-3;
        assert!((slope(1.999) - slope(2.001)).length() < 0.02);
        assert!(slope(1.0).length() < 0.02);
    }

    #[test]
    fn a_path_goes_beyond_none_of_its_keys_and_rests_between_equal_ones() {
        let path = HeadPath::parse(
            "[(time_s: 0), (time_s: 1), (time_s: 2, yaw_deg: 180), (time_s: 2.1, yaw_deg: 190), (time_s: 9, yaw_deg: 191)]",
        )
        .expect("sound");
        let mut last = 0.0;
        for step in 0..=900 {
            let time_s = f64::from(step) * 0.01;
            let yaw = path.at(time_s).yaw_deg;
            assert!(
                yaw > last - 1e-3 && yaw < 191.0 + 1e-3,
                "{time_s}: {yaw} after {last}"
            );
            assert!(time_s > 1.0 || yaw == 0.0, "{time_s}: {yaw}");
            last = yaw;
        }
        assert!((path.at(2.0).yaw_deg - 180.0).abs() < 1e-3);
    }

    #[test]
    fn a_walk_comes_with_the_program() {
        let walk = HeadPath::load(Path::new("walk")).expect("built in");
        assert_eq!(
            walk,
            HeadPath::load(Path::new("walk.ron")).expect("built in")
        );
        assert_eq!(
            (walk.at(0.0), walk.at(4.0)),
            (Head::default(), Head::default())
        );
        assert!(walk.at(2.2).place_m.length() > 0.5);
        let error = HeadPath::load(Path::new("nowhere/walk.ron")).expect_err("no file");
        assert!(
            error
                .to_string()
                .ends_with("comes with the program is walk")
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, said) in [
            ("", "it is empty"),
            ("(time_s: 1.0)", "must be a list such as"),
            ("[]", "no moments"),
            ("[(time_s: -1.0)]", "[1].time_s = -1 is"),
            (
                "[(time_s: 1.0), (time_s: 1.0)]",
                "[2].time_s = 1 must come after",
            ),
            ("[(time_s: 1, pitch_deg: NaN)]", "pitch_deg = NaN"),
            (
                "[(time_s: 1, forward_m: -100.1)]",
                "= -100.1 is out of range; allowed: -100 to 100",
            ),
            (
                "[(time_s: 1, sideways_m: 1.0)]",
                "fields of a moment are time_s, right_m",
            ),
            (
                "[(time_s:)]",
                "[1].time_s has no value; it must be a number, 0 to 3600",
            ),
            (
                "[(time_s: 1), (forward_m: 1.0)]",
                "time_s is missing in [2]",
            ),
            (
                "[(time_s: 1, yaw_deg: left)]",
                "1:23: [1].yaw_deg = left is not allowed; it must be a number, -360 to 360",
            ),
        ] {
            let error = HeadPath::parse(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }

    #[test]
    fn a_head_walks_where_it_faces() {
        let mut head = Head {
            yaw_deg: 90.0,
            ..Head::default()
        };
        head.walk(0.0, 2.0);
        // Turned to the right, forwards is to the right.
        assert!((head.place_m - Vec3::X * 2.0).length() < 1e-6, "{head:?}");
        let ahead = head.transform().forward();
        assert!((*ahead - Vec3::X).length() < 1e-6, "{ahead:?}");
        head.walk(0.0, f32::INFINITY);
        assert!(head.place_m.is_finite());
        let up = Head {
            pitch_deg: 500.0,
            ..Head::default()
        };
        assert_eq!(up.clamped().pitch_deg, STEEPEST_DEG);
    }
}
