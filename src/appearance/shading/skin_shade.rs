//! The skin of the lids and around them, the wet lid margin and the caruncle.
//! Twin: `shaders/lib/skin_shade.wgsl`, which says what is in `tissue`, `fine` and `coarse`.

use super::lamp_lobe::{lamp_alpha, lamp_lobe};
use super::mix;
use super::studio::{studio_ambient, studio_radiance, wrapped_cosine};
use super::tear_reflection::reflected;
use crate::appearance::materials::Studio;
use crate::optics::fresnel::fresnel_dielectric;
use crate::optics::smoothstep::smoothstep;
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

/// Colour: mottled by blood and by melanin, redder where the lid is thin, pink at the margin.
/// `distance_mm` is the distance from the globe's centre, `globe_mm` its radius.
pub fn skin_albedo(
    skin: DVec3,
    flesh: DVec3,
    tissue: DVec4,
    fine: DVec4,
    coarse: DVec4,
    distance_mm: f64,
    globe_mm: f64,
) -> DVec3 {
    let wet = tissue.x.clamp(0.0, 1.0);
    let thin = tissue.y.clamp(0.0, 1.0);
    let share = (tissue.x * 0.75).max(tissue.z).clamp(0.0, 1.0);
    let blotch = DVec3::new(0.10, 0.16, 0.18) * (0.6 * coarse.z + 0.4 * fine.z);
    let speck = 0.5 * fine.w;
    let mottled = skin * (1.0 + blotch + DVec3::new(0.05, 0.07, 0.07) * speck);
    let reddened = mottled * DVec3::ONE.lerp(DVec3::new(0.97, 0.86, 0.86), thin);
    let albedo = reddened.lerp(flesh * (1.0 + 0.3 * speck), share * 0.85);
    // Where wet tissue comes down onto the globe it is conjunctiva over sclera: pale, so that no edge
    // shows between the two.
    let onto_globe = wet * smoothstep(globe_mm + 1.7, globe_mm + 0.15, distance_mm);
    albedo.lerp(
        DVec3::new(0.70, 0.59, 0.54),
        onto_globe * (1.0 - 0.75 * tissue.z),
    )
}

/// Irradiance / π, and what passes through a thin lid from behind its edge.
pub fn skin_light(studio: &Studio, n: DVec3, tissue: DVec4) -> DVec3 {
    let thin = tissue.y.clamp(0.0, 1.0);
    let open = tissue.w.clamp(0.0, 1.0);
    let (key, fill) = (
        n.dot(studio.key_direction.as_dvec3()),
        n.dot(studio.fill_direction.as_dvec3()),
    );
    let wrapped =
        |cosine: f64| DVec3::new(0.48, 0.28, 0.20).map(|wrap| wrapped_cosine(cosine, wrap));
    let ambient = studio_ambient(studio, n) * DVec3::new(0.30, 0.20, 0.17).lerp(DVec3::ONE, open);
    let lamps =
        studio.key_color.as_dvec3() * wrapped(key) + studio.fill_color.as_dvec3() * wrapped(fill);
    let through = DVec3::new(1.0, 0.22, 0.12) * ((-key).max(0.0) * thin * 0.35);
    ambient + lamps * mix(0.35, 1.0, open) + studio.key_color.as_dvec3() * through
}

/// Highlight of one lamp on dry skin.
pub fn skin_sheen(n: DVec3, v: DVec3, l: DVec3, roughness: f64, lamp: f64) -> f64 {
    lamp_lobe(n, v, l, lamp_alpha(roughness, 0.3 * lamp), 1.42, 0.05)
}

/// Radiance of the sheen of skin and of the wet film on the margin.
pub fn skin_specular(studio: &Studio, n: DVec3, v: DVec3, tissue: DVec4, roughness: f64) -> DVec3 {
    let wet = tissue.x.clamp(0.0, 1.0);
    let (key, fill) = (
        studio.key_direction.as_dvec3(),
        studio.fill_direction.as_dvec3(),
    );
    let rough = mix(roughness, 0.14, wet);
    let r = reflected(v, n);
    let key_width = f64::from(studio.key_radius);
    let lobes = 0.62 * skin_sheen(n, v, key, rough, key_width)
        + 0.38 * skin_sheen(n, v, key, rough * 1.7, 0.2);
    let grazing = 1.0 - n.dot(v).max(0.0);
    let mut specular = studio.key_color.as_dvec3() * lobes
        + studio.fill_color.as_dvec3() * skin_sheen(n, v, fill, rough * 1.2, 0.3)
        + studio_ambient(studio, r) * (0.022 + 0.16 * grazing.powi(5));
    if wet > 0.02 {
        let film = fresnel_dielectric(n.dot(v).max(0.0), 1.0, 1.337) * 0.8;
        specular = specular.lerp(studio_radiance(studio, r, 0.10) * film, wet * 0.7);
    }
    specular * mix(0.25, 1.0, tissue.w.clamp(0.0, 1.0))
}
