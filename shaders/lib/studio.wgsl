// The studio that lights the eye: a four-paned window (the key light), a smaller lamp (the fill) and
// soft surroundings. Head frame. Twin: src/appearance/shading/studio.rs.

struct Studio {
    // Direction towards the window in the head frame; w: angular half-width of the window (rad).
    key_direction: vec4<f32>,
    // Irradiance / pi from the window, linear sRGB; w: exposure.
    key_color: vec4<f32>,
    fill_direction: vec4<f32>,
    fill_color: vec4<f32>,
    // Radiance of the surroundings from above; w: 1 where the key light is a four-paned window, 0 where it
    // is a round lamp.
    ambient_up: vec4<f32>,
    // And from below; w: 1 where the camera's exposure is still to come.
    ambient_down: vec4<f32>,
};

// Radiance over irradiance / pi of a round lamp of angular radius `radius` about `direction`.
fn round_lamp(d: vec3<f32>, direction: vec3<f32>, radius: f32, blur: f32) -> f32 {
    let edge = max(blur, 0.02);
    // The chord for the angle: an arc cosine is coarse where lamps are small.
    let angle = length(d - direction);
    // A lamp is at least as wide as its edge, and the edge adds a fifth of its square: the light stays
    // what it was.
    let wide = max(radius, edge);
    return smoothstep(wide + edge, wide - edge, angle) / (wide * wide + 0.2 * edge * edge);
}

// Radiance that arrives from direction d: a room with a four-paned window
// (the key light), a smaller lamp (the fill) and soft surroundings.
// `blur` (rad) is the width of the edges: wide for rough surfaces.
fn studio_radiance(studio: Studio, d: vec3<f32>, blur: f32) -> vec3<f32> {
    let up = 0.5 + 0.5 * d.y;
    var radiance = mix(studio.ambient_down.rgb, studio.ambient_up.rgb, smoothstep(0.15, 0.85, up));
    let key = studio.key_direction.xyz;
    let right = normalize(cross(vec3(0.0, 1.0, 0.0), key));
    let above = cross(key, right);
    let along = dot(d, key);
    // No branch hangs on uniforms alone: lavapipe puts their values into the code and compiles it anew
    // for each draw, 12 ms a frame of the eye.
    let is_window = studio.ambient_up.w;
    radiance += studio.key_color.rgb * ((1.0 - is_window) * round_lamp(d, key, studio.key_direction.w, blur));
    if is_window * along > 0.05 {
        let p = vec2(dot(d, right), dot(d, above)) / along;
        let half_size = vec2(0.72, 1.0) * studio.key_direction.w;
        let edge = max(blur, 0.008);
        let inside = smoothstep(vec2(edge), vec2(-edge), abs(p) - half_size);
        let bar = max(0.02, 0.07 * half_size.x);
        let panes = smoothstep(vec2(-edge), vec2(edge), abs(p) - vec2(bar));
        let coverage = inside.x * inside.y * mix(1.0, panes.x * panes.y, exp(-blur * 12.0));
        // The radiance of a window of this solid angle that gives the key's irradiance.
        let solid_angle = 4.0 * half_size.x * half_size.y;
        radiance += studio.key_color.rgb * (3.14159265 / solid_angle) * coverage * (0.75 + 0.25 * clamp(p.y / half_size.y, -1.0, 1.0));
    }
    let fill = round_lamp(d, studio.fill_direction.xyz, studio.fill_direction.w, blur);
    radiance += studio.fill_color.rgb * fill;
    return radiance;
}

// Irradiance / pi from the surroundings without the two lamps on a surface of normal n.
fn studio_ambient(studio: Studio, n: vec3<f32>) -> vec3<f32> {
    return mix(studio.ambient_down.rgb, studio.ambient_up.rgb, 0.5 + 0.5 * n.y);
}

// Mean cosine of a lamp of angular half-width `half` over a surface that bends light
// around its terminator by `wrap` (0: Lambert), never negative.
fn wrapped_cosine(cosine: f32, wrap: f32) -> f32 {
    let c = (cosine + wrap) / (1.0 + wrap);
    return max(c, 0.0) * max(c, 0.0) * 0.35 + max(c, 0.0) * 0.65;
}
