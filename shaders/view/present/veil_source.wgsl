// The picture in which a veil is spread: the view in the stereographic projection, half as fine. There a
// bell is the same everywhere. rgb is radiance over the scale of the place, a what a radiance of 1 is:
// 0 beyond the picture.

@group(0) @binding(1) var view_colour: texture_2d<f32>;
@group(0) @binding(2) var view_sampler: sampler;
@group(0) @binding(3) var<uniform> media: MediaUniform;
@group(0) @binding(4) var source_out: texture_storage_2d<rgba16float, write>;

// Samples along each axis of a texel.
const SOURCE_SAMPLES: u32 = 4u;

@compute @workgroup_size(8, 8)
fn project_source(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= media.source_size) {
        return;
    }
    let tan_half = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    var sum = vec3<f32>(0.0);
    var whole = 0.0;
    for (var k = 0u; k < SOURCE_SAMPLES * SOURCE_SAMPLES; k++) {
        let part = (vec2<f32>(f32(k % SOURCE_SAMPLES), f32(k / SOURCE_SAMPLES)) + 0.5) / f32(SOURCE_SAMPLES);
        let texel = vec2<f32>(id.xy) + part - 0.5 * vec2<f32>(media.source_size);
        let place = texel / media.texels_per_radian;
        let uv = 0.5 + 0.5 * tangents_of(place) / tan_half;
        // Of what lies beyond the picture nothing is known here.
        let share = select(0.0, 1.0 / stereographic_scale(place), all(abs(uv - 0.5) <= vec2<f32>(0.5)));
        // The first mip, whose texels are as large as these.
        sum += share * textureSampleLevel(view_colour, view_sampler, uv, 1.0).rgb;
        whole += share;
    }
    let taken = vec4<f32>(sum, whole) / f32(SOURCE_SAMPLES * SOURCE_SAMPLES);
    textureStore(source_out, id.xy, min(taken, vec4<f32>(65000.0)));
}
