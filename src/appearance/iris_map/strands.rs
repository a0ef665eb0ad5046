//! Lays the strands of the stroma, layer by layer, from the deep to the superficial.
//!
//! In: a [`Layout`]. Out: a [`Canvas`] of relative relief (1 = the highest trabeculae) and strand
//! tags.

use super::IrisMapSettings;
use super::canvas::{self, Canvas, Grid, Strand, blur};
use super::layout::{Crypt, Layout};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{HashStream, fbm, lerp, value_noise, wrap_half};

/// Grows all layers.
pub(super) fn grow(settings: &IrisMapSettings, layout: &Layout, grid: Grid) -> Canvas {
    let mut deep = Canvas::new(grid, 0.0);
    deep_layer(&mut deep, settings, layout);
    let mut upper = Canvas::new(grid, 0.0);
    middle_layer(&mut upper, settings, layout);
    trabeculae(&mut upper, settings, layout);
    pupillary_zone(&mut upper, settings, layout);
    let mut surface = settle(deep, upper, settings, layout);
    collarette(&mut surface, settings, layout);
    bridges(&mut surface, settings, layout);
    canvas::soften(&mut surface.relief, grid);
    surface
}

/// Moves a strand at `u` out of the openings; `give` 0 leaves it, 1 takes it all the way.
fn pushed(u: f32, v: f32, crypts: &[Crypt], give: f32) -> f32 {
    let mut u = u;
    for crypt in crypts {
        if (v - crypt.v).abs() >= crypt.half_length {
            continue;
        }
        let away = wrap_half(u - crypt.axis(v));
        let side = if away < 0.0 { -1.0 } else { 1.0 };
        let reach = crypt.reach(v, side) * give;
        let room = 3.2 * reach + 1e-6;
        if away.abs() < room {
            u += side * reach * (1.0 - away.abs() / room);
        }
    }
    u
}

fn deep_layer(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 10);
    let grid = canvas.grid;
    canvas.relief = canvas::slow_field(grid, |u, v| {
        0.085 + 0.05 * fbm(u * 40.0, v * 7.0, [40, 0], 2, settings.seed ^ 0x41)
    });
    for _ in 0..settings.fibre_count * 2 {
        let a = dice.unit();
        let start = dice.range(0.2, 0.75);
        let strand = Strand {
            v: [start, start + dice.range(0.2, 0.6)],
            half_width_mm: dice.range(0.010, 0.026),
            crest: dice.range(0.14, 0.34),
            taper: [0.06, 0.08],
            tag: dice.unit(),
            seed: dice.next_u32(),
        };
        let shift = 0.31 + dice.range(-0.004, 0.004);
        canvas.lay(&strand, |v| layout.ciliary_path(a + shift, v) - shift);
    }
}

fn middle_layer(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 11);
    let count = settings.fibre_count;
    for number in 0..count * 3 {
        let a = (number as f32 / 3.0 + dice.range(-0.9, 0.9)) / count as f32;
        let rim = layout.collarette(layout.ciliary_path(a, 0.36));
        let whole = dice.unit() < 0.45;
        let start = if whole {
            rim - dice.range(0.0, 0.03)
        } else {
            lerp(rim, 0.9, dice.unit())
        };
        let end = if whole {
            1.02
        } else {
            (start + dice.range(0.15, 0.5)).min(1.02)
        };
        let strand = Strand {
            v: [start, end],
            half_width_mm: lerp(0.010, 0.030, dice.unit() * dice.unit()),
            crest: dice.range(0.30, 0.92),
            taper: [0.05, 0.09],
            tag: dice.unit(),
            seed: dice.next_u32(),
        };
        let crypts = layout.crypts_near(a);
        let (give, own) = (dice.range(0.9, 1.35), dice.range(0.0002, 0.0012));
        canvas.lay(&strand, |v| {
            let wander = own * value_noise(v * 8.0 + 3.0, 0, strand.seed);
            pushed(layout.ciliary_path(a, v) + wander, v, &crypts, give)
        });
    }
}

/// The stout superficial bundles: each a few strands that part at one or both ends.
fn trabeculae(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 12);
    let count = settings.fibre_count / 4;
    for number in 0..count {
        let a = (number as f32 + dice.range(-0.6, 0.6)) / count as f32;
        let rim = layout.collarette(layout.ciliary_path(a, 0.36));
        let stem = dice.range(0.40, 0.8);
        let fork = dice.range(0.35, 1.0) / count as f32;
        let (inward, long) = (dice.unit() < 0.65, dice.unit() < 0.7);
        let branches = 2 + dice.next_u32() % 2;
        let height = dice.range(0.74, 1.0);
        for branch in 0..branches {
            let side = (branch as f32 - 0.5 * (branches - 1) as f32) * dice.range(0.6, 1.3);
            let outer = if long {
                1.02
            } else {
                stem + dice.range(0.1, 0.3)
            };
            let strand = Strand {
                v: [rim - dice.range(0.0, 0.025), outer],
                half_width_mm: dice.range(0.014, 0.038),
                crest: height * dice.range(0.9, 1.05),
                taper: [0.03, 0.12],
                tag: dice.unit(),
                seed: dice.next_u32(),
            };
            let crypts = layout.crypts_near(a);
            let give = dice.range(1.0, 1.25);
            canvas.lay(&strand, |v| {
                let past = if inward { stem - v } else { v - stem };
                let spread = side * fork * smoothstep(-0.02, 0.3, past);
                let wander = 0.0011 * value_noise(v * 7.0, 0, strand.seed);
                pushed(
                    layout.ciliary_path(a, v) + spread + wander,
                    v,
                    &crypts,
                    give,
                )
            });
        }
    }
}

fn pupillary_zone(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 13);
    let count = settings.fibre_count * 2;
    for number in 0..count {
        let a = (number as f32 + dice.range(-0.8, 0.8)) / count as f32;
        let rim = layout.collarette(a);
        let whole = dice.unit() < 0.6;
        let start = if whole {
            0.0
        } else {
            rim * dice.range(0.1, 0.7)
        };
        let end = if dice.unit() < 0.75 {
            rim + dice.range(0.0, 0.04)
        } else {
            rim * dice.range(0.5, 0.95)
        };
        let strand = Strand {
            v: [start.min(end), end],
            half_width_mm: dice.range(0.008, 0.020),
            crest: dice.range(0.30, 0.92),
            taper: [0.04, 0.03],
            tag: dice.unit(),
            seed: dice.next_u32(),
        };
        let crypts = layout.crypts_near(a);
        canvas.lay(&strand, |v| {
            let wander = 0.0009 * value_noise(v * 11.0, 0, strand.seed);
            pushed(layout.pupillary_path(a, v) + wander, v, &crypts, 1.1)
        });
    }
}

/// Lets the layers sink into their ground substance: dense where strands crowd, open where they
/// part, absent in crypts.
fn settle(deep: Canvas, upper: Canvas, settings: &IrisMapSettings, layout: &Layout) -> Canvas {
    let grid = deep.grid;
    let mut ground = upper.relief.clone();
    blur(&mut ground, grid, 0.14, 0.10);
    let seed = settings.seed ^ 0x51;
    let thinness = canvas::slow_field(grid, |u, v| {
        0.5 + 0.5 * fbm(u * 22.0, v * 4.0, [22, 0], 3, seed)
    });
    // Whole sectors are built stouter or leaner than others.
    let build = canvas::slow_field(grid, |u, v| {
        1.0 + 0.34 * fbm(u * 6.0, v * 2.2, [6, 0], 4, seed ^ 3)
    });
    // A lacunar stroma has less ground between its strands.
    let fill = 0.94 - 0.30 * settings.crypt_density;
    let mut surface = upper;
    for row in 0..grid.height {
        let v = grid.v(row);
        for column in 0..grid.width {
            let index = row * grid.width + column;
            let u = grid.u(column);
            let thin = thinness[index];
            let fine = fbm(u * 260.0, v * 30.0, [260, 0], 2, seed ^ 2);
            // Towards the root the ground thickens and the strands drown in it.
            let dense = lerp(thin, 1.0, 0.5 * smoothstep(0.55, 0.95, v));
            let rim = (v - layout.collarette(u) - 0.012) / 0.028;
            let ridge = 0.22 * (0.35 + thin) * (-rim * rim).exp();
            let bed = fill * ground[index] * lerp(0.60, 1.0, dense) + 0.04 * fine + ridge;
            let open = layout.crypt[index];
            let bed = lerp(bed, 0.0, open);
            // A strand that still crosses an opening is a deep one there.
            let strand = surface.relief[index] * (1.0 - 0.55 * open);
            let top = (strand.max(bed) * build[index]).max(deep.relief[index]);
            if top > strand + 0.02 && open > 0.5 {
                surface.tag[index] = deep.tag[index];
            }
            surface.relief[index] = top;
        }
    }
    surface
}

/// The collarette: a braid of short arcs along the zig-zag, thick in places, gone in others.
fn collarette(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 14);
    for ply in 0..8 {
        let seed = dice.next_u32();
        let (tag, offset) = (dice.unit(), 0.014 * dice.normal());
        let (crest, girth) = (dice.range(0.64, 0.92), dice.range(0.011, 0.028));
        let teeth = 19 + dice.next_u32() % 48;
        let stretch = if ply < 3 { 1.0 } else { dice.range(0.4, 1.7) };
        canvas.lay_ring(
            tag,
            |u| {
                let slide = 0.004 * value_noise(u * 19.0, 19, seed ^ 3);
                let ring = layout.collarette(u + slide);
                let mean = settings.collarette_radius;
                mean + (ring - mean) * stretch
                    + offset
                    + 0.020 * value_noise(u * teeth as f32, teeth, seed)
                    + 0.005 * value_noise(u * 140.0, 140, seed ^ 1)
            },
            |u| {
                let whole = value_noise(u * 6.0, 6, seed ^ 4);
                let part = smoothstep(-0.1, 0.7, value_noise(u * 34.0, 34, seed ^ 2) + 0.7 * whole);
                (crest * (0.5 + 0.5 * part), girth * part)
            },
        );
    }
}

/// Single fine strands that cross over openings and over other strands.
fn bridges(canvas: &mut Canvas, settings: &IrisMapSettings, layout: &Layout) {
    let mut dice = HashStream::new(settings.seed, 15);
    for _ in 0..settings.fibre_count / 3 {
        let a = dice.unit();
        let start = dice.range(0.3, 0.85);
        let length = dice.range(0.08, 0.25);
        let strand = Strand {
            v: [start, start + length],
            half_width_mm: dice.range(0.008, 0.018),
            crest: dice.range(0.5, 0.95),
            taper: [0.03, 0.03],
            tag: dice.unit(),
            seed: dice.next_u32(),
        };
        let slant = 0.010 * dice.normal();
        canvas.lay(&strand, |v| {
            let t = (v - start) / length - 0.5;
            layout.ciliary_path(a, v) + slant * t + 0.002 * value_noise(v * 9.0, 0, strand.seed)
        });
    }
}
