//! How much of an iris's light has been scattered once, and what the estimates miss.
//!
//! In: pigment, thickness of the stroma, density of the border layer, number of walks and a seed.
//! Out: the diffuse reflectance, by wavelength and in linear sRGB, by five methods that see the
//! same two layers over a black epithelium in diffuse light: single scattering in closed form
//! ([`super::layers`]), the two-flux estimate ([`super::slab`]), many fluxes without noise
//! ([`super::many_flux`]), random walks with any number of scatterings ([`super::random_walk`]),
//! and the same walks with the real phase functions in place of reduced isotropic scattering:
//! Rayleigh for the fibrils, Henyey & Greenstein with [`super::iris_layers::BUNDLE_MEAN_COSINE`]
//! for the bundles. The last says what the similarity relation σ_s (1 − g) = σ_s′, on which the
//! others stand, costs.

use super::iris_layers::{forward_layers, reduced_layers};
use super::iris_reflectance::{IRIS_WAVELENGTHS, IrisPigment, reflectance_of, within_range};
use super::layers::{Layer, stack_diffuse_reflectance_once};
use super::many_flux::stack_many_flux;
use super::melanin::TissueCoefficients;
use super::random_walk::{Estimate, Illumination, random_walk};
use super::wavelengths::Wavelengths;

/// Weights of linear sRGB in luminance (IEC 61966-2-1).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Diffuse reflectance of an iris at one wavelength by each method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WavelengthScattering {
    /// Wavelength (nm).
    pub nm: f64,
    /// Scattered exactly once, closed form.
    pub single: f64,
    /// Two-flux estimate.
    pub two_flux: f64,
    /// Any number of scatterings, reduced isotropic, with 16 nodes a hemisphere: error below 1e-6.
    pub many_flux: f64,
    /// The same with the phase functions of fibrils and bundles: error below 1e-6.
    pub many_flux_forward: f64,
    /// Any number of scatterings, reduced isotropic, by random walks.
    pub all_orders: Estimate,
    /// The same with the phase functions of fibrils and bundles.
    pub all_orders_forward: Estimate,
}

/// Diffuse reflectance of an iris by each method.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisScattering {
    /// By wavelength.
    pub by_wavelength: [WavelengthScattering; IRIS_WAVELENGTHS],
    /// Scattered exactly once (linear sRGB, not clamped).
    pub single: [f64; 3],
    /// Two-flux estimate (linear sRGB, not clamped).
    pub two_flux: [f64; 3],
    /// Any number of scatterings, reduced isotropic (linear sRGB, not clamped), without noise.
    pub many_flux: [f64; 3],
    /// The same with the phase functions of fibrils and bundles.
    pub many_flux_forward: [f64; 3],
    /// Any number of scatterings, reduced isotropic (linear sRGB with standard errors).
    pub all_orders: [Estimate; 3],
    /// The same with the phase functions of fibrils and bundles.
    pub all_orders_forward: [Estimate; 3],
    /// Collisions in all walks.
    pub collisions: u64,
}

fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(LUMINANCE).map(|(c, w)| c * w).sum()
}

impl IrisScattering {
    /// Luminance that single scattering misses, as a share of the luminance with all orders (by
    /// many fluxes), 0 to 1.
    pub fn missed_by_single_scattering(&self) -> f64 {
        1.0 - self.ratio(self.single)
    }

    /// Error of the two-flux estimate's luminance, as a share of the luminance with all orders;
    /// positive where it is too bright.
    pub fn two_flux_error(&self) -> f64 {
        self.ratio(self.two_flux) - 1.0
    }

    /// Change of the luminance by the real phase functions, as a share of that with reduced
    /// isotropic scattering.
    pub fn similarity_error(&self) -> f64 {
        self.ratio(self.many_flux_forward) - 1.0
    }

    fn ratio(&self, rgb: [f64; 3]) -> f64 {
        luminance(rgb) / luminance(self.many_flux).max(1e-12)
    }
}

/// Compares the methods for one iris: stroma `thickness_mm` thick (0 to 1,000; outside it is
/// clamped), border layer of relative density 0 to 1, `walks` random walks a wavelength and kind.
pub fn iris_scattering(
    pigment: &IrisPigment,
    thickness_mm: f64,
    density: f64,
    walks: u32,
    seed: u64,
) -> IrisScattering {
    let pigment = pigment.clamped();
    let (thickness_mm, density) = within_range(thickness_mm, density);
    let few = Wavelengths::<IRIS_WAVELENGTHS>::new();
    let tissues = TissueCoefficients::few(&few);
    let mut collisions = 0;
    let mut by_wavelength = [WavelengthScattering::default(); IRIS_WAVELENGTHS];
    for (i, at) in by_wavelength.iter_mut().enumerate() {
        let tissue = tissues[i];
        let reduced = reduced_layers(&pigment, thickness_mm, density, &tissue);
        let forward = forward_layers(&pigment, thickness_mm, density, &tissue);
        // A stream of its own for every wavelength and kind: their errors are independent.
        let mut walk = |layers: &[Layer], stream: u64| {
            let seed = seed.wrapping_mul(32).wrapping_add(stream);
            let walk = random_walk(layers, Illumination::Diffuse, walks, seed);
            collisions += walk.collisions;
            walk.reflectance
        };
        *at = WavelengthScattering {
            nm: few.nm[i],
            single: stack_diffuse_reflectance_once(&reduced),
            two_flux: reflectance_of(&pigment, thickness_mm, density, &tissue),
            many_flux: stack_many_flux::<16>(&reduced).reflectance,
            many_flux_forward: stack_many_flux::<16>(&forward).reflectance,
            all_orders: walk(&reduced, i as u64),
            all_orders_forward: walk(&forward, 16 + i as u64),
        };
    }
    let colour = |pick: &dyn Fn(&WavelengthScattering) -> f64| {
        few.linear_srgb(&by_wavelength.each_ref().map(pick))
    };
    let estimate = |pick: &dyn Fn(&WavelengthScattering) -> Estimate| {
        let mean = colour(&|at| pick(at).mean);
        core::array::from_fn(|channel| {
            let variance: f64 = by_wavelength
                .iter()
                .zip(few.weights[channel])
                .map(|(at, weight)| (weight * pick(at).standard_error).powi(2))
                .sum();
            Estimate {
                mean: mean[channel],
                standard_error: variance.sqrt(),
            }
        })
    };
    IrisScattering {
        by_wavelength,
        single: colour(&|at| at.single),
        two_flux: colour(&|at| at.two_flux),
        many_flux: colour(&|at| at.many_flux),
        many_flux_forward: colour(&|at| at.many_flux_forward),
        all_orders: estimate(&|at| at.all_orders),
        all_orders_forward: estimate(&|at| at.all_orders_forward),
        collisions,
    }
}

/// [`iris_scattering`] for the four irises of the app, stroma 0.45 mm thick, border layer half
/// dense.
pub fn iris_scattering_of_presets(walks: u32, seed: u64) -> [(&'static str, IrisScattering); 4] {
    [
        ("blue", IrisPigment::BLUE),
        ("green", IrisPigment::GREEN),
        ("hazel", IrisPigment::HAZEL),
        ("brown", IrisPigment::BROWN),
    ]
    .map(|(name, pigment)| (name, iris_scattering(&pigment, 0.45, 0.5, walks, seed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_scattering_misses_most_of_a_pale_iris_and_little_of_a_dark_one() {
        let presets = iris_scattering_of_presets(20_000, 1);
        for (name, iris) in &presets {
            println!(
                "{name}: single {:.4?} two-flux {:.4?} many-flux {:.4?} all {:.4?} ± {:.4?} forward {:.4?} ± {:.4?}; single misses {:.1} %, two-flux {:+.1} %, similarity {:+.1} %",
                iris.single,
                iris.two_flux,
                iris.many_flux,
                iris.all_orders.map(|c| c.mean),
                iris.all_orders.map(|c| c.standard_error),
                iris.all_orders_forward.map(|c| c.mean),
                iris.all_orders_forward.map(|c| c.standard_error),
                100.0 * iris.missed_by_single_scattering(),
                100.0 * iris.two_flux_error(),
                100.0 * iris.similarity_error(),
            );
        }
        let [blue, green, hazel, brown] = presets.map(|(_, iris)| iris);
        for iris in [&blue, &green, &hazel, &brown] {
            for at in &iris.by_wavelength {
                let noise = 4.0 * at.all_orders.standard_error;
                assert!(
                    (at.all_orders.mean - at.many_flux).abs() < noise + 1e-5,
                    "{at:?}"
                );
                assert!(
                    at.single > 0.0
                        && at.single < at.all_orders.mean + 4.0 * at.all_orders.standard_error
                );
            }
        }
        let missed = |iris: &IrisScattering| iris.missed_by_single_scattering();
        assert!(missed(&blue) > missed(&hazel) && missed(&green) > missed(&hazel));
        // Blood takes what is scattered often first, and green irises have the least of it.
        let bare = |pigment: IrisPigment| {
            let pigment = IrisPigment {
                stroma_blood_fraction: 0.0,
                ..pigment
            };
            missed(&iris_scattering(&pigment, 0.45, 0.5, 2_000, 1))
        };
        assert!(bare(IrisPigment::BLUE) > bare(IrisPigment::GREEN));
        assert!(bare(IrisPigment::GREEN) > missed(&hazel));
        assert!(missed(&hazel) > missed(&brown));
        assert!(iris_scattering(&IrisPigment::BLUE, f64::NAN, f64::NAN, 10, 1).single[0] > 0.0);
    }

    #[test]
    fn the_first_order_of_the_walks_is_the_closed_form() {
        let tissue = TissueCoefficients::at(500.0);
        let layers = reduced_layers(&IrisPigment::GREEN, 0.45, 0.5, &tissue);
        let walk = random_walk(&layers, Illumination::Diffuse, 200_000, 3);
        let (once, closed) = (
            walk.reflected_by_order[0],
            stack_diffuse_reflectance_once(&layers),
        );
        assert!((once.mean - closed).abs() < 4.0 * once.standard_error + 1e-6);
    }

    #[test]
    fn the_two_flux_column_is_what_the_app_shows() {
        let iris = iris_scattering(&IrisPigment::HAZEL, 0.45, 0.5, 2, 1);
        let shown =
            super::super::iris_reflectance::iris_reflectance(&IrisPigment::HAZEL, 0.45, 0.5);
        assert_eq!(iris.two_flux, shown);
    }
}
