// Once a view: scene colour and depth, or a photograph with vergence, become the static view.

@group(0) @binding(1) var scene_colour: texture_2d<f32>;
@group(0) @binding(2) var scene_depth: texture_depth_2d;
@group(0) @binding(3) var photo_vergence: texture_2d<f32>;
@group(0) @binding(4) var view_colour_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(5) var view_vergence_out: texture_storage_2d<r32float, write>;
@group(0) @binding(6) var<storage, read_write> luma_out: array<u32>;
@group(0) @binding(7) var downsample_source: texture_2d<f32>;
@group(0) @binding(8) var downsample_target: texture_storage_2d<rgba16float, write>;

// Finite, non-negative and inside half-float range; a NaN fails both comparisons.
fn safe_radiance(colour: vec3<f32>) -> vec3<f32> {
    let bounded = select(vec3<f32>(0.0), colour, colour > vec3<f32>(0.0));
    return min(bounded, vec3<f32>(65000.0));
}

// Rec. 709 luma of the sRGB-encoded colour, rounded to the nearest of 0..=255.
fn luma_of(radiance: vec3<f32>) -> u32 {
    let encoded = linear_to_srgb(radiance * percept.luma_exposure);
    return u32(clamp(255.0 * dot(encoded, vec3<f32>(0.2126, 0.7152, 0.0722)) + 0.5, 0.0, 255.0));
}

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

fn write_view(pixel: vec2<u32>, radiance: vec3<f32>, vergence_d: f32) {
    // Distances inside 1 mm do not reach the retina as images.
    let vergence = select(0.0, min(vergence_d, 1000.0), vergence_d > 0.0);
    textureStore(view_colour_out, pixel, vec4<f32>(radiance, vergence));
    textureStore(view_vergence_out, pixel, vec4<f32>(vergence, 0.0, 0.0, 1.0));
    luma_out[pixel.y * percept.size.x + pixel.x] = luma_of(radiance);
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

@compute @workgroup_size(8, 8)
fn capture_photo(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let texel = pixel * percept.supersampling + vec2<u32>(percept.supersampling / 2u);
    write_view(pixel, block_radiance(pixel), textureLoad(photo_vergence, texel, 0).x);
}

// Weights of source texels 2i, 2i+1, 2i+2 in target texel i, for a source of any length: the box of
// length n/m that the target texel covers, so that every level has the image's mean.
fn box_weights(i: u32, source: u32, target_size: u32) -> vec3<f32> {
    if source == 1u {
        return vec3<f32>(1.0, 0.0, 0.0);
    }
    if source == 2u * target_size {
        return vec3<f32>(0.5, 0.5, 0.0);
    }
    let m = f32(target_size);
    return vec3<f32>(m - f32(i), m, f32(i) + 1.0) / f32(source);
}

// The box under (1, 2, 1)/4: weights of source texels 2i-1 to 2i+3. Halving gives (1, 3, 3, 1)/8,
// which moves no light from where it is: the first two moments of a point are the same on every
// texel, where the box alone jumps from one target texel to the next.
fn tent_weights(i: u32, source: u32, target_size: u32) -> array<f32, 5> {
    let box = box_weights(i, source, target_size);
    if source == 1u {
        return array<f32, 5>(0.0, 1.0, 0.0, 0.0, 0.0);
    }
    return array<f32, 5>(
        0.25 * box.x,
        0.5 * box.x + 0.25 * box.y,
        0.25 * box.x + 0.5 * box.y + 0.25 * box.z,
        0.25 * box.y + 0.5 * box.z,
        0.25 * box.z,
    );
}

@compute @workgroup_size(8, 8)
fn downsample(@builtin(global_invocation_id) id: vec3<u32>) {
    let target_size = textureDimensions(downsample_target);
    let source = textureDimensions(downsample_source);
    if any(id.xy >= target_size) {
        return;
    }
    var wx = tent_weights(id.x, source.x, target_size.x);
    var wy = tent_weights(id.y, source.y, target_size.y);
    let first = 2 * vec2<i32>(id.xy) - 1;
    let last = vec2<i32>(source) - 1;
    var sum = vec4<f32>(0.0);
    for (var j = 0; j < 5; j++) {
        for (var i = 0; i < 5; i++) {
            let texel = clamp(first + vec2<i32>(i, j), vec2<i32>(0), last);
            sum += wx[i] * wy[j] * textureLoad(downsample_source, texel, 0);
        }
    }
    textureStore(downsample_target, id.xy, sum);
}
