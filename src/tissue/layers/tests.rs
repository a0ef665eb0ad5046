use super::*;
use proptest::prelude::*;

const STEPS: usize = 4096;

/// Midpoint march over 0…1.
fn march(f: impl Fn(f64) -> f64) -> f64 {
    let sum: f64 = (0..STEPS).map(|i| f((i as f64 + 0.5) / STEPS as f64)).sum();
    sum / STEPS as f64
}

fn iris_like() -> [Layer; 3] {
    let layer = |absorption, scattering, thickness_mm, phase| Layer {
        absorption,
        scattering,
        thickness_mm,
        phase,
    };
    [
        layer(4.0, 0.9, 0.04, PhaseMix::ISOTROPIC),
        layer(0.0, 0.0, 0.1, PhaseMix::RAYLEIGH),
        layer(0.1, 3.0, 0.45, PhaseMix::new(0.4, 0.0, 0.8)),
    ]
}

/// Depth (along the normal) in front of `z` mm, and the layer there.
fn at(layers: &[Layer], z: f64) -> (f64, Layer) {
    let (mut depth, mut front) = (0.0, 0.0);
    for layer in layers {
        if z <= front + layer.thickness_mm {
            return (depth + layer.extinction() * (z - front), *layer);
        }
        depth += layer.optical_depth();
        front += layer.thickness_mm;
    }
    panic!("beyond the stack");
}

#[test]
fn a_stack_equals_a_fine_march() {
    let layers = iris_like();
    let mut worst: f64 = 0.0;
    for cos_in in [1.0, 0.6, 0.15] {
        for cos_out in [1.0, 0.6, 0.5, 0.1] {
            let cos_scatter = 0.3;
            // Layer by layer, so that the march's own error is that of smooth functions.
            let marched = |exponent: &dyn Fn(f64) -> f64| {
                let (mut front, mut sum) = (0.0, 0.0);
                for layer in layers {
                    let d = layer.thickness_mm;
                    sum += d * march(|t| {
                        let depth = at(&layers, front + t * d).0;
                        layer.scattering * layer.phase.value(cos_scatter) * (-exponent(depth)).exp()
                    });
                    front += d;
                }
                sum / (cos_in * cos_out)
            };
            let back = marched(&|depth| depth / cos_in + depth / cos_out);
            let got = stack_reflect_once(&layers, cos_in, cos_out, cos_scatter);
            worst = worst.max((got / back - 1.0).abs());
        }
    }
    println!("closed form against 4,096 steps a layer: {worst:.1e}");
    // Midpoint rule: (x/4096)²/24 with x = 23 optical depths: 1.3e-6.
    assert!(worst < 1.4e-6, "{worst:e}");
}

#[test]
fn a_segment_equals_a_fine_march_whichever_way_the_light_shortens() {
    let (extinction, scattering) = (DVec3::new(0.0, 1e-9, 6.0), DVec3::new(2.0, 1.0, 5.0));
    for (length, start, end) in [
        (0.7, 0.2, 0.9),
        (0.7, 0.9, 0.2),
        (0.7, 1.3, 0.1),
        (1e-7, 0.1, 0.1),
        (0.5, 2.0, 0.0),
    ] {
        let mean = layer_mean_transmittance(extinction * start, extinction * (end + length));
        let got = scattering * length * mean;
        for i in 0..3 {
            let expected = scattering[i]
                * length
                * march(|t| {
                    let path = start + t * (end - start) + t * length;
                    (-extinction[i] * path).exp()
                });
            // (9/4096)²/24 = 2e-7.
            assert!(
                (got[i] / expected - 1.0).abs() < 2.1e-7,
                "{i} {got} {expected}"
            );
        }
    }
}

#[test]
fn the_mean_keeps_its_digits_where_the_difference_vanishes() {
    // Against the symmetric form e^(−(a+b)/2) sinh(h)/h, by its series, h = (a − b)/2.
    for a in [0.0_f64, 1e-12, 1e-3, 1.0, 30.0] {
        for h in [0.0_f64, 1e-300, 1e-17, 1e-9, 1e-3, 0.1] {
            let b = a + 2.0 * h;
            let h = 0.5 * (b - a);
            let series = 1.0
                + h * h / 6.0 * (1.0 + h * h / 20.0 * (1.0 + h * h / 42.0 * (1.0 + h * h / 72.0)));
            let expected = (-0.5 * (a + b)).exp() * series;
            let got = mean_transmittance(a, b);
            // e^(−30) carries 30 roundings of its argument.
            let tolerance = 4e-16 + 2e-16 * a;
            assert!(
                (got / expected - 1.0).abs() < tolerance,
                "{a} {h} {got} {expected}"
            );
            assert_eq!(got, mean_transmittance(b, a));
        }
    }
    // The bare quotient has two digits left at 1e-14.
    let (a, b) = (1.0_f64, 1.0_f64 + 1e-14);
    let bare = ((-a).exp() - (-b).exp()) / (b - a);
    assert!((bare / (-1.0_f64).exp() - 1.0).abs() > 1e-3);
}

#[test]
fn limits_known_in_closed_form() {
    let deep = Layer {
        absorption: 40.0,
        scattering: 60.0,
        thickness_mm: 1e6,
        phase: PhaseMix::ISOTROPIC,
    };
    // Chandrasekhar's half-space: BRDF ω/(4π (µ + µ₀)).
    let got = stack_reflect_once(&[deep], 0.7, 0.4, 0.0);
    let expected = 0.6 / (4.0 * core::f64::consts::PI * 1.1);
    assert!((got / expected - 1.0).abs() < 1e-14);
    // Thin: ω τ p/(µ µ₀).
    let thin = Layer {
        thickness_mm: 1e-12,
        ..deep
    };
    let expected = 60e-12 / (4.0 * core::f64::consts::PI * 0.28);
    let got = stack_reflect_once(&[thin], 0.7, 0.4, 0.0);
    assert!((got / expected - 1.0).abs() < 1e-9);
    let layer = Layer {
        thickness_mm: 0.01,
        ..deep
    };
    assert!((stack_transmittance(&[layer, layer], 0.5) / (-4.0_f64).exp() - 1.0).abs() < 1e-15);
}

#[test]
fn cutting_a_layer_in_two_changes_nothing() {
    let [border, _, stroma] = iris_like();
    let half = Layer {
        thickness_mm: 0.5 * stroma.thickness_mm,
        ..stroma
    };
    for (cos_in, cos_out) in [(1.0, 1.0), (0.3, 0.9), (0.5, 0.5 + 1e-12)] {
        let one = stack_reflect_once(&[border, stroma], cos_in, cos_out, 0.2);
        let two = stack_reflect_once(&[border, half, half], cos_in, cos_out, 0.2);
        assert!((one / two - 1.0).abs() < 1e-14);
    }
}

#[test]
fn light_and_eye_may_change_places() {
    // Helmholtz: the reflected BRDF is symmetric.
    let layers = iris_like();
    for (a, b) in [(0.9, 0.2), (1.0, 0.5)] {
        let one = stack_reflect_once(&layers, a, b, -0.4);
        let other = stack_reflect_once(&layers, b, a, -0.4);
        assert!((one / other - 1.0).abs() < 1e-15);
    }
}

#[test]
fn the_cosines_rule_is_gausss() {
    // Weights sum to 1 and powers of √µ up to 30 integrate exactly.
    for power in 0..30 {
        let got = over_cosines(|mu| mu.sqrt().powi(power));
        assert!(
            (got - 2.0 / f64::from(power + 2)).abs() < 2e-15,
            "{power} {got}"
        );
    }
}

/// E₂(x) = ∫₀¹ e^(−x/µ) dµ by a fine midpoint rule.
fn e2(x: f64) -> f64 {
    let steps = 3000;
    let sum: f64 = (0..steps)
        .map(|i| (-x * f64::from(steps) / (f64::from(i) + 0.5)).exp())
        .sum();
    sum / f64::from(steps)
}

#[test]
fn diffuse_single_scattering_is_the_integral_of_exponential_integrals() {
    // σ_s ∫ E₂(τ)² dz: fluence 2 E₂ of diffuse light at depth τ, half of it, E₂/2, escapes.
    let [border, _, stroma] = iris_like();
    for layers in [vec![border], vec![border, stroma]] {
        let (mut depth, mut expected) = (0.0, 0.0);
        for layer in &layers {
            let steps = 300;
            for i in 0..steps {
                let t = (f64::from(i) + 0.5) / f64::from(steps);
                let own = layer.optical_depth();
                expected += layer.scattering * layer.thickness_mm / f64::from(steps)
                    * e2(depth + t * own).powi(2);
            }
            depth += layer.optical_depth();
        }
        let got = stack_diffuse_reflectance_once(&layers);
        // The midpoint sums' own errors.
        assert!((got / expected - 1.0).abs() < 3e-4, "{got} {expected}");
    }
    // A deep layer has ω (1 − ln 2)·2/3, from ∫₀^∞ E₂² dτ (Chandrasekhar's half-space, first
    // order).
    let deep = Layer {
        absorption: 40.0,
        scattering: 60.0,
        thickness_mm: 10.0,
        phase: PhaseMix::ISOTROPIC,
    };
    let got = stack_diffuse_reflectance_once(&[deep]);
    let expected = 0.6 * 2.0 / 3.0 * (1.0 - core::f64::consts::LN_2);
    assert!((got - expected).abs() < 1e-6, "{got} {expected}");
}

fn anything() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(-1.0),
        Just(0.0),
        (-12.0..9.0_f64).prop_map(|e| 10.0_f64.powf(e)),
    ]
}

proptest! {
    #[test]
    fn never_anything_but_a_finite_number(
        numbers in proptest::collection::vec(anything(), 9),
        cosines in (anything(), anything(), anything()),
    ) {
        let layers: Vec<Layer> = numbers
            .chunks(3)
            .map(|n| Layer {
                absorption: n[0],
                scattering: n[1],
                thickness_mm: n[2],
                phase: PhaseMix::new(n[0], n[1], n[2]),
            })
            .collect();
        let (cos_in, cos_out, cos_scatter) = cosines;
        let value = stack_reflect_once(&layers, cos_in, cos_out, cos_scatter);
        prop_assert!(value.is_finite() && value >= 0.0, "{value}");
        let n = |i: usize| DVec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
        let value = layer_mean_transmittance(n(0) * numbers[8], n(3) * cos_in);
        prop_assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
        let diffuse = stack_diffuse_reflectance_once(&layers);
        prop_assert!((0.0..=1.0).contains(&diffuse), "{diffuse}");
        prop_assert!((0.0..=1.0).contains(&stack_transmittance(&layers, cos_in)));
        prop_assert!((0.0..=1.0).contains(&mean_transmittance(numbers[0], numbers[1])));
    }

    #[test]
    fn the_mean_lies_between_its_ends(a in 0.0..50.0_f64, b in 0.0..50.0_f64) {
        let mean = mean_transmittance(a, b);
        let (low, high) = ((-a.max(b)).exp(), (-a.min(b)).exp());
        prop_assert!(mean >= low * (1.0 - 1e-14) && mean <= high * (1.0 + 1e-14));
    }
}
