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
