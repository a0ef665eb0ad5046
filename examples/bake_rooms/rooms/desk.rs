//! The desk and what is on it or held above it: 0.3 m to 1 m from the eye.

use super::organic::{blend, capsule, skin, soft_box};
use super::prints::{Fonts, dial_canvas, letter_canvas, phone_canvas};
use super::shapes::Shape;
use super::{Alpha, Group, Set, Target, facing};
use glam::{Affine3A, Quat, Vec3};
use ocularium::scene::paint::{Canvas, hex, linear, mix};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Height of the desk's top, m.
const TOP_M: f32 = 0.8;

pub(super) fn build(set: &mut Set, fonts: &Fonts) {
    table(set);
    phone(set, fonts);
    letter(set, fonts);
    vase(set);
    mug(set);
    clock(set, fonts);
    small_things(set);
}

fn table(set: &mut Set) {
    let walnut = set.covered("walnut", true, 0.4);
    let top = Shape::rounded_box(Vec3::new(1.9, 0.035, 1.12), 0.012, 0.068);
    set.add(
        "desk top",
        top.uv_scaled(0.9, 0.9).at(0.0, TOP_M - 0.0175, -0.72),
        walnut,
    );
    for (x, z) in [(-0.86, -0.24), (0.86, -0.24), (-0.86, -1.2), (0.86, -1.2)] {
        let leg = Shape::rounded_box(Vec3::new(0.06, TOP_M - 0.035, 0.06), 0.006, 0.8);
        set.add(
            "desk leg",
            leg.uv_turned().at(x, (TOP_M - 0.035) / 2.0, z),
            walnut,
        );
    }
}

fn phone(set: &mut Set, fonts: &Fonts) {
    let (width, height, thick) = (0.066, 0.136, 0.0085);
    let black = set.plain("telephone", 0x17181b, 0.25);
    let screen = set.glowing(
        "telephone screen",
        &phone_canvas(fonts),
        220.0,
        Alpha::Opaque,
    );
    let body = Shape::rounded_box(Vec3::new(width, height, thick), 0.004, 0.05);
    let glass = Shape::picture(width - 0.005, height - 0.007);
    let skin_tone = set.plain("hand", 0xffffff, 0.55);
    let wool = set.plain("sleeve", 0x3b5a7a, 0.95);
    let group: Group = vec![
        ("telephone", body.at(0.0, 0.0, -thick / 2.0 - 0.0003), black),
        ("glow: telephone screen", glass, screen),
        ("hand", hand(), skin_tone),
        ("sleeve", sleeve(), wool),
    ];
    // The screen is perpendicular to the line of sight, so the target is on it exactly.
    set.add_group(group, facing(&Target::PHONE, -7.0));
}

/// A left hand behind the telephone, in its frame: x right, y up, z towards the reader.
fn hand() -> Shape {
    let v = Vec3::new;
    let distance = move |p: Vec3| {
        let palm = soft_box(
            p,
            v(-0.004, -0.052, -0.027),
            Quat::IDENTITY,
            v(0.036, 0.045, 0.0145),
            0.014,
        );
        let wrist = capsule(
            p,
            v(-0.012, -0.095, -0.03),
            v(-0.03, -0.16, -0.036),
            0.023,
            0.0245,
        );
        let ball = capsule(
            p,
            v(-0.03, -0.075, -0.022),
            v(-0.041, -0.048, -0.01),
            0.017,
            0.0135,
        );
        let thumb = capsule(
            p,
            v(-0.0435, -0.046, -0.006),
            v(-0.0405, -0.018, 0.0065),
            0.0112,
            0.0092,
        );
        let tip = capsule(
            p,
            v(-0.0405, -0.018, 0.0065),
            v(-0.031, 0.004, 0.0082),
            0.0092,
            0.0072,
        );
        let mut all = blend(blend(palm, wrist, 0.03), ball, 0.02);
        all = blend(all, blend(thumb, tip, 0.006), 0.012);
        for finger in 0..4u8 {
            let y = -0.07 + 0.0195 * f32::from(finger);
            let reach = [0.0, 0.003, 0.002, -0.001][usize::from(finger)];
            let knuckle = v(0.008, y, -0.028);
            let bend = v(0.0425, y + 0.006, -0.012);
            let end = v(0.033 - reach, y + 0.011, 0.0075);
            let back = capsule(p, knuckle, bend, 0.0105, 0.0088);
            let front = capsule(p, bend, end, 0.0088, 0.0072);
            all = blend(all, blend(back, front, 0.006), 0.005);
        }
        all
    };
    let mut shape = skin(
        &distance,
        v(-0.075, -0.2, -0.075),
        v(0.07, 0.035, 0.03),
        0.0053,
    );
    let nail = v(-0.0285, 0.0075, 0.0165);
    for (tint, p) in shape.tints.iter_mut().zip(&shape.positions) {
        // Blood shows at the tips and knuckles.
        let near_tip = (1.0 - (*p - v(-0.026, 0.013, 0.012)).length() / 0.02).max(0.0);
        let finger_tip = ((p.z - 0.002) / 0.012).clamp(0.0, 1.0);
        let flesh = mix(
            linear(0xe3ad8c),
            linear(0xd98873),
            0.6 * near_tip.max(finger_tip),
        );
        let on_nail = ((*p - nail) / v(0.0055, 0.0075, 0.006)).length();
        *tint = mix(
            flesh,
            linear(0xf3d3c6),
            0.8 * (1.0 - on_nail).clamp(0.0, 0.3) / 0.3,
        )
        .into();
    }
    shape
}

fn sleeve() -> Shape {
    let path = [
        Vec3::new(-0.026, -0.148, -0.036),
        Vec3::new(-0.045, -0.22, -0.045),
        Vec3::new(-0.08, -0.36, -0.05),
    ];
    let ring = Shape::tube(
        &[
            path[0],
            path[0].lerp(path[1], 0.12),
            path[0].lerp(path[1], 0.25),
        ],
        &[0.036, 0.0375, 0.037],
        24,
    );
    let mut cloth = Shape::tube(&path, &[0.034, 0.042, 0.05], 24);
    cloth.append(ring);
    cloth
}

fn letter(set: &mut Set, fonts: &Fonts) {
    let here = facing(&Target::LETTER, 2.0);
    let paper = set.printed("letter", &letter_canvas(fonts), false, 0.85);
    let oak = set.covered("easel wood", true, 0.5);
    set.add("letter", Shape::picture(0.148, 0.21).moved(here), paper);
    let board = Shape::rounded_box(Vec3::new(0.168, 0.228, 0.008), 0.003, 0.06).uv_turned();
    let ledge = Shape::rounded_box(Vec3::new(0.176, 0.01, 0.024), 0.003, 0.06);
    set.add(
        "easel",
        Shape::joined([board.at(0.0, 0.0, -0.0046), ledge.at(0.0, -0.111, 0.008)]).moved(here),
        oak,
    );
    for side in [-0.065, 0.065] {
        let foot = here.transform_point3(Vec3::new(side, -0.1, -0.012));
        let end = Vec3::new(foot.x, TOP_M + 0.006, foot.z + 0.01);
        let leg = Shape::tube(&[foot, foot.lerp(end, 0.5), end], &[0.006; 3], 10);
        set.add("easel leg", leg, oak);
    }
    let top = here.transform_point3(Vec3::new(0.0, 0.06, -0.012));
    let end = Vec3::new(top.x + 0.02, TOP_M + 0.006, top.z - 0.1);
    set.add(
        "easel leg",
        Shape::tube(&[top, top.lerp(end, 0.5), end], &[0.006; 3], 10),
        oak,
    );
}

fn vase(set: &mut Set) {
    let glaze = set.plain("vase glaze", 0x2f6f8f, 0.2);
    let profile = [
        (0.0, 0.0),
        (0.026, 0.0),
        (0.03, 0.004),
        (0.041, 0.03),
        (0.046, 0.058),
        (0.042, 0.088),
        (0.027, 0.115),
        (0.019, 0.132),
        (0.02, 0.146),
        (0.027, 0.158),
        (0.024, 0.159),
        (0.017, 0.146),
        (0.016, 0.125),
        (0.0, 0.12),
    ];
    let leaf = set.plain("leaves", 0xffffff, 0.55);
    let leaf = set.double_sided(leaf);
    let petal = set.plain("petals", 0xffffff, 0.6);
    let petal = set.double_sided(petal);
    let (green, blossom) = bouquet();
    let group: Group = vec![
        ("vase", Shape::lathe(&profile, 36), glaze),
        ("leaves", green, leaf),
        ("blossoms", blossom, petal),
    ];
    let foot = Target::VASE.point_m();
    let by = Affine3A::from_translation(Vec3::new(foot.x * 1.04, TOP_M, foot.z * 1.04));
    set.add_at_target(group, by, &Target::VASE);
}

/// Stems with leaves, and daisies at their ends, above the vase's mouth.
fn bouquet() -> (Shape, Shape) {
    let (mut green, mut blossom) = (Shape::default(), Shape::default());
    for stem in 0..9u8 {
        let k = f32::from(stem);
        let angle = 2.4 * k;
        let lean = 0.012 + 0.0115 * k;
        let out = Vec3::new(angle.sin(), 0.0, angle.cos());
        let root = Vec3::Y * 0.13 + out * 0.008;
        let end = Vec3::Y * (0.345 - 0.014 * k) + out * lean * 0.75;
        let middle = root.lerp(end, 0.55) + out * 0.2 * lean;
        green.append(
            Shape::tube(&[root, middle, end], &[0.0018, 0.0016, 0.0014], 6)
                .tinted(linear(0x4f7d3a)),
        );
        for side in 0..2u8 {
            let turn = Quat::from_rotation_y(angle + 1.3 + 2.9 * f32::from(side))
                * Quat::from_rotation_x(0.7);
            let tint = mix(
                linear(0x3c6e34),
                linear(0x86a957),
                f32::from((stem + side) % 4) / 3.0,
            );
            let start = root.lerp(end, 0.45 + 0.25 * f32::from(side));
            let blade = Shape::blade(0.055, 0.02, 0.8, 0.8)
                .turned(turn)
                .tinted(tint);
            green.append(blade.at(start.x, start.y, start.z));
        }
        let aim = Quat::from_rotation_arc(
            Vec3::Y,
            (Vec3::Y * 0.55 + out * 0.6 + Vec3::Z * 0.65).normalize(),
        );
        let tint = [0xf7f3ea, 0xf2c14e, 0xe8795a][usize::from(stem % 3)];
        for leaf in 0..10u8 {
            let turn =
                Quat::from_rotation_y(TAU * f32::from(leaf) / 10.0) * Quat::from_rotation_x(1.25);
            let one = Shape::blade(0.024, 0.0105, 0.35, 1.3)
                .turned(aim * turn)
                .tinted(linear(tint));
            blossom.append(one.at(end.x, end.y, end.z));
        }
        let heart = Shape::ellipsoid(Vec3::new(0.0065, 0.004, 0.0065), 10).turned(aim);
        let up = end + aim * (Vec3::Y * 0.0035);
        blossom.append(heart.tinted(linear(0xb9791f)).at(up.x, up.y, up.z));
    }
    (green, blossom)
}

fn mug(set: &mut Set) {
    let stripe = Canvas::shaded(64, 128, |_, v| {
        let band = (0.62..0.7).contains(&v) || (0.72..0.74).contains(&v);
        let color = if band { 0xf5ead2 } else { 0xc2452d };
        hex(color)
    });
    let glaze = set.printed("mug", &stripe, false, 0.25);
    let profile = [
        (0.0, 0.0),
        (0.033, 0.0),
        (0.037, 0.004),
        (0.0385, 0.03),
        (0.0385, 0.09),
        (0.0375, 0.094),
        (0.0355, 0.093),
        (0.035, 0.03),
        (0.033, 0.012),
        (0.0, 0.012),
    ];
    let arc: Vec<Vec3> = (0..=10u8)
        .map(|i| {
            let angle = PI * (f32::from(i) / 10.0 - 0.5);
            Vec3::new(0.036 + 0.024 * angle.cos(), 0.05 + 0.028 * angle.sin(), 0.0)
        })
        .collect();
    let coffee = set.plain("coffee", 0x2a160c, 0.1);
    let surface = Shape::lathe(&[(0.0354, 0.08), (0.0, 0.0801)], 32);
    let body = Shape::joined([
        Shape::lathe(&profile, 40),
        Shape::tube(&arc, &[0.0052; 11], 12),
    ]);
    let group: Group = vec![("mug", body, glaze), ("coffee", surface, coffee)];
    let foot = Target::MUG.point_m();
    let turn = Quat::from_rotation_y(-1.0);
    let by =
        Affine3A::from_rotation_translation(turn, Vec3::new(foot.x * 1.04, TOP_M, foot.z * 1.04));
    set.add_at_target(group, by, &Target::MUG);
}

fn clock(set: &mut Set, fonts: &Fonts) {
    let brass = set.metal("brass", 0xc79a4b, 0.3);
    let dial = set.printed("dial", &dial_canvas(fonts), false, 0.5);
    let wood = set.covered("clock wood", true, 0.35);
    let case_profile = [
        (0.0, -0.022),
        (0.04, -0.022),
        (0.043, -0.018),
        (0.043, 0.004),
        (0.0405, 0.008),
        (0.0385, 0.004),
        (0.0, 0.004),
    ];
    let case = Shape::lathe(&case_profile, 44)
        .turned(Quat::from_rotation_x(FRAC_PI_2))
        .at(0.0, 0.072, 0.0);
    let face = disc(0.0385, 40).at(0.0, 0.072, 0.0045);
    let base = Shape::joined([
        Shape::rounded_box(Vec3::new(0.085, 0.014, 0.04), 0.004, 0.05).at(0.0, 0.007, -0.008),
        Shape::rounded_box(Vec3::new(0.06, 0.024, 0.03), 0.006, 0.05).at(0.0, 0.024, -0.008),
    ]);
    let knob = Shape::joined([
        Shape::ellipsoid(Vec3::splat(0.006), 12).at(0.0, 0.12, -0.008),
        Shape::lathe(&[(0.004, 0.11), (0.003, 0.12)], 10).at(0.0, 0.0, -0.008),
    ]);
    let group: Group = vec![
        ("clock case", case, brass),
        ("clock dial", face, dial),
        ("clock base", base, wood),
        ("clock knob", knob, brass),
    ];
    let foot = Target::CLOCK.point_m();
    let turn = Quat::from_rotation_y(-Target::CLOCK.azimuth_deg.to_radians());
    let by = Affine3A::from_rotation_translation(turn, Vec3::new(foot.x, TOP_M, foot.z));
    set.add_at_target(group, by, &Target::CLOCK);
}

/// A round picture facing +z.
fn disc(radius: f32, sides: u32) -> Shape {
    let mut shape =
        Shape::lathe(&[(radius, 0.0), (0.0, 0.0)], sides).turned(Quat::from_rotation_x(FRAC_PI_2));
    for (uv, p) in shape.uvs.iter_mut().zip(&shape.positions) {
        *uv = glam::Vec2::new(0.5 + 0.5 * p.x / radius, 0.5 - 0.5 * p.y / radius);
    }
    shape.normals.fill(Vec3::Z);
    shape
}

fn small_things(set: &mut Set) {
    let peel = set.plain("orange", 0xe8832a, 0.55);
    set.add(
        "orange",
        Shape::ellipsoid(Vec3::new(0.036, 0.034, 0.036), 22).at(0.035, TOP_M + 0.034, -0.74),
        peel,
    );
    set.add(
        "orange",
        Shape::ellipsoid(Vec3::new(0.034, 0.033, 0.034), 22).at(-0.035, TOP_M + 0.033, -0.715),
        peel,
    );
    let stem = set.plain("stem", 0x4d6b2f, 0.8);
    set.add(
        "stem",
        Shape::ellipsoid(Vec3::new(0.004, 0.003, 0.004), 8).at(0.035, TOP_M + 0.068, -0.74),
        stem,
    );
    let yellow = set.plain("pencil", 0xe0b23a, 0.4);
    let graphite = set.plain("pencil tip", 0x3a2f28, 0.6);
    let lead = Vec3::new(0.055, TOP_M + 0.0042, -0.86);
    let tail = Vec3::new(-0.115, TOP_M + 0.0042, -0.80);
    let neck = lead.lerp(tail, 0.08);
    set.add(
        "pencil",
        Shape::tube(&[neck, neck.lerp(tail, 0.5), tail], &[0.0038; 3], 6),
        yellow,
    );
    set.add(
        "pencil tip",
        Shape::tube(
            &[lead, lead.lerp(neck, 0.5), neck],
            &[0.0006, 0.002, 0.0036],
            6,
        ),
        graphite,
    );
    let covers = [(0x7a2f3a, 0.034, 0.0), (0xd8c9a4, 0.026, 0.12)];
    let mut y = TOP_M;
    for (cover, thick, turn) in covers {
        let cloth = set.plain("book", cover, 0.7);
        let body = Shape::rounded_box(Vec3::new(0.15, thick, 0.21), 0.003, 0.1);
        let placed = body
            .turned(Quat::from_rotation_y(turn))
            .at(0.36, y + thick / 2.0, -1.08);
        set.add("book on desk", placed, cloth);
        y += thick;
    }
}
