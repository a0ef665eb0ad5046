// needs: knots.wgsl
//
// Light of a lamp on the iris plane, read from the eye's own table.
// Twin: src/appearance/light_table.rs.

// The table reaches this far beyond the iris root, as a share of its radius.
const IRIS_LIGHT_REACH: f32 = 1.04;
// Cosine to the axis down to which a lamp behind the plane of the iris fades out.
const IRIS_LIGHT_FADE: f32 = 0.06;

// Light of a lamp in the unit direction `light` (eye frame) at a place (mm) of the iris plane: xyz
// towards where it enters the cornea, w irradiance relative to the lamp's. The table stands obliquity
// over obliquity, evenly in tan(theta/2) to 90 degrees; each is a half of the iris, along the light's
// azimuth and across it, twice as wide as high: xy towards the light, z irradiance, w radius (mm) at
// which the light enters.
fn iris_light(table: texture_2d<f32>, linear: sampler, light: vec3f, p: vec2f, root_mm: f32, limbus_mm: f32) -> vec4f {
    let size = vec2f(textureDimensions(table));
    let across = 0.5 * size.x;
    let last = round(size.y / across) - 1.0;
    let slant = length(light.xy);
    let azimuth = select(light.xy / max(slant, 1e-6), vec2f(1.0, 0.0), slant < 1e-6);
    let side = vec2f(-azimuth.y, azimuth.x);
    let at = vec2f(dot(p, azimuth), dot(p, side)) / (root_mm * IRIS_LIGHT_REACH);
    let u = (clamp(at.x * 0.5 + 0.5, 0.0, 1.0) * (size.x - 1.0) + 0.5) / size.x;
    let v = clamp(abs(at.y), 0.0, 1.0) * (across - 1.0) + 0.5;
    let level = clamp(slant / max(1.0 - light.z, 1e-6), 0.0, 1.0) * last;
    let below = min(floor(level), last - 1.0);
    let low = textureSampleLevel(table, linear, vec2f(u, (v + below * across) / size.y), 0.0);
    let high = textureSampleLevel(table, linear, vec2f(u, (v + (below + 1.0) * across) / size.y), 0.0);
    let t = mix(low, high, level - below);
    let towards = azimuth * t.x + side * (select(1.0, -1.0, at.y < 0.0) * t.y);
    // Light that would have to enter outside the cornea meets the sclera instead.
    let inside = smoothstep(limbus_mm + 0.5, limbus_mm - 0.3, t.w);
    let fade = clamp(1.0 - light.z / IRIS_LIGHT_FADE, 0.0, 1.0);
    return vec4f(towards, -sqrt(max(1.0 - dot(towards, towards), 0.04)), t.z * inside * fade);
}

// Between which places of the sky's irradiance on the iris' plane `radius` mm from the axis lies.
fn iris_sky_knot(radius: f32, root_mm: f32) -> Knot {
    return knot_at(radius / (root_mm * IRIS_LIGHT_REACH), 32);
}

// By how much light on the iris changes where the cornea's concentration of it, `own` times, is taken to this power and its
// excess over an even light is scaled.
fn caustic_change(own: f32, scale: f32, power: f32) -> f32 {
    let wanted = 1.0 + (pow(max(own, 0.0), power) - 1.0) * scale;
    return max(wanted, 0.0) / max(own, 1e-2);
}
