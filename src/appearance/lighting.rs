//! The studio's lights, set anew where they change.

use super::EyeParts;
use super::materials::{GlobeMaterial, HairMaterial, MeniscusMaterial, SkinMaterial, Studio};
use bevy::prelude::*;

/// Hands a changed [`Studio`] to everything of the eye that it lights.
pub fn light_eye(
    studio: Res<Studio>,
    mut parts: ResMut<EyeParts>,
    mut globes: ResMut<Assets<GlobeMaterial>>,
    mut skins: ResMut<Assets<SkinMaterial>>,
    mut hairs: ResMut<Assets<HairMaterial>>,
    mut tears: ResMut<Assets<MeniscusMaterial>>,
) {
    if !studio.is_changed() {
        return;
    }
    for (_, material) in globes.iter_mut() {
        material.globe.studio = *studio;
    }
    for (_, material) in skins.iter_mut() {
        material.skin.studio = *studio;
    }
    for (_, material) in hairs.iter_mut() {
        material.hair.studio = *studio;
    }
    for (_, material) in tears.iter_mut() {
        material.meniscus.studio = *studio;
    }
    parts.relight();
}
