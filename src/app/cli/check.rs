//! `check`: what there is to say of a patient file.

use crate::anatomy::Laterality;
use crate::input_file::one_clause;
use crate::patients::PatientFile;

/// As on a prescription: signed, with the axis where there is one.
fn prescription(eye: &PatientFile) -> String {
    let dioptres = |value: f64| {
        let sign = if value < 0.0 { "−" } else { "+" };
        format!("{sign}{:.2} D", value.abs())
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

/// What there is to say of a sound patient file: who it is, what either eye has, and what comes otherwise
/// than written.
pub(super) fn checked(patient: &PatientFile, file: &str) -> Vec<String> {
    let leading = match patient.eye {
        Laterality::OD => "right",
        Laterality::OS => "left",
    };
    let mut lines = vec![format!(
        "{file} is sound: {}, {} years; the {leading} eye leads.",
        one_clause(&patient.name),
        patient.age_years
    )];
    for (name, eye) in [("right", Laterality::OD), ("left", Laterality::OS)] {
        let own = patient.of_eye(eye);
        let mut parts = vec![prescription(&own), format!("{:?} iris", own.iris_color)];
        if own.lid_opening != 1.0 {
            parts.push(format!("lids open to {} of usual", own.lid_opening));
        }
        parts.extend(
            own.condition_captions()
                .into_iter()
                .map(|(_, caption)| caption.trim_end_matches('.').to_owned()),
        );
        lines.push(format!("{name} eye: {}.", parts.join("; ")));
    }
    lines.extend(
        patient
            .remarks()
            .into_iter()
            .map(|remark| format!("{remark}.")),
    );
    lines
}
