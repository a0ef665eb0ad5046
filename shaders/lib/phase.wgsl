// Phase functions: the share of scattered light per steradian into a direction whose angle to the
// light's way on has the cosine `cos_angle` (1 straight on, -1 straight back), and draws from them.
// Mean cosines within +-(1 - 2^-13). Twin: src/tissue/phase.rs.
//
// Digits: 1 - g and 1 - cos are exact differences of the numbers given, so the peak has a few
// roundings of error. What f32 cannot hold is the cosine itself: a step of 6e-8 near 1 moves the
// peak's value by 6e-8 · 3 g/(1 - g)², 2e-3 of it at g = 0.99; hand the angle's versine on, not the
// cosine, where g is that high.

// Largest |g|, 1 - 2^-13.
const PHASE_MAX_MEAN_COSINE: f32 = 0.9998779296875;
// 1/(4π).
const PHASE_ISOTROPIC: f32 = 0.079577471545947668;

// Rayleigh, unpolarised light.
fn phase_rayleigh(cos_angle: f32) -> f32 {
    let c = clamp(cos_angle, -1.0, 1.0);
    return 0.75 * PHASE_ISOTROPIC * (1.0 + c * c);
}

// Henyey and Greenstein, mean cosine g.
fn phase_henyey_greenstein(cos_angle: f32, g: f32) -> f32 {
    let size = min(abs(g), PHASE_MAX_MEAN_COSINE);
    let c = clamp(cos_angle, -1.0, 1.0);
    let along = select(c, -c, g < 0.0);
    let less = 1.0 - size;
    let squared = less * less + 2.0 * size * (1.0 - along);
    return PHASE_ISOTROPIC * less * (1.0 + size) / (squared * sqrt(squared));
}

// The share `rayleigh` after Rayleigh, `isotropic` alike in all directions, the rest after Henyey
// and Greenstein.
fn phase_mix(cos_angle: f32, rayleigh: f32, isotropic: f32, g: f32) -> f32 {
    return rayleigh * phase_rayleigh(cos_angle)
        + isotropic * PHASE_ISOTROPIC
        + (1.0 - rayleigh - isotropic) * phase_henyey_greenstein(cos_angle, g);
}

// Cosine after Rayleigh for a random number, 0 (back) to 1 (straight on). `pow` may be a few
// roundings off; one Newton step on cos³ + 3 cos = 2 q mends that.
fn sample_rayleigh(xi: f32) -> f32 {
    let q = 4.0 * clamp(xi, 0.0, 1.0) - 2.0;
    let size = abs(q);
    let u = pow(size + sqrt(size * size + 1.0), 1.0 / 3.0);
    let rough = u - 1.0 / u;
    let c = rough - (rough * (rough * rough + 3.0) - 2.0 * size) / (3.0 * (rough * rough + 1.0));
    return sign(q) * clamp(c, 0.0, 1.0);
}

// 1 - cosine after Henyey and Greenstein for a random number, 0 (back) to 1 (straight on): a product
// of positive numbers, so nothing cancels for any g, 0 included.
fn sample_henyey_greenstein_versine(g: f32, xi: f32) -> f32 {
    let size = min(abs(g), PHASE_MAX_MEAN_COSINE);
    let x = clamp(xi, 0.0, 1.0);
    let back = g < 0.0;
    let on = select(x, 1.0 - x, back);
    let rest = select(1.0 - x, x, back);
    let ratio = (1.0 - size) / (1.0 - size + 2.0 * size * on);
    let versine = 2.0 * rest * ratio * ratio * (1.0 + size * on);
    return select(versine, 2.0 - versine, back);
}

// Cosine after Henyey and Greenstein.
fn sample_henyey_greenstein(g: f32, xi: f32) -> f32 {
    return clamp(1.0 - sample_henyey_greenstein_versine(g, xi), -1.0, 1.0);
}
