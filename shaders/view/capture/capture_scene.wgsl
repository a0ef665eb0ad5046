// Once a view: a camera's colour and depth become the static view.

@group(0) @binding(1) var scene_colour: texture_2d<f32>;
@group(0) @binding(2) var scene_depth: texture_depth_2d;

// Mean of the pixel's block of scene texels, in linear light.
fn block_radiance(pixel: vec2<u32>) -> vec3<f32> {
    let s = percept.supersampling;
    var sum = vec3<f32>(0.0);
    for (var j = 0u; j < s; j++) {
        for (var i = 0u; i < s; i++) {
            sum += safe_radiance(textureLoad(scene_colour, pixel * s + vec2<u32>(i, j), 0).rgb);
        }
    }
    return sum / f32(s * s);
}

@compute @workgroup_size(8, 8)
fn capture_scene(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    // The texel nearest the pixel's centre (the lower right of the middle four when even): a mean
    // of depths across an edge is the depth of nothing.
    let texel = pixel * percept.supersampling + vec2<u32>(percept.supersampling / 2u);
    let depth = textureLoad(scene_depth, texel, 0);
    let place = (vec2<f32>(texel) + 0.5) / f32(percept.supersampling);
    let ray = view_ray(place, vec2<f32>(percept.size), vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y));
    // Reverse infinite depth: distance along -z = near/depth; along the ray it is longer by 1/-z.
    write_view(pixel, block_radiance(pixel), depth / percept.near_m * -ray.z);
}
