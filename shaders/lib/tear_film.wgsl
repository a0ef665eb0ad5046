// Interference colours of the tear film's lipid layer in white light, as linear sRGB under D65: Airy's
// formula at four wavelengths and a matrix to the channels, within 3.4e-5 of the whole spectrum up to
// 200 nm. Twin: src/optics/tear_film.rs.

// 4π/λ (nm⁻¹) for 435.3, 487.3, 547.8 and 621.4 nm.
const TEAR_FILM_WAVES: vec4f = vec4f(0.028868299, 0.025787750, 0.022939705, 0.020222676);

// Linear sRGB reflectance of a film (the lipid layer, index `film_index`, thickness from 0 to 300 nm)
// between air and a substrate (the aqueous tear, `substrate_index`), both indices above 1; the
// arguments are those of fresnel_thin_film_rgb.
fn tear_film_rgb(
    cos_incidence: f32,
    film_index: f32,
    substrate_index: f32,
    film_thickness_nm: f32,
) -> vec3f {
    let cos_1 = clamp(cos_incidence, 0.0, 1.0);
    let cos_2 = sqrt((film_index - 1.0) * (film_index + 1.0) + cos_1 * cos_1) / film_index;
    let cos_3 = sqrt((substrate_index - 1.0) * (substrate_index + 1.0) + cos_1 * cos_1) / substrate_index;
    let cos_phase = cos(film_index * film_thickness_nm * cos_2 * TEAR_FILM_WAVES);

    let s_12 = (cos_1 - film_index * cos_2) / (cos_1 + film_index * cos_2);
    let s_23 = (film_index * cos_2 - substrate_index * cos_3) / (film_index * cos_2 + substrate_index * cos_3);
    let p_12 = (film_index * cos_1 - cos_2) / (film_index * cos_1 + cos_2);
    let p_23 = (substrate_index * cos_2 - film_index * cos_3) / (substrate_index * cos_2 + film_index * cos_3);
    let passed = 0.5 * (tear_film_passed(s_12, s_23, cos_phase) + tear_film_passed(p_12, p_23, cos_phase));
    return vec3f(
        1.0 - dot(vec4f(0.09642, -0.33863, 0.09177, 1.15044), passed),
        1.0 - dot(vec4f(-0.08306, 0.21419, 0.88262, -0.01375), passed),
        1.0 - dot(vec4f(0.66391, 0.52658, -0.18906, -0.00143), passed),
    );
}

// Airy's transmittance (1 − r₁₂²)(1 − r₂₃²)/|1 + r₁₂ r₂₃ e^{iφ}|² at four phases.
fn tear_film_passed(r_12: f32, r_23: f32, cos_phase: vec4f) -> vec4f {
    let product = r_12 * r_23;
    let entering = (1.0 - r_12 * r_12) * (1.0 - r_23 * r_23);
    // Both vanish together only where everything is reflected.
    return vec4f(entering) / max(vec4f(1.0 + product * product) + 2.0 * product * cos_phase, vec4f(1e-12));
}
