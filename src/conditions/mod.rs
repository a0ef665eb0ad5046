//! Conditions: what an eye may have, each in one file, written as anatomy.
//!
//! Enters: a condition's component, on an eye or on a person (then both eyes have it). Leaves: the
//! components that every eye has, healthy or not ([`VisualField`], [`OcularMedia`]); whoever draws or
//! sees reads those and knows no condition by name.
//!
//! A new condition is a file with a type that is a [`Condition`], and a line in the list below.

pub mod cataract;
pub mod glaucoma;

pub use cataract::Cataract;
pub use glaucoma::{Glaucoma, GlaucomaStage};

use crate::anatomy::{Eye, EyeOf, Iris, OcularMedia, Patient, VisualField};
use crate::frame::EyeSystems;
use bevy::ecs::component::Mutable;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// The list: calls a macro with the name of every condition, as it stands in patient files and in
/// links, its type and its meaning, before what else the macro is given.
macro_rules! with_conditions {
    ($callback:ident! { $($rest:tt)* }) => {
        $callback! {
            conditions {
                glaucoma: $crate::conditions::Glaucoma, "loss of nerve fibres and of the visual field: `Early`, `Moderate`, `Severe`, or `MeanDeviation(dB)`, 0 to -30";
                cataract: $crate::conditions::Cataract, "clouding of the lens by its LOCS III grades: `(nuclear: 0 to 6.9, cortical: 0 to 5.9, subcapsular: 0 to 5.9)`";
            }
            $($rest)*
        }
    };
}
pub(crate) use with_conditions;

/// What of an eye's anatomy conditions may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Affected {
    /// What it sees where.
    pub field: VisualField,
    /// What the light passes.
    pub media: OcularMedia,
}

/// One number of a condition, for a slider and for checks.
pub struct Control<C> {
    /// Its name in a patient file.
    pub name: &'static str,
    /// Lowest and highest value.
    pub range: (f64, f64),
    /// What it is.
    pub meaning: &'static str,
    /// Its value.
    pub get: fn(&C) -> f64,
    /// Gives it another.
    pub set: fn(&mut C, f64),
}

/// A condition of an eye.
pub trait Condition: Component<Mutability = Mutable> + Clone + PartialEq {
    /// Its title.
    const TITLE: &'static str;

    /// As it begins, for a user who turns it on.
    fn onset() -> Self;

    /// Its numbers.
    fn controls() -> &'static [Control<Self>];

    /// What it does to an eye.
    fn write(&self, affected: &mut Affected);

    /// What it is like, in a sentence.
    fn caption(&self) -> String;
}

/// Everybody's condition of one kind, and whose is gone.
#[derive(SystemParam)]
pub struct Having<'w, 's, C: Condition> {
    all: Query<'w, 's, Ref<'static, C>>,
    gone: RemovedComponents<'w, 's, C>,
}

impl<C: Condition> Having<'_, '_, C> {
    /// An eye's own condition, or its owner's.
    fn of(&self, eye: Entity, owner: Entity) -> Option<Ref<'_, C>> {
        self.all.get(eye).or_else(|_| self.all.get(owner)).ok()
    }

    /// Has anybody lost it since the last frame?
    fn is_gone(&mut self) -> bool {
        self.gone.read().count() > 0
    }

    fn is_changed(&self, eye: Entity, owner: Entity) -> bool {
        self.of(eye, owner).is_some_and(|own| own.is_changed())
    }

    fn write(&self, eye: Entity, owner: Entity, affected: &mut Affected) {
        if let Some(condition) = self.of(eye, owner) {
            condition.write(affected);
        }
    }
}

/// What of an eye decides its anatomy, and what was written before.
type Written<'a> = (
    Entity,
    Ref<'a, Eye>,
    Ref<'a, EyeOf>,
    Ref<'a, Iris>,
    Option<&'a VisualField>,
    Option<&'a OcularMedia>,
);

macro_rules! plugin {
    (conditions { $($name:ident: $condition:ty, $meaning:literal;)+ }) => {
        /// Writes conditions into anatomy.
        pub struct ConditionsPlugin;

        impl Plugin for ConditionsPlugin {
            fn build(&self, app: &mut App) {
                $(app.register_type::<$condition>();)+
                app.add_systems(
                    Update,
                    write_anatomy
                        .in_set(EyeSystems::Sense)
                        .after(crate::frame::EyeCommands),
                );
            }
        }

        /// What every eye has whose side, owner or conditions have changed.
        fn write_anatomy(
            eyes: Query<Written>,
            patients: Query<Ref<Patient>>,
            mut commands: Commands,
            ($(mut $name,)+): ($(Having<$condition>,)+)
        ) {
            // All of them are asked, so that none tells of the same loss again.
            let gone = [$($name.is_gone()),+].contains(&true);
            for (entity, eye, owner, iris, field, media) in &eyes {
                let Ok(patient) = patients.get(owner.0) else {
                    continue;
                };
                let is_changed = field.is_none()
                    || media.is_none()
                    || gone
                    || eye.is_changed()
                    || owner.is_changed()
                    || iris.is_changed()
                    || patient.is_changed()
                    $(|| $name.is_changed(entity, owner.0))+;
                if !is_changed {
                    continue;
                }
                let mut affected = Affected {
                    field: VisualField::normal(eye.laterality, patient.age_years),
                    media: OcularMedia::healthy(patient.age_years, iris.color.glare_pigment()),
                };
                $($name.write(entity, owner.0, &mut affected);)+
                let mut eye = commands.entity(entity);
                if field != Some(&affected.field) {
                    eye.insert(affected.field);
                }
                if media != Some(&affected.media) {
                    eye.insert(affected.media);
                }
            }
        }
    };
}
with_conditions! { plugin! {} }
