//! The skin of the lids and around them, the wet lid margin and the caruncle.
//! Twin: `shaders/lib/skin_shade.wgsl`, which says what is in `tissue`, `fine` and `coarse`.

use super::lamp_lobe::{lamp_alpha, lamp_lobe};
use super::mix;
use super::surroundings::wrapped_cosines;
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
    let gradient = DVec2::new(fine.x + 0.25 * coarse.y, fine.y + 0.25 * coarse.x).extend(0.0);
    (n - roughness * (gradient - n * gradient.dot(n))).normalize()
}

/// How wet the margin is where it is this near its posterior edge (1 there, 0 at the anterior one): tears reach to the
/// line of Marx, before which skin begins.
pub fn margin_wet(behind: f64) -> f64 {
    smoothstep(0.5, 0.9, behind)
}

/// Distance between the openings of Meibom's glands, mm: twenty to thirty of them open on a lower lid, in a row before
/// the line of Marx.
pub const GLAND_SPACING_MM: f64 = 1.05;
const GLAND_RIM_MM: f64 = 0.17;
const GLAND_HOLE_MM: f64 = 0.06;
/// Thickness of a lid's edge in its middle, mm: 1.8 above and 1.7 below (Pult 2015).
pub const MARGIN_MM: f64 = 1.75;

/// Share of a pixel of this footprint (mm) that the openings of Meibom's glands cover on the margin, this near its
/// posterior edge and `along` it (mm towards the temple, at rest): x their pale rims, y the holes in them. There are none
/// beyond the punctum.
pub fn margin_glands(behind: f64, along: f64, footprint: f64) -> DVec2 {
    let place = along / GLAND_SPACING_MM;
    let cell = place.floor();
    let odd = (cell * 0.7548777).rem_euclid(1.0);
    let row = 0.5 + 0.09 * (odd - 0.5);
    let off = DVec2::new(
        (place - cell - 0.5 - 0.4 * (odd - 0.5)) * GLAND_SPACING_MM,
        (behind - row) * MARGIN_MM,
    );
    let from_middle = off.length();
    let soft = (0.7 * footprint).max(0.05);
    let within = |radius: f64| smoothstep(radius + soft, radius - soft, from_middle);
    // Openings are oil or not, and where a pixel is wider than one of them they are a paler line.
    let lids = smoothstep(-9.5, -8.0, along) * (1.0 - smoothstep(10.0, 11.5, along));
    let seen = lids * (0.5 + 0.5 * odd) * (GLAND_RIM_MM / footprint.max(1e-3)).min(1.0);
    DVec2::new(within(GLAND_RIM_MM), within(GLAND_HOLE_MM)) * seen
}

/// Darkness of the grey line, where the muscle reaches the surface before the glands.
pub fn margin_grey_line(behind: f64, footprint: f64) -> f64 {
    let off = (behind - 0.3) * MARGIN_MM;
    let half_width = footprint.max(0.09);
    (-(off * off) / (half_width * half_width)).exp() * (0.09 / half_width).min(1.0)
}

/// Colour of the margin from that of its skin: before its wet edge it differs from the lid's as that does from the
/// face's, and has glands and the grey line (their sizes and tints are choices).
pub fn margin_albedo(own: DVec3, lid: DVec3, behind: f64, along: f64, footprint: f64) -> DVec3 {
    let glands = margin_glands(behind, along, footprint);
    let before = smoothstep(0.0, 0.4, behind) * (1.0 - margin_wet(behind));
    let flushed = own * DVec3::ONE.lerp(lid, before);
    let oil = flushed.max(DVec3::ZERO).powf(0.5) * DVec3::new(0.78, 0.74, 0.66);
    let pale = flushed.lerp(oil, 0.14 * glands.x);
    let line = margin_grey_line(behind, footprint);
    pale * (1.0 - 0.12 * glands.y) * (DVec3::ONE - DVec3::new(0.10, 0.08, 0.05) * line)
}

/// Where crow's feet come from, mm, how many there are to a radian, and how far apart the lid's creases are, mm (choices).
const CROWS_FEET_MM: DVec2 = DVec2::new(11.5, -0.5);
const CROWS_FEET_A_RAD: f64 = 5.0;
const LID_CREASE_MM: f64 = 2.1;

/// Slope of the wrinkles of age at a place `q` (mm, head frame, at rest) of the skin of a right eye, `depth` mm deep:
/// crow's feet, which fan out from the outer canthus, and creases that run along below the lower lid.
pub fn skin_wrinkles(q: DVec2, depth: f64) -> DVec2 {
    let off = q - CROWS_FEET_MM;
    // At the very place from which they come no direction is any line's.
    let from = if off.length_squared() < 1e-6 {
        DVec2::new(1e-3, 0.0)
    } else {
        off
    };
    let r = from.length().max(1.0);
    let angle = from.y.atan2(from.x);
    let fan = angle * CROWS_FEET_A_RAD + 0.35 * (0.5 * r).sin();
    let there = smoothstep(2.0, 7.0, r)
        * (1.0 - smoothstep(13.0, 27.0, r))
        * (1.0 - smoothstep(0.7, 1.35, angle.abs()));
    let feet = from.perp() / r * (CROWS_FEET_A_RAD / r) * groove(fan) * there;
    let below = q.y + 8.6 - 0.022 * q.x * q.x;
    let under = (1.0 - smoothstep(-1.5, 0.5, below))
        * smoothstep(-9.0, -5.0, below)
        * (1.0 - smoothstep(9.0, 15.0, q.x.abs()));
    let along = below / LID_CREASE_MM + 0.2 * (0.6 * q.x).sin();
    let creases = DVec2::new(-0.044 * q.x, 1.0) / LID_CREASE_MM * groove(along) * under;
    depth * (feet + 0.6 * creases)
}

/// Slope of grooves of depth one, one to a unit of `x`.
pub fn groove(x: f64) -> f64 {
    let s = (x.rem_euclid(1.0) - 0.5) / 0.13;
    2.0 / 0.13 * s * (-s * s).exp()
}

/// The normal `n` with this slope of the surface along x and y added.
pub fn skin_tilted(n: DVec3, slope: DVec2) -> DVec3 {
    let gradient = slope.extend(0.0);
    (n - (gradient - n * gradient.dot(n))).normalize()
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
    let blood = 1.4 * coarse.z + 0.6 * fine.w;
    let melanin = 1.45 * fine.z + 0.8 * coarse.w + 0.9 * fine.w;
    let mottled = skin * (-(mottling.blood * blood + mottling.melanin * melanin)).exp();
    let own = mottled * DVec3::ONE.lerp(mottling.lid, thin);
    own.lerp(flesh * (1.0 + 0.15 * fine.w), share * 0.85)
}

/// What skin takes up of a lamp with an irradiance / π of one from the unit direction `l`, and what passes
/// through a thin lid from behind its edge.
pub fn skin_lamp(n: DVec3, tissue: DVec4, l: DVec3) -> DVec3 {
    let thin = tissue.y.clamp(0.0, 1.0);
    let cosine = n.dot(l);
    let open = 0.35 * (1.0 - tissue.z.clamp(0.0, 1.0));
    let through = DVec3::new(1.0, 0.22, 0.12) * ((-cosine).max(0.0) * thin.powi(4) * open);
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

/// The three lobes of one lamp's sheen.
pub fn skin_lamp_sheen(
    n: DVec3,
    v: DVec3,
    tissue: DVec4,
    roughness: f64,
    l: DVec3,
    radius: f64,
) -> f64 {
    let rough = skin_roughness(tissue, roughness);
    let broad =
        0.5 * skin_sheen(n, v, l, rough, radius) + 0.37 * skin_sheen(n, v, l, rough * 1.7, 0.2);
    broad + 0.13 * skin_sheen(n, v, l, rough * 0.5, radius)
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
    let cosine = n.dot(v).clamp(0.0, 1.0);
    let dry = lamps + ambient * (0.022 + 0.16 * (1.0 - cosine).powi(5));
    let film = mirrored * (fresnel_dielectric(cosine, 1.0, 1.337) * 0.8);
    dry.lerp(film, wet * 0.7) * mix(0.25, 1.0, tissue.w.clamp(0.0, 1.0))
}
