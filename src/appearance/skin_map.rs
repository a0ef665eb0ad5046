//! Fine structure of skin as one tile that repeats: slope, and noise for blood and pigment.
//!
//! Leaves: RGBA texels, r and g the slope of the surface along x and y, b broad and a
//! fine noise, each about zero. Baked once: the picture then pays for two look-ups
//! where noise would cost hundreds of operations a pixel.

use crate::tissue::noise::{fbm, gradient_noise, worley};

/// Texels along a side.
pub const SIDE: usize = 256;
/// No number of it is further from zero.
pub const RANGE: f32 = 1.0;
/// What a side spans, mm.
pub const TILE_MM: f32 = 16.0;

/// Height of the skin, mm, at a place of the tile in texels.
fn height_mm(x: f32, y: f32, seed: u32) -> f32 {
    let s = 1.0 / SIDE as f32;
    let (u, v) = (x * s, y * s);
    // Polygons between the primary lines, half a millimetre wide and flattened along the lid.
    let plates = worley(u * 28.0, v * 38.0, [28, 38], seed);
    let lines = (plates.second - plates.nearest).clamp(0.0, 0.30) / 0.30;
    let fine = gradient_noise(u * 64.0, v * 86.0, [64, 86], seed ^ 0x51);
    let soft = gradient_noise(u * 9.0, v * 13.0, [9, 13], seed ^ 0x52);
    // Pores: small pits scattered over the plates.
    let pores = worley(u * 20.0, v * 20.0, [20, 20], seed ^ 0x53);
    let pit = if pores.id < 0.45 {
        (1.0 - pores.nearest / 0.13).max(0.0)
    } else {
        0.0
    };
    0.021 * lines + 0.007 * fine + 0.022 * soft - 0.022 * pit * pit
}

/// The tile, row by row.
pub fn skin_tile(seed: u32) -> Vec<[f32; 4]> {
    let heights: Vec<f32> = (0..SIDE * SIDE)
        .map(|i| height_mm((i % SIDE) as f32, (i / SIDE) as f32, seed))
        .collect();
    let at = |x: usize, y: usize| heights[(y % SIDE) * SIDE + x % SIDE];
    let per_mm = SIDE as f32 / TILE_MM * 0.5;
    (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = (i % SIDE, i / SIDE);
            let (u, v) = (x as f32 / SIDE as f32, y as f32 / SIDE as f32);
            [
                (at(x + 1, y) - at(x + SIDE - 1, y)) * per_mm,
                (at(x, y + 1) - at(x, y + SIDE - 1)) * per_mm,
                fbm(u * 4.0, v * 4.0, [4, 4], 4, seed ^ 0x54),
                fbm(u * 27.0, v * 27.0, [27, 27], 2, seed ^ 0x55),
            ]
        })
        .collect()
}

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
