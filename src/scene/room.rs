//! The built-in scenes: a furnished reading room, and an eye chart in a clinic's corridor.
//!
//! Enters: the baked files of `assets/scenes` (or a factor for the room's size). Leaves: a
//! [`SceneModel`] as `examples/bake_rooms` built it, with ambient occlusion in its vertex colours. World
//! metres; the floor is y = 0; the viewer sits at a desk and looks along −z, slightly down. What a
//! test or a demonstration fixates is listed in [`ROOM_TARGETS`]: along each of these directions the
//! first surface is at the stated distance.

use super::gltf_file::{Beside, load_gltf_among};
use super::model::{SceneError, SceneMesh, SceneModel, SceneTexture};
use super::paint::Canvas;
use super::trace::Tracer;
use glam::{Mat2, Vec2, Vec3};
use grounds::ground;

pub mod grounds;

/// The right eye of a person who sits at the desk, m.
pub const EYE_M: [f32; 3] = [0.0, 1.18, 0.0];

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
    /// The telephone in the left hand.
    pub const PHONE: Self = Self::new("phone", -17.5, -19.0, 0.3);
    /// The letter on its easel.
    pub const LETTER: Self = Self::new("letter", 13.0, -20.5, 0.6);
    /// The vase with flowers.
    pub const VASE: Self = Self::new("vase", -7.0, -17.0, 1.0);
    /// The mug.
    pub const MUG: Self = Self::new("mug", -1.4, -19.3, 1.0);
    /// The table clock.
    pub const CLOCK: Self = Self::new("clock", 3.7, -18.2, 1.0);
    /// The face of the reader in the armchair.
    pub const FACE: Self = Self::new("face", -12.0, -0.8, 3.0);
    /// The spines in the bookcase.
    pub const BOOKS: Self = Self::new("books", 19.0, -1.5, 3.0);
    /// The eye chart on the far wall of the room.
    pub const CHART: Self = Self::new("chart", -5.4, 3.6, 6.0);
    /// The street sign outside the window.
    pub const SIGN: Self = Self::new("street sign", 3.3, 1.9, 12.0);
    /// The tree outside the window.
    pub const TREE: Self = Self::new("tree", 8.9, 3.0, 20.0);
    /// The row of houses outside the window.
    pub const HOUSES: Self = Self::new("houses", 1.6, 0.5, 40.0);

    /// Something along a direction in degrees, at a distance in metres.
    pub const fn new(
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
}

/// What there is to look at in the room, near to far.
pub const ROOM_TARGETS: [Target; 11] = [
    Target::PHONE,
    Target::LETTER,
    Target::VASE,
    Target::MUG,
    Target::CLOCK,
    Target::FACE,
    Target::BOOKS,
    Target::CHART,
    Target::SIGN,
    Target::TREE,
    Target::HOUSES,
];

/// What there is to look at in the corridor.
pub const CHART_TARGETS: [Target; 1] = [Target::new("chart", 0.0, 0.0, 6.0)];

/// The furnished reading room.
///
/// # Errors
/// Only if the file that is compiled in is damaged.
pub fn room() -> Result<SceneModel, SceneError> {
    load("room", include_bytes!("../../assets/scenes/room.glb"))
}

/// The eye chart at 6 m at the end of a plain corridor.
///
/// # Errors
/// Only if the file that is compiled in is damaged.
pub fn chart() -> Result<SceneModel, SceneError> {
    load("chart", include_bytes!("../../assets/scenes/chart.glb"))
}

fn load(name: &str, glb: &[u8]) -> Result<SceneModel, SceneError> {
    let mut scene = load_gltf_among(glb, name, Beside::Files(&[]), Some(1.0))?;
    for material in &scene.materials {
        if let (Some(index), Some(ground)) = (material.base_color_texture, ground(&material.name)) {
            lay_under(&mut scene.textures[index], &ground);
        }
    }
    Ok(scene)
}

/// Puts a ground below a picture: it shows where the picture is transparent. A picture of another size
/// is only a stand-in, for programs that draw no grounds.
fn lay_under(picture: &mut SceneTexture, ground: &Canvas) {
    let below = ground.texture(false);
    let ink = std::mem::replace(&mut picture.rgba8, below.rgba8);
    if (picture.width, picture.height) == (below.width, below.height) {
        let texels = picture.rgba8.chunks_exact_mut(4);
        let inked = texels
            .zip(ink.chunks_exact(4))
            .filter(|(_, ink)| ink[3] > 0);
        for (texel, ink) in inked {
            let share = f32::from(ink[3]) / 255.0;
            for (below, &ink) in texel.iter_mut().zip(&ink[..3]) {
                let mixed = f32::from(*below) + (f32::from(ink) - f32::from(*below)) * share;
                *below = (mixed + 0.5) as u8;
            }
        }
    }
    (picture.width, picture.height) = (below.width, below.height);
}

/// Parts of the room that stand at its walls and ceiling, and move with them.
const SHELL: [&str; 10] = [
    "floor",
    "ceiling",
    "far wall",
    "left wall",
    "right wall",
    "near wall",
    "skirting",
    "cornice",
    "picture rail",
    "side window",
];

/// Inner faces of the walls and the ceiling that move outwards: x of the left and the right one, y of
/// the ceiling, m.
const WALLS_M: [f32; 3] = [-2.2, 2.1, 2.6];
/// What is this near to a wall moves with it, m: the window frames, but not what stands before it.
const AT_WALL_M: f32 = 0.15;

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
    let mut scene = room()?;
    if factor > 1.0 {
        let outwards = factor.sqrt() - 1.0;
        let shell = |mesh: &&mut SceneMesh| SHELL.contains(&mesh.name.as_str());
        scene
            .meshes
            .iter_mut()
            .filter(shell)
            .for_each(|mesh| widen(mesh, outwards));
        scene.mean_luminance_cd_m2 = Tracer::new(&scene).mean_luminance_cd_m2(40);
    }
    Ok(scene)
}

/// Moves the vertices at a side wall or the ceiling outwards by this share of their place. Textures
/// keep their scale.
fn widen(mesh: &mut SceneMesh, outwards: f32) {
    let [left, right, ceiling] = WALLS_M;
    let slope = mesh.uvs.as_ref().and_then(|uvs| uv_slope(mesh, uvs));
    for (vertex, position) in mesh.positions.iter_mut().enumerate() {
        let mut step = Vec3::ZERO;
        if position[0] < left + AT_WALL_M {
            step.x = left * outwards;
        } else if position[0] > right - AT_WALL_M {
            step.x = right * outwards;
        }
        if position[1] > ceiling - AT_WALL_M {
            step.y = ceiling * outwards;
        }
        *position = (Vec3::from(*position) + step).into();
        if let (Some([u, v]), Some(uvs)) = (slope, &mut mesh.uvs) {
            let moved = Vec2::from(uvs[vertex]) + Vec2::new(u.dot(step), v.dot(step));
            uvs[vertex] = moved.into();
        }
    }
}

/// By how much u and v grow a metre on a flat mesh, as on its first triangle.
fn uv_slope(mesh: &SceneMesh, uvs: &[[f32; 2]]) -> Option<[Vec3; 2]> {
    let corners = mesh.indices.get(..3)?;
    let [a, b, c] = [0, 1, 2].map(|k| corners[k] as usize);
    let place = |k: usize| Vec3::from(mesh.positions[k]);
    let (e, f) = (place(b) - place(a), place(c) - place(a));
    let gram = Mat2::from_cols_array(&[e.dot(e), e.dot(f), e.dot(f), f.dot(f)]);
    let inverse = (gram.determinant() > 0.0).then(|| gram.inverse())?;
    Some([0, 1].map(|axis| {
        let by = Vec2::new(uvs[b][axis] - uvs[a][axis], uvs[c][axis] - uvs[a][axis]);
        let weights = inverse * by;
        e * weights.x + f * weights.y
    }))
}

#[cfg(test)]
mod tests;
