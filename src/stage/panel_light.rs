//! Which light the shown eye is in.

use crate::appearance::studio::STUDIO_LIGHTS;
use crate::appearance::{EyeLight, Studio, StudioLight};

/// What the shown eye is lit by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelLight {
    /// The scene that it looks at.
    Scene,
    /// A photographer's light.
    Studio(StudioLight),
}

impl Default for PanelLight {
    /// The window: a room's reflection hides most of what lies behind a pupil.
    fn default() -> Self {
        Self::Studio(StudioLight::default())
    }
}

impl PanelLight {
    /// All of them.
    pub const ALL: [Self; STUDIO_LIGHTS.len() + 1] = {
        let mut all = [Self::Scene; STUDIO_LIGHTS.len() + 1];
        let mut i = 0;
        while i < STUDIO_LIGHTS.len() {
            all[i + 1] = Self::Studio(STUDIO_LIGHTS[i]);
            i += 1;
        }
        all
    };

    /// The word by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Studio(light) => light.name(),
        }
    }

    /// What it is, for lists.
    pub fn description(self) -> &'static str {
        match self {
            Self::Scene => "the scene that the eye looks at, which it mirrors",
            Self::Studio(light) => light.description(),
        }
    }

    /// The one of this name.
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|light| light.name() == name)
    }

    pub(super) fn component(self) -> EyeLight {
        match self {
            Self::Scene => EyeLight::Surroundings,
            Self::Studio(light) => EyeLight::Studio(Studio {
                light,
                ..Studio::default()
            }),
        }
    }
}

impl From<&EyeLight> for PanelLight {
    fn from(light: &EyeLight) -> Self {
        match light {
            EyeLight::Studio(studio) => Self::Studio(studio.light),
            EyeLight::Surroundings | EyeLight::World => Self::Scene,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_light_has_a_name_of_its_own() {
        for light in PanelLight::ALL {
            assert_eq!(PanelLight::of(light.name()), Some(light));
            assert_eq!(PanelLight::from(&light.component()), light);
        }
        assert_eq!(PanelLight::of("sun"), None);
    }
}
