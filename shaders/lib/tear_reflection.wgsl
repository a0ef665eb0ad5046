// needs: fresnel.wgsl, lash_comb.wgsl, surroundings.wgsl, tear_film.wgsl
//
// What the tears mirror. Head frame, unit vectors; n the normal, v towards the eye that looks; `mirrored` is
// the radiance from where the mirror looks. Twin: src/appearance/shading/tear_reflection.rs.

// Radius (mm) of the mirror that shrinks the lashes.
const LASH_MIRROR_MM: f32 = 7.8;

// Share of a mirrored ray that the lashes let pass to a pixel of this footprint (mm), see `lashes_left`.
fn lashes_pass(x: f32, r: vec3f, upper_gap: f32, footprint: f32) -> f32 {
    return lashes_left(x, r, upper_gap, footprint, 2.0 * footprint / LASH_MIRROR_MM);
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
