//! Sclera and iris with their maps: as textures on the device and as the same texels in f64.

use super::shading::{RGB_OUT, pass_unless_off, rgb};
use super::{between, unit, v2, v3};
use crate::gpu::{Map, Twin};
use glam::{DVec2, DVec3};
use ocularium::appearance::iris_map::{IrisMap, IrisMapSettings};
use ocularium::appearance::light_table::{
    LightTableSettings, LightTableSize, SKY_RADII, iris_light, iris_sky_knot,
};
use ocularium::appearance::sclera_map::{ScleraMap, ScleraMapSettings};
use ocularium::appearance::shading::iris_relief::{self, IrisFrame};
use ocularium::appearance::shading::iris_shade::{self, IrisMaps};
use ocularium::appearance::shading::sclera_shade::{self, ScleraSight};
use ocularium::tissue::iris_reflectance::{IrisPigment, IrisTissue};
use rand_pcg::Pcg64;

/// A point of the globe's front half and a normal near to it.
fn draw_place(rng: &mut Pcg64) -> [f32; 6] {
    let out = DVec3::from_array(unit(rng).map(f64::from));
    let p = DVec3::new(out.x, out.y, -out.z.abs() - 1e-3).normalize();
    let tilt = 0.2 * DVec3::from_array(unit(rng).map(f64::from));
    let (p, n) = (12.0 * p, (p + tilt).normalize());
    [p.x, p.y, p.z, n.x, n.y, n.z].map(|v| v as f32)
}

#[test]
fn sclera() {
    let map = ScleraMap::new(&ScleraMapSettings::default(), 1024);
    pass_unless_off(
        &Twin {
            name: "sclera_uv",
            library: &["sclera_shade"],
            call: "let u = sclera_uv(vec3f(x[0], x[1], x[2])); y[0] = u.x; y[1] = u.y;",
            draw: &|rng| draw_place(rng).to_vec(),
            exact: &|x| sclera_shade::sclera_uv(v3(x)).to_array().to_vec(),
            // WGSL lets an arc cosine have an arc tangent's 4096 roundings: 3.8e-4 of a right angle, here
            // over twice 100°.
            absolute: 1.1e-4,
            relative: 0.0,
            // At the pole the direction is a matter of rounding.
            steep_share: 0.001,
        },
        &[],
        0,
        1e-2,
    );
    pass_unless_off(
        &Twin {
            name: "conjunctiva_filter",
            library: &["sclera_shade"],
            call: "let c = conjunctiva_filter(vec3f(x[0], x[1], x[2]), vec3f(x[4], x[5], x[6]), x[3]); \
                   y[0] = c.x; y[1] = c.y; y[2] = c.z;",
            draw: &|rng| {
                let mut x: Vec<f32> = (0..3).map(|_| between(rng, 0.01, 0.9)).collect();
                x.push(between(rng, -0.2, 1.2));
                x.extend((0..3).map(|_| between(rng, 0.0, 0.9)));
                x
            },
            exact: &|x| rgb(sclera_shade::conjunctiva_filter(v3(x), v3(&x[4..]), x[3])),
            absolute: 0.0,
            // A power is an exponential of a logarithm: 4 roundings of a logarithm of up to 6.5 (WGSL 15.7.4).
            relative: 1e-5,
            steep_share: 0.0,
        },
        &[],
        3,
        1e-2,
    );
    pass_unless_off(
        &Twin {
            name: "vessel_filter",
            library: &["sclera_shade"],
            call: "let c = vessel_filter(x[0], x[1], x[2], vec3f(x[3], x[4], x[5])); \
                   let d = view_shift(normalize(vec3f(x[6], x[7], -1.0)), normalize(vec3f(x[8], x[9], -1.0)), x[0]); \
                   y[0] = c.x; y[1] = c.y; y[2] = c.z; y[3] = d.x; y[4] = d.y; y[5] = d.z;",
            draw: &|rng| {
                let mut x: Vec<f32> = (0..3).map(|_| between(rng, 0.0, 0.3)).collect();
                x.extend((0..3).map(|_| between(rng, 0.0, 1.0)));
                x.extend((0..4).map(|_| between(rng, -2.0, 2.0)));
                x
            },
            exact: &|x| {
                let c = sclera_shade::vessel_filter(x[0], x[1], x[2], v3(&x[3..]));
                let unit = |x: f64, y: f64| DVec3::new(x, y, -1.0).normalize();
                let d = sclera_shade::view_shift(unit(x[6], x[7]), unit(x[8], x[9]), x[0]);
                [rgb(c), rgb(d)].concat()
            },
            // Exponentials down to 1e-50 beside sums of 1.
            absolute: 1e-6,
            relative: 1e-5,
            steep_share: 0.0,
        },
        &[],
        2,
        1e-2,
    );
    let colors = Map {
        name: "sclera_map",
        levels: map.levels(),
        wrap: false,
    };
    let vessels = Map {
        name: "vessel_map",
        levels: map.vessel_levels(),
        wrap: false,
    };
    let (color_view, vessel_view) = (colors.view(), vessels.view());
    let above = DVec3::new(0.2, 0.3, 0.45);
    pass_unless_off(
        &Twin {
            name: "lump_color",
            library: &["sclera_shade"],
            call: &format!("let c = lump_color(x[0]); {RGB_OUT}"),
            draw: &|rng| vec![between(rng, -0.05, 0.2)],
            exact: &|x| rgb(sclera_shade::lump_color(x[0])),
            // A cubic of numbers of one.
            absolute: 1e-6,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        0,
        1e-2,
    );
    pass_unless_off(
        &Twin {
            name: "lumps_at",
            library: &["sclera_shade"],
            call: "let r = lumps_at(vessel_map, vessel_map_sampler, vec3f(x[0], x[1], x[2]), x[6], x[7]); \
                   y[0] = 20.0 * r.x; y[1] = r.y; y[2] = r.z; y[3] = r.w;",
            draw: &|rng| {
                let mut x = draw_place(rng).to_vec();
                x.extend([
                    10.0_f32.powf(between(rng, -3.0, 0.5)),
                    between(rng, 10.5, 12.5),
                ]);
                x
            },
            exact: &|x| {
                let lumps = sclera_shade::lumps_at(&vessel_view, v3(x), x[6], x[7]);
                vec![20.0 * lumps.x, lumps.y, lumps.z, lumps.w]
            },
            // A ninth of a texel of 0.04 mm, as for the white's own relief; where lumps meet the slope changes by 0.7 within one.
            absolute: 8e-2,
            relative: 0.0,
            // Where the level jumps to the next.
            steep_share: 0.004,
        },
        std::slice::from_ref(&vessels),
        0,
        0.1,
    );
    pass_unless_off(
        &Twin {
            name: "sclera_normal",
            library: &["sclera_shade"],
            call: "let u = unseen_slopes(x[6]); y[0] = 100.0 * u; y[1] = white_rough(0.1 + 0.01 * x[6], u); y[2] = mirror_spread(y[1]); \
                   let n = sclera_normal(vec3f(x[3], x[4], x[5]), vec3f(x[0], x[1], x[2]), vec2f(x[7], x[8])); \
                   y[3] = n.x; y[4] = n.y; y[5] = n.z; y[6] = sclera_lamp(x[7]).x;",
            draw: &|rng| {
                let mut x = draw_place(rng).to_vec();
                x.extend([
                    10.0_f32.powf(between(rng, -3.0, 0.5)),
                    between(rng, -0.5, 0.5),
                    between(rng, -0.5, 0.5),
                ]);
                x
            },
            exact: &|x| {
                let u = sclera_shade::unseen_slopes(x[6]);
                let rough = sclera_shade::white_rough(0.1 + 0.01 * x[6], u);
                let rise = DVec2::new(x[7], x[8]);
                let n = sclera_shade::sclera_normal(v3(&x[3..]), v3(x), rise);
                let spread = sclera_shade::mirror_spread(rough);
                let lamp = sclera_shade::sclera_lamp(x[7]).x;
                vec![100.0 * u, rough, spread, n.x, n.y, n.z, lamp]
            },
            // An arc cosine of a device is good to 1e-4 rad near straight on, where it is divided by its sine.
            absolute: 2e-4,
            relative: 1e-5,
            steep_share: 0.002,
        },
        &[],
        6,
        0.1,
    );
    pass_unless_off(
        &Twin {
            name: "sclera_surface",
            library: &["sclera_shade"],
            call: "let r = sclera_surface(sclera_map, vessel_map, sclera_map_sampler, vec3f(x[0], x[1], x[2]), \
                   vec3f(x[3], x[4], x[5]), normalize(vec3f(x[3], x[4], x[5]) + vec3f(x[8], x[9], x[10])), x[6], x[7], \
                   vec3f(0.2, 0.3, 0.45)); let c = r.albedo; y[0] = c.x; y[1] = c.y; y[2] = c.z; \
                   y[3] = r.normal.x; y[4] = r.normal.y; y[5] = r.normal.z; \
                   y[6] = r.soft.x; y[7] = r.soft.y; y[8] = textureSampleLevel(vessel_map, vessel_map_sampler, vec2f(0.5), 0.0).a;",
            draw: &|rng| {
                let mut x = draw_place(rng).to_vec();
                x.extend([
                    10.0_f32.powf(between(rng, -3.0, 0.5)),
                    between(rng, 10.5, 12.5),
                ]);
                x.extend((0..3).map(|_| between(rng, -0.5, 0.5)));
                x
            },
            exact: &|x| {
                let sight = ScleraSight {
                    p: v3(x),
                    normal: v3(&x[3..]),
                    v: (v3(&x[3..]) + v3(&x[8..])).normalize(),
                    footprint: x[6],
                };
                let r =
                    sclera_shade::sclera_surface(&color_view, &vessel_view, &sight, x[7], above);
                [rgb(r.albedo), rgb(r.normal), vec![r.soft.x, r.soft.y, 0.0]].concat()
            },
            // The place is good to 1.1e-4 of 1024 texels, a ninth of one, between texels of vessels and ripples.
            absolute: 9e-3,
            relative: 5e-6,
            // Where the level jumps to the next.
            steep_share: 0.002,
        },
        &[colors.clone(), vessels.clone()],
        10,
        0.3,
    );
}

fn light_table() -> Map {
    let settings = LightTableSettings {
        surface: DVec2::new(7.8, 0.75),
        index: 1.336,
        iris_z: 3.6,
        root_mm: 6.05,
        limbus_mm: 5.85,
    };
    Map {
        name: "light_table",
        levels: vec![settings.table(LightTableSize::PICTURE)],
        wrap: false,
    }
}

/// A smooth reflectance that falls with path and melanin, other in each colour.
fn reflectance_map() -> Map {
    let texel = |i: u16| {
        let (path, melanin) = (f32::from(i % 32) / 31.0, f32::from(i / 32) / 15.0);
        let of = |k: f32| (1.0 - (-k * (0.2 + path)).exp()) * (1.0 - 0.7 * melanin);
        [of(0.6), of(1.1), of(1.9), 1.0]
    };
    Map {
        name: "reflectance_map",
        levels: vec![(32, 16, (0..512).map(texel).collect())],
        wrap: false,
    }
}

fn iris_map() -> Map {
    Map {
        name: "iris_map",
        levels: IrisMap::new(&IrisMapSettings::default(), 256, 64).levels(),
        wrap: true,
    }
}

/// Radii from 1 to 9 mm of pupil, its centre up to a millimetre off, and a place of the iris plane.
fn draw_iris(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = vec![
        between(rng, 5.0, 6.6),
        between(rng, 0.5, 4.5),
        between(rng, 5.0, 6.5),
        0.8,
        between(rng, -1.0, 1.0),
        between(rng, -1.0, 1.0),
    ];
    let r = between(rng, 0.3, 6.5);
    let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
    x.extend([r * cos, r * sin]);
    x
}

fn iris_of(x: &[f64]) -> IrisFrame {
    IrisFrame {
        root: x[0],
        pupil: x[1],
        limbus: x[2],
        relief: x[3],
        center: v2(&x[4..]),
        thicken: 1.3,
        furrows: 0.7,
        cone: 0.15,
        bow: 0.2,
    }
}

const IRIS: &str = "let iris = IrisFrame(x[0], x[1], x[2], x[3], vec2f(x[4], x[5]), 1.3, 0.7, 0.15, 0.2); let p = vec2f(x[6], x[7]);";

#[test]
fn places_of_the_iris() {
    pass_unless_off(
        &Twin {
            name: "iris_place",
            library: &["iris_relief"],
            call: &format!(
                "{IRIS} let q = iris_place(p, iris); y[0] = cos(6.2831853 * q.uv.x); y[1] = sin(6.2831853 * q.uv.x); y[2] = q.uv.y; \
                 let s = iris_step(iris, q, vec2f(0.1, -0.2)) - q.uv; y[3] = s.x; y[4] = s.y;"
            ),
            draw: &draw_iris,
            exact: &|x| {
                let q = iris_relief::iris_place(v2(&x[6..]), &iris_of(x));
                let (sin, cos) = (core::f64::consts::TAU * q.uv.x).sin_cos();
                let step = iris_relief::iris_step(&iris_of(x), &q, DVec2::new(0.1, -0.2)) - q.uv;
                vec![cos, sin, q.uv.y, step.x, step.y]
            },
            // u jumps at the seam, so its circle is compared: WGSL allows an arc tangent 4096 roundings
            // and a cosine 2^-11. The rest is good to a few roundings of v, up to 12.
            absolute: 1e-3,
            relative: 0.0,
            steep_share: 0.001,
        },
        &[],
        4,
        0.01,
    );
}

#[test]
fn where_rays_land_on_the_iris() {
    pass_unless_off(
        &Twin {
            name: "iris_landing",
            library: &["iris_relief"],
            call: &format!(
                "{IRIS} let d = vec3f(x[8], x[9], x[10]); let m = iris_landing(p, d, iris); y[0] = m.x; y[1] = m.y; \
                 let b = iris_base(x[11], iris); y[2] = b.x; y[3] = b.y; \
                 let l = iris_lean(iris_place(p, iris), iris); y[4] = l.x; y[5] = l.y; y[6] = iris_within(d, l).z;"
            ),
            draw: &|rng| {
                let mut x = draw_march(rng);
                x[11] = between(rng, -0.2, 1.2);
                x
            },
            exact: &|x| {
                let (iris, p, d) = (iris_of(x), v2(&x[6..]), v3(&x[8..]));
                let landing = iris_relief::iris_landing(p, d, &iris);
                let base = iris_relief::iris_base(x[11], &iris);
                let lean = iris_relief::iris_lean(&iris_relief::iris_place(p, &iris), &iris);
                let within = iris_relief::iris_within(d, lean);
                [landing, base, lean]
                    .iter()
                    .flat_map(|v| v.to_array())
                    .chain([within.z])
                    .collect()
            },
            // Places are up to 6.5 mm, good to a few roundings.
            absolute: 1e-5,
            relative: 0.0,
            // Where the mean iris begins and ends, its slope jumps.
            steep_share: 0.005,
        },
        &[],
        8,
        0.01,
    );
}

#[test]
fn the_iris_by_its_pupil() {
    pass_unless_off(
        &Twin {
            name: "thicken",
            library: &["iris_relief"],
            call: "y[0] = thicken(x[0], x[1]); y[1] = furrow_depth(x[0]);",
            draw: &|rng| vec![between(rng, 0.0, 5.0), between(rng, 5.0, 6.6)],
            exact: &|x| {
                vec![
                    iris_relief::thicken(x[0], x[1]),
                    iris_relief::furrow_depth(x[0]),
                ]
            },
            // A root's slope is unbounded where furrows begin; what is left of the iris is at least 4 of its 44 mm².
            absolute: 1e-5,
            relative: 2e-6,
            steep_share: 0.001,
        },
        &[],
        0,
        0.01,
    );
}

/// The iris, a ray inside the eye, a light, a footprint and a level.
fn draw_march(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = draw_iris(rng);
    for side in [1.0, -1.0] {
        let (s, c) = between(rng, 0.0, 0.9).sin_cos();
        let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
        x.extend([s * cos, s * sin, side * c]);
    }
    x.extend([
        10.0_f32.powf(between(rng, -2.5, 0.0)),
        between(rng, 0.0, 2.4),
    ]);
    x
}

#[test]
fn the_relief_of_the_iris() {
    let map = iris_map();
    let view = map.view();
    pass_unless_off(
        &Twin {
            name: "relief_march",
            library: &["iris_relief"],
            call: &format!(
                "{IRIS} let q = iris_place(p, iris); let d = vec3f(x[8], x[9], x[10]); let l = vec3f(x[11], x[12], x[13]); \
                 let m = relief_march(iris_map, iris_map_sampler, iris, q, d, x[15], IRIS_MARCH_FAST); y[0] = m.x; y[1] = m.y; \
                 let f = relief_march(iris_map, iris_map_sampler, iris, q, d, x[15], IRIS_MARCH_FIXED); y[10] = f.x; y[11] = f.y; \
                 let t = iris_texel(iris_map, iris_map_sampler, iris, q.uv, x[15]); y[2] = t.height; y[3] = t.thickness; y[4] = t.melanin; \
                 let n = relief_normal(iris_map, iris_map_sampler, iris, q, max(x[14], 0.012), x[15], iris_lean(q, iris)); y[5] = n.x; y[6] = n.y; y[7] = n.z; \
                 let g = relief_way(iris_map, iris_map_sampler, iris, q, 0.2 * d.z - t.height, l, x[15], 4); y[8] = g.x; y[12] = g.y; y[13] = g.z; \
                 y[9] = iris_level(vec2f(textureDimensions(iris_map)), x[14], d, q);"
            ),
            draw: &draw_march,
            exact: &|x| {
                let (iris, p, lod) = (iris_of(x), v2(&x[6..]), x[15]);
                let (d, l) = (v3(&x[8..]), v3(&x[11..]));
                let q = iris_relief::iris_place(p, &iris);
                let march = |march| iris_relief::relief_march(&view, &iris, &q, d, lod, march);
                let moved = march(&iris_relief::IRIS_MARCH_FAST);
                let fixed = march(&iris_relief::IRIS_MARCH_FIXED);
                let t = iris_relief::iris_texel(&view, &iris, q.uv, lod);
                let lean = iris_relief::iris_lean(&q, &iris);
                let n = iris_relief::relief_normal(&view, &iris, &q, x[14].max(0.012), lod, lean);
                let under = 0.2 * d.z - t.height;
                let way = iris_relief::relief_way(&view, &iris, &q, under, l, lod, 4);
                let level = iris_relief::iris_level(view.size(), x[14], d, &q);
                [
                    &moved.to_array()[..],
                    &[t.height, t.thickness, t.melanin],
                    &n.to_array(),
                    &[way.x, level],
                    &fixed.to_array(),
                    &[way.y, way.z],
                ]
                .concat()
            },
            // An arc tangent off by 1e-5 moves a place by 5e-4 of 256 texels, between heights up to a
            // tenth of a millimetre apart; over the shadow's edge of 0.1 mm and the normal's 0.012 mm
            // both of a difference of two.
            absolute: 2e-3,
            relative: 0.0,
            // Where the ray grazes a ridge, and where the level jumps.
            steep_share: 0.01,
        },
        std::slice::from_ref(&map),
        8,
        0.05,
    );
}

#[test]
fn the_light_of_the_iris() {
    let maps = [iris_map(), reflectance_map(), light_table()];
    let views = IrisMaps {
        relief: maps[0].view(),
        reflectance: maps[1].view(),
        light: maps[2].view(),
    };
    let sky: [f64; SKY_RADII] = core::array::from_fn(|i| 1.6 - 0.05 * i as f64);
    let values: Vec<String> = sky.iter().map(f64::to_string).collect();
    let sky_values = values.join(", ");
    let hazel = IrisTissue::new(&IrisPigment::HAZEL);
    let vector = |v: DVec3| format!("vec3f({:e}, {:e}, {:e})", v.x, v.y, v.z);
    let w = hazel.weights;
    let tissue = format!(
        "IrisTissue({}, {}, {}, {}, {}, {}, {}, mat3x3f({}, {}, {}))",
        vector(hazel.border),
        vector(hazel.border_melanin),
        vector(hazel.border_scattering),
        vector(hazel.border_fibrils),
        vector(hazel.stroma),
        vector(hazel.stroma_scattering),
        vector(hazel.stroma_fibrils),
        vector(w.x_axis),
        vector(w.y_axis),
        vector(w.z_axis),
    );
    let call = format!(
        "{IRIS} var sky = array<f32, {SKY_RADII}>({sky_values}); let at = iris_sky_knot(length(p), x[0]); \
         let d = vec3f(x[8], x[9], x[10]); let l = vec3f(x[16], x[17], x[18]); \
         let u = iris_surface(iris_map, iris_map_sampler, iris, p, iris_place(p, iris), d, x[14], IRIS_MARCH_FAST); \
         let c = iris_lamp(iris_map, iris_map_sampler, reflectance_map, light_table_sampler, iris, {tissue}, u, \
         iris_light(light_table, light_table_sampler, l, u.at, iris.root, iris.limbus), x[11], IRIS_MARCH_FAST); {RGB_OUT} \
         let f = iris_lamp(iris_map, iris_map_sampler, reflectance_map, light_table_sampler, iris, {tissue}, u, \
         iris_light(light_table, light_table_sampler, l, u.at, iris.root, iris.limbus), x[11], IRIS_MARCH_FULL); y[6] = f.x; y[7] = f.z; \
         let a = iris_ambient(reflectance_map, light_table_sampler, u, mix(sky[at.below], sky[at.below + 1], at.part)); y[3] = a.x; y[4] = a.z; \
         y[5] = textureSampleLevel(reflectance_map, reflectance_map_sampler, vec2f(0.5), 0.0).a;"
    );
    pass_unless_off(
        &Twin {
            name: "iris_lamp",
            library: &["iris_shade"],
            call: &call,
            draw: &|rng| {
                let mut x = draw_march(rng);
                x[11] = between(rng, -0.2, 0.2);
                x.truncate(16);
                x.extend(unit(rng));
                x
            },
            exact: &|x| {
                let p = v2(&x[6..]);
                let iris = iris_of(x);
                let surface = iris_shade::iris_surface(
                    &views,
                    &iris,
                    p,
                    &iris_relief::iris_place(p, &iris),
                    v3(&x[8..]),
                    x[14],
                    &iris_relief::IRIS_MARCH_FAST,
                );
                let arrives = iris_light(
                    &views.light,
                    v3(&x[16..]),
                    surface.at,
                    iris.root,
                    iris.limbus,
                );
                let [fast, full] = [iris_relief::IRIS_MARCH_FAST, iris_relief::IRIS_MARCH_FULL]
                    .map(|march| {
                        iris_shade::iris_lamp(
                            &views, &iris, &hazel, &surface, arrives, x[11], &march,
                        )
                    });
                let ambient = iris_shade::iris_ambient(
                    &views,
                    &surface,
                    iris_sky_knot(p.length(), x[0]).read(&sky),
                );
                [rgb(fast), vec![ambient.x, ambient.z, 1.0, full.x, full.z]].concat()
            },
            // A place is good to 6e-8 of 256 texels; a way 0.1 mm high within one makes 2e-6 mm of each
            // of two readings, the normal's step of 0.012 mm 3e-4 of a slope, light up to 2 twice that.
            absolute: 6e-4,
            relative: 0.0,
            // Where the ray grazes a ridge, and where the level jumps.
            steep_share: 0.01,
        },
        &maps,
        16,
        0.05,
    );
}

#[test]
fn what_shows_through_the_pupil() {
    let call = format!(
        "{IRIS} let c = x[14] * vec3f(0.012, 0.010, 0.006); {RGB_OUT} \
         y[3] = pupil_edge(p, x[15], iris_width(iris)); y[4] = angle_share(p.y); \
         y[5] = iris_path(x[14], -x[15], x[9]);"
    );
    pass_unless_off(
        &Twin {
            name: "pupil_edge",
            library: &["iris_shade"],
            call: &call,
            draw: &|rng| {
                let mut x = draw_iris(rng);
                (x[6], x[7]) = (between(rng, -0.2, 1.0), between(rng, -0.1, 1.2));
                x.extend((0..7).map(|_| between(rng, 0.0, 1.0)));
                x.push(10.0_f32.powf(between(rng, -3.0, 0.0)));
                x
            },
            exact: &|x| {
                let (place, iris) = (v2(&x[6..]), iris_of(x));
                let pupil = x[14] * DVec3::new(0.012, 0.010, 0.006);
                let edge = iris_shade::pupil_edge(place, x[15], iris.width());
                let path = iris_shade::iris_path(x[14], -x[15], x[9]);
                let angle = iris_shade::angle_share(place.y);
                [rgb(pupil), vec![edge, angle, path]].concat()
            },
            // WGSL allows a sine 2^-11, of 0.011, over the softest edge of 0.016 with slope 1.5.
            absolute: 6e-4,
            relative: 0.0,
            steep_share: 0.001,
        },
        &[],
        7,
        0.01,
    );
}
