//! Gaze geometry: directions, the angles between them, and the torsion that Listing's law adds.
//!
//! What enters and leaves: azimuth (positive to the patient's right) and elevation (positive up)
//! in radians about the head's axes, x right, y up, gaze along −z; the globe's rotation is
//! Ry(−azimuth)·Rx(elevation)·Rz(−torsion). Listing's law is stated in these Fick angles.

use glam::DVec3;

/// How far the eye turns from straight ahead, rad (55°); farther targets are clamped to it.
pub const OCULOMOTOR_RANGE_RAD: f64 = 55.0 * std::f64::consts::PI / 180.0;

/// A direction of gaze relative to the head.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GazeAngles {
    /// Positive to the patient's right, rad.
    pub azimuth_rad: f64,
    /// Positive up, rad.
    pub elevation_rad: f64,
}

impl GazeAngles {
    /// Both angles, rad.
    #[must_use]
    pub const fn new(azimuth_rad: f64, elevation_rad: f64) -> Self {
        Self {
            azimuth_rad,
            elevation_rad,
        }
    }

    /// The unit vector (sin az cos el, sin el, −cos az cos el).
    #[must_use]
    pub fn direction(self) -> DVec3 {
        let (sin_az, cos_az) = self.azimuth_rad.sin_cos();
        let (sin_el, cos_el) = self.elevation_rad.sin_cos();
        DVec3::new(sin_az * cos_el, sin_el, -cos_az * cos_el)
    }

    /// The angles of a vector; the zero vector is straight ahead.
    #[must_use]
    pub fn of(direction: DVec3) -> Self {
        if direction == DVec3::ZERO {
            return Self::default();
        }
        Self {
            azimuth_rad: direction.x.atan2(-direction.z),
            elevation_rad: direction.y.atan2(direction.x.hypot(direction.z)),
        }
    }

    /// The angle to another direction, rad, exact for tiny ones too.
    #[must_use]
    pub fn angle_to(self, other: Self) -> f64 {
        let (a, b) = (self.direction(), other.direction());
        a.cross(b).length().atan2(a.dot(b))
    }

    /// `other` as seen from this gaze: where it falls in the visual field, in the same angles
    /// (Listing's torsion is left out, under 1° within 10° of straight ahead).
    #[must_use]
    pub fn field_position_of(self, other: Self) -> Self {
        let v = other.direction();
        let (sin_az, cos_az) = self.azimuth_rad.sin_cos();
        let (sin_el, cos_el) = self.elevation_rad.sin_cos();
        // The inverse of Ry(−az)·Rx(el), first about y, then about x.
        let (x, z) = (v.x * cos_az + v.z * sin_az, v.z * cos_az - v.x * sin_az);
        let (y, z) = (v.y * cos_el + z * sin_el, z * cos_el - v.y * sin_el);
        Self::of(DVec3::new(x, y, z))
    }

    /// The point at the share `fraction` of the great circle from here to `end`. Opposite
    /// directions, which no eye can join, stay at the nearer end.
    #[must_use]
    pub fn along(self, end: Self, fraction: f64) -> Self {
        let angle = self.angle_to(end);
        let sin = angle.sin();
        if sin < 1e-9 {
            let blend = |a: f64, b: f64| a + (b - a) * fraction;
            if angle > 1.0 {
                return if fraction < 0.5 { self } else { end };
            }
            return Self::new(
                blend(self.azimuth_rad, end.azimuth_rad),
                blend(self.elevation_rad, end.elevation_rad),
            );
        }
        let (a, b) = (((1.0 - fraction) * angle).sin(), (fraction * angle).sin());
        Self::of((self.direction() * a + end.direction() * b) / sin)
    }

    /// The nearest direction within [`OCULOMOTOR_RANGE_RAD`] of straight ahead.
    #[must_use]
    pub fn within_range(self) -> Self {
        let ahead = Self::default();
        let angle = ahead.angle_to(self);
        if angle <= OCULOMOTOR_RANGE_RAD {
            self
        } else {
            ahead.along(self, OCULOMOTOR_RANGE_RAD / angle)
        }
    }

    /// Torsion that Listing's law demands at this gaze, rad, positive when the top of the eye
    /// leans to the patient's right: tan(T/2) = tan(az/2)·tan(el/2) in these axes. (With elevation
    /// counted positive down, as in Fick's right-handed angles, or torsion the other way, the sign
    /// flips.)
    #[must_use]
    pub fn listing_torsion_rad(self) -> f64 {
        2.0 * ((0.5 * self.azimuth_rad).tan() * (0.5 * self.elevation_rad).tan()).atan()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn grid() -> impl Iterator<Item = GazeAngles> {
        (-5..=5).flat_map(|i| {
            (-5..=5).map(move |j| GazeAngles::new(f64::from(i) * 0.15, f64::from(j) * 0.13))
        })
    }

    /// Listing's law itself, as the oracle: the rotation from straight ahead has its axis in the
    /// plane across the line of sight, so the quaternion has no z component.
    #[test]
    fn torsion_obeys_listings_law() {
        for gaze in grid() {
            let q = DQuat::from_rotation_y(-gaze.azimuth_rad)
                * DQuat::from_rotation_x(gaze.elevation_rad)
                * DQuat::from_rotation_z(-gaze.listing_torsion_rad());
            assert!(q.z.abs() < 1e-15, "{gaze:?}: {}", q.z);
            let sight = q * DVec3::NEG_Z;
            assert!((sight - gaze.direction()).length() < 1e-14);
        }
        let wrong = DQuat::from_rotation_y(-0.5)
            * DQuat::from_rotation_x(0.4)
            * DQuat::from_rotation_z(GazeAngles::new(0.5, 0.4).listing_torsion_rad());
        assert!(wrong.z.abs() > 0.05);
    }

    #[test]
    fn angles_and_directions_are_inverse() {
        for gaze in grid() {
            let back = GazeAngles::of(gaze.direction());
            assert!((back.azimuth_rad - gaze.azimuth_rad).abs() < 1e-14);
            assert!((back.elevation_rad - gaze.elevation_rad).abs() < 1e-14);
        }
        assert_eq!(GazeAngles::of(DVec3::ZERO), GazeAngles::default());
    }

    #[test]
    fn field_position_is_the_inverse_rotation() {
        for gaze in grid() {
            let target = GazeAngles::new(0.3, -0.2);
            let seen = gaze.field_position_of(target);
            let q = DQuat::from_rotation_y(-gaze.azimuth_rad)
                * DQuat::from_rotation_x(gaze.elevation_rad);
            assert!((q * seen.direction() - target.direction()).length() < 1e-14);
        }
        let right = GazeAngles::new(0.2, 0.1).field_position_of(GazeAngles::new(0.5, 0.1));
        assert!(right.azimuth_rad > 0.0);
    }

    #[test]
    fn the_great_circle_covers_equal_angles() {
        let (a, b) = (GazeAngles::new(-0.6, 0.3), GazeAngles::new(0.5, -0.4));
        let whole = a.angle_to(b);
        for i in 0..=10 {
            let fraction = f64::from(i) / 10.0;
            let point = a.along(b, fraction);
            assert!((a.angle_to(point) - fraction * whole).abs() < 1e-14);
            assert!((point.angle_to(b) - (1.0 - fraction) * whole).abs() < 1e-14);
        }
        let opposite = GazeAngles::new(std::f64::consts::PI, 0.0);
        let middle = GazeAngles::default().along(opposite, 0.4);
        assert!(middle.azimuth_rad.is_finite() && middle.elevation_rad.is_finite());
        let far = GazeAngles::new(1.4, 0.3).within_range();
        let reach = GazeAngles::default().angle_to(far);
        assert!((reach - OCULOMOTOR_RANGE_RAD).abs() < 1e-14);
    }
}
