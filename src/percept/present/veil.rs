//! Straylight of clouded media, from the mips of a picture. Twin: `shaders/lib/veil.wgsl`.

use crate::optics::glare::cubic_spline;
use glam::DVec2;

/// Share of its solid angle that a pixel at this tangent from the middle of a view keeps along one axis,
/// cos³ θ. The product of both is (1 + x² + y²)^−1.5 but for x² y² in the bracket.
pub fn solid_angle_share(tangent: f64) -> f64 {
    let c = 1.0 / (1.0 + tangent * tangent);
    c * c.sqrt()
}

/// A cubic B-spline twice as wide as a texel's: its weight for a texel at this distance, in texels. Those
/// of all texels sum to 1.
pub fn wide_spline(distance: f64) -> f64 {
    0.5 * cubic_spline(0.5 * distance)
}

/// Two neighbouring texels as one bilinear tap, the first at this signed distance, each of which counts by
/// its share: x their weight, y how far the tap lies from the first towards the second.
pub fn wide_spline_pair(first: f64, shares: DVec2) -> DVec2 {
    let (a, b) = (
        wide_spline(first) * shares.x,
        wide_spline(first + 1.0) * shares.y,
    );
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
        assert_eq!(solid_angle_share(0.0), 1.0);
        // 60°: cos³ = 1/8.
        assert!((solid_angle_share(3f64.sqrt()) - 0.125).abs() < 1e-15);
    }
}
