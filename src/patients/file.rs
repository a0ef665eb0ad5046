//! A patient as written in a file: every field, with its range, default, unit and meaning, in one table.
//!
//! Enters: the table below. Leaves: [`PatientFile`] (what both eyes share, and what one of them has
//! otherwise), and [`FIELDS`], which checks, controls and the README's table are made from.

use crate::anatomy::{
    IRIS_CONE_DEG, IrisColor, Laterality, Lids, Look, PUPIL_RANGE_MM, PUPIL_SETTINGS, Patient,
    Sclera, Skin,
};
use crate::conditions::{Affected, Condition, with_conditions};
use bevy::ecs::component::Component;
use bevy::ecs::reflect::ReflectComponent;
use bevy::ecs::world::EntityWorldMut;
use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

/// How the pupil is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum PupilSetting {
    /// By light, age and the near response (Watson & Yellott 2012).
    #[default]
    Auto,
    /// The entrance pupil is held at this diameter in mm, within [`PUPIL_RANGE_MM`].
    Fixed(f64),
}

impl PupilSetting {
    /// The held diameter, if it is held.
    pub fn diameter_mm(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Fixed(diameter_mm) => Some(diameter_mm),
        }
    }
}

/// What is known of one number of a patient file.
pub struct Field {
    /// Its name in the file.
    pub name: &'static str,
    /// Which of several numbers under that name: 0, or 1 for the second of a pair.
    pub index: usize,
    /// Lowest and highest value that a patient may have.
    pub range: (f64, f64),
    /// Its unit, as written behind a number; empty where it has none.
    pub unit: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// May one eye have another value than the other?
    pub per_eye: bool,
    /// The value of a patient; `None` where it is left to be worked out.
    pub get: fn(&PatientFile) -> Option<f64>,
    /// Gives a patient this value.
    pub set: fn(&mut PatientFile, f64),
}

/// What may stand in `right` and `left`.
const EYE_ALLOWED: &str = "round brackets with what this eye has otherwise, as in (sphere_d: -2.0)";

/// What an eye has otherwise than its owner's file says: given, it is a value.
fn own<'a, D: serde::Deserializer<'a>, T: Deserialize<'a>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// What an eye has otherwise than its owner's file says, where that may also be nothing: absent is as both
/// eyes are, `None` is nothing.
mod own_or_none {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer, T: Serialize>(
        own: &Option<Option<T>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        own.as_ref().and_then(Option::as_ref).serialize(serializer)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>, T: Deserialize<'a>>(
        deserializer: D,
    ) -> Result<Option<Option<T>>, D::Error> {
        Option::deserialize(deserializer).map(Some)
    }
}

macro_rules! patient_file {
    (
        conditions { $($condition:ident : $condition_type:ty, $condition_meaning:literal;)+ }
        texts { $($(#[$text_doc:meta])* $text:ident : $text_type:ty = $text_default:expr, $text_allowed:expr;)+ }
        eye_choices { $($(#[$choice_doc:meta])* $choice:ident : $choice_type:ty = $choice_default:expr, $choice_allowed:literal;)+ }
        numbers { $($number:ident = $number_default:expr, $number_low:literal to $number_high:literal, $number_unit:literal, $number_meaning:literal;)+ }
        eye_numbers { $($eye:ident = $eye_default:expr, $eye_low:literal to $eye_high:literal, $eye_unit:literal, $eye_meaning:literal;)+ }
        eye_options { $($option:ident, $option_low:literal to $option_high:literal, $option_unit:literal, $option_meaning:literal;)+ }
        eye_pairs { $($pair:ident = $pair_default:expr, $pair_low:literal to $pair_high:literal, $pair_unit:literal, $pair_meaning:literal, $pair_second:literal;)+ }
    ) => {
        /// A patient as written in a file. Lengths in mm, powers in D, angles in degrees.
        ///
        /// As a component it makes its entity that patient, with two eyes, and is gone: see
        /// [`crate::patients`].
        #[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize, Reflect)]
        #[reflect(opaque, Component)]
        #[component(on_insert = super::components::replace_with_components)]
        #[serde(deny_unknown_fields, default)]
        pub struct PatientFile {
            $($(#[$text_doc])* pub $text: $text_type,)+
            $(#[doc = concat!($number_meaning, ": ", $number_low, " to ", $number_high, " ", $number_unit, ".")]
            pub $number: f64,)+
            $($(#[$choice_doc])* pub $choice: $choice_type,)+
            $(#[doc = $condition_meaning] pub $condition: Option<$condition_type>,)+
            $(#[doc = concat!($eye_meaning, ": ", $eye_low, " to ", $eye_high, " ", $eye_unit, ".")]
            pub $eye: f64,)+
            $(#[doc = concat!($option_meaning, ": ", $option_low, " to ", $option_high, " ", $option_unit, ".")]
            pub $option: Option<f64>,)+
            $(#[doc = concat!($pair_meaning, " and ", $pair_second, ": each ", $pair_low, " to ", $pair_high, " ", $pair_unit, ".")]
            pub $pair: [f64; 2],)+
            /// What the right eye has otherwise than the fields above say.
            pub right: EyeFile,
            /// What the left eye has otherwise than the fields above say.
            pub left: EyeFile,
        }

        /// What one eye has otherwise than its owner's file says for both.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct EyeFile {
            $($(#[$choice_doc])* #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "own")] pub $choice: Option<$choice_type>,)+
            $(#[doc = concat!($condition_meaning, ". `Some(None)`: this eye has it not.")]
            #[serde(skip_serializing_if = "Option::is_none", with = "own_or_none")] pub $condition: Option<Option<$condition_type>>,)+
            $(#[doc = $eye_meaning] #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "own")] pub $eye: Option<f64>,)+
            $(#[doc = concat!($option_meaning, ". `Some(None)`: worked out, for this eye.")]
            #[serde(skip_serializing_if = "Option::is_none", with = "own_or_none")] pub $option: Option<Option<f64>>,)+
            $(#[doc = $pair_meaning] #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "own")] pub $pair: Option<[f64; 2]>,)+
        }

        impl Default for PatientFile {
            fn default() -> Self {
                Self {
                    $($text: $text_default,)+
                    $($number: $number_default,)+
                    $($choice: $choice_default,)+
                    $($condition: None,)+
                    $($eye: $eye_default,)+
                    $($option: None,)+
                    $($pair: $pair_default,)+
                    right: EyeFile::default(),
                    left: EyeFile::default(),
                }
            }
        }

        impl PatientFile {
            /// One file of a person whose leading eye is like that of `leading` and whose other eye is
            /// like that of `other`, each read as if it were both: what is shared is the leading eye's.
            pub(super) fn join(leading: Self, other: &Self) -> Self {
                let (mut first, mut second) = (EyeFile::default(), EyeFile::default());
                let mut both = leading;
                $(if other.$choice != both.$choice { second.$choice = Some(other.$choice.clone()); })+
                $(if other.$eye != both.$eye { second.$eye = Some(other.$eye); })+
                $(if other.$pair != both.$pair { second.$pair = Some(other.$pair); })+
                // What only one eye has stands with that eye.
                $(if other.$condition != both.$condition {
                    match &other.$condition {
                        Some(_) => second.$condition = Some(other.$condition.clone()),
                        None => first.$condition = Some(both.$condition.take()),
                    }
                })+
                $(if other.$option != both.$option {
                    match other.$option {
                        Some(_) => second.$option = Some(other.$option),
                        None => first.$option = Some(both.$option.take()),
                    }
                })+
                (both.right, both.left) = match both.eye {
                    Laterality::OD => (first, second),
                    Laterality::OS => (second, first),
                };
                both
            }
        }

        impl PatientFile {
            /// The same person after a change to one of her eyes, or to both: `change` is given a file that
            /// both eyes are like.
            pub fn with_change(&self, of: Option<Laterality>, change: impl Fn(&mut Self)) -> Self {
                let [mut leading, mut other] = [self.eye, self.eye.other()].map(|eye| {
                    let mut own = self.of_eye(eye);
                    if of.is_none_or(|of| of == eye) {
                        change(&mut own);
                    }
                    own
                });
                // What both share follows whichever was changed.
                if of == Some(self.eye.other()) {
                    $(leading.$text = other.$text.clone();)+
                    $(leading.$number = other.$number;)+
                } else {
                    $(other.$text = leading.$text.clone();)+
                }
                Self::join(leading, &other)
            }

            /// The same person with both eyes like this one.
            pub fn of_eye(&self, eye: Laterality) -> Self {
                let own = match eye {
                    Laterality::OD => &self.right,
                    Laterality::OS => &self.left,
                };
                let mut both = self.clone();
                $(if let Some(value) = &own.$choice { both.$choice = value.clone(); })+
                $(if let Some(own) = &own.$condition { both.$condition = own.clone(); })+
                $(if let Some(value) = own.$eye { both.$eye = value; })+
                $(if let Some(own) = own.$option { both.$option = own; })+
                $(if let Some(value) = own.$pair { both.$pair = value; })+
                both.right = EyeFile::default();
                both.left = EyeFile::default();
                both
            }
        }

        /// The conditions that a file may give, with what they are.
        pub const CONDITIONS: &[(&str, &str)] = &[$((stringify!($condition), $condition_meaning),)+];

        impl PatientFile {
            /// The numbers of its conditions that are out of range: (condition, number, value, range).
            pub(super) fn wrong_condition_number(&self) -> Option<(&'static str, &'static str, f64, (f64, f64))> {
                $(if let Some(condition) = &self.$condition {
                    for control in <$condition_type as Condition>::controls() {
                        let (low, high) = control.range;
                        // A NaN is in no range.
                        if let Some(value) = (control.get)(condition) && !(low..=high).contains(&value) {
                            return Some((stringify!($condition), control.name, value, control.range));
                        }
                    }
                })+
                None
            }

            /// A condition as the file gives it; empty where it does not.
            pub(super) fn condition_notation(&self, name: &str) -> String {
                match name {
                    $(stringify!($condition) => self.$condition.as_ref().map_or_else(
                        String::new,
                        |condition| ron::to_string(condition).unwrap_or_default(),
                    ),)+
                    _ => String::new(),
                }
            }

            /// What should be known of its conditions in an eye that is `healthy` without them, as clauses.
            pub(super) fn condition_remarks(&self, mut healthy: Affected) -> Vec<String> {
                let mut remarks = Vec::new();
                $(if let Some(condition) = &self.$condition {
                    let remark = condition.remark(&healthy);
                    remarks.extend(remark.map(|remark| format!("{}: {remark}", stringify!($condition))));
                    condition.write(&mut healthy);
                })+
                remarks
            }

            /// What its conditions make of an eye that is without them.
            pub(super) fn write_conditions(&self, affected: &mut Affected) {
                $(if let Some(condition) = &self.$condition {
                    condition.write(affected);
                })+
            }

            /// What its conditions are like, by name.
            pub fn condition_captions(&self) -> Vec<(&'static str, String)> {
                let mut captions = Vec::new();
                $(if let Some(condition) = &self.$condition {
                    captions.push((stringify!($condition), condition.caption()));
                })+
                captions
            }

            /// Gives an eye the conditions of a file whose eyes are alike, and takes the others from it.
            pub(super) fn put_conditions(&self, eye: &mut EntityWorldMut) {
                $(match &self.$condition {
                    Some(condition) if eye.get::<$condition_type>() != Some(condition) => {
                        eye.insert(condition.clone());
                    }
                    Some(_) => {}
                    None => {
                        eye.remove::<$condition_type>();
                    }
                })+
            }

            /// Takes every condition from a person whose eyes have what the file says.
            pub(super) fn remove_conditions(person: &mut EntityWorldMut) {
                person.remove::<($($condition_type,)+)>();
            }

            /// Takes the conditions of an eye, or a person, into a file; what it has not is left as it is.
            pub(super) fn take_conditions(&mut self, parts: ConditionParts) {
                let ($($condition,)+) = parts;
                $(if let Some(condition) = $condition { self.$condition = Some(condition.clone()); })+
            }
        }

        /// The conditions of an eye.
        pub(super) type ConditionParts<'a> = ($(Option<&'a $condition_type>,)+);

        /// The ranges of a condition's numbers: (number, range).
        pub(super) fn condition_ranges(condition: &str) -> Vec<(&'static str, (f64, f64))> {
            match condition {
                $(stringify!($condition) => <$condition_type as Condition>::controls()
                    .iter()
                    .map(|control| (control.name, control.range))
                    .collect(),)+
                _ => Vec::new(),
            }
        }

        /// The fields that are no numbers, with what may stand there.
        pub(super) const WORDS: &[(&str, &str)] = &[
            $((stringify!($text), $text_allowed),)+
            $((stringify!($choice), $choice_allowed),)+
            ("right", EYE_ALLOWED),
            ("left", EYE_ALLOWED),
        ];

        /// Every number of a patient file.
        pub const FIELDS: &[Field] = &[
            $(Field {
                name: stringify!($number), index: 0, range: ($number_low as f64, $number_high as f64),
                unit: $number_unit, meaning: $number_meaning, per_eye: false,
                get: |file| Some(file.$number), set: |file, value| file.$number = value,
            },)+
            $(Field {
                name: stringify!($eye), index: 0, range: ($eye_low as f64, $eye_high as f64),
                unit: $eye_unit, meaning: $eye_meaning, per_eye: true,
                get: |file| Some(file.$eye), set: |file, value| file.$eye = value,
            },)+
            $(Field {
                name: stringify!($option), index: 0, range: ($option_low as f64, $option_high as f64),
                unit: $option_unit, meaning: $option_meaning, per_eye: true,
                get: |file| file.$option, set: |file, value| file.$option = Some(value),
            },)+
            $(Field {
                name: stringify!($pair), index: 0, range: ($pair_low as f64, $pair_high as f64),
                unit: $pair_unit, meaning: $pair_meaning, per_eye: true,
                get: |file| Some(file.$pair[0]), set: |file, value| file.$pair[0] = value,
            },
            Field {
                name: stringify!($pair), index: 1, range: ($pair_low as f64, $pair_high as f64),
                unit: $pair_unit, meaning: $pair_second, per_eye: true,
                get: |file| Some(file.$pair[1]), set: |file, value| file.$pair[1] = value,
            },)+
            Field {
                name: "pupil", index: 0, range: PUPIL_RANGE_MM,
                unit: "mm", meaning: "diameter at which the entrance pupil is held", per_eye: false,
                get: |file| file.pupil.diameter_mm(), set: |file, value| file.pupil = PupilSetting::Fixed(value),
            },
        ];
    };
}

with_conditions! { patient_file! {
    texts {
        /// Name shown to the user.
        name: String = "Unnamed".into(), "text in quotation marks";
        /// One sentence about this patient.
        description: String = String::new(), "text in quotation marks";
        /// The eye that leads, and is shown where one is shown.
        eye: Laterality = Laterality::OD, "OD or OS";
        /// Seed of the irises' fibres and the scleras' vessels.
        seed: u64 = 1, "a whole number, 0 to 18446744073709551615";
        /// Pupils: `Auto` or `Fixed(mm)`.
        pupil: PupilSetting = PupilSetting::Auto, PUPIL_SETTINGS;
    }
    eye_choices {
        /// Colour class of the iris; the three fractions override it.
        iris_color: IrisColor = IrisColor::Brown, "Blue, Green or Brown";
    }
    numbers {
        age_years = Patient::DEFAULT_AGE_YEARS, 1 to 110, "years", "age";
        interpupillary_mm = Patient::DEFAULT_INTERPUPILLARY_MM, 40 to 80, "mm", "distance between the eyes";
        skin_tone = Skin::DEFAULT.tone, 0 to 1, "", "tone of the skin, very light to very dark";
        starve_rate_per_s = 0.45, 0 to 10, "/s", "how fast remembered sharpness fades";
        voxel_mm = 10.0, 1 to 1000, "mm", "edge of a voxel of that memory";
        blur_cap_arcmin = 120.0, 10 to 600, "′", "largest blur that is shown";
    }
    eye_numbers {
        sphere_d = 0.0, -20 to 20, "D", "sphere of the refractive error";
        cylinder_d = 0.0, -10 to 10, "D", "its cylinder";
        axis_deg = 0.0, 0 to 180, "°", "axis of the cylinder";
        cornea_radius_mm = 7.8, 6 to 10, "mm", "apical radius of the front of the cornea";
        cornea_p = 0.75, 0.2 to 1.5, "", "its shape factor 1 + Q";
        cornea_posterior_radius_mm = 6.4, 5 to 9, "mm", "apical radius of the back of the cornea";
        cornea_posterior_p = 0.725, 0.2 to 1.5, "", "its shape factor";
        cornea_thickness_mm = 0.55, 0.3 to 0.9, "mm", "central thickness of the cornea";
        cornea_index = 1.376, 1 to 1.6, "", "refractive index of the cornea";
        aqueous_index = 1.336, 1 to 1.6, "", "refractive index of the aqueous";
        limbus_radius_mm = 5.85, 5 to 6.5, "mm", "radius of the limbus";
        iris_depth_mm = 3.6, 2.5 to 4.5, "mm", "pupil's edge behind the corneal apex";
        iris_cone_deg = IRIS_CONE_DEG, -5 to 20, "°", "cone in which the iris falls back from the pupil to its root";
        iris_freckles = 5.0, 0 to 80, "", "freckles on the iris";
        iris_sector_deg = 0.0, 0 to 360, "°", "width of a brown sector of the iris; 0 is none";
        iris_sector_at_deg = 270.0, 0 to 360, "°", "middle of that sector, counted as axes are";
        scleral_radius_mm = 11.5, 10.5 to 12.5, "mm", "radius of the scleral sphere";
        lipid_thickness_nm = 55.0, 0 to 200, "nm", "oily layer of the tear film";
        tear_breakup_s = 20.0, 1 to 60, "s", "how long after a blink the tear film begins to break; below 10 is dry";
        redness = Sclera::DEFAULT.redness, 0 to 1, "", "redness of the conjunctiva";
        bilirubin_mg_dl = Sclera::DEFAULT.bilirubin_mg_dl, 0 to 50, "mg/dL", "bilirubin in the serum; from 2.5 the white is yellow";
        pinguecula = Sclera::DEFAULT.pinguecula, 0 to 1, "", "yellow, raised tissue beside the limbus";
        lid_opening = Lids::DEFAULT.opening, 0 to 1.2, "", "how far the lids open; 1 is usual";
        look_iris_brightness = Look::DEFAULT.iris_brightness, 0 to 4, "", "artist's: brightness of the iris, against its own";
        look_iris_size = Look::DEFAULT.iris_size, 0.8 to 1.25, "", "artist's: size of iris and pupil as a pattern, against their own";
        look_iris_relief = Look::DEFAULT.iris_relief, 0 to 3, "", "artist's: relief of the iris, against its own";
        look_refraction = Look::DEFAULT.refraction, 0 to 1, "", "artist's: how much of the view's refraction there is";
        look_caustic_scale = Look::DEFAULT.caustic_scale, 0 to 4, "", "artist's: how much the cornea concentrates light on the iris, against what is computed";
        look_caustic_power = Look::DEFAULT.caustic_power, 0.25 to 4, "", "artist's: power of that concentration";
        look_cornea_roughness = Look::DEFAULT.cornea_roughness, 0 to 1, "", "artist's: roughness of the cornea's reflection";
        look_cornea_specularity = Look::DEFAULT.cornea_specularity, 0 to 4, "", "artist's: strength of the cornea's reflection, against its own";
        look_limbus_dark = Look::DEFAULT.limbus_dark, 0 to 4, "", "artist's: how dark the limbal ring is, against its own";
        look_limbus_power = Look::DEFAULT.limbus_power, 0.25 to 4, "", "artist's: power of that ring's profile";
        look_limbus_color_mm = Look::DEFAULT.limbus_color_mm, 0.1 to 1.35, "mm", "artist's: width over which iris goes over into white";
        look_limbus_shading_mm = Look::DEFAULT.limbus_shading_mm, 0.05 to 1.35, "mm", "artist's: width over which the cornea's shape goes over into the white's";
        look_white_brightness = Look::DEFAULT.white_brightness, 0 to 4, "", "artist's: brightness of the white, against its own";
        look_white_roughness = Look::DEFAULT.white_roughness, 0.02 to 1, "", "artist's: roughness of the wet white";
        look_white_specularity = Look::DEFAULT.white_specularity, 0 to 4, "", "artist's: strength of its reflections, against their own";
        look_white_relief = Look::DEFAULT.white_relief, 0 to 4, "", "artist's: relief of the wet white, against its own";
        look_white_relief_size = Look::DEFAULT.white_relief_size, 0.25 to 4, "", "artist's: size of that relief, against its own";
        look_flush_radius = Look::DEFAULT.flush_radius, 0.5 to 1.5, "", "artist's: how far from the cornea the white turns pink, against its own";
        look_flush_hardness = Look::DEFAULT.flush_hardness, 0.25 to 4, "", "artist's: how sharply it does, against its own";
        look_parallax = Look::DEFAULT.parallax, 0 to 1, "", "artist's: share of the iris, from the examiner's left, that lies where parallax mapping puts it; 0.5 shows both beside each other";
        look_matcap = Look::DEFAULT.matcap, 0 to 1, "", "artist's: strength of a reflection that follows the camera";
    }
    eye_options {
        stroma_melanin_fraction, 0 to 0.5, "", "melanin in the stroma's volume; by class without it";
        border_layer_melanin_fraction, 0 to 0.5, "", "melanin in the anterior border layer; by class without it";
        collarette_melanin_fraction, 0 to 0.5, "", "melanin of the border layer about the collarette, where that is more than elsewhere; by the person without it";
        eumelanin_ratio, 0 to 1, "", "eumelanin in all melanin; by class without it";
        iris_bowing_mm, -0.4 to 0.4, "mm", "how far the iris' middle stands before that cone, negative behind it; by age without it";
        arcus, 0 to 1, "", "lipid in the rim of the cornea; by age without it";
        accommodation_amplitude_d, 0 to 20, "D", "most that the lens can add; by age without it";
    }
    eye_pairs {
        pupil_decentration_mm = [0.2, 0.0], -1 to 1, "mm", "centre of the pupil towards the nose", "the same upwards";
        angle_alpha_deg = [5.45, 2.5], -15 to 15, "°", "optical axis outwards of the line of sight", "the same downwards";
    }
} }
