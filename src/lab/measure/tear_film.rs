//! Reflection of the tear film by thickness of its lipid layer, wavelength and incidence
//! ([`crate::optics::tear_film`]).
//!
//! In: an eye's lipid layer. Leaves: one row a thickness and angle of incidence.

use super::MeasuredEye;
use crate::optics::fresnel::{LIPID_INDEX, TEAR_INDEX, fresnel_thin_film};
use crate::optics::output::linear_to_srgb;
use crate::optics::tear_film::{TearFilm, tear_film_rgb, tear_film_rgb_exact};
use glam::DVec3;
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "Born & Wolf, Principles of Optics, sections 1.5.2 and 7.6.1 (Airy's sum over the reflections \
     of a film)",
    "Patel, Marshall & Fitzke 1995, J. Refract. Surg. 11, 100 (epithelium 1.401)",
    "Atchison & Smith 2005, J. Opt. Soc. Am. A 22, 29 (dispersion of the tears)",
    "CIE 1931 observer, D65, IEC 61966-2-1 (colours)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "Reflectances are those of unpolarised light, 0 to 1.",
    "lipid_reflectance: lipid of index 1.48 over tears of index 1.337, without dispersion. \
     film_reflectance: the same over dispersing tears 3 µm thick and epithelium of index 1.401, \
     fringes of the aqueous layer averaged.",
    "linear_srgb is exact for the lipid layer (41 wavelengths); shader_linear_srgb is the \
     four-wavelength form of the shader; film_linear_srgb that of the whole film. A perfect mirror \
     has (1, 1, 1). hue_srgb is linear_srgb scaled to a largest channel of 1 and encoded: the \
     colour without its brightness.",
    "Living films: lipid 20 to 120 nm, 41 to 67 on average; aqueous layer 3 to 5 µm.",
];

const WAVELENGTHS_NM: [f64; 7] = [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0];
const INCIDENCES_DEG: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
/// Steps of the thickness (nm), and how many.
const STEP_NM: f64 = 10.0;
const STEPS: i32 = 20;
const AQUEOUS_NM: f64 = 3000.0;

/// One wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FilmReflectance {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Of the lipid layer over tears.
    pub lipid_reflectance: f64,
    /// Of the whole film.
    pub film_reflectance: f64,
}

/// One thickness and angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TearFilmRow {
    /// `grid`, or `patient`.
    pub of: &'static str,
    /// Thickness of the lipid layer (nm).
    pub lipid_thickness_nm: f64,
    /// Angle of incidence (degrees).
    pub incidence_deg: f64,
    /// Reflectances.
    pub spectrum: [FilmReflectance; WAVELENGTHS_NM.len()],
    /// Colour of the lipid layer's reflection, exactly.
    pub linear_srgb: [f64; 3],
    /// The same by the shader's form.
    pub shader_linear_srgb: [f64; 3],
    /// Colour of the whole film's reflection.
    pub film_linear_srgb: [f64; 3],
    /// Colour without brightness, encoded.
    pub hue_srgb: [f64; 3],
}

/// Every tenth nanometre and the patient's own.
pub fn rows(eye: &MeasuredEye) -> Vec<TearFilmRow> {
    let grid = (0..=STEPS).map(|step| ("grid", STEP_NM * f64::from(step)));
    grid.chain([("patient", eye.lipid_thickness_nm)])
        .flat_map(|(of, lipid_nm)| INCIDENCES_DEG.map(|angle| row(of, lipid_nm, angle)))
        .collect()
}

fn row(of: &'static str, lipid_nm: f64, incidence_deg: f64) -> TearFilmRow {
    let cos = incidence_deg.to_radians().cos();
    let film = TearFilm {
        lipid_nm,
        aqueous_nm: AQUEOUS_NM,
    };
    let exact = tear_film_rgb_exact(cos, LIPID_INDEX, TEAR_INDEX, lipid_nm);
    TearFilmRow {
        of,
        lipid_thickness_nm: lipid_nm,
        incidence_deg,
        spectrum: WAVELENGTHS_NM.map(|wavelength_nm| FilmReflectance {
            wavelength_nm,
            lipid_reflectance: fresnel_thin_film(
                cos,
                LIPID_INDEX,
                TEAR_INDEX,
                lipid_nm,
                wavelength_nm,
            ),
            film_reflectance: film.reflectance(cos, wavelength_nm),
        }),
        linear_srgb: exact.to_array(),
        shader_linear_srgb: tear_film_rgb(cos, LIPID_INDEX, TEAR_INDEX, lipid_nm).to_array(),
        film_linear_srgb: film.rgb(cos).to_array(),
        hue_srgb: hue(exact).to_array(),
    }
}

/// A colour scaled to a largest channel of 1, encoded as sRGB.
fn hue(linear: DVec3) -> DVec3 {
    linear_to_srgb(linear / linear.max_element().max(f64::MIN_POSITIVE))
}
