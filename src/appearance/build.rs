//! What an eye in the world is made of: its parts' meshes, maps and materials, made when its anatomy is new or
//! changed.

use super::brow::{self, Brow};
use super::face_region::EyeRegion;
use super::globe_mesh::globe_meshes;
use super::illumination::Illumination;
use super::iris_map::DESIGN_PUPIL_RADIUS_MM;
use super::lashes::Lashes;
use super::materials::{
    GlobeMaterial, GlobePart, HairMaterial, HairUniform, MeniscusMaterial, MeniscusUniform,
    SkinMaterial, SkinUniform,
};
use super::mesh_fill::empty_mesh;
use super::model::{
    EyeAssets, EyeDetail, EyeModel, EyePart, EyeParts, FILLED_MM, FaceRegion, METRES_A_MM, side,
};
use super::pose::globe_tag;
use super::tissue_maps::{
    ImageStore, color, margin_flesh, skin_albedo, skin_variation, static_uniform, wrinkles_mm,
};
use crate::anatomy::{Cornea, Effective, Eye, EyeFinder, Iris, Look, Patient, Sclera, Skin};
use crate::frame::ledger::WorkLedger;
use crate::frame::readiness::Readiness;
use crate::optics::globe::GlobeShape;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::prelude::*;

/// What of a person and her eye is built in, so that another name builds nothing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MadeOf {
    eye: Eye,
    cornea: Cornea,
    iris: Iris,
    sclera: Sclera,
    age_years: f64,
    seed: u64,
    skin: Skin,
    fine: bool,
    flush: [f64; 2],
}

/// The anatomy that an eye is built from.
type Built<'a> = (
    &'a Eye,
    &'a Cornea,
    &'a Effective<Iris>,
    &'a Sclera,
    Option<&'a Look>,
);

/// What of a model decides how it is built.
type Model<'a> = (
    Entity,
    &'a EyeModel,
    &'a EyeDetail,
    Option<&'a RenderLayers>,
    Option<&'a Children>,
    &'a mut EyeParts,
);

/// Builds the parts of eyes whose anatomy is new or changed; of eyes that are gone nothing stays.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads and makes"
)]
pub fn build_eyes(
    mut models: Query<Model>,
    finder: EyeFinder,
    eyes: Query<Built>,
    people: Query<(&Patient, &Skin)>,
    old: Query<(), With<EyePart>>,
    region: Res<FaceRegion>,
    ledger: Res<WorkLedger>,
    readiness: Res<Readiness>,
    mut assets: EyeAssets,
    mut commands: Commands,
) {
    for (entity, model, detail, layers, children, mut parts) in &mut models {
        let own = || {
            let children = children.into_iter().flatten().copied();
            children.filter(|child| old.contains(*child))
        };
        let found = finder
            .find(model.0)
            .and_then(|(eye, patient)| Some((eye, eyes.get(eye).ok()?, people.get(patient).ok()?)));
        let Some((eye_entity, (eye, cornea, iris, sclera, look), (patient, skin))) = found else {
            if parts.eye.is_some() {
                own().for_each(|part| commands.entity(part).despawn());
                *parts = EyeParts {
                    built: parts.built + 1,
                    ..default()
                };
            }
            continue;
        };
        let layers = layers.cloned().unwrap_or_default();
        let look = look.copied().unwrap_or_default();
        let made_of = MadeOf {
            eye: eye.clone(),
            cornea: cornea.clone(),
            iris: iris.0.clone(),
            sclera: *sclera,
            age_years: patient.age_years,
            seed: patient.seed,
            skin: *skin,
            fine: detail.fine,
            flush: [look.flush_radius, look.flush_hardness],
        };
        let is_changed = parts.eye != Some(eye_entity) || parts.made_of.as_ref() != Some(&made_of);
        if !is_changed {
            if parts.layers != layers {
                own().for_each(|part| {
                    commands.entity(part).insert(layers.clone());
                });
                parts.layers = layers;
            }
            continue;
        }
        parts.eye = Some(eye_entity);
        parts.made_of = Some(made_of);
        parts.layers = layers.clone();
        own().for_each(|part| commands.entity(part).despawn());
        // Other colours and shapes need no other pipeline, and an eye that is changed all the time is drawn all the time.
        let kinds = [
            cornea.arcus_at(patient.age_years) > 0.0,
            wrinkles_mm(patient.age_years) > 0.0,
        ];
        if parts.kinds != Some(kinds) {
            parts.kinds = Some(kinds);
            readiness.restart();
        }
        let anatomy = Anatomy {
            eye,
            cornea,
            iris: &iris.0,
            sclera,
            look: &look,
            patient,
            skin,
        };
        let mut builder = Builder {
            model: entity,
            layers,
            commands: &mut commands,
            assets: &mut assets,
            ledger: &ledger,
        };
        if let Err(error) = builder.build(&anatomy, detail.fine, region.0.as_ref(), &mut parts) {
            error!("the globe cannot be built: {error}");
        }
    }
}

/// The anatomy of one eye.
pub(super) struct Anatomy<'a> {
    pub(super) eye: &'a Eye,
    pub(super) cornea: &'a Cornea,
    pub(super) iris: &'a Iris,
    pub(super) sclera: &'a Sclera,
    pub(super) look: &'a Look,
    pub(super) patient: &'a Patient,
    pub(super) skin: &'a Skin,
}

/// Makes the parts of one model.
struct Builder<'a, 'c, 's, 'w> {
    model: Entity,
    layers: RenderLayers,
    commands: &'a mut Commands<'c, 's>,
    assets: &'a mut EyeAssets<'w>,
    ledger: &'a WorkLedger,
}

impl Builder<'_, '_, '_, '_> {
    fn build(
        &mut self,
        anatomy: &Anatomy<'_>,
        fine: bool,
        region: Option<&EyeRegion>,
        parts: &mut EyeParts,
    ) -> Result<(), crate::optics::globe::GlobeShapeError> {
        let shape = GlobeShape::new(
            anatomy.eye.scleral_radius_mm,
            anatomy.cornea.anterior_radius_mm,
            anatomy.cornea.anterior_p,
            anatomy.cornea.limbus_radius_mm,
        )?;
        let (illumination, around) = parts
            .lit
            .as_ref()
            .map_or_else(Default::default, |lit| (lit.illumination, lit.map.clone()));
        let seed = anatomy.patient.iris_seed(anatomy.eye.laterality);
        self.globe(anatomy, &shape, (illumination, &around), fine, parts);
        self.skin(anatomy, (illumination, &around), seed, parts);
        self.hair((illumination, &around), seed, region, parts);
        let tears = self.assets.tears.add(MeniscusMaterial {
            meniscus: MeniscusUniform {
                strength: 1.0,
                lids: skin_albedo(anatomy.skin.tone),
            },
            illumination,
            around,
        });
        parts.meniscus_mesh = self.assets.meshes.add(empty_mesh());
        parts.meniscus_material = tears.clone();
        self.add(parts.meniscus_mesh.clone(), MeshMaterial3d(tears));
        parts.pose = None;
        parts.shape = Some(shape);
        parts.head_from_eye = None;
        parts.media = None;
        parts.focus = None;
        parts.tag = None;
        parts.look = None;
        parts.built += 1;
        Ok(())
    }

    /// A part of the head: it does not turn, and its mesh is filled as the lids move.
    fn add(&mut self, mesh: Handle<Mesh>, material: impl Bundle) -> Entity {
        let part = self.commands.spawn((
            EyePart,
            ChildOf(self.model),
            Mesh3d(mesh),
            material,
            NoFrustumCulling,
            Aabb::from_min_max(FILLED_MM.0, FILLED_MM.1),
            Transform::from_scale(Vec3::splat(METRES_A_MM)),
            self.layers.clone(),
        ));
        part.id()
    }

    fn globe(
        &mut self,
        anatomy: &Anatomy<'_>,
        shape: &GlobeShape,
        (illumination, around): (Illumination, &Handle<Image>),
        fine: bool,
        parts: &mut EyeParts,
    ) {
        let mut store = ImageStore {
            images: &mut self.assets.images,
            ledger: self.ledger,
            stromas: &mut self.assets.stromas.0,
        };
        let maps = &mut parts.maps;
        let [sclera_map, vessel_map] = maps.sclera(anatomy, fine, &mut store);
        let iris_map = maps.iris(anatomy, fine, &mut store);
        let reflectance_map = maps.reflectance(anatomy, &mut store);
        let light_table = maps.light(anatomy, &mut store);
        let uniform = static_uniform(anatomy, shape);
        parts.globe.clear();
        for (part, mesh) in [GlobePart::Cornea, GlobePart::Limbus, GlobePart::Sclera]
            .into_iter()
            .zip(globe_meshes(shape))
        {
            let material = self.assets.globes.add(GlobeMaterial {
                part,
                clouded: false,
                artistic: false,
                shading: parts.shading,
                globe: uniform,
                iris_map: iris_map.clone(),
                sclera_map: sclera_map.clone(),
                reflectance_map: reflectance_map.clone(),
                light_table: light_table.clone(),
                vessel_map: vessel_map.clone(),
                illumination,
                around: around.clone(),
            });
            let entity = self.commands.spawn((
                EyePart,
                ChildOf(self.model),
                Mesh3d(self.assets.meshes.add(mesh)),
                MeshMaterial3d(material.clone()),
                // Until the first pose an iris of the map's own pupil.
                globe_tag(DESIGN_PUPIL_RADIUS_MM, 0.0),
                Transform::from_scale(Vec3::splat(METRES_A_MM)),
                self.layers.clone(),
            ));
            parts.globe.push((entity.id(), material));
        }
        let material = self.assets.globes.add(GlobeMaterial {
            part: GlobePart::Conjunctiva,
            clouded: false,
            artistic: false,
            shading: parts.shading,
            globe: uniform,
            iris_map,
            sclera_map,
            reflectance_map,
            light_table,
            vessel_map,
            illumination,
            around: around.clone(),
        });
        parts.conjunctiva_mesh = self.assets.meshes.add(empty_mesh());
        let entity = self.add(
            parts.conjunctiva_mesh.clone(),
            (
                MeshMaterial3d(material.clone()),
                globe_tag(DESIGN_PUPIL_RADIUS_MM, 0.0),
            ),
        );
        parts.globe.push((entity, material));
    }

    fn skin(
        &mut self,
        anatomy: &Anatomy<'_>,
        (illumination, around): (Illumination, &Handle<Image>),
        seed: u64,
        parts: &mut EyeParts,
    ) {
        let variation = skin_variation(anatomy.skin.tone);
        let dry = SkinMaterial {
            wet: false,
            skin: SkinUniform {
                albedo: skin_albedo(anatomy.skin.tone),
                roughness: 0.42,
                flesh: margin_flesh(anatomy.sclera, anatomy.skin),
                pores: 1.0,
                blood: color(variation.blood),
                melanin: color(variation.melanin),
                lid: color(variation.lid),
                wrinkles_mm: wrinkles_mm(anatomy.patient.age_years),
                mirror: side(anatomy.eye.laterality),
            },
            skin_map: parts.maps.skin(
                seed,
                &mut ImageStore {
                    images: &mut self.assets.images,
                    ledger: self.ledger,
                    stromas: &mut self.assets.stromas.0,
                },
            ),
            illumination,
            around: around.clone(),
        };
        let wet = SkinMaterial {
            wet: true,
            ..dry.clone()
        };
        parts.skin_materials = [dry, wet].map(|material| self.assets.skins.add(material));
        parts.skin = self.assets.meshes.add(empty_mesh());
        parts.margin = self.assets.meshes.add(empty_mesh());
        let [dry, wet] = parts.skin_materials.clone();
        self.add(parts.skin.clone(), MeshMaterial3d(dry));
        self.add(parts.margin.clone(), MeshMaterial3d(wet));
    }

    fn hair(
        &mut self,
        (illumination, around): (Illumination, &Handle<Image>),
        seed: u64,
        region: Option<&EyeRegion>,
        parts: &mut EyeParts,
    ) {
        let material = self.assets.hairs.add(HairMaterial {
            hair: HairUniform {
                // Of photographs: 50 38 37 at the base, 96 62 45 in the last third.
                root: Vec3::new(0.030, 0.019, 0.018),
                tip: Vec3::new(0.115, 0.048, 0.026),
            },
            illumination,
            around: around.clone(),
        });
        parts.lash_mesh = self.assets.meshes.add(empty_mesh());
        parts.hair_material = material.clone();
        self.add(parts.lash_mesh.clone(), MeshMaterial3d(material.clone()));
        parts.lashes = Some(Lashes::new(seed));
        parts.brow = region.map(|region| Brow::new(region, brow::COUNT, seed));
        parts.brow_level = None;
        if parts.brow.is_some() {
            parts.brow_mesh = self.assets.meshes.add(empty_mesh());
            self.add(parts.brow_mesh.clone(), MeshMaterial3d(material));
        }
    }
}
