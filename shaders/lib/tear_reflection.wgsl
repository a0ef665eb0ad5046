// needs: fresnel.wgsl, lash_comb.wgsl, lid_shade.wgsl, surroundings.wgsl, tear_film.wgsl
//
// What the tears mirror. Head frame, unit vectors; n the normal, v towards the eye that looks; `mirrored` is
// the radiance from where the mirror looks. Twin: src/appearance/shading/tear_reflection.rs.

// Radius (mm) of the mirror that shrinks the lashes.
const LASH_MIRROR_MM: f32 = 7.8;

// Share of a mirrored ray that the lashes let pass to a pixel of this footprint (mm), see `lashes_left`.
fn lashes_pass(x: f32, r: vec3f, upper_gap: f32, footprint: f32) -> f32 {
    return lashes_left(x, r, upper_gap, footprint, 2.0 * footprint / LASH_MIRROR_MM);
}

// Radiance from the film over the globe, `lipid_nm` of lipid on it, at a place between the lids (`shade`), a pixel being `footprint` mm wide: lids
// and lashes hide what lies above and below, and send back `lids`.
fn tear_reflection(mirrored: vec3f, lids: vec3f, n: vec3f, v: vec3f, lipid_nm: f32, shade: LidShade, footprint: f32) -> vec3f {
    let cosine = clamp(dot(n, v), 0.0, 1.0);
    let f = tear_film_rgb(cosine, 1.48, 1.337, lipid_nm);
    return f * past_lids(mirrored, lids, reflect(-v, n), shade, footprint);
}

// How soft the lids' edges are as they are mirrored, of how steep a ray is.
const LID_MIRROR_SOFT: f32 = 0.35;

// Radiance from the unit direction r at a place between the lids: what is there, or the lids before it.
fn past_lids(mirrored: vec3f, lids: vec3f, r: vec3f, shade: LidShade, footprint: f32) -> vec3f {
    // The ray rises by r.y for each unit forward; it meets a lid where that is steeper than its edge.
    let rise = r.y / max(length(r.xz), 0.05);
    let upper = (shade.upper_gap + LID_EDGE_UP_MM) / LID_EDGE_MM - rise;
    let lower = (shade.lower_gap + LID_EDGE_UP_MM) / LID_EDGE_MM + rise;
    let past = smoothstep(-LID_MIRROR_SOFT, LID_MIRROR_SOFT, upper) * smoothstep(-LID_MIRROR_SOFT, LID_MIRROR_SOFT, lower);
    return mix(lids, mirrored * lashes_pass(shade.aside, r, shade.upper_gap, footprint), past * past_head(r));
}

// Radiance from the meniscus along the lids, a clear thread of tears.
fn meniscus_reflection(mirrored: vec3f, lids: vec3f, n: vec3f, v: vec3f, shade: LidShade, footprint: f32) -> vec3f {
    let seen = past_lids(mirrored, lids, reflect(-v, n), shade, footprint);
    return seen * fresnel_dielectric(max(dot(n, v), 0.0), 1.0, 1.337);
}

// How far (rad) the meniscus spreads what it mirrors into a pixel of this footprint (mm): its surface turns by the footprint over its
// radius of curvature, and what it mirrors by twice that; half of it to either side.
fn meniscus_blur(footprint: f32) -> f32 {
    return max(0.05, footprint / MENISCUS_RADIUS_MM);
}

// Of the meniscus's concave surface (0.365 ± 0.153 mm in normal eyes: Yokoi et al. 1999, Br J Ophthalmol 83:92).
const MENISCUS_RADIUS_MM: f32 = 0.365;
