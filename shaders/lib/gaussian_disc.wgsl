// The gather's kernel: a Gaussian with the variance of a uniform disc. Twin: src/percept/gather.rs.
//
// A uniform disc of diameter d has the variance d^2/16 along each axis, so sigma = d/4.
// sigma <= 0.7: four bilinear taps at (+-a, +-a) with a = sigma^2, whose variance is exactly a.
// Above: a golden-angle spiral over a disc of 2.4 sigma, weighted by the Gaussian, read from the mip
// level whose texel is the taps' spacing; sigma is lowered by what truncation and the texels add.

const GAUSSIAN_DISC_RADIUS: f32 = 2.4;
// Variance of a Gaussian cut at 2.4 sigma, in units of sigma^2: 1 - h e^-h/(1 - e^-h), h = 2.88.
const GAUSSIAN_DISC_TRUNCATION: f32 = 0.82871695;
const GOLDEN_ANGLE_COS: f32 = -0.737368878;
const GOLDEN_ANGLE_SIN: f32 = 0.675490294;
const SMALL_DISC_SIGMA_PX: f32 = 0.7;
const COPY_DIAMETER_PX: f32 = 0.5;

// Taps that a blur of this sigma takes: 0 (copy), 4, or 20 and up.
fn gaussian_disc_taps(sigma_px: f32, max_taps: u32) -> u32 {
    if sigma_px < 0.25 * COPY_DIAMETER_PX {
        return 0u;
    }
    if sigma_px <= SMALL_DISC_SIGMA_PX {
        return 4u;
    }
    return min(20u + u32(min(1.5 * sigma_px, 1e4)), max(max_taps, 20u));
}

// Mip level of the spiral's taps.
fn gaussian_disc_level(sigma_px: f32, taps: u32) -> f32 {
    let spacing = GAUSSIAN_DISC_RADIUS * sigma_px * sqrt(3.14159265 / f32(max(taps, 1u)));
    return max(floor(log2(max(spacing, 1.0)) + 0.6), 0.0);
}

// Sigma of the tap weights such that taps, truncation and texels together have `sigma_px`.
fn gaussian_disc_tap_sigma(sigma_px: f32, level: f32) -> f32 {
    let texel2 = exp2(2.0 * level);
    // A box of the level's width (level 0 is the image itself) and bilinear interpolation between.
    let texel_variance = (texel2 - 1.0) / 12.0 + texel2 / 6.0;
    let variance = max(sigma_px * sigma_px - texel_variance, 0.15 * sigma_px * sigma_px);
    return sqrt(variance / GAUSSIAN_DISC_TRUNCATION);
}
