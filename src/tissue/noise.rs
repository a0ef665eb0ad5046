//! Seeded, repeatable noise for procedural tissue, and for whatever else is not smooth.
//!
//! In: coordinates, a seed and, where the result has to wrap, a period in lattice cells.
//! Out: numbers in a documented range, the same on every machine that keeps IEEE `f32`.
//!
//! The integer hash is the PCG permutation RXS-M-XS on 32 bits (M. O'Neill, "PCG: a family of
//! simple fast space-efficient statistically good algorithms for random number generation",
//! 2014; recommended as a hash by Jarzynski and Olano, JCGT 9(3), 2020). Gradient noise follows
//! K. Perlin, "Improving noise", 2002 (quintic fade); cellular noise follows S. Worley, "A
//! cellular texture basis function", 1996.

/// Hashes 32 bits to 32 well-mixed bits.
#[must_use]
pub const fn pcg_hash(input: u32) -> u32 {
    let state = input.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Hashes a lattice point and a seed.
#[must_use]
pub const fn hash2(x: i32, y: i32, seed: u32) -> u32 {
    hash_in_row(x, row_hash(y, pcg_hash(seed)))
}

/// Maps a hash to `[0, 1)`, using its upper 24 bits, which an `f32` holds exactly.
#[must_use]
pub const fn unit_f32(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A number in `[0, 1)` of a lattice point and a seed.
#[must_use]
pub const fn unit_hash(x: i32, y: i32, seed: u32) -> f32 {
    unit_f32(hash2(x, y, seed))
}

/// Linear interpolation from `a` (at `t = 0`) to `b` (at `t = 1`).
#[must_use]
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// A stream of numbers from one seed, for placing features one after another.
#[derive(Clone, Debug)]
pub struct HashStream {
    seed: u32,
    counter: u32,
}

impl HashStream {
    /// Starts the stream number `stream` of `seed`; streams of one seed are independent.
    #[must_use]
    pub const fn new(seed: u32, stream: u32) -> Self {
        Self {
            seed: pcg_hash(seed ^ pcg_hash(stream.wrapping_add(0x9e37_79b9))),
            counter: 0,
        }
    }

    /// The next 32 bits.
    pub const fn next_u32(&mut self) -> u32 {
        self.counter = self.counter.wrapping_add(1);
        pcg_hash(self.seed ^ pcg_hash(self.counter))
    }

    /// Uniform in `[0, 1)`.
    pub const fn unit(&mut self) -> f32 {
        unit_f32(self.next_u32())
    }

    /// Uniform between `low` (included) and `high`.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        lerp(low, high, self.unit())
    }

    /// Roughly normal (sum of three uniforms), mean 0, standard deviation 1, within ±3.
    pub const fn normal(&mut self) -> f32 {
        (self.unit() + self.unit() + self.unit() - 1.5) * 2.0
    }
}

const fn wrap(cell: i32, period: u32) -> i32 {
    // A division is slow, and most cells are within the period.
    if period == 0 || (cell >= 0 && cell < period as i32) {
        cell
    } else {
        cell.rem_euclid(period as i32)
    }
}

/// The cell of a coordinate, and how far across it the coordinate is. There are millions of calls in a map, hence no `floor`, which is a
/// call of its own where a processor's oldest instructions must do.
#[inline]
fn cell_of(x: f32) -> (i32, f32) {
    let cut = x as i32;
    let cell = if cut as f32 > x {
        cut.wrapping_sub(1)
    } else {
        cut
    };
    (cell, x - cell as f32)
}

/// As [`hash2`] for all columns of a row: `row` is that of [`row_hash`].
const fn hash_in_row(x: i32, row: u32) -> u32 {
    pcg_hash((x as u32).wrapping_add(row))
}

const fn row_hash(y: i32, seed: u32) -> u32 {
    pcg_hash((y as u32).wrapping_add(seed))
}

#[inline]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Value noise on a line, in `[-1, 1]`; one lattice cell per unit of `x`; repeats after `period`
/// cells (0 = never).
#[must_use]
pub fn value_noise(x: f32, period: u32, seed: u32) -> f32 {
    let (cell, across) = cell_of(x);
    let row = row_hash(0, pcg_hash(seed));
    let at = |offset: i32| unit_f32(hash_in_row(wrap(cell + offset, period), row)) * 2.0 - 1.0;
    lerp(at(0), at(1), fade(across))
}

/// Gradient noise in the plane, in `[-1, 1]`, zero at lattice points, mean 0; `period` is the
/// number of cells after which it repeats along x and y (0 = never).
#[must_use]
pub fn gradient_noise(x: f32, y: f32, period: [u32; 2], seed: u32) -> f32 {
    const DIAGONAL: f32 = core::f32::consts::FRAC_1_SQRT_2;
    const GRADIENTS: [[f32; 2]; 8] = [
        [1.0, 0.0],
        [DIAGONAL, DIAGONAL],
        [0.0, 1.0],
        [-DIAGONAL, DIAGONAL],
        [-1.0, 0.0],
        [-DIAGONAL, -DIAGONAL],
        [0.0, -1.0],
        [DIAGONAL, -DIAGONAL],
    ];
    let ((cell_x, fx), (cell_y, fy)) = (cell_of(x), cell_of(y));
    let seed = pcg_hash(seed);
    let columns = [wrap(cell_x, period[0]), wrap(cell_x + 1, period[0])];
    let blend_x = fade(fx);
    let along = |offset_y: i32| {
        let row = row_hash(wrap(cell_y + offset_y, period[1]), seed);
        let ends = [0, 1].map(|i| {
            let [x, y] = GRADIENTS[(hash_in_row(columns[i], row) >> 29) as usize];
            x * (fx - i as f32) + y * (fy - offset_y as f32)
        });
        lerp(ends[0], ends[1], blend_x)
    };
    let value = lerp(along(0), along(1), fade(fy));
    // Unit gradients reach 1/sqrt(2) in the middle of a cell at most.
    value * core::f32::consts::SQRT_2
}

/// Fractal sum of `octaves` gradient noises, each of twice the frequency and half the amplitude
/// of the one before, scaled into `[-1, 1]`; periods as in [`gradient_noise`].
#[must_use]
pub fn fbm(x: f32, y: f32, period: [u32; 2], octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut total, mut amplitude, mut scale) = (0.0, 0.0, 1.0, 1_u32);
    for octave in 0..octaves {
        let periods = [period[0] * scale, period[1] * scale];
        let seed = pcg_hash(seed.wrapping_add(octave));
        let frequency = scale as f32;
        sum += amplitude * gradient_noise(x * frequency, y * frequency, periods, seed);
        total += amplitude;
        amplitude *= 0.5;
        scale *= 2;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Cellular noise: the distances, in cells, to the nearest and second nearest of the points
/// scattered one per cell, and a number in `[0, 1)` that names the nearest.
#[must_use]
pub fn worley(x: f32, y: f32, period: [u32; 2], seed: u32) -> Cellular {
    let ((cell_x, _), (cell_y, _)) = (cell_of(x), cell_of(y));
    let seed = pcg_hash(seed);
    let columns = [-1, 0, 1].map(|offset| wrap(cell_x + offset, period[0]));
    // Squares of distances, and the hash of the nearest.
    let (mut nearest, mut second, mut name) = (f32::MAX, f32::MAX, 0);
    for offset_y in -1..=1 {
        let row = row_hash(wrap(cell_y + offset_y, period[1]), seed);
        for (offset_x, column) in (-1..=1).zip(columns) {
            let hash = hash_in_row(column, row);
            let px = (cell_x + offset_x) as f32 + unit_f32(hash);
            let py = (cell_y + offset_y) as f32 + unit_f32(pcg_hash(hash));
            let square = (px - x) * (px - x) + (py - y) * (py - y);
            if square < nearest {
                (second, nearest, name) = (nearest, square, hash);
            } else if square < second {
                second = square;
            }
        }
    }
    Cellular {
        // A square root is rounded alike everywhere, as `hypot` is not.
        nearest: nearest.sqrt(),
        second: second.sqrt(),
        id: unit_f32(pcg_hash(name ^ 0x5bd1_e995)),
    }
}

/// What [`worley`] finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cellular {
    /// Distance to the nearest point, cells, `[0, sqrt(2)]`.
    pub nearest: f32,
    /// Distance to the second nearest point, cells.
    pub second: f32,
    /// A number in `[0, 1)` that belongs to the nearest point.
    pub id: f32,
}

/// Folds an angle fraction difference into `[-0.5, 0.5]` of a turn.
#[must_use]
pub fn wrap_half(turns: f32) -> f32 {
    turns - turns.round()
}

/// Value noise 0–1 that repeats every `period` in x and y.
#[derive(Debug, Clone)]
pub struct ValueNoise {
    period: i32,
    /// The numbers at the corners of each cell, row by row: as they are, right, below, right below.
    cells: Vec<[f32; 4]>,
}

impl ValueNoise {
    /// The noise of a seed, with `period²` cells.
    pub fn new(period: i32, seed: u32) -> Self {
        let places = (0..period).flat_map(|y| (0..period).map(move |x| (x, y)));
        let lattice: Vec<f32> = places.clone().map(|(x, y)| unit_hash(x, y, seed)).collect();
        let at = |x: i32, y: i32| lattice[((y % period) * period + x % period) as usize];
        let cells = places
            .map(|(x, y)| [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)])
            .collect();
        Self { period, cells }
    }

    /// Cells after which it repeats.
    pub fn period(&self) -> i32 {
        self.period
    }

    /// How far a coordinate is across its cell, on the quintic step, and the cell's number. There are ten million calls in a room, hence no `floor`.
    #[inline]
    fn cell(&self, place: f32) -> (f32, usize) {
        let cut = place as i32;
        let start = if cut as f32 > place { cut - 1 } else { cut };
        let across = place - start as f32;
        let number = if (0..self.period).contains(&start) {
            start
        } else {
            start.rem_euclid(self.period)
        };
        (fade(across), number as usize)
    }

    /// Its value at a place.
    #[inline]
    pub fn at(&self, x: f32, y: f32) -> f32 {
        let ((sx, column), (sy, row)) = (self.cell(x), self.cell(y));
        let [a, b, c, d] = self.cells[row * self.period as usize + column];
        let (top, bottom) = (a + (b - a) * sx, c + (d - c) * sx);
        top + (bottom - top) * sy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_the_published_permutation() {
        // Hand-evaluated from the RXS-M-XS definition with 64-bit integers.
        let oracle = |input: u64| {
            let state = (input * 747_796_405 + 2_891_336_453) & 0xffff_ffff;
            let word = (((state >> ((state >> 28) + 4)) ^ state) * 277_803_737) & 0xffff_ffff;
            (word >> 22) ^ word
        };
        for input in [0_u32, 1, 2, 77, 0xffff_ffff, 0x8000_0000] {
            assert_eq!(u64::from(pcg_hash(input)), oracle(u64::from(input)));
        }
    }

    #[test]
    fn stream_is_uniform_and_repeatable() {
        let (mut a, mut b) = (HashStream::new(7, 1), HashStream::new(7, 1));
        let mut other = HashStream::new(7, 2);
        let (mut sum, mut square, mut same) = (0.0_f64, 0.0_f64, 0);
        let count = 40_000;
        for _ in 0..count {
            let value = a.unit();
            assert!((0.0..1.0).contains(&value));
            assert_eq!(value, b.unit());
            same += u32::from(value == other.unit());
            sum += f64::from(value);
            square += f64::from(value) * f64::from(value);
        }
        let mean = sum / f64::from(count);
        // Standard error of the mean of a uniform is 0.2887/sqrt(40 000) = 0.0014; four of them.
        assert!((mean - 0.5).abs() < 0.006, "{mean}");
        let variance = square / f64::from(count) - mean * mean;
        assert!((variance - 1.0 / 12.0).abs() < 0.002, "{variance}");
        assert!(same < 10);
    }

    #[test]
    fn noise_stays_in_range_with_zero_mean() {
        let (mut sum, mut low, mut high) = (0.0_f64, f32::MAX, f32::MIN);
        for step in 0..90_000 {
            let (x, y) = ((step % 300) as f32 * 0.173, (step / 300) as f32 * 0.211);
            let value = gradient_noise(x, y, [0, 0], 3);
            assert!(value.abs() <= 1.0);
            assert!(fbm(x, y, [0, 0], 4, 3).abs() <= 1.0);
            assert!(value_noise(x, 0, 3).abs() <= 1.0);
            sum += f64::from(value);
            low = low.min(value);
            high = high.max(value);
        }
        assert!((sum / 90_000.0).abs() < 0.02);
        assert!(low < -0.6 && high > 0.6, "{low} {high}");
    }

    #[test]
    fn noise_repeats_after_its_period_and_not_before() {
        let mut differs = 0;
        for step in 0..500 {
            let (x, y) = (step as f32 * 0.125 % 12.0, step as f32 * 0.0625 % 5.0);
            let period = [12, 5];
            let shifted = (x + 12.0, y + 5.0);
            assert_eq!(
                gradient_noise(x, y, period, 9),
                gradient_noise(shifted.0, shifted.1, period, 9)
            );
            assert_eq!(
                fbm(x, y, period, 3, 9),
                fbm(shifted.0, shifted.1, period, 3, 9)
            );
            assert_eq!(value_noise(x, 12, 9), value_noise(x + 12.0, 12, 9));
            let (here, there) = (
                worley(x, y, period, 9),
                worley(shifted.0, shifted.1, period, 9),
            );
            assert!((here.nearest - there.nearest).abs() < 1e-5);
            assert_eq!(here.id, there.id);
            differs +=
                u32::from(gradient_noise(x, y, period, 9) != gradient_noise(x + 6.0, y, period, 9));
        }
        assert!(differs > 300);
    }

    #[test]
    fn noise_is_continuous_across_cells() {
        for step in 0..1_000 {
            let x = step as f32 * 0.25;
            let jump = gradient_noise(x + 1e-3, 0.37, [0, 0], 5)
                - gradient_noise(x - 1e-3, 0.37, [0, 0], 5);
            // The slope of unit-range gradient noise stays below about 4 per cell.
            assert!(jump.abs() < 8e-3, "{jump}");
        }
    }

    #[test]
    fn worley_finds_the_nearest_of_the_scattered_points() {
        for step in 0..2_000 {
            let (x, y) = (step as f32 * 0.037, step as f32 * 0.053 + 4.0);
            let found = worley(x, y, [0, 0], 11);
            assert!(found.nearest <= found.second);
            assert!(found.nearest <= core::f32::consts::SQRT_2);
            let mut brute = f32::MAX;
            for cell_y in y as i32 - 3..=y as i32 + 3 {
                for cell_x in x as i32 - 3..=x as i32 + 3 {
                    let hash = hash2(cell_x, cell_y, 11);
                    let px = cell_x as f32 + unit_f32(hash);
                    let py = cell_y as f32 + unit_f32(pcg_hash(hash));
                    brute = brute.min((px - x).hypot(py - y));
                }
            }
            assert!((found.nearest - brute).abs() < 1e-6);
        }
    }

    #[test]
    fn wrap_half_folds_a_turn() {
        assert!((wrap_half(0.9) + 0.1).abs() < 1e-6);
        assert!((wrap_half(-0.9) - 0.1).abs() < 1e-6);
        assert!(wrap_half(3.25) == 0.25);
    }
}
