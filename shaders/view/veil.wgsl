// The veil that clouded media lay over a view: once a view, from its mips, at a quarter of its size.

@group(0) @binding(1) var view_colour: texture_2d<f32>;
@group(0) @binding(2) var view_sampler: sampler;
@group(0) @binding(3) var<uniform> media: MediaUniform;
@group(0) @binding(4) var veil_out: texture_storage_2d<rgba16float, write>;

// Light at a place of a level, in shares of the view, by the solid angle that it has there.
fn weighted(uv: vec2<f32>, level: u32) -> vec3<f32> {
    let tangents = (2.0 * uv - 1.0) * vec2<f32>(percept.right.w, percept.up.w);
    return solid_angle_share(tangents) * textureSampleLevel(view_colour, view_sampler, uv, f32(level)).rgb;
}

fn spread_level(uv: vec2<f32>, level: u32) -> vec3<f32> {
    let texels = vec2<f32>(max(percept.size >> vec2<u32>(level), vec2<u32>(1u)));
    let at = uv * texels - 0.5;
    let base = floor(at);
    let x = spline_taps(at.x - base.x);
    let y = spline_taps(at.y - base.y);
    let left = (base.x + 0.5 + x.z) / texels.x;
    let right = (base.x + 0.5 + x.w) / texels.x;
    let top = (base.y + 0.5 + y.z) / texels.y;
    let bottom = (base.y + 0.5 + y.w) / texels.y;
    return y.x * (x.x * weighted(vec2<f32>(left, top), level) + x.y * weighted(vec2<f32>(right, top), level))
        + y.y * (x.x * weighted(vec2<f32>(left, bottom), level) + x.y * weighted(vec2<f32>(right, bottom), level));
}

@compute @workgroup_size(8, 8)
fn spread_veil(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(veil_out);
    if any(id.xy >= size) {
        return;
    }
    let uv = (vec2<f32>(id.xy) + 0.5) / vec2<f32>(size);
    // The last level of the mips is the picture's mean.
    var veil = media.rest * textureSampleLevel(view_colour, view_sampler, vec2<f32>(0.5), 31.0).rgb;
    for (var level = media.first_level; level <= media.last_level; level++) {
        veil += media.weights[level / 4u][level % 4u] * spread_level(uv, level);
    }
    textureStore(veil_out, id.xy, vec4<f32>(min(veil, vec3<f32>(65000.0)), 1.0));
}
