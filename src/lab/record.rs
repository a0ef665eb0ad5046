//! Recording an app of one's own without a window: its pictures, frame by frame, as files.
//!
//! Enters: an app built with [`plugins`] and [`RecordPlugin`], and a [`Recording`]. Leaves: `frame_NNNNN.png`
//! and `report.json` in a folder. Cameras that would draw into the primary window draw into a picture of that size.

use super::frame_folder::{FrameFolder, REPORT};
use super::headless::Headless;
use super::render::RenderError;
use crate::frame::panel::target_image;
use crate::frame::picture::encode_png;
use crate::output_file::{WriteError, write_whole};
use bevy::app::{PluginGroupBuilder, TerminalCtrlCHandlerPlugin, ctrlc};
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::window::WindowRef;
use serde::Serialize;
use std::num::NonZero;
use std::path::PathBuf;

/// The options of a recording.
const KNOWN: [&str; 4] = ["--frames", "--out", "--fps", "--size"];
/// The same, for people.
pub const USAGE: &str = "--frames N --out DIR (pictures in a folder in place of a window), --fps F (2) and --size WxH (1280x640)";

/// What is to be recorded.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Recording {
    /// Number of frames, 1 and more.
    pub frames: u64,
    /// Frames a second of simulated time.
    pub fps: f64,
    /// Width and height of the picture, pixels.
    pub size: UVec2,
    /// The folder for the frames.
    pub out: PathBuf,
}

impl Recording {
    /// What a command line asks for by `--frames N --out DIR`, with `--fps F` (2 without it) and
    /// `--size WxH` (1280x640); `None` where it asks for nothing.
    ///
    /// # Errors
    /// One sentence about what is wrong.
    pub fn from_arguments(
        arguments: impl IntoIterator<Item = String>,
    ) -> Result<Option<Self>, String> {
        let (mut frames, mut out) = (None, None);
        let mut given = Vec::new();
        let (mut fps, mut size) = (2.0, UVec2::new(1280, 640));
        // `--frames=3` is `--frames 3`.
        let mut arguments = arguments.into_iter().flat_map(|argument| {
            match argument
                .split_once('=')
                .filter(|_| argument.starts_with("--"))
            {
                Some((name, value)) => vec![name.to_owned(), value.to_owned()],
                None => vec![argument],
            }
        });
        while let Some(name) = arguments.next() {
            if !KNOWN.contains(&&*name) {
                return Err(format!("{name} is not known; known are {USAGE}"));
            }
            if given.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            given.push(name.clone());
            let value = arguments
                .next()
                .ok_or_else(|| format!("{name} needs a value"))?;
            let wrong = |range: &str| format!("{name} {value:?} is not {range}");
            match name.as_str() {
                "--frames" => {
                    let count = value.parse::<u64>().ok();
                    let count = count.filter(|count| *count > 0);
                    frames = Some(count.ok_or_else(|| wrong("a number of frames, 1 and more"))?);
                }
                "--out" => out = Some(PathBuf::from(value)),
                "--fps" => {
                    let rate = value.parse::<f64>().ok();
                    fps = rate
                        .filter(|rate| (1e-3..=1e3).contains(rate))
                        .ok_or_else(|| wrong("a rate of 0.001 to 1000 frames a second"))?;
                }
                "--size" => {
                    let sides = value.split_once('x').and_then(|(width, height)| {
                        Some(UVec2::new(width.parse().ok()?, height.parse().ok()?))
                    });
                    let allowed =
                        |size: &UVec2| size.min_element() >= 16 && size.max_element() <= 8192;
                    size = sides
                        .filter(allowed)
                        .ok_or_else(|| wrong("a size such as 640x320, each side 16 to 8192"))?;
                }
                _ => {}
            }
        }
        match (frames, out) {
            (None, None) => Ok(None),
            (Some(frames), Some(out)) => Ok(Some(Self {
                frames,
                fps,
                size,
                out,
            })),
            _ => Err("--frames and --out go together".into()),
        }
    }
}

/// Bevy's default plugins: with a window, or, for a recording, without.
pub fn plugins(recording: Option<&Recording>) -> PluginGroupBuilder {
    match recording {
        Some(_) => super::headless::plugins(),
        None => DefaultPlugins.build(),
    }
}

/// Records the app instead of running it, where there is something to record.
pub struct RecordPlugin(pub Option<Recording>);

/// The picture in the window's place.
#[derive(Resource)]
struct InWindowsPlace(Handle<Image>);

impl Plugin for RecordPlugin {
    fn build(&self, app: &mut App) {
        let Some(recording) = self.0.clone() else {
            return;
        };
        let picture = app
            .world_mut()
            .resource_mut::<Assets<Image>>()
            .add(target_image(recording.size));
        // Bevy's plugin would leave it to whoever started this, who may have it ignored, as a shell does for what it
        // runs in the background.
        if let Err(error) = ctrlc::set_handler(TerminalCtrlCHandlerPlugin::gracefully_exit) {
            warn!("Ctrl-C ends this at once: {error}");
        }
        app.insert_resource(InWindowsPlace(picture.clone()))
            .add_systems(PreUpdate, take_windows_place)
            .add_systems(Update, TerminalCtrlCHandlerPlugin::exit_on_flag)
            .set_runner(move |app| match record(app, &recording, &picture) {
                Ok(true) => AppExit::Success,
                Ok(false) => AppExit::from_code(INTERRUPTED),
                Err(error) => {
                    eprintln!("{error}");
                    AppExit::Error(NonZero::<u8>::MIN)
                }
            });
    }
}

/// Cameras that would draw into the primary window draw into the picture.
fn take_windows_place(picture: Res<InWindowsPlace>, mut cameras: Query<&mut RenderTarget>) {
    for mut target in &mut cameras {
        if matches!(*target, RenderTarget::Window(WindowRef::Primary)) {
            *target = RenderTarget::Image(picture.0.clone().into());
        }
    }
}

/// `report.json` of a recording.
#[derive(Serialize)]
struct RecordingReport {
    /// The program's version.
    version: &'static str,
    /// Frames written.
    frames: u64,
    /// Frames a second of simulated time.
    fps: f64,
    /// Width and height, pixels.
    size_px: [u32; 2],
    /// Stopped by the user before the end?
    interrupted: bool,
    /// What drew.
    device: String,
}

/// Exit status after Ctrl-C.
const INTERRUPTED: u8 = 130;

/// Records; says whether it came to its end.
fn record(app: App, recording: &Recording, picture: &Handle<Image>) -> Result<bool, RenderError> {
    let mut folder = FrameFolder::take(&recording.out)?;
    let mut headless = Headless::of(app)?;
    let mut frames = 0;
    for frame in 0..recording.frames {
        if headless.is_ending() {
            break;
        }
        headless.go_to(frame as f64 / recording.fps);
        headless.finish_frame();
        let png = encode_png(&headless.picture(picture)?)
            .map_err(|error| RenderError::Encode(frame, error.to_string()))?;
        folder.put(frame, &png)?;
        frames += 1;
    }
    let is_whole = frames == recording.frames;
    if frames == 0 {
        eprintln!("interrupted before the first frame; nothing was written");
        return Ok(false);
    }
    let after = folder.end(frames, is_whole)?;
    let report = RecordingReport {
        version: env!("CARGO_PKG_VERSION"),
        frames,
        fps: recording.fps,
        size_px: recording.size.to_array(),
        interrupted: !is_whole,
        device: headless.adapter(),
    };
    let path = recording.out.join(REPORT);
    let json = serde_json::to_vec_pretty(&report).map_err(|error| WriteError {
        path: path.display().to_string(),
        reason: error.to_string(),
    })?;
    write_whole(&path, &[&json, &b"\n"[..]].concat())?;
    let removal = after.removal(&recording.out, false);
    for remark in after.remarks(&recording.out).into_iter().chain(removal) {
        eprintln!("{remark}");
    }
    let frames = match frames {
        1 => "1 frame".into(),
        many => format!("{many} frames"),
    };
    println!("{frames} in {}", recording.out.display());
    if !is_whole {
        eprintln!("interrupted; what is in the folder is whole");
    }
    Ok(is_whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Option<Recording>, String> {
        Recording::from_arguments(text.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn a_command_line_asks_for_frames_or_for_a_window() {
        assert_eq!(read(""), Ok(None));
        let asked = read("--frames 5 --out o --size 64x48 --fps 2.5").expect("sound");
        assert_eq!(
            asked,
            Some(Recording {
                frames: 5,
                fps: 2.5,
                size: UVec2::new(64, 48),
                out: "o".into(),
            })
        );
        for (text, said) in [
            ("--frames 0 --out o", "\"0\""),
            ("--frames 3", "go together"),
            ("--out", "needs a value"),
            ("--size 4x4", "4x4"),
            ("--fps NaN", "NaN"),
            ("--what 3", "--what is not known"),
            ("--frames 1 --out o --frames 2", "--frames is given twice"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
