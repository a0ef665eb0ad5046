//! The light that falls on an eye, as its shaders read it: kept in step with
//! `shaders/lib/surroundings.wgsl`.

use super::shading::lid_shade::LIDS_FACE;
use super::shading::surroundings::ambient_light;
use bevy::math::{DVec3, Vec3, Vec4};
use bevy::reflect::Reflect;
use bevy::render::render_resource::ShaderType;

/// Most lamps that light an eye.
pub const MOST_LAMPS: usize = 8;

/// A lamp (struct `Lamp` of `shaders/lib/surroundings.wgsl`).
#[derive(Clone, Copy, Debug, PartialEq, Reflect, ShaderType)]
pub struct Lamp {
    /// Unit direction towards it, head frame.
    pub direction: Vec3,
    /// Angular radius, rad.
    pub radius: f32,
    /// Irradiance / π across its beam, linear sRGB.
    pub color: Vec3,
    /// What it is mirrored as: a disc (0), a ring whose hole has this share of its radius (to 1), or nothing,
    /// as it stands in the map of the surroundings (−1).
    pub hole: f32,
    /// One over its distance from the globe's centre, 1/mm; 0 far away.
    pub vergence: f32,
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            direction: Vec3::NEG_Z,
            radius: 0.05,
            color: Vec3::ZERO,
            hole: -1.0,
            vergence: 0.0,
        }
    }
}

/// The light that falls on an eye (struct `Illumination` of `shaders/lib/surroundings.wgsl`).
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct Illumination {
    /// The lamps.
    pub lamps: [Lamp; MOST_LAMPS],
    /// Irradiance / π from the surroundings without the lamps, by the normal: factors of
    /// [`super::shading::surroundings::ambient_basis`].
    pub ambient: [Vec4; 9],
    /// Irradiance / π of the lids' edges ([`super::shading::lid_shade::LIDS_FACE`]), lamps and all.
    pub lids_lit: Vec3,
    /// Factor on all of it before the output transform.
    pub exposure: f32,
    /// 1 where all of this is in cd/m² and the camera's exposure is still to come, 0 where the picture's
    /// own is all.
    pub is_luminance: f32,
}

impl Illumination {
    /// With what its surroundings and lamps give the lids' edges.
    pub fn lighting_lids(mut self) -> Self {
        let take = |lamp: &Lamp| lamp.direction.as_dvec3().dot(LIDS_FACE).max(0.0);
        let lamps = self.lamps.iter();
        let lit: DVec3 = lamps.map(|lamp| lamp.color.as_dvec3() * take(lamp)).sum();
        self.lids_lit = (lit + ambient_light(&self.ambient, LIDS_FACE)).as_vec3();
        self
    }

    /// What the pipeline is told of it.
    pub(super) fn key(&self) -> LightKey {
        let lit = |lamp: &Lamp| lamp.color.max_element() > 0.0;
        let count = self.lamps.iter().rposition(lit).map_or(0, |last| last + 1);
        LightKey {
            // A few numbers, so that a lamp more is not always another pipeline.
            lamps: [0, 1, 2, 4]
                .into_iter()
                .find(|most| count <= *most)
                .unwrap_or(MOST_LAMPS) as u32,
            has_bare: self.lamps.iter().any(|lamp| lit(lamp) && lamp.hole >= 0.0),
            has_near: self
                .lamps
                .iter()
                .any(|lamp| lit(lamp) && lamp.vergence > 0.0),
        }
    }
}

/// How many lamps a pipeline looks at, whether any of them stands in no map, and whether any is near.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightKey {
    pub(super) lamps: u32,
    pub(super) has_bare: bool,
    pub(super) has_near: bool,
}
