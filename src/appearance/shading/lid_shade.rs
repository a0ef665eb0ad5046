//! What the lids leave of the light on the globe. Twin: `shaders/lib/lid_shade.wgsl`.

use super::knots::{Knot, knot_at};
use super::mix;
use crate::appearance::materials::{LID_HALF_SPAN_MM, LID_SAMPLES, LidMargins, LidSpan};
use crate::optics::smoothstep::smoothstep;
use glam::DVec3;

/// Shares of the light that the lids leave, and the distance to their margins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidShade {
    /// Share of the sky.
    pub sky: f64,
    /// Share of any lamp that the lower lid's edge leaves.
    pub contact: f64,
    /// Height of the upper margin over the place, mm.
    pub upper_gap: f64,
    /// Height of the place over the lower margin, mm.
    pub lower_gap: f64,
}

/// Between which samples of the margins x (mm, head frame) lies; flat beyond them.
pub fn lid_knot(x: f64) -> Knot {
    let half_span = f64::from(LID_HALF_SPAN_MM);
    knot_at((x + half_span) / (2.0 * half_span), LID_SAMPLES)
}

/// The shade of the lids at a point `p` (head frame) of the globe.
pub fn lids_at(lids: &LidMargins, p: DVec3) -> LidShade {
    let at = lid_knot(p.x);
    lid_shade(&lids.spans[at.below], at.part, p)
}

/// The shade at a point `p` (head frame) of the globe, whose x lies at this `part` of this span of the margins: the upper
/// lid and its lashes overhang, so that
/// a soft band lies below its margin; the lower lid only touches.
pub fn lid_shade(span: &LidSpan, part: f64, p: DVec3) -> LidShade {
    let between = |here: f32, next: f32| mix(here.into(), next.into(), part);
    let upper = between(span.upper, span.upper_next) - p.y;
    let lower = p.y - between(span.lower, span.lower_next);
    let (u, l) = (upper.max(0.0), lower.max(0.0));
    LidShade {
        sky: (1.0 - 0.55 * (-u / 1.3).exp()) * (1.0 - 0.5 * (-l / 0.8).exp()),
        contact: 1.0 - 0.4 * (-l / 0.5).exp(),
        upper_gap: upper,
        lower_gap: lower,
    }
}

/// How far (mm) the edge of the upper lid that casts its shadow stands before the globe, and how soft that edge is:
/// a margin of 2 mm, rounded (choices within it).
pub const LID_EDGE_MM: f64 = 1.3;
const LID_EDGE_SOFT_MM: f64 = 1.2;

/// How much of a lamp of angular radius `radius` (rad) in the unit direction `light` (head frame) the lids leave where
/// that is their shade: the shadow of the upper lid's edge falls the lower, the higher the lamp stands.
pub fn lid_lamp(shade: &LidShade, light: DVec3, radius: f64) -> f64 {
    let rise = (light.y / (-light.z).max(0.2)).clamp(-2.0, 3.0);
    let below = shade.upper_gap - LID_EDGE_MM * rise;
    let soft = LID_EDGE_SOFT_MM + LID_EDGE_MM * radius.min(1.0);
    smoothstep(-soft, soft, below) * shade.contact
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of a lamp is left where the ray to its middle just passes an edge that stands before the margin.
    #[test]
    fn the_lids_shadow_falls_where_its_edge_stands_before_the_lamp() {
        for elevation_deg in [-30.0_f64, 0.0, 25.0, 55.0] {
            let (sin, cos) = elevation_deg.to_radians().sin_cos();
            let light = DVec3::new(0.0, sin, -cos);
            let half = (0..4000).map(|i| f64::from(i) * 0.002 - 3.0).find(|gap| {
                let shade = LidShade {
                    sky: 1.0,
                    contact: 1.0,
                    upper_gap: *gap,
                    lower_gap: 9.0,
                };
                lid_lamp(&shade, light, 0.1) >= 0.5
            });
            // From there up to the edge, as the lamp's ray goes.
            let edge = LID_EDGE_MM * elevation_deg.to_radians().tan();
            assert!(
                (half.expect("a border") - edge).abs() < 0.005,
                "{elevation_deg}"
            );
        }
    }
}
