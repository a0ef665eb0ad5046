use super::super::phase::PhaseMix;
use super::*;
use crate::tissue::layers::stack_transmittance;
use core::f64::consts::PI;
use proptest::prelude::*;

/// A layer by albedo and optical depth.
fn layer(albedo: f64, depth: f64, phase: PhaseMix) -> Layer {
    Layer {
        absorption: 1.0 - albedo,
        scattering: albedo,
        thickness_mm: depth,
        phase,
    }
}

/// Within four standard errors and `extra`: one seed in 16,000 fails by chance, and seeds are
/// fixed.
fn agrees(estimate: Estimate, expected: f64, extra: f64) {
    let off = (estimate.mean - expected).abs();
    assert!(
        off < 4.0 * estimate.standard_error + extra,
        "{estimate:?} against {expected}"
    );
}

#[test]
fn a_white_furnace_returns_everything() {
    // Without absorption nothing is lost: every walk ends outside, with the weight 1.
    let white = [
        layer(1.0, 0.5, PhaseMix::RAYLEIGH),
        layer(1.0, 2.0, PhaseMix::henyey_greenstein(0.8)),
        layer(1.0, 1.0, PhaseMix::ISOTROPIC),
    ];
    for illumination in [Illumination::Diffuse, Illumination::Beam(0.3)] {
        let walk = random_walk(&white, illumination, 10_000, 1);
        let back = walk.reflectance.mean + walk.transmittance.mean;
        assert!((back - 1.0).abs() <= f64::EPSILON, "{back}");
        assert!(walk.absorbed.iter().all(|a| *a == Estimate::default()));
        assert_eq!(walk.unfinished, 0.0);
    }
}

#[test]
fn the_books_of_every_run_add_up() {
    for (albedo, depth) in [(0.3, 0.7), (0.9, 5.0), (0.999, 50.0), (0.0, 2.0)] {
        let stack = [
            layer(albedo, depth, PhaseMix::henyey_greenstein(0.5)),
            layer(0.5 * albedo, 0.3, PhaseMix::ISOTROPIC),
        ];
        let walk = random_walk(&stack, Illumination::Diffuse, 20_000, 5);
        // Rounding of 2e4 sums of numbers up to 1.
        assert!((walk.total() - 1.0).abs() < 1e-12, "{}", walk.total());
        let orders: f64 = walk.reflected_by_order.iter().map(|o| o.mean).sum();
        assert!((orders - walk.reflectance.mean).abs() < 1e-12);
    }
}

#[test]
fn without_scattering_it_is_beer_and_lambert() {
    let stack = [
        layer(0.0, 0.4, PhaseMix::ISOTROPIC),
        layer(0.0, 0.8, PhaseMix::ISOTROPIC),
    ];
    let walk = random_walk(&stack, Illumination::Beam(0.6), 100_000, 2);
    agrees(walk.transmittance, stack_transmittance(&stack, 0.6), 0.0);
    agrees(walk.absorbed[0], 1.0 - (-0.4_f64 / 0.6).exp(), 0.0);
    assert_eq!(walk.transmittance, walk.direct_transmittance);
    assert_eq!(walk.reflectance.mean, 0.0);
    // Diffuse light: 2 E₃(1.2) = 2 · 0.0834471… by quadrature of 2 µ e^(−1.2/µ).
    let steps = 100_000;
    let expected: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
        .map(|mu| 2.0 * mu * (-1.2 / mu).exp() / f64::from(steps))
        .sum();
    let walk = random_walk(&stack, Illumination::Diffuse, 100_000, 2);
    agrees(walk.transmittance, expected, 1e-9);
}

#[test]
fn van_de_hulsts_slab() {
    // Multiple Light Scattering (1980), table 35: albedo 0.9, g 0.75, depth 2, normal incidence,
    // matched: reflected 0.09739, passed 0.66096. (Adding and doubling with 48 streams, done apart
    // from this code, gives 0.097395 and 0.660958; the 0.09734 often quoted is a Monte Carlo's
    // own.)
    let slab = [layer(0.9, 2.0, PhaseMix::henyey_greenstein(0.75))];
    let walk = random_walk(&slab, Illumination::Beam(1.0), 400_000, 3);
    println!("{:?} {:?}", walk.reflectance, walk.transmittance);
    agrees(walk.reflectance, 0.097_395, 0.0);
    agrees(walk.transmittance, 0.660_958, 0.0);
    agrees(walk.direct_transmittance, (-2.0_f64).exp(), 0.0);
    assert!(walk.reflectance.standard_error < 5e-4);
    // Diffuse light, by the same adding and doubling.
    let walk = random_walk(&slab, Illumination::Diffuse, 200_000, 3);
    agrees(walk.reflectance, 0.191_090, 0.0);
    agrees(walk.transmittance, 0.501_816, 0.0);
}

#[test]
fn isotropic_slabs_by_adding_and_doubling() {
    for (albedo, depth, reflected, passed) in [
        (0.9, 1.0, 0.267_410, 0.591_625),
        (0.99, 4.0, 0.645_047, 0.275_480),
    ] {
        let slab = [layer(albedo, depth, PhaseMix::ISOTROPIC)];
        let walk = random_walk(&slab, Illumination::Beam(1.0), 150_000, 4);
        agrees(walk.reflectance, reflected, 0.0);
        agrees(walk.transmittance, passed, 0.0);
        // Cut into pieces it is the same slab.
        let half = layer(albedo, 0.5 * depth, PhaseMix::ISOTROPIC);
        let cut = random_walk(&[half, half], Illumination::Beam(1.0), 150_000, 44);
        agrees(cut.reflectance, reflected, 0.0);
    }
}

/// Chandrasekhar's H for isotropic scattering by iteration of
/// 1/H(µ) = √(1−ω) + ω/2 ∫ µ′H(µ′)/(µ+µ′) dµ′, midpoints in √µ; H at 1 and ∫ H µ dµ.
fn h_function(albedo: f64) -> (f64, f64) {
    let n = 400;
    let nodes: Vec<(f64, f64)> = (0..n)
        .map(|i| (f64::from(i) + 0.5) / f64::from(n))
        .map(|s| (s * s, 2.0 * s / f64::from(n)))
        .collect();
    let mut h = vec![1.0; nodes.len()];
    let inverse = |mu: f64, h: &[f64]| {
        let sum: f64 = nodes
            .iter()
            .zip(h)
            .map(|((x, w), h)| w * x * h / (mu + x))
            .sum();
        (1.0 - albedo).sqrt() + 0.5 * albedo * sum
    };
    for _ in 0..40 {
        h = nodes.iter().map(|(mu, _)| 1.0 / inverse(*mu, &h)).collect();
    }
    let moment = nodes.iter().zip(&h).map(|((x, w), h)| w * x * h).sum();
    (1.0 / inverse(1.0, &h), moment)
}

#[test]
fn a_half_space_has_chandrasekhars_albedo() {
    // Plane albedo 1 − √(1−ω) H(µ₀), spherical albedo 1 − 2 √(1−ω) ∫ H µ dµ (Radiative Transfer,
    // chapter V).
    for (albedo, at_one) in [(0.5, 1.251_260), (0.8, 1.598_220), (0.9, 1.850_099)] {
        let (h, moment) = h_function(albedo);
        assert!((h - at_one).abs() < 2e-5, "{h}");
        let root = f64::sqrt(1.0 - albedo);
        let deep = [layer(albedo, 1e9, PhaseMix::ISOTROPIC)];
        let walk = random_walk(&deep, Illumination::Beam(1.0), 100_000, 6);
        agrees(walk.reflectance, 1.0 - root * h, 2e-5);
        let walk = random_walk(&deep, Illumination::Diffuse, 100_000, 6);
        agrees(walk.reflectance, 1.0 - 2.0 * root * moment, 2e-5);
        assert_eq!(walk.transmittance.mean, 0.0);
    }
}

#[test]
fn single_scattering_is_the_closed_form() {
    // First order of a beam, integrated over the hemisphere in front, against layers.rs.
    use crate::tissue::layers::stack_reflect_once;
    let stack = [
        layer(0.3, 0.2, PhaseMix::RAYLEIGH),
        layer(0.95, 1.4, PhaseMix::new(0.3, 0.2, 0.6)),
    ];
    let cos_in: f64 = 0.6;
    let sin_in = (1.0 - cos_in * cos_in).sqrt();
    let (rings, spokes) = (400, 64);
    let mut expected = 0.0;
    for ring in 0..rings {
        let cos = (f64::from(ring) + 0.5) / f64::from(rings);
        let sin = (1.0 - cos * cos).sqrt();
        for spoke in 0..spokes {
            let azimuth = 2.0 * PI * (f64::from(spoke) + 0.5) / f64::from(spokes);
            // The light goes down, the scattered light up.
            let scatter = -cos * cos_in + sin * sin_in * azimuth.cos();
            let solid_angle = 2.0 * PI / f64::from(spokes) / f64::from(rings);
            expected += stack_reflect_once(&stack, cos_in, cos, scatter) * cos * solid_angle;
        }
    }
    let walk = random_walk(&stack, Illumination::Beam(cos_in), 300_000, 7);
    agrees(walk.reflected_by_order[0], expected, 1e-5);
    let share = walk.reflected_by_order[0].mean / walk.reflectance.mean;
    assert!(share > 0.3 && share < 0.9, "{share}");
}

#[test]
fn similar_slabs_reflect_alike() {
    // σ_s (1 − g) the same: van de Hulst's similarity is an approximation, good to 0.01 where
    // scattering is many-fold, and a wrong rotation of directions would miss by 0.3.
    let forward = Layer {
        absorption: 0.02,
        scattering: 50.0,
        thickness_mm: 1.0,
        phase: PhaseMix::henyey_greenstein(0.9),
    };
    let isotropic = Layer {
        scattering: 5.0,
        phase: PhaseMix::ISOTROPIC,
        ..forward
    };
    let a = random_walk(&[forward], Illumination::Diffuse, 10_000, 8).reflectance;
    let b = random_walk(&[isotropic], Illumination::Diffuse, 10_000, 8).reflectance;
    assert!((a.mean - b.mean).abs() < 0.02, "{a:?} {b:?}");
}

#[test]
fn the_standard_error_is_the_spread_over_seeds() {
    let stack = [
        layer(0.9, 1.0, PhaseMix::henyey_greenstein(0.6)),
        layer(0.6, 1.0, PhaseMix::ISOTROPIC),
    ];
    let runs: Vec<RandomWalk> = (0..200)
        .map(|seed| random_walk(&stack, Illumination::Diffuse, 2000, 1000 + seed))
        .collect();
    let check = |pick: &dyn Fn(&RandomWalk) -> Estimate| {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|r| pick(r).mean).sum::<f64>() / n;
        let spread = (runs
            .iter()
            .map(|r| (pick(r).mean - mean).powi(2))
            .sum::<f64>()
            / (n - 1.0))
            .sqrt();
        let stated = runs.iter().map(|r| pick(r).standard_error).sum::<f64>() / n;
        // The spread of 200 runs is itself known to 1/√400 = 5 %; three times that.
        assert!((spread / stated - 1.0).abs() < 0.15, "{spread} {stated}");
    };
    check(&|r| r.reflectance);
    check(&|r| r.transmittance);
    check(&|r| r.absorbed[0]);
    check(&|r| r.absorbed[1]);
    check(&|r| r.reflected_by_order[1]);
}

#[test]
fn the_same_seed_gives_the_same_numbers() {
    let stack = [layer(0.9, 1.0, PhaseMix::RAYLEIGH)];
    let run = |seed| random_walk(&stack, Illumination::Diffuse, 1000, seed);
    assert_eq!(run(9), run(9));
    assert_ne!(run(9).reflectance, run(10).reflectance);
}

#[test]
fn a_million_collisions_a_second_and_more() {
    for phase in [
        PhaseMix::ISOTROPIC,
        PhaseMix::RAYLEIGH,
        PhaseMix::henyey_greenstein(0.8),
    ] {
        let stack = [layer(0.99, 5.0, phase)];
        let start = std::time::Instant::now();
        let walk = random_walk(&stack, Illumination::Diffuse, 50_000, 11);
        let rate = walk.collisions as f64 / start.elapsed().as_secs_f64();
        println!("{phase:?}: {:.1} million collisions a second", rate / 1e6);
        assert!(walk.collisions > 100_000);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_input_gives_shares(
        numbers in proptest::collection::vec(
            prop_oneof![any::<f64>(), 0.0..10.0_f64, Just(f64::INFINITY), Just(0.0)], 0..9),
        cos in prop_oneof![any::<f64>(), 0.0..1.0_f64],
        seed in any::<u64>(),
    ) {
        let layers: Vec<Layer> = numbers.chunks_exact(3).map(|n| Layer {
            // Some absorption, or a bottomless white layer takes a while.
            absorption: n[0].abs().max(0.05),
            scattering: n[1].min(10.0),
            thickness_mm: n[2],
            phase: PhaseMix::new(n[0], n[1], n[2]),
        }).collect();
        for illumination in [Illumination::Beam(cos), Illumination::Diffuse] {
            let walk = random_walk(&layers, illumination, 20, seed);
            prop_assert!((walk.total() - 1.0).abs() < 1e-12);
            for e in [walk.reflectance, walk.transmittance] {
                prop_assert!((0.0..=1.02).contains(&e.mean) && e.standard_error.is_finite());
            }
        }
    }
}
