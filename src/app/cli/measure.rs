//! `measure`: a table into a file or onto standard output.

use super::arguments::{DEFAULT_PATIENT, MeasureArgs, Measured};
use super::sentences::{inform, say};
use crate::anatomy::{Laterality, MEASURED_PUPIL_MM, USUAL_PUPIL_MM};
use crate::lab::iris_picture::iris_pictures;
use crate::lab::looks::looks;
use crate::lab::measure::{MeasuredEye, measure};
use crate::output_file::{WriteError, prepare_folder, write_whole};
use crate::patients::{PatientFile, load_patient};
use std::error::Error;
use std::path::Path;

pub(super) fn measure_command(arguments: &MeasureArgs) -> Result<(), Box<dyn Error>> {
    let name = arguments.patient.as_deref();
    let mut patient = load_patient(name.unwrap_or(Path::new(DEFAULT_PATIENT)))?;
    if let Some(eye) = arguments.eye {
        patient.eye = eye.laterality();
    }
    if let Measured::Table(table) = arguments.table
        && !table.is_of_the_patient()
        && (name.is_some() || arguments.eye.is_some())
    {
        inform(&format!(
            "the table {} is of published eyes: --patient and --eye change nothing in it",
            table.name()
        ));
    }
    let measured = || -> Result<(&str, String), Box<dyn Error>> {
        Ok(match arguments.table {
            Measured::Table(table) => (table.name(), measure(table, &measured_eye(&patient))?),
            Measured::Looks => ("looks", serde_json::to_string_pretty(&looks(&patient)?)?),
            Measured::IrisPicture => {
                // Minutes of work, on a processor.
                let pictures = iris_pictures(&patient, |row, of, all| {
                    inform(&format!(
                        "iris-picture {of} of {all}: light {}, pupil {} mm, {}°",
                        row.light, row.pupil_mm, row.angle_deg
                    ));
                })?;
                ("iris-picture", serde_json::to_string_pretty(&pictures)?)
            }
        })
    };
    let Some(file) = &arguments.out else {
        return Ok(say(&mut std::io::stdout().lock(), &measured()?.1)?);
    };
    prepare_file(file)?;
    let (name, text) = measured()?;
    write_whole(file, (text + "\n").as_bytes())?;
    inform(&format!("{name} in {}", file.display()));
    Ok(())
}

/// Makes the folder of a file, and sees that the file can be written, before any work is spent on it.
fn prepare_file(file: &Path) -> Result<(), WriteError> {
    let refused = |reason: String| WriteError {
        path: file.display().to_string(),
        reason,
    };
    // Replacing a folder fails late; replacing a device would be worse.
    let other = std::fs::metadata(file).is_ok_and(|found| !found.is_file());
    if other || file.file_name().is_none() {
        return Err(refused("it is not a file".into()));
    }
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    prepare_folder(folder).map_err(|error| refused(error.reason))
}

/// What of a patient is measured: of her leading eye.
fn measured_eye(patient: &PatientFile) -> MeasuredEye {
    let (eye, cornea, iris, ..) = patient.eye_components(patient.eye);
    let magnification = cornea.pupil_magnification(iris.depth_mm);
    let held_mm = patient
        .pupil
        .diameter_mm()
        .map(|seen_mm| seen_mm / magnification);
    let pigment = iris.pigment();
    MeasuredEye {
        name: patient.name.clone(),
        right_eye: eye.laterality == Laterality::OD,
        age_years: patient.age_years,
        anterior_radius_mm: cornea.anterior_radius_mm,
        anterior_shape_factor: cornea.anterior_p,
        posterior_radius_mm: cornea.posterior_radius_mm,
        posterior_shape_factor: cornea.posterior_p,
        corneal_thickness_mm: cornea.thickness_mm,
        cornea_index: cornea.index,
        aqueous_index: cornea.aqueous_index,
        limbus_radius_mm: cornea.limbus_radius_mm,
        iris_depth_mm: iris.depth_mm,
        pupil_diameter_mm: held_mm.unwrap_or(USUAL_PUPIL_MM),
        pupil_nasal_mm: iris.pupil_decentration_mm[0],
        pupil_superior_mm: iris.pupil_decentration_mm[1],
        stroma_melanin_fraction: pigment.stroma_melanin_fraction,
        border_layer_melanin_fraction: pigment.border_layer_melanin_fraction,
        eumelanin_ratio: pigment.eumelanin_ratio,
        stroma_blood_fraction: pigment.stroma_blood_fraction,
        glare_pigment: iris.color.glare_pigment(),
        media_straylight_deg2_per_sr: patient
            .media(patient.eye)
            .straylight_through(MEASURED_PUPIL_MM),
        lipid_thickness_nm: cornea.lipid_thickness_nm,
    }
}
