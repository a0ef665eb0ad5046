//! Gaze, defaults and what follows from components alone.

use super::*;
use bevy::math::Vec3;

fn eye(laterality: Laterality, angle_alpha_deg: [f64; 2]) -> Eye {
    Eye {
        laterality,
        scleral_radius_mm: 11.5,
        angle_alpha_deg,
    }
}

#[test]
fn gaze_turns_the_globe_the_right_way() {
    let gaze = Gaze {
        azimuth_rad: 0.3,
        elevation_rad: 0.2,
        torsion_rad: 0.0,
    };
    let forward = gaze.globe_rotation(&eye(Laterality::OD, [0.0; 2])) * Vec3::NEG_Z;
    // f32 rotation of a unit vector.
    assert!((forward.as_dvec3() - gaze.direction()).length() < 1e-6);
    let torted = Gaze {
        torsion_rad: 0.1,
        ..Gaze::default()
    };
    // Positive torsion: the top of the eye goes to the patient's right (+x).
    assert!((torted.rotation() * Vec3::Y).x > 0.05);
}

#[test]
fn the_optical_axis_points_outwards_and_down() {
    for laterality in Laterality::BOTH {
        let eye = eye(laterality, [5.0, 2.0]);
        let axis = Gaze::default().globe_rotation(&eye) * Vec3::NEG_Z;
        let outwards = axis.x * laterality.temporal_sign() as f32;
        // Fick's angles of the axis are the two angles themselves.
        assert!((outwards.atan2(-axis.z).to_degrees() - 5.0).abs() < 1e-4);
        assert!((axis.y.asin().to_degrees() + 2.0).abs() < 1e-4);
    }
}

#[test]
fn irises_of_one_person_differ() {
    let patient = Patient::default();
    let [right, left] = Laterality::BOTH.map(|eye| patient.iris_seed(eye));
    assert_ne!(right, left);
    assert_ne!(patient.vessel_seed(Laterality::OD), right);
}
