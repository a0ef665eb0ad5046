//! The skin about the eye: its normal, colour, light and sheen.

use super::shading::{
    RGB_OUT, VIEWS, draw_studio, draw_views, pass_unless_off, rgb, studio_of, studio_text, v4,
};
use super::{between, v3};
use crate::gpu::Twin;
use ocularium::appearance::shading::skin_shade;
use rand_pcg::Pcg64;

/// 24 numbers of the studio, normal and view, tissue, two readings of the tile, and three more.
fn draw_skin(rng: &mut Pcg64) -> Vec<f32> {
    let mut x = draw_studio(rng);
    draw_views(rng, &mut x);
    // The weights of a vertex reach their ends and, interpolated, a little past them.
    x.extend((0..4).map(|_| between(rng, -0.1, 1.1)));
    x.extend((0..8).map(|_| between(rng, -0.5, 0.5)));
    x.extend([
        between(rng, 10.0, 15.0),
        between(rng, 10.5, 12.5),
        between(rng, 0.2, 0.8),
    ]);
    x
}

#[test]
fn skin() {
    const TISSUE: &str = "let t = vec4f(x[30], x[31], x[32], x[33]); let f = vec4f(x[34], x[35], x[36], x[37]); \
                          let g = vec4f(x[38], x[39], x[40], x[41]);";
    let studio = studio_text(0);
    let compare = |name,
                   call: &str,
                   exact: &dyn Fn(&[f64]) -> Vec<f64>,
                   [absolute, relative]: [f64; 2],
                   control: (usize, f64)| {
        pass_unless_off(
            &Twin {
                name,
                library: &["skin_shade"],
                call: &format!(
                    "let s = Studio({studio}); {VIEWS} {TISSUE} let c = {call}; {RGB_OUT}"
                ),
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
        let (n, v) = (v3(&x[24..]), v3(&x[27..]));
        rgb(skin_shade::skin_normal(
            n,
            v,
            v4(&x[30..]),
            x[44],
            v4(&x[34..]),
            v4(&x[38..]),
        ))
    };
    compare(
        "skin_normal",
        "skin_normal(n, v, t, x[44], f, g)",
        &normal,
        [2e-6, 0.0],
        (34, 1e-2),
    );
    // 12 mm carries 1e-6, over an edge of 1.55 mm.
    let albedo = |x: &[f64]| {
        let (fine, coarse) = (v4(&x[34..]), v4(&x[38..]));
        rgb(skin_shade::skin_albedo(
            v3(x),
            v3(&x[4..]),
            v4(&x[30..]),
            fine,
            coarse,
            x[42],
            x[43],
        ))
    };
    let call =
        "skin_albedo(vec3f(x[0], x[1], x[2]), vec3f(x[4], x[5], x[6]), t, f, g, x[42], x[43])";
    compare("skin_albedo", call, &albedo, [4e-6, 0.0], (42, 2e-2));
    let light = |x: &[f64]| {
        rgb(skin_shade::skin_light(
            &studio_of(x),
            v3(&x[24..]),
            v4(&x[30..]),
        ))
    };
    compare(
        "skin_light",
        "skin_light(s, n, t)",
        &light,
        [4e-6, 0.0],
        (31, 2e-2),
    );
    // What the studio's arc cosine is off by, through the film's reflectance.
    let specular = |x: &[f64]| {
        let (n, v) = (v3(&x[24..]), v3(&x[27..]));
        rgb(skin_shade::skin_specular(
            &studio_of(x),
            n,
            v,
            v4(&x[30..]),
            x[44],
        ))
    };
    compare(
        "skin_specular",
        "skin_specular(s, n, v, t, x[44])",
        &specular,
        [3e-3, 3e-4],
        (44, 2e-2),
    );
}
