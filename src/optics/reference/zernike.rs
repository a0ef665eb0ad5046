//! Zernike polynomials of the unit disc as the vision sciences use them (ANSI Z80.28, OSA; Thibos et
//! al. 2002, J. Refract. Surg. 18, S652), to the sixth order.
//!
//! In: a point of the unit pupil (x to the right, y up), or coefficients (µm). Out: values and slopes
//! of the normalised polynomials, refractions in D.
//!
//! `Z_n^m = N R_n^|m|(ρ) cos mθ` for m ≥ 0 and `N R sin |m|θ` for m < 0, with
//! `N = √(2(n + 1)/(1 + δ_m0))`: each has mean square 1 over the disc, so that the root of the sum of
//! squared coefficients is the RMS. The single index is `j = (n(n + 2) + m)/2`. ρ^|m| cos mθ and
//! ρ^|m| sin |m|θ are the real and imaginary parts of (x + iy)^|m|, and the rest of R a polynomial in
//! ρ², so that no angle is ever taken.

use crate::optics::defocus::PowerVector;
use glam::DVec2;

/// Number of polynomials to the sixth order: j = 0 … 27.
pub const ZERNIKE_COUNT: usize = 28;
/// The highest order.
pub const ZERNIKE_ORDER: u32 = 6;

/// Single index of the polynomial with radial order `n` and angular frequency `m`; `None` where there
/// is none such up to the sixth order.
pub fn zernike_index(n: u32, m: i32) -> Option<usize> {
    let exists =
        n <= ZERNIKE_ORDER && m.unsigned_abs() <= n && (n + m.unsigned_abs()).is_multiple_of(2);
    let double = i64::from(n) * (i64::from(n) + 2) + i64::from(m);
    exists.then(|| usize::try_from(double / 2).ok()).flatten()
}

/// Radial order and angular frequency of single index `j`; `None` from 28 on.
pub fn zernike_order_frequency(j: usize) -> Option<(u32, i32)> {
    let mut first = 0;
    for n in 0..=ZERNIKE_ORDER {
        let count = n as usize + 1;
        if j < first + count {
            return Some((n, 2 * (j - first) as i32 - n as i32));
        }
        first += count;
    }
    None
}

/// Radial part over ρ^m as a polynomial in u = ρ², and its derivative by u, with the normalisation.
#[inline]
fn radial(n: u32, m: u32, u: f64) -> (f64, f64) {
    match (n, m) {
        (2, 0) => (2.0 * u - 1.0, 2.0),
        (3, 1) => (3.0 * u - 2.0, 3.0),
        (4, 0) => (6.0 * u * (u - 1.0) + 1.0, 12.0 * u - 6.0),
        (4, 2) => (4.0 * u - 3.0, 4.0),
        (5, 1) => (u * (10.0 * u - 12.0) + 3.0, 20.0 * u - 12.0),
        (5, 3) => (5.0 * u - 4.0, 5.0),
        (6, 0) => (
            u * (u * (20.0 * u - 30.0) + 12.0) - 1.0,
            u * (60.0 * u - 60.0) + 12.0,
        ),
        (6, 2) => (u * (15.0 * u - 20.0) + 6.0, 30.0 * u - 20.0),
        (6, 4) => (6.0 * u - 5.0, 6.0),
        // n = m.
        _ => (1.0, 0.0),
    }
}

/// Powers 0 … 6 of x + iy.
#[inline]
fn powers(p: DVec2) -> [DVec2; 7] {
    let mut powers = [DVec2::X; 7];
    for i in 1..7 {
        powers[i] = powers[i - 1].rotate(p);
    }
    powers
}

/// Calls `visit(j, n, |m|, normalisation, is_cosine)` for all polynomials.
#[inline]
fn for_each(mut visit: impl FnMut(usize, u32, u32, f64, bool)) {
    let mut j = 0;
    for n in 0..=ZERNIKE_ORDER {
        for i in 0..=n {
            let (m, cosine) = if 2 * i >= n {
                (2 * i - n, true)
            } else {
                (n - 2 * i, false)
            };
            let norm = if m == 0 { n + 1 } else { 2 * (n + 1) };
            visit(j, n, m, f64::from(norm).sqrt(), cosine);
            j += 1;
        }
    }
}

/// The values of all polynomials at a point of the unit pupil. Outside it they are the polynomials'
/// continuation.
pub fn zernike_values(p: DVec2) -> [f64; ZERNIKE_COUNT] {
    let powers = powers(p);
    let u = p.length_squared();
    let mut values = [0.0; ZERNIKE_COUNT];
    for_each(|j, n, m, norm, cosine| {
        let angular = powers[m as usize];
        values[j] = norm * radial(n, m, u).0 * if cosine { angular.x } else { angular.y };
    });
    values
}

/// The slopes (∂/∂x, ∂/∂y) of all polynomials at a point of the unit pupil.
pub fn zernike_slopes(p: DVec2) -> [DVec2; ZERNIKE_COUNT] {
    let powers = powers(p);
    let u = p.length_squared();
    let mut slopes = [DVec2::ZERO; ZERNIKE_COUNT];
    for_each(|j, n, m, norm, cosine| {
        let (value, by_u) = radial(n, m, u);
        let angular = powers[m as usize];
        let below = if m == 0 {
            DVec2::ZERO
        } else {
            f64::from(m) * powers[m as usize - 1]
        };
        // d(x + iy)^m = m (x + iy)^(m−1) (dx + i dy).
        let (part, by_x, by_y) = if cosine {
            (angular.x, below.x, -below.y)
        } else {
            (angular.y, below.y, below.x)
        };
        slopes[j] = norm * (2.0 * by_u * part * p + value * DVec2::new(by_x, by_y));
    });
    slopes
}

/// The surface that `coefficients` describe, at a point of the unit pupil.
pub fn zernike_sum(coefficients: &[f64; ZERNIKE_COUNT], p: DVec2) -> f64 {
    zernike_values(p)
        .iter()
        .zip(coefficients)
        .map(|(value, coefficient)| value * coefficient)
        .sum()
}

/// The second-order coefficients `[c2,−2, c2,0, c2,2]` (µm) of an eye with this refraction, in the
/// plane of the pupil, over a pupil of `pupil_radius_mm`.
pub fn zernike_from_refraction(refraction: PowerVector, pupil_radius_mm: f64) -> [f64; 3] {
    let r2 = pupil_radius_mm * pupil_radius_mm;
    let [sphere, cylinder] = [-r2 / (4.0 * 3_f64.sqrt()), -r2 / (2.0 * 6_f64.sqrt())];
    [
        cylinder * refraction.j45_d,
        sphere * refraction.m_d,
        cylinder * refraction.j0_d,
    ]
}

/// The refraction, in the plane of the pupil, of second-order coefficients `[c2,−2, c2,0, c2,2]` (µm):
/// the one that leaves the least RMS.
pub fn refraction_from_zernike(second: [f64; 3], pupil_radius_mm: f64) -> PowerVector {
    let r2 = pupil_radius_mm * pupil_radius_mm;
    PowerVector {
        m_d: -4.0 * 3_f64.sqrt() * second[1] / r2,
        j0_d: -2.0 * 6_f64.sqrt() * second[2] / r2,
        j45_d: -2.0 * 6_f64.sqrt() * second[0] / r2,
    }
}

/// Mean sphere (D) by the curvature of the wavefront at the pupil's centre (Seidel refraction):
/// `−(4√3 c20 − 12√5 c40 + 24√7 c60)/r²`.
pub fn paraxial_sphere_from_zernike(
    coefficients: &[f64; ZERNIKE_COUNT],
    pupil_radius_mm: f64,
) -> f64 {
    let [c20, c40, c60] = [coefficients[4], coefficients[12], coefficients[24]];
    -(4.0 * 3_f64.sqrt() * c20 - 12.0 * 5_f64.sqrt() * c40 + 24.0 * 7_f64.sqrt() * c60)
        / (pupil_radius_mm * pupil_radius_mm)
}

/// RMS (µm) of the orders `from` and higher.
pub fn zernike_rms(coefficients: &[f64; ZERNIKE_COUNT], from_order: u32) -> f64 {
    let first = (from_order * (from_order + 1) / 2) as usize;
    coefficients
        .iter()
        .skip(first)
        .map(|c| c * c)
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Factorial form of the radial polynomial.
    fn radial_by_factorials(n: u32, m: u32, rho: f64) -> f64 {
        let factorial = |k: u32| (1..=k).map(f64::from).product::<f64>();
        (0..=(n - m) / 2)
            .map(|s| {
                let sign = if s % 2 == 0 { 1.0 } else { -1.0 };
                sign * factorial(n - s)
                    / (factorial(s) * factorial((n + m) / 2 - s) * factorial((n - m) / 2 - s))
                    * rho.powi((n - 2 * s) as i32)
            })
            .sum()
    }

    #[test]
    fn indices_go_both_ways() {
        let mut j = 0;
        for n in 0..=6_u32 {
            for m in (-(n as i32)..=n as i32).step_by(2) {
                assert_eq!(zernike_index(n, m), Some(j));
                assert_eq!(zernike_order_frequency(j), Some((n, m)));
                j += 1;
            }
        }
        assert_eq!(j, ZERNIKE_COUNT);
        assert_eq!(zernike_order_frequency(ZERNIKE_COUNT), None);
        for (n, m) in [(2, 1), (3, -5), (7, 1)] {
            assert_eq!(zernike_index(n, m), None);
        }
    }

    #[test]
    fn values_are_the_textbook_s() {
        for (rho, theta) in [(0.0, 0.0), (0.3, 1.0), (0.8, 4.0), (1.0, 2.5)] {
            let values = zernike_values(rho * DVec2::from_angle(theta));
            for (j, value) in values.into_iter().enumerate() {
                let (n, m) = zernike_order_frequency(j).unwrap();
                let norm = f64::from((n + 1) * if m == 0 { 1 } else { 2 }).sqrt();
                let angular = if m < 0 {
                    (f64::from(-m) * theta).sin()
                } else {
                    (f64::from(m) * theta).cos()
                };
                let expected = norm * radial_by_factorials(n, m.unsigned_abs(), rho) * angular;
                assert!((value - expected).abs() < 2e-14, "{j} {value} {expected}");
            }
        }
    }

    #[test]
    fn they_are_orthonormal() {
        // Gauss–Legendre in ρ² (7 nodes: exact to degree 13) and 16 equal angles (to frequency 15):
        // products of two are of degree 6 in ρ² and frequency 12.
        const NODES: [(f64, f64); 7] = [
            (0.025446043828620757, 0.06474248308443485),
            (0.12923440720030277, 0.13985269574463835),
            (0.2970774243113014, 0.19091502525255946),
            (0.5, 0.2089795918367347),
            (0.7029225756886985, 0.19091502525255946),
            (0.8707655927996972, 0.13985269574463835),
            (0.9745539561713792, 0.06474248308443485),
        ];
        let mut products = [[0.0; ZERNIKE_COUNT]; ZERNIKE_COUNT];
        for (u, weight) in NODES {
            for i in 0..16_i32 {
                let angle = core::f64::consts::TAU * f64::from(i) / 16.0;
                let z = zernike_values(f64::sqrt(u) * DVec2::from_angle(angle));
                for (j, row) in products.iter_mut().enumerate() {
                    for (k, product) in row.iter_mut().enumerate() {
                        *product += weight / 16.0 * z[j] * z[k];
                    }
                }
            }
        }
        for (j, row) in products.iter().enumerate() {
            for (k, product) in row.iter().enumerate() {
                let expected = if j == k { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-13, "{j} {k} {product}");
            }
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        let h = 1e-5;
        for p in [DVec2::new(0.3, -0.4), DVec2::new(-0.8, 0.5), DVec2::ZERO] {
            let slopes = zernike_slopes(p);
            let along = |axis: DVec2| {
                let (a, b) = (zernike_values(p + h * axis), zernike_values(p - h * axis));
                core::array::from_fn::<f64, ZERNIKE_COUNT, _>(|j| (a[j] - b[j]) / (2.0 * h))
            };
            let (by_x, by_y) = (along(DVec2::X), along(DVec2::Y));
            for j in 0..ZERNIKE_COUNT {
                // h² times third derivatives of up to a few hundred.
                assert!((slopes[j].x - by_x[j]).abs() < 2e-7, "{j}");
                assert!((slopes[j].y - by_y[j]).abs() < 2e-7, "{j}");
            }
        }
    }

    #[test]
    fn refractions_have_the_published_coefficients() {
        // REFERENCE: −3 D over 5 mm is 2.7063 µm.
        let myope = PowerVector::from_sphere_cylinder(-3.0, 0.0, 0.0);
        let [_, c20, _] = zernike_from_refraction(myope, 2.5);
        assert!((c20 - 2.7063).abs() < 5e-5);
        // The wavefront is −(S + C sin²(θ − A)) r²/2 up to piston, in each meridian.
        let (sphere, cylinder, axis) = (1.5, -2.0, 0.5_f64);
        let refraction = PowerVector::from_sphere_cylinder(sphere, cylinder, axis);
        let second = zernike_from_refraction(refraction, 3.0);
        let mut coefficients = [0.0; ZERNIKE_COUNT];
        coefficients[3..6].copy_from_slice(&second);
        let centre = zernike_sum(&coefficients, DVec2::ZERO);
        for angle in [0.0, 0.5, 1.0, 2.0_f64] {
            let edge = zernike_sum(&coefficients, DVec2::from_angle(angle)) - centre;
            let power = sphere + cylinder * (angle - axis).sin().powi(2);
            assert!((edge + power * 9.0 / 2.0).abs() < 1e-13, "{angle}");
        }
        assert!((paraxial_sphere_from_zernike(&coefficients, 3.0) - 0.5).abs() < 1e-14);
    }

    #[test]
    fn rms_counts_from_its_order() {
        let mut c = [0.0; ZERNIKE_COUNT];
        c[4] = 3.0;
        c[7] = 0.3;
        c[12] = 0.4;
        assert!((zernike_rms(&c, 3) - 0.5).abs() < 1e-15);
        assert!((zernike_rms(&c, 2) - 9.25_f64.sqrt()).abs() < 1e-15);
        assert_eq!(zernike_rms(&c, 5), 0.0);
        assert_eq!(zernike_rms(&c, 9), 0.0);
    }

    proptest! {
        #[test]
        fn refraction_goes_there_and_back(
            sphere in -20.0..20.0_f64,
            cylinder in -8.0..-0.01_f64,
            axis in 0.0..3.1_f64,
            radius in 0.5..4.5_f64,
        ) {
            let given = PowerVector::from_sphere_cylinder(sphere, cylinder, axis);
            let back = refraction_from_zernike(zernike_from_refraction(given, radius), radius);
            let (sphere_back, cylinder_back, axis_back) = back.to_sphere_cylinder();
            prop_assert!((sphere_back - sphere).abs() < 1e-12);
            prop_assert!((cylinder_back - cylinder).abs() < 1e-12);
            let turn = (axis_back - axis).rem_euclid(core::f64::consts::PI);
            prop_assert!(turn.min(core::f64::consts::PI - turn) < 1e-12);
        }
    }
}
