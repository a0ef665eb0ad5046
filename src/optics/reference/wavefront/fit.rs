//! Least squares for Zernike coefficients.
//!
//! The rays stand near the nodes of a quadrature of the disc, on which the polynomials are orthonormal,
//! so that the normal equations are near the identity and Cholesky's factors lose no digits.

use super::WavefrontSample;
use crate::optics::reference::zernike::{ZERNIKE_COUNT, zernike_sum, zernike_values};

/// The coefficients that leave the least weighted square, and the root of its mean.
pub(super) fn least_squares(samples: &[WavefrontSample]) -> ([f64; ZERNIKE_COUNT], f64) {
    let mut normal = [[0.0; ZERNIKE_COUNT]; ZERNIKE_COUNT];
    let mut right = [0.0; ZERNIKE_COUNT];
    for sample in samples {
        let z = zernike_values(sample.pupil);
        for i in 0..ZERNIKE_COUNT {
            let weighted = sample.weight * z[i];
            right[i] += weighted * sample.aberration_um;
            for j in 0..=i {
                normal[i][j] += weighted * z[j];
            }
        }
    }
    let coefficients = solve(normal, right);
    let (mut squares, mut weights) = (0.0, 0.0);
    for sample in samples {
        let left = sample.aberration_um - zernike_sum(&coefficients, sample.pupil);
        squares += sample.weight * left * left;
        weights += sample.weight;
    }
    (coefficients, (squares / weights).sqrt())
}

/// Solves the symmetric positive system whose lower triangle is given.
pub fn solve(
    mut a: [[f64; ZERNIKE_COUNT]; ZERNIKE_COUNT],
    mut b: [f64; ZERNIKE_COUNT],
) -> [f64; ZERNIKE_COUNT] {
    for j in 0..ZERNIKE_COUNT {
        for i in j..ZERNIKE_COUNT {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            a[i][j] -= sum;
            a[i][j] = if i == j {
                a[i][j].max(f64::MIN_POSITIVE).sqrt()
            } else {
                a[i][j] / a[j][j]
            };
        }
    }
    for i in 0..ZERNIKE_COUNT {
        let sum: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    for i in (0..ZERNIKE_COUNT).rev() {
        let sum: f64 = (i + 1..ZERNIKE_COUNT).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    b
}
