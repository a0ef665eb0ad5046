// needs: iris_light.wgsl, iris_relief.wgsl
//
// The light that iris and pupil send back. Eye frame, millimetres.
// Twin: src/appearance/shading/iris_shade.rs.

// Longest path (mm) of the reflectance map.
const IRIS_PATH_MAX_MM: f32 = 2.5;

// Path (mm) of light through the stroma, in towards z and out at the cosine of the view.
fn iris_path(thickness: f32, towards_z: f32, view_cosine: f32) -> f32 {
    return thickness * 0.5 * (1.0 / max(-towards_z, 0.35) + 1.0 / max(view_cosine, 0.35));
}

// Radiance at the edges of the iris: the root lies in the shade of the limbus; the ruff is pigment
// without stroma. v runs from the pupil's edge to the root.
fn iris_edges(radiance: vec3f, v: f32) -> vec3f {
    let root = smoothstep(0.80, 1.02, v);
    let ruff = smoothstep(0.035, 0.0, v);
    let shaded = radiance * mix(vec3f(1.0), vec3f(0.30, 0.33, 0.38), root);
    return shaded * mix(vec3f(1.0), vec3f(0.16, 0.11, 0.08), ruff);
}

// What of the surroundings reaches a place of this height: over the dome they arrive nearly evenly;
// what is deep sees less of them.
fn iris_openness(height: f32) -> f32 {
    return clamp(0.80 + height * 2.2, 0.35, 1.15);
}

// Where a refracted ray meets the iris, what is there, and how it is turned to the ray.
struct IrisSurface { at: vec2f, place: IrisPlace, texel: IrisTexel, normal: vec3f, view_cosine: f32, lod: f32 };

// Where a refracted ray that lands at `point` of the iris' plane meets it, `start` being that point's place
// in the map.
fn iris_surface(map: texture_2d<f32>, polar: sampler, iris: IrisFrame, point: vec2f, direction: vec3f, start: IrisPlace, footprint: f32) -> IrisSurface {
    let lod = iris_level(vec2f(textureDimensions(map)), footprint, length(point), iris_width(iris));
    // The next coarser level, by its number: between two, devices break ties differently.
    let moved = relief_march(map, polar, start, direction, ceil(lod));
    let place = IrisPlace(iris_step(start, moved), start.du, start.dv);
    let texel = iris_texel(map, polar, place.uv, lod);
    let normal = relief_normal(map, polar, place, texel.height, footprint, lod, iris.relief);
    return IrisSurface(point + moved, place, texel, normal, max(-dot(normal, direction), 0.2), lod);
}

// Reflectance of tissue on the path of light that arrives with this z.
fn iris_reflectance(reflectance_map: texture_2d<f32>, linear: sampler, surface: IrisSurface, towards_z: f32) -> vec3f {
    let path = iris_path(surface.texel.thickness, towards_z, surface.view_cosine);
    return textureSampleLevel(reflectance_map, linear, vec2f(path / IRIS_PATH_MAX_MM, surface.texel.melanin), 0.0).rgb;
}

// What the iris sends back of a lamp with an irradiance / pi of one in the unit direction `light` of the eye
// frame.
fn iris_lamp(map: texture_2d<f32>, polar: sampler, reflectance_map: texture_2d<f32>, light_table: texture_2d<f32>, linear: sampler, iris: IrisFrame, surface: IrisSurface, light: vec3f) -> vec3f {
    let arrives = iris_light(light_table, linear, light, surface.at, iris.root, iris.limbus);
    let shadow = relief_shadow(map, polar, surface.place, surface.texel.height, arrives.xyz, surface.lod);
    let gain = arrives.w * relief_gain(surface.normal, arrives.xyz) * shadow;
    return gain * iris_reflectance(reflectance_map, linear, surface, arrives.z);
}

// Mean cosine in the aqueous of light from all of the sky before an eye: cosines beyond the critical angle
// do not occur.
const IRIS_SKY_COSINE: f32 = 0.87;

// What the iris sends back of surroundings with an irradiance / pi of one.
fn iris_ambient(reflectance_map: texture_2d<f32>, linear: sampler, surface: IrisSurface) -> vec3f {
    return 0.92 * iris_openness(surface.texel.height) * iris_reflectance(reflectance_map, linear, surface, -IRIS_SKY_COSINE);
}

// What shows through the pupil: nearly black, and what the lens sends back (`lens`) of the lamps' `light`.
fn pupil_radiance(light: vec3f, lens: vec3f) -> vec3f {
    return vec3f(0.0016, 0.0013, 0.0012) + light * lens;
}

// Share of the iris (0 in the pupil, 1 outside) at a place of the map: the pupil's margin is uneven
// and softened over a pixel.
fn pupil_edge(uv: vec2f, footprint: f32, width: f32) -> f32 {
    let uneven = 0.006 * sin(uv.x * 81.6814) + 0.005 * sin(uv.x * 37.6991 + 1.7);
    let soft = max(0.75 * footprint / width, 0.008);
    return smoothstep(-soft, soft, uv.y - uneven);
}

// Pupil, iris and, past the root, the dark angle behind the limbus, each by its share.
fn iris_and_pupil(pupil: vec3f, iris: vec3f, edge: f32, v: f32) -> vec3f {
    let beyond = smoothstep(1.0, 1.12, v);
    return mix(pupil, mix(iris, vec3f(0.03, 0.028, 0.027), beyond), edge);
}
