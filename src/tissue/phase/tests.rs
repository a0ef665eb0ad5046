use super::*;
use proptest::prelude::*;

/// Composite Gauss–Legendre over the cosine, panels halved towards +1 and −1 where a peak is.
fn over_the_sphere(f: impl Fn(f64) -> f64) -> f64 {
    // Five-point rule on −1…1.
    const RULE: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let mut sum = 0.0;
    for end in [-1.0, 1.0] {
        let mut outer: f64 = 1.0;
        for level in 0..60 {
            // Distance from the end: outer/√2 to outer, the last panel down to 0.
            let inner = if level == 59 {
                0.0
            } else {
                outer * 0.5_f64.sqrt()
            };
            for (x, w) in RULE {
                let from_end = 0.5 * (inner + outer + x * (outer - inner));
                sum += 0.5 * (outer - inner) * w * f(end * (1.0 - from_end));
            }
            outer = inner;
        }
    }
    2.0 * PI * sum
}

const COSINES: [f64; 11] = [
    -0.999, -0.9, -0.5, -1e-3, -1e-12, 0.0, 1e-8, 0.3, 0.75, 0.95, 0.999,
];

#[test]
fn every_phase_function_integrates_to_one_with_its_mean_cosine() {
    for g in COSINES {
        let one = over_the_sphere(|c| phase_henyey_greenstein(c, g));
        let mean = over_the_sphere(|c| c * phase_henyey_greenstein(c, g));
        // The rule's own error on panels of ratio √2.
        assert!((one - 1.0).abs() < 1e-9, "g {g}: {one}");
        assert!((mean - g).abs() < 1e-9, "g {g}: {mean}");
        let mix = PhaseMix::new(0.3, 0.2, g);
        assert!((over_the_sphere(|c| mix.value(c)) - 1.0).abs() < 1e-9);
        assert!((over_the_sphere(|c| c * mix.value(c)) - mix.mean_cosine()).abs() < 1e-9);
        assert!((mix.mean_cosine() - 0.5 * g).abs() < 1e-15);
    }
    assert!((over_the_sphere(phase_rayleigh) - 1.0).abs() < 1e-12);
    assert!(over_the_sphere(|c| c * phase_rayleigh(c)).abs() < 1e-12);
    // Mean square cosine: 2/5 for Rayleigh, (1 + 2 g²)/3 for Henyey & Greenstein.
    assert!((over_the_sphere(|c| c * c * phase_rayleigh(c)) - 0.4).abs() < 1e-12);
    let squared = over_the_sphere(|c| c * c * phase_henyey_greenstein(c, 0.75));
    assert!((squared - (1.0 + 2.0 * 0.75 * 0.75) / 3.0).abs() < 1e-9);
}

#[test]
fn values_worked_out_by_hand() {
    // g = ½: forwards ¾/(4π ⅛) = 6/(4π), sideways ¾/(4π 1.25^1.5), backwards ¾/(4π 27/8) =
    // 2/9/(4π).
    let quarter = |v: f64| v * PHASE_ISOTROPIC;
    for (cos, expected) in [
        (1.0, 6.0),
        (0.0, 0.75 / 1.25_f64.powf(1.5)),
        (-1.0, 2.0 / 9.0),
    ] {
        let got = phase_henyey_greenstein(cos, 0.5);
        assert!((got / quarter(expected) - 1.0).abs() < 1e-15);
        assert!((phase_henyey_greenstein(-cos, -0.5) / got - 1.0).abs() < 1e-15);
    }
    assert!((phase_rayleigh(1.0) / quarter(1.5) - 1.0).abs() < 1e-15);
    assert!((phase_rayleigh(0.0) / quarter(0.75) - 1.0).abs() < 1e-15);
    for cos in [-1.0, 0.2, 1.0] {
        assert_eq!(phase_henyey_greenstein(cos, 0.0), PHASE_ISOTROPIC);
    }
}

#[test]
fn the_peak_keeps_its_digits_as_g_goes_to_one() {
    // Forwards the value is (1 + g)/(4π (1 − g)²), exactly.
    for exponent in 1..13 {
        let less = 0.5_f64.powi(exponent);
        let exact = PHASE_ISOTROPIC * (2.0 - less) / (less * less);
        let got = phase_henyey_greenstein(1.0, 1.0 - less);
        assert!((got / exact - 1.0).abs() < 1e-14, "{less}: {got}");
    }
    assert_eq!(
        phase_henyey_greenstein(0.3, 1.0),
        phase_henyey_greenstein(0.3, MAX_MEAN_COSINE)
    );
}

/// Distribution function of Henyey & Greenstein's cosine, by its integral in closed form, for
/// 0 < g < 1 and `versine` = 1 − cos.
fn distribution(versine: f64, g: f64) -> f64 {
    let root = ((1.0 - g) * (1.0 - g) + 2.0 * g * versine).sqrt();
    (1.0 - g) / (2.0 * g) * ((1.0 + g) / root - 1.0)
}

#[test]
fn sampling_inverts_the_distribution() {
    for g in COSINES {
        for i in 0..=1000 {
            let xi = f64::from(i) / 1000.0;
            if g <= 0.0 {
                // Forwards and backwards change places.
                let (one, other) = (
                    sample_henyey_greenstein(g, xi),
                    sample_henyey_greenstein(-g, 1.0 - xi),
                );
                assert!((one + other).abs() < 1e-12);
                continue;
            }
            let back = distribution(sample_henyey_greenstein_versine(g, xi), g);
            // The closed form of the distribution itself loses 1/g.
            let tolerance = 1e-15 / g + 1e-13;
            assert!((back - xi).abs() < tolerance, "g {g} ξ {xi}: {back}");
        }
    }
    for i in 0..=1000 {
        let xi = f64::from(i) / 1000.0;
        let cos = sample_rayleigh(xi);
        let back = 0.5 + (3.0 * cos + cos.powi(3)) / 8.0;
        assert!((back - xi).abs() < 5e-16, "{xi}: {back}");
    }
}

#[test]
fn sampling_goes_continuously_through_isotropic() {
    // At g = 1e-300 the textbook's inverse is not a number.
    for i in 0..=100 {
        let xi = f64::from(i) / 100.0;
        let flat = 2.0 * xi - 1.0;
        assert!((sample_henyey_greenstein(0.0, xi) - flat).abs() < 1e-15);
        for g in [1e-300, 1e-16, 1e-9] {
            // First order in g: ½ g (3 + (2ξ−1)²) − 2 g (2ξ−1)², so at most 1.5 g.
            assert!((sample_henyey_greenstein(g, xi) - flat).abs() <= 1.5 * g + 1e-15);
            assert!((sample_henyey_greenstein(-g, xi) - flat).abs() <= 1.5 * g + 1e-15);
        }
    }
    // And the textbook's inverse does lose them: five digits are left at g = 1e-11.
    let (g, xi): (f64, f64) = (1e-11, 0.3);
    let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * xi);
    let textbook = (1.0 + g * g - ratio * ratio) / (2.0 * g);
    assert!((textbook - (-0.4)).abs() > 1e-7);
}

#[test]
fn small_angles_keep_their_digits() {
    // Near straight on, 1 − cos = 2 (1 − ξ)((1 − g)/(1 + g))² to first order in 1 − ξ.
    for g in [0.0, 0.9, 0.999] {
        let rest = 1e-12;
        let got = sample_henyey_greenstein_versine(g, 1.0 - rest);
        let expected = 2.0 * rest * (1.0 - g) * (1.0 - g) / (1.0 + g);
        // ξ itself is rounded to 1e-16 of 1, so its rest to 1e-4 of itself.
        assert!(
            (got / expected - 1.0).abs() < 2e-4,
            "g {g}: {got:e} {expected:e}"
        );
    }
}

#[test]
fn drawn_cosines_fill_the_histogram() {
    // Stratified draws: 1e5 equal steps of ξ put the integral of p into each bin, to a step.
    let draws = 100_000;
    let bins = 20;
    for mix in [
        PhaseMix::ISOTROPIC,
        PhaseMix::RAYLEIGH,
        PhaseMix::henyey_greenstein(0.8),
        PhaseMix::henyey_greenstein(-0.4),
        PhaseMix::new(0.3, 0.25, 0.9),
    ] {
        let mut counts = vec![0_u32; bins];
        for i in 0..draws {
            let cos = mix.sample((f64::from(i) + 0.5) / f64::from(draws));
            counts[(((cos + 1.0) * 0.5 * bins as f64) as usize).min(bins - 1)] += 1;
        }
        for (bin, count) in counts.into_iter().enumerate() {
            let (low, steps) = (-1.0 + 2.0 * bin as f64 / bins as f64, 2000);
            let width = 2.0 / bins as f64 / f64::from(steps);
            let expected: f64 = (0..steps)
                .map(|i| 2.0 * PI * width * mix.value(low + width * (f64::from(i) + 0.5)))
                .sum();
            let got = f64::from(count) / f64::from(draws);
            // Three parts, each with a step at either edge of the bin; the midpoint sum 1e-6.
            assert!(
                (got - expected).abs() < 7e-5,
                "{mix:?} {bin}: {got} {expected}"
            );
        }
    }
}

proptest! {
    #[test]
    fn never_anything_but_a_finite_number(
        cos in prop_oneof![any::<f64>(), -1.0..1.0_f64],
        g in prop_oneof![any::<f64>(), -1.0..1.0_f64],
        xi in prop_oneof![any::<f64>(), 0.0..1.0_f64],
        shares in (any::<f64>(), -0.5..1.5_f64),
    ) {
        for value in [phase_henyey_greenstein(cos, g), phase_rayleigh(cos)] {
            prop_assert!(value.is_finite() && value > 0.0);
        }
        let mix = PhaseMix::new(shares.0, shares.1, g);
        prop_assert!(mix.value(cos).is_finite() && mix.value(cos) >= 0.0);
        for cosine in [sample_henyey_greenstein(g, xi), sample_rayleigh(xi), mix.sample(xi), mix.mean_cosine()] {
            prop_assert!((-1.0..=1.0).contains(&cosine));
        }
        prop_assert!((0.0..=2.0).contains(&sample_henyey_greenstein_versine(g, xi)));
    }

    #[test]
    fn sampling_rises_with_the_random_number(g in -1.0..1.0_f64, a in 0.0..1.0_f64, b in 0.0..1.0_f64) {
        let (low, high) = (a.min(b), a.max(b));
        prop_assert!(sample_henyey_greenstein(g, low) <= sample_henyey_greenstein(g, high) + 1e-15);
        prop_assert!(sample_rayleigh(low) <= sample_rayleigh(high) + 1e-15);
    }
}
