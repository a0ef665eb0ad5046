//! What is beyond the window: a lawn, a street sign, trees and houses under a bright sky. All of
//! it shines by itself, at the luminance that the sun would give it.

use super::super::model::Alpha;
use super::super::paint::{Canvas, clouds, hash, hex, mix, smoothstep};
use super::super::shapes::Shape;
use super::prints::Fonts;
use super::{HOUSES, SIGN, Set, TREE};
use crate::scene::text::Style;
use glam::Vec3;

/// Luminance of a sunlit white surface outdoors, cd/m²: a hazy evening, some ten times the room.
const WHITE_CD_M2: f32 = 900.0;

pub(super) fn build(set: &mut Set, fonts: &Fonts) {
    let backdrop = set.glowing("sky and houses", &skyline(), WHITE_CD_M2, Alpha::Opaque);
    set.add(
        "outdoors: sky and houses",
        Shape::picture(30.0, 22.5).moved(HOUSES.facing(0.0)),
        backdrop,
    );
    let grass = Canvas::shaded(256, 256, |u, v| {
        let stripe = if (v * 14.0).fract() < 0.5 { 0.06 } else { 0.0 };
        let path = smoothstep(0.05, 0.03, (u - 0.53 - 0.06 * (v * 7.0).sin()).abs());
        let lawn = mix(hex(0x5e8f3a), hex(0x8fb558), clouds(u, v, 9, 40) + stripe);
        mix(lawn, hex(0xcdb992), path)
    });
    let lawn = set.glowing("lawn", &grass, 0.65 * WHITE_CD_M2, Alpha::Opaque);
    let ground = Shape::sheet(
        Vec3::new(-14.0, -0.4, -6.4),
        Vec3::X * 34.0,
        Vec3::NEG_Z * 36.0,
        40.0,
    );
    set.add("outdoors: lawn", ground, lawn);
    let leaves = set.glowing("tree", &tree(3), 0.75 * WHITE_CD_M2, Alpha::Mask(0.5));
    set.add(
        "outdoors: tree",
        Shape::picture(4.2, 5.2).moved(TREE.facing(0.0)),
        leaves,
    );
    let hedge = set.glowing("bush", &tree(8), 0.6 * WHITE_CD_M2, Alpha::Mask(0.5));
    for (x, z, size) in [(-1.0, -17.0, 2.6), (4.6, -27.0, 3.2), (6.2, -30.0, 4.6)] {
        set.add(
            "outdoors: bush",
            Shape::picture(size, size).at(x, 0.36 * size - 0.4, z),
            hedge,
        );
    }
    let plate = set.glowing("street sign", &sign(fonts), WHITE_CD_M2, Alpha::Opaque);
    let here = SIGN.facing(0.0);
    set.add(
        "outdoors: street sign",
        Shape::picture(0.92, 0.26).moved(here),
        plate,
    );
    let post = set.glowing(
        "sign post",
        &Canvas::new(4, 4, hex(0x6f767b)),
        0.7 * WHITE_CD_M2,
        Alpha::Opaque,
    );
    let foot = Vec3::from(here.translation);
    let path = [
        Vec3::new(foot.x, -0.4, foot.z - 0.04),
        Vec3::new(foot.x, 0.6, foot.z - 0.04),
        Vec3::new(foot.x, foot.y + 0.2, foot.z - 0.04),
    ];
    set.add(
        "outdoors: sign post",
        Shape::tube(&path, &[0.035; 3], 10),
        post,
    );
}

/// Sky with clouds over hills and a row of houses; the horizon is at the middle.
fn skyline() -> Canvas {
    let mut canvas = Canvas::shaded(1024, 768, |u, v| {
        let height = (0.5 - v) * 2.0;
        let hill = 0.03 + 0.035 * (u * 9.0).sin() + 0.02 * (u * 23.0 + 1.0).sin();
        if height < -0.035 {
            mix(hex(0x6f9a4f), hex(0x93b565), clouds(u, v, 40, 6))
        } else if height < hill + 0.06 {
            mix(hex(0x9db7a0), hex(0x7e9f86), clouds(u, v, 30, 5))
        } else {
            let sky = mix(hex(0xe8eef0), hex(0x86b4e2), smoothstep(-0.05, 0.6, height));
            let cloud = smoothstep(0.52, 0.72, clouds(u * 0.9 + 0.05, v * 2.2, 5, 12));
            mix(sky, [1.0, 0.99, 0.97], 0.85 * cloud)
        }
    });
    let fronts = [0xe7c9a0, 0xd98c6a, 0xf0e6d2, 0xb7c4cf, 0xe3b25f, 0xcf7f62];
    for (i, &front) in fronts.iter().cycle().take(14).enumerate() {
        let x = 20.0 + 72.0 * i as f32 + 10.0 * hash(i as i32, 1, 4);
        let (width, height) = (
            50.0 + 14.0 * hash(i as i32, 2, 4),
            34.0 + 14.0 * hash(i as i32, 3, 4),
        );
        house(&mut canvas, [x, 398.0], [width, height], hex(front));
    }
    for i in 0..40i32 {
        let (x, y) = (1024.0 * hash(i, 5, 9), 392.0 + 10.0 * hash(i, 6, 9));
        let size = 7.0 + 9.0 * hash(i, 7, 9);
        canvas.ellipse(
            [x, y],
            [size, 0.8 * size],
            mix(hex(0x3f6b34), hex(0x6f9a45), hash(i, 8, 9)),
            1.0,
            0.15,
        );
    }
    canvas
}

fn house(canvas: &mut Canvas, [x, foot]: [f32; 2], [width, height]: [f32; 2], front: [f32; 3]) {
    let roof = hex(0x8a4b3a);
    let top = foot - height;
    canvas.rect(x, top, x + width, foot, front);
    canvas.rect(
        x + 0.8 * width,
        top,
        x + width,
        foot,
        front.map(|c| 0.8 * c),
    );
    for row in 0..16u8 {
        let t = f32::from(row) / 16.0;
        let inset = 0.5 * width * t - 3.0;
        canvas.rect(
            x + inset,
            top - f32::from(row) - 1.0,
            x + width - inset,
            top - f32::from(row),
            roof.map(|c| c * (1.0 - 0.2 * t)),
        );
    }
    for column in 0..3u8 {
        for row in 0..2u8 {
            let (wx, wy) = (
                x + width * (0.14 + 0.28 * f32::from(column)),
                top + 6.0 + 15.0 * f32::from(row),
            );
            canvas.rect(wx - 1.0, wy - 1.0, wx + 8.0, wy + 10.0, hex(0xf8f5ee));
            canvas.rect(wx, wy, wx + 7.0, wy + 9.0, hex(0x51616e));
        }
    }
}

/// A tree as a cut-out: trunk and a crown of lit and shaded clumps, light from the upper left.
fn tree(seed: u32) -> Canvas {
    let mut canvas = Canvas::new(512, 640, hex(0x4c7034));
    canvas.clear_alpha();
    let bark = hex(0x5b4632);
    canvas.line([256.0, 640.0], [250.0, 380.0], 34.0, bark, 1.0);
    for (x, y) in [(150.0, 300.0), (350.0, 290.0), (250.0, 200.0)] {
        canvas.line([252.0, 430.0], [x, y], 14.0, bark, 1.0);
    }
    for i in 0..1100i32 {
        let t = i as f32 / 1100.0;
        let angle = std::f32::consts::TAU * hash(i, 0, seed);
        let reach = hash(i, 1, seed).sqrt();
        let (x, y) = (
            256.0 + 205.0 * reach * angle.cos(),
            245.0 + 200.0 * reach * angle.sin(),
        );
        let lit = (0.5 - 0.35 * reach * angle.sin() - 0.2 * reach * angle.cos()).clamp(0.0, 1.0);
        let depth = (0.25 + 0.75 * t) * lit;
        let color = mix(
            hex(0x2f5427),
            hex(0xa8c65c),
            (1.1 * depth + 0.12 * hash(i, 2, seed)).min(1.0),
        );
        let size = 6.0 + 11.0 * hash(i, 3, seed);
        canvas.ellipse([x, y], [size, 0.7 * size], color, 1.0, 0.08);
    }
    canvas
}

fn sign(fonts: &Fonts) -> Canvas {
    let mut canvas = Canvas::new(736, 208, hex(0xf4f4f0));
    canvas.rect(12.0, 12.0, 724.0, 196.0, hex(0x1f4f8f));
    fonts.sans.draw_centred(
        &mut canvas,
        368.0,
        138.0,
        "ELM STREET",
        Style::new(124.0, hex(0xffffff)).bold(),
    );
    canvas
}
