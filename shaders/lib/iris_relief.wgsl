// The relief of the iris over its plane: where the refracted ray meets it and what it puts in the way of
// light. Twin: src/appearance/shading/iris_relief.rs.

// Radii (mm) of the root, the pupil and the limbus, how many times as high as its own the relief is, the pupil's centre (mm), how many
// times as thick as in the map the stroma is (it keeps its volume), how deep its furrows are (1 as in the map), the slope of the cone in
// which it falls back from the pupil to its root, and how far its middle stands before that, four times, over its width.
struct IrisFrame { root: f32, pupil: f32, limbus: f32, relief: f32, center: vec2f, thicken: f32, furrows: f32, cone: f32, bow: f32 };

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

// Height over the mean plane, thickness (mm) of border layer and stroma as if the latter were as dense everywhere, melanin.
struct IrisTexel { height: f32, thickness: f32, melanin: f32 };

// Thickness (mm) of the anterior border layer.
const BORDER_LAYER_MM: f32 = 0.04;
// Density of the stroma's bundles and of the mesh behind them, against the mean of the map, and the depth (mm of the map) of its back.
const BUNDLE_DENSITY: f32 = 4.0;
const MESH_DENSITY: f32 = 0.25;
const STROMA_BACK_MM: f32 = 0.45;

// Stroma that a reading has, mm as dense as the mean.
fn stroma_of(texel: IrisTexel) -> f32 {
    return max(texel.thickness - BORDER_LAYER_MM, 0.0);
}

// Depth (mm, from behind the border layer) of the bundles where there is so much stroma in all (mm as dense as the mean).
fn bundle_depth(stroma: f32, iris: IrisFrame) -> f32 {
    let mesh = MESH_DENSITY * STROMA_BACK_MM * iris.thicken;
    return max(stroma - mesh, 0.0) / (BUNDLE_DENSITY - MESH_DENSITY);
}

// Depth (mm, from behind the border layer) of the black epithelium there.
fn stroma_back(stroma: f32, iris: IrisFrame) -> f32 {
    return min(stroma / MESH_DENSITY, STROMA_BACK_MM * iris.thicken);
}

// How much stroma (mm as dense as the mean) lies over this depth (mm, from behind the border layer) where there is so much in all.
fn stroma_over(depth: f32, stroma: f32, iris: IrisFrame) -> f32 {
    let bundles = bundle_depth(stroma, iris);
    return clamp(BUNDLE_DENSITY * min(depth, bundles) + MESH_DENSITY * max(depth - bundles, 0.0), 0.0, stroma);
}

// Width (mm) of the iris from pupil to root.
fn iris_width(iris: IrisFrame) -> f32 {
    return max(iris.root - iris.pupil, 0.5);
}

// Place in the iris map: u the angle, v from the pupil's edge to the root; and what small steps from it need: the unit direction away from the
// pupil, one over the distance (mm) from there and over the iris' width, and by what the pupil's part in places falls with a step.
struct IrisPlace { uv: vec2f, away: vec2f, bend: f32, dv: f32, fall: vec2f };

// How far (mm) the mean iris lies behind the plane of the pupil's edge at this part of its width, 0 at that edge and 1 at the root, and how
// fast it falls back there; level within the pupil and from a tenth past the root on.
fn iris_base(v: f32, iris: IrisFrame) -> vec2f {
    let part = clamp(v, 0.0, 1.1);
    let falls = select(0.0, iris.cone - iris.bow * (1.0 - 2.0 * part), part == v);
    return vec2f(iris_width(iris) * part * (iris.cone - iris.bow * (1.0 - part)), falls);
}

// Unit direction away from the pupil's middle at a point (mm), and the distance from there.
fn iris_away(p: vec2f, iris: IrisFrame) -> vec3f {
    let q = p - iris.center * (1.0 - length(p) / iris.root);
    let r = max(length(q), 0.2);
    return vec3f(q / r, r);
}

// How fast the mean iris falls back at a place, along x and y.
fn iris_lean(place: IrisPlace, iris: IrisFrame) -> vec2f {
    let out = place.away + place.fall * dot(iris.center, place.away);
    return out * iris_base(place.uv.y, iris).y;
}

// A direction as it is over an iris that is laid flat by moving all of it along the axis: lengths along rays and depths along the axis stay
// what they are.
fn iris_within(direction: vec3f, lean: vec2f) -> vec3f {
    return vec3f(direction.xy, direction.z - dot(lean, direction.xy));
}

// Where (mm) a ray that crosses the plane of the pupil's edge at `point` meets the mean iris: by two steps after Newton.
fn iris_landing(point: vec2f, direction: vec3f, iris: IrisFrame) -> vec2f {
    let slope = direction.xy / max(direction.z, 0.2);
    var depth = 0.0;
    for (var i = 0; i < 2; i++) {
        let away = iris_away(point + slope * depth, iris);
        let base = iris_base((away.z - iris.pupil) / iris_width(iris), iris);
        depth += (base.x - depth) / max(1.0 - base.y * dot(away.xy, slope), 0.3);
    }
    return point + slope * depth;
}

// The place in the map of a point of the iris.
fn iris_place(p: vec2f, iris: IrisFrame) -> IrisPlace {
    let out = iris_away(p, iris);
    let dv = 1.0 / iris_width(iris);
    let uv = vec2f(atan2(out.y, out.x) * 0.15915494 + 0.5, (out.z - iris.pupil) * dv);
    return IrisPlace(uv, out.xy, 1.0 / out.z, dv, p / (max(length(p), 0.2) * iris.root));
}

// The place in the map a step (mm) away, to the third order of it: within a micrometre for a tenth of the distance from the pupil's middle.
fn iris_step(iris: IrisFrame, place: IrisPlace, step: vec2f) -> vec2f {
    let moved = step + iris.center * dot(place.fall, step);
    let out = dot(place.away, moved);
    let round = place.away.x * moved.y - place.away.y * moved.x;
    let o = out * place.bend;
    let t = round * place.bend;
    return place.uv + vec2f(t * (1.0 - o + o * o - t * t * (1.0 / 3.0)) * 0.15915494, (out + 0.5 * round * t * (1.0 - o)) * place.dv);
}

fn iris_texel(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, uv: vec2f, lod: f32) -> IrisTexel {
    let t = textureSampleLevel(map, polar, vec2f(uv.x, clamp(uv.y, 0.001, 0.999)), lod);
    return IrisTexel((t.b * iris.thicken - t.a * iris.furrows) * iris.relief, t.r * iris.thicken, t.g);
}

// Width (mm) of a texel of a map of this many rows, at this level.
fn iris_texel_mm(rows: f32, lod: f32, iris: IrisFrame) -> f32 {
    return iris_width(iris) / rows * exp2(lod);
}

// Square of the aqueous' index.
const AQUEOUS_SQUARED: f32 = 1.784896;

// Level of a map of this size (texels) at a place of the iris for a pixel of this footprint (mm), whose ray goes in the unit direction
// `direction` within the aqueous and sees the iris the longer along its slant, the flatter it is there and before the cornea (their geometric
// mean: 1.6 times from 60 degrees, where the pupil is 0.62 times as wide as high); a little sharper than that, as the eye forgives more than it
// misses, but where ridges stand before each other.
fn iris_level(size: vec2f, footprint: f32, direction: vec3f, place: IrisPlace) -> f32 {
    let slant = dot(direction.xy, direction.xy);
    let longer = inverseSqrt(max(1.0 - AQUEOUS_SQUARED * slant, 0.05) * max(1.0 - slant, 0.05)) - 1.0;
    let beside = dot(direction.xy, place.away);
    let out = beside * beside / max(slant, 1e-6);
    let along = sqrt(vec2f(1.0 + longer * (1.0 - out), 1.0 + longer * out));
    let texels = footprint * along * size * vec2f(min(place.bend, 1.0) * 0.15915494, place.dv);
    return max(log2(max(texels.x, texels.y)) - 0.4 + slant, 0.0);
}

// Half of a fibre's width, mm: what a step may not leave out however fine the map is.
const STRAND_MM: f32 = 0.05;

// How an iris is followed: the fewest and most steps of the view to its relief, and how long one is along the iris, in texels, or in
// STRAND_MM where those are finer; how far behind it the view is followed, as a multiple
// of how deep its back is there, and in how many segments behind the border layer; by how many looks light's way to each of them is known.
struct IrisMarch { fewest: f32, most: f32, stride: f32, reach: f32, segments: i32, looks: i32 };

// By what a pixel shows, as far as a rasteriser on processors goes; the same as a picture that is to be kept has it;
// and the plain way, which they are measured against.
const IRIS_MARCH_FAST = IrisMarch(5.0, 24.0, 0.6, 1.5, 5, 4);
const IRIS_MARCH_FULL = IrisMarch(8.0, 48.0, 0.25, 1.6, 8, 4);
const IRIS_MARCH_FIXED = IrisMarch(64.0, 64.0, 0.25, 1.6, 64, 4);

// How far (mm) the refracted ray that lands at this place of the mean iris has moved aside where it meets the relief: the first place where
// the ray (`iris_within`) is below the surface, by even steps and two secants.
fn relief_march(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, direction: vec3f, lod: f32, march: IrisMarch) -> vec2f {
    let slope = direction.xy / max(direction.z, 0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20 * iris.thicken * max(iris.relief, 1.0);
    let deepest = 2.0 * top;
    let texel = iris_texel_mm(f32(textureDimensions(map).y), lod, iris);
    let steps = clamp(ceil(length(slope) * deepest / (march.stride * max(texel, STRAND_MM))), march.fewest, march.most);
    var before = 0.0;
    var gap_before = -0.05;
    for (var i = 1.0; i <= steps; i += 1.0) {
        let depth = deepest * i / steps;
        let gap = depth - top + iris_texel(map, polar, iris, iris_step(iris, place, slope * (depth - top)), lod).height;
        if gap >= 0.0 {
            let first = mix(before, depth, gap_before / (gap_before - gap));
            // Again between the nearer two.
            let left = first - top + iris_texel(map, polar, iris, iris_step(iris, place, slope * (first - top)), lod).height;
            let over = left >= 0.0;
            let low = select(first, before, over);
            let high = select(depth, first, over);
            let low_gap = select(left, gap_before, over);
            let high_gap = select(gap, left, over);
            return slope * (mix(low, high, clamp(low_gap / min(low_gap - high_gap, -1e-6), 0.0, 1.0)) - top);
        }
        before = depth;
        gap_before = gap;
    }
    return slope * (deepest - top);
}

// The normal at a place, from four heights of the relief `e` mm apart and how the iris leans.
fn relief_normal(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, e: f32, lod: f32, lean: vec2f) -> vec3f {
    let x = vec2f(0.5 * e, 0.0);
    let rise = iris_texel(map, polar, iris, iris_step(iris, place, x), lod).height - iris_texel(map, polar, iris, iris_step(iris, place, -x), lod).height;
    let up = iris_texel(map, polar, iris, iris_step(iris, place, x.yx), lod).height - iris_texel(map, polar, iris, iris_step(iris, place, -x.yx), lod).height;
    return normalize(vec3f(lean - vec2f(rise, up) / e, -1.0));
}

// Path (mm) of light from the direction `towards` (`iris_within`) through the relief to what lies `under` mm below the mean iris at this place of
// it, the melanin of the border layer where it came in, and the stroma (mm as dense as the mean) on its way: by this many looks along it, further
// apart the higher they are. Tissue that it crosses behind the first place where it leaves some is counted too.
fn relief_way(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, place: IrisPlace, under: f32, towards: vec3f, lod: f32, looks: i32) -> vec3f {
    let up = max(-towards.z, 0.25);
    // Up to the highest ridges.
    let all = max(under + 0.2 * iris.thicken * max(iris.relief, 1.0), 0.01) / up;
    var way = 0.0;
    var melanin = 0.0;
    var stroma = 0.0;
    var begins = 0.0;
    for (var i = 1; i <= looks; i++) {
        let part = f32(i) / f32(looks);
        let ends = all * part * sqrt(part);
        let middle = 0.5 * (begins + ends);
        let there = iris_texel(map, polar, iris, iris_step(iris, place, towards.xy * middle), lod);
        let above = under - up * middle + there.height;
        let half = 0.5 * up * (ends - begins);
        let inside = clamp(0.5 * above / half + 0.5, 0.0, 1.0);
        way += inside * (ends - begins);
        let own = stroma_of(there);
        stroma += (stroma_over(max(above + half - BORDER_LAYER_MM, 0.0), own, iris) - stroma_over(max(above - half - BORDER_LAYER_MM, 0.0), own, iris)) / up;
        melanin = select(melanin, there.melanin, inside > 0.0);
        begins = ends;
    }
    return vec3f(way, melanin, stroma);
}
