//! What the lids leave of the light on the globe. Twin: `shaders/lib/lid_shade.wgsl`.

use super::mix;
use crate::appearance::materials::{LID_HALF_SPAN_MM, LID_SAMPLES, LidHeights};
use crate::optics::smoothstep::smoothstep;
use bevy::math::Vec4;
use glam::DVec3;

/// Shares of the light that the lids leave, and the distance to their margins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidShade {
    /// Share of the sky.
    pub sky: f64,
    /// Share of the key light.
    pub key: f64,
    /// Height of the upper margin over the place, mm.
    pub upper_gap: f64,
    /// Height of the place over the lower margin, mm.
    pub lower_gap: f64,
}

/// Height (mm) of a margin at x, between its samples; flat beyond them.
pub fn lid_height(heights: &[Vec4; LID_SAMPLES / 4], x: f64) -> f64 {
    let half_span = f64::from(LID_HALF_SPAN_MM);
    let at = ((x + half_span) / (2.0 * half_span)).clamp(0.0, 1.0) * (LID_SAMPLES - 1) as f64;
    let i = (at as usize).min(LID_SAMPLES - 2);
    let sample = |i: usize| f64::from(heights[i / 4][i % 4]);
    mix(sample(i), sample(i + 1), at - i as f64)
}

/// The shade at a point `p` (head frame) of the globe: the upper lid and its lashes overhang, so that a
/// soft band lies below its margin; the lower lid only touches.
pub fn lid_shade(lids: &LidHeights, p: DVec3) -> LidShade {
    let upper = lid_height(&lids.upper, p.x) - p.y;
    let lower = p.y - lid_height(&lids.lower, p.x);
    let (u, l) = (upper.max(0.0), lower.max(0.0));
    LidShade {
        sky: (1.0 - 0.55 * (-u / 1.3).exp()) * (1.0 - 0.5 * (-l / 0.8).exp()),
        key: smoothstep(-0.9, 1.9, upper) * (1.0 - 0.4 * (-l / 0.5).exp()),
        upper_gap: upper,
        lower_gap: lower,
    }
}
