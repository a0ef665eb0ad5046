// The corneal conicoid of François et al. 2007, equation 1:
//     p z² − 2 R z + x² + y² = 0
// Origin at the apex, +z into the eye, millimetres. R is the apical radius, p the shape
// factor (1 sphere, 0 paraboloid, below 0 hyperboloid). Only the front sheet, R − p z ≥ 0, is
// the eye's surface.
// Twin: src/optics/conicoid.rs.

// Coefficients of t² smaller than this put the root further away than any eye is wide.
const CONICOID_FLAT_QUADRATIC: f32 = 1e-6;

// Distance along `dir` (in lengths of `dir`) to the nearest point at or ahead of `origin` on
// the front sheet, or −1 when the ray misses it.
fn conicoid_intersect(origin: vec3f, dir: vec3f, radius: f32, p: f32) -> f32 {
    let dir_squared = dot(dir, dir);
    if !(dir_squared > 0.0 && radius > 0.0) {
        return -1.0;
    }
    // From the point of closest approach to the apex every coefficient is of the eye's size,
    // however far away the camera stands.
    let shift = -dot(origin, dir) / dir_squared;
    let o = origin + shift * dir;
    let a = p * dir.z * dir.z + dir.x * dir.x + dir.y * dir.y;
    let b = p * o.z * dir.z - radius * dir.z + o.x * dir.x + o.y * dir.y;
    let c = p * o.z * o.z - 2.0 * radius * o.z + o.x * o.x + o.y * o.y;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return -1.0;
    }
    // Both roots without subtracting nearly equal numbers: t₁ = q/a, t₂ = c/q.
    let q = -(b + select(-1.0, 1.0, b >= 0.0) * sqrt(discriminant));
    var nearest = -1.0;
    if abs(a) > CONICOID_FLAT_QUADRATIC * dir_squared {
        nearest = conicoid_nearer(nearest, q / a, shift, o.z, dir.z, radius, p);
    }
    if q != 0.0 {
        nearest = conicoid_nearer(nearest, c / q, shift, o.z, dir.z, radius, p);
    }
    return nearest;
}

// The smaller of `nearest` (−1: none yet) and the root `t`, if that lies ahead of the origin
// and on the front sheet.
fn conicoid_nearer(nearest: f32, t: f32, shift: f32, o_z: f32, dir_z: f32, radius: f32, p: f32) -> f32 {
    let forward = t + shift;
    let on_front_sheet = radius - p * (o_z + t * dir_z) >= 0.0;
    if forward >= 0.0 && on_front_sheet && (nearest < 0.0 || forward < nearest) {
        return forward;
    }
    return nearest;
}

// Unit normal at a point of the surface, pointing out of the eye (−z at the apex).
fn conicoid_normal(point: vec3f, radius: f32, p: f32) -> vec3f {
    let gradient = vec3f(point.xy, p * point.z - radius);
    let squared = dot(gradient, gradient);
    if !(squared > 0.0) {
        return vec3f(0.0, 0.0, -1.0);
    }
    return gradient * inverseSqrt(squared);
}
