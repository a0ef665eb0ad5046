use super::*;
use crate::optics::surface::Quadric;
use glam::DVec2;
use proptest::prelude::*;

/// Escudero-Sanz & Navarro 1999 at 543 nm, without retina.
fn navarro() -> Vec<Interface> {
    let at = |radius, p, z| Placed::at(Quadric::conicoid(radius, p), z);
    vec![
        Interface::uniform(at(7.72, 0.74, 0.0), 1.0, 1.3777),
        Interface::uniform(at(6.5, 1.0, 0.55), 1.3777, 1.3391),
        Interface::uniform(at(10.2, -2.1316, 3.6), 1.3391, 1.4222),
        Interface::uniform(at(-6.0, 0.0, 7.6), 1.4222, 1.3377),
    ]
}

fn through(traced: Traced) -> (Ray, f64) {
    match traced {
        Traced::Through {
            ray,
            optical_path_mm,
        } => (ray, optical_path_mm),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_ellipse_of_eccentricity_one_over_n_is_perfect() {
    // Descartes: collimated light meets exactly at f = nR/(n − 1), along equal optical paths.
    let (n, radius) = (1.336, 7.8);
    let p = 1.0 - 1.0 / (n * n);
    let lens = [Interface::uniform(
        Placed::at(Quadric::conicoid(radius, p), 0.0),
        1.0,
        n,
    )];
    let focus = DVec3::new(0.0, 0.0, n * radius / (n - 1.0));
    for i in 0..60_i32 {
        let (x, y) = (0.1 * f64::from(i), 0.03 * f64::from(i));
        let from = Ray::new(DVec3::new(x, y, -20.0), DVec3::Z).unwrap();
        let (ray, path) = through(trace_into(&lens, from));
        let to_focus = focus - ray.origin;
        // 40 mm at 1e-16 a few times.
        assert!(to_focus.cross(ray.direction).length() < 3e-14, "{x}");
        let total = path + n * to_focus.length();
        assert!((total - (20.0 + n * focus.z)).abs() < 3e-14, "{x}");
    }
}

#[test]
fn rays_are_those_of_opticstudio() {
    // Ansys OpticStudio's trace of another eye, printed to ten digits in the test data of
    // visisipy (MREYE-LUMC, 2024), rays in the y–z plane. (Its cornea is biconic, which in this
    // plane is the conicoid of 7.6967 mm and Q = −0.2304.) Depths count from the pupil.
    let at = |radius, p, z| Placed::at(Quadric::conicoid(radius, p), z);
    let eye = [
        Interface::uniform(at(7.6967, 1.0 - 0.2304, -3.9065), 1.0, 1.3777),
        Interface::uniform(at(6.2343, 1.0 - 0.1444, -3.345), 1.3777, 1.3391),
        Interface::uniform(Placed::at(Quadric::PLANE, 0.0), 1.3391, 1.3391),
        Interface::uniform(at(10.2, 1.0 - 3.1316, 0.0), 1.3391, 1.4222),
        Interface::uniform(at(-5.4537, 1.0, 3.17), 1.4222, 1.3377),
        Interface::uniform(at(-12.5, 1.033, 20.3985), 1.3377, 1.3377),
    ];
    for (field_degrees, points) in OPTICSTUDIO {
        let angle: f64 = field_degrees.to_radians();
        let dir = DVec3::new(0.0, angle.sin(), angle.cos());
        let first = DVec3::new(0.0, points[0].0, points[0].1);
        let mut ray = Ray::new(first - 5.0 * dir, dir).unwrap();
        for (interface, (y, z)) in eye.iter().zip(points) {
            ray = through(trace_into(core::slice::from_ref(interface), ray)).0;
            // Ten digits of 10 mm, and the first point's rounding carried through the eye.
            let off = ray.origin.distance(DVec3::new(0.0, *y, *z));
            assert!(off < 5e-9, "{field_degrees}° at {y}: {off:e}");
        }
    }
}

/// Field angle (°) and the points (y, z) on cornea, posterior cornea, pupil, lens, lens, retina (mm).
const OPTICSTUDIO: &[(f64, [(f64, f64); 6])] = &[
    (
        -60.0,
        [
            (4.4880066437, -2.4989535778),
            (3.8684146182, -2.0253058647),
            (1.174793673, 0.0),
            (1.0968378158, 0.058614206645),
            (-2.0750583265, 2.7598083654),
            (-12.052388775, 10.707546792),
        ],
    ),
    (
        -30.0,
        [
            (2.7760170868, -3.3926788401),
            (2.484470435, -2.8318818929),
            (1.0044938196, 0.0),
            (0.98000943354, 0.046849989953),
            (-0.54567130783, 3.1426326947),
            (-8.0303013817, 17.463012315),
        ],
    ),
    (
        30.0,
        [
            (-0.75895983748, -3.8690097951),
            (-0.52635500552, -3.3227462337),
            (0.92597053451, 0.0),
            (0.94501829681, 0.043578990159),
            (2.0366146395, 2.7754545242),
            (7.9347167387, 17.543251926),
        ],
    ),
    (
        60.0,
        [
            (-3.3342369119, -3.1561498435),
            (-2.7883817968, -2.6921838738),
            (0.46074206478, 0.0),
            (0.47401984448, 0.011001804154),
            (2.8941581885, 2.3387119321),
            (12.023235036, 10.844632858),
        ],
    ),
    (
        60.0,
        [
            (-3.9374710643, -2.8427644783),
            (-3.3574295372, -2.37658878),
            (-0.33808471575, 0.0),
            (-0.3312548962, 0.0053758922818),
            (2.50364621, 2.5613592716),
            (12.042112725, 10.756777112),
        ],
    ),
];

#[test]
fn light_retraces_its_path() {
    let eye = navarro();
    for (x, y, tilt) in [
        (0.0, 0.0, 0.0),
        (2.0, 1.0, 0.1),
        (-3.0, 0.5, 0.5),
        (1.0, -2.5, -0.9),
    ] {
        let start = DVec3::new(x - 10.0 * f64::sin(tilt), y, -10.0 * f64::cos(tilt));
        let ray = Ray::new(start, DVec3::new(tilt.sin(), 0.02, tilt.cos())).unwrap();
        let (inside, there) = through(trace_into(&eye, ray));
        let back = Ray {
            origin: inside.at(3.0),
            direction: -inside.direction,
        };
        let (outside, again) = through(trace_out_of(&eye, back));
        assert!(outside.direction.distance(-ray.direction) < 2e-14);
        // Both paths share all but the end pieces.
        let gap = (ray.origin - outside.origin).length();
        assert!((there + 3.0 * 1.3377 - again - gap).abs() < 1e-13);
        assert!((ray.origin - outside.origin).cross(ray.direction).length() < 1e-13);
    }
}

#[test]
fn every_way_to_fail_has_its_name() {
    let eye = navarro();
    let ray = |o: [f64; 3], d: [f64; 3]| Ray::new(o.into(), d.into()).unwrap();
    assert_eq!(
        trace_into(&eye, ray([20.0, 0.0, -9.0], [0.0, 0.0, 1.0])),
        Traced::Missed { surface: 0 }
    );
    assert_eq!(
        trace_into(&eye, ray([0.0, 0.0, -9.0], [0.0, 0.0, -1.0])),
        Traced::Missed { surface: 0 }
    );
    // From the iris steeply outwards: total reflection at the cornea's front.
    let cornea = &eye[..2];
    let steep = trace_out_of(cornea, ray([-4.8, 0.0, 3.6], [0.9, 0.0, -0.45]));
    assert_eq!(steep, Traced::TotalReflection { surface: 0 });
    let mut stopped = eye;
    stopped[2].placed = stopped[2].placed.with_aperture(1.5, 1.5);
    assert_eq!(
        trace_into(&stopped, ray([2.5, 0.0, -9.0], [0.0, 0.0, 1.0])),
        Traced::Blocked { surface: 2 }
    );
    assert!(
        trace_into(&stopped, ray([1.0, 0.0, -9.0], [0.0, 0.0, 1.0]))
            .ray()
            .is_some()
    );
    assert_eq!(
        trace_into(&[], ray([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
            .ray()
            .unwrap()
            .origin,
        DVec3::X
    );
    assert_eq!(Ray::new(DVec3::NAN, DVec3::Z), None);
    assert_eq!(Ray::new(DVec3::ZERO, DVec3::ZERO), None);
}

#[test]
fn a_tilted_plate_shifts_a_ray_by_the_textbook_amount() {
    // d = t sin(θ − θ′)/cos θ′, and the direction is unchanged.
    let (n, thickness, angle) = (1.5, 2.0, 0.6_f64);
    let plate = |z: f64, front, back| {
        // Both faces turn about a common line: the second vertex moves with the tilt.
        let mut placed = Placed::at(Quadric::PLANE, 0.0).tilted(0.0, angle);
        placed.vertex = placed.direction_from_local(DVec3::new(0.0, 0.0, z));
        Interface::uniform(placed, front, back)
    };
    let faces = [plate(0.0, 1.0, n), plate(thickness, n, 1.0)];
    let ray = Ray::new(DVec3::new(0.0, 0.3, -5.0), DVec3::Z).unwrap();
    let (out, _) = through(trace_into(&faces, ray));
    let inner = (angle.sin() / n).asin();
    let shift = thickness * (angle - inner).sin() / inner.cos();
    assert!(out.direction.distance(DVec3::Z) < 1e-15);
    assert!((DVec2::new(out.origin.x, out.origin.y - 0.3).length() - shift).abs() < 1e-14);
}

fn anterior_gradient() -> LensGradient {
    // Atchison 2006, anterior part of the lens.
    LensGradient {
        z_mm: 3.7,
        axial: [1.371, 0.0652778, -0.0226659],
        radial: -0.0020399,
    }
}

#[test]
fn an_axial_gradient_keeps_n_sine() {
    let gradient = LensGradient {
        radial: 0.0,
        ..anterior_gradient()
    };
    let plane = Placed::at(Quadric::PLANE, 5.14);
    let ray = Ray::new(DVec3::new(0.0, 0.0, 3.7), DVec3::new(0.4, 0.3, 1.0)).unwrap();
    let arrival = gradient.march(ray, &plane, Crossing::Inward).unwrap();
    let invariant = |r: Ray| gradient.index(r.origin) * r.direction.truncate().length();
    assert!((arrival.ray.origin.z - 5.14).abs() < 1e-14);
    // The step's error; see the next test.
    assert!((invariant(arrival.ray) - invariant(ray)).abs() < 1e-9);
    // x(z) = ∫ s/√(n² − s²) dz and the optical path ∫ n²/√(n² − s²) dz, by Gauss–Legendre
    // with three points on each of 200 intervals: exact to 1e-15.
    let s = invariant(ray);
    let (mut x, mut path) = (0.0, 0.0);
    let width = 1.44 / 200.0;
    for i in 0..200_i32 {
        for (node, weight) in [(-0.6_f64.sqrt(), 5.0), (0.0, 8.0), (0.6_f64.sqrt(), 5.0)] {
            let z = 3.7 + width * (f64::from(i) + 0.5 + 0.5 * node);
            let n = gradient.index(DVec3::new(0.0, 0.0, z));
            let root = (n * n - s * s).sqrt();
            x += width * weight / 18.0 * s / root;
            path += width * weight / 18.0 * n * n / root;
        }
    }
    assert!((arrival.ray.origin.truncate().length() - x).abs() < 1e-9);
    assert!(
        (arrival.optical_path_mm - path).abs() < 1e-9,
        "{} {path}",
        arrival.optical_path_mm
    );
}

#[test]
fn the_step_in_a_gradient_is_small_enough() {
    let gradient = anterior_gradient();
    let end = Placed::at(Quadric::conicoid(-5.9, -1.0), 7.3);
    let ray = Ray::new(DVec3::new(2.0, 0.5, 3.9), DVec3::new(-0.15, 0.05, 1.0)).unwrap();
    let by = |step| {
        gradient
            .march_by(step, ray, &end, Crossing::Inward)
            .unwrap()
    };
    let truth = by(0.002);
    let error = |step| {
        let arrival = by(step);
        (
            arrival.ray.origin.distance(truth.ray.origin),
            arrival.ray.direction.distance(truth.ray.direction),
            (arrival.optical_path_mm - truth.optical_path_mm).abs(),
        )
    };
    let (coarse, fine) = (error(0.2), error(0.05));
    println!("gradient lens, step 0.2: {coarse:?}; 0.05: {fine:?}");
    assert!(fine.0 < 3e-10 && fine.1 < 1e-10 && fine.2 < 2e-9);
    // Fourth order: 256 times, less what the last, shorter step and rounding leave.
    assert!(coarse.0 > 60.0 * fine.0);
    // A skew ray in a medium of revolution keeps n (x dy − y dx).
    let skew =
        |r: Ray| gradient.index(r.origin) * r.origin.truncate().perp_dot(r.direction.truncate());
    assert!((skew(by(0.05).ray) - skew(ray)).abs() < 1e-9);
    // And retraces its path.
    let there = by(0.05).ray;
    let back = Ray {
        origin: there.origin,
        direction: -there.direction,
    };
    let start = Placed::at(Quadric::PLANE, 3.9);
    let again = gradient.march(back, &start, Crossing::Outward).unwrap();
    assert!(again.ray.origin.distance(ray.origin) < 8e-9);
}

proptest! {
    #[test]
    fn no_ray_gives_anything_but_finite_numbers(
        o in prop::array::uniform3(prop::num::f64::ANY),
        d in prop::array::uniform3(prop::num::f64::ANY),
        x in -8.0..8.0_f64,
        y in -8.0..8.0_f64,
        log_distance in -3.0..6.0_f64,
        n in prop::num::f64::ANY,
    ) {
        let mut eye = navarro();
        let finite = |traced: Traced| match traced {
            Traced::Through { ray, optical_path_mm } =>
                ray.origin.is_finite() && ray.direction.is_finite() && optical_path_mm.is_finite(),
            _ => true,
        };
        if let Some(ray) = Ray::new(o.into(), d.into()) {
            prop_assert!(finite(trace_into(&eye, ray)));
            prop_assert!(finite(trace_out_of(&eye, ray)));
        }
        let aim = DVec3::new(x, y, 2.0);
        if let Some(dir) = DVec3::from(d).try_normalize() {
            let ray = Ray { origin: aim - 10f64.powf(log_distance) * dir, direction: dir };
            prop_assert!(finite(trace_into(&eye, ray)));
            prop_assert!(finite(trace_out_of(&eye, ray)));
            eye[1].back = IndexField::Uniform(n);
            eye[2].back = IndexField::Gradient(anterior_gradient());
            eye[3].front = eye[2].back;
            prop_assert!(finite(trace_into(&eye, ray)));
        }
    }
}
