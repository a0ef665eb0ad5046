// Glare: light scattered by the eye's media, as a spread function of the angle from the source
// (CIE 135/1-1999, the complete equation of Vos & van den Berg). Twin: src/optics/glare.rs.

// Widths of the terms, as 1/b² with b in degrees: 0.0046, 0.045 and 0.1.
const GLARE_CORE: f32 = 47258.979206;
const GLARE_HALO: f32 = 493.827160;
const GLARE_WIDE: f32 = 100.0;

// Equivalent luminance (cd/m²) per lux at the eye, sr⁻¹, at `theta_rad` from the source, for the age
// (1 to 110 years) and the pigmentation (0 very dark, 0.5 brown, 1 green, 1.2 light blue) of the eye.
fn glare_spread(theta_rad: f32, age_years: f32, pigment: f32) -> f32 {
    let age = clamp(age_years, 1.0, 110.0) / 70.0;
    let a = age * age * age * age;
    let p = clamp(pigment, 0.0, 1.2);
    let theta = degrees(clamp(abs(theta_rad), 0.0, 3.14159265));
    let squared = theta * theta;
    let core = 1.0 + squared * GLARE_CORE;
    let halo = 1.0 + squared * GLARE_HALO;
    let wide = 1.0 / (1.0 + squared * GLARE_WIDE);
    let root = sqrt(wide);
    let narrow = 9.2e6 / (core * sqrt(core)) + 1.5e5 / (halo * sqrt(halo));
    let scattered = 400.0 * wide + 3e-8 * squared + p * root * (1300.0 * wide + 0.8);
    return (1.0 - 0.08 * a) * narrow + (1.0 + 1.6 * a) * scattered + 2.5e-3 * p;
}
