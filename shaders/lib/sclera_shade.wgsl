// needs: surroundings.wgsl, footprint.wgsl
//
// The sclera's diffuse light. Eye frame, millimetres.
// Twin: src/appearance/shading/sclera_shade.rs.

// The map is azimuthal equidistant from the front, to 100 degrees.
const SCLERA_HALF_ANGLE: f32 = 1.7453293;

// `normal` is that of its wet surface, `soft` that of the tissue as its diffuse light shows it; `unseen` is the
// variance of its slopes that a pixel does not see.
struct ScleraSurface { albedo: vec3f, normal: vec3f, soft: vec3f, unseen: f32 };

// Depth (mm) of the episcleral vessels under the surface, and how far light travels sideways in the tissue, so that a
// vessel's shadow is that wide.
const EPISCLERAL_DEPTH_MM: f32 = 0.15;
const SHADOW_MM: f32 = 0.3;
const SCLERA_INDEX: f32 = 1.37;

fn sclera_uv(p: vec3f) -> vec2f {
    let n = normalize(p);
    let angle = acos(clamp(-n.z, -1.0, 1.0));
    let across = length(n.xy);
    let direction = select(vec2f(0.0), n.xy / across, across > 1e-6);
    return 0.5 + 0.5 * direction * (angle / SCLERA_HALF_ANGLE);
}

// The normal at p with relief that rises so fast (in the map, to the right and up): outwards from the front as fast on the globe, around it faster,
// as the map spreads what lies there.
fn sclera_normal(normal: vec3f, p: vec3f, rise: vec2f) -> vec3f {
    let n = normalize(p);
    let across = length(n.xy);
    let away = select(vec2f(1.0, 0.0), n.xy / max(across, 1e-6), across > 1e-6);
    let angle = acos(clamp(-n.z, -1.0, 1.0));
    let spread = select(1.0, angle / max(across, 1e-6), across > 1e-3);
    let outward = vec3f(-n.z * away, across);
    let around = vec3f(-away.y, away.x, 0.0);
    return normalize(normal - dot(rise, away) * outward - (dot(rise, around.xy) * min(spread, 4.0)) * around);
}

// Share of the relief's slopes that diffuse light shows: it travels further than most of them are wide.
const WHITE_SOFT: f32 = 0.3;
// Spread (rad, of the slopes along an axis) of the relief of the wet white, and the width (mm) of a pixel that no longer sees half of it.
const WHITE_SLOPES: f32 = 0.044;
const WHITE_SLOPES_MM: f32 = 0.12;

// Variance of the slopes of the wet white along an axis that a pixel of this footprint (mm) does not see one by one.
fn unseen_slopes(footprint: f32) -> f32 {
    let wide = pow(max(footprint, 1e-6) / WHITE_SLOPES_MM, 1.6);
    return WHITE_SLOPES * WHITE_SLOPES * (1.0 - 1.0 / (1.0 + wide));
}

// Roughness of a surface whose own is this and whose slopes vary by `unseen` more: variances add.
fn white_rough(own: f32, unseen: f32) -> f32 {
    let square = own * own;
    return sqrt(sqrt(square * square + 2.0 * unseen));
}

// How far (rad) a surface of this roughness spreads what it mirrors, as the surroundings' map counts it: its slopes' spread twice, of a width that is
// even.
fn mirror_spread(roughness: f32) -> f32 {
    return 2.45 * roughness * roughness;
}

// What vessels with columns of blood of `column` mm in the mean leave of white light, linear sRGB: green by Beer's law, red and
// blue in the proportion to it of a vessel of 0.05 mm that light crosses twice, as a vessel that is not resolved is a thread
// of thick blood and not a veil of thin.
fn blood_filter(column: f32) -> vec3f {
    let green = 1.0 - exp(-18.8 * max(column, 0.0));
    return max(1.0 - green * vec3f(0.218, 1.0, 1.148), vec3f(0.0));
}

// Where (a step from the surface, mm, tangential) a view from the unit direction v is at this depth below a surface
// of normal n.
fn view_shift(n: vec3f, v: vec3f, depth: f32) -> vec3f {
    let cosine = dot(n, v);
    let aside = (v - n * cosine) / SCLERA_INDEX;
    return aside * (-depth * inverseSqrt(max(1.0 - dot(aside, aside), 0.1)));
}

// What vessels leave of the light that the white sends back: the superficial ones, with columns of `shallow` mm on the
// way out and `shadow` on the way in, dim all of it; the deep ones what has not turned back above them (`above`).
fn vessel_filter(shallow: f32, shadow: f32, deep: f32, above: vec3f) -> vec3f {
    return blood_filter(shallow + shadow) * mix(blood_filter(2.0 * deep), vec3f(1.0), above);
}

// What the white takes up of a lamp with an irradiance / pi of one, at this cosine: light travels under the
// surface, red furthest.
fn sclera_lamp(cosine: f32) -> vec3f {
    return wrapped_cosines(cosine, vec3f(0.42, 0.30, 0.24));
}

// What the conjunctiva leaves of the light from the `white` below it, by Beer and Lambert: all of it where it is thin
// and clear (share 0), as much as makes the white look like flesh where it is thick (share 1).
fn conjunctiva_filter(flesh: vec3f, white: vec3f, share: f32) -> vec3f {
    return pow(min(flesh / max(white, vec3f(0.02)), vec3f(2.0)), vec3f(clamp(share, 0.0, 1.0)));
}

// Albedo and normal at a point p seen from the unit direction v. `colors` holds the albedo without vessels, `vessels` columns
// of blood (mm) near the surface and deeper, and the height (mm); `above` is the share of light that does not reach the
// deeper ones.
fn sclera_surface(colors: texture_2d<f32>, vessels: texture_2d<f32>, linear: sampler, p: vec3f, normal: vec3f, v: vec3f, footprint: f32, sclera_radius: f32, above: vec3f) -> ScleraSurface {
    let uv = sclera_uv(p);
    let side = f32(textureDimensions(vessels).x);
    let texel = 2.0 * SCLERA_HALF_ANGLE * sclera_radius / side;
    let lod = footprint_level(footprint, texel);
    let level = round(lod);
    // The slope is taken over what the level resolves.
    let step = 1.5 * exp2(level) / side;
    let here = textureSampleLevel(vessels, linear, uv, lod);
    let right = textureSampleLevel(vessels, linear, uv + vec2f(step, 0.0), lod).b;
    let upper = textureSampleLevel(vessels, linear, uv + vec2f(0.0, step), lod).b;
    let shift = view_shift(normal, v, EPISCLERAL_DEPTH_MM);
    let deep = textureSampleLevel(vessels, linear, sclera_uv(p + shift), lod).g;
    let shadow = textureSampleLevel(vessels, linear, uv, max(lod, log2(SHADOW_MM / texel))).r;
    let ground = textureSampleLevel(colors, linear, uv, max(lod - 2.0, 0.0)).rgb;
    let albedo = ground * vessel_filter(here.r, shadow, deep, above);
    let rise = vec2f(right - here.b, upper - here.b) / (step * side * texel);
    return ScleraSurface(albedo, sclera_normal(normal, p, rise), sclera_normal(normal, p, WHITE_SOFT * rise), unseen_slopes(max(footprint, texel)));
}

// The lumps of plica and caruncle at a point p of the head frame: their height (mm), how fast it rises along x and y, and whether there are
// any about it (1) or none (0).
fn lumps_at(vessels: texture_2d<f32>, linear: sampler, p: vec3f, footprint: f32, sclera_radius: f32) -> vec4f {
    let uv = sclera_uv(p);
    let side = f32(textureDimensions(vessels).x);
    let texel = 2.0 * SCLERA_HALF_ANGLE * sclera_radius / side;
    let lod = footprint_level(footprint, texel);
    let step = 1.5 * exp2(round(lod)) / side;
    let here = textureSampleLevel(vessels, linear, uv, lod).a;
    let right = textureSampleLevel(vessels, linear, uv + vec2f(step, 0.0), lod).a;
    let upper = textureSampleLevel(vessels, linear, uv + vec2f(0.0, step), lod).a;
    let about = textureSampleLevel(vessels, linear, uv, max(lod, log2(LUMPS_ABOUT_MM / texel))).a;
    return vec4f(here, vec2f(right - here, upper - here) / (step * side * texel), smoothstep(0.0, 0.03, about));
}

// How far about a place (mm) lumps count as being there.
const LUMPS_ABOUT_MM: f32 = 1.3;

// What a place between or on those lumps sends back against their mean: hollows hold more blood and less light.
fn lump_color(height: f32) -> vec3f {
    return mix(vec3f(0.80, 0.60, 0.57), vec3f(1.10, 1.12, 1.06), smoothstep(0.0, 0.11, height));
}

// The place whose relief a point p of the white has where it is `size` times as large, about the middle of the map.
fn relief_place(p: vec3f, size: f32) -> vec3f {
    let n = normalize(p);
    let across = length(n.xy);
    let angle = min(acos(clamp(-n.z, -1.0, 1.0)) / max(size, 1e-3), SCLERA_HALF_ANGLE);
    let aside = select(vec2f(0.0), n.xy / max(across, 1e-6), across > 1e-6);
    return length(p) * vec3f(sin(angle) * aside, -cos(angle));
}
