// needs: iris_light.wgsl, iris_relief.wgsl, layers.wgsl, phase.wgsl
//
// The light that iris and pupil send back, subsurface texture mapping (Francois et al. 2007, section 5.4): behind the relief
// the view is followed through border layer and stroma, segment by segment in closed form, and each lamp's light to each
// segment by its own path; what is scattered more than once is read from a table, by light that has spread sideways.
// Eye frame, millimetres. Twin: src/appearance/shading/iris_shade.rs.

// Longest path (mm) of the reflectance map.
const IRIS_PATH_MAX_MM: f32 = 2.5;
// How far (mm) light that is scattered more than once spreads sideways.
const IRIS_SPREAD_MM: f32 = 0.08;
// Over how much (mm) of the relief its normal is taken for that light.
const IRIS_LEVEL_MM: f32 = 0.25;

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

// Where a refracted ray meets the iris, how far (mm) the mean iris lies behind the plane of the pupil's edge there and how fast it falls back,
// what is there, the ray's unit direction and the same over the iris laid flat; what is there smoothed by as much as light spreads, with how
// that is turned; then how far (mm) the ray goes through the border layer, and from where it meets the iris to where it is left.
struct IrisSurface {
    at: vec2f,
    place: IrisPlace,
    base: f32,
    lean: vec2f,
    texel: IrisTexel,
    direction: vec3f,
    within: vec3f,
    lod: f32,
    smooth_texel: IrisTexel,
    smooth_normal: vec3f,
    border: f32,
    reach: f32,
};

// Where a refracted ray that lands at `point` of the mean iris, `start` in the map, meets it.
fn iris_surface(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, point: vec2f, start: IrisPlace, direction: vec3f, footprint: f32, march: IrisMarch) -> IrisSurface {
    let size = vec2f(textureDimensions(map));
    let lod = iris_level(size, footprint, direction, start);
    let flat = iris_within(direction, iris_lean(start, iris));
    let at = point + relief_march(map, polar, iris, start, flat, lod, march);
    let place = iris_place(at, iris);
    let base = iris_base(place.uv.y, iris).x;
    let lean = iris_lean(place, iris);
    let within = iris_within(direction, lean);
    let texel = iris_texel(map, polar, iris, place.uv, lod);
    let spread = max(lod, log2(IRIS_SPREAD_MM / iris_texel_mm(size.y, 0.0, iris)));
    let smooth_texel = iris_texel(map, polar, iris, place.uv, spread);
    let normal_lod = max(lod, log2(IRIS_LEVEL_MM / iris_texel_mm(size.y, 0.0, iris)));
    let smooth_normal = relief_normal(map, polar, iris, place, max(footprint, IRIS_LEVEL_MM), normal_lod, lean);

    let down = max(within.z, 0.35);
    // As if the relief were level, and as deep as it is there.
    let level = BORDER_LAYER_MM / down;
    let reached = down * level + iris_texel(map, polar, iris, iris_step(iris, place, direction.xy * level), lod).height - texel.height;
    let border = level * clamp(BORDER_LAYER_MM / max(reached, 0.01), 0.5, 2.5);
    // Further than to the back of what is there: the view may leave a ridge and meet the next.
    let back = BORDER_LAYER_MM + stroma_back(stroma_of(texel), iris);
    let reach = border + max(march.reach * back / down - border, 0.03);
    return IrisSurface(at, place, base, lean, texel, direction, within, lod, smooth_texel, smooth_normal, border, reach);
}

// Diffuse reflectance of tissue on the path of light that arrives with this z: of all light (`half` 0) or of what is scattered more
// than once (1); the map holds one above the other.
fn iris_reflectance(reflectance_map: texture_2d<f32>, linear: sampler, surface: IrisSurface, towards_z: f32, half: f32) -> vec3f {
    // Thickness counts along the axis, whichever way the iris leans.
    let leans = sqrt(1.0 + dot(surface.lean, surface.lean));
    let path = iris_path(surface.smooth_texel.thickness, towards_z, -dot(surface.smooth_normal, surface.direction) * leans);
    let rows = 0.5 * f32(textureDimensions(reflectance_map).y);
    let row = clamp(sqrt(max(surface.texel.melanin, 0.0)) * rows, 0.5, rows - 0.5);
    return textureSampleLevel(reflectance_map, linear, vec2f(path / IRIS_PATH_MAX_MM, 0.5 * (row / rows + half)), 0.0).rgb;
}

// Share of a place that has tissue: the ruff is bare epithelium, which is black.
fn iris_covered(texel: IrisTexel) -> f32 {
    return smoothstep(0.03, 0.08, texel.thickness);
}

// Radiance by one scattering of light with an irradiance of one across its beam that comes from the unit direction `towards`: the
// border layer and segments behind it, each in closed form; the beam gathers by this share of itself a mm behind the mean iris (`beam_on`).
fn iris_scattered_once(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, tissue: IrisTissue, surface: IrisSurface, towards: vec3f, gathers: f32, march: IrisMarch) -> vec3f {
    let cosine = dot(towards, surface.direction);
    let rayleigh = vec3f(phase_rayleigh(cosine));
    let bundles = vec3f(mix(phase_henyey_greenstein(cosine, BUNDLE_COSINE), PHASE_ISOTROPIC, BUNDLE_SIDEWAYS));
    let from_border = tissue.border_scattering * mix(bundles, rayleigh, tissue.border_fibrils);
    let from_stroma = tissue.stroma_scattering * mix(bundles, rayleigh, tissue.stroma_fibrils);
    let light = iris_within(towards, surface.lean);
    let down = max(surface.within.z, 0.35);
    let up = max(-light.z, 0.25);
    var scattered = vec3f(0.0);
    var passed = vec3f(1.0);
    var begins = 0.0;
    var ends = 0.5 * surface.border;
    var depth_before = 0.0;
    var along_before = 0.0;
    for (var i = 0; i <= march.segments + 1; i++) {
        let in_front = i < 2;
        let along = 0.5 * (begins + ends);
        let aside = surface.direction.xy * along;
        let place = iris_place(surface.at + aside, iris);
        let there = iris_texel(map, polar, iris, place.uv, surface.lod);
        let under = down * along - surface.texel.height;
        let depth = under + there.height;
        // How fast the view goes down into it, which counts where the border layer is crossed.
        let steep = clamp(select(down, abs(depth - depth_before) / (along - along_before), in_front), 0.2 * down, 4.0 * down);
        depth_before = depth;
        along_before = along;
        // What of the segment lies in the border layer and what in the stroma, before the black epithelium.
        let half = 0.5 * steep * (ends - begins);
        let stroma = stroma_of(there);
        let back = BORDER_LAYER_MM + stroma_back(stroma, iris);
        let low = clamp(depth - half, 0.0, back);
        let high = clamp(depth + half, 0.0, back);
        let in_border = (min(high, BORDER_LAYER_MM) - min(low, BORDER_LAYER_MM)) / steep;
        let over = vec3f(stroma_over(max(low - BORDER_LAYER_MM, 0.0), stroma, iris), stroma_over(max(depth - BORDER_LAYER_MM, 0.0), stroma, iris),
            stroma_over(max(high - BORDER_LAYER_MM, 0.0), stroma, iris));
        let in_stroma = (over.z - over.x) / steep;
        let border = tissue.border + tissue.border_melanin * there.melanin;
        let takes = border * in_border + tissue.stroma * in_stroma;
        // Light's way to its middle.
        var way = vec3f(0.0);
        if in_front {
            // So little of it lies in the border layer that it crosses the relief next to it.
            way = vec3f(max(depth, 0.01) / up, there.melanin, over.y / up);
        } else {
            way = relief_way(map, polar, iris, place, under, light, surface.lod, march.looks);
        }
        let dims = tissue.border + tissue.border_melanin * way.y;
        let share = way.x / max(depth, 0.01);
        let arrives = dims * (share * min(low, BORDER_LAYER_MM)) + tissue.stroma * max(way.z + share * (over.x - over.y), 0.0);
        let leaves = dims * (share * min(high, BORDER_LAYER_MM)) + tissue.stroma * max(way.z + share * (over.z - over.y), 0.0);
        let gathered = clamp(1.0 + gathers * under / up, 0.5, 2.0);
        scattered += gathered * passed * (from_border * in_border + from_stroma * in_stroma) * layer_mean_transmittance(arrives, leaves + takes);
        // Behind it lies the black epithelium.
        passed *= exp(-takes) * clamp((back - depth) / (2.0 * half) + 0.5, 0.0, 1.0);
        // Shorter ones first, where more is left of the light.
        let part = f32(i) / f32(march.segments);
        begins = ends;
        ends = mix(surface.border, surface.reach, part * part);
    }
    return tissue.weights * scattered;
}

// What the iris sends back of a lamp with an irradiance / pi of one, of which this arrives (`iris_light`) at the mean iris and gathers
// (`beam_on`).
fn iris_lamp(map: texture_2d<f32>, polar: sampler, reflectance_map: texture_2d<f32>, linear: sampler, iris: IrisFrame, tissue: IrisTissue, surface: IrisSurface, arrives: vec4f, gathers: f32, march: IrisMarch) -> vec3f {
    // Across the beam, from a plane across the axis.
    let across = arrives.w / max(-arrives.z, 0.2);
    let once = iris_scattered_once(map, polar, iris, tissue, surface, arrives.xyz, gathers, march) * (3.14159265 * across);
    let spread = across * max(dot(surface.smooth_normal, arrives.xyz), 0.0);
    let slant = iris_within(arrives.xyz, surface.lean).z;
    let again = spread * iris_reflectance(reflectance_map, linear, surface, slant, 1.0);
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

// Share of what is seen past the root at this part of the iris' width.
fn angle_share(v: f32) -> f32 {
    return smoothstep(1.0, 1.02, v);
}

// Share of the iris (0 in the pupil, 1 outside) at a place of the map: the pupil's margin is uneven
// and softened over a pixel.
fn pupil_edge(uv: vec2f, footprint: f32, width: f32) -> f32 {
    let uneven = 0.003 * sin(uv.x * 81.6814) + 0.003 * sin(uv.x * 37.6991 + 1.7);
    let soft = max(0.75 * footprint / width, 0.008);
    return smoothstep(-soft, soft, uv.y - uneven);
}

