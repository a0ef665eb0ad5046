//! The patient file: RON, every field optional, units in the names, checked on reading.
//!
//! Enters: text. Leaves: a [`PatientFile`] whose every number is finite and in
//! the range that its documentation states, or one sentence that says which
//! field is wrong, what it holds and what is allowed.

use super::components::Laterality;
use crate::input_file::{one_clause, read_input_file};
use crate::optics::globe::GlobeShape;
use crate::tissue::iris_reflectance::IrisPigment;
use serde::{Deserialize, Serialize};
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
    #[error("{file}: {field} = {value} is out of range; allowed: {allowed}")]
    OutOfRange {
        /// The file.
        file: String,
        /// The field.
        field: &'static str,
        /// What it holds.
        value: String,
        /// What may stand there.
        allowed: String,
    },
}

/// Colour class of the iris: how much melanin, and of which kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum IrisColor {
    /// Almost no melanin in stroma and border layer: the colour is scattering alone.
    Blue,
    /// A little, mostly pheomelanin, in the border layer.
    Green,
    /// Dense eumelanin in both.
    #[default]
    Brown,
}

impl IrisColor {
    /// (stroma fraction, border-layer fraction, eumelanin ratio) of this class.
    pub(super) fn pigment(self) -> (f64, f64, f64) {
        let pigment = match self {
            Self::Blue => IrisPigment::BLUE,
            Self::Green => IrisPigment::GREEN,
            Self::Brown => IrisPigment::BROWN,
        };
        (
            pigment.stroma_melanin_fraction,
            pigment.border_layer_melanin_fraction,
            pigment.eumelanin_ratio,
        )
    }
}

/// How the pupil is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum PupilSetting {
    /// By light, age and the near response (Watson & Yellott 2012).
    #[default]
    Auto,
    /// Held at this diameter in mm, 1 to 9.
    Fixed(f64),
}

impl PupilSetting {
    /// The held diameter, if it is held.
    pub fn diameter_mm(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Fixed(diameter_mm) => Some(diameter_mm),
        }
    }
}

/// Stage of glaucoma after Hodapp, Parrish and Anderson, by mean deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GlaucomaStage {
    /// Mean deviation better than −6 dB.
    Early,
    /// −6 to −12 dB.
    Moderate,
    /// Worse than −12 dB.
    Severe,
}

/// A patient as written in a file. Lengths in mm, powers in D, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PatientFile {
    /// Name shown to the user.
    pub name: String,
    /// One sentence about this patient.
    pub description: String,
    /// Which eye is shown.
    pub eye: Laterality,
    /// Age, 1 to 110 years.
    pub age_years: f64,
    /// Colour class of the iris; the three fractions below override it.
    pub iris_color: IrisColor,
    /// Volume fraction of melanin in the stroma, 0 to 0.5.
    pub stroma_melanin_fraction: Option<f64>,
    /// Volume fraction of melanin in the anterior border layer, 0 to 0.5.
    pub border_layer_melanin_fraction: Option<f64>,
    /// Eumelanin to all melanin, 0 to 1.
    pub eumelanin_ratio: Option<f64>,
    /// Seed of iris fibres and scleral vessels.
    pub seed: u64,
    /// Pupil: `Auto` or `Fixed(mm)`, 1 to 9 mm.
    pub pupil: PupilSetting,
    /// Decentration of the pupil (nasal, superior), −1 to 1 mm.
    pub pupil_decentration_mm: [f64; 2],
    /// Sphere of the refractive error, −20 to 20 D.
    pub sphere_d: f64,
    /// Cylinder, −10 to 10 D.
    pub cylinder_d: f64,
    /// Axis of the cylinder, 0 to 180 degrees.
    pub axis_deg: f64,
    /// Amplitude of accommodation, 0 to 20 D; by age (Hofstetter's mean) where it is not given.
    pub accommodation_amplitude_d: Option<f64>,
    /// Apical radius of the anterior cornea, 6 to 10 mm (François: 7.8).
    pub cornea_radius_mm: f64,
    /// Shape factor p = 1 + Q of the anterior cornea, 0.2 to 1.5 (François: 0.75).
    pub cornea_p: f64,
    /// Apical radius of the posterior cornea, 5 to 9 mm.
    pub cornea_posterior_radius_mm: f64,
    /// Shape factor of the posterior cornea, 0.2 to 1.5.
    pub cornea_posterior_p: f64,
    /// Central thickness of the cornea, 0.3 to 0.9 mm.
    pub cornea_thickness_mm: f64,
    /// Radius of the limbus, 5 to 6.5 mm.
    pub limbus_radius_mm: f64,
    /// Depth of the iris behind the corneal apex, 2.5 to 4.5 mm.
    pub iris_depth_mm: f64,
    /// Radius of the scleral sphere, 10.5 to 12.5 mm.
    pub scleral_radius_mm: f64,
    /// Lipid layer of the tear film, 0 to 200 nm.
    pub lipid_thickness_nm: f64,
    /// Redness of the conjunctiva, 0 to 1.
    pub redness: f64,
    /// Skin tone, 0 (very light) to 1 (very dark).
    pub skin_tone: f64,
    /// Glaucoma, if the patient has it.
    pub glaucoma: Option<GlaucomaStage>,
    /// Starving rate of the visual memory, 0 to 10 per second.
    pub starve_rate_per_s: f64,
    /// Voxel of the sharpness field, 1 to 1000 mm.
    pub voxel_mm: f64,
    /// Largest blur shown, 10 to 600 arcmin of visual angle.
    pub blur_cap_arcmin: f64,
}

impl Default for PatientFile {
    fn default() -> Self {
        Self {
            name: "Unnamed".into(),
            description: String::new(),
            eye: Laterality::OD,
            age_years: 30.0,
            iris_color: IrisColor::Brown,
            stroma_melanin_fraction: None,
            border_layer_melanin_fraction: None,
            eumelanin_ratio: None,
            seed: 1,
            pupil: PupilSetting::Auto,
            pupil_decentration_mm: [0.2, 0.0],
            sphere_d: 0.0,
            cylinder_d: 0.0,
            axis_deg: 0.0,
            accommodation_amplitude_d: None,
            cornea_radius_mm: 7.8,
            cornea_p: 0.75,
            cornea_posterior_radius_mm: 6.4,
            cornea_posterior_p: 0.725,
            cornea_thickness_mm: 0.55,
            limbus_radius_mm: 5.85,
            iris_depth_mm: 3.6,
            scleral_radius_mm: 11.5,
            lipid_thickness_nm: 55.0,
            redness: 0.12,
            skin_tone: 0.3,
            glaucoma: None,
            starve_rate_per_s: 0.45,
            voxel_mm: 10.0,
            blur_cap_arcmin: 120.0,
        }
    }
}

impl PatientFile {
    /// Sphere plus half the cylinder, D.
    pub fn spherical_equivalent_d(&self) -> f64 {
        self.sphere_d + 0.5 * self.cylinder_d
    }

    /// Amplitude of accommodation, D: as given, or by age.
    pub fn amplitude_d(&self) -> f64 {
        self.accommodation_amplitude_d
            .unwrap_or_else(|| crate::motion::accommodation::hofstetter_amplitude_d(self.age_years))
    }

    /// Every numeric field with its name and allowed range.
    fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let mut ranges = vec![
            ("age_years", self.age_years, 1.0, 110.0),
            (
                "pupil_decentration_mm",
                self.pupil_decentration_mm[0],
                -1.0,
                1.0,
            ),
            (
                "pupil_decentration_mm",
                self.pupil_decentration_mm[1],
                -1.0,
                1.0,
            ),
            ("sphere_d", self.sphere_d, -20.0, 20.0),
            ("cylinder_d", self.cylinder_d, -10.0, 10.0),
            ("axis_deg", self.axis_deg, 0.0, 180.0),
            ("cornea_radius_mm", self.cornea_radius_mm, 6.0, 10.0),
            ("cornea_p", self.cornea_p, 0.2, 1.5),
            (
                "cornea_posterior_radius_mm",
                self.cornea_posterior_radius_mm,
                5.0,
                9.0,
            ),
            ("cornea_posterior_p", self.cornea_posterior_p, 0.2, 1.5),
            ("cornea_thickness_mm", self.cornea_thickness_mm, 0.3, 0.9),
            ("limbus_radius_mm", self.limbus_radius_mm, 5.0, 6.5),
            ("iris_depth_mm", self.iris_depth_mm, 2.5, 4.5),
            ("scleral_radius_mm", self.scleral_radius_mm, 10.5, 12.5),
            ("lipid_thickness_nm", self.lipid_thickness_nm, 0.0, 200.0),
            ("redness", self.redness, 0.0, 1.0),
            ("skin_tone", self.skin_tone, 0.0, 1.0),
            ("starve_rate_per_s", self.starve_rate_per_s, 0.0, 10.0),
            ("voxel_mm", self.voxel_mm, 1.0, 1000.0),
            ("blur_cap_arcmin", self.blur_cap_arcmin, 10.0, 600.0),
        ];
        let optional = [
            (
                "stroma_melanin_fraction",
                self.stroma_melanin_fraction,
                0.0,
                0.5,
            ),
            (
                "border_layer_melanin_fraction",
                self.border_layer_melanin_fraction,
                0.0,
                0.5,
            ),
            ("eumelanin_ratio", self.eumelanin_ratio, 0.0, 1.0),
            (
                "accommodation_amplitude_d",
                self.accommodation_amplitude_d,
                0.0,
                20.0,
            ),
            ("pupil", self.pupil.diameter_mm(), 1.0, 9.0),
        ];
        ranges.extend(
            optional
                .into_iter()
                .filter_map(|(name, value, low, high)| value.map(|value| (name, value, low, high))),
        );
        ranges
    }

    /// Checks every number against its range; `file` names the source in the error.
    pub fn check(&self, file: &str) -> Result<(), PatientError> {
        for (field, value, low, high) in self.ranges() {
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                return Err(PatientError::OutOfRange {
                    file: file.into(),
                    field,
                    value: format!("{value}"),
                    allowed: format!("{low} to {high}"),
                });
            }
        }
        self.check_text(file)?;
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
        for preset in crate::anatomy::PRESETS {
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
