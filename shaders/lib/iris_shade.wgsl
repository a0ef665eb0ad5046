// needs: iris_light.wgsl, iris_relief.wgsl, layers.wgsl, phase.wgsl
//
// The light that iris and pupil send back, subsurface texture mapping (Francois et al. 2007, section 5.4): behind the relief
// the view is followed through border layer and stroma, segment by segment in closed form, and each lamp's light to each
// segment by its own path; what is scattered more than once is read from a table, by light that has spread sideways.
// Eye frame, millimetres. Twin: src/appearance/shading/iris_shade.rs.

// Longest path (mm) of the reflectance map.
const IRIS_PATH_MAX_MM: f32 = 2.5;
// Thickness (mm) of the anterior border layer.
const BORDER_LAYER_MM: f32 = 0.04;
// Segments of a view through the stroma.
const STROMA_SEGMENTS: i32 = 3;
// How far (mm) light that is scattered more than once spreads sideways.
const IRIS_SPREAD_MM: f32 = 0.25;

// Of what collagen bundles scatter beside their forward peak: the share that goes into all directions alike, and the mean cosine
// of the rest.
const BUNDLE_SIDEWAYS: f32 = 0.39260335;
const BUNDLE_COSINE: f32 = 0.47643979;

// What the iris is made of, at three wavelengths: extinction and scattering (1/mm), the share of the latter that follows
// Rayleigh (the rest Henyey and Greenstein), the border layer's extinction by melanin where it is densest, and what the wavelengths weigh in linear sRGB (columns).
struct IrisTissue {
    border: vec3<f32>,
    border_melanin: vec3<f32>,
    border_scattering: vec3<f32>,
    border_fibrils: vec3<f32>,
    stroma: vec3<f32>,
    stroma_scattering: vec3<f32>,
    stroma_fibrils: vec3<f32>,
    weights: mat3x3<f32>,
};

// Mean of the inverse cosine to the normal of light in the aqueous.
const AQUEOUS_SLANT: f32 = 1.2026;

// Thickness (mm) that acts on light in the aqueous as the stroma does on light that comes towards z and is seen at this cosine.
fn iris_path(thickness: f32, towards_z: f32, view_cosine: f32) -> f32 {
    return thickness * (0.5 / AQUEOUS_SLANT) * (1.0 / max(-towards_z, 0.35) + 1.0 / max(view_cosine, 0.35));
}

// Where a refracted ray meets the iris, what is there, and the same smoothed by as much as light spreads, with how
// that is turned; then what the ray passes: its path (mm) through the border layer, how far (mm) along it the middle of each segment of the
// stroma is and how deep below the surface, the depth (mm below the border layer) at which the segment begins, and its length in tissue.
struct IrisSurface {
    at: vec2f,
    place: IrisPlace,
    texel: IrisTexel,
    direction: vec3f,
    lod: f32,
    smooth_texel: IrisTexel,
    smooth_normal: vec3f,
    border: f32,
    alongs: vec3f,
    depths: vec3f,
    begins: vec3f,
    lengths: vec3f,
};

// Where a refracted ray that lands at `point` of the iris' plane meets it, `start` being that point's place
// in the map; `steps`: the fewest and most of its march.
fn iris_surface(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, point: vec2f, direction: vec3f, start: IrisPlace, footprint: f32, steps: vec2f) -> IrisSurface {
    let size = vec2f(textureDimensions(map));
    let lod = iris_level(size, footprint, length(point), iris_width(iris));
    // The next coarser level, by its number: between two, devices break ties differently.
    let moved = relief_march(map, polar, iris, start, direction, ceil(lod), steps);
    let place = IrisPlace(iris_step(start, moved), start.du, start.dv);
    let texel = iris_texel(map, polar, iris, place.uv, lod);
    let spread = max(lod, log2(IRIS_SPREAD_MM / iris_texel_mm(size.y, 0.0, iris)));
    let smooth_texel = iris_texel(map, polar, iris, place.uv, spread);
    let smooth_normal = relief_normal(map, polar, iris, place, max(footprint, IRIS_SPREAD_MM), spread);

    let down = max(direction.z, 0.35);
    // As if the relief were level, and as deep as it is there.
    let level = BORDER_LAYER_MM / down;
    let reached = down * level + iris_texel(map, polar, iris, iris_step(place, direction.xy * level), lod).height - texel.height;
    let first = level * clamp(BORDER_LAYER_MM / max(reached, 0.01), 0.5, 2.5);
    // A little further than to the back of what is there, as what lies behind may be thicker.
    let segment = max(1.3 * texel.thickness / down - first, 0.03) / f32(STROMA_SEGMENTS);
    let deep = segment * down;
    var alongs = vec3f(0.0);
    var depths = vec3f(0.0);
    var begins = vec3f(0.0);
    var lengths = vec3f(0.0);
    var open = 1.0;
    for (var i = 0; i < STROMA_SEGMENTS; i++) {
        let along = first + (f32(i) + 0.5) * segment;
        let there = iris_texel(map, polar, iris, iris_step(place, direction.xy * along), lod);
        let depth = down * along + there.height - texel.height;
        let below = depth - BORDER_LAYER_MM;
        let inside = min(clamp(below / deep + 0.5, 0.0, 1.0), clamp((there.thickness - depth) / deep + 0.5, 0.0, 1.0));
        alongs[i] = along;
        depths[i] = depth;
        begins[i] = max(below - 0.5 * deep, 0.0);
        lengths[i] = open * inside * segment;
        // Behind it lies the black epithelium.
        open *= clamp((there.thickness - depth) / deep + 0.5, 0.0, 1.0);
    }
    return IrisSurface(point + moved, place, texel, direction, lod, smooth_texel, smooth_normal, first, alongs, depths, begins, lengths);
}

// Diffuse reflectance of tissue on the path of light that arrives with this z: of all light (`half` 0) or of what is scattered more
// than once (1); the map holds one above the other.
fn iris_reflectance(reflectance_map: texture_2d<f32>, linear: sampler, surface: IrisSurface, towards_z: f32, half: f32) -> vec3f {
    let path = iris_path(surface.smooth_texel.thickness, towards_z, -dot(surface.smooth_normal, surface.direction));
    let rows = 0.5 * f32(textureDimensions(reflectance_map).y);
    let row = clamp(sqrt(max(surface.texel.melanin, 0.0)) * rows, 0.5, rows - 0.5);
    return textureSampleLevel(reflectance_map, linear, vec2f(path / IRIS_PATH_MAX_MM, 0.5 * (row / rows + half)), 0.0).rgb;
}

// Share of a place that has tissue: the ruff is bare epithelium, which is black.
fn iris_covered(texel: IrisTexel) -> f32 {
    return smoothstep(0.03, 0.08, texel.thickness);
}

// How many mm of a lamp's light lie in the relief for each mm of depth of a segment's middle.
fn iris_ways(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, surface: IrisSurface, towards: vec3f) -> vec3f {
    var ways = vec3f(0.0);
    for (var i = 0; i < STROMA_SEGMENTS; i++) {
        let aside = surface.direction.xy * surface.alongs[i];
        let under = max(surface.direction.z, 0.35) * surface.alongs[i] - surface.texel.height;
        ways[i] = relief_way(map, polar, iris, surface.place, aside, under, surface.depths[i], towards, surface.lod) / max(surface.depths[i], 0.02);
    }
    return ways;
}

// Radiance by one scattering of light with an irradiance of one across its beam that comes from the unit direction `towards`,
// by these ways (`iris_ways`).
fn iris_scattered_once(tissue: IrisTissue, surface: IrisSurface, towards: vec3f, ways: vec3f) -> vec3f {
    let cosine = dot(towards, surface.direction);
    let rayleigh = vec3f(phase_rayleigh(cosine));
    let bundles = vec3f(mix(phase_henyey_greenstein(cosine, BUNDLE_COSINE), PHASE_ISOTROPIC, BUNDLE_SIDEWAYS));
    let border = tissue.border + tissue.border_melanin * surface.texel.melanin;
    let sum = layer_segment_scatter(border, tissue.border_scattering, surface.border, 0.0, BORDER_LAYER_MM * ways[0]);
    var scattered = sum * mix(bundles, rayleigh, tissue.border_fibrils);
    var passed = exp(-border * surface.border) * mix(bundles, rayleigh, tissue.stroma_fibrils);
    for (var i = 0; i < STROMA_SEGMENTS; i++) {
        let begins = surface.begins[i];
        let length = surface.lengths[i];
        let ends = begins + length * max(surface.direction.z, 0.35);
        let covered = exp(-border * (BORDER_LAYER_MM * ways[i]));
        scattered += passed * covered * layer_segment_scatter(tissue.stroma, tissue.stroma_scattering, length, begins * ways[i], ends * ways[i]);
        passed *= exp(-tissue.stroma * length);
    }
    return tissue.weights * scattered;
}

// What the iris sends back of a lamp with an irradiance / pi of one, of which this arrives (`iris_light`).
fn iris_lamp(map: texture_2d<f32>, polar: sampler, reflectance_map: texture_2d<f32>, linear: sampler, iris: IrisFrame, tissue: IrisTissue, surface: IrisSurface, arrives: vec4f) -> vec3f {
    // Across the beam, from the plane of the iris.
    let across = arrives.w / max(-arrives.z, 0.2);
    let ways = iris_ways(map, polar, iris, surface, arrives.xyz);
    let once = iris_scattered_once(tissue, surface, arrives.xyz, ways) * (3.14159265 * across);
    let spread = across * max(dot(surface.smooth_normal, arrives.xyz), 0.0);
    let again = spread * iris_reflectance(reflectance_map, linear, surface, arrives.z, 1.0);
    return (max(once, vec3f(0.0)) + again) * iris_covered(surface.texel);
}

// Cosine in the aqueous that stands for light from all of the sky before an eye: one over the mean slant.
const IRIS_SKY_COSINE: f32 = 0.83;
// Half the width (mm) of the grooves between fibres: what lies that deep in one sees half of the sky.
const IRIS_GROOVE_MM: f32 = 0.12;

// What the iris sends back of surroundings with an irradiance / pi of one; `sky` is what of an even one reaches its plane.
fn iris_ambient(reflectance_map: texture_2d<f32>, linear: sampler, surface: IrisSurface, sky: f32) -> vec3f {
    let sunk = max(surface.smooth_texel.height - surface.texel.height, 0.0) / IRIS_GROOVE_MM;
    let arrives = sky / (1.0 + sunk * sunk);
    return arrives * iris_covered(surface.texel) * iris_reflectance(reflectance_map, linear, surface, -IRIS_SKY_COSINE, 0.0);
}

// Share of the iris (0 in the pupil, 1 outside) at a place of the map: the pupil's margin is uneven
// and softened over a pixel.
fn pupil_edge(uv: vec2f, footprint: f32, width: f32) -> f32 {
    let uneven = 0.003 * sin(uv.x * 81.6814) + 0.003 * sin(uv.x * 37.6991 + 1.7);
    let soft = max(0.75 * footprint / width, 0.008);
    return smoothstep(-soft, soft, uv.y - uneven);
}

// Reflectance of the dark angle behind the limbus.
const IRIS_ANGLE_COLOR = vec3<f32>(0.035, 0.033, 0.032);

// Pupil, iris and, past the root, the dark angle in this `light`, each by its share.
fn iris_and_pupil(pupil: vec3f, iris: vec3f, light: vec3f, edge: f32, v: f32) -> vec3f {
    let beyond = smoothstep(1.0, 1.12, v);
    return mix(pupil, mix(iris, IRIS_ANGLE_COLOR * light, beyond), edge);
}
