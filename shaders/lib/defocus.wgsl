// Defocus in dioptres. Demers' circle of confusion |A F (P − D) / (D (P − F))| on an image at
// distance I equals A I |1/D − 1/P|: as an angle, without a pole, and with ametropia as one more
// term. Twin: src/optics/defocus.rs.

// Angular diameter (rad) of the blur disc of a point at vergence 1/D = `distance_vergence_d`
// (dioptres; 0 is infinity), seen by an eye accommodated to 1/P = `focus_vergence_d` whose
// spectacle refraction is `refraction_d` (negative: myopia), through a pupil of `pupil_m` metres.
fn defocus_blur_angle(pupil_m: f32, distance_vergence_d: f32, focus_vergence_d: f32, refraction_d: f32) -> f32 {
    return pupil_m * abs(distance_vergence_d - focus_vergence_d + refraction_d);
}

// Blur of an eye whose error of refraction is `sphere_d` (spherical equivalent) with a cross cylinder of
// `astigmatism_d` (half of the cylinder, not negative): x the diameter (rad) of the disc of as much
// variance, y by how much of that variance the one along the axis of the minus cylinder exceeds it (-1 to
// 1; across the axis it falls short by as much). 0 is a disc, 1 and -1 are lines.
fn astigmatic_blur(pupil_m: f32, sphere_d: f32, astigmatism_d: f32) -> vec2<f32> {
    let strength2 = sphere_d * sphere_d + astigmatism_d * astigmatism_d;
    let elongation = 2.0 * sphere_d * astigmatism_d / max(strength2, 1e-12);
    return vec2<f32>(max(pupil_m, 0.0) * sqrt(strength2), elongation);
}
