// Straylight of clouded media, from the mips of a picture. Twin: src/percept/present/veil.rs.

// Stereographic place of a place in tangents from the middle of a view: 2 tan(theta/2) for tan theta.
fn stereographic(tangents: vec2<f32>) -> vec2<f32> {
    return 2.0 * tangents / (1.0 + sqrt(1.0 + dot(tangents, tangents)));
}

// Tangents from the middle of a view of a stereographic place within 90 degrees of it; beyond, those far
// out in its direction.
fn tangents_of(place: vec2<f32>) -> vec2<f32> {
    return place / max(1.0 - 0.25 * dot(place, place), 1e-3);
}

// How much larger a stereographic place is drawn than the middle, along each axis.
fn stereographic_scale(place: vec2<f32>) -> f32 {
    return 1.0 + 0.25 * dot(place, place);
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
