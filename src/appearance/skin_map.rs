//! Fine structure of skin as one tile that repeats: slope, and noise for blood and pigment.
//!
//! Leaves: RGBA texels, r and g the slope of the surface along x and y, b broad and a
//! fine noise, each about zero. Baked once: the picture then pays for two look-ups
//! where noise would cost hundreds of operations a pixel.
//!
//! **What it is made of** (photographs show a net of cells of 0.35 to 0.7 mm): a net of lines, deeper here and shallower there,
//! and a finer one; a grain whose slopes sparkle one by one where they face a lamp; pores. Lines and pores are also darker, as light
//! that enters them comes out less.

use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{fbm, gradient_noise, worley};

/// Texels along a side.
pub const SIDE: usize = 512;
/// No number of it is further from zero.
pub const RANGE: f32 = 1.0;
/// What a side spans, mm.
pub const TILE_MM: f32 = 16.0;

/// A place of the tile (0 to 1 along each side), moved aside a little, so that lines do not lie in rows.
fn bent(u: f32, v: f32, seed: u32) -> [f32; 2] {
    let aside = |own: u32| {
        gradient_noise(u * 6.0, v * 6.0, [6, 6], seed ^ own)
            + 0.5 * gradient_noise(u * 14.0, v * 14.0, [14, 14], seed ^ own ^ 0x1f)
    };
    [u + 0.016 * aside(0x61), v + 0.016 * aside(0x62)]
}

/// Depth of a line (0 to 1) where two cells meet, this wide in cells.
fn line(cells: [u32; 2], [u, v]: [f32; 2], width: f32, seed: u32) -> f32 {
    let [columns, rows] = cells;
    let found = worley(u * columns as f32, v * rows as f32, cells, seed);
    let across = ((found.second - found.nearest) / width).min(1.0);
    (1.0 - across) * (1.0 - across)
}

/// What a place of the skin is: its height, mm, and how much of a line or pore it is.
fn skin_place(u: f32, v: f32, seed: u32) -> (f32, f32) {
    let at = bent(u, v, seed);
    let [s, t] = at;
    // Lines are deeper here and shallower there.
    let deep = 1.0 + 0.9 * gradient_noise(u * 7.0, v * 7.0, [7, 7], seed ^ 0x56);
    let primary = line([35, 46], at, 0.62, seed) * deep;
    let secondary = line([70, 84], at, 0.7, seed ^ 0x57) * (2.0 - deep);
    let grain = gradient_noise(s * 96.0, t * 104.0, [96, 104], seed ^ 0x51);
    let bump = gradient_noise(s * 46.0, t * 50.0, [46, 50], seed ^ 0x58);
    let soft = gradient_noise(u * 9.0, v * 13.0, [9, 13], seed ^ 0x52);
    let pores = worley(u * 17.0, v * 17.0, [17, 17], seed ^ 0x53);
    // One place in two has a pore, of a size of its own.
    let wide = 0.07 + 0.10 * pores.id;
    let pit = if pores.id < 0.55 {
        smoothstep(wide, 0.2 * wide, pores.nearest)
    } else {
        0.0
    };
    let height =
        -0.018 * primary - 0.008 * secondary + 0.0035 * grain + 0.007 * bump + 0.016 * soft
            - 0.022 * pit;
    (height, 0.4 * primary + 0.25 * secondary + 0.9 * pit)
}

/// The tile, row by row.
pub fn skin_tile(seed: u32) -> Vec<[f32; 4]> {
    let share = |i: usize| (i % SIDE) as f32 / SIDE as f32;
    let places: Vec<(f32, f32)> = (0..SIDE * SIDE)
        .map(|i| skin_place(share(i), share(i / SIDE), seed))
        .collect();
    let hollow = places.iter().map(|place| place.1).sum::<f32>() / places.len() as f32;
    let at = |x: usize, y: usize| places[(y % SIDE) * SIDE + x % SIDE].0;
    let per_mm = SIDE as f32 / TILE_MM * 0.5;
    (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = (i % SIDE, i / SIDE);
            let (u, v) = (share(i), share(i / SIDE));
            [
                (at(x + 1, y) - at(x + SIDE - 1, y)) * per_mm,
                (at(x, y + 1) - at(x, y + SIDE - 1)) * per_mm,
                fbm(u * 4.0, v * 4.0, [4, 4], 4, seed ^ 0x54),
                0.6 * fbm(u * 27.0, v * 27.0, [27, 27], 2, seed ^ 0x55)
                    + HOLLOW_DARK * (places[i].1 - hollow),
            ]
        })
        .collect()
}

/// How much darker a line or a pore is, as the fine noise has it (a choice).
const HOLLOW_DARK: f32 = 0.4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_numbers_stay_within_their_range() {
        for seed in 0..24 {
            let numbers = skin_tile(seed);
            let largest = [0, 1, 2, 3].map(|channel| {
                numbers
                    .iter()
                    .map(|texel| texel[channel].abs())
                    .fold(0.0, f32::max)
            });
            println!("{seed}: {largest:?}");
            assert!(
                largest.into_iter().all(|number| number < RANGE),
                "{largest:?}"
            );
        }
    }

    #[test]
    fn the_tile_repeats_and_is_about_level() {
        let tile = skin_tile(7);
        let mut mean = [0.0f64; 4];
        for texel in &tile {
            for (sum, value) in mean.iter_mut().zip(texel) {
                assert!(value.is_finite());
                *sum += f64::from(*value) / tile.len() as f64;
            }
        }
        // Slopes of a repeating surface cancel to rounding; the noises are centred within a tenth.
        assert!(mean[0].abs() < 1e-4 && mean[1].abs() < 1e-4, "{mean:?}");
        assert!(mean[2].abs() < 0.1 && mean[3].abs() < 0.1, "{mean:?}");
        // Across the seam the slope is no steeper than inside.
        let seam = (0..SIDE)
            .map(|y| tile[y * SIDE][0].abs())
            .fold(0.0, f32::max);
        let inner = (0..SIDE)
            .map(|y| tile[y * SIDE + SIDE / 3][0].abs())
            .fold(0.0, f32::max);
        assert!(seam < 2.0 * inner, "{seam} {inner}");
    }
}
