//! Algorithm 1 of François et al. 2007: the baseline for accuracy and cost, not for use.

use super::super::conicoid::{conicoid_intersect, conicoid_normal};
use super::super::fermat::FermatSource;
use glam::{DVec2, DVec3};

/// Where the straight line from the iris along `towards` leaves the eye.
fn fermat_exit(iris_point: DVec3, towards: DVec3, surface: DVec2) -> DVec3 {
    let t = conicoid_intersect(iris_point, towards, surface.x, surface.y);
    iris_point + t.max(0.0) * towards
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
    /// Scale `α_j` below which the search on a plane ends, ε′ of equation 5. By equation 6 the scale
    /// is the step divided by the gradient, which vanishes at the goal: the paper gives no value, and
    /// the default leaves all `N` steps.
    pub scale_epsilon: f64,
}

impl Default for DescentSettings {
    fn default() -> Self {
        Self {
            alpha_mm: 0.5,
            planes: 20,
            steps: 100,
            epsilon_mm: 1e-3,
            scale_epsilon: 0.0,
        }
    }
}

/// Algorithm 1 of François et al. 2007: gradient descent of the optical path on
/// successive tangent planes, with steps of length `α/(j + 1)` (equation 6). Returns the estimate of
/// `K` and the number of gradient evaluations.
///
/// The step's length does not depend on the slope, so a plane's point is known no better than the
/// last step, `α/N`. A baseline for accuracy and cost, not for use.
pub fn fermat_gradient_descent(
    iris_point: DVec3,
    source: &FermatSource,
    surface: DVec2,
    n: f64,
    settings: DescentSettings,
) -> (DVec3, u32) {
    // K₀⁰: where the straight line from the iris to the source leaves the eye.
    let to_source = match source.inverse_distance {
        0.0 => source.direction,
        q => (source.direction / q - iris_point).normalize_or(source.direction),
    };
    let mut entry = fermat_exit(iris_point, to_source, surface);
    let mut evaluations = 0;
    for _ in 0..settings.planes {
        let normal = conicoid_normal(entry, surface.x, surface.y);
        let mut on_plane = entry;
        for j in 0..settings.steps {
            // Equation 7: the gradient of |CK| + n |KP|, less its part along the normal.
            let gradient = n * (on_plane - iris_point).normalize_or_zero() - source.from(on_plane);
            let tangential = gradient - gradient.dot(normal) * normal;
            evaluations += 1;
            let length = tangential.length();
            let step = settings.alpha_mm / f64::from(j + 1);
            if length == 0.0 || step / length < settings.scale_epsilon {
                break;
            }
            on_plane -= step / length * tangential;
        }
        entry = fermat_exit(
            iris_point,
            (on_plane - iris_point).normalize_or(to_source),
            surface,
        );
        if entry.distance(on_plane) < settings.epsilon_mm {
            break;
        }
    }
    (entry, evaluations)
}
