//! The one place where linear radiance becomes a displayed colour: exposure, a shoulder, and the
//! sRGB transfer curve (IEC 61966-2-1).
//!
//! In: linear RGB of a scene. Out: linear or encoded display RGB in 0 to 1.
//!
//! Twin: `shaders/lib/output.wgsl`.

use glam::{DVec2, DVec3};

/// Below this the output curve is the identity.
const OUTPUT_KNEE: f64 = 0.6;
/// How fast colours far over white lose their saturation.
const OUTPUT_DESATURATION: f64 = 0.15;
/// Largest half-float: brighter input is cut there, so that no infinity enters the curve.
const OUTPUT_BRIGHTEST: f64 = 65504.0;

/// Linear display RGB in 0 to 1 from linear scene RGB.
///
/// The identity (times `exposure`) while the largest channel is below 0.6, then a shoulder that
/// reaches 1 at infinity with continuous slope. All channels are scaled together, which keeps the
/// hue, and what lies far over white fades to white as it does on film.
pub fn output_transform(linear_rgb: DVec3, exposure: f64) -> DVec3 {
    let rgb = clamp_channels(linear_rgb * exposure, OUTPUT_BRIGHTEST);
    let peak = rgb.max_element();
    if peak <= OUTPUT_KNEE {
        return rgb;
    }
    let room = 1.0 - OUTPUT_KNEE;
    let shoulder = 1.0 - room * room / (peak - OUTPUT_KNEE + room);
    let white = 1.0 - 1.0 / (OUTPUT_DESATURATION * (peak - shoulder) + 1.0);
    (rgb * (shoulder / peak)).lerp(DVec3::splat(shoulder), white)
}

/// A displayed linear colour, half a code of eight bits up or down by the pixel: interleaved gradient noise
/// (Jimenez 2014).
pub fn dithered(linear_rgb: DVec3, pixel: DVec2) -> DVec3 {
    let noise = (52.9829189
        * pixel
            .floor()
            .dot(DVec2::new(0.06711056, 0.00583715))
            .fract())
    .fract();
    // What a code is in linear light.
    let code =
        |linear: f64| (2.2748815 * linear.max(1e-9).powf(1.4 / 2.4)).max(1.0 / 12.92) / 255.0;
    let moved = linear_rgb + (noise - 0.5) * linear_rgb.map(code);
    moved.clamp(DVec3::ZERO, DVec3::ONE)
}

/// sRGB-encoded from linear, both 0 to 1 (input is clamped).
pub fn linear_to_srgb(linear_rgb: DVec3) -> DVec3 {
    clamp_channels(linear_rgb, 1.0).map(srgb_encode)
}

/// One channel of linear light, 0 to 1, as sRGB encodes it (IEC 61966-2-1).
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// One sRGB channel, 0 to 1, as linear light (IEC 61966-2-1).
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Each channel clamped to 0 to `highest`; what is not a number becomes 0.
fn clamp_channels(rgb: DVec3, highest: f64) -> DVec3 {
    rgb.map(|c| c.max(0.0).min(highest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mid_tones_pass_unchanged() {
        let rgb = DVec3::new(0.6, 0.18, 0.02);
        assert_eq!(output_transform(rgb, 1.0), rgb);
        assert_eq!(output_transform(rgb, 0.5), rgb * 0.5);
    }

    #[test]
    fn the_shoulder_rises_to_one_with_a_continuous_slope() {
        let grey = |v: f64| output_transform(DVec3::splat(v), 1.0).x;
        let h = 1e-6;
        let slopes = [0.6 - h, 0.6 + h].map(|v| (grey(v + h) - grey(v - h)) / (2.0 * h));
        // f'' = −2/0.4 just above the knee, so the slope is off by 5·h there.
        assert!((slopes[0] - 1.0).abs() < 1e-5 && (slopes[1] - 1.0).abs() < 1e-5);
        let mut last = 0.0;
        for i in 0..4000 {
            let v = grey(f64::from(i) * 0.01);
            assert!(v >= last && v < 1.0);
            last = v;
        }
        assert!(grey(1e9) <= 1.0 && grey(1e9) > 0.99999);
    }

    #[test]
    fn hue_stays_and_the_very_bright_turns_white() {
        let hue = |c: DVec3| (c.y - c.z) / (c.x - c.z);
        let orange = DVec3::new(2.0, 1.0, 0.2);
        // Scaling and mixing with white keep the hue exactly.
        assert!((hue(output_transform(orange, 1.0)) - hue(orange)).abs() < 1e-14);
        let sun = output_transform(orange, 1e4);
        assert!(sun.min_element() > 0.99);
    }

    #[test]
    fn what_is_not_a_colour_becomes_black_or_white() {
        assert_eq!(output_transform(DVec3::NAN, 1.0), DVec3::ZERO);
        assert_eq!(output_transform(DVec3::splat(-1.0), 1.0), DVec3::ZERO);
        assert!(output_transform(DVec3::INFINITY, 1.0).is_finite());
        assert_eq!(linear_to_srgb(DVec3::NAN), DVec3::ZERO);
    }

    #[test]
    fn srgb_has_its_published_values() {
        // IEC 61966-2-1: linear 0.5 encodes to 0.735357, 0.18 to 0.461356.
        let encoded = linear_to_srgb(DVec3::new(0.5, 0.18, 1.0));
        assert!((encoded.x - 0.735_357).abs() < 1e-6);
        assert!((encoded.y - 0.461_356).abs() < 1e-6);
        assert!((encoded.z - 1.0).abs() < 1e-15);
    }
}
