// Once a view: a photograph with vergence becomes the static view.

@group(0) @binding(1) var photo_colour: texture_2d<f32>;
@group(0) @binding(2) var photo_vergence: texture_2d<f32>;

// Mean of the pixel's block of photograph texels, in linear light.
fn block_radiance(pixel: vec2<u32>) -> vec3<f32> {
    let s = percept.supersampling;
    var sum = vec3<f32>(0.0);
    for (var j = 0u; j < s; j++) {
        for (var i = 0u; i < s; i++) {
            sum += safe_radiance(textureLoad(photo_colour, pixel * s + vec2<u32>(i, j), 0).rgb);
        }
    }
    return sum / f32(s * s);
}

@compute @workgroup_size(8, 8)
fn capture_photo(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let texel = pixel * percept.supersampling + vec2<u32>(percept.supersampling / 2u);
    write_view(pixel, block_radiance(pixel), textureLoad(photo_vergence, texel, 0).x);
}
