//! `check`: what there is to say of a patient file.

use crate::anatomy::Laterality;
use crate::input_file::one_clause;
use crate::patients::{FIELDS, PatientFile};
use crate::stage::HeadPath;

/// As on a prescription: signed, two decimals at least and all that there are, with the axis where there is one.
fn prescription(eye: &PatientFile) -> String {
    let dioptres = |value: f64| {
        let sign = if value < 0.0 { "−" } else { "+" };
        let (usual, exact) = (format!("{:.2}", value.abs()), value.abs().to_string());
        let is_exact = usual.parse() == Ok(value.abs());
        format!("{sign}{} D", if is_exact { usual } else { exact })
    };
    let sphere = dioptres(eye.sphere_d);
    if eye.cylinder_d == 0.0 {
        return format!("{sphere} sphere");
    }
    format!(
        "{sphere} sphere, {} cylinder at {}°",
        dioptres(eye.cylinder_d),
        eye.axis_deg
    )
}

/// What is said in words of its own; the axis only where there is a cylinder.
const SAID: [&str; 4] = ["age_years", "sphere_d", "cylinder_d", "axis_deg"];

/// The numbers of a file whose eyes are alike that are not those of a file without them, of one eye or shared by
/// both, by name. An artist's are said by the file's remarks.
fn unusual(eye: &PatientFile, per_eye: bool) -> Vec<String> {
    let usual = PatientFile::default();
    let is_said = |name: &str| {
        let is_axis = name == "axis_deg" && eye.cylinder_d == 0.0;
        (SAID.contains(&name) && !is_axis) || name.starts_with("look_")
    };
    let numbers = FIELDS
        .iter()
        .filter(|field| field.index == 0 && field.per_eye == per_eye && !is_said(field.name));
    let mut said = Vec::new();
    if !per_eye && eye.seed != usual.seed {
        said.push(format!("seed {}", eye.seed));
    }
    for number in numbers {
        // Both of a pair are said together.
        let fields = || FIELDS.iter().filter(|field| field.name == number.name);
        if fields().all(|field| (field.get)(eye) == (field.get)(&usual)) {
            continue;
        }
        let values: Vec<_> = fields()
            .filter_map(|field| (field.get)(eye))
            // Plus nothing: minus nothing is nothing.
            .map(|value| (value + 0.0).to_string())
            .collect();
        if !values.is_empty() {
            let gap = if number.unit.starts_with(char::is_alphabetic) {
                " "
            } else {
                ""
            };
            said.push(format!(
                "{} {}{gap}{}",
                number.name,
                values.join(" and "),
                number.unit
            ));
        }
    }
    said
}

/// What there is to say of a sound patient file: who it is, what either eye has, and what comes otherwise
/// than written.
pub(super) fn checked(patient: &PatientFile, file: &str) -> Vec<String> {
    let leading = match patient.eye {
        Laterality::OD => "right",
        Laterality::OS => "left",
    };
    let years = if patient.age_years == 1.0 {
        "year"
    } else {
        "years"
    };
    let mut person = vec![format!("{} {years}", patient.age_years)];
    person.extend(unusual(patient, false));
    let mut lines = vec![format!(
        "{file} is sound: {}, {}; the {leading} eye leads.",
        one_clause(&patient.name),
        person.join("; ")
    )];
    let eyes = [Laterality::OD, Laterality::OS].map(|eye| {
        let own = patient.of_eye(eye);
        let mut parts = vec![prescription(&own), format!("{:?} iris", own.iris_color)];
        parts.extend(unusual(&own, true));
        parts.extend(
            own.condition_captions()
                .into_iter()
                .map(|(_, caption)| caption.trim_end_matches('.').to_owned()),
        );
        parts.join("; ")
    });
    match eyes {
        [right, left] if right == left => lines.push(format!("both eyes: {right}.")),
        [right, left] => {
            lines.push(format!("right eye: {right}."));
            lines.push(format!("left eye: {left}."));
        }
    }
    lines.extend(
        patient
            .remarks()
            .into_iter()
            .map(|remark| format!("{remark}.")),
    );
    lines
}

/// What there is to say of a sound head path.
pub(super) fn checked_path(path: &HeadPath, file: &str) -> String {
    let (moments, seconds) = (path.moments(), path.end_s());
    let moments = match moments {
        1 => "one moment".into(),
        many => format!("{many} moments"),
    };
    format!("{file} is sound: a head path of {moments}, {seconds} s long.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patients::parse_patient;

    #[test]
    fn every_number_that_is_not_the_usual_one_is_said_once() {
        let said = |text: &str| {
            let patient = parse_patient(text, "ann.ron").expect("sound");
            checked(&patient, "ann.ron").join("\n")
        };
        let plain = said("(name: \"Ann\")");
        assert!(
            plain.contains("ann.ron is sound: Ann, 30 years; the right eye leads.")
                && plain.contains("both eyes: +0.00 D sphere; Brown iris.")
        );
        let most = said(
            "(name: \"Ann\", voxel_mm: 5, redness: 0.4, seed: 9, angle_alpha_deg: (5.45, 3.0), left: (arcus: 0.5, sphere_d: -2, axis_deg: 20))",
        );
        for (words, times) in [
            ("voxel_mm 5 mm", 1),
            ("redness 0.4", 2),
            ("angle_alpha_deg 5.45 and 3°", 2),
            ("arcus 0.5", 1),
            ("−2.00 D sphere", 1),
            ("sphere_d", 0),
            ("axis_deg 20°", 1),
            ("seed 9", 1),
        ] {
            assert_eq!(most.matches(words).count(), times, "{words}: {most}");
        }
        for (text, words) in [
            ("(sphere_d: 0.001)", "+0.001 D sphere"),
            ("(sphere_d: -1.125)", "−1.125 D sphere"),
            ("(cataract: (nuclear: 0.04))", "nuclear 0.04"),
            (
                "(cataract: (log_s: 1.5, nuclear: 2, cortical: 4))",
                "1.5 log s, in the proportion of nuclear 2, cortical 4",
            ),
            (
                "(lid_opening: 0.5, ptosis: (mrd1_mm: 3))",
                "leave the margin at −0.4 mm",
            ),
        ] {
            assert!(said(text).contains(words), "{text}: {}", said(text));
        }
        // A field that nobody listed here is said too.
        let usual = PatientFile::default();
        for field in FIELDS.iter().filter(|field| !SAID.contains(&field.name)) {
            let mut patient = usual.clone();
            let (low, high) = field.range;
            let other = if (field.get)(&usual) == Some(high) {
                low
            } else {
                high
            };
            (field.set)(&mut patient, other);
            let lines = checked(&patient, "ann.ron").join("\n");
            assert!(lines.contains(field.name), "{}: {lines}", field.name);
        }
    }
}
