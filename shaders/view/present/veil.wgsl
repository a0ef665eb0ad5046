// The veil that clouded media lay over a view: once a view, from its mips, at half of its size. It is what
// is seen where all light is scattered.

@group(0) @binding(1) var source: texture_2d<f32>;          // see `veil_source.wgsl`
@group(0) @binding(2) var view_sampler: sampler;
@group(0) @binding(3) var<uniform> media: MediaUniform;
@group(0) @binding(4) var veil_out: texture_storage_2d<rgba16float, write>;

// Square of the angle (rad) within which places of the border count alike: half of that between two of them
// in a view of 60 degrees.
const BORDER_SOFTNESS: f32 = 0.001;
// Places along the picture's border, one for each invocation of a group: the light of each, over the scale
// of its place and what of it lies in the picture.
const BORDER_PLACES: u32 = 64u;
var<workgroup> border_light: array<vec4<f32>, 64>;

// The share of the source at which one of them is.
fn border_place(index: u32) -> vec2<f32> {
    let along = 4.0 * (f32(index) + 0.5) / f32(BORDER_PLACES);
    let side = u32(along);
    let far = f32(side / 2u);
    let place = select(vec2<f32>(far, fract(along)), vec2<f32>(fract(along), far), side % 2u == 0u);
    // Towards the corners the picture lies within the source.
    let tan_half = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    return 0.5 + stereographic((2.0 * place - 1.0) * tan_half) * media.texels_per_radian / vec2<f32>(media.source_size);
}

// All invocations of a group call it before any reads the border.
fn read_border(index: u32) {
    let apart = f32(2u * (media.source_size.x + media.source_size.y)) / f32(BORDER_PLACES);
    let level = floor(log2(max(apart, 1.0)));
    border_light[index] = textureSampleLevel(source, view_sampler, border_place(index), level);
    workgroupBarrier();
}

// What lies around the picture, seen from this share of the source, as far as its border says: near places
// say most, as of light that falls with the square of the angle.
fn around(uv: vec2<f32>) -> vec3<f32> {
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < BORDER_PLACES; k++) {
        let off = (border_place(k) - uv) * vec2<f32>(media.source_size) / media.texels_per_radian;
        sum += border_light[k] / (dot(off, off) + BORDER_SOFTNESS);
    }
    return sum.rgb / max(sum.a, 1e-6);
}

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
    let uv = place * media.texels_per_radian / vec2<f32>(media.source_size) + 0.5;
    var veil = vec4<f32>(0.0);
    for (var level = 0u; level <= media.last_level; level++) {
        veil += media.weights[level / 4u][level % 4u] * spread_level(uv, level);
    }
    veil *= stereographic_scale(place);
    // What comes from nowhere in the picture comes from around it.
    let seen = veil.rgb + max(1.0 - veil.a, 0.0) * around(uv);
    textureStore(veil_out, id.xy, vec4<f32>(min(seen, vec3<f32>(65000.0)), 1.0));
}
