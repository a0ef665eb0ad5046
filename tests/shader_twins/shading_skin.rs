//! The skin about the eye: its normal, colour, light and sheen.

use super::shading::{RGB_OUT, VIEWS, draw_views, pass_unless_off, rgb, v4};
use super::{between, unit, v3};
use crate::gpu::Twin;
use glam::{DVec2, DVec3, Vec3Swizzles};
use ocularium::appearance::shading::skin_shade;
use rand_pcg::Pcg64;

/// Two colours, normal and view, tissue, two readings of the tile, roughness, a lamp's direction and radius,
/// and a third colour.
fn draw_skin(rng: &mut Pcg64) -> Vec<f32> {
    let mut x: Vec<f32> = (0..6).map(|_| between(rng, 0.0, 1.0)).collect();
    draw_views(rng, &mut x);
    // The weights of a vertex reach their ends and, interpolated, a little past them.
    x.extend((0..4).map(|_| between(rng, -0.1, 1.1)));
    x.extend((0..8).map(|_| between(rng, -0.5, 0.5)));
    x.push(between(rng, 0.2, 0.8));
    let v = DVec3::new(x[9].into(), x[10].into(), x[11].into());
    // The half vector of opposite directions is none.
    let mut l = unit(rng);
    while v.dot(DVec3::from_array(l.map(f64::from))) < -0.98 {
        l = unit(rng);
    }
    x.extend(l);
    x.push(between(rng, 0.0, 0.5));
    x.extend((0..3).map(|_| between(rng, 0.0, 1.0)));
    x
}

#[test]
fn skin() {
    const TISSUE: &str = "let t = vec4f(x[12], x[13], x[14], x[15]); let f = vec4f(x[16], x[17], x[18], x[19]); \
                          let g = vec4f(x[20], x[21], x[22], x[23]); let l = vec3f(x[25], x[26], x[27]); \
                          let q = vec3f(x[29], x[30], x[31]);";
    let compare = |name,
                   call: &str,
                   exact: &dyn Fn(&[f64]) -> Vec<f64>,
                   [absolute, relative]: [f64; 2],
                   control: (usize, f64)| {
        pass_unless_off(
            &Twin {
                name,
                library: &["skin_shade"],
                call: &format!("{VIEWS} {TISSUE} let c = {call}; {RGB_OUT}"),
                draw: &draw_skin,
                exact,
                absolute,
                relative,
                steep_share: 0.005,
            },
            &[],
            control.0,
            control.1,
        );
    };
    // A few roundings of a unit vector.
    let normal = |x: &[f64]| {
        let (fine, coarse) = (v4(&x[16..]), v4(&x[20..]));
        rgb(skin_shade::skin_normal(
            v3(&x[6..]),
            v3(&x[9..]),
            v4(&x[12..]),
            x[24],
            fine,
            coarse,
        ))
    };
    compare(
        "skin_normal",
        "skin_normal(n, v, t, x[24], f, g)",
        &normal,
        [2e-6, 0.0],
        (16, 1e-2),
    );
    let albedo = |x: &[f64]| {
        let (fine, coarse) = (v4(&x[16..]), v4(&x[20..]));
        let mottling = skin_shade::Mottling {
            blood: v3(&x[29..]),
            melanin: v3(&x[3..]).zxy(),
            lid: v3(x).yzx(),
        };
        rgb(skin_shade::skin_albedo(
            v3(x),
            mottling,
            v3(&x[3..]),
            v4(&x[12..]),
            fine,
            coarse,
        ))
    };
    compare(
        "skin_albedo",
        "skin_albedo(m, Mottling(q, k.zxy, m.yzx), k, t, f, g)",
        &albedo,
        [4e-6, 4e-6],
        (12, 2e-2),
    );
    let margin = |x: &[f64]| {
        let (along, footprint) = (60.0 * (x[24] - 0.5), 1.2 * x[28] * x[28] + 0.002);
        let albedo = skin_shade::margin_albedo(v3(x), v3(&x[3..]), x[12], along, footprint);
        rgb(albedo * skin_shade::margin_wet(x[13]))
    };
    // The soft edge of a gland's opening, over a place of 15 mm.
    compare(
        "margin_albedo",
        "margin_albedo(m, k, x[12], 60.0 * (x[24] - 0.5), 1.2 * x[28] * x[28] + 0.002) * margin_wet(x[13])",
        &margin,
        [2e-5, 0.0],
        (12, 2e-2),
    );
    let wrinkled = |x: &[f64]| {
        let q = DVec2::new(40.0 * (x[0] - 0.4), 30.0 * (x[1] - 0.7));
        rgb(skin_shade::skin_tilted(
            v3(&x[6..]),
            skin_shade::skin_wrinkles(q, 0.1 * x[2]),
        ))
    };
    // WGSL allows an arc tangent 4096 ulp, 1e-3 of a groove, whose slope's is 1.7 of it each 0.13 of that way.
    compare(
        "skin_wrinkles",
        "skin_tilted(n, skin_wrinkles(vec2f(40.0 * (x[0] - 0.4), 30.0 * (x[1] - 0.7)), 0.1 * x[2]))",
        &wrinkled,
        [5e-4, 0.0],
        (2, 1e-1),
    );
    let light = |x: &[f64]| {
        let tissue = v4(&x[12..]);
        rgb(skin_shade::skin_lamp(v3(&x[6..]), tissue, v3(&x[25..]))
            + skin_shade::skin_openness(tissue))
    };
    compare(
        "skin_lamp",
        "skin_lamp(n, t, l) + skin_openness(t)",
        &light,
        [4e-6, 0.0],
        (13, 2e-2),
    );
    // The half vector carries 1e-7, and a lobe with alpha 0.02 turns that into 1e-4 of itself.
    let sheen = |x: &[f64]| {
        let one = skin_shade::skin_lamp_sheen(
            v3(&x[6..]),
            v3(&x[9..]),
            v4(&x[12..]),
            x[24],
            v3(&x[25..]),
            x[28],
        );
        rgb(DVec3::splat(one))
    };
    compare(
        "skin_lamp_sheen",
        "vec3f(skin_lamp_sheen(n, v, t, x[24], l, x[28]))",
        &sheen,
        [1e-4, 3e-4],
        (24, 2e-2),
    );
    // A few roundings of numbers up to 1.
    let specular = |x: &[f64]| {
        rgb(skin_shade::skin_specular(
            v3(x),
            v3(&x[3..]),
            v3(&x[29..]),
            v3(&x[6..]),
            v3(&x[9..]),
            v4(&x[12..]),
        ))
    };
    compare(
        "skin_specular",
        "skin_specular(m, k, q, n, v, t)",
        &specular,
        [2e-6, 1e-5],
        (12, 2e-2),
    );
    // Along its normal, where rounding makes cosines of more than one.
    let along = |x: &[f64]| {
        let n = v3(&x[6..]);
        rgb(skin_shade::skin_specular(
            v3(x),
            v3(&x[3..]),
            v3(&x[29..]),
            n,
            n,
            v4(&x[12..]),
        ))
    };
    compare(
        "skin_specular",
        "skin_specular(m, k, q, n, n, t)",
        &along,
        [2e-6, 1e-5],
        (12, 2e-2),
    );
}
