//! The grounds of the built-in scenes' pictures: wood, cloth, paint, sky, leaves.
//!
//! Enters: a material's name. Leaves: what is drawn below its baked picture, or in its place. Noise does
//! not compress: as PNG these would be 1.9 MB; these lines draw them in 0.15 s.

use super::super::paint::{
    Canvas, Clouds, ValueNoise, hex, mix, plaster, smoothstep, unit_hash, weave, wood,
};

/// The ground of a material of the built-in scenes; `None` where the baked picture is all.
pub fn ground(material: &str) -> Option<Canvas> {
    Some(match material {
        "floor" => wood(0xb98555, 0x8a5a35, 6, 11),
        "walnut" => wood(0xa8703f, 0x6b4023, 3, 5),
        "easel wood" => wood(0xd0a46e, 0xa9773f, 1, 14),
        "clock wood" => wood(0x8a4f2c, 0x5a2f18, 1, 44),
        "bookcase" => wood(0x9a6a3f, 0x6e4526, 1, 61),
        "sideboard" => wood(0x9b5a35, 0x6f3b20, 1, 71),
        "door" => wood(0xc79a66, 0xa2743f, 1, 21),
        "ceiling" => plaster(0xf4efe6, 5),
        "wall, cream" => plaster(0xe9dcc4, 6),
        "paint" => plaster(0xefece2, 4),
        "curtain" => weave(0xd9a441, 0xcf9434, 8),
        "armchair" => weave(0x2f6d69, 0x3b807a, 51),
        "cushion" => weave(0xe3b04b, 0xd79a35, 52),
        "wall, green" => wallpaper(0x8fa38c, 0x9db099),
        "rug" => rug(),
        "eye chart" => Canvas::new(1200, 1728, hex(0xfbfaf4)),
        "dial" => Canvas::new(384, 384, hex(0xf7f1e1)),
        "letter" => paper(),
        "telephone screen" => screen(),
        "book spines" => spines(),
        "sky and houses" => countryside(),
        "lawn" => lawn(),
        "tree" => tree(3),
        "bush" => tree(8),
        _ => return None,
    })
}

/// Paper with a quiet leaf pattern.
fn wallpaper(ground: u32, leaf: u32) -> Canvas {
    let (ground, leaf) = (hex(ground), hex(leaf));
    let shade = Clouds::new(8, 31);
    let mut canvas = Canvas::shaded(512, 512, |u, v| {
        ground.map(|c| c * (0.97 + 0.05 * shade.at(u, v)))
    });
    for row in 0..8u8 {
        for column in 0..8u8 {
            let shift = if row % 2 == 0 { 0.0 } else { 32.0 };
            let (x, y) = (
                f32::from(column) * 64.0 + 16.0 + shift,
                f32::from(row) * 64.0 + 32.0,
            );
            canvas.line([x, y + 22.0], [x, y - 16.0], 1.6, leaf, 0.9);
            for side in [-1.0, 1.0] {
                for step in 0..3u8 {
                    let rise = f32::from(step) * 11.0 - 8.0;
                    canvas.ellipse([x + side * 7.5, y - rise], [6.5, 2.8], leaf, 0.75, 0.3);
                }
            }
        }
    }
    canvas
}

/// Lozenges and a border, in wool.
fn rug() -> Canvas {
    let [red, blue, sand] = [hex(0x9c3b2e), hex(0x2f4a63), hex(0xe2c89a)];
    let (pile, worn) = (ValueNoise::new(256, 77), Clouds::new(5, 3));
    Canvas::shaded(512, 512, |u, v| {
        let edge = u.min(1.0 - u).min(v.min(1.0 - v));
        let (x, y) = ((u * 12.0).fract() - 0.5, (v * 12.0).fract() - 0.5);
        let lozenge = x.abs() + y.abs();
        let field = if lozenge < 0.16 {
            sand
        } else if lozenge < 0.3 {
            blue
        } else {
            red
        };
        let border = if (u * 40.0 + v * 40.0).fract() < 0.5 {
            blue
        } else {
            sand
        };
        let color = if edge < 0.02 || (0.085..0.1).contains(&edge) {
            sand
        } else if edge < 0.085 {
            border
        } else {
            field
        };
        let pile = 0.82 + 0.3 * pile.at(u * 256.0, v * 256.0);
        mix(color, color.map(|c| c * 0.8), worn.at(u, v)).map(|c| c * pile)
    })
}

/// Writing paper.
fn paper() -> Canvas {
    let pulp = ValueNoise::new(9, 2);
    Canvas::shaded(888, 1260, |u, v| {
        hex(0xfaf6ea).map(|c| c * (0.985 + 0.02 * pulp.at(u * 9.0, v * 9.0)))
    })
}

/// A telephone's screen with the bar of a program.
fn screen() -> Canvas {
    let (light, dim) = (hex(0xfdfdfb), hex(0xf0f3f6));
    let mut canvas = Canvas::shaded(592, 1232, |_, v| mix(light, dim, v));
    canvas.rect(0.0, 0.0, 592.0, 150.0, hex(0x1f6f78));
    canvas
}

/// Sixteen spines bound in cloth, lying one above the other.
fn spines() -> Canvas {
    let cloth = [
        0x7b2d26, 0x1f4e5f, 0xd9a441, 0x2e2f45, 0x3f6b4f, 0xb5533c, 0xe6dcc3, 0x6a4c7d, 0x34688f,
        0x111820, 0xc98a5e, 0x8c9a5b, 0x264653, 0x9c4f6b, 0x88b0a8, 0x5b3a29,
    ];
    let worn = Clouds::new(32, 7);
    Canvas::shaded(512, 1024, |u, v| {
        let row = (v * 16.0) as usize % 16;
        let across = (v * 16.0).fract();
        let round = 0.72 + 0.42 * (1.0 - (2.0 * across - 1.0).powi(2)).sqrt();
        let worn = 0.94 + 0.1 * worn.at(u, v);
        hex(cloth[row]).map(|c| (c * round * worn).min(1.0))
    })
}

/// Sky with clouds over hills; the horizon is at the middle.
fn countryside() -> Canvas {
    let [meadow, wood, sky] = [(40, 6), (30, 5), (5, 12)].map(|(p, seed)| Clouds::new(p, seed));
    Canvas::shaded(1024, 768, |u, v| {
        let height = (0.5 - v) * 2.0;
        let hill = 0.03 + 0.035 * (u * 9.0).sin() + 0.02 * (u * 23.0 + 1.0).sin();
        if height < -0.035 {
            mix(hex(0x6f9a4f), hex(0x93b565), meadow.at(u, v))
        } else if height < hill + 0.06 {
            mix(hex(0x9db7a0), hex(0x7e9f86), wood.at(u, v))
        } else {
            let clear = mix(hex(0xe8eef0), hex(0x86b4e2), smoothstep(-0.05, 0.6, height));
            let cloud = smoothstep(0.52, 0.72, sky.at(u * 0.9 + 0.05, v * 2.2));
            mix(clear, [1.0, 0.99, 0.97], 0.85 * cloud)
        }
    })
}

/// Mown grass with a path.
fn lawn() -> Canvas {
    let grass = Clouds::new(9, 40);
    Canvas::shaded(256, 256, |u, v| {
        let stripe = if (v * 14.0).fract() < 0.5 { 0.06 } else { 0.0 };
        let path = smoothstep(0.05, 0.03, (u - 0.53 - 0.06 * (v * 7.0).sin()).abs());
        let lawn = mix(hex(0x5e8f3a), hex(0x8fb558), grass.at(u, v) + stripe);
        mix(lawn, hex(0xcdb992), path)
    })
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
        let angle = std::f32::consts::TAU * unit_hash(i, 0, seed);
        let reach = unit_hash(i, 1, seed).sqrt();
        let (x, y) = (
            256.0 + 205.0 * reach * angle.cos(),
            245.0 + 200.0 * reach * angle.sin(),
        );
        let lit = (0.5 - 0.35 * reach * angle.sin() - 0.2 * reach * angle.cos()).clamp(0.0, 1.0);
        let depth = (0.25 + 0.75 * t) * lit;
        let color = mix(
            hex(0x2f5427),
            hex(0xa8c65c),
            (1.1 * depth + 0.12 * unit_hash(i, 2, seed)).min(1.0),
        );
        let size = 6.0 + 11.0 * unit_hash(i, 3, seed);
        canvas.ellipse([x, y], [size, 0.7 * size], color, 1.0, 0.08);
    }
    canvas
}
