//! The gradient index of a crystalline lens, and curved rays through it.
//!
//! In: a parabolic index distribution, a ray, the surface that ends it. Out: the ray there and its
//! optical path.
//!
//! `n(r, z) = n₀ + n₁ ζ + n₂ ζ² + n_r r²`, ζ measured from a plane of the lens: the form of Liou &
//! Brennan 1997 (J. Opt. Soc. Am. A 14, 1684) and Atchison 2006 (Vision Res. 46, 2236), who use one
//! for the anterior and one for the posterior part. Rays obey `d²R/dt² = n ∇n` with `dt = ds/n`,
//! integrated by the fourth-order scheme of Sharma, Kumar & Ghatak 1982 (Appl. Opt. 21, 984).

use super::super::surface::{Crossing, Placed};
use super::Ray;
use glam::DVec3;

/// Step in `t` = length / index (mm). Errors fall with its fourth power; at this step a lens is
/// crossed to 3e-10 mm and 1e-10 rad, its optical path to 2e-9 mm, 3e-6 of a wavelength.
const STEP_MM: f64 = 0.05;
/// Longest path in a lens, in `t` (mm): wider than any.
const LONGEST_MM: f64 = 30.0;

/// A parabolic index distribution about the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensGradient {
    /// Depth of the plane ζ = 0 in the optics frame (mm).
    pub z_mm: f64,
    /// Index on the axis at ζ = 0, its slope (1/mm), and half its second derivative (1/mm²).
    pub axial: [f64; 3],
    /// Coefficient of r² (1/mm²); negative in a lens that converges light.
    pub radial: f64,
}

/// A ray that has arrived at the surface that ends a gradient.
pub(super) struct Arrival {
    pub(super) ray: Ray,
    pub(super) optical_path_mm: f64,
}

/// Position and optical direction `T = n d`.
#[derive(Clone, Copy)]
struct State {
    r: DVec3,
    t: DVec3,
}

impl LensGradient {
    /// Index at a point of the optics frame.
    pub fn index(&self, point: DVec3) -> f64 {
        let zeta = point.z - self.z_mm;
        let [n0, n1, n2] = self.axial;
        n0 + zeta * (n1 + zeta * n2) + self.radial * (point.x * point.x + point.y * point.y)
    }

    /// `n ∇n`.
    fn force(&self, point: DVec3) -> DVec3 {
        let radial = 2.0 * self.radial;
        let axial = self.axial[1] + 2.0 * self.axial[2] * (point.z - self.z_mm);
        self.index(point) * DVec3::new(radial * point.x, radial * point.y, axial)
    }

    fn step(&self, s: State, h: f64) -> State {
        let a = h * self.force(s.r);
        let b = h * self.force(s.r + h * (0.5 * s.t + 0.125 * a));
        let c = h * self.force(s.r + h * (s.t + 0.5 * b));
        State {
            r: s.r + h * (s.t + (a + 2.0 * b) / 6.0),
            t: s.t + (a + 4.0 * b + c) / 6.0,
        }
    }

    /// `∫ n² dt` over a step, from n² and its slope `2 n ∇n · T` at both ends and n² in the middle
    /// (Lobatto's rule with derivatives, seventh order). The middle is that of the quintic through
    /// position, direction and curvature at both ends.
    fn path(&self, from: State, to: State, h: f64) -> f64 {
        let (f0, f1) = (self.force(from.r), self.force(to.r));
        let middle = 0.5 * (from.r + to.r) + h * (0.15625 * (from.t - to.t) + h / 64.0 * (f0 + f1));
        let squared = |r: DVec3| self.index(r).powi(2);
        h / 30.0 * (7.0 * (squared(from.r) + squared(to.r)) + 16.0 * squared(middle))
            + h * h / 30.0 * (f0.dot(from.t) - f1.dot(to.t))
    }

    /// Follows `ray` to `end`; `None` when it does not get there.
    #[inline(never)]
    pub(super) fn march(&self, ray: Ray, end: &Placed, crossing: Crossing) -> Option<Arrival> {
        self.march_by(STEP_MM, ray, end, crossing)
    }

    pub(super) fn march_by(
        &self,
        step_mm: f64,
        ray: Ray,
        end: &Placed,
        crossing: Crossing,
    ) -> Option<Arrival> {
        let side = match crossing {
            Crossing::Inward => 1.0,
            Crossing::Outward => -1.0,
        };
        // The implicit function: positive until `end` is crossed.
        let ahead = |r: DVec3| {
            let local = end.to_local(r);
            side * (local.dot(end.surface.curvature * local) - 2.0 * local.z)
        };
        let mut state = State {
            r: ray.origin,
            t: self.index(ray.origin) * ray.direction,
        };
        let mut optical_path_mm = 0.0;
        for _ in 0..(LONGEST_MM / step_mm) as u32 {
            let next = self.step(state, step_mm);
            // Also ends on what is not a number.
            if ahead(next.r) > 0.0 {
                optical_path_mm += self.path(state, next, step_mm);
                state = next;
                continue;
            }
            let (last, h) = self.last_step(state, step_mm, end)?;
            let direction = last.t.try_normalize()?;
            let forward = h >= -super::TOUCHING_MM && last.r.is_finite();
            return forward.then(|| Arrival {
                ray: Ray {
                    origin: last.r,
                    direction,
                },
                optical_path_mm: optical_path_mm + self.path(state, last, h),
            });
        }
        None
    }

    /// The step that ends on the surface, by Newton's method on the step's length.
    fn last_step(&self, from: State, step_mm: f64, end: &Placed) -> Option<(State, f64)> {
        let mut h = 0.5 * step_mm;
        for _ in 0..12 {
            let at = self.step(from, h);
            let local = end.to_local(at.r);
            let value = local.dot(end.surface.curvature * local) - 2.0 * local.z;
            let slope = 2.0
                * end
                    .surface
                    .gradient(local)
                    .dot(end.direction_to_local(at.t));
            let change = value / slope;
            h -= change;
            if change.abs() < 1e-14 {
                return Some((self.step(from, h), h));
            }
        }
        None
    }
}
