//! What glTF has no words for, said in `extras` under the key `ocularium`.
//!
//! A scene's: `{"ambient": {"color": [r, g, b], "brightness_cd_m2": n}, "background_cd_m2": [r, g, b],
//! "mean_luminance_cd_m2": n}` (see [`SceneLight::Ambient`] and [`SceneModel`]), each of them optional. A
//! light's: `{"shadows": true}`, whether it casts shadows.

use super::super::model::{SceneError, SceneLight, SceneModel};
use super::{BRIGHTEST_CD_M2, Source};
use crate::input_file::one_clause;
use gltf::json::Extras;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Light that comes from no lamp of the file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Surroundings {
    ambient: Option<Ambient>,
    background_cd_m2: Option<[f32; 3]>,
    mean_luminance_cd_m2: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ambient {
    color: [f32; 3],
    brightness_cd_m2: f32,
}

/// What is said of a light.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OfLight {
    pub(super) shadows: Option<bool>,
}

/// What the extras of a scene or of a light (`what`) hold for this program.
pub(super) fn read<T: DeserializeOwned + Default>(
    extras: &Extras,
    what: &str,
    source: &Source,
) -> Result<T, SceneError> {
    let own = extras
        .as_ref()
        .and_then(|raw| serde_json::from_str::<Value>(raw.get()).ok())
        .and_then(|mut all| all.get_mut("ocularium").map(Value::take));
    own.map_or_else(
        || Ok(T::default()),
        |own| {
            serde_json::from_value(own).map_err(|error| {
                let reason = one_clause(&error);
                source.content(format!("its {what}'s extras \"ocularium\": {reason}"))
            })
        },
    )
}

impl Surroundings {
    /// Adds them to a scene.
    pub(super) fn apply(self, scene: &mut SceneModel, source: &Source) -> Result<(), SceneError> {
        let check = |name: &str, value: f64| {
            if (0.0..=BRIGHTEST_CD_M2).contains(&value) {
                return Ok(());
            }
            Err(source.content(format!(
                "its scene's extras \"ocularium\": {name} is {value:.1e}, but must be 0 to {BRIGHTEST_CD_M2:.0e}"
            )))
        };
        if let Some(Ambient {
            color,
            brightness_cd_m2: brightness,
        }) = self.ambient
        {
            check("brightness_cd_m2", brightness.into())?;
            for channel in color {
                check("color", channel.into())?;
            }
            scene.lights.push(SceneLight::Ambient { color, brightness });
        }
        if let Some(background) = self.background_cd_m2 {
            for channel in background {
                check("background_cd_m2", channel.into())?;
            }
            scene.background = background;
        }
        if let Some(mean) = self.mean_luminance_cd_m2 {
            check("mean_luminance_cd_m2", mean)?;
            scene.mean_luminance_cd_m2 = mean;
        }
        Ok(())
    }
}
