// needs: knots.wgsl
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

// `contact` is what of any lamp the lower lid's edge leaves.
struct LidShade { sky: f32, contact: f32, upper_gap: f32, lower_gap: f32 };

// How far (mm) the edge of the upper lid that casts its shadow stands before the globe, and how soft that edge is.
const LID_EDGE_MM: f32 = 1.3;
// How far (mm) that edge stands over the one that touches the globe.
const LID_EDGE_UP_MM: f32 = 0.5;
const LID_EDGE_SOFT_MM: f32 = 1.2;

// How much of the sky and of lamps the lids leave at a point p (head frame) of the globe, whose x lies at this part of this span of
// the margins (`lid_knot`): the upper lid and its lashes overhang, so that a soft band lies below its margin; the lower lid only touches.
fn lid_shade(span: LidSpan, part: f32, p: vec3<f32>) -> LidShade {
    let upper = mix(span.upper, span.upper_next, part) - p.y;
    let lower = p.y - mix(span.lower, span.lower_next, part);
    let u = max(upper, 0.0);
    let l = max(lower, 0.0);
    var shade: LidShade;
    shade.sky = (1.0 - 0.55 * exp(-u / 1.3)) * (1.0 - 0.5 * exp(-l / 0.8));
    shade.contact = 1.0 - 0.4 * exp(-l / 0.5);
    shade.upper_gap = upper;
    shade.lower_gap = lower;
    return shade;
}

// How much of a lamp of angular radius `radius` (rad) in the unit direction `light` (head frame) the lids leave where that is
// their shade: the shadow of the upper lid's edge falls the lower, the higher the lamp stands.
fn lid_lamp(shade: LidShade, light: vec3<f32>, radius: f32) -> f32 {
    let rise = clamp(light.y / max(-light.z, 0.2), -2.0, 3.0);
    let below = shade.upper_gap - max(LID_EDGE_MM * rise - LID_EDGE_UP_MM, 0.0);
    let soft = LID_EDGE_SOFT_MM + LID_EDGE_MM * min(radius, 1.0);
    return smoothstep(-soft, soft, below) * shade.contact;
}

// What lids send on of the light that they keep from the iris.
const LIDS_SEND: f32 = 0.25;

// The share of a sky's irradiance within an aqueous of this index that is not behind an edge `gap` mm up and `depth` mm before.
fn sky_past_edge(gap: f32, depth: f32, index: f32) -> f32 {
    return 0.5 + 0.5 * clamp(index * gap / max(sqrt(gap * gap + depth * depth), 0.1), -1.0, 1.0);
}

// How much of the sky the lids leave to a place of the iris, `depth` mm behind their edges in an aqueous of this `index`, whose shade this is.
fn lid_sky_within(shade: LidShade, depth: f32, index: f32) -> f32 {
    let left = max(sky_past_edge(shade.upper_gap, depth, index) + sky_past_edge(shade.lower_gap, depth, index) - 1.0, 0.0);
    return mix(LIDS_SEND, 1.0, left);
}
