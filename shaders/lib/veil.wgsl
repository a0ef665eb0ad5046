// Straylight of clouded media, from the mips of a picture. Twin: src/percept/veil.rs.

// Share of its solid angle that a pixel at these tangents from the middle of a view keeps.
fn solid_angle_share(tangents: vec2<f32>) -> f32 {
    let c = 1.0 / (1.0 + dot(tangents, tangents));
    return c * sqrt(c);
}

// A cubic B-spline at the share `f` (0 to 1) of the way from one texel to the next, as two bilinear
// taps: xy their weights, zw their places from the first of the two texels.
fn spline_taps(f: f32) -> vec4<f32> {
    let g = 1.0 - f;
    let before = g * g * g / 6.0;
    let after = f * f * f / 6.0;
    let here = (4.0 - 3.0 * f * f * (2.0 - f)) / 6.0;
    let next = 1.0 - before - after - here;
    let first = before + here;
    let second = next + after;
    return vec4<f32>(first, second, here / first - 1.0, 1.0 + after / second);
}
