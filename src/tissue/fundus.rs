//! The light that the fundus sends back.
//!
//! Delori and Pflibsen (1989, *Applied Optics* 28, 1061, table 1): equivalent reflectance of the perifovea, 2.5° from the
//! fovea, mean of ten people 22 to 38 years old; that of a white diffuser in its place behind clear media, so it holds what the
//! media take twice. Among people it varies by a quarter to a half, by the melanin of the choroid.

use super::spectrum::{spectrum_from, spectrum_to_linear_srgb};

/// Wavelength, nm; equivalent reflectance, %.
const PERIFOVEA: [(f64, f64); 18] = [
    (445.0, 0.68),
    (455.0, 0.73),
    (480.0, 0.89),
    (505.0, 1.20),
    (522.0, 1.41),
    (540.0, 1.44),
    (548.0, 1.53),
    (560.0, 1.61),
    (565.0, 1.61),
    (569.0, 1.61),
    (575.0, 1.62),
    (586.0, 1.88),
    (595.0, 2.62),
    (610.0, 3.99),
    (640.0, 5.79),
    (675.0, 7.70),
    (705.0, 8.93),
    (728.0, 9.71),
];

/// Equivalent reflectance of the fundus at a wavelength (nm), 0 to 1: between the measured ones along lines, beyond them the
/// last; not a number gives that of 445 nm.
pub fn fundus_reflectance(nm: f64) -> f64 {
    let after = PERIFOVEA.partition_point(|(at, _)| *at <= nm);
    let last = PERIFOVEA.len() - 1;
    let (low, high) = (after.saturating_sub(1), after.min(last));
    let ((from, a), (to, b)) = (PERIFOVEA[low], PERIFOVEA[high]);
    let share = if to > from {
        (nm - from) / (to - from)
    } else {
        0.0
    };
    1e-2 * if share.is_nan() {
        a
    } else {
        a + (b - a) * share.clamp(0.0, 1.0)
    }
}

/// Its colour in white light, linear sRGB.
pub fn fundus_color() -> [f64; 3] {
    spectrum_to_linear_srgb(&spectrum_from(fundus_reflectance)).map(|channel| channel.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_table() {
        for (nm, percent) in PERIFOVEA {
            assert!((fundus_reflectance(nm) - 1e-2 * percent).abs() < 1e-15);
        }
        assert!((fundus_reflectance(602.5) - 0.5e-2 * (2.62 + 3.99)).abs() < 1e-15);
        assert!((fundus_reflectance(100.0) - 0.0068).abs() < 1e-15);
        assert!((fundus_reflectance(2000.0) - 0.0971).abs() < 1e-15);
        assert!(fundus_reflectance(f64::NAN).is_finite());
    }

    #[test]
    fn it_is_red() {
        let [r, g, b] = fundus_color();
        println!("fundus {r:.4} {g:.4} {b:.4}");
        assert!(r > 2.5 * g && g > b && b > 0.005, "{r} {g} {b}");
    }
}
