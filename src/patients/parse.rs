//! Reading and checking patient files: RON, every field optional, units in the names.
//!
//! Enters: text. Leaves: a [`PatientFile`] whose every number is finite and in the range that
//! [`FIELDS`] states, or one sentence that says which field is wrong, what it holds and what is
//! allowed.

use super::file::{CONDITIONS, FIELDS, Field, PatientFile, WORDS, condition_ranges};
use crate::anatomy::Laterality;
use crate::input_file::notation::{self, Fault, FaultKind, one_of};
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
    /// A field holds a value of another kind than it may have.
    #[error("{file}:{line}:{column}: {field} {}; it must be {allowed}", has(value))]
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

/// What is wrong with a value.
fn has(value: &str) -> String {
    if value.is_empty() {
        "has no value".into()
    } else {
        format!("= {value} is not allowed")
    }
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
    let begins = text.trim_start_matches('\u{feff}').trim_start();
    if !begins.is_empty() && !begins.starts_with(['(', '/', '#']) {
        return Err(PatientError::Syntax {
            file: file.into(),
            line: 1,
            column: 1,
            reason:
                "this is not a patient file: it must be RON, as in (name: \"Ann\", age_years: 40)"
                    .into(),
        });
    }
    notation::read(text).map_err(|fault| of_fault(fault, file))
}

/// A fault of the notation, in a user's words.
fn of_fault(fault: Fault, file: &str) -> PatientError {
    let field = fault.field();
    let (line, column) = (fault.line, fault.column);
    let syntax = |reason: String| PatientError::Syntax {
        file: file.into(),
        line,
        column,
        reason,
    };
    let kind = |value: String, allowed: String| PatientError::Kind {
        file: file.into(),
        line,
        column,
        field: field.clone(),
        value,
        allowed,
    };
    // The field itself, whichever eye it is of.
    let (eye, own) = match fault.path.split_first() {
        Some((eye, own)) if eye == "right" || eye == "left" => (Some(&**eye), own),
        _ => (None, &*fault.path),
    };
    let whose = match (eye, own) {
        (None, []) => "a patient".to_owned(),
        (Some(_), []) => "one eye".to_owned(),
        _ => field.clone(),
    };
    match fault.kind {
        FaultKind::Notation(clause) if field.is_empty() => syntax(clause),
        FaultKind::Notation(clause) => syntax(format!("in {field}: {clause}")),
        FaultKind::Twice { field } => syntax(format!("{field} of {whose} is given twice")),
        FaultKind::Missing { field } => syntax(format!("{field} of {whose} is missing")),
        FaultKind::UnknownField { found, known } => {
            let is_shared = own.is_empty()
                && (FIELDS.iter().any(|field| field.name == found)
                    || WORDS.iter().any(|(name, _)| *name == found));
            syntax(match eye {
                Some(eye) if is_shared => {
                    format!("{found} belongs to the person: it stands outside of {eye}")
                }
                _ => match nearest(&found, known) {
                    Some(meant) => {
                        format!("unknown field {found:?} of {whose}; did you mean {meant}?")
                    }
                    None => format!(
                        "unknown field {found:?}; the fields of {whose} are {}",
                        known.join(", ")
                    ),
                },
            })
        }
        FaultKind::UnknownWord { found, known } => {
            kind(found, allowed(own).unwrap_or_else(|| one_of(known)))
        }
        FaultKind::Value { found } => match allowed(if own.is_empty() { &fault.path } else { own })
        {
            Some(allowed) => kind(found, allowed),
            None => syntax("this is not a sound patient file".into()),
        },
    }
}

/// The name that is most like another, if one is.
fn nearest(found: &str, known: &'static [&'static str]) -> Option<&'static str> {
    let alike = |name: &&str| strsim::jaro_winkler(&found.to_lowercase(), name);
    let best = known
        .iter()
        .copied()
        .max_by(|a, b| alike(a).total_cmp(&alike(b)))?;
    (alike(&best) > 0.86).then_some(best)
}

/// A field's entries in the table: one, or the two of a pair.
fn pair_of(name: &str) -> [Option<&'static Field>; 2] {
    [0, 1].map(|index| {
        FIELDS
            .iter()
            .find(|field| field.name == name && field.index == index)
    })
}

/// What may stand in a field, by its path without the eye; `None` where there is no such field.
fn allowed(path: &[String]) -> Option<String> {
    let (name, inner) = path.split_first()?;
    if let Some((_, meaning)) = CONDITIONS.iter().find(|(condition, _)| condition == name) {
        let numbers = condition_ranges(name);
        let of_number = match inner {
            [] => None,
            [number, ..] => numbers.iter().find(|(own, _)| own == number).or(
                // The number of a word, such as MeanDeviation(-8).
                numbers.first().filter(|_| numbers.len() == 1),
            ),
        };
        return Some(match of_number {
            Some((_, (low, high))) => format!("a number, {low} to {high}"),
            // What it is stands before the colon.
            None => meaning
                .split_once(": ")
                .map_or(*meaning, |(_, written)| written)
                .to_owned(),
        });
    }
    if let Some((_, allowed)) = WORDS.iter().find(|(word, _)| word == name) {
        return Some((*allowed).to_owned());
    }
    match pair_of(name) {
        [Some(one), None] => Some(format!("a number, {} to {}", one.range.0, one.range.1)),
        [Some(one), Some(_)] => Some(format!(
            "two numbers in round brackets, each {} to {}",
            one.range.0, one.range.1
        )),
        _ => None,
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
        assert_eq!(
            said("(age_years: \"old\")"),
            "p.ron:1:13: age_years = \"old\" is not allowed; it must be a number, 1 to 110"
        );
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
            error.contains("age_years") && error.contains("outside of right"),
            "{error}"
        );
    }

    #[test]
    fn a_value_of_another_kind_is_told_what_may_stand_there() {
        for (text, parts) in [
            (
                "(left: (redness: yes))",
                &["left.redness = yes", "a number, 0 to 1"][..],
            ),
            (
                "(pupil: 4.0)",
                &["pupil = 4.0", "Auto or Fixed(mm), 1 to 9"],
            ),
            ("(pupil: Fixed(wide))", &["pupil.Fixed = wide", "1 to 9"]),
            ("(eye: Right)", &["eye = Right", "OD or OS"]),
            ("(seed: -1)", &["seed = -1", "whole number"]),
            ("(seed: 1.5)", &["seed = 1.5", "whole number"]),
            ("(name: Ann)", &["name = Ann", "quotation marks"]),
            (
                "(angle_alpha_deg: 5.0)",
                &["angle_alpha_deg = 5.0", "each -15 to 15"],
            ),
            (
                "(angle_alpha_deg: [5.0, 1.0])",
                &["angle_alpha_deg", "round brackets"],
            ),
            (
                "(angle_alpha_deg: (5.0, 1.0, 2.0))",
                &["angle_alpha_deg", "two numbers"],
            ),
            (
                "(angle_alpha_deg: (5.0, 20.0))",
                &["angle_alpha_deg = (5, 20)", "each -15 to 15"],
            ),
            (
                "(glaucoma: Bad)",
                &["glaucoma = Bad", "it must be `Early`", "MeanDeviation"],
            ),
            (
                "(glaucoma: MeanDeviation(-3, 1))",
                &["glaucoma.MeanDeviation = -3, 1 is"],
            ),
            ("(pupil: Fixed)", &["pupil.Fixed has no value", "1 to 9"]),
            (
                "(shpere_d: 1)",
                &["\"shpere_d\" of a patient", "mean sphere_d?"],
            ),
            (
                "(left: (sphere_d: None))",
                &["left.sphere_d = None", "-20 to 20"],
            ),
            ("(sphere_d: 1,5)", &["p.ron:1:13", "decimal point"]),
            ("", &["it is empty"]),
            (
                "(glaucoma: MeanDeviation(x))",
                &["glaucoma.MeanDeviation = x", "-30 to 0"],
            ),
            (
                "(glaucoma: MeanDeviation(-40))",
                &["glaucoma = MeanDeviation(-40", "-30 to 0"],
            ),
            (
                "(cataract: (log_s: 2.6))",
                &["cataract.log_s = 2.6", "0.5 to 2.5"],
            ),
            (
                "(right: (cataract: (nuclear: 7)))",
                &["right.cataract.nuclear = 7", "0 to 6.9"],
            ),
            (
                "(cataract: (nuclear: much))",
                &["cataract.nuclear = much", "0 to 6.9"],
            ),
            (
                "(cataract: (center: 1.0))",
                &["fields of cataract are nuclear"],
            ),
            ("(cataract: 3)", &["cataract = 3", "nuclear: 0 to 6.9"]),
            ("(ptosis: ())", &["mrd1_mm of ptosis is missing"]),
            ("(left: 3)", &["left = 3", "(sphere_d: -2.0)"]),
            (
                "(left: (age_years: 4.0))",
                &["age_years belongs to the person", "outside of left"],
            ),
            (
                "(left: (colour: 4.0))",
                &["\"colour\"", "fields of one eye"],
            ),
            (
                "(age_years: 3.0, age_years: 4.0)",
                &["age_years of a patient is given twice"],
            ),
            ("(age_years: 3.0", &["bracket"]),
            ("[1, 2]", &["not a patient file"]),
        ] {
            let error = parse_patient(text, "p.ron").expect_err(text).to_string();
            for part in parts.iter().chain([&"p.ron"]) {
                assert!(error.contains(part), "{text}: {error} lacks {part}");
            }
            for parser in ["Laterality", "PatientFile", "EyeFile", "Expected", "f64"] {
                assert!(!error.contains(parser), "{text}: {error}");
            }
        }
    }

    #[test]
    fn one_eye_may_lack_what_both_have() {
        let file = parse_patient(
            "(cataract: (nuclear: 3.0), eumelanin_ratio: 0.2, right: (cataract: None, eumelanin_ratio: None))",
            "p.ron",
        )
        .expect("sound");
        let [right, left] = Laterality::BOTH.map(|eye| file.of_eye(eye));
        assert_eq!((right.cataract, right.eumelanin_ratio), (None, None));
        assert!(left.cataract.is_some() && left.eumelanin_ratio.is_some());
        let text = ron::ser::to_string(&file).expect("RON");
        assert_eq!(parse_patient(&text, "again").expect("sound"), file);
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
