//! The two-point problem of a stop behind refracting surfaces: which ray of a viewer passes a given
//! point of it.
//!
//! In: a map from points of the viewer's plane to points of the stop's (the trace), a target. Out: the
//! point of view whose ray meets the target, to [`FOUND_MM`].

use glam::{DMat2, DVec2};

/// Distance on the plane of the stop (mm) at which a ray counts as found.
const FOUND_MM: f64 = 1e-11;
/// Step of the difference quotients (mm): the Jacobian is good to 1e-7, so Newton gains seven digits a
/// step.
const DIFFERENCE_MM: f64 = 1e-6;

/// A point of the view whose ray reaches the plane of the stop, as near to its centre as a coarse
/// search along the foreshortened direction finds.
pub(in crate::optics) fn search_start(
    centre: DVec2,
    oblique: DVec2,
    to_stop: &impl Fn(DVec2) -> Option<DVec2>,
) -> Option<DVec2> {
    let mut best = None;
    let mut nearest = f64::INFINITY;
    for i in -32..=32_i32 {
        let at = 0.25 * f64::from(i) * oblique;
        if let Some(point) = to_stop(at) {
            let distance = point.distance_squared(centre);
            if distance < nearest {
                (nearest, best) = (distance, Some(at));
            }
        }
    }
    best
}

/// The point of the view whose ray meets the plane of the stop at `target`, and the Jacobian there.
///
/// Newton's method with Broyden's update of the Jacobian, which asks for one ray a step; where that
/// does not gain, difference quotients and steps short enough to come nearer.
pub(in crate::optics) fn find(
    target: DVec2,
    start: DVec2,
    slope: Option<DMat2>,
    to_stop: &impl Fn(DVec2) -> Option<DVec2>,
) -> Option<(DVec2, DMat2)> {
    let mut at = start;
    let mut miss = to_stop(at)? - target;
    let mut fresh = slope.is_none();
    let mut slope = match slope {
        Some(slope) => slope,
        None => jacobian(at, to_stop)?,
    };
    for _ in 0..40 {
        if miss.length_squared() < FOUND_MM * FOUND_MM {
            return Some((at, slope));
        }
        let whole = -(slope.inverse() * miss);
        if !whole.is_finite() {
            return None;
        }
        // A step of more than 2 mm would leave the cornea.
        let mut step = whole.clamp_length_max(2.0);
        let mut better = None;
        for _ in 0..if fresh { 12 } else { 1 } {
            if let Some(point) = to_stop(at + step) {
                let next = point - target;
                if next.length_squared() < 0.25 * miss.length_squared()
                    || (fresh && next.length_squared() < 0.9 * miss.length_squared())
                {
                    better = Some(next);
                    break;
                }
            }
            step *= 0.5;
        }
        match better {
            Some(next) => {
                let surprise = (next - miss - slope * step) / step.length_squared();
                slope += DMat2::from_cols(surprise * step.x, surprise * step.y);
                at += step;
                miss = next;
                fresh = false;
            }
            None if fresh => {
                // Rounding is all that is left, or no ray goes there.
                return (miss.length() < 1e3 * FOUND_MM).then_some((at, slope));
            }
            None => {
                slope = jacobian(at, to_stop)?;
                fresh = true;
            }
        }
    }
    None
}

/// Derivatives of the point on the stop by the point of the view.
fn jacobian(at: DVec2, to_stop: &impl Fn(DVec2) -> Option<DVec2>) -> Option<DMat2> {
    let here = to_stop(at)?;
    // At the edge of what refracts, one side is enough.
    let along = |axis: DVec2| {
        let step = DIFFERENCE_MM * axis;
        match to_stop(at + step) {
            Some(there) => Some((there - here) / DIFFERENCE_MM),
            None => Some((here - to_stop(at - step)?) / DIFFERENCE_MM),
        }
    };
    Some(DMat2::from_cols(along(DVec2::X)?, along(DVec2::Y)?))
}
