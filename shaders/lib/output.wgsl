// The one place where linear radiance becomes a displayed colour: exposure, a shoulder, and the
// sRGB transfer curve (IEC 61966-2-1). Twin: src/optics/output.rs.

// Below this the curve is the identity.
const OUTPUT_KNEE: f32 = 0.6;
// How fast colours far over white lose their saturation.
const OUTPUT_DESATURATION: f32 = 0.15;
// Largest half-float: brighter input is cut there, so that no infinity enters the curve.
const OUTPUT_BRIGHTEST: f32 = 65504.0;

// Linear display RGB in 0 to 1 from linear scene RGB. The identity (times exposure) while the
// largest channel is below the knee, then a shoulder that reaches 1 at infinity with continuous
// slope; all channels are scaled together, which keeps the hue, and what lies far over white fades
// to white as it does on film.
fn output_transform(linear_rgb: vec3f, exposure: f32) -> vec3f {
    let rgb = clamp(linear_rgb * exposure, vec3f(0.0), vec3f(OUTPUT_BRIGHTEST));
    let peak = max(rgb.r, max(rgb.g, rgb.b));
    if peak <= OUTPUT_KNEE {
        return rgb;
    }
    let room = 1.0 - OUTPUT_KNEE;
    let shoulder = 1.0 - room * room / (peak - OUTPUT_KNEE + room);
    let white = 1.0 - 1.0 / (OUTPUT_DESATURATION * (peak - shoulder) + 1.0);
    return mix(rgb * (shoulder / peak), vec3f(shoulder), white);
}

fn linear_to_srgb(linear_rgb: vec3f) -> vec3f {
    let rgb = clamp(linear_rgb, vec3f(0.0), vec3f(1.0));
    let curve = 1.055 * pow(max(rgb, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * rgb, rgb <= vec3f(0.0031308));
}

// A displayed linear colour, half a code of eight bits up or down by the pixel: interleaved gradient noise
// (Jimenez 2014).
fn dithered(linear_rgb: vec3f, pixel: vec2f) -> vec3f {
    let noise = fract(52.9829189 * fract(dot(floor(pixel), vec2f(0.06711056, 0.00583715))));
    // What a code is in linear light.
    let code = max(2.2748815 * pow(max(linear_rgb, vec3f(1e-9)), vec3f(1.4 / 2.4)), vec3f(1.0 / 12.92)) / 255.0;
    return clamp(linear_rgb + (noise - 0.5) * code, vec3f(0.0), vec3f(1.0));
}
