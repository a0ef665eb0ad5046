//! Fresnel reflectance of smooth interfaces for unpolarised light, exact, of the tear film's lipid
//! layer by Airy's sum over the reflections within a film, and of any number of films on one another
//! (Born & Wolf, *Principles of Optics*, sections 1.5.2, 7.6.1 and 1.6).
//!
//! In: the cosine of the angle of incidence, indices, film thickness and wavelength in nm. Out: the
//! fraction of light reflected, 0 to 1.
//!
//! Twin of the interface: `shaders/lib/fresnel.wgsl`; of the film in white light: [`super::tear_film`].

mod stack;

pub use stack::{Film, LightSplit, fresnel_stack, fresnel_stack_over_thick};

use core::f64::consts::TAU;
use glam::DVec3;

/// Index of the tear film's lipid layer (from memory in REFERENCE: 1.48).
pub const LIPID_INDEX: f64 = 1.48;
/// Index of the aqueous tear under the lipid layer.
pub const TEAR_INDEX: f64 = 1.337;

/// Reflectance of an interface from index `n1` (the ray's side) to `n2` for unpolarised light.
/// `cos_incidence` runs from 0 (grazing) to 1 (perpendicular) and is clamped to it; what is not a
/// number counts as grazing. Indices are limited to 0.001 to 1000, what is not a number counts as 1.
/// Total reflection gives 1.
pub fn fresnel_dielectric(cos_incidence: f64, n1: f64, n2: f64) -> f64 {
    let cos_1 = fresnel_cosine(cos_incidence);
    let (n1, n2) = (clamp_or(n1, 1e-3, 1e3, 1.0), clamp_or(n2, 1e-3, 1e3, 1.0));
    let eta = n1 / n2;
    let cos_2_squared = 1.0 - eta * eta * (1.0 - cos_1) * (1.0 + cos_1);
    if cos_2_squared <= 0.0 {
        return 1.0;
    }
    let cos_2 = cos_2_squared.sqrt();
    let s = (n1 * cos_1 - n2 * cos_2) / (n1 * cos_1 + n2 * cos_2);
    let t = (n2 * cos_1 - n1 * cos_2) / (n2 * cos_1 + n1 * cos_2);
    0.5 * (s * s + t * t)
}

/// The surface between air and a body of this index (1 to 4) that is filled with diffuse light: what it lets in of
/// diffuse light that falls on it, and what it sends back down of diffuse light that comes up. The mean of Fresnel's
/// reflectance over the flux; n² of the light that comes up keeps within the critical angle.
pub fn diffuse_surface(index: f64) -> [f64; 2] {
    let index = clamp_or(index, 1.0, 4.0, 1.0);
    // Midpoints of the flux, ∫ T(µ) 2µ dµ = ∫ T(√x) dx.
    const STEPS: u32 = 4096;
    let passed = (0..STEPS).map(|i| {
        let cosine = ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt();
        1.0 - fresnel_dielectric(cosine, 1.0, index)
    });
    let entering = passed.sum::<f64>() / f64::from(STEPS);
    [entering, 1.0 - entering / (index * index)]
}

/// Reflectance at one wavelength of a film (the lipid layer, [`LIPID_INDEX`], 20 to 120 nm thick)
/// between air and a substrate (the aqueous tear, [`TEAR_INDEX`]). Indices from 1 to 4, thickness
/// from 0 to 1 m and wavelength from 1 nm to 1 m, both in nm; each is limited to that, and what is
/// not a number counts as index 1, thickness 0, wavelength 555 nm and grazing incidence.
pub fn fresnel_thin_film(
    cos_incidence: f64,
    film_index: f64,
    substrate_index: f64,
    film_thickness_nm: f64,
    wavelength_nm: f64,
) -> f64 {
    let cos_1 = fresnel_cosine(cos_incidence);
    let film_index = clamp_or(film_index, 1.0, 4.0, 1.0);
    let substrate_index = clamp_or(substrate_index, 1.0, 4.0, 1.0);
    let film_thickness_nm = clamp_or(film_thickness_nm, 0.0, 1e9, 0.0);
    let wavelength_nm = clamp_or(wavelength_nm, 1.0, 1e9, 555.0);
    if cos_1 < GRAZING_COSINE {
        return 1.0;
    }
    let cos_2 = cosine_within(film_index, cos_1);
    let cos_3 = cosine_within(substrate_index, cos_1);
    let phase = 2.0 * TAU * film_index * film_thickness_nm * cos_2 / wavelength_nm;
    let cos_phase = phase.cos();

    let s_12 = (cos_1 - film_index * cos_2) / (cos_1 + film_index * cos_2);
    let s_23 = (film_index * cos_2 - substrate_index * cos_3)
        / (film_index * cos_2 + substrate_index * cos_3);
    let p_12 = (film_index * cos_1 - cos_2) / (film_index * cos_1 + cos_2);
    let p_23 = (substrate_index * cos_2 - film_index * cos_3)
        / (substrate_index * cos_2 + film_index * cos_3);
    0.5 * (fresnel_airy(s_12, s_23, cos_phase) + fresnel_airy(p_12, p_23, cos_phase))
}

/// `|(r₁₂ + r₂₃ e^{iφ}) / (1 + r₁₂ r₂₃ e^{iφ})|²`.
fn fresnel_airy(r_12: f64, r_23: f64, cos_phase: f64) -> f64 {
    let product = r_12 * r_23;
    let interference = 2.0 * product * cos_phase;
    // Grazing light has r₁₂ = −1, where numerator and denominator are equal term by term; they
    // vanish together only if r₂₃ = ±1 too.
    let denominator = 1.0 + product * product + interference;
    if denominator <= 0.0 {
        return 1.0;
    }
    ((r_12 * r_12 + r_23 * r_23 + interference) / denominator).clamp(0.0, 1.0)
}

/// The film's reflectance for red, green and blue: at the dominant wavelengths of the sRGB
/// primaries, 611.4, 549.1 and 464.2 nm.
pub fn fresnel_thin_film_rgb(
    cos_incidence: f64,
    film_index: f64,
    substrate_index: f64,
    film_thickness_nm: f64,
) -> DVec3 {
    let at = |wavelength_nm| {
        fresnel_thin_film(
            cos_incidence,
            film_index,
            substrate_index,
            film_thickness_nm,
            wavelength_nm,
        )
    };
    DVec3::new(at(611.4), at(549.1), at(464.2))
}

/// Light flatter than this counts as grazing: it is reflected but for 1e-11.
pub(super) const GRAZING_COSINE: f64 = 1e-12;

/// Cosine of the direction within a medium of index 1 or more, of light that meets it from air:
/// `√(1 − sin² θ/n²)` without the difference that fails at grazing incidence.
pub(super) fn cosine_within(index: f64, cos_incidence: f64) -> f64 {
    ((index - 1.0) * (index + 1.0) + cos_incidence * cos_incidence).sqrt() / index
}

fn fresnel_cosine(cos_incidence: f64) -> f64 {
    clamp_or(cos_incidence, 0.0, 1.0, 0.0)
}

pub(super) fn clamp_or(value: f64, low: f64, high: f64, if_nan: f64) -> f64 {
    if value.is_nan() {
        if_nan
    } else {
        value.clamp(low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_surface_returns_most_of_the_diffuse_light_from_below() {
        // Walsh's formula gives 0.0918 for diffuse light on glass of 1.5 (Duntley 1942); Egan and Hilgeman's fit
        // of what is sent back, −1.4399/n² + 0.7099/n + 0.6681 + 0.0636 n, is right within 0.004.
        assert!((diffuse_surface(1.5)[0] - (1.0 - 0.0918)).abs() < 1e-4);
        for n in [1.2, 1.37, 1.5] {
            let fit = -1.4399 / (n * n) + 0.7099 / n + 0.6681 + 0.0636 * n;
            assert!((diffuse_surface(n)[1] - fit).abs() < 0.004, "{n}");
        }
        assert_eq!(diffuse_surface(1.0), [1.0, 0.0]);
        assert_eq!(diffuse_surface(f64::NAN), [1.0, 0.0]);
    }

    #[test]
    fn perpendicular_reflectance_of_the_cornea() {
        // ((1.376 − 1)/(1.376 + 1))² = 2.504 %.
        let expected = (0.376_f64 / 2.376).powi(2);
        assert!((fresnel_dielectric(1.0, 1.0, 1.376) - expected).abs() < 1e-16);
        assert!((fresnel_dielectric(1.0, 1.376, 1.0) - expected).abs() < 1e-16);
    }

    #[test]
    fn grazing_and_total_reflection_are_complete() {
        assert_eq!(fresnel_dielectric(0.0, 1.0, 1.336), 1.0);
        assert_eq!(fresnel_dielectric(0.5, 1.336, 1.0), 1.0);
        assert_eq!(fresnel_dielectric(-1.0, 1.0, 1.336), 1.0);
    }

    #[test]
    fn brewsters_angle_reflects_only_the_s_wave() {
        // tan θ_B = n; there R_p = 0 and R_s = ((n² − 1)/(n² + 1))².
        let n = 1.336_f64;
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        assert!((fresnel_dielectric(n.atan().cos(), 1.0, n) - expected).abs() < 1e-15);
    }

    #[test]
    fn film_reproduces_the_tabulated_reflectances() {
        // REFERENCE, "Tear film": % at 450, 550, 650 nm, lipid 1.48 over 1.337, two decimals.
        let table = [
            (0.0, [2.08, 2.08, 2.08]),
            (42.0, [4.31, 3.72, 3.32]),
            (80.0, [5.83, 5.68, 5.23]),
            (120.0, [3.54, 5.14, 5.78]),
            (157.0, [2.12, 2.93, 4.41]),
        ];
        for (thickness, percents) in table {
            for (wavelength, percent) in [450.0, 550.0, 650.0].into_iter().zip(percents) {
                let got =
                    100.0 * fresnel_thin_film(1.0, LIPID_INDEX, TEAR_INDEX, thickness, wavelength);
                assert!(
                    (got - percent).abs() < 0.00501,
                    "{thickness} nm at {wavelength}: {got}"
                );
            }
        }
    }

    #[test]
    fn film_without_thickness_is_the_bare_interface() {
        for cos in [0.0, 1e-6, 0.1, 0.5, 1.0] {
            let film = fresnel_thin_film(cos, LIPID_INDEX, TEAR_INDEX, 0.0, 550.0);
            assert!((film - fresnel_dielectric(cos, 1.0, TEAR_INDEX)).abs() < 1e-14);
        }
    }

    #[test]
    fn film_stays_within_its_physical_range() {
        for i in 0..=100 {
            let cos = f64::from(i) / 100.0;
            for d in 0..40 {
                let rgb = fresnel_thin_film_rgb(cos, LIPID_INDEX, TEAR_INDEX, f64::from(d) * 10.0);
                assert!(rgb.min_element() >= 0.0 && rgb.max_element() <= 1.0);
            }
        }
        assert_eq!(
            fresnel_thin_film_rgb(0.0, LIPID_INDEX, TEAR_INDEX, 60.0),
            DVec3::ONE
        );
    }

    proptest! {
        #[test]
        fn nonsense_gives_a_fraction(
            cos in prop::num::f64::ANY, n in prop::num::f64::ANY, m in prop::num::f64::ANY,
            d in prop::num::f64::ANY, wavelength in prop::num::f64::ANY,
        ) {
            for r in [
                fresnel_dielectric(cos, n, m),
                fresnel_dielectric(cos, 1.0, n),
                fresnel_thin_film(cos, n, m, d, wavelength),
                fresnel_thin_film(0.7, 1.48, 1.337, d, wavelength),
                fresnel_thin_film_rgb(cos, n, m, d).x,
            ] {
                prop_assert!((0.0..=1.0).contains(&r), "{r}");
            }
        }
    }
}
