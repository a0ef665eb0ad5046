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
const THINGS: [Thing; 10] = [
    // Somebody opposite: hair, face, neck, shoulders.
    round(
        [0.05, 0.085, -0.60],
        [0.088, 0.07, 0.0],
        plain(0.05, 0.04, 0.03),
    ),
    round(
        [0.05, 0.02, -0.61],
        [0.075, 0.115, 0.0],
        plain(0.45, 0.31, 0.24),
    ),
    thing(
        2,
        [0.05, -0.13, -0.62],
        [0.055, 0.07, 0.0],
        plain(0.42, 0.29, 0.22),
    ),
    round(
        [0.05, -0.42, -0.63],
        [0.23, 0.24, 0.0],
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
    // A picture and a door, shelves, a lamp's dark stand.
    thing(2, [-0.85, 0.35, -1.74], [0.34, 0.26, 0.0], Paint::Picture),
    thing(
        0,
        [-1.89, -0.20, -0.85],
        [0.0, 1.0, 0.42],
        plain(0.30, 0.20, 0.13),
    ),
    thing(0, [2.29, 0.25, -0.9], [0.0, 0.75, 0.7], Paint::Books),
    thing(
        2,
        [0.42, -0.35, -1.70],
        [0.05, 0.85, 0.0],
        plain(0.06, 0.06, 0.06),
    ),
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
    let ground = if d.y < -0.12 {
        DVec3::new(0.20, 0.19, 0.18)
    } else {
        DVec3::new(0.12, 0.15, 0.08)
    };
    let below = sky * lies * ground;
    let standing = below.lerp(sky * stands * upright, smoothstep(-0.006, 0.006, height));
    standing.lerp(over, smoothstep(top - 0.006, top + 0.006, height))
}
