//! The parts of the eye as entities: built when the patient changes, moved when the pose does.

use super::eye_camera::{EYE_LAYER, EyeCamera, camera_bundle};
use super::face_region::{EyeRegion, LidPose, PosedRegion};
use super::globe_mesh::globe_meshes;
use super::hair::HairMesh;
use super::images::map_image;
use super::lashes::Lashes;
use super::light_table::{LAMPS, LightTable, SIDE};
use super::materials::{
    GlobeMaterial, GlobePart, HairMaterial, HairUniform, LidHeights, MeniscusMaterial,
    MeniscusUniform, SkinMaterial, SkinUniform, Studio,
};
use super::mesh_fill::{brow_mesh, empty_mesh, fill_hair, fill_mesh, lid_heights};
use super::tissue_maps::{
    iris_image, light_settings, reflectance_image, sclera_image, skin_albedo, skin_image,
    static_uniform,
};
use crate::anatomy::{Cornea, Eye, Eyelids, GazeController, Iris, Laterality, Pupil, Sclera};
use crate::app::Panels;
use crate::ledger::WorkLedger;
use crate::optics::globe::GlobeShape;
use crate::readiness::Readiness;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

/// Everything about the eye that is on screen, and a version that counts its changes.
#[derive(Resource, Default)]
pub struct EyeParts {
    /// Counts what the next frame would show differently.
    pub version: u64,
    /// Counts how often it was built anew.
    pub built: u64,
    region: Option<EyeRegion>,
    lashes: Option<Lashes>,
    posed: PosedRegion,
    hair: HairMesh,
    pose: Option<LidPose>,
    shape: Option<GlobeShape>,
    lids: LidHeights,
    head_from_eye: Option<Quat>,
    pupil_radius_mm: f32,
    globe: Vec<(Entity, Handle<GlobeMaterial>)>,
    lights: Option<(LightTable, Handle<Image>)>,
    skin: Option<Handle<Mesh>>,
    lash_mesh: Option<Handle<Mesh>>,
    meniscus_mesh: Option<Handle<Mesh>>,
}

impl EyeParts {
    /// Has the lamps' light through the cornea worked out again.
    pub(super) fn relight(&mut self) {
        self.head_from_eye = None;
    }
}

/// Marks what belongs to the eye on screen.
#[derive(Component)]
pub struct EyePart;

/// Rotation of the globe in the head (Fick: azimuth, then elevation, then torsion).
pub fn globe_rotation(gaze: &GazeController) -> Quat {
    Quat::from_rotation_y(-gaze.azimuth_rad as f32)
        * Quat::from_rotation_x(gaze.elevation_rad as f32)
        * Quat::from_rotation_z(-gaze.torsion_rad as f32)
}

type NewPatient = Or<(
    Added<Eye>,
    Changed<Eye>,
    Changed<Cornea>,
    Changed<Iris>,
    Changed<Sclera>,
)>;

/// The stores of the eye's materials, and what lights them.
#[derive(SystemParam)]
pub struct EyeMaterials<'w> {
    studio: Res<'w, Studio>,
    globes: ResMut<'w, Assets<GlobeMaterial>>,
    skins: ResMut<'w, Assets<SkinMaterial>>,
    hairs: ResMut<'w, Assets<HairMaterial>>,
    tears: ResMut<'w, Assets<MeniscusMaterial>>,
}

/// Builds meshes, maps and materials of a patient that is new or changed.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are the assets that it creates"
)]
pub fn build_eye(
    patient: Query<(&Eye, &Cornea, &Iris, &Sclera, &Eyelids), NewPatient>,
    old: Query<Entity, With<EyePart>>,
    cameras: Query<Entity, With<EyeCamera>>,
    panels: Res<Panels>,
    ledger: Res<WorkLedger>,
    readiness: Res<Readiness>,
    mut parts: ResMut<EyeParts>,
    mut commands: Commands,
    (mut meshes, mut images): (ResMut<Assets<Mesh>>, ResMut<Assets<Image>>),
    materials: EyeMaterials,
) {
    let Ok((eye, cornea, iris, sclera, lids)) = patient.single() else {
        return;
    };
    let EyeMaterials {
        studio,
        mut globes,
        mut skins,
        mut hairs,
        mut tears,
    } = materials;
    if cameras.is_empty() {
        commands.spawn(camera_bundle(&panels));
    }
    for entity in &old {
        commands.entity(entity).despawn();
    }
    readiness.restart();

    let shape = match GlobeShape::new(
        eye.scleral_radius_mm,
        cornea.anterior_radius_mm,
        cornea.anterior_p,
        cornea.limbus_radius_mm,
    ) {
        Ok(shape) => shape,
        Err(error) => {
            error!("the globe cannot be built: {error}");
            return;
        }
    };
    let layer = RenderLayers::layer(EYE_LAYER);
    // A small panel cannot show what the large maps hold.
    let fine = panels.eye.size.min_element() > 560;
    let maps = [
        images.add(iris_image(iris, fine)),
        images.add(sclera_image(eye, sclera, fine)),
        images.add(reflectance_image(iris)),
    ];
    ledger.bytes_uploaded(
        maps.iter()
            .filter_map(|map| images.get(map))
            .map(|image| image.data.as_ref().map_or(0, Vec::len) as u64)
            .sum(),
    );
    let [iris_map, sclera_map, reflectance_map] = maps;
    let studio = *studio;
    let uniform = static_uniform(eye, cornea, iris, &shape, studio);
    let light_table = images.add(map_image(
        &[(
            (LAMPS * SIDE) as u32,
            SIDE as u32,
            vec![[0.0; 4]; LAMPS * SIDE * SIDE],
        )],
        false,
    ));
    parts.globe.clear();
    for (part, mesh) in [GlobePart::Cornea, GlobePart::Sclera]
        .into_iter()
        .zip(globe_meshes(&shape))
    {
        let material = globes.add(GlobeMaterial {
            part,
            globe: uniform,
            iris_map: iris_map.clone(),
            sclera_map: sclera_map.clone(),
            reflectance_map: reflectance_map.clone(),
            light_table: light_table.clone(),
        });
        let entity = commands
            .spawn((
                EyePart,
                Mesh3d(meshes.add(mesh)),
                MeshMaterial3d(material.clone()),
                layer.clone(),
            ))
            .id();
        parts.globe.push((entity, material));
    }
    parts.lights = Some((LightTable::new(light_settings(cornea, iris)), light_table));

    if parts.region.is_none() {
        match EyeRegion::load() {
            Ok(region) => parts.region = Some(region),
            Err(error) => error!("the face cannot be built: {error}"),
        }
    }
    parts.lashes = Some(Lashes::new(iris.seed));
    parts.pose = None;
    parts.shape = Some(shape);
    parts.head_from_eye = None;

    // The meshes of the moving parts are filled by `move_lids`.
    let skin_mesh = meshes.add(empty_mesh());
    let lash_mesh = meshes.add(empty_mesh());
    let meniscus_mesh = meshes.add(empty_mesh());
    let albedo = skin_albedo(lids.skin_tone);
    commands.spawn((
        EyePart,
        Mesh3d(skin_mesh.clone()),
        MeshMaterial3d(skins.add(SkinMaterial {
            skin: SkinUniform {
                studio,
                albedo: albedo.extend(0.42),
                flesh: (Vec3::new(0.62, 0.30, 0.26) * (0.55 + 0.45 * albedo.x)).extend(1.0),
                globe: Vec4::new(eye.scleral_radius_mm as f32, 0.0, 0.0, 0.0),
            },
            skin_map: images.add(skin_image(iris.seed)),
        })),
        NoFrustumCulling,
        layer.clone(),
    ));
    let hair_material = hairs.add(HairMaterial {
        hair: HairUniform {
            studio,
            root: Vec4::new(0.010, 0.007, 0.006, 0.0),
            tip: Vec4::new(0.024, 0.016, 0.012, 0.0),
        },
    });
    commands.spawn((
        EyePart,
        Mesh3d(lash_mesh.clone()),
        MeshMaterial3d(hair_material.clone()),
        NoFrustumCulling,
        layer.clone(),
    ));
    commands.spawn((
        EyePart,
        Mesh3d(meniscus_mesh.clone()),
        MeshMaterial3d(tears.add(MeniscusMaterial {
            meniscus: MeniscusUniform {
                studio,
                options: Vec4::new(1.0, 0.0, 0.0, 0.0),
            },
        })),
        NoFrustumCulling,
        layer,
    ));
    if let Some(region) = &parts.region {
        commands.spawn((
            EyePart,
            Mesh3d(meshes.add(brow_mesh(region, &shape, iris.seed, side(eye.laterality)))),
            MeshMaterial3d(hair_material),
            NoFrustumCulling,
            RenderLayers::layer(EYE_LAYER),
        ));
    }
    parts.built += 1;
    parts.skin = Some(skin_mesh);
    parts.lash_mesh = Some(lash_mesh);
    parts.meniscus_mesh = Some(meniscus_mesh);
    parts.version += 1;
}

/// +1 for the right eye, −1 for the left one, whose region is mirrored.
pub(super) fn side(laterality: Laterality) -> f32 {
    match laterality {
        Laterality::OD => 1.0,
        Laterality::OS => -1.0,
    }
}

/// Turns the globe and sets the pupil, where they changed.
pub fn move_eye(
    patient: Query<(&Eye, &GazeController, &Pupil)>,
    mut parts: ResMut<EyeParts>,
    mut globes: ResMut<Assets<GlobeMaterial>>,
    mut images: ResMut<Assets<Image>>,
    mut transforms: Query<&mut Transform>,
    (panels, studio): (Res<Panels>, Res<Studio>),
    ledger: Res<WorkLedger>,
) {
    let Ok((eye, gaze, pupil)) = patient.single() else {
        return;
    };
    if !panels.eye.visible {
        return;
    }
    let rotation = globe_rotation(gaze);
    let radius = (pupil.diameter_mm * 0.5) as f32;
    if parts.head_from_eye == Some(rotation) && parts.pupil_radius_mm == radius {
        return;
    }
    let turned = parts.head_from_eye != Some(rotation);
    parts.head_from_eye = Some(rotation);
    parts.pupil_radius_mm = radius;
    parts.version += 1;
    let nasal = -side(eye.laterality);
    for (entity, material) in &parts.globe {
        if let Ok(mut transform) = transforms.get_mut(*entity) {
            transform.rotation = rotation;
        }
        if let Some(mut material) = globes.get_mut(material) {
            material.globe.head_from_eye = Mat4::from_quat(rotation);
            material.globe.iris.z = radius;
            material.globe.pupil.x = nasal * pupil.decentration_mm[0] as f32;
            material.globe.pupil.y = pupil.decentration_mm[1] as f32;
        }
    }
    if let Some((lights, table)) = parts.lights.as_mut().filter(|_| turned) {
        let eye_from_head = rotation.inverse();
        lights.settings.lamps = [studio.key_direction, studio.fill_direction].map(|lamp| {
            (eye_from_head * lamp.truncate())
                .as_dvec3()
                .normalize_or(DVec3::NEG_Z)
        });
        let level = ((LAMPS * SIDE) as u32, SIDE as u32, lights.texels());
        // Under the same handle: the materials, changed above, bind the new texture.
        if images
            .insert(table.id(), map_image(&[level], false))
            .is_ok()
        {
            ledger.bytes_uploaded((LAMPS * SIDE * SIDE * 8) as u64);
        }
    }
}

/// Poses lids, lashes and tears, where lids or gaze changed.
pub fn move_lids(
    patient: Query<(&Eye, &Eyelids, &GazeController)>,
    mut parts: ResMut<EyeParts>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut globes: ResMut<Assets<GlobeMaterial>>,
    ledger: Res<WorkLedger>,
    panels: Res<Panels>,
) {
    let Ok((eye, lids, gaze)) = patient.single() else {
        return;
    };
    if !panels.eye.visible {
        return;
    }
    let mirror = side(eye.laterality);
    let pose = LidPose {
        aperture: lids.aperture as f32,
        gaze_azimuth_rad: mirror * gaze.azimuth_rad as f32,
        gaze_elevation_rad: gaze.elevation_rad as f32,
        squint: 0.0,
    };
    if parts.pose.as_ref() == Some(&pose) {
        return;
    }
    let parts = &mut *parts;
    let (Some(region), Some(shape), Some(lashes)) =
        (&parts.region, &parts.shape, &mut parts.lashes)
    else {
        return;
    };
    // Region and globe meet in the right eye's frame; a left eye is mirrored into it.
    let mut mirrored_gaze = gaze.clone();
    mirrored_gaze.azimuth_rad *= f64::from(mirror);
    mirrored_gaze.torsion_rad *= f64::from(mirror);
    let eye_from_head = globe_rotation(&mirrored_gaze).inverse();
    let globe_radius =
        |direction: Vec3| shape.radius_along((eye_from_head * direction).as_dvec3()) as f32;
    region.pose(&pose, &globe_radius, &mut parts.posed);
    parts.lids = lid_heights(&parts.posed.upper_margin, &parts.posed.lower_margin, mirror);

    let mut vertices = parts.posed.positions.len();
    if let Some(mut mesh) = parts
        .skin
        .as_ref()
        .and_then(|handle| meshes.get_mut(handle))
    {
        // What lies in the fold or under the lid changes with the pose, so it rides in the weights.
        let tissue = region.tissue().iter().zip(&parts.posed.light);
        let tissue = tissue.map(|(weights, light)| [weights[0], weights[1], weights[2], *light]);
        let rest = region.rest().iter().map(|p| [p[0], p[1], p[2], 1.0]);
        fill_mesh(
            &mut mesh,
            &parts.posed.positions,
            &parts.posed.normals,
            tissue.collect(),
            || rest.collect(),
            region.indices(),
            mirror,
        );
    }
    lashes.pose(&parts.posed, &mut parts.hair);
    if let Some(mut mesh) = parts
        .lash_mesh
        .as_ref()
        .and_then(|handle| meshes.get_mut(handle))
    {
        vertices += parts.hair.positions.len();
        fill_hair(
            &mut mesh,
            &parts.hair,
            lashes.parameter(),
            lashes.indices(),
            mirror,
        );
    }
    if let Some(mut mesh) = parts
        .meniscus_mesh
        .as_ref()
        .and_then(|handle| meshes.get_mut(handle))
    {
        let count = parts.posed.meniscus_positions.len();
        vertices += count;
        fill_mesh(
            &mut mesh,
            &parts.posed.meniscus_positions,
            &parts.posed.meniscus_normals,
            vec![[0.0; 4]; count],
            || vec![[0.0, 0.0, 0.0, 1.0]; count],
            region.meniscus_indices(),
            mirror,
        );
    }
    ledger.lid_poses(1);
    ledger.lid_vertices(vertices as u64);
    ledger.bytes_uploaded(vertices as u64 * 48);
    parts.pose = Some(pose);
    parts.version += 1;
    for (_, material) in &parts.globe {
        if let Some(mut material) = globes.get_mut(material) {
            material.globe.lids = parts.lids;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh_fill::height_at;
    use super::*;

    #[test]
    fn gaze_turns_the_globe_the_right_way() {
        let gaze = GazeController {
            azimuth_rad: 0.3,
            elevation_rad: 0.2,
            ..GazeController::default()
        };
        let forward = globe_rotation(&gaze) * Vec3::NEG_Z;
        let expected = Vec3::new(
            0.3f32.sin() * 0.2f32.cos(),
            0.2f32.sin(),
            -(0.3f32.cos() * 0.2f32.cos()),
        );
        // f32 rotation of a unit vector.
        assert!((forward - expected).length() < 1e-6, "{forward} {expected}");
        let torted = GazeController {
            torsion_rad: 0.1,
            ..GazeController::default()
        };
        // Positive torsion: the top of the eye goes to the patient's right (+x).
        assert!((globe_rotation(&torted) * Vec3::Y).x > 0.05);
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
