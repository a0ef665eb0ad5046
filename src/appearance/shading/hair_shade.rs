//! Lashes and brow hairs: dark fibres with two highlights (Kajiya and Kay 1989).
//! Twin: `shaders/lib/hair_shade.wgsl`.

use crate::optics::smoothstep::smoothstep;
use glam::DVec3;

/// Radiance of a fibre of this colour along the unit direction `along`, seen from `v`, under a lamp from
/// the unit direction `light` with an irradiance / π of one.
pub fn hair_lamp(color: DVec3, along: DVec3, v: DVec3, light: DVec3) -> DVec3 {
    let sine_to = |d: DVec3| (1.0 - along.dot(d) * along.dot(d)).max(0.0).sqrt();
    let s = sine_to((light + v).normalize());
    color * (0.20 + 0.55 * sine_to(light) + 0.35 * s.powi(14)) + 0.035 * s.powi(60)
}

/// The same under surroundings that send this irradiance / π to a face.
pub fn hair_ambient(color: DVec3, ambient: DVec3) -> DVec3 {
    0.8 * color * ambient
}

/// An edge of the ribbon that draws a hair, this half width (of either sign) aside of its centre line as it is seen from `camera`;
/// `along` and `chord` (from root to tip) are unit vectors. The chord tells which side is which where the hair bends towards the
/// camera and away again.
pub fn hair_ribbon(
    center: DVec3,
    along: DVec3,
    chord: DVec3,
    camera: DVec3,
    half_width: f64,
) -> DVec3 {
    let v = (camera - center).normalize();
    let aside = along.cross(v);
    let turned = if aside.dot(chord.cross(v)) >= 0.0 {
        1.0
    } else {
        -1.0
    };
    center + aside * (turned * half_width / aside.length().max(1e-4))
}

/// Half width of the ribbon that draws a hair of this half width (same units as a pixel, same sign), so wide that no pixel's
/// centre misses it.
pub fn hair_drawn(half_width: f64, pixel: f64) -> f64 {
    (half_width.abs() + 0.5 * pixel)
        .max(pixel)
        .copysign(half_width)
}

/// Share of a pixel that a hair of this half width covers this far aside of its middle; over the ribbon's width as much as the
/// hair is wide.
pub fn hair_coverage(half_width: f64, pixel: f64, aside: f64) -> f64 {
    let w = half_width.abs() / pixel;
    ((w + 0.5).max(1.0) - aside.abs() / pixel).clamp(0.0, 1.0) * (2.0 * w).min(1.0)
}

/// Share of a hair that is seen this far along it (0 root, 1 tip): it comes out of its skin little by little.
pub fn hair_rooted(along: f64) -> f64 {
    smoothstep(0.0, 0.06, along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hair_covers_as_much_as_it_is_wide_however_many_pixels_that_is() {
        for pixel in [0.02, 0.1, 0.7] {
            for half_width in [1e-3, 0.01, 0.04, 0.06, 0.2] {
                let drawn = hair_drawn(half_width, pixel);
                assert!(drawn >= pixel && hair_coverage(half_width, pixel, drawn).abs() < 1e-12);
                // The midpoint rule is exact for lines, and errs in the few cells with a corner.
                let cells = 20_000;
                let step = 2.0 * drawn / f64::from(cells);
                let sum: f64 = (0..cells)
                    .map(|i| hair_coverage(half_width, pixel, (f64::from(i) + 0.5) * step - drawn))
                    .sum();
                assert!((sum * step / (2.0 * half_width) - 1.0).abs() < 1e-6);
            }
        }
        assert_eq!(hair_drawn(-0.3, 0.1), -0.35);
    }
}
