//! The relief of the iris over its plane: where the refracted ray meets it and what it puts in the
//! way of light. Twin: `shaders/lib/iris_relief.wgsl`.

use super::mix;
use crate::appearance::images::MapView;
use crate::appearance::iris_map::{DESIGN_PUPIL_RADIUS_MM, ROOT_RADIUS_MM};
use core::f64::consts::TAU;
use glam::{DVec2, DVec3};

/// What the shader must know of the iris to find a place in its map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisFrame {
    /// Radius of the root, mm.
    pub root: f64,
    /// Radius of the pupil, mm.
    pub pupil: f64,
    /// Radius of the limbus, mm.
    pub limbus: f64,
    /// How many times as high as its own the relief is.
    pub relief: f64,
    /// Centre of the pupil, mm.
    pub center: DVec2,
    /// How many times as thick as in the map the stroma is: it keeps its volume as the pupil opens.
    pub thicken: f64,
    /// How deep its contraction furrows are, 1 as in the map.
    pub furrows: f64,
}

impl IrisFrame {
    /// Width (mm) from pupil to root (`iris_width` of the shader).
    pub fn width(&self) -> f64 {
        (self.root - self.pupil).max(0.5)
    }
}

/// Widest pupil that a tag holds, mm of its radius.
const TAGGED_MM: f64 = 8.0;

/// Half of the tag of a globe's mesh: a pupil of this radius, mm, 0 to 8.
pub fn pupil_code(radius_mm: f64) -> u32 {
    // What is not a number counts as none.
    (radius_mm / TAGGED_MM * 65535.0)
        .round()
        .clamp(0.0, 65535.0) as u32
}

/// Radius (mm) of the pupil in the tag of a globe's mesh, whose other half is the age of its tear film.
pub fn tagged_pupil(tag: u32) -> f64 {
    f64::from(tag & 0xffff) * (TAGGED_MM / 65535.0)
}

/// How many times as thick as in its map the stroma is at a pupil of this radius, mm: it keeps its volume.
pub fn thicken(pupil_radius_mm: f64, root_radius_mm: f64) -> f64 {
    let root = root_radius_mm.max(1.0);
    let area = |pupil: f64| root * root - pupil * pupil;
    let pupil = pupil_radius_mm.clamp(0.0, root - 0.5);
    area(f64::from(DESIGN_PUPIL_RADIUS_MM).min(root - 0.5)) / area(pupil)
}

/// Pupil radius at which the iris is stretched flat and its furrows are gone, mm.
const FLAT_PUPIL_RADIUS_MM: f64 = 0.75;

/// How deep the furrows are at a pupil of this radius, mm, against the map's: a fold of a given length along the surface
/// deepens with the root of what it is shortened by.
pub fn furrow_depth(pupil_radius_mm: f64) -> f64 {
    let shortened = |pupil: f64| {
        let flat = f64::from(ROOT_RADIUS_MM) - FLAT_PUPIL_RADIUS_MM;
        ((pupil - FLAT_PUPIL_RADIUS_MM) / flat).clamp(0.0, 1.0)
    };
    (shortened(pupil_radius_mm) / shortened(f64::from(DESIGN_PUPIL_RADIUS_MM))).sqrt()
}

/// A reading of the iris map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisTexel {
    /// Height over the mean plane, mm.
    pub height: f64,
    /// Thickness of the stroma, mm.
    pub thickness: f64,
    /// Melanin of the border layer.
    pub melanin: f64,
}

/// Place in the iris map and how it changes with a step on the iris plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisPlace {
    /// u the angle, v from the pupil's edge to the root.
    pub uv: DVec2,
    /// Change of u by mm.
    pub du: DVec2,
    /// Change of v by mm.
    pub dv: DVec2,
}

/// The place in the map of a point of the iris plane.
pub fn iris_place(p: DVec2, iris: &IrisFrame) -> IrisPlace {
    let q = p - iris.center * (1.0 - p.length() / iris.root);
    let r = q.length().max(0.2);
    IrisPlace {
        uv: DVec2::new(q.y.atan2(q.x) / TAU + 0.5, (r - iris.pupil) / iris.width()),
        du: q.perp() / (TAU * r * r),
        dv: q / (r * iris.width()),
    }
}

/// The place in the map a step (mm) away.
pub fn iris_step(place: &IrisPlace, step: DVec2) -> DVec2 {
    place.uv + DVec2::new(place.du.dot(step), place.dv.dot(step))
}

/// A reading of the map, which ends a thousandth within its edges.
pub fn iris_texel(map: &MapView, iris: &IrisFrame, uv: DVec2, lod: f64) -> IrisTexel {
    let [thickness, melanin, height, furrow] =
        map.sample(DVec2::new(uv.x, uv.y.clamp(0.001, 0.999)), lod);
    IrisTexel {
        height: (height * iris.thicken - furrow * iris.furrows) * iris.relief,
        thickness: thickness * iris.thicken,
        melanin,
    }
}

/// Width (mm) of a texel of a map of this many rows, at this level.
pub fn iris_texel_mm(rows: f64, lod: f64, iris: &IrisFrame) -> f64 {
    iris.width() / rows * lod.exp2()
}

/// Level of a map of this size (texels) for a footprint (mm) at `radius` mm from the axis; a little
/// sharper than the footprint, as the eye forgives more than it misses.
pub fn iris_level(size: DVec2, footprint: f64, radius: f64, width: f64) -> f64 {
    let texels = footprint * size / DVec2::new(TAU * radius.max(1.0), width);
    (texels.max_element().log2() - 0.4).max(0.0)
}

/// Fewest and most steps of the march.
pub const RELIEF_STEPS: [f64; 2] = [3.0, 12.0];

/// How far (mm, on the iris plane) the refracted ray has moved where it meets the relief: the first
/// place where the ray is below the surface, by steps of two texels of this level, of these fewest and most, and one secant.
pub fn relief_march(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    direction: DVec3,
    lod: f64,
    between: [f64; 2],
) -> DVec2 {
    let slope = direction.truncate() / direction.z.max(0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20 * iris.thicken * iris.relief.max(1.0);
    let deepest = 2.0 * top;
    let texel = iris_texel_mm(map.size().y, lod, iris);
    let steps = (slope.length() * deepest / (2.0 * texel))
        .ceil()
        .clamp(between[0], between[1]);
    let (mut before, mut gap_before) = (0.0, -0.05);
    for i in 1..=steps as u32 {
        let depth = deepest * f64::from(i) / steps;
        let below = iris_step(place, slope * (depth - top));
        let gap = depth - top + iris_texel(map, iris, below, lod).height;
        if gap >= 0.0 {
            return slope * (mix(before, depth, gap_before / (gap_before - gap)) - top);
        }
        (before, gap_before) = (depth, gap);
    }
    slope * (deepest - top)
}

/// The relief's normal, from three heights on a circle `e` mm across.
pub fn relief_normal(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    e: f64,
    lod: f64,
) -> DVec3 {
    let r = 0.5 * e;
    let height = |x: f64, y: f64| {
        let step = DVec2::new(x, y) * r;
        iris_texel(map, iris, iris_step(place, step), lod).height
    };
    let half_root = 0.75_f64.sqrt();
    let (upper, left, right) = (
        height(0.0, 1.0),
        height(-half_root, -0.5),
        height(half_root, -0.5),
    );
    let slope = DVec2::new(
        (right - left) / (2.0 * half_root),
        (upper - 0.5 * (left + right)) / 1.5,
    ) / r;
    (-slope).extend(-1.0).normalize()
}

/// Path (mm) of light from the unit direction `towards` through the relief to what lies `depth` mm below its surface,
/// `under` mm below its mean plane and the step `aside` (mm) from a place of it: where the light crossed the surface, by a
/// secant and a step of Newton's.
#[expect(clippy::too_many_arguments, reason = "the shader twin's argument list")]
pub fn relief_way(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    aside: DVec2,
    under: f64,
    depth: f64,
    towards: DVec3,
    lod: f64,
) -> f64 {
    let up = (-towards.z).max(0.25);
    let deep = depth.max(0.02);
    let height = |way: f64| {
        let step = aside + towards.truncate() * way;
        iris_texel(map, iris, iris_step(place, step), lod).height
    };
    let first = deep / up;
    let there = under - deep + height(first);
    let second = first * (deep / (deep - there).max(0.25 * deep)).clamp(0.3, 4.0);
    let left = under - up * second + height(second);
    (second + left / up).max(0.3 * first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_iris_keeps_its_volume_and_folds_as_the_pupil_opens() {
        let design = f64::from(DESIGN_PUPIL_RADIUS_MM);
        assert!((thicken(design, 6.05) - 1.0).abs() < 1e-12);
        // (6.05² − 1.75²)/(6.05² − 4²) by hand.
        assert!((thicken(4.0, 6.05) - 33.54 / 20.6025).abs() < 1e-4);
        assert!((furrow_depth(design) - 1.0).abs() < 1e-12);
        assert_eq!(furrow_depth(0.7), 0.0);
        assert!((1.7..2.0).contains(&furrow_depth(4.0)));
        for wild in [-1.0, 100.0] {
            assert!(thicken(wild, 6.0).is_finite() && furrow_depth(wild).is_finite());
        }
    }
}
