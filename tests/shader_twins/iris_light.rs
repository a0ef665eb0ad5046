//! The look-up of the lamps' light on the iris: against the same look-up in f64, and against the exact
//! solution that its table stands for.

use super::{between, v2};
use crate::gpu::{Gpu, Map, Twin};
use glam::{DVec2, DVec3};
use ocularium::appearance::light_table::{
    IrisLight, LightTableSettings, LightTableSize, iris_light,
};

fn settings() -> LightTableSettings {
    LightTableSettings {
        surface: DVec2::new(7.8, 0.75),
        index: 1.336,
        iris_z: 3.6,
        root_mm: 6.05,
        limbus_mm: 5.85,
    }
}

/// A lamp at an angle to the axis.
fn lamp(degrees: f64, turn: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin * turn.cos(), sin * turn.sin(), -cos)
}

fn table(settings: &LightTableSettings) -> Map {
    Map {
        name: "light_table",
        levels: vec![settings.table(LightTableSize::PICTURE)],
        wrap: false,
    }
}

const CALL: &str = "let r = iris_light(light_table, light_table_sampler, vec3f(x[0], x[1], x[2]), vec2f(x[3], x[4]), x[5], x[6]); \
    y[0] = r.x; y[1] = r.y; y[2] = r.z; y[3] = r.w;";

#[test]
fn iris_light_reads_as_in_f64() {
    let map = table(&settings());
    let view = map.view();
    let against = |root_factor: f64| {
        Twin {
            name: "iris_light",
            library: &["iris_light"],
            call: CALL,
            // Past the root and past the table too, and from behind the eye.
            draw: &|rng| {
                let light = lamp(
                    between(rng, 0.0, 95.0).into(),
                    between(rng, 0.0, 6.3).into(),
                );
                let place = [between(rng, -7.0, 7.0), between(rng, -7.0, 7.0)];
                let limbus = between(rng, 5.0, 6.5);
                let mut x = light.as_vec3().to_array().to_vec();
                x.extend([place[0], place[1], limbus + 0.2, limbus]);
                x
            },
            exact: &|x| {
                let light = DVec3::new(x[0], x[1], x[2]);
                iris_light(&view, light, v2(&x[3..]), root_factor * x[5], x[6])
                    .to_array()
                    .to_vec()
            },
            // A place is good to 6e-8 of 56 texels; neighbours differ by less than 0.5 (and by less
            // than a millimetre of entry, over the limbus' edge of 0.8 mm).
            absolute: 1e-5,
            relative: 0.0,
            // At the corner of the clamp to the table, and near the caustic of grazing light, where
            // neighbours differ by more.
            steep_share: 0.02,
        }
        .compare_with(std::slice::from_ref(&map))
    };
    against(1.0).unwrap_or_else(|why| panic!("{why}"));
    // A root a thousandth wider is a different place.
    assert!(against(1.001).is_err());
}

/// Errors of direction and irradiance of the device's look-up against the exact light of `truth`.
#[derive(Debug)]
struct Off {
    rms: [f64; 2],
    most: [f64; 2],
}

fn off(table_of: &LightTableSettings, truth: &LightTableSettings, angle: f64) -> Off {
    let mut data = Vec::new();
    for light in [lamp(angle, 0.6), lamp(0.7 * angle, 3.4)] {
        for i in -30..=30 {
            for j in -30..=30 {
                let place = [i, j].map(|k: i8| f32::from(k) * (5.5 / 30.0));
                if place[0].hypot(place[1]) <= 5.5 {
                    data.extend(light.as_vec3().to_array());
                    let [root, limbus] = [truth.root_mm, truth.limbus_mm].map(|v| v as f32);
                    data.extend([place[0], place[1], root, limbus]);
                }
            }
        }
    }
    let map = [table(table_of)];
    let got = Gpu::shared().evaluate_with(&["iris_light"], &map, CALL, &data, 7, 4);
    let mut off = Off {
        rms: [0.0; 2],
        most: [0.0; 2],
    };
    for (x, y) in data.chunks_exact(7).zip(got.chunks_exact(4)) {
        let [x, y] = [x, y].map(|v| v.iter().copied().map(f64::from).collect::<Vec<f64>>());
        let exact: IrisLight = truth.exact(DVec3::new(x[0], x[1], x[2]), v2(&x[3..]));
        let irradiance = exact.irradiance(truth.limbus_mm);
        // Where it is dark no direction is asked for.
        let direction = if irradiance > 0.0 {
            exact.towards.distance(v2(&y))
        } else {
            0.0
        };
        for (i, error) in [direction, (irradiance - y[3]).abs()]
            .into_iter()
            .enumerate()
        {
            off.rms[i] += error * error;
            off.most[i] = off.most[i].max(error);
        }
    }
    let count = (data.len() / 7) as f64;
    off.rms = off.rms.map(|sum| (sum / count).sqrt());
    off
}

#[test]
fn iris_light_is_close_to_the_exact_light() {
    // Bilinear over cells of h = 0.23 mm errs by h²/8 of the second derivative, linear over 0.065 of θ by
    // 0.065²/8 of another, and half floats by 2.4e-4 of a number near 1: together 1e-3 of an irradiance near 1, and less of a direction. At 60° the
    // caustic itself is 2 and steep on the far side, and the edge of what light can reach crosses cells,
    // where the look-up is off by a part of the jump. [direction, irradiance], rms and largest.
    let close = |angle: f64, off: &Off| {
        let (rms, most) = if angle < 50.0 {
            ([3e-4, 1e-3], [1e-3, 5e-3])
        } else {
            ([2e-3, 4e-3], [0.05, 0.06])
        };
        (0..2).all(|i| off.rms[i] < rms[i] && off.most[i] < most[i])
    };
    for angle in [0.0, 20.0, 40.0, 60.0] {
        let truth = settings();
        let found = off(&truth, &truth, angle);
        println!("{angle}°: {found:?}");
        assert!(close(angle, &found), "{angle}°: {found:?}");
        // A table for an iris an eighth of a millimetre deeper, and one for the cornea's index.
        for wrong in [
            LightTableSettings {
                iris_z: 3.725,
                ..truth
            },
            LightTableSettings {
                index: 1.376,
                ..truth
            },
        ] {
            let found = off(&wrong, &truth, angle);
            assert!(
                !close(angle, &found),
                "{angle}°: {wrong:?} passes: {found:?}"
            );
        }
    }
}
