//! The highlight of a lamp on a rough, moist surface. Twin: `shaders/lib/lamp_lobe.wgsl`.

use crate::optics::fresnel::fresnel_dielectric;
use crate::optics::microfacet::{ggx_ndf, ggx_visibility_smith};
use core::f64::consts::PI;
use glam::DVec3;

/// GGX parameter of a surface of this roughness under a lamp whose width blurs the lobe by `widening`.
pub fn lamp_alpha(roughness: f64, widening: f64) -> f64 {
    (roughness * roughness + widening).clamp(1e-3, 1.0)
}

/// Radiance towards `v` for a lamp from `l` with an irradiance / π of one; unit vectors. Seen more
/// obliquely than `least_cosine` the lobe grows no further.
pub fn lamp_lobe(n: DVec3, v: DVec3, l: DVec3, alpha: f64, index: f64, least_cosine: f64) -> f64 {
    let h = (l + v).normalize();
    let nl = n.dot(l).max(0.0);
    let nv = n.dot(v).max(least_cosine);
    let f = fresnel_dielectric(v.dot(h).max(0.0), 1.0, index);
    PI * ggx_ndf(n.dot(h).max(0.0), alpha) * ggx_visibility_smith(nv, nl, alpha) * f * nl
}
