//! Patients as files: reading, checking, the built-in ones, and making entities of them.
//!
//! Enters: a name, a path, or text in RON. Leaves: a [`PatientFile`]. Spawned or inserted as a
//! component it makes its entity that person, with two eyes ([`crate::anatomy`]) and the conditions
//! that they have ([`crate::conditions`]), and is gone.

mod components;
mod file;
mod parse;
mod presets;

pub use components::PatientReader;
pub use file::{CONDITIONS, EyeFile, FIELDS, Field, PatientFile, PupilSetting};
#[cfg(feature = "app")]
pub(crate) use parse::parse_unchecked;
pub use parse::{PatientError, load_patient, parse_patient};
pub use presets::{PRESETS, Preset, preset};
