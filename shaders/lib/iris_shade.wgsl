// needs: studio.wgsl, lid_shade.wgsl, iris_light.wgsl, iris_relief.wgsl
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

// Radiance of the iris where a refracted ray lands at `point` of its plane, `start` being that point's
// place in the map.
fn iris_radiance(
    map: texture_2d<f32>,
    polar: sampler,
    reflectance_map: texture_2d<f32>,
    light_table: texture_2d<f32>,
    linear: sampler,
    iris: IrisFrame,
    studio: Studio,
    head_from_eye: mat3x3f,
    point: vec2f,
    direction: vec3f,
    start: IrisPlace,
    footprint: f32,
    shade: LidShade,
) -> vec3f {
    let lod = iris_level(vec2f(textureDimensions(map)), footprint, length(point), iris_width(iris));
    // The next coarser level, by its number: between two, devices break ties differently.
    let moved = relief_march(map, polar, start, direction, ceil(lod));
    let place = IrisPlace(iris_step(start, moved), start.du, start.dv);
    let texel = iris_texel(map, polar, place.uv, lod);
    let normal = relief_normal(map, polar, place, texel.height, footprint, lod, iris.relief);
    let view_cosine = max(-dot(normal, direction), 0.2);

    // A row times the turn into the head is the column times the turn out of it.
    let key = iris_light(light_table, linear, studio.key_direction * head_from_eye, point + moved, iris.root, iris.limbus);
    let fill = iris_light(light_table, linear, studio.fill_direction * head_from_eye, point + moved, iris.root, iris.limbus);
    let shadow = relief_shadow(map, polar, place, texel.height, key.xyz, lod);
    let path = iris_path(texel.thickness, key.z, view_cosine);
    let reflectance = textureSampleLevel(reflectance_map, linear, vec2f(path / IRIS_PATH_MAX_MM, texel.melanin), 0.0).rgb;

    var light = studio.key_color * (key.w * relief_gain(normal, key.xyz) * shadow * shade.key);
    light += studio.fill_color * (fill.w * relief_gain(normal, fill.xyz) * shade.sky);
    light += studio_ambient(studio, -head_from_eye[2]) * (iris_openness(texel.height) * shade.sky * 0.92);
    return iris_edges(reflectance * light, place.uv.y);
}

// What shows through the pupil: nearly black, and what the lens sends back (`lens`) of the lamps' light.
fn pupil_radiance(studio: Studio, lens: vec3f, shade: LidShade) -> vec3f {
    let light = (studio.key_color + studio.fill_color) * shade.key;
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
