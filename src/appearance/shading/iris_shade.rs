//! The light that iris and pupil send back: subsurface texture mapping (François et al. 2007, section 5.4).
//!
//! Behind the relief the view is followed through border layer and stroma, segment by segment in closed form
//! ([`crate::tissue::layers`]), and each lamp's light to each segment by its own path; what is scattered more
//! than once is read from a table ([`crate::tissue::iris_reflectance`]), by light that has spread sideways.
//! Eye frame, mm. Twin: `shaders/lib/iris_shade.wgsl`.

use super::iris_relief::{
    IrisFrame, IrisMarch, IrisPlace, IrisTexel, iris_base, iris_lean, iris_level, iris_place,
    iris_step, iris_texel, iris_texel_mm, iris_within, relief_march, relief_normal, relief_way,
    stroma_back, stroma_of, stroma_over,
};
use super::mix;
use crate::appearance::images::MapView;
use crate::optics::smoothstep::smoothstep;
use crate::tissue::iris_layers::{BUNDLE_SCALED_COSINE, BUNDLE_SIDEWAYS};
use crate::tissue::iris_reflectance::{AQUEOUS_SLANT, BORDER_LAYER_MM, IrisTissue};
use crate::tissue::layers::layer_mean_transmittance;
use crate::tissue::phase::{PHASE_ISOTROPIC, phase_henyey_greenstein, phase_rayleigh};
use glam::{DVec2, DVec3, DVec4};

/// Longest path (mm) of the reflectance map.
pub const IRIS_PATH_MAX_MM: f64 = 2.5;
/// How far (mm) light that is scattered more than once spreads sideways: the width of the texels that it is smoothed over. Random walks
/// through strands 0.1 mm wide say so, in a test; in the dense bundles its mean free path is 0.12 mm at 480 nm.
pub const IRIS_SPREAD_MM: f64 = 0.08;
/// Over how much (mm) of the relief its normal is taken for that light: half of its mean free path in the mean of the stroma, 0.5 mm at 480 nm.
pub const IRIS_LEVEL_MM: f64 = 0.25;

/// The maps of one iris.
#[derive(Clone, Debug)]
pub struct IrisMaps {
    /// Relief, thickness and melanin.
    pub relief: MapView,
    /// Reflectance by path and melanin.
    pub reflectance: MapView,
    /// Light of the lamps.
    pub light: MapView,
}

/// Thickness (mm) that acts on light in the aqueous as the stroma does on light that comes towards z and is seen at this
/// cosine.
pub fn iris_path(thickness: f64, towards_z: f64, view_cosine: f64) -> f64 {
    let slants = 1.0 / (-towards_z).max(0.35) + 1.0 / view_cosine.max(0.35);
    thickness * (0.5 / AQUEOUS_SLANT) * slants
}

/// Where a refracted ray meets the iris, what is there, and what the ray passes behind.
#[derive(Clone, Copy, Debug)]
pub struct IrisSurface {
    /// Place, mm.
    pub at: DVec2,
    /// Place in the map.
    pub place: IrisPlace,
    /// How far the mean iris lies behind the plane of the pupil's edge there, mm.
    pub base: f64,
    /// How fast it falls back there, along x and y.
    pub lean: DVec2,
    /// What the map has there.
    pub texel: IrisTexel,
    /// Unit direction of the ray.
    pub direction: DVec3,
    /// The same over the iris laid flat ([`iris_within`]).
    pub within: DVec3,
    /// Level of the map.
    pub lod: f64,
    /// What the map has, smoothed by as much as light spreads.
    pub smooth_texel: IrisTexel,
    /// Normal of that relief.
    pub smooth_normal: DVec3,
    /// Path through the border layer, mm.
    pub border: f64,
    /// From where the ray meets the iris to where it is left, mm.
    pub reach: f64,
}

/// Where a refracted ray that lands at `point` of the mean iris, `start` in the map, meets it.
pub fn iris_surface(
    maps: &IrisMaps,
    iris: &IrisFrame,
    point: DVec2,
    start: &IrisPlace,
    direction: DVec3,
    footprint: f64,
    march: &IrisMarch,
) -> IrisSurface {
    let map = &maps.relief;
    let lod = iris_level(map.size(), footprint, direction, start);
    let flat = iris_within(direction, iris_lean(start, iris));
    let at = point + relief_march(map, iris, start, flat, lod, march);
    let place = iris_place(at, iris);
    let (base, lean) = (iris_base(place.uv.y, iris).x, iris_lean(&place, iris));
    let within = iris_within(direction, lean);
    let texel = iris_texel(map, iris, place.uv, lod);
    let finest = iris_texel_mm(map.size().y, 0.0, iris);
    let spread = lod.max((IRIS_SPREAD_MM / finest).log2());
    let smooth_texel = iris_texel(map, iris, place.uv, spread);
    let normal_lod = lod.max((IRIS_LEVEL_MM / finest).log2());
    let over = footprint.max(IRIS_LEVEL_MM);
    let smooth_normal = relief_normal(map, iris, &place, over, normal_lod, lean);

    let down = within.z.max(0.35);
    // As if the relief were level, and as deep as it is there.
    let level = BORDER_LAYER_MM / down;
    let step = iris_step(iris, &place, direction.truncate() * level);
    let there = iris_texel(map, iris, step, lod);
    let reached = down * level + there.height - texel.height;
    let border = level * (BORDER_LAYER_MM / reached.max(0.01)).clamp(0.5, 2.5);
    // Further than to the back of what is there: the view may leave a ridge and meet the next.
    let back = BORDER_LAYER_MM + stroma_back(stroma_of(&texel), iris);
    let reach = border + (march.reach * back / down - border).max(0.03);
    IrisSurface {
        at,
        place,
        base,
        lean,
        texel,
        direction,
        within,
        lod,
        smooth_texel,
        smooth_normal,
        border,
        reach,
    }
}

/// Which light a reflectance is of; the map holds one above the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scattered {
    /// All of it.
    All,
    /// What is scattered more than once.
    Again,
}

/// Diffuse reflectance of tissue on the path of light that arrives with this z.
pub fn iris_reflectance(
    maps: &IrisMaps,
    surface: &IrisSurface,
    towards_z: f64,
    which: Scattered,
) -> DVec3 {
    // Thickness counts along the axis, whichever way the iris leans.
    let leans = (1.0 + surface.lean.length_squared()).sqrt();
    let view_cosine = -surface.smooth_normal.dot(surface.direction) * leans;
    let path = iris_path(surface.smooth_texel.thickness, towards_z, view_cosine);
    let rows = 0.5 * maps.reflectance.size().y;
    let row = (surface.texel.melanin.max(0.0).sqrt() * rows).clamp(0.5, rows - 0.5);
    let half = f64::from(u8::from(which == Scattered::Again));
    let at = DVec2::new(path / IRIS_PATH_MAX_MM, 0.5 * (row / rows + half));
    let [r, g, b, _] = maps.reflectance.sample(at, 0.0);
    DVec3::new(r, g, b)
}

/// Share of a place that has tissue: the ruff is bare epithelium, which is black.
pub fn iris_covered(texel: &IrisTexel) -> f64 {
    smoothstep(0.03, 0.08, texel.thickness)
}

/// Radiance by one scattering of light with an irradiance of one across its beam that comes from the unit direction
/// `towards`; linear sRGB. The border layer and segments behind it, each in closed form; the beam gathers by this
/// share of itself a mm behind the mean iris ([`super::near_light::beam_on`]).
pub fn iris_scattered_once(
    maps: &IrisMaps,
    iris: &IrisFrame,
    tissue: &IrisTissue,
    surface: &IrisSurface,
    towards: DVec3,
    gathers: f64,
    march: &IrisMarch,
) -> DVec3 {
    let cosine = towards.dot(surface.direction);
    let rayleigh = phase_rayleigh(cosine);
    let peak = phase_henyey_greenstein(cosine, BUNDLE_SCALED_COSINE);
    let bundles = mix(peak, PHASE_ISOTROPIC, BUNDLE_SIDEWAYS);
    let phase = |fibrils: DVec3| bundles + fibrils * (rayleigh - bundles);
    let from_border = tissue.border_scattering * phase(tissue.border_fibrils);
    let from_stroma = tissue.stroma_scattering * phase(tissue.stroma_fibrils);
    let light = iris_within(towards, surface.lean);
    let (down, up) = (surface.within.z.max(0.35), (-light.z).max(0.25));
    let (mut scattered, mut passed) = (DVec3::ZERO, DVec3::ONE);
    let (mut begins, mut ends) = (0.0, 0.5 * surface.border);
    let (mut depth_before, mut along_before) = (0.0, 0.0);
    for i in 0..=march.segments + 1 {
        let in_front = i < 2;
        let along = 0.5 * (begins + ends);
        let (map, lod) = (&maps.relief, surface.lod);
        let aside = surface.direction.truncate() * along;
        let place = iris_place(surface.at + aside, iris);
        let there = iris_texel(map, iris, place.uv, lod);
        let under = down * along - surface.texel.height;
        let depth = under + there.height;
        // How fast the view goes down into it, which counts where the border layer is crossed.
        let steep = match in_front {
            true => ((depth - depth_before) / (along - along_before)).abs(),
            false => down,
        };
        let steep = steep.clamp(0.2 * down, 4.0 * down);
        (depth_before, along_before) = (depth, along);
        // What of the segment lies in the border layer and what in the stroma, before the black epithelium.
        let half = 0.5 * steep * (ends - begins);
        let stroma = stroma_of(&there);
        let back = BORDER_LAYER_MM + stroma_back(stroma, iris);
        let over = |depth: f64| stroma_over((depth - BORDER_LAYER_MM).max(0.0), stroma, iris);
        let [low, high] = [depth - half, depth + half].map(|depth| depth.clamp(0.0, back));
        let in_border = (high.min(BORDER_LAYER_MM) - low.min(BORDER_LAYER_MM)) / steep;
        let in_stroma = (over(high) - over(low)) / steep;
        let border = tissue.border + tissue.border_melanin * there.melanin;
        let takes = border * in_border + tissue.stroma * in_stroma;
        // Light's way to its middle.
        let way = if in_front {
            // So little of it lies in the border layer that it crosses the relief next to it.
            DVec3::new(depth.max(0.01), up * there.melanin, over(depth)) / up
        } else {
            relief_way(map, iris, &place, under, light, lod, march.looks)
        };
        let dims = tissue.border + tissue.border_melanin * way.y;
        let share = way.x / depth.max(0.01);
        let [arrives, leaves] = [low, high].map(|end| {
            let stroma = (way.z + share * (over(end) - over(depth))).max(0.0);
            dims * (share * end.min(BORDER_LAYER_MM)) + tissue.stroma * stroma
        });
        let gathered = (1.0 + gathers * under / up).clamp(0.5, 2.0);
        scattered += gathered
            * passed
            * (from_border * in_border + from_stroma * in_stroma)
            * layer_mean_transmittance(arrives, leaves + takes);
        // Behind it lies the black epithelium.
        passed *= (-takes).exp() * ((back - depth) / (2.0 * half) + 0.5).clamp(0.0, 1.0);
        // Shorter ones first, where more is left of the light.
        let part = i as f64 / march.segments as f64;
        begins = ends;
        ends = mix(surface.border, surface.reach, part * part);
    }
    tissue.weights * scattered
}

/// What the iris sends back of a lamp with an irradiance / π of one, of which this arrives
/// ([`crate::appearance::light_table::iris_light`]) at the mean iris and gathers ([`super::near_light::beam_on`]).
pub fn iris_lamp(
    maps: &IrisMaps,
    iris: &IrisFrame,
    tissue: &IrisTissue,
    surface: &IrisSurface,
    arrives: DVec4,
    gathers: f64,
    march: &IrisMarch,
) -> DVec3 {
    let towards = arrives.truncate();
    // Across the beam, from a plane across the axis.
    let across = arrives.w / (-towards.z).max(0.2);
    let once = iris_scattered_once(maps, iris, tissue, surface, towards, gathers, march)
        * (core::f64::consts::PI * across);
    let spread = across * surface.smooth_normal.dot(towards).max(0.0);
    let slant = iris_within(towards, surface.lean).z;
    let again = spread * iris_reflectance(maps, surface, slant, Scattered::Again);
    (once.max(DVec3::ZERO) + again) * iris_covered(&surface.texel)
}

/// Cosine in the aqueous that stands for light from all of the sky before an eye: one over the mean slant.
pub const IRIS_SKY_COSINE: f64 = 0.83;
/// Half the width (mm) of the grooves between fibres: what lies that deep in one sees half of the sky.
pub const IRIS_GROOVE_MM: f64 = 0.12;

/// What the iris sends back of surroundings with an irradiance / π of one; `sky` is what of an even one reaches its plane
/// ([`crate::appearance::light_table::iris_sky`]).
pub fn iris_ambient(maps: &IrisMaps, surface: &IrisSurface, sky: f64) -> DVec3 {
    let sunk = (surface.smooth_texel.height - surface.texel.height).max(0.0) / IRIS_GROOVE_MM;
    let arrives = sky / (1.0 + sunk * sunk) * iris_covered(&surface.texel);
    arrives * iris_reflectance(maps, surface, -IRIS_SKY_COSINE, Scattered::All)
}

/// Share of what is seen past the root at this part of the iris' width: the sclera's inner wall. Through a cornea hardly any of it is seen, as its
/// light is reflected totally there (tests), which is why an examiner lays a lens on it; a patient's file or an artist may take the refraction away.
pub fn angle_share(v: f64) -> f64 {
    smoothstep(1.0, 1.02, v)
}

/// Share of the iris (0 in the pupil, 1 outside) at a place of the map: the pupil's margin is uneven
/// and softened over a pixel.
pub fn pupil_edge(uv: DVec2, footprint: f64, width: f64) -> f64 {
    let uneven = 0.003 * (uv.x * 81.6814).sin() + 0.003 * (uv.x * 37.6991 + 1.7).sin();
    let soft = (0.75 * footprint / width).max(0.008);
    smoothstep(-soft, soft, uv.y - uneven)
}

#[cfg(test)]
mod tests;
