//! The tear film's reflection in white light: interference colours of its lipid layer.
//!
//! In: the cosine of the angle of incidence, indices, thickness (nm). Out: reflectance as linear
//! sRGB under D65 for the CIE 1931 observer, a perfect mirror being (1, 1, 1).
//!
//! [`tear_film_rgb_exact`] sums Airy's formula ([`super::fresnel`]) over the 41 wavelengths of
//! [`crate::tissue::spectrum`]: the reference. A few wavelengths are enough, since all that the
//! colour depends on is how fast `∫ w(λ) cos(4π L/λ) dλ` of each channel's weight w fades with the
//! optical path L: [`tear_film_rgb`] takes four, with a matrix from reflectances to channels, chosen
//! for the smallest largest error of those integrals up to L = 450 nm. Against the reference with
//! constant indices, all incidences, lipid 1.48 over 1.337:
//!
//! | form | bytes | up to 200 nm | up to 300 nm |
//! |---|---|---|---|
//! | [`super::fresnel::fresnel_thin_film_rgb`], one wavelength a channel | 12 | 1.0e-2 | 1.3e-2 |
//! | three wavelengths and a matrix | 48 | 5.0e-4 | 9.3e-4 |
//! | **four wavelengths, [`tear_film_rgb`]** | 64 | 3.4e-5 | 1.2e-4 |
//! | six | 96 | 1.6e-6 | 1.1e-5 |
//! | table, 64 thicknesses × 64 cosines, half floats, bilinear | 24,576 | | 1.1e-3 |
//!
//! A film reflects 0.02 to 0.06 at perpendicular incidence. Leaving out the dispersion of the tears
//! costs 1.7e-3 at most (0.9e-3 perpendicular), so more than four wavelengths would be false
//! accuracy.
//!
//! [`TearFilm`] is the whole film, lipid over aqueous tear over epithelium, with dispersion.
//!
//! Twin of [`tear_film_rgb`]: `shaders/lib/tear_film.wgsl`.

use super::fresnel::{
    Film, GRAZING_COSINE, LIPID_INDEX, clamp_or, cosine_within, fresnel_stack,
    fresnel_stack_over_thick, fresnel_thin_film,
};
use super::media::Medium;
use crate::tissue::spectrum::{spectrum_from, spectrum_to_linear_srgb};
use core::f64::consts::TAU;
use glam::{DMat4, DVec3, DVec4};

/// Index of the corneal epithelium (Patel, Marshall & Fitzke 1995, J. Refract. Surg. 11, 100).
pub const EPITHELIUM_INDEX: f64 = 1.401;

/// The four wavelengths (nm) of [`tear_film_rgb`].
const TEAR_FILM_NM: DVec4 = DVec4::new(435.3, 487.3, 547.8, 621.4);

/// What each wavelength adds to red, green and blue; each channel's weights sum to 1. The fourth row
/// is empty.
const TEAR_FILM_WEIGHTS: DMat4 = DMat4::from_cols_array_2d(&[
    [0.096_42, -0.083_06, 0.663_91, 0.0],
    [-0.338_63, 0.214_19, 0.526_58, 0.0],
    [0.091_77, 0.882_62, -0.189_06, 0.0],
    [1.150_44, -0.013_75, -0.001_43, 0.0],
]);

/// Linear sRGB reflectance of a film of index `film_index` (the lipid layer) between air and
/// `substrate_index` (the aqueous tear) in D65 light; the arguments are those of
/// [`super::fresnel::fresnel_thin_film_rgb`] and limited as there. The errors of the module's table
/// hold for thicknesses from 0 to 300 nm; thicker films keep their colours a little too long.
/// Channels may leave 0 to 1, as saturated colours do in sRGB, but not −0.34 to 1.34.
pub fn tear_film_rgb(
    cos_incidence: f64,
    film_index: f64,
    substrate_index: f64,
    film_thickness_nm: f64,
) -> DVec3 {
    let cos_1 = clamp_or(cos_incidence, 0.0, 1.0, 0.0);
    let film_index = clamp_or(film_index, 1.0, 4.0, 1.0);
    let substrate_index = clamp_or(substrate_index, 1.0, 4.0, 1.0);
    let film_thickness_nm = clamp_or(film_thickness_nm, 0.0, 1e9, 0.0);
    if cos_1 < GRAZING_COSINE {
        return DVec3::ONE;
    }
    let cos_2 = cosine_within(film_index, cos_1);
    let cos_3 = cosine_within(substrate_index, cos_1);
    let path = 2.0 * TAU * film_index * film_thickness_nm * cos_2;
    let cos_phase = (path / TEAR_FILM_NM).map(f64::cos);

    let s_12 = (cos_1 - film_index * cos_2) / (cos_1 + film_index * cos_2);
    let s_23 = (film_index * cos_2 - substrate_index * cos_3)
        / (film_index * cos_2 + substrate_index * cos_3);
    let p_12 = (film_index * cos_1 - cos_2) / (film_index * cos_1 + cos_2);
    let p_23 = (substrate_index * cos_2 - film_index * cos_3)
        / (substrate_index * cos_2 + film_index * cos_3);
    let passed =
        0.5 * (tear_film_passed(s_12, s_23, cos_phase) + tear_film_passed(p_12, p_23, cos_phase));
    DVec3::ONE - (TEAR_FILM_WEIGHTS * passed).truncate()
}

/// Airy's transmittance `(1 − r₁₂²)(1 − r₂₃²)/|1 + r₁₂ r₂₃ e^{iφ}|²` at four phases.
fn tear_film_passed(r_12: f64, r_23: f64, cos_phase: DVec4) -> DVec4 {
    let product = r_12 * r_23;
    let entering = (1.0 - r_12 * r_12) * (1.0 - r_23 * r_23);
    let around = DVec4::splat(1.0 + product * product) + 2.0 * product * cos_phase;
    // Both vanish together only where everything is reflected.
    entering / around.max(DVec4::splat(1e-12))
}

/// The same from all 41 wavelengths: exact for constant indices but for the 10 nm step of the
/// spectrum.
pub fn tear_film_rgb_exact(
    cos_incidence: f64,
    film_index: f64,
    substrate_index: f64,
    film_thickness_nm: f64,
) -> DVec3 {
    DVec3::from_array(spectrum_to_linear_srgb(&spectrum_from(|wavelength_nm| {
        fresnel_thin_film(
            cos_incidence,
            film_index,
            substrate_index,
            film_thickness_nm,
            wavelength_nm,
        )
    })))
}

/// The tear film on the cornea: lipid, aqueous tear with its mucin, epithelium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TearFilm {
    /// Thickness of the lipid layer (nm): 20 to 120, 41 to 67 on average.
    pub lipid_nm: f64,
    /// Thickness of the aqueous layer (nm): 3,000 to 5,000.
    pub aqueous_nm: f64,
}

impl TearFilm {
    /// Reflectance for unpolarised light of one wavelength (nm), the aqueous layer averaged over its
    /// phase: what a spot of ordinary size on a living cornea shows.
    pub fn reflectance(self, cos_incidence: f64, wavelength_nm: f64) -> f64 {
        fresnel_stack_over_thick(
            cos_incidence,
            1.0,
            &[self.lipid()],
            Medium::Tears.index(wavelength_nm),
            &[],
            EPITHELIUM_INDEX,
            wavelength_nm,
        )
        .reflectance()
    }

    /// The same with the aqueous layer coherent, as over a smooth surface: its fringes ride on the
    /// spectrum, as in the interferometry of its thickness.
    pub fn coherent_reflectance(self, cos_incidence: f64, wavelength_nm: f64) -> f64 {
        let aqueous = Film {
            index: Medium::Tears.index(wavelength_nm),
            thickness_nm: self.aqueous_nm,
        };
        fresnel_stack(
            cos_incidence,
            1.0,
            &[self.lipid(), aqueous],
            EPITHELIUM_INDEX,
            wavelength_nm,
        )
        .reflectance()
    }

    /// [`Self::reflectance`] as linear sRGB under D65.
    pub fn rgb(self, cos_incidence: f64) -> DVec3 {
        DVec3::from_array(spectrum_to_linear_srgb(&spectrum_from(|wavelength_nm| {
            self.reflectance(cos_incidence, wavelength_nm)
        })))
    }

    fn lipid(self) -> Film {
        Film {
            index: LIPID_INDEX,
            thickness_nm: self.lipid_nm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel::{TEAR_INDEX, fresnel_dielectric, fresnel_thin_film_rgb};
    use proptest::prelude::*;

    /// Largest channel error against the reference, over all incidences.
    fn worst(form: impl Fn(f64, f64) -> DVec3, thickest_nm: i32) -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..=60 {
            let cos = f64::from(i) / 60.0;
            for d in (0..=thickest_nm).step_by(5) {
                let d = f64::from(d);
                let exact = tear_film_rgb_exact(cos, LIPID_INDEX, TEAR_INDEX, d);
                worst = worst.max((form(cos, d) - exact).abs().max_element());
            }
        }
        worst
    }

    #[test]
    fn four_wavelengths_are_as_good_as_the_table_says() {
        let four = |cos, d| tear_film_rgb(cos, LIPID_INDEX, TEAR_INDEX, d);
        let (near, far) = (worst(four, 200), worst(four, 300));
        println!("four wavelengths: {near:.2e} to 200 nm, {far:.2e} to 300 nm");
        assert!(near < 3.6e-5 && far < 1.3e-4);
        // The form it replaces, so that the comparison is known to see a difference.
        let one = |cos, d| fresnel_thin_film_rgb(cos, LIPID_INDEX, TEAR_INDEX, d);
        let (near, far) = (worst(one, 200), worst(one, 300));
        println!("one wavelength a channel: {near:.2e} to 200 nm, {far:.2e} to 300 nm");
        assert!((0.9e-2..1.1e-2).contains(&near) && (1.2e-2..1.4e-2).contains(&far));
    }

    #[test]
    fn more_wavelengths_would_be_better_still() {
        // Other sizes of the same form, as in the module's table.
        let form = |nm: &[f64], weights: [&[f64]; 3], cos: f64, d: f64| {
            DVec3::from_array(weights.map(|w| {
                w.iter()
                    .zip(nm)
                    .map(|(w, nm)| w * fresnel_thin_film(cos, LIPID_INDEX, TEAR_INDEX, d, *nm))
                    .sum()
            }))
        };
        let three = |cos, d| {
            form(
                &[444.2, 527.2, 608.2],
                [
                    &[0.04193, -0.4866, 1.44467],
                    &[-0.09514, 0.9678, 0.12734],
                    &[0.96572, 0.12991, -0.09563],
                ],
                cos,
                d,
            )
        };
        let six = |cos, d| {
            form(
                &[420.1, 455.5, 481.8, 537.0, 593.9, 650.9],
                [
                    &[0.03045, 0.08163, -0.22898, -0.32976, 1.08288, 0.36378],
                    &[-0.02876, -0.08487, 0.17356, 0.80522, 0.17656, -0.04171],
                    &[0.21733, 0.74032, 0.12724, -0.02357, -0.06306, 0.00174],
                ],
                cos,
                d,
            )
        };
        let found = [
            worst(three, 200),
            worst(three, 300),
            worst(six, 200),
            worst(six, 300),
        ];
        println!(
            "three, six wavelengths: {:.2e} {:.2e} {:.2e} {:.2e}",
            found[0], found[1], found[2], found[3]
        );
        for (found, limit) in found.into_iter().zip([5.2e-4, 9.6e-4, 1.8e-6, 1.2e-5]) {
            assert!(
                found < limit && found > 0.8 * limit,
                "{found:.2e} {limit:.2e}"
            );
        }
    }

    #[test]
    fn without_thickness_it_is_the_bare_tear() {
        for i in 0..=20 {
            let cos = f64::from(i) / 20.0;
            let bare = DVec3::splat(fresnel_dielectric(cos, 1.0, TEAR_INDEX));
            // The weights sum to 1, and 1 − T loses no more than rounding.
            assert!(tear_film_rgb(cos, 1.48, TEAR_INDEX, 0.0).distance(bare) < 1e-14);
            assert!(tear_film_rgb_exact(cos, 1.48, TEAR_INDEX, 0.0).distance(bare) < 1e-14);
        }
        assert!(tear_film_rgb(0.0, 1.48, TEAR_INDEX, 60.0).distance(DVec3::ONE) < 1e-15);
    }

    #[test]
    fn the_colours_are_those_seen_in_the_clinic() {
        // Interferometers with white light: grey to bluish white while thin, yellow from about
        // 90 nm, brown to red from 130, purple and blue at 180 to 210.
        let at = |d| tear_film_rgb_exact(1.0, LIPID_INDEX, TEAR_INDEX, d);
        for d in (0..=300).step_by(30) {
            println!("{d} nm: {:.4}", at(f64::from(d)));
        }
        let thin = at(30.0);
        assert!(thin.z > thin.y && thin.y > thin.x && thin.z < 1.3 * thin.x);
        for d in [90.0, 105.0, 120.0] {
            let c = at(d);
            assert!(c.z < c.x && c.z < c.y, "yellow at {d}: {c}");
        }
        for d in [135.0, 150.0] {
            let c = at(d);
            assert!(c.x > 1.3 * c.y && c.y > 1.3 * c.z, "brown at {d}: {c}");
        }
        for d in [180.0, 195.0, 210.0] {
            let c = at(d);
            assert!(c.z > c.x && c.z > c.y, "blue at {d}: {c}");
        }
        assert!(
            at(180.0).x > 1.3 * at(180.0).y,
            "purple at 180: {}",
            at(180.0)
        );
        // It is brightest near a quarter wave of green, 550/(4 · 1.48) = 93 nm.
        let brightest = (0..200_i32)
            .max_by(|a, b| at(f64::from(*a)).y.total_cmp(&at(f64::from(*b)).y))
            .unwrap();
        assert!((brightest - 93_i32).abs() <= 2, "{brightest}");
    }

    #[test]
    fn the_whole_film_is_the_lipid_layer_over_a_little_more() {
        let film = TearFilm {
            lipid_nm: 60.0,
            aqueous_nm: 3000.0,
        };
        // The epithelium adds ((1.401 − 1.337)/(1.401 + 1.337))² = 0.05 % at 550 nm.
        let lipid = fresnel_thin_film(1.0, LIPID_INDEX, Medium::Tears.index(550.0), 60.0, 550.0);
        let added = film.reflectance(1.0, 550.0) - lipid;
        assert!((4e-4..7e-4).contains(&added), "{added}");
        // Fringes of the aqueous layer swing by 2 √R_lipid √R_epithelium about that mean and come
        // every λ²/(2 n d) = 38 nm of wavelength.
        let spectrum: Vec<f64> = (5000..6000)
            .map(|i| film.coherent_reflectance(1.0, 0.1 * f64::from(i)))
            .collect();
        let swing = spectrum.iter().fold(0.0, |a: f64, b| a.max(*b))
            - spectrum.iter().fold(1.0, |a: f64, b| a.min(*b));
        let expected = 4.0 * (lipid * added).sqrt();
        assert!((swing / expected - 1.0).abs() < 0.2, "{swing} {expected}");
        // The colour of the whole film: the shader's form misses the epithelium's light and the
        // dispersion of the tears.
        let off = film.rgb(1.0) - tear_film_rgb(1.0, LIPID_INDEX, TEAR_INDEX, 60.0);
        println!("whole film − shader's form: {off:.5}");
        assert!(off.abs().max_element() < 2e-3);
    }

    proptest! {
        #[test]
        fn any_film_is_finite(
            cos in prop::num::f64::ANY, film in prop::num::f64::ANY,
            substrate in prop::num::f64::ANY, d in prop::num::f64::ANY,
            legal in (0.0..1.0_f64, 1.0..2.0_f64, 1.0..2.0_f64, 0.0..1e5_f64),
        ) {
            let (c, n, m, t) = legal;
            for rgb in [
                tear_film_rgb(cos, film, substrate, d),
                tear_film_rgb(c, n, m, t),
                tear_film_rgb(c, film, m, d),
            ] {
                prop_assert!(rgb.is_finite() && rgb.min_element() > -0.35 && rgb.max_element() < 1.35);
            }
            let whole = TearFilm { lipid_nm: d, aqueous_nm: film };
            prop_assert!((0.0..=1.0 + 1e-9).contains(&whole.reflectance(cos, substrate)));
            prop_assert!((0.0..=1.0 + 1e-9).contains(&whole.coherent_reflectance(cos, substrate)));
        }
    }
}
