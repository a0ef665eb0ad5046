//! The parts of the eye as entities: built when the patient changes, moved when the pose does.

use super::brow::Brow;
use super::eye_camera::{EYE_LAYER, EyeCamera, camera_bundle};
use super::face_region::{EyeRegion, LidPose, PosedRegion};
use super::globe_mesh::globe_meshes;
use super::hair::{HairMesh, RINGS, SIDES};
use super::images::{map_image, mip_chain};
use super::iris_map::{IrisMap, IrisMapSettings};
use super::lashes::Lashes;
use super::light_table::{LAMPS, LightTableSettings, SIDE};
use super::materials::{
    GlobeMaterial, GlobePart, GlobeUniform, HairMaterial, HairUniform, LID_HALF_SPAN_MM,
    LID_SAMPLES, LidHeights, MeniscusMaterial, MeniscusUniform, SkinMaterial, SkinUniform, Studio,
};
use super::sclera_map::{ScleraMap, ScleraMapSettings};
use crate::anatomy::{Cornea, Eye, Eyelids, GazeController, Iris, Laterality, Pupil, Sclera};
use crate::app::Panels;
use crate::ledger::WorkLedger;
use crate::optics::globe::GlobeShape;
use crate::readiness::Readiness;
use crate::tissue::iris_reflectance::{IrisPigment, IrisReflectanceTable};
use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::ecs::system::SystemParam;
use bevy::math::{DVec2, DVec3};
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;

/// Everything about the eye that is on screen, and a version that counts its changes.
#[derive(Resource, Default)]
pub struct EyeParts {
    /// Counts what the next frame would show differently.
    pub version: u64,
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
    lights: Option<(LightTableSettings, Handle<Image>)>,
    skin: Option<Handle<Mesh>>,
    lash_mesh: Option<Handle<Mesh>>,
    meniscus_mesh: Option<Handle<Mesh>>,
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

/// Albedo (linear sRGB) of skin from very light (0) to very dark (1).
fn skin_albedo(tone: f64) -> Vec3 {
    let light = Vec3::new(0.72, 0.47, 0.36);
    let middle = Vec3::new(0.42, 0.225, 0.135);
    let dark = Vec3::new(0.085, 0.042, 0.026);
    let tone = tone.clamp(0.0, 1.0) as f32;
    if tone < 0.5 {
        light.lerp(middle, tone * 2.0)
    } else {
        middle.lerp(dark, tone * 2.0 - 1.0)
    }
}

type NewPatient = Or<(
    Added<Eye>,
    Changed<Eye>,
    Changed<Cornea>,
    Changed<Iris>,
    Changed<Sclera>,
)>;

/// The stores of the eye's materials.
#[derive(SystemParam)]
pub struct EyeMaterials<'w> {
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
    let uniform = static_uniform(eye, cornea, iris, &shape);
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
    parts.lights = Some((light_settings(cornea, iris), light_table));

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
    let studio = Studio::default();
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
    parts.skin = Some(skin_mesh);
    parts.lash_mesh = Some(lash_mesh);
    parts.meniscus_mesh = Some(meniscus_mesh);
    parts.version += 1;
}

/// +1 for the right eye, −1 for the left one, whose region is mirrored.
fn side(laterality: Laterality) -> f32 {
    match laterality {
        Laterality::OD => 1.0,
        Laterality::OS => -1.0,
    }
}

fn iris_image(iris: &Iris, fine: bool) -> Image {
    let map = IrisMap::new(
        &iris_settings(iris),
        if fine { 2048 } else { 1024 },
        if fine { 512 } else { 256 },
    );
    map_image(&map.levels(), true)
}

/// A map's 32-bit seed from a patient's 64-bit one.
fn fold(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

/// The border layer covers the stroma of a dark iris and leaves that of a light one bare.
fn iris_settings(iris: &Iris) -> IrisMapSettings {
    let (light, dark) = (
        IrisPigment::BLUE.border_layer_melanin_fraction,
        IrisPigment::BROWN.border_layer_melanin_fraction,
    );
    let share = (iris.border_layer_melanin_fraction - light) / (dark - light);
    let share = share.clamp(0.0, 1.0) as f32;
    // A little pigment gathers about the collarette first: hazel and green eyes.
    let ring = 4.0 * share * (1.0 - share);
    IrisMapSettings {
        seed: fold(iris.seed),
        border_layer_cover: 0.15 + 0.6 * share,
        central_heterochromia: 0.3 + 0.5 * ring,
        crypt_density: 0.5 - 0.15 * share,
        furrow_count: if share > 0.7 { 5 } else { 4 },
        ..IrisMapSettings::default()
    }
}

fn skin_image(seed: u64) -> Image {
    let side = super::skin_map::SIDE as u32;
    let tile = super::skin_map::skin_tile(fold(seed));
    let mut image = map_image(&mip_chain((side, side, tile)), true);
    if let bevy::image::ImageSampler::Descriptor(sampler) = &mut image.sampler {
        sampler.address_mode_v = bevy::image::ImageAddressMode::Repeat;
    }
    image
}

/// The studio's lamps as the light table wants them; their directions are set when the eye turns.
fn light_settings(cornea: &Cornea, iris: &Iris) -> LightTableSettings {
    LightTableSettings {
        surface: DVec2::new(cornea.anterior_radius_mm, cornea.anterior_p),
        index: cornea.aqueous_index,
        iris_z: iris.depth_mm,
        root_mm: iris.root_radius_mm,
        limbus_mm: cornea.limbus_radius_mm,
        lamps: [DVec3::NEG_Z; LAMPS],
    }
}

fn sclera_image(eye: &Eye, sclera: &Sclera, fine: bool) -> Image {
    let map = ScleraMap::new(
        &ScleraMapSettings {
            seed: fold(sclera.seed),
            age_years: eye.age_years as f32,
            redness: sclera.redness as f32,
            nasal_sign: -side(eye.laterality),
        },
        if fine { 1024 } else { 512 },
    );
    map_image(&map.levels(), false)
}

fn reflectance_image(iris: &Iris) -> Image {
    let table = IrisReflectanceTable::new(
        &IrisPigment {
            stroma_melanin_fraction: iris.stroma_melanin_fraction,
            border_layer_melanin_fraction: iris.border_layer_melanin_fraction,
            eumelanin_ratio: iris.eumelanin_ratio,
        },
        64,
        32,
    );
    let texels = table
        .rgb()
        .iter()
        .map(|rgb| [rgb[0] as f32, rgb[1] as f32, rgb[2] as f32, 1.0])
        .collect();
    map_image(&mip_chain((64, 32, texels))[..1], false)
}

fn empty_mesh() -> Mesh {
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0f32; 3]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0f32, 0.0, -1.0]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[0.0f32, 0.0, 0.0, 1.0]; 3])
    .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0f32; 4]; 3])
    .with_inserted_indices(Indices::U32(vec![0, 1, 2]))
}

fn static_uniform(eye: &Eye, cornea: &Cornea, iris: &Iris, shape: &GlobeShape) -> GlobeUniform {
    GlobeUniform {
        studio: Studio::default(),
        lids: LidHeights::default(),
        head_from_eye: Mat4::IDENTITY,
        cornea: Vec4::new(
            cornea.anterior_radius_mm as f32,
            cornea.anterior_p as f32,
            cornea.posterior_radius_mm as f32,
            cornea.posterior_p as f32,
        ),
        cornea_inside: Vec4::new(
            cornea.thickness_mm as f32,
            cornea.index as f32,
            cornea.aqueous_index as f32,
            shape.apex_distance_mm() as f32,
        ),
        iris: Vec4::new(
            iris.depth_mm as f32,
            iris.root_radius_mm as f32,
            2.0,
            cornea.limbus_radius_mm as f32,
        ),
        pupil: Vec4::new(
            0.0,
            0.0,
            eye.scleral_radius_mm as f32,
            cornea.lipid_thickness_nm as f32,
        ),
        options: Vec4::new(
            // The old lens scatters: 0 at 40 years, 1 at 90.
            ((eye.age_years - 40.0) / 50.0).clamp(0.0, 1.0) as f32,
            0.5,
            side(eye.laterality),
            1.0,
        ),
    }
}

/// Turns the globe and sets the pupil, where they changed.
pub fn move_eye(
    patient: Query<(&Eye, &GazeController, &Pupil)>,
    mut parts: ResMut<EyeParts>,
    mut globes: ResMut<Assets<GlobeMaterial>>,
    mut images: ResMut<Assets<Image>>,
    mut transforms: Query<&mut Transform>,
    panels: Res<Panels>,
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
    if let Some((settings, table)) = parts.lights.as_mut().filter(|_| turned) {
        let studio = Studio::default();
        let eye_from_head = rotation.inverse();
        settings.lamps = [studio.key_direction, studio.fill_direction].map(|lamp| {
            (eye_from_head * lamp.truncate())
                .as_dvec3()
                .normalize_or(DVec3::NEG_Z)
        });
        let level = ((LAMPS * SIDE) as u32, SIDE as u32, settings.texels());
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

/// Puts a pose into a mesh; what does not move (`rest`, indices) only the first time. The region
/// is a right eye's; `mirror` = −1 makes it a left one's.
fn fill_mesh(
    mesh: &mut Mesh,
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    tissue: Vec<[f32; 4]>,
    rest: impl FnOnce() -> Vec<[f32; 4]>,
    indices: &[u32],
    mirror: f32,
) {
    let first_time = mesh.count_vertices() != positions.len();
    let turned = |vectors: &[[f32; 3]]| -> Vec<[f32; 3]> {
        vectors
            .iter()
            .map(|v| [mirror * v[0], v[1], v[2]])
            .collect()
    };
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, turned(positions));
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, turned(normals));
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, tissue);
    if first_time {
        mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, rest());
        let mut indices = indices.to_vec();
        if mirror < 0.0 {
            // A mirror image winds the other way.
            for triangle in indices.chunks_exact_mut(3) {
                triangle.swap(1, 2);
            }
        }
        mesh.insert_indices(Indices::U32(indices));
    }
}

/// Puts posed hairs into a mesh: the weights hold each vertex' direction and place along the hair.
fn fill_hair(mesh: &mut Mesh, hair: &HairMesh, parameter: &[f32], indices: &[u32], mirror: f32) {
    let count = hair.positions.len();
    let at = |index: usize| Vec3::from(hair.positions[index.min(count - 1)]);
    let along = (0..count).map(|index| {
        let ring = index / SIDES % RINGS;
        let (from, to) = if ring + 1 < RINGS {
            (index, index + SIDES)
        } else {
            (index - SIDES, index)
        };
        let direction = (at(to) - at(from)).normalize_or(Vec3::NEG_Z);
        [
            mirror * direction.x,
            direction.y,
            direction.z,
            parameter[index],
        ]
    });
    let along = along.collect();
    let rest = || vec![[0.0, 0.0, 0.0, 1.0]; count];
    fill_mesh(
        mesh,
        &hair.positions,
        &hair.normals,
        along,
        rest,
        indices,
        mirror,
    );
}

/// The brow rides on skin that hardly moves, so it is posed once, with the lids open.
fn brow_mesh(region: &EyeRegion, shape: &GlobeShape, seed: u64, mirror: f32) -> Mesh {
    let brow = Brow::new(region, 700, seed);
    let mut posed = PosedRegion::default();
    let radius = |direction: Vec3| shape.radius_along(direction.as_dvec3()) as f32;
    region.pose(&LidPose::default(), &radius, &mut posed);
    let mut hair = HairMesh::default();
    brow.pose(&posed, &mut hair);
    let mut mesh = empty_mesh();
    if !hair.positions.is_empty() {
        fill_hair(&mut mesh, &hair, brow.parameter(), brow.indices(), mirror);
    }
    mesh
}

/// Heights of the margins at fixed x, for the shader's lid shadow.
fn lid_heights(upper: &[Vec3], lower: &[Vec3], mirror: f32) -> LidHeights {
    let sample = |margin: &[Vec3]| {
        let mut heights = [Vec4::ZERO; LID_SAMPLES / 4];
        for i in 0..LID_SAMPLES {
            let across = i as f32 / (LID_SAMPLES - 1) as f32 * 2.0 - 1.0;
            heights[i / 4][i % 4] = height_at(margin, mirror * across * LID_HALF_SPAN_MM);
        }
        heights
    };
    LidHeights {
        upper: sample(upper),
        lower: sample(lower),
    }
}

/// Height of a polyline at x, its ends extended flat; x may run either way.
fn height_at(margin: &[Vec3], x: f32) -> f32 {
    let mut nearest = (f32::INFINITY, 0.0);
    for pair in margin.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let span = b.x - a.x;
        let s = if span.abs() > 1e-6 {
            ((x - a.x) / span).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let at = a.lerp(b, s);
        let off = (at.x - x).abs();
        if off < nearest.0 {
            nearest = (off, at.y);
        }
    }
    nearest.1
}

#[cfg(test)]
mod tests {
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
