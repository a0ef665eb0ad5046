//! What the eye does to light: the tear film's colours, astigmatic blur.

use super::{between, pass};
use crate::gpu::Twin;
use ocularium::optics::{defocus, tear_film};

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

#[test]
fn astigmatic_blur() {
    pass(&Twin {
        name: "astigmatic_blur",
        library: &["defocus"],
        call: "let b = astigmatic_blur(x[0], x[1], x[2]); y[0] = 100.0 * b.x; y[1] = b.y;",
        draw: &|rng| {
            vec![
                between(rng, 1e-3, 9e-3),
                between(rng, -20.0, 20.0),
                between(rng, 0.0, 5.0),
            ]
        },
        exact: &|x| {
            let [diameter_rad, elongation] = defocus::astigmatic_blur(x[0], x[1], x[2]);
            vec![100.0 * diameter_rad, elongation]
        },
        // A few roundings of 19 hundredths of a radian, and of 1.
        absolute: 4e-6,
        relative: 4e-7,
        steep_share: 0.0,
    });
}
