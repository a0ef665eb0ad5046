//! The paths of retinal nerve fibres, after Jansonius et al. (2009).
//!
//! What enters: a place on the retina of OD in degrees, the fovea at the origin, x towards the
//! nose (temporal in the field), y up on the retina (down in the field). What leaves: where the
//! fibre of that place enters the disc. A path is φ = φ0 + b(φ0)·(r − 4)^c(φ0) in polar
//! coordinates about the disc at (15, 2)°; the y axis is bent by 2(x/15)² on the nasal side, so
//! that the line from disc to fovea and on to the raphe is straight.

use crate::optics::root::illinois;

/// Angle at the disc, °, between which and its negative fibres run straight (they are not
/// described by the paper, and serve the temporal field).
const STRAIGHT_WITHIN_DEG: f64 = 60.0;
/// An angle that is this far from the one that is sought counts as this far, °.
const FAR_OFF_DEG: f64 = 30.0;
/// Radius of the disc's border, °.
const DISC_RADIUS_DEG: f64 = 4.0;

/// The fibre that serves a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle {
    /// Angle at which it enters the disc, °, −180–180: 0 nasal, 90 above, ±180 towards the fovea.
    pub angle_deg: f64,
    /// Distance of the place from the disc's centre, °.
    pub distance_deg: f64,
}

/// The path of the bundle that enters at `angle_deg`: its polar angle at `distance_deg` from the
/// disc, both in °. The published range is 60 ≤ |angle| ≤ 180; inside ±60° paths are straight.
#[must_use]
pub fn path_angle_deg(angle_deg: f64, distance_deg: f64) -> f64 {
    let beyond = (distance_deg - DISC_RADIUS_DEG).max(0.0);
    if beyond == 0.0 || angle_deg.abs() < STRAIGHT_WITHIN_DEG {
        angle_deg
    } else if angle_deg > 0.0 {
        let tanh = ((angle_deg - 121.0) / 14.0).tanh();
        angle_deg + (-1.9 - 3.9 * tanh).exp() * beyond.powf(1.9 + 1.4 * tanh)
    } else {
        let tanh = ((-angle_deg - 90.0) / 25.0).tanh();
        angle_deg - (0.7 - 1.5 * tanh).exp() * beyond.powf(1.0 + 0.5 * tanh)
    }
}

/// The bundle that serves the place (x, y), by solving its path for the entry angle.
#[must_use]
pub fn bundle_of(x_deg: f64, y_deg: f64) -> Bundle {
    let bent = if x_deg > 0.0 {
        2.0 * (x_deg / 15.0).powi(2)
    } else {
        0.0
    };
    let (dx, dy) = (x_deg - 15.0, y_deg - bent);
    let distance_deg = dx.hypot(dy);
    let polar = dy.atan2(dx).to_degrees();
    let sign = if polar < 0.0 { -1.0 } else { 1.0 };
    let first = path_angle_deg(sign * STRAIGHT_WITHIN_DEG, distance_deg);
    let angle_deg = if distance_deg <= DISC_RADIUS_DEG {
        polar
    } else if polar.abs() <= first.abs() {
        // Between the horizontal and the first described path: spread evenly.
        polar * STRAIGHT_WITHIN_DEG / first.abs()
    } else {
        entry_angle_deg(polar, sign, distance_deg)
    };
    Bundle {
        angle_deg,
        distance_deg,
    }
}

/// Entry angle whose path passes through `polar`. Bundles do not cross, so the polar angle grows with
/// the entry angle; a dozen steps leave less than 1e-6°.
fn entry_angle_deg(polar: f64, sign: f64, distance_deg: f64) -> f64 {
    // Long paths make the far end explode; what is far off is far off.
    let excess = |angle: f64| {
        (path_angle_deg(sign * angle, distance_deg).abs() - polar.abs()).min(FAR_OFF_DEG)
    };
    let ends = [STRAIGHT_WITHIN_DEG, 180.0].map(|angle| (angle, excess(angle)));
    sign * illinois(ends[0], ends[1], 1e-7, excess)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coefficients_are_the_published_ones() {
        // At φ0 = 121 the hyperbolic tangent is 0: b = e^−1.9, c = 1.9; at −90: −e^0.7 and 1.
        let above = path_angle_deg(121.0, 14.0);
        assert!((above - (121.0 + (-1.9_f64).exp() * 10.0_f64.powf(1.9))).abs() < 1e-12);
        let below = path_angle_deg(-90.0, 14.0);
        assert!((below + 90.0 + 0.7_f64.exp() * 10.0).abs() < 1e-12);
        assert_eq!(path_angle_deg(121.0, 4.0), 121.0);
    }

    #[test]
    fn a_place_on_a_path_finds_its_bundle() {
        for entry in [
            -170.0, -140.0, -120.0, -90.0, -62.0, 62.0, 90.0, 120.0, 140.0, 170.0,
        ] {
            for distance in [5.0, 10.0, 15.0, 20.0] {
                let polar: f64 = path_angle_deg(entry, distance);
                // Beyond the raphe a path is not a fibre any more.
                if polar.abs() >= 180.0 {
                    continue;
                }
                let (sin, cos) = polar.to_radians().sin_cos();
                let x = 15.0 + distance * cos;
                let bent = if x > 0.0 {
                    2.0 * (x / 15.0).powi(2)
                } else {
                    0.0
                };
                let found = bundle_of(x, distance * sin + bent);
                assert!((found.distance_deg - distance).abs() < 1e-9);
                assert!((found.angle_deg - entry).abs() < 1e-4, "{entry}: {found:?}");
            }
        }
    }

    #[test]
    fn no_two_bundles_cross_before_the_raphe() {
        for distance in [5.0, 10.0, 20.0, 30.0] {
            for sign in [-1.0, 1.0] {
                let mut last = 0.0;
                for entry in 60..=180 {
                    let polar = path_angle_deg(sign * f64::from(entry), distance).abs();
                    if polar > 180.0 {
                        break;
                    }
                    assert!(polar > last, "{sign} {entry} at {distance}");
                    last = polar;
                }
            }
        }
    }

    #[test]
    fn the_raphe_divides_upper_from_lower_bundles() {
        let (above, below) = (bundle_of(-12.0, 0.01), bundle_of(-12.0, -0.01));
        assert!(above.angle_deg > 100.0 && below.angle_deg < -100.0);
        assert!(bundle_of(60.0, 0.0).angle_deg.abs() < 60.0);
        for (x, y) in [
            (15.0, 2.0),
            (0.0, 0.0),
            (-180.0, 0.0),
            (0.0, 180.0),
            (90.0, -90.0),
        ] {
            let bundle = bundle_of(x, y);
            assert!(bundle.angle_deg.is_finite() && bundle.distance_deg.is_finite());
        }
    }
}
