//! The generator of the built-in scenes: a furnished reading room, and an eye chart in a clinic's
//! corridor.
//!
//! Enters: nothing. Leaves: a [`SceneModel`] with baked ambient occlusion. World metres; the floor is
//! y = 0; the viewer sits at a desk and looks along −z, slightly down.

use glam::{Affine3A, Mat3A, Quat, Vec3};
use ocularium::scene::model::{Alpha, EyePlacement, SceneLight, SceneMaterial, SceneModel};
use ocularium::scene::paint::{Canvas, linear};
use ocularium::scene::room::grounds::ground;
use ocularium::scene::room::{CHART_TARGETS, EYE_M, Target};
use ocularium::scene::trace::Tracer;
use shade::bake_ambient_occlusion;
use shapes::Shape;
use std::error::Error;

pub mod clinic;
mod desk;
mod furniture;
pub mod glb;
mod organic;
mod outdoors;
mod person;
mod prints;
mod shade;
mod shapes;
mod shell;
mod text;

#[cfg(test)]
mod tests;

/// What builds a scene.
pub type Build = fn() -> Result<SceneModel, Box<dyn Error>>;

/// The scenes by their names.
pub const ALL: [(&str, Build); 2] = [("room", room), ("chart", chart)];

/// The head is bent forward by this much, degrees.
const HEAD_PITCH_DEG: f32 = -6.0;

/// From a frame whose xy plane faces the viewer and whose origin is the target, turned by `roll_deg`
/// clockwise, to the world.
fn facing(target: &Target, roll_deg: f32) -> Affine3A {
    let back = -Vec3::from(target.direction());
    let right = Vec3::Y.cross(back).normalize_or(Vec3::X);
    let turn = Mat3A::from_cols(right.into(), back.cross(right).into(), back.into());
    let roll = Mat3A::from_rotation_z(-roll_deg.to_radians());
    Affine3A {
        matrix3: turn * roll,
        translation: target.point_m().into(),
    }
}

/// The ground of a material, which the library draws.
fn ground_of(material: &str) -> Canvas {
    ground(material).unwrap_or_else(|| panic!("no ground is drawn for \"{material}\""))
}

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

    /// A surface that is covered with its ground alone.
    fn covered(&mut self, name: &str, repeat: bool, roughness: f32) -> usize {
        self.printed(name, &ground_of(name), repeat, roughness)
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
    fn finish(mut self) -> Result<SceneModel, Box<dyn Error>> {
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
pub fn room() -> Result<SceneModel, Box<dyn Error>> {
    let mut set = Set::new("room");
    let fonts = prints::Fonts::new()?;
    shell::build(&mut set, shell::Extent::of_room());
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
pub fn chart() -> Result<SceneModel, Box<dyn Error>> {
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
