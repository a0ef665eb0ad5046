// needs: conicoid.wgsl, snell.wgsl, fresnel.wgsl
//
// A camera ray through the cornea onto the plane of the iris (François et al. 2007, section 5.4,
// step 2), exact: ray against conicoid, Snell, ray against plane. Optics frame: origin at the
// corneal apex, +z into the eye, millimetres. A surface is vec2(apical radius R, shape factor p).
// Twin: src/optics/cornea.rs.

struct CorneaTrace {
    // Where the ray enters the anterior cornea.
    entry: vec3f,
    // Where it meets the plane z = iris_z.
    point: vec3f,
    // Unit direction in the medium in front of the iris.
    direction: vec3f,
    // Fraction of the light that the interfaces let through, 0 to 1.
    transmittance: f32,
    // 1, or 0 when the ray misses the cornea or never reaches the plane.
    valid: f32,
}

// A camera further away than this is moved along its ray up to it, so that positions keep the
// precision of eye-sized numbers. Wider than any eye.
const CORNEA_NEARBY: f32 = 40.0;

fn cornea_trace_miss() -> CorneaTrace {
    return CorneaTrace(vec3f(0.0), vec3f(0.0), vec3f(0.0, 0.0, 1.0), 0.0, 0.0);
}

fn cornea_approach(origin: vec3f, dir: vec3f) -> vec3f {
    return origin + max(-dot(origin, dir) - CORNEA_NEARBY, 0.0) * dir;
}

// Two refracting surfaces: air, cornea, aqueous. The posterior surface's apex lies `thickness`
// behind the anterior one. Where the cornea's edge is so thick that the plane of the iris is met
// inside it, the ray ends there, in the cornea.
fn cornea_trace(
    origin: vec3f,
    dir: vec3f,
    anterior: vec2f,
    posterior: vec2f,
    thickness: f32,
    n_cornea: f32,
    n_aqueous: f32,
    iris_z: f32,
) -> CorneaTrace {
    var trace = cornea_trace_single(origin, dir, anterior, n_cornea, iris_z);
    if trace.valid == 0.0 {
        return trace;
    }
    let posterior_apex = vec3f(0.0, 0.0, thickness);
    let t = conicoid_intersect(trace.entry - posterior_apex, trace.direction, posterior.x, posterior.y);
    let back = trace.entry + t * trace.direction;
    if t < 0.0 || back.z >= iris_z {
        return trace;
    }
    let normal = conicoid_normal(back - posterior_apex, posterior.x, posterior.y);
    let refracted = snell_refract(trace.direction, normal, n_cornea / n_aqueous);
    if refracted.w == 0.0 || refracted.z <= 0.0 {
        return cornea_trace_miss();
    }
    let reflected = fresnel_dielectric(abs(dot(trace.direction, normal)), n_cornea, n_aqueous);
    trace.direction = refracted.xyz;
    trace.point = back + (iris_z - back.z) / refracted.z * refracted.xyz;
    trace.transmittance *= 1.0 - reflected;
    return trace;
}

// One refracting surface with index `n` behind it. With n = 1.336 it stands in for the two
// surfaces of a real cornea.
fn cornea_trace_single(origin: vec3f, dir: vec3f, surface: vec2f, n: f32, iris_z: f32) -> CorneaTrace {
    let start = cornea_approach(origin, dir);
    let t = conicoid_intersect(start, dir, surface.x, surface.y);
    let entry = start + t * dir;
    if t < 0.0 || entry.z >= iris_z {
        return cornea_trace_miss();
    }
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let cos_incidence = -dot(dir, normal);
    let refracted = snell_refract(dir, normal, 1.0 / n);
    if cos_incidence <= 0.0 || refracted.z <= 0.0 {
        return cornea_trace_miss();
    }
    let point = entry + (iris_z - entry.z) / refracted.z * refracted.xyz;
    let transmittance = 1.0 - fresnel_dielectric(cos_incidence, 1.0, n);
    return CorneaTrace(entry, point, refracted.xyz, transmittance, 1.0);
}

// Of the depth of the iris, where the plane lies on which parallax mapping errs least (`measure parallax-error`).
const PARALLAX_SHARE: f32 = 0.775;

// Where parallax mapping puts what a ray of this unit direction shows that enters at `entry`: straight on to a plane this deep (mm).
fn parallax_place(entry: vec3<f32>, direction: vec3<f32>, depth: f32) -> vec2<f32> {
    return entry.xy + direction.xy * ((depth - entry.z) / max(direction.z, 1e-6));
}
