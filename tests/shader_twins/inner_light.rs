//! What is mirrored within the eye, what its fundus sends back, and lamps that are near.

use super::shading::{draw_lamp, lamp_of, lamp_text, pass_unless_off};
use super::{between, light, surface, v2, v3};
use crate::gpu::{Map, Twin};
use glam::{DVec2, DVec3};
use ocularium::appearance::Lamp;
use ocularium::appearance::light_table::{LightTableSettings, LightTableSize};
use ocularium::appearance::shading::near_light::iris_near_lamp;
use ocularium::appearance::shading::{fundus, lens_shade, near_light, surroundings};
use ocularium::optics::cornea::cornea_trace;
use ocularium::optics::lens_mirror::{
    LensMirrored, MirrorEye, mirror_cornea, mirror_lens_back, mirror_lens_front,
};
use rand_pcg::Pcg64;

/// The call's eye, of 14 numbers from the first on, and a ray in its aqueous.
const EYE: &str = "let e = MirrorEye(vec2f(x[0], x[1]), vec2f(x[2], x[3]), vec2f(x[4], x[5]), vec2f(x[6], x[7]), \
    x[8], x[9], x[10], x[11], x[12], x[13]); let p = vec3f(x[14], x[15], x[16]); let d = vec3f(x[17], x[18], x[19]);";
const OUT: &str = "y[0] = m.direction.x; y[1] = m.direction.y; y[2] = m.direction.z; y[3] = m.exit.x; y[4] = m.exit.y; \
    y[5] = m.crossing.x; y[6] = m.crossing.y; y[7] = 1000.0 * m.share;";

fn eye_of(x: &[f64]) -> MirrorEye {
    MirrorEye {
        anterior: v2(x),
        posterior: v2(&x[2..]),
        lens_front: v2(&x[4..]),
        lens_back: v2(&x[6..]),
        thickness: x[8],
        lens_depth: x[9],
        lens_thickness: x[10],
        n_cornea: x[11],
        n_aqueous: x[12],
        n_lens: x[13],
    }
}

/// Eyes of people, and rays of a camera's that come through a pupil of up to 8 mm.
fn draw_eye(rng: &mut Pcg64) -> Vec<f32> {
    loop {
        let mut x = surface(rng).to_vec();
        x.extend([between(rng, 6.0, 7.0), between(rng, 0.4, 1.0)]);
        x.extend([between(rng, 6.0, 12.0), between(rng, -3.0, 1.0)]);
        x.extend([between(rng, 5.0, 7.0), between(rng, -2.0, 1.0)]);
        x.extend([between(rng, 0.45, 0.65), between(rng, 3.0, 4.0)]);
        x.extend([between(rng, 3.5, 5.0), 1.376, 1.336]);
        x.push(between(rng, 1.40, 1.44));
        let towards = light(rng, 50.0);
        let aim = [between(rng, -3.0, 3.0), between(rng, -3.0, 3.0), 3.0];
        let origin: [f32; 3] = core::array::from_fn(|i| aim[i] + 30.0 * towards[i]);
        let wide = |v: [f32; 3]| v3(&v.map(f64::from));
        let e: Vec<f64> = x.iter().copied().map(f64::from).collect();
        let e = eye_of(&e);
        let trace = cornea_trace(
            wide(origin),
            -wide(towards),
            e.anterior,
            e.posterior,
            e.thickness,
            e.n_cornea,
            e.n_aqueous,
            e.lens_depth,
        );
        if trace.valid == 1.0 && trace.point.truncate().length() < 4.0 {
            x.extend(trace.point.as_vec3().to_array());
            x.extend(trace.direction.as_vec3().to_array());
            return x;
        }
    }
}

fn numbers(m: &LensMirrored) -> Vec<f64> {
    let (d, e, c) = (m.direction, m.exit, m.crossing);
    vec![d.x, d.y, d.z, e.x, e.y, c.x, c.y, 1000.0 * m.share]
}

/// The image that a call makes `m` of agrees with this one.
fn pass_image(name: &'static str, call: &str, exact: &dyn Fn(&[f64]) -> LensMirrored) {
    pass_unless_off(
        &Twin {
            name,
            library: &["lens_mirror"],
            call: &format!("{EYE} {call} {OUT}"),
            draw: &draw_eye,
            exact: &|x| numbers(&exact(x)),
            // Four intersections and as many refractions of places good to 1e-6 mm.
            absolute: 4e-5,
            relative: 0.0,
            // Where the ray leaves grazing, or not at all.
            steep_share: 0.02,
        },
        &[],
        2,
        0.02,
    );
}

#[test]
fn purkinje_images() {
    // From a place of the cornea, as far before the pupil.
    pass_image(
        "mirror_cornea",
        "let m = mirror_cornea(p - 3.2 * d, d, e);",
        &|x| {
            let d = v3(&x[17..]);
            mirror_cornea(v3(&x[14..]) - 3.2 * d, d, &eye_of(x))
        },
    );
    pass_image(
        "mirror_lens_front",
        "let m = mirror_lens_front(p, d, e);",
        &|x| mirror_lens_front(v3(&x[14..]), v3(&x[17..]), &eye_of(x)),
    );
    pass_image(
        "mirror_lens_back",
        "let m = mirror_lens_back(p, d, e);",
        &|x| mirror_lens_back(v3(&x[14..]), v3(&x[17..]), &eye_of(x)),
    );
}

#[test]
fn fundus_reflex() {
    pass_unless_off(
        &Twin {
            name: "fundus_reflex",
            library: &["fundus"],
            call: "y[0] = 0.01 * fundus_reflex(vec3f(x[0], x[1], x[2]), x[3], x[4], x[5], vec3f(x[6], x[7], x[8]), vec2f(x[9], x[10]), \
                vec3f(x[11], x[12], x[13]), x[14]);",
            draw: &|rng| {
                let mut x = light(rng, 8.0).to_vec();
                x.extend([between(rng, 0.001, 0.2), between(rng, -1.0, 0.9)]);
                x.push(between(rng, 0.0, 0.02));
                x.extend(light(rng, 8.0));
                x.extend([between(rng, -3.0, 3.0), between(rng, -3.0, 3.0)]);
                x.push(between(rng, -0.02, 0.02));
                x.extend([between(rng, -0.005, 0.005), between(rng, -0.005, 0.005)]);
                x.push(between(rng, 0.5, 4.0));
                x
            },
            exact: &|x| {
                vec![
                    0.01 * fundus::fundus_reflex(
                        v3(x),
                        x[3],
                        x[4],
                        x[5],
                        v3(&x[6..]),
                        v2(&x[9..]),
                        v3(&x[11..]),
                        x[14],
                    ),
                ]
            },
            // Up to 10 of what a point lights, by an edge of a hundredth of a radian in 6e-8.
            absolute: 2e-5,
            relative: 2e-5,
            // In focus, where all of the light is within its soft edge.
            steep_share: 0.02,
        },
        &[],
        5,
        0.001,
    );
}

#[test]
fn near_lamps() {
    pass_unless_off(
        &Twin {
            name: "lamp_from",
            library: &["surroundings"],
            call: &format!(
                "var l = {}; l.vergence = x[8]; let m = lamp_from(l, vec3f(x[9], x[10], x[11])); \
                 y[0] = m.direction.x; y[1] = m.direction.y; y[2] = m.direction.z; y[3] = m.radius; y[4] = m.color.x; y[5] = m.color.z; y[6] = m.vergence;",
                lamp_text(0)
            ),
            draw: &|rng| {
                let mut x = draw_lamp(rng);
                x.push(between(rng, 0.0, 0.025));
                x.extend((0..3).map(|_| between(rng, -15.0, 15.0)));
                x
            },
            exact: &|x| {
                let lamp = Lamp {
                    vergence: x[8] as f32,
                    ..lamp_of(x)
                };
                let (d, nearer) = surroundings::lamp_from(&lamp, v3(&x[9..]));
                let share = nearer * nearer;
                let [radius, vergence] = [x[3] * nearer, x[8] * nearer];
                vec![d.x, d.y, d.z, radius, x[4] * share, x[6] * share, vergence]
            },
            // A dozen roundings of numbers up to 2.
            absolute: 1e-6,
            relative: 2e-6,
            steep_share: 0.001,
        },
        &[],
        8,
        0.001,
    );
    pass_unless_off(
        &Twin {
            name: "near_concentration",
            library: &["near_light"],
            call: "let p = vec3f(x[0], x[1], x[2]); let s = vec2f(x[6], x[7]); let k = light_entry(p, vec3f(x[3], x[4], x[5]), s); \
                y[0] = k.x; y[1] = k.y; y[2] = k.z; \
                y[3] = near_concentration(x[8], k, p, vec3f(x[9], x[10], x[11]), s, 1.336, x[12]); \
                let g = beam_gathers(k, p, vec3f(x[9], x[10], x[11]), s, 1.336, x[12]); y[4] = g.x; y[7] = g.y; \
                let o = beam_on(g, 0.5 * (x[8] - 1.0)); y[8] = o.x; y[9] = o.y; \
                let c = crosses_plane(p.xy, 0.1 * x[8], vec3f(x[9], x[10], x[11]), 1.336); y[5] = c.x; y[6] = c.y;",
            draw: &|rng| {
                let mut x = vec![between(rng, -5.0, 5.0), between(rng, -5.0, 5.0)];
                x.push(between(rng, 3.0, 4.0));
                x.extend(light(rng, 40.0));
                x.extend(surface(rng));
                x.push(between(rng, 0.2, 2.0));
                x.extend(light(rng, 60.0));
                x.push(between(rng, 0.0, 0.025));
                x
            },
            exact: &|x| {
                let (point, shape) = (v3(x), v2(&x[6..]));
                let k = near_light::light_entry(point, v3(&x[3..]), shape);
                let near = near_light::near_concentration(
                    x[8],
                    k,
                    point,
                    v3(&x[9..]),
                    shape,
                    1.336,
                    x[12],
                );
                let light = v3(&x[9..]);
                let gathers = near_light::beam_gathers(k, point, light, shape, 1.336, x[12]);
                let crosses = near_light::crosses_plane(v2(x), 0.1 * x[8], light, 1.336);
                let on = near_light::beam_on(gathers, 0.5 * (x[8] - 1.0));
                vec![
                    k.x, k.y, k.z, near, gathers.x, crosses.x, crosses.y, gathers.y, on.x, on.y,
                ]
            },
            absolute: 1e-5,
            relative: 0.0,
            steep_share: 0.01,
        },
        &[],
        12,
        0.001,
    );
}

#[test]
fn near_lamps_on_the_iris() {
    let eye = LightTableSettings {
        surface: DVec2::new(7.8, 0.75),
        index: 1.336,
        iris_z: 3.6,
        root_mm: 6.05,
        limbus_mm: 5.85,
    };
    let map = Map {
        name: "light_table",
        levels: vec![eye.table(LightTableSize::PICTURE)],
        wrap: false,
    };
    let view = map.view();
    pass_unless_off(
        &Twin {
            name: "iris_near_lamp",
            library: &["near_light"],
            call: "let own = Lamp(vec3f(x[0], x[1], x[2]), 0.05, vec3f(1.0), 0.0, x[3]); \
                let m = iris_near_lamp(light_table, light_table_sampler, own, vec3f(0.0, 0.0, -12.0), vec3f(x[4], x[5], 3.6), vec2f(7.8, 0.75), 1.336, 6.05, 5.85); \
                y[0] = m.direction.x; y[1] = m.direction.y; y[2] = m.direction.z; y[3] = 0.1 * m.color.x;",
            draw: &|rng| {
                let mut x = light(rng, 60.0).to_vec();
                x.push(between(rng, 0.001, 0.02));
                x.extend((0..2).map(|_| between(rng, -4.0, 4.0)));
                x
            },
            exact: &|x| {
                let own = Lamp {
                    direction: v3(x).as_vec3(),
                    radius: 0.05,
                    vergence: x[3] as f32,
                    ..Lamp::default()
                };
                let apex = DVec3::new(0.0, 0.0, -12.0);
                let point = DVec3::new(x[4], x[5], 3.6);
                let (d, share) =
                    iris_near_lamp(&view, &own, apex, point, eye.surface, 1.336, 6.05, 5.85);
                vec![d.x, d.y, d.z, 0.1 * share]
            },
            // The table's look-up is good to 1e-5; what a near lamp makes of it, to a few of them.
            absolute: 5e-5,
            relative: 0.0,
            // At the edge of what light can reach.
            steep_share: 0.02,
        },
        std::slice::from_ref(&map),
        3,
        0.001,
    );
}

#[test]
fn clouds_before_a_bright_fundus() {
    pass_unless_off(
        &Twin {
            name: "lens_clear",
            library: &["lens_shade"],
            call: "y[0] = lens_clear(x[0], x[1], vec2f(x[2], x[3]), vec2f(x[4], x[5]), x[6]);",
            draw: &|rng| {
                let mut x = vec![between(rng, -0.5, 3.0), between(rng, -0.1, 0.9)];
                x.extend((0..2).map(|_| between(rng, -4.0, 4.0)));
                x.extend((0..2).map(|_| between(rng, -0.8, 0.8)));
                x.push(between(rng, 0.0, 6.3));
                x
            },
            exact: &|x| {
                vec![lens_shade::lens_clear(
                    x[0],
                    x[1],
                    v2(&x[2..]),
                    v2(&x[4..]),
                    x[6],
                )]
            },
            // As of the clouds themselves.
            absolute: 2e-5,
            relative: 0.0,
            steep_share: 0.01,
        },
        &[],
        1,
        0.02,
    );
}
