//! Reading and checking patient files: RON, every field optional, units in the names.
//!
//! Enters: text. Leaves: a [`PatientFile`] whose every number is finite and in the range that
//! [`FIELDS`] states, or one sentence that says which field is wrong, what it holds and what is
//! allowed.

mod faults;

use super::file::{FIELDS, Field, PatientFile};
use crate::anatomy::Laterality;
use crate::input_file::notation;
use crate::input_file::{did_you_mean, one_clause, read_input_file};
use crate::optics::conicoid::conicoid_sag;
use crate::optics::globe::GlobeShape;
use std::path::Path;

/// Why a patient could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PatientError {
    /// The name is neither built in nor a file.
    #[error("unknown patient {name:?}: it is neither a file nor one of {known}{meant}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// A question for the name that it is like, or nothing.
        meant: String,
        /// The built-in names.
        known: String,
    },
    /// The file could not be read.
    #[error("cannot read patient file {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// A field holds a value of another kind than it may have.
    #[error(
        "{file}:{line}:{column}: {}",
        notation::not_allowed(field, value, allowed)
    )]
    Kind {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The field, as in `left.cataract.nuclear`.
        field: String,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// The text is not a patient.
    #[error("{file}:{line}:{column}: {reason}")]
    Syntax {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        reason: String,
    },
    /// A field holds a value that no eye has.
    #[error("{file}: {}{field}{} = {value} is out of range; allowed: {allowed}", of(*eye), number_of(part))]
    OutOfRange {
        /// The file.
        file: String,
        /// The eye, where it is about one of the two.
        eye: Option<Laterality>,
        /// The field.
        field: &'static str,
        /// The number of a condition, as in `nuclear`; empty for a field of its own.
        part: &'static str,
        /// What it holds.
        value: String,
        /// What may stand there.
        allowed: String,
    },
}

/// The number of a condition, behind the condition's name.
fn number_of(part: &str) -> String {
    if part.is_empty() {
        String::new()
    } else {
        format!(".{part}")
    }
}

/// The part of a file that speaks of this eye.
fn of(eye: Option<Laterality>) -> &'static str {
    match eye {
        None => "",
        Some(Laterality::OD) => "right.",
        Some(Laterality::OS) => "left.",
    }
}

impl PatientError {
    /// The same error, about one eye.
    fn of_eye(self, own: Option<Laterality>) -> Self {
        match self {
            Self::OutOfRange {
                file,
                field,
                part,
                value,
                allowed,
                ..
            } => Self::OutOfRange {
                file,
                eye: own,
                field,
                part,
                value,
                allowed,
            },
            other => other,
        }
    }
}

impl PatientFile {
    /// Checks every number against its range; `file` names the source in the error.
    pub fn check(&self, file: &str) -> Result<(), PatientError> {
        self.check_text(file)?;
        let [right, left] = Laterality::BOTH.map(|eye| self.of_eye(eye).check_eye(file).err());
        let is_of_both = |one: &PatientError, other: &PatientError| {
            // One text for one field, value and range.
            one.to_string() == other.to_string()
        };
        match (right, left) {
            (None, None) => Ok(()),
            (Some(right), Some(left)) if is_of_both(&right, &left) => Err(right),
            (Some(right), _) => Err(right.of_eye(Some(Laterality::OD))),
            (None, Some(left)) => Err(left.of_eye(Some(Laterality::OS))),
        }
    }

    /// Checks a patient with both eyes alike.
    fn check_eye(&self, file: &str) -> Result<(), PatientError> {
        for field in FIELDS {
            let Some(value) = (field.get)(self) else {
                continue;
            };
            let (low, high) = field.range;
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                let [first, second] = pair_of(field.name);
                let (value, allowed) = match (first, second) {
                    (Some(first), Some(second)) => {
                        let numbers =
                            [first, second].map(|one| (one.get)(self).unwrap_or_default());
                        (
                            format!("({}, {})", numbers[0], numbers[1]),
                            format!("each {low} to {high}"),
                        )
                    }
                    _ => (format!("{value}"), format!("{low} to {high}")),
                };
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    eye: None,
                    field: field.name,
                    part: "",
                    value,
                    allowed,
                });
            }
        }
        if let Some((field, part, value, (low, high))) = self.wrong_condition_number() {
            let written = self.condition_notation(field);
            // One that is written as a word, such as MeanDeviation(-40), has no names of numbers.
            let is_word = written.starts_with(char::is_alphabetic);
            return Err(PatientError::OutOfRange {
                file: file.into(),
                eye: None,
                field,
                part: if is_word { "" } else { part },
                value: if is_word { written } else { format!("{value}") },
                allowed: format!("{low} to {high}"),
            });
        }
        self.check_shape(file)?;
        self.check_globe(file)
    }

    /// Text is shown on terminals, which take control characters for commands.
    fn check_text(&self, file: &str) -> Result<(), PatientError> {
        let breaks: &[char] = &['\n', '\r', '\t'];
        for (field, text, allowed_too) in [
            ("name", &self.name, &[][..]),
            ("description", &self.description, breaks),
        ] {
            if let Some(found) = text
                .chars()
                .find(|c| c.is_control() && !allowed_too.contains(c))
            {
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    eye: None,
                    field,
                    part: "",
                    value: format!("\"{}\"", one_clause(text)),
                    allowed: format!("text without control characters such as {found:?}"),
                });
            }
        }
        Ok(())
    }

    /// Cornea and sclera must meet at the limbus, with the iris inside.
    fn check_globe(&self, file: &str) -> Result<(), PatientError> {
        let refused = |value: String, allowed: String| PatientError::OutOfRange {
            file: file.into(),
            eye: None,
            field: "cornea_radius_mm",
            part: "",
            value,
            allowed,
        };
        let shape = GlobeShape::new(
            self.scleral_radius_mm,
            self.cornea_radius_mm,
            self.cornea_p,
            self.limbus_radius_mm,
        )
        .map_err(|error| {
            refused(
                format!("{}", self.cornea_radius_mm),
                format!(
                    "a radius with which cornea (p = {}), limbus ({} mm) and sclera ({} mm) meet: {error}",
                    self.cornea_p, self.limbus_radius_mm, self.scleral_radius_mm
                ),
            )
        })?;
        let deepest = 0.6 * shape.apex_distance_mm();
        if self.iris_depth_mm > deepest {
            return Err(PatientError::OutOfRange {
                file: file.into(),
                eye: None,
                field: "iris_depth_mm",
                part: "",
                value: format!("{}", self.iris_depth_mm),
                allowed: format!("2.5 to {deepest:.2} for this globe"),
            });
        }
        Ok(())
    }

    /// The corneal conicoid must reach the limbus, and the iris must lie inside the eye.
    fn check_shape(&self, file: &str) -> Result<(), PatientError> {
        for (field, radius, p) in [
            ("cornea_p", self.cornea_radius_mm, self.cornea_p),
            (
                "cornea_posterior_p",
                self.cornea_posterior_radius_mm,
                self.cornea_posterior_p,
            ),
        ] {
            let widest = if p > 0.0 {
                radius / p.sqrt()
            } else {
                f64::INFINITY
            };
            // A margin keeps the slope at the limbus finite.
            if widest < self.limbus_radius_mm * 1.02 {
                let largest = (radius / (1.02 * self.limbus_radius_mm)).powi(2);
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    eye: None,
                    field,
                    part: "",
                    value: format!("{p}"),
                    allowed: format!(
                        "0.2 to {largest:.3} for a radius of {radius} mm and a limbus of {} mm, \
                         or the surface does not reach the limbus",
                        self.limbus_radius_mm
                    ),
                });
            }
        }
        self.check_thickness(file)
    }

    /// The back of the cornea must lie behind its front as far as the limbus.
    fn check_thickness(&self, file: &str) -> Result<(), PatientError> {
        let nearer = |r: f64| {
            conicoid_sag(r, self.cornea_radius_mm, self.cornea_p)
                - conicoid_sag(r, self.cornea_posterior_radius_mm, self.cornea_posterior_p)
        };
        let places = (0..=64).map(|step| f64::from(step) / 64.0 * self.limbus_radius_mm);
        let least = places.map(nearer).fold(0.0, f64::max);
        if self.cornea_thickness_mm > least {
            return Ok(());
        }
        let surfaces = format!(
            "radii of {} and {} mm (p = {} and {})",
            self.cornea_radius_mm,
            self.cornea_posterior_radius_mm,
            self.cornea_p,
            self.cornea_posterior_p
        );
        let crossing = "or front and back of the cornea cross before the limbus";
        // No cornea is as thick as some surfaces would need.
        let (field, value, allowed) = if least < 0.9 {
            let allowed = format!("more than {least:.3} for {surfaces}, {crossing}");
            ("cornea_thickness_mm", self.cornea_thickness_mm, allowed)
        } else {
            let allowed = format!("smaller against the front's, {crossing}: now {surfaces}");
            let radius = self.cornea_posterior_radius_mm;
            ("cornea_posterior_radius_mm", radius, allowed)
        };
        Err(PatientError::OutOfRange {
            file: file.into(),
            eye: None,
            field,
            part: "",
            value: format!("{value}"),
            allowed,
        })
    }
}

/// Reads a patient from RON text; `file` names it in errors.
pub fn parse_patient(text: &str, file: &str) -> Result<PatientFile, PatientError> {
    let patient = parse_unchecked(text, file)?;
    patient.check(file)?;
    Ok(patient)
}

/// [`parse_patient`] without [`PatientFile::check`].
pub(crate) fn parse_unchecked(text: &str, file: &str) -> Result<PatientFile, PatientError> {
    notation::read(text).map_err(|fault| faults::of_fault(fault, file))
}

/// A field's entries in the table: one, or the two of a pair.
pub(super) fn pair_of(name: &str) -> [Option<&'static Field>; 2] {
    [0, 1].map(|index| {
        FIELDS
            .iter()
            .find(|field| field.name == name && field.index == index)
    })
}

/// Largest patient file, bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Loads a built-in patient by name, or a patient file by path.
pub fn load_patient(name_or_path: impl AsRef<Path>) -> Result<PatientFile, PatientError> {
    let path = name_or_path.as_ref();
    if let Some(preset) = path.to_str().and_then(super::preset) {
        return parse_patient(preset.text, preset.name);
    }
    let shown = path.display().to_string();
    if path.exists() || path.extension().is_some_and(|extension| extension == "ron") {
        let unreadable = |reason: String| PatientError::Unreadable {
            file: shown.clone(),
            reason,
        };
        let bytes = read_input_file(path, MAX_FILE_BYTES).map_err(|error| {
            unreadable(match error.kind() {
                std::io::ErrorKind::NotFound => "it does not exist".into(),
                _ => error.to_string(),
            })
        })?;
        let text = String::from_utf8(bytes)
            .map_err(|_| unreadable("it is not UTF-8 text, so not a patient file".into()))?;
        return parse_patient(&text, &shown);
    }
    let known: Vec<&str> = super::PRESETS.iter().map(|preset| preset.name).collect();
    Err(PatientError::Unknown {
        meant: did_you_mean(&shown, &known),
        name: shown,
        known: known.join(", "),
    })
}

#[cfg(test)]
mod tests;
