//! Skew rays through any sequence of refracting surfaces, into the eye or out of it.
//!
//! In: a list of [`Interface`]s in the order in which light enters the eye, and a ray of the optics
//! frame (mm, +z into the eye). Out: the ray behind the last surface with its optical path, or which
//! surface stopped it and why. There is no third possibility: a ray of finite numbers never gives
//! one that is not.
//!
//! Between surfaces the path is straight (uniform index) or follows the gradient of a crystalline
//! lens ([`gradient`]). At each surface: the crossing of [`super::surface`], the clear aperture, and
//! Snell's law in vector form, `d′ = η d + (η cos i − √(1 − η² sin² i)) n`, which keeps a unit
//! direction unit to rounding. The crossing's discriminant is the cosine of incidence, so that a
//! surface costs two square roots and four divisions. Inner loops allocate nothing.

pub mod gradient;

use super::surface::{Crossing, Placed, nearby};
use glam::DVec3;
use gradient::LensGradient;

/// Two surfaces that touch, and a ray that starts on one, may be crossed this far behind the ray's
/// origin (mm) by rounding alone.
const TOUCHING_MM: f64 = 1e-9;

/// A ray of the optics frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point of it (mm).
    pub origin: DVec3,
    /// Unit direction of travel.
    pub direction: DVec3,
}

impl Ray {
    /// The ray from `origin` along `direction`, of any length; `None` where either is not finite or
    /// the direction has no length.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let direction = direction.try_normalize()?;
        (origin.is_finite() && direction.is_finite()).then_some(Self { origin, direction })
    }

    /// The point `distance` mm along the ray.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }

    /// The point where the ray's line meets the plane z = `z_mm`; `None` for a ray parallel to it.
    pub fn at_depth(&self, z_mm: f64) -> Option<DVec3> {
        let point = self.at((z_mm - self.origin.z) / self.direction.z);
        point
            .is_finite()
            .then(|| DVec3::new(point.x, point.y, z_mm))
    }
}

/// The refractive index of what lies between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IndexField {
    /// The same everywhere.
    Uniform(f64),
    /// A crystalline lens.
    Gradient(LensGradient),
}

impl IndexField {
    /// Index at a point of the optics frame.
    pub fn at(&self, point: DVec3) -> f64 {
        match self {
            Self::Uniform(n) => *n,
            Self::Gradient(gradient) => gradient.index(point),
        }
    }
}

/// A surface and the indices on its two sides. A stop is a plane between equal indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Shape, place and aperture.
    pub placed: Placed,
    /// Index on the side of smaller z, in front of the surface.
    pub front: IndexField,
    /// Index behind it.
    pub back: IndexField,
}

impl Interface {
    /// An interface between uniform media.
    pub fn uniform(placed: Placed, n_front: f64, n_back: f64) -> Self {
        Self {
            placed,
            front: IndexField::Uniform(n_front),
            back: IndexField::Uniform(n_back),
        }
    }
}

/// What became of a ray. `surface` counts from 0 in the order of the list, whichever way the light
/// went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Traced {
    /// It crossed every surface.
    Through {
        /// It starts on the last surface crossed.
        ray: Ray,
        /// Geometric length times index, from the traced ray's origin to the new one's (mm).
        optical_path_mm: f64,
    },
    /// It met a surface beyond the critical angle.
    TotalReflection {
        /// That surface.
        surface: usize,
    },
    /// It passed beside a surface, or never reached it.
    Missed {
        /// That surface.
        surface: usize,
    },
    /// It met a surface outside its clear aperture.
    Blocked {
        /// That surface.
        surface: usize,
    },
}

impl Traced {
    /// The ray behind the last surface, if it got there.
    pub fn ray(&self) -> Option<Ray> {
        match self {
            Self::Through { ray, .. } => Some(*ray),
            _ => None,
        }
    }
}

/// Traces a ray that travels towards +z through all surfaces, first to last.
pub fn trace_into(interfaces: &[Interface], ray: Ray) -> Traced {
    trace(interfaces.iter().enumerate(), ray, Crossing::Inward)
}

/// Traces a ray that travels towards −z through all surfaces, last to first.
pub fn trace_out_of(interfaces: &[Interface], ray: Ray) -> Traced {
    trace(interfaces.iter().enumerate().rev(), ray, Crossing::Outward)
}

#[inline]
fn trace<'a>(
    interfaces: impl Iterator<Item = (usize, &'a Interface)>,
    mut ray: Ray,
    crossing: Crossing,
) -> Traced {
    let mut optical_path_mm = 0.0;
    // The stretch before the near point is counted in the first medium, below.
    let (near, mut left_out) = nearby(ray.origin, ray.direction);
    ray.origin = near;
    for (surface, interface) in interfaces {
        let (before, after) = match crossing {
            Crossing::Inward => (&interface.front, &interface.back),
            Crossing::Outward => (&interface.back, &interface.front),
        };
        let placed = &interface.placed;
        let local_direction = placed.direction_to_local(ray.direction);
        let (local, cosine, n_before) = match before {
            IndexField::Uniform(n) => {
                let origin = placed.to_local(ray.origin);
                let Some((hit, cosine)) =
                    placed
                        .surface
                        .steep_crossing(origin, origin, local_direction, crossing)
                else {
                    return Traced::Missed { surface };
                };
                let distance = hit.distance + left_out;
                if distance < -TOUCHING_MM {
                    return Traced::Missed { surface };
                }
                optical_path_mm += n * distance;
                (hit.point, cosine, *n)
            }
            IndexField::Gradient(lens) => {
                let Some(arrival) = lens.march(ray, placed, crossing) else {
                    return Traced::Missed { surface };
                };
                ray.direction = arrival.ray.direction;
                optical_path_mm += arrival.optical_path_mm;
                let local = placed.to_local(arrival.ray.origin);
                let local_direction = placed.direction_to_local(ray.direction);
                let cosine = local_direction.dot(placed.surface.gradient(local)).abs();
                (local, cosine, lens.index(arrival.ray.origin))
            }
        };
        left_out = 0.0;
        if !placed.lets_through(local) {
            return Traced::Blocked { surface };
        }
        ray.origin = placed.from_local(local);
        let n_after = after.at(ray.origin);
        if n_before != n_after {
            let gradient = placed.direction_from_local(placed.surface.gradient(local));
            let eta = n_before / n_after;
            let Some(direction) = refract(ray.direction, gradient, cosine, eta, crossing) else {
                return Traced::TotalReflection { surface };
            };
            ray.direction = direction;
        }
    }
    if ray.origin.is_finite() && ray.direction.is_finite() {
        Traced::Through {
            ray,
            optical_path_mm,
        }
    } else {
        // Indices that are not finite and positive: nothing passes.
        Traced::Missed { surface: 0 }
    }
}

/// Snell's law with a normal `gradient` of any length, towards smaller z; `cosine` is its length
/// times the cosine of incidence. `None` on total reflection.
///
/// With g the length, `d′ = η d + (η c − √(g² (1 − η²) + η² c²)) n/g²`, c = g cos i.
#[inline]
fn refract(
    dir: DVec3,
    gradient: DVec3,
    cosine: f64,
    eta: f64,
    crossing: Crossing,
) -> Option<DVec3> {
    let facing = match crossing {
        Crossing::Inward => gradient,
        Crossing::Outward => -gradient,
    };
    let squared = gradient.length_squared();
    let scaled = eta * cosine;
    let under_root = squared * (1.0 - eta * eta) + scaled * scaled;
    (under_root >= 0.0).then(|| eta * dir + (scaled - under_root.sqrt()) / squared * facing)
}

#[cfg(test)]
mod tests;
