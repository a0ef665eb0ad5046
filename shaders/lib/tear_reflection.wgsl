// needs: fresnel.wgsl, tear_film.wgsl
//
// What the tears mirror. Head frame, unit vectors; n the normal, v towards the eye that looks; `mirrored` is
// the radiance from where the mirror looks. Twin: src/appearance/shading/tear_reflection.rs.

// Radiance from the film over the globe, `lipid_nm` of lipid on it, at a place `upper_gap` mm below
// the upper lid's margin: lids and lashes hide what lies above, and send back `lid_light` times what skin does.
fn tear_reflection(mirrored: vec3f, lid_light: vec3f, n: vec3f, v: vec3f, lipid_nm: f32, upper_gap: f32) -> vec3f {
    let r = reflect(-v, n);
    let cosine = clamp(dot(n, v), 0.0, 1.0);
    let f = tear_film_rgb(cosine, 1.48, 1.337, lipid_nm);
    // The reflected ray rises by r.y for each unit forward; it meets the upper lid when that is steeper than the gap allows.
    let rise = r.y / max(length(r.xz), 0.05);
    let lid = smoothstep(-0.35, 0.35, upper_gap * 0.42 + 0.25 - rise);
    let outward = smoothstep(-0.05, 0.25, -r.z + 0.25);
    let skin = vec3f(0.45, 0.27, 0.20) * lid_light;
    return f * mix(skin, mirrored, lid * outward);
}

// Radiance from the meniscus along the lids, a clear thread of tears.
fn meniscus_reflection(mirrored: vec3f, n: vec3f, v: vec3f) -> vec3f {
    return mirrored * fresnel_dielectric(max(dot(n, v), 0.0), 1.0, 1.337);
}

// How far (rad) the meniscus spreads what it mirrors into a pixel of this footprint (mm): its surface turns by the footprint over its
// radius of curvature, and what it mirrors by twice that; half of it to either side.
fn meniscus_blur(footprint: f32) -> f32 {
    return max(0.05, footprint / MENISCUS_RADIUS_MM);
}

// Of the meniscus's concave surface (0.365 ± 0.153 mm in normal eyes: Yokoi et al. 1999, Br J Ophthalmol 83:92).
const MENISCUS_RADIUS_MM: f32 = 0.365;
