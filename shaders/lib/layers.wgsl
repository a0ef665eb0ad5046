// Light scattered once in a stack of homogeneous layers, in closed form: nothing is marched inside a
// layer. Coefficients per millimetre, lengths in millimetres, one per colour; the results want to be
// multiplied by a phase function (phase.wgsl). Twin: src/tissue/layers.rs.
//
// Digits: e^-x carries x roundings of its argument, 1e-6 of itself at a depth of 20. Nothing else
// grows: neither vanishing extinction nor equal depths at both ends cost a digit.

// Mean of e^-depth along a segment whose optical depth changes linearly from `start` to `end` (0 or
// more).
fn layer_mean_transmittance(start: vec3f, end: vec3f) -> vec3f {
    let a = max(start, vec3f(0.0));
    let b = max(end, vec3f(0.0));
    let x = abs(a - b);
    // Up to a difference of 2: e^-(a+b)/2 sinh(h)/h, h half the difference, by its series (the next
    // term is 2.5e-8).
    let h = 0.25 * x * x;
    let series = 1.0 + h * (1.0 / 6.0) * (1.0 + h * (1.0 / 20.0) * (1.0 + h * (1.0 / 42.0) * (1.0 + h * (1.0 / 72.0))));
    let near = exp(-0.5 * (a + b)) * series;
    // Beyond it 1 - e^-x has lost nothing.
    let far = exp(-min(a, b)) * (1.0 - exp(-x)) / max(x, vec3f(1.0));
    return select(far, near, x < vec3f(2.0));
}
