// needs: conicoid.wgsl, snell.wgsl
//
// The two-point problem of François et al. 2007, section 3, for a distant light: where does the
// light that reaches a point of the iris enter the cornea? By Fermat's principle (equation 2)
// the optical path Φ(x, y) = −L·K + n |K − P| over the surface points K = (x, y, sag) is
// stationary there. In place of the paper's gradient descent (Algorithm 1), Newton's method on
// ∂Φ/∂(x, y) = 0 with the analytic Hessian. Optics frame, millimetres.
// Twin: src/optics/fermat.rs.

// Newton steps that are enough for a picture: see the table in the twin.
const FERMAT_STEPS: u32 = 6u;
// A solution leaves no more than this of the (unitless) tangential Snell residual.
const FERMAT_TOLERANCE: f32 = 1e-3;
const FERMAT_LONGEST_STEP: f32 = 2.0;

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

// Entry point of the straight line from the iris towards `towards`.
fn fermat_exit(iris_point: vec3f, towards: vec3f, surface: vec2f) -> vec3f {
    let t = conicoid_intersect(iris_point, towards, surface.x, surface.y);
    return iris_point + max(t, 0.0) * towards;
}

// xyz: the point K of the anterior cornea where light from the unit direction `light_dir`
// (towards the light, so light_dir.z < 0 in front of the eye) enters to reach `iris_point`;
// w = 1 when K faces the light and obeys Snell's law, otherwise 0. K may lie outside the limbus:
// compare length(K.xy) with the limbus radius.
fn fermat_entry(iris_point: vec3f, light_dir: vec3f, surface: vec2f, n: f32, steps: u32) -> vec4f {
    // Start: the unrefracted line, then twice the refraction at the point found so far.
    var start = fermat_exit(iris_point, light_dir, surface);
    for (var i = 0u; i < 2u; i++) {
        let inside = snell_refract(-light_dir, conicoid_normal(start, surface.x, surface.y), 1.0 / n);
        start = fermat_exit(iris_point, -inside.xyz, surface);
    }
    // Stay off the equator, where the sag has no derivative.
    let widest = select(1e3, 0.95 * surface.x / sqrt(max(surface.y, 1e-6)), surface.y > 0.0);

    var k = start.xy;
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
