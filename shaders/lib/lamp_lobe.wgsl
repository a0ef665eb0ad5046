// needs: fresnel.wgsl, microfacet.wgsl
//
// The highlight of a lamp on a rough, moist surface. Twin: src/appearance/shading/lamp_lobe.rs.

// GGX parameter of a surface of this roughness under a lamp whose width blurs the lobe by `widening`.
fn lamp_alpha(roughness: f32, widening: f32) -> f32 {
    return clamp(roughness * roughness + widening, 1e-3, 1.0);
}

// Radiance towards v for a lamp from l with an irradiance / pi of one; n, v and l are unit vectors.
// Seen more obliquely than `least_cosine` the lobe grows no further.
fn lamp_lobe(n: vec3f, v: vec3f, l: vec3f, alpha: f32, index: f32, least_cosine: f32) -> f32 {
    let h = normalize(l + v);
    let nl = max(dot(n, l), 0.0);
    let nv = max(dot(n, v), least_cosine);
    let f = fresnel_dielectric(max(dot(v, h), 0.0), 1.0, index);
    return MICROFACET_PI * ggx_ndf(max(dot(n, h), 0.0), alpha) * ggx_visibility_smith(nv, nl, alpha) * f * nl;
}
