//! The gather of the device against `reference_gather`, with a near card before a far plane.

use super::{Eye, NEUTRAL, Photograph, SIDE};
use crate::stage::turn;
use bevy::math::DVec3;
use image::{Rgba, RgbaImage};
use ocularium::lab::image_difference::{Difference, Limits};
use ocularium::optics::output::linear_to_srgb;

/// Left, top, right and bottom of the card, pixels.
const CARD: [i32; 4] = [40, 30, 110, 120];
/// How far from the card's edge a pixel is still at the edge: the widest kernel here, of 8 mrad or
/// 5.6 pixels, reaches 3.7 pixels, and the mips' texels another 4.
const BAND: i32 = 8;
/// Blurs (pixels) that are not judged: wider than a copy, and too narrow for a reference that takes
/// the Gaussian at the pixels' middles (at 1.4 pixels it blurs half as wide as it should, and from
/// 2.4 on within 1 %).
const UNJUDGED_PX: std::ops::Range<f32> = 0.5..2.4;

/// Plates of four greys; those of the card are smaller.
pub fn card_before_plane() -> Photograph {
    let [left, top, right, bottom] = CARD.map(|edge| edge as u32);
    Photograph::new(|x, y| {
        let near = (left..right).contains(&x) && (top..bottom).contains(&y);
        let side = if near { 7 } else { 11 };
        let (column, row) = (x / side, y / side);
        let kind = column * 7 + row * 5 + column * row;
        ([30, 80, 140, 200][(kind % 4) as usize], near)
    })
}

/// Pixels from the card's edge, negative outside.
fn depth_in_card(x: u32, y: u32) -> i32 {
    let [left, top, right, bottom] = CARD;
    let (x, y) = (x as i32, y as i32);
    (x - left)
        .min(right - 1 - x)
        .min(y - top)
        .min(bottom - 1 - y)
}

/// A part of the picture, and how far the device may be from the reference there, in code values. Both
/// sum the same texels away from edges, but for the window that ends the device's; at an edge a texel
/// of a coarser level has one depth where the reference has several, and what spreads over the edge is
/// summed at 20 to 30 places. Found, at most, are 0.15, 1 and 1 on the card, 0.30, 6 and 11 at its
/// edge and 0.13, 1 and 1 on the plane, and what is sharp differs by nothing.
pub struct Part {
    pub name: &'static str,
    holds: fn(i32) -> bool,
    limits: Limits,
}

static PARTS: [Part; 3] = [
    Part {
        name: "card",
        holds: |depth| depth >= BAND,
        limits: Limits {
            mean: 0.2,
            percentile_999: 2,
            max: 2,
        },
    },
    Part {
        name: "edge",
        holds: |depth| depth.abs() < BAND,
        limits: Limits {
            mean: 0.35,
            percentile_999: 7,
            max: 12,
        },
    },
    Part {
        name: "plane",
        holds: |depth| depth <= -BAND,
        limits: Limits {
            mean: 0.2,
            percentile_999: 2,
            max: 2,
        },
    },
];

/// The same parts and how far an astigmat's picture may be from the reference there, whose every texel is
/// summed as it is here; at the edge as the case has it.
pub fn card_parts(edge_mean: f64) -> [(&'static Part, Limits); 3] {
    let limits = |mean, percentile_999, max| Limits {
        mean,
        percentile_999,
        max,
    };
    let [card, edge, plane] = &PARTS;
    [
        (card, limits(0.2, 2, 2)),
        (edge, limits(edge_mean, 24, 31)),
        (plane, limits(0.28, 3, 4)),
    ]
}

pub fn expected(photograph: &Photograph, eye: Eye) -> RgbaImage {
    let seen = photograph.reference(eye);
    RgbaImage::from_fn(SIDE, SIDE, |x, y| {
        let code = linear_to_srgb(DVec3::splat(seen[(y * SIDE + x) as usize])).y * 255.0;
        let code = code.round() as u8;
        Rgba([code, code, code, 255])
    })
}

/// Difference from what the reference says over the judged pixels of a part.
pub fn difference(
    part: &Part,
    wanted: &RgbaImage,
    drawn: &RgbaImage,
    blur_px: &[f32],
) -> Difference {
    let [wanted, drawn] = [wanted, drawn].map(|picture| {
        let pixels = picture.enumerate_pixels().zip(blur_px);
        let judged = pixels.filter(|((x, y, _), blur)| {
            (part.holds)(depth_in_card(*x, *y)) && !UNJUDGED_PX.contains(*blur)
        });
        let bytes: Vec<u8> = judged.flat_map(|((_, _, pixel), _)| pixel.0).collect();
        RgbaImage::from_vec(bytes.len() as u32 / 4, 1, bytes).expect("whole pixels")
    });
    assert!(
        wanted.width() > 300,
        "{}: {} pixels",
        part.name,
        wanted.width()
    );
    Difference::between(&wanted, &drawn).expect("one size")
}

#[test]
fn depth_edges_are_drawn_as_the_reference_draws_them() {
    let _turn = turn();
    let photograph = card_before_plane();
    let mut headless = photograph.open();
    // The far plane sharp, both blurred alike, and the card sharp.
    for sphere_d in [0.0, -1.0, -2.0] {
        let eye = Eye {
            sphere_d,
            ..NEUTRAL
        };
        let control = Eye {
            sphere_d: sphere_d - 0.25,
            ..eye
        };
        let (wanted, blur_px) = (expected(&photograph, eye), photograph.blur_px(eye).0);
        let [drawn, other] = [eye, control].map(|eye| eye.draw(&mut headless));
        for part in &PARTS {
            let found = difference(part, &wanted, &drawn, &blur_px);
            let refused = difference(part, &wanted, &other, &blur_px);
            println!(
                "{sphere_d} D, {}: {found:?}; -0.25 D: {refused:?}",
                part.name
            );
            assert!(
                found.keeps(&part.limits),
                "{sphere_d} D, {}: {found:?}",
                part.name
            );
            assert!(
                !refused.keeps(&part.limits),
                "{sphere_d} D, {}: -0.25 D passes with {refused:?}",
                part.name
            );
        }
    }
}
