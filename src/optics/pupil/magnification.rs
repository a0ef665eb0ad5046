//! How much larger the pupil looks than the hole in the iris is.

/// Diameter of the entrance pupil over that of the stop, near the axis: the stop at `iris_depth_mm`
/// behind the corneal apex, imaged by both surfaces of the cornea.
///
/// Radii and depths in mm, all above 0, the iris behind the cornea's `thickness_mm`; indices of
/// cornea and aqueous at least 1. 1 where that is not so.
pub fn entrance_pupil_magnification(
    anterior_radius_mm: f64,
    posterior_radius_mm: f64,
    thickness_mm: f64,
    cornea_index: f64,
    aqueous_index: f64,
    iris_depth_mm: f64,
) -> f64 {
    // Light leaves the eye: it meets both surfaces from their hollow side. Each keeps
    // n'/s' = n/s − (n' − n)/R for a virtual image at s' behind it, and magnifies n s'/(n' s).
    let image = |distance_mm: f64, from: f64, to: f64, radius_mm: f64| {
        let reduced = from / distance_mm - (from - to) / radius_mm;
        let image_mm = to / reduced;
        (image_mm, from * image_mm / (to * distance_mm))
    };
    let (behind_mm, inner) = image(
        iris_depth_mm - thickness_mm,
        aqueous_index,
        cornea_index,
        posterior_radius_mm,
    );
    let (_, outer) = image(
        behind_mm + thickness_mm,
        cornea_index,
        1.0,
        anterior_radius_mm,
    );
    let magnification = inner * outer;
    if magnification.is_finite() && magnification > 0.0 {
        magnification
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::pupil::{AnteriorSegment, Viewer, entrance_pupil};
    use glam::DVec2;

    /// Against real rays through a small stop, seen from far in front: the two differ by aberration,
    /// which falls with the square of the stop.
    #[test]
    fn it_is_what_rays_through_a_small_stop_say() {
        for (anterior, posterior, thickness_mm, depth_mm) in [
            (7.8, 6.4, 0.55, 3.6),
            (6.2, 5.2, 0.4, 2.6),
            (9.5, 8.5, 0.8, 4.4),
        ] {
            let magnification = entrance_pupil_magnification(
                anterior,
                posterior,
                thickness_mm,
                1.376,
                1.336,
                depth_mm,
            );
            let eye = AnteriorSegment {
                anterior: DVec2::new(anterior, 1.0),
                posterior: Some(DVec2::new(posterior, 1.0)),
                thickness_mm,
                cornea_index: 1.376,
                aqueous_index: 1.336,
                iris_depth_mm: depth_mm,
                pupil_diameters_mm: DVec2::splat(0.2),
                ..AnteriorSegment::default()
            };
            let ahead = Viewer::Direction {
                azimuth: 0.0,
                elevation: 0.0,
            };
            let seen_mm = entrance_pupil(&eye, ahead).expect("a pupil").width_mm();
            let traced = seen_mm / 0.2;
            assert!(
                (magnification / traced - 1.0).abs() < 1e-3,
                "{magnification} {traced}"
            );
        }
        // Published for people: 1.12 to 1.14.
        let usual = entrance_pupil_magnification(7.8, 6.4, 0.55, 1.376, 1.336, 3.6);
        assert!((1.12..1.15).contains(&usual), "{usual}");
        assert_eq!(
            entrance_pupil_magnification(f64::NAN, 6.4, 0.55, 1.376, 1.336, 3.6),
            1.0
        );
    }
}
