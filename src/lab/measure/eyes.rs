//! The published schematic eyes and their first-order constants.
//!
//! Leaves: one row an eye and state, by [`crate::optics::reference::paraxial`], at the wavelength for which the
//! eye was published, and its chromatic difference of refraction beside that of living eyes.

use super::{NullReasons, known};
use crate::optics::reference::chromatic::chromatic_difference_from;
use crate::optics::reference::paraxial::{Meridian, paraxial};
use crate::optics::schematic_eye::{GREEN_NM, PHOTOPIC_NM, SODIUM_NM, SchematicEye};
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "Navarro, Santamaría & Bescós 1985, J. Opt. Soc. Am. A 2, 1273",
    "Escudero-Sanz & Navarro 1999, J. Opt. Soc. Am. A 16, 1881",
    "Le Grand & El Hage 1980, Physiological Optics",
    "Gullstrand 1909, appendix to Helmholtz, Physiological Optics, 3rd edition",
    "Liou & Brennan 1997, J. Opt. Soc. Am. A 14, 1684",
    "Atchison 2006, Vision Res. 46, 2236",
    "François, Gautron, Breton & Bouatouch 2007 (one surface)",
    "Atchison & Smith 2000, Optics of the Human Eye, appendix 3 (published_power_d of Le Grand and \
     Gullstrand)",
    "Thibos, Ye, Zhang & Bradley 1992, Appl. Opt. 31, 3594 (thibos_1992_difference_d)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "Places (..._z_mm) count from the corneal apex, positive into the eye; all eyes here are \
     centred and the same in every meridian to first order.",
    "Focal lengths count from the principal points; magnifications of the pupils are relative to \
     the stop.",
    "refraction_d is the vergence at the corneal apex of light that comes to a focus on the \
     retina: negative in myopia and in an accommodated eye. far_point_z_mm is its reciprocal.",
    "retina_mm_per_degree is the chief ray's landing place for a distant object near the axis.",
    "chromatic: refraction_d at each wavelength and its difference from that at wavelength_nm, \
     beside the fit to living eyes of Thibos 1992.",
];

/// Wavelengths (nm) of the chromatic difference.
const CHROMATIC_NM: [f64; 8] = [400.0, 450.0, 486.1, 500.0, 550.0, 600.0, 656.3, 700.0];
/// A refraction smaller than this (D) puts the far point beyond a kilometre.
const SMALLEST_REFRACTION_D: f64 = 1e-3;

/// Refraction at another wavelength.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChromaticRow {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Refraction at the corneal apex (D).
    pub refraction_d: f64,
    /// Its difference from that at the eye's own wavelength (D).
    pub difference_d: f64,
    /// The same difference in living eyes (D).
    pub thibos_1992_difference_d: f64,
}

/// One eye in one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EyeRow {
    /// Whose eye.
    pub eye: &'static str,
    /// Its accommodation or refraction.
    pub state: &'static str,
    /// The wavelength for which it was published (nm).
    pub wavelength_nm: f64,
    /// Equivalent power (D).
    pub power_d: f64,
    /// The same as published (D).
    pub published_power_d: Option<f64>,
    /// P to F (mm), negative.
    pub front_focal_length_mm: f64,
    /// P′ to F′ (mm).
    pub back_focal_length_mm: f64,
    /// F (mm).
    pub front_focus_z_mm: f64,
    /// F′ (mm).
    pub back_focus_z_mm: f64,
    /// P (mm).
    pub front_principal_z_mm: f64,
    /// P′ (mm).
    pub back_principal_z_mm: f64,
    /// N (mm).
    pub front_nodal_z_mm: f64,
    /// N′ (mm).
    pub back_nodal_z_mm: f64,
    /// The stop (mm).
    pub stop_z_mm: f64,
    /// The stop as seen from the front (mm).
    pub entrance_pupil_z_mm: f64,
    /// Its size over that of the stop.
    pub entrance_pupil_magnification: f64,
    /// The stop as seen from the retina (mm).
    pub exit_pupil_z_mm: f64,
    /// Its size over that of the stop.
    pub exit_pupil_magnification: f64,
    /// Corneal apex to retina (mm).
    pub axial_length_mm: Option<f64>,
    /// Refraction at the corneal apex (D).
    pub refraction_d: Option<f64>,
    /// The far point (mm), negative in front of the eye.
    pub far_point_z_mm: Option<f64>,
    /// Retinal distance of a degree of visual field (mm).
    pub retina_mm_per_degree: Option<f64>,
    /// Refraction at other wavelengths.
    pub chromatic: Option<Vec<ChromaticRow>>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// An eye of the list.
struct Published {
    eye: &'static str,
    state: &'static str,
    wavelength_nm: f64,
    power_d: Option<f64>,
    /// Of one surface with one index: without retina and without dispersion.
    is_cornea: bool,
    at: fn(f64) -> SchematicEye,
}

const fn published(
    eye: &'static str,
    state: &'static str,
    wavelength_nm: f64,
    power_d: Option<f64>,
    at: fn(f64) -> SchematicEye,
) -> Published {
    Published {
        eye,
        state,
        wavelength_nm,
        power_d,
        is_cornea: false,
        at,
    }
}

const fn cornea(state: &'static str, at: fn(f64) -> SchematicEye) -> Published {
    Published {
        eye: "François 2007, one surface",
        state,
        wavelength_nm: PHOTOPIC_NM,
        power_d: None,
        is_cornea: true,
        at,
    }
}

#[rustfmt::skip]
const EYES: [Published; 17] = [
    published("Navarro 1985", "relaxed", SODIUM_NM, Some(60.416), |nm| SchematicEye::navarro(0.0, nm)),
    published("Navarro 1985", "accommodated by 2 D", SODIUM_NM, None, |nm| SchematicEye::navarro(2.0, nm)),
    published("Navarro 1985", "accommodated by 5 D", SODIUM_NM, None, |nm| SchematicEye::navarro(5.0, nm)),
    published("Navarro 1985", "accommodated by 10 D", SODIUM_NM, None, |nm| SchematicEye::navarro(10.0, nm)),
    published("Escudero-Sanz & Navarro 1999", "relaxed", GREEN_NM, None, SchematicEye::escudero_navarro),
    published("Le Grand", "relaxed", SODIUM_NM, Some(59.940), SchematicEye::le_grand),
    published("Le Grand", "accommodated", SODIUM_NM, Some(67.677), SchematicEye::le_grand_accommodated),
    published("Gullstrand No. 1", "relaxed", SODIUM_NM, Some(58.636), SchematicEye::gullstrand),
    published("Gullstrand No. 1", "accommodated", SODIUM_NM, Some(70.576), SchematicEye::gullstrand_accommodated),
    published("Liou & Brennan 1997", "relaxed", PHOTOPIC_NM, Some(60.35), SchematicEye::liou_brennan),
    published("Atchison 2006", "spectacle refraction 2 D", PHOTOPIC_NM, None, |nm| SchematicEye::atchison(2.0, nm)),
    published("Atchison 2006", "spectacle refraction 0 D", PHOTOPIC_NM, None, |nm| SchematicEye::atchison(0.0, nm)),
    published("Atchison 2006", "spectacle refraction -3 D", PHOTOPIC_NM, None, |nm| SchematicEye::atchison(-3.0, nm)),
    published("Atchison 2006", "spectacle refraction -6 D", PHOTOPIC_NM, None, |nm| SchematicEye::atchison(-6.0, nm)),
    published("Atchison 2006", "spectacle refraction -10 D", PHOTOPIC_NM, None, |nm| SchematicEye::atchison(-10.0, nm)),
    cornea("index 1.376 as printed", |_| SchematicEye::francois(1.376)),
    cornea("index 1.336, which stands in for both surfaces", |_| SchematicEye::francois(1.336)),
];

/// All eyes.
pub fn rows() -> Vec<EyeRow> {
    EYES.iter().map(row).collect()
}

fn row(of: &Published) -> EyeRow {
    let eye = (of.at)(of.wavelength_nm);
    let found = paraxial(&eye, Meridian::Vertical);
    let mut null_reasons = NullReasons::new();
    let mut behind_the_cornea = |key, value: f64| {
        let reason = "the paper gives a cornea and an iris plane, no retina";
        let value = (!of.is_cornea).then_some(value);
        known(&mut null_reasons, key, value, reason)
    };
    let axial_length_mm = behind_the_cornea("axial_length_mm", found.axial_length_mm);
    let refraction_d = behind_the_cornea("refraction_d", found.refraction_d);
    let per_degree = found.retina_mm_per_radian.to_radians();
    let retina_mm_per_degree = behind_the_cornea("retina_mm_per_degree", per_degree);
    let far_point_z_mm = known(
        &mut null_reasons,
        "far_point_z_mm",
        refraction_d
            .filter(|refraction| refraction.abs() >= SMALLEST_REFRACTION_D)
            .map(|_| found.far_point_z_mm()),
        if of.is_cornea {
            "the paper gives a cornea and an iris plane, no retina"
        } else {
            "emmetropic: the far point is beyond a kilometre"
        },
    );
    let published_power_d = known(
        &mut null_reasons,
        "published_power_d",
        of.power_d,
        "no published power of this state is known here",
    );
    let chromatic = refraction_d.map(|reference| chromatic(of, reference));
    if chromatic.is_none() {
        let reason = "one index for all wavelengths, and no retina";
        null_reasons.insert("chromatic", reason.into());
    }
    EyeRow {
        eye: of.eye,
        state: of.state,
        wavelength_nm: of.wavelength_nm,
        power_d: found.power_d,
        published_power_d,
        front_focal_length_mm: found.front_focus_z_mm - found.principal_z_mm[0],
        back_focal_length_mm: found.back_focus_z_mm - found.principal_z_mm[1],
        front_focus_z_mm: found.front_focus_z_mm,
        back_focus_z_mm: found.back_focus_z_mm,
        front_principal_z_mm: found.principal_z_mm[0],
        back_principal_z_mm: found.principal_z_mm[1],
        front_nodal_z_mm: found.nodal_z_mm[0],
        back_nodal_z_mm: found.nodal_z_mm[1],
        stop_z_mm: eye.stop_z_mm(),
        entrance_pupil_z_mm: found.entrance_pupil.z_mm,
        entrance_pupil_magnification: found.entrance_pupil.magnification,
        exit_pupil_z_mm: found.exit_pupil.z_mm,
        exit_pupil_magnification: found.exit_pupil.magnification,
        axial_length_mm,
        refraction_d,
        far_point_z_mm,
        retina_mm_per_degree,
        chromatic,
        null_reasons,
    }
}

fn chromatic(of: &Published, reference_d: f64) -> Vec<ChromaticRow> {
    CHROMATIC_NM
        .map(|wavelength_nm| {
            let found = paraxial(&(of.at)(wavelength_nm), Meridian::Vertical);
            ChromaticRow {
                wavelength_nm,
                refraction_d: found.refraction_d,
                difference_d: found.refraction_d - reference_d,
                thibos_1992_difference_d: chromatic_difference_from(
                    wavelength_nm,
                    of.wavelength_nm,
                ),
            }
        })
        .into()
}
