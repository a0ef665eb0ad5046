// needs: fresnel.wgsl, surroundings.wgsl, tear_film.wgsl
//
// What the tears mirror. Head frame, unit vectors; n the normal, v towards the eye that looks; `mirrored` is
// the radiance from where the mirror looks. Twin: src/appearance/shading/tear_reflection.rs.

// How much the upper lashes rise (1/mm: their height over the margin is this times the square of how far they stand before it), how
// far they reach forward (mm), and how dark they are.
const LASH_CURL: f32 = 0.09;
const LASH_REACH_MM: f32 = 8.0;
const LASH_DARK: f32 = 0.8;
// Their comb, rad/mm, and the share of it that is lash; the radius (mm) of the mirror that shrinks it.
const LASH_COMB: f32 = 19.0;
const LASH_SHARE: f32 = 0.29;
const LASH_MIRROR_MM: f32 = 7.8;

// Share of a ray in the unit direction r, from a place `x` mm aside and `upper_gap` mm below the upper lid's margin, that its
// lashes let pass: they stand as a comb on a sheet that curls up before the lid, and a pixel of this footprint (mm) that is wider
// than its teeth sees what they take in the mean.
fn lashes_pass(x: f32, r: vec3f, upper_gap: f32, footprint: f32) -> f32 {
    let forward = max(-r.z, 0.2);
    let rise = r.y / forward;
    let crosses = rise * rise - 4.0 * LASH_CURL * max(upper_gap, 0.0);
    let reach = (rise - sqrt(max(crosses, 0.0))) / (2.0 * LASH_CURL);
    let aside = x + r.x / forward * reach;
    let comb = sin(aside * LASH_COMB + 2.5 * sin(aside * 2.3) + 1.7 * sin(aside * 5.1));
    // How far apart neighbouring pixels' places on the sheet are.
    let turn = LASH_COMB * footprint * (1.0 + 2.0 * reach / LASH_MIRROR_MM + abs(r.x) / forward * inverseSqrt(max(crosses, 0.01)));
    let tooth = mix(LASH_SHARE, smoothstep(0.3, 0.95, comb), exp(-turn * turn));
    let there = smoothstep(0.0, 0.06, crosses) * smoothstep(0.0, 0.3, rise) * (1.0 - smoothstep(0.5 * LASH_REACH_MM, LASH_REACH_MM, reach));
    return 1.0 - LASH_DARK * there * tooth;
}

// Radiance from the film over the globe, `lipid_nm` of lipid on it, at a place `x` mm aside (head frame) and `upper_gap` mm below
// the upper lid's margin, a pixel being `footprint` mm wide: lids and lashes hide what lies above, and send back `lid_light` times what
// skin does.
fn tear_reflection(mirrored: vec3f, lid_light: vec3f, n: vec3f, v: vec3f, lipid_nm: f32, x: f32, upper_gap: f32, footprint: f32) -> vec3f {
    let cosine = clamp(dot(n, v), 0.0, 1.0);
    let f = tear_film_rgb(cosine, 1.48, 1.337, lipid_nm);
    return f * past_lids(mirrored, lid_light, reflect(-v, n), x, upper_gap, footprint);
}

// Radiance from the unit direction r at a place `x` mm aside (head frame) and `upper_gap` mm below the upper lid's margin: what is there, or
// the lids before it.
fn past_lids(mirrored: vec3f, lid_light: vec3f, r: vec3f, x: f32, upper_gap: f32, footprint: f32) -> vec3f {
    // The reflected ray rises by r.y for each unit forward; it meets the upper lid when that is steeper than the gap allows.
    let rise = r.y / max(length(r.xz), 0.05);
    let lid = smoothstep(-0.35, 0.35, upper_gap * 0.42 + 0.25 - rise);
    let skin = vec3f(0.45, 0.27, 0.20) * lid_light;
    return mix(skin, mirrored * lashes_pass(x, r, upper_gap, footprint), lid * past_head(r));
}

// Radiance from the meniscus along the lids, a clear thread of tears.
fn meniscus_reflection(mirrored: vec3f, lid_light: vec3f, n: vec3f, v: vec3f, x: f32, upper_gap: f32, footprint: f32) -> vec3f {
    let seen = past_lids(mirrored, lid_light, reflect(-v, n), x, upper_gap, footprint);
    return seen * fresnel_dielectric(max(dot(n, v), 0.0), 1.0, 1.337);
}

// How far (rad) the meniscus spreads what it mirrors into a pixel of this footprint (mm): its surface turns by the footprint over its
// radius of curvature, and what it mirrors by twice that; half of it to either side.
fn meniscus_blur(footprint: f32) -> f32 {
    return max(0.05, footprint / MENISCUS_RADIUS_MM);
}

// Of the meniscus's concave surface (0.365 ± 0.153 mm in normal eyes: Yokoi et al. 1999, Br J Ophthalmol 83:92).
const MENISCUS_RADIUS_MM: f32 = 0.365;
