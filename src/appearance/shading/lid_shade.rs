//! What the lids leave of the light on the globe. Twin: `shaders/lib/lid_shade.wgsl`.

use super::knots::{Knot, knot_at};
use super::lash_comb::{LASH_DARK, LASH_SHARE, lash_rise, lashes_left};
use super::mix;
use crate::appearance::materials::{LID_HALF_SPAN_MM, LID_SAMPLES, LidMargins, LidSpan};
use crate::optics::smoothstep::smoothstep;
use bevy::math::Vec4;
use core::f64::consts::{FRAC_1_PI, FRAC_2_PI};
use glam::DVec3;

/// Where a place of the globe lies between the lids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidShade {
    /// To the patient's right, mm.
    pub aside: f64,
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

/// The shade at a point `p` (head frame) of the globe, whose x lies at this `part` of this span of the margins.
pub fn lid_shade(span: &LidSpan, part: f64, p: DVec3) -> LidShade {
    let between = |here: f32, next: f32| mix(here.into(), next.into(), part);
    let lower = p.y - between(span.lower, span.lower_next);
    LidShade {
        aside: p.x,
        upper_gap: between(span.upper, span.upper_next) - p.y,
        lower_gap: lower,
    }
}

/// How far (mm) the edges of the lids that cast their shadows stand before the globe: a margin of 2 mm, rounded (a choice within it).
pub const LID_EDGE_MM: f64 = 1.3;
/// How far (mm) an edge stands beyond the one that touches the globe: a margin looks to the other and forward, and from the front half a
/// millimetre of it is seen (a choice).
pub const LID_EDGE_UP_MM: f64 = 0.5;
/// How soft (mm) the edges of their shadows are: the upper lid's is rounded, the lower one's sharp (choices).
const LID_EDGE_SOFT_MM: f64 = 1.2;
const LOWER_EDGE_SOFT_MM: f64 = 0.5;
/// Where the lids' edges look to in the mean: forward and, as the upper one stands further out, down.
pub const LIDS_FACE: DVec3 = DVec3::new(0.0, -0.406_138_5, -0.913_811_5);

/// How much of a lamp of angular radius `radius` (rad) in the unit direction `light` (head frame) the lids leave where
/// that is their shade: the shadow of the upper lid's edge falls the lower, the higher the lamp stands, that of the lower one's the higher,
/// the lower it stands, and the upper lashes throw theirs, which the lamp's width (a disc's spread is half of its radius) and the
/// tissue blur.
pub fn lid_lamp(shade: &LidShade, light: DVec3, radius: f64) -> f64 {
    let rise = (light.y / (-light.z).max(0.2)).clamp(-3.0, 3.0);
    let below = shade.upper_gap - (LID_EDGE_MM * rise - LID_EDGE_UP_MM).max(0.0);
    let above = shade.lower_gap - (-LID_EDGE_MM * rise - LID_EDGE_UP_MM).max(0.0);
    let wide = LID_EDGE_MM * radius.min(1.0);
    let soft = LID_EDGE_SOFT_MM + wide;
    let lower_soft = LOWER_EDGE_SOFT_MM + wide;
    let lashes = lashes_left(
        shade.aside,
        light,
        shade.upper_gap,
        LASH_SHADOW_MM,
        0.35 * radius,
    );
    smoothstep(-soft, soft, below) * smoothstep(-lower_soft, lower_soft, above) * lashes
}

/// How far (mm) light goes aside in the tissue on which a lash's shadow falls: the spread of a vessel's (`SHADOW_MM` of the white).
const LASH_SHADOW_MM: f64 = 0.06;

/// The sine, against a normal that rises by `tilt` (sine), at which an edge is seen that stands `up` mm higher and `before` mm in
/// front; one behind the horizon is at it.
fn edge_sine(up: f64, before: f64, tilt: f64) -> f64 {
    let upright = (1.0 - tilt * tilt).max(0.0).sqrt();
    if before * upright + up * tilt > 0.0 {
        let far = (up * up + before * before).max(1e-6).sqrt();
        ((up * upright - before * tilt) / far).clamp(-1.0, 1.0)
    } else {
        if up < 0.0 { -1.0 } else { 1.0 }
    }
}

/// Twice the integral of the square of the cosine from 0 to where the sine is `s`, over π, within 6e-4.
fn square_cosines(s: f64) -> f64 {
    let s2 = s * s;
    FRAC_2_PI * s * (1.0 + s2 * (-0.189 + s2 * (0.056 - 0.0816 * s2)))
}

/// Irradiance / π of the surroundings between the normal's plane and where the sine is `s`, of radiance that does not depend on the direction, that
/// goes with its part along the normal and up across it, and with the products of those: along twice, up twice, both.
fn sky_to(s: f64, [even, along, up]: [DVec3; 3], [along2, up2, both]: [DVec3; 3]) -> DVec3 {
    let s2 = s * s;
    let c2 = (1.0 - s2).max(0.0);
    0.5 * s * even
        + square_cosines(s) * along
        + FRAC_1_PI * s2 * up
        + s * (1.0 - 0.5 * s2) * along2
        + (0.5 * s * (s2 - 1.0)) * up2
        - c2 * c2.sqrt() * both
}

/// Irradiance / π that comes from the surroundings (factors of [`super::surroundings::ambient_basis`]) past the lids and lashes to a place of the
/// globe of normal `n` (head frame), whose shade this is, and what the lids send on, whose radiance is `lids`. The lids' edges count as straight and level;
/// past such edges the integral is exact for radiance of the second degree and less, of which these factors are.
pub fn lid_sky(ambient: &[Vec4; 9], shade: &LidShade, n: DVec3, lids: DVec3) -> DVec3 {
    let upper = edge_sine(shade.upper_gap + LID_EDGE_UP_MM, LID_EDGE_MM, n.y);
    let lower = edge_sine(-shade.lower_gap - LID_EDGE_UP_MM, LID_EDGE_MM, n.y).min(upper);
    // What lies between them and the upper edge comes past the lashes.
    let lashes = edge_sine(lash_rise(shade.upper_gap), 1.0, n.y).clamp(lower, upper);
    let passed = 1.0 - LASH_DARK * LASH_SHARE;
    let open = 0.5 * (mix(lashes, upper, passed) - lower);
    // Along the normal, and up across it.
    let t = (DVec3::Y - n.y * n) / (1.0 - n.y * n.y).max(1e-4).sqrt();
    let factors = ambient.map(|factor| factor.truncate().as_dvec3());
    let first = [factors[0], rising(&factors, n), rising(&factors, t)];
    let second = [
        crossing(&factors, n, n),
        crossing(&factors, t, t),
        crossing(&factors, n, t),
    ];
    let to = |s: f64| sky_to(s, first, second);
    let sky = to(lashes).lerp(to(upper), passed) - to(lower);
    sky.max(DVec3::ZERO) + LIDS_SEND * (1.0 - open) * lids
}

/// The part of the first degree along `d`.
fn rising(factors: &[DVec3; 9], d: DVec3) -> DVec3 {
    factors[1] * d.y + factors[2] * d.z + factors[3] * d.x
}

/// The part of the second degree along `a` and `b`.
fn crossing(factors: &[DVec3; 9], a: DVec3, b: DVec3) -> DVec3 {
    factors[4] * (0.5 * (a.x * b.y + a.y * b.x))
        + factors[5] * (0.5 * (a.y * b.z + a.z * b.y))
        + factors[6] * (3.0 * a.z * b.z - a.dot(b))
        + factors[7] * (0.5 * (a.x * b.z + a.z * b.x))
        + factors[8] * (a.x * b.x - a.y * b.y)
}

/// What of the lids' own radiance their edges and lashes have, which see half of the light (a choice).
pub const LIDS_SEND: f64 = 0.5;

/// How much of the sky the lids leave to a place of the iris, `depth` mm behind their edges in an aqueous of this `index`, whose shade this is:
/// light comes there from all of the sky through a cone, of which an edge hides a half and more where it hangs before the place.
/// Of the rest they send on.
pub fn lid_sky_within(shade: &LidShade, depth: f64, index: f64) -> f64 {
    // The share of a sky's irradiance that is not behind a straight edge, by the sine of how far up it is seen.
    let open = |gap: f64| {
        let sine = gap / (gap * gap + depth * depth).sqrt().max(0.1);
        0.5 + 0.5 * (index * sine).clamp(-1.0, 1.0)
    };
    (open(shade.upper_gap) + open(shade.lower_gap) - 1.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::surroundings::Surroundings;
    use core::f64::consts::PI;

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
                aside: 0.0,
                upper_gap: gap,
                lower_gap: 1e6,
            };
            let exact = f64::from(open) / f64::from(all);
            let ours = lid_sky_within(&shade, depth, index);
            // Lids send back about a quarter of what they keep, so the light differs by three quarters of that.
            assert!(0.75 * (ours - exact).abs() < 0.03, "{gap}: {ours} {exact}");
        }
    }

    /// Light from all directions of a sky that is three times as bright above as at the horizon, and of a ground, past two straight edges and
    /// the lashes' sheet, added up direction by direction.
    #[test]
    fn the_sky_that_lids_leave_is_that_of_all_directions_between_them() {
        let overcast = |d: DVec3| if d.y > 0.0 { 1.0 + 2.0 * d.y } else { 0.4 } / 3.0;
        // Of the second degree, in all nine factors.
        let soft = |d: DVec3| {
            0.5 + 0.3 * d.y - 0.1 * d.z
                + 0.15 * d.x
                + 0.2 * d.y * d.y
                + 0.1 * d.y * d.z
                + 0.1 * d.x * d.x
                - 0.12 * d.x * d.y
                + 0.09 * d.x * d.z
        };
        let radiance = |d: DVec3| DVec3::new(soft(d), overcast(d), 0.0);
        let around = Surroundings::new(256, radiance, |_| DVec3::ZERO, Vec::new());
        let ambient = around.ambient.map(|c| c.extend(0.0));
        let passed = 1.0 - LASH_DARK * LASH_SHARE;
        let lids = DVec3::new(0.3, 0.2, 0.0);
        let mut worst = DVec3::ZERO;
        for (aside_deg, rise_deg, gaps) in [
            (0.0_f64, 0.0_f64, [4.0, 6.0]),
            (40.0, 15.0, [0.5, 9.0]),
            (0.0, 20.0, [0.0, 10.0]),
            (-35.0, 15.0, [2.0, 8.0]),
            (50.0, -15.0, [8.0, 2.0]),
            (0.0, -20.0, [9.0, 0.3]),
            (-20.0, 10.0, [-1.5, 9.0]),
        ] {
            let (sin, cos) = rise_deg.to_radians().sin_cos();
            let (aside, ahead) = aside_deg.to_radians().sin_cos();
            let n = DVec3::new(cos * aside, sin, -cos * ahead);
            let forward = DVec3::new(aside, 0.0, -ahead);
            let shade = LidShade {
                aside: 0.0,
                upper_gap: gaps[0],
                lower_gap: gaps[1],
            };
            let (mut sky, mut left, mut all) = (DVec3::ZERO, 0.0, 0.0);
            let count = 400;
            for i in 0..count {
                for j in 0..2 * count {
                    let z = (f64::from(i) + 0.5) / f64::from(count) * 2.0 - 1.0;
                    let (s, c) = (f64::from(j) / f64::from(count) * PI).sin_cos();
                    let d = DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z);
                    let cosine = d.dot(n).max(0.0);
                    // Edges lie level across the normal's way: a ray passes below one that is higher where the ray has come as far forward.
                    let (up, far) = (d.y, d.dot(forward));
                    let under = |high: f64, before: f64| up * before < far * high;
                    let below =
                        under(gaps[0] + LID_EDGE_UP_MM, LID_EDGE_MM) && (far > 0.0 || up < 0.0);
                    let above =
                        !under(-gaps[1] - LID_EDGE_UP_MM, LID_EDGE_MM) || (far < 0.0 && up > 0.0);
                    let behind = !under(lash_rise(gaps[0]), 1.0);
                    let open = match (below && above, behind) {
                        (false, _) => 0.0,
                        (true, true) => passed,
                        (true, false) => 1.0,
                    };
                    all += cosine;
                    sky += cosine * open * radiance(d);
                    left += cosine * open;
                }
            }
            let (sky, open) = (sky / all, left / all);
            let exact = sky + LIDS_SEND * (1.0 - open) * lids;
            let ours = lid_sky(&ambient, &shade, n, lids);
            println!("{rise_deg} {gaps:?}: {ours:.4} {exact:.4}, open {open:.3}");
            worst = worst.max((ours - exact).abs());
        }
        // The first is the sum's own error; the second that of nine factors of a sky with a horizon.
        assert!(worst.x < 5e-4 && worst.y < 0.012, "{worst}");
    }

    /// Half of a lamp is left where the ray to its middle just passes an edge that stands before the margin.
    #[test]
    fn the_lids_shadow_falls_where_its_edge_stands_before_the_lamp() {
        for elevation_deg in [-30.0_f64, 0.0, 25.0, 55.0] {
            let (sin, cos) = elevation_deg.to_radians().sin_cos();
            let light = DVec3::new(0.0, sin, -cos);
            let lashes = |shade: &LidShade, light: DVec3| {
                lashes_left(0.0, light, shade.upper_gap, LASH_SHADOW_MM, 0.035)
            };
            let half = (0..4000).map(|i| f64::from(i) * 0.002 - 3.0).find(|gap| {
                let shade = LidShade {
                    aside: 0.0,
                    upper_gap: *gap,
                    lower_gap: 9.0,
                };
                lid_lamp(&shade, light, 0.1) / lashes(&shade, light) >= 0.5
            });
            // The lower lid, whose edges are where the upper's are, mirrored.
            let half_above = (0..4000).map(|i| f64::from(i) * 0.002 - 3.0).find(|gap| {
                let shade = LidShade {
                    aside: 0.0,
                    upper_gap: 9.0,
                    lower_gap: *gap,
                };
                lid_lamp(&shade, DVec3::new(0.0, -sin, -cos), 0.1) >= 0.5
            });
            // From there up to the edge, as the lamp's ray goes; or where the lid touches.
            let edge = LID_EDGE_MM * elevation_deg.to_radians().tan() - LID_EDGE_UP_MM;
            let edge = edge.max(0.0);
            assert!(
                (half.expect("a border") - edge).abs() < 0.005,
                "{elevation_deg}"
            );
            if elevation_deg >= 0.0 {
                assert!((half_above.expect("a border") - edge).abs() < 0.005);
            }
        }
    }

    /// A small lamp throws each lash's shadow, a wide one that of all.
    #[test]
    fn lashes_throw_their_shadow() {
        let light = DVec3::new(0.0, 0.88, -0.475);
        let along = |radius: f64| {
            let left = (0..200).map(move |k| {
                let shade = LidShade {
                    aside: 0.02 * f64::from(k),
                    upper_gap: 2.5,
                    lower_gap: 8.0,
                };
                lid_lamp(&shade, light, radius)
            });
            let (low, high) = left.fold((9.0_f64, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        assert!(
            along(0.01) > 0.1 && along(0.6) < 0.02,
            "{} {}",
            along(0.01),
            along(0.6)
        );
    }
}
