//! The look-up of the lamps' light on the iris: against the same look-up in f64, and against the exact
//! solution that its table stands for.

use super::{between, v2};
use crate::gpu::{Gpu, Map, Twin};
use glam::{DVec2, DVec3};
use ocularium::appearance::light_table::{
    IrisLight, LAMPS, LightTable, LightTableSettings, SIDE, iris_light,
};

/// The key at an angle to the axis, the fill on the other side of it.
fn settings(angle_deg: f64) -> LightTableSettings {
    let lamp = |degrees: f64, turn: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(sin * turn.cos(), sin * turn.sin(), -cos)
    };
    LightTableSettings {
        surface: DVec2::new(7.8, 0.75),
        index: 1.336,
        iris_z: 3.6,
        root_mm: 6.05,
        limbus_mm: 5.85,
        lamps: [lamp(angle_deg, 0.6), lamp(0.7 * angle_deg, 3.4)],
    }
}

fn table(settings: LightTableSettings) -> Map {
    let texels = LightTable::new(settings).texels();
    Map {
        name: "light_table",
        levels: vec![((LAMPS * SIDE) as u32, SIDE as u32, texels)],
        wrap: false,
    }
}

const CALL: &str = "let r = iris_light(light_table, light_table_sampler, x[0], vec2f(x[1], x[2]), x[3], x[4]); \
    y[0] = r.x; y[1] = r.y; y[2] = r.z; y[3] = r.w;";

#[test]
fn iris_light_reads_as_in_f64() {
    for angle in [0.0, 45.0, 75.0] {
        let map = table(settings(angle));
        let view = map.view();
        let against = |root_factor: f64| {
            Twin {
                name: "iris_light",
                library: &["iris_light"],
                call: CALL,
                // Past the root and past the table too.
                draw: &|rng| {
                    let lamp = between(rng, 0.0, 2.0).floor().min(1.0);
                    let place = [between(rng, -7.0, 7.0), between(rng, -7.0, 7.0)];
                    let limbus = between(rng, 5.0, 6.5);
                    vec![lamp, place[0], place[1], limbus + 0.2, limbus]
                },
                exact: &|x| {
                    let root = root_factor * x[3];
                    iris_light(&view, x[0] as usize, v2(&x[1..]), root, x[4])
                        .to_array()
                        .to_vec()
                },
                // A place is good to 6e-8 of 96 texels; neighbours differ by less than 0.5 (and by less
                // than a millimetre of entry, over the limbus' edge of 0.8 mm).
                absolute: 1e-5,
                relative: 0.0,
                // At the corner of the clamp to the table.
                steep_share: 0.001,
            }
            .compare_with(std::slice::from_ref(&map))
        };
        against(1.0).unwrap_or_else(|why| panic!("{angle}°: {why}"));
        // A root a thousandth wider is a different place.
        assert!(against(1.001).is_err(), "{angle}°");
    }
}

/// Errors of direction and irradiance of the device's look-up against the exact light of `truth`.
#[derive(Debug)]
struct Off {
    rms: [f64; 2],
    most: [f64; 2],
}

fn off(table_of: LightTableSettings, truth: &LightTableSettings) -> Off {
    let mut data = Vec::new();
    for lamp in 0..LAMPS {
        for i in -30..=30 {
            for j in -30..=30 {
                let place = [i, j].map(|k: i8| f32::from(k) * (5.5 / 30.0));
                if place[0].hypot(place[1]) <= 5.5 {
                    let [root, limbus] = [truth.root_mm, truth.limbus_mm].map(|v| v as f32);
                    data.extend([lamp as f32, place[0], place[1], root, limbus]);
                }
            }
        }
    }
    let map = [table(table_of)];
    let got = Gpu::shared().evaluate_with(&["iris_light"], &map, CALL, &data, 5, 4);
    let mut off = Off {
        rms: [0.0; 2],
        most: [0.0; 2],
    };
    for (x, y) in data.chunks_exact(5).zip(got.chunks_exact(4)) {
        let [x, y] = [x, y].map(|v| v.iter().copied().map(f64::from).collect::<Vec<f64>>());
        let exact: IrisLight = truth.exact(x[0] as usize, v2(&x[1..]));
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
    let count = (data.len() / 5) as f64;
    off.rms = off.rms.map(|sum| (sum / count).sqrt());
    off
}

#[test]
fn iris_light_is_close_to_the_exact_light() {
    // Bilinear over cells of h = 0.27 mm errs by h²/8 of the second derivative and half floats by 2.4e-4
    // of a number near 1: together 1e-3 of an irradiance near 1, and less of a direction. At 60° the
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
        let truth = settings(angle);
        let found = off(truth, &truth);
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
            let found = off(wrong, &truth);
            assert!(
                !close(angle, &found),
                "{angle}°: {wrong:?} passes: {found:?}"
            );
        }
    }
}
