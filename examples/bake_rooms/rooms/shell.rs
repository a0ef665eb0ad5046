//! Floor, walls, ceiling and windows.

use super::Set;
use super::shapes::Shape;
use glam::{Quat, Vec3};
use ocularium::scene::paint::{Canvas, Clouds, hex, linear, mix};
use std::f32::consts::FRAC_PI_2;

/// Inner faces of the walls, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    left: f32,
    right: f32,
    ceiling: f32,
    far: f32,
    near: f32,
}

/// An opening in a wall: along the wall from `from` to `to`, between two heights, m.
#[derive(Debug, Clone, Copy)]
struct Opening {
    from: f32,
    to: f32,
    low: f32,
    high: f32,
}

const FAR_WINDOW: Opening = Opening {
    from: -0.02,
    to: 1.2,
    low: 0.95,
    high: 2.25,
};
const SIDE_WINDOWS: [Opening; 2] = [
    Opening {
        from: -0.9,
        to: 1.0,
        low: 0.75,
        high: 2.4,
    },
    Opening {
        from: -3.1,
        to: -1.5,
        low: 0.75,
        high: 2.4,
    },
];

impl Extent {
    pub(super) fn of_room() -> Self {
        Self {
            left: -2.2,
            right: 2.1,
            ceiling: 2.6,
            far: -6.02,
            near: 1.8,
        }
    }
}

pub(super) fn build(set: &mut Set, extent: Extent) {
    let Extent {
        left,
        right,
        ceiling,
        far,
        near,
    } = extent;
    let (width, depth) = (right - left, near - far);
    let cell = (width * depth).sqrt() / 22.0;
    let floor = set.covered("floor", true, 0.45);
    let boards = Shape::sheet(
        Vec3::new(left, 0.0, near),
        Vec3::X * width,
        Vec3::NEG_Z * depth,
        cell,
    );
    set.add(
        "floor",
        boards.uv_scaled(width / 1.1, depth / 1.1).uv_turned(),
        floor,
    );
    let white = set.covered("ceiling", true, 0.95);
    let above = Shape::sheet(
        Vec3::new(left, ceiling, far),
        Vec3::X * width,
        Vec3::Z * depth,
        cell,
    );
    set.add("ceiling", above.uv_scaled(width, depth), white);
    let sage = set.covered("wall, green", true, 0.9);
    let cream = set.covered("wall, cream", true, 0.95);
    let far_wall = Shape::joined(pierced(left, right, ceiling, &[FAR_WINDOW]));
    set.add("far wall", far_wall.at(0.0, 0.0, far), sage);
    // Along the left wall the running coordinate is −z, so the openings are mirrored.
    let turned = SIDE_WINDOWS.map(|o| Opening {
        from: -o.to,
        to: -o.from,
        ..o
    });
    let mut left_wall = Shape::joined(pierced(-near, -far, ceiling, &turned));
    left_wall = left_wall
        .turned(Quat::from_rotation_y(FRAC_PI_2))
        .at(left, 0.0, 0.0);
    set.add("left wall", left_wall, cream);
    let right_wall = Shape::sheet(
        Vec3::new(right, 0.0, far),
        Vec3::Z * depth,
        Vec3::Y * ceiling,
        0.5,
    );
    set.add("right wall", right_wall.uv_scaled(depth, ceiling), cream);
    let back = Shape::sheet(
        Vec3::new(right, 0.0, near),
        Vec3::NEG_X * width,
        Vec3::Y * ceiling,
        0.8,
    );
    set.add("near wall", back.uv_scaled(width, ceiling), cream);
    trim(set, extent);
    windows(set, extent);
    curtains(set, extent);
    rug(set);
}

/// A wall in the xy plane, facing +z, from x `from` to `to`, with openings in ascending order of
/// x or not; coordinates in metres.
fn pierced(from: f32, to: f32, height: f32, openings: &[Opening]) -> Vec<Shape> {
    let mut openings = openings.to_vec();
    openings.sort_by(|a, b| a.from.total_cmp(&b.from));
    let mut panels = Vec::new();
    let mut panel = |x0: f32, x1: f32, y0: f32, y1: f32| {
        let sheet = Shape::sheet(
            Vec3::new(x0, y0, 0.0),
            Vec3::X * (x1 - x0),
            Vec3::Y * (y1 - y0),
            0.25,
        );
        let mut sheet = sheet;
        for (uv, position) in sheet.uvs.iter_mut().zip(&sheet.positions) {
            *uv = glam::Vec2::new(position.x, -position.y);
        }
        panels.push(sheet);
    };
    let mut x = from;
    for opening in openings {
        panel(x, opening.from, 0.0, height);
        panel(opening.from, opening.to, 0.0, opening.low);
        panel(opening.from, opening.to, opening.high, height);
        x = opening.to;
    }
    panel(x, to, 0.0, height);
    panels
}

fn trim(set: &mut Set, extent: Extent) {
    let paint = set.plain("trim", 0xf3eee2, 0.5);
    let width = extent.right - extent.left;
    let middle = (extent.left + extent.right) / 2.0;
    let board = |length: f32| Shape::rounded_box(Vec3::new(length, 0.12, 0.02), 0.006, 0.8);
    let cornice = Shape::rounded_box(Vec3::new(width, 0.08, 0.06), 0.02, 0.7);
    set.add(
        "skirting",
        board(width).at(middle, 0.06, extent.far + 0.01),
        paint,
    );
    set.add(
        "cornice",
        cornice.at(middle, extent.ceiling - 0.04, extent.far + 0.03),
        paint,
    );
    let picture_rail = Shape::rounded_box(Vec3::new(width, 0.025, 0.02), 0.008, 0.8);
    set.add(
        "picture rail",
        picture_rail.at(middle, 2.36, extent.far + 0.01),
        paint,
    );
}

/// Frame, cross bars and sill of one window in the xy plane with its outside at −z.
fn window(opening: Opening) -> Shape {
    let Opening {
        from,
        to,
        low,
        high,
    } = opening;
    let (width, height) = (to - from, high - low);
    let (x, y) = ((from + to) / 2.0, (low + high) / 2.0);
    let bar = |size: Vec3| Shape::rounded_box(size, 0.006, 1.0);
    let deep = 0.14;
    let upright = || bar(Vec3::new(0.05, height + 0.05, deep));
    let across = || bar(Vec3::new(width + 0.05, 0.05, deep));
    Shape::joined([
        upright().at(from, y, -deep / 2.0 + 0.03),
        upright().at(to, y, -deep / 2.0 + 0.03),
        across().at(x, high, -deep / 2.0 + 0.03),
        across().at(x, low, -deep / 2.0 + 0.03),
        bar(Vec3::new(0.03, height, 0.04)).at(x, y, -0.06),
        bar(Vec3::new(width, 0.03, 0.04)).at(x, low + 0.68 * height, -0.06),
        bar(Vec3::new(width + 0.16, 0.03, 0.2)).at(x, low - 0.02, 0.04),
    ])
}

fn windows(set: &mut Set, extent: Extent) {
    let paint = set.plain("window paint", 0xf6f2ea, 0.35);
    set.add(
        "far window",
        window(FAR_WINDOW).at(0.0, 0.0, extent.far),
        paint,
    );
    for opening in SIDE_WINDOWS {
        let turned = Opening {
            from: -opening.to,
            to: -opening.from,
            ..opening
        };
        let frame = window(turned).turned(Quat::from_rotation_y(FRAC_PI_2));
        set.add("side window", frame.at(extent.left, 0.0, 0.0), paint);
    }
}

fn curtains(set: &mut Set, extent: Extent) {
    let linen = set.covered("curtain", true, 0.95);
    let linen = set.double_sided(linen);
    let z = extent.far + 0.11;
    for (x, width) in [(-0.27, 0.28), (1.16, 0.3)] {
        let cloth = Shape::curtain(width, 2.32, 4.0, 0.022).uv_scaled(5.0, 5.0);
        set.add("curtain", cloth.at(x, 0.02, z), linen);
    }
    let brass = set.metal("curtain rail", 0xb08d57, 0.35);
    let rail = Shape::tube(
        &[
            Vec3::new(-0.36, 2.34, z),
            Vec3::new(0.6, 2.34, z),
            Vec3::new(1.56, 2.34, z),
        ],
        &[0.011; 3],
        10,
    );
    set.add("curtain rail", rail, brass);
    for x in [-0.37, 1.57] {
        set.add(
            "curtain rail end",
            Shape::ellipsoid(Vec3::splat(0.026), 12).at(x, 2.34, z),
            brass,
        );
    }
}

fn rug(set: &mut Set) {
    let wool = set.covered("rug", false, 1.0);
    let sheet = Shape::sheet(
        Vec3::new(-1.5, 0.012, -2.0),
        Vec3::X * 2.8,
        Vec3::NEG_Z * 3.2,
        0.2,
    );
    set.add("rug", sheet, wool);
}

/// The clinic's corridor, with its eye at (0, 1.18, 0).
pub(super) fn corridor(set: &mut Set) {
    let (left, right, far, near, ceiling) = (-1.2, 1.2, -6.02, 1.5, 2.5);
    let (width, depth) = (right - left, near - far);
    let stains = Clouds::new(6, 9);
    let tiles = Canvas::shaded(256, 256, |u, v| {
        let tile = ((u * 2.0).floor() + (v * 2.0).floor()) as i32 % 2 == 0;
        let seam = (u * 2.0).fract().min((v * 2.0).fract()) < 0.02;
        let base = if seam {
            hex(0x8d968f)
        } else if tile {
            hex(0xc9d2c8)
        } else {
            hex(0xb4c0b6)
        };
        base.map(|c| c * (0.96 + 0.08 * stains.at(u, v)))
    });
    let floor = set.printed("tiles", &tiles, true, 0.3);
    let ground = Shape::sheet(
        Vec3::new(left, 0.0, near),
        Vec3::X * width,
        Vec3::NEG_Z * depth,
        0.25,
    );
    set.add("floor", ground.uv_scaled(width / 0.8, depth / 0.8), floor);
    let paint = set.covered("paint", true, 0.9);
    let above = Shape::sheet(
        Vec3::new(left, ceiling, far),
        Vec3::X * width,
        Vec3::Z * depth,
        0.4,
    );
    set.add("ceiling", above.uv_scaled(width, depth), paint);
    let end = Shape::sheet(
        Vec3::new(left, 0.0, far),
        Vec3::X * width,
        Vec3::Y * ceiling,
        0.2,
    );
    set.add("far wall", end.uv_scaled(width, ceiling), paint);
    let side = Shape::sheet(
        Vec3::new(left, 0.0, near),
        Vec3::NEG_Z * depth,
        Vec3::Y * ceiling,
        0.3,
    );
    set.add("left wall", side.uv_scaled(depth, ceiling), paint);
    let other = Shape::sheet(
        Vec3::new(right, 0.0, far),
        Vec3::Z * depth,
        Vec3::Y * ceiling,
        0.3,
    );
    set.add("right wall", other.uv_scaled(depth, ceiling), paint);
    let back = Shape::sheet(
        Vec3::new(right, 0.0, near),
        Vec3::NEG_X * width,
        Vec3::Y * ceiling,
        0.5,
    );
    set.add("near wall", back.uv_scaled(width, ceiling), paint);
    let teal = set.plain("hand rail", 0x3f7f86, 0.4);
    let oak = set.covered("door", true, 0.5);
    for side in [-1.0, 1.0] {
        let rail = Shape::rounded_box(Vec3::new(0.04, 0.14, depth), 0.015, 0.6);
        set.add(
            "hand rail",
            rail.at(side * 1.18, 0.92, (far + near) / 2.0),
            teal,
        );
        let door = Shape::rounded_box(Vec3::new(0.05, 2.05, 0.9), 0.01, 0.4);
        set.add(
            "door",
            door.uv_scaled(0.6, 0.6)
                .uv_turned()
                .at(side * 1.2, 1.03, -3.2 - 0.6 * side),
            oak,
        );
    }
    let panel = Canvas::new(8, 8, [1.0, 0.99, 0.96]);
    let lamp = set.glowing("lamp panel", &panel, 1200.0, super::Alpha::Opaque);
    for z in [-1.2, -3.0, -4.8] {
        let sheet = Shape::sheet(
            Vec3::new(-0.3, 2.49, z - 0.3),
            Vec3::X * 0.6,
            Vec3::Z * 0.6,
            0.6,
        );
        set.add("glow: lamp panel", sheet, lamp);
    }
    let green = set.plain("leaf", 0xffffff, 0.6);
    let green = set.double_sided(green);
    let leaves = (0..26u8).map(|i| {
        let angle = f32::from(i) * 2.4;
        let lean = 0.25 + 0.03 * f32::from(i);
        let tint = mix(linear(0x2f6b35), linear(0x78a548), f32::from(i % 5) / 4.0);
        let blade = Shape::blade(0.55 - 0.008 * f32::from(i), 0.07, 0.9, 0.8);
        blade
            .turned(Quat::from_rotation_y(angle) * Quat::from_rotation_x(lean))
            .tinted(tint)
    });
    set.add("plant", Shape::joined(leaves).at(0.85, 0.45, -5.5), green);
    let pot = set.plain("pot", 0xd8d2c4, 0.4);
    let profile = [
        (0.0, 0.0),
        (0.13, 0.0),
        (0.16, 0.44),
        (0.17, 0.46),
        (0.14, 0.46),
        (0.13, 0.4),
        (0.0, 0.4),
    ];
    set.add("pot", Shape::lathe(&profile, 28).at(0.85, 0.0, -5.5), pot);
}
