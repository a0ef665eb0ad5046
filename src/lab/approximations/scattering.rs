//! Light scattered in an iris: orders of scattering, and single scattering along a segment.

use super::colour::{Iris, irises, two_flux};
use super::rows::{ErrorRow, Task};
use super::timing::Stopwatch;
use crate::tissue::iris_layers::reduced_layers;
use crate::tissue::layers::{Layer, layer_mean_transmittance, stack_diffuse_reflectance_once};
use crate::tissue::many_flux::stack_many_flux;
use crate::tissue::melanin::TissueCoefficients;
use crate::tissue::random_walk::{Illumination, random_walk};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// An iris at one wavelength.
struct Stack {
    iris: Iris,
    tissue: TissueCoefficients,
    layers: [Layer; 2],
    reflectance: f64,
    seed: u64,
}

/// Diffuse reflectance with any number of scatterings; `count` irises, up to `walks` random walks.
pub fn reflectance(stopwatch: &Stopwatch, count: usize, most_walks: u32) -> Task {
    let mut random = Pcg64::seed_from_u64(14);
    let cases: Vec<Stack> = irises(count, 15)
        .into_iter()
        .map(|iris| {
            let tissue = TissueCoefficients::at(random.random_range(400.0..700.0));
            let layers = reduced_layers(&iris.pigment, iris.path_mm, iris.density, &tissue);
            Stack {
                iris,
                tissue,
                layers,
                reflectance: stack_many_flux::<24>(&layers).reflectance,
                seed: random.random(),
            }
        })
        .collect();
    let error = |case: &Stack, reflectance: f64| reflectance - case.reflectance;
    let mut rows = vec![
        stopwatch.row(
            ("single scattering", "closed form", 0),
            &cases,
            |case| stack_diffuse_reflectance_once(&case.layers),
            error,
        ),
        stopwatch.row(
            ("two-flux", 2, 0),
            &cases,
            |case| two_flux(&case.iris, &case.tissue),
            error,
        ),
        many::<1>(stopwatch, &cases),
        many::<2>(stopwatch, &cases),
        many::<3>(stopwatch, &cases),
        many::<4>(stopwatch, &cases),
        many::<6>(stopwatch, &cases),
        many::<8>(stopwatch, &cases),
        many::<16>(stopwatch, &cases),
    ];
    let mut walks = 100;
    while walks <= most_walks {
        let run = |case: &Stack| {
            random_walk(&case.layers, Illumination::Diffuse, walks, case.seed)
                .reflectance
                .mean
        };
        rows.push(stopwatch.row(("random walks", walks, 0), &cases, run, error));
        walks *= 10;
    }
    Task {
        name: "iris-reflectance".to_owned(),
        title: "Diffuse reflectance of an iris".to_owned(),
        call: "one iris at one wavelength".to_owned(),
        domain: format!(
            "{count} seeded irises of every legal melanin, without blood, at 400 to 700 nm; reduced isotropic scattering; \
             diffuse light; path 0 to 2.5 mm"
        ),
        reference: "many fluxes with 24 nodes a hemisphere".to_owned(),
        unit: "reflectance".to_owned(),
        rows,
    }
}

fn many<const N: usize>(stopwatch: &Stopwatch, cases: &[Stack]) -> ErrorRow {
    let run = |case: &Stack| stack_many_flux::<N>(&case.layers).reflectance;
    let error = |case: &Stack, reflectance: f64| reflectance - case.reflectance;
    stopwatch.row(("many fluxes", N, 0), cases, run, error)
}

/// A straight way through a layer and the light's ways to it.
struct Segment {
    extinction: DVec3,
    scattering: DVec3,
    length: f64,
    light_start: f64,
    light_end: f64,
    exact: DVec3,
}

impl Segment {
    /// The integrand of single scattering at a share of the way.
    fn at(&self, t: f64) -> DVec3 {
        let light = self.light_start + t * (self.light_end - self.light_start);
        (-self.extinction * (light + t * self.length)).exp()
    }

    fn march(&self, steps: u32) -> DVec3 {
        let step = 1.0 / f64::from(steps);
        let mut sum = DVec3::ZERO;
        for i in 0..steps {
            sum += self.at((f64::from(i) + 0.5) * step);
        }
        self.scattering * sum * (self.length * step)
    }

    /// Gauss and Legendre, 5 points on each of 64 panels: rounding only, with less than an optical
    /// depth a panel.
    fn quadrature(&self) -> DVec3 {
        const HALF: [(f64, f64); 2] = [
            (0.269_234_655_052_841_5, 0.239_314_335_249_683_23),
            (0.453_089_922_969_332, 0.118_463_442_528_094_54),
        ];
        const MIDDLE: f64 = 0.284_444_444_444_444_44;
        const PANELS: u32 = 64;
        let mut sum = DVec3::ZERO;
        for panel in 0..PANELS {
            let at = |u: f64| self.at((f64::from(panel) + u) / f64::from(PANELS));
            sum += MIDDLE * at(0.5);
            for (off, weight) in HALF {
                sum += weight * (at(0.5 - off) + at(0.5 + off));
            }
        }
        self.scattering * sum * (self.length / f64::from(PANELS))
    }
}

fn segments(count: usize) -> Vec<Segment> {
    let mut random = Pcg64::seed_from_u64(16);
    (0..count)
        .map(|_| {
            let mut colour = |most: f64| {
                DVec3::from_array([most; 3]) * {
                    let [r, g, b] = core::array::from_fn(|_| random.random::<f64>());
                    DVec3::new(r, g, b)
                }
            };
            let scattering = colour(8.0);
            let extinction = scattering + colour(12.0);
            let way = colour(1.0);
            let mut segment = Segment {
                extinction,
                scattering,
                length: way.x,
                light_start: way.y,
                light_end: way.z,
                exact: DVec3::ZERO,
            };
            segment.exact = segment.quadrature();
            segment
        })
        .collect()
}

/// Single scattering along a segment: marches and the closed form; `count` segments.
pub fn segment(stopwatch: &Stopwatch, count: usize) -> Task {
    let cases = segments(count);
    let error =
        |case: &Segment, light: DVec3| ((light - case.exact) / case.exact).abs().max_element();
    let mut rows = Vec::new();
    for steps in [1, 2, 4, 8, 16, 32, 64, 256, 1024, 4096] {
        let run = |case: &Segment| case.march(steps);
        rows.push(stopwatch.row(("march", steps, 0), &cases, run, error));
    }
    let run = |case: &Segment| {
        let start = case.extinction * case.light_start;
        let end = case.extinction * (case.light_end + case.length);
        case.scattering * case.length * layer_mean_transmittance(start, end)
    };
    rows.push(stopwatch.row(("closed form", "exact", 0), &cases, run, error));
    Task {
        name: "segment".to_owned(),
        title: "Single scattering along a segment".to_owned(),
        call: "three colours of one segment".to_owned(),
        domain: format!(
            "{count} seeded segments of 0 to 1 mm; light's ways 0 to 1 mm; scattering to 8 and absorption \
             to 12 per mm"
        ),
        reference: "Gauss–Legendre quadrature with 320 points (largest of the colours)".to_owned(),
        unit: "relative".to_owned(),
        rows,
    }
}
