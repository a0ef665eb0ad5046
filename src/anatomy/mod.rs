//! The patient: one anatomical state that both viewers read.
//!
//! Enters: nothing; patient files and presets come in by [`crate::patients`]. Leaves: the components
//! of a person ([`Patient`]) and of each of her eyes ([`Eye`], [`EyeOf`]), what an eye's media and
//! retina let it see ([`VisualField`]), and the geometry of gaze. No value is stored twice: what
//! is drawn and what is seen are both read from these components.
//!
//! Shapes and defaults follow François et al. 2007 (cornea, equation 1), Atchison 2006 and the
//! reference tables named in each field's documentation.

mod components;
pub mod gaze;
mod look;
mod media;
pub mod visual_field;

pub use components::{
    Accommodation, Adaptation, Cornea, Effective, Eye, EyeOf, Eyelids, Eyes, Gaze, IRIS_CONE_DEG,
    Iris, IrisColor, Laterality, Lens, Lids, PUPIL_RANGE, PUPIL_RANGE_MM, PUPIL_RANGE_WITH_UNIT,
    PUPIL_SETTINGS, Patient, Pupil, PupilControl, Refraction, Sclera, Skin, USUAL_PUPIL_MM,
};
pub use look::Look;
pub use media::{
    CAPSULE_BEAM, CAPSULE_DEPTH_MM, CORTEX_DEPTH_MM, LENS_DISC_MM, MEASURED_PUPIL_MM,
    NUCLEUS_DEPTH_MM, NUCLEUS_RADIUS_MM, OcularMedia,
};
pub use visual_field::VisualField;

use bevy::ecs::system::SystemParam;
use bevy::prelude::{Entity, Query};

/// Finds eyes: by an eye's entity, or by a person's, which means her leading eye.
#[derive(SystemParam)]
pub struct EyeFinder<'w, 's> {
    patients: Query<'w, 's, (&'static Patient, Option<&'static Eyes>)>,
    eyes: Query<'w, 's, &'static Eye>,
    owners: Query<'w, 's, &'static EyeOf>,
}

impl EyeFinder<'_, '_> {
    /// The entities of eye and person; `None` where there is no such eye (yet).
    pub fn find(&self, eye_or_patient: Entity) -> Option<(Entity, Entity)> {
        if self.eyes.contains(eye_or_patient) {
            let owner = self.owners.get(eye_or_patient).ok()?;
            return Some((eye_or_patient, owner.0));
        }
        let (patient, _) = self.patients.get(eye_or_patient).ok()?;
        let eye = self.eye_of(eye_or_patient, patient.leading)?;
        Some((eye, eye_or_patient))
    }

    /// Which of the two an eye is.
    pub fn laterality(&self, eye: Entity) -> Option<Laterality> {
        self.eyes.get(eye).ok().map(|eye| eye.laterality)
    }

    /// One eye of a person; the other where she has but one.
    pub fn eye_of(&self, patient: Entity, wanted: Laterality) -> Option<Entity> {
        let (_, eyes) = self.patients.get(patient).ok()?;
        let eyes = eyes?.entities();
        let is_wanted = |entity: &&Entity| {
            self.eyes
                .get(**entity)
                .is_ok_and(|eye| eye.laterality == wanted)
        };
        eyes.iter()
            .find(is_wanted)
            .or_else(|| eyes.first())
            .copied()
    }
}
