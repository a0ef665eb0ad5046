// Blur at the retina in radians of visual angle (diameters), and directions in the view.
// Twin: src/percept/present/gather.rs; the defocus itself is lib/defocus.wgsl.

// Resolution limit of the healthy retina at an eccentricity: linear, doubling at `e2_rad`.
fn neural_blur(eccentricity_rad: f32, floor_rad: f32, e2_rad: f32) -> f32 {
    return floor_rad * (1.0 + eccentricity_rad / e2_rad);
}

// Independent blurs add their variances.
fn combined_blur(a_rad: f32, b_rad: f32) -> f32 {
    return sqrt(a_rad * a_rad + b_rad * b_rad);
}

// Unit direction, in the view's frame (+x right, +y up, looking along -z), of a place in the image
// in pixels from its top left corner.
fn view_ray(place_px: vec2<f32>, size_px: vec2<f32>, tan_half_fov: vec2<f32>) -> vec3<f32> {
    let ndc = 2.0 * place_px / size_px - 1.0;
    return normalize(vec3<f32>(ndc.x * tan_half_fov.x, -ndc.y * tan_half_fov.y, -1.0));
}

// Angle between unit vectors, exact for small angles where acos of the dot product is not.
fn angle_between(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return 2.0 * asin(clamp(0.5 * length(a - b), 0.0, 1.0));
}

// Place of a direction in the visual field centred on the fixation, as perimetry draws it: the
// length is the eccentricity (rad), +x right and +y up.
fn perimetric_angles(direction: vec3<f32>, fixation: vec3<f32>) -> vec2<f32> {
    let right = normalize(vec3<f32>(-fixation.z, 0.0, fixation.x) + vec3<f32>(1e-12, 0.0, 0.0));
    let up = cross(right, fixation);
    let across = vec2<f32>(dot(direction, right), dot(direction, up));
    let length_across = max(length(across), 1e-12);
    return across * (angle_between(direction, fixation) / length_across);
}
