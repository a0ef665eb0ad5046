//! How the eye's surfaces answer light, without their maps: studio, lids, limbus, tears, hair.
//!
//! Each comparison is made twice: with the twin, which must agree, and with the twin asked for one
//! input slightly off, which must not.

use super::{between, unit, v2, v3};
use crate::gpu::{Map, Twin};
use bevy::math::Vec3;
use glam::{DVec3, DVec4};
use ocularium::appearance::Studio;
use ocularium::appearance::materials::{LID_SAMPLES, LidHeights};
use ocularium::appearance::shading::lid_shade::LidShade;
use ocularium::appearance::shading::{
    footprint, hair_shade, lamp_lobe, lens_shade, lid_shade, limbus, studio, tear_reflection,
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

/// Lamps anywhere but straight above or below, from points to wide ones, and any colours; the fill's
/// radiance over its disc is at most 1, so that the arc cosine's error counts for no more.
pub fn draw_studio(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = Vec::with_capacity(24);
    let colors = |rng: &mut Pcg64, most: f32| -> Vec<f32> {
        let mut color: Vec<f32> = (0..3).map(|_| between(rng, 0.0, most)).collect();
        color.push(1.0);
        color
    };
    let mut key = unit(rng);
    while key[1].abs() > 0.98 {
        key = unit(rng);
    }
    x.extend(key);
    x.push(between(rng, 0.05, 0.5));
    x.extend(colors(rng, 1.0));
    x.extend(unit(rng));
    let radius = between(rng, 0.03, 0.3);
    x.push(radius);
    x.extend(colors(rng, radius * radius));
    x.extend(colors(rng, 1.0));
    x.extend(colors(rng, 1.0));
    // The key light is a window, or a round lamp.
    x[15] = f32::from(u8::from(between(rng, 0.0, 1.0) < 0.5));
    x
}

/// The call's studio, from 24 numbers from `first` on.
pub fn studio_text(first: usize) -> String {
    let parts: Vec<String> = (0..6)
        .map(|k| {
            let i = first + 4 * k;
            format!("vec3f(x[{i}], x[{}], x[{}]), x[{}]", i + 1, i + 2, i + 3)
        })
        .collect();
    parts.join(", ")
}

pub fn studio_of(x: &[f64]) -> Studio {
    let three = |i: usize| v3(&x[4 * i..]).as_vec3();
    let one = |i: usize| x[4 * i + 3] as f32;
    Studio {
        key_direction: three(0),
        key_radius: one(0),
        key_color: three(1),
        exposure: one(1),
        fill_direction: three(2),
        fill_radius: one(2),
        fill_color: three(3),
        is_window: one(3),
        ambient_up: three(4),
        is_luminance: one(4),
        ambient_down: three(5),
        unused: one(5),
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

fn draw_radiance(rng: &mut Pcg64, lamp: usize) -> Vec<f32> {
    let mut x = draw_studio(rng);
    // Half of the directions near the lamp, within its edges and across them.
    let near = between(rng, 0.0, 1.0) < 0.5;
    let at = DVec3::new(
        x[8 * lamp].into(),
        x[8 * lamp + 1].into(),
        x[8 * lamp + 2].into(),
    );
    let reach = if near {
        f64::from(x[8 * lamp + 3])
    } else {
        3.0
    };
    let aside = DVec3::from_array(unit(rng).map(f64::from));
    let d = (at + reach * aside)
        .normalize()
        .to_array()
        .map(|v| v as f32);
    x.extend(d);
    x.push(if near {
        between(rng, 0.0, 0.1)
    } else {
        between(rng, 0.0, 0.5)
    });
    x
}

#[test]
fn the_studio() {
    let call = format!(
        "let c = studio_radiance(Studio({}), vec3f(x[24], x[25], x[26]), x[27]); {RGB_OUT}",
        studio_text(0)
    );
    let exact = |x: &[f64]| rgb(studio::studio_radiance(&studio_of(x), v3(&x[24..]), x[27]));
    for lamp in 0..2 {
        pass_unless_off(
            &Twin {
                name: "studio_radiance",
                library: &["studio"],
                call: &call,
                draw: &|rng| draw_radiance(rng, lamp),
                exact: &exact,
                // WGSL lets an arc cosine have an arc tangent's 4096 roundings: 7e-5 of 0.3 rad, over an
                // edge of 0.04 with slope 1.5. The window's edge of 0.016 does a tenth of that to what
                // f32 makes of a place, times a radiance of 100 and more: in proportion.
                absolute: 3e-3,
                relative: 3e-4,
                steep_share: 0.002,
            },
            &[],
            4 * (2 * lamp + 1),
            0.02,
        );
    }
    // Away from lamps the surroundings are known to rounding.
    let call = format!(
        "let s = Studio({}); let c = studio_ambient(s, vec3f(x[24], x[25], x[26])); {RGB_OUT} y[3] = wrapped_cosine(x[25], x[27]);",
        studio_text(0)
    );
    pass_unless_off(
        &Twin {
            name: "studio_ambient",
            library: &["studio"],
            call: &call,
            draw: &|rng| draw_radiance(rng, 0),
            exact: &|x| {
                let mut out = rgb(studio::studio_ambient(&studio_of(x), v3(&x[24..])));
                out.push(studio::wrapped_cosine(x[25], x[27]));
                out
            },
            // A few roundings of numbers up to 1.
            absolute: 5e-7,
            relative: 0.0,
            steep_share: 0.001,
        },
        &[],
        25,
        1e-4,
    );
}

#[test]
fn the_lids() {
    let samples = 2 * LID_SAMPLES;
    let call = format!(
        "let s = lid_shade(Lids(array<vec4f, 8>({}), array<vec4f, 8>({})), vec3f(x[{}], x[{}], x[{}])); \
         y[0] = s.sky; y[1] = s.key; y[2] = s.upper_gap; y[3] = s.lower_gap;",
        vec4s(0, 8),
        vec4s(LID_SAMPLES, 8),
        samples,
        samples + 1,
        samples + 2
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
                x
            },
            exact: &|x| {
                let four = |i: usize| v4(&x[4 * i..]).as_vec4();
                let lids = LidHeights {
                    upper: core::array::from_fn(four),
                    lower: core::array::from_fn(|i| four(i + LID_SAMPLES / 4)),
                };
                let s = lid_shade::lid_shade(&lids, v3(&x[samples..]));
                vec![s.sky, s.key, s.upper_gap, s.lower_gap]
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
            call: "y[0] = limbus_share(x[0], x[1]); let c = limbus_tint(y[0]); y[1] = c.x; y[2] = c.y; y[3] = c.z; \
                   let n = limbus_normal(vec3f(x[2], x[3], x[4]), vec3f(x[5], x[6], x[7]), y[0]); \
                   y[4] = n.x; y[5] = n.y; y[6] = n.z;",
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
                    &[limbus + between(rng, -1.5, 1.0), limbus][..],
                    &globe,
                    &cornea,
                ]
                .concat()
            },
            exact: &|x| {
                let share = limbus::limbus_share(x[0], x[1]);
                let normal = limbus::limbus_normal(v3(&x[2..]), v3(&x[5..]), share);
                let mut out = vec![share];
                out.extend(rgb(limbus::limbus_tint(share)));
                out.extend(rgb(normal));
                out
            },
            // 6 mm carries 5e-7; over an edge of 1.05 mm and then over 0.35 of the share.
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

fn draw_mirror(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = draw_studio(rng);
    draw_views(rng, &mut x);
    x.extend([
        between(rng, 0.0, 0.3),
        between(rng, 0.0, 200.0),
        between(rng, -3.0, 12.0),
    ]);
    x
}

pub const VIEWS: &str = "let n = vec3f(x[24], x[25], x[26]); let v = vec3f(x[27], x[28], x[29]);";

#[test]
fn tears() {
    let call = format!(
        "let s = Studio({}); {VIEWS} let c = tear_reflection(s, n, v, x[30], x[31], x[32]); {RGB_OUT}",
        studio_text(0)
    );
    pass_unless_off(
        &Twin {
            name: "tear_reflection",
            library: &["tear_reflection"],
            call: &call,
            draw: &draw_mirror,
            exact: &|x| {
                let (n, v) = (v3(&x[24..]), v3(&x[27..]));
                rgb(tear_reflection::tear_reflection(
                    &studio_of(x),
                    n,
                    v,
                    x[30],
                    x[31],
                    x[32],
                ))
            },
            // The film reflects at most what the studio's radiance is off by.
            absolute: 3e-3,
            relative: 3e-4,
            steep_share: 0.002,
        },
        &[],
        32,
        0.1,
    );
    let call = format!(
        "let s = Studio({}); {VIEWS} let c = meniscus_reflection(s, n, v); {RGB_OUT}",
        studio_text(0)
    );
    pass_unless_off(
        &Twin {
            name: "meniscus_reflection",
            library: &["tear_reflection"],
            call: &call,
            draw: &draw_mirror,
            exact: &|x| {
                rgb(tear_reflection::meniscus_reflection(
                    &studio_of(x),
                    v3(&x[24..]),
                    v3(&x[27..]),
                ))
            },
            absolute: 3e-3,
            relative: 3e-4,
            steep_share: 0.002,
        },
        &[],
        24,
        0.02,
    );
}

#[test]
fn hair() {
    let call = format!(
        "let s = Studio({}); {VIEWS} let c = hair_radiance(s, vec3f(x[30], x[31], x[32]), n, v); {RGB_OUT}",
        studio_text(0)
    );
    pass_unless_off(
        &Twin {
            name: "hair_radiance",
            library: &["hair_shade"],
            call: &call,
            draw: &|rng| {
                let mut x = draw_studio(rng);
                draw_views(rng, &mut x);
                x.extend((0..3).map(|_| between(rng, 0.0, 1.0)));
                x
            },
            exact: &|x| {
                let (along, v, color) = (v3(&x[24..]), v3(&x[27..]), v3(&x[30..]));
                rgb(hair_shade::hair_radiance(&studio_of(x), color, along, v))
            },
            // The sixtieth power of a sine near 1 makes sixty roundings of one.
            absolute: 1e-5,
            relative: 1e-5,
            steep_share: 0.01,
        },
        &[],
        24,
        1e-3,
    );
}

/// Any shade that lids can make.
pub fn draw_shade(rng: &mut Pcg64) -> [f32; 4] {
    [
        between(rng, 0.0, 1.0),
        between(rng, 0.0, 1.0),
        between(rng, -2.0, 10.0),
        between(rng, -2.0, 10.0),
    ]
}

pub fn shade_of(x: &[f64]) -> LidShade {
    LidShade {
        sky: x[0],
        key: x[1],
        upper_gap: x[2],
        lower_gap: x[3],
    }
}

#[test]
fn a_studio_is_read_in_its_order() {
    let x: Vec<f64> = (0..24).map(f64::from).collect();
    let studio = studio_of(&x);
    assert_eq!(studio.ambient_up, Vec3::new(16.0, 17.0, 18.0));
    assert_eq!((studio.is_window, studio.is_luminance), (15.0, 19.0));
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
