//! How a user's photograph or model stands: distances, heights and units of the command line.

use super::Shown;
use crate::percept::NEAR_M;
use crate::scene::depth_file::DepthUnit;
use crate::scene::photo::PhotoOptions;
use clap::ValueEnum;
use clap::builder::PossibleValue;

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum SceneUnit {
    /// Metre.
    M,
    /// Centimetre.
    Cm,
    /// Millimetre.
    Mm,
    /// Inch.
    In,
}

impl SceneUnit {
    pub(super) fn metres(self) -> f32 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::In => 0.0254,
        }
    }
}

impl ValueEnum for DepthUnit {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Millimetres,
            Self::Centimetres,
            Self::Metres,
            Self::Dioptres,
            Self::Inverse,
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Millimetres => ("mm", "a distance in millimetres; 0 is no measurement"),
            Self::Centimetres => ("cm", "a distance in centimetres; 0 is no measurement"),
            Self::Metres => ("m", "a distance in metres; 0 is no measurement"),
            Self::Dioptres => ("diopter", "thousandths of a dioptre; 0 is infinitely far"),
            Self::Inverse => ("inverse", "white near, black far, linear in dioptres"),
        };
        Some(PossibleValue::new(name).help(help))
    }
}

/// Height of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Span {
    Degrees(f32),
    Metres(f32),
}

/// A length with its unit (m without one), in m, above 0; `inf` is allowed.
pub(super) fn parse_length(text: &str) -> Result<f32, String> {
    let wrong = || format!("{text:?} is not a length above 0 such as 0.4m, 40cm, 400mm or inf");
    let text = text.trim();
    let (number, unit_m) = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("", 1.0)]
        .into_iter()
        .find_map(|(unit, unit_m)| Some((text.strip_suffix(unit)?, unit_m)))
        .ok_or_else(wrong)?;
    let is_infinite = number.trim() == "inf";
    let number: f64 = number.trim().parse().map_err(|_| wrong())?;
    let length_m = (number * unit_m) as f32;
    // What is no number of an f32 was not meant.
    if length_m > 0.0 && length_m.is_infinite() == is_infinite {
        Ok(length_m)
    } else {
        Err(wrong())
    }
}

pub(super) fn parse_at(text: &str) -> Result<f32, String> {
    let at_m = parse_length(text)?;
    if at_m >= NEAR_M {
        return Ok(at_m);
    }
    Err(format!(
        "{text:?} is nearer than 2 cm, the nearest that is drawn"
    ))
}

pub(super) fn parse_span(text: &str) -> Result<Span, String> {
    let wrong =
        || format!("{text:?} is not a height such as 20deg (1 to 120) or a length such as 21cm");
    if let Some(degrees) = text
        .trim()
        .strip_suffix("deg")
        .or_else(|| text.trim().strip_suffix('°'))
    {
        let degrees = degrees.trim().parse::<f32>().map_err(|_| wrong())?;
        return if (1.0..=120.0).contains(&degrees) {
            Ok(Span::Degrees(degrees))
        } else {
            Err(wrong())
        };
    }
    if text.trim().parse::<f32>().is_ok() {
        return Err(format!(
            "{text:?} is not a height without its unit: an angle such as 20deg (1 to 120) or a length such as 21cm"
        ));
    }
    let with_unit = text.trim().ends_with('m');
    match parse_length(text) {
        Ok(length_m) if with_unit && length_m.is_finite() => Ok(Span::Metres(length_m)),
        _ => Err(wrong()),
    }
}

/// How a photograph stands, from what the command line says of it.
pub(super) fn photo_options(shown: &Shown) -> Result<PhotoOptions, String> {
    let usual = PhotoOptions::default();
    if shown.at.is_some() && shown.depth.is_some() {
        return Err(
            "--at is the distance of a photograph without --depth; leave one of them out".into(),
        );
    }
    let scaled = shown.depth_near.is_some() || shown.depth_far.is_some();
    if scaled && !matches!(shown.depth_unit, None | Some(DepthUnit::Inverse)) {
        return Err("--depth-near and --depth-far go with --depth-unit inverse only".into());
    }
    if let Some(near_m) = shown.depth_near.filter(|near_m| *near_m < NEAR_M) {
        return Err(format!(
            "--depth-near is {near_m} m, nearer than 2 cm, the nearest that is drawn"
        ));
    }
    let near_m = shown.depth_near.unwrap_or(usual.near_m);
    let far_m = shown.depth_far.unwrap_or(usual.far_m);
    if far_m <= near_m {
        return Err(format!(
            "--depth-far is {far_m} m, but must be farther than --depth-near, which is {near_m} m"
        ));
    }
    let flat_depth_m = shown.at.unwrap_or(usual.flat_depth_m);
    let vertical_fov_deg = match shown.span {
        None => usual.vertical_fov_deg,
        Some(Span::Degrees(degrees)) => degrees,
        Some(Span::Metres(_)) if flat_depth_m.is_infinite() => {
            return Err(
                "--span of a photograph that is infinitely far must be an angle, such as 20deg"
                    .into(),
            );
        }
        Some(Span::Metres(height_m)) => 2.0 * (0.5 * height_m / flat_depth_m).atan().to_degrees(),
    };
    if !(1.0..=120.0).contains(&vertical_fov_deg) {
        return Err(format!(
            "--span makes the photograph {vertical_fov_deg:.1}° high at {flat_depth_m} m, but it must be 1° to 120°"
        ));
    }
    Ok(PhotoOptions {
        // Who says where white and black stand says that they are shares between them.
        depth_unit: shown.depth_unit.or(scaled.then_some(DepthUnit::Inverse)),
        near_m,
        far_m,
        flat_depth_m,
        vertical_fov_deg,
        fps: shown.scene_fps,
    })
}
