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

/// How far (mm) the edge of the upper lid that casts its shadow stands before the globe: a margin of 2 mm, rounded (a choice within it).
pub const LID_EDGE_MM: f64 = 1.3;
/// How far (mm) that edge stands over the one that touches the globe: a margin looks down and forward, and from the front half a
/// millimetre of it is seen (a choice).
pub const LID_EDGE_UP_MM: f64 = 0.5;
/// How soft (mm) the shadow's edge is (a choice).
const LID_EDGE_SOFT_MM: f64 = 1.2;

/// How much of a lamp of angular radius `radius` (rad) in the unit direction `light` (head frame) the lids leave where
/// that is their shade: the shadow of the upper lid's edge falls the lower, the higher the lamp stands.
pub fn lid_lamp(shade: &LidShade, light: DVec3, radius: f64) -> f64 {
    let rise = (light.y / (-light.z).max(0.2)).clamp(-2.0, 3.0);
    let below = shade.upper_gap - (LID_EDGE_MM * rise - LID_EDGE_UP_MM).max(0.0);
    let soft = LID_EDGE_SOFT_MM + LID_EDGE_MM * radius.min(1.0);
    smoothstep(-soft, soft, below) * shade.contact
}

/// What lids send on of the light that they keep from the iris, against what would have come there: their edges and the lashes see half of the
/// sky, and skin sends back about half of that.
const LIDS_SEND: f64 = 0.25;

/// How much of the sky the lids leave to a place of the iris, `depth` mm behind their edges in an aqueous of this `index`, whose shade this is:
/// light comes there from all of the sky through a cone, of which an edge hides a half and more where it hangs before the place.
pub fn lid_sky_within(shade: &LidShade, depth: f64, index: f64) -> f64 {
    // The share of a sky's irradiance that is not behind a straight edge, by the sine of how far up it is seen.
    let open = |gap: f64| {
        let sine = gap / (gap * gap + depth * depth).sqrt().max(0.1);
        0.5 + 0.5 * (index * sine).clamp(-1.0, 1.0)
    };
    let left = (open(shade.upper_gap) + open(shade.lower_gap) - 1.0).max(0.0);
    mix(LIDS_SEND, 1.0, left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_hides_as_much_of_the_sky_from_the_iris_as_by_all_directions() {
        let (depth, index) = (3.0, 1.336);
        for gap in [-2.0, -0.5, 0.0, 0.7, 2.0, 5.0] {
            // Even steps of the aqueous' cone over the plane of the iris.
            let (mut open, mut all) = (0, 0);
            for i in 0..800 {
                for j in 0..800 {
                    let at = [i, j].map(|k: i32| (f64::from(k) + 0.5) / 400.0 - 1.0);
                    let [x, y] = at.map(|k| k / index);
                    let sine2 = x * x + y * y;
                    if sine2 < 1.0 / (index * index) {
                        all += 1;
                        open += i32::from(y / (1.0 - sine2).sqrt() * depth < gap);
                    }
                }
            }
            let shade = LidShade {
                sky: 1.0,
                contact: 1.0,
                upper_gap: gap,
                lower_gap: 1e6,
            };
            let exact = mix(LIDS_SEND, 1.0, f64::from(open) / f64::from(all));
            let ours = lid_sky_within(&shade, depth, index);
            assert!((ours - exact).abs() < 0.03, "{gap}: {ours} {exact}");
        }
    }

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
            // From there up to the edge, as the lamp's ray goes; or where the lid touches.
            let edge = LID_EDGE_MM * elevation_deg.to_radians().tan() - LID_EDGE_UP_MM;
            let edge = edge.max(0.0);
            assert!(
                (half.expect("a border") - edge).abs() < 0.005,
                "{elevation_deg}"
            );
        }
    }
}
