//! How the view is seen: retina, corners, the sharpness field's keys and voxels, the gather's
//! kernel, the lids.

use super::{between, pass, unit};
use crate::gpu::Twin;
use glam::DVec2;
use ocularium::percept::{fast, gather, gather_ellipse, sharpness_field as field, veil};
use rand::RngExt;
use rand_pcg::Pcg64;

/// A whole number below `count`, which f32 holds exactly up to 2^24.
fn whole(rng: &mut Pcg64, count: u32) -> f32 {
    rng.random_range(0..count) as f32
}

fn d3(x: &[f64]) -> [f64; 3] {
    [x[0], x[1], x[2]]
}

fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// Two directions of a view: within 60° of straight ahead.
fn two_directions(rng: &mut Pcg64) -> Vec<f32> {
    let mut near_ahead = || loop {
        let v = unit(rng);
        if v[2] < -0.5 {
            return v;
        }
    };
    [near_ahead(), near_ahead()].concat()
}

#[test]
fn retinal_blur() {
    pass(&Twin {
        name: "neural_blur",
        library: &["retinal_blur"],
        call: "y[0] = neural_blur(x[0], x[1], x[2]);",
        draw: &|rng| {
            vec![
                between(rng, 0.0, 1.5),
                between(rng, 1e-4, 1e-3),
                between(rng, 0.02, 0.1),
            ]
        },
        exact: &|x| vec![gather::neural_blur(x[0], x[1], x[2])],
        absolute: 0.0,
        // A quotient (2.5 roundings by the WGSL rules), a sum and a product.
        relative: 5e-7,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "combined_blur",
        library: &["retinal_blur"],
        call: "y[0] = combined_blur(x[0], x[1]);",
        draw: &|rng| {
            (0..2)
                .map(|_| 10.0_f32.powf(between(rng, -6.0, 0.5)))
                .collect()
        },
        exact: &|x| vec![gather::combined_blur(x[0], x[1])],
        absolute: 0.0,
        relative: 3e-7,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "view_ray",
        library: &["retinal_blur"],
        call: "let r = view_ray(vec2f(x[0], x[1]), vec2f(x[2], x[3]), vec2f(x[4], x[5])); \
               y[0] = r.x; y[1] = r.y; y[2] = r.z;",
        draw: &|rng| {
            let size = [16.0 + whole(rng, 4000), 16.0 + whole(rng, 4000)];
            let place = size.map(|side| between(rng, 0.0, side));
            let tan_half = [between(rng, 0.05, 2.0), between(rng, 0.05, 2.0)];
            [place, size, tan_half].concat()
        },
        exact: &|x| gather::view_ray([x[0], x[1]], [x[2], x[3]], [x[4], x[5]]).to_vec(),
        absolute: 6e-7,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "angle_between",
        library: &["retinal_blur"],
        call: "y[0] = angle_between(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]));",
        draw: &two_directions,
        exact: &|x| vec![gather::angle_between(d3(x), d3(&x[3..]))],
        // WGSL lets asin be off by 4,096 roundings, here up to 8e-4 rad of two asin; software comes to
        // half of that at 80°. That is 3 arcmin where the retina resolves no less than 30.
        absolute: 8e-4,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "perimetric_angles",
        library: &["retinal_blur"],
        call: "let a = perimetric_angles(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5])); \
               y[0] = a.x; y[1] = a.y;",
        draw: &two_directions,
        exact: &|x| gather::perimetric_angles(d3(x), d3(&x[3..])).to_vec(),
        // The same angle; near 120° apart the component across is small against its roundings.
        absolute: 8e-4,
        relative: 0.0,
        steep_share: 0.005,
    });
}

#[test]
fn angles_of_neighbouring_pixels_keep_their_digits() {
    // Directions a thousandth of a radian apart, as far as f32 tells them apart.
    pass(&Twin {
        name: "angle_between, small",
        library: &["retinal_blur"],
        call: "y[0] = angle_between(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]));",
        draw: &|rng| {
            let (a, off) = (unit(rng), unit(rng));
            let along = dot(&a, &off);
            let b: [f32; 3] = core::array::from_fn(|i| a[i] + 1e-3 * (off[i] - along * a[i]));
            [a, b].concat()
        },
        exact: &|x| vec![gather::angle_between(d3(x), d3(&x[3..]))],
        // A difference of neighbours is exact; acos of the dot product would be off by a tenth.
        absolute: 0.0,
        relative: 1e-6,
        steep_share: 0.0,
    });
}

/// Strength of the middle of a 7 × 7 image whose ring and centre are given, by the detector.
fn strength(x: &[f64]) -> f64 {
    let mut image = [0_u8; 49];
    image[24] = x[16] as u8;
    for (value, (dx, dy)) in x.iter().zip(fast::RING) {
        image[((3 + dy) * 7 + 3 + dx) as usize] = *value as u8;
    }
    let corners = fast::detect(&image, 7, 7, 0, false).expect("49 bytes");
    // At a threshold of 0 every strength above 0 is a corner, and its score is one less.
    corners
        .first()
        .map_or(0.0, |corner| f64::from(corner.score) + 1.0)
}

#[test]
fn fast_strength() {
    pass(&Twin {
        name: "fast_strength_of",
        library: &["fast_strength"],
        call: "var d: array<i32, 16>; \
               for (var k = 0u; k < 16u; k++) { d[k] = i32(x[k]) - i32(x[16]); } \
               y[0] = f32(fast_strength_of(d));",
        draw: &|rng| {
            // An arc of 6 to 12 pixels to one side, the rest anywhere: many are corners.
            let (centre, start) = (rng.random_range(0..=255_i32), rng.random_range(0..16_usize));
            let (arc, side) = (
                rng.random_range(6..=12_usize),
                rng.random_range(0..2_i32) * 2 - 1,
            );
            let mut ring = [0.0_f32; 17];
            for k in 0..16 {
                let on_arc = k < arc;
                let step = if on_arc {
                    side * rng.random_range(1..120)
                } else {
                    rng.random_range(-120..120)
                };
                ring[(start + k) % 16] = (centre + step).clamp(0, 255) as f32;
            }
            ring[16] = centre as f32;
            ring.to_vec()
        },
        exact: &|x| vec![strength(x)],
        // Whole numbers.
        absolute: 0.0,
        relative: 0.0,
        steep_share: 0.0,
    });
}

/// Parts of a key, which f32 holds exactly: its epoch, its value and the elongation's code.
fn parts(key: u32) -> Vec<f64> {
    [key >> 28, (key >> 7) & 0x1F_FFFF, key & 0x7F]
        .map(f64::from)
        .to_vec()
}

const PARTS: &str =
    "y[0] = f32(key >> 28u); y[1] = f32((key >> 7u) & 0x1FFFFFu); y[2] = f32(key & 0x7Fu);";
const KEY: &str = "u32(x[0]) << 28u | u32(x[1]) << 7u | u32(x[2])";

/// A key of its parts.
fn key_of(x: &[f64]) -> u32 {
    (x[0] as u32) << 28 | (x[1] as u32) << 7 | x[2] as u32
}

/// A stored key (its parts), the starvation now and the epoch now: mostly of this epoch.
fn stored(rng: &mut Pcg64) -> [f32; 5] {
    let epoch = rng.random_range(0..16_u32);
    let starved = rng.random_range(0..field::STARVE_STEPS_MAX);
    let top = if rng.random_bool(0.8) {
        15 - epoch
    } else {
        rng.random_range(0..16)
    };
    let blur = rng.random_range(0..=field::LN_STEPS_MAX + 20_000);
    let value = (field::STARVE_STEPS_MAX - starved + blur).min(0x1F_FFFF);
    let code = rng.random_range(0..128_u32);
    [top, value, code, starved, epoch].map(|part| part as f32)
}

#[test]
fn sharpness_key() {
    let encode =
        format!("let key = sharpness_key_encode(x[0], x[1], u32(x[2]), u32(x[3])); {PARTS}");
    pass(&Twin {
        name: "sharpness_key_encode",
        library: &["sharpness_key"],
        call: &encode,
        draw: &|rng| {
            let coc = 10.0_f32.powf(between(rng, -7.0, 1.5));
            vec![
                coc,
                between(rng, -1.0, 1.0),
                whole(rng, field::STARVE_STEPS_MAX + 1),
                whole(rng, 16),
            ]
        },
        exact: &|x| {
            parts(field::sharpness_key_encode(
                x[0],
                x[1],
                x[2] as u32,
                x[3] as u8,
            ))
        },
        // A logarithm or an arcsine in f32 may fall on the other side of a step's edge; the next one is
        // wrong.
        absolute: 1.0,
        relative: 0.0,
        steep_share: 0.0,
    });
    let decode = format!("y[0] = sharpness_key_decode({KEY}, u32(x[3]), u32(x[4]), x[5]);");
    pass(&Twin {
        name: "sharpness_key_decode",
        library: &["sharpness_key"],
        call: &decode,
        draw: &|rng| [&stored(rng)[..], &[between(rng, 1e-3, 10.0)]].concat(),
        exact: &|x| {
            vec![field::sharpness_key_decode(
                key_of(x),
                x[3] as u32,
                x[4] as u8,
                x[5],
            )]
        },
        // exp of 14 in f32: the argument's rounding, 1e-6, and the function's own. A step is 2.4e-4.
        absolute: 1e-9,
        relative: 5e-6,
        steep_share: 0.0,
    });
    let elongation = format!("y[0] = sharpness_key_elongation({KEY}, u32(x[4]));");
    pass(&Twin {
        name: "sharpness_key_elongation",
        library: &["sharpness_key"],
        call: &elongation,
        draw: &|rng| stored(rng).to_vec(),
        exact: &|x| vec![field::sharpness_key_elongation(key_of(x), x[4] as u8)],
        // WGSL allows a sine 2^-11; a step of the code is 0.025 at a disc.
        absolute: 5e-4,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "elongation_encode",
        library: &["sharpness_key"],
        call: "y[0] = f32(elongation_encode(x[0]));",
        draw: &|rng| vec![between(rng, -1.1, 1.1)],
        exact: &|x| vec![f64::from(field::elongation_encode(x[0]))],
        // An arcsine may fall on the other side of a step's edge.
        absolute: 1.0,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "elongation_decode",
        library: &["sharpness_key"],
        call: "y[0] = elongation_decode(u32(x[0]));",
        draw: &|rng| vec![whole(rng, 128)],
        exact: &|x| vec![field::elongation_decode(x[0] as u32)],
        // WGSL allows a sine 2^-11; a step of the code is 0.025 at a disc.
        absolute: 5e-4,
        relative: 0.0,
        steep_share: 0.0,
    });
    let rebase = format!(
        "let key = sharpness_key_rebase({KEY}, \
         select(u32(x[3]), 0xFFFFFFFFu, x[3] < 0.0), u32(x[4])); {PARTS}"
    );
    pass(&Twin {
        name: "sharpness_key_rebase",
        library: &["sharpness_key"],
        call: &rebase,
        draw: &|rng| {
            let mut x = stored(rng);
            // A negative number stands for forgetting everything.
            if rng.random_bool(0.05) {
                x[3] = -1.0;
            }
            x.to_vec()
        },
        exact: &|x| {
            let steps = if x[3] < 0.0 { u32::MAX } else { x[3] as u32 };
            parts(field::sharpness_key_rebase(key_of(x), steps, x[4] as u8))
        },
        // Whole numbers.
        absolute: 0.0,
        relative: 0.0,
        steep_share: 0.0,
    });
}

/// Points seen from near the field's origin, with a voxel side (0: by distance) and a voxel angle.
fn seen_point(rng: &mut Pcg64, vergence: [f32; 2], side_m: f32) -> Vec<f32> {
    let eye: [f32; 3] = core::array::from_fn(|_| between(rng, -0.1, 0.1));
    let vergence = between(rng, vergence[0], vergence[1]);
    let angle = between(rng, 1e-3, 2e-2);
    [&eye[..], &unit(rng), &[vergence, side_m, angle]].concat()
}

#[test]
fn sharpness_voxel() {
    // Whether a point lies on this or that side of a cell's wall is decided by roundings when it
    // lies within one: a thousand cells from the origin that is one point in some thousand.
    type Draw = fn(&mut Pcg64) -> Vec<f32>;
    let draws: [(&str, Draw, f64); 3] = [
        (
            "sharpness_voxel, by distance",
            |rng| seen_point(rng, [0.05, 20.0], 0.0),
            0.005,
        ),
        (
            "sharpness_voxel, uniform",
            |rng| seen_point(rng, [0.1, 20.0], 0.01),
            0.005,
        ),
        (
            "sharpness_voxel, sky",
            |rng| seen_point(rng, [0.0, 9.9e-4], 0.01),
            0.005,
        ),
    ];
    for (name, draw, steep_share) in draws {
        pass(&Twin {
            name,
            library: &["sharpness_voxel"],
            call: "let v = sharpness_voxel(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), x[6], x[7], x[8]); \
                   y[0] = f32(v.x); y[1] = f32(v.y); y[2] = f32(v.z); y[3] = f32(v.w);",
            draw: &draw,
            exact: &|x| {
                field::sharpness_voxel(d3(x), d3(&x[3..]), x[6], x[7], x[8])
                    .map(f64::from)
                    .to_vec()
            },
            absolute: 0.0,
            relative: 0.0,
            steep_share,
        });
    }
}

#[test]
fn sharpness_voxel_at() {
    for side_m in [0.0, 0.01] {
        pass(&Twin {
            name: "sharpness_voxel_at",
            library: &["sharpness_voxel"],
            call: "let v = sharpness_voxel_at(vec3f(x[0], x[1], x[2]), x[3], x[4]); \
                   y[0] = f32(v.x); y[1] = f32(v.y); y[2] = f32(v.z); y[3] = f32(v.w);",
            draw: &|rng| {
                let point: [f32; 3] = core::array::from_fn(|_| between(rng, -8.0, 8.0));
                [&point[..], &[side_m, between(rng, 1e-3, 2e-2)]].concat()
            },
            exact: &|x| {
                field::sharpness_voxel_at(d3(x), x[3], x[4])
                    .map(f64::from)
                    .to_vec()
            },
            absolute: 0.0,
            relative: 0.0,
            // As for the points of a view.
            steep_share: 0.005,
        });
    }
}

#[test]
fn sharpness_voxel_names() {
    // Words as two halves of 16 bits each, which f32 holds exactly.
    let split = |words: &[u32]| -> Vec<f64> {
        words
            .iter()
            .flat_map(|w| [f64::from(w >> 16), f64::from(w & 0xFFFF)])
            .collect()
    };
    pass(&Twin {
        name: "sharpness_mix",
        library: &["sharpness_voxel"],
        call: "let h = sharpness_mix(u32(x[0]) << 16u | u32(x[1])); \
               y[0] = f32(h >> 16u); y[1] = f32(h & 0xFFFFu);",
        draw: &|rng| vec![whole(rng, 1 << 16), whole(rng, 1 << 16)],
        exact: &|x| split(&[field::sharpness_mix((x[0] as u32) << 16 | x[1] as u32)]),
        absolute: 0.0,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "sharpness_voxel_hash",
        library: &["sharpness_voxel"],
        call: "let h = sharpness_voxel_hash(vec4<i32>(i32(x[0]), i32(x[1]), i32(x[2]), i32(x[3]))); \
               y[0] = f32(h.x >> 16u); y[1] = f32(h.x & 0xFFFFu); \
               y[2] = f32(h.y >> 16u); y[3] = f32(h.y & 0xFFFFu);",
        draw: &|rng| (0..4).map(|_| whole(rng, 200_001) - 100_000.0).collect(),
        exact: &|x| {
            let voxel = core::array::from_fn(|i| x[i] as i32);
            split(&field::sharpness_voxel_hash(voxel))
        },
        absolute: 0.0,
        relative: 0.0,
        steep_share: 0.0,
    });
}

#[test]
fn gaussian_disc() {
    let sigma = |rng: &mut Pcg64| 10.0_f32.powf(between(rng, -2.0, 2.5));
    pass(&Twin {
        name: "gaussian_window",
        library: &["gaussian_disc"],
        call: "y[0] = gaussian_window(x[0]);",
        draw: &|rng| vec![10.0_f32.powf(between(rng, -4.0, 0.0))],
        exact: &|x| vec![gather::gaussian_window(x[0])],
        // One subtraction of f32.
        absolute: 6e-8,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "gaussian_steps",
        library: &["gaussian_disc"],
        call: "let s = gaussian_steps(x[0], x[1]); y[0] = s.x; y[1] = s.y; y[2] = s.z;",
        // As far before the place as the pairs begin.
        draw: &|rng| {
            let deviation = between(rng, 0.7, 1.8);
            let pairs = gather::gaussian_disc_pairs(f64::from(deviation)) as f32;
            vec![between(rng, 0.0, 1.0) - pairs, deviation]
        },
        exact: &|x| gather::gaussian_steps(x[0], x[1]).to_vec(),
        absolute: 0.0,
        // Exponents of up to 12 carry four roundings into the exponential.
        relative: 4e-6,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "gaussian_disc_deviation",
        library: &["gaussian_disc"],
        call: "y[0] = gaussian_disc_deviation(x[0], x[1]);",
        draw: &|rng| vec![sigma(rng), whole(rng, 9)],
        exact: &|x| vec![gather::gaussian_disc_deviation(x[0], x[1])],
        absolute: 0.0,
        // σ² less the level's keeps at least 0.15 of σ²: seven roundings become some forty in the
        // worst case.
        relative: 2e-6,
        steep_share: 0.0,
    });
    // Whole numbers: wrong only where one ends and the next begins.
    for (name, call, exact) in [
        (
            "gaussian_disc_pairs",
            "y[0] = f32(gaussian_disc_pairs(x[0]));",
            (|x| f64::from(gather::gaussian_disc_pairs(x[0]))) as fn(&[f64]) -> f64,
        ),
        (
            "gaussian_disc_level",
            "y[0] = gaussian_disc_level(x[0], 4u + u32(x[1]) % 3u);",
            |x| gather::gaussian_disc_level(x[0], 4 + x[1] as u32 % 3),
        ),
        (
            "gaussian_disc_budget",
            "y[0] = f32(gaussian_disc_budget(u32(x[1])));",
            |x| f64::from(gather::gaussian_disc_budget(x[1] as u32)),
        ),
        (
            "gaussian_disc_taps",
            "y[0] = f32(gaussian_disc_taps(x[0], u32(x[1])));",
            |x| f64::from(gather::gaussian_disc_taps(x[0], x[1] as u32)),
        ),
        (
            "spread_taps",
            "y[0] = f32(spread_taps(x[0], u32(x[1])));",
            |x| f64::from(gather::spread_taps(x[0], x[1] as u32)),
        ),
        (
            "spread_level",
            "y[0] = spread_level(x[0], 20u + u32(x[1]));",
            |x| gather::spread_level(x[0], 20 + x[1] as u32),
        ),
    ] {
        pass(&Twin {
            name,
            library: &["gaussian_disc"],
            call,
            draw: &|rng| vec![sigma(rng), whole(rng, 128)],
            exact: &|x| vec![exact(x)],
            absolute: 0.0,
            relative: 0.0,
            steep_share: 0.001,
        });
    }
}

#[test]
fn eyelid_view() {
    pass(&Twin {
        name: "eyelid_transmission",
        library: &["eyelid_view"],
        call: "y[0] = eyelid_transmission(x[0], vec2f(x[1], x[2]), vec2f(x[3], x[4]), x[5]); y[1] = disc_below(x[1]);",
        draw: &|rng| {
            vec![
                between(rng, -1.0, 1.0),
                between(rng, -4.0, 5.0),
                between(rng, 1.0, 4.0),
                between(rng, -6.0, -3.0),
                between(rng, 1.0, 4.0),
                between(rng, 0.5, 4.5),
            ]
        },
        exact: &|x| {
            vec![
                gather::eyelid_transmission(x[0], [x[1], x[2]], [x[3], x[4]], x[5]),
                gather::disc_below(x[1]),
            ]
        },
        // WGSL allows an arc sine 2^-11 and more; twice one over π.
        absolute: 5e-4,
        relative: 0.0,
        steep_share: 0.0,
    });
}

#[test]
fn veils() {
    pass(&Twin {
        name: "wide_spline_pair",
        library: &["veil"],
        call: "let t = wide_spline_pair(x[0], vec2f(abs(x[1]), abs(x[2]))); y[0] = t.x; y[1] = t.y; y[2] = wide_spline(x[0]); \
               let p = stereographic(vec2f(x[1], x[2])); y[3] = p.x; y[4] = p.y; y[5] = stereographic_scale(p); \
               let b = tangents_of(p); y[6] = b.x; y[7] = b.y;",
        draw: &|rng| {
            vec![
                // Where both have no weight there is no place between them.
                between(rng, -3.9, 2.9),
                between(rng, -2.0, 2.0),
                between(rng, -2.0, 2.0),
            ]
        },
        exact: &|x| {
            let taps = veil::wide_spline_pair(x[0], DVec2::new(x[1], x[2]).abs());
            let place = veil::stereographic(DVec2::new(x[1], x[2]));
            let back = veil::tangents_of(place);
            vec![
                taps.x,
                taps.y,
                veil::wide_spline(x[0]),
                place.x,
                place.y,
                veil::stereographic_scale(place),
                back.x,
                back.y,
            ]
        },
        // A few roundings of numbers up to 1; a place is their quotient, of 1e-4 and more.
        absolute: 5e-5,
        relative: 0.0,
        steep_share: 0.0,
    });
}

#[test]
fn gaussian_ellipse() {
    let library: &[&str] = &["gaussian_disc", "gaussian_ellipse"];
    let blur = |rng: &mut Pcg64| {
        vec![
            10.0_f32.powf(between(rng, -2.0, 3.0)),
            between(rng, -1.0, 1.0),
        ]
    };
    pass(&Twin {
        name: "ellipse_variances",
        library,
        call: "let v = ellipse_variances(x[0], x[1]); y[0] = v.x / (x[0] * x[0]); y[1] = v.y / (x[0] * x[0]);",
        draw: &blur,
        exact: &|x| {
            let [along, across] = gather_ellipse::ellipse_variances(x[0], x[1]);
            vec![along / (x[0] * x[0]), across / (x[0] * x[0])]
        },
        // A handful of roundings of an eighth.
        absolute: 5e-8,
        relative: 0.0,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "ellipse_on_level",
        library,
        call: "let v = ellipse_on_level(vec2<f32>(x[0], x[1]), x[2]); y[0] = v.x; y[1] = v.y;",
        draw: &|rng| {
            vec![
                10.0_f32.powf(between(rng, -2.0, 3.0)),
                10.0_f32.powf(between(rng, -2.0, 3.0)),
                whole(rng, 6),
            ]
        },
        exact: &|x| gather_ellipse::ellipse_on_level([x[0], x[1]], x[2]).to_vec(),
        absolute: 6e-8,
        relative: 3e-7,
        steep_share: 0.0,
    });
    pass(&Twin {
        name: "row_weight",
        library,
        call: "y[0] = row_weight(x[0], x[1]);",
        draw: &|rng| {
            let variance = 10.0_f32.powf(between(rng, -2.0, 1.2));
            vec![between(rng, -6.0, 6.0), variance]
        },
        exact: &|x| vec![gather_ellipse::row_weight(x[0], x[1])],
        // An exponent of up to six, and where one kind of weight ends and the next begins.
        absolute: 3e-6,
        relative: 0.0,
        steep_share: 0.0005,
    });
    // Whole numbers: wrong only where one ends and the next begins.
    for (name, call, exact) in [
        (
            "row_reach",
            "y[0] = row_reach(x[0]);",
            (|x| gather_ellipse::row_reach(x[0])) as fn(&[f64]) -> f64,
        ),
        (
            "ellipse_level",
            "y[0] = ellipse_level(ellipse_variances(x[0], x[1]));",
            |x| gather_ellipse::ellipse_level(gather_ellipse::ellipse_variances(x[0], x[1])),
        ),
    ] {
        pass(&Twin {
            name,
            library,
            call,
            draw: &blur,
            exact: &|x| vec![exact(x)],
            absolute: 0.0,
            relative: 0.0,
            steep_share: 0.001,
        });
    }
}
