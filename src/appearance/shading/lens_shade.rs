//! A clouded lens behind the pupil. Twin: `shaders/lib/lens_shade.wgsl`.

use crate::anatomy::{
    CAPSULE_DEPTH_MM, CORTEX_DEPTH_MM, LENS_DISC_MM, NUCLEUS_DEPTH_MM, NUCLEUS_RADIUS_MM,
};
use crate::optics::smoothstep::smoothstep;
use glam::{DVec2, DVec3};

const LENS_RADIUS_MM: f64 = 0.5 * LENS_DISC_MM;
/// Share of light that a cloud takes out of its way (a choice: ripe cortex and plaque look black against the
/// fundus).
const LENS_OPAQUE: f64 = 0.9;
const CORTEX_COLOR: DVec3 = DVec3::new(0.13, 0.135, 0.14);

/// Share of a place (mm from the lens's middle) that wedges of clouded cortex cover, which cover this
/// share of the lens. They begin at its rim and point to its middle, and `turn` (rad) makes them those of
/// this eye.
pub fn cortical_wedges(place_mm: DVec2, share: f64, turn: f64) -> f64 {
    let angle = place_mm.y.atan2(place_mm.x + 1e-9);
    let depth = 0.5
        + 0.2 * (7.0 * angle + turn).sin()
        + 0.15 * (11.0 * angle + 2.3 * turn).sin()
        + 0.15 * (17.0 * angle + 4.1 * turn).sin();
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

/// Share of light that crosses a clouded lens on its way out, as it is seen against a bright fundus: what is
/// opaque scatters nearly all of it aside. The arguments are those of [`lens_cloud`].
pub fn lens_clear(
    capsule_radius_mm: f64,
    cortical_share: f64,
    place_mm: DVec2,
    slope: DVec2,
    turn: f64,
) -> f64 {
    let mut clear = 1.0;
    let behind = place_mm + slope * CAPSULE_DEPTH_MM;
    if capsule_radius_mm > 0.0 && behind.length() < LENS_RADIUS_MM {
        clear *= 1.0 - LENS_OPAQUE * capsule_cloud(behind, capsule_radius_mm).clamp(0.0, 1.0);
    }
    if cortical_share > 0.0 {
        let before = place_mm + slope * CORTEX_DEPTH_MM;
        clear *= 1.0 - LENS_OPAQUE * cortical_wedges(before, cortical_share, turn);
    }
    clear
}

/// What a clouded lens sends back of the irradiance / π on it, linear sRGB: `nucleus` that of the
/// nucleus, `capsule` that of a cloud of this radius behind it, whose light has passed the nucleus;
/// clouded cortex covers a share of the disc before both. `place_mm` is where the view crosses the plane
/// of the iris, `slope` how far aside it goes with each mm inwards; `turn` is of this eye.
pub fn lens_cloud(
    nucleus: DVec3,
    capsule: DVec3,
    capsule_radius_mm: f64,
    cortical_share: f64,
    place_mm: DVec2,
    slope: DVec2,
    turn: f64,
) -> DVec3 {
    let off = (place_mm + slope * NUCLEUS_DEPTH_MM).length();
    let middle = 1.0 - smoothstep(0.7, 1.25, off / NUCLEUS_RADIUS_MM);
    let mut color = nucleus * (0.25 + 0.75 * middle);
    let behind = place_mm + slope * CAPSULE_DEPTH_MM;
    if capsule_radius_mm > 0.0 && behind.length() < LENS_RADIUS_MM {
        color += capsule * capsule_cloud(behind, capsule_radius_mm);
    }
    let before = place_mm + slope * CORTEX_DEPTH_MM;
    if cortical_share > 0.0 {
        color = color.lerp(CORTEX_COLOR, cortical_wedges(before, cortical_share, turn));
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
                        covered += cortical_wedges(place, share, 0.7);
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
        // Seen from aside what lies deep moves against the pupil: 3.8 mm at a slope of a half.
        let cloud = |x: f64, slope: f64| {
            let (place, slope) = (DVec2::new(x, 0.0), DVec2::new(slope, 0.0));
            lens_cloud(DVec3::ZERO, DVec3::ONE, 1.0, 0.0, place, slope, 0.0).x
        };
        assert!((cloud(-1.9, 0.5) - cloud(0.0, 0.0)).abs() < 1e-12);
        // The axis is spared at first.
        assert!(cortical_wedges(DVec2::ZERO, 0.3, 0.7) < 0.01);
    }
}
