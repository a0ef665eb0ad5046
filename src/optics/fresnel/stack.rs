//! Light on any number of films on one another (Born & Wolf, *Principles of Optics*, section 1.6).
//!
//! [`fresnel_stack`] adds the films from below, each by Airy's sum with the amplitude reflectance of
//! all that lies under it. Unlike the product of characteristic matrices this never forms the
//! growing wave of an evanescent film, so that no thickness overflows. A layer thicker than the
//! light's coherence (the aqueous tear, 3 to 5 µm, over a rough epithelium: its fringes are of low
//! contrast, King-Smith et al. 2014, IOVS 55, 2614) stands in [`fresnel_stack_over_thick`],
//! averaged over its phase.

use super::{GRAZING_COSINE, clamp_or, fresnel_cosine};
use core::f64::consts::TAU;

/// A homogeneous film without absorption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Refractive index, 1 to 4.
    pub index: f64,
    /// Thickness (nm), from 0.
    pub thickness_nm: f64,
}

/// Fractions of the incident light, by polarisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSplit {
    /// Reflected of the light polarised across the plane of incidence.
    pub reflected_s: f64,
    /// Reflected of the light polarised in the plane of incidence.
    pub reflected_p: f64,
    /// Passed into the substrate, s.
    pub transmitted_s: f64,
    /// Passed into the substrate, p.
    pub transmitted_p: f64,
}

impl LightSplit {
    /// Everything reflected.
    const MIRROR: Self = Self {
        reflected_s: 1.0,
        reflected_p: 1.0,
        transmitted_s: 0.0,
        transmitted_p: 0.0,
    };

    /// Reflected fraction of unpolarised light.
    pub fn reflectance(self) -> f64 {
        0.5 * (self.reflected_s + self.reflected_p)
    }

    /// Transmitted fraction of unpolarised light; 1 − reflectance to rounding, since no film absorbs.
    pub fn transmittance(self) -> f64 {
        0.5 * (self.transmitted_s + self.transmitted_p)
    }
}

/// Light of one wavelength on a stack of films, the first of them next to the outer medium.
///
/// Each index is taken from 1 to 4, thicknesses from 0 to 1 m, the vacuum wavelength from 1 nm to
/// 1 m, the cosine from 0 to 1; what is not a number counts as index 1, thickness 0, wavelength
/// 555 nm and grazing incidence. Exact to rounding, 1e-14; a stack that traps light (nearly grazing
/// light, or a film near its critical angle) enlarges rounding to 1e-16 over the cosine there.
pub fn fresnel_stack(
    cos_incidence: f64,
    outside_index: f64,
    films: &[Film],
    substrate_index: f64,
    wavelength_nm: f64,
) -> LightSplit {
    let cos_outside = fresnel_cosine(cos_incidence);
    if cos_outside < GRAZING_COSINE {
        return LightSplit::MIRROR;
    }
    let outside = fresnel_index(outside_index);
    let top = Layer {
        index: outside,
        cosine: Complex::real(cos_outside),
    };
    let wave_number = TAU / clamp_or(wavelength_nm, 1.0, 1e9, 555.0);

    // From below: what lies under the current interface reflects and passes these amplitudes.
    let mut below = Layer::new(fresnel_index(substrate_index), outside, cos_outside);
    let substrate = below;
    let (mut s, mut p) = (Amplitudes::NOTHING_BELOW, Amplitudes::NOTHING_BELOW);
    let mut round_trip = Complex::ONE;
    let mut one_way = Complex::ONE;
    for film in films.iter().rev() {
        let layer = Layer::new(fresnel_index(film.index), outside, cos_outside);
        s = s.under(interface_s(layer, below), one_way, round_trip);
        p = p.under(interface_p(layer, below), one_way, round_trip);
        let thickness = clamp_or(film.thickness_nm, 0.0, 1e9, 0.0);
        one_way = (layer.projected().scale(wave_number * thickness)).phase();
        round_trip = one_way.times(one_way);
        below = layer;
    }
    s = s.under(interface_s(top, below), one_way, round_trip);
    p = p.under(interface_p(top, below), one_way, round_trip);

    // Energy flows into the substrate in proportion to Re(n cos θ); for real indices that is the
    // same for both polarisations.
    let flow = substrate.projected().re / (outside * cos_outside);
    LightSplit {
        reflected_s: s.reflected.norm_squared().min(1.0),
        reflected_p: p.reflected.norm_squared().min(1.0),
        transmitted_s: (flow * s.transmitted.norm_squared()).min(1.0),
        transmitted_p: (flow * p.transmitted.norm_squared()).min(1.0),
    }
}

/// The same with a layer of index `thick_index` between the films `above` and `below` that is too
/// thick, or too uneven, to interfere: the reflectances of the two stacks add as intensities,
/// `R = R_a + T_a² R_b/(1 − R_a R_b)`, which is the mean of the coherent result over the layer's
/// phase. Arguments as for [`fresnel_stack`].
pub fn fresnel_stack_over_thick(
    cos_incidence: f64,
    outside_index: f64,
    above: &[Film],
    thick_index: f64,
    below: &[Film],
    substrate_index: f64,
    wavelength_nm: f64,
) -> LightSplit {
    let cos_outside = fresnel_cosine(cos_incidence);
    let (outside, thick) = (fresnel_index(outside_index), fresnel_index(thick_index));
    let cos_thick = Layer::new(thick, outside, cos_outside).cosine;
    if cos_thick.re <= 0.0 {
        return LightSplit::MIRROR;
    }
    let upper = fresnel_stack(
        cos_outside,
        outside_index,
        above,
        thick_index,
        wavelength_nm,
    );
    let lower = fresnel_stack(
        cos_thick.re,
        thick_index,
        below,
        substrate_index,
        wavelength_nm,
    );
    // Without absorption a stack reflects as much from either side.
    let mix = |r_a: f64, t_a: f64, r_b: f64, t_b: f64| {
        let between = 1.0 - r_a * r_b;
        if between <= 0.0 {
            return (1.0, 0.0);
        }
        (
            (r_a + t_a * t_a * r_b / between).min(1.0),
            (t_a * t_b / between).min(1.0),
        )
    };
    let (reflected_s, transmitted_s) = mix(
        upper.reflected_s,
        upper.transmitted_s,
        lower.reflected_s,
        lower.transmitted_s,
    );
    let (reflected_p, transmitted_p) = mix(
        upper.reflected_p,
        upper.transmitted_p,
        lower.reflected_p,
        lower.transmitted_p,
    );
    LightSplit {
        reflected_s,
        reflected_p,
        transmitted_s,
        transmitted_p,
    }
}

fn fresnel_index(index: f64) -> f64 {
    clamp_or(index, 1.0, 4.0, 1.0)
}

/// A medium of the stack and the cosine of the light's direction in it, imaginary where the light is
/// evanescent.
#[derive(Clone, Copy)]
struct Layer {
    index: f64,
    cosine: Complex,
}

impl Layer {
    /// At exactly a film's critical angle the interfaces' amplitudes are ±1 and Airy's denominator
    /// is 0/0; half the digits are left this far from it.
    const SMALLEST_COSINE_SQUARED: f64 = 1e-16;

    /// A medium of `index` below light that comes at `cos_outside` from one of index `outside`:
    /// `cos² = 1 − (n₀ sin θ₀/n)²`, without the difference that fails at grazing incidence.
    fn new(index: f64, outside: f64, cos_outside: f64) -> Self {
        let squared = ((index - outside) * (index + outside)
            + outside * outside * cos_outside * cos_outside)
            / (index * index);
        let smallest = if index == outside {
            0.0
        } else {
            Self::SMALLEST_COSINE_SQUARED
        };
        let cosine = if squared >= 0.0 {
            Complex::real(squared.max(smallest).sqrt())
        } else {
            // The positive root decays downwards.
            Complex::new(0.0, (-squared).max(smallest).sqrt())
        };
        Self { index, cosine }
    }

    /// n cos θ.
    fn projected(self) -> Complex {
        self.cosine.scale(self.index)
    }
}

/// Amplitude reflectance and transmittance.
#[derive(Clone, Copy)]
struct Amplitudes {
    reflected: Complex,
    transmitted: Complex,
}

impl Amplitudes {
    const NOTHING_BELOW: Self = Self {
        reflected: Complex::ZERO,
        transmitted: Complex::ONE,
    };

    /// Airy's sum: these amplitudes, seen through a film with the given phase factors, under one
    /// more interface.
    fn under(self, interface: Self, one_way: Complex, round_trip: Complex) -> Self {
        let returned = self.reflected.times(round_trip);
        let inverse = Complex::ONE
            .plus(interface.reflected.times(returned))
            .inverse();
        Self {
            reflected: interface.reflected.plus(returned).times(inverse),
            transmitted: interface
                .transmitted
                .times(self.transmitted)
                .times(one_way)
                .times(inverse),
        }
    }
}

/// Fresnel's amplitudes at an interface, s-polarised.
fn interface_s(above: Layer, below: Layer) -> Amplitudes {
    interface(above.projected(), below.projected(), above.projected())
}

/// Fresnel's amplitudes at an interface, p-polarised.
fn interface_p(above: Layer, below: Layer) -> Amplitudes {
    interface(
        above.cosine.scale(below.index),
        below.cosine.scale(above.index),
        above.projected(),
    )
}

/// `(x − y)/(x + y)` and `2 z/(x + y)`.
fn interface(x: Complex, y: Complex, z: Complex) -> Amplitudes {
    let inverse = x.plus(y).inverse();
    Amplitudes {
        reflected: x.plus(y.scale(-1.0)).times(inverse),
        transmitted: z.scale(2.0).times(inverse),
    }
}

/// As much of the complex numbers as a stack needs.
#[derive(Clone, Copy)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    const ZERO: Self = Self::new(0.0, 0.0);
    const ONE: Self = Self::new(1.0, 0.0);

    const fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    const fn real(re: f64) -> Self {
        Self::new(re, 0.0)
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }

    fn times(self, other: Self) -> Self {
        Self::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }

    fn scale(self, factor: f64) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }

    fn norm_squared(self) -> f64 {
        self.re * self.re + self.im * self.im
    }

    fn inverse(self) -> Self {
        let norm = self.norm_squared();
        Self::new(self.re / norm, -self.im / norm)
    }

    /// `e^(i z)`.
    fn phase(self) -> Self {
        let (sin, cos) = self.re.sin_cos();
        let decay = (-self.im).exp();
        Self::new(decay * cos, decay * sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel::{LIPID_INDEX, TEAR_INDEX, fresnel_dielectric, fresnel_thin_film};
    use proptest::prelude::*;

    fn film(index: f64, thickness_nm: f64) -> Film {
        Film {
            index,
            thickness_nm,
        }
    }

    #[test]
    fn a_stack_of_one_film_is_airys_sum() {
        for i in 0..=50 {
            let cos = f64::from(i) / 50.0;
            for d in [0.0, 20.0, 42.0, 90.0, 157.0, 400.0] {
                for wavelength in [380.0, 555.0, 780.0] {
                    let stack =
                        fresnel_stack(cos, 1.0, &[film(LIPID_INDEX, d)], TEAR_INDEX, wavelength);
                    let airy = fresnel_thin_film(cos, LIPID_INDEX, TEAR_INDEX, d, wavelength);
                    // Some twenty roundings of numbers below 1.
                    assert!((stack.reflectance() - airy).abs() < 1e-14, "{cos} {d}");
                }
            }
            let bare = fresnel_stack(cos, 1.0, &[], 1.376, 555.0).reflectance();
            assert!((bare - fresnel_dielectric(cos, 1.0, 1.376)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_film_may_be_cut_in_two_and_an_empty_one_left_out() {
        for cos in [0.02, 0.4, 1.0] {
            let whole = fresnel_stack(cos, 1.0, &[film(1.48, 90.0)], 1.337, 500.0);
            let parts = [
                film(1.7, 0.0),
                film(1.48, 30.0),
                film(1.48, 60.0),
                film(1.337, 700.0),
            ];
            let cut = fresnel_stack(cos, 1.0, &parts, 1.337, 500.0);
            assert!((whole.reflected_s - cut.reflected_s).abs() < 1e-13);
            assert!((whole.reflected_p - cut.reflected_p).abs() < 1e-13);
        }
    }

    #[test]
    fn textbook_coatings() {
        // A quarter wave of index √n quenches the reflection; two quarter waves reflect
        // ((n₁² n_s − n₂² n₀)/(n₁² n_s + n₂² n₀))² with n₁ on the outside (Born & Wolf, 1.6.5).
        let quarter = |n: f64| film(n, 550.0 / (4.0 * n));
        let quenched = fresnel_stack(1.0, 1.0, &[quarter(1.52_f64.sqrt())], 1.52, 550.0);
        assert!(quenched.reflectance() < 1e-30);
        let (n1, n2, ns) = (1.38_f64, 1.8_f64, 1.52);
        let expected = ((n1 * n1 * ns - n2 * n2) / (n1 * n1 * ns + n2 * n2)).powi(2);
        let two = fresnel_stack(1.0, 1.0, &[quarter(n1), quarter(n2)], ns, 550.0);
        assert!((two.reflectance() - expected).abs() < 1e-15);
    }

    #[test]
    fn total_reflection_is_frustrated_by_a_second_medium() {
        // Glass, an air gap, glass beyond the critical angle (41.8° at 1.5): at 45° the passed
        // fraction is 1/(1 + a sinh² κd), with a for s = ((n² − 1)²)/(4 n² cos² (n² sin² − 1)).
        let (n, wavelength) = (1.5_f64, 600.0);
        let (sin2, cos2) = (0.5, 0.5);
        let kappa = TAU / wavelength * (n * n * sin2 - 1.0).sqrt();
        let a = (n * n - 1.0).powi(2) / (4.0 * n * n * cos2 * (n * n * sin2 - 1.0));
        for gap in [1.0, 100.0, 500.0, 1e5] {
            let got = fresnel_stack(cos2.sqrt(), n, &[film(1.0, gap)], n, wavelength);
            let expected = 1.0 / (1.0 + a * (kappa * gap).sinh().powi(2));
            assert!((got.transmitted_s - expected).abs() < 1e-13, "{gap}");
            assert!((got.reflected_s + got.transmitted_s - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_thick_layer_is_the_mean_over_its_phase() {
        let lipid = [film(LIPID_INDEX, 60.0)];
        for cos in [0.1, 0.6, 1.0] {
            let thick = fresnel_stack_over_thick(cos, 1.0, &lipid, TEAR_INDEX, &[], 1.401, 550.0);
            let cos_tear = (1.0 - (1.0 - cos * cos) / TEAR_INDEX.powi(2)).sqrt();
            // One period of the phase, sampled evenly: the error falls as (r₁ r₂)^64.
            let period = 550.0 / (2.0 * TEAR_INDEX * cos_tear);
            let mean = |pick: &dyn Fn(LightSplit) -> f64| {
                (0..64)
                    .map(|i| {
                        let d = 3000.0 + period * f64::from(i) / 64.0;
                        let films = [lipid[0], film(TEAR_INDEX, d)];
                        pick(fresnel_stack(cos, 1.0, &films, 1.401, 550.0))
                    })
                    .sum::<f64>()
                    / 64.0
            };
            assert!((mean(&|l| l.reflected_s) - thick.reflected_s).abs() < 1e-14);
            assert!((mean(&|l| l.reflected_p) - thick.reflected_p).abs() < 1e-14);
            assert!((mean(&|l| l.transmitted_p) - thick.transmitted_p).abs() < 1e-13);
        }
    }

    #[test]
    fn matched_films_are_invisible_even_at_grazing_incidence() {
        for cos in [1e-11, 1e-9, 1e-4, 0.5] {
            let light = fresnel_stack(cos, 1.0, &[film(1.0, 500.0)], 1.0, 550.0);
            assert!(light.reflectance() < 1e-20, "{cos}: {light:?}");
            assert!((light.transmittance() - 1.0).abs() < 1e-13);
        }
    }

    proptest! {
        #[test]
        fn no_light_is_lost(
            cos in 1e-4..1.0_f64,
            outside in 1.0..1.6_f64,
            films in prop::collection::vec((1.0..2.0_f64, 0.0..2000.0_f64), 0..6),
            substrate in 1.0..2.0_f64,
            wavelength in 380.0..780.0_f64,
        ) {
            let films: Vec<Film> = films.into_iter().map(|(n, d)| film(n, d)).collect();
            let light = fresnel_stack(cos, outside, &films, substrate, wavelength);
            // Rounding, enlarged where a film traps light between its evanescent neighbours.
            prop_assert!((light.reflected_s + light.transmitted_s - 1.0).abs() < 1e-9);
            prop_assert!((light.reflected_p + light.transmitted_p - 1.0).abs() < 1e-9);
            let thick = fresnel_stack_over_thick(
                cos, outside, &films, 1.337, &films, substrate, wavelength,
            );
            prop_assert!((thick.reflectance() + thick.transmittance() - 1.0).abs() < 1e-9);
        }

        #[test]
        fn nonsense_gives_a_fraction(
            cos in prop::num::f64::ANY,
            n in prop::num::f64::ANY,
            d in prop::num::f64::ANY,
            wavelength in prop::num::f64::ANY,
        ) {
            let films = [film(n, d), film(1.5, d)];
            for light in [
                fresnel_stack(cos, n, &films, 1.376, wavelength),
                fresnel_stack(cos, 1.0, &films, n, wavelength),
                fresnel_stack_over_thick(cos, 1.0, &films, n, &films, 1.376, wavelength),
            ] {
                for part in [light.reflected_s, light.reflected_p, light.transmitted_s, light.transmitted_p] {
                    prop_assert!((0.0..=1.0).contains(&part), "{light:?}");
                }
            }
        }
    }
}
