//! What is wrong in the notation of a patient file, in a user's words.

use super::super::file::{CONDITIONS, FIELDS, WORDS, condition_ranges};
use super::{PatientError, pair_of};
use crate::input_file::nearest;
use crate::input_file::notation::{Fault, FaultKind, one_of};

/// A fault of the notation, in a user's words.
pub(super) fn of_fault(fault: Fault, file: &str) -> PatientError {
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
                    None => {
                        let (artists, own): (Vec<&str>, Vec<&str>) =
                            known.iter().partition(|name| name.starts_with("look_"));
                        let more = match artists.len() {
                            0 => String::new(),
                            many => format!(", and {many} that begin with look_"),
                        };
                        format!(
                            "unknown field {found:?}; the fields of {whose} are {}{more}",
                            own.join(", ")
                        )
                    }
                },
            })
        }
        FaultKind::UnknownWord { found, known } => {
            kind(found, allowed(own).unwrap_or_else(|| one_of(known)))
        }
        FaultKind::Value { found } => match allowed(if own.is_empty() { &fault.path } else { own })
        {
            Some(allowed) => kind(found, allowed),
            None => syntax(
                "this is not a patient file: it must be a RON structure, as in (name: \"Ann\", age_years: 40); a list \
                 is a head path, for --head-path"
                    .into(),
            ),
        },
    }
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
