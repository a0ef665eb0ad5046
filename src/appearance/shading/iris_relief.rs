//! The relief of the iris over its plane: where the refracted ray meets it and what it puts in the
//! way of light. Twin: `shaders/lib/iris_relief.wgsl`.

use super::mix;
use crate::appearance::images::MapView;
use crate::appearance::iris_map::{DESIGN_PUPIL_RADIUS_MM, ROOT_RADIUS_MM};
use crate::tissue::iris_reflectance::BORDER_LAYER_MM;
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
    /// Slope of the cone in which it falls back from the pupil's edge to its root.
    pub cone: f64,
    /// How far its middle stands before that cone, four times, over its width: by how much its slope is less at the pupil, more at the root.
    pub bow: f64,
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
    /// Thickness of border layer and stroma, mm, as if the latter were as dense everywhere.
    pub thickness: f64,
    /// Melanin of the border layer.
    pub melanin: f64,
}

/// Density of the stroma's bundles, which lie in front, and of the loose mesh behind them, against the mean of the map. An iris' fibres are
/// vessels in thick sheaths of collagen, about as deep as wide, before a mesh that is mostly aqueous (Hogan, Alvarado and Weddell 1971);
/// the two numbers, and how deep the mesh goes, are choices that make them so: 0.15 mm deep where they are stoutest.
const BUNDLE_DENSITY: f64 = 4.0;
const MESH_DENSITY: f64 = 0.25;
/// Depth of the stroma's back where it is not bare of bundles, mm of the map.
const STROMA_BACK_MM: f64 = 0.45;

/// Depth (mm, from behind the border layer) of the bundles where there is so much stroma in all (mm as dense as the mean).
pub fn bundle_depth(stroma: f64, iris: &IrisFrame) -> f64 {
    let mesh = MESH_DENSITY * STROMA_BACK_MM * iris.thicken;
    (stroma - mesh).max(0.0) / (BUNDLE_DENSITY - MESH_DENSITY)
}

/// Depth (mm, from behind the border layer) of the black epithelium there.
pub fn stroma_back(stroma: f64, iris: &IrisFrame) -> f64 {
    (stroma / MESH_DENSITY).min(STROMA_BACK_MM * iris.thicken)
}

/// Its density at this depth (mm, from behind the border layer), against the mean of the map; `None` behind its back.
pub fn stroma_density(depth: f64, stroma: f64, iris: &IrisFrame) -> Option<f64> {
    let is_bundle = depth < bundle_depth(stroma, iris);
    let density = if is_bundle {
        BUNDLE_DENSITY
    } else {
        MESH_DENSITY
    };
    (depth < stroma_back(stroma, iris)).then_some(density)
}

/// How much stroma (mm as dense as the mean) lies over this depth (mm, from behind the border layer) where there is so much in all.
pub fn stroma_over(depth: f64, stroma: f64, iris: &IrisFrame) -> f64 {
    let bundles = bundle_depth(stroma, iris);
    let over = BUNDLE_DENSITY * depth.min(bundles) + MESH_DENSITY * (depth - bundles).max(0.0);
    over.clamp(0.0, stroma)
}

/// Place in the iris map, and what small steps from it need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisPlace {
    /// u the angle, v from the pupil's edge to the root.
    pub uv: DVec2,
    /// Unit direction away from the pupil.
    pub away: DVec2,
    /// One over the distance from the pupil's middle, 1/mm.
    pub bend: f64,
    /// One over the width of the iris, 1/mm.
    pub dv: f64,
    /// By what the pupil's part in places falls with a step, 1/mm.
    pub fall: DVec2,
}

/// How far (mm) the mean iris lies behind the plane of the pupil's edge at this part of its width, 0 at that edge and 1 at the root, and
/// how fast it falls back there; level within the pupil and from a tenth past the root on.
pub fn iris_base(v: f64, iris: &IrisFrame) -> DVec2 {
    let part = v.clamp(0.0, 1.1);
    let falls = if part == v { 1.0 } else { 0.0 };
    DVec2::new(
        iris.width() * part * (iris.cone - iris.bow * (1.0 - part)),
        falls * (iris.cone - iris.bow * (1.0 - 2.0 * part)),
    )
}

/// Unit direction away from the pupil's middle at a point (mm), and the distance from there.
pub fn iris_away(p: DVec2, iris: &IrisFrame) -> DVec3 {
    let q = p - iris.center * (1.0 - p.length() / iris.root);
    let r = q.length().max(0.2);
    (q / r).extend(r)
}

/// How fast the mean iris falls back at a place, along x and y.
pub fn iris_lean(place: &IrisPlace, iris: &IrisFrame) -> DVec2 {
    let out = place.away + place.fall * iris.center.dot(place.away);
    out * iris_base(place.uv.y, iris).y
}

/// A direction as it is over an iris that is laid flat by moving all of it along the axis: lengths along rays and depths along the
/// axis stay what they are.
pub fn iris_within(direction: DVec3, lean: DVec2) -> DVec3 {
    direction - DVec3::Z * lean.dot(direction.truncate())
}

/// Where (mm) a ray that crosses the plane of the pupil's edge at `point` meets the mean iris: by two steps after Newton (tests
/// say how near).
pub fn iris_landing(point: DVec2, direction: DVec3, iris: &IrisFrame) -> DVec2 {
    let slope = direction.truncate() / direction.z.max(0.2);
    let mut depth = 0.0;
    for _ in 0..2 {
        let away = iris_away(point + slope * depth, iris);
        let base = iris_base((away.z - iris.pupil) / iris.width(), iris);
        let nears = 1.0 - base.y * away.truncate().dot(slope);
        depth += (base.x - depth) / nears.max(0.3);
    }
    point + slope * depth
}

/// The place in the map of a point (mm) of the iris.
pub fn iris_place(p: DVec2, iris: &IrisFrame) -> IrisPlace {
    let out = iris_away(p, iris);
    let dv = 1.0 / iris.width();
    IrisPlace {
        uv: DVec2::new(out.y.atan2(out.x) / TAU + 0.5, (out.z - iris.pupil) * dv),
        away: out.truncate(),
        bend: 1.0 / out.z,
        dv,
        fall: p / (p.length().max(0.2) * iris.root),
    }
}

/// The place in the map a step (mm) away, to the third order of it: within a micrometre for a tenth of the distance from the
/// pupil's middle.
pub fn iris_step(iris: &IrisFrame, place: &IrisPlace, step: DVec2) -> DVec2 {
    let moved = step + iris.center * place.fall.dot(step);
    let (out, round) = (place.away.dot(moved), place.away.perp_dot(moved));
    let (o, t) = (out * place.bend, round * place.bend);
    let turn = t * (1.0 - o + o * o - t * t / 3.0);
    place.uv + DVec2::new(turn / TAU, (out + 0.5 * round * t * (1.0 - o)) * place.dv)
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

/// Square of the aqueous' index.
const AQUEOUS_SQUARED: f64 = 1.336 * 1.336;

/// Level of a map of this size (texels) at a place of the iris for a pixel of this footprint (mm), whose ray goes in the unit direction
/// `direction` within the aqueous and sees the iris the longer along its slant, the flatter it is there and before the cornea (their
/// geometric mean: 1.6 times from 60°, where the pupil is 0.62 times as wide as high); a little sharper than that, as the eye forgives
/// more than it misses, but where ridges stand before each other.
pub fn iris_level(size: DVec2, footprint: f64, direction: DVec3, place: &IrisPlace) -> f64 {
    let slant = direction.truncate().length_squared();
    let before = (1.0 - AQUEOUS_SQUARED * slant).max(0.05);
    let longer = 1.0 / (before * (1.0 - slant).max(0.05)).sqrt() - 1.0;
    let out = direction.truncate().dot(place.away).powi(2) / slant.max(1e-6);
    let along = DVec2::new(1.0 + longer * (1.0 - out), 1.0 + longer * out);
    let texel = DVec2::new(TAU / place.bend.min(1.0), 1.0 / place.dv) / size;
    let texels = along.map(f64::sqrt) * footprint / texel;
    (texels.max_element().log2() - 0.4 + slant).max(0.0)
}

/// Half of a fibre's width, mm: what a step may not leave out however fine the map is.
const STRAND_MM: f64 = 0.05;

/// How an iris is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisMarch {
    /// Fewest steps of the view to its relief.
    pub fewest: f64,
    /// Most steps.
    pub most: f64,
    /// How long a step is along the iris, in texels, or in [`STRAND_MM`] where those are finer.
    pub stride: f64,
    /// How far behind it the view is followed, as a multiple of how deep its back is there.
    pub reach: f64,
    /// In how many segments behind the border layer.
    pub segments: usize,
    /// By how many looks light's way to each of them is known.
    pub looks: usize,
}

/// By what a pixel shows, as far as a rasteriser on processors goes.
pub const IRIS_MARCH_FAST: IrisMarch = IrisMarch {
    fewest: 5.0,
    most: 24.0,
    stride: 0.6,
    reach: 1.5,
    segments: 5,
    looks: 4,
};
/// By what a pixel shows, in a picture that is to be kept.
pub const IRIS_MARCH_FULL: IrisMarch = IrisMarch {
    fewest: 8.0,
    most: 48.0,
    stride: 0.25,
    reach: 1.6,
    segments: 8,
    looks: 4,
};
/// The plain way, which the others are measured against.
pub const IRIS_MARCH_FIXED: IrisMarch = IrisMarch {
    fewest: 64.0,
    most: 64.0,
    segments: 64,
    ..IRIS_MARCH_FULL
};

/// How far (mm) the refracted ray that lands at this place of the mean iris has moved aside where it meets the relief: the
/// first place where the ray ([`iris_within`]) is below the surface, by even steps and two secants.
pub fn relief_march(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    direction: DVec3,
    lod: f64,
    march: &IrisMarch,
) -> DVec2 {
    let slope = direction.truncate() / direction.z.max(0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20 * iris.thicken * iris.relief.max(1.0);
    let deepest = 2.0 * top;
    let texel = iris_texel_mm(map.size().y, lod, iris);
    let steps = (slope.length() * deepest / (march.stride * texel.max(STRAND_MM)))
        .ceil()
        .clamp(march.fewest, march.most);
    let gap_at = |depth: f64| {
        let step = iris_step(iris, place, slope * (depth - top));
        depth - top + iris_texel(map, iris, step, lod).height
    };
    let (mut before, mut gap_before) = (0.0, -0.05);
    for i in 1..=steps as u32 {
        let depth = deepest * f64::from(i) / steps;
        let gap = gap_at(depth);
        if gap >= 0.0 {
            let first = mix(before, depth, gap_before / (gap_before - gap));
            // Again between the nearer two.
            let left = gap_at(first);
            let [low, high] = if left >= 0.0 {
                [(before, gap_before), (first, left)]
            } else {
                [(first, left), (depth, gap)]
            };
            let part = low.1 / (low.1 - high.1).min(-1e-6);
            return slope * (mix(low.0, high.0, part.clamp(0.0, 1.0)) - top);
        }
        (before, gap_before) = (depth, gap);
    }
    slope * (deepest - top)
}

/// The normal at a place, from four heights of the relief `e` mm apart and how the iris leans.
pub fn relief_normal(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    e: f64,
    lod: f64,
    lean: DVec2,
) -> DVec3 {
    let height = |step: DVec2| iris_texel(map, iris, iris_step(iris, place, step), lod).height;
    let rise = |axis: DVec2| height(axis * (0.5 * e)) - height(axis * (-0.5 * e));
    let slope = DVec2::new(rise(DVec2::X), rise(DVec2::Y)) / e;
    (lean - slope).extend(-1.0).normalize()
}

/// Stroma that a reading has, mm as dense as the mean.
pub fn stroma_of(texel: &IrisTexel) -> f64 {
    (texel.thickness - BORDER_LAYER_MM).max(0.0)
}

/// Path (mm) of light from the direction `towards` ([`iris_within`]) through the relief to what lies `under` mm below the mean iris at
/// this place of it, the melanin of the border layer where it came in, and the stroma (mm as dense as the mean) on its way: by this many looks
/// along it, further apart the higher they are. Tissue that it crosses behind the first place where it leaves some is counted too.
pub fn relief_way(
    map: &MapView,
    iris: &IrisFrame,
    place: &IrisPlace,
    under: f64,
    towards: DVec3,
    lod: f64,
    looks: usize,
) -> DVec3 {
    let up = (-towards.z).max(0.25);
    // Up to the highest ridges.
    let all = (under + 0.2 * iris.thicken * iris.relief.max(1.0)).max(0.01) / up;
    let (mut way, mut melanin, mut stroma, mut begins) = (0.0, 0.0, 0.0, 0.0);
    for i in 1..=looks {
        let part = i as f64 / looks as f64;
        let ends = all * part * part.sqrt();
        let middle = 0.5 * (begins + ends);
        let step = iris_step(iris, place, towards.truncate() * middle);
        let there = iris_texel(map, iris, step, lod);
        let above = under - up * middle + there.height;
        let half = 0.5 * up * (ends - begins);
        let inside = (0.5 * above / half + 0.5).clamp(0.0, 1.0);
        way += inside * (ends - begins);
        let [low, high] = [above - half, above + half].map(|depth| {
            let behind = (depth - BORDER_LAYER_MM).max(0.0);
            stroma_over(behind, stroma_of(&there), iris)
        });
        stroma += (high - low) / up;
        if inside > 0.0 {
            melanin = there.melanin;
        }
        begins = ends;
    }
    DVec3::new(way, melanin, stroma)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_step_leads_where_the_place_itself_is() {
        let iris = frame();
        for (r, reach, most_mm) in [(2.0, 0.2, 1e-3), (3.0, 0.5, 5e-3), (5.0, 0.5, 2e-3)] {
            let mut worst = 0.0_f64;
            for i in 0..16 {
                for j in 0..16 {
                    let turned = |k: i32, r: f64| DVec2::from_angle(f64::from(k) * TAU / 16.0) * r;
                    let (p, step) = (turned(i, r), turned(j, reach));
                    let truth = iris_place(p + step, &iris);
                    let found = iris_step(&iris, &iris_place(p, &iris), step);
                    let turn = (found.x - truth.uv.x + 0.5).rem_euclid(1.0) - 0.5;
                    let off =
                        DVec2::new(turn * TAU / truth.bend, (found.y - truth.uv.y) / truth.dv);
                    worst = worst.max(off.length());
                }
            }
            assert!(worst < most_mm, "{r}: {worst}");
            // The straight step of the first order is further off.
            let place = iris_place(DVec2::new(r, 0.0), &iris);
            let straight = IrisPlace { bend: 0.0, ..place };
            let step = DVec2::new(0.0, reach);
            let of = |place: &IrisPlace| iris_step(&iris, place, step).y;
            assert!(
                (of(&place) - of(&straight)).abs() / place.dv > 2.0 * worst,
                "{r}: {worst}"
            );
        }
    }

    #[test]
    fn rays_land_on_the_mean_iris() {
        // As healthy, bulging forward, bowed back, steep, and towards the cornea.
        let shapes = [
            (0.146, 0.0, 1e-4),
            (0.2, 0.37, 2e-3),
            (0.05, -0.37, 2e-3),
            (0.36, 0.0, 1e-3),
            (-0.09, 0.0, 1e-4),
        ];
        for (cone, bow, most_mm) in shapes {
            let (mut worst, mut ignored) = (0.0_f64, 0.0_f64);
            for pupil in [0.5, 1.75, 4.4] {
                let iris = IrisFrame {
                    pupil,
                    cone,
                    bow,
                    ..frame()
                };
                for i in 0..240 {
                    for j in 0..24 {
                        let part = f64::from(i / 24) / 10.0;
                        let turned =
                            |k: i32, r: f64| DVec2::from_angle(f64::from(k) * TAU / 24.0) * r;
                        let point = turned(i, pupil + 0.1 + part * (5.8 - pupil));
                        let direction = turned(j, 0.6).extend(0.8);
                        let at = iris_landing(point, direction, &iris);
                        let v = iris_place(at, &iris).uv.y;
                        if !(0.02..1.0).contains(&v) {
                            continue;
                        }
                        // Where it is, along the ray, and how far before or behind the mean iris that is.
                        let slope = direction.truncate() / direction.z;
                        let depth = (at - point).dot(slope) / slope.length_squared();
                        let base = iris_base(v, &iris).x;
                        worst = worst.max((depth - base).abs());
                        ignored = ignored.max(base.abs());
                    }
                }
            }
            println!("cone {cone}, bow {bow}: {worst:.1e} of {ignored:.2} mm");
            assert!(worst < most_mm, "{cone} {bow}: {worst}");
        }
    }

    fn frame() -> IrisFrame {
        IrisFrame {
            root: 6.05,
            pupil: 1.75,
            limbus: 5.85,
            relief: 1.0,
            center: DVec2::new(0.25, -0.1),
            thicken: 1.0,
            furrows: 1.0,
            cone: 0.15,
            bow: 0.1,
        }
    }

    #[test]
    fn an_iris_that_is_laid_flat_keeps_lengths_and_depths() {
        let iris = IrisFrame {
            cone: 0.2,
            bow: 0.3,
            ..frame()
        };
        let p = DVec2::new(-2.0, 3.0);
        let lean = iris_lean(&iris_place(p, &iris), &iris);
        let base = |p: DVec2| iris_base(iris_place(p, &iris).uv.y, &iris).x;
        // It is the slope of what it leans by.
        let e = 1e-5;
        let slope =
            [DVec2::X, DVec2::Y].map(|axis| (base(p + axis * e) - base(p - axis * e)) / (2.0 * e));
        assert!(lean.distance(DVec2::from(slope)) < 1e-8);
        // A step along a ray goes down over it by so much.
        let direction = DVec3::new(0.5, -0.3, 0.81).normalize();
        let step = 1e-4;
        let down = direction.z * step - (base(p + direction.truncate() * step) - base(p));
        assert!((iris_within(direction, lean).z * step - down).abs() < 1e-8);
        // Between pupil and root it stands before its cone by its bow.
        assert!((iris_base(0.5, &iris).x - 4.3 * (0.5 * 0.2 - 0.25 * 0.3)).abs() < 1e-12);
        assert!((base(DVec2::new(6.05, 0.0)) - 4.3 * 0.2).abs() < 1e-12);
    }

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
