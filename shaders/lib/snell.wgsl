// Snell's law in vector form (François et al. 2007, section 5.1, at each corneal interface).
// Twin: src/optics/snell.rs.

// Refracts the unit ray direction `dir` at a surface with unit `normal` (either side of the
// surface may be meant; the side facing the ray is taken). `eta` = index on the ray's side
// divided by the index behind the surface. xyz: unit direction behind the surface, w = 1; on
// total reflection xyz is the reflected direction and w = 0.
fn snell_refract(dir: vec3f, normal: vec3f, eta: f32) -> vec4f {
    let projection = dot(dir, normal);
    let facing = select(normal, -normal, projection > 0.0);
    let cos_in = abs(projection);
    let cos_out_squared = 1.0 - eta * eta * max(1.0 - cos_in * cos_in, 0.0);
    if cos_out_squared < 0.0 {
        return vec4f(dir + 2.0 * cos_in * facing, 0.0);
    }
    let refracted = eta * dir + (eta * cos_in - sqrt(cos_out_squared)) * facing;
    return vec4f(normalize(refracted), 1.0);
}
