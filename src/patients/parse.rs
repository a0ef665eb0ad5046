//! Reading and checking patient files: RON, every field optional, units in the names.
//!
//! Enters: text. Leaves: a [`PatientFile`] whose every number is finite and in the range that
//! [`FIELDS`] states, or one sentence that says which field is wrong, what it holds and what is
//! allowed.

use super::file::{FIELDS, PatientFile};
use crate::anatomy::Laterality;
use crate::input_file::{one_clause, read_input_file};
use crate::optics::globe::GlobeShape;
use std::path::Path;

/// Why a patient could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PatientError {
    /// The name is neither built in nor a file.
    #[error("unknown patient {name:?}: it is neither a file nor one of {known}")]
    Unknown {
        /// What was asked for.
        name: String,
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
    #[error("{file}: {}{field} = {value} is out of range; allowed: {allowed}", of(*eye))]
    OutOfRange {
        /// The file.
        file: String,
        /// The eye, where it is about one of the two.
        eye: Option<Laterality>,
        /// The field.
        field: &'static str,
        /// What it holds.
        value: String,
        /// What may stand there.
        allowed: String,
    },
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
                value,
                allowed,
                ..
            } => Self::OutOfRange {
                file,
                eye: own,
                field,
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
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    eye: None,
                    field: field.name,
                    value: format!("{value}"),
                    allowed: format!("{low} to {high}"),
                });
            }
        }
        for (field, value, (low, high)) in self.condition_numbers() {
            if !(low..=high).contains(&value) {
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    eye: None,
                    field,
                    value: format!("{value}"),
                    allowed: format!("{low} to {high}"),
                });
            }
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
                    value: format!("{p}"),
                    allowed: format!(
                        "0.2 to {largest:.3} for a radius of {radius} mm and a limbus of {} mm, \
                         or the surface does not reach the limbus",
                        self.limbus_radius_mm
                    ),
                });
            }
        }
        Ok(())
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
    // Some editors begin a file with this mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let options =
        ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options
        .from_str(text)
        .map_err(|error| PatientError::Syntax {
            file: file.into(),
            line: error.span.start.line,
            column: error.span.start.col,
            reason: if text.trim_start().starts_with('(')
                && matches!(error.code, ron::error::Error::ExpectedStructLike)
            {
                "round brackets are expected here, as in (0.2, 0.0)".into()
            } else {
                sentence(&error.code)
            },
        })
}

/// What RON found, in a user's words.
fn sentence(code: &ron::error::Error) -> String {
    use ron::error::Error;
    match code {
        Error::NoSuchStructField {
            expected, found, ..
        } => format!(
            "unknown field \"{}\"; the fields of a patient are {}",
            one_clause(found),
            expected.join(", ")
        ),
        Error::NoSuchEnumVariant {
            expected,
            found,
            outer,
        } => format!(
            "unknown {} \"{}\"; it may be {}",
            outer.as_deref().unwrap_or("value"),
            one_clause(found),
            expected.join(", ")
        ),
        Error::SuggestRawIdentifier(found) | Error::InvalidIdentifier(found) => format!(
            "a name is expected here, not {}; a pupil, say, is Auto or Fixed(4.5)",
            one_clause(found)
        ),
        Error::ExpectedDifferentStructName { .. }
        | Error::ExpectedStructLike
        | Error::ExpectedNamedStructLike(_)
        | Error::Eof => {
            "this is not a patient file: it must be RON, as in (name: \"Ann\", age_years: 40)"
                .into()
        }
        other => format!("this is not a sound patient file: {}", one_clause(other)),
    }
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
    Err(PatientError::Unknown {
        name: shown,
        known: super::PRESETS
            .iter()
            .map(|preset| preset.name)
            .collect::<Vec<_>>()
            .join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_sound() {
        for preset in crate::patients::PRESETS {
            let patient = load_patient(preset.name).expect(preset.name);
            assert!(
                !patient.description.is_empty(),
                "{} has no description",
                preset.name
            );
        }
    }

    #[test]
    fn an_empty_patient_is_the_default_one() {
        assert_eq!(
            parse_patient("()", "x").expect("sound"),
            PatientFile::default()
        );
    }

    #[test]
    fn errors_name_file_field_value_and_range() {
        let said = |text: &str| parse_patient(text, "p.ron").expect_err(text).to_string();
        let error = said("(age_years: 300.0)");
        for part in ["p.ron", "age_years", "300", "1 to 110"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(parse_patient("\u{feff}(age_years: 40.0)", "p.ron").is_ok());
        assert!(said("(name: \"\\u{1b}[31mAnn\")").contains("control"));
        assert!(said("(sphere_d: NaN)").contains("NaN"));
        assert!(said("(pupil: Fixed(0.5))").contains("1 to 9"));
        let error = said("(eye_color: Blue)");
        assert!(
            error.contains("eye_color") && error.contains("iris_color"),
            "{error}"
        );
        assert!(said("(iris_color: Purple)").contains("Brown"));
        assert!(said("").contains("RON"));
        assert!(said("(age_years: \"old\")").contains("p.ron:1:"));
        assert!(said("(cornea_p: 1.5, cornea_radius_mm: 6.0)").contains("limbus"));
    }

    #[test]
    fn one_eye_may_have_what_the_other_has_not() {
        let text = "(sphere_d: -1.0, left: (sphere_d: -4.0, iris_color: Blue))";
        let file = parse_patient(text, "p.ron").expect("sound");
        let [right, left] = Laterality::BOTH.map(|eye| file.of_eye(eye));
        assert_eq!((right.sphere_d, left.sphere_d), (-1.0, -4.0));
        assert_ne!(right.iris_color, left.iris_color);
        let said = |text: &str| parse_patient(text, "p.ron").expect_err(text).to_string();
        let error = said("(left: (sphere_d: -40.0))");
        for part in ["p.ron", "left.sphere_d", "-40", "-20 to 20"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(!said("(sphere_d: -40.0)").contains("right"));
        // What both share is nobody's alone, however else the eyes differ.
        let error = said("(age_years: 300.0, left: (sphere_d: -4.0))");
        assert!(
            !error.contains("right") && !error.contains("left"),
            "{error}"
        );
        let error = said("(right: (age_years: 4.0))");
        assert!(
            error.contains("age_years") && error.contains("sphere_d"),
            "{error}"
        );
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        let error = load_patient("nobody").expect_err("unknown").to_string();
        assert!(
            error.contains("healthy-brown") && error.contains("glaucoma-moderate"),
            "{error}"
        );
    }

    #[test]
    fn a_file_survives_being_written_and_read() {
        let patient = load_patient("glaucoma-moderate").expect("preset");
        let text = ron::ser::to_string(&patient).expect("RON");
        assert_eq!(parse_patient(&text, "again").expect("sound"), patient);
    }
}
