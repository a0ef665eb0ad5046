//! Defocus in dioptres: the blur disc of a point as an angle, and its blur ellipse where the eye is
//! astigmatic.
//!
//! In: pupil diameter (m), vergences (D), refraction (D; sphere, cylinder, axis). Out: the disc's
//! angular diameter (rad), or the ellipse's axes (rad) and orientation.
//!
//! Demers' circle of confusion on an image at distance `I` behind the lens,
//! `|A F (P − D) / (D (P − F))|` with `1/F = 1/P + 1/I` (the form of Nießner et al. 2013), is
//! identical to `A I |1/D − 1/P|`. As an angle, `A |1/D − 1/P|`, it has no pole at `P = F`, is exact
//! as `D` or `P` goes to infinity, and takes ametropia as one added term.
//!
//! **Astigmatism.** A refraction is the power vector (M, J₀, J₄₅) of Thibos, Wheeler & Horner 1997
//! (Optom. Vis. Sci. 74, 367): `M = S + C/2`, `J₀ = −(C/2) cos 2α`, `J₄₅ = −(C/2) sin 2α`, which
//! turns combining refractions into adding vectors. The dioptric matrix (Long 1976, Am. J. Optom.
//! 53, 27) is then `F = [[M + J₀, J₄₅], [J₄₅, M − J₀]]`: a ray through the pupil point x (m) leaves
//! the direction of a sharp image by the angle `F x`. So the blur of a point is the pupil itself,
//! deformed by F: a circular pupil of radius a gives an ellipse whose semi-axes are a times the
//! absolute eigenvalues of F, `|M ± √(J₀² + J₄₅²)|`, along the eigenvectors; the spherical case is
//! the disc above.
//!
//! Axes are those of a prescription (TABO): anticlockwise from the horizontal as the examiner sees
//! the patient's eye. In the patient's own view, +x right and +y up, they are mirrored:
//! [`PowerVector::in_view`].
//!
//! Twin: `shaders/lib/defocus.wgsl`.

use super::fresnel::clamp_or;
use core::f64::consts::{FRAC_PI_2, PI};
use glam::{DMat2, DVec2, DVec3};

/// Angular diameter (rad) of the blur disc of a point at vergence `distance_vergence_d` = 1/D (D;
/// 0 is infinity), seen by an eye accommodated to `focus_vergence_d` = 1/P with the spectacle
/// refraction `refraction_d` (negative: myopia), through a pupil of `pupil_m` metres.
///
/// The factor is 3.438 arcmin per mm of pupil and dioptre. Nothing infinite leaves here, nor from the
/// ellipses below: pupils are limited to 0 to 1 m and sums of vergences to ±10⁶ D, and what is not a
/// number counts as 0.
pub fn defocus_blur_angle(
    pupil_m: f64,
    distance_vergence_d: f64,
    focus_vergence_d: f64,
    refraction_d: f64,
) -> f64 {
    sane_pupil(pupil_m) * sane_power(distance_vergence_d - focus_vergence_d + refraction_d).abs()
}

/// Vergence (D) of a distance in metres; infinity is 0. Distances below a millimetre, and what is
/// not a number, count as a millimetre: nothing stands nearer to a cornea.
pub fn vergence_of_distance(distance_m: f64) -> f64 {
    1.0 / distance_m.max(1e-3)
}

/// A refraction, or the error of one, as a power vector (D).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PowerVector {
    /// Spherical equivalent M (D).
    pub m_d: f64,
    /// Cross cylinder with axes at 0 and 90°, J₀ (D).
    pub j0_d: f64,
    /// Cross cylinder with axes at 45 and 135°, J₄₅ (D).
    pub j45_d: f64,
}

impl PowerVector {
    /// From sphere and cylinder (D, either sign of the cylinder) and the cylinder's axis (rad).
    pub fn from_sphere_cylinder(sphere_d: f64, cylinder_d: f64, axis_rad: f64) -> Self {
        let half = 0.5 * cylinder_d;
        let (sin, cos) = (2.0 * axis_rad).sin_cos();
        Self {
            m_d: sphere_d + half,
            j0_d: -half * cos,
            j45_d: -half * sin,
        }
    }

    /// Sphere (D), cylinder (D, never positive) and axis (rad, from 0 up to but not including π);
    /// the axis of a spherical refraction is 0.
    pub fn to_sphere_cylinder(self) -> (f64, f64, f64) {
        let j = self.astigmatism_d();
        let axis = half_turn(0.5 * self.j45_d.atan2(self.j0_d));
        (self.m_d + j, -2.0 * j, axis)
    }

    /// `J = √(J₀² + J₄₅²)` (D): half the cylinder's size.
    pub fn astigmatism_d(self) -> f64 {
        self.j0_d.hypot(self.j45_d)
    }

    /// The same refraction with a vergence (D) added at every meridian.
    pub fn plus_sphere(self, vergence_d: f64) -> Self {
        Self {
            m_d: self.m_d + vergence_d,
            ..self
        }
    }

    /// The same refraction with its axis turned by an angle (rad).
    pub fn turned(self, angle_rad: f64) -> Self {
        let (sin, cos) = (2.0 * angle_rad).sin_cos();
        Self {
            j0_d: self.j0_d * cos - self.j45_d * sin,
            j45_d: self.j0_d * sin + self.j45_d * cos,
            ..self
        }
    }

    /// The same refraction in the patient's view (+x right, +y up as the patient sees it), where a
    /// prescription's axes run clockwise. Its own inverse.
    pub fn in_view(self) -> Self {
        Self {
            j45_d: -self.j45_d,
            ..self
        }
    }

    /// The dioptric matrix F (D).
    pub fn dioptric_matrix(self) -> DMat2 {
        DMat2::from_cols(
            DVec2::new(self.m_d + self.j0_d, self.j45_d),
            DVec2::new(self.j45_d, self.m_d - self.j0_d),
        )
    }
}

impl core::ops::Add for PowerVector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            m_d: self.m_d + other.m_d,
            j0_d: self.j0_d + other.j0_d,
            j45_d: self.j45_d + other.j45_d,
        }
    }
}

/// The blur of a point: a uniformly bright ellipse of visual angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurEllipse {
    /// Longer diameter (rad).
    pub major_rad: f64,
    /// Shorter diameter (rad): 0 at a line focus.
    pub minor_rad: f64,
    /// Direction of the longer diameter (rad), from 0 up to π; 0 for a disc.
    pub orientation_rad: f64,
}

impl BlurEllipse {
    /// Second moments of the ellipse about its centre (rad²): the covariance of the blur, which adds
    /// to that of other blurs. A uniform disc of diameter d has d²/16 in every direction.
    pub fn covariance(self) -> DMat2 {
        let (sin, cos) = self.orientation_rad.sin_cos();
        let (a, b) = (self.major_rad.powi(2) / 16.0, self.minor_rad.powi(2) / 16.0);
        let across = (a - b) * sin * cos;
        DMat2::from_cols(
            DVec2::new(a * cos * cos + b * sin * sin, across),
            DVec2::new(across, a * sin * sin + b * cos * cos),
        )
    }
}

/// The error of refraction (D) with which an eye of the given spectacle refraction, accommodated to
/// `focus_vergence_d`, sees a point at `distance_vergence_d`; each component within ±10⁶ D.
pub fn defocus_error(
    distance_vergence_d: f64,
    focus_vergence_d: f64,
    refraction: PowerVector,
) -> PowerVector {
    PowerVector {
        m_d: sane_power(refraction.m_d + (distance_vergence_d - focus_vergence_d)),
        j0_d: sane_power(refraction.j0_d),
        j45_d: sane_power(refraction.j45_d),
    }
}

/// The blur ellipse of a point at `distance_vergence_d` (D; 0 is infinity), seen by an eye
/// accommodated to `focus_vergence_d` with the spectacle `refraction`, through a circular pupil of
/// `pupil_m` metres. Without astigmatism its diameters are [`defocus_blur_angle`].
///
/// First-order optics, as there: exact to rounding for the model, which leaves out the wavefront's
/// aberrations and diffraction.
pub fn defocus_blur_ellipse(
    pupil_m: f64,
    distance_vergence_d: f64,
    focus_vergence_d: f64,
    refraction: PowerVector,
) -> BlurEllipse {
    let pupil = sane_pupil(pupil_m);
    let error = defocus_error(distance_vergence_d, focus_vergence_d, refraction);
    let j = error.astigmatism_d();
    // The eigenvector of M + J lies along the axis of the minus cylinder; that of M − J across it.
    let along = 0.5 * error.j45_d.atan2(error.j0_d);
    let orientation = if error.m_d >= 0.0 {
        along
    } else {
        along + FRAC_PI_2
    };
    BlurEllipse {
        major_rad: pupil * (error.m_d.abs() + j),
        minor_rad: pupil * (error.m_d.abs() - j).abs(),
        orientation_rad: if j > 0.0 { half_turn(orientation) } else { 0.0 },
    }
}

/// Blur of an eye whose error of refraction is `sphere_d` (D, spherical equivalent) with a cross cylinder of
/// `astigmatism_d` (D, half of the cylinder, not negative), as the view draws it: the diameter (rad) of the
/// disc of as much variance, and its *elongation*, by how much of that variance the one along the axis of the
/// minus cylinder exceeds it (−1 to 1; across the axis it falls short by as much). 0 is a disc, ±1 are lines.
///
/// The variances are those of [`defocus_blur_covariance`], p²(M ± J)²/16: exact.
pub fn astigmatic_blur(pupil_m: f64, sphere_d: f64, astigmatism_d: f64) -> [f64; 2] {
    let (m, j) = (sane_power(sphere_d), sane_power(astigmatism_d));
    let strength2 = m * m + j * j;
    let elongation = 2.0 * m * j / strength2.max(1e-12);
    [sane_pupil(pupil_m) * strength2.sqrt(), elongation]
}

/// Second moments (xx, xy, yy; rad²) of [`defocus_blur_ellipse`] without its trigonometry:
/// `F Fᵀ a²/4` with a the pupil's radius, for renderers that add blurs or draw Gaussians.
pub fn defocus_blur_covariance(
    pupil_m: f64,
    distance_vergence_d: f64,
    focus_vergence_d: f64,
    refraction: PowerVector,
) -> DVec3 {
    let pupil = 0.25 * sane_pupil(pupil_m);
    let error = defocus_error(distance_vergence_d, focus_vergence_d, refraction);
    let xx = pupil * (error.m_d + error.j0_d);
    let yy = pupil * (error.m_d - error.j0_d);
    let xy = pupil * error.j45_d;
    DVec3::new(xx * xx + xy * xy, xy * (xx + yy), yy * yy + xy * xy)
}

fn sane_pupil(pupil_m: f64) -> f64 {
    clamp_or(pupil_m, 0.0, 1.0, 0.0)
}

fn sane_power(power_d: f64) -> f64 {
    clamp_or(power_d, -1e6, 1e6, 0.0)
}

/// A direction without a sense, from 0 up to π.
fn half_turn(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(PI);
    // A tiny negative angle's remainder rounds to π itself.
    if turned < PI { turned } else { 0.0 }
}

#[cfg(test)]
mod tests;
