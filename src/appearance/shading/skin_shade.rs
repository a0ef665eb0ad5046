//! The skin of the lids and around them, the wet lid margin and the caruncle.
//! Twin: `shaders/lib/skin_shade.wgsl`, which says what is in `tissue`, `fine` and `coarse`.

use super::lamp_lobe::{lamp_alpha, lamp_lobe};
use super::mix;
use super::surroundings::wrapped_cosines;
use crate::optics::fresnel::fresnel_dielectric;
use glam::{DVec2, DVec3, DVec4};

/// The normal that faces the eye that looks, with the slope of pores and creases where skin is dry.
pub fn skin_normal(
    normal: DVec3,
    v: DVec3,
    tissue: DVec4,
    pores: f64,
    fine: DVec4,
    coarse: DVec4,
) -> DVec3 {
    let roughness = (1.0 - tissue.x.clamp(0.0, 1.0)) * (1.0 - tissue.z) * pores;
    // Both sides of the thin mesh may be seen at a corner; light the one that faces the camera.
    let n = if normal.dot(v) < -0.35 {
        -normal
    } else {
        normal
    };
    let gradient = DVec2::new(fine.x + 0.5 * coarse.y, fine.y + 0.5 * coarse.x).extend(0.0);
    (n - roughness * (gradient - n * gradient.dot(n))).normalize()
}

/// How skin changes from place to place ([`crate::tissue::skin::SkinVariation`]): by which powers of its blood and
/// of its melanin reflectance falls, and what a lid sends back against the face.
#[derive(Clone, Copy, Debug)]
pub struct Mottling {
    /// Of blood.
    pub blood: DVec3,
    /// Of melanin.
    pub melanin: DVec3,
    /// Of a lid.
    pub lid: DVec3,
}

/// Colour: mottled by blood and by melanin, that of a lid where skin is thin, pink at the margin.
pub fn skin_albedo(
    skin: DVec3,
    mottling: Mottling,
    flesh: DVec3,
    tissue: DVec4,
    fine: DVec4,
    coarse: DVec4,
) -> DVec3 {
    let thin = tissue.y.clamp(0.0, 1.0);
    let share = (tissue.x * 0.75).max(tissue.z).clamp(0.0, 1.0);
    let blood = coarse.z + 0.4 * fine.w;
    let melanin = 0.7 * fine.z + 0.4 * coarse.w;
    let mottled = skin * (-(mottling.blood * blood + mottling.melanin * melanin)).exp();
    let own = mottled * DVec3::ONE.lerp(mottling.lid, thin);
    own.lerp(flesh * (1.0 + 0.15 * fine.w), share * 0.85)
}

/// What skin takes up of a lamp with an irradiance / π of one from the unit direction `l`, and what passes
/// through a thin lid from behind its edge.
pub fn skin_lamp(n: DVec3, tissue: DVec4, l: DVec3) -> DVec3 {
    let thin = tissue.y.clamp(0.0, 1.0);
    let cosine = n.dot(l);
    let through = DVec3::new(1.0, 0.22, 0.12) * ((-cosine).max(0.0) * thin.powi(4) * 0.35);
    let shaded = mix(0.35, 1.0, tissue.w.clamp(0.0, 1.0));
    wrapped_cosines(cosine, DVec3::new(0.48, 0.28, 0.20)) * shaded + through
}

/// What of the surroundings' irradiance reaches skin that is hidden: red goes furthest into a fold.
pub fn skin_openness(tissue: DVec4) -> DVec3 {
    DVec3::new(0.30, 0.20, 0.17).lerp(DVec3::ONE, tissue.w.clamp(0.0, 1.0))
}

/// Highlight of one lamp on dry skin.
pub fn skin_sheen(n: DVec3, v: DVec3, l: DVec3, roughness: f64, lamp: f64) -> f64 {
    lamp_lobe(n, v, l, lamp_alpha(roughness, 0.3 * lamp), 1.42, 0.05)
}

/// Roughness of skin, smooth where its margin is wet.
pub fn skin_roughness(tissue: DVec4, roughness: f64) -> f64 {
    mix(roughness, 0.14, tissue.x.clamp(0.0, 1.0))
}

/// The two lobes of one lamp's sheen.
pub fn skin_lamp_sheen(
    n: DVec3,
    v: DVec3,
    tissue: DVec4,
    roughness: f64,
    l: DVec3,
    radius: f64,
) -> f64 {
    let rough = skin_roughness(tissue, roughness);
    0.62 * skin_sheen(n, v, l, rough, radius) + 0.38 * skin_sheen(n, v, l, rough * 1.7, 0.2)
}

/// Radiance of the sheen of skin and of the wet film on the margin: `lamps` the lamps' sheen, `ambient` the
/// irradiance / π about where a mirror looks, `mirrored` the radiance from there.
pub fn skin_specular(
    lamps: DVec3,
    ambient: DVec3,
    mirrored: DVec3,
    n: DVec3,
    v: DVec3,
    tissue: DVec4,
) -> DVec3 {
    let wet = tissue.x.clamp(0.0, 1.0);
    let cosine = n.dot(v).max(0.0);
    let dry = lamps + ambient * (0.022 + 0.16 * (1.0 - cosine).powi(5));
    let film = mirrored * (fresnel_dielectric(cosine, 1.0, 1.337) * 0.8);
    dry.lerp(film, wet * 0.7) * mix(0.25, 1.0, tissue.w.clamp(0.0, 1.0))
}
