//! The patient: one anatomical state that both viewers read.
//!
//! Enters: a patient file (RON) or a built-in preset. Leaves: an entity whose
//! components are the eye's parts ([`Eye`], [`Cornea`], [`Iris`], [`Pupil`],
//! [`Lens`], [`Sclera`], [`Eyelids`], [`GazeController`], [`SharpnessField`])
//! and, only where the patient has it, [`Glaucoma`]. No value is stored twice:
//! the appearance and the percept both read these components.
//!
//! Shapes and defaults follow François et al. 2007 (cornea, equation 1),
//! Atchison 2006 and the reference tables named in each field's documentation.

mod components;
mod patient;
mod presets;

pub use components::{
    Cornea, Eye, Eyelids, GazeController, Glaucoma, Iris, Laterality, Lens, Pupil, Sclera,
    SharpnessField,
};
#[cfg(feature = "app")]
pub(crate) use patient::parse_unchecked;
pub use patient::{
    GlaucomaStage, IrisColor, PatientError, PatientFile, PupilSetting, load_patient, parse_patient,
};
pub use presets::{PRESETS, Preset, preset};
