//! The radiance of a pixel of an iris by paths: the tissue as a body between the relief and its back, the view and each
//! lamp's light followed through it in small steps.

use super::seen::{IrisPicture, SeenIris};
use crate::appearance::illumination::Lamp;
use crate::appearance::light_table::{FADE, LightTableSettings};
use crate::appearance::shading::iris_relief::{
    IrisTexel, iris_base, iris_lean, iris_level, iris_place, iris_texel, iris_texel_mm,
    iris_within, stroma_density, stroma_of,
};
use crate::appearance::shading::iris_shade::{
    IRIS_LEVEL_MM, IRIS_SPREAD_MM, IrisSurface, Scattered, iris_covered, iris_reflectance,
};
use crate::appearance::shading::near_light::light_entry;
use crate::optics::caustic::near_irradiance;
use crate::tissue::iris_layers::{BUNDLE_SCALED_COSINE, BUNDLE_SIDEWAYS};
use crate::tissue::iris_reflectance::BORDER_LAYER_MM;
use crate::tissue::phase::{PHASE_ISOTROPIC, phase_henyey_greenstein, phase_rayleigh};
use bevy::math::{DVec2, DVec3};
use core::f64::consts::PI;

/// Step (mm of depth) by which the view looks for the relief.
const MARCH_MM: f64 = 0.004;
/// Steps (mm) along the view in the border layer, in the stroma, and of light on its way in.
const FINE_MM: f64 = 0.004;
const COARSE_MM: f64 = 0.01;

/// Light of a lamp at a place behind the cornea.
struct Arriving {
    /// Unit direction from the place towards where it enters.
    towards: DVec3,
    /// Irradiance across its beam, over the lamp's own.
    across: f64,
    /// Where it enters the cornea.
    enters: DVec3,
    /// Unit direction towards the lamp from there, and how much nearer it is than from the globe's centre.
    lamp: (DVec3, f64),
}

impl IrisPicture {
    fn texel(&self, at: DVec2, lod: f64) -> IrisTexel {
        let place = iris_place(at, &self.frame);
        iris_texel(&self.maps.relief, &self.frame, place.uv, lod)
    }

    /// Depth of a place below the surface of the tissue over or under it, and what that is.
    fn depth(&self, p: DVec3, lod: f64) -> (f64, IrisTexel) {
        let texel = self.texel(p.truncate(), lod);
        let surface = self.iris_depth() + self.base(p.truncate()) - texel.height;
        (p.z - surface, texel)
    }

    /// How far the mean iris lies behind the plane of the pupil's edge.
    fn base(&self, at: DVec2) -> f64 {
        iris_base(iris_place(at, &self.frame).uv.y, &self.frame).x
    }

    /// How far before and behind that plane any of its tissue lies.
    fn extent(&self) -> [f64; 2] {
        let (frame, thicken) = (&self.frame, self.frame.thicken);
        let bows = 0.25 * frame.width() * frame.bow;
        let falls = frame.width() * frame.cone;
        [
            falls.min(0.0) - bows.max(0.0) - 0.3 * thicken,
            falls.max(0.0) + (-bows).max(0.0) + 0.6 * thicken,
        ]
    }

    /// The first place of the view's ray that is not before the relief.
    fn meets(&self, seen: &SeenIris, lod: f64) -> DVec3 {
        let (point, direction) = (seen.trace.point, seen.trace.direction);
        let at = |depth: f64| point + direction * (depth / direction.z.max(0.05));
        let [mut before, deepest] = self.extent();
        while before < deepest {
            let next = before + MARCH_MM;
            if self.depth(at(next), lod).0 >= 0.0 {
                let (mut out, mut within) = (before, next);
                for _ in 0..40 {
                    let middle = 0.5 * (out + within);
                    if self.depth(at(middle), lod).0 >= 0.0 {
                        within = middle;
                    } else {
                        out = middle;
                    }
                }
                return at(within);
            }
            before = next;
        }
        at(deepest)
    }

    fn normal(&self, at: DVec2, over_mm: f64, lod: f64) -> DVec3 {
        let height = |step: DVec2| self.texel(at + step, lod).height - self.base(at + step);
        let half = 0.5 * over_mm;
        let rise = |axis: DVec2| height(axis * half) - height(-axis * half);
        let slope = DVec2::new(rise(DVec2::X), rise(DVec2::Y)) / over_mm;
        (-slope).extend(-1.0).normalize()
    }

    /// The surface at a place of it, for what is scattered more than once.
    fn surface(&self, seen: &SeenIris, at: DVec3, lod: f64) -> IrisSurface {
        let finest = iris_texel_mm(self.maps.relief.size().y, 0.0, &self.frame);
        let spread = lod.max((IRIS_SPREAD_MM / finest).log2());
        let normal_lod = lod.max((IRIS_LEVEL_MM / finest).log2());
        let over = at.truncate();
        let place = iris_place(over, &self.frame);
        let lean = iris_lean(&place, &self.frame);
        IrisSurface {
            at: over,
            place,
            base: self.base(over),
            lean,
            texel: self.texel(over, lod),
            direction: seen.trace.direction,
            within: iris_within(seen.trace.direction, lean),
            lod,
            smooth_texel: self.texel(over, spread),
            smooth_normal: self.normal(over, seen.footprint.max(IRIS_LEVEL_MM), normal_lod),
            border: 0.0,
            reach: 0.0,
        }
    }

    /// Light of a lamp (eye frame) at a place, by Fermat's principle; `None` in the dark.
    fn arriving(&self, lamp: &Lamp, p: DVec3) -> Option<Arriving> {
        let settings = LightTableSettings {
            surface: self.anterior(),
            index: self.aqueous(),
            iris_z: p.z,
            root_mm: self.frame.root,
            limbus_mm: self.frame.limbus,
        };
        let solve = |light: DVec3| {
            let exact = settings.exact(light, p.truncate());
            let aside = exact.towards;
            let towards = aside.extend(-(1.0 - aside.length_squared()).max(0.0).sqrt());
            (exact, towards, light_entry(p, towards, settings.surface))
        };
        let (light, nearer, (exact, towards, enters), on_plane) = match self.lamp_place(lamp) {
            None => {
                let light = lamp.direction.as_dvec3();
                let solved = solve(light);
                let on_plane = solved.0.unbounded_irradiance;
                (light, 1.0, solved, on_plane)
            }
            Some(place) => {
                let mut light = place.normalize();
                let mut solved = solve(light);
                for _ in 0..20 {
                    light = (place - solved.2).normalize();
                    solved = solve(light);
                }
                let unit = 1.0 / f64::from(lamp.vergence);
                let nearer = unit / place.distance(solved.2);
                let on_plane =
                    near_irradiance(place, solved.2, unit, settings.surface, settings.index, p.z);
                (light, nearer, solved, on_plane)
            }
        };
        let inside = exact.passes_limbus(self.frame.limbus);
        let fade = (1.0 - light.z / FADE).clamp(0.0, 1.0);
        let across = on_plane * inside * fade / (-towards.z).max(0.05);
        (across > 0.0).then_some(Arriving {
            towards,
            across,
            enters,
            lamp: (light, nearer),
        })
    }

    /// What tissue at this depth below its surface takes from light, 1/mm; `None` behind its back.
    fn extinction(&self, depth: f64, texel: &IrisTexel) -> Option<DVec3> {
        if depth < 0.0 {
            Some(DVec3::ZERO)
        } else if depth < BORDER_LAYER_MM {
            Some(self.tissue.border + self.tissue.border_melanin * texel.melanin)
        } else {
            let (behind, stroma) = (depth - BORDER_LAYER_MM, stroma_of(texel));
            let density = stroma_density(behind, stroma, &self.frame)?;
            Some(self.tissue.stroma * density)
        }
    }

    /// Optical depth of all tissue from a place towards where its light enters; `None` where the black epithelium is in the way.
    fn way_in(&self, from: DVec3, towards: DVec3, lod: f64) -> Option<DVec3> {
        let top = self.iris_depth() + self.extent()[0];
        let mut sum = DVec3::ZERO;
        let mut along = 0.0;
        loop {
            // Fine where it begins, as the border layer is thin.
            let step = if along < 0.08 { FINE_MM } else { COARSE_MM };
            let p = from + towards * (along + 0.5 * step);
            if p.z < top {
                return Some(sum);
            }
            let (depth, texel) = self.depth(p, lod);
            sum += self.extinction(depth, &texel)? * step;
            along += step;
            // Nothing is left of it.
            if sum.min_element() > 20.0 || along > 10.0 {
                return None;
            }
        }
    }

    /// Radiance at three wavelengths by one scattering of a lamp's light, over its irradiance.
    fn once(&self, seen: &SeenIris, lamp: &Lamp, from: DVec3, lod: f64) -> DVec3 {
        let direction = seen.trace.direction;
        let (mut sum, mut passed, mut along) = (DVec3::ZERO, DVec3::ONE, 0.0);
        while along < 10.0 && passed.max_element() > 1e-4 {
            let step = if along < 0.1 { FINE_MM } else { COARSE_MM };
            let p = from + direction * (along + 0.5 * step);
            along += step;
            let (depth, texel) = self.depth(p, lod);
            let Some(extinction) = self.extinction(depth, &texel) else {
                break;
            };
            if depth < 0.0 {
                // It may come out of a ridge, and go past all of it.
                if p.z > self.iris_depth() + self.extent()[1] {
                    break;
                }
                continue;
            }
            let (albedo, fibrils) = if depth < BORDER_LAYER_MM {
                let scattering = self.tissue.border_scattering;
                (scattering / extinction, self.tissue.border_fibrils)
            } else {
                let scattering = self.tissue.stroma_scattering;
                (scattering / self.tissue.stroma, self.tissue.stroma_fibrils)
            };
            let leaves = (-extinction * step).exp();
            if let Some(arriving) = self.arriving(lamp, p)
                && let Some(way) = self.way_in(p, arriving.towards, lod)
            {
                let cosine = arriving.towards.dot(direction);
                let peak = phase_henyey_greenstein(cosine, BUNDLE_SCALED_COSINE);
                let bundles = peak + (PHASE_ISOTROPIC - peak) * BUNDLE_SIDEWAYS;
                let phase = bundles + fibrils * (phase_rayleigh(cosine) - bundles);
                // All that this step scatters of what reaches it.
                let part = (DVec3::ONE - leaves) * albedo;
                sum += passed * part * phase * (-way).exp() * arriving.across;
            }
            passed *= leaves;
        }
        sum
    }

    /// What the camera gets, by paths.
    pub fn by_paths(&self, seen: &SeenIris) -> DVec3 {
        let size = self.maps.relief.size();
        let lod = iris_level(size, seen.footprint, seen.trace.direction, &seen.start);
        let at = self.meets(seen, lod);
        let surface = self.surface(seen, at, lod);
        let covered = iris_covered(&surface.texel);
        let [mut lit, mut on_iris] = self.sky(&surface);
        for lamp in self.lamps() {
            let Some(arriving) = self.arriving(&lamp, at) else {
                continue;
            };
            let (light, nearer) = arriving.lamp;
            let passes = self.lids_leave(arriving.enters, light, f64::from(lamp.radius) * nearer);
            let once = self.tissue.weights * self.once(seen, &lamp, at, lod) * PI;
            let spread = arriving.across * surface.smooth_normal.dot(arriving.towards).max(0.0);
            let towards_z = iris_within(arriving.towards, surface.lean).z;
            let again =
                spread * iris_reflectance(&self.maps, &surface, towards_z, Scattered::Again);
            let falls = passes * nearer * nearer * (-light.z).max(0.0);
            on_iris += lamp.color.as_dvec3() * falls;
            lit += lamp.color.as_dvec3() * (passes * covered) * (once.max(DVec3::ZERO) + again);
        }
        self.shown(seen, lit, on_iris)
    }
}
