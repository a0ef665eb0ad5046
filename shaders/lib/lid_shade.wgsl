// needs: knots.wgsl, lash_comb.wgsl
//
// What the lids leave of the light on the globe. Twin: src/appearance/shading/lid_shade.rs.

const LID_SAMPLES: i32 = 32;
const LID_HALF_SPAN_MM: f32 = 20.0;

// Heights (y, mm, head frame) of the lid margins at a place and at the next.
struct LidSpan { upper: f32, upper_next: f32, lower: f32, lower_next: f32 };

struct Lids {
    // From each of LID_SAMPLES places from x = -LID_HALF_SPAN_MM to +LID_HALF_SPAN_MM to the next.
    spans: array<LidSpan, 32>,
};

// Between which places of the margins x (mm, head frame) lies; flat beyond them.
fn lid_knot(x: f32) -> Knot {
    return knot_at((x + LID_HALF_SPAN_MM) / (2.0 * LID_HALF_SPAN_MM), LID_SAMPLES);
}

// Where a place is: mm aside, below the upper lid's margin, above the lower one's.
struct LidShade { aside: f32, upper_gap: f32, lower_gap: f32 };

// How far (mm) the edges of the lids that cast their shadows stand before the globe, and how soft their shadows are.
const LID_EDGE_MM: f32 = 1.3;
// How far (mm) an edge stands beyond the one that touches the globe.
const LID_EDGE_UP_MM: f32 = 0.5;
const LID_EDGE_SOFT_MM: f32 = 1.2;
const LOWER_EDGE_SOFT_MM: f32 = 0.5;

// How a point p (head frame) of the globe lies between the lids, whose x lies at this part of this span of the margins (`lid_knot`).
fn lid_shade(span: LidSpan, part: f32, p: vec3<f32>) -> LidShade {
    let upper = mix(span.upper, span.upper_next, part) - p.y;
    let lower = p.y - mix(span.lower, span.lower_next, part);
    return LidShade(p.x, upper, lower);
}

// How much of a lamp of angular radius `radius` (rad) in the unit direction `light` (head frame) the lids leave where that is
// their shade: the shadow of the upper lid's edge falls the lower, the higher the lamp stands, that of the lower one's the higher, the lower it
// stands, and the upper lashes throw theirs, which the lamp's width and the tissue blur.
fn lid_lamp(shade: LidShade, light: vec3<f32>, radius: f32) -> f32 {
    let rise = clamp(light.y / max(-light.z, 0.2), -3.0, 3.0);
    let below = shade.upper_gap - max(LID_EDGE_MM * rise - LID_EDGE_UP_MM, 0.0);
    let above = shade.lower_gap - max(-LID_EDGE_MM * rise - LID_EDGE_UP_MM, 0.0);
    let wide = LID_EDGE_MM * min(radius, 1.0);
    let soft = LID_EDGE_SOFT_MM + wide;
    let lower_soft = LOWER_EDGE_SOFT_MM + wide;
    let lashes = lashes_left(shade.aside, light, shade.upper_gap, LASH_SHADOW_MM, 0.35 * radius);
    return smoothstep(-soft, soft, below) * smoothstep(-lower_soft, lower_soft, above) * lashes;
}

// How far (mm) light goes aside in the tissue on which a lash's shadow falls.
const LASH_SHADOW_MM: f32 = 0.06;

// What of the lids' own radiance their edges and lashes have, which see half of the light.
const LIDS_SEND: f32 = 0.5;

// The sine, against a normal that rises by `tilt` (sine), at which an edge is seen that stands `up` mm higher and `before` mm in front; one behind
// the horizon is at it.
fn edge_sine(up: f32, before: f32, tilt: f32) -> f32 {
    let upright = sqrt(max(1.0 - tilt * tilt, 0.0));
    let sine = (up * upright - before * tilt) * inverseSqrt(max(up * up + before * before, 1e-6));
    return select(select(-1.0, 1.0, up >= 0.0), clamp(sine, -1.0, 1.0), before * upright + up * tilt > 0.0);
}

// Twice the integral of the square of the cosine from 0 to where the sine is s, over pi, within 6e-4.
fn square_cosines(s: f32) -> f32 {
    let s2 = s * s;
    return 0.63661977 * s * (1.0 + s2 * (-0.189 + s2 * (0.056 - 0.0816 * s2)));
}

// Irradiance / pi of the surroundings between the normal's plane and where the sine is s, of radiance that does not depend on the direction, that
// goes with its part along the normal and up across it, and with the products of those: along twice, up twice, both.
fn sky_to(s: f32, first: mat3x3f, second: mat3x3f) -> vec3f {
    let s2 = s * s;
    let c2 = max(1.0 - s2, 0.0);
    return first * vec3f(0.5 * s, square_cosines(s), 0.31830989 * s2) + second * vec3f(s * (1.0 - 0.5 * s2), 0.5 * s * (s2 - 1.0), -c2 * sqrt(c2));
}

// The surroundings' irradiance / pi: what of it does not depend on the direction, what goes with its parts (columns by x, y, z), and what with the
// products of those (columns by x, y, z, of matrices by x, y, z).
struct SkyFactors { even: vec3f, linear: mat3x3f, xs: mat3x3f, ys: mat3x3f, zs: mat3x3f };

// They, from the factors of 1, y, z, x, xy, yz, 3zz - 1, xz and xx - yy.
fn sky_factors(even: vec3f, y: vec3f, z: vec3f, x: vec3f, xy: vec3f, yz: vec3f, zz: vec3f, xz: vec3f, xx: vec3f) -> SkyFactors {
    let xs = mat3x3f(xx - zz, 0.5 * xy, 0.5 * xz);
    let ys = mat3x3f(0.5 * xy, -xx - zz, 0.5 * yz);
    let zs = mat3x3f(0.5 * xz, 0.5 * yz, 2.0 * zz);
    return SkyFactors(even, mat3x3f(x, y, z), xs, ys, zs);
}

// Irradiance / pi that comes from the surroundings past the lids and lashes to a place of the globe of normal n (head frame), whose shade this
// is, and what the lids send on, whose radiance is `lids`.
fn lid_sky(around: SkyFactors, shade: LidShade, n: vec3f, lids: vec3f) -> vec3f {
    let upper = edge_sine(shade.upper_gap + LID_EDGE_UP_MM, LID_EDGE_MM, n.y);
    let lower = min(edge_sine(-shade.lower_gap - LID_EDGE_UP_MM, LID_EDGE_MM, n.y), upper);
    // What lies between them and the upper edge comes past the lashes.
    let lashes = clamp(edge_sine(lash_rise(shade.upper_gap), 1.0, n.y), lower, upper);
    let passed = 1.0 - LASH_DARK * LASH_SHARE;
    let open = 0.5 * (mix(lashes, upper, passed) - lower);
    // Along the normal, and up across it.
    let t = (vec3f(0.0, 1.0, 0.0) - n.y * n) * inverseSqrt(max(1.0 - n.y * n.y, 1e-4));
    let first = mat3x3f(around.even, around.linear * n, around.linear * t);
    // The part of the second degree with one direction left open.
    let with_n = mat3x3f(around.xs * n, around.ys * n, around.zs * n);
    let with_t = mat3x3f(around.xs * t, around.ys * t, around.zs * t);
    let second = mat3x3f(with_n * n, with_t * t, with_n * t);
    let sky = mix(sky_to(lashes, first, second), sky_to(upper, first, second), passed) - sky_to(lower, first, second);
    return max(sky, vec3f(0.0)) + LIDS_SEND * (1.0 - open) * lids;
}

// The share of a sky's irradiance within an aqueous of this index that is not behind an edge `gap` mm up and `depth` mm before.
fn sky_past_edge(gap: f32, depth: f32, index: f32) -> f32 {
    return 0.5 + 0.5 * clamp(index * gap / max(sqrt(gap * gap + depth * depth), 0.1), -1.0, 1.0);
}

// How much of the sky the lids leave to a place of the iris, `depth` mm behind their edges in an aqueous of this `index`, whose shade this is;
// of the rest they send on.
fn lid_sky_within(shade: LidShade, depth: f32, index: f32) -> f32 {
    return max(sky_past_edge(shade.upper_gap, depth, index) + sky_past_edge(shade.lower_gap, depth, index) - 1.0, 0.0);
}
