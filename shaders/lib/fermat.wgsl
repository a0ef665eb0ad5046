// needs: conicoid.wgsl
//
// The two-point problem of François et al. 2007, section 3, for a distant light: where does the
// light that reaches a point of the iris enter the cornea? By Fermat's principle (equation 2)
// the optical path Φ(x, y) = −L·K + n |K − P| over the surface points K = (x, y, sag) is
// stationary there. In place of the paper's gradient descent (Algorithm 1), a start from the
// osculating sphere and Newton's method on ∂Φ/∂(x, y) = 0 with the analytic Hessian. Optics frame,
// millimetres.
// Twin: src/optics/fermat.rs.

// Newton steps that are enough for a picture: see the table in the twin.
const FERMAT_STEPS: u32 = 6u;
// A solution leaves no more than this of the (unitless) tangential Snell residual.
const FERMAT_TOLERANCE: f32 = 1e-3;
const FERMAT_LONGEST_STEP: f32 = 2.0;
// Steps for the path length on the sphere.
const FERMAT_SPHERE_STEPS: u32 = 3u;

struct FermatResidual {
    // ∂Φ/∂(x, y): zero where Snell's law holds.
    gradient: vec2f,
    // Its derivative (xx, xy, yy).
    hessian: vec3f,
}

fn fermat_residual(k: vec2f, iris_point: vec3f, light_dir: vec3f, surface: vec2f, n: f32) -> FermatResidual {
    let s = sqrt(max(surface.x * surface.x - surface.y * dot(k, k), 1e-6));
    let slope = k / s;
    let path = vec3f(k, dot(k, k) / (surface.x + s)) - iris_point;
    let inverse_length = inverseSqrt(max(dot(path, path), 1e-12));
    let u = path * inverse_length;
    let g = n * u - light_dir;
    let along = u.xy + slope * u.z;
    let m = n * inverse_length;
    let bend = g.z / s;
    let curve = surface.y * bend;
    return FermatResidual(
        g.xy + slope * g.z,
        vec3f(
            m * (1.0 + slope.x * slope.x - along.x * along.x) + bend + curve * slope.x * slope.x,
            m * (slope.x * slope.y - along.x * along.y) + curve * slope.x * slope.y,
            m * (1.0 + slope.y * slope.y - along.y * along.y) + bend + curve * slope.y * slope.y,
        ),
    );
}

// The entry point on the sphere that osculates the apex, for a distant source: there
// K − O is parallel to L + x (P − O) with x = n/ℓ and ℓ = |K − P|: one equation in one unknown.
fn fermat_sphere_start(iris_point: vec3f, light_dir: vec3f, radius: f32, n: f32) -> vec2f {
    let p = iris_point - vec3f(0.0, 0.0, radius);
    let d_squared = dot(p, p);
    let c = dot(p, light_dir);
    let base = radius * radius + d_squared;
    // The unrefracted path is too long, the perpendicular one too short.
    let straight = sqrt(max(c * c + radius * radius - d_squared, 0.0)) - c;
    let shortest = abs(radius - sqrt(d_squared));
    var x = n / max(0.5 * (straight + shortest), 1e-3);
    for (var i = 0u; i < FERMAT_SPHERE_STEPS; i++) {
        let inverse_v = inverseSqrt(max(1.0 + x * (2.0 * c + x * d_squared), 1e-12));
        // P·K̂, and how it changes with x.
        let t = (c + x * d_squared) * inverse_v;
        let t_slope = (d_squared - t * t) * inverse_v;
        let inverse_l = inverseSqrt(max(base - 2.0 * radius * t, 1e-12));
        let residual = x - n * inverse_l;
        let slope = 1.0 - n * radius * t_slope * inverse_l * inverse_l * inverse_l;
        // Where the sphere has a fold the slope vanishes: the step stays finite there.
        x = max(x - residual / max(slope, 0.1), 1e-6);
    }
    let v = light_dir + x * p;
    return v.xy * (radius * inverseSqrt(max(dot(v, v), 1e-12)));
}

// xyz: the point K of the anterior cornea where light from the unit direction `light_dir`
// (towards the light, so light_dir.z < 0 in front of the eye) enters to reach `iris_point`;
// w = 1 when K faces the light and obeys Snell's law, otherwise 0. K may lie outside the limbus:
// compare length(K.xy) with the limbus radius.
fn fermat_entry(iris_point: vec3f, light_dir: vec3f, surface: vec2f, n: f32, steps: u32) -> vec4f {
    // Stay off the equator, where the sag has no derivative.
    let widest = select(1e3, 0.95 * surface.x / sqrt(max(surface.y, 1e-6)), surface.y > 0.0);

    var k = fermat_sphere_start(iris_point, light_dir, surface.x, n);
    k *= min(1.0, widest * inverseSqrt(max(dot(k, k), 1e-12)));
    var residual = fermat_residual(k, iris_point, light_dir, surface, n);
    var error = dot(residual.gradient, residual.gradient);
    var step = vec2f(0.0);
    var fresh = true;
    for (var i = 0u; i < steps; i++) {
        if fresh {
            let h = residual.hessian;
            let g = residual.gradient;
            let determinant = h.x * h.z - h.y * h.y;
            let safe = select(determinant, select(-1e-9, 1e-9, determinant >= 0.0), abs(determinant) < 1e-9);
            step = vec2f(h.y * g.y - h.z * g.x, h.y * g.x - h.x * g.y) / safe;
            step *= min(1.0, FERMAT_LONGEST_STEP * inverseSqrt(max(dot(step, step), 1e-12)));
        } else {
            step *= 0.5;
        }
        var candidate = k + step;
        candidate *= min(1.0, widest * inverseSqrt(max(dot(candidate, candidate), 1e-12)));
        let attempt = fermat_residual(candidate, iris_point, light_dir, surface, n);
        let attempt_error = dot(attempt.gradient, attempt.gradient);
        fresh = attempt_error < error;
        if fresh {
            k = candidate;
            residual = attempt;
            error = attempt_error;
        }
        // Below the rounding of f32 there is nothing left to gain.
        if error < 1e-13 {
            break;
        }
    }
    let entry = vec3f(k, conicoid_sag(length(k), surface.x, surface.y));
    let faces_light = dot(conicoid_normal(entry, surface.x, surface.y), light_dir) > 0.0;
    let solved = error < FERMAT_TOLERANCE * FERMAT_TOLERANCE;
    return vec4f(entry, select(0.0, 1.0, faces_light && solved));
}
