//! What is beyond the window: a lawn, a street sign, trees and houses under a bright sky. All of
//! it shines by itself, at the luminance that the sun would give it.

use super::prints::Fonts;
use super::shapes::Shape;
use super::text::Style;
use super::{Set, Target, facing, ground_of};
use glam::Vec3;
use ocularium::scene::model::Alpha;
use ocularium::scene::paint::{Canvas, hex, mix, unit_hash};

/// Luminance of a sunlit white surface outdoors, cd/m²: a hazy evening, some ten times the room.
const WHITE_CD_M2: f32 = 900.0;

pub(super) fn build(set: &mut Set, fonts: &Fonts) {
    let backdrop = set.glowing("sky and houses", &skyline(), WHITE_CD_M2, Alpha::Opaque);
    set.add(
        "outdoors: sky and houses",
        Shape::picture(30.0, 22.5).moved(facing(&Target::HOUSES, 0.0)),
        backdrop,
    );
    let lawn = set.glowing(
        "lawn",
        &ground_of("lawn"),
        0.65 * WHITE_CD_M2,
        Alpha::Opaque,
    );
    let ground = Shape::sheet(
        Vec3::new(-14.0, -0.4, -6.4),
        Vec3::X * 34.0,
        Vec3::NEG_Z * 36.0,
        40.0,
    );
    set.add("outdoors: lawn", ground, lawn);
    let leaves = set.glowing(
        "tree",
        &ground_of("tree"),
        0.75 * WHITE_CD_M2,
        Alpha::Mask(0.5),
    );
    set.add(
        "outdoors: tree",
        Shape::picture(4.2, 5.2).moved(facing(&Target::TREE, 0.0)),
        leaves,
    );
    let hedge = set.glowing(
        "bush",
        &ground_of("bush"),
        0.6 * WHITE_CD_M2,
        Alpha::Mask(0.5),
    );
    for (x, z, size) in [(-1.0, -17.0, 2.6), (4.6, -27.0, 3.2), (6.2, -30.0, 4.6)] {
        set.add(
            "outdoors: bush",
            Shape::picture(size, size).at(x, 0.36 * size - 0.4, z),
            hedge,
        );
    }
    let plate = set.glowing("street sign", &sign(fonts), WHITE_CD_M2, Alpha::Opaque);
    let here = facing(&Target::SIGN, 0.0);
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
    let mut canvas = ground_of("sky and houses");
    let fronts = [0xe7c9a0, 0xd98c6a, 0xf0e6d2, 0xb7c4cf, 0xe3b25f, 0xcf7f62];
    for (i, &front) in fronts.iter().cycle().take(14).enumerate() {
        let x = 20.0 + 72.0 * i as f32 + 10.0 * unit_hash(i as i32, 1, 4);
        let (width, height) = (
            50.0 + 14.0 * unit_hash(i as i32, 2, 4),
            34.0 + 14.0 * unit_hash(i as i32, 3, 4),
        );
        house(&mut canvas, [x, 398.0], [width, height], hex(front));
    }
    for i in 0..40i32 {
        let (x, y) = (
            1024.0 * unit_hash(i, 5, 9),
            392.0 + 10.0 * unit_hash(i, 6, 9),
        );
        let size = 7.0 + 9.0 * unit_hash(i, 7, 9);
        canvas.ellipse(
            [x, y],
            [size, 0.8 * size],
            mix(hex(0x3f6b34), hex(0x6f9a45), unit_hash(i, 8, 9)),
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
