//! Blood: what haemoglobin takes of light, in vessels that are seen singly and in those that are not.
//!
//! In: saturation, columns of blood in mm, diameters of vessels. Out: absorption in mm⁻¹ at the
//! [`super::spectrum`]'s wavelengths, and what light is left, as linear sRGB.
//!
//! Molar extinction: S. Prahl's tabulation of data by Gratzer (London) and Kollias (Boston), Oregon
//! Medical Laser Center 1999, every fifth row; absorption of whole blood by his formula, 2.303 ε
//! (150 g/L)/(64,500 g/mol).

use super::spectrum::{SAMPLES, Spectrum};
use std::sync::LazyLock;

/// Haemoglobin in whole blood, g/L.
pub const HAEMOGLOBIN_G_PER_L: f64 = 150.0;
/// Its molar mass, g/mol.
pub const HAEMOGLOBIN_G_PER_MOL: f64 = 64_500.0;
/// Saturation of the blood of a conjunctiva, most of whose vessels are venules: between the 0.97 of
/// arteries and the 0.6 to 0.7 of veins.
pub const CONJUNCTIVAL_SATURATION: f64 = 0.8;

/// Molar extinction of oxygenated haemoglobin, cm⁻¹/M, at 380, 390 … 780 nm.
#[rustfmt::skip]
const OXYGENATED: Spectrum = [
    109564.0, 167748.0, 266232.0, 466840.0, 480360.0, 246072.0, 102580.0, 62816.0, 44480.0, 33209.2,
    26629.2, 23684.4, 20932.8, 20035.2, 24202.4, 39956.8, 53236.0, 43016.0, 32613.2, 44496.0,
    50104.0, 14400.8, 3200.0, 1506.0, 942.0, 610.0, 442.0, 368.0, 319.6, 294.0,
    277.6, 276.0, 290.0, 314.0, 348.0, 390.0, 446.0, 518.0, 586.0, 650.0,
    710.0,
];
/// The same without oxygen.
#[rustfmt::skip]
const DEOXYGENATED: Spectrum = [
    145232.0, 167780.0, 223296.0, 303956.0, 407560.0, 528600.0, 413280.0, 103292.0, 23388.8, 16156.4,
    14550.0, 16684.0, 20862.0, 25773.6, 31589.6, 39036.4, 46592.0, 53412.0, 53788.0, 45072.0,
    37020.0, 28324.4, 14677.2, 9443.6, 6509.6, 5148.8, 4345.2, 3750.12, 3226.56, 2795.12,
    2407.92, 2051.96, 1794.28, 1540.48, 1325.88, 1102.2, 1115.88, 1405.24, 1548.52, 1311.88,
    1075.44,
];

/// Absorption (mm⁻¹) of whole blood of this saturation, 0 to 1 (clamped; what is not a number counts
/// as [`CONJUNCTIVAL_SATURATION`]).
pub fn blood_absorption(saturation: f64) -> Spectrum {
    let share = if saturation.is_nan() {
        CONJUNCTIVAL_SATURATION
    } else {
        saturation.clamp(0.0, 1.0)
    };
    // ln 10, and a tenth from cm⁻¹ to mm⁻¹.
    let scale = core::f64::consts::LN_10 * HAEMOGLOBIN_G_PER_L / HAEMOGLOBIN_G_PER_MOL / 10.0;
    core::array::from_fn(|i| scale * (share * OXYGENATED[i] + (1.0 - share) * DEOXYGENATED[i]))
}

/// What is left of an absorption (mm⁻¹) where what absorbs is packed into vessels of this diameter
/// (mm) and light passes between them: (1 − e^−µd)/µd (van Veen, Verkruysse and Sterenborg 2002,
/// from Verkruysse et al. 1997), 1 where they are thin.
pub fn packed(absorption: f64, diameter_mm: f64) -> f64 {
    let depth = (absorption * diameter_mm).max(0.0);
    if depth < 1e-6 {
        return absorption * (1.0 - 0.5 * depth);
    }
    absorption * -(-depth).exp_m1() / depth
}

/// Diameter of the vessels of an iris, mm: between its capillaries and its radial arteries, 10 to 60 µm.
pub const IRIS_VESSEL_MM: f64 = 0.02;

/// Absorption (mm⁻¹) of blood in the vessels of an iris, for a volume of one.
pub fn iris_blood_absorption() -> &'static Spectrum {
    static ABSORPTION: LazyLock<Spectrum> = LazyLock::new(|| {
        blood_absorption(CONJUNCTIVAL_SATURATION).map(|whole| packed(whole, IRIS_VESSEL_MM))
    });
    &ABSORPTION
}

/// What a column of blood (mm, from 0) leaves of white light: linear sRGB by the whole spectrum, not
/// below 0.
pub fn blood_transmittance(column_mm: f64) -> [f64; 3] {
    let absorption = blood_absorption(CONJUNCTIVAL_SATURATION);
    let passed: Spectrum =
        core::array::from_fn(|i: usize| (-absorption[i] * column_mm.max(0.0)).exp());
    super::spectrum::spectrum_to_linear_srgb(&passed).map(|channel| channel.max(0.0))
}

const _: () = assert!(SAMPLES == 41);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::spectrum::{FIRST_NM, STEP_NM};

    fn at(spectrum: &Spectrum, nm: f64) -> f64 {
        spectrum[((nm - FIRST_NM) / STEP_NM).round() as usize]
    }

    #[test]
    fn absorption_is_prahls() {
        // By hand: 2.302585 · 53236 · 150/64500 = 285.07 cm⁻¹.
        let oxygenated = blood_absorption(1.0);
        assert!((at(&oxygenated, 540.0) - 28.507).abs() < 1e-3);
        assert!((at(&oxygenated, 660.0) - 0.17114).abs() < 1e-4);
        // 2.302585 · 3226.56 · 150/64500 = 17.278 cm⁻¹.
        assert!((at(&blood_absorption(0.0), 660.0) - 1.7278).abs() < 1e-3);
        // Both absorb alike at 390, 452, 500 … nm: an isosbestic point.
        let (a, b) = (at(&oxygenated, 390.0), at(&blood_absorption(0.0), 390.0));
        assert!((a / b - 1.0).abs() < 1e-3);
        assert_eq!(
            blood_absorption(f64::NAN),
            blood_absorption(CONJUNCTIVAL_SATURATION)
        );
    }

    #[test]
    fn packing_saves_light_where_it_is_taken_most() {
        assert!((packed(28.5, 0.01) / 28.5 - 0.8701).abs() < 1e-3);
        assert!(packed(257.0, 0.02) / 257.0 < 0.2);
        assert!((packed(3.0, 0.0) - 3.0).abs() < 1e-15);
        // Both forms meet.
        let (a, b) = (packed(1.0, 0.99e-6), packed(1.0, 1.01e-6));
        assert!((a - b).abs() < 1e-7);
    }

    #[test]
    fn a_column_of_blood_reddens() {
        let [red, green, blue] = blood_transmittance(0.05);
        assert!(
            red > 0.8 && green < 0.45 && blue < green,
            "{red} {green} {blue}"
        );
        assert_eq!(
            blood_transmittance(0.0).map(|c| (c * 1e9).round()),
            [1e9; 3]
        );
    }
}
