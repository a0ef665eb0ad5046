use super::*;
use proptest::prelude::*;

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

fn prescription(sphere: f64, cylinder: f64, axis_deg: f64) -> PowerVector {
    PowerVector::from_sphere_cylinder(sphere, cylinder, axis_deg.to_radians())
}

#[test]
fn power_vectors_have_their_textbook_values() {
    // By hand from the equations of Thibos et al. 1997: −1.00 −2.00 × 180 is M −2, J₀ +1 (with
    // the rule), × 90 J₀ −1, × 45 J₄₅ +1; +3.00 −2.00 × 30 is M 2, J₀ 0.5, J₄₅ 0.866.
    for (s, c, axis, expected) in [
        (-1.0, -2.0, 180.0, [-2.0, 1.0, 0.0]),
        (-1.0, -2.0, 90.0, [-2.0, -1.0, 0.0]),
        (-1.0, -2.0, 45.0, [-2.0, 0.0, 1.0]),
        (3.0, -2.0, 30.0, [2.0, 0.5, 0.75_f64.sqrt()]),
    ] {
        let v = prescription(s, c, axis);
        let got = [v.m_d, v.j0_d, v.j45_d];
        for (got, expected) in got.into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-15, "{s} {c} {axis}");
        }
    }
    // Crossed cylinders of equal power are a sphere.
    let both = prescription(0.0, -1.5, 20.0) + prescription(0.0, -1.5, 110.0);
    assert!(both.astigmatism_d() < 1e-15 && (both.m_d + 1.5).abs() < 1e-15);
}

#[test]
fn the_matrix_is_longs() {
    // Long 1976: f₁₁ = S + C sin² α, f₁₂ = −C sin α cos α, f₂₂ = S + C cos² α.
    for axis in [0.0, 17.0, 90.0, 133.0_f64] {
        let (s, c, a) = (-2.5, -1.75, axis.to_radians());
        let f = prescription(s, c, axis).dioptric_matrix();
        assert!((f.x_axis.x - (s + c * a.sin().powi(2))).abs() < 1e-14);
        assert!((f.x_axis.y + c * a.sin() * a.cos()).abs() < 1e-14);
        assert!((f.y_axis.y - (s + c * a.cos().powi(2))).abs() < 1e-14);
    }
}

/// The blur by brute force: the widest and narrowest extent of F x over the pupil's edge.
fn extents(error: PowerVector, pupil_m: f64) -> (f64, f64, f64) {
    let edge: Vec<DVec2> = (0..3600)
        .map(|i| error.dioptric_matrix() * DVec2::from_angle(f64::from(i) * PI / 1800.0) * pupil_m)
        .collect();
    let mut widest = (0.0, 0.0);
    let mut narrowest = f64::INFINITY;
    for i in 0..1800 {
        let direction = f64::from(i) * PI / 1800.0;
        let unit = DVec2::from_angle(direction);
        let extent = edge.iter().map(|q| q.dot(unit)).fold(0.0, f64::max);
        if extent > widest.0 {
            widest = (extent, direction);
        }
        narrowest = narrowest.min(extent);
    }
    (widest.0, narrowest, widest.1)
}

#[test]
fn the_ellipse_is_what_rays_through_the_pupil_make() {
    for (s, c, axis) in [(-2.0, -1.0, 30.0), (0.5, -3.0, 170.0), (4.0, 2.0, 80.0)] {
        let refraction = prescription(s, c, axis);
        let blur = defocus_blur_ellipse(5e-3, 1.0, 0.4, refraction);
        let (major, minor, direction) = extents(defocus_error(1.0, 0.4, refraction), 5e-3);
        // A tenth of a degree of direction and of place on the edge: 1.5e-6 of the length,
        // more for the minor axis, which the major's length multiplies.
        assert!((blur.major_rad / major - 1.0).abs() < 3e-6);
        assert!((blur.minor_rad - minor).abs() < 3e-6 * major.max(minor) * major / minor);
        let turn = (blur.orientation_rad - direction + 0.5 * PI).rem_euclid(PI) - 0.5 * PI;
        assert!(turn.abs() < 2e-3, "{s} {c} {axis}: {turn}");
    }
}

#[test]
fn line_foci_lie_where_optics_says() {
    // A simple myopic astigmat, plano −2.00 × 180: the vertical meridian is 2 D too strong, so
    // a far point blurs to a vertical line; half a metre away it is a horizontal one.
    let refraction = prescription(0.0, -2.0, 180.0);
    let far = defocus_blur_ellipse(4e-3, 0.0, 0.0, refraction);
    assert!((far.major_rad - 8e-3).abs() < 1e-17 && far.minor_rad == 0.0);
    assert!((far.orientation_rad - 0.5 * PI).abs() < 1e-15);
    let near = defocus_blur_ellipse(4e-3, 2.0, 0.0, refraction);
    assert!((near.major_rad - 8e-3).abs() < 1e-17 && near.minor_rad == 0.0);
    assert!(near.orientation_rad.abs() < 1e-15);
    // Between them, at the circle of least confusion, a disc of half the size.
    let between = defocus_blur_ellipse(4e-3, 1.0, 0.0, refraction);
    assert!((between.major_rad - 4e-3).abs() < 1e-17);
    assert!((between.minor_rad - 4e-3).abs() < 1e-17);
}

#[test]
fn the_view_mirrors_the_axis() {
    let v = prescription(0.0, -1.0, 30.0).in_view();
    let expected = prescription(0.0, -1.0, 150.0);
    assert!((v.j0_d - expected.j0_d).abs() < 1e-15);
    assert!((v.j45_d - expected.j45_d).abs() < 1e-15);
    assert_eq!(v.in_view(), prescription(0.0, -1.0, 30.0));
}

fn refractions() -> impl Strategy<Value = PowerVector> {
    (-20.0..20.0_f64, -8.0..8.0_f64, 0.0..180.0_f64)
        .prop_map(|(s, c, axis)| prescription(s, c, axis))
}

proptest! {
    #[test]
    fn sphere_and_cylinder_come_back(v in refractions()) {
        let (s, c, axis) = v.to_sphere_cylinder();
        prop_assert!(c <= 0.0 && (0.0..PI).contains(&axis));
        let back = PowerVector::from_sphere_cylinder(s, c, axis);
        // A few roundings of 30 D.
        prop_assert!((back.m_d - v.m_d).abs() < 2e-14);
        prop_assert!((back.j0_d - v.j0_d).abs() < 2e-14);
        prop_assert!((back.j45_d - v.j45_d).abs() < 2e-14);
    }

    #[test]
    fn a_spherical_eye_has_the_disc_of_before(
        pupil in 1e-3..9e-3_f64, distance in 0.0..1000.0_f64, focus in 0.0..20.0_f64,
        sphere in -20.0..20.0_f64,
    ) {
        let disc = defocus_blur_angle(pupil, distance, focus, sphere);
        let refraction = PowerVector::from_sphere_cylinder(sphere, 0.0, 1.0);
        let blur = defocus_blur_ellipse(pupil, distance, focus, refraction);
        // The same sum in another order: two roundings of 1000 D.
        prop_assert!((blur.major_rad - disc).abs() < 4e-13 * pupil);
        prop_assert_eq!(blur.major_rad, blur.minor_rad);
        prop_assert_eq!(blur.orientation_rad, 0.0);
    }

    #[test]
    fn blur_grows_with_pupil_and_defocus(
        v in refractions(), pupil in 1e-3..8.9e-3_f64, more in 0.0..5.0_f64,
    ) {
        let blur = |pupil, v: PowerVector| defocus_blur_ellipse(pupil, 0.0, 0.0, v);
        let here = blur(pupil, v);
        prop_assert!(blur(pupil + 1e-4, v).major_rad >= here.major_rad);
        prop_assert!(blur(pupil + 1e-4, v).minor_rad >= here.minor_rad);
        let further = v.plus_sphere(more.copysign(v.m_d));
        prop_assert!(blur(pupil, further).major_rad >= here.major_rad);
    }

    #[test]
    fn moments_are_those_of_the_deformed_disc(v in refractions(), pupil in 1e-3..9e-3_f64) {
        // The covariance of F x over a uniform disc of radius a is F Fᵀ a²/4.
        let covariance = defocus_blur_ellipse(pupil, 0.0, 0.0, v).covariance();
        let f = v.dioptric_matrix();
        let expected = f * f.transpose() * (pupil * pupil / 16.0);
        let scale = expected.x_axis.x + expected.y_axis.y;
        let off = covariance - expected;
        for entry in off.to_cols_array() {
            prop_assert!(entry.abs() <= 1e-14 * scale);
        }
        let direct = defocus_blur_covariance(pupil, 0.0, 0.0, v);
        for (got, expected) in [
            (direct.x, expected.x_axis.x),
            (direct.y, expected.x_axis.y),
            (direct.z, expected.y_axis.y),
        ] {
            prop_assert!((got - expected).abs() <= 1e-14 * scale);
        }
    }

    #[test]
    fn extreme_eyes_are_finite(
        v in refractions(), pupil in -1.0..1.0_f64, distance in prop::num::f64::ANY,
    ) {
        let vergence = vergence_of_distance(distance);
        let blur = defocus_blur_ellipse(pupil, vergence, 0.0, v);
        for part in [blur.major_rad, blur.minor_rad, blur.orientation_rad] {
            prop_assert!(part.is_finite() && part >= 0.0);
        }
        prop_assert!(blur.minor_rad <= blur.major_rad && blur.orientation_rad < PI);
    }

    #[test]
    fn nonsense_is_finite(
        a in prop::num::f64::ANY, b in prop::num::f64::ANY, c in prop::num::f64::ANY,
        d in prop::num::f64::ANY, e in prop::num::f64::ANY,
    ) {
        let v = PowerVector { m_d: c, j0_d: d, j45_d: e };
        let blur = defocus_blur_ellipse(a, b, c, v);
        for part in [blur.major_rad, blur.minor_rad, blur.orientation_rad] {
            prop_assert!(part.is_finite() && part >= 0.0);
        }
        prop_assert!(defocus_blur_covariance(a, b, c, v).is_finite());
        prop_assert!(defocus_blur_angle(a, b, c, d).is_finite());
    }
}

#[test]
fn the_views_blur_has_the_covariance_of_the_ellipse() {
    for (sphere, cylinder, axis) in [(0.0, -2.0, 30.0), (-3.0, 1.5, 100.0), (1.0, -2.0, 0.0)] {
        for vergence in [0.0, 0.5, 3.0] {
            let error = defocus_error(vergence, 0.75, prescription(sphere, cylinder, axis));
            let [diameter, elongation] = astigmatic_blur(4e-3, error.m_d, error.astigmatism_d());
            let mean = diameter * diameter / 16.0;
            let turn = error.j45_d.atan2(error.j0_d);
            let found = DVec3::new(
                mean * (1.0 + elongation * turn.cos()),
                mean * elongation * turn.sin(),
                mean * (1.0 - elongation * turn.cos()),
            );
            let wanted =
                defocus_blur_covariance(4e-3, vergence, 0.75, prescription(sphere, cylinder, axis));
            assert!(
                (found - wanted).length() < 1e-12 * wanted.length(),
                "{found} {wanted}"
            );
        }
    }
    // A line focus, and nothing at all.
    let [_, line] = astigmatic_blur(4e-3, 0.5, 0.5);
    assert!((line - 1.0).abs() < 1e-15);
    assert_eq!(astigmatic_blur(4e-3, 0.0, 0.0), [0.0, 0.0]);
    assert_eq!(astigmatic_blur(f64::NAN, f64::NAN, 1.0)[0], 0.0);
}

#[test]
fn a_turned_refraction_has_its_axis_turned() {
    let turned = prescription(-1.0, -2.0, 30.0).turned(20_f64.to_radians());
    let wanted = prescription(-1.0, -2.0, 50.0);
    assert!(
        (turned.j0_d - wanted.j0_d).abs() < 1e-14 && (turned.j45_d - wanted.j45_d).abs() < 1e-14
    );
    assert_eq!(turned.m_d, wanted.m_d);
}
