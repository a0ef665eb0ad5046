//! The wave aberration of an eye, by the optical paths of real rays.
//!
//! In: a [`SchematicEye`], the diameter of its entrance pupil, and the object: where in the field and
//! how far. Out: a [`Wavefront`], the aberration over the entrance pupil as Zernike coefficients to
//! the sixth order with what they leave.
//!
//! As an aberrometer measures it (ANSI Z80.28): light leaves the place on the retina where the chief
//! ray from the object lands, and is compared, where it comes out, with a sphere about the object
//! through the centre of the entrance pupil. `W = [path of the chief ray] − [path]` in µm, positive
//! where light is early, so that a myope has positive c20. An object away from infinity asks for the
//! wave that converges to it: an eye in focus on the object has no defocus here.
//!
//! Pupil coordinates are in the plane of the entrance pupil, square to the axis, over the radius of
//! the pupil: the pupil is the unit disc off axis as well. [`Wavefront::power_vector`] undoes the
//! obliquity.

pub mod fit;

use super::paraxial::{Meridian, Paraxial, paraxial};
use super::zernike::{ZERNIKE_COUNT, refraction_from_zernike, zernike_rms};
use crate::optics::defocus::PowerVector;
use crate::optics::pupil::search::{find, search_start};
use crate::optics::ray_trace::{Ray, Traced, trace_out_of};
use crate::optics::schematic_eye::SchematicEye;
use glam::{DVec2, DVec3};
use thiserror::Error;

/// Rings of rays, and rays on each: the fit is exact for aberrations to the fifteenth order.
const RINGS: usize = 8;
const SPOKES: usize = 24;
/// Nodes of Gauss–Legendre quadrature on 0 … 1 for ρ², with their weights: rays stand where a sum over
/// them is an integral over the disc.
const RING_NODES: [(f64, f64); RINGS] = [
    (0.019_855_071_751_231_912, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_63),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_63),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// The object whose image is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectPoint {
    /// Reciprocal of its distance (m) from the entrance pupil: 0 for a distant one, −20 to 1000 D.
    /// Negative: light that converges on its way in, as behind a correcting lens.
    pub vergence_d: f64,
    /// Direction from the axis to the patient's right, +x (rad).
    pub azimuth: f64,
    /// Direction from the axis upwards, +y (rad).
    pub elevation: f64,
}

/// Why there is no wavefront.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum WavefrontError {
    /// The pupil's diameter is not between 0.01 and 10 mm.
    #[error("a pupil of {0} mm is not between 0.01 and 10 mm")]
    Pupil(f64),
    /// The vergence is not between −20 and 1000 D, or a direction not within 89° of the axis.
    #[error("no object stands there")]
    Object,
    /// A ray that the pupil should pass is stopped by a surface; which, and how.
    #[error("a ray of the pupil does not pass the eye: {0:?}")]
    Ray(Traced),
    /// No ray from the object passes the centre of the stop and reaches the retina.
    #[error("the object cannot be seen")]
    NotSeen,
}

/// One ray of a wavefront.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WavefrontSample {
    /// Where in the unit entrance pupil.
    pub pupil: DVec2,
    /// Aberration (µm).
    pub aberration_um: f64,
    /// Its share of the pupil's area.
    weight: f64,
}

/// The wave aberration of an eye over its entrance pupil.
#[derive(Clone, Debug, PartialEq)]
pub struct Wavefront {
    /// Zernike coefficients (µm) by the OSA's single index.
    pub coefficients_um: [f64; ZERNIKE_COUNT],
    /// Radius of the unit pupil (mm).
    pub pupil_radius_mm: f64,
    /// RMS (µm) of what the coefficients leave.
    pub residual_um: f64,
    /// The traced rays.
    pub samples: Vec<WavefrontSample>,
    /// Where on the retina the chief ray lands (mm).
    pub retina_mm: DVec3,
    /// Direction from the eye to the object: unit, in the optics frame.
    pub towards_object: DVec3,
}

impl Wavefront {
    /// RMS of the aberration without piston, tilt (and, `from_order` 3, defocus and astigmatism).
    pub fn rms_um(&self, from_order: u32) -> f64 {
        zernike_rms(&self.coefficients_um, from_order)
    }

    /// The refraction that leaves the least RMS, in the plane square to the chief ray:
    /// what a lens in front of the eye, square to the line of sight, has to have.
    pub fn power_vector(&self) -> PowerVector {
        let [_, _, _, oblique, defocus, astigmatism, ..] = self.coefficients_um;
        let at_pupil =
            refraction_from_zernike([oblique, defocus, astigmatism], self.pupil_radius_mm);
        let PowerVector {
            m_d: m,
            j0_d: j0,
            j45_d: j45,
        } = at_pupil;
        // As a matrix of powers in the plane of the pupil, P = [[M + J0, J45], [J45, M − J0]];
        // obliquely the pupil is foreshortened by cos θ along the field, so W's curvature grows.
        let along = self.towards_object.truncate();
        let cosine = -self.towards_object.z;
        let Some(along) = along.try_normalize() else {
            return at_pupil;
        };
        let stretch = |v: DVec2| v + (1.0 / cosine - 1.0) * along.dot(v) * along;
        let power = |v: DVec2| DVec2::new((m + j0) * v.x + j45 * v.y, j45 * v.x + (m - j0) * v.y);
        let (x, y) = (stretch(DVec2::X), stretch(DVec2::Y));
        let (xx, xy, yy) = (x.dot(power(x)), x.dot(power(y)), y.dot(power(y)));
        PowerVector {
            m_d: 0.5 * (xx + yy),
            j0_d: 0.5 * (xx - yy),
            j45_d: xy,
        }
    }
}

/// Traces the wavefront of `eye` for `object` through an entrance pupil of `pupil_diameter_mm`.
///
/// The pupil is that of a distant observer on the axis: the stop is opened so far that the real ray
/// that enters parallel to the axis at half the diameter just passes. Apertures of the eye's surfaces
/// other than the stop are heeded.
pub fn trace_wavefront(
    eye: &SchematicEye,
    pupil_diameter_mm: f64,
    object: ObjectPoint,
) -> Result<Wavefront, WavefrontError> {
    if !(0.01..=10.0).contains(&pupil_diameter_mm) {
        return Err(WavefrontError::Pupil(pupil_diameter_mm));
    }
    let radius = 0.5 * pupil_diameter_mm;
    let open = eye.clone().with_stop_radius(f64::INFINITY);
    let eye = &open;
    let stop_radius = stop_radius_for(eye, radius).ok_or(WavefrontError::NotSeen)?;
    let constants = paraxial(eye, Meridian::Vertical);
    let chief = ChiefRay::find(eye, &constants, object)?;

    // Rays leave the retina towards the stop's image in the lens.
    let exit = constants.exit_pupil;
    let path = |on_stop: DVec2| -> Result<(DVec2, f64), WavefrontError> {
        let aim = (exit.magnification * on_stop).extend(exit.z_mm);
        let ray = Ray::new(chief.retina, aim - chief.retina).ok_or(WavefrontError::NotSeen)?;
        match trace_out_of(&eye.interfaces, ray) {
            Traced::Through {
                ray,
                optical_path_mm,
            } => chief
                .compare(ray)
                .map(|(pupil, beyond)| (pupil, optical_path_mm + beyond))
                .ok_or(WavefrontError::NotSeen),
            stopped => Err(WavefrontError::Ray(stopped)),
        }
    };
    let reference = chief.optical_path_mm;
    let mut samples = Vec::with_capacity(RINGS * SPOKES);
    for (u, weight) in RING_NODES {
        for spoke in 0..SPOKES {
            let angle = core::f64::consts::TAU * (spoke as f64 + 0.5) / SPOKES as f64;
            let on_stop = stop_radius * u.sqrt() * DVec2::from_angle(angle);
            let (pupil, length) = path(on_stop)?;
            samples.push(WavefrontSample {
                pupil: pupil / radius,
                aberration_um: 1e3 * (reference - length),
                weight: weight / SPOKES as f64,
            });
        }
    }
    let (coefficients_um, residual_um) = fit::least_squares(&samples);
    Ok(Wavefront {
        coefficients_um,
        pupil_radius_mm: radius,
        residual_um,
        samples,
        retina_mm: chief.retina,
        towards_object: chief.towards,
    })
}

/// Radius of the stop (mm) that the real ray parallel to the axis at `entrance_radius_mm` just passes;
/// `None` where that ray does not get there.
pub fn stop_radius_for(eye: &SchematicEye, entrance_radius_mm: f64) -> Option<f64> {
    let ray = Ray::new(DVec3::new(entrance_radius_mm, 0.0, -10.0), DVec3::Z)?;
    eye.trace_to_stop(ray).map(|point| point.x)
}

/// The ray from the object through the centre of the stop, and the sphere about the object.
struct ChiefRay {
    /// Where it lands.
    retina: DVec3,
    /// Direction from the eye to the object.
    towards: DVec3,
    /// Where it crosses the plane of the entrance pupil.
    centre: DVec3,
    /// Curvature (1/mm) of the sphere about the object through `centre`.
    curvature: f64,
    /// Path from the retina to `centre` (mm).
    optical_path_mm: f64,
}

impl ChiefRay {
    fn find(
        eye: &SchematicEye,
        constants: &Paraxial,
        object: ObjectPoint,
    ) -> Result<Self, WavefrontError> {
        let limit = 89_f64.to_radians();
        let legal = (-20.0..=1000.0).contains(&object.vergence_d)
            && object.azimuth.abs() <= limit
            && object.elevation.abs() <= limit;
        if !legal {
            return Err(WavefrontError::Object);
        }
        let (sin_a, cos_a) = object.azimuth.sin_cos();
        let (sin_e, cos_e) = object.elevation.sin_cos();
        let towards = DVec3::new(sin_a * cos_e, sin_e, -cos_a * cos_e);
        let z = constants.entrance_pupil.z_mm;
        let vergence = 1e-3 * object.vergence_d;
        // The ray of the object through the point `at` of the plane of the entrance pupil.
        let ray_at = |at: DVec2| {
            let offset = at.extend(0.0);
            let direction = (vergence * offset - towards).try_normalize()?;
            let through = offset + DVec3::new(0.0, 0.0, z);
            // From in front of the cornea, but not from behind the object.
            let back = 15.0_f64.min(0.999 / vergence.max(1e-9)).max(0.0);
            Ray::new(through - back * direction, direction)
        };
        let to_stop = |at: DVec2| Some(eye.trace_to_stop(ray_at(at)?)?.truncate());
        let centre = eye.interfaces[eye.stop].placed.vertex.truncate();
        let oblique = towards.truncate().try_normalize().unwrap_or(DVec2::X);
        let found = find(centre, centre, None, &to_stop)
            .or_else(|| {
                find(
                    centre,
                    search_start(centre, oblique, &to_stop)?,
                    None,
                    &to_stop,
                )
            })
            .ok_or(WavefrontError::NotSeen)?;
        let incoming = ray_at(found.0).ok_or(WavefrontError::NotSeen)?;
        let retina = match eye.trace_to_retina(incoming) {
            Traced::Through { ray, .. } => ray,
            stopped => return Err(WavefrontError::Ray(stopped)),
        };
        let mut chief = Self {
            retina: retina.origin,
            towards: -incoming.direction,
            centre: found.0.extend(z),
            curvature: 0.0,
            optical_path_mm: 0.0,
        };
        // The object stands 1/V from the axial point of the pupil; from `centre` it is a little nearer
        // or further.
        let to_object = towards - vergence * found.0.extend(0.0);
        chief.curvature = vergence / to_object.length();
        // The path is measured outwards, like those it is compared with.
        match trace_out_of(
            &eye.interfaces,
            Ray {
                origin: retina.origin,
                direction: -retina.direction,
            },
        ) {
            Traced::Through {
                ray,
                optical_path_mm,
            } => {
                let (_, beyond) = chief.compare(ray).ok_or(WavefrontError::NotSeen)?;
                chief.optical_path_mm = optical_path_mm + beyond;
                Ok(chief)
            }
            stopped => Err(WavefrontError::Ray(stopped)),
        }
    }

    /// Where a ray that has left the eye crosses the plane of the entrance pupil (from the chief ray,
    /// mm), and how far along it the sphere about the object is (mm; behind it, mostly).
    fn compare(&self, ray: Ray) -> Option<(DVec2, f64)> {
        let pupil = ray.at_depth(self.centre.z)?.truncate() - self.centre.truncate();
        // |q + s d − u/κ| = 1/κ with q from the centre of the pupil: κ s² + 2 b s + c = 0, which has
        // its root of small s however flat the sphere.
        let q = ray.origin - self.centre;
        let b = self.curvature * ray.direction.dot(q) - ray.direction.dot(self.towards);
        let c = self.curvature * q.length_squared() - 2.0 * q.dot(self.towards);
        let discriminant = b * b - self.curvature * c;
        let s = c / (discriminant.max(0.0).sqrt() - b);
        (b < 0.0 && s.is_finite()).then_some((pupil, s))
    }
}

#[cfg(test)]
mod tests;
