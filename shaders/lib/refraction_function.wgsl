// The refraction function of François et al. 2007, section 5.1, for one light: coordinates in which
// the entry point is smooth, and the weights of the B-spline coefficients that a place needs. The
// coefficients themselves are the caller's to fetch: K = Σ by_b[j] by_w[m] c[first_b + j][first_w + m]
// along and across the light's azimuth, mm.
// Twin: src/optics/refraction_function.rs.

// w and β of a place: `a` mm towards the light's azimuth, `b` ≥ 0 mm across it. `ends` = (a₀, a₁)
// coefficients of 1, β², β⁴; `kappa` likewise; `widest` the b at β = 1.
fn refraction_place(widest: f32, far: vec3f, near: vec3f, kappa: vec3f, a: f32, b: f32) -> vec2f {
    let beta = b / widest;
    let q = min(beta * beta, 1.5);
    let powers = vec3f(1.0, q, q * q);
    let a0 = dot(far, powers);
    let a1 = dot(near, powers);
    let k = max(dot(kappa, powers), 1e-3);
    let share = (a - a0) / max(a1 - a0, 0.1);
    // The square root that undoes the fold beyond grazing light.
    let root = sqrt(max(k * k + 4.0 * (1.0 - k) * share, 0.0));
    return vec2f(2.0 * share / (k + root), beta);
}

// x: index of the first of three coefficients among `count`, yzw: their weights, for a place of
// [0, 1]; outside of it the outermost cell goes on, by at most one cell.
fn refraction_weights(place: f32, count: u32) -> vec4f {
    let cells = f32(count) - 2.0;
    let x = clamp(place * cells, -1.0, cells + 1.0);
    let first = clamp(floor(x), 0.0, cells - 1.0);
    let f = x - first;
    let g = 1.0 - f;
    return vec4f(first, 0.5 * g * g, 0.5 + f * g, 0.5 * f * f);
}
