//! The corneal conicoid of François et al. 2007, equation 1: `p z² − 2 R z + x² + y² = 0`.
//!
//! In: rays and points of the optics frame (origin at the apex, +z into the eye, mm). Out: where a
//! ray meets the front sheet, the normal there, the sag. `R` is the apical radius of curvature and
//! `p` the shape factor: 1 sphere, 0 paraboloid, below 0 hyperboloid, `p = 1 + Q` with the
//! asphericity `Q` of schematic eyes. Only the front sheet `R − p z ≥ 0` is the eye's surface.
//!
//! Twin: `shaders/lib/conicoid.wgsl`.

use glam::DVec3;

/// Coefficients of `t²` smaller than this put the root further away than any eye is wide.
const CONICOID_FLAT_QUADRATIC: f64 = 1e-6;

/// Distance along `dir` (in lengths of `dir`) to the nearest point at or ahead of `origin` on the
/// front sheet; −1 when the ray misses it, and for a radius that is not positive or a `dir` of
/// length zero.
///
/// The origin may be any distance away: the quadratic is set up at the ray's closest approach to
/// the apex, and its roots are found without subtracting nearly equal numbers.
pub fn conicoid_intersect(origin: DVec3, dir: DVec3, radius: f64, p: f64) -> f64 {
    let dir_squared = dir.length_squared();
    if !(radius > 0.0 && dir_squared > 0.0) {
        return -1.0;
    }
    let shift = -origin.dot(dir) / dir_squared;
    let o = origin + shift * dir;
    let a = p * dir.z * dir.z + dir.x * dir.x + dir.y * dir.y;
    let b = p * o.z * dir.z - radius * dir.z + o.x * dir.x + o.y * dir.y;
    let c = p * o.z * o.z - 2.0 * radius * o.z + o.x * o.x + o.y * o.y;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return -1.0;
    }
    // t₁ = q/a and t₂ = c/q.
    let q = -(b + if b >= 0.0 { 1.0 } else { -1.0 } * discriminant.sqrt());
    let nearer = |nearest: f64, t: f64| {
        let forward = t + shift;
        let on_front_sheet = radius - p * (o.z + t * dir.z) >= 0.0;
        if forward >= 0.0 && on_front_sheet && (nearest < 0.0 || forward < nearest) {
            forward
        } else {
            nearest
        }
    };
    let mut nearest = -1.0;
    if a.abs() > CONICOID_FLAT_QUADRATIC * dir_squared {
        nearest = nearer(nearest, q / a);
    }
    if q != 0.0 {
        nearest = nearer(nearest, c / q);
    }
    nearest
}

/// Unit normal at a point of the surface, pointing out of the eye (−z at the apex).
pub fn conicoid_normal(point: DVec3, radius: f64, p: f64) -> DVec3 {
    DVec3::new(point.x, point.y, p * point.z - radius)
        .try_normalize()
        .unwrap_or(DVec3::NEG_Z)
}

/// Depth (mm) of the surface below the apex plane at distance `r` from the axis. Past the equator
/// of an ellipsoid it stays at the equator's depth, so that the result is always finite.
pub fn conicoid_sag(r: f64, radius: f64, p: f64) -> f64 {
    if p <= 0.0 {
        return r * r / (radius + (radius * radius - p * r * r).sqrt());
    }
    // R² − p r² as a product: near the equator the difference would lose its digits.
    let w = (p.sqrt() * r.abs()).min(radius);
    w * w / (p * (radius + ((radius - w) * (radius + w)).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 7.8;
    const P: f64 = 0.75;

    fn implicit(q: DVec3, radius: f64, p: f64) -> f64 {
        p * q.z * q.z - 2.0 * radius * q.z + q.x * q.x + q.y * q.y
    }

    #[test]
    fn sag_at_the_limbus_is_the_published_one() {
        // REFERENCE: 2.4924 mm at 5.85 mm, four decimals.
        assert!((conicoid_sag(5.85, R, P) - 2.4924).abs() < 5e-5);
        assert_eq!(conicoid_sag(0.0, R, P), 0.0);
        // A sphere has the textbook sag; a paraboloid r²/2R.
        assert!((conicoid_sag(3.0, 5.0, 1.0) - 1.0).abs() < 1e-15);
        assert!((conicoid_sag(3.0, 5.0, 0.0) - 0.9).abs() < 1e-15);
        // Beyond the equator: the equator.
        assert!((conicoid_sag(99.0, 5.0, 1.0) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn sag_continues_smoothly_through_the_paraboloid() {
        let sags = [-1e-9, 0.0, 1e-9].map(|p| conicoid_sag(5.0, R, p));
        assert!((sags[0] - sags[1]).abs() < 1e-8 && (sags[2] - sags[1]).abs() < 1e-8);
    }

    #[test]
    fn hits_lie_on_the_surface_for_every_shape() {
        for p in [-0.5, -1e-7, 0.0, 1e-7, 0.5, 0.75, 1.0, 1.6] {
            for step in 0..200 {
                let (x, y) = (f64::from(step % 20) * 0.25, f64::from(step / 20) * 0.3);
                let target = DVec3::new(x, y, conicoid_sag(x.hypot(y), R, p));
                if x * x + y * y > 30.0 {
                    continue;
                }
                for distance in [0.5, 30.0, 1e3, 1e6] {
                    let origin = DVec3::new(distance * 0.3, -0.2 * distance, -distance);
                    let dir = (target - origin).normalize();
                    let t = conicoid_intersect(origin, dir, R, p);
                    let hit = origin + t * dir;
                    // The rounding of a position 10⁶ mm away is 10⁻¹⁰ mm.
                    let room = 1e-12 * (1.0 + distance) * 20.0;
                    assert!(t > 0.0, "p {p} target {target} distance {distance}");
                    assert!(implicit(hit, R, p).abs() < room, "p {p} {hit}");
                    assert!(hit.z <= target.z + room, "nearest of the two roots");
                }
            }
        }
    }

    #[test]
    fn the_back_of_an_ellipsoid_is_not_the_cornea() {
        // From inside, backwards: only the back sheet lies ahead.
        let inside = DVec3::new(0.0, 0.0, 5.0);
        assert_eq!(conicoid_intersect(inside, DVec3::Z, R, P), -1.0);
        // From inside, forwards: the apex.
        assert!((conicoid_intersect(inside, DVec3::NEG_Z, R, P) - 5.0).abs() < 1e-14);
        // The second sheet of a hyperboloid lies in front of the apex: rays start beyond it.
        let far = DVec3::new(0.0, 0.0, -100.0);
        assert!((conicoid_intersect(far, DVec3::Z, R, -0.5) - 100.0).abs() < 1e-12);
    }

    #[test]
    fn grazing_rays_hit_just_inside_and_miss_just_outside() {
        let tangent = |offset: f64| {
            // Tangent at the apex: along +x at depth `offset`.
            conicoid_intersect(DVec3::new(-50.0, 0.0, offset), DVec3::X, R, P)
        };
        assert!(tangent(1e-12) > 49.9);
        assert_eq!(tangent(-1e-12), -1.0);
        assert!((tangent(0.0) - 50.0).abs() < 1e-12);
    }

    #[test]
    fn degenerate_input_is_a_miss() {
        for (radius, dir) in [
            (0.0, DVec3::Z),
            (-7.8, DVec3::Z),
            (f64::NAN, DVec3::Z),
            (R, DVec3::ZERO),
            (R, DVec3::NAN),
        ] {
            assert_eq!(
                conicoid_intersect(DVec3::new(0.0, 0.0, -5.0), dir, radius, P),
                -1.0
            );
        }
    }

    #[test]
    fn normal_is_the_gradient_and_points_out() {
        assert_eq!(conicoid_normal(DVec3::ZERO, R, P), DVec3::NEG_Z);
        let h = 1e-5;
        for (x, y) in [(1.0, 2.0), (-4.0, 3.0), (5.85, 0.0)] {
            let at = |x: f64, y: f64| DVec3::new(x, y, conicoid_sag(x.hypot(y), R, P));
            let along_x = at(x + h, y) - at(x - h, y);
            let along_y = at(x, y + h) - at(x, y - h);
            let expected = along_y.cross(along_x).normalize();
            // Central differences err by h² = 1e-10 and by 1e-16/h.
            assert!(conicoid_normal(at(x, y), R, P).distance(expected) < 1e-9);
        }
    }
}
