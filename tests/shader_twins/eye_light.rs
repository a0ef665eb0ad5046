//! What the eye does to light: glare, the tear film's colours, astigmatic blur.

use super::{between, pass};
use crate::gpu::Twin;
use ocularium::optics::defocus::PowerVector;
use ocularium::optics::{defocus, glare, tear_film};
use rand_pcg::Pcg64;

#[test]
fn glare() {
    pass(&Twin {
        name: "glare_spread",
        library: &["glare"],
        call: "y[0] = glare_spread(x[0], x[1], x[2]);",
        draw: &|rng| {
            // From a tenth of a second of arc to behind the head.
            let theta = core::f32::consts::PI * 10.0_f32.powf(between(rng, -6.8, 0.0));
            vec![theta, between(rng, 0.0, 120.0), between(rng, 0.0, 1.2)]
        },
        exact: &|x| vec![glare::glare_spread(x[0], x[1], x[2])],
        // A dozen roundings; the core falls with the cube of an angle of two more.
        absolute: 0.0,
        relative: 1e-6,
        steep_share: 0.001,
    });
}

#[test]
fn tear_film() {
    pass(&Twin {
        name: "tear_film_rgb",
        library: &["tear_film"],
        call: "let c = tear_film_rgb(x[0], x[1], x[2], x[3]); y[0] = c.x; y[1] = c.y; y[2] = c.z;",
        draw: &|rng| {
            vec![
                between(rng, 0.0, 1.0),
                between(rng, 1.4, 1.6),
                between(rng, 1.3, 1.4),
                between(rng, 0.0, 300.0),
            ]
        },
        exact: &|x| {
            tear_film::tear_film_rgb(x[0], x[1], x[2], x[3])
                .to_array()
                .to_vec()
        },
        // As for the film at one wavelength, with weights that sum to 1.6 in size.
        absolute: 2e-6,
        relative: 0.0,
        steep_share: 0.001,
    });
}

/// Pupil, vergences and a refraction up to ±20 D with 6 D of cylinder.
fn draw_astigmatic(rng: &mut Pcg64) -> Vec<f32> {
    vec![
        between(rng, 1e-3, 9e-3),
        between(rng, 0.0, 10.0),
        between(rng, 0.0, 10.0),
        between(rng, -20.0, 20.0),
        between(rng, -3.0, 3.0),
        between(rng, -3.0, 3.0),
    ]
}

fn refraction(x: &[f64]) -> PowerVector {
    PowerVector {
        m_d: x[3],
        j0_d: x[4],
        j45_d: x[5],
    }
}

#[test]
fn astigmatic_blur() {
    pass(&Twin {
        name: "defocus_blur_ellipse",
        library: &["defocus"],
        call: "let e = defocus_blur_ellipse(x[0], x[1], x[2], vec3f(x[3], x[4], x[5])); \
               y[0] = e.x; y[1] = e.y;",
        draw: &draw_astigmatic,
        exact: &|x| {
            let e = defocus::defocus_blur_ellipse(x[0], x[1], x[2], refraction(x));
            vec![e.major_rad, e.minor_rad]
        },
        // A few roundings of 30 D through 9 mm.
        absolute: 8e-8,
        relative: 3e-7,
        steep_share: 0.001,
    });
    pass(&Twin {
        name: "defocus_blur_ellipse",
        library: &["defocus"],
        // A direction has no sense: twice the angle is compared, as a point of the unit circle.
        call: "let e = defocus_blur_ellipse(x[0], x[1], x[2], vec3f(x[3], x[4], x[5])); \
               y[0] = cos(2.0 * e.z); y[1] = sin(2.0 * e.z);",
        draw: &draw_astigmatic,
        exact: &|x| {
            let e = defocus::defocus_blur_ellipse(x[0], x[1], x[2], refraction(x));
            let (sin, cos) = (2.0 * e.orientation_rad).sin_cos();
            vec![cos, sin]
        },
        // WGSL allows sin and cos 2^-11 and atan2 4096 roundings; a tenth of a degree is 3.5e-3 here.
        absolute: 2e-3,
        relative: 0.0,
        steep_share: 0.002,
    });
    pass(&Twin {
        name: "defocus_blur_covariance",
        library: &["defocus"],
        call: "let c = defocus_blur_covariance(x[0], x[1], x[2], vec3f(x[3], x[4], x[5])); \
               y[0] = 1e4 * c.x; y[1] = 1e4 * c.y; y[2] = 1e4 * c.z;",
        draw: &draw_astigmatic,
        exact: &|x| {
            let c = defocus::defocus_blur_covariance(x[0], x[1], x[2], refraction(x));
            (1e4 * c).to_array().to_vec()
        },
        // (9 mm · 33 D/4)² is 0.0055 rad², 55 in these units, its factors each a few roundings off.
        absolute: 3e-5,
        relative: 5e-7,
        steep_share: 0.001,
    });
}
