// The gather's kernel: a Gaussian with the variance of a uniform disc. Twin: src/percept/present/gather.rs.
//
// A uniform disc of diameter d has the variance d^2/16 along each axis, so sigma = d/4.
// sigma <= 0.7: four bilinear taps at (+-a, +-a) with a = sigma^2, whose variance is exactly a.
// Above: every texel of a mip level under a windowed Gaussian, two by two in one bilinear tap, so
// that a point is drawn alike wherever it lies; sigma is lowered by what window and level add.

// The window subtracts the Gaussian's value at 3.4 deviations, so that no texel comes or goes with
// a step.
const GAUSSIAN_WINDOW: f32 = 3.4;
const GAUSSIAN_WINDOW_EDGE: f32 = 0.0030887154;
// Variance of the windowed Gaussian, in units of its deviation squared.
const GAUSSIAN_WINDOW_VARIANCE: f32 = 0.96741795;
// Most pairs of texels along each side.
const GAUSSIAN_PAIRS_MAX: u32 = 6u;
const SMALL_DISC_SIGMA_PX: f32 = 0.7;
const COPY_DIAMETER_PX: f32 = 0.5;

// Weight in the window of a place where the Gaussian has this value.
fn gaussian_window(gaussian: f32) -> f32 {
    return max(gaussian - GAUSSIAN_WINDOW_EDGE, 0.0);
}

// The Gaussian of this deviation at a distance (texels), by what it is multiplied one texel further,
// and by what that factor is multiplied: a row of texels costs no exponentials but these.
fn gaussian_steps(distance: f32, deviation: f32) -> vec3<f32> {
    let inverse2 = 1.0 / (deviation * deviation);
    return exp(-inverse2 * vec3<f32>(0.5 * distance * distance, distance + 0.5, 1.0));
}

// Deviation (texels of the level) of the window such that window and level together have `sigma_px`.
// A level of the mips, each the one before under (1, 3, 3, 1)/8, has the variance (4^level - 1)/4.
fn gaussian_disc_deviation(sigma_px: f32, level: f32) -> f32 {
    let inverse2 = exp2(-2.0 * level);
    let whole = sigma_px * sigma_px * inverse2;
    let own = max(whole - 0.25 * (1.0 - inverse2), 0.15 * whole);
    return sqrt(own / GAUSSIAN_WINDOW_VARIANCE);
}

// Pairs of texels along each side that such a window covers.
fn gaussian_disc_pairs(deviation: f32) -> u32 {
    return u32(ceil(clamp(GAUSSIAN_WINDOW * deviation, 1.0, 1e4)));
}

// Mip level: the finest on which no more pairs than these are needed.
fn gaussian_disc_level(sigma_px: f32, pairs: u32) -> f32 {
    var level = max(floor(log2(max(sigma_px, 1.0))) - 1.0, 0.0);
    for (var k = 0; k < 3; k++) {
        if gaussian_disc_pairs(gaussian_disc_deviation(sigma_px, level)) <= pairs {
            break;
        }
        level += 1.0;
    }
    return level;
}

// Pairs along each side that a budget of taps allows.
fn gaussian_disc_budget(max_taps: u32) -> u32 {
    return clamp(u32(sqrt(f32(max_taps)) + 1e-3), 4u, GAUSSIAN_PAIRS_MAX);
}

// Taps that a blur of this sigma takes: 0 (copy), 4, or a square.
fn gaussian_disc_taps(sigma_px: f32, max_taps: u32) -> u32 {
    if sigma_px < 0.25 * COPY_DIAMETER_PX {
        return 0u;
    }
    if sigma_px <= SMALL_DISC_SIGMA_PX {
        return 4u;
    }
    let level = gaussian_disc_level(sigma_px, gaussian_disc_budget(max_taps));
    let pairs = gaussian_disc_pairs(gaussian_disc_deviation(sigma_px, level));
    return pairs * pairs;
}

// What lies nearer spreads over what is behind along a golden-angle spiral of equal areas over 2.4
// of its largest sigma: taps, and the mip level whose texel is their spacing.
const SPREAD_RADIUS: f32 = 2.4;
const GOLDEN_ANGLE_COS: f32 = -0.737368878;
const GOLDEN_ANGLE_SIN: f32 = 0.675490294;

fn spread_taps(sigma_px: f32, max_taps: u32) -> u32 {
    return min(20u + u32(min(1.5 * sigma_px, 1e4)), max(max_taps, 20u));
}

fn spread_level(sigma_px: f32, taps: u32) -> f32 {
    let spacing = SPREAD_RADIUS * sigma_px * sqrt(3.14159265 / f32(max(taps, 1u)));
    return max(floor(log2(max(spacing, 1.0)) + 0.6), 0.0);
}
