//! What the tears mirror of the surroundings. Head frame, unit vectors; `n` the normal, `v` towards the
//! eye that looks. Twin: `shaders/lib/tear_reflection.wgsl`.

use super::lash_comb::lashes_left;
use super::lid_shade::{LID_EDGE_MM, LID_EDGE_UP_MM, LidShade};
use super::surroundings::past_head;
use crate::optics::fresnel::fresnel_dielectric;
use crate::optics::smoothstep::smoothstep;
use crate::optics::tear_film::tear_film_rgb;
use glam::{DVec2, DVec3};

/// Radius of the mirror that shrinks the lashes, mm: a cornea's.
const LASH_MIRROR_MM: f64 = 7.8;

/// Share of a mirrored ray that the lashes let pass to a pixel of this `footprint` (mm); arguments as of [`lashes_left`].
pub fn lashes_pass(x: f64, r: DVec3, upper_gap: f64, footprint: f64) -> f64 {
    lashes_left(x, r, upper_gap, footprint, 2.0 * footprint / LASH_MIRROR_MM)
}

/// Radiance from the film over the globe, `lipid_nm` of lipid on it, at a place between the lids (`shade`), a pixel being `footprint` mm wide:
/// lids and lashes hide what lies above and below, and send back `lids`. `mirrored` is the radiance from where the mirror looks.
pub fn tear_reflection(
    mirrored: DVec3,
    lids: DVec3,
    [n, v]: [DVec3; 2],
    lipid_nm: f64,
    shade: &LidShade,
    footprint: f64,
) -> DVec3 {
    let f = tear_film_rgb(n.dot(v).clamp(0.0, 1.0), 1.48, 1.337, lipid_nm);
    f * past_lids(mirrored, lids, reflected(v, n), shade, footprint)
}

/// How soft the lids' edges are as they are mirrored, of how steep a ray is (a choice).
const LID_MIRROR_SOFT: f64 = 0.35;

/// Radiance from the unit direction `r` at a place between the lids: what is there, or the lids before it; arguments as of
/// [`tear_reflection`].
fn past_lids(mirrored: DVec3, lids: DVec3, r: DVec3, shade: &LidShade, footprint: f64) -> DVec3 {
    // The ray rises by r.y for each unit forward; it meets a lid where that is steeper than its edge.
    let rise = r.y / DVec2::new(r.x, r.z).length().max(0.05);
    let edge = |gap: f64| (gap + LID_EDGE_UP_MM) / LID_EDGE_MM;
    let soft = |off: f64| smoothstep(-LID_MIRROR_SOFT, LID_MIRROR_SOFT, off);
    let past = soft(edge(shade.upper_gap) - rise) * soft(edge(shade.lower_gap) + rise);
    lids.lerp(
        mirrored * lashes_pass(shade.aside, r, shade.upper_gap, footprint),
        past * past_head(r),
    )
}

/// Radiance from the meniscus along the lids, a clear thread of tears; arguments as of [`tear_reflection`].
pub fn meniscus_reflection(
    mirrored: DVec3,
    lids: DVec3,
    [n, v]: [DVec3; 2],
    shade: &LidShade,
    footprint: f64,
) -> DVec3 {
    let seen = past_lids(mirrored, lids, reflected(v, n), shade, footprint);
    seen * fresnel_dielectric(n.dot(v).max(0.0), 1.0, 1.337)
}

/// Direction from which the light comes that a mirror of normal `n` sends towards `v`.
pub(super) fn reflected(v: DVec3, n: DVec3) -> DVec3 {
    2.0 * n.dot(v) * n - v
}

/// Radius of the meniscus's concave surface, mm (0.365 ± 0.153 in normal eyes: Yokoi et al. 1999, Br J Ophthalmol 83:92).
const MENISCUS_RADIUS_MM: f64 = 0.365;

/// How far (rad) the meniscus spreads what it mirrors into a pixel of this footprint (mm): its surface turns by the footprint over its
/// radius of curvature, and what it mirrors by twice that; half of it to either side.
pub fn meniscus_blur(footprint: f64) -> f64 {
    (footprint / MENISCUS_RADIUS_MM).max(0.05)
}
