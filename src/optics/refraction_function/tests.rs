use super::super::caustic::caustic_jacobian;
use super::super::conicoid::conicoid_sag;
use super::domain::EXIT_INCIDENCE_DEG;
use super::polynomial::RefractionPolynomial;
use super::*;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A place of the iris, a light, and where that light enters.
struct Pair {
    place: DVec2,
    light: DVec3,
    entry: DVec2,
}

/// Pairs of the domain, traced forward: half of them uniform in exit incidence, half in solid angle.
fn pairs(
    eye: &RefractionEye,
    count: usize,
    degrees: core::ops::Range<f64>,
    seed: u64,
) -> Vec<Pair> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let greatest = 2.0 * eye.greatest_half_tangent().atan();
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let k = eye.limbus_mm
            * rng.random::<f64>().sqrt()
            * DVec2::from_angle(rng.random::<f64>() * core::f64::consts::TAU);
        let (low, high) = (degrees.start.to_radians(), degrees.end.to_radians());
        let cosine = if rng.random::<bool>() {
            rng.random_range(low..high).cos()
        } else {
            rng.random_range(high.cos()..low.cos())
        };
        let (radius, p) = (eye.surface.x, eye.surface.y);
        let normal =
            DVec3::new(k.x, k.y, p * conicoid_sag(k.length(), radius, p) - radius).normalize();
        let side = normal.any_orthonormal_vector();
        let turn = DVec2::from_angle(rng.random::<f64>() * core::f64::consts::TAU);
        let sine = (1.0 - cosine * cosine).sqrt();
        let light = cosine * normal + sine * (turn.x * side + turn.y * normal.cross(side));
        if light.z >= 0.0 || light.z.abs().acos() > greatest {
            continue;
        }
        // The same light with its azimuth along +x, in which the domain is described.
        let along = light.truncate().normalize_or(DVec2::X);
        let turned = DVec3::new(light.truncate().length(), 0.0, light.z);
        let seen = DVec2::new(along.dot(k), along.perp_dot(k));
        let landing = eye.land(seen, turned);
        let inside = degrees.end > EXIT_INCIDENCE_DEG || eye.is_in_domain(seen, turned);
        if landing.point.length() > eye.limbus_mm || !inside {
            continue;
        }
        // Where the same place is reached by a shorter path too, that one is meant.
        if eye
            .solve(landing.point, turned)
            .is_none_or(|k| k.distance(seen) > 1e-6)
        {
            continue;
        }
        pairs.push(Pair {
            place: landing.point.x * along + landing.point.y * along.perp(),
            light,
            entry: k,
        });
    }
    pairs
}

/// Largest, 99.9 % and root-mean-square error.
fn errors(pairs: &[Pair], entry: impl Fn(&Pair) -> DVec2) -> [f64; 3] {
    let mut errors: Vec<f64> = pairs
        .iter()
        .map(|pair| entry(pair).distance(pair.entry))
        .collect();
    errors.sort_by(f64::total_cmp);
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let last = errors.len() - 1;
    [
        errors[last],
        errors[last * 999 / 1000],
        (squares / errors.len() as f64).sqrt(),
    ]
}

#[test]
fn it_keeps_its_promise_in_12_and_in_300_kilobytes() {
    let eye = RefractionEye::default();
    let pairs = pairs(&eye, 300_000, 0.0..EXIT_INCIDENCE_DEG, 1);
    for (size, bytes, most) in [
        (RefractionSize::SMALL, 12_000, 0.02),
        (RefractionSize::LARGE, 300_000, 0.001),
    ] {
        let function = RefractionFunction::new(eye, size);
        assert!(function.bytes() <= bytes, "{}", function.bytes());
        let plain = errors(&pairs, |pair| function.entry(pair.place, pair.light));
        let polished = errors(&pairs, |pair| {
            function.polished_entry(pair.place, pair.light)
        });
        println!(
            "{} bytes: {plain:?} mm, polished {polished:?}",
            function.bytes()
        );
        assert!(plain[0] <= most, "{plain:?}");
        // One step of Newton's method squares the error; where dK/dP is 40 it also multiplies it.
        assert!(polished[1] <= 1e-4 && polished[2] <= 1e-5, "{polished:?}");
        let twice = errors(&pairs, |pair| {
            let once = function.polished_entry(pair.place, pair.light);
            function.polish(once, pair.place, pair.light)
        });
        assert!(twice[0] <= 1e-6, "{twice:?}");
    }
    let large = RefractionFunction::new(eye, RefractionSize::LARGE);
    assert!(errors(&pairs, |pair| large.polished_entry(pair.place, pair.light))[0] <= 1e-4);
}

#[test]
fn a_linear_table_in_the_same_coordinates_errs_more() {
    // The comparison can fail: it tells a coarser method from a finer one.
    let eye = RefractionEye::default();
    let pairs = pairs(&eye, 20_000, 0.0..EXIT_INCIDENCE_DEG, 2);
    let of = |order| {
        let size = RefractionSize {
            order,
            ..RefractionSize::SMALL
        };
        let function = RefractionFunction::new(eye, size);
        errors(&pairs, |pair| function.entry(pair.place, pair.light))
    };
    let (linear, quadratic) = (of(Order::Linear), of(Order::Quadratic));
    println!("linear {linear:?}, quadratic {quadratic:?}");
    assert!(linear[2] > 5.0 * quadratic[2] && linear[0] > 0.02);
}

#[test]
fn polynomials_gain_with_their_degree() {
    let eye = RefractionEye::default();
    let pairs = pairs(&eye, 20_000, 0.0..EXIT_INCIDENCE_DEG, 6);
    let of = |size| {
        let polynomial = RefractionPolynomial::new(eye, size);
        let found = errors(&pairs, |pair| polynomial.entry(pair.place, pair.light));
        println!("{size:?}: {} bytes, {found:?}", polynomial.bytes());
        found
    };
    let (low, middle, high) = (of([6, 4, 6]), of([9, 5, 9]), of([14, 8, 14]));
    // The largest error of the middle one is 4 mm, in a corner where its coordinates, polynomials in
    // the obliquity too, miss the fold by more than its distance.
    assert!(middle[1] < 0.5 * low[1] && high[1] < 0.1 * middle[1]);
    assert!(high[0] < 0.05, "{high:?}");
}

#[test]
fn other_eyes_are_kept_too() {
    for (radius, p, depth, limbus, most) in [
        (7.8, 0.4, 3.6, 5.85, 0.02),
        (10.0, 0.75, 3.6, 5.85, 0.02),
        (7.8, 0.75, 4.4, 5.85, 0.02),
        (7.0, 0.2, 4.2, 6.0, 0.05),
        (8.5, 1.0, 3.0, 6.2, 0.1),
    ] {
        let eye = RefractionEye {
            surface: DVec2::new(radius, p),
            iris_z_mm: depth,
            limbus_mm: limbus,
            ..RefractionEye::default()
        };
        let pairs = pairs(&eye, 20_000, 0.0..EXIT_INCIDENCE_DEG, 3);
        let function = RefractionFunction::new(eye, RefractionSize::SMALL);
        let found = errors(&pairs, |pair| function.entry(pair.place, pair.light));
        println!(
            "R {radius} p {p} depth {depth} limbus {limbus}: to {:.1}°, {found:?} mm",
            function.greatest_obliquity().to_degrees()
        );
        // Where the limbus is nearly as deep as the iris, as in the last, paths are short and steep.
        assert!(found[0] < most, "{found:?}");
    }
}

#[test]
fn a_slice_is_the_function_for_its_light() {
    let function = RefractionFunction::new(RefractionEye::default(), RefractionSize::SMALL);
    for pair in pairs(function.eye(), 200, 0.0..EXIT_INCIDENCE_DEG, 4) {
        let slice = function.towards(pair.light);
        let (a, b) = (
            slice.entry(pair.place),
            function.entry(pair.place, pair.light),
        );
        // The order of f32 sums.
        assert!(a.distance(b) < 1e-5, "{a} {b}");
    }
}

#[test]
fn groups_are_the_single_look_ups_whatever_their_number() {
    let eye = RefractionEye::default();
    let pairs = pairs(&eye, 50, 0.0..EXIT_INCIDENCE_DEG, 7);
    for order in [Order::Linear, Order::Quadratic] {
        let size = RefractionSize {
            order,
            ..RefractionSize::SMALL
        };
        let function = RefractionFunction::new(eye, size);
        let slice = function.towards(pairs[0].light);
        for count in [0, 1, 15, 16, 17, 50] {
            let asked: Vec<_> = pairs[..count].iter().map(|p| (p.place, p.light)).collect();
            let places: Vec<_> = asked.iter().map(|(place, _)| *place).collect();
            let nowhere = DVec2::splat(99.0);
            let (mut found, mut along) = (vec![nowhere; count + 1], vec![nowhere; count + 1]);
            function.entries(&asked, &mut found);
            slice.entries(&places, &mut along);
            for (i, (place, light)) in asked.iter().enumerate() {
                // The same sums; the compiler may take them in another order.
                assert!(
                    found[i].distance(function.entry(*place, *light)) < 1e-5,
                    "{count} {i}"
                );
                assert!(along[i].distance(slice.entry(*place)) < 1e-5, "{count} {i}");
            }
            assert!(
                found[count] == nowhere && along[count] == nowhere,
                "{count}"
            );
        }
    }
}

#[test]
fn the_entry_moves_with_the_place_as_the_jacobian_says() {
    // ∂K/∂P of the function against the inverse of the caustic's Jacobian, where it is smooth.
    let eye = RefractionEye::default();
    let function = RefractionFunction::new(eye, RefractionSize::LARGE);
    let h = 1e-2;
    let mut worst: f64 = 0.0;
    for pair in pairs(&eye, 2000, 0.0..60.0, 5) {
        let along = |step: DVec2| {
            let there = function.polished_entry(pair.place + step, pair.light);
            let back = function.polished_entry(pair.place - step, pair.light);
            (there - back) / (2.0 * h)
        };
        let (x, y) = (along(DVec2::new(h, 0.0)), along(DVec2::new(0.0, h)));
        let k = pair.entry;
        let entry = k.extend(conicoid_sag(k.length(), eye.surface.x, eye.surface.y));
        let jacobian = caustic_jacobian(entry, pair.light, eye.surface, eye.index, eye.iris_z_mm);
        worst = worst.max(((x.x * y.y - x.y * y.x) * jacobian - 1.0).abs());
    }
    println!("Jacobian of the function against the closed form: {worst:.1e}");
    // h² times third derivatives of a map that is steep at the rim.
    assert!(worst < 1e-4, "{worst}");
}

fn some_place() -> impl Strategy<Value = (DVec2, DVec3)> {
    let angle = 0.0..core::f64::consts::TAU;
    (0.0..5.5_f64, angle.clone(), 0.0..60.0_f64, angle).prop_map(|(r, turn, polar, azimuth)| {
        let (s, c) = polar.to_radians().sin_cos();
        (
            r * DVec2::from_angle(turn),
            DVec3::new(s * azimuth.cos(), s * azimuth.sin(), -c),
        )
    })
}

fn shared() -> &'static RefractionFunction {
    static SHARED: std::sync::LazyLock<RefractionFunction> = std::sync::LazyLock::new(|| {
        RefractionFunction::new(RefractionEye::default(), RefractionSize::SMALL)
    });
    &SHARED
}

proptest! {
    #[test]
    fn it_is_continuous((place, light) in some_place(), turn in 0.0..core::f64::consts::TAU) {
        // |∂K/∂P| is below 5 for lights to 60°; f32 adds a rounding of 1e-6.
        let step = 1e-3 * DVec2::from_angle(turn);
        let moved = shared().entry(place + step, light).distance(shared().entry(place, light));
        prop_assert!(moved < 5e-3 + 2e-6, "{moved}");
        let tilted = (light + 1e-4 * DVec3::new(turn.cos(), turn.sin(), 0.0)).normalize();
        let moved = shared().entry(place, tilted).distance(shared().entry(place, light));
        prop_assert!(moved < 5e-3, "{moved}");
    }

    #[test]
    fn it_turns_and_mirrors_with_the_world((place, light) in some_place(), turn in 0.0..core::f64::consts::TAU) {
        let spin = DVec2::from_angle(turn);
        let turned = DVec3::new(spin.rotate(light.truncate()).x, spin.rotate(light.truncate()).y, light.z);
        let expected = spin.rotate(shared().entry(place, light));
        prop_assert!(shared().entry(spin.rotate(place), turned).distance(expected) < 2e-5);
        let flip = DVec2::new(1.0, -1.0);
        let mirrored = shared().entry(flip * place, DVec3::new(light.x, -light.y, light.z));
        prop_assert!(mirrored.distance(flip * shared().entry(place, light)) < 1e-6);
    }

    #[test]
    fn nothing_is_ever_not_a_number(x in -50.0..50.0_f64, y in -50.0..50.0_f64, a in -1.0..1.0_f64, b in -1.0..1.0_f64, c in -1.0..1.0_f64) {
        let light = DVec3::new(a, b, c).normalize_or(DVec3::NEG_Z);
        let place = DVec2::new(x, y);
        prop_assert!(shared().entry(place, light).is_finite());
        prop_assert!(shared().polished_entry(place, light).is_finite());
        prop_assert!(shared().towards(light).entry(place).is_finite());
    }
}
