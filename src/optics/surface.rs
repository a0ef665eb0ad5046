//! One form for every optical surface of the eye: `kx x² + ky y² + kz z² = 2 z`, in a frame of its
//! own with the vertex at the origin and the axis along z.
//!
//! In: rays, in the surface's frame or (through a [`Placed`] surface) in the optics frame, mm. Out:
//! where they cross the surface, its normal there, its sag.
//!
//! `kx` and `ky` are the principal curvatures at the vertex and `kz = p k` closes the surface along
//! the axis, with the shape factor `p = 1 + Q` of schematic eyes: sphere p = 1, paraboloid 0,
//! hyperboloid below 0. Curvatures in place of radii make the plane (0, 0, 0) and the paraboloid
//! (kz = 0) ordinary members rather than limits, a concave surface a change of sign, and a toric
//! cornea or a triaxial globe two unequal numbers. Only the sheet that holds the vertex,
//! `1 − kz z ≥ 0`, is the eye's surface.
//!
//! **The crossing.** With `g(t) = ½ d/dt` of the implicit function, the two roots along a ray are told
//! apart by the side they are crossed from: `g = −√D` from the front (smaller z) to the back, `+√D`
//! the other way. So a ray that starts on a surface finds that surface without a tolerance, and
//! the root of the wrong sign is never a candidate.
//!
//! **Digits.** `D = B² − A C` cancels for grazing rays, and the rounding of A, B and C themselves
//! would then decide between hit and miss. By Lagrange's identity D is a function of the ray's
//! direction `d` and moment `m = o × d` alone,
//!
//! `D = dz² + 2 (kx dx my − ky dy mx) − kx ky mz² − ky kz mx² − kx kz my²`,
//!
//! which is summed in twice the working precision whenever it cancels. Far origins are first moved,
//! by their moment in the same precision, to the ray's nearest point to the vertex.
//!
//! [`super::conicoid`] is the older, convex-only form with a shader twin.

mod compensated;

use compensated::{Pair, product};
use glam::{DMat3, DVec2, DVec3};

/// Below this share of `B² + 1` the discriminant is summed with its rounding errors: rays that meet
/// the surface more than 70° to 80° from its normal.
const CANCELLATION: f64 = 0.05;
/// An origin further from the vertex than this (mm) is moved near with compensated products: wider
/// than an eye, so no ray inside one pays for it.
const NEARBY_MM: f64 = 40.0;

/// How far the squared length of a direction may be from 1 before it is normalised. The formulas take
/// any length; only the choice of a nearby point of the ray leans on it.
const NEARLY_UNIT: f64 = 1e-3;

/// From which side a ray crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// From the side of smaller z, that of the cornea's front, to that of larger z: into the eye.
    Inward,
    /// From larger z to smaller z: out of the eye.
    Outward,
}

/// Where a ray crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, in lengths of its direction; negative behind the origin.
    pub distance: f64,
    /// The point, in the frame of the ray (mm). Not rounded through `distance`: an origin 10⁶ mm
    /// away costs no digits here.
    pub point: DVec3,
}

/// The surface `kx x² + ky y² + kz z² = 2 z`.
///
/// A curvature that is not finite (from a radius of zero or NaN) makes a surface that no ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    /// `kx`, `ky`, `kz` in 1/mm: positive where the centre of curvature lies behind the vertex (+z).
    pub curvature: DVec3,
}

impl Quadric {
    /// The plane z = 0.
    pub const PLANE: Self = Self {
        curvature: DVec3::ZERO,
    };

    /// A conicoid of revolution with apical radius `radius_mm` (positive: centre behind the vertex;
    /// negative: in front; infinite: a plane) and shape factor `p = 1 + Q`.
    pub fn conicoid(radius_mm: f64, p: f64) -> Self {
        let k = 1.0 / radius_mm;
        Self {
            curvature: DVec3::new(k, k, p * k),
        }
    }

    /// A toric surface: principal radii along x and y, and the shape factor `p` that it has about
    /// its mean curvature. In the x meridian the shape factor is then `p (kx + ky)/(2 kx)`.
    ///
    /// The quadric that a videokeratoscope's "biconic" approaches: the same curvatures, with one kz
    /// for all meridians, so that it closes to an ellipsoid.
    pub fn toric(radius_x_mm: f64, radius_y_mm: f64, p: f64) -> Self {
        let (kx, ky) = (1.0 / radius_x_mm, 1.0 / radius_y_mm);
        Self {
            curvature: DVec3::new(kx, ky, 0.5 * p * (kx + ky)),
        }
    }

    /// A triaxial ellipsoid with semi-axes `semi_axes_mm`, touching the vertex with its front pole;
    /// with a negative z semi-axis, with its back pole, as a retina does.
    pub fn ellipsoid(semi_axes_mm: DVec3) -> Self {
        let c = semi_axes_mm.z;
        Self {
            curvature: DVec3::new(
                c / (semi_axes_mm.x * semi_axes_mm.x),
                c / (semi_axes_mm.y * semi_axes_mm.y),
                1.0 / c,
            ),
        }
    }

    /// Where the line through `origin` along `dir` crosses the vertex sheet from the given side, be
    /// it ahead of the origin or behind it. `dir` need not be a unit vector.
    ///
    /// Error of the point: below 2e-14 mm for eye-sized surfaces, grazing or not, wherever the
    /// origin (f64 inputs taken as exact; measured in the tests against 106-bit arithmetic).
    pub fn crossing(&self, origin: DVec3, dir: DVec3, crossing: Crossing) -> Option<Hit> {
        let length_squared = dir.length_squared();
        if (length_squared - 1.0).abs() > NEARLY_UNIT {
            let length = length_squared.sqrt();
            let hit = self.crossing(origin, (dir / length).try_normalize()?, crossing)?;
            return Some(Hit {
                distance: hit.distance / length,
                point: hit.point,
            });
        }
        let (near, shift) = nearby(origin, dir);
        self.steep_crossing(near, origin, dir, crossing)
            .map(|(hit, _)| Hit {
                distance: hit.distance + shift,
                point: hit.point,
            })
    }

    /// As [`Self::crossing`] for an origin that is near, with `√D`: the cosine of incidence times the
    /// lengths of `dir` and of [`Self::gradient`] at the point. `exact` is the point of the ray that
    /// decides whether it grazes: the same, or the unrounded one far away.
    #[inline]
    pub(super) fn steep_crossing(
        &self,
        origin: DVec3,
        exact: DVec3,
        dir: DVec3,
        crossing: Crossing,
    ) -> Option<(Hit, f64)> {
        let k = self.curvature;
        // Any point of the line near the vertex will do, so `dir` need be unit only roughly.
        let shift = -origin.dot(dir);
        let foot = origin + shift * dir;
        let kd = k * dir;
        let ko = k * foot;
        let a = kd.dot(dir);
        let b = ko.dot(dir) - dir.z;
        let c = ko.dot(foot) - 2.0 * foot.z;
        let plain = b * b - a * c;
        let discriminant = if plain > CANCELLATION * (b * b + 1.0) {
            plain
        } else {
            self.discriminant(exact, dir)
        };
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        let side = match crossing {
            Crossing::Inward => 1.0,
            Crossing::Outward => -1.0,
        };
        // −side (side b + √D)/a and side c/(√D − side b) are the same root. The first errs by
        // ε (b + √D)/a; the second, where nothing cancels in it, by ε |foot|. A ray that grazes has
        // √D ≈ b ≈ 0 and needs the first; one nearly along the axis of a paraboloid has a ≈ 0 and
        // needs the second.
        let facing = side * b;
        let sum = root - facing;
        let t = if facing > 0.0 || sum * sum < a * a * foot.length_squared() {
            -side * (facing + root) / a
        } else {
            side * c / sum
        };
        let point = foot + t * dir;
        // A root at infinity has a non-finite z and fails here, as does the other sheet.
        let on_sheet = 1.0 - k.z * point.z >= 0.0 && point.is_finite();
        on_sheet.then_some((
            Hit {
                distance: t + shift,
                point,
            },
            root,
        ))
    }

    /// The nearest crossing at or ahead of `origin`, from whichever side.
    pub fn intersect(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let ahead = |crossing| {
            self.crossing(origin, dir, crossing)
                .filter(|hit| hit.distance >= 0.0)
        };
        match (ahead(Crossing::Inward), ahead(Crossing::Outward)) {
            (Some(a), Some(b)) => Some(if b.distance < a.distance { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// Unit normal at a point of the vertex sheet, on the side of smaller z (−z at the vertex).
    pub fn normal(&self, point: DVec3) -> DVec3 {
        self.gradient(point).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// Half the gradient of the implicit function: along [`Self::normal`], of length 1 at the vertex.
    #[inline]
    pub fn gradient(&self, point: DVec3) -> DVec3 {
        self.curvature * point - DVec3::Z
    }

    /// Depth z (mm) of the vertex sheet at (x, y). Beyond the equator of an ellipsoid it stays at the
    /// equator's depth, so that it is finite wherever curvatures and arguments are.
    pub fn sag(&self, x: f64, y: f64) -> f64 {
        let k = self.curvature;
        let w = k.x * x * x + k.y * y * y;
        let plain = 1.0 - k.z * w;
        let room = if plain > CANCELLATION {
            plain
        } else {
            // Near the equator the difference would lose its digits.
            let w = Pair::from(k.x) * product(x, x) + Pair::from(k.y) * product(y, y);
            (Pair::from(1.0) - Pair::from(k.z) * w).value()
        };
        if room < 0.0 {
            return 1.0 / k.z;
        }
        w / (1.0 + room.sqrt())
    }

    /// `B² − A C` by the ray's moment about the vertex, in twice the working precision.
    #[cold]
    fn discriminant(&self, origin: DVec3, dir: DVec3) -> f64 {
        let [mx, my, mz] = moment(origin, dir);
        let [kx, ky, kz] = self.curvature.to_array().map(Pair::from);
        let two = Pair::from(2.0);
        let linear = kx * Pair::from(dir.x) * my - ky * Pair::from(dir.y) * mx;
        let products = kx * ky * mz * mz + kz * (ky * mx * mx + kx * my * my);
        (product(dir.z, dir.z) + two * linear - products).value()
    }
}

/// `o × d` with its rounding errors.
fn moment(o: DVec3, d: DVec3) -> [Pair; 3] {
    [
        product(o.y, d.z) - product(o.z, d.y),
        product(o.z, d.x) - product(o.x, d.z),
        product(o.x, d.y) - product(o.y, d.x),
    ]
}

/// A point of the line within eye's reach of the frame's origin, where there is one, and its distance
/// along `dir` from `origin`: the origin itself, or the line's nearest point.
#[inline]
pub(super) fn nearby(origin: DVec3, dir: DVec3) -> (DVec3, f64) {
    if origin.length_squared() < NEARBY_MM * NEARBY_MM {
        (origin, 0.0)
    } else {
        nearest_point(origin, dir)
    }
}

#[cold]
fn nearest_point(origin: DVec3, dir: DVec3) -> (DVec3, f64) {
    let dir_squared = dir.length_squared();
    // d × (o × d)/d²: the large parts of the origin cancel inside the compensated moment.
    let m = DVec3::from_array(moment(origin, dir).map(Pair::value));
    (dir.cross(m) / dir_squared, -origin.dot(dir) / dir_squared)
}

/// A surface in the optics frame, with a clear aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The surface in its own frame.
    pub surface: Quadric,
    /// Its vertex in the optics frame (mm).
    pub vertex: DVec3,
    /// Rotation from the surface's frame to the optics frame; `None` for an upright surface, which
    /// is most of them and costs no matrix.
    pub tilt: Option<DMat3>,
    /// Reciprocal semi-axes of the elliptical clear aperture in the surface's x and y (1/mm); zero
    /// lets everything through.
    pub inverse_aperture: DVec2,
}

impl Placed {
    /// An upright, centred surface with its vertex at depth `z_mm`, unbounded.
    pub fn at(surface: Quadric, z_mm: f64) -> Self {
        Self {
            surface,
            vertex: DVec3::new(0.0, 0.0, z_mm),
            tilt: None,
            inverse_aperture: DVec2::ZERO,
        }
    }

    /// The same surface with its vertex moved sideways to (x, y) (mm).
    pub fn decentred(mut self, x_mm: f64, y_mm: f64) -> Self {
        self.vertex.x = x_mm;
        self.vertex.y = y_mm;
        self
    }

    /// The same surface turned about its vertex, by `about_x` and then `about_y` (rad,
    /// right-handed about the axes of the optics frame).
    pub fn tilted(mut self, about_x: f64, about_y: f64) -> Self {
        self.tilt = (about_x != 0.0 || about_y != 0.0)
            .then(|| DMat3::from_rotation_y(about_y) * DMat3::from_rotation_x(about_x));
        self
    }

    /// The same surface with an elliptical clear aperture of semi-axes `x_mm` and `y_mm`, seen along
    /// its axis. Zero, negative or NaN semi-axes close it.
    pub fn with_aperture(mut self, x_mm: f64, y_mm: f64) -> Self {
        // Reciprocals of what is not positive would be negative or NaN and open it again.
        let inverse = |semi: f64| {
            if semi > 0.0 {
                1.0 / semi
            } else {
                f64::INFINITY
            }
        };
        self.inverse_aperture = DVec2::new(inverse(x_mm), inverse(y_mm));
        self
    }

    /// Whether a point of the surface's own frame lies within the clear aperture.
    #[inline]
    pub fn lets_through(&self, local: DVec3) -> bool {
        (local.truncate() * self.inverse_aperture).length_squared() <= 1.0
    }

    /// A point of the optics frame in the surface's frame.
    #[inline]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.direction_to_local(point - self.vertex)
    }

    /// A direction of the optics frame in the surface's frame.
    #[inline]
    pub fn direction_to_local(&self, dir: DVec3) -> DVec3 {
        self.tilt.map_or(dir, |tilt| tilt.transpose() * dir)
    }

    /// A direction of the surface's frame in the optics frame.
    #[inline]
    pub fn direction_from_local(&self, dir: DVec3) -> DVec3 {
        self.tilt.map_or(dir, |tilt| tilt * dir)
    }

    /// A point of the surface's frame in the optics frame.
    #[inline]
    pub fn from_local(&self, point: DVec3) -> DVec3 {
        self.vertex + self.direction_from_local(point)
    }

    /// As [`Quadric::crossing`], in the optics frame and without regard to the aperture. A far origin
    /// is moved near before it is rotated, so that its digits survive the tilt as well.
    pub fn crossing(&self, origin: DVec3, dir: DVec3, crossing: Crossing) -> Option<Hit> {
        let (near, shift) = nearby(origin, dir);
        let hit =
            self.surface
                .crossing(self.to_local(near), self.direction_to_local(dir), crossing)?;
        Some(Hit {
            distance: hit.distance + shift,
            point: self.from_local(hit.point),
        })
    }
}

#[cfg(test)]
mod tests;
