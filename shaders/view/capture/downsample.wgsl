// One level of the view's mips from the one before.

@group(0) @binding(0) var downsample_source: texture_2d<f32>;
@group(0) @binding(1) var downsample_target: texture_storage_2d<rgba16float, write>;

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
