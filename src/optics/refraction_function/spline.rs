//! Uniform B-splines of order 2 (linear) and 3 (quadratic) on [0, 1]: where to sample, how to turn
//! samples into coefficients, which coefficients a place needs.

/// Order of interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Two taps a coordinate; the error falls with the square of the spacing.
    Linear,
    /// Three taps a coordinate, one derivative continuous; the error falls with the cube.
    Quadratic,
}

impl Order {
    /// Taps a coordinate.
    pub fn taps(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Quadratic => 3,
        }
    }
}

/// The smaller of two numbers, in one instruction; the second where the first is not a number.
#[inline(always)]
pub(super) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// First coefficient and weights of the `N` that a place needs; places outside of [0, 1]
/// extrapolate the outermost cell, by at most one cell.
#[inline]
pub fn weights<const N: usize>(place: f32, count: usize) -> (usize, [f32; N]) {
    let ([first], weights) = lane_weights::<N, 1>(&[place], count);
    (first, weights.map(|[weight]| weight))
}

/// [`weights`] of several places at once.
#[inline(always)]
pub(super) fn lane_weights<const N: usize, const L: usize>(
    places: &[f32; L],
    count: usize,
) -> ([usize; L], [[f32; L]; N]) {
    // Adding this rounds to a whole number, which then stands in the lowest bits: casts are slow.
    const LARGE: f32 = 8_388_608.0;
    let cells = (count - (N - 1)) as f32;
    let (mut firsts, mut out) = ([0; L], [[0.0; L]; N]);
    for l in 0..L {
        let x = most(least(places[l] * cells, cells + 1.0), -1.0);
        // Half a unit in doubt only continues the neighbouring cell.
        let shifted = most(least(x - 0.5, cells - 1.0), 0.0) + LARGE;
        firsts[l] = (shifted.to_bits() & 0x3f_ffff) as usize;
        let f = x - (shifted - LARGE);
        let g = 1.0 - f;
        if N == 2 {
            out[0][l] = g;
            out[1][l] = f;
        } else {
            out[0][l] = 0.5 * g * g;
            out[1][l] = 0.5 + f * g;
            out[2][l] = 0.5 * f * f;
        }
    }
    (firsts, out)
}

/// Places in [0, 1] where a function of `count` coefficients is sampled.
pub fn sites(order: Order, count: usize) -> Vec<f64> {
    match order {
        Order::Linear => (0..count).map(|i| i as f64 / (count - 1) as f64).collect(),
        Order::Quadratic => {
            let cells = count - 2;
            let middles = (0..cells).map(|i| (i as f64 + 0.5) / cells as f64);
            core::iter::once(0.0)
                .chain(middles)
                .chain(core::iter::once(1.0))
                .collect()
        }
    }
}

/// Turns samples at [`sites`] into coefficients along the middle axis of a block `[outer, count,
/// inner]`.
pub fn prefilter(order: Order, samples: &[f64], [outer, count, inner]: [usize; 3]) -> Vec<f64> {
    if order == Order::Linear {
        return samples.to_vec();
    }
    let mut out = samples.to_vec();
    // Each interior sample at a cell's middle is (c₋ + 6 c + c₊)/8; those at the ends are means of
    // two coefficients. Solved by elimination without pivoting: the rows are diagonally dominant
    // after the first is used to remove c₀.
    let mut line = vec![0.0; count];
    for block in 0..outer {
        for lane in 0..inner {
            let at = |i: usize| (block * count + i) * inner + lane;
            for (i, value) in line.iter_mut().enumerate() {
                *value = samples[at(i)];
            }
            solve(&mut line);
            for (i, value) in line.iter().enumerate() {
                out[at(i)] = *value;
            }
        }
    }
    out
}

/// Solves the collocation equations in place.
fn solve(line: &mut [f64]) {
    let count = line.len();
    let last = count - 1;
    // Row 0: (c₀ + c₁)/2; row i: (c_{i−1} + 6 c_i + c_{i+1})/8; row last: (c_{last−1} + c_last)/2.
    let (lower, middle, upper) = (1.0 / 8.0, 6.0 / 8.0, 1.0 / 8.0);
    let mut ratio = vec![0.0; count];
    ratio[0] = 1.0;
    line[0] *= 2.0;
    for i in 1..last {
        let pivot = middle - lower * ratio[i - 1];
        ratio[i] = upper / pivot;
        line[i] = (line[i] - lower * line[i - 1]) / pivot;
    }
    let pivot = 0.5 - 0.5 * ratio[last - 1];
    line[last] = (line[last] - 0.5 * line[last - 1]) / pivot;
    for i in (0..last).rev() {
        line[i] -= ratio[i] * line[i + 1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value<const N: usize>(coefficients: &[f64], place: f64) -> f64 {
        let (first, weights) = weights::<N>(place as f32, coefficients.len());
        weights
            .iter()
            .enumerate()
            .map(|(i, w)| f64::from(*w) * coefficients[first + i])
            .sum()
    }

    #[test]
    fn splines_interpolate_their_samples_and_reproduce_parabolas() {
        let f = |x: f64| 1.0 - 3.0 * x + 2.0 * x * x;
        for count in [3, 4, 9, 30] {
            let samples: Vec<f64> = sites(Order::Quadratic, count).into_iter().map(f).collect();
            let c = prefilter(Order::Quadratic, &samples, [1, count, 1]);
            for i in 0..=100 {
                let x = f64::from(i) / 100.0;
                // f32 weights.
                assert!((value::<3>(&c, x) - f(x)).abs() < 2e-6, "{count} {x}");
            }
            let outside = value::<3>(&c, -0.01);
            assert!((outside - f(-0.01)).abs() < 2e-6, "extrapolates: {outside}");
        }
    }

    #[test]
    fn the_error_falls_with_the_cube_and_the_square() {
        let worst = |order: Order, count: usize| {
            let samples: Vec<f64> = sites(order, count).into_iter().map(f64::exp).collect();
            let c = prefilter(order, &samples, [1, count, 1]);
            (0..=1000)
                .map(|i| f64::from(i) / 1000.0)
                .map(|x| {
                    let got = if order == Order::Linear {
                        value::<2>(&c, x)
                    } else {
                        value::<3>(&c, x)
                    };
                    (got - x.exp()).abs()
                })
                .fold(0.0, f64::max)
        };
        let linear = worst(Order::Linear, 5) / worst(Order::Linear, 9);
        let quadratic = worst(Order::Quadratic, 6) / worst(Order::Quadratic, 10);
        assert!((3.5..4.5).contains(&linear), "{linear}");
        assert!((6.5..9.5).contains(&quadratic), "{quadratic}");
    }
}
