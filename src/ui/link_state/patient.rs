//! A patient as a built-in one and the fields in which it differs.

use crate::anatomy::Laterality;
use crate::patients::{PRESETS, PatientError, PatientFile, load_patient, parse_unchecked};
use serde_json::{Map, Value};

fn fields_of(patient: &PatientFile) -> Map<String, Value> {
    match serde_json::to_value(patient) {
        Ok(Value::Object(fields)) => fields,
        // A struct of numbers, names and options is an object.
        _ => Map::new(),
    }
}

/// The nearest built-in patient's name and, by name, the fields in which this one differs.
pub fn changes(patient: &PatientFile) -> (&'static str, Vec<(String, String)>) {
    let wanted = fields_of(patient);
    let differences = PRESETS.iter().filter_map(|preset| {
        let usual = fields_of(&load_patient(preset.name).ok()?);
        let differing: Vec<_> = wanted
            .iter()
            .filter(|(field, value)| usual.get(*field) != Some(*value))
            .map(|(field, value)| (key_of(field).to_owned(), notation(value)))
            .collect();
        Some((preset.name, differing))
    });
    differences
        .min_by_key(|(_, differing)| differing.len())
        .unwrap_or((PRESETS[0].name, Vec::new()))
}

/// A value as a patient file writes it; text stands without quotation marks.
fn notation(value: &Value) -> String {
    match value {
        Value::Null => "None".into(),
        Value::String(text) => text.clone(),
        Value::Array(parts) => {
            let parts: Vec<String> = parts.iter().map(notation).collect();
            format!("({})", parts.join(","))
        }
        // An enum's variant with a value, as in Fixed(4.0).
        Value::Object(variant)
            if variant
                .keys()
                .any(|name| name.starts_with(char::is_uppercase)) =>
        {
            variant
                .iter()
                .map(|(name, value)| format!("{name}({})", notation(value)))
                .collect()
        }
        // What one eye has of its own.
        Value::Object(fields) => {
            let fields: Vec<String> = fields
                .iter()
                .map(|(name, value)| format!("{name}:{}", notation(value)))
                .collect();
            format!("({})", fields.join(","))
        }
        other => {
            let number = other.to_string();
            number.strip_suffix(".0").unwrap_or(&number).to_owned()
        }
    }
}

/// Fields that hold text.
const TEXTS: [&str; 2] = ["name", "description"];
/// The patient's seed by its name in a link, where `seed` is that of the session.
const PATIENT_SEED: &str = "patient_seed";

/// Fields that may be at fault where another is named.
const BESIDE: [&str; 8] = [
    "right",
    "left",
    "limbus_radius_mm",
    "scleral_radius_mm",
    "cornea_p",
    "cornea_posterior_p",
    "cornea_posterior_radius_mm",
    "iris_depth_mm",
];

fn key_of(field: &str) -> &str {
    if field == "seed" { PATIENT_SEED } else { field }
}

fn field_of(key: &str) -> &str {
    if key == PATIENT_SEED { "seed" } else { key }
}

/// The built-in patient with these fields changed. One that is refused stays as it is and adds a
/// sentence.
pub(super) fn with_changes(
    preset: &str,
    changes: &[(&str, &str)],
    refused: &mut Vec<String>,
) -> PatientFile {
    let usual = load_patient(preset).unwrap_or_default();
    let mut wanted = Map::new();
    for &(key, value) in changes {
        match read(field_of(key), value) {
            Ok(value) => {
                wanted.insert(field_of(key).into(), value);
            }
            Err(reason) => refused.push(reason),
        }
    }
    // Fields may be sound only together, so they are judged together, and the one that fails goes.
    loop {
        let mut fields = fields_of(&usual);
        fields.extend(wanted.clone());
        let Ok(patient) = serde_json::from_value::<PatientFile>(Value::Object(fields)) else {
            // A number that is none, beside another fault.
            let alone = |(key, value): &(&String, &Value)| {
                let mut fields = fields_of(&usual);
                fields.insert((*key).clone(), (*value).clone());
                serde_json::from_value::<PatientFile>(Value::Object(fields)).is_err()
            };
            let Some(key) = wanted.iter().find(alone).map(|(key, _)| key.clone()) else {
                return usual;
            };
            wanted.remove(&key);
            refused.push(format!("The link's {} cannot be read.", key_of(&key)));
            continue;
        };
        let Err(error) = patient.check("The link") else {
            return patient;
        };
        refused.push(format!("{error}."));
        let failed = match error {
            PatientError::OutOfRange { field, eye, .. } => remove_fault(&mut wanted, eye, field),
            _ => None,
        };
        // What is at fault may be an eye's, or a field beside it.
        let failed = failed.or_else(|| BESIDE.iter().find_map(|field| wanted.remove(*field)));
        if failed.is_none() {
            return usual;
        }
    }
}

/// Takes a field that is at fault from what is wanted: from the eye that it is of, or from both where both
/// have it otherwise than the person; `None` where it is nowhere.
fn remove_fault(
    wanted: &mut Map<String, Value>,
    eye: Option<Laterality>,
    field: &str,
) -> Option<Value> {
    let of = |eye: Laterality| match eye {
        Laterality::OD => "right",
        Laterality::OS => "left",
    };
    let eyes = eye.map_or(Laterality::BOTH.to_vec(), |eye| vec![eye]);
    let own = |wanted: &Map<String, Value>, eye: &Laterality| {
        wanted
            .get(of(*eye))
            .is_some_and(|own| own.get(field).is_some())
    };
    if eyes.iter().all(|eye| own(wanted, eye)) {
        let mut removed = None;
        for eye in eyes {
            removed = wanted.get_mut(of(eye))?.as_object_mut()?.remove(field);
        }
        return removed;
    }
    wanted.remove(field)
}

/// Is it about a number that is infinite or none?
fn is_no_number(error: &PatientError) -> bool {
    let PatientError::OutOfRange { value, .. } = error else {
        return false;
    };
    value.contains("NaN") || value.contains("inf")
}

/// One field's value.
fn read(field: &str, value: &str) -> Result<Value, String> {
    let key = key_of(field);
    if !fields_of(&PatientFile::default()).contains_key(field) {
        return Err(format!("The link's key {key:?} is not known."));
    }
    if TEXTS.contains(&field) {
        return Ok(Value::String(value.into()));
    }
    let refuse = |reason: &str| format!("The link's {key} is {value:?}: {reason}.");
    match parse_unchecked(&format!("({field}: {value})"), "The link") {
        Ok(patient) => match patient.check("The link") {
            // JSON has no number for infinity and NaN, so these are told here; whatever else is out of
            // range is judged beside the other fields.
            Err(error @ PatientError::OutOfRange { .. }) if is_no_number(&error) => {
                Err(format!("{error}."))
            }
            _ => fields_of(&patient)
                .remove(field)
                .ok_or_else(|| refuse("it cannot be read")),
        },
        Err(PatientError::Kind {
            field: inner,
            value: found,
            allowed,
            ..
        }) => Err(if inner == field {
            format!("The link's {key} is {value:?}, but must be {allowed}.")
        } else {
            format!("The link's {inner} is {found:?}, but must be {allowed}.")
        }),
        Err(PatientError::Syntax { reason, .. }) => Err(refuse(&reason)),
        Err(error) => Err(format!("{error}.")),
    }
}
