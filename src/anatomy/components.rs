//! The components that are the patient.
//!
//! A person ([`Patient`]) has two eyes, entities of their own that are related to the person by
//! [`EyeOf`]. What a patient file sets (anatomy) and what moves from frame to frame (state) are
//! different components, so that Bevy's `Changed<T>` says what changed:
//!
//! | | anatomy | state |
//! |---|---|---|
//! | person | [`Patient`], [`Skin`], [`PupilControl`], [`Adaptation`] | [`Eyelids`] |
//! | eye | [`Eye`], [`Cornea`], [`Iris`], [`Lens`], [`Refraction`], [`Sclera`], [`Lids`], [`super::Look`] | [`Gaze`], [`Pupil`], [`Accommodation`] |

use super::gaze::GazeAngles;
use crate::optics::defocus::PowerVector;
use crate::optics::pupil::entrance_pupil_magnification;
use crate::optics::smoothstep::smoothstep;
use crate::tissue::iris_reflectance::IrisPigment;
use bevy::ecs::reflect::ReflectComponent;
use bevy::math::{DVec3, Quat};
use bevy::prelude::{Component, Entity};
use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

/// Which of the two eyes: OD (oculus dexter, right) or OS (oculus sinister, left).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
pub enum Laterality {
    /// The right eye; its temporal side is the patient's right.
    #[default]
    OD,
    /// The left eye; its temporal side is the patient's left.
    OS,
}

impl Laterality {
    /// Both, right first.
    pub const BOTH: [Self; 2] = [Self::OD, Self::OS];

    /// +1 for the right eye, −1 for the left: the sign of its temporal side along x.
    pub fn temporal_sign(self) -> f64 {
        match self {
            Self::OD => 1.0,
            Self::OS => -1.0,
        }
    }

    /// The other eye.
    pub fn other(self) -> Self {
        match self {
            Self::OD => Self::OS,
            Self::OS => Self::OD,
        }
    }
}

/// A person; her eyes are the entities of [`Eyes`].
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
#[require(Skin, Eyelids, PupilControl, Adaptation)]
pub struct Patient {
    /// Name shown to the user.
    pub name: String,
    /// One sentence about this person.
    pub description: String,
    /// Age, 1 to 110 years.
    pub age_years: f64,
    /// The eye that leads: it is shown where one is shown, and the other follows its gaze.
    pub leading: Laterality,
    /// Distance between the centres of rotation of the eyes, mm.
    pub interpupillary_mm: f64,
    /// Seed of what nobody measures: the fibres of the irises, the vessels, the pores.
    pub seed: u64,
}

impl Default for Patient {
    fn default() -> Self {
        Self {
            name: "Unnamed".into(),
            description: String::new(),
            age_years: Self::DEFAULT_AGE_YEARS,
            leading: Laterality::OD,
            interpupillary_mm: Self::DEFAULT_INTERPUPILLARY_MM,
            seed: 1,
        }
    }
}

impl Patient {
    /// The age of somebody of whom nothing else is known, years.
    pub const DEFAULT_AGE_YEARS: f64 = 30.0;
    /// The distance between the eyes of somebody of whom nothing else is known, mm.
    pub const DEFAULT_INTERPUPILLARY_MM: f64 = 63.0;

    /// Seed of the iris of one of her eyes. The irises of one person are no copies of each other.
    pub fn iris_seed(&self, eye: Laterality) -> u64 {
        match eye {
            Laterality::OD => self.seed,
            Laterality::OS => self.seed ^ 0x1ef7_1ef7,
        }
    }

    /// Seed of the vessels on one of her eyes.
    pub fn vessel_seed(&self, eye: Laterality) -> u64 {
        self.iris_seed(eye) ^ 0x5c1e_4a00
    }
}

/// The person whose eye this entity is.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
#[relationship(relationship_target = Eyes)]
pub struct EyeOf(pub Entity);

/// The eyes of a person.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component)]
#[relationship_target(relationship = EyeOf, linked_spawn)]
pub struct Eyes(Vec<Entity>);

impl Eyes {
    /// The entities of the eyes, in the order in which they were made.
    pub fn entities(&self) -> &[Entity] {
        &self.0
    }
}

/// An eye's globe.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
#[require(
    Lens,
    Refraction,
    Sclera,
    Lids,
    super::Look,
    Gaze,
    Pupil,
    Accommodation
)]
pub struct Eye {
    /// Right or left eye.
    pub laterality: Laterality,
    /// Radius of the scleral sphere, mm.
    pub scleral_radius_mm: f64,
    /// Angle alpha: how far the optical axis points outwards (temporally) and down of the line of
    /// sight, degrees.
    pub angle_alpha_deg: [f64; 2],
}

/// The cornea as two conicoids p z² − 2 R z + x² + y² = 0 (François 2007, equation 1).
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Cornea {
    /// Apical radius of the anterior surface, mm.
    pub anterior_radius_mm: f64,
    /// Shape factor p = 1 + Q of the anterior surface.
    pub anterior_p: f64,
    /// Apical radius of the posterior surface, mm.
    pub posterior_radius_mm: f64,
    /// Shape factor of the posterior surface.
    pub posterior_p: f64,
    /// Central thickness, mm.
    pub thickness_mm: f64,
    /// Index of the stroma at 555 nm.
    pub index: f64,
    /// Index of the aqueous at 555 nm.
    pub aqueous_index: f64,
    /// Radius of the limbus, mm.
    pub limbus_radius_mm: f64,
    /// Thickness of the tear film's lipid layer, nm.
    pub lipid_thickness_nm: f64,
    /// How long after a blink the tear film begins to break, s.
    pub tear_breakup_s: f64,
    /// Lipid in the periphery of the stroma, 0 (none) to 1 (a dense arcus senilis); `None`: by age.
    pub arcus: Option<f64>,
}

/// Years at which an arcus begins to show, and at which it would be complete.
const ARCUS_YEARS: [f64; 2] = [45.0, 110.0];

impl Cornea {
    /// The arcus that it has at this age (years), 0 to 1.
    pub fn arcus_at(&self, age_years: f64) -> f64 {
        let [begins, complete] = ARCUS_YEARS;
        self.arcus
            .unwrap_or_else(|| smoothstep(begins, complete, age_years))
            .clamp(0.0, 1.0)
    }

    /// Diameter of the entrance pupil in that of the stop, for an iris this far (mm) behind the apex.
    pub fn pupil_magnification(&self, iris_depth_mm: f64) -> f64 {
        entrance_pupil_magnification(
            self.anterior_radius_mm,
            self.posterior_radius_mm,
            self.thickness_mm,
            self.index,
            self.aqueous_index,
            iris_depth_mm,
        )
    }
}

/// Colour class of the iris: how much melanin, and of which kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
pub enum IrisColor {
    /// Almost no melanin in stroma and border layer: the colour is scattering alone.
    Blue,
    /// A little, mostly pheomelanin, in the border layer.
    Green,
    /// Dense eumelanin in both.
    #[default]
    Brown,
}

impl IrisColor {
    /// Pigmentation factor of the glare function of CIE 135/1-1999.
    pub fn glare_pigment(self) -> f64 {
        match self {
            Self::Brown => 0.5,
            Self::Green => 1.0,
            Self::Blue => 1.2,
        }
    }

    /// Pigment of this class.
    pub fn pigment(self) -> IrisPigment {
        match self {
            Self::Blue => IrisPigment::BLUE,
            Self::Green => IrisPigment::GREEN,
            Self::Brown => IrisPigment::BROWN,
        }
    }
}

/// The iris: where it lies, where the hole in it is, and what it is made of.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Iris {
    /// Colour class, where nothing more exact is known.
    pub color: IrisColor,
    /// Volume fraction of melanin in the stroma (C_m of equation 13), 0 to 0.5; `None`: by class.
    pub stroma_melanin_fraction: Option<f64>,
    /// Volume fraction of melanin in the anterior border layer, 0 to 0.5; `None`: by class.
    pub border_layer_melanin_fraction: Option<f64>,
    /// Volume fraction of melanin in the border layer about the collarette, 0 to 0.5, where that is more than elsewhere; `None`: by the person.
    pub collarette_melanin_fraction: Option<f64>,
    /// Ratio of eumelanin to all melanin (β_m of equation 13), 0 to 1; `None`: by class.
    pub eumelanin_ratio: Option<f64>,
    /// Depth of the pupil's edge behind the corneal apex, mm.
    pub depth_mm: f64,
    /// Angle of the cone in which it falls back from there to its root, degrees.
    pub cone_deg: f64,
    /// How far its middle stands before that cone, mm; negative behind it; `None`: by age.
    pub bowing_mm: Option<f64>,
    /// Radius of the iris root, mm.
    pub root_radius_mm: f64,
    /// Freckles on it, 0 to 80: clusters of melanocytes on the border layer, denser than its own.
    pub freckles: f64,
    /// Width of a sector of another colour, brown, degrees, 0 (none) to 360: sectoral heterochromia.
    pub sector_deg: f64,
    /// Where its middle stands, degrees, as axes are: from the examiner's right, counter-clockwise.
    pub sector_at_deg: f64,
    /// Decentration of the pupil from the corneal axis, mm: nasal positive, superior positive.
    pub pupil_decentration_mm: [f64; 2],
}

/// Cone of a healthy iris, degrees (8.3 ± 3.3 in 3,708 eyes, REFERENCE-face).
pub const IRIS_CONE_DEG: f64 = 8.3;
/// Years up to which an iris is flat in the mean, and by how much it bulges a year from then on, mm: half of all by 0.12 mm and more over
/// 71 years, none under 31 (REFERENCE-face).
const BOWING_YEARS: f64 = 31.0;
const BOWING_MM_A_YEAR: f64 = 0.003;

impl Iris {
    /// How far its middle stands before its cone at this age (years), mm.
    pub fn bowing_at(&self, age_years: f64) -> f64 {
        let grown = BOWING_MM_A_YEAR * (age_years - BOWING_YEARS).max(0.0);
        self.bowing_mm.unwrap_or(grown)
    }

    /// What the iris is made of: the class, and what is known better.
    pub fn pigment(&self) -> IrisPigment {
        let class = self.color.pigment();
        IrisPigment {
            stroma_melanin_fraction: self
                .stroma_melanin_fraction
                .unwrap_or(class.stroma_melanin_fraction),
            border_layer_melanin_fraction: self
                .border_layer_melanin_fraction
                .unwrap_or(class.border_layer_melanin_fraction),
            eumelanin_ratio: self.eumelanin_ratio.unwrap_or(class.eumelanin_ratio),
            ..class
        }
    }
}

/// The crystalline lens.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Lens {
    /// Largest accommodation, D, 0 to 20; `None`: by age (Hofstetter's mean).
    pub amplitude_d: Option<f64>,
}

/// The refractive error as spectacles correct it, in the plane of the cornea.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Refraction {
    /// Sphere, D; negative is short-sighted.
    pub sphere_d: f64,
    /// Cylinder, D.
    pub cylinder_d: f64,
    /// Axis of the cylinder, degrees, 0 to 180.
    pub axis_deg: f64,
}

impl Refraction {
    /// Sphere plus half the cylinder, D.
    pub fn spherical_equivalent_d(&self) -> f64 {
        self.sphere_d + 0.5 * self.cylinder_d
    }

    /// The same as a power vector; its axis is the prescription's.
    pub fn power_vector(&self) -> PowerVector {
        PowerVector::from_sphere_cylinder(
            self.sphere_d,
            self.cylinder_d,
            self.axis_deg.to_radians(),
        )
    }
}

/// The sclera and what covers it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Sclera {
    /// Redness of the conjunctiva, 0 (quiet) to 1 (injected).
    pub redness: f64,
    /// Bilirubin in the serum, mg/dL, 0 to 50: jaundice yellows the white from about 2.5.
    pub bilirubin_mg_dl: f64,
    /// Elastotic tissue beside the limbus, 0 (none) to 1 (a raised, yellow pinguecula).
    pub pinguecula: f64,
}

impl Sclera {
    /// A healthy one, slightly flushed.
    pub const DEFAULT: Self = Self {
        redness: 0.12,
        bilirubin_mg_dl: 0.6,
        pinguecula: 0.0,
    };
}

impl Default for Sclera {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The lids of an eye.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Lids {
    /// How far they open at rest, 0 (never) to 1.2; 1 is usual: 9.7 mm straight ahead.
    pub opening: f64,
    /// How far the upper lid alone hangs from there, 0 (not) to 1 (as if closed).
    pub droop: f64,
}

impl Lids {
    /// Open as is usual, none hanging.
    pub const DEFAULT: Self = Self {
        opening: 1.0,
        droop: 0.0,
    };
}

impl Default for Lids {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What an eye has with its conditions, of something that it has of its own: [`Refraction`], [`Iris`],
/// [`Lids`]. Whoever draws or sees reads this; a patient file, a slider or an app writes the component
/// itself, in whatever way, and never this.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Effective<C: Component>(pub C);

/// A person's skin.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Skin {
    /// Tone, 0 (very light) to 1 (very dark).
    pub tone: f64,
}

impl Skin {
    /// Light skin.
    pub const DEFAULT: Self = Self { tone: 0.3 };
}

impl Default for Skin {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The range of entrance pupils, as numbers and in words.
macro_rules! pupil_range {
    ($smallest:literal to $largest:literal) => {
        /// The diameters that an entrance pupil can take, mm.
        pub const PUPIL_RANGE_MM: (f64, f64) = ($smallest as f64, $largest as f64);
        /// The same in words.
        pub const PUPIL_RANGE: &str = concat!($smallest, " to ", $largest);
        /// The same in words with its unit.
        pub const PUPIL_RANGE_WITH_UNIT: &str = concat!($smallest, " to ", $largest, " mm");
        /// What a patient file may say of the pupil.
        pub const PUPIL_SETTINGS: &str =
            concat!("Auto or Fixed(mm), ", $smallest, " to ", $largest);
    };
}
pupil_range!(1 to 9);

/// The pupil of somebody of whom nothing else is known, mm: a choice in the middle of what rooms make of it.
pub const USUAL_PUPIL_MM: f64 = 4.0;

/// What sets a person's pupils: light, age and focus, unless they are held. Both numbers are
/// diameters of the entrance pupil, as it is seen and measured from in front.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct PupilControl {
    /// Diameter at which the pupils stand for good, mm, within [`PUPIL_RANGE_MM`] (drops, injury).
    pub fixed_mm: Option<f64>,
    /// Diameter at which somebody holds them for now, mm, within [`PUPIL_RANGE_MM`].
    pub held_mm: Option<f64>,
}

impl PupilControl {
    /// The diameter at which they stand, if they do, mm.
    pub fn diameter_mm(&self) -> Option<f64> {
        self.held_mm.or(self.fixed_mm)
    }
}

/// The light to which a person's eyes are adapted.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Adaptation {
    /// Mean luminance of what is before the eyes, cd/m².
    pub luminance_cd_m2: f64,
    /// Is that measured, by the camera that sees as she does, in what it draws? If not, or without such a
    /// camera, it is what an app says.
    pub is_measured: bool,
}

impl Default for Adaptation {
    /// A well-lit room, until a camera measures what is there.
    fn default() -> Self {
        Self {
            luminance_cd_m2: 100.0,
            is_measured: true,
        }
    }
}

/// Where an eye looks now: its line of sight in the head.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Gaze {
    /// Azimuth, radians, positive to the patient's right.
    pub azimuth_rad: f64,
    /// Elevation, radians, positive up.
    pub elevation_rad: f64,
    /// Torsion, radians, by Listing's law; the top of the eye to the patient's right.
    pub torsion_rad: f64,
}

impl Gaze {
    /// The line of sight towards these angles, with the torsion that Listing's law gives it.
    pub fn towards(angles: GazeAngles) -> Self {
        Self {
            azimuth_rad: angles.azimuth_rad,
            elevation_rad: angles.elevation_rad,
            torsion_rad: angles.listing_torsion_rad(),
        }
    }

    /// Unit vector of the line of sight in the head: x to the patient's right, y up, −z ahead.
    pub fn direction(&self) -> DVec3 {
        GazeAngles::new(self.azimuth_rad, self.elevation_rad).direction()
    }

    /// Rotation that brings the line of sight from straight ahead here (Fick: azimuth, elevation,
    /// torsion).
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(-self.azimuth_rad as f32)
            * Quat::from_rotation_x(self.elevation_rad as f32)
            * Quat::from_rotation_z(-self.torsion_rad as f32)
    }

    /// Rotation of the globe in the head. Its optical axis lies aside of the line of sight by angle
    /// alpha ([`Eye::angle_alpha_deg`]).
    pub fn globe_rotation(&self, eye: &Eye) -> Quat {
        let [outwards, down] = eye.angle_alpha_deg.map(|angle| angle.to_radians() as f32);
        let temporal = eye.laterality.temporal_sign() as f32;
        self.rotation() * Quat::from_rotation_y(-temporal * outwards) * Quat::from_rotation_x(-down)
    }
}

/// The pupil as it is now.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Pupil {
    /// Diameter of the stop, the hole in the iris, mm. What is seen of it from in front, and what
    /// limits the light, is the entrance pupil: [`Cornea::pupil_magnification`] times this.
    pub diameter_mm: f64,
}

impl Default for Pupil {
    fn default() -> Self {
        Self {
            diameter_mm: USUAL_PUPIL_MM,
        }
    }
}

/// What the lens does now.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Accommodation {
    /// Response above the relaxed state, D.
    pub response_d: f64,
}

/// A person's lids as they are now.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Eyelids {
    /// Opening relative to the person's relaxed one: 0 closed, 1 open.
    pub aperture: f64,
    /// Is a blink under way?
    pub blinking: bool,
    /// Number of blinks that have fully closed the lids.
    pub blink_epoch: u64,
}

impl Default for Eyelids {
    fn default() -> Self {
        Self {
            aperture: 1.0,
            blinking: false,
            blink_epoch: 0,
        }
    }
}

#[cfg(test)]
mod tests;
