//! The components that are the patient.
//!
//! Static anatomy (cornea, iris pigment, sclera) is set when a patient is
//! loaded; the moving parts (pupil, lens, lids, gaze) are written once a frame
//! in the `Move` set and read by everyone after it.

use super::patient::{GlaucomaStage, PatientFile};
use bevy::prelude::Component;
use serde::{Deserialize, Serialize};

/// Which of the two eyes: OD (oculus dexter, right) or OS (oculus sinister, left).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Laterality {
    /// The right eye; its temporal side is the patient's right.
    #[default]
    OD,
    /// The left eye; its temporal side is the patient's left.
    OS,
}

/// The eye itself: marks the patient's entity and says who it belongs to.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Eye {
    /// Right or left eye.
    pub laterality: Laterality,
    /// The owner's age in years, 1 to 110.
    pub age_years: f64,
    /// Radius of the scleral sphere, mm.
    pub scleral_radius_mm: f64,
}

/// The cornea as two conicoids p z² − 2 R z + x² + y² = 0 (François 2007, equation 1).
#[derive(Component, Clone, Debug, PartialEq)]
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
}

/// The iris: where it lies and what it is made of.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Iris {
    /// Depth of the iris plane behind the corneal apex, mm.
    pub depth_mm: f64,
    /// Radius of the iris root, mm.
    pub root_radius_mm: f64,
    /// Volume fraction of melanin in the stroma (C_m of equation 13).
    pub stroma_melanin_fraction: f64,
    /// Volume fraction of melanin in the anterior border layer.
    pub border_layer_melanin_fraction: f64,
    /// Ratio of eumelanin to all melanin (β_m of equation 13), 0 to 1.
    pub eumelanin_ratio: f64,
    /// Seed of the fibre relief.
    pub seed: u64,
}

/// The pupil as it is now.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Pupil {
    /// Diameter of the real pupil, mm, 1 to 9.
    pub diameter_mm: f64,
    /// Decentration of the pupil from the corneal axis, mm: nasal positive, superior positive.
    pub decentration_mm: [f64; 2],
}

/// The crystalline lens as it is now, with the eye's refractive error.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Lens {
    /// Accommodation above the relaxed state, D.
    pub accommodation_d: f64,
    /// Largest accommodation, D.
    pub amplitude_d: f64,
    /// Spherical equivalent of the refractive error, D; negative is myopia.
    pub spherical_equivalent_d: f64,
}

impl Lens {
    /// The vergence (D) of the plane that is sharp now: the far point, −SE, plus accommodation.
    pub fn focus_vergence_d(&self) -> f64 {
        self.accommodation_d - self.spherical_equivalent_d
    }
}

/// The sclera and what covers it.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Sclera {
    /// Redness of the conjunctiva, 0 (quiet) to 1 (injected).
    pub redness: f64,
    /// Seed of the vessels.
    pub seed: u64,
}

/// The lids as they are now.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Eyelids {
    /// Opening relative to the patient's relaxed one: 0 closed, 1 open.
    pub aperture: f64,
    /// Is a blink under way?
    pub blinking: bool,
    /// Number of blinks that have fully closed the lids.
    pub blink_epoch: u64,
    /// Skin tone, 0 (very light) to 1 (very dark).
    pub skin_tone: f64,
}

/// Where the eye looks now.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct GazeController {
    /// Azimuth of gaze, radians, positive to the patient's right.
    pub azimuth_rad: f64,
    /// Elevation of gaze, radians, positive up.
    pub elevation_rad: f64,
    /// Torsion, radians, by Listing's law.
    pub torsion_rad: f64,
    /// Azimuth of the fixated point (the end of the saccade in flight), radians.
    pub fixation_azimuth_rad: f64,
    /// Elevation of the fixated point, radians.
    pub fixation_elevation_rad: f64,
    /// Distance of the fixated point, m; may be infinite.
    pub fixation_distance_m: f64,
    /// Is a saccade in flight?
    pub in_saccade: bool,
    /// Number of fixations so far.
    pub fixation_index: u64,
}

/// The memory of what was seen sharply (Nießner 2013, section 4).
#[derive(Component, Clone, Debug, PartialEq)]
pub struct SharpnessField {
    /// Starving rate r, 1/s: the blur of an unseen place grows as e^(r t).
    /// 1–2 % a step at 30 Hz is 0.3–0.6.
    pub starve_rate_per_s: f64,
    /// Edge of a voxel, m.
    pub voxel_m: f64,
    /// Largest blur that is shown, as a visual angle in radians.
    pub blur_cap_rad: f64,
}

/// Glaucoma; a patient without it has no such component, and no pass, key or texture of it.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Glaucoma {
    /// Hodapp–Parrish–Anderson stage.
    pub stage: GlaucomaStage,
}

impl PatientFile {
    /// The components of this patient, at rest: looking straight ahead, lids open.
    pub fn components(
        &self,
    ) -> (
        Eye,
        Cornea,
        Iris,
        Pupil,
        Lens,
        Sclera,
        Eyelids,
        GazeController,
        SharpnessField,
    ) {
        let pigment = self.iris_color.pigment();
        (
            Eye {
                laterality: self.eye,
                age_years: self.age_years,
                scleral_radius_mm: self.scleral_radius_mm,
            },
            Cornea {
                anterior_radius_mm: self.cornea_radius_mm,
                anterior_p: self.cornea_p,
                posterior_radius_mm: self.cornea_posterior_radius_mm,
                posterior_p: self.cornea_posterior_p,
                thickness_mm: self.cornea_thickness_mm,
                index: 1.376,
                aqueous_index: 1.336,
                limbus_radius_mm: self.limbus_radius_mm,
                lipid_thickness_nm: self.lipid_thickness_nm,
            },
            Iris {
                depth_mm: self.iris_depth_mm,
                root_radius_mm: self.limbus_radius_mm + 0.2,
                stroma_melanin_fraction: self.stroma_melanin_fraction.unwrap_or(pigment.0),
                border_layer_melanin_fraction: self
                    .border_layer_melanin_fraction
                    .unwrap_or(pigment.1),
                eumelanin_ratio: self.eumelanin_ratio.unwrap_or(pigment.2),
                seed: self.seed,
            },
            Pupil {
                diameter_mm: self.pupil.diameter_mm().unwrap_or(4.0),
                decentration_mm: self.pupil_decentration_mm,
            },
            Lens {
                accommodation_d: 0.0,
                amplitude_d: self.amplitude_d(),
                spherical_equivalent_d: self.spherical_equivalent_d(),
            },
            Sclera {
                redness: self.redness,
                seed: self.seed ^ 0x5c1e_4a00,
            },
            Eyelids {
                aperture: 1.0,
                blinking: false,
                blink_epoch: 0,
                skin_tone: self.skin_tone,
            },
            GazeController {
                fixation_distance_m: f64::INFINITY,
                ..GazeController::default()
            },
            SharpnessField {
                starve_rate_per_s: self.starve_rate_per_s,
                voxel_m: self.voxel_mm * 1e-3,
                blur_cap_rad: self.blur_cap_arcmin.to_radians() / 60.0,
            },
        )
    }
}
