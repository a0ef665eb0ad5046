//! Tables of what [`crate::optics`] and [`crate::tissue`] compute, for `ocularium measure`.
//!
//! In: which table ([`MeasureTable`]), and for some an eye as plain numbers ([`MeasuredEye`]). Out:
//! one JSON object, the same bytes each time: `table`, `version`, `meaning`, `source` (citations),
//! `notes` (conventions, units, ranges), `patient` where the table depends on one, and `rows`.
//! Units stand in the keys. A number that does not exist is `null`, and `null_reasons` beside it says
//! why; nothing else is ever `null`.
//!
//! Free of Bevy and of the patient file: the command line turns a patient into a [`MeasuredEye`].

pub mod blur_disc;
pub mod eyes;
pub mod glare;
pub mod mtf;
pub mod parallax_error;
pub mod pupil_ratio;
pub mod refraction_function;
pub mod tear_film;
pub mod tissue;

use crate::tissue::iris_reflectance::IrisPigment;
use glam::DVec2;
use serde::Serialize;
use std::collections::BTreeMap;

/// How much work a table is worth.
#[derive(Clone, Copy)]
struct Effort {
    /// Random pairs of the refraction function, within its domain.
    refraction_pairs: usize,
    /// Random walks in an iris, for each wavelength.
    walks: u32,
    /// Pupils of the modulation transfer (mm).
    mtf_pupils_mm: &'static [f64],
}

/// What the command line shows.
const WHOLE: Effort = Effort {
    refraction_pairs: 1_000_000,
    walks: 50_000,
    mtf_pupils_mm: &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
};

/// What can be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureTable {
    /// First-order constants of the published schematic eyes.
    Eyes,
    /// The pupil as it looks from the side.
    PupilRatio,
    /// Where the iris is seen, by simpler pictures of a cornea.
    ParallaxError,
    /// Error of the precomputed refraction function, and the caustic.
    RefractionFunction,
    /// The traced blur of a point beside the simple formula.
    BlurDisc,
    /// Modulation transfer of the eye.
    Mtf,
    /// Scatter in the eye's media.
    Glare,
    /// Spectra of the iris's tissue and the colours they make.
    Tissue,
    /// Reflection of the tear film.
    TearFilm,
}

impl MeasureTable {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 9] = [
        Self::Eyes,
        Self::PupilRatio,
        Self::ParallaxError,
        Self::RefractionFunction,
        Self::BlurDisc,
        Self::Mtf,
        Self::Glare,
        Self::Tissue,
        Self::TearFilm,
    ];

    /// The name on the command line, and `table` in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eyes => "eyes",
            Self::PupilRatio => "pupil-ratio",
            Self::ParallaxError => "parallax-error",
            Self::RefractionFunction => "refraction-function",
            Self::BlurDisc => "blur-disc",
            Self::Mtf => "mtf",
            Self::Glare => "glare",
            Self::Tissue => "tissue",
            Self::TearFilm => "tear-film",
        }
    }

    /// What it holds, in which units and over which ranges.
    pub fn description(self) -> &'static str {
        match self {
            Self::Eyes => {
                "Published schematic eyes: power (D), cardinal points and pupils (mm from the corneal \
                 apex), axial length (mm), refraction (D), chromatic difference (D) at 400 to 700 nm"
            }
            Self::PupilRatio => {
                "The patient's pupil as it looks: width, height, shift (mm) and ratio at viewing \
                 angles of -80 to 80 degrees in steps of 5, horizontal and vertical, beside the \
                 measured fit of Mathur 2013; pupil as the patient's file holds it, or 4 mm"
            }
            Self::ParallaxError => {
                "Error of the place on the iris that is seen through the patient's cornea, per cent of the \
                 limbus radius, from 0 to 60 degrees: painted on, by parallax mapping, and refracted at a \
                 sphere, at one surface and at both, beside real rays"
            }
            Self::RefractionFunction => {
                "Precomputed refraction through the patient's cornea: bytes and error (mm at the \
                 cornea) over 1,000,000 random pairs, before and after polishing, up to 80 degrees of \
                 exit incidence and in the rim beyond; peak of the caustic at lights 0 to 85 degrees \
                 off the axis"
            }
            Self::BlurDisc => {
                "Blur (arcmin) of a point by real rays through Navarro's eye and by the simple \
                 formula: distances 0.05 m to infinity, pupils 1 to 8 mm, accommodation 0 to 8 D"
            }
            Self::Mtf => {
                "Modulation transfer, 0 to 1, of the mean eye (Watson 2013), of diffraction and of a \
                 traced eye: pupils 1 to 7 mm, 0 to 60 cycles/degree"
            }
            Self::Glare => {
                "CIE glare function (1/sr), as published and normalised, straylight and integral: \
                 angles 0.01 to 90 degrees, ages 20 to 80 years, pigment 0 to 1.2, and the patient's \
                 own age, pigment and clouded media"
            }
            Self::Tissue => {
                "Absorption and scattering (1/mm) at 380 to 780 nm, reflectance and sRGB of irises by \
                 melanin, share of light scattered once with its standard error; presets and the \
                 patient's own iris"
            }
            Self::TearFilm => {
                "Reflectance, 0 to 1, and sRGB of the tear film: lipid 0 to 200 nm and the patient's \
                 own, 400 to 700 nm, incidence 0 to 80 degrees"
            }
        }
    }

    /// Whether the table depends on the patient.
    pub fn is_of_the_patient(self) -> bool {
        match self {
            Self::PupilRatio
            | Self::ParallaxError
            | Self::RefractionFunction
            | Self::Glare
            | Self::Tissue
            | Self::TearFilm => true,
            Self::Eyes | Self::BlurDisc | Self::Mtf => false,
        }
    }
}

/// A patient's eye as plain numbers. Every number finite and in the range of the patient file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredEye {
    /// Whose.
    pub name: String,
    /// Right eye, whose nose is towards −x; otherwise the left.
    pub right_eye: bool,
    /// Age (years).
    pub age_years: f64,
    /// Apical radius of the anterior cornea (mm).
    pub anterior_radius_mm: f64,
    /// Its shape factor p = 1 + Q.
    pub anterior_shape_factor: f64,
    /// Apical radius of the posterior cornea (mm).
    pub posterior_radius_mm: f64,
    /// Its shape factor.
    pub posterior_shape_factor: f64,
    /// Central thickness of the cornea (mm).
    pub corneal_thickness_mm: f64,
    /// Index of the cornea.
    pub cornea_index: f64,
    /// Index of the aqueous.
    pub aqueous_index: f64,
    /// Radius of the limbus (mm).
    pub limbus_radius_mm: f64,
    /// Plane of the iris behind the corneal apex (mm).
    pub iris_depth_mm: f64,
    /// Diameter of the real pupil (mm).
    pub pupil_diameter_mm: f64,
    /// Decentration of the pupil towards the nose (mm).
    pub pupil_nasal_mm: f64,
    /// Decentration of the pupil upwards (mm).
    pub pupil_superior_mm: f64,
    /// Volume fraction of melanin in the iris's stroma, 0 to 1.
    pub stroma_melanin_fraction: f64,
    /// The same in its anterior border layer.
    pub border_layer_melanin_fraction: f64,
    /// Eumelanin in all melanin, 0 to 1.
    pub eumelanin_ratio: f64,
    /// Volume fraction of blood in the stroma, 0 to 0.5.
    pub stroma_blood_fraction: f64,
    /// Pigmentation of the CIE's glare function: 0 black, 0.5 brown, 1 green, 1.2 light blue.
    pub glare_pigment: f64,
    /// Straylight parameter at 7° of clouded media, beyond a healthy eye's (deg² sr⁻¹).
    pub media_straylight_deg2_per_sr: f64,
    /// Lipid layer of the tear film (nm).
    pub lipid_thickness_nm: f64,
}

impl Default for MeasuredEye {
    /// The eye of an empty patient file.
    fn default() -> Self {
        let brown = IrisPigment::BROWN;
        Self {
            name: "Unnamed".into(),
            right_eye: true,
            age_years: 30.0,
            anterior_radius_mm: 7.8,
            anterior_shape_factor: 0.75,
            posterior_radius_mm: 6.4,
            posterior_shape_factor: 0.725,
            corneal_thickness_mm: 0.55,
            cornea_index: 1.376,
            aqueous_index: 1.336,
            limbus_radius_mm: 5.85,
            iris_depth_mm: 3.6,
            pupil_diameter_mm: 4.0,
            pupil_nasal_mm: 0.2,
            pupil_superior_mm: 0.0,
            stroma_melanin_fraction: brown.stroma_melanin_fraction,
            border_layer_melanin_fraction: brown.border_layer_melanin_fraction,
            eumelanin_ratio: brown.eumelanin_ratio,
            stroma_blood_fraction: brown.stroma_blood_fraction,
            glare_pigment: 0.5,
            media_straylight_deg2_per_sr: 0.0,
            lipid_thickness_nm: 55.0,
        }
    }
}

impl MeasuredEye {
    /// The anterior cornea as (apical radius in mm, shape factor).
    pub fn anterior(&self) -> DVec2 {
        DVec2::new(self.anterior_radius_mm, self.anterior_shape_factor)
    }

    /// The posterior cornea likewise.
    pub fn posterior(&self) -> DVec2 {
        DVec2::new(self.posterior_radius_mm, self.posterior_shape_factor)
    }

    /// Centre of the pupil (mm) along +x, the patient's right, and +y, up.
    pub fn pupil_centre_mm(&self) -> DVec2 {
        let nose = if self.right_eye { -1.0 } else { 1.0 };
        DVec2::new(nose * self.pupil_nasal_mm, self.pupil_superior_mm)
    }

    /// Pigment of the iris.
    pub fn pigment(&self) -> IrisPigment {
        IrisPigment {
            stroma_melanin_fraction: self.stroma_melanin_fraction,
            border_layer_melanin_fraction: self.border_layer_melanin_fraction,
            eumelanin_ratio: self.eumelanin_ratio,
            stroma_blood_fraction: self.stroma_blood_fraction,
        }
    }
}

/// Why a number is `null`, by its key.
pub type NullReasons = BTreeMap<&'static str, String>;

/// `value`, or a note under `key` why it does not exist; what is not finite does not.
fn known(
    reasons: &mut NullReasons,
    key: &'static str,
    value: Option<f64>,
    reason: &str,
) -> Option<f64> {
    // Adding 0 makes a 0 of −0.
    let value = value.filter(|value| value.is_finite()).map(|v| v + 0.0);
    if value.is_none() {
        reasons.insert(key, reason.to_owned());
    }
    value
}

/// What all tables have in common, and the rows of one.
#[derive(Serialize)]
struct Report<'a, Body> {
    table: &'static str,
    version: &'static str,
    meaning: &'static str,
    source: &'a [&'a str],
    notes: &'a [&'a str],
    #[serde(skip_serializing_if = "Option::is_none")]
    patient: Option<&'a MeasuredEye>,
    #[serde(flatten)]
    body: Body,
}

/// Rows alone.
#[derive(Serialize)]
struct Rows<Row> {
    rows: Vec<Row>,
}

/// The table as pretty JSON without a last line feed. `eye` matters where
/// [`MeasureTable::is_of_the_patient`]. At most some seconds.
///
/// # Errors
/// None that the tables can cause; those of the serializer are passed on.
pub fn measure(table: MeasureTable, eye: &MeasuredEye) -> serde_json::Result<String> {
    measure_with(table, eye, WHOLE)
}

fn measure_with(
    table: MeasureTable,
    eye: &MeasuredEye,
    effort: Effort,
) -> serde_json::Result<String> {
    match table {
        MeasureTable::Eyes => {
            let rows = eyes::rows();
            text(table, eye, eyes::SOURCE, eyes::NOTES, Rows { rows })
        }
        MeasureTable::PupilRatio => {
            let rows = pupil_ratio::rows(eye);
            let (source, notes) = (pupil_ratio::SOURCE, pupil_ratio::NOTES);
            text(table, eye, source, notes, Rows { rows })
        }
        MeasureTable::ParallaxError => {
            let rows = parallax_error::rows(eye);
            let (source, notes) = (parallax_error::SOURCE, parallax_error::NOTES);
            text(table, eye, source, notes, Rows { rows })
        }
        MeasureTable::RefractionFunction => {
            let body = refraction_function::measure_pairs(eye, effort.refraction_pairs);
            let (source, notes) = (refraction_function::SOURCE, refraction_function::NOTES);
            text(table, eye, source, notes, body)
        }
        MeasureTable::BlurDisc => {
            let rows = blur_disc::rows();
            text(
                table,
                eye,
                blur_disc::SOURCE,
                blur_disc::NOTES,
                Rows { rows },
            )
        }
        MeasureTable::Mtf => {
            let rows = mtf::rows(effort.mtf_pupils_mm);
            text(table, eye, mtf::SOURCE, mtf::NOTES, Rows { rows })
        }
        MeasureTable::Glare => {
            let body = glare::table(eye);
            text(table, eye, glare::SOURCE, glare::NOTES, body)
        }
        MeasureTable::Tissue => {
            let body = tissue::table(eye, effort.walks);
            text(table, eye, tissue::SOURCE, tissue::NOTES, body)
        }
        MeasureTable::TearFilm => {
            let rows = tear_film::rows(eye);
            text(
                table,
                eye,
                tear_film::SOURCE,
                tear_film::NOTES,
                Rows { rows },
            )
        }
    }
}

fn text<Body: Serialize>(
    table: MeasureTable,
    eye: &MeasuredEye,
    source: &[&str],
    notes: &[&str],
    body: Body,
) -> serde_json::Result<String> {
    serde_json::to_string_pretty(&Report {
        table: table.name(),
        version: env!("CARGO_PKG_VERSION"),
        meaning: table.description(),
        source,
        notes,
        patient: table.is_of_the_patient().then_some(eye),
        body,
    })
}

#[cfg(test)]
mod tests;
