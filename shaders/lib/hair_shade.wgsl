// Lashes and brow hairs: dark fibres with two highlights (Kajiya and Kay 1989).
// Twin: src/appearance/shading/hair_shade.rs.

// Radiance of a fibre of this colour along the unit direction `along`, seen from v, under a lamp from the
// unit direction `light` with an irradiance / pi of one.
fn hair_lamp(color: vec3f, along: vec3f, v: vec3f, light: vec3f) -> vec3f {
    let sine = sqrt(max(1.0 - dot(along, light) * dot(along, light), 0.0));
    let half_way = normalize(light + v);
    // The highlights' powers of the sine, 14 and 60, are products.
    let s2 = max(1.0 - dot(along, half_way) * dot(along, half_way), 0.0);
    let s4 = s2 * s2;
    let s8 = s4 * s4;
    let s14 = s8 * s4 * s2;
    let s28 = s14 * s14;
    return color * (0.20 + 0.55 * sine + 0.35 * s14) + 0.035 * (s28 * s28 * s4);
}

// The same under surroundings that send this irradiance / pi to a face.
fn hair_ambient(color: vec3f, ambient: vec3f) -> vec3f {
    return 0.8 * color * ambient;
}

// An edge of the ribbon that draws a hair, this half width (of either sign) aside of its centre line as it is seen from `camera`.
// The chord from root to tip tells which side is which where the hair bends towards the camera and away again.
fn hair_ribbon(center: vec3f, along: vec3f, chord: vec3f, camera: vec3f, half_width: f32) -> vec3f {
    let v = normalize(camera - center);
    let aside = cross(along, v);
    let turned = select(-1.0, 1.0, dot(aside, cross(chord, v)) >= 0.0);
    return center + aside * (turned * half_width / max(length(aside), 1e-4));
}

// Half width of the ribbon that draws a hair of this half width (same units as a pixel, same sign), so wide that no pixel's
// centre misses it.
fn hair_drawn(half_width: f32, pixel: f32) -> f32 {
    return sign(half_width) * max(abs(half_width) + 0.5 * pixel, pixel);
}

// Share of a pixel that a hair of this half width covers this far aside of its middle; over the ribbon's width as much as the hair is
// wide.
fn hair_coverage(half_width: f32, pixel: f32, aside: f32) -> f32 {
    let w = abs(half_width) / pixel;
    return clamp(max(w + 0.5, 1.0) - abs(aside) / pixel, 0.0, 1.0) * min(2.0 * w, 1.0);
}

// Share of a hair that is seen this far along it (0 root, 1 tip): it comes out of its skin little by little.
fn hair_rooted(along: f32) -> f32 {
    return smoothstep(0.0, 0.06, along);
}
