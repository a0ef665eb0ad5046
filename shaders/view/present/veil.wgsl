// The veil that clouded media lay over a view: once a view, from its mips, at half of its size.

@group(0) @binding(1) var view_colour: texture_2d<f32>;
@group(0) @binding(2) var view_sampler: sampler;
@group(0) @binding(3) var<uniform> media: MediaUniform;
@group(0) @binding(4) var veil_out: texture_storage_2d<rgba16float, write>;

// Two texels along an axis of this many, from `first` on, as a tap for a place at `at`; `tan_half` is the
// tangent of half the field. See `wide_spline_pair`.
fn pair_along(first: f32, at: f32, texels: f32, tan_half: f32) -> vec2<f32> {
    let tangents = (2.0 * (vec2<f32>(first, first + 1.0) + 0.5) / texels - 1.0) * tan_half;
    let shares = vec2<f32>(solid_angle_share(tangents.x), solid_angle_share(tangents.y));
    return wide_spline_pair(first - at, shares);
}

// What lies around the picture, as far as its border says.
fn border() -> vec3<f32> {
    let level = f32(max(media.last_level, 3u) - 2u);
    var sum = vec3<f32>(0.0);
    for (var k = 0; k < 9; k++) {
        if k != 4 {
            let uv = 0.5 * vec2<f32>(f32(k % 3), f32(k / 3));
            sum += textureSampleLevel(view_colour, view_sampler, uv, level).rgb;
        }
    }
    return sum / 8.0;
}

// The mean light about a place, under a spline eight texels of a level wide, by solid angle: 16 taps of
// two by two.
fn spread_level(uv: vec2<f32>, level: u32) -> vec3<f32> {
    let texels = vec2<f32>(max(percept.size >> vec2<u32>(level), vec2<u32>(1u)));
    let at = uv * texels - 0.5;
    let base = floor(at) - 3.0;
    var sum = vec3<f32>(0.0);
    var whole = 0.0;
    for (var j = 0; j < 4; j++) {
        let row = base.y + 2.0 * f32(j);
        let y = pair_along(row, at.y, texels.y, percept.tan_half_fov_y);
        for (var i = 0; i < 4; i++) {
            let column = base.x + 2.0 * f32(i);
            let x = pair_along(column, at.x, texels.x, percept.tan_half_fov_x);
            let place = (vec2<f32>(column + x.y, row + y.y) + 0.5) / texels;
            sum += x.x * y.x * textureSampleLevel(view_colour, view_sampler, place, f32(level)).rgb;
            whole += x.x * y.x;
        }
    }
    return sum / max(whole, 1e-6);
}

@compute @workgroup_size(8, 8)
fn spread_veil(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(veil_out);
    if any(id.xy >= size) {
        return;
    }
    let uv = (vec2<f32>(id.xy) + 0.5) / vec2<f32>(size);
    var veil = media.rest * border();
    // Away from the middle an angle takes more texels: part of each level's light is read a level
    // coarser.
    let tangent = (2.0 * uv - 1.0) * vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let coarser = min(0.75 * log2(1.0 + dot(tangent, tangent)), 1.0);
    var passed_on = 0.0;
    for (var level = media.first_level; level <= media.last_level; level++) {
        let own = media.weights[level / 4u][level % 4u];
        let passes = select(coarser * own, 0.0, level == media.last_level);
        veil += (own - passes + passed_on) * spread_level(uv, level);
        passed_on = passes;
    }
    textureStore(veil_out, id.xy, vec4<f32>(min(veil, vec3<f32>(65000.0)), 1.0));
}
