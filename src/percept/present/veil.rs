//! Straylight of clouded media, from the mips of a picture. Twin: `shaders/lib/veil.wgsl`.

use crate::optics::glare::cubic_spline;
pub use crate::optics::glare::stereographic;
use glam::DVec2;

/// Tangents from the middle of a view of a stereographic place within 90° of it; beyond, those far out in
/// its direction.
pub fn tangents_of(place: DVec2) -> DVec2 {
    place / (1.0 - 0.25 * place.length_squared()).max(1e-3)
}

/// How much larger a stereographic place is drawn than the middle, along each axis.
pub fn stereographic_scale(place: DVec2) -> f64 {
    1.0 + 0.25 * place.length_squared()
}

/// A cubic B-spline twice as wide as a texel's: its weight for a texel at this distance, in texels. Those
/// of all texels sum to 1.
pub fn wide_spline(distance: f64) -> f64 {
    0.5 * cubic_spline(0.5 * distance)
}

/// Two neighbouring texels as one bilinear tap, the first at this signed distance, each of which counts by
/// its share: x their weight, y how far the tap lies from the first towards the second.
pub fn wide_spline_pair(first: f64, shares: DVec2) -> DVec2 {
    let a = wide_spline(first) * shares.x;
    let b = wide_spline(first + 1.0) * shares.y;
    DVec2::new(a + b, b / (a + b).max(1e-20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_texels_make_the_whole() {
        for i in 0..20 {
            let f = f64::from(i) / 20.0;
            let sum: f64 = (-3..=4)
                .map(|texel| wide_spline(f64::from(texel) - f))
                .sum();
            assert!((sum - 1.0).abs() < 1e-14, "{f}: {sum}");
            let pairs: f64 = (0..4)
                .map(|j| wide_spline_pair(f64::from(2 * j - 3) - f, DVec2::ONE).x)
                .sum();
            assert!((pairs - 1.0).abs() < 1e-14, "{f}: {pairs}");
        }
        assert_eq!(wide_spline(4.0), 0.0);
    }

    #[test]
    fn a_place_has_its_tangents_back_and_the_scale_of_its_angle() {
        for deg in [0.0, 5.0, 30.0, 60.0, 85.0_f64] {
            let angle = deg.to_radians();
            let place = stereographic(DVec2::from_angle(0.7) * angle.tan());
            assert!((place.length() - 2.0 * (0.5 * angle).tan()).abs() < 1e-12);
            assert!((tangents_of(place).length() - angle.tan()).abs() < 1e-10);
            // dθ to dplace, and sin θ to its circle.
            let scale = 1.0 / (0.5 * angle).cos().powi(2);
            assert!((stereographic_scale(place) - scale).abs() < 1e-12);
        }
        assert!(tangents_of(DVec2::splat(9.0)).is_finite());
    }
}
