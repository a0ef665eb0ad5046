// GGX microfacets (Walter et al. 2007) with the height-correlated Smith visibility (Heitz 2014).
// `alpha` is the roughness parameter of those papers, above 0. Twin: src/optics/microfacet.rs.

const MICROFACET_PI: f32 = 3.141592653589793;

// Density of microfacet normals (sr⁻¹) at `cos_half`, the cosine between normal and half vector;
// its integral over projected solid angle is 1 (Walter's equation 33).
fn ggx_ndf(cos_half: f32, alpha: f32) -> f32 {
    if cos_half <= 0.0 {
        return 0.0;
    }
    let c = min(cos_half, 1.0);
    let a = alpha * alpha;
    // (1 − c)(1 + c) keeps the sine of a small angle, which c²(α² − 1) + 1 loses.
    let spread = (1.0 - c) * (1.0 + c) + a * c * c;
    return a / (MICROFACET_PI * spread * spread);
}

// G₂ / (4 cos_view cos_light), Heitz's equation 99: the lobe is ndf × visibility × Fresnel.
fn ggx_visibility_smith(cos_view: f32, cos_light: f32, alpha: f32) -> f32 {
    if cos_view <= 0.0 || cos_light <= 0.0 {
        return 0.0;
    }
    let a = alpha * alpha;
    let view = cos_light * sqrt(cos_view * cos_view * (1.0 - a) + a);
    let light = cos_view * sqrt(cos_light * cos_light * (1.0 - a) + a);
    return 0.5 / (view + light);
}
