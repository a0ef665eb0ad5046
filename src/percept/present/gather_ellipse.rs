//! The gather's kernel for a blur that has a direction.
//!
//! Enters: a blur's diameter (pixels) and its elongation ([`crate::optics::defocus::astigmatic_blur`]).
//! Leaves: the level of the mips, and the texels' weights. Twins of `shaders/lib/gaussian_ellipse.wgsl`,
//! where the kernel is described.

use super::gather::{GAUSSIAN_WINDOW, GAUSSIAN_WINDOW_VARIANCE, gaussian_window};

/// Variance (texels²) up to which three texels are taken.
pub const THREE_TEXELS_VARIANCE: f64 = 0.49;
/// Texels to either side of the middle that a kernel may take along its rows.
pub const ELLIPSE_ROWS_MAX: f64 = 14.0;
/// And across them.
pub const ELLIPSE_ACROSS_MAX: f64 = 4.0;

/// Variances (pixels²) along the axis of the minus cylinder and across it, of a blur of this diameter
/// (pixels) and elongation (−1 to 1).
pub fn ellipse_variances(diameter_px: f64, elongation: f64) -> [f64; 2] {
    let variance = 0.0625 * diameter_px * diameter_px;
    [variance * (1.0 + elongation), variance * (1.0 - elongation)]
}

/// Texels to either side that a row of this variance (texels²) needs.
pub fn row_reach(variance: f64) -> f64 {
    if variance <= THREE_TEXELS_VARIANCE {
        return 1.0;
    }
    let deviations = GAUSSIAN_WINDOW * (variance / GAUSSIAN_WINDOW_VARIANCE).sqrt();
    deviations.min(1e4).ceil()
}

/// Variances (texels²) that are left to the kernel on a level of the mips, which has (4^level − 1)/4 itself.
pub fn ellipse_on_level(variances: [f64; 2], level: f64) -> [f64; 2] {
    let inverse2 = (-2.0 * level).exp2();
    variances.map(|variance| (variance * inverse2 - 0.25 * (1.0 - inverse2)).max(0.0))
}

/// The finest level on which the kernel stays within its texels; at most 31.
pub fn ellipse_level(variances: [f64; 2]) -> f64 {
    let fits = |level: &f64| {
        let [a, b] = ellipse_on_level(variances, *level);
        row_reach(a.max(b)) <= ELLIPSE_ROWS_MAX && row_reach(a.min(b)) <= ELLIPSE_ACROSS_MAX
    };
    (0..31).map(f64::from).find(fits).unwrap_or(31.0)
}

/// Weight of a texel whose middle lies `distance` (texels) from that of a row of this variance.
pub fn row_weight(distance: f64, variance: f64) -> f64 {
    let off = distance.abs();
    if variance > THREE_TEXELS_VARIANCE {
        return gaussian_window((-0.5 * GAUSSIAN_WINDOW_VARIANCE * off * off / variance).exp());
    }
    let is_nearest = off <= 0.5;
    let e = if is_nearest { off } else { 1.0 - off };
    let spread = variance.max(e.abs() * (1.0 - e.abs())) + e * e;
    if is_nearest {
        1.0 - spread
    } else if off <= 1.5 {
        0.5 * (spread + e)
    } else {
        0.0
    }
}

/// Rows of texels, as `rows_of` of `shaders/view/present/gather_ellipse.wgsl` lays them: whether they follow
/// each other down the image, the variances within a row and along the rows (texels²), and the texels by
/// which a row's middle moves from row to row. `turned` is the cosine and sine of twice the axis in the
/// image.
#[cfg(test)]
fn rows_of(left: [f64; 2], turned: [f64; 2]) -> (bool, [f64; 2], f64) {
    let (mean, more) = (0.5 * (left[0] + left[1]), 0.5 * (left[0] - left[1]));
    let (straight, across) = (more * turned[0], more * turned[1]);
    let along = mean + straight.abs();
    let slope = across / along.max(1e-9);
    let within = (mean - straight.abs() - slope * across).max(0.0);
    (straight <= 0.0, [within, along], slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second moments (xx, xy, yy; texels²) of the kernel at a place between texels, and its mean.
    fn moments(left: [f64; 2], axis_rad: f64, at: [f64; 2]) -> ([f64; 2], [f64; 3]) {
        let (sin, cos) = (2.0 * axis_rad).sin_cos();
        let (tall, [within, along], slope) = rows_of(left, [cos, sin]);
        let middle = if tall { at } else { [at[1], at[0]] };
        let first = middle[1].round();
        let (mut total, mut sums) = (0.0, [0.0; 5]);
        let reach = row_reach(along) as i32;
        for j in -reach..=reach {
            let down = first + f64::from(j) - middle[1];
            let row_middle = middle[0] + slope * down;
            let nearest = row_middle.round();
            let reach = row_reach(within) as i32;
            for i in -reach..=reach {
                let across = nearest + f64::from(i);
                let weight = row_weight(down, along) * row_weight(across - row_middle, within);
                let (u, v) = (across - middle[0], down);
                let (x, y) = if tall { (u, v) } else { (v, u) };
                total += weight;
                for (sum, value) in sums.iter_mut().zip([x, y, x * x, x * y, y * y]) {
                    *sum += weight * value;
                }
            }
        }
        let [x, y, xx, xy, yy] = sums.map(|sum| sum / total);
        ([x, y], [xx - x * x, xy - x * y, yy - y * y])
    }

    fn wanted(left: [f64; 2], axis_rad: f64) -> [f64; 3] {
        let (sin, cos) = axis_rad.sin_cos();
        [
            left[0] * cos * cos + left[1] * sin * sin,
            (left[0] - left[1]) * sin * cos,
            left[0] * sin * sin + left[1] * cos * cos,
        ]
    }

    #[test]
    fn the_kernel_has_the_moments_that_are_asked_for() {
        // A Gaussian a texel wide, taken at its texels and cut by the window, is 1 % off at most.
        let mut worst = 0.0_f64;
        for left in [
            [9.0, 0.6],
            [0.55, 0.52],
            [4.0, 1.0],
            [0.7, 9.0],
            [20.0, 1.2],
        ] {
            for degree in 0..36 {
                let axis = f64::from(5 * degree).to_radians();
                for at in [[0.0, 0.0], [0.25, 0.4], [0.5, 0.5]] {
                    let (mean, found) = moments(left, axis, at);
                    let wanted = wanted(left, axis);
                    let scale = left[0].max(left[1]);
                    assert!(
                        mean.iter().all(|m| m.abs() < 0.02 * scale.sqrt()),
                        "{mean:?} {left:?}"
                    );
                    for (found, wanted) in found.iter().zip(wanted) {
                        worst = worst.max((found - wanted).abs() / scale);
                    }
                }
            }
        }
        println!("second moments are off by at most {worst:.4} of the longer variance");
        assert!(worst < 0.011, "{worst}");
        let (_, found) = moments([9.0, 0.6], 0.3, [0.0; 2]);
        let other = wanted([9.0, 0.6], 0.3 + 0.02);
        assert!(
            (found[1] - other[1]).abs() > 0.01 * 9.0,
            "an axis one degree aside is refused"
        );
    }

    #[test]
    fn three_texels_have_the_middle_and_the_variance_that_are_asked_for() {
        for step in -10..=10 {
            let middle = 0.0499 * f64::from(step);
            for variance in [0.0, 0.1, 0.25, 0.3, 0.49] {
                let weights = [-1.0, 0.0, 1.0].map(|x| row_weight(x - middle, variance));
                let total: f64 = weights.iter().sum();
                let mean = weights[2] - weights[0];
                let square = weights[2] + weights[0] - mean * mean;
                let least = middle.abs() * (1.0 - middle.abs());
                assert!((total - 1.0).abs() < 1e-12 && (mean - middle).abs() < 1e-12);
                assert!((square - variance.max(least)).abs() < 1e-12, "{square}");
                assert!(weights.iter().all(|weight| *weight >= -1e-12));
            }
        }
        assert_eq!((row_weight(1.6, 0.3), row_weight(90.0, 4.0)), (0.0, 0.0));
    }

    #[test]
    fn every_blur_finds_a_level_within_its_texels() {
        let mut diameter = 0.1;
        while diameter < 1e5 {
            for elongation in [-1.0, -0.99, -0.5, 0.0, 0.3, 0.9, 1.0] {
                let variances = ellipse_variances(diameter, elongation);
                let level = ellipse_level(variances);
                let left = ellipse_on_level(variances, level);
                assert!(left.iter().all(|v| v.is_finite() && *v >= 0.0));
                assert!(row_reach(left[0].max(left[1])) <= ELLIPSE_ROWS_MAX);
            }
            diameter *= 1.3;
        }
        assert_eq!(ellipse_level([0.0, 0.0]), 0.0);
        assert_eq!(ellipse_level([f64::MAX, 0.0]), 31.0);
    }
}
