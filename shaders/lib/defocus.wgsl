// Defocus in dioptres. Demers' circle of confusion |A F (P − D) / (D (P − F))| on an image at
// distance I equals A I |1/D − 1/P|: as an angle, without a pole, and with ametropia as one more
// term. Twin: src/optics/defocus.rs.

// Angular diameter (rad) of the blur disc of a point at vergence 1/D = `distance_vergence_d`
// (dioptres; 0 is infinity), seen by an eye accommodated to 1/P = `focus_vergence_d` whose
// spectacle refraction is `refraction_d` (negative: myopia), through a pupil of `pupil_m` metres.
fn defocus_blur_angle(pupil_m: f32, distance_vergence_d: f32, focus_vergence_d: f32, refraction_d: f32) -> f32 {
    return pupil_m * abs(distance_vergence_d - focus_vergence_d + refraction_d);
}
