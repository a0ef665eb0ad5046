//! What stands around a photographer's light: a room with somebody opposite, or open country under clouds.
//!
//! Enters: where a studio's lamps are. Leaves: radiance by direction of the head's frame. Surfaces are Lambert's, lit by the lamps themselves
//! and by the same light from everywhere that many reflections leave; places and reflectances are choices.

use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{fbm, unit_hash, value_noise};
use bevy::math::{DVec2, DVec3};

/// Walls of the room, m from the eye of somebody who sits in it.
const LOW: DVec3 = DVec3::new(-1.9, -1.2, -1.75);
const HIGH: DVec3 = DVec3::new(2.3, 1.5, 1.6);
/// Light from everywhere, over what comes straight from the lamps to the eye.
const INDIRECT: f64 = 0.12;

/// What a surface of the room is painted with.
#[derive(Clone, Copy)]
enum Paint {
    Plain(DVec3),
    /// Books beside each other.
    Books,
    /// A picture in a frame.
    Picture,
}

/// A thing in the room: flat, upright or level, across one axis.
struct Thing {
    /// Which axis it is across.
    axis: usize,
    middle: DVec3,
    /// Half of its sides; nothing along its own axis.
    half: DVec3,
    is_round: bool,
    paint: Paint,
}

const fn plain(r: f64, g: f64, b: f64) -> Paint {
    Paint::Plain(DVec3::new(r, g, b))
}

const fn thing(axis: usize, middle: [f64; 3], half: [f64; 3], paint: Paint) -> Thing {
    Thing {
        axis,
        middle: DVec3::from_array(middle),
        half: DVec3::from_array(half),
        is_round: false,
        paint,
    }
}

const fn round(middle: [f64; 3], half: [f64; 3], paint: Paint) -> Thing {
    Thing {
        is_round: true,
        ..thing(2, middle, half, paint)
    }
}

/// The nearest first.
const THINGS: [Thing; 14] = [
    // Somebody opposite with a camera at the eye: lens, body, hands, hair, face, arms, shoulders.
    round(
        [0.035, -0.005, -0.50],
        [0.030, 0.030, 0.0],
        plain(0.02, 0.02, 0.025),
    ),
    thing(
        2,
        [0.03, 0.0, -0.52],
        [0.070, 0.045, 0.0],
        plain(0.045, 0.045, 0.05),
    ),
    round(
        [0.105, -0.03, -0.53],
        [0.035, 0.05, 0.0],
        plain(0.45, 0.31, 0.24),
    ),
    round(
        [-0.035, -0.045, -0.53],
        [0.035, 0.045, 0.0],
        plain(0.45, 0.31, 0.24),
    ),
    round(
        [0.055, 0.09, -0.60],
        [0.088, 0.075, 0.0],
        plain(0.05, 0.04, 0.03),
    ),
    round(
        [0.05, 0.02, -0.61],
        [0.075, 0.115, 0.0],
        plain(0.45, 0.31, 0.24),
    ),
    round(
        [0.20, -0.21, -0.62],
        [0.075, 0.17, 0.0],
        plain(0.10, 0.12, 0.17),
    ),
    round(
        [-0.11, -0.23, -0.62],
        [0.07, 0.16, 0.0],
        plain(0.10, 0.12, 0.17),
    ),
    round(
        [0.055, -0.44, -0.63],
        [0.24, 0.27, 0.0],
        plain(0.09, 0.11, 0.16),
    ),
    // A table, a letter on it.
    thing(
        1,
        [-0.12, -0.415, -0.62],
        [0.10, 0.0, 0.14],
        plain(0.78, 0.77, 0.74),
    ),
    thing(
        1,
        [0.0, -0.42, -0.75],
        [0.8, 0.0, 0.40],
        plain(0.42, 0.29, 0.18),
    ),
    // A picture and a door, shelves.
    thing(2, [-0.85, 0.35, -1.74], [0.34, 0.26, 0.0], Paint::Picture),
    thing(
        0,
        [-1.89, -0.20, -0.85],
        [0.0, 1.0, 0.42],
        plain(0.30, 0.20, 0.13),
    ),
    thing(0, [2.29, 0.25, -0.9], [0.0, 0.75, 0.7], Paint::Books),
];

impl Thing {
    /// How far away it is along a unit direction, and where on it that is, from −1 to 1.
    fn met(&self, d: DVec3) -> Option<(f64, DVec2)> {
        let far = self.middle[self.axis] / d[self.axis];
        if !(far.is_finite() && far > 0.0) {
            return None;
        }
        let off = (d * far - self.middle) / self.half.max(DVec3::splat(1e-9));
        let at = match self.axis {
            0 => DVec2::new(off.z, off.y),
            1 => DVec2::new(off.x, off.z),
            _ => DVec2::new(off.x, off.y),
        };
        let is_within = if self.is_round {
            at.length_squared() <= 1.0
        } else {
            at.abs().max_element() <= 1.0
        };
        is_within.then_some((far, at))
    }
}

impl Paint {
    fn reflectance(self, at: DVec2) -> DVec3 {
        match self {
            Self::Plain(color) => color,
            Self::Books => {
                let shelf = (2.5 * (at.y + 1.0)).floor();
                let book = (14.0 * (at.x + 1.0) + 3.0 * shelf).floor();
                let of = |k: u32| f64::from(unit_hash(shelf as i32, book as i32, k));
                let gap = 2.5 * (at.y + 1.0) - shelf;
                let bright = if gap > 0.8 { 0.03 } else { 0.08 + 0.5 * of(1) };
                bright * DVec3::new(0.6 + 0.4 * of(2), 0.5 + 0.4 * of(3), 0.4 + 0.5 * of(4))
            }
            Self::Picture => match at.abs().max_element() {
                0.88.. => DVec3::splat(0.05),
                0.70.. => DVec3::splat(0.75),
                _ => DVec3::new(0.20, 0.30, 0.42) * (1.0 + 0.6 * at.y),
            },
        }
    }
}

/// A lamp as the room has it.
pub(super) struct RoomLamp {
    /// Where it hangs, m from the eye.
    pub(super) place: DVec3,
    /// Irradiance / π at the eye.
    pub(super) color: DVec3,
}

/// Radiance within the room by direction, before it is brought to the light that it gives a face.
fn room(d: DVec3, lamps: &[RoomLamp], all: DVec3) -> DVec3 {
    // Out to the walls.
    let to = DVec3::from_array(core::array::from_fn(|i| {
        let wall = if d[i] < 0.0 { LOW[i] } else { HIGH[i] };
        if d[i].abs() > 1e-9 {
            wall / d[i]
        } else {
            f64::MAX
        }
    }));
    let mut far = to.min_element();
    let axis = (0..3).find(|i| to[*i] <= far).unwrap_or(2);
    let (mut faces, mut reflectance) = (DVec3::ZERO, DVec3::new(0.60, 0.58, 0.54));
    faces[axis] = -d[axis].signum();
    if axis == 1 {
        reflectance = if d.y > 0.0 {
            DVec3::new(0.76, 0.76, 0.74)
        } else {
            let board = ((d * far).x / 0.14).floor();
            let tone = 0.85 + 0.3 * f64::from(unit_hash(board as i32, 7, 0));
            tone * DVec3::new(0.30, 0.20, 0.13)
        };
    }
    for thing in &THINGS {
        if let Some((near, at)) = thing.met(d)
            && near < far
        {
            far = near;
            faces = DVec3::ZERO;
            faces[thing.axis] = -d[thing.axis].signum();
            reflectance = thing.paint.reflectance(at);
        }
    }
    let point = d * far;
    let mut light = all * INDIRECT;
    for lamp in lamps {
        let towards = lamp.place - point;
        let away = towards.length().max(0.3);
        // It shines towards the eye, and less aside.
        let ahead = towards.dot(lamp.place) / (away * lamp.place.length());
        let falls = faces.dot(towards) / away;
        let nearer = lamp.place.length() / away;
        light += lamp.color * (falls.max(0.0) * ahead.max(0.0) * nearer * nearer);
    }
    reflectance * light
}

/// What surrounds an eye in a room with these lamps, which light a face with so much (irradiance / π) beside their own light.
pub(super) fn room_around(lamps: Vec<RoomLamp>, level: DVec3) -> impl Fn(DVec3) -> DVec3 {
    let all = lamps.iter().map(|lamp| lamp.color).sum::<DVec3>();
    let all = if lamps.is_empty() { DVec3::ONE } else { all };
    // What of it lights a face, over a grid of cosine-weighted directions.
    const STEPS: i32 = 64;
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for i in 0..STEPS {
        for j in 0..STEPS {
            let p = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * (2.0 / f64::from(STEPS)) - 1.0;
            if p.length_squared() < 1.0 {
                sum += room(p.extend(-(1.0 - p.length_squared()).sqrt()), &lamps, all);
                count += 1.0;
            }
        }
    }
    let scale = level * count / sum.max(DVec3::splat(1e-9));
    move |d| scale * room(d, &lamps, all)
}

/// How high (rad) what stands on the ground reaches at this azimuth, and whether that is a house.
fn skyline(azimuth: f64) -> (f64, bool) {
    let turn = azimuth.to_degrees();
    // Two rows of houses between trees.
    let house = [(-52.0, 26.0, 0.17), (38.0, 18.0, 0.13), (118.0, 30.0, 0.15)];
    for (middle, half, eaves) in house {
        let off = (turn - middle) / half;
        if f64::abs(off) < 1.0 {
            // A gable every third of it.
            let gable = 1.0 - (3.0 * (off + 1.0) - (3.0 * (off + 1.0)).floor() - 0.5).abs() * 2.0;
            return (eaves + 0.05 * gable, true);
        }
    }
    let rough = |scale: f64, k: u32| f64::from(value_noise((turn * scale) as f32, 0, k));
    let crowns = 0.10 + 0.05 * rough(0.06, 1) + 0.025 * rough(0.3, 2) + 0.01 * rough(1.1, 3);
    (crowns.max(0.015), false)
}

/// The standard overcast sky (CIE S 011: (1 + 2 sin γ)/3 of the zenith) over a street with houses and trees.
pub(super) fn overcast(d: DVec3) -> DVec3 {
    let sky = DVec3::new(0.97, 1.0, 1.05);
    let height = d.y.clamp(-1.0, 1.0).asin();
    let azimuth = d.x.atan2(-d.z);
    let (top, is_house) = skyline(azimuth);
    // The sky's light on what is upright and on what lies, over the zenith's radiance: 7/9 π, and 0.396 of that.
    let (lies, stands) = (7.0 / 9.0, 0.396 * 7.0 / 9.0);
    let over = sky * ((1.0 + 2.0 * d.y.max(0.0)) / 3.0);
    let turn = azimuth.to_degrees();
    let upright = if is_house {
        let [column, row] = [
            (turn * 0.55).rem_euclid(1.0),
            (height / 0.055).rem_euclid(1.0),
        ];
        let is_window = (0.3..0.7).contains(&column) && (0.3..0.75).contains(&row);
        let wall = if is_window { 0.10 } else { 0.38 };
        DVec3::new(1.0, 0.93, 0.84) * wall
    } else {
        let leaves = f64::from(fbm(
            (turn * 0.4) as f32,
            (height * 25.0) as f32,
            [0, 0],
            3,
            5,
        ));
        DVec3::new(0.09, 0.11, 0.06) * (1.0 + leaves)
    };
    // Grass, and a path that comes nearer, by where a view meets the ground 1.6 m down.
    let far = 1.6 / (-d.y).max(0.02);
    let at = DVec2::new(d.x, -d.z) * far;
    let rough = f64::from(fbm(at.x as f32 * 0.5, at.y as f32 * 0.5, [0, 0], 3, 6));
    let path = smoothstep(
        0.5,
        -0.5,
        (at.x + 0.25 * at.y - 0.6).abs() - 1.1 + 0.5 * rough,
    );
    let grass = DVec3::new(0.11, 0.122, 0.085) * (1.0 + 0.5 * rough);
    let ground = grass.lerp(DVec3::new(0.24, 0.22, 0.19), path);
    let below = sky * lies * ground;
    let standing = below.lerp(sky * stands * upright, smoothstep(-0.006, 0.006, height));
    standing.lerp(over, smoothstep(top - 0.006, top + 0.006, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::surroundings::Surroundings;

    /// Irradiance / π on a surface of this normal, by directions that share the sphere evenly.
    fn irradiance(n: DVec3, radiance: impl Fn(DVec3) -> DVec3) -> DVec3 {
        const COUNT: i32 = 200_000;
        let mut sum = DVec3::ZERO;
        for i in 0..COUNT {
            let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(COUNT);
            let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
            let d = (1.0 - y * y).sqrt() * DVec3::new(cos, 0.0, sin) + DVec3::Y * y;
            sum += radiance(d) * d.dot(n).max(0.0);
        }
        4.0 * sum / f64::from(COUNT)
    }

    #[test]
    fn a_room_lights_a_face_as_it_is_asked_to() {
        let level = DVec3::new(0.155, 0.151, 0.14);
        let lamp = || RoomLamp {
            place: DVec3::new(1.1, 1.15, -1.7),
            color: DVec3::new(0.8, 0.85, 0.9),
        };
        for lamps in [Vec::new(), vec![lamp()]] {
            let lit = !lamps.is_empty();
            let around = room_around(lamps, level);
            let found = irradiance(DVec3::NEG_Z, &around);
            println!("{found} for {level}");
            // A grid of 64 by 64 directions over edges.
            assert!(found.distance(level) < 0.02 * level.length(), "{found}");
            // A lamp before the eye leaves the person opposite against the light, and lights the wall behind the face.
            let opposite = around(DVec3::new(0.05, -0.3, -0.6).normalize()).y;
            let behind = around(DVec3::new(0.5, 0.2, 0.8).normalize()).y;
            assert!(opposite > 0.0 && (!lit || behind > 4.0 * opposite));
        }
    }

    #[test]
    fn a_nearer_thing_hides_what_is_behind_it() {
        let around = room_around(Vec::new(), DVec3::ONE);
        // Lens before camera before face before the wall: each darker than the wall.
        let wall = around(DVec3::new(-0.9, 0.9, -1.7).normalize()).y;
        for at in [[0.035, -0.005, -0.5], [0.09, 0.03, -0.52]] {
            let seen = around(DVec3::from(at).normalize()).y;
            assert!(seen < 0.2 * wall, "{at:?}: {seen} of {wall}");
        }
        // What is behind the eye is not seen before it.
        assert!(THINGS.iter().all(|thing| thing.met(DVec3::Z).is_none()));
    }

    /// CIE S 011: an open sky gives a level place 7/9 of what an even one of the zenith's radiance would, an upright one 0.396 of that.
    #[test]
    fn clouds_light_a_level_place_by_seven_ninths() {
        let open =
            |d: DVec3| DVec3::splat((1.0 + 2.0 * d.y) / 3.0) * f64::from(u8::from(d.y > 0.0));
        let (level, upright) = (irradiance(DVec3::Y, open).y, irradiance(DVec3::Z, open).y);
        assert!((level - 7.0 / 9.0).abs() < 1e-3, "{level}");
        assert!(
            (upright / level - 0.396).abs() < 2e-3,
            "{}",
            upright / level
        );
        // With houses and trees some of it is missing.
        let found = irradiance(DVec3::Y, overcast).y;
        assert!((0.85..1.0).contains(&(found / level)), "{found}");
        let none = Surroundings::new(64, overcast, |_| DVec3::ZERO, Vec::new());
        assert!(none.ambient.iter().all(|factor| factor.is_finite()));
        for d in [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::Z, DVec3::NEG_Z] {
            assert!(
                overcast(d).is_finite() && overcast(d).min_element() > 0.0,
                "{d}"
            );
        }
    }
}
