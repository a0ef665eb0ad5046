//! How the media of a schematic eye disperse.
//!
//! In: a medium, a wavelength (nm). Out: an index.
//!
//! Navarro, Santamaría & Bescós 1985 (J. Opt. Soc. Am. A 2, 1273) give each medium's index at 365,
//! 486.1, 656.3 and 1014 nm and interpolate by Herzberger's formula,
//!
//! `n(λ) = Σ aᵢ(λ) nᵢ, aᵢ = Aᵢ + Bᵢ λ² + Pᵢ/(λ² − λ₀²) + Rᵢ/(λ² − λ₀²)²`,
//!
//! λ in µm and λ₀² = 0.028. The indices were adjusted there so that the eye has the measured
//! longitudinal chromatic aberration. Eyes quoted for one wavelength disperse in proportion: n − 1
//! scales as that of Navarro's medium. Valid from 365 to 1014 nm; other wavelengths are taken to the
//! nearer end, and what is not a number to 555 nm.

/// A transparent medium of the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OcularMedium {
    /// Cornea.
    Cornea,
    /// Aqueous humour.
    Aqueous,
    /// Crystalline lens, as one homogeneous body.
    Lens,
    /// Vitreous body.
    Vitreous,
}

/// Shortest wavelength of the formula (nm).
pub const SHORTEST_NM: f64 = 365.0;
/// Longest wavelength of the formula (nm).
pub const LONGEST_NM: f64 = 1014.0;

/// λ₀² (µm²).
const POLE: f64 = 0.028;
const A: [f64; 4] = [0.661_471_96, -4.201_463_83, 6.298_342_37, -1.758_350_59];
const B: [f64; 4] = [-0.403_527_96, 2.735_089_56, -4.694_099_35, 2.362_537_94];
const P: [f64; 4] = [-0.280_467_90, 1.505_437_84, -1.575_086_50, 0.350_116_57];
const R: [f64; 4] = [0.033_859_79, -0.115_932_35, 0.102_930_38, -0.020_857_82];

/// Index of Navarro's medium, lens relaxed.
pub fn navarro_index(medium: OcularMedium, wavelength_nm: f64) -> f64 {
    let nodes = match medium {
        OcularMedium::Cornea => [1.3975, 1.3807, 1.374_05, 1.3668],
        OcularMedium::Aqueous => [1.3593, 1.3422, 1.3354, 1.3278],
        OcularMedium::Lens => [1.4492, 1.426_25, 1.4175, 1.4097],
        OcularMedium::Vitreous => [1.3565, 1.3407, 1.3341, 1.3273],
    };
    let micrometres = if wavelength_nm.is_nan() {
        0.555
    } else {
        1e-3 * wavelength_nm.clamp(SHORTEST_NM, LONGEST_NM)
    };
    let square = micrometres * micrometres;
    let u = 1.0 / (square - POLE);
    (0..4)
        .map(|i| nodes[i] * (A[i] + B[i] * square + u * (P[i] + u * R[i])))
        .sum()
}

/// Index at `wavelength_nm` of a medium that has `index` at `reference_nm`: n − 1 in proportion to
/// Navarro's. Exactly `index` at the reference.
pub fn dispersed(medium: OcularMedium, index: f64, reference_nm: f64, wavelength_nm: f64) -> f64 {
    if wavelength_nm == reference_nm {
        return index;
    }
    let ratio =
        (navarro_index(medium, wavelength_nm) - 1.0) / (navarro_index(medium, reference_nm) - 1.0);
    1.0 + (index - 1.0) * ratio
}
