//! Where light goes: conicoid, Snell, cornea.

use super::{SNELL_CALL, between, draw_snell, pass, ray, surface, v2, v3};
use crate::gpu::Twin;
use glam::DVec2;
use ocularium::optics::{conicoid, cornea, snell};

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
        name: "parallax_place",
        library: &["cornea"],
        call: "let p = parallax_place(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), PARALLAX_SHARE * x[6]); \
               y[0] = p.x; y[1] = p.y;",
        draw: &|rng| {
            let mut x = ray(rng).to_vec();
            // Before the eye's face a ray goes into it, not along it.
            x[5] = x[5].abs().max(0.3);
            x.push(between(rng, 3.0, 4.2));
            x
        },
        exact: &|x| {
            let depth = cornea::PARALLAX_SHARE * x[6];
            cornea::parallax_place(v3(x), v3(&x[3..]), depth)
                .to_array()
                .to_vec()
        },
        // A step of some 30 mm along a slope of 5: six roundings of 150 mm, in a sum that may be small.
        absolute: 1e-4,
        relative: 0.0,
        steep_share: 0.0,
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
