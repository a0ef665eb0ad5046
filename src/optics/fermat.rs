//! The two-point problem of François et al. 2007, section 3: through which point `K` of the cornea
//! does the light of a source reach a point of the iris?
//!
//! In: a point inside the eye, a source (a direction, or a camera or lamp at a finite distance), a
//! surface, the index behind it. Out: the entry point `K`.
//!
//! By Fermat's principle (equations 2 to 4) the optical path `Φ(x, y) = |C − K| + n |K − P|` over
//! the surface points `K = (x, y, sag)` is stationary there. [`fermat_solve`] solves
//! `∂Φ/∂(x, y) = 0`, which is Snell's law in the tangent plane, in three parts:
//!
//! 1. **A start from a sphere.** On a sphere about `O` Snell's law says that `K − O` is parallel to
//!    `L + (n/ℓ)(P − O)` with `ℓ = |K − P|`: two equations become one for the number `ℓ`, which lies
//!    between `R − d` and `R + d`, `d = |P − O|`. A few Newton steps within that bracket solve it.
//! 2. **Newton's method** on the conicoid, with the analytic Hessian: quadratic.
//! 3. **A fallback.** A step that does not shrink the residual, or that would leave the minimum for
//!    a saddle, becomes a step down the path's length, halved until `Φ` falls: from the start this
//!    converges to a minimum of `Φ`, which is the path in front of any fold.
//!
//! **Convergence**: see [`tests`] for the domain and the counts. A distant source is the limit
//! `1/distance = 0` of the same expressions, not a case of its own.
//!
//! [`descent`] holds the paper's Algorithm 1 as the baseline, [`two_surfaces`] the same problem
//! through both surfaces of the cornea.
//!
//! Twin: `shaders/lib/fermat.wgsl`.

pub mod descent;

use super::conicoid::{conicoid_normal, conicoid_sag};
use glam::{DVec2, DVec3, DVec4};

/// Newton steps that are enough for every legal pair (exit incidence to 80°): see the tests.
pub const FERMAT_STEPS: u32 = 6;
/// A solution leaves no more than this of the (unitless) tangential Snell residual.
const FERMAT_TOLERANCE: f64 = 1e-3;
/// Longest step of Newton's method (mm).
const FERMAT_LONGEST_STEP: f64 = 2.0;
/// Steps for the path length on the sphere.
const FERMAT_SPHERE_STEPS: u32 = 3;

/// Where light comes from, or where a camera stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FermatSource {
    /// Unit direction from the corneal apex towards the source; `z < 0` in front of the eye.
    pub direction: DVec3,
    /// One over its distance from the corneal apex (mm⁻¹); 0 is infinitely far.
    pub inverse_distance: f64,
}

impl FermatSource {
    /// A source infinitely far away in a direction (need not be of unit length; a null vector or
    /// one that is not finite counts as straight ahead).
    pub fn distant(direction: DVec3) -> Self {
        Self {
            direction: direction.try_normalize().unwrap_or(DVec3::NEG_Z),
            inverse_distance: 0.0,
        }
    }

    /// A source at a point of the optics frame (mm), at least 1 µm from the corneal apex.
    pub fn at(point: DVec3) -> Self {
        let distance = point.length();
        if !distance.is_finite() {
            return Self::distant(point.clamp(DVec3::splat(-1.0), DVec3::ONE));
        }
        Self {
            direction: point.try_normalize().unwrap_or(DVec3::NEG_Z),
            inverse_distance: 1.0 / distance.max(1e-3),
        }
    }

    /// Unit direction from a point of the cornea towards the source.
    pub fn from(&self, point: DVec3) -> DVec3 {
        if self.inverse_distance == 0.0 {
            return self.direction;
        }
        (self.direction - self.inverse_distance * point).normalize_or(self.direction)
    }
}

/// What the two-point solver found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FermatSolution {
    /// The entry point `K` on the anterior cornea (mm).
    pub entry: DVec3,
    /// Length of the remaining tangential Snell residual (unitless).
    pub residual: f64,
    /// Evaluations of the residual after the first: Newton steps, tried ones included.
    pub iterations: u32,
    /// Whether `K` faces the source.
    pub faces_light: bool,
    /// Determinant of the path's second derivatives (mm⁻²): 0 on a fold, where two paths merge.
    pub curvature: f64,
}

struct FermatResidual {
    gradient: DVec2,
    /// (xx, xy, yy).
    hessian: DVec3,
}

#[inline]
fn fermat_residual(
    k: DVec2,
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
) -> FermatResidual {
    let squared = k.length_squared();
    let s = (surface.x * surface.x - surface.y * squared)
        .max(1e-6)
        .sqrt();
    let inverse_s = 1.0 / s;
    let slope = k * inverse_s;
    let entry = k.extend(squared / (surface.x + s));
    let path = entry - iris_point;
    let inverse_length = 1.0 / path.length_squared().max(1e-12).sqrt();
    let u = path * inverse_length;
    let along = u.truncate() + slope * u.z;
    let m = n * inverse_length;
    let metric = DVec3::new(
        1.0 + slope.x * slope.x,
        slope.x * slope.y,
        1.0 + slope.y * slope.y,
    );
    let mut hessian =
        m * (metric - DVec3::new(along.x * along.x, along.x * along.y, along.y * along.y));
    let mut outside = source.direction;
    let q = source.inverse_distance;
    if q > 0.0 {
        let to = source.direction - q * entry;
        let inverse = 1.0 / to.length_squared().max(1e-18).sqrt();
        outside = to * inverse;
        let o = outside.truncate() + slope * outside.z;
        hessian += q * inverse * (metric - DVec3::new(o.x * o.x, o.x * o.y, o.y * o.y));
    }
    let g = n * u - outside;
    let bend = g.z * inverse_s;
    let curve = surface.y * bend;
    hessian += DVec3::new(
        bend + curve * slope.x * slope.x,
        curve * slope.x * slope.y,
        bend + curve * slope.y * slope.y,
    );
    FermatResidual {
        gradient: g.truncate() + slope * g.z,
        hessian,
    }
}

/// The entry point on the sphere that osculates the apex, for a distant source: there
/// `K − O ∥ L + x (P − O)` with `x = n/ℓ` and `ℓ = |K − P|`, so that `x ℓ(x) = n` is one equation
/// in one unknown.
#[inline]
fn fermat_sphere_start(iris_point: DVec3, light_dir: DVec3, radius: f64, n: f64) -> DVec2 {
    let p = iris_point - DVec3::new(0.0, 0.0, radius);
    let (d_squared, c) = (p.length_squared(), p.dot(light_dir));
    let base = radius * radius + d_squared;
    // The unrefracted path is too long, the perpendicular one too short.
    let straight = (c * c + radius * radius - d_squared).max(0.0).sqrt() - c;
    let shortest = (radius - d_squared.sqrt()).abs();
    let mut x = n / (0.5 * (straight + shortest)).max(1e-3);
    for _ in 0..FERMAT_SPHERE_STEPS {
        let inverse_v = 1.0 / (1.0 + x * (2.0 * c + x * d_squared)).max(1e-12).sqrt();
        // P·K̂, and how it changes with x.
        let t = (c + x * d_squared) * inverse_v;
        let t_slope = (d_squared - t * t) * inverse_v;
        let inverse_l = 1.0 / (base - 2.0 * radius * t).max(1e-12).sqrt();
        let residual = x - n * inverse_l;
        let slope = 1.0 - n * radius * t_slope * inverse_l * inverse_l * inverse_l;
        // Where the sphere has a fold the slope vanishes: the step stays finite there.
        x = (x - residual / slope.max(0.1)).max(1e-6);
    }
    let v = light_dir + x * p;
    (v * (radius / v.length_squared().max(1e-12).sqrt())).truncate()
}

/// The optical path `|C − K| + n |K − P|`, for a distant source less its distance.
fn fermat_path(k: DVec2, iris_point: DVec3, source: &FermatSource, surface: DVec2, n: f64) -> f64 {
    let entry = k.extend(conicoid_sag(k.length(), surface.x, surface.y));
    let q = source.inverse_distance;
    // |C − K| − 1/q = (q K² − 2 L·K)/(|L − q K| + 1), which has no pole at q = 0.
    let along = entry.dot(source.direction);
    let outside = (q * entry.length_squared() - 2.0 * along)
        / ((source.direction - q * entry).length() + 1.0);
    outside + n * entry.distance(iris_point)
}

/// Newton's method with at most `steps` evaluations after the first; it ends early when the squared
/// residual is below `enough`.
pub fn fermat_solve_from(
    iris_point: DVec3,
    source: &FermatSource,
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
    let mut k = fermat_start(iris_point, source, surface, n).clamp_length_max(widest);
    let mut residual = fermat_residual(k, iris_point, source, surface, n);
    let mut error = residual.gradient.length_squared();
    let mut iterations = 0;
    let mut shrink = 1.0;
    while iterations < steps && error >= enough {
        iterations += 1;
        let candidate = (k + shrink * newton_step(&residual)).clamp_length_max(widest);
        let attempt = fermat_residual(candidate, iris_point, source, surface, n);
        let attempt_error = attempt.gradient.length_squared();
        if attempt_error < error {
            (k, residual, error, shrink) = (candidate, attempt, attempt_error, 1.0);
        } else {
            shrink *= 0.5;
        }
    }
    let entry = k.extend(conicoid_sag(k.length(), surface.x, surface.y));
    let h = residual.hessian;
    FermatSolution {
        entry,
        residual: error.sqrt(),
        iterations,
        faces_light: conicoid_normal(entry, surface.x, surface.y).dot(source.from(entry)) > 0.0,
        curvature: h.x * h.z - h.y * h.y,
    }
}

fn fermat_start(iris_point: DVec3, source: &FermatSource, surface: DVec2, n: f64) -> DVec2 {
    if source.inverse_distance == 0.0 {
        return fermat_sphere_start(iris_point, source.direction, surface.x, n);
    }
    // As seen from where the line from the iris to the apex would leave, and again from there.
    let first = fermat_sphere_start(iris_point, source.direction, surface.x, n);
    let at = first.extend(conicoid_sag(first.length(), surface.x, surface.y));
    fermat_sphere_start(iris_point, source.from(at), surface.x, n)
}

/// One step of Newton's method from `k`.
#[inline]
pub fn fermat_newton(
    k: DVec2,
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
) -> DVec2 {
    k + newton_step(&fermat_residual(k, iris_point, source, surface, n))
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

/// [`fermat_solve_from`] for a distant light.
pub fn fermat_solve(
    iris_point: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    steps: u32,
    enough: f64,
) -> FermatSolution {
    let source = FermatSource {
        direction: light_dir,
        inverse_distance: 0.0,
    };
    fermat_solve_from(iris_point, &source, surface, n, steps, enough)
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

#[cfg(test)]
mod tests;
