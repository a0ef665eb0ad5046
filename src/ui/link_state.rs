//! The state of a session as a link's fragment: versioned, readable, and complete for what is built in.
//!
//! Enters and leaves: [`LinkState`], and text such as
//! `v=1&patient=myope-3d&sphere_d=-4.5&scene=room&seed=7&gaze=13,-14.5,0.6`. A patient is the built-in
//! one that it is nearest to, and the fields in which it differs, by the names and in the notation of
//! a patient file. What is as usual is left out. A user's own scene is not in the link.

mod patient;

pub use patient::changes;

use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::{PUPIL_RANGE, PUPIL_RANGE_MM};
use crate::appearance::EyeOrbit;
use crate::patients::{PRESETS, PatientFile, load_patient};
use crate::scene::catalog::BuiltIn;
use crate::stage::PanelLight;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Version of the notation that is written.
pub const VERSION: u32 = 1;
/// Longest link that is read, bytes: beyond what any browser hands on.
const LONGEST: usize = 16 << 10;

/// What stays readable in a fragment (RFC 3986, section 3.5, less what separates keys).
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'_')
    .remove(b'.')
    .remove(b'~')
    .remove(b',')
    .remove(b'(')
    .remove(b')')
    .remove(b':');

/// Who directs gaze, and where to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LinkGaze {
    /// The eye looks about by itself.
    #[default]
    Auto,
    /// It follows the pointer.
    Follow,
    /// It stays on one point.
    Fixed {
        /// To the right, degrees, −180 to 180.
        azimuth_deg: f64,
        /// Up, degrees, −180 to 180.
        elevation_deg: f64,
        /// Distance, m, above 0; may be infinite.
        distance_m: f64,
    },
}

/// Everything that a link says.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkState {
    /// The patient, with every change.
    pub patient: PatientFile,
    /// The built-in scene.
    pub scene: BuiltIn,
    /// Seed of every random choice.
    pub seed: u64,
    /// Which panels are shown (eye, view).
    pub shown: [bool; 2],
    /// Who directs gaze.
    pub gaze: LinkGaze,
    /// Pupil held by hand, mm, within [`PUPIL_RANGE_MM`].
    pub held_pupil_mm: Option<f64>,
    /// Where the camera before the eye stands.
    pub orbit: EyeOrbit,
    /// What the eye is lit by.
    pub light: PanelLight,
    /// Seconds of simulation in a second of real time, 0.05 to 4.
    pub speed: f64,
    /// Is it marked in the view where the eye looks?
    pub marker: bool,
    /// The time at which it stands still, s, 0 to 3600; `None` while it runs.
    pub paused_at_s: Option<f64>,
}

impl Default for LinkState {
    fn default() -> Self {
        Self {
            patient: load_patient(USUAL_PATIENT).unwrap_or_default(),
            scene: BuiltIn::Room,
            seed: 1,
            shown: [true; 2],
            gaze: LinkGaze::Auto,
            held_pupil_mm: None,
            orbit: EyeOrbit::default(),
            light: PanelLight::default(),
            speed: 1.0,
            marker: false,
            paused_at_s: None,
        }
    }
}

/// The built-in patient of a link that names none, as of a command line that names none.
const USUAL_PATIENT: &str = "healthy-brown";

/// A number with at most so many decimals, and none that say nothing.
fn short(value: f64, decimals: usize) -> String {
    if value.is_infinite() {
        return "inf".into();
    }
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if text == "-0" { "0" } else { text }.into()
}

const PANELS: [(&str, [bool; 2]); 4] = [
    ("both", [true, true]),
    ("eye", [true, false]),
    ("view", [false, true]),
    ("none", [false, false]),
];

impl LinkState {
    /// The fragment, without `#`.
    pub fn to_fragment(&self) -> String {
        let usual = Self::default();
        let mut out = format!("v={VERSION}");
        let mut put = |key: &str, value: &str| {
            let value = utf8_percent_encode(value, ENCODED);
            // Writing into a string does not fail.
            let _ = write!(out, "&{key}={value}");
        };
        let (preset, changes) = patient::changes(&self.patient);
        put("patient", preset);
        for (field, value) in &changes {
            put(field, value);
        }
        put("scene", self.scene.name());
        put("seed", &self.seed.to_string());
        if self.shown != usual.shown {
            let named = PANELS.iter().find(|(_, shown)| *shown == self.shown);
            put("panels", named.map_or("both", |(name, _)| name));
        }
        match self.gaze {
            LinkGaze::Auto => {}
            LinkGaze::Follow => put("gaze", "follow"),
            LinkGaze::Fixed {
                azimuth_deg,
                elevation_deg,
                distance_m,
            } => {
                let angles = [azimuth_deg, elevation_deg].map(|angle| short(angle, 2));
                let place = [&*angles[0], &*angles[1], &*short(distance_m.max(1e-4), 4)];
                put("gaze", &place.join(","));
            }
        }
        if let Some(pupil_mm) = self.held_pupil_mm {
            put("pupil_mm", &short(pupil_mm, 2));
        }
        let [orbit, usual_orbit] = [self.orbit, usual.orbit].map(|orbit| {
            let place = [orbit.azimuth_deg, orbit.elevation_deg, orbit.distance_mm];
            place.map(|number| short(number.into(), 1)).join(",")
        });
        if orbit != usual_orbit {
            put("orbit", &orbit);
        }
        if self.light != usual.light {
            put("light", self.light.name());
        }
        if self.speed != usual.speed {
            put("speed", &short(self.speed.max(0.05), 2));
        }
        if self.marker {
            put("marker", "on");
        }
        if let Some(time_s) = self.paused_at_s {
            put("paused_at_s", &short(time_s.min(3600.0), 3));
        }
        out
    }

    /// Reads a fragment, or a whole link with one. What cannot be obeyed is as usual, and there is a
    /// sentence for each such key.
    pub fn parse(link: &str) -> (Self, Vec<String>) {
        let mut state = Self::default();
        let mut refused = Vec::new();
        if link.len() > LONGEST {
            refused.push(format!(
                "The link has {} bytes, but may have at most {LONGEST}.",
                link.len()
            ));
            return (state, refused);
        }
        let fragment = match link.split_once('#') {
            Some((_, fragment)) => fragment,
            None if link.contains("://") => "",
            None => link,
        };
        let pairs: Vec<(String, String)> = fragment
            .split('&')
            .filter(|pair| !pair.is_empty())
            .map(|pair| {
                let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
                let decoded = |text| percent_decode_str(text).decode_utf8_lossy().into_owned();
                (decoded(key), decoded(value))
            })
            .collect();
        let mut fields = Vec::new();
        let mut preset = USUAL_PATIENT;
        let mut given = BTreeSet::new();
        for (key, value) in &pairs {
            if !given.insert(key) {
                refused.push(format!("The link has {key} twice; the last counts."));
            }
            let outcome = match key.as_str() {
                "patient" => known_preset(value).map(|name| preset = name),
                "v" => check_version(value),
                _ => match state.set(key, value) {
                    Some(outcome) => outcome,
                    None => {
                        fields.push((key.as_str(), value.as_str()));
                        Ok(())
                    }
                },
            };
            refused.extend(outcome.err());
        }
        state.patient = patient::with_changes(preset, &fields, &mut refused);
        (state, refused)
    }

    /// Obeys one key that is not the patient's; `None` where there is no such key.
    fn set(&mut self, key: &str, value: &str) -> Option<Result<(), String>> {
        let refuse = |allowed: &str| {
            Err(format!(
                "The link's {key} is {value:?}, but must be {allowed}."
            ))
        };
        let number = |low: f64, high: f64| {
            let number = value.parse::<f64>().ok();
            number.filter(|number| (low..=high).contains(number))
        };
        let outcome = match key {
            "scene" => match BuiltIn::ALL.into_iter().find(|s| s.name() == value) {
                Some(scene) => {
                    self.scene = scene;
                    Ok(())
                }
                None => refuse(&format!(
                    "one of {}",
                    BuiltIn::ALL.map(BuiltIn::name).join(", ")
                )),
            },
            "seed" => match value.parse() {
                Ok(seed) => {
                    self.seed = seed;
                    Ok(())
                }
                Err(_) => refuse("a whole number from 0 to 18446744073709551615"),
            },
            "panels" => match PANELS.iter().find(|(name, _)| *name == value) {
                Some((_, shown)) => {
                    self.shown = *shown;
                    Ok(())
                }
                None => refuse("both, eye, view or none"),
            },
            "gaze" => match parse_gaze(value) {
                Some(gaze) => {
                    self.gaze = gaze;
                    Ok(())
                }
                None => refuse(
                    "auto, follow, or degrees to the right, degrees up (at most 55 from straight ahead) and metres (0.02 or more), as in 13,-14.5,0.6",
                ),
            },
            "orbit" => match parse_three(value) {
                Some([azimuth, elevation, distance])
                    if azimuth.abs() <= 85.0
                        && elevation.abs() <= 80.0
                        && EyeOrbit::DISTANCES_MM.contains(&(distance as f32)) =>
                {
                    self.orbit = EyeOrbit {
                        azimuth_deg: azimuth as f32,
                        elevation_deg: elevation as f32,
                        distance_mm: distance as f32,
                    };
                    Ok(())
                }
                _ => refuse(
                    "degrees (-85 to 85), degrees (-80 to 80) and mm (35 to 1000), as in 30,0,93",
                ),
            },
            "light" => match PanelLight::of(value) {
                Some(light) => {
                    self.light = light;
                    Ok(())
                }
                None => refuse(&PanelLight::ALL.map(PanelLight::name).join(", ")),
            },
            "pupil_mm" => match number(PUPIL_RANGE_MM.0, PUPIL_RANGE_MM.1) {
                Some(pupil_mm) => {
                    self.held_pupil_mm = Some(pupil_mm);
                    Ok(())
                }
                None => refuse(PUPIL_RANGE),
            },
            "speed" => match number(0.05, 4.0) {
                Some(speed) => {
                    self.speed = speed;
                    Ok(())
                }
                None => refuse("0.05 to 4"),
            },
            "marker" => match value {
                "on" | "off" => {
                    self.marker = value == "on";
                    Ok(())
                }
                _ => refuse("on or off"),
            },
            "paused_at_s" => match number(0.0, 3600.0) {
                Some(time_s) => {
                    self.paused_at_s = Some(time_s);
                    Ok(())
                }
                None => refuse("0 to 3600"),
            },
            _ => return None,
        };
        Some(outcome)
    }
}

fn known_preset(value: &str) -> Result<&'static str, String> {
    crate::patients::preset(value).map_or_else(
        || {
            let known: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
            Err(format!(
                "The link's patient is {value:?}, but must be one of {}.",
                known.join(", ")
            ))
        },
        |preset| Ok(preset.name),
    )
}

fn check_version(value: &str) -> Result<(), String> {
    match value.parse::<u32>() {
        Ok(version) if (1..=VERSION).contains(&version) => Ok(()),
        Ok(version) if version > VERSION => Err(format!(
            "The link is of version {version}, newer than this program's {VERSION}: what it knows of it is shown."
        )),
        _ => Err(format!(
            "The link's v is {value:?}, but must be a version from 1 to {VERSION}."
        )),
    }
}

fn parse_three(value: &str) -> Option<[f64; 3]> {
    let mut parts = value.split(',').map(|part| part.trim().parse::<f64>().ok());
    let three = [parts.next()??, parts.next()??, parts.next()??];
    parts.next().is_none().then_some(three)
}

/// The nearest that is drawn, m.
pub const GAZE_NEAREST_M: f64 = crate::percept::NEAR_M as f64;

fn parse_gaze(value: &str) -> Option<LinkGaze> {
    match value {
        "auto" => return Some(LinkGaze::Auto),
        "follow" => return Some(LinkGaze::Follow),
        _ => {}
    }
    let [azimuth_deg, elevation_deg, distance_m] = parse_three(value)?;
    let turn = -90.0..=90.0;
    if !turn.contains(&azimuth_deg) || !turn.contains(&elevation_deg) {
        return None;
    }
    let asked = GazeAngles::new(azimuth_deg.to_radians(), elevation_deg.to_radians());
    // Links hold hundredths of a degree.
    let within = asked.angle_to(asked.within_range()) < 0.02f64.to_radians();
    (within && distance_m >= GAZE_NEAREST_M).then_some(LinkGaze::Fixed {
        azimuth_deg,
        elevation_deg,
        distance_m,
    })
}

#[cfg(test)]
mod tests;
