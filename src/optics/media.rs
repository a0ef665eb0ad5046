//! Refractive indices of the eye's media by wavelength.
//!
//! In: a medium and a vacuum wavelength (nm). Out: its phase index, group index and Abbe number.
//!
//! Cauchy's series `n(λ) = c₀ + c₁/λ² + c₂/λ⁴ + c₃/λ⁶`, λ in nm. The dispersions c₁ to c₃ are
//! Atchison & Smith 2005 (J. Opt. Soc. Am. A 22, 29), fitted to the measured indices of human eyes;
//! the levels c₀ are Navarro 2014 (J. Vision 14(13):21), who set them so that at 555 nm the cornea
//! and the aqueous have the indices of Le Grand's eye, 0.0014 above those of Atchison & Smith. The
//! tears keep Atchison & Smith's own level of the aqueous, as in Campbell 2010 (J. Opt. Soc. Am. A
//! 27, 730). That 0.0014 between two careful papers is the error to expect of any level here; the
//! dispersion is common to both.
//!
//! Wavelengths are limited to the visible range of the fits, [`SHORTEST_NM`] to [`LONGEST_NM`].

/// Shortest wavelength (nm): what is shorter counts as this.
pub const SHORTEST_NM: f64 = 380.0;
/// Longest wavelength (nm): what is longer counts as this.
pub const LONGEST_NM: f64 = 780.0;
/// The wavelength (nm) at which indices of white-light eyes are quoted, the peak of photopic
/// vision; it stands in for a wavelength that is not a number.
pub const REFERENCE_NM: f64 = 555.0;

/// Spectral lines of the Abbe number (nm): helium d, hydrogen F and C.
const LINE_D_NM: f64 = 587.562;
const LINE_F_NM: f64 = 486.133;
const LINE_C_NM: f64 = 656.272;

/// Largest index taken from a caller: above every transparent solid.
const LARGEST_INDEX: f64 = 4.0;

/// Cauchy coefficients: 1, nm², nm⁴, nm⁶.
type Cauchy = [f64; 4];

const CORNEA: Cauchy = [1.362_994, 6.009_687e3, -6.760_760e8, 5.908_450e13];
const AQUEOUS: Cauchy = [1.323_031, 6.070_796e3, -7.062_305e8, 6.147_861e13];
const TEARS: Cauchy = [1.321_631, 6.070_796e3, -7.062_305e8, 6.147_861e13];
const LENS_EDGE: Cauchy = [1.356_086, 6.428_455e3, -6.023_738e8, 5.824_149e13];
const VITREOUS: Cauchy = [1.323_757, 5.560_240e3, -5.817_391e8, 5.036_810e13];
/// Atchison & Smith's low-index lens. Their high-index lens is this one times 1.01443 in all four
/// coefficients: dispersion grows in proportion to the index.
const LENS_SCALED: Cauchy = [1.369_486, 6.428_455e3, -6.023_738e8, 5.824_149e13];

/// What light passes through on its way to the retina.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Medium {
    /// Index 1 at every wavelength (the true 1.00028 of air is less than the media's own error).
    Air,
    /// Stroma of the cornea.
    Cornea,
    /// Aqueous humour.
    Aqueous,
    /// Aqueous layer of the tear film.
    Tears,
    /// Surface layer of the crystalline lens, where its gradient index begins.
    LensEdge,
    /// A level of the lens's gradient index, or an equivalent homogeneous lens: its index at
    /// [`REFERENCE_NM`]. The dispersion is Atchison & Smith's, in proportion to the index. Taken
    /// from 1 to 4; what is not a number counts as 1.
    Lens {
        /// Index at 555 nm: about 1.37 at the surface, 1.41 in the nucleus, 1.42 to 1.43 for the
        /// equivalent homogeneous lens.
        index_at_555_nm: f64,
    },
    /// Vitreous body.
    Vitreous,
    /// The same index at every wavelength, for schematic eyes that are monochromatic. Taken from 1
    /// to 4; what is not a number counts as 1.
    Constant(f64),
}

impl Medium {
    /// Phase index at the vacuum wavelength `wavelength_nm`, at least 1. Wavelengths outside
    /// [`SHORTEST_NM`] to [`LONGEST_NM`] count as the nearer limit, what is not a number as
    /// [`REFERENCE_NM`].
    pub fn index(self, wavelength_nm: f64) -> f64 {
        let u = inverse_square(wavelength_nm);
        match self {
            Self::Air => 1.0,
            Self::Cornea => cauchy(&CORNEA, u),
            Self::Aqueous => cauchy(&AQUEOUS, u),
            Self::Tears => cauchy(&TEARS, u),
            Self::LensEdge => cauchy(&LENS_EDGE, u),
            Self::Lens { index_at_555_nm } => lens_scale(index_at_555_nm) * cauchy(&LENS_SCALED, u),
            Self::Vitreous => cauchy(&VITREOUS, u),
            Self::Constant(index) => sane_index(index),
        }
        .max(1.0)
    }

    /// Group index `n − λ dn/dλ`, which optical coherence tomography and time of flight measure;
    /// wavelengths as for [`Self::index`].
    pub fn group_index(self, wavelength_nm: f64) -> f64 {
        let u = inverse_square(wavelength_nm);
        match self {
            Self::Air => 1.0,
            Self::Cornea => cauchy_group(&CORNEA, u),
            Self::Aqueous => cauchy_group(&AQUEOUS, u),
            Self::Tears => cauchy_group(&TEARS, u),
            Self::LensEdge => cauchy_group(&LENS_EDGE, u),
            Self::Lens { index_at_555_nm } => {
                lens_scale(index_at_555_nm) * cauchy_group(&LENS_SCALED, u)
            }
            Self::Vitreous => cauchy_group(&VITREOUS, u),
            Self::Constant(index) => sane_index(index),
        }
        .max(1.0)
    }

    /// Abbe number `(n_d − 1)/(n_F − n_C)`; infinite for a medium without dispersion.
    pub fn abbe_number(self) -> f64 {
        let dispersion = self.index(LINE_F_NM) - self.index(LINE_C_NM);
        if dispersion > 0.0 {
            (self.index(LINE_D_NM) - 1.0) / dispersion
        } else {
            f64::INFINITY
        }
    }
}

/// `1/λ²` of a wavelength within the limits.
fn inverse_square(wavelength_nm: f64) -> f64 {
    let wavelength = if wavelength_nm.is_nan() {
        REFERENCE_NM
    } else {
        wavelength_nm.clamp(SHORTEST_NM, LONGEST_NM)
    };
    1.0 / (wavelength * wavelength)
}

fn cauchy(c: &Cauchy, u: f64) -> f64 {
    c[0] + u * (c[1] + u * (c[2] + u * c[3]))
}

/// `n − λ dn/dλ`: the term in λ^−2k counts 1 + 2k times.
fn cauchy_group(c: &Cauchy, u: f64) -> f64 {
    c[0] + u * (3.0 * c[1] + u * (5.0 * c[2] + u * (7.0 * c[3])))
}

/// Ratio of a lens's index to that of [`LENS_SCALED`].
fn lens_scale(index_at_555_nm: f64) -> f64 {
    sane_index(index_at_555_nm) / cauchy(&LENS_SCALED, 1.0 / (REFERENCE_NM * REFERENCE_NM))
}

fn sane_index(index: f64) -> f64 {
    if index.is_nan() {
        1.0
    } else {
        index.clamp(1.0, LARGEST_INDEX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DISPERSIVE: [Medium; 6] = [
        Medium::Cornea,
        Medium::Aqueous,
        Medium::Tears,
        Medium::LensEdge,
        Medium::Lens {
            index_at_555_nm: 1.406,
        },
        Medium::Vitreous,
    ];

    #[test]
    fn indices_at_555_nm_are_the_published_ones() {
        // REFERENCE: cornea 1.3774, aqueous 1.3374, to four decimals; Le Grand's eye has 1.3771 and
        // 1.3374. Tears: Atchison & Smith's aqueous, 0.0014 lower.
        assert!((Medium::Cornea.index(555.0) - 1.3774).abs() < 5e-5);
        assert!((Medium::Aqueous.index(555.0) - 1.3374).abs() < 5e-5);
        let step = Medium::Aqueous.index(480.0) - Medium::Tears.index(480.0);
        assert!((step - 0.0014).abs() < 1e-12);
        // Navarro 2014 gives the vitreous the aqueous's index; Atchison & Smith's 1.322357 + … of
        // the vitreous is 1.3360, Le Grand's value, again 0.0014 lower.
        assert!((Medium::Vitreous.index(555.0) - 1.3374).abs() < 5e-5);
        assert!((Medium::Vitreous.index(555.0) - 0.0014 - 1.3360).abs() < 5e-5);
        assert!((Medium::LensEdge.index(555.0) - 1.3726).abs() < 5e-5);
    }

    #[test]
    fn the_series_is_summed_as_written() {
        // Against the powers themselves, rounding apart.
        for i in 0..=40 {
            let l = 380.0 + 10.0 * f64::from(i);
            let expected = 1.362_994 + 6.009_687e3 / l.powi(2) - 6.760_760e8 / l.powi(4)
                + 5.908_450e13 / l.powi(6);
            assert!((Medium::Cornea.index(l) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn a_lens_of_higher_index_disperses_in_proportion() {
        // Atchison & Smith 2005 print the high-index lens as 1.389248, 6.521218e3, −6.110661e8,
        // 5.908191e13: seven digits.
        let high: Cauchy = [1.389_248, 6.521_218e3, -6.110_661e8, 5.908_191e13];
        let at = |l: f64| cauchy(&high, 1.0 / (l * l));
        let lens = Medium::Lens {
            index_at_555_nm: at(555.0),
        };
        for l in [380.0, 450.0, 589.0, 780.0] {
            assert!((lens.index(l) - at(l)).abs() < 2e-7, "{l}");
        }
    }

    #[test]
    fn abbe_numbers_are_those_of_watery_tissue() {
        // Water has 55.7; published model eyes give cornea 55 to 61, aqueous and vitreous 50 to 56,
        // lens 46 to 50 (Atchison & Smith 2000, Navarro 1985, Liou & Brennan 1997).
        let range = [
            (Medium::Cornea, 54.0, 61.0),
            (Medium::Aqueous, 50.0, 56.0),
            (Medium::Vitreous, 50.0, 57.0),
            (Medium::LensEdge, 44.0, 51.0),
        ];
        for (medium, low, high) in range {
            let v = medium.abbe_number();
            println!(
                "{medium:?}: V_d = {v:.2}, n(555) = {:.5}",
                medium.index(555.0)
            );
            assert!((low..high).contains(&v), "{medium:?}: {v}");
        }
        assert_eq!(Medium::Air.abbe_number(), f64::INFINITY);
        assert_eq!(Medium::Constant(1.336).abbe_number(), f64::INFINITY);
    }

    #[test]
    fn dispersion_is_normal_and_the_group_lags() {
        for medium in DISPERSIVE {
            for nm in 380..780 {
                let l = f64::from(nm);
                assert!(medium.index(l) > medium.index(l + 1.0), "{medium:?} {l}");
                // n − λ dn/dλ by a central difference: h² n‴ λ/6 is below 1e-7 with h = 0.1 nm.
                if nm > 380 {
                    let h = 0.1;
                    let slope = (medium.index(l + h) - medium.index(l - h)) / (2.0 * h);
                    let expected = medium.index(l) - l * slope;
                    assert!(
                        (medium.group_index(l) - expected).abs() < 1e-6,
                        "{medium:?} {l}"
                    );
                }
            }
        }
    }

    #[test]
    fn outside_the_visible_range_the_limits_hold() {
        for medium in DISPERSIVE {
            assert_eq!(medium.index(0.0), medium.index(380.0));
            assert_eq!(medium.index(-5.0), medium.index(380.0));
            assert_eq!(medium.index(f64::INFINITY), medium.index(780.0));
            assert_eq!(medium.index(f64::NAN), medium.index(555.0));
        }
        assert_eq!(Medium::Constant(f64::NAN).index(555.0), 1.0);
        assert_eq!(Medium::Constant(f64::INFINITY).index(555.0), 4.0);
        assert_eq!(Medium::Constant(1.336).index(1.0), 1.336);
    }

    proptest! {
        #[test]
        fn any_wavelength_and_any_index_give_a_finite_index(
            wavelength in prop::num::f64::ANY,
            index in prop::num::f64::ANY,
        ) {
            for medium in DISPERSIVE.into_iter().chain([
                Medium::Air,
                Medium::Constant(index),
                Medium::Lens { index_at_555_nm: index },
            ]) {
                let n = medium.index(wavelength);
                let group = medium.group_index(wavelength);
                prop_assert!((1.0..=5.0).contains(&n) && (1.0..=6.0).contains(&group));
            }
        }
    }
}
