// Defocus in dioptres. Demers' circle of confusion |A F (P − D) / (D (P − F))| on an image at
// distance I equals A I |1/D − 1/P|: as an angle, without a pole, and with ametropia as one more
// term. Twin: src/optics/defocus.rs.

// Angular diameter (rad) of the blur disc of a point at vergence 1/D = `distance_vergence_d`
// (dioptres; 0 is infinity), seen by an eye accommodated to 1/P = `focus_vergence_d` whose
// spectacle refraction is `refraction_d` (negative: myopia), through a pupil of `pupil_m` metres.
fn defocus_blur_angle(pupil_m: f32, distance_vergence_d: f32, focus_vergence_d: f32, refraction_d: f32) -> f32 {
    return pupil_m * abs(distance_vergence_d - focus_vergence_d + refraction_d);
}

// The blur ellipse of an astigmatic eye: x and y its longer and shorter diameter (rad), z the
// direction of the longer one (rad, from 0 up to pi; 0 for a disc). `refraction` is the power vector
// (M, J0, J45) in dioptres of Thibos et al. 1997, in the frame in which the direction is wanted.
fn defocus_blur_ellipse(
    pupil_m: f32,
    distance_vergence_d: f32,
    focus_vergence_d: f32,
    refraction: vec3f,
) -> vec3f {
    let pupil = max(pupil_m, 0.0);
    let m = refraction.x + (distance_vergence_d - focus_vergence_d);
    let j = length(refraction.yz);
    // The eigenvector of M + J lies along the axis of the minus cylinder; that of M - J across it.
    let along = 0.5 * atan2(refraction.z, select(1.0, refraction.y, j > 0.0));
    let direction = select(along + 1.57079633, along, m >= 0.0);
    let turned = direction - 3.14159265 * floor(direction / 3.14159265);
    return vec3f(pupil * (abs(m) + j), pupil * abs(abs(m) - j), select(0.0, turned, j > 0.0));
}

// Second moments (xx, xy, yy; rad^2) of the same ellipse, without trigonometry.
fn defocus_blur_covariance(
    pupil_m: f32,
    distance_vergence_d: f32,
    focus_vergence_d: f32,
    refraction: vec3f,
) -> vec3f {
    let pupil = 0.25 * max(pupil_m, 0.0);
    let m = refraction.x + (distance_vergence_d - focus_vergence_d);
    let xx = pupil * (m + refraction.y);
    let yy = pupil * (m - refraction.y);
    let xy = pupil * refraction.z;
    return vec3f(xx * xx + xy * xy, xy * (xx + yy), yy * yy + xy * xy);
}
