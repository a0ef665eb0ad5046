// The veil that clouded media lay over a view: once a view, from its mips, at half of its size. It is what
// is seen where all light leaves its place.

@group(0) @binding(1) var source: texture_2d<f32>;          // see `veil_source.wgsl`
@group(0) @binding(2) var view_sampler: sampler;
@group(0) @binding(3) var<uniform> media: MediaUniform;
@group(0) @binding(4) var veil_out: texture_storage_2d<rgba16float, write>;

// Places along the picture's border, one for each invocation of a group: where it is (stereographic), and
// what is there.
const BORDER_PLACES: u32 = 64u;
var<workgroup> border_at: array<vec2<f32>, 64>;
var<workgroup> border_light: array<vec3<f32>, 64>;
// What a border's place counts at most in what lies beyond it, in means of the border: a lamp that the picture
// cuts does not go on for ever.
const BORDER_MOST: f32 = 2.0;

fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3<f32>(0.2126, 0.7152, 0.0722));
}

// The share of the picture at which one of them is, evenly along its border.
fn border_place(index: u32) -> vec2<f32> {
    let size = vec2<f32>(percept.size);
    let along = (f32(index) + 0.5) / f32(BORDER_PLACES) * 2.0 * (size.x + size.y);
    if along < size.x { return vec2<f32>(along / size.x, 0.0); }
    if along < 2.0 * size.x { return vec2<f32>(along / size.x - 1.0, 1.0); }
    let down = along - 2.0 * size.x;
    if down < size.y { return vec2<f32>(0.0, down / size.y); }
    return vec2<f32>(1.0, down / size.y - 1.0);
}

fn uv_of(place: vec2<f32>) -> vec2<f32> {
    return 0.5 + place * media.texels_per_radian / vec2<f32>(media.source_size);
}

// All invocations of a group call it before any reads the border.
fn read_border(index: u32) {
    let tan_half = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let place = stereographic((2.0 * border_place(index) - 1.0) * tan_half);
    // A fourth of what lies between two places, so that a lamp near the border is not taken to cross it.
    let apart = f32(2u * (media.source_size.x + media.source_size.y)) / f32(BORDER_PLACES);
    let level = max(floor(log2(max(apart, 1.0))) - 2.0, 0.0);
    let light = textureSampleLevel(source, view_sampler, uv_of(place), level);
    border_at[index] = place;
    let found = light.rgb / max(light.a, 1e-6);
    border_light[index] = found;
    workgroupBarrier();
    var mean = 0.0;
    for (var k = 0u; k < BORDER_PLACES; k++) {
        mean += luminance(border_light[k]) / f32(BORDER_PLACES);
    }
    let most = BORDER_MOST * max(mean, 1e-9);
    workgroupBarrier();
    border_light[index] = found * min(most / max(luminance(found), 1e-9), 1.0);
    workgroupBarrier();
}

// What lies around the picture, seen from this place, as far as its border says: each direction goes on as
// the picture ends there. A part of the border counts by the angle that it takes up, and by the light of an
// inverse square from there outwards.
fn around(place: vec2<f32>) -> vec3<f32> {
    let edges = border_edges();
    let spacing = 2.0 * (edges.x + edges.y) / f32(BORDER_PLACES) * 2.0;
    let near = 0.5 * spacing;
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < BORDER_PLACES; k++) {
        let at = border_at[k];
        let off = at - place;
        // How far the side of the border on which that is lies from here.
        let sides = abs(off);
        let on_side = abs(at) / edges;
        let across = max(select(sides.y, sides.x, on_side.x > on_side.y), near);
        let distance2 = dot(off, off) + near * near;
        let outwards = max(0.5 * log(BORDER_FARTHEST * BORDER_FARTHEST / distance2), 0.05);
        let weight = across / distance2 * outwards;
        sum += weight * vec4<f32>(border_light[k], 1.0);
    }
    return sum.rgb / max(sum.a, 1e-6);
}

// Half of the picture's sides, stereographic.
fn border_edges() -> vec2<f32> {
    let x = stereographic(vec2<f32>(percept.tan_half_fov_x, 0.0)).x;
    let y = stereographic(vec2<f32>(0.0, percept.tan_half_fov_y)).y;
    return vec2<f32>(x, y);
}

// How far out light comes from, stereographic: a right angle.
const BORDER_FARTHEST: f32 = 2.0;

// Which of two neighbouring texels, this one and the next, are within an axis of this many.
fn texels_within(first: f32, texels: f32) -> vec2<f32> {
    let pair = vec2<f32>(first, first + 1.0);
    return select(vec2<f32>(0.0), vec2<f32>(1.0), (pair >= vec2<f32>(0.0)) & (pair < vec2<f32>(texels)));
}

// The light about a place, under a spline eight texels of a level wide: 16 taps of two by two.
fn spread_level(uv: vec2<f32>, level: u32) -> vec4<f32> {
    let texels = vec2<f32>(max(media.source_size >> vec2<u32>(level), vec2<u32>(1u)));
    let at = uv * texels - 0.5;
    let base = floor(at) - 3.0;
    var sum = vec4<f32>(0.0);
    for (var j = 0; j < 4; j++) {
        let row = base.y + 2.0 * f32(j);
        let y = wide_spline_pair(row - at.y, texels_within(row, texels.y));
        for (var i = 0; i < 4; i++) {
            let column = base.x + 2.0 * f32(i);
            let x = wide_spline_pair(column - at.x, texels_within(column, texels.x));
            let place = (vec2<f32>(column + x.y, row + y.y) + 0.5) / texels;
            sum += x.x * y.x * textureSampleLevel(source, view_sampler, place, f32(level));
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn spread_veil(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    read_border(index);
    let size = textureDimensions(veil_out);
    if any(id.xy >= size) {
        return;
    }
    let tan_half = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let place = stereographic((2.0 * (vec2<f32>(id.xy) + 0.5) / vec2<f32>(size) - 1.0) * tan_half);
    let uv = uv_of(place);
    var veil = vec4<f32>(0.0);
    for (var level = 0u; level <= media.last_level; level++) {
        veil += media.weights[level / 4u][level % 4u] * spread_level(uv, level);
    }
    veil *= stereographic_scale(place);
    // What comes from nowhere in the picture comes from around it. What stays where it is, `near`, is not
    // in the veil.
    let leaves = 1.0 - media.near;
    let seen = (veil.rgb + max(leaves - veil.a, 0.0) * around(place)) / max(leaves, 1e-3);
    textureStore(veil_out, id.xy, vec4<f32>(min(seen, vec3<f32>(65000.0)), 1.0));
}
