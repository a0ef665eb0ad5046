// Closed forms for light in a homogeneous layer, so that a march is needed only to find where
// layers begin and end. Coefficients per millimetre, lengths in millimetres, one per colour.
// Twin: src/tissue/slab.rs.

// Fraction of light that passes `path` millimetres (Beer and Lambert).
fn slab_transmittance(extinction: vec3f, path: f32) -> vec3f {
    return exp(-extinction * path);
}

// π × BRDF of a layer over black for light scattered once, isotropically: light enters at
// `cos_in` and leaves at `cos_out` to the layer's normal.
fn slab_single_scatter(extinction: vec3f, scattering: vec3f, thickness: f32, cos_in: f32, cos_out: f32) -> vec3f {
    if cos_in <= 0.0 || cos_out <= 0.0 {
        return vec3f(0.0);
    }
    let slant = 1.0 / cos_in + 1.0 / cos_out;
    return scattering * slab_decay_integral(extinction * slant, thickness) / (4.0 * cos_in * cos_out);
}

// ∫₀^d e^{−k z} dz = (1 − e^{−k d})/k: below k d = 2 as d e^{−h} sinh(h)/h with h = k d/2, by its series
// (the next term is 2.5e-8), where the difference would cancel; a few roundings everywhere.
fn slab_decay_integral(k: vec3f, d: f32) -> vec3f {
    let x = k * d;
    let h = 0.25 * x * x;
    let series = 1.0 + h * (1.0 / 6.0) * (1.0 + h * (1.0 / 20.0) * (1.0 + h * (1.0 / 42.0) * (1.0 + h * (1.0 / 72.0))));
    let near = d * exp(-0.5 * x) * series;
    let far = (1.0 - exp(-x)) / max(k, vec3f(1e-20));
    return select(far, near, x < vec3f(2.0));
}
