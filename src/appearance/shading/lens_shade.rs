//! A clouded lens behind the pupil. Twin: `shaders/lib/lens_shade.wgsl`.

use crate::anatomy::LENS_DISC_MM;
use crate::optics::smoothstep::smoothstep;
use glam::{DVec2, DVec3};

const LENS_RADIUS_MM: f64 = 0.5 * LENS_DISC_MM;
const NUCLEUS_RADIUS_MM: f64 = 2.75;
const CORTEX_COLOR: DVec3 = DVec3::new(0.13, 0.135, 0.14);

/// Share of a place (mm from the lens's middle) that wedges of clouded cortex cover, which cover this
/// share of the lens. They begin at its rim and point to its middle.
pub fn cortical_wedges(place_mm: DVec2, share: f64) -> f64 {
    let angle = place_mm.y.atan2(place_mm.x + 1e-9);
    let depth = 0.5 + 0.3 * (9.0 * angle + 1.3).sin() + 0.2 * (17.0 * angle + 0.4).sin();
    let covered = (2.0 * share * depth).clamp(0.0, 1.0);
    let begins = LENS_RADIUS_MM * (1.0 - covered).sqrt();
    smoothstep(-0.25, 0.25, place_mm.length() - begins)
}

/// Share of a place that a cloud of this radius (mm) in the middle of the capsule covers: grains with
/// gaps.
pub fn capsule_cloud(place_mm: DVec2, radius_mm: f64) -> f64 {
    let (x, y) = (place_mm.x, place_mm.y);
    let grain = (7.1 * x + 2.3 * (4.7 * y).sin()).sin() * (6.3 * y + 1.9 * (5.9 * x).sin()).sin();
    let edge = radius_mm * (0.9 + 0.1 * grain) - place_mm.length();
    smoothstep(-0.2, 0.2, edge) * (0.75 + 0.25 * grain)
}

/// What a clouded lens sends back of the irradiance / π on it, linear sRGB: `nucleus` that of the
/// nucleus, `capsule` that of a cloud of this radius behind it, whose light has passed the nucleus;
/// clouded cortex covers a share of the disc before both.
pub fn lens_cloud(
    nucleus: DVec3,
    capsule: DVec3,
    capsule_radius_mm: f64,
    cortical_share: f64,
    place_mm: DVec2,
) -> DVec3 {
    let middle = 1.0 - smoothstep(0.7, 1.25, place_mm.length() / NUCLEUS_RADIUS_MM);
    let mut color = nucleus * (0.25 + 0.75 * middle);
    if capsule_radius_mm > 0.0 && place_mm.length() < LENS_RADIUS_MM {
        color += capsule * capsule_cloud(place_mm, capsule_radius_mm);
    }
    if cortical_share > 0.0 {
        color = color.lerp(CORTEX_COLOR, cortical_wedges(place_mm, cortical_share));
    }
    color
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wedges_cover_the_share_that_they_are_given() {
        for share in [0.1, 0.25, 0.45] {
            let (mut covered, mut all) = (0.0, 0.0);
            for i in -75..=75 {
                for j in -75..=75 {
                    let place = DVec2::new(f64::from(i), f64::from(j)) * 0.05;
                    if place.length() < LENS_RADIUS_MM {
                        covered += cortical_wedges(place, share);
                        all += 1.0;
                    }
                }
            }
            // The soft edge of half a millimetre is cut at the rim.
            assert!(
                (covered / all - share).abs() < 0.06,
                "{share}: {}",
                covered / all
            );
        }
        // The axis is spared at first.
        assert!(cortical_wedges(DVec2::ZERO, 0.3) < 0.01);
    }
}
