//! What a file calls translucent and is not.
//!
//! A surface that is blended has no distance: the eye looks through it. Exporters blend whatever has an
//! alpha channel, so a poster or a leaf would be as sharp, or as blurred, as what stands behind it. Enters:
//! a scene as its file has it. Leaves: the same, with opaque surfaces opaque and cut-outs masked, and a
//! remark on what is truly translucent.

use super::super::model::{Alpha, SceneMaterial, SceneModel};
use crate::input_file::one_clause;

/// From this code on alpha is opaque; and below its complement nothing is left to see.
const OPAQUE: u8 = 247;
/// Share of a cut-out's visible texels that may lie between, as along its edges.
const EDGES: f64 = 0.2;

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
        let of = |mesh: &super::SceneMesh| &scene.materials[mesh.material].name;
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
    let (mut whole, mut between, mut clear) = (0u64, 0u64, 0u64);
    for texel in scene.textures[texture].rgba8.chunks_exact(4) {
        match texel[3] {
            OPAQUE.. => whole += 1,
            alpha if alpha > u8::MAX - OPAQUE => between += 1,
            _ => clear += 1,
        }
    }
    match (between, clear) {
        (0, 0) => Some(Alpha::Opaque),
        _ if between as f64 <= EDGES * (whole + between) as f64 => Some(Alpha::Mask(0.5)),
        _ => None,
    }
}
