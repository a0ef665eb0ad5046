//! Conditions: what an eye may have, each in one file, written as anatomy.
//!
//! Enters: a condition's component, on an eye or on a person (then both eyes have it). Leaves: the
//! components that every eye has, healthy or not: [`VisualField`], [`OcularMedia`], and [`crate::anatomy::Effective`] of its
//! own [`Refraction`], [`Iris`] and [`Lids`]. Whoever draws or sees reads those and knows no condition by
//! name.
//!
//! A new condition is a file with a type that is a [`Condition`], and a line in the list below. One of
//! another crate is added by [`AddCondition::add_condition`].

pub mod cataract;
pub mod glaucoma;
pub mod ptosis;
mod write;

pub use cataract::Cataract;
pub use glaucoma::{Glaucoma, GlaucomaStage};
pub use ptosis::Ptosis;
pub use write::AddCondition;
pub(crate) use write::put;

use crate::anatomy::{Effective, Iris, Lids, OcularMedia, Refraction, VisualField};
use bevy::ecs::component::Mutable;
use bevy::prelude::*;

/// The list: calls a macro with the name of every condition, as it stands in patient files and in
/// links, its type and its meaning, before what else the macro is given.
macro_rules! with_conditions {
    ($callback:ident! { $($rest:tt)* }) => {
        $callback! {
            conditions {
                glaucoma: $crate::conditions::Glaucoma, "loss of nerve fibres and of the visual field: `Early`, `Moderate`, `Severe`, or `MeanDeviation(dB)`, 0 to -30";
                cataract: $crate::conditions::Cataract, "clouding of the lens by its LOCS III grades: `(nuclear: 0 to 6.9, cortical: 0 to 5.9, subcapsular: 0 to 5.9)`, or by the straylight of the whole eye, as in `(log_s: 1.4)`, 0.5 to 2.5, beside which grades only say in which proportion the three places are clouded";
                ptosis: $crate::conditions::Ptosis, "an upper lid that hangs: `(mrd1_mm: -4 to 4.4)`, its margin above the corneal reflex";
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
    /// Its refractive error.
    pub refraction: Refraction,
    /// Its iris.
    pub iris: Iris,
    /// Its lids.
    pub lids: Lids,
}

#[cfg(test)]
impl Affected {
    /// What a healthy eye has.
    fn healthy(laterality: crate::anatomy::Laterality, age_years: f64) -> Self {
        let iris = tests::iris();
        Self {
            field: VisualField::normal(laterality, age_years),
            media: OcularMedia::healthy(age_years, iris.color.glare_pigment()),
            refraction: Refraction::default(),
            iris,
            lids: Lids::default(),
        }
    }
}

/// One number of a condition, for a slider and for checks.
pub struct Control<C> {
    /// Its name in a patient file.
    pub name: &'static str,
    /// Lowest and highest value.
    pub range: (f64, f64),
    /// What it is.
    pub meaning: &'static str,
    /// Its value; `None` where it is not given.
    pub get: fn(&C) -> Option<f64>,
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

    /// What should be known of it in an eye that is like `without` without it, as a clause: where a number
    /// of it does not come to what it says.
    fn remark(&self, without: &Affected) -> Option<String> {
        let _ = without;
        None
    }
}

macro_rules! plugin {
    (conditions { $($name:ident: $condition:ty, $meaning:literal;)+ }) => {
        /// Writes conditions into anatomy.
        pub struct ConditionsPlugin;

        impl Plugin for ConditionsPlugin {
            fn build(&self, app: &mut App) {
                write::build(app);
                app.register_type::<Effective<Refraction>>()
                    .register_type::<Effective<Iris>>()
                    .register_type::<Effective<Lids>>();
                $(app.register_type::<$condition>().add_condition::<$condition>();)+
            }
        }
    };
}
with_conditions! { plugin! {} }

/// A number of a caption: two decimals at most, none that say nothing, and a minus sign.
pub(crate) fn short(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    // Plus nothing: minus nothing is nothing.
    (rounded + 0.0).to_string().replace('-', "−")
}

#[cfg(test)]
mod tests;
