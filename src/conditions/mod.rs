//! Conditions: what an eye may have, each in one file, written as anatomy.
//!
//! Enters: a condition's component, on an eye or on a person (then both eyes have it). Leaves: the
//! components that every eye has, healthy or not ([`VisualField`]); whoever draws or sees reads
//! those and knows no condition by name.

pub mod glaucoma;

pub use glaucoma::{Glaucoma, GlaucomaStage};

use crate::anatomy::{Eye, EyeOf, Patient, VisualField};
use crate::frame::EyeSystems;
use bevy::prelude::*;

/// Writes conditions into anatomy.
pub struct ConditionsPlugin;

impl Plugin for ConditionsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Glaucoma>().add_systems(
            Update,
            write_visual_fields
                .in_set(EyeSystems::Sense)
                .after(crate::frame::EyeCommands),
        );
    }
}

/// What an eye has: its own condition, or its owner's.
fn of_eye<'a, C: Component>(
    eye: Entity,
    owner: Entity,
    conditions: &'a Query<Ref<C>>,
) -> Option<Ref<'a, C>> {
    conditions.get(eye).or_else(|_| conditions.get(owner)).ok()
}

/// The field of every eye whose side, owner's age or conditions have changed.
fn write_visual_fields(
    eyes: Query<(Entity, Ref<Eye>, Ref<EyeOf>, Option<&VisualField>)>,
    patients: Query<Ref<Patient>>,
    glaucoma: Query<Ref<Glaucoma>>,
    mut removed: RemovedComponents<Glaucoma>,
    mut commands: Commands,
) {
    let gone = removed.read().count() > 0;
    for (entity, eye, owner, field) in &eyes {
        let Ok(patient) = patients.get(owner.0) else {
            continue;
        };
        let own = of_eye(entity, owner.0, &glaucoma);
        let changed = field.is_none()
            || gone
            || eye.is_changed()
            || owner.is_changed()
            || patient.is_changed()
            || own.as_ref().is_some_and(|own| own.is_changed());
        if !changed {
            continue;
        }
        let mut wanted = VisualField::normal(eye.laterality, patient.age_years);
        if let Some(glaucoma) = own {
            glaucoma.write(&mut wanted);
        }
        if field != Some(&wanted) {
            commands.entity(entity).insert(wanted);
        }
    }
}
