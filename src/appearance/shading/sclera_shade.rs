//! The sclera's diffuse light. Eye frame, mm.
//! Twin: `shaders/lib/sclera_shade.wgsl`.

use super::footprint::footprint_level;
use super::surroundings::wrapped_cosines;
use crate::appearance::images::MapView;
use crate::optics::smoothstep::smoothstep;
use crate::tissue::sclera::SCLERA_INDEX;
use glam::{DVec2, DVec3, DVec4};

/// The map is azimuthal equidistant from the front, to 100°.
pub const SCLERA_HALF_ANGLE: f64 = 1.7453293;

/// Colour and normal of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScleraSurface {
    /// Albedo, linear sRGB.
    pub albedo: DVec3,
    /// Normal of its wet surface, with the map's relief.
    pub normal: DVec3,
    /// Normal of the tissue as its diffuse light shows it.
    pub soft: DVec3,
    /// Variance of its slopes along an axis that a pixel does not see.
    pub unseen: f64,
}

/// Place in the map of a point of the globe.
pub fn sclera_uv(p: DVec3) -> DVec2 {
    let n = p.normalize();
    let angle = (-n.z).clamp(-1.0, 1.0).acos();
    let direction = n.truncate().normalize_or_zero();
    0.5 + 0.5 * direction * (angle / SCLERA_HALF_ANGLE)
}

/// Depth (mm) of the episcleral vessels under the surface: below conjunctiva and half of the episclera
/// (REFERENCE-face).
pub const EPISCLERAL_DEPTH_MM: f64 = 0.15;
/// How far light travels sideways in the tissue, mm, so that a vessel's shadow is that wide: three mean free paths of
/// [`crate::tissue::sclera::sclera_scattering`].
pub const SHADOW_MM: f64 = 0.3;

/// The normal at `p` with relief that rises so fast (in the map, to the right and up): outwards from the front as fast on the globe, around it
/// faster, as the map spreads what lies there.
pub fn sclera_normal(normal: DVec3, p: DVec3, rise: DVec2) -> DVec3 {
    let n = p.normalize();
    let across = n.truncate().length();
    let away = if across > 1e-6 {
        n.truncate() / across
    } else {
        DVec2::X
    };
    let angle = (-n.z).clamp(-1.0, 1.0).acos();
    let spread = if across > 1e-3 { angle / across } else { 1.0 };
    let outward = (-n.z * away).extend(across);
    let around = away.perp();
    let along = rise.dot(around) * spread.min(4.0);
    (normal - rise.dot(away) * outward - along * around.extend(0.0)).normalize()
}

/// Share of the relief's slopes that diffuse light shows: it travels further than most of them are wide (a choice).
const WHITE_SOFT: f64 = 0.3;
/// Spread of the slopes of the relief of the wet white along an axis, rad, and the width of a pixel that no longer sees half of their
/// variance, mm: of the map's, a test of which holds them.
const WHITE_SLOPES: f64 = 0.044;
const WHITE_SLOPES_MM: f64 = 0.12;

/// Variance of the slopes of the wet white along an axis that a pixel of this footprint (mm) does not see one by one.
pub fn unseen_slopes(footprint: f64) -> f64 {
    let wide = (footprint.max(0.0) / WHITE_SLOPES_MM).powf(1.6);
    WHITE_SLOPES * WHITE_SLOPES * (1.0 - 1.0 / (1.0 + wide))
}

/// Roughness of a surface whose own is this and whose slopes vary by `unseen` more along an axis: variances add, and that of GGX's slopes is half of
/// the fourth power of the roughness.
pub fn white_rough(own: f64, unseen: f64) -> f64 {
    (own.powi(4) + 2.0 * unseen).sqrt().sqrt()
}

/// How far (rad) a surface of this roughness spreads what it mirrors, as [`super::surroundings::surroundings_radiance`] counts it, whose texels are
/// twice as wide as this: a slope turns what is mirrored by twice itself (√2 of the square of the roughness), and an even width w has a spread
/// of w/√12.
pub fn mirror_spread(roughness: f64) -> f64 {
    2.45 * roughness * roughness
}

/// What vessels with columns of blood of `column` mm in the mean leave of white light, linear sRGB: green by Beer's law, red and
/// blue in the proportion to it of a vessel of 0.05 mm that light crosses twice, as a vessel that is not resolved is a thread
/// of thick blood and not a veil of thin, which would be yellow.
pub fn blood_filter(column: f64) -> DVec3 {
    let green = 1.0 - (-18.8 * column.max(0.0)).exp();
    (1.0 - green * DVec3::new(0.218, 1.0, 1.148)).max(DVec3::ZERO)
}

/// Where (a step from the surface, mm, tangential) a view from the unit direction `v` is at this depth below a surface of
/// normal `n`.
pub fn view_shift(n: DVec3, v: DVec3, depth: f64) -> DVec3 {
    let aside = (v - n * n.dot(v)) / SCLERA_INDEX;
    aside * (-depth / (1.0 - aside.length_squared()).max(0.1).sqrt())
}

/// The place whose relief a point of the white has where it is `size` times as large, about the middle of the
/// map.
pub fn relief_place(p: DVec3, size: f64) -> DVec3 {
    let n = p.normalize();
    let angle = ((-n.z).clamp(-1.0, 1.0).acos() / size.max(1e-3)).min(SCLERA_HALF_ANGLE);
    let aside = n.truncate().normalize_or_zero() * angle.sin();
    p.length() * aside.extend(-angle.cos())
}

/// What vessels leave of the light that the white sends back: the superficial ones, with columns of `shallow` mm on the
/// way out and `shadow` on the way in, dim all of it; the deep ones what has not turned back above them (`above`).
pub fn vessel_filter(shallow: f64, shadow: f64, deep: f64, above: DVec3) -> DVec3 {
    let deep = blood_filter(2.0 * deep);
    blood_filter(shallow + shadow) * (deep + (DVec3::ONE - deep) * above)
}

/// What the white takes up of a lamp with an irradiance / π of one, at this cosine: light travels under the
/// surface, red furthest.
pub fn sclera_lamp(cosine: f64) -> DVec3 {
    wrapped_cosines(cosine, DVec3::new(0.42, 0.30, 0.24))
}

/// What the conjunctiva leaves of the light from the `white` below it, by Beer and Lambert: all of it where it is thin and
/// clear (`share` 0), as much as makes the white look like flesh where it is thick (`share` 1).
pub fn conjunctiva_filter(flesh: DVec3, white: DVec3, share: f64) -> DVec3 {
    let ratio = (flesh / white.max(DVec3::splat(0.02))).min(DVec3::splat(2.0));
    ratio.powf(share.clamp(0.0, 1.0))
}

/// Where and from where a place of the white is seen: point and unit direction (eye frame), width of a pixel there (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScleraSight {
    /// Point of the surface, mm.
    pub p: DVec3,
    /// Unit normal there.
    pub normal: DVec3,
    /// Unit direction towards the camera.
    pub v: DVec3,
    /// Width of a pixel, mm.
    pub footprint: f64,
}

/// The lumps of plica and caruncle at a point `p` of the head frame: their height (mm), how fast it rises
/// along x and y, and whether there are any about it (1) or none (0).
pub fn lumps_at(vessels: &MapView, p: DVec3, footprint: f64, sclera_radius: f64) -> DVec4 {
    let uv = sclera_uv(p);
    let side = vessels.size().x;
    let texel = 2.0 * SCLERA_HALF_ANGLE * sclera_radius / side;
    let lod = footprint_level(footprint, texel);
    let step = 1.5 * lod.round_ties_even().exp2() / side;
    let height = |x: f64, y: f64| vessels.sample(uv + DVec2::new(x, y) * step, lod)[3];
    let here = height(0.0, 0.0);
    let run = step * side * texel;
    let about = vessels.sample(uv, lod.max((LUMPS_ABOUT_MM / texel).log2()))[3];
    DVec4::new(
        here,
        (height(1.0, 0.0) - here) / run,
        (height(0.0, 1.0) - here) / run,
        smoothstep(0.0, 0.03, about),
    )
}

/// How far about a place (mm) lumps count as being there.
const LUMPS_ABOUT_MM: f64 = 1.3;

/// What a place between or on those lumps sends back against their mean: hollows hold more blood and less light.
pub fn lump_color(height: f64) -> DVec3 {
    DVec3::new(0.80, 0.60, 0.57).lerp(DVec3::new(1.10, 1.12, 1.06), smoothstep(0.0, 0.11, height))
}

/// Albedo and normal at a place. `colors` holds the albedo without vessels, `vessels` columns of blood (mm) near the surface
/// and deeper, and the height (mm); `above` is the share of light that does not reach the deeper ones.
pub fn sclera_surface(
    colors: &MapView,
    vessels: &MapView,
    sight: &ScleraSight,
    sclera_radius: f64,
    above: DVec3,
) -> ScleraSurface {
    let ScleraSight {
        p,
        normal,
        v,
        footprint,
    } = *sight;
    let uv = sclera_uv(p);
    let side = vessels.size().x;
    let texel = 2.0 * SCLERA_HALF_ANGLE * sclera_radius / side;
    let lod = footprint_level(footprint, texel);
    // WGSL rounds halves to even.
    let step = 1.5 * lod.round_ties_even().exp2() / side;
    let [shallow, _, here, _] = vessels.sample(uv, lod);
    let height = |x: f64, y: f64| vessels.sample(uv + DVec2::new(x, y) * step, lod)[2] - here;
    let rise = DVec2::new(height(1.0, 0.0), height(0.0, 1.0)) / (step * side * texel);
    let shift = view_shift(normal, v, EPISCLERAL_DEPTH_MM);
    let deep = vessels.sample(sclera_uv(p + shift), lod)[1];
    let shadow = vessels.sample(uv, lod.max((SHADOW_MM / texel).log2()))[0];
    let [r, g, b, _] = colors.sample(uv, (lod - 2.0).max(0.0));
    ScleraSurface {
        albedo: DVec3::new(r, g, b) * vessel_filter(shallow, shadow, deep, above),
        normal: sclera_normal(normal, p, rise),
        soft: sclera_normal(normal, p, WHITE_SOFT * rise),
        unseen: unseen_slopes(footprint.max(texel)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::blood::blood_transmittance;

    #[test]
    fn a_thread_of_blood_has_the_spectrums_colour() {
        // A round vessel of 0.05 mm is π/4 of that thick in the mean.
        let column = 2.0 * 0.05 * core::f64::consts::FRAC_PI_4;
        let (ours, exact) = (
            blood_filter(column),
            DVec3::from(blood_transmittance(column)),
        );
        assert!((ours - exact).abs().max_element() < 0.015, "{ours} {exact}");
        // Green, which decides how strong a vessel is, at all columns.
        for k in 0..=40 {
            let column = 0.005 * f64::from(k);
            let error = blood_filter(column).y - blood_transmittance(column)[1];
            assert!(error.abs() < 0.03, "{column}: {error}");
        }
        assert_eq!(blood_filter(9.0).z, 0.0);
    }

    #[test]
    fn depth_shifts_away_from_the_viewer_by_snell() {
        let (n, v) = (DVec3::NEG_Z, DVec3::new(0.5, 0.0, -0.75_f64.sqrt()));
        // sin 30°/1.37 is the sine inside.
        let inside = (0.5_f64 / 1.37).asin();
        let shift = view_shift(n, v, 0.2);
        assert!((shift - DVec3::NEG_X * 0.2 * inside.tan()).length() < 1e-12);
        assert_eq!(view_shift(n, n, 0.2).length(), 0.0);
    }

    #[test]
    fn deep_vessels_are_paler_and_bluer() {
        let above = DVec3::new(0.2, 0.3, 0.45);
        let (near, far) = (
            vessel_filter(0.04, 0.0, 0.0, above),
            vessel_filter(0.0, 0.0, 0.02, above),
        );
        assert!(far.y > near.y && far.z / far.x > 1.5 * near.z / near.x);
    }
}
