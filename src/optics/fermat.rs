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
//! 3. **A fallback** ([`fermat_solve_surely`]): steps down the path's length, halved until `Φ` falls,
//!    so that they converge to a minimum of `Φ`, which is a path in front of any fold.
//!
//! **Convergence**, over pairs traced forward through a limbus of 5.85 mm onto an iris plane 3.6 mm
//! deep, sources of the whole hemisphere, exit incidence up to 80°, R 7.8, p 0.75, n 1.336: every
//! pair, in 2.9 steps on average and 4 at most, to 2e-11 mm. To 90° every pair in front of the fold
//! converges as far as it is conditioned. A distant source is the limit `1/distance = 0` of the same
//! expressions, not a case of its own.
//!
//! [`descent`](super::reference::descent) holds the paper's Algorithm 1 as the baseline, [`two_surfaces`] the same problem
//! through both surfaces of the cornea.

pub mod two_surfaces;

use super::conicoid::{conicoid_normal, conicoid_sag};
use glam::{DVec2, DVec3, DVec4};

/// Newton steps that are enough for every legal pair (exit incidence to 80°): see the tests.
pub const FERMAT_STEPS: u32 = 6;
/// A solution leaves no more than this of the (unitless) tangential Snell residual.
const FERMAT_TOLERANCE: f64 = 1e-3;
/// Longest step of Newton's method (mm).
const FERMAT_LONGEST_STEP: f64 = 2.0;
/// Most steps of the fallback.
const FERMAT_FALLBACK_STEPS: u32 = 60;
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

#[derive(Clone, Copy)]
struct FermatResidual {
    gradient: DVec2,
    /// (xx, xy, yy).
    hessian: DVec3,
}

impl FermatResidual {
    fn curvature(&self) -> f64 {
        let h = self.hessian;
        // Positive for a minimum; a maximum counts as negative too.
        let determinant = h.x * h.z - h.y * h.y;
        if h.x + h.z > 0.0 {
            determinant
        } else {
            -determinant.abs()
        }
    }
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
/// residual is below `enough`, or where a step does not shrink it.
///
/// Finite for every finite argument; where there is no path, `residual` stays large or `faces_light`
/// is false. [`fermat_solve_surely`] searches on where this fails.
pub fn fermat_solve_from(
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
    steps: u32,
    enough: f64,
) -> FermatSolution {
    let widest = fermat_widest(surface);
    let mut k = fermat_start(iris_point, source, surface, n).clamp_length_max(widest);
    let mut residual = fermat_residual(k, iris_point, source, surface, n);
    let mut error = residual.gradient.length_squared();
    let (mut iterations, mut share) = (0, 1.0);
    while iterations < steps && error >= enough {
        iterations += 1;
        let candidate = (k + share * newton_step(&residual)).clamp_length_max(widest);
        let attempt = fermat_residual(candidate, iris_point, source, surface, n);
        let attempt_error = attempt.gradient.length_squared();
        if attempt_error < error {
            (k, residual, error, share) = (candidate, attempt, attempt_error, 1.0);
        } else {
            share *= 0.5;
        }
    }
    conclude(k, &residual, iterations, source, surface)
}

fn conclude(
    k: DVec2,
    residual: &FermatResidual,
    iterations: u32,
    source: &FermatSource,
    surface: DVec2,
) -> FermatSolution {
    let entry = k.extend(conicoid_sag(k.length(), surface.x, surface.y));
    FermatSolution {
        entry,
        residual: residual.gradient.length(),
        iterations,
        faces_light: conicoid_normal(entry, surface.x, surface.y).dot(source.from(entry)) > 0.0,
        curvature: residual.curvature(),
    }
}

/// [`fermat_solve_from`] and, where that has not come to a shortest path that faces the source, a
/// search: minimisation of the path, from the same start and then from the most promising places of
/// a grid over the cornea. `None` where that finds nothing either: no light arrives. For tables and
/// references; a dark place costs 0.1 ms.
pub fn fermat_solve_surely(
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
) -> Option<FermatSolution> {
    let sound = |found: &FermatSolution| {
        found.residual < 1e-9 && found.curvature > 0.0 && found.faces_light
    };
    let newton = fermat_solve_from(iris_point, source, surface, n, 8 * FERMAT_STEPS, 1e-28);
    if sound(&newton) {
        return Some(newton);
    }
    let widest = fermat_widest(surface);
    let mut starts: Vec<(f64, DVec2)> = (0..16)
        .flat_map(|ring| (0..32).map(move |turn| (ring, turn)))
        .map(|(ring, turn)| {
            let radius = widest * (f64::from(ring) + 0.5) / 16.0;
            let k = radius * DVec2::from_angle(f64::from(turn) * core::f64::consts::TAU / 32.0);
            let residual = fermat_residual(k, iris_point, source, surface, n);
            let entry = k.extend(conicoid_sag(radius, surface.x, surface.y));
            let normal = conicoid_normal(entry, surface.x, surface.y);
            // Away from the light no path begins; where the path is not convex none is shortest.
            let lit = normal.dot(source.from(entry)) > 0.0 && residual.curvature() > 0.0;
            let slope = residual.gradient.length_squared();
            (if lit { slope } else { f64::INFINITY }, k)
        })
        .filter(|(slope, _)| slope.is_finite())
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = fermat_start(iris_point, source, surface, n).clamp_length_max(widest);
    core::iter::once(first)
        .chain(starts.into_iter().map(|(_, k)| k).take(8))
        .map(|start| {
            let (k, residual, iterations) =
                fermat_descend(start, newton.iterations, iris_point, source, surface, n);
            conclude(k, &residual, iterations, source, surface)
        })
        .find(sound)
}

/// How far out the solver looks: off the equator, where the sag has no derivative.
fn fermat_widest(surface: DVec2) -> f64 {
    if surface.y > 0.0 {
        0.95 * surface.x / surface.y.max(1e-6).sqrt()
    } else {
        1e3
    }
}

/// Minimises the optical path: Newton's step where the path is convex, a step down its slope where
/// it is not, halved until the path is shorter. Between two such steps the path only falls, so that
/// it cannot cycle or run to a saddle.
#[cold]
fn fermat_descend(
    start: DVec2,
    taken: u32,
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
) -> (DVec2, FermatResidual, u32) {
    let widest = fermat_widest(surface);
    let mut k = start;
    let mut length = fermat_path(k, iris_point, source, surface, n);
    let mut residual = fermat_residual(k, iris_point, source, surface, n);
    let mut iterations = taken;
    for _ in 0..FERMAT_FALLBACK_STEPS {
        if residual.gradient.length_squared() < 1e-28 {
            break;
        }
        iterations += 1;
        let h = residual.hessian;
        let least = 0.5 * (h.x + h.z) - (0.5 * (h.x - h.z)).hypot(h.y);
        let shift = (1e-3 - least).max(0.0);
        let convex = FermatResidual {
            hessian: h + DVec3::new(shift, 0.0, shift),
            ..residual
        };
        let step = newton_step(&convex);
        let mut share = 1.0;
        let mut better = None;
        for _ in 0..30 {
            let candidate = (k + share * step).clamp_length_max(widest);
            let tried = fermat_path(candidate, iris_point, source, surface, n);
            let attempt = fermat_residual(candidate, iris_point, source, surface, n);
            // Near the minimum the path's length is flat to rounding and the slope decides.
            let flatter = attempt.gradient.length_squared() < residual.gradient.length_squared();
            if tried < length || (flatter && tried - length < 1e-14 * length.abs()) {
                better = Some((candidate, tried, attempt));
                break;
            }
            share *= 0.5;
        }
        let Some((candidate, tried, attempt)) = better else {
            break;
        };
        (k, length, residual) = (candidate, tried, attempt);
    }
    // The path's length is flat to 1e-8 mm about its minimum; its slope is not.
    for _ in 0..4 {
        let candidate = (k + newton_step(&residual)).clamp_length_max(widest);
        let attempt = fermat_residual(candidate, iris_point, source, surface, n);
        if attempt.gradient.length_squared() < residual.gradient.length_squared() {
            (k, residual) = (candidate, attempt);
        }
    }
    (k, residual, iterations)
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

/// Newton's step (mm) from `k`.
#[inline]
pub fn fermat_newton_step(
    k: DVec2,
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
) -> DVec2 {
    newton_step(&fermat_residual(k, iris_point, source, surface, n))
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
