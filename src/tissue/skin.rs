//! Skin as layers: epidermis with its melanin, dermis with its plexuses of blood, and what lies below:
//! fat in the face, the orbicularis muscle in a lid.
//!
//! In: shares of melanosomes and of blood, thicknesses. Out: diffuse reflectance as linear sRGB, by
//! [`super::many_flux`] at all 41 wavelengths, as it leaves through the surface.
//!
//! **Coefficients** (REFERENCE-face, "Skin"). Absorption without pigment and of melanosomes: Jacques 1998, in
//! [`super::melanin`]; reduced scattering of epidermis and dermis, of fat and of muscle ("other soft tissues"):
//! Jacques 2013. Layers and how the blood is shared out among them: 0.06 mm of epidermis with the horny layer,
//! papillary dermis 0.18, upper plexus 0.09, reticular dermis 1.5 and deep plexus 0.1 mm, which hold blood as
//! 5 : 20 : 4 : 10. How much of it there is in all is not agreed on (0.2 to 5 % of the dermis): [`FACE_BLOOD`] gives
//! light skin of a face an a* of 12. With all of it such skin is a fifth darker than skin that is photographed, so the
//! picture takes from here how one place differs from another ([`SkinVariation`]), and not the mean.

use super::blood::{blood_absorption, packed};
use super::layers::Layer;
use super::many_flux::stack_many_flux;
use super::melanin::{baseline_absorption, eumelanin_absorption};
use super::phase::PhaseMix;
use super::spectrum::{FIRST_NM, STEP_NM, Spectrum, spectrum_to_linear_srgb};

/// Index of the epidermis (1.41 to 1.49; REFERENCE-face).
pub const SKIN_INDEX: f64 = 1.44;
/// Share of the volume of epidermis that melanosomes take in the lightest and in the darkest skin
/// (Jacques 1998).
pub const MELANIN_RANGE: (f64, f64) = (0.013, 0.43);
/// Blood in a face's dermis, share of its volume.
pub const FACE_BLOOD: f64 = 0.02;
/// How much more there is in a lid: with it, and its thickness, a lower lid differs from the cheek in L*, a* and b*
/// as in eight photographs (−7, +4.8, −3.9; REFERENCE).
const LID_BLOOD: f64 = 3.0;
/// Tone at which a lid is set against its face, for every tone: with as much melanin below each square millimetre of both,
/// what a lid sends back against the face is the same within 0.05 from tone 0 to 0.6.
const LID_TONE: f64 = 0.3;
/// Saturation of the blood of skin, most of which is in venules.
const SATURATION: f64 = 0.7;
/// Diameter of the vessels of the dermis, mm.
const VESSEL_MM: f64 = 0.03;
/// Blood, or what absorbs like it, in muscle (myoglobin has nearly the spectrum of haemoglobin).
const MUSCLE_BLOOD: f64 = 0.06;
/// Thickness of the dermis of a face, mm; its parts stand in the same proportion where it is thinner.
const FACE_DERMIS_MM: f64 = 1.87;
/// Parts of the dermis: share of its thickness, and its blood against the mean of all.
const DERMIS: [(f64, f64); 4] = [
    (0.18 / FACE_DERMIS_MM, 0.963),
    (0.09 / FACE_DERMIS_MM, 3.854),
    (1.5 / FACE_DERMIS_MM, 0.771),
    (0.1 / FACE_DERMIS_MM, 1.927),
];
/// Nodes in each hemisphere: 3e-4 of error.
const NODES: usize = 4;

/// One place of the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinTissue {
    /// Share of the epidermis's volume that is melanosomes, 0 to 1.
    pub melanin_share: f64,
    /// Share of the dermis's volume that is blood, 0 to 1.
    pub blood_share: f64,
    /// Thickness of the epidermis, mm, 0 to 1.
    pub epidermis_mm: f64,
    /// Thickness of the dermis, mm, 0 to 5.
    pub dermis_mm: f64,
    /// Thickness of the muscle right below it, mm, 0 to 5; of a face there is fat.
    pub muscle_mm: f64,
}

impl SkinTissue {
    /// Skin of a face from very light (tone 0) to very dark (1): the logarithm of its melanin goes with the square of
    /// the tone, so that lightness falls about evenly.
    pub fn face(tone: f64) -> Self {
        let tone = if tone.is_nan() {
            0.0
        } else {
            tone.clamp(0.0, 1.0)
        };
        let (least, most) = MELANIN_RANGE;
        Self {
            melanin_share: least * (most / least).powf(tone * tone),
            blood_share: FACE_BLOOD,
            epidermis_mm: 0.06,
            dermis_mm: FACE_DERMIS_MM,
            muscle_mm: 0.0,
        }
    }

    /// Skin of a lid of somebody light: thin over its muscle (0.32 mm near the lashes, a ninth of it epidermis;
    /// Hwang 2006).
    pub fn lid() -> Self {
        Self {
            epidermis_mm: 0.035,
            dermis_mm: 0.3,
            muscle_mm: 1.0,
            blood_share: LID_BLOOD * FACE_BLOOD,
            ..Self::face(LID_TONE)
        }
    }
}

/// Reduced scattering (mm⁻¹) of epidermis (Jacques 2013).
fn epidermis_scattering(nm: f64) -> f64 {
    let x = nm / 500.0;
    6.67 * (0.29 * x.powi(-4) + 0.71 * x.powf(-0.689))
}

/// The same of dermis.
fn dermis_scattering(nm: f64) -> f64 {
    let x = nm / 500.0;
    4.36 * (0.41 * x.powi(-4) + 0.59 * x.powf(-0.35))
}

/// The same of muscle.
fn muscle_scattering(nm: f64) -> f64 {
    1.89 * (nm / 500.0).powf(-1.286)
}

/// The same of fat.
fn fat_scattering(nm: f64) -> f64 {
    1.84 * (nm / 500.0).powf(-0.672)
}

fn bounded(value: f64, high: f64) -> f64 {
    if value.is_nan() {
        0.0
    } else {
        value.clamp(0.0, high)
    }
}

fn layer(absorption: f64, scattering: f64, thickness_mm: f64) -> Layer {
    Layer {
        absorption,
        scattering,
        thickness_mm,
        phase: PhaseMix::ISOTROPIC,
    }
}

/// Diffuse reflectance (linear sRGB) of a place of the skin. `surface` is what its surface lets in of diffuse light
/// and what it sends back down: [`crate::optics::fresnel::diffuse_surface`] of [`SKIN_INDEX`].
pub fn skin_reflectance(tissue: &SkinTissue, surface: [f64; 2]) -> [f64; 3] {
    let blood = blood_absorption(SATURATION);
    let melanin = bounded(tissue.melanin_share, 1.0);
    let share = bounded(tissue.blood_share, 1.0);
    let dermis_mm = bounded(tissue.dermis_mm, 5.0);
    let spectrum: Spectrum = core::array::from_fn(|i| {
        let nm = FIRST_NM + STEP_NM * i as f64;
        let base = baseline_absorption(nm);
        // A share of whole blood, in vessels.
        let with_blood = |share: f64, diameter_mm: f64| {
            (1.0 - share) * base + share * packed(blood[i], diameter_mm)
        };
        let part = |(thickness, of_mean): (f64, f64)| {
            let share = (share * of_mean).min(1.0);
            layer(
                with_blood(share, VESSEL_MM),
                dermis_scattering(nm),
                thickness * dermis_mm,
            )
        };
        let [papillary, upper, reticular, deep] = DERMIS.map(part);
        let below = stack_many_flux::<NODES>(&[
            layer(
                melanin * eumelanin_absorption(nm) + (1.0 - melanin) * base,
                epidermis_scattering(nm),
                bounded(tissue.epidermis_mm, 1.0),
            ),
            papillary,
            upper,
            reticular,
            deep,
            layer(
                with_blood(MUSCLE_BLOOD, 0.0),
                muscle_scattering(nm),
                bounded(tissue.muscle_mm, 5.0),
            ),
            layer(base, fat_scattering(nm), 5.0),
        ]);
        let [entering, returned] = surface;
        let reflected = below.reflectance;
        entering * (1.0 - returned) * reflected / (1.0 - returned * reflected)
    });
    spectrum_to_linear_srgb(&spectrum).map(|channel| channel.clamp(0.0, 1.0))
}

/// By which power of something of it the reflectance of skin falls, that times a quarter more and less, as blotches have.
fn power(surface: [f64; 2], changed: impl Fn(f64) -> SkinTissue) -> [f64; 3] {
    const STEP: f64 = 1.25;
    let [less, more] = [1.0 / STEP, STEP].map(|by| skin_reflectance(&changed(by), surface));
    core::array::from_fn(|c| (less[c].max(1e-9) / more[c].max(1e-9)).ln() / (2.0 * STEP.ln()))
}

/// How the colour of somebody's skin changes from place to place, against that of her face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinVariation {
    /// By which power of the blood reflectance falls: −∂ ln R/∂ ln blood, linear sRGB.
    pub blood: [f64; 3],
    /// The same of melanin.
    pub melanin: [f64; 3],
    /// Reflectance of a lid over that of the face.
    pub lid: [f64; 3],
}

impl SkinVariation {
    /// Of skin of this tone ([`SkinTissue::face`]); `surface` as of [`skin_reflectance`].
    pub fn new(tone: f64, surface: [f64; 2]) -> Self {
        let face = SkinTissue::face(tone);
        let blood = |by: f64| SkinTissue {
            blood_share: face.blood_share * by,
            ..face
        };
        let [usual, lid] = [SkinTissue::face(LID_TONE), SkinTissue::lid()]
            .map(|tissue| skin_reflectance(&tissue, surface));
        Self {
            blood: power(surface, blood),
            melanin: Self::melanin(tone, surface),
            lid: core::array::from_fn(|c| lid[c] / usual[c].max(1e-9)),
        }
    }

    /// [`Self::melanin`] of skin of this tone.
    pub fn melanin(tone: f64, surface: [f64; 2]) -> [f64; 3] {
        let face = SkinTissue::face(tone);
        power(surface, |by| SkinTissue {
            melanin_share: face.melanin_share * by,
            ..face
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel::diffuse_surface;
    use crate::tissue::colour_difference::linear_srgb_to_lab;
    use proptest::prelude::*;

    fn lab(tissue: &SkinTissue) -> [f64; 3] {
        linear_srgb_to_lab(skin_reflectance(tissue, diffuse_surface(SKIN_INDEX)))
    }

    #[test]
    fn the_parts_of_the_dermis_are_all_of_it_and_hold_all_its_blood() {
        let whole: f64 = DERMIS.iter().map(|(share, _)| share).sum();
        let blood: f64 = DERMIS.iter().map(|(share, blood)| share * blood).sum();
        assert!(
            (whole - 1.0).abs() < 1e-12 && (blood - 1.0).abs() < 1e-3,
            "{whole} {blood}"
        );
    }

    #[test]
    fn tones_go_from_very_light_to_dark() {
        // The individual typology angle, atan((L* − 50)/b*), of Chardon 1991: above 55° very light, below −30° dark.
        let angles = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|tone| {
            let [l, a, b] = lab(&SkinTissue::face(tone));
            println!("tone {tone}: {l:.1} {a:.1} {b:.1}");
            assert!(a > 4.0 && b > 4.0);
            ((l - 50.0) / b).atan().to_degrees()
        });
        assert!(
            angles.windows(2).all(|pair| pair[1] < pair[0]),
            "{angles:?}"
        );
        assert!(angles[0] > 41.0 && angles[5] < -30.0, "{angles:?}");
        // A face's a*, which hardly depends on its tone, is about 12.
        assert!((lab(&SkinTissue::face(0.3))[1] - 12.0).abs() < 1.0);
    }

    #[test]
    fn a_lid_differs_from_its_face_as_in_photographs() {
        let (face, lid) = (lab(&SkinTissue::face(LID_TONE)), lab(&SkinTissue::lid()));
        let off: [f64; 3] = core::array::from_fn(|i| lid[i] - face[i]);
        println!("lid against face: {off:.1?}");
        for (off, seen) in off.into_iter().zip([-7.0, 4.8, -3.9]) {
            assert!((off - seen).abs() < 1.5, "{off} {seen}");
        }
        // One with the blood of the face is not.
        let bloodless = lab(&SkinTissue {
            blood_share: FACE_BLOOD,
            ..SkinTissue::lid()
        });
        assert!(bloodless[1] - face[1] < 2.0);
    }

    #[test]
    fn a_lid_with_its_faces_melanin_differs_alike_at_every_tone() {
        let surface = diffuse_surface(SKIN_INDEX);
        let ratios = [0.0, 0.3, 0.6].map(|tone| {
            let face = SkinTissue::face(tone);
            let lid = SkinTissue {
                epidermis_mm: face.epidermis_mm,
                melanin_share: face.melanin_share,
                ..SkinTissue::lid()
            };
            let [lid, face] = [lid, face].map(|tissue| skin_reflectance(&tissue, surface));
            [0, 1, 2].map(|c| lid[c] / face[c])
        });
        println!("{ratios:.3?}");
        for ratio in ratios {
            assert!(
                (0..3).all(|c| (ratio[c] - ratios[1][c]).abs() < 0.051),
                "{ratios:?}"
            );
        }
    }

    #[test]
    fn powers_are_those_of_the_whole_model() {
        let surface = diffuse_surface(SKIN_INDEX);
        let variation = SkinVariation::new(0.3, surface);
        println!("{variation:.3?}");
        let face = SkinTissue::face(0.3);
        let own = skin_reflectance(&face, surface);
        let mut worst: f64 = 0.0;
        for (blood, melanin) in [
            (0.6, 1.0),
            (1.6, 1.0),
            (1.0, 0.6),
            (1.0, 1.6),
            (0.7, 1.5),
            (1.5, 1.5),
        ] {
            let changed = SkinTissue {
                blood_share: face.blood_share * blood,
                melanin_share: face.melanin_share * melanin,
                ..face
            };
            let there = linear_srgb_to_lab(skin_reflectance(&changed, surface));
            let about = linear_srgb_to_lab(core::array::from_fn(|c| {
                own[c]
                    * (-variation.blood[c] * blood.ln() - variation.melanin[c] * melanin.ln()).exp()
            }));
            for i in 0..3 {
                worst = worst.max((there[i] - about[i]).abs());
            }
        }
        // Up to 1.6 times more or less of either, which is more than blotches have: 0.59 of L*a*b*.
        println!("powers against the model: {worst:.2}");
        assert!(worst < 0.6, "{worst}");
    }

    proptest! {
        #[test]
        fn always_a_colour(
            melanin in prop::num::f64::ANY, blood in prop::num::f64::ANY, thick in prop::num::f64::ANY, tone in prop::num::f64::ANY,
        ) {
            let surface = diffuse_surface(SKIN_INDEX);
            let tissue = SkinTissue {
                melanin_share: melanin, blood_share: blood, epidermis_mm: thick, dermis_mm: thick, muscle_mm: thick,
            };
            prop_assert!(skin_reflectance(&tissue, surface).iter().all(|c| (0.0..=1.0).contains(c)));
            let variation = SkinVariation::new(tone, surface);
            // Of nearly black skin more blood may leave blue as it is, but for what a screen cannot show of it.
            for c in [variation.blood, variation.melanin, variation.lid].concat() {
                prop_assert!((-0.01..2.0).contains(&c), "{variation:?}");
            }
        }
    }
}
