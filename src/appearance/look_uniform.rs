//! An artist's changes as the globe's shader reads them.

use crate::anatomy::Look;
use bevy::render::render_resource::ShaderType;

/// Struct `Look` of `shaders/eye/globe.wgsl`: see [`Look`].
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct LookUniform {
    /// Brightness of the iris, against its own.
    pub iris_brightness: f32,
    /// Size of iris and pupil as a pattern, against their own.
    pub iris_size: f32,
    /// How much of the view's refraction there is.
    pub refraction: f32,
    /// How much the cornea concentrates light on the iris, against what is computed.
    pub caustic_scale: f32,
    /// Power of that concentration.
    pub caustic_power: f32,
    /// Roughness of the cornea's reflection.
    pub cornea_roughness: f32,
    /// Strength of the cornea's reflection, against its own.
    pub cornea_specularity: f32,
    /// How dark the limbal ring is, against its own.
    pub limbus_dark: f32,
    /// Power of that ring's profile.
    pub limbus_power: f32,
    /// Width over which iris goes over into white.
    pub limbus_color_mm: f32,
    /// Width over which the cornea's shape goes over into the white's.
    pub limbus_shading_mm: f32,
    /// Brightness of the white, against its own.
    pub white_brightness: f32,
    /// Roughness of the wet white.
    pub white_roughness: f32,
    /// Strength of its reflections, against their own.
    pub white_specularity: f32,
    /// Relief of the wet white, against its own.
    pub white_relief: f32,
    /// Size of that relief, against its own.
    pub white_relief_size: f32,
    /// Share of the iris that lies where parallax mapping puts it.
    pub parallax: f32,
    /// Strength of a reflection that follows the camera.
    pub matcap: f32,
}

impl From<&Look> for LookUniform {
    fn from(look: &Look) -> Self {
        Self {
            iris_brightness: look.iris_brightness as f32,
            iris_size: look.iris_size as f32,
            refraction: look.refraction as f32,
            caustic_scale: look.caustic_scale as f32,
            caustic_power: look.caustic_power as f32,
            cornea_roughness: look.cornea_roughness as f32,
            cornea_specularity: look.cornea_specularity as f32,
            limbus_dark: look.limbus_dark as f32,
            limbus_power: look.limbus_power as f32,
            limbus_color_mm: look.limbus_color_mm as f32,
            limbus_shading_mm: look.limbus_shading_mm as f32,
            white_brightness: look.white_brightness as f32,
            white_roughness: look.white_roughness as f32,
            white_specularity: look.white_specularity as f32,
            white_relief: look.white_relief as f32,
            white_relief_size: look.white_relief_size as f32,
            parallax: look.parallax as f32,
            matcap: look.matcap as f32,
        }
    }
}
