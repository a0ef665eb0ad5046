//! How the eye's surfaces answer light, without their maps: lamps, lids, limbus, tears, hair.
//!
//! Each comparison is made twice: with the twin, which must agree, and with the twin asked for one
//! input slightly off, which must not.

use super::{between, unit, v2, v3};
use crate::gpu::{Map, Twin};
use glam::{DVec3, DVec4};
use ocularium::appearance::Studio;
use ocularium::appearance::illumination::Lamp;
use ocularium::appearance::materials::{LID_SAMPLES, LidMargins};
use ocularium::appearance::shading::lid_shade::LidShade;
use ocularium::appearance::shading::{
    footprint, hair_shade, iris_relief, knots, lamp_lobe, lash_comb, lens_shade, lid_shade, limbus,
    surroundings, tear_layer, tear_reflection,
};
use rand_pcg::Pcg64;

/// The twin agrees, and does not when its input of this index is off by `by`.
pub fn pass_unless_off(twin: &Twin, maps: &[Map], input: usize, by: f64) {
    if let Err(why) = twin.compare_with(maps) {
        panic!("{why}");
    }
    let off = |x: &[f64]| {
        let mut x = x.to_vec();
        x[input] += by;
        (twin.exact)(&x)
    };
    let control = Twin {
        exact: &off,
        ..*twin
    };
    let found = control.compare_with(maps);
    assert!(found.is_err(), "{}: the control passes", twin.name);
}

/// WGSL that makes `count` four-vectors of the inputs from `first` on.
pub fn vec4s(first: usize, count: usize) -> String {
    let four = |i: usize| {
        let at = first + 4 * i;
        format!(
            "vec4f(x[{at}], x[{}], x[{}], x[{}])",
            at + 1,
            at + 2,
            at + 3
        )
    };
    (0..count).map(four).collect::<Vec<_>>().join(", ")
}

pub fn v4(x: &[f64]) -> DVec4 {
    DVec4::new(x[0], x[1], x[2], x[3])
}

/// A lamp anywhere, from points to wide ones, of any colour: direction, radius, colour, hole. Its radiance over
/// its disc is at most 1, so that a chord's rounding counts for no more.
pub fn draw_lamp(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = unit(rng).to_vec();
    let radius = between(rng, 0.03, 0.5);
    x.push(radius);
    x.extend((0..3).map(|_| between(rng, 0.0, radius * radius)));
    x.push([-1.0, 0.0, between(rng, 0.2, 0.9)][(between(rng, 0.0, 2.999)) as usize]);
    x
}

/// The call's lamp, from 8 numbers from `first` on.
pub fn lamp_text(first: usize) -> String {
    let v = |i: usize| {
        format!(
            "vec3f(x[{}], x[{}], x[{}])",
            first + i,
            first + i + 1,
            first + i + 2
        )
    };
    format!(
        "Lamp({}, x[{}], {}, x[{}], 0.0)",
        v(0),
        first + 3,
        v(4),
        first + 7
    )
}

pub fn lamp_of(x: &[f64]) -> Lamp {
    Lamp {
        direction: v3(x).as_vec3(),
        radius: x[3] as f32,
        color: v3(&x[4..]).as_vec3(),
        hole: x[7] as f32,
        vergence: 0.0,
    }
}

pub const RGB_OUT: &str = "y[0] = c.x; y[1] = c.y; y[2] = c.z;";

pub fn rgb(c: DVec3) -> Vec<f64> {
    c.to_array().to_vec()
}

#[test]
fn footprints() {
    pass_unless_off(
        &Twin {
            name: "pixel_footprint",
            library: &["footprint"],
            call: "y[0] = pixel_footprint(x[0], x[1], x[2]); y[1] = footprint_level(y[0], x[3]);",
            draw: &|rng| {
                let texel = 10.0_f32.powf(between(rng, -3.0, 0.0));
                vec![
                    between(rng, 20.0, 500.0),
                    between(rng, 1.0, 10.0),
                    between(rng, 16.0, 8192.0),
                    texel,
                ]
            },
            exact: &|x| {
                let size = footprint::pixel_footprint(x[0], x[1], x[2]);
                vec![size, footprint::footprint_level(size, x[3])]
            },
            // Three roundings, twice; a level is a logarithm of up to 15.
            absolute: 2e-6,
            relative: 5e-7,
            steep_share: 0.001,
        },
        &[],
        0,
        1e-2,
    );
}

#[test]
fn lamps() {
    let call = format!(
        "let c = lamp_radiance({}, vec3f(x[8], x[9], x[10]), x[11]); {RGB_OUT} y[3] = wrapped_cosine(x[9], x[11]); \
         let w = wrapped_cosines(x[9], vec3f(x[11], 0.3, 0.2)); y[4] = w.x; y[5] = w.z; y[6] = past_head(vec3f(x[8], x[9], x[10]));",
        lamp_text(0)
    );
    pass_unless_off(
        &Twin {
            name: "lamp_radiance",
            library: &["surroundings"],
            call: &call,
            draw: &|rng| {
                let mut x = draw_lamp(rng);
                // Half of the directions near the lamp, within its edges and across them.
                let near = between(rng, 0.0, 1.0) < 0.5;
                let reach = if near { 1.2 * f64::from(x[3]) } else { 3.0 };
                let at = DVec3::new(x[0].into(), x[1].into(), x[2].into());
                let aside = DVec3::from_array(unit(rng).map(f64::from));
                let d = (at + reach * aside).normalize().to_array();
                x.extend(d.map(|v| v as f32));
                x.push(between(rng, 0.0, if near { 0.1 } else { 0.5 }));
                x
            },
            exact: &|x| {
                let d = v3(&x[8..]);
                let mut out = rgb(surroundings::lamp_radiance(&lamp_of(x), d, x[11]));
                out.push(surroundings::wrapped_cosine(x[9], x[11]));
                let w = surroundings::wrapped_cosines(x[9], DVec3::new(x[11], 0.3, 0.2));
                out.extend([w.x, w.z, surroundings::past_head(d)]);
                out
            },
            // A chord carries 1e-7 over an edge of 0.04 with slope 1.5, in a disc of radiance up to 1, or, with
            // a hole, of one over what is left of it.
            absolute: 1e-5,
            relative: 0.0,
            // Where the blur is as wide as the hole.
            steep_share: 0.002,
        },
        &[],
        3,
        0.02,
    );
}

#[test]
fn what_surrounds_an_eye() {
    let studio = Studio::default().surroundings();
    // A coarse map: its texels tell places apart.
    let map = Map {
        name: "around_map",
        levels: studio.levels[3..].to_vec(),
        wrap: false,
    };
    let view = map.view();
    pass_unless_off(
        &Twin {
            name: "surroundings_radiance",
            library: &["surroundings"],
            call: "let d = vec3f(x[0], x[1], x[2]); let u = surroundings_uv(d); y[3] = u.x; y[4] = u.y; \
                   let c = surroundings_radiance(around_map, around_map_sampler, d, x[3]); y[0] = c.x; y[1] = c.y; y[2] = c.z;",
            draw: &|rng| {
                let mut x = unit(rng).to_vec();
                x.push(between(rng, 0.0, 0.4));
                x
            },
            exact: &|x| {
                let d = v3(x);
                let mut out = rgb(surroundings::surroundings_radiance(&view, d, x[3]));
                out.extend(surroundings::surroundings_uv(d).to_array());
                out
            },
            // A place is good to 3e-7 of 64 texels, between texels up to 10 apart.
            absolute: 5e-4,
            relative: 0.0,
            // Straight behind all places are one.
            steep_share: 0.003,
        },
        std::slice::from_ref(&map),
        0,
        0.05,
    );
    let call = format!(
        "let c = ambient_light(array<vec4f, 9>({}), vec3f(x[36], x[37], x[38])); {RGB_OUT}",
        vec4s(0, 9)
    );
    pass_unless_off(
        &Twin {
            name: "ambient_light",
            library: &["surroundings"],
            call: &call,
            draw: &|rng| {
                let mut x: Vec<f32> = (0..36).map(|_| between(rng, -0.2, 0.4)).collect();
                x.extend(unit(rng));
                x
            },
            exact: &|x| {
                let factors = core::array::from_fn(|i| v4(&x[4 * i..]).as_vec4());
                rgb(surroundings::ambient_light(&factors, v3(&x[36..])))
            },
            // A few roundings of numbers up to 1.
            absolute: 1e-6,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        36,
        1e-2,
    );
}

#[test]
fn a_place_in_a_table() {
    pass_unless_off(
        &Twin {
            name: "knot_at",
            library: &["knots"],
            // One number that is continuous where the knot changes.
            call: "let k = knot_at(x[0], i32(x[1])); y[0] = f32(k.below) + k.part; \
                   y[1] = select(0.0, 1.0, k.below >= 0 && k.below + 1 < i32(x[1]));",
            draw: &|rng| {
                let knots = between(rng, 2.0, 40.0).floor();
                vec![between(rng, -0.3, 1.3), knots]
            },
            exact: &|x| {
                let knot = knots::knot_at(x[0], x[1] as usize);
                vec![knot.below as f64 + knot.part, 1.0]
            },
            // Two roundings of a place among up to 39 intervals.
            absolute: 8e-6,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        0,
        1e-3,
    );
}

#[test]
fn the_lids() {
    let samples = 2 * LID_SAMPLES;
    let call = format!(
        "let p = vec3f(x[{}], x[{}], x[{}]); let at = lid_knot(p.x); \
         let s = lid_shade(LidSpan(x[at.below], x[at.below + 1], x[at.below + LID_SAMPLES], x[at.below + LID_SAMPLES + 1]), at.part, p); \
         y[0] = s.aside; y[1] = s.upper_gap; y[2] = s.lower_gap; y[3] = LIDS_SEND; \
         y[4] = lid_lamp(s, vec3f(x[{}], x[{}], x[{}]), x[{}]); y[5] = lid_sky_within(s, 3.0, 1.336); \
         var a = array<vec3f, 9>(); for (var i = 0; i < 9; i++) {{ a[i] = vec3f(1.0 - 0.2 * f32(i), 0.3 + 0.1 * f32(i), 0.5); }} \
         let around = sky_factors(a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]); \
         let sky = lid_sky(around, s, normalize(vec3f(x[{}], x[{}], x[{}]) - vec3f(0.0, 0.0, 2.0)), vec3f(0.3, 0.2, 0.1)); y[6] = sky.x; y[7] = sky.y; y[8] = sky.z;",
        samples,
        samples + 1,
        samples + 2,
        samples + 3,
        samples + 4,
        samples + 5,
        samples + 6,
        samples + 3,
        samples + 4,
        samples + 5
    );
    pass_unless_off(
        &Twin {
            name: "lid_shade",
            library: &["lid_shade"],
            call: &call,
            // Margins from wide open to crossed, and places past their ends.
            draw: &|rng| {
                let upper = between(rng, -6.0, 9.0);
                let lower = between(rng, -9.0, -2.0);
                let mut x: Vec<f32> = (0..samples)
                    .map(|i| {
                        let middle = if i < LID_SAMPLES { upper } else { lower };
                        middle + between(rng, -1.0, 1.0)
                    })
                    .collect();
                x.extend([between(rng, -25.0, 25.0), between(rng, -12.0, 12.0), -10.0]);
                x.extend(unit(rng));
                x.push(between(rng, 0.0, 1.2));
                x
            },
            exact: &|x| {
                let heights = |from: usize| core::array::from_fn(|i| x[from + i] as f32);
                let lids = LidMargins::new(heights(0), heights(LID_SAMPLES));
                let s = lid_shade::lids_at(&lids, v3(&x[samples..]));
                let lamp = lid_shade::lid_lamp(&s, v3(&x[samples + 3..]), x[samples + 6]);
                let within = lid_shade::lid_sky_within(&s, 3.0, 1.336);
                let around = core::array::from_fn(|i| {
                    let i = i as f32;
                    bevy::math::Vec4::new(1.0 - 0.2 * i, 0.3 + 0.1 * i, 0.5, 0.0)
                });
                let n = (v3(&x[samples + 3..]) - 2.0 * DVec3::Z).normalize();
                let sky = lid_shade::lid_sky(&around, &s, n, DVec3::new(0.3, 0.2, 0.1));
                let send = lid_shade::LIDS_SEND;
                let lids = [s.aside, s.upper_gap, s.lower_gap, send, lamp, within];
                [&lids[..], &rgb(sky)].concat()
            },
            // A place among 31 intervals is good to 4e-6, between heights 2 mm apart.
            absolute: 2e-5,
            relative: 0.0,
            steep_share: 0.001,
        },
        &[],
        samples + 1,
        1e-3,
    );
}

#[test]
fn the_limbus() {
    pass_unless_off(
        &Twin {
            name: "limbus_share",
            library: &["limbus"],
            call: "y[0] = limbus_share(x[0], x[1]); \
                   var table = array<vec4<f32>, 8>(); for (var i = 0; i < 8; i++) { let t = 0.1 + 0.1 * f32(i); table[i] = vec4f(t, t * t, 1.0 - t, 1.0); } \
                   let at = lamellae_knot(x[8]); let there = mix(table[at.below], table[at.below + 1], at.part).rgb; let whole = table[7].rgb; \
                   let c = limbus_through(there, whole) + 0.25 * limbus_white(there, whole); y[1] = c.x; y[2] = c.y; y[3] = c.z; \
                   let n = limbus_normal(vec3f(x[2], x[3], x[4]), vec3f(x[5], x[6], x[7]), y[0]); \
                   y[4] = n.x; y[5] = n.y; y[6] = n.z; y[7] = arcus_share(x[0], x[2], x[1], x[8], 0.6 + 0.5 * x[8]); y[8] = limbus_width(vec2f(x[0] * x[2], x[1] * x[3]), 6.0 * x[8]);",
            draw: &|rng| {
                let limbus = between(rng, 5.0, 6.5);
                let globe = unit(rng);
                // The two normals differ by less than a right angle wherever a limbus is.
                let tilt = unit(rng);
                let cornea = DVec3::new(
                    f64::from(globe[0]) + 0.6 * f64::from(tilt[0]),
                    f64::from(globe[1]) + 0.6 * f64::from(tilt[1]),
                    f64::from(globe[2]) + 0.6 * f64::from(tilt[2]),
                );
                let cornea = cornea.normalize().to_array().map(|v| v as f32);
                [
                    &[limbus + between(rng, -1.5, 1.5), limbus][..],
                    &globe,
                    &cornea,
                    &[between(rng, 0.0, 1.0)],
                ]
                .concat()
            },
            exact: &|x| {
                let share = limbus::limbus_share(x[0], x[1]);
                let normal = limbus::limbus_normal(v3(&x[2..]), v3(&x[5..]), share);
                let mut out = vec![share];
                let table: Vec<DVec3> = (0..8)
                    .map(|i| 0.1 + 0.1 * f64::from(i))
                    .map(|t| DVec3::new(t, t * t, 1.0 - t))
                    .collect();
                let at = limbus::lamellae_knot(x[8]);
                let there = table[at.below].lerp(table[at.below + 1], at.part);
                let through = limbus::limbus_through(there, table[7]);
                out.extend(rgb(through + 0.25 * limbus::limbus_white(there, table[7])));
                out.extend(rgb(normal));
                out.push(limbus::arcus_share(
                    x[0],
                    x[2],
                    x[1],
                    x[8],
                    0.6 + 0.5 * x[8],
                ));
                let place = glam::DVec2::new(x[0] * x[2], x[1] * x[3]);
                out.push(limbus::limbus_width(place, 6.0 * x[8]));
                out
            },
            // 6 mm carries 5e-7; over an edge of 1.35 mm and then over 0.35 of the share.
            absolute: 8e-6,
            relative: 0.0,
            steep_share: 0.001,
        },
        &[],
        0,
        1e-3,
    );
}

/// A normal, and a view within a right angle of it or a little past.
pub fn draw_views(rng: &mut Pcg64, x: &mut Vec<f32>) {
    let n = unit(rng);
    let mut v = unit(rng);
    while n[0] * v[0] + n[1] * v[1] + n[2] * v[2] < -0.2 {
        v = unit(rng);
    }
    x.extend(n);
    x.extend(v);
}

#[test]
fn lamp_lobes() {
    let call = "y[0] = lamp_lobe(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), vec3f(x[6], x[7], x[8]), \
                lamp_alpha(x[9], x[10]), x[11], x[12]);";
    pass_unless_off(
        &Twin {
            name: "lamp_lobe",
            library: &["lamp_lobe"],
            call,
            draw: &|rng| {
                let mut x = Vec::new();
                draw_views(rng, &mut x);
                let v = DVec3::new(x[3].into(), x[4].into(), x[5].into());
                // The half vector of opposite directions is none.
                let mut l = unit(rng);
                while v.dot(DVec3::from_array(l.map(f64::from))) < -0.98 {
                    l = unit(rng);
                }
                x.extend(l);
                x.extend([
                    between(rng, 0.1, 1.0),
                    between(rng, 0.0, 0.15),
                    between(rng, 1.3, 1.45),
                    0.05,
                ]);
                x
            },
            exact: &|x| {
                let alpha = lamp_lobe::lamp_alpha(x[9], x[10]);
                vec![lamp_lobe::lamp_lobe(
                    v3(x),
                    v3(&x[3..]),
                    v3(&x[6..]),
                    alpha,
                    x[11],
                    x[12],
                )]
            },
            // The half vector carries 1e-7, and a lobe with alpha 0.01 turns that into 1e-3 of itself.
            absolute: 1e-5,
            relative: 1e-4,
            steep_share: 0.01,
        },
        &[],
        9,
        1e-3,
    );
}

/// Where a mirror of [`draw_mirror`] is between its lids.
fn between_lids(x: &[f64]) -> LidShade {
    LidShade {
        aside: x[14],
        upper_gap: x[13],
        lower_gap: 8.0 - 0.9 * x[13],
    }
}

fn draw_mirror(rng: &mut Pcg64) -> Vec<f32> {
    let mut x: Vec<f32> = (0..6).map(|_| between(rng, 0.0, 1.0)).collect();
    draw_views(rng, &mut x);
    x.extend([
        between(rng, 0.0, 200.0),
        between(rng, -3.0, 12.0),
        between(rng, -14.0, 14.0),
        10.0_f32.powf(between(rng, -3.0, -0.5)),
    ]);
    x
}

pub const VIEWS: &str = "let m = vec3f(x[0], x[1], x[2]); let k = vec3f(x[3], x[4], x[5]); \
     let n = vec3f(x[6], x[7], x[8]); let v = vec3f(x[9], x[10], x[11]);";

#[test]
fn tears() {
    pass_unless_off(
        &Twin {
            name: "tear_reflection",
            library: &["tear_reflection"],
            call: &format!(
                "{VIEWS} let c = tear_reflection(m, k, n, v, x[12], LidShade(x[14], x[13], 8.0 - 0.9 * x[13]), 1.0); {RGB_OUT}"
            ),
            draw: &draw_mirror,
            exact: &|x| {
                rgb(tear_reflection::tear_reflection(
                    v3(x),
                    v3(&x[3..]),
                    [v3(&x[6..]), v3(&x[9..])],
                    x[12],
                    &between_lids(x),
                    // Seen from so far that the lashes' comb, which a test of its own runs, is even.
                    1.0,
                ))
            },
            // A film's cosine of its phase, of numbers up to 10.
            absolute: 2e-6,
            relative: 1e-5,
            steep_share: 0.002,
        },
        &[],
        13,
        0.1,
    );
    pass_unless_off(
        &Twin {
            name: "lashes_left",
            library: &["tear_reflection"],
            call: "let r = normalize(vec3f(x[6], x[7], x[8])); y[0] = lashes_pass(x[14], r, x[13], x[15]); \
                   y[1] = lashes_left(x[14], r, x[13], 0.06, 0.1 * x[15]); y[2] = lash_rise(x[13]);",
            draw: &draw_mirror,
            exact: &|x| {
                let r = v3(&x[6..]).normalize();
                vec![
                    tear_reflection::lashes_pass(x[14], r, x[13], x[15]),
                    lash_comb::lashes_left(x[14], r, x[13], 0.06, 0.1 * x[15]),
                    lash_comb::lash_rise(x[13]),
                ]
            },
            // 19 rad a millimetre at a place of 40 mm, good to 5e-6, through a step of 2.3 and 0.8.
            absolute: 2e-4,
            relative: 0.0,
            steep_share: 0.004,
        },
        &[],
        14,
        0.02,
    );
    pass_unless_off(
        &Twin {
            name: "tagged_pupil",
            library: &["tear_layer", "iris_relief"],
            call: "let tag = (u32(x[0]) << 16u) | u32(x[1]); y[0] = tear_age(tag); y[1] = tagged_pupil(tag); y[2] = BROKEN_BLUR;",
            draw: &|rng| vec![between(rng, 0.0, 65535.0), between(rng, 0.0, 65535.0)],
            exact: &|x| {
                let tag = (x[0] as u32) << 16 | x[1] as u32;
                vec![
                    tear_layer::tear_age(tag),
                    iris_relief::tagged_pupil(tag),
                    tear_layer::BROKEN_BLUR,
                ]
            },
            // An exponential of up to 6.
            absolute: 1e-6,
            relative: 3e-6,
            steep_share: 0.0,
        },
        &[],
        1,
        3.0,
    );
    pass_unless_off(
        &Twin {
            name: "tear_layer",
            library: &["tear_layer"],
            call: "let t = tear_layer(vec2f(x[0], x[1]), x[2], x[3], x[4], x[5]); y[0] = 0.01 * t.lipid_nm; y[1] = 100.0 * t.tilt.x; \
                   y[2] = 100.0 * t.tilt.y; y[3] = t.broken;",
            draw: &|rng| {
                vec![
                    between(rng, -14.0, 14.0),
                    between(rng, -10.0, 10.0),
                    10.0_f32.powf(between(rng, -3.0, 2.0)),
                    between(rng, 0.0, 200.0),
                    between(rng, 1.0, 60.0),
                    between(rng, 0.0, 6.3),
                ]
            },
            exact: &|x| {
                let layer = tear_layer::tear_layer(v2(x), x[2], x[3], x[4], x[5]);
                let tilt = 100.0 * layer.tilt;
                vec![0.01 * layer.lipid_nm, tilt.x, tilt.y, layer.broken]
            },
            // WGSL allows a sine 2^-11 within half a turn, and places here are up to fifteen turns away; half as much of the fresh
            // film's slope, and of where it breaks.
            absolute: 4e-3,
            relative: 1e-4,
            steep_share: 0.01,
        },
        &[],
        0,
        0.1,
    );
    pass_unless_off(
        &Twin {
            name: "meniscus_reflection",
            library: &["tear_reflection"],
            call: &format!(
                "{VIEWS} let c = meniscus_reflection(m, k, n, v, LidShade(x[14], x[13], 8.0 - 0.9 * x[13]), 1.0) * meniscus_blur(0.01 * x[12]); {RGB_OUT}"
            ),
            draw: &draw_mirror,
            exact: &|x| {
                let radiance = tear_reflection::meniscus_reflection(
                    v3(x),
                    v3(&x[3..]),
                    [v3(&x[6..]), v3(&x[9..])],
                    &between_lids(x),
                    // As above.
                    1.0,
                );
                rgb(radiance * tear_reflection::meniscus_blur(0.01 * x[12]))
            },
            absolute: 2e-6,
            relative: 1e-5,
            steep_share: 0.002,
        },
        &[],
        0,
        0.02,
    );
}

#[test]
fn hair() {
    pass_unless_off(
        &Twin {
            name: "hair_lamp",
            library: &["hair_shade"],
            call: &format!(
                "{VIEWS} let c = hair_lamp(m, n, v, vec3f(x[14], x[15], x[16])) + hair_ambient(m, k); {RGB_OUT}"
            ),
            draw: &|rng| {
                let mut x = draw_mirror(rng);
                let v = DVec3::new(x[9].into(), x[10].into(), x[11].into());
                // The half vector of opposite directions is none.
                let mut l = unit(rng);
                while v.dot(DVec3::from_array(l.map(f64::from))) < -0.98 {
                    l = unit(rng);
                }
                x.extend(l);
                x
            },
            exact: &|x| {
                let light = v3(&x[14..]);
                rgb(
                    hair_shade::hair_lamp(v3(x), v3(&x[6..]), v3(&x[9..]), light)
                        + hair_shade::hair_ambient(v3(x), v3(&x[3..])),
                )
            },
            // The half vector carries 5e-7 where it is short; a power of 60 makes 60 times that, of 0.035.
            absolute: 5e-6,
            relative: 1e-5,
            steep_share: 0.005,
        },
        &[],
        0,
        1e-2,
    );
}

#[test]
fn ribbon() {
    pass_unless_off(
        &Twin {
            name: "hair_ribbon",
            library: &["hair_shade"],
            call: &format!("{VIEWS} let c = hair_ribbon(m, k, n, v, x[12]); {RGB_OUT}"),
            draw: &|rng| {
                let mut x: Vec<f32> = (0..3).map(|_| between(rng, -20.0, 20.0)).collect();
                x.extend(unit(rng));
                x.extend(unit(rng));
                let away = between(rng, 30.0, 500.0);
                x.extend(unit(rng).map(|c| c * away));
                x.push(between(rng, -0.1, 0.1));
                x
            },
            exact: &|x| {
                rgb(hair_shade::hair_ribbon(
                    v3(x),
                    v3(&x[3..]),
                    v3(&x[6..]),
                    v3(&x[9..]),
                    x[12],
                ))
            },
            // Places of 20 mm carry 2e-6; which side is which flips where the chord points at the camera.
            absolute: 5e-6,
            relative: 1e-6,
            steep_share: 0.001,
        },
        &[],
        0,
        1e-3,
    );
}
#[test]
fn coverage() {
    pass_unless_off(
        &Twin {
            name: "hair_coverage",
            library: &["hair_shade"],
            call: "y[0] = hair_coverage(x[0], x[1], x[2]); y[1] = hair_drawn(x[0], x[1]); y[2] = hair_rooted(0.2 * x[2]);",
            draw: &|rng| {
                vec![
                    between(rng, -0.1, 0.1),
                    between(rng, 0.01, 0.5),
                    between(rng, -0.5, 0.5),
                ]
            },
            exact: &|x| {
                vec![
                    hair_shade::hair_coverage(x[0], x[1], x[2]),
                    hair_shade::hair_drawn(x[0], x[1]),
                    hair_shade::hair_rooted(0.2 * x[2]),
                ]
            },
            // Differences of quotients up to 60.
            absolute: 1e-5,
            relative: 1e-6,
            steep_share: 0.001,
        },
        &[],
        1,
        1e-3,
    );
}

#[test]
fn clouded_lenses() {
    pass_unless_off(
        &Twin {
            name: "lens_cloud",
            library: &["lens_shade"],
            call: &format!(
                "let c = lens_cloud(vec3f(x[0], x[1], x[2]), vec3f(x[7], x[8], x[9]), x[4], x[3], vec2f(x[5], x[6]), vec2f(x[10], x[11]), x[12]); {RGB_OUT} \
                 y[3] = cortical_wedges(vec2f(x[5], x[6]), x[3], x[12]); y[4] = capsule_cloud(vec2f(x[5], x[6]), x[4]);"
            ),
            draw: &|rng| {
                vec![
                    between(rng, 0.0, 0.2),
                    between(rng, 0.0, 0.2),
                    between(rng, 0.0, 0.2),
                    between(rng, 0.0, 0.6),
                    between(rng, 0.0, 3.0),
                    between(rng, -4.0, 4.0),
                    between(rng, -4.0, 4.0),
                    between(rng, 0.0, 0.1),
                    between(rng, 0.0, 0.1),
                    between(rng, 0.0, 0.1),
                    between(rng, -0.7, 0.7),
                    between(rng, -0.7, 0.7),
                    between(rng, 0.0, 6.3),
                ]
            },
            exact: &|x| {
                let place = glam::DVec2::new(x[5], x[6]);
                let color = lens_shade::lens_cloud(
                    v3(x),
                    v3(&x[7..]),
                    x[4],
                    x[3],
                    place,
                    v2(&x[10..]),
                    x[12],
                );
                let mut out = rgb(color);
                out.push(lens_shade::cortical_wedges(place, x[3], x[12]));
                out.push(lens_shade::capsule_cloud(place, x[4]));
                out
            },
            // WGSL lets sines have an error of 2^-11; nested ones turn it by 7 a millimetre, over an edge
            // of 0.4 mm.
            absolute: 2e-2,
            relative: 0.0,
            steep_share: 0.002,
        },
        &[],
        3,
        0.1,
    );
}
