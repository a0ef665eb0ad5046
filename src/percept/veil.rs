//! Straylight of clouded media, from the mips of a picture. Twin: `shaders/lib/veil.wgsl`.

use glam::{DVec2, DVec4};

/// Share of its solid angle that a pixel at these tangents from the middle of a view keeps, cos³ θ.
pub fn solid_angle_share(tangents: DVec2) -> f64 {
    let c = 1.0 / (1.0 + tangents.length_squared());
    c * c.sqrt()
}

/// A cubic B-spline at the share `f` (0 to 1) of the way from one texel to the next, as two bilinear
/// taps: x and y their weights, z and w their places from the first of the two texels.
pub fn spline_taps(f: f64) -> DVec4 {
    let g = 1.0 - f;
    let before = g * g * g / 6.0;
    let after = f * f * f / 6.0;
    let here = (4.0 - 3.0 * f * f * (2.0 - f)) / 6.0;
    let next = 1.0 - before - after - here;
    let (first, second) = (before + here, next + after);
    DVec4::new(first, second, here / first - 1.0, 1.0 + after / second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_taps_are_the_spline() {
        for i in 0..=20 {
            let f = f64::from(i) / 20.0;
            let taps = spline_taps(f);
            // A bilinear tap shares its weight among two texels: the spline's four weights come back.
            let at = |texel: f64| {
                let tent = |place: f64| (1.0 - (place - texel).abs()).max(0.0);
                taps.x * tent(taps.z) + taps.y * tent(taps.w)
            };
            let spline = |x: f64| {
                let x = x.abs();
                match x {
                    x if x < 1.0 => (4.0 - 6.0 * x * x + 3.0 * x.powi(3)) / 6.0,
                    x if x < 2.0 => (2.0 - x).powi(3) / 6.0,
                    _ => 0.0,
                }
            };
            for texel in [-1.0, 0.0, 1.0, 2.0] {
                assert!((at(texel) - spline(f - texel)).abs() < 1e-14, "{f} {texel}");
            }
        }
        assert_eq!(solid_angle_share(DVec2::ZERO), 1.0);
        // 60°: cos³ = 1/8.
        assert!((solid_angle_share(DVec2::new(3f64.sqrt(), 0.0)) - 0.125).abs() < 1e-15);
    }
}
