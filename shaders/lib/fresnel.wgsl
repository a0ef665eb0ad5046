// Fresnel reflectance of smooth interfaces for unpolarised light, exact (Born & Wolf, Principles of
// Optics, section 1.5.2).
// Twin: src/optics/fresnel.rs.

// Reflectance, 0 to 1, of an interface from index `n1` (the ray's side) to `n2`;
// `cos_incidence` 0 (grazing) to 1 (perpendicular). Total reflection gives 1.
fn fresnel_dielectric(cos_incidence: f32, n1: f32, n2: f32) -> f32 {
    let cos_1 = clamp(cos_incidence, 0.0, 1.0);
    let eta = n1 / n2;
    let cos_2_squared = 1.0 - eta * eta * (1.0 - cos_1) * (1.0 + cos_1);
    if cos_2_squared <= 0.0 {
        return 1.0;
    }
    let cos_2 = sqrt(cos_2_squared);
    let s = (n1 * cos_1 - n2 * cos_2) / (n1 * cos_1 + n2 * cos_2);
    let t = (n2 * cos_1 - n1 * cos_2) / (n2 * cos_1 + n1 * cos_2);
    return 0.5 * (s * s + t * t);
}
