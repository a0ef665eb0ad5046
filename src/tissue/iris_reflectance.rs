//! The colour of an iris from its pigment and its thickness.
//!
//! In: an [`IrisPigment`], the light's path through the stroma, the local density of the anterior
//! border layer. Out: diffuse reflectance in linear sRGB, as a function or as a table for a shader.
//!
//! Layers from the front: the anterior border layer (0.04 mm), where pigment cells lie dense; the
//! stroma; the pigment epithelium, which absorbs all that reaches it (François et al. 2007, section
//! 4). Each layer is a two-flux slab ([`super::slab`]) with the coefficients of equations 10 to 14
//! at the [`IRIS_WAVELENGTHS`] wavelengths of [`super::wavelengths`]: without blood an iris's spectrum is so
//! smooth that these give the colour of all 41 to a CIEDE2000 difference of 0.004, half of what the
//! 41 themselves miss of a 1 nm table (0.009); with the bands of its blood to 0.3 on average and 1.4 at
//! the worst, where the path is longest. A blue iris has no blue pigment: thin fibrils
//! scatter blue more, the black epithelium swallows the rest, and what melanin there is takes the
//! blue away again, to green, hazel and brown.
//!
//! **Path.** A layer of thickness `d` lit at `µ_i` and seen at `µ_o` acts by the mean slant
//! `d (1/µ_i + 1/µ_o)/2`; the table's first axis is that path in the stroma, 0 to
//! [`STROMA_PATH_MAX_MM`].

use super::iris_layers::{
    bundles_without_peak, peakless_border_layer, peakless_stroma, reduced_border_layer,
    reduced_stroma, stroma_absorption,
};
use super::layers::{Layer, mean_transmittance};
use super::many_flux::{LayerFlux, mean_phase, nodes_within};
use super::melanin::TissueCoefficients;
use super::phase::PhaseMix;
use super::slab::{TwoFlux, slab_two_flux};
use super::spectrum::{Spectrum, spectrum_from, spectrum_to_linear_srgb};
use super::wavelengths::Wavelengths;
use glam::{DMat3, DVec3};
use std::sync::LazyLock;

/// Number of wavelengths at which an iris is computed.
pub const IRIS_WAVELENGTHS: usize = 8;

/// Nodes in each hemisphere of the many-flux colours.
const NODES: usize = 4;
/// Longest path (mm) in the table.
pub const STROMA_PATH_MAX_MM: f64 = 2.5;
/// Thickness (mm) of the anterior border layer.
pub const BORDER_LAYER_MM: f64 = 0.04;
/// Density of thin fibrils in the stroma relative to the skin of equation 14. The stroma is a
/// loose mesh in aqueous humour; this and [`STROMA_MIE_DENSITY`] are calibrated so that
/// [`IrisPigment::BLUE`], 0.45 mm thick, is as bright beside the white as photographs show light irises
/// (their mean is sRGB 90 91 89 where the white has 202 186 169), and bluer than most of them.
pub const STROMA_RAYLEIGH_DENSITY: f64 = 0.18;
/// Density of thick collagen bundles in the stroma relative to the skin of equation 14.
pub const STROMA_MIE_DENSITY: f64 = 0.16;
/// Density of thin fibrils in the anterior border layer relative to that skin: it is made of cells, not of a mesh.
pub const BORDER_LAYER_RAYLEIGH_DENSITY: f64 = 0.03;
/// Density of collagen bundles in it: they give dark irises the matt brown that they have in place of black.
pub const BORDER_LAYER_MIE_DENSITY: f64 = 0.15;

/// How much melanin an iris holds, where, and of which kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisPigment {
    /// Volume fraction of melanin in the stroma, C_m of equation 13, 0 to 0.5.
    pub stroma_melanin_fraction: f64,
    /// Volume fraction of melanin in the anterior border layer where it is densest, 0 to 0.5.
    pub border_layer_melanin_fraction: f64,
    /// Ratio of eumelanin to all melanin, β_m of equation 13, 0 to 1.
    pub eumelanin_ratio: f64,
    /// Volume fraction of blood in the stroma, 0 to 0.5.
    pub stroma_blood_fraction: f64,
}

/// Volume fraction of blood in the stroma of a blue or hazel iris. The paper has none; without it pale irises come out bluer, and brown
/// ones more olive, than photographs show them (the fractions are choices by their means, sRGB 90 91 89 and 91 62 52).
pub const STROMA_BLOOD: f64 = 0.02;
/// That of a green iris, which more would turn hazel, and of a brown one.
const GREEN_BLOOD: f64 = 0.005;
const BROWN_BLOOD: f64 = 0.033;

impl IrisPigment {
    /// Next to no melanin: blue by scattering; a little pheomelanin where the border layer is densest, as the collarette of most
    /// pale irises is yellower than the rest.
    pub const BLUE: Self = Self {
        stroma_melanin_fraction: 0.0004,
        border_layer_melanin_fraction: 0.035,
        eumelanin_ratio: 0.1,
        stroma_blood_fraction: STROMA_BLOOD,
    };
    /// Pheomelanin in the border layer: yellow over blue; amber where it is densest.
    pub const GREEN: Self = Self {
        stroma_melanin_fraction: 0.002,
        border_layer_melanin_fraction: 0.18,
        eumelanin_ratio: 0.02,
        stroma_blood_fraction: GREEN_BLOOD,
    };
    /// Between green and brown.
    pub const HAZEL: Self = Self {
        stroma_melanin_fraction: 0.010,
        border_layer_melanin_fraction: 0.28,
        eumelanin_ratio: 0.3,
        stroma_blood_fraction: STROMA_BLOOD,
    };
    /// Dense melanin, most of it in the border layer, where it is thick in one place and thin in the next: with as much of it in the stroma
    /// as would make it as dark, a brown iris varies half as much in lightness as photographs of them do. Enough of it is pheomelanin to be
    /// warm.
    pub const BROWN: Self = Self {
        stroma_melanin_fraction: 0.01,
        border_layer_melanin_fraction: 0.5,
        eumelanin_ratio: 0.15,
        stroma_blood_fraction: BROWN_BLOOD,
    };

    /// Fractions clamped to their ranges; what is not a number counts as none.
    pub(super) fn clamped(self) -> Self {
        let within = |v: f64, high: f64| if v.is_nan() { 0.0 } else { v.clamp(0.0, high) };
        Self {
            stroma_melanin_fraction: within(self.stroma_melanin_fraction, 1.0),
            border_layer_melanin_fraction: within(self.border_layer_melanin_fraction, 1.0),
            eumelanin_ratio: within(self.eumelanin_ratio, 1.0),
            stroma_blood_fraction: within(self.stroma_blood_fraction, 1.0),
        }
    }
}

/// The wavelengths and the tissue's coefficients there.
static AT: LazyLock<(
    Wavelengths<IRIS_WAVELENGTHS>,
    [TissueCoefficients; IRIS_WAVELENGTHS],
)> = LazyLock::new(|| {
    let few = Wavelengths::new();
    (few, TissueCoefficients::few(&few))
});

/// The anterior border layer at a density of its pigment from 0 to 1.
fn border_layer(pigment: &IrisPigment, density: f64, tissue: &TissueCoefficients) -> TwoFlux {
    let melanin = pigment.border_layer_melanin_fraction * density;
    slab_two_flux(
        tissue.absorption(melanin, pigment.eumelanin_ratio),
        border_layer_scattering(tissue),
        BORDER_LAYER_MM,
    )
}

/// The stroma along a path.
fn stroma(pigment: &IrisPigment, path_mm: f64, tissue: &TissueCoefficients) -> TwoFlux {
    slab_two_flux(
        stroma_absorption(pigment, tissue),
        stroma_scattering(tissue),
        path_mm,
    )
}

/// Reduced scattering coefficient (mm⁻¹) of the anterior border layer.
pub(super) fn border_layer_scattering(tissue: &TissueCoefficients) -> f64 {
    BORDER_LAYER_MIE_DENSITY * tissue.mie_scattering
        + BORDER_LAYER_RAYLEIGH_DENSITY * tissue.rayleigh_scattering
}

/// Reduced scattering coefficient (mm⁻¹) of the stroma.
pub(super) fn stroma_scattering(tissue: &TissueCoefficients) -> f64 {
    STROMA_MIE_DENSITY * tissue.mie_scattering
        + STROMA_RAYLEIGH_DENSITY * tissue.rayleigh_scattering
}

/// Reflectance of the layers over the black pigment epithelium.
fn over_black(border_layer: TwoFlux, stroma: TwoFlux) -> f64 {
    border_layer.over(stroma).reflectance
}

/// Reflectance at one wavelength of an iris whose numbers are within their ranges.
pub(super) fn reflectance_of(
    pigment: &IrisPigment,
    path_mm: f64,
    density: f64,
    tissue: &TissueCoefficients,
) -> f64 {
    over_black(
        border_layer(pigment, density, tissue),
        stroma(pigment, path_mm, tissue),
    )
}

/// A path and a density within their ranges; what is not a number counts as 0.
pub(super) fn within_range(path_mm: f64, density: f64) -> (f64, f64) {
    let within = |v: f64, high: f64| if v.is_nan() { 0.0 } else { v.clamp(0.0, high) };
    (within(path_mm, 1e3), within(density, 1.0))
}

/// Linear sRGB of reflectances at the wavelengths, within 0 and 1.
fn colour(reflectance: &[f64; IRIS_WAVELENGTHS]) -> [f64; 3] {
    AT.0.linear_srgb(reflectance)
        .map(|channel| channel.clamp(0.0, 1.0))
}

/// Diffuse reflectance (linear sRGB, 0 to 1) of an iris whose stroma the light crosses on a path of
/// `path_mm` (from 0), under a border layer of the relative melanin density `density` (0 to 1).
/// Arguments outside their ranges are clamped; colours outside sRGB lose their negative channel.
pub fn iris_reflectance(pigment: &IrisPigment, path_mm: f64, density: f64) -> [f64; 3] {
    let pigment = pigment.clamped();
    let (path_mm, density) = within_range(path_mm, density);
    let reflectance =
        AT.1.each_ref()
            .map(|tissue| reflectance_of(&pigment, path_mm, density, tissue));
    colour(&reflectance)
}

/// As [`iris_reflectance`], with eight fluxes in place of two ([`super::many_flux`]): all orders of
/// scattering within 3e-4 (without blood 6e-4), where two-flux is 3 to 10 % too dark.
pub fn iris_reflectance_many_flux(pigment: &IrisPigment, path_mm: f64, density: f64) -> [f64; 3] {
    let pigment = pigment.clamped();
    let (path_mm, density) = within_range(path_mm, density);
    colour(&AT.1.each_ref().map(|tissue| {
        many_flux_border_layer(&pigment, density, tissue)
            .reflectance_over(&many_flux_stroma(&pigment, path_mm, tissue))
    }))
}

/// Nodes in each hemisphere of what is seen in the aqueous: the three steepest of eight fill the cone of
/// [`AQUEOUS_COSINE`].
const SEEN_NODES: usize = 8;
/// Cosine of the critical angle of the aqueous, √(1 − 1.336⁻²): no light reaches the middle of an iris from further aside.
pub const AQUEOUS_COSINE: f64 = 0.663;
/// Mean of the inverse cosine over the flux of that cone, 2/(1 + [`AQUEOUS_COSINE`]): what a layer's thickness counts
/// there.
pub const AQUEOUS_SLANT: f64 = 1.2026;

/// A layer as seen in the aqueous.
struct SeenLayer {
    layer: Layer,
    flux: LayerFlux<SEEN_NODES>,
}

/// Two nodes of what is seen in the aqueous, and mean phase functions from one to the other.
struct Pair {
    into: f64,
    out: f64,
    share: f64,
    rayleigh: f64,
    bundles: f64,
}

static PAIRS: LazyLock<Vec<Pair>> = LazyLock::new(|| {
    let nodes = nodes_within::<SEEN_NODES>(AQUEOUS_COSINE);
    let both = nodes.iter().flat_map(|a| nodes.iter().map(move |b| (a, b)));
    both.map(|(&(into, lit), &(out, seen))| Pair {
        into,
        out,
        share: lit * seen,
        rayleigh: mean_phase(&PhaseMix::RAYLEIGH, into, out),
        bundles: mean_phase(&bundles_without_peak(), into, out),
    })
    .collect()
});

impl Pair {
    fn phase(&self, layer: &Layer) -> f64 {
        let fibrils = layer.phase.rayleigh_share();
        fibrils * self.rayleigh + (1.0 - fibrils) * self.bundles
    }
}

impl SeenLayer {
    fn new(layer: Layer) -> Self {
        Self {
            flux: LayerFlux::within(&layer, AQUEOUS_COSINE),
            layer,
        }
    }

    fn border(pigment: &IrisPigment, density: f64, tissue: &TissueCoefficients) -> Self {
        Self::new(peakless_border_layer(pigment, density, tissue))
    }

    fn stroma(pigment: &IrisPigment, thickness_mm: f64, tissue: &TissueCoefficients) -> Self {
        Self::new(peakless_stroma(pigment, thickness_mm, tissue))
    }

    /// Stromas of these thicknesses (mm), which grow by even steps: each is the one before and a step more.
    fn stromas(pigment: &IrisPigment, all_mm: &[f64], tissue: &TissueCoefficients) -> Vec<Self> {
        let [first, second, ..] = all_mm else {
            let alone = |mm: &f64| Self::stroma(pigment, *mm, tissue);
            return all_mm.iter().map(alone).collect();
        };
        let step = Self::stroma(pigment, second - first, tissue);
        let mut grown = vec![Self::stroma(pigment, *first, tissue)];
        for thickness_mm in &all_mm[1..] {
            let layer = peakless_stroma(pigment, *thickness_mm, tissue);
            let flux = grown[grown.len() - 1].flux.and(&step.flux, AQUEOUS_COSINE);
            grown.push(Self { layer, flux });
        }
        grown
    }

    /// This layer over `below` over black: all light, and what is scattered more than once.
    fn over(&self, below: &Self) -> [f64; 2] {
        let all = self.flux.reflectance_over(&below.flux);
        let border = self.layer.optical_depth();
        let whole = border + below.layer.optical_depth();
        let mut once = 0.0;
        for pair in PAIRS.iter() {
            // π BRDF: phase and albedo over the cosines times ∫ e^(−τ s) dτ.
            let slant = 1.0 / pair.into + 1.0 / pair.out;
            let above = border * mean_transmittance(0.0, border * slant);
            let deeper = (whole - border) * mean_transmittance(border * slant, whole * slant);
            let sum = self.layer.albedo() * above * pair.phase(&self.layer)
                + below.layer.albedo() * deeper * pair.phase(&below.layer);
            once += pair.share * core::f64::consts::PI * sum / (pair.into * pair.out);
        }
        [all, (all - once).max(0.0)]
    }
}

/// Reflectance (linear sRGB) of an iris as it is lit and seen in the aqueous, through which no light goes further aside than
/// [`AQUEOUS_COSINE`]: radiance over irradiance/π, of all light and of what is scattered more than once. `thickness_mm` is the
/// stroma's; arguments as in [`iris_reflectance`]. Light all around would come back more, the more obliquely the more.
pub fn iris_reflectance_seen(
    pigment: &IrisPigment,
    thickness_mm: f64,
    density: f64,
) -> [[f64; 3]; 2] {
    let pigment = pigment.clamped();
    let (thickness_mm, density) = within_range(thickness_mm, density);
    let both = AT.1.each_ref().map(|tissue| {
        SeenLayer::border(&pigment, density, tissue).over(&SeenLayer::stroma(
            &pigment,
            thickness_mm,
            tissue,
        ))
    });
    [0, 1].map(|which| colour(&both.map(|one| one[which])))
}

fn many_flux_border_layer(
    pigment: &IrisPigment,
    density: f64,
    tissue: &TissueCoefficients,
) -> LayerFlux<NODES> {
    LayerFlux::new(&reduced_border_layer(pigment, density, tissue))
}

fn many_flux_stroma(
    pigment: &IrisPigment,
    path_mm: f64,
    tissue: &TissueCoefficients,
) -> LayerFlux<NODES> {
    LayerFlux::new(&reduced_stroma(pigment, path_mm, tissue))
}

/// The same iris's reflectance at all 41 wavelengths of [`super::spectrum`]: the reference, and
/// what a spectrometer would show. Arguments as in [`iris_reflectance`].
pub fn iris_reflectance_spectrum(pigment: &IrisPigment, path_mm: f64, density: f64) -> Spectrum {
    let pigment = pigment.clamped();
    let (path_mm, density) = within_range(path_mm, density);
    spectrum_from(|nm| reflectance_of(&pigment, path_mm, density, &TissueCoefficients::at(nm)))
}

/// Coefficients of an iris at three wavelengths, for light that is followed through it: extinction and scattering, mm⁻¹,
/// without the forward peak of collagen bundles ([`super::iris_layers::BUNDLE_SCALED_COSINE`]). Three wavelengths give the colour of 41 to a CIEDE2000 difference of 0.7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisTissue {
    /// Extinction of the border layer without melanin.
    pub border: DVec3,
    /// What its melanin adds where it is densest.
    pub border_melanin: DVec3,
    /// Scattering of the border layer.
    pub border_scattering: DVec3,
    /// Share of that that thin fibrils do, after Rayleigh; the rest is what bundles do ([`super::iris_layers::bundles_without_peak`]).
    pub border_fibrils: DVec3,
    /// Extinction of the stroma.
    pub stroma: DVec3,
    /// Scattering of the stroma.
    pub stroma_scattering: DVec3,
    /// Share of that that thin fibrils do.
    pub stroma_fibrils: DVec3,
    /// What each wavelength weighs in linear sRGB: its columns.
    pub weights: DMat3,
}

/// Thickness (mm) of the stroma for which three wavelengths are matched to all: that of a mean iris.
const MATCHED_MM: f64 = 0.45;

/// The coefficients at three wavelengths with as much absorption by blood as gives a stroma of [`MATCHED_MM`] under a border
/// layer without pigment the colour that it has by all of them: three numbers for three channels. Those of [`TissueCoefficients::few`] are up to a ΔE2000 of 12 off, as
/// blood's bands are narrower than what lies between three nodes.
pub(crate) fn matched(pigment: &IrisPigment, few: &Wavelengths<3>) -> [TissueCoefficients; 3] {
    let tissue = TissueCoefficients::few(few);
    if pigment.stroma_blood_fraction <= 0.0 {
        return tissue;
    }
    // Under a border layer without pigment, as it is seen.
    let of = |tissue: &TissueCoefficients| reflectance_of(pigment, MATCHED_MM, 0.0, tissue);
    let spectrum = spectrum_from(|nm| of(&TissueCoefficients::at(nm)));
    let color = DVec3::from(spectrum_to_linear_srgb(&spectrum));
    let row = |channel: usize| DVec3::from(few.weights[channel]);
    let weights = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    let wanted = weights.inverse() * color;
    core::array::from_fn(|i| {
        let with = |blood_absorption: f64| TissueCoefficients {
            blood_absorption,
            ..tissue[i]
        };
        // More of it, less light: halved to the last bits.
        let (mut low, mut high) = (0.0, MOST_BLOOD_PER_MM);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if of(&with(middle)) > wanted[i] {
                low = middle;
            } else {
                high = middle;
            }
        }
        with(0.5 * (low + high))
    })
}

/// More than blood absorbs anywhere, mm⁻¹.
const MOST_BLOOD_PER_MM: f64 = 400.0;

impl IrisTissue {
    /// The coefficients of this pigment.
    pub fn new(pigment: &IrisPigment) -> Self {
        let pigment = pigment.clamped();
        let few = Wavelengths::<3>::new();
        let tissue = matched(&pigment, &few);
        let of =
            |value: &dyn Fn(&TissueCoefficients) -> f64| DVec3::from(tissue.each_ref().map(value));
        let border = |density: f64| {
            move |t: &TissueCoefficients| peakless_border_layer(&pigment, density, t)
        };
        let (bare, dense) = (border(0.0), border(1.0));
        let stroma = |t: &TissueCoefficients| peakless_stroma(&pigment, 1.0, t);
        let row = |channel: usize| DVec3::from(few.weights[channel]);
        Self {
            border: of(&|t| bare(t).extinction()),
            border_melanin: of(&|t| dense(t).absorption - bare(t).absorption),
            border_scattering: of(&|t| bare(t).scattering),
            border_fibrils: of(&|t| bare(t).phase.rayleigh_share()),
            stroma: of(&|t| stroma(t).extinction()),
            stroma_scattering: of(&|t| stroma(t).scattering),
            stroma_fibrils: of(&|t| stroma(t).phase.rayleigh_share()),
            weights: DMat3::from_cols(row(0), row(1), row(2)).transpose(),
        }
    }
}

/// [`iris_reflectance`] on a grid: columns along the path, rows along the border layer's density.
///
/// Values belong to texel centres: column `i` of `w` stands for the path
/// `STROMA_PATH_MAX_MM (i + ½)/w`, row `j` of `h` for the density `((j + ½)/h)²`, so that a linear
/// texture lookup at `(path/STROMA_PATH_MAX_MM, √density)` reads the right place: a little melanin changes most.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisReflectanceTable {
    rgb: Vec<[f64; 3]>,
    width: usize,
    height: usize,
}

/// Columns and rows of each of the two tables ([`IrisReflectanceTable::seen`]) that the picture uses: within ΔE2000 2.4 of the
/// function at 99.9 % of a hazel iris's places, 3.7 at the worst, 0.16 in the mean square.
pub const IRIS_TABLE: [usize; 2] = [64, 32];

/// Layers of many thicknesses, each by itself.
fn each<L>(
    of: impl Fn(&IrisPigment, f64, &TissueCoefficients) -> L,
) -> impl Fn(&IrisPigment, &[f64], &TissueCoefficients) -> Vec<L> {
    move |pigment, all, tissue| all.iter().map(|one| of(pigment, *one, tissue)).collect()
}

impl IrisReflectanceTable {
    /// Computes the table of [`iris_reflectance`]; a size of 0 counts as 1.
    pub fn new(pigment: &IrisPigment, width: usize, height: usize) -> Self {
        let [rgb] = Self::stacked(
            pigment,
            width,
            height,
            border_layer,
            each(stroma),
            |above, below| [over_black(*above, *below)],
        );
        Self {
            rgb,
            width: width.max(1),
            height: height.max(1),
        }
    }

    /// Computes the table of [`iris_reflectance_many_flux`]; a size of 0 counts as 1.
    pub fn many_flux(pigment: &IrisPigment, width: usize, height: usize) -> Self {
        let [rgb] = Self::stacked(
            pigment,
            width,
            height,
            many_flux_border_layer,
            each(many_flux_stroma),
            |above, below| [above.reflectance_over(below)],
        );
        Self {
            rgb,
            width: width.max(1),
            height: height.max(1),
        }
    }

    /// Computes the tables of [`iris_reflectance_seen`]: of all light, and of what is scattered more than once. A size of 0
    /// counts as 1.
    pub fn seen(pigment: &IrisPigment, width: usize, height: usize) -> [Self; 2] {
        let stacked = Self::stacked(
            pigment,
            width,
            height,
            SeenLayer::border,
            SeenLayer::stromas,
            SeenLayer::over,
        );
        stacked.map(|rgb| Self {
            rgb,
            width: width.max(1),
            height: height.max(1),
        })
    }

    /// The stroma does not depend on the row nor the border layer on the column: what costs is
    /// computed once for each column and each row, and a texel only stacks the two.
    fn stacked<L, const K: usize>(
        pigment: &IrisPigment,
        width: usize,
        height: usize,
        border_layer: impl Fn(&IrisPigment, f64, &TissueCoefficients) -> L,
        stromas: impl Fn(&IrisPigment, &[f64], &TissueCoefficients) -> Vec<L>,
        over_black: impl Fn(&L, &L) -> [f64; K],
    ) -> [Vec<[f64; 3]>; K] {
        let (width, height) = (width.max(1), height.max(1));
        let pigment = pigment.clamped();
        let paths: Vec<f64> = (0..width)
            .map(|column| STROMA_PATH_MAX_MM * (column as f64 + 0.5) / width as f64)
            .collect();
        let stromas =
            AT.1.each_ref()
                .map(|tissue| stromas(&pigment, &paths, tissue));
        let mut rgb: [Vec<[f64; 3]>; K] =
            core::array::from_fn(|_| Vec::with_capacity(width * height));
        for row in 0..height {
            let root = (row as f64 + 0.5) / height as f64;
            let density = root * root;
            let border =
                AT.1.each_ref()
                    .map(|tissue| border_layer(&pigment, density, tissue));
            let at = |column: usize| -> [[f64; K]; IRIS_WAVELENGTHS] {
                core::array::from_fn(|i| over_black(&border[i], &stromas[i][column]))
            };
            for found in (0..width).map(at) {
                for (k, rgb) in rgb.iter_mut().enumerate() {
                    rgb.push(colour(&found.map(|one| one[k])));
                }
            }
        }
        rgb
    }

    /// Linear sRGB reflectances, row after row.
    pub fn rgb(&self) -> &[[f64; 3]] {
        &self.rgb
    }

    /// Columns: paths.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows: densities of the border layer.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The table's value, linear between texel centres and constant beyond the outermost ones, as a
    /// texture lookup gives it.
    pub fn sample(&self, path_mm: f64, density: f64) -> [f64; 3] {
        let (column, across) = lattice(path_mm / STROMA_PATH_MAX_MM, self.width);
        let (row, down) = lattice(density.max(0.0).sqrt(), self.height);
        let (right, below) = (
            (column + 1).min(self.width - 1),
            (row + 1).min(self.height - 1),
        );
        let at = |c: usize, r: usize| self.rgb[r * self.width + c];
        let corners = [
            at(column, row),
            at(right, row),
            at(column, below),
            at(right, below),
        ];
        core::array::from_fn(|i| {
            let top = corners[0][i] + across * (corners[1][i] - corners[0][i]);
            let bottom = corners[2][i] + across * (corners[3][i] - corners[2][i]);
            top + down * (bottom - top)
        })
    }
}

/// Texel before the coordinate `u` (0 to 1) and the fraction of the way to the next.
fn lattice(u: f64, size: usize) -> (usize, f64) {
    let u = if u.is_nan() { 0.0 } else { u };
    let position = (u * size as f64 - 0.5).clamp(0.0, (size - 1) as f64);
    (position.floor() as usize, position.fract())
}

#[cfg(test)]
mod tests;
