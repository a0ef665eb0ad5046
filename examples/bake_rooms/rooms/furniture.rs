//! Bookcase, floor lamp, sideboard and pictures: 3 m to 6 m from the eye.

use super::prints::{Fonts, frame, hang_chart, portrait_canvas, spines_canvas};
use super::shapes::Shape;
use super::{Alpha, Set, Target};
use glam::{Quat, Vec3};
use ocularium::scene::model::SceneLight;
use ocularium::scene::paint::{Canvas, hex, linear, mix, unit_hash};

pub(super) fn build(set: &mut Set, fonts: &Fonts) {
    bookcase(set, fonts);
    floor_lamp(set);
    sideboard(set);
    hang_chart(set, fonts, &Target::CHART);
    picture(
        set,
        &Target::new("portrait", -16.4, 6.8, 6.2),
        [0.52, 0.65],
        &portrait_canvas(),
    );
}

fn picture(set: &mut Set, place: &Target, [width, height]: [f32; 2], canvas: &Canvas) {
    let paint = set.printed("painting", canvas, false, 0.6);
    let gilt = set.metal("gilt frame", 0xb8924a, 0.45);
    let at = place.point_m();
    let (x, y, z) = (at.x, at.y, -5.985);
    set.add("painting", Shape::picture(width, height).at(x, y, z), paint);
    set.add(
        "painting frame",
        frame(width, height, 0.045, 0.04).at(x, y, z),
        gilt,
    );
}

/// A case of four shelves whose spines' plane meets the line of sight at 3 m.
fn bookcase(set: &mut Set, fonts: &Fonts) {
    let oak = set.covered("bookcase", true, 0.5);
    let (left, width, height, deep) = (0.66, 1.0, 1.62, 0.3);
    let front = Target::BOOKS.point_m().z;
    let board = |w: f32, h: f32, d: f32| Shape::rounded_box(Vec3::new(w, h, d), 0.004, 0.3);
    let z = front + 0.025 - deep / 2.0;
    let mut case = Shape::joined([
        board(0.03, height, deep)
            .uv_turned()
            .at(left, height / 2.0, z),
        board(0.03, height, deep)
            .uv_turned()
            .at(left + width, height / 2.0, z),
        board(width + 0.06, 0.035, deep + 0.03).at(left + width / 2.0, height, z),
        board(width, height, 0.012).at(left + width / 2.0, height / 2.0, front - deep + 0.03),
    ]);
    let shelves = [0.08, 0.42, 0.76, 1.08, 1.36];
    for y in shelves {
        case.append(board(width - 0.03, 0.024, deep - 0.01).at(left + width / 2.0, y, z));
    }
    set.add("bookcase", case, oak);
    let spines = set.printed("book spines", &spines_canvas(fonts), false, 0.7);
    let paper = set.plain("book blocks", 0xe8dcc0, 0.9);
    let (mut backs, mut blocks) = (Shape::default(), Shape::default());
    for (shelf, y) in shelves.into_iter().enumerate().skip(1) {
        let room_above = shelves.get(shelf + 1).map_or(height, |next| *next) - y - 0.05;
        let mut x = left + 0.03;
        let mut book = 0;
        while x < left + width - 0.09 {
            let random = |k: u32| unit_hash(book, shelf as i32, 100 + k);
            let thick = 0.026 + 0.03 * random(0);
            let tall = room_above * (0.74 + 0.24 * random(1));
            let row = (random(2) * 16.0) as u32 % 16;
            let sheet = Shape::picture(tall, thick)
                .turned(Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2));
            let [v0, v1] =
                [row, row + 1].map(|r| (r as f32 + if r == row { 0.02 } else { -0.02 }) / 16.0);
            let (cx, cy) = (x + thick / 2.0, y + 0.0125 + tall / 2.0);
            backs.append(sheet.uv_into([0.0, v0, 1.0, v1]).at(cx, cy, front));
            let block = Shape::rounded_box(Vec3::new(thick, tall, 0.19), 0.0, 1.0);
            blocks.append(block.at(cx, cy, front - 0.0955));
            x += thick + 0.0015;
            book += 1;
            // A gap with an ornament now and then.
            if shelf == 2 && book == 9 {
                x += 0.16;
            }
        }
    }
    set.add("book spines", backs, spines);
    set.add("book blocks", blocks, paper);
    ornaments(set, left, width, height, z);
}

fn ornaments(set: &mut Set, left: f32, width: f32, height: f32, z: f32) {
    let clay = set.plain("flower pot", 0xb8643c, 0.8);
    let pot = [
        (0.0, 0.0),
        (0.055, 0.0),
        (0.075, 0.11),
        (0.08, 0.11),
        (0.08, 0.13),
        (0.068, 0.13),
        (0.06, 0.11),
        (0.0, 0.11),
    ];
    let top = height + 0.018;
    set.add(
        "flower pot",
        Shape::lathe(&pot, 28).at(left + 0.24, top, z + 0.03),
        clay,
    );
    let leaf = set.plain("house plant", 0xffffff, 0.5);
    let leaf = set.double_sided(leaf);
    let leaves = (0..34u8).map(|i| {
        let k = f32::from(i);
        let tint = mix(
            linear(0x2c6238),
            linear(0x8fb457),
            unit_hash(i32::from(i), 0, 3),
        );
        let lean = 0.15 + 0.035 * k;
        let blade = Shape::blade(0.3 - 0.003 * k, 0.042, 1.3, 0.75);
        blade
            .turned(Quat::from_rotation_y(2.4 * k) * Quat::from_rotation_x(lean))
            .tinted(tint)
    });
    set.add(
        "house plant",
        Shape::joined(leaves).at(left + 0.24, top + 0.11, z + 0.03),
        leaf,
    );
    let sea = set.plain("globe", 0x4f86a8, 0.35);
    let brass = set.metal("globe stand", 0xb08d57, 0.35);
    let x = left + 0.52 * width;
    set.add(
        "globe",
        Shape::ellipsoid(Vec3::splat(0.095), 24).at(x, top + 0.15, z + 0.02),
        sea,
    );
    let ring = [
        (0.0, 0.0),
        (0.06, 0.0),
        (0.055, 0.012),
        (0.01, 0.02),
        (0.009, 0.06),
        (0.0, 0.06),
    ];
    set.add(
        "globe stand",
        Shape::lathe(&ring, 24).at(x, top, z + 0.02),
        brass,
    );
}

fn floor_lamp(set: &mut Set) {
    let brass = set.metal("lamp stand", 0xa98446, 0.35);
    let at = Vec3::new(-1.2, 0.0, -3.35);
    let stand = [
        (0.0, 0.0),
        (0.15, 0.0),
        (0.15, 0.015),
        (0.03, 0.03),
        (0.012, 0.05),
        (0.011, 1.4),
        (0.0, 1.4),
    ];
    set.add(
        "lamp stand",
        Shape::lathe(&stand, 24).at(at.x, 0.0, at.z),
        brass,
    );
    let glow = Canvas::shaded(16, 128, |_, v| {
        let bright = 1.0 - 1.5 * (v - 0.55).powi(2);
        mix(hex(0x6a3d12), hex(0xffdca6), bright.clamp(0.0, 1.0))
    });
    let shade = set.glowing("lamp shade", &glow, 420.0, Alpha::Opaque);
    let shade = set.double_sided(shade);
    let cone = Shape::lathe(&[(0.215, 1.34), (0.13, 1.64)], 40);
    set.add("glow: lamp shade", cone.at(at.x, 0.0, at.z), shade);
    let rims = Shape::joined([
        Shape::lathe(&[(0.2155, 1.335), (0.2165, 1.345)], 40),
        Shape::lathe(&[(0.1305, 1.635), (0.1315, 1.645)], 40),
    ]);
    set.add("lamp rims", rims.at(at.x, 0.0, at.z), brass);
    set.scene.lights.push(SceneLight::Point {
        position: [at.x, 1.5, at.z],
        color: [1.0, 0.7, 0.4],
        intensity_lm: 1500.0,
        range: 6.0,
        shadows: false,
    });
}

fn sideboard(set: &mut Set) {
    let cherry = set.covered("sideboard", true, 0.4);
    let brass = set.metal("handles", 0xb08d57, 0.3);
    let (x, z) = (-1.05, -5.78);
    let body = Shape::rounded_box(Vec3::new(1.3, 0.62, 0.4), 0.008, 0.35);
    let top = Shape::rounded_box(Vec3::new(1.36, 0.03, 0.44), 0.008, 0.15);
    set.add(
        "sideboard",
        Shape::joined([body.at(x, 0.43, z), top.at(x, 0.755, z)]),
        cherry,
    );
    for column in [-0.42, 0.0, 0.42] {
        let panel = Shape::rounded_box(Vec3::new(0.4, 0.54, 0.02), 0.008, 0.3);
        set.add(
            "sideboard door",
            panel.uv_turned().at(x + column, 0.43, z + 0.205),
            cherry,
        );
        set.add(
            "handle",
            Shape::ellipsoid(Vec3::splat(0.013), 10).at(x + column + 0.15, 0.5, z + 0.225),
            brass,
        );
    }
    for (dx, dz) in [(-0.6, 0.15), (0.6, 0.15), (-0.6, -0.15), (0.6, -0.15)] {
        set.add(
            "sideboard leg",
            Shape::lathe(&[(0.012, 0.0), (0.02, 0.12)], 8).at(x + dx, 0.0, z + dz),
            cherry,
        );
    }
    let plaster = set.plain("figurine", 0xf0eadc, 0.7);
    let figure = [
        (0.0, 0.0),
        (0.06, 0.0),
        (0.06, 0.03),
        (0.035, 0.045),
        (0.03, 0.1),
        (0.048, 0.16),
        (0.055, 0.2),
        (0.03, 0.235),
        (0.018, 0.25),
        (0.03, 0.275),
        (0.036, 0.305),
        (0.028, 0.335),
        (0.0, 0.35),
    ];
    set.add(
        "figurine",
        Shape::lathe(&figure, 24).at(x + 0.5, 0.77, z),
        plaster,
    );
    let jug = set.plain("jug", 0x5d7f9c, 0.3);
    let profile = [
        (0.0, 0.0),
        (0.05, 0.0),
        (0.085, 0.06),
        (0.08, 0.13),
        (0.04, 0.19),
        (0.035, 0.22),
        (0.045, 0.25),
        (0.0, 0.24),
    ];
    set.add("jug", Shape::lathe(&profile, 28).at(x + 0.2, 0.77, z), jug);
    for (i, cover) in [0x8c3b3b, 0x355e7a, 0xd8b45a].into_iter().enumerate() {
        let cloth = set.plain("books lying", cover, 0.7);
        let book = Shape::rounded_box(Vec3::new(0.26 - 0.02 * i as f32, 0.04, 0.18), 0.004, 0.2);
        set.add(
            "books lying",
            book.at(x - 0.15, 0.79 + 0.04 * i as f32, z),
            cloth,
        );
    }
}
