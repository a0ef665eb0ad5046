//! What an artist may change of how an eye looks, beside its anatomy.

use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::Component;
use bevy::reflect::Reflect;

/// An artist's changes to the picture of an eye: the parameters that programs for rendering eyes offer, each
/// neutral by default, where anatomy and light alone decide. What has a physical number is changed there
/// instead: how deep the iris lies ([`super::Iris::depth_mm`]), how wide it is
/// ([`super::Cornea::limbus_radius_mm`]), the indices ([`super::Cornea::aqueous_index`]) and the pupil
/// ([`super::PupilControl`]).
///
/// None of it changes what the eye sees. An eye without changes is drawn by a pipeline without them.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Look {
    /// Brightness of the iris against its own, 0 to 4.
    pub iris_brightness: f64,
    /// Size of iris and pupil as a pattern about their centre, against their own, 0.8 to 1.25.
    pub iris_size: f64,
    /// Relief of the iris against its own, 0 to 3.
    pub iris_relief: f64,
    /// How much of the view's refraction at the cornea there is, 0 to 1.
    pub refraction: f64,
    /// How strongly the cornea concentrates light on the iris: 0 evenly, 1 as computed, to 4.
    pub caustic_scale: f64,
    /// Power of that concentration, 0.25 to 4: from a wide glow to a narrow crescent.
    pub caustic_power: f64,
    /// Roughness of the cornea's reflection, 0 to 1.
    pub cornea_roughness: f64,
    /// Strength of the cornea's reflection against its own, 0 to 4.
    pub cornea_specularity: f64,
    /// How dark the limbal ring is against its own, 0 to 4.
    pub limbus_dark: f64,
    /// Power of the ring's profile, 0.25 to 4: below 1 it spreads into the white, above into the iris.
    pub limbus_power: f64,
    /// Width over which iris goes over into white, mm, 0.1 to 1.1.
    pub limbus_color_mm: f64,
    /// Width over which the cornea's shape goes over into the white's, mm, 0.05 to 1.1.
    pub limbus_shading_mm: f64,
    /// Brightness of the white against its own, 0 to 4.
    pub white_brightness: f64,
    /// Roughness of the wet white, 0.02 to 1.
    pub white_roughness: f64,
    /// Strength of the white's reflections against their own, 0 to 4.
    pub white_specularity: f64,
    /// Relief of the wet white against its own, 0 (flat) to 4.
    pub white_relief: f64,
    /// Size of that relief against its own, 0.25 to 4.
    pub white_relief_size: f64,
    /// How far from the cornea the white goes over into its pink surround, against its own, 0.5 to 1.5.
    pub flush_radius: f64,
    /// How sharply it does, against its own, 0.25 to 4.
    pub flush_hardness: f64,
    /// Share of the iris, from the examiner's left, that lies where parallax mapping puts it (the eye-shading notes' way:
    /// straight on to a plane whose depth errs least, `measure parallax-error`), 0 to 1: 0.5 shows both beside each other.
    pub parallax: f64,
    /// Strength of a reflection that follows the camera, whatever is around, 0 to 1.
    pub matcap: f64,
}

impl Look {
    /// As anatomy and physics make it.
    pub const DEFAULT: Self = Self {
        iris_brightness: 1.0,
        iris_size: 1.0,
        iris_relief: 1.0,
        refraction: 1.0,
        caustic_scale: 1.0,
        caustic_power: 1.0,
        cornea_roughness: 0.012,
        cornea_specularity: 1.0,
        limbus_dark: 1.0,
        limbus_power: 1.0,
        limbus_color_mm: 1.35,
        limbus_shading_mm: 1.35,
        white_brightness: 1.0,
        white_roughness: 0.2,
        white_specularity: 1.0,
        white_relief: 1.0,
        white_relief_size: 1.0,
        flush_radius: 1.0,
        flush_hardness: 1.0,
        parallax: 0.0,
        matcap: 0.0,
    };
}

impl Default for Look {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Look {
    /// Is nothing changed?
    pub fn is_neutral(&self) -> bool {
        *self == Self::default()
    }
}
