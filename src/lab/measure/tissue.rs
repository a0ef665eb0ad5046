//! The tissue of the iris: its spectra, the colours they make by melanin, and how much of the light
//! has been scattered once ([`crate::tissue`]).
//!
//! In: an eye's pigment. Leaves: reflectance and colour by melanin and for named irises with the
//! patient's own, coefficients by wavelength, shares of single scattering with standard errors.

use super::MeasuredEye;
use crate::optics::output::linear_to_srgb;
use crate::tissue::iris_layers::reduced_layers;
use crate::tissue::iris_reflectance::{
    BORDER_LAYER_MM, IRIS_WAVELENGTHS, IrisPigment, STROMA_BLOOD, iris_reflectance,
    iris_reflectance_many_flux, iris_reflectance_seen, iris_reflectance_spectrum,
};
use crate::tissue::melanin::{PHEOMELANIN_DILUTE, TissueCoefficients, pheomelanin_absorption};
use crate::tissue::scattering_orders::{IrisScattering, iris_scattering};
use crate::tissue::spectrum::{FIRST_NM, SAMPLES, STEP_NM};
use crate::tissue::wavelengths::Wavelengths;
use glam::DVec3;
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "François, Gautron, Breton & Bouatouch 2007, equations 10 to 14 (coefficients)",
    "Donner & Jensen 2006, A Spectral BSSRDF for Shading Human Skin; Jacques 1998, Oregon Medical \
     Laser Center News (whence they come)",
    "Kubelka & Munk; van Gemert & Star 1987 (two-flux); Wiscombe 1976, 1977 (many-flux)",
    "CIE 1931 observer, D65, IEC 61966-2-1 (colours)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "An iris: border layer 0.04 mm thick at half of its greatest density (0.5), stroma 0.45 mm \
     thick, black epithelium. Diffuse light in and out. Strengths of scattering in the iris and the \
     melanin of the colour classes are calibrated to photographs, not measured.",
    "stroma_blood_fraction is the volume fraction of blood in the stroma, 0.02 in rows; it is calibrated too. \
     blood_absorption_per_mm is that of vessels of 0.02 mm, for a volume of one (Prahl 1999).",
    "rows: melanin_fraction is the volume fraction in the stroma; the border layer holds ten times \
     as much, at most 0.5. eumelanin_ratio is its share of eumelanin. stroma_albedo is scattering \
     over extinction at the wavelength; reflectance the iris's diffuse albedo, by two fluxes.",
    "linear_srgb is by two fluxes, many_flux_linear_srgb by all orders of scattering, both in diffuse light; \
     seen_linear_srgb is what the picture shows, lit and seen within the critical angle of the aqueous; \
     srgb is linear_srgb encoded, 0 to 1.",
    "coefficients: 1/mm. pheomelanin_absorption_dilute_per_mm reads the printed constant per cm.",
    "scattering: luminances relative to a white surface. single_share is light scattered exactly \
     once over light scattered any number of times by random walks, with the standard error (one \
     standard deviation) that the walks leave; single_share_many_flux the same without noise; \
     two_flux_error and similarity_error are errors of luminance of the two-flux estimate and of \
     reduced isotropic scattering.",
];

/// Thickness of the stroma (mm) and density of the border layer of the table's irises.
const STROMA_MM: f64 = 0.45;
const DENSITY: f64 = 0.5;
const MELANIN_FRACTIONS: [f64; 8] = [0.0, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05];
const EUMELANIN_RATIOS: [f64; 3] = [0.0, 0.5, 1.0];
/// Wavelengths (nm) of single values.
const BLUE_GREEN_RED_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Weights of linear sRGB in luminance (IEC 61966-2-1).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// At one wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AlbedoRow {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Scattering over extinction in the stroma.
    pub stroma_albedo: f64,
    /// Scattering over extinction in the border layer.
    pub border_layer_albedo: f64,
    /// Diffuse reflectance of the iris.
    pub reflectance: f64,
}

/// An iris by its melanin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MelaninRow {
    /// Volume fraction of melanin in the stroma.
    pub melanin_fraction: f64,
    /// Volume fraction in the border layer where it is densest.
    pub border_layer_melanin_fraction: f64,
    /// Eumelanin in all melanin.
    pub eumelanin_ratio: f64,
    /// Albedos at three wavelengths.
    pub albedo: [AlbedoRow; 3],
    /// Diffuse reflectance by two fluxes.
    pub linear_srgb: [f64; 3],
    /// The same by many fluxes.
    pub many_flux_linear_srgb: [f64; 3],
    /// `linear_srgb`, encoded.
    pub srgb: [f64; 3],
}

/// The tissue's coefficients at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CoefficientRow {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Equation 10 (mm⁻¹).
    pub eumelanin_absorption_per_mm: f64,
    /// Equation 11 as printed (mm⁻¹).
    pub pheomelanin_absorption_per_mm: f64,
    /// Equation 11 read per cm (mm⁻¹).
    pub pheomelanin_absorption_dilute_per_mm: f64,
    /// Equation 12 (mm⁻¹).
    pub baseline_absorption_per_mm: f64,
    /// Of blood in the vessels of an iris (mm⁻¹).
    pub blood_absorption_per_mm: f64,
    /// First term of equation 14 (mm⁻¹).
    pub mie_scattering_per_mm: f64,
    /// Second term of equation 14 (mm⁻¹).
    pub rayleigh_scattering_per_mm: f64,
}

/// One wavelength of an iris.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReflectanceRow {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Diffuse reflectance by two fluxes.
    pub reflectance: f64,
}

/// A named iris.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IrisRow {
    /// Its name; `patient` is the patient's own.
    pub iris: &'static str,
    /// Volume fraction of melanin in the stroma.
    pub stroma_melanin_fraction: f64,
    /// Volume fraction in the border layer where it is densest.
    pub border_layer_melanin_fraction: f64,
    /// Eumelanin in all melanin.
    pub eumelanin_ratio: f64,
    /// Volume fraction of blood in the stroma.
    pub stroma_blood_fraction: f64,
    /// Diffuse reflectance by two fluxes.
    pub linear_srgb: [f64; 3],
    /// The same by many fluxes.
    pub many_flux_linear_srgb: [f64; 3],
    /// The same as it is lit and seen in the aqueous: what the picture shows.
    pub seen_linear_srgb: [f64; 3],
    /// `linear_srgb`, encoded.
    pub srgb: [f64; 3],
    /// Its spectrum.
    pub spectrum: Vec<ReflectanceRow>,
}

/// Orders of scattering in a named iris.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScatteringRow {
    /// Its name.
    pub iris: &'static str,
    /// Random walks in all.
    pub walks: u32,
    /// Luminance of light scattered once, closed form.
    pub single_luminance: f64,
    /// Luminance of light scattered any number of times, by random walks.
    pub all_orders_luminance: f64,
    /// Its standard error.
    pub all_orders_luminance_standard_error: f64,
    /// Luminance of the same by many fluxes.
    pub many_flux_luminance: f64,
    /// Share of light scattered once.
    pub single_share: f64,
    /// Its standard error.
    pub single_share_standard_error: f64,
    /// The same share by many fluxes.
    pub single_share_many_flux: f64,
    /// Error of the two-flux luminance.
    pub two_flux_error: f64,
    /// Change of luminance by the real phase functions.
    pub similarity_error: f64,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TissueTable {
    /// Thickness of the border layer (mm).
    pub border_layer_mm: f64,
    /// Thickness of the stroma (mm).
    pub stroma_mm: f64,
    /// Colours by melanin.
    pub rows: Vec<MelaninRow>,
    /// Coefficients by wavelength.
    pub coefficients: Vec<CoefficientRow>,
    /// Named irises.
    pub irises: Vec<IrisRow>,
    /// Orders of scattering in them.
    pub scattering: Vec<ScatteringRow>,
}

/// Everything, with the patient's own iris last; `walks` random walks a wavelength and kind.
pub fn table(eye: &MeasuredEye, walks: u32) -> TissueTable {
    let named = [
        ("blue", IrisPigment::BLUE),
        ("green", IrisPigment::GREEN),
        ("hazel", IrisPigment::HAZEL),
        ("brown", IrisPigment::BROWN),
        ("patient", eye.pigment()),
    ];
    let mut rows = Vec::with_capacity(MELANIN_FRACTIONS.len() * EUMELANIN_RATIOS.len());
    for eumelanin_ratio in EUMELANIN_RATIOS {
        rows.extend(MELANIN_FRACTIONS.map(|fraction| melanin_row(fraction, eumelanin_ratio)));
    }
    TissueTable {
        border_layer_mm: BORDER_LAYER_MM,
        stroma_mm: STROMA_MM,
        rows,
        coefficients: sampled_nm().map(coefficient_row).collect(),
        irises: named
            .iter()
            .map(|(name, iris)| iris_row(name, iris))
            .collect(),
        scattering: named
            .iter()
            .zip(1..)
            .map(|((name, iris), seed)| scattering_row(name, iris, walks, seed))
            .collect(),
    }
}

/// The wavelengths (nm) of a spectrum.
fn sampled_nm() -> impl Iterator<Item = f64> {
    (0..SAMPLES).map(|i| FIRST_NM + STEP_NM * i as f64)
}

fn encoded(linear_srgb: [f64; 3]) -> [f64; 3] {
    linear_to_srgb(DVec3::from_array(linear_srgb)).to_array()
}

fn melanin_row(melanin_fraction: f64, eumelanin_ratio: f64) -> MelaninRow {
    let pigment = IrisPigment {
        stroma_melanin_fraction: melanin_fraction,
        border_layer_melanin_fraction: (10.0 * melanin_fraction).min(0.5),
        eumelanin_ratio,
        stroma_blood_fraction: STROMA_BLOOD,
    };
    let spectrum = iris_reflectance_spectrum(&pigment, STROMA_MM, DENSITY);
    let linear_srgb = iris_reflectance(&pigment, STROMA_MM, DENSITY);
    MelaninRow {
        melanin_fraction,
        border_layer_melanin_fraction: pigment.border_layer_melanin_fraction,
        eumelanin_ratio,
        albedo: BLUE_GREEN_RED_NM.map(|wavelength_nm| {
            let tissue = TissueCoefficients::at(wavelength_nm);
            let [border, stroma] = reduced_layers(&pigment, STROMA_MM, DENSITY, &tissue);
            AlbedoRow {
                wavelength_nm,
                stroma_albedo: stroma.albedo(),
                border_layer_albedo: border.albedo(),
                reflectance: spectrum[((wavelength_nm - FIRST_NM) / STEP_NM).round() as usize],
            }
        }),
        linear_srgb,
        many_flux_linear_srgb: iris_reflectance_many_flux(&pigment, STROMA_MM, DENSITY),
        srgb: encoded(linear_srgb),
    }
}

fn coefficient_row(wavelength_nm: f64) -> CoefficientRow {
    let tissue = TissueCoefficients::at(wavelength_nm);
    CoefficientRow {
        wavelength_nm,
        eumelanin_absorption_per_mm: tissue.eumelanin_absorption,
        pheomelanin_absorption_per_mm: tissue.pheomelanin_absorption,
        pheomelanin_absorption_dilute_per_mm: pheomelanin_absorption(
            wavelength_nm,
            PHEOMELANIN_DILUTE,
        ),
        baseline_absorption_per_mm: tissue.baseline_absorption,
        blood_absorption_per_mm: tissue.blood_absorption,
        mie_scattering_per_mm: tissue.mie_scattering,
        rayleigh_scattering_per_mm: tissue.rayleigh_scattering,
    }
}

fn iris_row(iris: &'static str, pigment: &IrisPigment) -> IrisRow {
    let linear_srgb = iris_reflectance(pigment, STROMA_MM, DENSITY);
    let spectrum = iris_reflectance_spectrum(pigment, STROMA_MM, DENSITY);
    IrisRow {
        iris,
        stroma_melanin_fraction: pigment.stroma_melanin_fraction,
        border_layer_melanin_fraction: pigment.border_layer_melanin_fraction,
        eumelanin_ratio: pigment.eumelanin_ratio,
        stroma_blood_fraction: pigment.stroma_blood_fraction,
        linear_srgb,
        many_flux_linear_srgb: iris_reflectance_many_flux(pigment, STROMA_MM, DENSITY),
        seen_linear_srgb: iris_reflectance_seen(pigment, STROMA_MM, DENSITY)[0],
        srgb: encoded(linear_srgb),
        spectrum: sampled_nm()
            .zip(spectrum)
            .map(|(wavelength_nm, reflectance)| ReflectanceRow {
                wavelength_nm,
                reflectance,
            })
            .collect(),
    }
}

/// Orders of scattering in an iris, by `walks` random walks a wavelength and kind. Irises with seeds of
/// their own have independent errors.
pub fn scattering_row(
    iris: &'static str,
    pigment: &IrisPigment,
    walks: u32,
    seed: u64,
) -> ScatteringRow {
    let found = iris_scattering(pigment, STROMA_MM, DENSITY, walks, seed);
    let luminance = |rgb: [f64; 3]| -> f64 { rgb.iter().zip(LUMINANCE).map(|(c, w)| c * w).sum() };
    let all_orders = luminance(found.all_orders.map(|channel| channel.mean));
    let standard_error = luminance_standard_error(&found);
    let (single, many_flux) = (luminance(found.single), luminance(found.many_flux));
    let share = single / all_orders;
    ScatteringRow {
        iris,
        walks: walks * IRIS_WAVELENGTHS as u32,
        single_luminance: single,
        all_orders_luminance: all_orders,
        all_orders_luminance_standard_error: standard_error,
        many_flux_luminance: many_flux,
        single_share: share,
        // The closed form has no error of its own.
        single_share_standard_error: share * standard_error / all_orders,
        single_share_many_flux: 1.0 - found.missed_by_single_scattering(),
        two_flux_error: found.two_flux_error(),
        similarity_error: found.similarity_error(),
    }
}

/// Standard error of the luminance by random walks: wavelengths are independent, channels are not.
fn luminance_standard_error(found: &IrisScattering) -> f64 {
    let few = Wavelengths::<IRIS_WAVELENGTHS>::new();
    let variance: f64 = found
        .by_wavelength
        .iter()
        .enumerate()
        .map(|(i, at)| {
            let weight: f64 = (0..3).map(|c| LUMINANCE[c] * few.weights[c][i]).sum();
            (weight * at.all_orders.standard_error).powi(2)
        })
        .sum();
    variance.sqrt()
}
