//! Where light goes: conicoid, Snell, cornea, two-point problem, caustic.

use super::{SNELL_CALL, between, draw_snell, light, pass, ray, surface, v2, v3};
use crate::gpu::Twin;
use glam::DVec2;
use ocularium::optics::refraction_function::domain::{RefractionEye, frame_place};
use ocularium::optics::refraction_function::spline;
use ocularium::optics::{caustic, conicoid, cornea, fermat, snell};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

#[test]
fn conicoid() {
    pass(&Twin {
        name: "conicoid_intersect",
        library: &["conicoid"],
        call: "y[0] = conicoid_intersect(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), x[6], x[7]);",
        draw: &|rng| [&ray(rng)[..], &surface(rng)].concat(),
        exact: &|x| vec![conicoid::conicoid_intersect(v3(x), v3(&x[3..]), x[6], x[7])],
        // Positions up to a metre away carry 6e-5 mm.
        absolute: 1e-5,
        relative: 6e-7,
        steep_share: 0.003,
    });
    pass(&Twin {
        name: "conicoid_normal",
        library: &["conicoid"],
        call: "let n = conicoid_normal(vec3f(x[0], x[1], x[2]), x[3], x[4]); y[0] = n.x; y[1] = n.y; y[2] = n.z;",
        draw: &|rng| {
            let p = [
                between(rng, -6.0, 6.0),
                between(rng, -6.0, 6.0),
                between(rng, 0.0, 3.0),
            ];
            [&p[..], &surface(rng)].concat()
        },
        exact: &|x| {
            conicoid::conicoid_normal(v3(x), x[3], x[4])
                .to_array()
                .to_vec()
        },
        absolute: 2e-7,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "conicoid_sag",
        library: &["conicoid"],
        call: "y[0] = conicoid_sag(x[0], x[1], x[2]);",
        draw: &|rng| [&[between(rng, 0.0, 10.0)][..], &surface(rng)].concat(),
        exact: &|x| vec![conicoid::conicoid_sag(x[0], x[1], x[2])],
        absolute: 4e-7,
        relative: 4e-7,
        // The square root at the equator.
        steep_share: 0.003,
    });
}

#[test]
fn snell() {
    pass(&Twin {
        name: "snell_refract",
        library: &["snell"],
        call: SNELL_CALL,
        draw: &draw_snell,
        exact: &|x| {
            snell::snell_refract(v3(x), v3(&x[3..]), x[6])
                .to_array()
                .to_vec()
        },
        absolute: 3e-6,
        relative: 0.0,
        // The edge of total reflection.
        steep_share: 0.002,
    });
}

/// A trace as numbers; a miss is all zeros, so that both sides agree on it.
fn trace_numbers(t: &cornea::CorneaTrace) -> Vec<f64> {
    [
        &t.entry.to_array()[..],
        &t.point.to_array(),
        &t.direction.to_array(),
        &[t.transmittance, t.valid],
    ]
    .concat()
}

const TRACE_OUT: &str = "y[0] = t.entry.x; y[1] = t.entry.y; y[2] = t.entry.z; \
     y[3] = t.point.x; y[4] = t.point.y; y[5] = t.point.z; \
     y[6] = t.direction.x; y[7] = t.direction.y; y[8] = t.direction.z; \
     y[9] = t.transmittance; y[10] = t.valid;";

#[test]
fn cornea() {
    pass(&Twin {
        name: "cornea_trace",
        library: &["cornea"],
        call: &format!(
            "let t = cornea_trace(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), \
             vec2f(x[8], 1.0), x[9], x[10], x[11], x[12]); {TRACE_OUT}"
        ),
        draw: &|rng| {
            let eye = [
                between(rng, 6.0, 7.0),
                between(rng, 0.4, 0.7),
                between(rng, 1.36, 1.39),
                between(rng, 1.33, 1.34),
                between(rng, 3.0, 4.2),
            ];
            [&ray(rng)[..], &surface(rng), &eye].concat()
        },
        exact: &|x| {
            trace_numbers(&cornea::cornea_trace(
                v3(x),
                v3(&x[3..]),
                v2(&x[6..]),
                DVec2::new(x[8], 1.0),
                x[9],
                x[10],
                x[11],
                x[12],
            ))
        },
        absolute: 2e-4,
        relative: 0.0,
        steep_share: 0.003,
    });
    pass(&Twin {
        name: "cornea_trace_single",
        library: &["cornea"],
        call: &format!(
            "let t = cornea_trace_single(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), \
             x[8], x[9]); {TRACE_OUT}"
        ),
        draw: &|rng| {
            let eye = [between(rng, 1.33, 1.38), between(rng, 3.0, 4.2)];
            [&ray(rng)[..], &surface(rng), &eye].concat()
        },
        exact: &|x| {
            trace_numbers(&cornea::cornea_trace_single(
                v3(x),
                v3(&x[3..]),
                v2(&x[6..]),
                x[8],
                x[9],
            ))
        },
        absolute: 2e-4,
        relative: 0.0,
        steep_share: 0.003,
    });
}

/// A point of the iris, a light, a cornea and its index.
fn two_points(rng: &mut Pcg64) -> Vec<f32> {
    let r = 5.6 * rng.random::<f32>().sqrt();
    let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
    let point = [r * cos, r * sin, between(rng, 3.0, 4.2)];
    let eye = [
        between(rng, 7.4, 8.2),
        between(rng, 0.6, 0.9),
        between(rng, 1.33, 1.38),
    ];
    [&point[..], &light(rng, 75.0), &eye].concat()
}

/// Where the light that arrives enters well inside the eye and not grazing; elsewhere whether it
/// arrives at all is a matter of rounding.
fn well_lit(rng: &mut Pcg64) -> Vec<f32> {
    loop {
        let x = two_points(rng);
        let w: Vec<f64> = x.iter().copied().map(f64::from).collect();
        let k = fermat::fermat_solve(v3(&w), v3(&w[3..]), v2(&w[6..]), w[8], 40, 1e-26);
        let cosine = conicoid::conicoid_normal(k.entry, w[6], w[7]).dot(v3(&w[3..]));
        if k.residual < 1e-10 && cosine > 0.1 && k.entry.truncate().length() < 6.5 {
            return x;
        }
    }
}

#[test]
fn fermat() {
    pass(&Twin {
        name: "fermat_entry",
        library: &["fermat"],
        call: "let k = fermat_entry(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), x[8], 12u); \
               y[0] = k.x; y[1] = k.y; y[2] = k.z; y[3] = k.w;",
        draw: &well_lit,
        exact: &|x| {
            fermat::fermat_entry(v3(x), v3(&x[3..]), v2(&x[6..]), x[8], 40)
                .to_array()
                .to_vec()
        },
        // The residual is known to 2e-7; divided by the path's curvature (0.05 per mm and more),
        // some 1e-6 mm.
        absolute: 1e-5,
        relative: 0.0,
        steep_share: 0.003,
    });
}

#[test]
fn fermat_agrees_on_what_is_lit() {
    // Both answers occur, so agreeing means something.
    let mut rng = Pcg64::seed_from_u64(2);
    let lit = (0..1000).filter(|_| {
        let x: Vec<f64> = two_points(&mut rng).into_iter().map(f64::from).collect();
        fermat::fermat_entry(v3(&x), v3(&x[3..]), v2(&x[6..]), x[8], 12).w == 1.0
    });
    assert!((100..990).contains(&lit.count()));
    pass(&Twin {
        name: "fermat_entry, valid",
        library: &["fermat"],
        call: "y[0] = fermat_entry(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), x[8], 12u).w;",
        draw: &two_points,
        exact: &|x| vec![fermat::fermat_entry(v3(x), v3(&x[3..]), v2(&x[6..]), x[8], 12).w],
        absolute: 0.0,
        relative: 0.0,
        // The terminator itself.
        steep_share: 0.001,
    });
}

#[test]
fn caustic() {
    pass(&Twin {
        name: "caustic_jacobian",
        library: &["caustic"],
        call: "y[0] = caustic_jacobian(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), x[8], x[9]);",
        draw: &|rng| {
            let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
            let (r, shape) = (5.85 * rng.random::<f32>().sqrt(), surface(rng));
            let sag = conicoid::conicoid_sag(f64::from(r), f64::from(shape[0]), f64::from(shape[1]))
                as f32;
            let eye = [between(rng, 1.33, 1.38), between(rng, 3.6, 4.2)];
            [
                &[r * cos, r * sin, sag][..],
                &light(rng, 75.0),
                &shape,
                &eye,
            ]
            .concat()
        },
        exact: &|x| {
            vec![caustic::caustic_jacobian(
                v3(x),
                v3(&x[3..]),
                v2(&x[6..]),
                x[8],
                x[9],
            )]
        },
        absolute: 1e-6,
        relative: 1e-6,
        // Whether grazing light enters at all.
        steep_share: 0.003,
    });
    pass(&Twin {
        name: "caustic_irradiance",
        library: &["caustic"],
        call: "y[0] = caustic_irradiance(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec2f(x[6], x[7]), x[8]);",
        draw: &well_lit,
        exact: &|x| {
            let k =
                fermat::fermat_entry(v3(x), v3(&x[3..]), v2(&x[6..]), x[8], fermat::FERMAT_STEPS);
            if k.w == 0.0 {
                return vec![0.0];
            }
            vec![caustic::caustic_irradiance_at(
                k.truncate(),
                v3(&x[3..]),
                v2(&x[6..]),
                x[8],
                x[2],
            )]
        },
        absolute: 2e-6,
        relative: 5e-6,
        steep_share: 0.003,
    });
}

#[test]
fn refraction_function() {
    let eye = RefractionEye::default();
    pass(&Twin {
        name: "refraction_place",
        library: &["refraction_function"],
        call: "let p = refraction_place(x[0], vec3f(x[1], x[2], x[3]), vec3f(x[4], x[5], x[6]), vec3f(x[7], x[8], x[9]), x[10], x[11]); \
               y[0] = p.x; y[1] = p.y;",
        draw: &|rng| {
            let frame = eye.frame(f64::from(between(rng, 0.0, 1.0)));
            let mut x: Vec<f32> = frame.iter().map(|v| *v as f32).collect();
            let b = between(rng, 0.0, x[0]);
            x.extend([between(rng, -4.0, 4.0), b]);
            x
        },
        exact: &|x| {
            let frame: [f64; 10] = core::array::from_fn(|i| x[i]);
            let (w, beta) = frame_place(&frame, x[10], x[11]);
            vec![w, beta]
        },
        // The square root at the fold.
        absolute: 2e-6,
        relative: 2e-6,
        steep_share: 0.02,
    });
    pass(&Twin {
        name: "refraction_weights",
        library: &["refraction_function"],
        call: "let w = refraction_weights(x[0], u32(x[1])); y[0] = w.x; y[1] = w.y; y[2] = w.z; y[3] = w.w;",
        draw: &|rng| vec![between(rng, -0.1, 1.1), between(rng, 3.0, 80.0).floor()],
        exact: &|x| {
            let (first, w) = spline::weights::<3>(x[0] as f32, x[1] as usize);
            vec![
                first as f64,
                f64::from(w[0]),
                f64::from(w[1]),
                f64::from(w[2]),
            ]
        },
        // Where the first index jumps the spline itself is continuous.
        absolute: 2e-5,
        relative: 0.0,
        steep_share: 0.001,
    });
}
