// The relief of the iris over its plane: where the refracted ray meets it and what it takes of the
// light. Twin: src/appearance/shading/iris_relief.rs.

// Radii (mm) of the root, the pupil and the limbus, the pupil's centre (mm), and how much of the
// relief's slope shows.
struct IrisFrame { root: f32, pupil: f32, limbus: f32, relief: f32, center: vec2f };

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

fn iris_texel(map: texture_2d<f32>, polar: sampler, uv: vec2f, lod: f32) -> IrisTexel {
    let t = textureSampleLevel(map, polar, vec2f(uv.x, clamp(uv.y, 0.001, 0.999)), lod);
    return IrisTexel(t.b, t.r, t.g);
}

// Level of a map of this size (texels) for a footprint (mm) at `radius` mm from the axis; a little
// sharper than the footprint, as the eye forgives more than it misses.
fn iris_level(size: vec2f, footprint: f32, radius: f32, width: f32) -> f32 {
    let texels = footprint * vec2f(size.x / (6.2831853 * max(radius, 1.0)), size.y / width);
    return max(log2(max(texels.x, texels.y)) - 0.4, 0.0);
}

// How far (mm, on the iris plane) the refracted ray has moved where it meets the relief: the first
// place where the ray is below the surface, by linear steps and one secant.
fn relief_march(map: texture_2d<f32>, polar: sampler, place: IrisPlace, direction: vec3f, lod: f32) -> vec2f {
    let slope = direction.xy / max(direction.z, 0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20;
    let deepest = 0.40;
    var before = 0.0;
    var gap_before = -0.05;
    for (var i = 1; i <= 5; i++) {
        let depth = deepest * f32(i) / 5.0;
        let gap = depth - top + iris_texel(map, polar, iris_step(place, slope * (depth - top)), lod).height;
        if gap >= 0.0 {
            return slope * (mix(before, depth, gap_before / (gap_before - gap)) - top);
        }
        before = depth;
        gap_before = gap;
    }
    return slope * (deepest - top);
}

// The relief's normal, by differences one footprint wide.
fn relief_normal(map: texture_2d<f32>, polar: sampler, place: IrisPlace, height: f32, footprint: f32, lod: f32, relief: f32) -> vec3f {
    let e = max(footprint, 0.012);
    let hx = iris_texel(map, polar, iris_step(place, vec2f(e, 0.0)), lod).height - height;
    let hy = iris_texel(map, polar, iris_step(place, vec2f(0.0, e)), lod).height - height;
    let strength = relief / e;
    return normalize(vec3f(-hx * strength, -hy * strength, -1.0));
}

// What the relief leaves of a lamp's light: two short steps towards the lamp decide its own shadow.
fn relief_shadow(map: texture_2d<f32>, polar: sampler, place: IrisPlace, height: f32, towards: vec3f, lod: f32) -> f32 {
    var shadow = 1.0;
    for (var i = 1; i <= 2; i++) {
        let s = 0.09 * f32(i);
        let ridge = iris_texel(map, polar, iris_step(place, towards.xy * (s / max(-towards.z, 0.25))), lod).height - height;
        shadow *= 1.0 - 0.55 * smoothstep(0.0, 0.10, ridge - s);
    }
    return shadow;
}

// What of a lamp's irradiance the relief takes up at this normal. Light that enters one fibre
// leaves through its neighbours, so that a part of the contrast is lost.
fn relief_gain(normal: vec3f, towards: vec3f) -> f32 {
    let cosine = max(dot(normal, towards), 0.0);
    return clamp(mix(1.0, cosine / max(-towards.z, 0.1), 0.75), 0.0, 2.2);
}
