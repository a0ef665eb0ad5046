//! The outer surface of the globe: scleral sphere and corneal conicoid, joined smoothly at the
//! limbus.
//!
//! In: the radii of an eye. Out: the surface's distance from the centre of rotation in any
//! direction, its normal, and the one conversion between globe and optics frame.
//!
//! Globe frame: origin at the centre of rotation (the sphere's centre), y up, gaze along −z, mm.
//! With R 7.8, p 0.75, a limbus of 5.85 and a sphere of 11.5 mm the apex stands 12.39 mm in front of
//! the centre and the globe is 23.9 mm long, as the emmetropic eye is (Atchison 2006: 23.58).

use super::conicoid::{conicoid_intersect, conicoid_normal, conicoid_sag};
use glam::{DVec2, DVec3};
use thiserror::Error;

/// Height (mm) over which sclera and cornea merge by default: it rounds the limbus over about
/// 1.3 mm, the width of the limbal transition, and lifts it by a quarter of this.
pub const LIMBUS_BLEND_MM: f64 = 0.15;

/// A globe that cannot be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GlobeShapeError {
    /// A number lies outside the range that eyes have.
    #[error("globe {field} is {value}, but must lie between {low} and {high}")]
    OutOfRange {
        /// The field's name, with its unit.
        field: &'static str,
        /// What was given.
        value: f64,
        /// Lowest allowed.
        low: f64,
        /// Highest allowed.
        high: f64,
    },
    /// The cornea would not bulge out of the sclera.
    #[error(
        "corneal radius {cornea_radius_mm} mm with shape factor {shape_factor} is no steeper at the \
         limbus ({limbus_radius_mm} mm) than the sclera ({sclera_radius_mm} mm): give a smaller corneal radius"
    )]
    CorneaTooFlat {
        /// Apical radius of the cornea.
        cornea_radius_mm: f64,
        /// Shape factor of the cornea.
        shape_factor: f64,
        /// Radius of the limbus.
        limbus_radius_mm: f64,
        /// Radius of the sclera.
        sclera_radius_mm: f64,
    },
}

/// The outer shape of an eye, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobeShape {
    sclera_radius_mm: f64,
    cornea: DVec2,
    limbus_radius_mm: f64,
    blend_mm: f64,
    /// [`Self::apex_distance_mm`], which every distance asks for.
    apex_mm: f64,
    /// Cosine to the axis below which the surface is the scleral sphere and nothing else.
    scleral_cosine: f64,
}

impl Default for GlobeShape {
    /// The schematic eye: sphere 11.5 mm, cornea R 7.8 mm and p 0.75, limbus 5.85 mm.
    fn default() -> Self {
        Self::of(11.5, super::cornea::ANTERIOR_CORNEA, 5.85)
    }
}

impl GlobeShape {
    /// A globe of scleral radius 9 to 15 mm, corneal apical radius 6 to 10 mm, shape factor −0.5 to
    /// 1.5 and limbus radius 4.5 to 6.8 mm.
    ///
    /// # Errors
    /// [`GlobeShapeError`] when a number is out of range or the cornea would not bulge.
    pub fn new(
        sclera_radius_mm: f64,
        cornea_radius_mm: f64,
        shape_factor: f64,
        limbus_radius_mm: f64,
    ) -> Result<Self, GlobeShapeError> {
        for (field, value, low, high) in [
            ("sclera_radius_mm", sclera_radius_mm, 9.0, 15.0),
            ("cornea_radius_mm", cornea_radius_mm, 6.0, 10.0),
            ("shape_factor", shape_factor, -0.5, 1.5),
            ("limbus_radius_mm", limbus_radius_mm, 4.5, 6.8),
        ] {
            if !(low..=high).contains(&value) {
                return Err(GlobeShapeError::OutOfRange {
                    field,
                    value,
                    low,
                    high,
                });
            }
        }
        // Slopes at the limbus: r/√(R² − p r²) against r/√(S² − r²).
        let cornea_squared = cornea_radius_mm.powi(2) - shape_factor * limbus_radius_mm.powi(2);
        let sclera_squared = sclera_radius_mm.powi(2) - limbus_radius_mm.powi(2);
        // A limbus within 5 % of an ellipsoid's equator would hang over.
        let overhangs = cornea_squared < 0.1 * cornea_radius_mm.powi(2);
        if overhangs {
            let high = cornea_radius_mm * (0.9 / shape_factor).sqrt();
            return Err(GlobeShapeError::OutOfRange {
                field: "limbus_radius_mm",
                value: limbus_radius_mm,
                low: 4.5,
                high,
            });
        }
        if cornea_squared >= sclera_squared {
            return Err(GlobeShapeError::CorneaTooFlat {
                cornea_radius_mm,
                shape_factor,
                limbus_radius_mm,
                sclera_radius_mm,
            });
        }
        Ok(Self::of(
            sclera_radius_mm,
            DVec2::new(cornea_radius_mm, shape_factor),
            limbus_radius_mm,
        ))
    }

    fn of(sclera_radius_mm: f64, cornea: DVec2, limbus_radius_mm: f64) -> Self {
        let mut shape = Self {
            sclera_radius_mm,
            cornea,
            limbus_radius_mm,
            blend_mm: LIMBUS_BLEND_MM,
            apex_mm: globe_apex_distance(sclera_radius_mm, cornea, limbus_radius_mm),
            scleral_cosine: -1.0,
        };
        // From the back to the front, for as long as there is no cornea.
        const STEPS: u32 = 360;
        let cosine = |step: u32| (core::f64::consts::PI * f64::from(step) / f64::from(STEPS)).cos();
        let is_scleral = |step: &u32| {
            let cosine = cosine(*step);
            shape.radius_at(cosine) == sclera_radius_mm
        };
        let clear = (0..=STEPS).rev().take_while(is_scleral).last();
        // The border lies before the last step that has no cornea.
        shape.scleral_cosine = clear.map_or(-1.0, cosine);
        shape
    }

    /// Radius of the scleral sphere (mm).
    pub fn sclera_radius_mm(&self) -> f64 {
        self.sclera_radius_mm
    }

    /// The anterior cornea: (apical radius in mm, shape factor).
    pub fn cornea(&self) -> DVec2 {
        self.cornea
    }

    /// Radius of the limbus, where conicoid and sphere meet (mm).
    pub fn limbus_radius_mm(&self) -> f64 {
        self.limbus_radius_mm
    }

    /// Height over which the two surfaces merge (mm).
    pub fn blend_mm(&self) -> f64 {
        self.blend_mm
    }

    /// Distance from the centre of rotation to the corneal apex (mm).
    pub fn apex_distance_mm(&self) -> f64 {
        self.apex_mm
    }

    /// A point of the globe frame in the optics frame.
    pub fn optics_from_globe(&self, point: DVec3) -> DVec3 {
        point + DVec3::new(0.0, 0.0, self.apex_distance_mm())
    }

    /// A point of the optics frame in the globe frame.
    pub fn globe_from_optics(&self, point: DVec3) -> DVec3 {
        point - DVec3::new(0.0, 0.0, self.apex_distance_mm())
    }

    /// Distance (mm) from the centre of rotation to the surface along a direction of the globe
    /// frame (need not be of unit length; a null vector counts as straight ahead). One derivative
    /// is continuous everywhere.
    pub fn radius_along(&self, direction: DVec3) -> f64 {
        self.radius_at(-direction.normalize_or(DVec3::NEG_Z).z)
    }

    /// The same along any direction whose angle to the axis has this cosine: the globe is round.
    pub fn radius_at(&self, cosine: f64) -> f64 {
        if cosine < self.scleral_cosine {
            return self.sclera_radius_mm;
        }
        let cosine = cosine.min(1.0);
        let reach = self.corneal_reach(cosine).unwrap_or_else(|| {
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            let apex = DVec3::new(0.0, 0.0, self.apex_mm);
            let direction = DVec3::new(sine, 0.0, -cosine);
            conicoid_intersect(apex, direction, self.cornea.x, self.cornea.y)
        });
        merged(reach, self.sclera_radius_mm, self.blend_mm)
    }

    /// Distance (mm) to the front half of the conicoid, in the plane of axis and direction; none where it is not met there.
    fn corneal_reach(&self, cosine: f64) -> Option<f64> {
        let [radius, p] = self.cornea.to_array();
        let apex = self.apex_mm;
        // With z = apex − r cos, equation 1 is a r² + 2 b r = c.
        let a = 1.0 + (p - 1.0) * cosine * cosine;
        let b = (radius - p * apex) * cosine;
        let c = (2.0 * radius - p * apex) * apex;
        let discriminant = b * b + a * c;
        if cosine < 0.0 || discriminant < 0.0 {
            return None;
        }
        // Of two forms of one root, the one that adds.
        let reach = if b >= 0.0 {
            c / (b + discriminant.sqrt())
        } else {
            (discriminant.sqrt() - b) / a
        };
        let is_front = radius - p * (apex - reach * cosine) >= 0.0;
        (is_front && reach > 0.0 && reach.is_finite()).then_some(reach)
    }

    /// Unit normal, pointing out of the globe, of the surface along a direction of the globe frame.
    pub fn normal_along(&self, direction: DVec3) -> DVec3 {
        let direction = direction.normalize_or(DVec3::NEG_Z);
        let apex = DVec3::new(0.0, 0.0, self.apex_distance_mm());
        let reach = conicoid_intersect(apex, direction, self.cornea.x, self.cornea.y);
        let over = reach - self.sclera_radius_mm;
        if over <= -self.blend_mm {
            return direction;
        }
        let normal = conicoid_normal(apex + reach * direction, self.cornea.x, self.cornea.y);
        // r̂ − ∇ρ/ρ is the normal of r = ρ(direction): the cornea's own, n/(n·r̂), counts in
        // proportion to the smooth maximum's derivative.
        let weight = (0.5 * (1.0 + over / self.blend_mm)).clamp(0.0, 1.0);
        let corneal = normal / normal.dot(direction).max(1e-6);
        let slope = (corneal - direction) * (weight * reach / self.radius_along(direction));
        (direction + slope).normalize()
    }
}

/// Distance (mm) from the globe's centre to its surface along the unit `direction` of the globe
/// frame. `cornea` = (apical radius, shape factor), `blend` = the height (mm) over which the two
/// surfaces merge at the limbus.
pub fn globe_radius_along(
    direction: DVec3,
    sclera_radius: f64,
    cornea: DVec2,
    limbus_radius: f64,
    blend: f64,
) -> f64 {
    let apex = globe_apex_distance(sclera_radius, cornea, limbus_radius);
    let reach = conicoid_intersect(DVec3::new(0.0, 0.0, apex), direction, cornea.x, cornea.y);
    merged(reach, sclera_radius, blend)
}

/// The smooth maximum of two heights: polynomial, one derivative continuous.
fn merged(reach: f64, sclera_radius: f64, blend: f64) -> f64 {
    let overlap = (blend - (reach - sclera_radius).abs()).max(0.0);
    reach.max(sclera_radius) + overlap * overlap / (4.0 * blend)
}

/// Distance (mm) from the globe's centre to the corneal apex: the two surfaces meet at
/// `limbus_radius`.
pub fn globe_apex_distance(sclera_radius: f64, cornea: DVec2, limbus_radius: f64) -> f64 {
    let sclera_depth = (sclera_radius * sclera_radius - limbus_radius * limbus_radius)
        .max(0.0)
        .sqrt();
    sclera_depth + conicoid_sag(limbus_radius, cornea.x, cornea.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_way_over_the_sclera_is_the_whole_one() {
        for (sclera, radius, p, limbus) in [
            (11.5, 7.8, 0.75, 5.85),
            (10.0, 6.5, -0.4, 5.0),
            (13.5, 8.4, 1.2, 6.4),
            (12.0, 7.0, 0.0, 5.5),
        ] {
            let shape = GlobeShape::new(sclera, radius, p, limbus).expect("an eye");
            // Most of a globe is sclera; a hyperboloid comes round again behind it.
            assert!(p <= 0.0 || shape.scleral_cosine > 0.7, "{shape:?}");
            // Towards the asymptote of a hyperboloid digits are lost, whichever way is taken.
            let farthest = if p <= 0.0 { 1200 } else { 1800 };
            for step in 0..=farthest {
                let direction = direction(0.1 * f64::from(step));
                let whole =
                    globe_radius_along(direction, sclera, shape.cornea, limbus, shape.blend_mm);
                // The cosine and its sine are rounded once more, and near grazing digits are lost.
                let off = (shape.radius_along(direction) - whole).abs();
                assert!(off < 1e-12, "{shape:?} {step}: {off}");
            }
        }
    }

    fn direction(degrees: f64) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(0.6 * sin, 0.8 * sin, -cos)
    }

    #[test]
    fn apex_and_poles_stand_where_they_should() {
        let globe = GlobeShape::default();
        // √(11.5² − 5.85²) + 2.4924 = 9.9009 + 2.4924.
        assert!((globe.apex_distance_mm() - 12.3933).abs() < 1e-4);
        assert!((globe.radius_along(DVec3::NEG_Z) - globe.apex_distance_mm()).abs() < 1e-12);
        assert_eq!(globe.radius_along(DVec3::Z), 11.5);
        assert_eq!(globe.radius_along(DVec3::X), 11.5);
        let apex = globe.globe_from_optics(DVec3::ZERO);
        assert!((apex.z + 12.3933).abs() < 1e-4);
        assert!(globe.optics_from_globe(apex).length() < 1e-15);
    }

    #[test]
    fn the_cornea_is_the_conicoid_and_the_sclera_the_sphere_off_the_limbus() {
        let globe = GlobeShape::default();
        for degrees in 0..=27 {
            let d = direction(f64::from(degrees));
            let q = globe.optics_from_globe(globe.radius_along(d) * d);
            let r = q.truncate().length();
            assert!(
                (q.z - conicoid_sag(r, 7.8, 0.75)).abs() < 1e-12,
                "{degrees}°"
            );
        }
        for degrees in 35..=180 {
            assert_eq!(globe.radius_along(direction(f64::from(degrees))), 11.5);
        }
        // The limbus is lifted by a quarter of the blend and no more.
        let limbus = direction((5.85_f64 / 11.5).asin().to_degrees());
        assert!((globe.radius_along(limbus) - 11.5 - 0.0375).abs() < 1e-9);
    }

    #[test]
    fn radius_and_slope_are_continuous() {
        let globe = GlobeShape::default();
        let radius = |degrees: f64| globe.radius_along(direction(degrees));
        let step = 1e-3;
        let mut last_slope = 0.0;
        for i in 1..60_000 {
            let degrees = f64::from(i) * step;
            let slope = (radius(degrees) - radius(degrees - step)) / step;
            // The merge bends by 0.05 mm/° within 2.9°, so by 4e-5 in a thousandth; a kink would
            // jump by all of 0.05.
            assert!(
                (slope - last_slope).abs() < 1e-4,
                "{degrees}°: {last_slope} {slope}"
            );
            last_slope = slope;
        }
    }

    #[test]
    fn normals_are_the_gradient() {
        let globe = GlobeShape::default();
        for degrees in [0.5, 10.0, 27.0, 29.0, 30.5, 31.0, 33.0, 60.0, 170.0] {
            let h = 1e-4;
            let at = |t: f64| globe.radius_along(direction(t)) * direction(t);
            let along = at(degrees + h) - at(degrees - h);
            let around = DVec3::new(-0.8, 0.6, 0.0);
            let expected = along.cross(around).normalize();
            let expected = if expected.dot(direction(degrees)) < 0.0 {
                -expected
            } else {
                expected
            };
            // Second-order differences over 2e-6 rad.
            assert!(
                globe.normal_along(direction(degrees)).distance(expected) < 1e-7,
                "{degrees}°"
            );
        }
        assert_eq!(globe.normal_along(DVec3::ZERO).z, -1.0);
    }

    #[test]
    fn impossible_globes_are_refused_in_one_sentence() {
        let error = GlobeShape::new(11.5, 5.0, 0.75, 5.85).unwrap_err();
        assert_eq!(
            error.to_string(),
            "globe cornea_radius_mm is 5, but must lie between 6 and 10"
        );
        assert!(GlobeShape::new(f64::NAN, 7.8, 0.75, 5.85).is_err());
        assert!(matches!(
            GlobeShape::new(9.0, 9.0, 0.0, 5.85),
            Err(GlobeShapeError::CorneaTooFlat { .. })
        ));
        assert!(GlobeShape::new(11.5, 6.0, 1.2, 5.85).is_err());
        assert!(GlobeShape::new(11.5, 7.8, 0.75, 5.85).is_ok_and(|g| g == GlobeShape::default()));
    }
}
