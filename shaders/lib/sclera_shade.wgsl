// needs: surroundings.wgsl, lid_shade.wgsl, footprint.wgsl
//
// The sclera's diffuse light. Eye frame, millimetres.
// Twin: src/appearance/shading/sclera_shade.rs.

// The map is azimuthal equidistant from the front, to 100 degrees.
const SCLERA_HALF_ANGLE: f32 = 1.7453293;

struct ScleraSurface { albedo: vec3f, normal: vec3f };

fn sclera_uv(p: vec3f) -> vec2f {
    let n = normalize(p);
    let angle = acos(clamp(-n.z, -1.0, 1.0));
    let across = length(n.xy);
    let direction = select(vec2f(0.0), n.xy / across, across > 1e-6);
    return 0.5 + 0.5 * direction * (angle / SCLERA_HALF_ANGLE);
}

// The normal with the relief of the map, from its height here and a step to the right and above.
fn sclera_normal(normal: vec3f, here: f32, right: f32, above: f32) -> vec3f {
    let bump = vec2f(right - here, above - here) * 1.3;
    return normalize(normal - vec3f(bump, 0.0));
}

// What the white takes up of a lamp with an irradiance / pi of one, at this cosine: light travels under the
// surface, red furthest.
fn sclera_lamp(cosine: f32) -> vec3f {
    return wrapped_cosines(cosine, vec3f(0.42, 0.30, 0.24));
}

// What the lids reflect back is warm, most of it near their margins.
fn sclera_lid_bounce(shade: LidShade) -> vec3f {
    let near_lid = exp(-max(min(shade.upper_gap, shade.lower_gap), 0.0) / 1.1);
    return mix(vec3f(1.0), vec3f(1.05, 0.86, 0.80), near_lid * 0.8);
}

// Mean albedo of the white, linear sRGB: what a thin layer of tissue is seen over.
const SCLERA_WHITE: vec3f = vec3f(0.70, 0.59, 0.54);

// What the conjunctiva leaves of the light from the white below it, by Beer and Lambert: all of it where it
// is thin and clear (share 0), as much as makes the white look like flesh where it is thick (share 1).
fn conjunctiva_filter(flesh: vec3f, share: f32) -> vec3f {
    return pow(flesh / SCLERA_WHITE, vec3f(clamp(share, 0.0, 1.0)));
}

// Albedo and normal at a point p; `map` holds the albedo and in its last channel the height.
fn sclera_surface(map: texture_2d<f32>, linear: sampler, p: vec3f, normal: vec3f, footprint: f32, sclera_radius: f32) -> ScleraSurface {
    let uv = sclera_uv(p);
    let texels = f32(textureDimensions(map).x);
    let lod = footprint_level(footprint, 2.0 * SCLERA_HALF_ANGLE * sclera_radius / texels);
    let here = textureSampleLevel(map, linear, uv, lod);
    let step = 1.5 / texels;
    let right = textureSampleLevel(map, linear, uv + vec2f(step, 0.0), lod).a;
    let above = textureSampleLevel(map, linear, uv + vec2f(0.0, step), lod).a;
    return ScleraSurface(here.rgb, sclera_normal(normal, here.a, right, above));
}
