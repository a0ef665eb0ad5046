// The relief of the iris over its plane: where the refracted ray meets it and what it puts in the way of
// light. Twin: src/appearance/shading/iris_relief.rs.

// Radii (mm) of the root, the pupil and the limbus, how many times as high as its own the relief is, the pupil's centre (mm), how many
// times as thick as in the map the stroma is (it keeps its volume), and how deep its furrows are (1 as in the map).
struct IrisFrame { root: f32, pupil: f32, limbus: f32, relief: f32, center: vec2f, thicken: f32, furrows: f32 };

// Radii (mm) of the pupil for which the map is made, of its root, and of the pupil at which the iris is stretched flat.
const DESIGN_PUPIL_RADIUS_MM: f32 = 1.75;
const ROOT_RADIUS_MM: f32 = 5.85;
const FLAT_PUPIL_RADIUS_MM: f32 = 0.75;

// Radius (mm) of the pupil in the tag of a globe's mesh, whose other half is the age of its tear film.
fn tagged_pupil(tag: u32) -> f32 {
    return f32(tag & 0xffffu) * (TAGGED_MM / 65535.0);
}

// Widest pupil that a tag holds, mm of its radius.
const TAGGED_MM: f32 = 8.0;

// How many times as thick as in its map the stroma is at a pupil of this radius (mm): it keeps its volume.
fn thicken(pupil_radius: f32, root_radius: f32) -> f32 {
    let root = max(root_radius, 1.0);
    let pupil = clamp(pupil_radius, 0.0, root - 0.5);
    let design = min(DESIGN_PUPIL_RADIUS_MM, root - 0.5);
    return (root * root - design * design) / (root * root - pupil * pupil);
}

// How deep the furrows are at a pupil of this radius (mm) against the map's: a fold of a given length along the surface deepens with
// the root of what it is shortened by.
fn furrow_depth(pupil_radius: f32) -> f32 {
    let shortened = clamp((pupil_radius - FLAT_PUPIL_RADIUS_MM) / (ROOT_RADIUS_MM - FLAT_PUPIL_RADIUS_MM), 0.0, 1.0);
    return sqrt(shortened * ((ROOT_RADIUS_MM - FLAT_PUPIL_RADIUS_MM) / (DESIGN_PUPIL_RADIUS_MM - FLAT_PUPIL_RADIUS_MM)));
}

struct IrisTexel { height: f32, thickness: f32, melanin: f32 };

// Place in the iris map: u the angle, v from the pupil's edge to the root, and how both change
// with a step on the iris plane, so that small steps need no arc tangent.
struct IrisPlace { uv: vec2f, du: vec2f, dv: vec2f };

// Width (mm) of the iris from pupil to root.
fn iris_width(iris: IrisFrame) -> f32 {
    return max(iris.root - iris.pupil, 0.5);
}

fn iris_place(p: vec2f, iris: IrisFrame) -> IrisPlace {
    let q = p - iris.center * (1.0 - length(p) / iris.root);
    let r = max(length(q), 0.2);
    let width = iris_width(iris);
    return IrisPlace(
        vec2f(atan2(q.y, q.x) * 0.15915494 + 0.5, (r - iris.pupil) / width),
        vec2f(-q.y, q.x) * (0.15915494 / (r * r)),
        q / (r * width),
    );
}

fn iris_step(place: IrisPlace, step: vec2f) -> vec2f {
    return place.uv + vec2f(dot(place.du, step), dot(place.dv, step));
}

fn iris_texel(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, uv: vec2f, lod: f32) -> IrisTexel {
    let t = textureSampleLevel(map, polar, vec2f(uv.x, clamp(uv.y, 0.001, 0.999)), lod);
    return IrisTexel((t.b * iris.thicken - t.a * iris.furrows) * iris.relief, t.r * iris.thicken, t.g);
}

// Width (mm) of a texel of a map of this many rows, at this level.
fn iris_texel_mm(rows: f32, lod: f32, iris: IrisFrame) -> f32 {
    return iris_width(iris) / rows * exp2(lod);
}

// Level of a map of this size (texels) for a footprint (mm) at `radius` mm from the axis; a little
// sharper than the footprint, as the eye forgives more than it misses.
fn iris_level(size: vec2f, footprint: f32, radius: f32, width: f32) -> f32 {
    let texels = footprint * vec2f(size.x / (6.2831853 * max(radius, 1.0)), size.y / width);
    return max(log2(max(texels.x, texels.y)) - 0.4, 0.0);
}

// Fewest and most steps of the march.
const RELIEF_STEPS = vec2<f32>(3.0, 12.0);

// How far (mm, on the iris plane) the refracted ray has moved where it meets the relief: the first place where the ray is
// below the surface, by steps of two texels of this level, of these fewest and most, and one secant.
fn relief_march(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, direction: vec3f, lod: f32, between: vec2f) -> vec2f {
    let slope = direction.xy / max(direction.z, 0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20 * iris.thicken * max(iris.relief, 1.0);
    let deepest = 2.0 * top;
    let texel = iris_texel_mm(f32(textureDimensions(map).y), lod, iris);
    let steps = clamp(ceil(length(slope) * deepest / (2.0 * texel)), between.x, between.y);
    var before = 0.0;
    var gap_before = -0.05;
    for (var i = 1.0; i <= steps; i += 1.0) {
        let depth = deepest * i / steps;
        let gap = depth - top + iris_texel(map, polar, iris, iris_step(place, slope * (depth - top)), lod).height;
        if gap >= 0.0 {
            return slope * (mix(before, depth, gap_before / (gap_before - gap)) - top);
        }
        before = depth;
        gap_before = gap;
    }
    return slope * (deepest - top);
}

// The relief's normal, from three heights on a circle `e` mm across.
fn relief_normal(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, e: f32, lod: f32) -> vec3f {
    let r = 0.5 * e;
    let upper = iris_texel(map, polar, iris, iris_step(place, vec2f(0.0, r)), lod).height;
    let left = iris_texel(map, polar, iris, iris_step(place, vec2f(-0.8660254, -0.5) * r), lod).height;
    let right = iris_texel(map, polar, iris, iris_step(place, vec2f(0.8660254, -0.5) * r), lod).height;
    let slope = vec2f((right - left) / 1.7320508, (upper - 0.5 * (left + right)) / 1.5) / r;
    return normalize(vec3f(-slope, -1.0));
}

// Path (mm) of light from the unit direction `towards` through the relief to what lies `depth` mm below its surface, `under`
// below its mean plane and the step `aside` from a place of it: where the light crossed the surface, by a secant and a step of
// Newton's.
fn relief_way(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, aside: vec2f, under: f32, depth: f32, towards: vec3f, lod: f32) -> f32 {
    let up = max(-towards.z, 0.25);
    let deep = max(depth, 0.02);
    let first = deep / up;
    let there = under - deep + iris_texel(map, polar, iris, iris_step(place, aside + towards.xy * first), lod).height;
    let second = first * clamp(deep / max(deep - there, 0.25 * deep), 0.3, 4.0);
    let left = under - up * second + iris_texel(map, polar, iris, iris_step(place, aside + towards.xy * second), lod).height;
    return max(second + left / up, 0.3 * first);
}
