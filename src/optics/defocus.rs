//! Defocus in dioptres: the blur disc of a point as an angle.
//!
//! In: pupil diameter (m), vergences (D), refraction (D). Out: the disc's angular diameter (rad).
//!
//! Demers' circle of confusion on an image at distance `I` behind the lens,
//! `|A F (P − D) / (D (P − F))|` with `1/F = 1/P + 1/I` (the form of Nießner et al. 2013), is
//! identical to `A I |1/D − 1/P|`. As an angle, `A |1/D − 1/P|`, it has no pole at `P = F`, is exact
//! as `D` or `P` goes to infinity, and takes ametropia as one added term.
//!
//! Twin: `shaders/lib/defocus.wgsl`.

/// Angular diameter (rad) of the blur disc of a point at vergence `distance_vergence_d` = 1/D (D;
/// 0 is infinity), seen by an eye accommodated to `focus_vergence_d` = 1/P with the spectacle
/// refraction `refraction_d` (negative: myopia), through a pupil of `pupil_m` metres.
///
/// The factor is 3.438 arcmin per mm of pupil and dioptre.
pub fn defocus_blur_angle(
    pupil_m: f64,
    distance_vergence_d: f64,
    focus_vergence_d: f64,
    refraction_d: f64,
) -> f64 {
    pupil_m * (distance_vergence_d - focus_vergence_d + refraction_d).abs()
}

/// Vergence (D) of a distance in metres; infinity is 0. Distances below a millimetre, and what is
/// not a number, count as a millimetre: nothing stands nearer to a cornea.
pub fn vergence_of_distance(distance_m: f64) -> f64 {
    1.0 / distance_m.max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Demers' circle of confusion (m) on the image.
    fn demers(aperture: f64, object: f64, plane_in_focus: f64, image: f64) -> f64 {
        let focal = 1.0 / (1.0 / plane_in_focus + 1.0 / image);
        (aperture * focal * (plane_in_focus - object) / (object * (plane_in_focus - focal))).abs()
    }

    #[test]
    fn equals_demers_where_that_is_well_conditioned() {
        let image = 0.017;
        for pupil in [1e-3, 4e-3, 9e-3] {
            for object in [0.1, 0.3, 1.0, 6.0, 40.0] {
                for focus in [0.15, 0.35, 2.0, 10.0] {
                    let disc = image * defocus_blur_angle(pupil, 1.0 / object, 1.0 / focus, 0.0);
                    let oracle = demers(pupil, object, focus, image);
                    // Both cancel in P − D: the relative error is bounded through the largest term.
                    assert!((disc - oracle).abs() < 1e-14 * pupil * image * 10.0 / 0.017);
                }
            }
        }
    }

    #[test]
    fn one_millimetre_and_one_dioptre_is_3_438_arcmin() {
        let arcmin = defocus_blur_angle(1e-3, 1.0, 0.0, 0.0).to_degrees() * 60.0;
        assert!((arcmin - 3.438).abs() < 5e-4);
    }

    #[test]
    fn a_myope_of_three_dioptres_sees_sharp_at_a_third_of_a_metre() {
        assert_eq!(defocus_blur_angle(4e-3, 3.0, 0.0, -3.0), 0.0);
        // And far things through 3 D, whether relaxed or not more.
        assert!((defocus_blur_angle(4e-3, 0.0, 0.0, -3.0) - 0.012).abs() < 1e-17);
    }

    #[test]
    fn extremes_are_finite() {
        assert_eq!(vergence_of_distance(f64::INFINITY), 0.0);
        assert_eq!(vergence_of_distance(0.0), 1000.0);
        assert_eq!(vergence_of_distance(f64::NAN), 1000.0);
        for pupil in [1e-3, 9e-3] {
            for refraction in [-20.0, 20.0] {
                for distance in [1e-3, 1.0, f64::INFINITY] {
                    let blur =
                        defocus_blur_angle(pupil, vergence_of_distance(distance), 0.0, refraction);
                    assert!(blur.is_finite() && blur >= 0.0);
                }
            }
        }
    }
}
