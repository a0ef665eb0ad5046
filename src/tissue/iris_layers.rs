//! An iris as a stack of [`Layer`]s over black: anterior border layer and stroma at one wavelength.
//!
//! In: pigment, thickness of the stroma, density of the border layer, the tissue's coefficients at
//! a wavelength. Out: two layers, with reduced isotropic scattering or with the phase functions of
//! fibrils and bundles.

use super::iris_reflectance::{
    BORDER_LAYER_MIE_DENSITY, BORDER_LAYER_MM, BORDER_LAYER_RAYLEIGH_DENSITY, IrisPigment,
    STROMA_MIE_DENSITY, STROMA_RAYLEIGH_DENSITY,
};
use super::layers::Layer;
use super::melanin::TissueCoefficients;
use super::phase::PhaseMix;

/// Share of what bundles of collagen scatter that goes into all directions alike, and mean cosine of the rest, which follows
/// Henyey and Greenstein: human dermis at 633 nm (Jacques, Alter and Prahl 1987, *Lasers in the Life Sciences* 1, 309). A
/// Henyey–Greenstein function alone of the same mean sends back half of that, and irises that hold melanin come out olive.
pub const BUNDLE_ISOTROPIC: f64 = 0.1;
const BUNDLE_PEAK_COSINE: f64 = 0.91;
/// Mean cosine of all that they scatter.
pub const BUNDLE_MEAN_COSINE: f64 = (1.0 - BUNDLE_ISOTROPIC) * BUNDLE_PEAK_COSINE;

/// The anterior border layer with a density of its pigment from 0 to 1, bundles scattering with the
/// mean cosine `g` (0, or [`BUNDLE_MEAN_COSINE`]): their coefficient is 1/(1 − g) times the reduced one.
fn border_layer(pigment: &IrisPigment, density: f64, tissue: &TissueCoefficients, g: f64) -> Layer {
    layer(
        tissue.absorption(
            pigment.border_layer_melanin_fraction * density,
            pigment.eumelanin_ratio,
        ),
        BORDER_LAYER_MIE_DENSITY * tissue.mie_scattering / (1.0 - g),
        BORDER_LAYER_RAYLEIGH_DENSITY * tissue.rayleigh_scattering,
        BORDER_LAYER_MM,
        g,
    )
}

/// Absorption (mm⁻¹) of the stroma: of its melanin, its tissue and the blood in its vessels.
pub(super) fn stroma_absorption(pigment: &IrisPigment, tissue: &TissueCoefficients) -> f64 {
    tissue.absorption(pigment.stroma_melanin_fraction, pigment.eumelanin_ratio)
        + pigment.stroma_blood_fraction * tissue.blood_absorption
}

/// The stroma, likewise, with the blood in its vessels.
fn stroma(pigment: &IrisPigment, thickness_mm: f64, tissue: &TissueCoefficients, g: f64) -> Layer {
    layer(
        stroma_absorption(pigment, tissue),
        STROMA_MIE_DENSITY * tissue.mie_scattering / (1.0 - g),
        STROMA_RAYLEIGH_DENSITY * tissue.rayleigh_scattering,
        thickness_mm,
        g,
    )
}

fn layer(absorption: f64, bundles: f64, fibrils: f64, thickness_mm: f64, g: f64) -> Layer {
    let scattering = bundles + fibrils;
    let isotropic = BUNDLE_ISOTROPIC * bundles / scattering;
    let peak = g / (1.0 - BUNDLE_ISOTROPIC);
    Layer {
        absorption,
        scattering,
        thickness_mm,
        phase: PhaseMix::new(fibrils / scattering, isotropic, peak),
    }
}

/// The anterior border layer with reduced isotropic scattering.
pub(super) fn reduced_border_layer(
    pigment: &IrisPigment,
    density: f64,
    tissue: &TissueCoefficients,
) -> Layer {
    Layer {
        phase: PhaseMix::ISOTROPIC,
        ..border_layer(pigment, density, tissue, 0.0)
    }
}

/// The stroma with reduced isotropic scattering.
pub(super) fn reduced_stroma(
    pigment: &IrisPigment,
    thickness_mm: f64,
    tissue: &TissueCoefficients,
) -> Layer {
    Layer {
        phase: PhaseMix::ISOTROPIC,
        ..stroma(pigment, thickness_mm, tissue, 0.0)
    }
}

/// Mean cosine of the forward part of bundles whose peak, the share g² of that part, is taken as not scattered
/// (delta-Eddington: Joseph, Wiscombe and Weinman 1976): g/(1 + g). It keeps two moments of the phase function where reducing
/// keeps one.
pub const BUNDLE_SCALED_COSINE: f64 = BUNDLE_PEAK_COSINE / (1.0 + BUNDLE_PEAK_COSINE);
/// What is left of all that they scatter.
const BUNDLE_LEFT: f64 =
    BUNDLE_ISOTROPIC + (1.0 - BUNDLE_ISOTROPIC) * (1.0 - BUNDLE_PEAK_COSINE * BUNDLE_PEAK_COSINE);
/// Share of that which goes into all directions alike.
pub const BUNDLE_SIDEWAYS: f64 = BUNDLE_ISOTROPIC / BUNDLE_LEFT;

/// What bundles without their peak do.
pub fn bundles_without_peak() -> PhaseMix {
    PhaseMix::new(0.0, BUNDLE_SIDEWAYS, BUNDLE_SCALED_COSINE)
}

fn without_peak(layer: Layer, fibrils: f64) -> Layer {
    // The layer's bundles are reduced ones, (1 − g) of themselves.
    let bundles = (layer.scattering - fibrils) * BUNDLE_LEFT / (1.0 - BUNDLE_MEAN_COSINE);
    let scattering = bundles + fibrils;
    let sideways = BUNDLE_SIDEWAYS * bundles / scattering;
    Layer {
        scattering,
        phase: PhaseMix::new(fibrils / scattering, sideways, BUNDLE_SCALED_COSINE),
        ..layer
    }
}

/// The anterior border layer with its bundles' forward peak taken as not scattered.
pub(super) fn peakless_border_layer(
    pigment: &IrisPigment,
    density: f64,
    tissue: &TissueCoefficients,
) -> Layer {
    without_peak(
        border_layer(pigment, density, tissue, 0.0),
        BORDER_LAYER_RAYLEIGH_DENSITY * tissue.rayleigh_scattering,
    )
}

/// The stroma, likewise.
pub(super) fn peakless_stroma(
    pigment: &IrisPigment,
    thickness_mm: f64,
    tissue: &TissueCoefficients,
) -> Layer {
    without_peak(
        stroma(pigment, thickness_mm, tissue, 0.0),
        STROMA_RAYLEIGH_DENSITY * tissue.rayleigh_scattering,
    )
}

/// Border layer and stroma with reduced isotropic scattering, as the two-flux estimate sees them.
/// `thickness_mm` is the stroma's, `density` the border layer's from 0 to 1.
pub fn reduced_layers(
    pigment: &IrisPigment,
    thickness_mm: f64,
    density: f64,
    tissue: &TissueCoefficients,
) -> [Layer; 2] {
    [
        reduced_border_layer(pigment, density, tissue),
        reduced_stroma(pigment, thickness_mm, tissue),
    ]
}

/// Border layer and stroma whose fibrils scatter after Rayleigh and whose bundles after Henyey &
/// Greenstein with [`BUNDLE_MEAN_COSINE`]; the same reduced coefficients.
pub fn forward_layers(
    pigment: &IrisPigment,
    thickness_mm: f64,
    density: f64,
    tissue: &TissueCoefficients,
) -> [Layer; 2] {
    [
        border_layer(pigment, density, tissue, BUNDLE_MEAN_COSINE),
        stroma(pigment, thickness_mm, tissue, BUNDLE_MEAN_COSINE),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_have_the_same_reduced_coefficients() {
        let tissue = TissueCoefficients::at(480.0);
        let reduced = reduced_layers(&IrisPigment::HAZEL, 0.45, 0.5, &tissue);
        let forward = forward_layers(&IrisPigment::HAZEL, 0.45, 0.5, &tissue);
        for (a, b) in reduced.iter().zip(&forward) {
            assert_eq!(
                (a.absorption, a.thickness_mm),
                (b.absorption, b.thickness_mm)
            );
            let less = |l: &Layer| l.scattering * (1.0 - l.phase.mean_cosine());
            assert!((less(a) / less(b) - 1.0).abs() < 1e-14);
            assert!(b.scattering > 1.5 * a.scattering);
        }
        // Equation 14's terms at 480 nm by hand: 14.74 · 480^−0.22 = 3.78987, 2.2e11/480⁴ =
        // 4.14436.
        let of = |bundles: f64, fibrils: f64| bundles * 3.789_87 + fibrils * 4.144_36;
        let border = of(BORDER_LAYER_MIE_DENSITY, BORDER_LAYER_RAYLEIGH_DENSITY);
        let stroma = of(STROMA_MIE_DENSITY, STROMA_RAYLEIGH_DENSITY);
        assert!((reduced[0].scattering - border).abs() < 1e-5);
        assert!((reduced[1].scattering - stroma).abs() < 1e-5);
        // Without its peak a bundle keeps its reduced coefficient.
        let left = BUNDLE_LEFT * (1.0 - bundles_without_peak().mean_cosine());
        assert!((left - (1.0 - BUNDLE_MEAN_COSINE)).abs() < 1e-14);
    }
}
