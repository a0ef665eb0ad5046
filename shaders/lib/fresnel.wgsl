// Fresnel reflectance of smooth interfaces for unpolarised light, exact, and of the tear film's
// lipid layer by Airy's sum (Born & Wolf, Principles of Optics, sections 1.5.2 and 7.6.1).
// Twin: src/optics/fresnel.rs.

const FRESNEL_TAU: f32 = 6.283185307179586;

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

// Reflectance at one wavelength of a film (the lipid layer, index `film_index`) between air and
// a substrate (the aqueous tear, `substrate_index`). Thickness and wavelength in nanometres.
fn fresnel_thin_film(
    cos_incidence: f32,
    film_index: f32,
    substrate_index: f32,
    film_thickness_nm: f32,
    wavelength_nm: f32,
) -> f32 {
    let cos_1 = clamp(cos_incidence, 0.0, 1.0);
    let sin_squared = (1.0 - cos_1) * (1.0 + cos_1);
    let cos_2 = sqrt(max(1.0 - sin_squared / (film_index * film_index), 0.0));
    let cos_3 = sqrt(max(1.0 - sin_squared / (substrate_index * substrate_index), 0.0));
    let phase = 2.0 * FRESNEL_TAU * film_index * film_thickness_nm * cos_2 / wavelength_nm;
    let cos_phase = cos(phase);

    let s_12 = (cos_1 - film_index * cos_2) / (cos_1 + film_index * cos_2);
    let s_23 = (film_index * cos_2 - substrate_index * cos_3) / (film_index * cos_2 + substrate_index * cos_3);
    let p_12 = (film_index * cos_1 - cos_2) / (film_index * cos_1 + cos_2);
    let p_23 = (substrate_index * cos_2 - film_index * cos_3) / (substrate_index * cos_2 + film_index * cos_3);
    return 0.5 * (fresnel_airy(s_12, s_23, cos_phase) + fresnel_airy(p_12, p_23, cos_phase));
}

// |(r₁₂ + r₂₃ e^{iφ}) / (1 + r₁₂ r₂₃ e^{iφ})|², Airy's sum over the reflections within a film.
fn fresnel_airy(r_12: f32, r_23: f32, cos_phase: f32) -> f32 {
    let product = r_12 * r_23;
    let interference = 2.0 * product * cos_phase;
    // Grazing light has r₁₂ = −1, where numerator and denominator are equal term by term; they
    // vanish together only if r₂₃ = ±1 too.
    let denominator = 1.0 + product * product + interference;
    if denominator <= 0.0 {
        return 1.0;
    }
    return clamp((r_12 * r_12 + r_23 * r_23 + interference) / denominator, 0.0, 1.0);
}

// The film's reflectance for red, green and blue: at the dominant wavelengths of the sRGB
// primaries, 611.4, 549.1 and 464.2 nm.
fn fresnel_thin_film_rgb(
    cos_incidence: f32,
    film_index: f32,
    substrate_index: f32,
    film_thickness_nm: f32,
) -> vec3f {
    return vec3f(
        fresnel_thin_film(cos_incidence, film_index, substrate_index, film_thickness_nm, 611.4),
        fresnel_thin_film(cos_incidence, film_index, substrate_index, film_thickness_nm, 549.1),
        fresnel_thin_film(cos_incidence, film_index, substrate_index, film_thickness_nm, 464.2),
    );
}
