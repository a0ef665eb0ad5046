//! The colour of an iris: how many wavelengths, and which size of table.

use super::rows::Task;
use super::timing::Stopwatch;
use crate::tissue::colour_difference::{delta_e_2000, linear_srgb_to_lab};
use crate::tissue::iris_layers::reduced_layers;
use crate::tissue::iris_reflectance::{
    IrisPigment, IrisReflectanceTable, STROMA_PATH_MAX_MM, iris_reflectance_seen,
};
use crate::tissue::melanin::TissueCoefficients;
use crate::tissue::slab::slab_two_flux;
use crate::tissue::spectrum::{spectrum_from, spectrum_to_linear_srgb};
use crate::tissue::wavelengths::Wavelengths;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// An iris where light falls on it.
#[derive(Clone, Copy, Debug)]
pub struct Iris {
    /// Its melanin.
    pub pigment: IrisPigment,
    /// The light's path through the stroma (mm).
    pub path_mm: f64,
    /// Relative density of the border layer.
    pub density: f64,
}

/// Seeded irises of every legal melanin, more often with little of it than with much.
pub fn irises(count: usize, seed: u64) -> Vec<Iris> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut share = || random.random::<f64>();
    let draw = |_| Iris {
        pigment: IrisPigment {
            stroma_melanin_fraction: 0.5 * share().powi(3),
            border_layer_melanin_fraction: 0.5 * share().powi(2),
            eumelanin_ratio: share(),
            // Few wavelengths keep its bands by another way, see `TissueCoefficients::few`.
            stroma_blood_fraction: 0.0,
        },
        path_mm: STROMA_PATH_MAX_MM * share(),
        density: share(),
    };
    (0..count).map(draw).collect()
}

/// Reflectance by two fluxes at one wavelength.
pub fn two_flux(iris: &Iris, tissue: &TissueCoefficients) -> f64 {
    let [border, stroma] = reduced_layers(&iris.pigment, iris.path_mm, iris.density, tissue)
        .map(|layer| slab_two_flux(layer.absorption, layer.scattering, layer.thickness_mm));
    border.over(stroma).reflectance
}

/// L*a*b* from all samples of the spectrum.
struct Coloured {
    iris: Iris,
    lab: [f64; 3],
}

/// The number of wavelengths; `count` irises.
pub fn wavelengths(stopwatch: &Stopwatch, count: usize) -> Task {
    let all = spectrum_from(|nm| nm).map(TissueCoefficients::at);
    let full =
        |iris: &Iris| spectrum_to_linear_srgb(&all.each_ref().map(|tissue| two_flux(iris, tissue)));
    let cases: Vec<Coloured> = irises(count, 12)
        .into_iter()
        .map(|iris| Coloured {
            lab: linear_srgb_to_lab(full(&iris)),
            iris,
        })
        .collect();
    let mut rows = vec![
        few::<3>(stopwatch, &cases),
        few::<4>(stopwatch, &cases),
        few::<5>(stopwatch, &cases),
        few::<6>(stopwatch, &cases),
        few::<8>(stopwatch, &cases),
        few::<10>(stopwatch, &cases),
        few::<14>(stopwatch, &cases),
    ];
    rows.push(stopwatch.row(
        ("every 10 nm", all.len(), 7 * all.len() * size_of::<f64>()),
        &cases,
        |case| full(&case.iris),
        difference,
    ));
    Task {
        name: "wavelengths".to_owned(),
        title: "Wavelengths for the colour of an iris".to_owned(),
        call: "linear sRGB of one iris, two fluxes at every wavelength".to_owned(),
        domain: format!(
            "{count} seeded irises of every legal melanin, without blood; path 0 to 2.5 mm; border layer's density 0 to 1"
        ),
        reference: "the colour by all 41 wavelengths (CIEDE2000)".to_owned(),
        unit: "ΔE2000".to_owned(),
        rows,
    }
}

fn difference(case: &Coloured, rgb: [f64; 3]) -> f64 {
    delta_e_2000(case.lab, linear_srgb_to_lab(rgb))
}

fn few<const N: usize>(stopwatch: &Stopwatch, cases: &[Coloured]) -> super::ErrorRow {
    let few = Wavelengths::<N>::new();
    let tissue = TissueCoefficients::few(&few);
    // Three weights and four coefficients a wavelength.
    let bytes = 7 * N * size_of::<f64>();
    let run = |case: &Coloured| {
        few.linear_srgb(&tissue.each_ref().map(|tissue| two_flux(&case.iris, tissue)))
    };
    stopwatch.row(("Gauss nodes", N, bytes), cases, run, difference)
}

/// The size of the table that the shader reads; `count` places.
pub fn table(stopwatch: &Stopwatch, count: usize) -> Task {
    // The strongest colours change most within a cell.
    let pigment = IrisPigment::HAZEL;
    let exact = |iris: &Iris| iris_reflectance_seen(&pigment, iris.path_mm, iris.density)[0];
    let cases: Vec<Coloured> = irises(count, 13)
        .into_iter()
        .map(|iris| Coloured {
            lab: linear_srgb_to_lab(exact(&iris)),
            iris,
        })
        .collect();
    let mut rows = Vec::new();
    for (width, height) in [(8, 4), (16, 8), (32, 16), (64, 32), (128, 64)] {
        let [table, _] = IrisReflectanceTable::seen(&pigment, width, height);
        // Four half floats a texel on the GPU.
        let bytes = width * height * 8;
        let run = |case: &Coloured| table.sample(case.iris.path_mm, case.iris.density);
        let method = ("table", format!("{width}×{height}"), bytes);
        rows.push(stopwatch.row(method, &cases, run, difference));
    }
    rows.push(stopwatch.row(
        ("many fluxes", 16, 0),
        &cases,
        |case| exact(&case.iris),
        difference,
    ));
    Task {
        name: "iris-table".to_owned(),
        title: "The table of an iris's colours".to_owned(),
        call: "linear sRGB at one path and density; the function by 16 fluxes at 8 wavelengths"
            .to_owned(),
        domain: format!(
            "{count} seeded places of a hazel iris; path 0 to 2.5 mm; border layer's density 0 to 1"
        ),
        reference: "the function that the table holds (CIEDE2000)".to_owned(),
        unit: "ΔE2000".to_owned(),
        rows,
    }
}
