//! Eyes in the world follow their owners: globe and pupil, lids, lashes and tears.

use super::face_region::LidPose;
use super::materials::GlobePart;
use super::mesh_fill::{fill_brow, fill_hair, fill_mesh, lid_margins};
use super::model::{EyeAssets, EyeParts, FaceRegion, METRES_A_MM, side};
use super::shading::iris_relief::pupil_code;
use super::shading::tear_layer::{TEAR_DRIFT_S, tear_age_code};
use crate::anatomy::{
    Accommodation, Cornea, Effective, Eye, EyeOf, Eyelids, Gaze, Iris, Lids, Look, OcularMedia,
    Pupil, Refraction,
};
use crate::frame::clock::SimulationClock;
use crate::frame::ledger::WorkLedger;
use crate::optics::defocus::PowerVector;
use crate::optics::lens_mirror::LensShape;
use bevy::math::DVec3;
use bevy::mesh::MeshTag;
use bevy::prelude::*;

/// What of an eye moves its globe.
type Turning<'a> = (&'a Eye, &'a Gaze, &'a Pupil, &'a Effective<Iris>);

/// An eye that nobody may see is not moved.
fn is_hidden(visibility: &Visibility) -> bool {
    *visibility == Visibility::Hidden
}

/// Turns the globes and sets the pupils, where they changed.
pub fn move_eyes(
    eyes: Query<Turning>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut transforms: Query<&mut Transform>,
    mut assets: EyeAssets,
) {
    for (mut parts, visibility) in &mut models {
        let Some(Ok((eye, gaze, pupil, iris))) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        if is_hidden(visibility) {
            continue;
        }
        let rotation = gaze.globe_rotation(eye);
        let radius = (pupil.diameter_mm * 0.5) as f32;
        if parts.head_from_eye == Some(rotation) && parts.pupil_radius_mm == radius {
            continue;
        }
        // From here on the picture of it changes.
        let parts = &mut *parts;
        let turned = parts.head_from_eye.replace(rotation) != Some(rotation);
        parts.pupil_radius_mm = radius;
        let nasal = -side(eye.laterality);
        if !turned {
            continue;
        }
        for (entity, material) in &parts.globe {
            let Some(mut material) = assets.globes.get_mut(material) else {
                continue;
            };
            material.globe.head_from_eye = Mat4::from_quat(rotation);
            let [nasally, up] = iris.0.pupil_decentration_mm.map(|mm| mm as f32);
            material.globe.pupil_center_mm = Vec2::new(nasal * nasally, up);
            if material.part != GlobePart::Conjunctiva
                && let Ok(mut transform) = transforms.get_mut(*entity)
            {
                *transform =
                    Transform::from_rotation(rotation).with_scale(Vec3::splat(METRES_A_MM));
            }
        }
    }
}

/// What the mesh of a globe carries of the pupil and of the tear film's age, s: a tag changes without its material being bound anew.
pub fn globe_tag(pupil_radius_mm: f32, tears_s: f64) -> MeshTag {
    MeshTag(tear_age_code(tears_s) << 16 | pupil_code(pupil_radius_mm.into()))
}

/// Opening of the lids, of their usual one, below which they lay down a new film of tears: the margin has then passed the pupil.
const LIDS_WIPE: f64 = 0.35;
/// After so long a film has calmed, s.
const TEARS_CALM_S: f64 = 3.0 * TEAR_DRIFT_S;

/// The age at which a film of this age, s, that begins to break after `breakup_s` is drawn: between calming and breaking it
/// does not change, and once it has broken all over no more.
fn tears_drawn_s(age_s: f64, breakup_s: f64) -> f64 {
    if age_s > TEARS_CALM_S && age_s < breakup_s {
        TEARS_CALM_S
    } else {
        age_s.min((5.0 * breakup_s).max(TEARS_CALM_S))
    }
}

/// Lets the tear films age, from when the lids last opened.
pub fn age_tears(
    eyes: Query<(&Cornea, &EyeOf)>,
    people: Query<&Eyelids>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut tags: Query<&mut MeshTag>,
    clock: Res<SimulationClock>,
) {
    for (mut parts, visibility) in &mut models {
        let Some(Ok((cornea, owner))) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        let Ok(person) = people.get(owner.0) else {
            continue;
        };
        if is_hidden(visibility) {
            continue;
        }
        let is_wiped = person.aperture < LIDS_WIPE;
        let opened_s = match parts.tears_from_s {
            _ if is_wiped => clock.time_s,
            Some(from) if from <= clock.time_s => from,
            // Nobody has seen it blink, or the clock was set back: a film that is calm and whole.
            _ => clock.time_s - TEARS_CALM_S.min(0.9 * cornea.tear_breakup_s),
        };
        if parts.tears_from_s != Some(opened_s) {
            parts.bypass_change_detection().tears_from_s = Some(opened_s);
        }
        let tag = globe_tag(
            parts.pupil_radius_mm,
            tears_drawn_s(clock.time_s - opened_s, cornea.tear_breakup_s),
        );
        if parts.tag == Some(tag.0) {
            continue;
        }
        // From here on the picture of it changes.
        parts.tag = Some(tag.0);
        for (entity, _) in &parts.globe {
            if let Ok(mut own) = tags.get_mut(*entity) {
                *own = MeshTag(tag.0);
            }
        }
    }
}

/// Clouds the lenses, where their media have changed.
pub fn cloud_lenses(
    eyes: Query<&OcularMedia>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut assets: EyeAssets,
) {
    for (mut parts, visibility) in &mut models {
        let Some(Ok(media)) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        if is_hidden(visibility) || parts.media.as_ref() == Some(media) {
            continue;
        }
        let parts = &mut *parts;
        parts.media = Some(*media);
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.clouded = !media.is_clear();
                let through = media.transmittance();
                material.globe.lens_passes = through * through;
                material.globe.lens = media.healthy_backscatter();
                material.globe.nucleus = media.nucleus_color();
                material.globe.cortical_share = media.cortical_share as f32;
                material.globe.capsule = media.capsule_color();
                material.globe.capsule_radius_mm = 0.5 * media.subcapsular_mm as f32;
            }
        }
    }
}

/// Steps of a dioptre in which a lens changes its shape.
pub const FOCUS_STEPS: f64 = 50.0;

/// Shapes the lenses by what they are focused for, where that has changed (Navarro, Santamaría and Bescós 1985).
pub fn focus_lenses(
    eyes: Query<(&Effective<Refraction>, &Accommodation)>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut assets: EyeAssets,
) {
    for (mut parts, visibility) in &mut models {
        let Some(Ok((refraction, accommodation))) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        let steps = (accommodation.response_d * FOCUS_STEPS).round() as i32;
        if is_hidden(visibility) || parts.focus == Some((refraction.0, steps)) {
            continue;
        }
        let parts = &mut *parts;
        parts.focus = Some((refraction.0, steps));
        let response_d = f64::from(steps) / FOCUS_STEPS;
        let lens = LensShape::accommodated(response_d);
        let PowerVector { m_d, j0_d, j45_d } = refraction.0.power_vector().in_view();
        for (_, material) in &parts.globe {
            let part = assets.globes.get(material).map(|material| material.part);
            if part.is_some_and(GlobePart::is_corneal)
                && let Some(mut material) = assets.globes.get_mut(material)
            {
                let [front, back] = [lens.front.as_vec2(), lens.back.as_vec2()];
                material.globe.lens_front_radius_mm = front.x;
                material.globe.lens_front_p = front.y;
                material.globe.lens_back_radius_mm = back.x;
                material.globe.lens_back_p = back.y;
                material.globe.lens_thickness_mm = lens.thickness_mm as f32;
                material.globe.lens_index = lens.index as f32;
                material.globe.lens_forward_mm = lens.forward_mm as f32;
                material.globe.focus = (DVec3::new(m_d - response_d, j0_d, j45_d) * 1e-3).as_vec3();
            }
        }
    }
}

/// Takes an artist's changes into the materials, where they have changed.
pub fn apply_looks(
    eyes: Query<Option<&Look>>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut assets: EyeAssets,
) {
    for (mut parts, visibility) in &mut models {
        let Some(Ok(look)) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        let look = look.copied().unwrap_or_default();
        if is_hidden(visibility) || parts.look == Some(look) {
            continue;
        }
        let parts = &mut *parts;
        parts.look = Some(look);
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.artistic = !look.is_neutral();
                material.globe.look = (&look).into();
                material.globe.relief = look.iris_relief as f32;
            }
        }
    }
}

/// Poses lids, lashes and tears, where lids or gaze changed.
pub fn move_lids(
    eyes: Query<(&Eye, &Gaze, &Effective<Lids>, &EyeOf)>,
    people: Query<&Eyelids>,
    mut models: Query<(&mut EyeParts, &Visibility)>,
    mut assets: EyeAssets,
    region: Res<FaceRegion>,
    ledger: Res<WorkLedger>,
) {
    let Some(region) = &region.0 else { return };
    for (mut parts, visibility) in &mut models {
        let Some(Ok((eye, gaze, own, owner))) = parts.eye.map(|eye| eyes.get(eye)) else {
            continue;
        };
        let Ok(lids) = people.get(owner.0) else {
            continue;
        };
        if is_hidden(visibility) {
            continue;
        }
        let mirror = side(eye.laterality);
        let pose = LidPose {
            aperture: (lids.aperture * own.0.opening) as f32,
            droop: own.0.droop as f32,
            gaze_azimuth_rad: mirror * gaze.azimuth_rad as f32,
            gaze_elevation_rad: gaze.elevation_rad as f32,
            squint: 0.0,
        };
        if parts.pose.as_ref() == Some(&pose) || parts.shape.is_none() {
            continue;
        }
        let parts = &mut *parts;
        let (Some(shape), Some(lashes)) = (&parts.shape, &mut parts.lashes) else {
            continue;
        };
        // Region and globe meet in the right eye's frame; a left eye is mirrored into it.
        let mirrored = Gaze {
            azimuth_rad: gaze.azimuth_rad * f64::from(mirror),
            torsion_rad: gaze.torsion_rad * f64::from(mirror),
            ..*gaze
        };
        let right = Eye {
            laterality: crate::anatomy::Laterality::OD,
            ..eye.clone()
        };
        let axis = mirrored.globe_rotation(&right) * Vec3::NEG_Z;
        let globe_radius = |direction: Vec3| shape.radius_at(axis.dot(direction).into()) as f32;
        region.pose_level(parts.level, &pose, &globe_radius, &mut parts.posed);
        parts.lids = lid_margins(&parts.posed.upper_margin, &parts.posed.lower_margin, mirror);

        let mut vertices = 0;
        let meshes = region.parts(parts.level);
        for (handle, part) in [
            (&parts.skin, &meshes.skin),
            (&parts.margin, &meshes.margin),
            (&parts.conjunctiva_mesh, &meshes.conjunctiva),
        ] {
            let Some(mut mesh) = assets.meshes.get_mut(handle) else {
                continue;
            };
            vertices += part.vertices.len();
            // What lies in the fold or under the lid changes with the pose, so it rides in the weights.
            let tissue = part
                .of_list(region.tissue())
                .zip(part.of_list(&parts.posed.light));
            let tissue = tissue.map(|(weights, light)| [weights[0], weights[1], weights[2], light]);
            let rest = part.of_list(region.rest()).map(|p| [p[0], p[1], p[2], 1.0]);
            fill_mesh(
                &mut mesh,
                part.of_list(&parts.posed.positions),
                part.of_list(&parts.posed.normals),
                tissue.collect(),
                || rest.collect(),
                &part.indices,
                mirror,
            );
        }
        lashes.divide(parts.hair_level);
        lashes.pose(&parts.posed, &mut parts.hair);
        if let Some(mut mesh) = assets.meshes.get_mut(&parts.lash_mesh) {
            vertices += parts.hair.positions.len();
            fill_hair(&mut mesh, &parts.hair, lashes.strips(), mirror);
        }
        if parts.brow_level != Some(parts.hair_level)
            && let Some(brow) = &parts.brow
            && let Some(mut mesh) = assets.meshes.get_mut(&parts.brow_mesh)
        {
            fill_brow(&mut mesh, brow, parts.hair_level, region, shape, mirror);
            ledger.bytes_uploaded(mesh.count_vertices() as u64 * 48);
            parts.brow_level = Some(parts.hair_level);
        }
        if let Some(mut mesh) = assets.meshes.get_mut(&parts.meniscus_mesh) {
            let count = parts.posed.meniscus_positions.len();
            vertices += count;
            fill_mesh(
                &mut mesh,
                parts.posed.meniscus_positions.iter().copied(),
                parts.posed.meniscus_normals.iter().copied(),
                parts.posed.meniscus_gaps().collect(),
                || vec![[0.0, 0.0, 0.0, 1.0]; count],
                region.meniscus_indices(),
                mirror,
            );
        }
        ledger.lid_poses(1);
        ledger.lid_vertices(vertices as u64);
        ledger.bytes_uploaded(vertices as u64 * 48);
        parts.pose = Some(pose);
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.globe.lids = parts.lids;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh_fill::height_at;
    use super::*;

    #[test]
    fn a_film_is_drawn_anew_while_it_changes() {
        assert_eq!(tears_drawn_s(0.4, 20.0), 0.4);
        assert_eq!(tears_drawn_s(7.0, 20.0), tears_drawn_s(19.0, 20.0));
        assert!(tears_drawn_s(21.0, 20.0) > 20.9);
        assert_eq!(tears_drawn_s(1e6, 20.0), 100.0);
        // One that breaks at once changes until it has.
        assert_eq!(
            (tears_drawn_s(2.0, 1.0), tears_drawn_s(9.0, 1.0)),
            (2.0, 5.0)
        );
    }

    #[test]
    fn margins_are_sampled_either_way_round() {
        let margin: Vec<Vec3> = (0..=10)
            .map(|i| Vec3::new(i as f32 - 5.0, (i as f32) * 0.1, -10.0))
            .collect();
        let reversed: Vec<Vec3> = margin.iter().rev().copied().collect();
        for x in [-9.0, -5.0, -0.3, 2.2, 8.0] {
            // The same polyline: equal to rounding.
            assert!((height_at(&margin, x) - height_at(&reversed, x)).abs() < 1e-5);
        }
        assert!((height_at(&margin, -20.0) - 0.0).abs() < 1e-6);
        assert!((height_at(&margin, 0.5) - 0.55).abs() < 1e-5);
    }
}
