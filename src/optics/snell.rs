//! Snell's law in vector form (François et al. 2007, section 5.1).
//!
//! In: a unit ray direction, a unit surface normal, the ratio of indices. Out: the direction behind
//! the surface, or the reflected one when reflection is total.
//!
//! Twin: `shaders/lib/snell.wgsl`.

use glam::{DVec3, DVec4};

/// Refracts the unit ray direction `dir` at a surface with unit `normal`; the side of the normal
/// that faces the ray is taken. `eta` is the index on the ray's side divided by the index behind
/// the surface.
///
/// `xyz` is the unit direction behind the surface and `w` = 1; on total reflection `xyz` is the
/// reflected direction and `w` = 0.
pub fn snell_refract(dir: DVec3, normal: DVec3, eta: f64) -> DVec4 {
    let projection = dir.dot(normal);
    let facing = if projection > 0.0 { -normal } else { normal };
    let cos_in = projection.abs();
    let cos_out_squared = 1.0 - eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if cos_out_squared < 0.0 {
        return (dir + 2.0 * cos_in * facing).extend(0.0);
    }
    let refracted = eta * dir + (eta * cos_in - cos_out_squared.sqrt()) * facing;
    refracted.normalize_or(dir).extend(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(incidence: f64) -> DVec3 {
        DVec3::new(incidence.sin(), 0.0, incidence.cos())
    }

    #[test]
    fn angles_obey_the_law_of_sines() {
        for degrees in 0..=90 {
            let incidence = f64::from(degrees).to_radians();
            let out = snell_refract(ray(incidence), DVec3::NEG_Z, 1.0 / 1.336);
            assert_eq!(out.w, 1.0);
            assert!((out.x - incidence.sin() / 1.336).abs() < 1e-15);
            assert!((out.truncate().length() - 1.0).abs() < 1e-15);
            assert!(out.z > 0.0 && out.y == 0.0);
        }
    }

    #[test]
    fn the_normal_may_face_either_way() {
        let dir = ray(0.7);
        let a = snell_refract(dir, DVec3::NEG_Z, 0.75);
        assert_eq!(a, snell_refract(dir, DVec3::Z, 0.75));
    }

    #[test]
    fn beyond_the_critical_angle_the_ray_is_reflected() {
        // asin(1/1.336) = 48.46°.
        let critical = (1.0_f64 / 1.336).asin();
        assert_eq!(
            snell_refract(ray(critical - 1e-9), DVec3::NEG_Z, 1.336).w,
            1.0
        );
        let total = snell_refract(ray(critical + 1e-9), DVec3::NEG_Z, 1.336);
        assert_eq!(total.w, 0.0);
        let expected = DVec3::new(critical.sin(), 0.0, -critical.cos());
        assert!(total.truncate().distance(expected) < 1e-8);
    }

    #[test]
    fn light_paths_are_reversible() {
        let normal = DVec3::new(0.3, -0.2, -0.9).normalize();
        let dir = ray(1.1);
        let there = snell_refract(dir, normal, 1.0 / 1.376).truncate();
        let back = snell_refract(-there, normal, 1.376);
        assert!(back.truncate().distance(-dir) < 1e-14 && back.w == 1.0);
    }
}
