//! The published eyes.

use super::dispersion::OcularMedium::{Aqueous, Cornea, Lens, Vitreous};
use super::dispersion::dispersed;
use super::{GREEN_NM, PHOTOPIC_NM, Row, SODIUM_NM, SchematicEye, gradient, uniform};
use crate::optics::ray_trace::IndexField;
use crate::optics::surface::Quadric;

/// Accommodations are taken from 0 to this (D): Navarro's formulas hold to 10 D.
const MOST_ACCOMMODATION_D: f64 = 10.0;
/// Refractions are taken from minus this to this (D).
const MOST_REFRACTION_D: f64 = 20.0;

fn limited(value: f64, low: f64, high: f64) -> f64 {
    if value.is_nan() {
        0.0
    } else {
        value.clamp(low, high)
    }
}

/// The retina of Escudero-Sanz & Navarro.
fn round_retina() -> Quadric {
    Quadric::conicoid(-12.0, 1.0)
}

impl SchematicEye {
    /// Navarro, Santamaría & Bescós 1985 (J. Opt. Soc. Am. A 2, 1273), accommodated by
    /// `accommodation_d` (0 to 10 D; anything else is taken to the nearer end, NaN to 0).
    ///
    /// The eye keeps its length: what the lens and the anterior chamber change by, the vitreous
    /// takes up. The retina is Escudero-Sanz & Navarro's, whom the 1985 eye leaves without one.
    pub fn navarro(accommodation_d: f64, wavelength_nm: f64) -> Self {
        let a = limited(accommodation_d, 0.0, MOST_ACCOMMODATION_D);
        let log = a.ln_1p();
        let chamber = 3.05 - 0.05 * log;
        let lens = 4.0 + 0.1 * log;
        let n = |medium, index| dispersed(medium, index, SODIUM_NM, wavelength_nm);
        let lens_index = n(Lens, 1.42) + 9e-5 * a * (10.0 + a);
        let vitreous = 16.403_98 - 0.05 * log;
        Self::from_rows(
            &[
                Row(7.72, 0.74, 0.55, uniform(n(Cornea, 1.376))),
                Row(6.5, 1.0, chamber, uniform(n(Aqueous, 1.3374))),
                Row(
                    10.2 - 1.75 * log,
                    1.0 - 3.1316 - 0.34 * log,
                    lens,
                    uniform(lens_index),
                ),
                Row(
                    -6.0 + 0.2294 * log,
                    -0.125 * log,
                    vitreous,
                    uniform(n(Vitreous, 1.336)),
                ),
            ],
            2,
            round_retina(),
        )
    }

    /// Escudero-Sanz & Navarro 1999 (J. Opt. Soc. Am. A 16, 1881): the relaxed eye above with a
    /// spherical retina and its vitreous set for 543 nm, where it has the four decimals that the
    /// paper prints.
    pub fn escudero_navarro(wavelength_nm: f64) -> Self {
        let n = |medium, index| uniform(dispersed(medium, index, GREEN_NM, wavelength_nm));
        Self::from_rows(
            &[
                Row(7.72, 0.74, 0.55, n(Cornea, 1.3777)),
                Row(6.5, 1.0, 3.05, n(Aqueous, 1.3391)),
                Row(10.2, 1.0 - 3.1316, 4.0, n(Lens, 1.4222)),
                Row(-6.0, 0.0, 16.3203, n(Vitreous, 1.3377)),
            ],
            2,
            round_retina(),
        )
    }

    /// Le Grand's full theoretical eye (Le Grand & El Hage 1980, Physiological Optics), relaxed.
    pub fn le_grand(wavelength_nm: f64) -> Self {
        Self::le_grand_with([3.05, 10.2, 4.0, 1.42, -6.0], 16.596_55, wavelength_nm)
    }

    /// Le Grand's eye accommodated: lens thicker, rounder, of higher index and further forward. The
    /// retina stays where the relaxed eye has it.
    pub fn le_grand_accommodated(wavelength_nm: f64) -> Self {
        Self::le_grand_with([2.65, 6.0, 4.5, 1.427, -5.5], 16.496_55, wavelength_nm)
    }

    fn le_grand_with(
        [chamber, lens_front, lens_thickness, lens_index, lens_back]: [f64; 5],
        vitreous: f64,
        wavelength_nm: f64,
    ) -> Self {
        let n = |medium, index| uniform(dispersed(medium, index, SODIUM_NM, wavelength_nm));
        Self::from_rows(
            &[
                Row(7.8, 1.0, 0.55, n(Cornea, 1.3771)),
                Row(6.5, 1.0, chamber, n(Aqueous, 1.3374)),
                Row(lens_front, 1.0, lens_thickness, n(Lens, lens_index)),
                Row(lens_back, 1.0, vitreous, n(Vitreous, 1.336)),
            ],
            2,
            Quadric::conicoid(-13.4, 1.0),
        )
    }

    /// Gullstrand's exact (No. 1) eye, relaxed (appendix to Helmholtz's Physiological Optics, 3rd ed.
    /// 1909): a lens of core and cortex. Its fovea lies 24.0 mm deep, which leaves it hyperopic by
    /// 1 D, as Gullstrand says.
    pub fn gullstrand(wavelength_nm: f64) -> Self {
        Self::gullstrand_with(
            [3.1, 10.0, 0.546, 7.911, 2.419, -5.76, 0.635, -6.0],
            wavelength_nm,
        )
    }

    /// Gullstrand's exact eye at his maximum accommodation: near point 102.3 mm in front of the cornea.
    pub fn gullstrand_accommodated(wavelength_nm: f64) -> Self {
        Self::gullstrand_with(
            [2.7, 5.333, 0.6725, 2.655, 2.655, -2.655, 0.6725, -5.333],
            wavelength_nm,
        )
    }

    fn gullstrand_with(
        [chamber, r3, cortex, r4, core, r5, back_cortex, r6]: [f64; 8],
        wavelength_nm: f64,
    ) -> Self {
        let n = |medium, index| uniform(dispersed(medium, index, SODIUM_NM, wavelength_nm));
        let (cortex_index, core_index) = (n(Lens, 1.386), n(Lens, 1.406));
        let lens_back = 0.5 + chamber + cortex + core + back_cortex;
        Self::from_rows(
            &[
                Row(7.7, 1.0, 0.5, n(Cornea, 1.376)),
                Row(6.8, 1.0, chamber, n(Aqueous, 1.336)),
                Row(r3, 1.0, cortex, cortex_index),
                Row(r4, 1.0, core, core_index),
                Row(r5, 1.0, back_cortex, cortex_index),
                Row(r6, 1.0, 24.0 - lens_back, n(Vitreous, 1.336)),
            ],
            2,
            Quadric::conicoid(-12.0, 1.0),
        )
    }

    /// Liou & Brennan 1997 (J. Opt. Soc. Am. A 14, 1684): gradient-index lens, traced as such. The
    /// paper moves the pupil 0.5 mm nasally; it is centred here
    /// ([`Placed::decentred`](crate::optics::surface::Placed::decentred) moves it).
    ///
    /// Dispersion is the paper's: `n(λ) = n(555) + 0.0512 − 0.1455 λ + 0.0961 λ²`, λ in µm, for all
    /// media (380 to 750 nm): that of water, which gives the eye half the measured longitudinal
    /// chromatic aberration.
    pub fn liou_brennan(wavelength_nm: f64) -> Self {
        let micrometres = 1e-3 * limited(wavelength_nm, 380.0, 750.0);
        let shift = if wavelength_nm == PHOTOPIC_NM || wavelength_nm.is_nan() {
            0.0
        } else {
            0.0512 + micrometres * (-0.1455 + micrometres * 0.0961)
        };
        let radial = -0.001_978;
        Self::from_rows(
            &[
                Row(7.77, 1.0 - 0.18, 0.50, uniform(1.376 + shift)),
                Row(6.40, 1.0 - 0.60, 3.16, uniform(1.336 + shift)),
                Row(
                    12.40,
                    1.0 - 0.94,
                    1.59,
                    gradient([1.368 + shift, 0.049_057, -0.015_427], radial),
                ),
                Row(
                    f64::INFINITY,
                    1.0,
                    2.43,
                    gradient([1.407 + shift, 0.0, -0.006_605], radial),
                ),
                Row(-8.10, 1.0 + 0.96, 16.27, uniform(1.336 + shift)),
            ],
            2,
            round_retina(),
        )
    }

    /// Atchison 2006 (Vision Res. 46, 2236), the centred eye for a spectacle refraction of
    /// `refraction_d` (made for 0 to −10 D; taken from −20 to 20 D, NaN as 0): gradient-index lens,
    /// traced as such; cornea, vitreous and retina grow with myopia. 555 nm.
    ///
    /// The retina is printed with one asphericity a meridian; they agree on the depth of the
    /// ellipsoid to 0.1 % in the emmetrope, so that their mean makes it one triaxial quadric. Away
    /// from 555 nm the gradient moves as a whole, by the dispersion of a lens of its mean index.
    pub fn atchison(refraction_d: f64, wavelength_nm: f64) -> Self {
        let sr = limited(refraction_d, -MOST_REFRACTION_D, MOST_REFRACTION_D);
        let n = |medium, index| dispersed(medium, index, PHOTOPIC_NM, wavelength_nm);
        let shift = n(Lens, 1.4) - 1.4;
        let radial = -0.002_039_9;
        let lens = |axial: [f64; 3]| -> IndexField {
            gradient([axial[0] + shift, axial[1], axial[2]], radial)
        };
        let (rx, ry) = (-12.91 - 0.094 * sr, -12.72 + 0.004 * sr);
        let (px, py) = (1.27 + 0.026 * sr, 1.25 + 0.017 * sr);
        let mut retina = Quadric::toric(rx, ry, 1.0);
        retina.curvature.z = 0.5 * (px / rx + py / ry);
        Self::from_rows(
            &[
                Row(
                    7.77 + 0.022 * sr,
                    1.0 - 0.15,
                    0.55,
                    uniform(n(Cornea, 1.376)),
                ),
                Row(6.40, 1.0 - 0.275, 3.15, uniform(n(Aqueous, 1.3374))),
                Row(
                    11.48,
                    1.0 - 5.0,
                    1.44,
                    lens([1.371, 0.065_277_8, -0.022_665_9]),
                ),
                Row(f64::INFINITY, 1.0, 2.16, lens([1.418, 0.0, -0.010_073_7])),
                Row(
                    -5.90,
                    1.0 - 2.0,
                    16.28 - 0.299 * sr,
                    uniform(n(Vitreous, 1.336)),
                ),
            ],
            2,
            retina,
        )
    }

    /// François et al. 2007: one conicoid, R = 7.8 mm and p = 0.75, with one index behind it (1.376
    /// as printed; 1.336 stands in for a real cornea and aqueous). The paper has neither lens nor
    /// retina: the iris plane is the stop, and the retina is put at the paraxial focus.
    pub fn francois(index: f64) -> Self {
        let focus = index * 7.8 / (index - 1.0);
        let mut eye = Self::from_rows(
            &[Row(7.8, 0.75, focus, uniform(index))],
            usize::MAX,
            round_retina(),
        );
        eye.interfaces
            .push(crate::optics::ray_trace::Interface::uniform(
                crate::optics::surface::Placed::at(Quadric::PLANE, 3.6),
                index,
                index,
            ));
        eye.stop = 1;
        eye
    }
}
