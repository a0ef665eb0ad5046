//! The coordinates of the refraction function, in which its values are smooth.
//!
//! In: an eye ([`RefractionEye`]), the obliquity of a light. Out: a [`Frame`], which maps a place of
//! the iris to two numbers between 0 and 1.
//!
//! By the symmetry of the cornea about its axis a light and an iris point are three numbers: the
//! polar angle θ of the light, and the point's coordinates along (`a`, towards the light) and across
//! (`b ≥ 0`) the light's azimuth. The entry point is smooth in them except at grazing light: there
//! `∂K/∂a` grows to 40, and just outside the domain (above θ = 86°) it is infinite: two paths merge
//! on a fold `a = a_f`, and `K` runs like `√(a − a_f)`. So the second coordinate is
//!
//! `w` with `a = a₀ + (a₁ − a₀)(κ w + (1 − κ) w²)`,
//!
//! the square root that undoes that fold: `κ` is chosen so that `∂K/∂w` is equal at both ends. The
//! ends `a₀`, `a₁` are the images of two curves of the cornea, the limbus on the light's side and,
//! on the other, the limbus or the line of the greatest exit incidence, whichever comes first. All
//! three depend on θ and, as polynomials in `β² = (b/B)²`, on `b`.

use super::super::conicoid::conicoid_sag;
use super::super::fermat::{FermatSource, fermat_newton_step, fermat_solve};
use glam::{DVec2, DVec3};

/// The part of an eye that the refraction function depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefractionEye {
    /// Anterior cornea: apical radius (mm) and shape factor.
    pub surface: DVec2,
    /// Index behind it.
    pub index: f64,
    /// Depth of the iris plane behind the corneal apex (mm).
    pub iris_z_mm: f64,
    /// Radius of the limbus (mm), of the entry points and of the iris.
    pub limbus_mm: f64,
}

impl Default for RefractionEye {
    /// François' cornea with the index that stands for both surfaces.
    fn default() -> Self {
        Self {
            surface: super::super::cornea::ANTERIOR_CORNEA,
            index: super::super::cornea::AQUEOUS_INDEX,
            iris_z_mm: 3.6,
            limbus_mm: 5.85,
        }
    }
}

/// Greatest exit incidence (degrees) of the domain for which the coordinates are made.
pub const EXIT_INCIDENCE_DEG: f64 = 80.0;

/// Greatest stretch `|∂K/∂P|` of the domain. François' cornea has at most 41 up to 80°; with a deep
/// iris or a steep cornea a fold comes into that range, and the domain ends in front of it.
pub const GREATEST_STRETCH: f64 = 50.0;

/// Where light that meets the cornea at a place lands, by Snell's law continued analytically past
/// grazing incidence.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Where it meets the iris plane (mm).
    pub point: DVec2,
    /// Cosine of the incidence; negative where the cornea faces away from the light.
    pub cos_incidence: f64,
    /// Component of the refracted ray along the axis.
    pub ray_z: f64,
}

impl RefractionEye {
    /// The direction towards a light at `half_tangent = tan(θ/2)`, azimuth along +x.
    pub fn light(half_tangent: f64) -> DVec3 {
        let t2 = half_tangent * half_tangent;
        DVec3::new(2.0 * half_tangent, 0.0, t2 - 1.0) / (1.0 + t2)
    }

    /// Radius (mm) up to which the cornea's sag is used: short of an ellipsoid's equator.
    pub fn widest_mm(&self) -> f64 {
        if self.surface.y > 0.0 {
            0.97 * self.surface.x / self.surface.y.sqrt()
        } else {
            1e3
        }
    }

    /// Traces light from `light` through the place `k` of the cornea to the iris plane.
    pub fn land(&self, k: DVec2, light: DVec3) -> Landing {
        let k = k.clamp_length_max(self.widest_mm());
        let squared = k.length_squared();
        let s = (self.surface.x * self.surface.x - self.surface.y * squared)
            .max(1e-9)
            .sqrt();
        let z = squared / (self.surface.x + s);
        let normal = DVec3::new(k.x, k.y, -s) / (squared + s * s).sqrt();
        let eta = 1.0 / self.index;
        let cos_in = light.dot(normal);
        let cos_out = (1.0 - eta * eta * (1.0 - cos_in * cos_in)).max(0.0).sqrt();
        let ray = (eta * cos_in - cos_out) * normal - eta * light;
        let ray_z = ray.z.max(0.02);
        Landing {
            point: k + ray.truncate() * ((self.iris_z_mm - z) / ray_z),
            cos_incidence: cos_in,
            ray_z: ray.z,
        }
    }

    /// Newton's step (mm) on Snell's law from a nearby entry point; its length is the error of that
    /// point to first order.
    #[inline]
    pub fn newton_step(&self, entry: DVec2, place: DVec2, light: DVec3) -> DVec2 {
        let source = FermatSource {
            direction: light,
            inverse_distance: 0.0,
        };
        let point = place.extend(self.iris_z_mm);
        fermat_newton_step(entry, point, &source, self.surface, self.index)
    }

    /// The entry point for a place of the iris, exactly; `None` where no light arrives, or where it
    /// lies behind a fold or beyond the cornea.
    pub fn solve(&self, place: DVec2, light: DVec3) -> Option<DVec2> {
        let point = place.extend(self.iris_z_mm);
        let found = fermat_solve(point, light, self.surface, self.index, 40, 1e-26);
        // Short of the iris plane: light does not reach the iris from behind.
        let before = found.entry.z < self.iris_z_mm - 0.02;
        let sound = found.residual < 1e-9 && found.curvature > 0.0 && before;
        let k = found.entry.truncate();
        (sound && k.length() < 0.95 * self.widest_mm()).then_some(k)
    }

    /// The entry point for a place of the iris on the analytic continuation of the map, from one
    /// nearby: also where the cornea faces away from the light, or lies behind the iris plane.
    pub fn continued(&self, place: DVec2, light: DVec3, near: DVec2) -> Option<DVec2> {
        let mut k = near;
        for _ in 0..12 {
            let landing = self.land(k, light);
            let [x, y] = self.jacobian(k, light);
            let determinant = x.x * y.y - x.y * y.x;
            if determinant < 1e-4 || landing.ray_z < 0.03 || k.length() > 0.98 * self.widest_mm() {
                return None;
            }
            let off = landing.point - place;
            k -= DVec2::new(y.y * off.x - y.x * off.y, x.x * off.y - x.y * off.x) / determinant;
            if off.length_squared() < 1e-22 {
                return k.is_finite().then_some(k);
            }
        }
        None
    }

    /// The largest stretch `|∂K/∂P|` at a place of the cornea: infinite on a fold, and where the map
    /// has turned over.
    pub fn stretch(&self, k: DVec2, light: DVec3) -> f64 {
        let [x, y] = self.jacobian(k, light);
        let determinant = x.x * y.y - x.y * y.x;
        let landing = self.land(k, light);
        if determinant <= 0.0 || x.x + y.y <= 0.0 || landing.ray_z <= 0.02 {
            return f64::INFINITY;
        }
        // Largest singular value of the inverse: s_max/det.
        let sum = x.length_squared() + y.length_squared();
        let largest = 0.5
            * (sum
                + (sum * sum - 4.0 * determinant * determinant)
                    .max(0.0)
                    .sqrt());
        largest.sqrt() / determinant
    }

    /// `∂P/∂K_x` and `∂P/∂K_y`.
    fn jacobian(&self, k: DVec2, light: DVec3) -> [DVec2; 2] {
        let h = 1e-4;
        [DVec2::X, DVec2::Y].map(|axis| {
            let [there, back] = [h, -h].map(|step| self.land(k + step * axis, light).point);
            (there - back) / (2.0 * h)
        })
    }

    /// Whether a place of the cornea belongs to the domain: its exit incidence is not too great,
    /// and its path stands well in front of any fold. The limbus is left to the caller.
    pub fn is_in_domain(&self, k: DVec2, light: DVec3) -> bool {
        let before = conicoid_sag(k.length(), self.surface.x, self.surface.y) < self.iris_z_mm;
        before
            && self.land(k, light).cos_incidence >= EXIT_INCIDENCE_DEG.to_radians().cos()
            && self.stretch(k, light) <= GREATEST_STRETCH
    }

    /// The ends of the domain on the meridian of the light, away from the light and towards it; at
    /// most half as far again as the limbus.
    fn meridian(&self, light: DVec3) -> [f64; 2] {
        let inside = |x: f64| self.is_in_domain(DVec2::new(x, 0.0), light);
        let farthest = 1.5 * self.limbus_mm.min(self.widest_mm());
        // Where the light falls in perpendicularly, or as near to it as the cornea reaches.
        let slant = light.x / -light.z.min(-1e-9);
        let (radius, p) = (self.surface.x, self.surface.y);
        let perpendicular = radius * slant / (1.0 + p.max(0.0) * slant * slant).sqrt();
        let mut start = perpendicular.min(0.9 * self.limbus_mm);
        for _ in 0..60 {
            if inside(start) {
                break;
            }
            start *= 0.9;
        }
        [-1.0, 1.0].map(|sign| {
            let step = 0.05 * sign;
            let mut x = start;
            while inside(x + step) && (x + step).abs() < farthest {
                x += step;
            }
            let (mut good, mut bad) = (x, x + step);
            for _ in 0..40 {
                let middle = 0.5 * (good + bad);
                if inside(middle) {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            good
        })
    }
}

impl RefractionEye {
    /// The greatest obliquity, as `tan(θ/2)`, of which no path within the limbus and the exit
    /// incidence stands near a fold: 1, that is 90°, for François' cornea, less where the iris lies
    /// deep or the cornea is steep.
    pub fn greatest_half_tangent(&self) -> f64 {
        let free = |half_tangent: f64| {
            let light = Self::light(half_tangent);
            let [away, towards] = self.meridian(light);
            let step = 1e-3;
            let folded = |x: f64| {
                let landing = self.land(DVec2::new(x, 0.0), light);
                landing.cos_incidence > EXIT_INCIDENCE_DEG.to_radians().cos()
                    && x.abs() < self.limbus_mm
            };
            !folded(away - step) && !folded(towards + step)
        };
        if free(1.0) {
            return 1.0;
        }
        let (mut good, mut bad) = (0.2, 1.0);
        for _ in 0..12 {
            let middle = 0.5 * (good + bad);
            if free(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    }
}

/// The coordinates at one obliquity: `[B, a₀ (3), a₁ (3), κ (3)]`, each triple the coefficients of
/// 1, β² and β⁴.
pub const FRAME: usize = 10;

/// See [`FRAME`].
pub type Frame = [f64; FRAME];

/// Places of β at which the coordinates are fixed.
const BETAS: [f64; 3] = [0.0, 0.55, 1.0];

/// Coefficients of 1, β², β⁴ through three values at [`BETAS`].
fn even_quartic(values: [f64; 3]) -> [f64; 3] {
    let [x1, x2] = [BETAS[1] * BETAS[1], BETAS[2] * BETAS[2]];
    let (d1, d2) = ((values[1] - values[0]) / x1, (values[2] - values[0]) / x2);
    let quartic = (d2 - d1) / (x2 - x1);
    [values[0], d1 - quartic * x1, quartic]
}

impl RefractionEye {
    /// The coordinates at `half_tangent = tan(θ/2)`, 0 to 1.
    pub fn frame(&self, half_tangent: f64) -> Frame {
        let light = Self::light(half_tangent);
        let limbus = self.limbus_mm;
        // The terminator and the far limbus, merged over a millimetre so that all is smooth in θ.
        let soft = 1.0;
        let [away, towards] = self.meridian(light);
        let gap = (away + limbus) / soft;
        let share = 1.0 / (1.0 + (-gap).exp());
        let merged = gap.max(0.0) + (-gap.abs()).exp().ln_1p();
        let far = soft * (merged - 2.8 * share * (1.0 - share)) - limbus;
        let bulge = 0.5 / limbus;
        let near = towards.min(limbus);
        let near_curve = |y: f64| DVec2::new(near - bulge * y * y, y);
        let far_curve = |y: f64| DVec2::new(far + (1.0 - share) * bulge * y * y, y);

        let mut widest: f64 = 0.1;
        for i in 0..=128 {
            let (sin, cos) = (f64::from(i) / 128.0 * core::f64::consts::PI).sin_cos();
            let landing = self.land(limbus * DVec2::new(cos, sin), light);
            if landing.cos_incidence >= EXIT_INCIDENCE_DEG.to_radians().cos() {
                widest = widest.max(landing.point.y);
            }
        }
        let b_max = widest * 1.002;
        let ends = BETAS.map(|beta| {
            let b = beta * b_max;
            [
                self.image(far_curve, b, light),
                self.image(near_curve, b, light),
            ]
        });
        let slopes = BETAS.map(|beta| {
            let b = beta * b_max;
            let k0 = far_curve(self.height(far_curve, b, light));
            let k1 = near_curve(self.height(near_curve, b, light));
            let (s0, s1) = (self.slope(k0, light), self.slope(k1, light));
            (2.0 * s1 / (s0 + s1)).clamp(1e-3, 1.8)
        });
        let a0 = even_quartic(ends.map(|end| end[0]));
        let a1 = even_quartic(ends.map(|end| end[1]));
        let kappa = even_quartic(slopes);
        [
            b_max, a0[0], a0[1], a0[2], a1[0], a1[1], a1[2], kappa[0], kappa[1], kappa[2],
        ]
    }

    /// Height `y` on a curve of the cornea whose image lies at `b`.
    fn height(&self, curve: impl Fn(f64) -> DVec2, b: f64, light: DVec3) -> f64 {
        let (mut low, mut high) = (0.0, 1.3 * self.limbus_mm);
        for _ in 0..48 {
            let middle = 0.5 * (low + high);
            if self.land(curve(middle), light).point.y < b {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// `a` of the image of a curve at `b`.
    fn image(&self, curve: impl Fn(f64) -> DVec2 + Copy, b: f64, light: DVec3) -> f64 {
        self.land(curve(self.height(curve, b, light)), light)
            .point
            .x
    }

    /// `∂K_a/∂a` at fixed `b`.
    fn slope(&self, k: DVec2, light: DVec3) -> f64 {
        let [x, y] = self.jacobian(k, light);
        let determinant = x.x * y.y - x.y * y.x;
        (y.y / determinant.max(1e-6)).clamp(0.05, 1e3)
    }
}

/// `w` and β of a place in a frame, `a` mm towards the light's azimuth and `b ≥ 0` mm across it: the
/// inverse of the module's formula.
#[inline]
pub fn frame_place<T: Float>(frame: &[T; FRAME], a: T, b: T) -> (T, T) {
    // In one instruction each, unlike the functions of the standard library.
    let least = |a: T, b: T| if a < b { a } else { b };
    let most = |a: T, b: T| if a > b { a } else { b };
    let one = T::one();
    let beta = b / frame[0];
    let q = least(beta * beta, T::of(1.5));
    let a0 = frame[1] + q * (frame[2] + q * frame[3]);
    let a1 = frame[4] + q * (frame[5] + q * frame[6]);
    let kappa = most(frame[7] + q * (frame[8] + q * frame[9]), T::of(1e-3));
    let share = (a - a0) / most(a1 - a0, T::of(0.1));
    let squared = kappa * kappa + T::of(4.0) * (one - kappa) * share;
    let root = most(squared, T::of(0.0)).sqrt();
    ((share + share) / (kappa + root), beta)
}

/// Single precision for the look-ups, double for their twin.
pub trait Float:
    Copy
    + PartialOrd
    + core::ops::Add<Output = Self>
    + core::ops::Sub<Output = Self>
    + core::ops::Mul<Output = Self>
    + core::ops::Div<Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;
    /// 1.
    fn one() -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
}

macro_rules! float {
    ($t:ty) => {
        impl Float for $t {
            #[inline]
            fn of(value: f64) -> Self {
                value as $t
            }
            #[inline]
            fn one() -> Self {
                1.0
            }
            #[inline]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
        }
    };
}
float!(f32);
float!(f64);

/// `a` of a `w` at a β: the module's formula.
pub fn frame_a(frame: &Frame, w: f64, beta: f64) -> f64 {
    let q = (beta * beta).min(1.5);
    let a0 = frame[1] + q * (frame[2] + q * frame[3]);
    let a1 = frame[4] + q * (frame[5] + q * frame[6]);
    let kappa = (frame[7] + q * (frame[8] + q * frame[9])).max(1e-3);
    a0 + (a1 - a0).max(0.1) * w * (kappa + (1.0 - kappa) * w)
}
