//! Values of options as a user writes them.

use crate::appearance::eye_camera::EyeOrbit;
use bevy::math::UVec2;

pub(super) fn parse_size(text: &str) -> Result<UVec2, String> {
    let wrong = || format!("{text:?} is not a size such as 1280x640, each side 16 to 8192 pixels");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |side: &str| {
        side.trim()
            .parse::<u32>()
            .ok()
            .filter(|side| (16..=8192).contains(side))
            .ok_or_else(wrong)
    };
    Ok(UVec2::new(side(width)?, side(height)?))
}

fn parse_whole(text: &str, most: u64) -> Result<u64, String> {
    let number = text.trim().parse::<u64>().ok();
    number
        .filter(|number| *number <= most)
        .ok_or_else(|| format!("{text:?} is not a whole number from 0 to {most}"))
}

pub(super) fn parse_seed(text: &str) -> Result<u64, String> {
    parse_whole(text, u64::MAX)
}

pub(super) fn parse_threshold(text: &str) -> Result<u8, String> {
    parse_whole(text, u8::MAX.into()).map(|threshold| threshold as u8)
}

pub(super) fn parse_range(text: &str, what: &str, low: f64, high: f64) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|value| *value > low && *value <= high)
        .ok_or_else(|| format!("{text:?} is not {what} above {low} and up to {high}"))
}

pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_range(text, "a number of seconds", 0.0, 3600.0)
}

pub(super) fn parse_fps(text: &str) -> Result<f64, String> {
    parse_range(text, "a frame rate", 0.0, 1000.0)
}

pub(super) fn parse_scene_fps(text: &str) -> Result<f32, String> {
    text.parse::<f32>()
        .ok()
        .filter(|value| (0.1..=240.0).contains(value))
        .ok_or_else(|| format!("{text:?} is not a rate of 0.1 to 240 pictures a second"))
}

pub(super) fn parse_distance(text: &str) -> Result<f32, String> {
    let text = text.trim();
    let (number, unit_mm) = [("mm", 1.0), ("cm", 10.0), ("m", 1000.0)]
        .iter()
        .find_map(|(unit, mm)| Some((text.strip_suffix(unit)?, *mm)))
        .unwrap_or((text, 1.0));
    let value = number.trim().parse::<f32>().ok();
    value
        .map(|value| value * unit_mm)
        .filter(|value| EyeOrbit::DISTANCES_MM.contains(value))
        .ok_or_else(|| {
            let (from, to) = (EyeOrbit::DISTANCES_MM.start(), EyeOrbit::DISTANCES_MM.end());
            format!("{text:?} is not a distance of {from} to {to} mm, as in 60, 60mm, 6cm or 0.5m")
        })
}

pub(super) fn parse_orbit(text: &str) -> Result<[f32; 2], String> {
    let wrong = || format!("{text:?} is not AZ,EL in degrees, AZ -85 to 85 and EL -80 to 80");
    let (azimuth, elevation) = text.split_once(',').ok_or_else(wrong)?;
    let angle = |text: &str, most: f32| {
        text.trim()
            .parse::<f32>()
            .ok()
            .filter(|angle| angle.abs() <= most)
            .ok_or_else(wrong)
    };
    Ok([angle(azimuth, 85.0)?, angle(elevation, 80.0)?])
}
