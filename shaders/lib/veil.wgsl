// Straylight of clouded media, from the mips of a picture. Twin: src/percept/present/veil.rs.

// Share of its solid angle that a pixel at this tangent from the middle of a view keeps along one axis.
// The product of both is (1 + x² + y²)^-1.5 but for x² y² in the bracket.
fn solid_angle_share(tangent: f32) -> f32 {
    let c = 1.0 / (1.0 + tangent * tangent);
    return c * sqrt(c);
}

// A cubic B-spline twice as wide as a texel's: its weight for a texel at this distance, in texels. Those
// of all texels sum to 1.
fn wide_spline(distance: f32) -> f32 {
    let t = 0.5 * abs(distance);
    let near = (4.0 - 3.0 * t * t * (2.0 - t)) / 12.0;
    let far = max(2.0 - t, 0.0);
    return select(far * far * far / 12.0, near, t < 1.0);
}

// Two neighbouring texels as one bilinear tap, the first at this signed distance, each of which counts by
// its share: x their weight, y how far the tap lies from the first towards the second.
fn wide_spline_pair(first: f32, shares: vec2<f32>) -> vec2<f32> {
    let a = wide_spline(first) * shares.x;
    let b = wide_spline(first + 1.0) * shares.y;
    return vec2<f32>(a + b, b / max(a + b, 1e-20));
}
