//! Light in tissue: phase functions, single scattering in layers.

use super::{between, pass, v3};
use crate::gpu::Twin;
use ocularium::tissue::{layers, phase};
use rand_pcg::Pcg64;

/// A cosine, a mean cosine up to either peak.
fn angle_and_mean(rng: &mut Pcg64) -> Vec<f32> {
    vec![between(rng, -1.0, 1.0), between(rng, -1.0, 1.0)]
}

#[test]
fn phase_functions() {
    pass(&Twin {
        name: "phase_rayleigh",
        library: &["phase"],
        call: "y[0] = phase_rayleigh(x[0]);",
        draw: &|rng| vec![between(rng, -1.0, 1.0)],
        exact: &|x| vec![phase::phase_rayleigh(x[0])],
        absolute: 0.0,
        relative: 5e-7,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "phase_henyey_greenstein",
        library: &["phase"],
        call: "y[0] = phase_henyey_greenstein(x[0], x[1]);",
        draw: &angle_and_mean,
        exact: &|x| vec![phase::phase_henyey_greenstein(x[0], x[1])],
        // Seven roundings and a square root; the peak included.
        absolute: 0.0,
        relative: 1.5e-6,
        steep_share: 0.001,
    });
}

#[test]
fn layers_scatter_once() {
    let rgb = |call: &str| format!("let c = {call}; y[0] = c.x; y[1] = c.y; y[2] = c.z;");
    let powers = |rng: &mut Pcg64, n: usize, low: f32, high: f32| -> Vec<f32> {
        (0..n)
            .map(|_| 10.0_f32.powf(between(rng, low, high)))
            .collect()
    };
    pass(&Twin {
        name: "layer_mean_transmittance",
        library: &["layers"],
        call: &rgb("layer_mean_transmittance(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]))"),
        draw: &|rng| {
            // Ends apart by anything from nothing to twice the start, either way.
            let start = powers(rng, 3, -6.0, 1.0);
            let apart = powers(rng, 3, -8.0, 0.3);
            let end = start.iter().zip(apart).map(|(a, b)| a * (1.0 + b));
            let (start, end): (Vec<f32>, Vec<f32>) = (start.clone(), end.collect());
            if between(rng, 0.0, 1.0) < 0.5 {
                [start, end].concat()
            } else {
                [end, start].concat()
            }
        },
        exact: &|x| {
            layers::layer_mean_transmittance(v3(x), v3(&x[3..]))
                .to_array()
                .to_vec()
        },
        // e^−x carries the rounding of x, twice where it goes through exp2: 4e-6 at 30.
        absolute: 1e-12,
        relative: 4e-6,
        steep_share: 0.01,
    });
}
