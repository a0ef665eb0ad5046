// Phase functions: the share of scattered light per steradian into a direction whose angle to the
// light's way on has the cosine `cos_angle` (1 straight on, -1 straight back).
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
