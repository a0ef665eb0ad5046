// needs: studio.wgsl
//
// Lashes and brow hairs: dark fibres with two highlights (Kajiya and Kay 1989).
// Twin: src/appearance/shading/hair_shade.rs.

// Radiance of a fibre of this colour along the unit direction `along`, seen from v.
fn hair_radiance(studio: Studio, color: vec3f, along: vec3f, v: vec3f) -> vec3f {
    let key = studio.key_direction;
    let sine = sqrt(max(1.0 - dot(along, key) * dot(along, key), 0.0));
    let half_way = normalize(key + v);
    let s = sqrt(max(1.0 - dot(along, half_way) * dot(along, half_way), 0.0));
    var radiance = color * (studio.key_color * (0.20 + 0.55 * sine) + 0.8 * studio_ambient(studio, vec3f(0.0, 0.3, -0.9)));
    radiance += studio.key_color * (0.035 * pow(s, 60.0) + color * 0.35 * pow(s, 14.0));
    return radiance;
}
