//! What an artist may change of an eye's picture, beside its f64 twins.

use super::shading::pass_unless_off;
use super::{between, unit, v3};
use crate::gpu::Twin;
use ocularium::appearance::light_table::caustic_change;
use ocularium::appearance::shading::{limbus, sclera_shade};

#[test]
fn an_artists_changes() {
    pass_unless_off(
        &Twin {
            name: "limbus_place",
            library: &["limbus"],
            call: "y[0] = limbus_place(x[0], x[1], x[2]); y[1] = limbus_shaped(x[0], x[1], x[2]);",
            draw: &|rng| {
                let limbus = between(rng, 5.0, 6.5);
                vec![
                    limbus + between(rng, -1.5, 1.0),
                    limbus,
                    between(rng, 0.1, 1.35),
                ]
            },
            exact: &|x| {
                let place = limbus::limbus_place(x[0], x[1], x[2]);
                vec![place, limbus::limbus_shaped(x[0], x[1], x[2])]
            },
            // Fourteen times 1.5 mm, and 6.5 mm, in f32.
            absolute: 3e-5,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        2,
        1e-3,
    );
    pass_unless_off(
        &Twin {
            name: "relief_place",
            library: &["sclera_shade"],
            call: "let q = relief_place(12.0 * vec3f(x[0], x[1], x[2]), x[3]); y[0] = q.x; y[1] = q.y; y[2] = q.z;",
            draw: &|rng| [&unit(rng)[..], &[between(rng, 0.25, 4.0)]].concat(),
            exact: &|x| {
                sclera_shade::relief_place(12.0 * v3(x), x[3])
                    .to_array()
                    .to_vec()
            },
            // WGSL allows an arc cosine near its ends some 1e-3 of an angle that is divided by a quarter.
            absolute: 0.05,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        3,
        0.3,
    );
    pass_unless_off(
        &Twin {
            name: "caustic_change",
            library: &["iris_light"],
            call: "y[0] = caustic_change(x[0], x[1], x[2]);",
            draw: &|rng| {
                vec![
                    between(rng, 0.0, 4.0),
                    between(rng, 0.0, 4.0),
                    between(rng, 0.25, 4.0),
                ]
            },
            exact: &|x| vec![caustic_change(x[0], x[1], x[2])],
            // A power of four and a quotient by a hundredth: 100 times a few roundings.
            absolute: 3e-3,
            relative: 0.0,
            steep_share: 0.0,
        },
        &[],
        2,
        1e-2,
    );
    // Nothing changed is nothing changed.
    for own in [0.0, 0.3, 1.0, 3.0] {
        let change = caustic_change(own, 1.0, 1.0);
        assert!((change - f64::from(own > 0.0)).abs() < 1e-12, "{own}");
    }
    assert_eq!(limbus::limbus_place(5.5, 5.85, limbus::LIMBUS_MM), 5.5);
    let look = ocularium::anatomy::Look::DEFAULT;
    assert_eq!(look.limbus_color_mm, limbus::LIMBUS_MM);
    assert_eq!(look.limbus_shading_mm, limbus::LIMBUS_MM);
}
