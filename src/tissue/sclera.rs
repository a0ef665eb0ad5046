//! The white of an eye as layers: conjunctiva and episclera with their blood, sclera, the dark
//! uvea behind.
//!
//! In: thicknesses, share of blood, yellow pigments. Out: diffuse reflectance as linear sRGB, by
//! [`super::many_flux`] at all 41 wavelengths, as it leaves through the wet surface.
//!
//! **Coefficients.** Reduced scattering of sclera falls as a power of the wavelength through 14 mm⁻¹
//! at 442 nm and 7 at 804: what random walks need through 0.6 mm of index 1.37 to pass the 6 and 35 %
//! that are measured, with an absorption of 0.4 mm⁻¹ at 442 nm (REFERENCE, marked provisional there:
//! Tuchin's and Vogel's tables were not found in the open). That absorption is three times that of
//! bloodless skin (equation 12 of François et al. 2007), and is given its spectrum. The covering
//! scatters as Jacques' "other fibrous tissue" (2013). Blood lies in vessels too thin to be seen;
//! [`super::blood::packed`] says what their packing saves.

use super::blood::{CONJUNCTIVAL_SATURATION, blood_absorption, packed};
use super::layers::Layer;
use super::many_flux::LayerFlux;
use super::melanin::{baseline_absorption, eumelanin_absorption};
use super::phase::PhaseMix;
use super::spectrum::{FIRST_NM, SAMPLES, STEP_NM, Spectrum, spectrum_to_linear_srgb};

/// Index of scleral tissue.
pub const SCLERA_INDEX: f64 = 1.37;
/// Thickness of conjunctiva and episclera together, mm, the mean of its four sides (Teeuw, 107 people,
/// REFERENCE-face).
pub const COVERING_MM: f64 = 0.21;
/// What the uvea sends back of the light that has passed the sclera: it is nearly black.
const UVEA_REFLECTANCE: f64 = 0.05;
/// Diameter of the vessels that are not seen singly, mm: conjunctival ones near the limbus measure
/// 0.012 to 0.013 (REFERENCE-face).
const CAPILLARY_MM: f64 = 0.0125;
/// Sclera absorbs this many times what bloodless skin does at any wavelength.
const ABSORPTION_OVER_SKIN: f64 = 3.0;
/// Nodes in each hemisphere: 3e-4 of error.
const NODES: usize = 4;

/// Molar extinction of bilirubin bound to albumin, cm⁻¹/M: 48,000 at its peak at 460 nm, a bell.
fn bilirubin_extinction(nm: f64) -> f64 {
    48_000.0 * (-0.5 * ((nm - 460.0) / 32.0).powi(2)).exp()
}
/// Molar mass of bilirubin, g/mol.
const BILIRUBIN_G_PER_MOL: f64 = 584.7;
/// Share of the serum's concentration that connective tissue holds: albumin fills its interstitial
/// fluid half as densely, which is two fifths of its volume.
const BILIRUBIN_IN_TISSUE: f64 = 0.2;

/// Reduced scattering (mm⁻¹) of sclera.
pub fn sclera_scattering(nm: f64) -> f64 {
    // ln(7/14)/ln(804/442).
    14.0 * (nm / 442.0).powf(-1.1585)
}

/// Reduced scattering (mm⁻¹) of conjunctiva and episclera.
pub fn covering_scattering(nm: f64) -> f64 {
    2.71 * (nm / 500.0).powf(-1.627)
}

/// One place of the white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScleralTissue {
    /// Thickness of the sclera, mm, 0 to 2.
    pub sclera_mm: f64,
    /// Thickness of what covers it, mm, 0 to 5.
    pub covering_mm: f64,
    /// Share of the covering's volume that is blood in vessels not seen singly, 0 to 1.
    pub blood_share: f64,
    /// Yellow pigment of sclera and covering: times their usual absorption, 0 to 20.
    pub yellowing: f64,
    /// Bilirubin in the serum, mg/dL, 0 to 50.
    pub bilirubin_mg_dl: f64,
}

impl Default for ScleralTissue {
    fn default() -> Self {
        Self {
            sclera_mm: 0.53,
            covering_mm: COVERING_MM,
            blood_share: 0.009,
            yellowing: 1.0,
            bilirubin_mg_dl: 0.6,
        }
    }
}

fn bounded(value: f64, high: f64) -> f64 {
    if value.is_nan() {
        0.0
    } else {
        value.clamp(0.0, high)
    }
}

fn wavelength(index: usize) -> f64 {
    FIRST_NM + STEP_NM * index as f64
}

fn bilirubin_absorption(nm: f64, mg_dl: f64) -> f64 {
    let molar = bounded(mg_dl, 50.0) * 0.01 / BILIRUBIN_G_PER_MOL;
    core::f64::consts::LN_10 / 10.0 * bilirubin_extinction(nm) * molar * BILIRUBIN_IN_TISSUE
}

fn layer(absorption: f64, scattering: f64, thickness_mm: f64) -> LayerFlux<NODES> {
    LayerFlux::new(&Layer {
        absorption,
        scattering,
        thickness_mm,
        phase: PhaseMix::ISOTROPIC,
    })
}

fn sclera_layer(index: usize, tissue: &ScleralTissue) -> LayerFlux<NODES> {
    let nm = wavelength(index);
    let own = ABSORPTION_OVER_SKIN * bounded(tissue.yellowing, 20.0) * baseline_absorption(nm);
    layer(
        own + bilirubin_absorption(nm, tissue.bilirubin_mg_dl),
        sclera_scattering(nm),
        bounded(tissue.sclera_mm, 2.0),
    )
}

fn covering_layer(index: usize, blood: f64, tissue: &ScleralTissue) -> LayerFlux<NODES> {
    let nm = wavelength(index);
    let share = bounded(tissue.blood_share, 1.0);
    let own = bounded(tissue.yellowing, 20.0) * baseline_absorption(nm)
        + bilirubin_absorption(nm, tissue.bilirubin_mg_dl);
    layer(
        (1.0 - share) * own + share * packed(blood, CAPILLARY_MM),
        covering_scattering(nm),
        bounded(tissue.covering_mm, 5.0),
    )
}

/// Light that a body of this diffuse reflectance sends out through its surface, which lets `entering`
/// of what falls on it in and sends `returned` of what comes up back down.
fn through_surface(reflectance: f64, [entering, returned]: [f64; 2]) -> f64 {
    entering * (1.0 - returned) * reflectance / (1.0 - returned * reflectance)
}

/// Diffuse reflectance (linear sRGB) of a place of the white. `surface` is what its wet surface lets in of diffuse
/// light and what it sends back down: [`crate::optics::fresnel::diffuse_surface`] of [`SCLERA_INDEX`].
pub fn sclera_reflectance(tissue: &ScleralTissue, surface: [f64; 2]) -> [f64; 3] {
    let blood = blood_absorption(CONJUNCTIVAL_SATURATION);
    let spectrum: Spectrum = core::array::from_fn(|i| {
        let below = sclera_layer(i, tissue);
        over_uvea(&covering_layer(i, blood[i], tissue), &below, surface)
    });
    spectrum_to_linear_srgb(&spectrum).map(|channel| channel.clamp(0.0, 1.0))
}

/// Thickness of the epithelium of conjunctiva, mm (REFERENCE-face).
const EPITHELIUM_MM: f64 = 0.044;

/// What the epithelium of conjunctiva and lid margins leaves of diffuse light that crosses it twice, linear sRGB, where melanosomes
/// take this share of its volume (0 to 1): diffuse light goes twice as far as its layer is thick.
pub fn epithelium_passes(melanin_share: f64) -> [f64; 3] {
    let share = bounded(melanin_share, 1.0);
    let spectrum: Spectrum = core::array::from_fn(|i| {
        (-4.0 * EPITHELIUM_MM * share * eumelanin_absorption(wavelength(i))).exp()
    });
    spectrum_to_linear_srgb(&spectrum).map(|channel| channel.clamp(0.0, 1.0))
}

/// The stack's reflectance; what the uvea returns passes both layers twice.
fn over_uvea(above: &LayerFlux<NODES>, below: &LayerFlux<NODES>, surface: [f64; 2]) -> f64 {
    let (reflected, passed) = (
        above.reflectance_over(below),
        above.transmittance_over(below),
    );
    let returned = below.reflectance();
    let uvea = passed * passed * UVEA_REFLECTANCE / (1.0 - returned * UVEA_REFLECTANCE);
    through_surface((reflected + uvea).min(1.0), surface)
}

/// Share (linear sRGB) of what the white sends back that has not been deeper than `depth_mm` of
/// the covering: a vessel there cannot dim it.
pub fn returned_above(tissue: &ScleralTissue, depth_mm: f64, surface: [f64; 2]) -> [f64; 3] {
    let whole = sclera_reflectance(tissue, surface);
    let blood = blood_absorption(CONJUNCTIVAL_SATURATION);
    let thin = ScleralTissue {
        covering_mm: depth_mm,
        ..*tissue
    };
    let above: Spectrum = core::array::from_fn(|i| {
        let layer = covering_layer(i, blood[i], &thin);
        // The surface sends light back down below the vessel as often as above it: its loss is
        // that of the whole.
        surface[0] * (1.0 - surface[1]) * layer.reflectance()
    });
    let above = spectrum_to_linear_srgb(&above);
    core::array::from_fn(|c| (above[c] / whole[c].max(1e-6)).clamp(0.0, 1.0))
}

/// Knots of [`lamellae`].
pub const LAMELLAE: usize = 8;

/// Lamellae of the sclera over nothing that sends light back, as they end over the clear cornea and the chamber behind it: at
/// [`LAMELLAE`] thicknesses, of which `tissue` has the last and the others the squares of even steps, what they send back of diffuse
/// light through the wet surface, and what they pass of it, linear sRGB. The covering and its blood end before them.
pub fn lamellae(tissue: &ScleralTissue, surface: [f64; 2]) -> [[[f64; 3]; 2]; LAMELLAE] {
    core::array::from_fn(|knot| {
        let share = knot as f64 / (LAMELLAE - 1) as f64;
        let thin = ScleralTissue {
            sclera_mm: bounded(tissue.sclera_mm, 2.0) * share * share,
            ..*tissue
        };
        let layers: [LayerFlux<NODES>; SAMPLES] = core::array::from_fn(|i| sclera_layer(i, &thin));
        let color = |of: &dyn Fn(&LayerFlux<NODES>) -> f64| {
            let spectrum: Spectrum = core::array::from_fn(|i| of(&layers[i]));
            spectrum_to_linear_srgb(&spectrum).map(|channel| channel.clamp(0.0, 1.0))
        };
        [
            color(&|layer| through_surface(layer.reflectance(), surface)),
            color(&|layer| layer.transmittance()),
        ]
    })
}

/// Knots of a [`ScleraTable`]: thickness of the sclera, mm.
const THICKNESSES: [f64; 7] = [0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8];
/// Share of blood: squares of even steps, to 0.09.
const BLOODS: usize = 10;
const BLOOD_STEP: f64 = 1.0 / 30.0;
/// Yellowing.
const YELLOWS: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];

/// [`sclera_reflectance`] over thickness, blood and yellowing at one concentration of bilirubin under the
/// usual covering, for maps: linear in between, constant beyond.
#[derive(Clone, Debug)]
pub struct ScleraTable {
    rgb: Vec<[f64; 3]>,
}

impl ScleraTable {
    /// Computes it: a few hundred colours.
    pub fn new(bilirubin_mg_dl: f64, surface: [f64; 2]) -> Self {
        let blood = blood_absorption(CONJUNCTIVAL_SATURATION);
        let mut sums = vec![[0.0; SAMPLES]; THICKNESSES.len() * BLOODS * YELLOWS.len()];
        for (i, blood) in blood.iter().enumerate() {
            let of = |sclera_mm: f64, yellowing: f64, blood_share: f64| ScleralTissue {
                sclera_mm,
                yellowing,
                blood_share,
                bilirubin_mg_dl,
                ..ScleralTissue::default()
            };
            for (y, yellow) in YELLOWS.into_iter().enumerate() {
                let above: Vec<_> = (0..BLOODS)
                    .map(|k| (k as f64 * BLOOD_STEP).powi(2))
                    .map(|share| covering_layer(i, *blood, &of(0.0, yellow, share)))
                    .collect();
                for (t, thickness) in THICKNESSES.into_iter().enumerate() {
                    let below = sclera_layer(i, &of(thickness, yellow, 0.0));
                    let row = (t * YELLOWS.len() + y) * BLOODS;
                    for (b, above) in above.iter().enumerate() {
                        sums[row + b][i] = over_uvea(above, &below, surface);
                    }
                }
            }
        }
        let rgb = sums
            .iter()
            .map(|s| spectrum_to_linear_srgb(s).map(|c| c.clamp(0.0, 1.0)));
        Self { rgb: rgb.collect() }
    }

    /// Linear sRGB of a place; its covering and bilirubin are the table's.
    pub fn sample(&self, tissue: &ScleralTissue) -> [f64; 3] {
        let (t, ft) = knot(&THICKNESSES, tissue.sclera_mm);
        let (y, fy) = knot(&YELLOWS, tissue.yellowing);
        let root = (bounded(tissue.blood_share, 1.0).sqrt() / BLOOD_STEP).min((BLOODS - 1) as f64);
        let b = (root as usize).min(BLOODS - 2);
        // Linear in the share, not in its root.
        let square = |k: usize| (k * k) as f64;
        let fb = (root * root - square(b)) / (square(b + 1) - square(b));
        let at = |t: usize, y: usize, b: usize| self.rgb[(t * YELLOWS.len() + y) * BLOODS + b];
        core::array::from_fn(|c| {
            let along = |t: usize, y: usize| mixed(at(t, y, b)[c], at(t, y, b + 1)[c], fb);
            let across = |t: usize| mixed(along(t, y), along(t, y + 1), fy);
            mixed(across(t), across(t + 1), ft)
        })
    }
}

fn mixed(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The knot before a value, and the share of the way to the next.
fn knot(knots: &[f64], value: f64) -> (usize, f64) {
    let value = bounded(value, f64::MAX);
    let after = knots.iter().position(|k| value < *k).unwrap_or(knots.len());
    let before = after.saturating_sub(1).min(knots.len() - 2);
    let share = (value - knots[before]) / (knots[before + 1] - knots[before]);
    (before, share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel::diffuse_surface;
    use crate::tissue::many_flux::stack_many_flux;
    use crate::tissue::random_walk::{Illumination, random_walk};

    fn surface() -> [f64; 2] {
        diffuse_surface(SCLERA_INDEX)
    }

    #[test]
    fn sclera_passes_what_was_measured() {
        // 6 % at 442 nm and 35 % at 804 of perpendicular light through 0.6 mm, both faces of index 1.37 in air. A beam's
        // walks once through, then diffuse light up and down between the faces. The reference's coefficients were given
        // to a digit: a tenth of each.
        for (nm, absorption, measured) in [(442.0, 0.4, 0.06), (804.0, 0.02, 0.35)] {
            let layer = Layer {
                absorption,
                scattering: sclera_scattering(nm),
                thickness_mm: 0.6,
                phase: PhaseMix::ISOTROPIC,
            };
            let first = random_walk(&[layer], Illumination::Beam(1.0), 200_000, 3);
            let (r0, t0) = (first.reflectance.mean, first.transmittance.mean);
            let alone = stack_many_flux::<8>(&[layer]);
            let (r, t, b) = (alone.reflectance, alone.transmittance, surface()[1]);
            // Light that leaves the tissue at the front (u) and at the back (d): u = r0 + b (r u + t d) …
            let whole = (1.0 - b * r).powi(2) - (b * t).powi(2);
            let back = (t0 * (1.0 - b * r) + b * t * r0) / whole;
            let entering = 1.0 - (0.37_f64 / 2.37).powi(2);
            let passed = entering * (1.0 - b) * back;
            assert!((passed / measured - 1.0).abs() < 0.1, "{nm}: {passed}");
        }
    }

    #[test]
    fn thin_lamellae_are_a_bluish_haze_and_thick_ones_the_white() {
        let tissue = ScleralTissue::default();
        let knots = lamellae(&tissue, surface());
        // Nothing is clear, and loses what the 41 wavelengths' weights miss of one.
        assert_eq!(knots[0][0], [0.0; 3]);
        assert!(knots[0][1].iter().all(|passed| *passed > 0.999));
        for pair in knots.windows(2) {
            assert!((0..3).all(|c| pair[1][0][c] > pair[0][0][c] && pair[1][1][c] < pair[0][1][c]));
        }
        // What is thin scatters blue before red, what is thick both.
        let blueness = |[reflected, _]: &[[f64; 3]; 2]| reflected[2] / reflected[0];
        assert!(blueness(&knots[1]) > 1.3 && blueness(&knots[LAMELLAE - 1]) < 1.0);
        // A hundredth of the thickness: one scattering, half of it back.
        let [reflected, _] = knots[1];
        let depth = sclera_scattering(550.0) * tissue.sclera_mm / 49.0;
        let once = surface()[0] * (1.0 - surface()[1]) * depth;
        assert!(
            (0.5..1.0).contains(&(reflected[1] / once)),
            "{reflected:?} {once}"
        );
    }

    #[test]
    fn a_quiet_eye_is_warm_and_light() {
        let [r, g, b] = sclera_reflectance(&ScleralTissue::default(), surface());
        // Photographs: 202 186 169 as sRGB, 1 : 0.83 : 0.67; neutral ones from 1 : 0.9 : 0.8.
        assert!(r > g && g > b && r < 1.3 * g && b > 0.6 * r, "{r} {g} {b}");
        assert!((0.35..0.7).contains(&g));
    }

    #[test]
    fn each_quantity_changes_what_it_should() {
        let of = |change: fn(&mut ScleralTissue)| {
            let mut tissue = ScleralTissue::default();
            change(&mut tissue);
            sclera_reflectance(&tissue, surface())
        };
        let usual = of(|_| {});
        let blue = |c: [f64; 3]| c[2] / c[0];
        let thin = of(|t| t.sclera_mm = 0.25);
        assert!(
            thin[1] < usual[1] && blue(thin) > blue(usual),
            "the uvea shows through"
        );
        let red = of(|t| t.blood_share = 0.03);
        assert!(red[1] / red[0] < 0.85 * usual[1] / usual[0]);
        let old = of(|t| t.yellowing = 3.0);
        assert!(blue(old) < 0.95 * blue(usual));
        let jaundice = of(|t| t.bilirubin_mg_dl = 10.0);
        assert!(blue(jaundice) < 0.75 * blue(usual));
        // It takes blue light, and next to nothing of red.
        assert!((jaundice[0] / usual[0] - 1.0).abs() < 0.1);
    }

    #[test]
    fn the_table_is_the_function() {
        let table = ScleraTable::new(0.6, surface());
        let mut worst: f64 = 0.0;
        for k in 0..60 {
            let u = |p: f64| (k as f64 * p).fract();
            let tissue = ScleralTissue {
                sclera_mm: 0.06 + 0.7 * u(0.618),
                blood_share: 0.08 * u(0.414).powi(2),
                yellowing: 0.5 + 4.0 * u(0.732),
                ..ScleralTissue::default()
            };
            let (a, b) = (
                table.sample(&tissue),
                sclera_reflectance(&tissue, surface()),
            );
            for c in 0..3 {
                worst = worst.max((a[c] - b[c]).abs());
            }
        }
        assert!(worst < 0.01, "{worst}");
        let far = ScleralTissue {
            sclera_mm: 9.0,
            blood_share: 1.0,
            yellowing: f64::NAN,
            ..ScleralTissue::default()
        };
        assert!(table.sample(&far).iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn blue_light_returns_from_above_a_deep_vessel() {
        let [red, _, blue] = returned_above(&ScleralTissue::default(), 0.1, surface());
        assert!(blue > 1.2 * red && blue < 0.6, "{red} {blue}");
        assert_eq!(
            returned_above(&ScleralTissue::default(), 0.0, surface()),
            [0.0; 3]
        );
    }
}
