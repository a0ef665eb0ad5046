// needs: gaussian_disc
// The gather's kernel for a blur that has a direction: an ellipse. Twin: src/percept/present/gather_ellipse.rs.
//
// The Gaussian falls into rows along the image axis that is nearer to its longer one: a row's weight is the
// Gaussian of the variance along that axis, and within the row the texels' are those of a narrower one whose
// middle moves on by the same slope from row to row. Both may be narrower than a texel: three texels then have
// the middle and the variance that are asked for, as far as three texels can (e(1 - e) at e between two).

// Variance up to which three texels are taken.
const THREE_TEXELS_VARIANCE: f32 = 0.49;
// Texels to either side of the middle that a kernel may take along its rows and across them.
const ELLIPSE_ROWS_MAX: f32 = 14.0;
const ELLIPSE_ACROSS_MAX: f32 = 4.0;

// Variances (pixels^2) along the axis of the minus cylinder and across it, of a blur of this diameter
// (pixels) and elongation.
fn ellipse_variances(diameter_px: f32, elongation: f32) -> vec2<f32> {
    let variance = 0.0625 * diameter_px * diameter_px;
    return variance * vec2<f32>(1.0 + elongation, 1.0 - elongation);
}

// Texels to either side that a row of this variance (texels^2) needs.
fn row_reach(variance: f32) -> f32 {
    let deviations = GAUSSIAN_WINDOW * sqrt(variance / GAUSSIAN_WINDOW_VARIANCE);
    return select(ceil(min(deviations, 1e4)), 1.0, variance <= THREE_TEXELS_VARIANCE);
}

// Variances (texels^2) that are left to the kernel on a level of the mips, which has (4^level - 1)/4 itself.
fn ellipse_on_level(variances: vec2<f32>, level: f32) -> vec2<f32> {
    let inverse2 = exp2(-2.0 * level);
    return max(variances * inverse2 - 0.25 * (1.0 - inverse2), vec2<f32>(0.0));
}

// The finest level on which the kernel stays within its texels.
fn ellipse_level(variances: vec2<f32>) -> f32 {
    for (var level = 0.0; level < 31.0; level += 1.0) {
        let left = ellipse_on_level(variances, level);
        let along = row_reach(max(left.x, left.y));
        if along <= ELLIPSE_ROWS_MAX && row_reach(min(left.x, left.y)) <= ELLIPSE_ACROSS_MAX {
            return level;
        }
    }
    return 31.0;
}

// Weight of a texel whose middle lies `distance` (texels) from that of a row of this variance.
fn row_weight(distance: f32, variance: f32) -> f32 {
    let off = abs(distance);
    if variance > THREE_TEXELS_VARIANCE {
        return gaussian_window(exp(-0.5 * GAUSSIAN_WINDOW_VARIANCE * off * off / variance));
    }
    // How far the nearest texel is.
    let e = select(1.0 - off, off, off <= 0.5);
    let spread = max(variance, abs(e) * (1.0 - abs(e))) + e * e;
    return select(select(0.5 * (spread + e), 1.0 - spread, off <= 0.5), 0.0, off > 1.5);
}
