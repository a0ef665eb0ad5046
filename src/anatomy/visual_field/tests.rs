//! Tests of the visual field against the reference tables and the clinical classes.

use super::*;
use crate::conditions::GlaucomaStage;
use crate::conditions::glaucoma::glaucoma_field;

fn at(field: &VisualField, x_deg: f64, y_deg: f64) -> f64 {
    let eccentricity = x_deg.hypot(y_deg).to_radians();
    let meridian = y_deg.atan2(x_deg);
    let (sin, cos) = eccentricity.sin_cos();
    let gaze = GazeAngles::of(glam::DVec3::new(
        sin * meridian.cos(),
        sin * meridian.sin(),
        -cos,
    ));
    field.sensitivity_db(gaze.azimuth_rad, gaze.elevation_rad)
}

#[test]
fn the_table_is_reproduced_and_mirrored() {
    let right = VisualField::normal(Laterality::OD, 50.0);
    let left = VisualField::normal(Laterality::OS, 50.0);
    // Published places of the 24-2, dB.
    for (x, y, db) in [
        (-9.0, 21.0, 27.5),
        (9.0, 21.0, 26.5),
        (-15.0, 15.0, 28.7),
        (21.0, 9.0, 29.6),
        (-27.0, 3.0, 27.5),
        (21.0, -3.0, 30.6),
        (3.0, -3.0, 33.7),
        (-21.0, -9.0, 29.2),
        (9.0, -21.0, 30.5),
    ] {
        assert!((at(&right, x, y) - db).abs() < 1e-9, "{x}, {y}");
        assert!((at(&left, -x, y) - db).abs() < 1e-9, "OS {x}, {y}");
    }
    // Half-way between two places: their mean.
    assert!((at(&right, 0.0, 3.0) - 0.5 * (33.2 + 33.0)).abs() < 1e-9);
}

#[test]
fn the_blind_spot_is_temporal_and_the_field_ends_where_it_should() {
    let right = VisualField::normal(Laterality::OD, 50.0);
    assert_eq!(at(&right, 15.0, -1.5), 0.0);
    assert!(at(&right, -15.0, -1.5) > 30.0);
    assert_eq!(
        at(&VisualField::normal(Laterality::OS, 50.0), -15.0, -1.5),
        0.0
    );
    // 5.5 × 7.5°: blind within 90 % of the half-axes, untouched beyond 110 %.
    assert_eq!(at(&right, 15.0 + 0.85 * 2.75, -1.5), 0.0);
    assert!(at(&right, 15.0 + 1.15 * 2.75, -1.5) > 29.0);
    assert_eq!(at(&right, 15.0, -1.5 + 0.85 * 3.75), 0.0);
    for (meridian_deg, extent) in [
        (0.0_f64, 85.0),
        (45.0, 55.0),
        (90.0, 45.0),
        (135.0, 55.0),
        (180.0, 60.0),
        (225.0, 50.0),
        (270.0, 65.0),
        (315.0, 85.0),
    ] {
        let (sin, cos) = meridian_deg.to_radians().sin_cos();
        let sensitivity = |e: f64| at(&right, e * cos, e * sin);
        assert!(sensitivity(extent - 1.0) > 0.0, "{meridian_deg}");
        assert_eq!(sensitivity(extent + 0.01), 0.0, "{meridian_deg}");
    }
}

#[test]
fn age_lowers_the_hill_at_the_published_rate() {
    let young = VisualField::normal(Laterality::OD, 30.0);
    let old = VisualField::normal(Laterality::OD, 80.0);
    assert!((at(&young, 3.0, 3.0) - at(&old, 3.0, 3.0) - 50.0 * 0.061).abs() < 1e-9);
    assert_eq!(old.mean_deviation_db(), 0.0);
    assert!(young.is_whole());
    let ageless = VisualField::normal(Laterality::OD, f64::NAN);
    assert!(ageless.sensitivity_db(0.0, 0.0).is_finite());
}

#[test]
fn the_sensitivity_is_continuous_at_the_edge_of_the_table() {
    let right = VisualField::normal(Laterality::OD, 50.0);
    for i in 0..360 {
        let (sin, cos) = f64::from(i).to_radians().sin_cos();
        let edge = (27.0 / cos.abs()).min(21.0 / sin.abs());
        let step = at(&right, cos * (edge - 1e-6), sin * (edge - 1e-6))
            - at(&right, cos * (edge + 1e-6), sin * (edge + 1e-6));
        // The steepest slope of the hill is below 5 dB a degree, so 2e-6° moves it by 1e-5 dB.
        assert!(step.abs() < 1e-4, "{i}: {step}");
    }
}

#[test]
fn the_mean_deviations_fall_into_their_hodapp_classes() {
    let deviation = |stage, eye| glaucoma_field(stage, eye, 50.0).mean_deviation_db();
    for eye in [Laterality::OD, Laterality::OS] {
        let early = deviation(GlaucomaStage::Early, eye);
        let moderate = deviation(GlaucomaStage::Moderate, eye);
        let severe = deviation(GlaucomaStage::Severe, eye);
        println!("{early:.2} {moderate:.2} {severe:.2}");
        assert!((-6.0..-2.0).contains(&early), "{early}");
        assert!((-12.0..-6.0).contains(&moderate), "{moderate}");
        assert!((-25.0..-12.0).contains(&severe), "{severe}");
        // The class stays with age, since the deviation is against the normal of the same age.
        for age_years in [20.0, 90.0] {
            let aged = glaucoma_field(GlaucomaStage::Moderate, eye, age_years);
            assert!((-12.0..-6.0).contains(&aged.mean_deviation_db()));
        }
    }
}

#[test]
fn the_loss_is_an_arcuate_with_a_nasal_step() {
    let field = glaucoma_field(GlaucomaStage::Moderate, Laterality::OD, 50.0);
    let loss =
        |x: f64, y: f64| at(&VisualField::normal(Laterality::OD, 50.0), x, y) - at(&field, x, y);
    // Above the raphe lost, just below it kept: the step that respects the horizontal meridian.
    assert!(
        loss(-20.0, 1.0) > loss(-20.0, -1.0) + 5.0,
        "{} {}",
        loss(-20.0, 1.0),
        loss(-20.0, -1.0)
    );
    // The arc runs 10 to 20° above the fovea; fixation and the temporal wedge are spared.
    assert!(loss(-3.0, 15.0) > 15.0, "{}", loss(-3.0, 15.0));
    assert!(loss(0.0, 0.0) < 6.0, "{}", loss(0.0, 0.0));
    assert!(loss(27.0, 3.0) < 6.0, "{}", loss(27.0, 3.0));
}

#[test]
fn what_is_lost_is_not_seen() {
    let healthy = VisualField::normal(Laterality::OD, 50.0);
    let severe = glaucoma_field(GlaucomaStage::Severe, Laterality::OD, 50.0);
    let (azimuth, elevation) = ((-3.0_f64).to_radians(), 15.0_f64.to_radians());
    assert!(healthy.seen(azimuth, elevation) > 0.99);
    assert!(severe.seen(azimuth, elevation) < 0.1);
    assert!(severe.seen(0.0, 0.0) > 0.9);
    assert!(severe.loss_db(azimuth, elevation) > 20.0);
    assert_eq!(healthy.seen(2.0, 0.0), 0.0);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(healthy.seen(value, 0.0), 0.0);
        assert_eq!(severe.sensitivity_db(0.0, value), 0.0);
    }
    assert_eq!(healthy.seen(std::f64::consts::PI, 0.0), 0.0);
}

#[test]
fn blur_grows_with_eccentricity_and_with_glaucoma() {
    // 1′ (1 + 10/2.5) − 1′ = 4′.
    let ten_degrees = eccentricity_blur_rad(10.0_f64.to_radians(), 1.0);
    assert!((ten_degrees.to_degrees() * 60.0 - 4.0).abs() < 1e-12);
    assert_eq!(eccentricity_blur_rad(0.0, 5.0), 0.0);
    assert!(
        (eccentricity_blur_rad(0.3, 3.0) / eccentricity_blur_rad(0.3, 1.0) - 3.0).abs() < 1e-12
    );
    let factors: Vec<f64> = [
        GlaucomaStage::Early,
        GlaucomaStage::Moderate,
        GlaucomaStage::Severe,
    ]
    .into_iter()
    .map(|stage| glaucoma_field(stage, Laterality::OD, 50.0).eccentricity_factor())
    .collect();
    assert!(1.0 < factors[0] && factors[0] < factors[1] && factors[1] < factors[2]);
}
