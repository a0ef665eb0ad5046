// Light of a lamp on the iris plane, read from the table that the program solves for it.
// Twin: src/appearance/light_table.rs.

// The table reaches this far beyond the iris root, as a share of its radius.
const IRIS_LIGHT_REACH: f32 = 1.04;

// Light of a lamp (0 key, 1 fill) at a place (mm) of the iris plane: xyz towards where it enters the
// cornea, w irradiance relative to the lamp's. The table holds the lamps side by side: xy towards the
// light, z irradiance, w radius (mm) at which the light enters.
fn iris_light(table: texture_2d<f32>, linear: sampler, lamp: f32, p: vec2f, root_mm: f32, limbus_mm: f32) -> vec4f {
    let size = vec2f(textureDimensions(table)) * vec2f(0.5, 1.0);
    let at = clamp(p / (root_mm * IRIS_LIGHT_REACH) * 0.5 + 0.5, vec2f(0.0), vec2f(1.0)) * (size - 1.0) + 0.5;
    let t = textureSampleLevel(table, linear, (at + vec2f(lamp * size.x, 0.0)) / (size * vec2f(2.0, 1.0)), 0.0);
    // Light that would have to enter outside the cornea meets the sclera instead.
    let inside = smoothstep(limbus_mm + 0.5, limbus_mm - 0.3, t.w);
    return vec4f(t.xy, -sqrt(max(1.0 - dot(t.xy, t.xy), 0.04)), t.z * inside);
}
