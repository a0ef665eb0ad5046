//! The built-in scenes: a furnished reading room, and an eye chart in a clinic's corridor.
//!
//! Enters: nothing (or a factor for the room's size). Leaves: a [`SceneModel`] with baked ambient
//! occlusion. World metres; the floor is y = 0; the viewer sits at a desk and looks along −z,
//! slightly down. What a test or a demonstration fixates is listed in [`ROOM_TARGETS`]: along each
//! of these directions the first surface is at the stated distance.

use super::model::{Alpha, EyePlacement, SceneError, SceneLight, SceneMaterial, SceneModel};
use super::paint::{Canvas, linear};
use super::shapes::Shape;
use super::trace::{Tracer, bake_ambient_occlusion};
use glam::{Affine3A, Mat3A, Quat, Vec3};

mod desk;
mod furniture;
mod outdoors;
mod person;
mod prints;
mod shell;

#[cfg(test)]
mod tests;

/// The right eye of a person who sits at the desk, m.
pub const EYE_M: [f32; 3] = [0.0, 1.18, 0.0];
/// The head is bent forward by this much, degrees.
pub const HEAD_PITCH_DEG: f32 = -6.0;

/// Something to fixate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// What it is.
    pub name: &'static str,
    /// Direction from the eye: positive to the right of world −z, degrees.
    pub azimuth_deg: f32,
    /// Direction from the eye: positive above the horizon, degrees.
    pub elevation_deg: f32,
    /// Distance of the first surface in that direction, m.
    pub distance_m: f32,
}

impl Target {
    const fn new(
        name: &'static str,
        azimuth_deg: f32,
        elevation_deg: f32,
        distance_m: f32,
    ) -> Self {
        Self {
            name,
            azimuth_deg,
            elevation_deg,
            distance_m,
        }
    }

    /// Unit direction from the eye.
    pub fn direction(&self) -> [f32; 3] {
        let (az, el) = (
            self.azimuth_deg.to_radians(),
            self.elevation_deg.to_radians(),
        );
        [az.sin() * el.cos(), el.sin(), -az.cos() * el.cos()]
    }

    /// The fixated point, m.
    pub fn point_m(&self) -> Vec3 {
        Vec3::from(EYE_M) + Vec3::from(self.direction()) * self.distance_m
    }

    /// From a frame whose xy plane faces the viewer and whose origin is the target, turned by
    /// `roll_deg` clockwise, to the world.
    fn facing(&self, roll_deg: f32) -> Affine3A {
        let back = -Vec3::from(self.direction());
        let right = Vec3::Y.cross(back).normalize_or(Vec3::X);
        let turn = Mat3A::from_cols(right.into(), back.cross(right).into(), back.into());
        let roll = Mat3A::from_rotation_z(-roll_deg.to_radians());
        Affine3A {
            matrix3: turn * roll,
            translation: self.point_m().into(),
        }
    }
}

const PHONE: Target = Target::new("phone", -17.5, -19.0, 0.3);
const LETTER: Target = Target::new("letter", 13.0, -20.5, 0.6);
const VASE: Target = Target::new("vase", -7.0, -17.0, 1.0);
const MUG: Target = Target::new("mug", -1.4, -19.3, 1.0);
const CLOCK: Target = Target::new("clock", 3.7, -18.2, 1.0);
const FACE: Target = Target::new("face", -12.0, -0.8, 3.0);
const BOOKS: Target = Target::new("books", 19.0, -1.5, 3.0);
const CHART: Target = Target::new("chart", -5.4, 3.6, 6.0);
const SIGN: Target = Target::new("street sign", 3.3, 1.9, 12.0);
const TREE: Target = Target::new("tree", 8.9, 3.0, 20.0);
const HOUSES: Target = Target::new("houses", 1.6, 0.5, 40.0);

/// What there is to look at in the room, near to far.
pub const ROOM_TARGETS: [Target; 11] = [
    PHONE, LETTER, VASE, MUG, CLOCK, FACE, BOOKS, CHART, SIGN, TREE, HOUSES,
];

/// What there is to look at in the corridor.
pub const CHART_TARGETS: [Target; 1] = [Target::new("chart", 0.0, 0.0, 6.0)];

/// A scene under construction.
struct Set {
    scene: SceneModel,
}

/// Parts that are moved together: name, shape, material.
type Group = Vec<(&'static str, Shape, usize)>;

impl Set {
    fn new(name: &str) -> Self {
        Self {
            scene: SceneModel {
                name: name.into(),
                ..Default::default()
            },
        }
    }

    fn texture(&mut self, canvas: &Canvas, repeat: bool) -> usize {
        self.scene.textures.push(canvas.texture(repeat));
        self.scene.textures.len() - 1
    }

    fn material(&mut self, material: SceneMaterial) -> usize {
        self.scene.materials.push(material);
        self.scene.materials.len() - 1
    }

    /// A plain surface.
    fn plain(&mut self, name: &str, color: u32, roughness: f32) -> usize {
        let [r, g, b] = linear(color);
        self.material(SceneMaterial {
            name: name.into(),
            base_color: [r, g, b, 1.0],
            roughness,
            ..Default::default()
        })
    }

    /// A metal.
    fn metal(&mut self, name: &str, color: u32, roughness: f32) -> usize {
        let index = self.plain(name, color, roughness);
        self.scene.materials[index].metallic = 1.0;
        index
    }

    /// A surface with a picture.
    fn printed(&mut self, name: &str, canvas: &Canvas, repeat: bool, roughness: f32) -> usize {
        let base_color_texture = Some(self.texture(canvas, repeat));
        self.material(SceneMaterial {
            name: name.into(),
            base_color: [1.0; 4],
            base_color_texture,
            roughness,
            ..Default::default()
        })
    }

    /// A surface that shines by itself and reflects little; `white` is the luminance of its
    /// picture's white, cd/m².
    fn glowing(&mut self, name: &str, canvas: &Canvas, white: f32, alpha: Alpha) -> usize {
        let texture = Some(self.texture(canvas, false));
        self.material(SceneMaterial {
            name: name.into(),
            base_color: [0.01, 0.01, 0.01, 1.0],
            base_color_texture: texture,
            emissive: [white; 3],
            emissive_texture: texture,
            roughness: 1.0,
            alpha,
            ..Default::default()
        })
    }

    fn double_sided(&mut self, material: usize) -> usize {
        self.scene.materials[material].double_sided = true;
        material
    }

    fn add(&mut self, name: &str, shape: Shape, material: usize) {
        self.scene.meshes.push(shape.mesh(name, material));
    }

    fn add_group(&mut self, group: Group, by: Affine3A) {
        for (name, shape, material) in group {
            self.add(name, shape.moved(by), material);
        }
    }

    /// Puts a group near its target by `by`, then shifts it along the line of sight until its
    /// first surface is exactly at the target.
    fn add_at_target(&mut self, group: Group, by: Affine3A, target: &Target) {
        let group: Group = group
            .into_iter()
            .map(|(name, shape, m)| (name, shape.moved(by), m))
            .collect();
        let probe = SceneModel {
            meshes: group
                .iter()
                .map(|(name, shape, _)| shape.clone().mesh(name, 0))
                .collect(),
            materials: vec![SceneMaterial::default()],
            ..Default::default()
        };
        let sight = Vec3::from(target.direction());
        let met = Tracer::new(&probe).cast(EYE_M.into(), sight, 0.0, 100.0);
        let shift = met.map_or(0.0, |hit| target.distance_m - hit.distance_m);
        self.add_group(group, Affine3A::from_translation(sight * shift));
    }

    /// Bakes occlusion and measures the view.
    fn finish(mut self) -> Result<SceneModel, SceneError> {
        // Frames would darken the few vertices of a flat print as a whole.
        let left_out = [
            "outdoors",
            "glow",
            "eye chart",
            "letter",
            "painting",
            "clock dial",
        ];
        let lit = |name: &str| !left_out.iter().any(|start| name.starts_with(start));
        bake_ambient_occlusion(&mut self.scene, 0.6, 12, lit);
        self.scene.validate()?;
        self.scene.mean_luminance_cd_m2 = Tracer::new(&self.scene).mean_luminance_cd_m2(40);
        Ok(self.scene)
    }
}

/// The furnished reading room.
///
/// # Errors
/// Only if a font that is compiled in cannot be read.
pub fn room() -> Result<SceneModel, SceneError> {
    room_scaled(1.0)
}

/// The same room with walls and ceiling moved outwards until its volume is `factor` times as
/// large; the far wall and everything in the room stay where they are.
///
/// # Errors
/// If `factor` is not within 1–1,000.
pub fn room_scaled(factor: f32) -> Result<SceneModel, SceneError> {
    if !(1.0..=1000.0).contains(&factor) {
        return Err(SceneError::Content {
            source_name: "room".into(),
            reason: format!("its volume factor is {factor}, but must be 1 to 1000"),
        });
    }
    let mut set = Set::new("room");
    let fonts = prints::Fonts::new()?;
    shell::build(&mut set, shell::Extent::of_room().widened(factor));
    outdoors::build(&mut set, &fonts);
    furniture::build(&mut set, &fonts);
    person::build(&mut set);
    desk::build(&mut set, &fonts);
    let pitch = Quat::from_rotation_x(HEAD_PITCH_DEG.to_radians());
    set.scene.eye = EyePlacement {
        position_m: EYE_M,
        forward: (pitch * Vec3::NEG_Z).into(),
        up: (pitch * Vec3::Y).into(),
        vertical_fov_deg: 50.0,
        horizontal_fov_deg: 50.0,
    };
    set.scene.background = [300.0, 420.0, 600.0];
    set.scene.lights.extend([
        SceneLight::Directional {
            direction: Vec3::new(0.8, -0.42, -0.3).normalize().into(),
            color: [1.0, 0.86, 0.66],
            illuminance_lux: 1400.0,
            shadows: true,
        },
        SceneLight::Ambient {
            color: [0.97, 0.98, 1.0],
            brightness: 105.0,
        },
    ]);
    set.finish()
}

/// The eye chart at 6 m at the end of a plain corridor.
///
/// # Errors
/// Only if a font that is compiled in cannot be read.
pub fn chart() -> Result<SceneModel, SceneError> {
    let mut set = Set::new("chart");
    let fonts = prints::Fonts::new()?;
    shell::corridor(&mut set);
    let target = &CHART_TARGETS[0];
    prints::hang_chart(&mut set, &fonts, target);
    set.scene.eye = EyePlacement {
        position_m: EYE_M,
        ..Default::default()
    };
    set.scene.lights = vec![
        SceneLight::Directional {
            direction: Vec3::new(0.25, -0.75, -0.6).normalize().into(),
            color: [1.0, 0.98, 0.95],
            illuminance_lux: 300.0,
            shadows: false,
        },
        SceneLight::Ambient {
            color: [1.0, 0.99, 0.97],
            brightness: 90.0,
        },
    ];
    set.finish()
}
