// The studio that lights the eye: a four-paned window (the key light), a smaller lamp (the fill) and
// soft surroundings. Head frame. Twin: src/appearance/shading/studio.rs.

struct Studio {
    // Unit direction towards the key light in the head frame.
    key_direction: vec3<f32>,
    // Its angular half-width as a window, or radius as a lamp (rad).
    key_radius: f32,
    // Irradiance / pi from it, linear sRGB.
    key_color: vec3<f32>,
    exposure: f32,
    fill_direction: vec3<f32>,
    fill_radius: f32,
    fill_color: vec3<f32>,
    // 1 where the key light is a four-paned window, 0 where it is a round lamp.
    is_window: f32,
    // Radiance of the surroundings from above and below.
    ambient_up: vec3<f32>,
    // 1 where the camera's exposure is still to come.
    is_luminance: f32,
    ambient_down: vec3<f32>,
    unused: f32,
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
    var radiance = mix(studio.ambient_down, studio.ambient_up, smoothstep(0.15, 0.85, up));
    let key = studio.key_direction;
    let right = normalize(cross(vec3(0.0, 1.0, 0.0), key));
    let above = cross(key, right);
    let along = dot(d, key);
    // No branch hangs on uniforms alone: lavapipe puts their values into the code and compiles it anew
    // for each draw, 12 ms a frame of the eye.
    let is_window = studio.is_window;
    radiance += studio.key_color * ((1.0 - is_window) * round_lamp(d, key, studio.key_radius, blur));
    if is_window * along > 0.05 {
        let p = vec2(dot(d, right), dot(d, above)) / along;
        let half_size = vec2(0.72, 1.0) * studio.key_radius;
        let edge = max(blur, 0.008);
        let inside = smoothstep(vec2(edge), vec2(-edge), abs(p) - half_size);
        let bar = max(0.02, 0.07 * half_size.x);
        let panes = smoothstep(vec2(-edge), vec2(edge), abs(p) - vec2(bar));
        let coverage = inside.x * inside.y * mix(1.0, panes.x * panes.y, exp(-blur * 12.0));
        // The radiance of a window of this solid angle that gives the key's irradiance.
        let solid_angle = 4.0 * half_size.x * half_size.y;
        radiance += studio.key_color * (3.14159265 / solid_angle) * coverage * (0.75 + 0.25 * clamp(p.y / half_size.y, -1.0, 1.0));
    }
    let fill = round_lamp(d, studio.fill_direction, studio.fill_radius, blur);
    radiance += studio.fill_color * fill;
    return radiance;
}

// Irradiance / pi from the surroundings without the two lamps on a surface of normal n.
fn studio_ambient(studio: Studio, n: vec3<f32>) -> vec3<f32> {
    return mix(studio.ambient_down, studio.ambient_up, 0.5 + 0.5 * n.y);
}

// Mean cosine of a lamp of angular half-width `half` over a surface that bends light
// around its terminator by `wrap` (0: Lambert), never negative.
fn wrapped_cosine(cosine: f32, wrap: f32) -> f32 {
    let c = (cosine + wrap) / (1.0 + wrap);
    return max(c, 0.0) * max(c, 0.0) * 0.35 + max(c, 0.0) * 0.65;
}
