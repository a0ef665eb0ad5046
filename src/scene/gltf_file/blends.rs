//! What a file calls translucent and is not.
//!
//! A surface that is blended has no distance: the eye looks through it. Exporters blend whatever has an
//! alpha channel, so a poster or a leaf would be as sharp, or as blurred, as what stands behind it. Enters:
//! a scene as its file has it. Leaves: the same, with opaque surfaces opaque and cut-outs masked, and a
//! remark on what is truly translucent.

use super::super::model::{Alpha, SceneMaterial, SceneMesh, SceneModel, SceneTexture, Wrap};
use crate::input_file::one_clause;
use glam::{Vec2, Vec3};

/// From this code on alpha is opaque; and below its complement nothing is left to see.
const OPAQUE: u8 = 247;
/// Share of a cut-out's visible texels that may lie between, as along its edges.
const EDGES: f64 = 0.2;
/// About how many places of a mesh are looked at.
const SAMPLES: f64 = 20_000.0;

/// Settles what every blended material is.
pub(super) fn settle(scene: &mut SceneModel) {
    let mut translucent = Vec::new();
    for index in 0..scene.materials.len() {
        if scene.materials[index].alpha != Alpha::Blend {
            continue;
        }
        match alpha_of(scene, index) {
            Some(alpha) => scene.materials[index].alpha = alpha,
            None => translucent.push(one_clause(&scene.materials[index].name)),
        }
    }
    let used = |name: &String| {
        let of = |mesh: &SceneMesh| &scene.materials[mesh.material].name;
        scene
            .meshes
            .iter()
            .any(|mesh| one_clause(of(mesh)) == *name)
    };
    translucent.retain(used);
    if let Some(first) = translucent.first() {
        let others = match translucent.len() {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        scene.remarks.push(format!(
            "\"{}\": translucent surfaces (material \"{first}\"{others}) have no distance of their own; the eye looks \
             through them.",
            scene.name
        ));
    }
}

/// What a blended material is in truth; `None` where it is translucent.
fn alpha_of(scene: &SceneModel, index: usize) -> Option<Alpha> {
    let material: &SceneMaterial = &scene.materials[index];
    let share = f32::from(OPAQUE) / 255.0;
    let mut vertices = scene
        .meshes
        .iter()
        .filter(|mesh| mesh.material == index)
        .flat_map(|mesh| mesh.colors.iter().flatten());
    if material.base_color[3] < share || vertices.any(|color| color[3] < share) {
        return None;
    }
    let Some(texture) = material.base_color_texture else {
        return Some(Alpha::Opaque);
    };
    let texture = &scene.textures[texture];
    if texture
        .rgba8
        .chunks_exact(4)
        .all(|texel| texel[3] >= OPAQUE)
    {
        return Some(Alpha::Opaque);
    }
    // Of an atlas only what the surfaces show counts, by its area in the scene.
    let (mut whole, mut between, mut clear) = (0.0, 0.0, 0.0);
    for mesh in scene.meshes.iter().filter(|mesh| mesh.material == index) {
        for_samples(mesh, |uv, area| match alpha_at(texture, uv) {
            OPAQUE.. => whole += area,
            alpha if alpha > u8::MAX - OPAQUE => between += area,
            _ => clear += area,
        });
    }
    match (between > 0.0, clear > 0.0) {
        (false, false) => Some(Alpha::Opaque),
        _ if between <= EDGES * (whole + between) => Some(Alpha::Mask(0.5)),
        _ => None,
    }
}

/// Calls `see` with coordinates of places spread evenly over each triangle, and the area that each stands for.
fn for_samples(mesh: &SceneMesh, mut see: impl FnMut([f32; 2], f64)) {
    let Some(uvs) = &mesh.uvs else { return };
    let triangles = mesh.indices.len() / 3;
    // Rows of places along a triangle's edge: 2 to 100.
    let rows = (SAMPLES / triangles.max(1) as f64).sqrt().clamp(2.0, 100.0) as u32;
    for corners in mesh.indices.chunks_exact(3) {
        let at = |k: usize| Vec3::from(mesh.positions[corners[k] as usize]);
        let uv = |k: usize| Vec2::from(uvs[corners[k] as usize]);
        let area = 0.5 * f64::from((at(1) - at(0)).cross(at(2) - at(0)).length());
        let share = area / f64::from(rows * (rows + 1) / 2);
        for row in 0..rows {
            for column in 0..=row {
                // The middles of the upright ones of the small triangles.
                let b = (f64::from(column) + 1.0 / 3.0) / f64::from(rows);
                let a = (f64::from(rows - 1 - row) + 1.0 / 3.0) / f64::from(rows);
                let (a, b) = (a as f32, b as f32);
                see(
                    (uv(0) * (1.0 - a - b) + uv(1) * a + uv(2) * b).into(),
                    share,
                );
            }
        }
    }
}

/// Alpha of the texel at coordinates, which may lie beyond the texture.
fn alpha_at(texture: &SceneTexture, uv: [f32; 2]) -> u8 {
    let place = |k: usize, side: u32| {
        let along = match texture.wrap[k] {
            Wrap::Clamp => uv[k].clamp(0.0, 1.0),
            Wrap::Repeat => uv[k].rem_euclid(1.0),
            Wrap::Mirror => 1.0 - (uv[k].rem_euclid(2.0) - 1.0).abs(),
        };
        ((along * side as f32) as usize).min(side as usize - 1)
    };
    let texel = place(1, texture.height) * texture.width as usize + place(0, texture.width);
    texture.rgba8[4 * texel + 3]
}
