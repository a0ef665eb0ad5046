// What every capture leaves: the static view.

@group(0) @binding(3) var view_colour_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var view_vergence_out: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read_write> luma_out: array<u32>;

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

fn write_view(pixel: vec2<u32>, radiance: vec3<f32>, vergence_d: f32) {
    // Distances inside 1 mm do not reach the retina as images.
    let vergence = select(0.0, min(vergence_d, 1000.0), vergence_d > 0.0);
    textureStore(view_colour_out, pixel, vec4<f32>(radiance, vergence));
    textureStore(view_vergence_out, pixel, vec4<f32>(vergence, 0.0, 0.0, 1.0));
    luma_out[pixel.y * percept.size.x + pixel.x] = luma_of(radiance);
}
