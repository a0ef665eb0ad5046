//! The two-point problem of François et al. 2007, section 3, for a distant light: where does the
//! light that reaches a point of the iris enter the cornea?
//!
//! In: a point inside the eye, the unit direction towards the light, a surface, the index behind it.
//! Out: the entry point `K`.
//!
//! By Fermat's principle (equation 2) the optical path `Φ(x, y) = −L·K + n |K − P|` over the surface
//! points `K = (x, y, sag)` is stationary there. [`fermat_entry`] solves `∂Φ/∂(x, y) = 0`, which is
//! Snell's law in the tangent plane, by Newton's method with the analytic Hessian; a step that does
//! not shrink the residual is halved. [`fermat_gradient_descent`] is the paper's Algorithm 1, kept
//! as the baseline.
//!
//! **Convergence**, over pairs traced forward through a limbus of 5.85 mm onto iris radii 0 to
//! 5.85 mm, planes 3.0 to 4.2 mm deep, lights 0 to 85° off the axis, front-facing entry, R 7.8,
//! p 0.75, n 1.336: every pair converges, in 3.2 steps on average and 15 at most (to 1e-13). Beyond
//! 80° deep planes have a fold, and some points are reached by two paths; there the solver returns
//! the one in front of the fold. The numbers are those of `tests::every_legal_pair_converges`.
//!
//! Twin: `shaders/lib/fermat.wgsl`.

use super::conicoid::{conicoid_intersect, conicoid_normal, conicoid_sag};
use super::snell::snell_refract;
use glam::{DVec2, DVec3, DVec4};

/// Newton steps that are enough for a picture: see the table in the tests.
pub const FERMAT_STEPS: u32 = 6;
/// A solution leaves no more than this of the (unitless) tangential Snell residual.
const FERMAT_TOLERANCE: f64 = 1e-3;
const FERMAT_LONGEST_STEP: f64 = 2.0;

/// What the two-point solver found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FermatSolution {
    /// The entry point `K` on the anterior cornea (mm).
    pub entry: DVec3,
    /// Length of the remaining tangential Snell residual (unitless).
    pub residual: f64,
    /// Newton steps taken, halved ones included.
    pub iterations: u32,
    /// Whether `K` faces the light.
    pub faces_light: bool,
}

struct FermatResidual {
    gradient: DVec2,
    /// (xx, xy, yy).
    hessian: DVec3,
}

fn fermat_residual(
    k: DVec2,
    iris_point: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
) -> FermatResidual {
    let s = (surface.x * surface.x - surface.y * k.length_squared())
        .max(1e-6)
        .sqrt();
    let slope = k / s;
    let path = k.extend(k.length_squared() / (surface.x + s)) - iris_point;
    let inverse_length = 1.0 / path.length_squared().max(1e-12).sqrt();
    let u = path * inverse_length;
    let g = n * u - light_dir;
    let along = u.truncate() + slope * u.z;
    let m = n * inverse_length;
    let bend = g.z / s;
    let curve = surface.y * bend;
    FermatResidual {
        gradient: g.truncate() + slope * g.z,
        hessian: DVec3::new(
            m * (1.0 + slope.x * slope.x - along.x * along.x) + bend + curve * slope.x * slope.x,
            m * (slope.x * slope.y - along.x * along.y) + curve * slope.x * slope.y,
            m * (1.0 + slope.y * slope.y - along.y * along.y) + bend + curve * slope.y * slope.y,
        ),
    }
}

/// Where the straight line from the iris along `towards` leaves the eye.
fn fermat_exit(iris_point: DVec3, towards: DVec3, surface: DVec2) -> DVec3 {
    let t = conicoid_intersect(iris_point, towards, surface.x, surface.y);
    iris_point + t.max(0.0) * towards
}

/// The refracted start: the unrefracted line, then twice the refraction at the point found so far.
fn fermat_start(iris_point: DVec3, light_dir: DVec3, surface: DVec2, n: f64) -> DVec3 {
    let mut start = fermat_exit(iris_point, light_dir, surface);
    for _ in 0..2 {
        let normal = conicoid_normal(start, surface.x, surface.y);
        let inside = snell_refract(-light_dir, normal, 1.0 / n).truncate();
        start = fermat_exit(iris_point, -inside, surface);
    }
    start
}

/// Newton's method with at most `steps` steps; it ends early when the squared residual is below
/// `enough`.
pub fn fermat_solve(
    iris_point: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    steps: u32,
    enough: f64,
) -> FermatSolution {
    // Stay off the equator, where the sag has no derivative.
    let widest = if surface.y > 0.0 {
        0.95 * surface.x / surface.y.max(1e-6).sqrt()
    } else {
        1e3
    };
    let mut k = fermat_start(iris_point, light_dir, surface, n).truncate();
    let mut residual = fermat_residual(k, iris_point, light_dir, surface, n);
    let mut error = residual.gradient.length_squared();
    let mut step = DVec2::ZERO;
    let mut fresh = true;
    let mut iterations = 0;
    while iterations < steps {
        iterations += 1;
        if fresh {
            step = newton_step(&residual);
        } else {
            step *= 0.5;
        }
        let candidate = (k + step).clamp_length_max(widest);
        let attempt = fermat_residual(candidate, iris_point, light_dir, surface, n);
        let attempt_error = attempt.gradient.length_squared();
        fresh = attempt_error < error;
        if fresh {
            k = candidate;
            residual = attempt;
            error = attempt_error;
        }
        if error < enough {
            break;
        }
    }
    let entry = k.extend(conicoid_sag(k.length(), surface.x, surface.y));
    FermatSolution {
        entry,
        residual: error.sqrt(),
        iterations,
        faces_light: conicoid_normal(entry, surface.x, surface.y).dot(light_dir) > 0.0,
    }
}

fn newton_step(residual: &FermatResidual) -> DVec2 {
    let (h, g) = (residual.hessian, residual.gradient);
    let determinant = h.x * h.z - h.y * h.y;
    let safe = if determinant.abs() >= 1e-9 {
        determinant
    } else if determinant >= 0.0 {
        1e-9
    } else {
        -1e-9
    };
    let step = DVec2::new(h.y * g.y - h.z * g.x, h.y * g.x - h.x * g.y) / safe;
    step.clamp_length_max(FERMAT_LONGEST_STEP)
}

/// `xyz`: the point `K` of the anterior cornea where light from the unit direction `light_dir`
/// (towards the light, so `light_dir.z < 0` in front of the eye) enters to reach `iris_point`;
/// `w` = 1 when `K` faces the light and obeys Snell's law, otherwise 0. `K` may lie outside the
/// limbus: compare `length(K.xy)` with the limbus radius.
pub fn fermat_entry(
    iris_point: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    steps: u32,
) -> DVec4 {
    let solution = fermat_solve(iris_point, light_dir, surface, n, steps, 1e-26);
    let solved = solution.residual < FERMAT_TOLERANCE;
    let valid = solution.faces_light && solved && solution.entry.is_finite();
    solution.entry.extend(f64::from(u8::from(valid)))
}

/// Settings of [`fermat_gradient_descent`], named as in the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentSettings {
    /// First step on a tangent plane (mm): the paper's α = 0.05 in its centimetres.
    pub alpha_mm: f64,
    /// Most tangent planes, `M`.
    pub planes: u32,
    /// Most steps on a plane, `N`.
    pub steps: u32,
    /// Distance (mm) between a plane's best point and the surface that ends the search, ε.
    pub epsilon_mm: f64,
}

impl Default for DescentSettings {
    fn default() -> Self {
        Self {
            alpha_mm: 0.5,
            planes: 20,
            steps: 100,
            epsilon_mm: 1e-3,
        }
    }
}

/// Algorithm 1 of François et al. 2007 for a distant light: gradient descent of the optical path on
/// successive tangent planes, with steps of length `α/(j + 1)` (equation 6). Returns the estimate of
/// `K` and the number of gradient evaluations.
///
/// The step's length does not depend on the slope, so a plane's point is known no better than the
/// last step, `α/N`. A baseline for accuracy and cost, not for use.
pub fn fermat_gradient_descent(
    iris_point: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    settings: DescentSettings,
) -> (DVec3, u32) {
    let mut entry = fermat_exit(iris_point, light_dir, surface);
    let mut evaluations = 0;
    for _ in 0..settings.planes {
        let normal = conicoid_normal(entry, surface.x, surface.y);
        let mut on_plane = entry;
        for j in 0..settings.steps {
            let gradient = n * (on_plane - iris_point).normalize_or_zero() - light_dir;
            let tangential = gradient - gradient.dot(normal) * normal;
            evaluations += 1;
            let step = settings.alpha_mm / f64::from(j + 1);
            on_plane -= step * tangential.normalize_or_zero();
        }
        entry = fermat_exit(
            iris_point,
            (on_plane - iris_point).normalize_or(light_dir),
            surface,
        );
        if entry.distance(on_plane) < settings.epsilon_mm {
            break;
        }
    }
    (entry, evaluations)
}

#[cfg(test)]
mod tests;
