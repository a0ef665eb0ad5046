//! Light of a photographer's, in the place of the world's: what a macro picture of an eye is taken in.
//!
//! Enters: which light, and how far it is turned about the head. Leaves: the [`Surroundings`] of it, under a
//! photographer's exposure: a grey card before the face is as bright in each.

use super::eye_camera::EyeOrbit;
use super::illumination::Lamp;
use super::studio_room::{RoomLamp, overcast, room_around};
use super::surroundings::{STUDIO_SIDE, Surroundings, lamp_color};
use crate::optics::smoothstep::smoothstep;
use bevy::math::{DQuat, DVec2, DVec3, Vec3};
use bevy::reflect::Reflect;

/// A light that an eye is photographed in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub enum StudioLight {
    /// A four-paned window, up and to one side, in a room with somebody opposite, and a small lamp on the other side.
    #[default]
    Window,
    /// A square softbox above, and a reflector below.
    Softbox,
    /// A ring flash around the lens.
    Ring,
    /// A small lamp along the lens's axis by a mirror, as an ophthalmoscope's, in a dim room: the red reflex.
    Coaxial,
    /// A penlight before the eye, in a dim room.
    Penlight,
    /// Outdoors under clouds: the CIE's standard overcast sky over a street.
    Overcast,
    /// A table lamp in the evening.
    Lamp,
}

/// All of them.
pub const STUDIO_LIGHTS: [StudioLight; 7] = [
    StudioLight::Window,
    StudioLight::Softbox,
    StudioLight::Ring,
    StudioLight::Coaxial,
    StudioLight::Penlight,
    StudioLight::Overcast,
    StudioLight::Lamp,
];

impl StudioLight {
    /// The word by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Window => "window",
            Self::Softbox => "softbox",
            Self::Ring => "ring",
            Self::Coaxial => "coaxial",
            Self::Penlight => "penlight",
            Self::Overcast => "overcast",
            Self::Lamp => "lamp",
        }
    }

    /// What it is, for lists.
    pub fn description(self) -> &'static str {
        match self {
            Self::Window => "a window in a room, somebody opposite",
            Self::Softbox => "a softbox above, a reflector below",
            Self::Ring => "a ring flash around the lens",
            Self::Coaxial => "a small lamp along the lens's axis: the red reflex",
            Self::Penlight => "a penlight before the eye",
            Self::Overcast => "outdoors, clouds over a street",
            Self::Lamp => "a table lamp in the evening",
        }
    }

    /// Does it go with the camera?
    pub fn is_on_the_lens(self) -> bool {
        matches!(self, Self::Ring | Self::Coaxial)
    }

    /// Its lamp, where the camera stands.
    pub(super) fn on_the_lens(self, orbit: &EyeOrbit) -> Lamp {
        let lens = orbit.place_mm();
        match self {
            Self::Coaxial => near_lamp(lens, COAXIAL_WIDTH * lens.length(), COAXIAL_COLOR, 0.0),
            _ => near_lamp(lens, RING_MM, RING_COLOR, RING_HOLE),
        }
    }

    /// The one of this name.
    pub fn of(name: &str) -> Option<Self> {
        STUDIO_LIGHTS.into_iter().find(|light| light.name() == name)
    }
}

/// A studio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub struct Studio {
    /// Its light.
    pub light: StudioLight,
    /// How far all of it is turned about the vertical, degrees.
    pub turn_deg: f32,
}

/// Irradiance / π on a face, as a luminance, that a photographer exposes for: the white of an eye is then about as bright as
/// in photographs (Y 0.5, REFERENCE).
const FACE_LIGHT: f64 = 1.2;
/// Outer radius of a ring flash and the share of it that is its hole, mm.
const RING_MM: f32 = 33.0;
const RING_HOLE: f32 = 0.68;
const RING_COLOR: Vec3 = Vec3::splat(0.80);
/// Radius of a lamp that shines through the lens by a mirror, in its distance: with the distance its light on the fundus would
/// else go from pale to burnt out.
const COAXIAL_WIDTH: f32 = 0.02;
const COAXIAL_COLOR: Vec3 = Vec3::new(0.80, 0.78, 0.76);
/// Where a penlight is held (head frame, mm) and its radius.
const PENLIGHT_PLACE_MM: Vec3 = Vec3::new(46.0, -22.0, -92.0);
const PENLIGHT_MM: f32 = 4.0;
const PENLIGHT_COLOR: Vec3 = Vec3::new(0.80, 0.79, 0.77);
/// From the globe's centre to where the cornea stands, mm: where what a near lamp gives is given.
const CORNEA_MM: Vec3 = Vec3::new(0.0, 0.0, -12.5);

/// A lamp at a place (head frame, mm) of this radius (mm), which has this irradiance / π at the cornea.
fn near_lamp(place_mm: Vec3, radius_mm: f32, color: Vec3, hole: f32) -> Lamp {
    let distance = place_mm.length().max(1.0);
    let nearer = place_mm.distance(CORNEA_MM) / distance;
    Lamp {
        direction: place_mm / distance,
        radius: (radius_mm / distance).atan(),
        color: color * nearer * nearer,
        hole,
        vergence: 1.0 / distance,
    }
}

/// What shines in a studio.
struct Shining {
    direction: DVec3,
    /// Half of its sides, or its radius, as tangents.
    half: DVec2,
    shape: Shape,
    /// Irradiance / π.
    color: DVec3,
    /// How far away it hangs in its room, m.
    away: f64,
}

enum Shape {
    /// A lampshade, narrower above, through which its bulb shines.
    Shade,
    /// Brighter above by half.
    Square,
    /// Four panes of sky, brighter above.
    Panes,
}

/// A lampshade against the disc about it: how tall it is, how wide in its middle, how much narrower at its top, and how far behind its cloth the
/// bulb is.
const SHADE_TALL: f64 = 0.8;
const SHADE_WIDE: f64 = 0.78;
const SHADE_TAPER: f64 = 0.2;
const SHADE_BULB: f64 = 0.8;

/// Width of an edge, as a tangent.
const EDGE: f64 = 0.008;

impl Shining {
    fn shade(direction: DVec3, radius: f64, color: DVec3, away: f64) -> Self {
        let half = DVec2::splat(radius);
        Self {
            direction: direction.normalize(),
            half,
            shape: Shape::Shade,
            color,
            away,
        }
    }

    /// Radiance but for a factor.
    fn at(&self, d: DVec3) -> f64 {
        let along = d.dot(self.direction);
        if along <= 0.05 {
            return 0.0;
        }
        let right = DVec3::Y.cross(self.direction).normalize_or(DVec3::X);
        let above = self.direction.cross(right);
        let p = DVec2::new(d.dot(right), d.dot(above)) / along;
        let inside = |off: f64| smoothstep(EDGE, -EDGE, off);
        let within = inside(p.x.abs() - self.half.x) * inside(p.y.abs() - self.half.y);
        let up = (p.y / self.half.y).clamp(-1.0, 1.0);
        match self.shape {
            Shape::Shade => {
                let tall = inside(p.y.abs() - SHADE_TALL * self.half.y);
                let wide = inside(p.x.abs() - self.half.x * (SHADE_WIDE - SHADE_TAPER * up));
                // A bulb in its middle, behind the cloth: by the square of its distance and by the cosine on the cloth.
                let far =
                    p.length_squared() / (SHADE_BULB * SHADE_BULB * self.half.x * self.half.x);
                tall * wide * (1.0 + far).powf(-1.5)
            }
            Shape::Square => within * (1.0 + 0.2 * up),
            Shape::Panes => {
                let bar = (0.07 * self.half.x).max(0.02);
                let panes = |off: f64| smoothstep(-EDGE, EDGE, off.abs() - bar);
                within * panes(p.x) * panes(p.y) * (0.75 + 0.25 * up)
            }
        }
    }

    /// Radiance over what [`Self::at`] says.
    fn factor(&self) -> DVec3 {
        // To the corners, however it is turned.
        let reach = 1.45 * self.half.max_element() + EDGE;
        let unit = lamp_color(self.direction, reach.atan(), |d| DVec3::splat(self.at(d)));
        self.color / f64::from(unit.x).max(1e-9)
    }
}

impl Studio {
    /// What surrounds an eye there.
    pub fn surroundings(&self) -> Surroundings {
        let rgb = DVec3::new;
        // How much light a face gets from the room beside its lamps' own.
        let (room, shining) = match self.light {
            StudioLight::Window => (
                rgb(0.155, 0.151, 0.153),
                vec![
                    // The window stands up and to the viewer's left, the lamp low on the right.
                    Shining {
                        direction: rgb(0.50, 0.52, -0.78).normalize(),
                        half: DVec2::new(0.108, 0.15),
                        shape: Shape::Panes,
                        color: rgb(0.83, 0.85, 0.87),
                        away: 2.2,
                    },
                    Shining::shade(rgb(-0.72, -0.05, -0.62), 0.07, rgb(0.10, 0.088, 0.08), 1.2),
                ],
            ),
            StudioLight::Softbox => (
                rgb(0.07, 0.069, 0.068),
                vec![
                    Shining {
                        direction: rgb(0.30, 0.55, -0.78).normalize(),
                        half: DVec2::splat(0.32),
                        shape: Shape::Square,
                        color: rgb(0.86, 0.85, 0.83),
                        away: 0.9,
                    },
                    Shining {
                        direction: rgb(-0.12, -0.62, -0.78).normalize(),
                        half: DVec2::new(0.42, 0.22),
                        shape: Shape::Square,
                        color: rgb(0.15, 0.14, 0.13),
                        // Before the person opposite.
                        away: 0.4,
                    },
                ],
            ),
            StudioLight::Ring => (rgb(0.06, 0.0585, 0.0575), Vec::new()),
            StudioLight::Coaxial | StudioLight::Penlight => (rgb(0.03, 0.0285, 0.027), Vec::new()),
            StudioLight::Overcast => (DVec3::ZERO, Vec::new()),
            StudioLight::Lamp => (
                rgb(0.080, 0.053, 0.031),
                vec![Shining::shade(
                    rgb(-0.62, 0.30, -0.72),
                    0.14,
                    rgb(0.95, 0.63, 0.34),
                    1.3,
                )],
            ),
        };
        let hung = shining.iter().map(|lamp: &Shining| RoomLamp {
            place: lamp.direction * lamp.away,
            color: lamp.color,
        });
        let around: Box<dyn Fn(DVec3) -> DVec3> = match self.light {
            StudioLight::Overcast => Box::new(overcast),
            _ => Box::new(room_around(hung.collect(), room)),
        };
        let turn = DQuat::from_rotation_y(f64::from(self.turn_deg).to_radians());
        let back = turn.inverse();
        let mut lamps: Vec<Lamp> = shining
            .iter()
            .map(|lamp| Lamp {
                direction: (turn * lamp.direction).as_vec3(),
                radius: lamp.half.max_element() as f32,
                color: lamp.color.as_vec3(),
                hole: -1.0,
                vergence: 0.0,
            })
            .collect();
        let factors: Vec<DVec3> = shining.iter().map(Shining::factor).collect();
        let shine = |d: DVec3| {
            let d = back * d;
            let lamps = shining.iter().zip(&factors);
            lamps.map(|(lamp, factor)| *factor * lamp.at(d)).sum()
        };
        if self.light.is_on_the_lens() {
            lamps.push(self.light.on_the_lens(&EyeOrbit::default()));
        } else if self.light == StudioLight::Penlight {
            let place = turn.as_quat() * PENLIGHT_PLACE_MM;
            lamps.push(near_lamp(place, PENLIGHT_MM, PENLIGHT_COLOR, 0.0));
        }
        let mut found = Surroundings::new(STUDIO_SIDE, |d| around(back * d), shine, lamps);
        found.exposure = face_exposure(&found);
        found
    }
}

/// The exposure that a photographer of a face chooses in these surroundings: a white card before it is as bright in any.
pub fn face_exposure(surroundings: &Surroundings) -> f32 {
    (FACE_LIGHT / face_light(surroundings).max(1e-9)) as f32
}

/// Luminance of a white card in place of the face.
pub fn face_light(around: &Surroundings) -> f64 {
    around
        .irradiance(DVec3::NEG_Z)
        .dot(DVec3::new(0.2126, 0.7152, 0.0722))
        .max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::images::MapView;
    use crate::appearance::shading::surroundings::{surroundings_direction, surroundings_radiance};

    #[test]
    fn a_card_is_as_bright_in_every_light() {
        for light in STUDIO_LIGHTS {
            let around = Studio {
                light,
                turn_deg: 0.0,
            }
            .surroundings();
            let card = face_light(&around) * f64::from(around.exposure);
            assert!((card - FACE_LIGHT).abs() < 1e-6, "{light:?}: {card}");
            assert_eq!(StudioLight::of(light.name()), Some(light));
        }
        assert_eq!(StudioLight::of("moon"), None);
    }

    /// What is mirrored of a lamp is what lights: the map without the rest has its irradiance.
    #[test]
    fn the_map_holds_the_light_of_its_lamps() {
        for light in [StudioLight::Window, StudioLight::Softbox, StudioLight::Lamp] {
            let around = Studio {
                light,
                turn_deg: 25.0,
            }
            .surroundings();
            let view = MapView::new(&around.levels, false);
            let side = 512;
            let n = around.lamps[0].direction.as_dvec3();
            let (mut all, texel) = (DVec3::ZERO, 16.0 / f64::from(side * side));
            for row in 0..side {
                for column in 0..side {
                    let uv =
                        (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / f64::from(side);
                    if uv.distance(DVec2::splat(0.5)) < 0.5 {
                        let d = surroundings_direction(uv);
                        all += surroundings_radiance(&view, d, 0.0) * d.dot(n).max(0.0) * texel;
                    }
                }
            }
            let (found, wanted) = (all / core::f64::consts::PI, around.irradiance(n));
            println!("{light:?}: {found:.4} for {wanted:.4}");
            assert!(found.distance(wanted) < 0.02 * wanted.length(), "{light:?}");
        }
    }
}
