//! From a patient file to entities, and back.
//!
//! Enters: a [`PatientFile`], put on an entity. Leaves: that entity as a person with two eyes; the file
//! itself is gone, so that every number has one owner. [`PatientReader`] reads a person's file back
//! from her components.

use super::file::{ConditionParts, FIELDS, PatientFile, PupilSetting};
use crate::anatomy::{
    Cornea, Eye, EyeOf, Eyes, Iris, Laterality, Lens, Lids, Look, OcularMedia, Patient,
    PupilControl, Refraction, Sclera, Skin, USUAL_PUPIL_MM, VisualField,
};
use crate::conditions::{Affected, put};
use crate::optics::accommodation::hofstetter_amplitude_d;
use crate::percept::SharpnessField;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::system::SystemParam;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

/// How far the root of the iris lies behind the limbus, mm.
const ROOT_BEYOND_LIMBUS_MM: f64 = 0.2;

/// What a person's eye is made of.
type EyeBundle = (Eye, Cornea, Iris, Lens, Refraction, Sclera, Lids, Look);

impl PatientFile {
    /// The person's own components.
    fn person(&self) -> (Patient, Skin) {
        (
            Patient {
                name: self.name.clone(),
                description: self.description.clone(),
                age_years: self.age_years,
                leading: self.eye,
                interpupillary_mm: self.interpupillary_mm,
                seed: self.seed,
            },
            Skin {
                tone: self.skin_tone,
            },
        )
    }

    /// How she remembers; what she remembers stays.
    fn memory(&self, now: Option<&SharpnessField>) -> SharpnessField {
        let (starve_rate_per_s, voxel_m, blur_cap_rad) = (
            self.starve_rate_per_s,
            self.voxel_mm * 1e-3,
            self.blur_cap_arcmin.to_radians() / 60.0,
        );
        match now.cloned() {
            None => SharpnessField::new(starve_rate_per_s, voxel_m, blur_cap_rad),
            Some(mut memory) => {
                memory.starve_rate_per_s = starve_rate_per_s;
                memory.voxel_m = voxel_m;
                memory.blur_cap_rad = blur_cap_rad;
                memory
            }
        }
    }

    /// The components of one eye.
    pub fn eye_components(&self, laterality: Laterality) -> EyeBundle {
        let own = self.of_eye(laterality);
        (
            Eye {
                laterality,
                scleral_radius_mm: own.scleral_radius_mm,
                angle_alpha_deg: own.angle_alpha_deg,
            },
            Cornea {
                anterior_radius_mm: own.cornea_radius_mm,
                anterior_p: own.cornea_p,
                posterior_radius_mm: own.cornea_posterior_radius_mm,
                posterior_p: own.cornea_posterior_p,
                thickness_mm: own.cornea_thickness_mm,
                index: own.cornea_index,
                aqueous_index: own.aqueous_index,
                limbus_radius_mm: own.limbus_radius_mm,
                lipid_thickness_nm: own.lipid_thickness_nm,
                tear_breakup_s: own.tear_breakup_s,
                arcus: own.arcus,
            },
            Iris {
                color: own.iris_color,
                stroma_melanin_fraction: own.stroma_melanin_fraction,
                border_layer_melanin_fraction: own.border_layer_melanin_fraction,
                collarette_melanin_fraction: own.collarette_melanin_fraction,
                eumelanin_ratio: own.eumelanin_ratio,
                depth_mm: own.iris_depth_mm,
                cone_deg: own.iris_cone_deg,
                bowing_mm: own.iris_bowing_mm,
                root_radius_mm: own.limbus_radius_mm + ROOT_BEYOND_LIMBUS_MM,
                freckles: own.iris_freckles,
                sector_deg: own.iris_sector_deg,
                sector_at_deg: own.iris_sector_at_deg,
                pupil_decentration_mm: own.pupil_decentration_mm,
            },
            Lens {
                amplitude_d: own.accommodation_amplitude_d,
            },
            Refraction {
                sphere_d: own.sphere_d,
                cylinder_d: own.cylinder_d,
                axis_deg: own.axis_deg,
            },
            Sclera {
                redness: own.redness,
                bilirubin_mg_dl: own.bilirubin_mg_dl,
                pinguecula: own.pinguecula,
            },
            Lids {
                opening: own.lid_opening,
                droop: 0.0,
            },
            Look {
                iris_brightness: own.look_iris_brightness,
                iris_size: own.look_iris_size,
                iris_relief: own.look_iris_relief,
                refraction: own.look_refraction,
                caustic_scale: own.look_caustic_scale,
                caustic_power: own.look_caustic_power,
                cornea_roughness: own.look_cornea_roughness,
                cornea_specularity: own.look_cornea_specularity,
                limbus_dark: own.look_limbus_dark,
                limbus_power: own.look_limbus_power,
                limbus_color_mm: own.look_limbus_color_mm,
                limbus_shading_mm: own.look_limbus_shading_mm,
                white_brightness: own.look_white_brightness,
                white_roughness: own.look_white_roughness,
                white_specularity: own.look_white_specularity,
                white_relief: own.look_white_relief,
                white_relief_size: own.look_white_relief_size,
                flush_radius: own.look_flush_radius,
                flush_hardness: own.look_flush_hardness,
                parallax: own.look_parallax,
                matcap: own.look_matcap,
            },
        )
    }

    /// An eye as it would be without its conditions.
    fn without_conditions(&self, laterality: Laterality) -> Affected {
        let (_, _, iris, _, refraction, _, lids, _) = self.eye_components(laterality);
        Affected {
            field: VisualField::normal(laterality, self.age_years),
            media: OcularMedia::healthy(self.age_years, iris.color.glare_pigment()),
            refraction,
            iris,
            lids,
        }
    }

    /// The media of an eye, with what its conditions do to them.
    pub fn media(&self, laterality: Laterality) -> OcularMedia {
        let mut affected = self.without_conditions(laterality);
        self.of_eye(laterality).write_conditions(&mut affected);
        affected.media
    }

    /// What a reader should know of how it is shown, a sentence without full stop each.
    pub fn remarks(&self) -> Vec<String> {
        let [right, left] = Laterality::BOTH.map(|laterality| {
            let look = self.eye_components(laterality).7;
            let without = self.without_conditions(laterality);
            let mut remarks = self.of_eye(laterality).condition_remarks(without);
            if self.of_eye(laterality).lid_opening == 0.0 {
                remarks.push("the lids are shut (lid_opening 0), and what is seen is black".into());
            }
            remarks.extend(self.of_eye(laterality).cut_blur());
            if !look.is_neutral() {
                remarks.push(self.of_eye(laterality).artists_choices());
            }
            remarks
        });
        if right == left {
            return right;
        }
        let of = |eye: &'static str, remarks: Vec<String>| {
            remarks
                .into_iter()
                .map(move |remark| format!("the {eye} eye: {remark}"))
        };
        of("right", right).chain(of("left", left)).collect()
    }

    /// That its largest blur is not shown whole: of what is far away through the usual pupil, or the one that is held.
    fn cut_blur(&self) -> Option<String> {
        let pupil_mm = self.pupil.diameter_mm().unwrap_or(USUAL_PUPIL_MM);
        // The more short-sighted of the two meridians, or the more long-sighted beyond what the lens makes up for.
        let meridians = [self.sphere_d, self.sphere_d + self.cylinder_d];
        let amplitude_d = self
            .accommodation_amplitude_d
            .unwrap_or_else(|| hofstetter_amplitude_d(self.age_years));
        let off_d = meridians
            .into_iter()
            .map(|d| (-d).max(d - amplitude_d))
            .fold(0.0, f64::max);
        let arcmin = (1e-3 * pupil_mm * off_d).to_degrees() * 60.0;
        (arcmin > self.blur_cap_arcmin).then(|| {
            format!(
                "what is far away is blurred over {arcmin:.0}′ through a pupil of {pupil_mm} mm, and shown with \
                 {} at most (blur_cap_arcmin)",
                self.blur_cap_arcmin
            )
        })
    }

    /// Names the fields in which an artist has chosen otherwise than anatomy has it.
    fn artists_choices(&self) -> String {
        let usual = Self::default();
        let chosen: Vec<String> = FIELDS
            .iter()
            .filter(|field| field.name.starts_with("look_"))
            .filter_map(|field| {
                let value =
                    (field.get)(self).filter(|value| (field.get)(&usual) != Some(*value))?;
                Some(format!("{} = {value}", field.name))
            })
            .collect();
        let (are, choice) = match chosen.len() {
            1 => ("is", "an artist's choice"),
            _ => ("are", "an artist's choices"),
        };
        format!("{} {are} {choice}, not anatomy", chosen.join(", "))
    }

    /// Makes an entity this person. Eyes that she has already become those of the file, and what she had of
    /// conditions herself goes; what an entity without eyes was spawned with stays.
    fn write_to(self, person: &mut EntityWorldMut) {
        let held_mm = person
            .get::<PupilControl>()
            .and_then(|control| control.held_mm);
        let (patient, skin) = self.person();
        put(person, patient);
        put(person, skin);
        put(
            person,
            PupilControl {
                fixed_mm: self.pupil.diameter_mm(),
                held_mm,
            },
        );
        let now = person.get::<SharpnessField>();
        let memory = self.memory(now);
        if now.is_none_or(|now| !now.fades_like(&memory)) {
            person.insert(memory);
        }
        let owner = person.id();
        let there = person
            .get::<Eyes>()
            .map_or_else(Vec::new, |eyes| eyes.entities().to_vec());
        // A file that makes somebody another says all that either eye has; one that makes somebody leaves
        // what she is spawned with.
        if !there.is_empty() {
            Self::remove_conditions(person);
        }
        person.world_scope(|world| {
            for laterality in Laterality::BOTH {
                let found = there.iter().copied().find(|eye| {
                    world
                        .get::<Eye>(*eye)
                        .is_some_and(|eye| eye.laterality == laterality)
                });
                let mut eye = match found {
                    Some(eye) => world.entity_mut(eye),
                    None => world.spawn(EyeOf(owner)),
                };
                let (globe, cornea, iris, lens, refraction, sclera, lids, look) =
                    self.eye_components(laterality);
                put(&mut eye, globe);
                put(&mut eye, cornea);
                put(&mut eye, iris);
                put(&mut eye, lens);
                put(&mut eye, refraction);
                put(&mut eye, sclera);
                put(&mut eye, lids);
                put(&mut eye, look);
                self.of_eye(laterality).put_conditions(&mut eye);
            }
        });
    }
}

/// Takes a file off the entity that it was put on, and makes that entity the patient.
pub(super) fn replace_with_components(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| {
        let Ok(mut person) = world.get_entity_mut(entity) else {
            return;
        };
        if let Some(file) = person.take::<PatientFile>() {
            file.write_to(&mut person);
        }
    });
}

impl Patient {
    /// A built-in patient, to be spawned; [`super::PRESETS`] names them.
    ///
    /// # Panics
    /// Where there is none of this name; [`super::load_patient`] gives an error instead.
    pub fn preset(name: &str) -> PatientFile {
        assert!(
            super::preset(name).is_some(),
            "there is no built-in patient {name:?}"
        );
        super::load_patient(name).unwrap_or_default()
    }
}

type PersonParts = (
    &'static Patient,
    &'static Skin,
    &'static SharpnessField,
    &'static PupilControl,
    &'static Eyes,
    ConditionParts<'static>,
);

type EyeParts = (
    &'static Eye,
    &'static Cornea,
    &'static Iris,
    &'static Lens,
    &'static Refraction,
    &'static Sclera,
    &'static Lids,
    Option<&'static Look>,
    ConditionParts<'static>,
);

/// Reads the files of people from their components.
#[derive(SystemParam)]
pub struct PatientReader<'w, 's> {
    people: Query<'w, 's, PersonParts>,
    eyes: Query<'w, 's, EyeParts>,
}

impl PatientReader<'_, '_> {
    /// The file that makes this person; `None` where the entity is none.
    pub fn file(&self, patient: Entity) -> Option<PatientFile> {
        let (patient, skin, field, pupil, eyes, conditions) = self.people.get(patient).ok()?;
        let mut shared = PatientFile {
            name: patient.name.clone(),
            description: patient.description.clone(),
            eye: patient.leading,
            age_years: patient.age_years,
            interpupillary_mm: patient.interpupillary_mm,
            seed: patient.seed,
            pupil: pupil
                .fixed_mm
                .map_or(PupilSetting::Auto, PupilSetting::Fixed),
            skin_tone: skin.tone,
            starve_rate_per_s: field.starve_rate_per_s,
            voxel_mm: field.voxel_m * 1e3,
            blur_cap_arcmin: field.blur_cap_rad.to_degrees() * 60.0,
            ..PatientFile::default()
        };
        // Of an eye that has not its own.
        shared.take_conditions(conditions);
        let of = |wanted: Laterality| {
            eyes.entities().iter().find_map(|eye| {
                let parts = self.eyes.get(*eye).ok()?;
                (parts.0.laterality == wanted).then(|| with_eye(&shared, parts))
            })
        };
        let (leading, other) = (of(patient.leading), of(patient.leading.other()));
        match (leading, other) {
            (Some(leading), Some(other)) => Some(PatientFile::join(leading, &other)),
            (one, other) => one.or(other),
        }
    }
}

/// The file of a person both of whose eyes are like this one.
fn with_eye(
    shared: &PatientFile,
    (eye, cornea, iris, lens, refraction, sclera, lids, look, conditions): <EyeParts as bevy::ecs::query::QueryData>::Item<'_, '_>,
) -> PatientFile {
    let look = look.copied().unwrap_or_default();
    let mut file = PatientFile {
        iris_color: iris.color,
        sphere_d: refraction.sphere_d,
        cylinder_d: refraction.cylinder_d,
        axis_deg: refraction.axis_deg,
        cornea_radius_mm: cornea.anterior_radius_mm,
        cornea_p: cornea.anterior_p,
        cornea_posterior_radius_mm: cornea.posterior_radius_mm,
        cornea_posterior_p: cornea.posterior_p,
        cornea_thickness_mm: cornea.thickness_mm,
        cornea_index: cornea.index,
        aqueous_index: cornea.aqueous_index,
        limbus_radius_mm: cornea.limbus_radius_mm,
        iris_depth_mm: iris.depth_mm,
        iris_cone_deg: iris.cone_deg,
        iris_bowing_mm: iris.bowing_mm,
        scleral_radius_mm: eye.scleral_radius_mm,
        lipid_thickness_nm: cornea.lipid_thickness_nm,
        tear_breakup_s: cornea.tear_breakup_s,
        arcus: cornea.arcus,
        iris_freckles: iris.freckles,
        iris_sector_deg: iris.sector_deg,
        iris_sector_at_deg: iris.sector_at_deg,
        redness: sclera.redness,
        bilirubin_mg_dl: sclera.bilirubin_mg_dl,
        pinguecula: sclera.pinguecula,
        lid_opening: lids.opening,
        look_iris_brightness: look.iris_brightness,
        look_iris_size: look.iris_size,
        look_iris_relief: look.iris_relief,
        look_refraction: look.refraction,
        look_caustic_scale: look.caustic_scale,
        look_caustic_power: look.caustic_power,
        look_cornea_roughness: look.cornea_roughness,
        look_cornea_specularity: look.cornea_specularity,
        look_limbus_dark: look.limbus_dark,
        look_limbus_power: look.limbus_power,
        look_limbus_color_mm: look.limbus_color_mm,
        look_limbus_shading_mm: look.limbus_shading_mm,
        look_white_brightness: look.white_brightness,
        look_white_roughness: look.white_roughness,
        look_white_specularity: look.white_specularity,
        look_white_relief: look.white_relief,
        look_white_relief_size: look.white_relief_size,
        look_flush_radius: look.flush_radius,
        look_flush_hardness: look.flush_hardness,
        look_parallax: look.parallax,
        look_matcap: look.matcap,
        stroma_melanin_fraction: iris.stroma_melanin_fraction,
        border_layer_melanin_fraction: iris.border_layer_melanin_fraction,
        collarette_melanin_fraction: iris.collarette_melanin_fraction,
        eumelanin_ratio: iris.eumelanin_ratio,
        accommodation_amplitude_d: lens.amplitude_d,
        pupil_decentration_mm: iris.pupil_decentration_mm,
        angle_alpha_deg: eye.angle_alpha_deg,
        ..shared.clone()
    };
    file.take_conditions(conditions);
    file
}

#[cfg(test)]
mod tests {
    use super::super::EyeFile;
    use super::super::parse::parse_patient;
    use super::*;
    use bevy::ecs::system::RunSystemOnce;

    /// What the largest blur that is shown cuts off is said of short sight, of long sight beyond what the lens makes up for, and of which eye.
    #[test]
    fn a_blur_that_is_cut_is_said() {
        let of = |sphere_d: f64, age_years: f64| PatientFile {
            sphere_d,
            age_years,
            ..PatientFile::default()
        };
        let said = |file: &PatientFile| file.remarks().iter().any(|r| r.contains("blurred over"));
        assert!(said(&of(-12.0, 30.0)) && said(&of(12.0, 70.0)));
        // 12 D are made up for by the lens of a child, and 2 D blur less than what is shown.
        assert!(!said(&of(12.0, 8.0)) && !said(&of(2.0, 70.0)));
        let text = "(left: (sphere_d: -20.0))";
        let found = parse_patient(text, "p.ron").expect("sound").remarks();
        let [one] = &found[..] else {
            panic!("{found:?}")
        };
        assert!(
            one.starts_with("the left eye: what is far away is blurred over 275′"),
            "{one}"
        );
    }

    fn read_back(world: &mut World, patient: Entity) -> PatientFile {
        world
            .run_system_once(move |patients: PatientReader| patients.file(patient))
            .expect("it runs")
            .expect("a patient")
    }

    #[test]
    fn a_condition_of_a_person_ends_with_a_file_without_it() {
        use crate::conditions::Cataract;
        let mut world = World::new();
        let patient = world
            .spawn((Patient::preset("healthy-blue"), Cataract::nuclear(2.5)))
            .id();
        world.flush();
        assert!(world.get::<Cataract>(patient).is_some());
        let file = read_back(&mut world, patient);
        assert_eq!(file.cataract, Some(Cataract::nuclear(2.5)));
        let healthy = PatientFile {
            cataract: None,
            ..file
        };
        world.entity_mut(patient).insert(healthy.clone());
        world.flush();
        assert!(world.get::<Cataract>(patient).is_none());
        assert_eq!(read_back(&mut world, patient), healthy);
    }

    #[test]
    fn an_empty_file_gives_what_components_have_by_default() {
        let file = PatientFile::default();
        let (patient, skin) = file.person();
        assert_eq!((patient, skin), (Patient::default(), Skin::default()));
        let field = file.memory(None);
        assert!(field.fades_like(&SharpnessField::default()));
        for eye in Laterality::BOTH {
            let (_, _, _, lens, refraction, sclera, lids, look) = file.eye_components(eye);
            assert_eq!(look, Look::default());
            assert_eq!((lens, refraction), (Lens::default(), Refraction::default()));
            assert_eq!((sclera, lids), (Sclera::default(), Lids::default()));
        }
    }

    #[test]
    fn every_patient_comes_back_as_the_file_that_made_it() {
        let mut world = World::new();
        let own = PatientFile {
            eye: Laterality::OS,
            pupil: PupilSetting::Fixed(3.25),
            sphere_d: -2.5,
            right: EyeFile {
                sphere_d: Some(1.0),
                ..EyeFile::default()
            },
            left: EyeFile {
                glaucoma: Some(Some(crate::conditions::GlaucomaStage::Severe.into())),
                cataract: Some(Some(crate::conditions::Cataract::nuclear(3.0))),
                eumelanin_ratio: Some(Some(0.5)),
                ..EyeFile::default()
            },
            ..PatientFile::default()
        };
        let files = crate::patients::PRESETS
            .iter()
            .map(|preset| Patient::preset(preset.name))
            .chain([own]);
        // One entity after another's file: nothing of the one before is left.
        let patient = world.spawn_empty().id();
        for file in files {
            world.entity_mut(patient).insert(file.clone());
            world.flush();
            assert!(world.get::<PatientFile>(patient).is_none());
            let eyes = world.get::<Eyes>(patient).expect("eyes");
            assert_eq!(eyes.entities().len(), 2);
            let found = read_back(&mut world, patient);
            // Two numbers change their unit on the way.
            let rounded = PatientFile {
                voxel_mm: file.voxel_mm,
                blur_cap_arcmin: file.blur_cap_arcmin,
                ..found.clone()
            };
            assert_eq!(rounded, file);
            assert!((found.voxel_mm - file.voxel_mm).abs() < 1e-9);
            assert!((found.blur_cap_arcmin - file.blur_cap_arcmin).abs() < 1e-9);
        }
    }
}
