//! A reader in an armchair, her face 3 m from the eye.

use super::organic::{blend, capsule, carve, ellipsoid, skin};
use super::shapes::Shape;
use super::{Group, Set, Target};
use glam::{Affine3A, Quat, Vec3};
use ocularium::scene::paint::{ValueNoise, linear, mix, smoothstep};

const fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

const SIDES: [f32; 2] = [-1.0, 1.0];

/// How much brighter than the hair's mean colour a strand is at most; no vertex colour is above 1.
const BRIGHTEST_STRAND: f32 = 1.45;

/// Centre of the head in the person's frame: y up from the floor, facing +z.
const HEAD: Vec3 = v(0.0, 1.145, 0.0);

pub(super) fn build(set: &mut Set) {
    let flesh = set.plain("skin", 0xffffff, 0.5);
    let hair = set.plain("hair", 0x4b2d1d, 0.55);
    let color = &mut set.scene.materials[hair].base_color;
    color[..3].iter_mut().for_each(|c| *c *= BRIGHTEST_STRAND);
    let wool = set.plain("sweater", 0xb5533c, 0.95);
    let denim = set.plain("trousers", 0x31445f, 0.9);
    let leather = set.plain("shoes", 0x4a3020, 0.45);
    let white = set.plain("eye white", 0xf2ece4, 0.2);
    let iris = set.plain("iris", 0x3b2a1c, 0.15);
    let book = set.plain("reader's book", 0x2f5d50, 0.7);
    let pages = set.plain("pages", 0xf3ead6, 0.9);
    let eyes = SIDES.map(|side| bead(side, v(0.0, 0.0, 0.0), v(0.0125, 0.0085, 0.0105)));
    let irises = SIDES.map(|side| bead(side, v(0.0, -0.0002, 0.0082), v(0.0056, 0.0058, 0.0034)));
    let (lids, features, lips) = face_details();
    let turned = |shape: Shape| shape.moved(head_turn());
    let group: Group = vec![
        ("face", turned(face()), flesh),
        ("hair", turned(hair_shape()), hair),
        ("eyes", turned(Shape::joined(eyes)), white),
        ("irises", turned(Shape::joined(irises)), iris),
        ("lids", turned(lids), flesh),
        (
            "brows and lashes",
            turned(features).tinted([1.0 / BRIGHTEST_STRAND; 3]),
            hair,
        ),
        ("lips", turned(lips), flesh),
        (
            "sweater",
            skin(&sweater, v(-0.38, 0.4, -0.22), v(0.38, 1.08, 0.42), 0.027),
            wool,
        ),
        (
            "trousers",
            skin(&trousers, v(-0.28, 0.04, -0.2), v(0.28, 0.66, 0.66), 0.036),
            denim,
        ),
        (
            "hands",
            Shape::joined([hand(-1.0), hand(1.0)]).tinted(linear(0xe0a987)),
            flesh,
        ),
        ("shoes", Shape::joined([shoe(-1.0), shoe(1.0)]), leather),
        ("reader's book", cover(), book),
        ("reader's pages", leaves(), pages),
    ];
    let mut all = group;
    all.extend(armchair(set));
    let foot = Target::FACE.point_m();
    let yaw = Quat::from_rotation_y(0.2);
    let by = Affine3A::from_rotation_translation(
        yaw,
        Vec3::new(foot.x, 0.0, foot.z) - yaw * v(0.0, 0.0, 0.09),
    );
    set.add_at_target(all, by, &Target::FACE);
}

/// An ellipsoid at an eye's centre plus `offset`, mirrored with the side.
fn bead(side: f32, offset: Vec3, radii: Vec3) -> Shape {
    let at = HEAD
        + v(
            side * (0.031 + offset.x),
            0.008 + offset.y,
            0.0755 + offset.z,
        );
    Shape::ellipsoid(radii, 14).moved(Affine3A::from_translation(at))
}

/// What is finer than the face's lattice: lids; brows and lash lines; lips with a slight smile.
fn face_details() -> (Shape, Shape, Shape) {
    let skin_tone = linear(0xe2b08f);
    let (mut lids, mut hairs) = (Shape::default(), Shape::default());
    for side in SIDES {
        let upper = bead(side, v(0.0, 0.0072, 0.0004), v(0.0148, 0.0066, 0.0114));
        let lower = bead(side, v(0.0, -0.0086, -0.0018), v(0.0142, 0.0044, 0.0102));
        lids.append(upper.tinted(skin_tone));
        lids.append(lower.tinted(skin_tone));
        let arc = |points: [[f32; 3]; 3]| points.map(|[x, y, z]| HEAD + v(side * x, y, z));
        let lash = arc([
            [0.0185, 0.0085, 0.079],
            [0.031, 0.0112, 0.0875],
            [0.0445, 0.0085, 0.0765],
        ]);
        hairs.append(Shape::tube(&lash, &[0.0009, 0.0014, 0.0013], 6));
        let brow = arc([
            [0.0145, 0.0355, 0.0855],
            [0.028, 0.0395, 0.083],
            [0.0455, 0.034, 0.069],
        ]);
        hairs.append(Shape::tube(&brow, &[0.0021, 0.0022, 0.0012], 8));
    }
    let curve = |y: f32, z: f32, rise: f32| -> Vec<Vec3> {
        let steps = [-1.0f32, -0.55, 0.0, 0.55, 1.0];
        steps
            .map(|t| HEAD + v(0.0225 * t, y + rise * t * t, z - 0.0062 * t * t))
            .to_vec()
    };
    let lips = Shape::joined([
        Shape::tube(
            &curve(-0.0528, 0.0895, 0.0055),
            &[0.0012, 0.0027, 0.0031, 0.0027, 0.0012],
            8,
        ),
        Shape::tube(
            &curve(-0.0585, 0.0885, 0.0105),
            &[0.0012, 0.0034, 0.0043, 0.0034, 0.0012],
            8,
        ),
    ]);
    (lids, hairs, lips.tinted(linear(0xbd5d4e)))
}

/// The hair with strands in its colour.
fn hair_shape() -> Shape {
    let mut shape = skin(
        &hair_distance,
        HEAD - v(0.14, 0.18, 0.15),
        HEAD + v(0.14, 0.16, 0.13),
        0.0115,
    );
    let strands = ValueNoise::new(64, 5);
    for (tint, position) in shape.tints.iter_mut().zip(&shape.positions) {
        let q = *position - HEAD;
        let strand = strands.at(
            14.0 * q.x.atan2(q.z + 0.02).abs() + 9.0 * q.y,
            6.0 * q.y + 3.0,
        );
        *tint *= (0.65 + 0.8 * strand) / BRIGHTEST_STRAND;
    }
    shape
}

/// She looks up from the page, a little to the viewer.
fn head_turn() -> Affine3A {
    let pivot = HEAD - v(0.0, 0.09, 0.03);
    let turn =
        Quat::from_rotation_y(0.04) * Quat::from_rotation_x(0.03) * Quat::from_rotation_z(-0.05);
    Affine3A::from_translation(pivot)
        * Affine3A::from_quat(turn)
        * Affine3A::from_translation(-pivot)
}

fn face_distance(p: Vec3) -> f32 {
    let q = v(p.x.abs(), p.y, p.z) - HEAD;
    let skull = ellipsoid(q, v(0.0, 0.025, -0.012), v(0.076, 0.095, 0.092));
    let cheeks = ellipsoid(q, v(0.022, -0.035, 0.035), v(0.044, 0.05, 0.046));
    let jaw = ellipsoid(q, v(0.0, -0.068, 0.042), v(0.042, 0.034, 0.042));
    let mut head = blend(blend(skull, cheeks, 0.04), jaw, 0.04);
    head = carve(
        head,
        ellipsoid(q, v(0.032, 0.01, 0.092), v(0.018, 0.011, 0.017)),
        0.012,
    );
    let brow = capsule(
        q,
        v(0.012, 0.026, 0.079),
        v(0.042, 0.028, 0.066),
        0.006,
        0.005,
    );
    let bridge = capsule(q, v(0.0, 0.016, 0.082), v(0.0, -0.02, 0.1), 0.0065, 0.0095);
    let wing = ellipsoid(q, v(0.01, -0.025, 0.09), v(0.008, 0.007, 0.009));
    let lips = ellipsoid(q, v(0.0, -0.0545, 0.079), v(0.021, 0.009, 0.0085));
    let chin = ellipsoid(q, v(0.0, -0.088, 0.072), v(0.018, 0.014, 0.015));
    head = blend(blend(head, brow, 0.014), blend(bridge, wing, 0.008), 0.012);
    head = blend(blend(head, lips, 0.006), chin, 0.02);
    let ear = ellipsoid(q, v(0.078, -0.004, -0.008), v(0.01, 0.028, 0.017));
    let neck = capsule(
        q,
        v(0.0, -0.06, -0.015),
        v(0.0, -0.19, -0.035),
        0.047,
        0.056,
    );
    blend(blend(head, ear, 0.008), neck, 0.025)
}

fn face() -> Shape {
    let mut shape = skin(
        &face_distance,
        HEAD - v(0.1, 0.2, 0.13),
        HEAD + v(0.1, 0.14, 0.13),
        0.008,
    );
    for (tint, position) in shape.tints.iter_mut().zip(&shape.positions) {
        let q = v(position.x.abs(), position.y, position.z) - HEAD;
        let near =
            |centre: Vec3, radii: Vec3| 1.0 - smoothstep(0.6, 1.2, ((q - centre) / radii).length());
        let mut color = linear(0xe6b896);
        color = mix(
            color,
            linear(0xd8846c),
            0.4 * near(v(0.04, -0.03, 0.06), v(0.024, 0.018, 0.04)),
        );
        color = mix(
            color,
            linear(0xcf8a70),
            0.5 * near(v(0.0, -0.02, 0.105), v(0.014, 0.012, 0.014)),
        );
        color = mix(
            color,
            linear(0xa86f55),
            0.45 * near(v(0.032, 0.016, 0.08), v(0.02, 0.01, 0.03)),
        );
        *tint = color.into();
    }
    shape
}

/// A chin-length bob with a parting, open at the face.
fn hair_distance(p: Vec3) -> f32 {
    let q = p - HEAD;
    let side = v(q.x.abs(), q.y, q.z);
    let cap = ellipsoid(q, v(0.0, 0.035, -0.018), v(0.091, 0.101, 0.106));
    let locks = ellipsoid(side, v(0.07, -0.03, -0.022), v(0.034, 0.085, 0.062));
    let back = ellipsoid(q, v(0.0, -0.03, -0.07), v(0.075, 0.08, 0.045));
    let all = blend(blend(cap, locks, 0.03), back, 0.04);
    let open = ellipsoid(q, v(0.008, -0.014, 0.12), v(0.067, 0.1, 0.092));
    let around = q.x.atan2(q.z + 0.02);
    let waves = 0.0035 * (17.0 * around + 30.0 * q.y).sin() * smoothstep(0.11, 0.02, q.y);
    carve(all, open, 0.012) + waves
}

fn sweater(p: Vec3) -> f32 {
    let q = v(p.x.abs(), p.y, p.z);
    // The trunk is flatter than wide.
    let flat = v(p.x * 0.82, p.y, p.z * 1.2);
    let trunk = capsule(flat, v(0.0, 0.56, 0.03), v(0.0, 0.84, -0.01), 0.13, 0.125);
    let shoulders = capsule(q, v(0.0, 0.935, -0.02), v(0.155, 0.905, -0.02), 0.07, 0.066);
    let upper = capsule(q, v(0.185, 0.89, -0.015), v(0.265, 0.665, 0.09), 0.06, 0.05);
    let lower = capsule(q, v(0.265, 0.665, 0.09), v(0.135, 0.66, 0.285), 0.05, 0.036);
    let collar = capsule(q, v(0.0, 0.955, -0.03), v(0.0, 1.0, -0.025), 0.064, 0.058);
    let body = blend(blend(trunk, shoulders, 0.07), collar, 0.03);
    let folds = 0.003 * (70.0 * p.y + 25.0 * p.x.abs() + 8.0 * p.z).sin();
    blend(body, blend(upper, lower, 0.03), 0.03) + folds
}

fn trousers(p: Vec3) -> f32 {
    let q = v(p.x.abs(), p.y, p.z);
    let hips = ellipsoid(q, v(0.0, 0.53, 0.0), v(0.18, 0.11, 0.15));
    let thigh = capsule(q, v(0.09, 0.525, 0.06), v(0.1, 0.535, 0.47), 0.085, 0.066);
    let shin = capsule(q, v(0.1, 0.53, 0.475), v(0.1, 0.12, 0.5), 0.064, 0.05);
    blend(hips, blend(thigh, shin, 0.03), 0.05)
}

fn hand(side: f32) -> Shape {
    let wrist = v(side * 0.128, 0.66, 0.295);
    let palm = v(side * 0.098, 0.672, 0.345);
    let fingers = v(side * 0.062, 0.678, 0.362);
    let thumb = v(side * 0.075, 0.705, 0.332);
    Shape::joined([
        Shape::tube(&[wrist, palm, fingers], &[0.028, 0.034, 0.022], 12),
        Shape::tube(
            &[palm, palm.lerp(thumb, 0.5), thumb],
            &[0.016, 0.014, 0.01],
            10,
        ),
    ])
}

fn shoe(side: f32) -> Shape {
    let sole = Shape::ellipsoid(v(0.046, 0.045, 0.125), 18).at(side * 0.1, 0.045, 0.56);
    let ankle = Shape::ellipsoid(v(0.05, 0.055, 0.06), 14).at(side * 0.1, 0.085, 0.5);
    Shape::joined([sole, ankle])
}

/// One half of an open book, from the fold outwards.
fn half(side: f32, thick: f32, width: f32) -> Shape {
    let board = Shape::rounded_box(v(width, 0.175, thick), 0.0015, 0.1);
    let turn = Quat::from_rotation_y(-side * 0.3);
    board.at(side * width / 2.0, 0.0, 0.0).turned(turn)
}

fn placed(shape: Shape) -> Shape {
    // Leaning back towards the reader, its outside to the viewer.
    shape.turned(Quat::from_rotation_x(0.75)).at(0.0, 0.7, 0.36)
}

fn cover() -> Shape {
    placed(Shape::joined([
        half(-1.0, 0.005, 0.13),
        half(1.0, 0.005, 0.13),
    ]))
}

fn leaves() -> Shape {
    placed(
        Shape::joined([half(-1.0, 0.012, 0.122), half(1.0, 0.012, 0.122)]).at(0.0, 0.002, -0.009),
    )
}

/// An armchair in the person's frame.
fn armchair(set: &mut Set) -> Group {
    let cloth = set.covered("armchair", true, 0.95);
    let accent = set.covered("cushion", true, 0.95);
    let oak = set.plain("chair legs", 0x6b4226, 0.4);
    let soft = |x: f32, y: f32, z: f32, radius: f32| {
        Shape::rounded_box(v(x, y, z), radius, 0.14).uv_scaled(6.0, 6.0)
    };
    let back = soft(0.66, 0.66, 0.17, 0.07)
        .turned(Quat::from_rotation_x(-0.17))
        .at(0.0, 0.73, -0.25);
    let seat = soft(0.6, 0.2, 0.62, 0.06).at(0.0, 0.33, 0.08);
    let arm = |side: f32| soft(0.14, 0.42, 0.72, 0.06).at(side * 0.36, 0.4, 0.04);
    let wing = |side: f32| soft(0.1, 0.4, 0.26, 0.045).at(side * 0.33, 0.84, -0.17);
    let pillow = soft(0.36, 0.3, 0.13, 0.06)
        .turned(Quat::from_rotation_z(0.25))
        .at(0.2, 0.66, -0.14);
    let legs = [(-0.33, 0.34), (0.33, 0.34), (-0.33, -0.28), (0.33, -0.28)]
        .map(|(x, z)| Shape::lathe(&[(0.014, 0.0), (0.026, 0.2)], 10).at(x, 0.0, z));
    vec![
        (
            "armchair",
            Shape::joined([back, seat, arm(-1.0), arm(1.0), wing(-1.0), wing(1.0)]),
            cloth,
        ),
        ("cushion", pillow, accent),
        ("chair legs", Shape::joined(legs), oak),
    ]
}
