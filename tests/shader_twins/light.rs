//! How much light, and what colour: Fresnel, defocus, microfacets, output.

use super::{between, pass, v3};
use crate::gpu::Twin;
use glam::DVec2;
use ocularium::optics::{defocus, fresnel, microfacet, output};

#[test]
fn fresnel() {
    pass(&Twin {
        name: "fresnel_dielectric",
        library: &["fresnel"],
        call: "y[0] = fresnel_dielectric(x[0], x[1], x[2]);",
        draw: &|rng| {
            vec![
                between(rng, 0.0, 1.0),
                between(rng, 1.0, 1.5),
                between(rng, 1.0, 1.5),
            ]
        },
        exact: &|x| vec![fresnel::fresnel_dielectric(x[0], x[1], x[2])],
        absolute: 1e-6,
        relative: 0.0,
        steep_share: 0.015,
    });
}

#[test]
fn defocus() {
    pass(&Twin {
        name: "defocus_blur_angle",
        library: &["defocus"],
        call: "y[0] = defocus_blur_angle(x[0], x[1], x[2], x[3]);",
        draw: &|rng| {
            vec![
                between(rng, 1e-3, 9e-3),
                between(rng, 0.0, 10.0),
                between(rng, 0.0, 10.0),
                between(rng, -20.0, 20.0),
            ]
        },
        exact: &|x| vec![defocus::defocus_blur_angle(x[0], x[1], x[2], x[3])],
        // Two roundings of 30 D through 9 mm.
        absolute: 4e-8,
        relative: 2e-7,
        steep_share: 0.0,
    });
}

#[test]
fn microfacet() {
    pass(&Twin {
        name: "ggx_ndf",
        library: &["microfacet"],
        call: "y[0] = ggx_ndf(x[0], x[1]);",
        draw: &|rng| vec![between(rng, -0.2, 1.0), between(rng, 0.02, 1.0)],
        exact: &|x| vec![microfacet::ggx_ndf(x[0], x[1])],
        absolute: 0.0,
        relative: 1e-6,
        steep_share: 0.001,
    });
    pass(&Twin {
        name: "ggx_visibility_smith",
        library: &["microfacet"],
        call: "y[0] = ggx_visibility_smith(x[0], x[1], x[2]);",
        draw: &|rng| {
            vec![
                between(rng, -0.1, 1.0),
                between(rng, -0.1, 1.0),
                between(rng, 0.02, 1.0),
            ]
        },
        exact: &|x| vec![microfacet::ggx_visibility_smith(x[0], x[1], x[2])],
        absolute: 0.0,
        relative: 1e-6,
        steep_share: 0.001,
    });
}

#[test]
fn output() {
    let call = |function: &str| format!("let c = {function}; y[0] = c.x; y[1] = c.y; y[2] = c.z;");
    pass(&Twin {
        name: "output_transform",
        library: &["output"],
        call: &call("output_transform(vec3f(x[0], x[1], x[2]), x[3])"),
        draw: &|rng| {
            let scale = 10.0_f32.powf(between(rng, -3.0, 3.0));
            let rgb: [f32; 3] = core::array::from_fn(|_| scale * between(rng, -0.1, 1.0));
            [&rgb[..], &[between(rng, 0.1, 4.0)]].concat()
        },
        exact: &|x| output::output_transform(v3(x), x[3]).to_array().to_vec(),
        absolute: 5e-7,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "dithered",
        library: &["output"],
        call: &call("dithered(vec3f(x[0], x[1], x[2]), vec2f(x[3], x[4]))"),
        draw: &|rng| {
            let mut x: Vec<f32> = (0..3).map(|_| between(rng, 0.0, 1.0)).collect();
            x.extend((0..2).map(|_| between(rng, 0.0, 512.0)));
            x
        },
        exact: &|x| {
            output::dithered(v3(x), DVec2::new(x[3], x[4]))
                .to_array()
                .to_vec()
        },
        // A sum of up to 40 carries 4e-6, times 53 of a code of up to 0.009.
        absolute: 4e-6,
        relative: 0.0,
        // Where the noise begins anew.
        steep_share: 0.002,
    });
    pass(&Twin {
        name: "linear_to_srgb",
        library: &["output"],
        call: &call("linear_to_srgb(vec3f(x[0], x[1], x[2]))"),
        draw: &|rng| (0..3).map(|_| between(rng, -0.1, 1.1)).collect(),
        exact: &|x| output::linear_to_srgb(v3(x)).to_array().to_vec(),
        // `pow` by exp2 and log2; an 8-bit step is 4e-3.
        absolute: 1e-6,
        relative: 0.0,
        steep_share: 0.0,
    });
}
