//! `ocularium render`: frames, a trace, and a report of what was done.

use super::frame_folder::{FrameFolder, REPORT};
use super::headless::{Headless, HeadlessError, Which};
use crate::anatomy::Laterality;
use crate::appearance::{EyeOrbit, EyeQuality};
use crate::frame::ledger::Work;
pub use crate::frame::picture::encode_png;
use crate::frame::picture::side_by_side;
use crate::motion::trace::{TraceRow, write_trace};
use crate::output_file::{WriteError, write_whole};
use crate::percept::ViewOptions;
use crate::percept::places::FEWEST_CORNERS;
use crate::stage::{HeadPath, Session};
use bevy::math::UVec2;
use image::RgbaImage;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Which panels are in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PanelChoice {
    /// The patient's eye.
    Eye,
    /// What the patient sees.
    View,
    /// Both, the eye on the left.
    Both,
}

/// What to render.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// Which panels.
    pub panels: PanelChoice,
    /// Width and height of the picture, pixels.
    pub size: UVec2,
    /// Length, s.
    pub seconds: f64,
    /// Frames a second.
    pub fps: f64,
    /// Where the camera before the eye stands.
    pub orbit: EyeOrbit,
    /// How finely that draws.
    pub quality: EyeQuality,
    /// Marker and threshold of the view.
    pub options: ViewOptions,
    /// The way that the head goes, if it moves.
    pub head_path: Option<HeadPath>,
    /// The folder that gets the files.
    pub out: PathBuf,
    /// What was asked for in words, for the report.
    pub arguments: Vec<String>,
}

/// Why nothing, or not everything, was rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A frame could not be made.
    #[error(transparent)]
    Frame(#[from] HeadlessError),
    /// A picture could not be encoded.
    #[error("frame {0} could not be encoded: {1}")]
    Encode(u64, String),
}

/// `report.json`.
#[derive(Clone, Debug, Serialize)]
pub struct RenderReport {
    /// The program's version.
    pub version: &'static str,
    /// The command line's arguments: with them the same is rendered again.
    pub arguments: Vec<String>,
    /// The patient's name.
    pub patient: String,
    /// The eye that is drawn and that sees.
    pub eye: Laterality,
    /// The scene's name.
    pub scene: String,
    /// What the eye is lit by, as `--light` names it; `None` where no eye is in the picture.
    pub light: Option<&'static str>,
    /// Where the camera before the eye stands: degrees to the patient's right and up; `None` where there is none.
    pub orbit_deg: Option<[f32; 2]>,
    /// Its distance from the cornea, mm; `None` where there is none.
    pub distance_mm: Option<f32>,
    /// How its iris is computed, as [`EyeShading::name`](crate::appearance::EyeShading::name) has it; `None` where there is none.
    pub quality: Option<&'static str>,
    /// How much a corner of the view differs from its ring at least, 0 to 255; `None` where there is no view.
    pub threshold: Option<u8>,
    /// Panels in the picture.
    pub panel: PanelChoice,
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Seed of every random choice.
    pub seed: u64,
    /// Frames a second of simulated time.
    pub fps: f64,
    /// Frames written.
    pub frames: u64,
    /// Stopped by the user before the end?
    pub interrupted: bool,
    /// Fixations made.
    pub fixations: u64,
    /// Blinks that closed the lids.
    pub blinks: u64,
    /// Corners found in the view.
    pub candidates: usize,
    /// Among what the eye chose where to look.
    pub looked_at: LookedAt,
    /// What drew.
    pub device: String,
    /// Seconds until the first frame was complete.
    pub ready_after_s: f64,
    /// Milliseconds a frame, without reading back and encoding: mean. The first frame was complete
    /// before the clock began (`ready_after_s`) and does not count; `None` where there is no other.
    pub frame_ms_mean: Option<f64>,
    /// The same, median.
    pub frame_ms_median: Option<f64>,
    /// The same, largest.
    pub frame_ms_max: Option<f64>,
    /// Work done from the first frame to the last.
    pub work: Work,
    /// Frames of an earlier, longer run into the same folder that were removed.
    pub removed_frames: u64,
    /// The same in a sentence, where there were any.
    #[serde(skip)]
    pub removal: Option<String>,
    /// How many numbers the frames of it go on after these, because this run was stopped before it came to
    /// them.
    pub left_frames: u64,
    /// What a user should know about how the scene was read, one sentence each.
    pub remarks: Vec<String>,
}

/// Among what an eye chooses where to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LookedAt {
    /// The corners of its view.
    Corners,
    /// These, and places by chance, because they are few.
    CornersAndChance,
    /// Places by chance: its view was not drawn, or has no corner.
    Chance,
}

impl LookedAt {
    fn of(view_drawn: bool, corners: usize) -> Self {
        match corners {
            _ if !view_drawn => Self::Chance,
            0 => Self::Chance,
            1..FEWEST_CORNERS => Self::CornersAndChance,
            _ => Self::Corners,
        }
    }
}

/// Number of frames: at least one, at times 0, 1/fps, 2/fps, ….
pub fn frame_count(seconds: f64, fps: f64) -> u64 {
    ((seconds * fps).round() as u64).max(1)
}

/// Sizes of eye and view in a picture, and which of them are drawn.
pub fn layout(panels: PanelChoice, size: UVec2) -> ([UVec2; 2], [bool; 2]) {
    match panels {
        PanelChoice::Eye => ([size, UVec2::splat(16)], [true, false]),
        PanelChoice::View => ([UVec2::splat(16), size], [false, true]),
        PanelChoice::Both => {
            let eye = UVec2::new(size.x / 2, size.y);
            let view = UVec2::new(size.x - eye.x, size.y);
            ([eye, view], [true, true])
        }
    }
}

/// The picture of this moment.
pub fn picture(headless: &Headless, request: &RenderRequest) -> Result<RgbaImage, HeadlessError> {
    match request.panels {
        PanelChoice::Eye => headless.panel(Which::Eye),
        PanelChoice::View => headless.panel(Which::View),
        PanelChoice::Both => {
            let (eye, view) = (headless.panel(Which::Eye)?, headless.panel(Which::View)?);
            Ok(side_by_side(&eye, &view))
        }
    }
}

/// Renders; `stop` ends it after the frame in work, keeping what is done.
pub fn render(
    session: Session,
    request: &RenderRequest,
    stop: &AtomicBool,
    mut progress: impl FnMut(u64, u64),
) -> Result<RenderReport, RenderError> {
    let mut folder = FrameFolder::take(&request.out)?;
    let mut remarks = session.scene.remarks().to_vec();
    let started = Instant::now();
    let (sizes, shown) = layout(request.panels, request.size);
    let (patient, seed) = (session.patient.name.clone(), session.seed);
    let (leading, light) = (session.patient.eye, session.light);
    let scene = session.scene.name().to_owned();
    let is_far = session.scene.is_far();
    // All of it stands before the first look: what the eye may look at is searched for but once.
    let mut headless = Headless::prepared(session, sizes, shown, |world, stage| {
        world
            .entity_mut(stage.eye)
            .insert((request.orbit, request.quality));
        let mut view = world.entity_mut(stage.view);
        if let Some(mut options) = view.get_mut::<ViewOptions>() {
            let exposure = options.exposure;
            *options = ViewOptions {
                exposure,
                ..request.options
            };
        }
        if let Some(path) = &request.head_path {
            view.insert((path.at(0.0), path.clone()));
        }
    })?;
    headless.stand_still();
    let ready_after_s = started.elapsed().as_secs_f64();

    let total = frame_count(request.seconds, request.fps);
    let before = headless.work();
    let (mut rows, mut times_ms) = (Vec::new(), Vec::new());
    for frame in 0..total {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let at = Instant::now();
        headless.go_to(frame as f64 / request.fps);
        headless.finish_frame();
        if frame > 0 {
            times_ms.push(at.elapsed().as_secs_f64() * 1e3);
        }
        rows.push(TraceRow::from(&headless.state()));
        let png = encode_png(&picture(&headless, request)?)
            .map_err(|error| RenderError::Encode(frame, error.to_string()))?;
        folder.put(frame, &png)?;
        progress(frame + 1, total);
    }
    let mut trace = Vec::new();
    write_trace(&rows, &mut trace).map_err(|error| WriteError {
        path: "trace.csv".into(),
        reason: error.to_string(),
    })?;
    if !rows.is_empty() {
        write_whole(&request.out.join("trace.csv"), &trace)?;
    }

    let state = headless.state();
    let captured = headless.percept().captured();
    let candidates = captured.corners.len();
    if shown[1] && captured.is_empty() && !is_far {
        remarks.push(nothing_in_view(&scene));
    }
    let frames = rows.len() as u64;
    // Whoever stops a run may want the longer one that was there before.
    let after = folder.end(frames, frames == total)?;
    remarks.extend(after.remarks(&request.out));
    let (drawn, orbit) = (!times_ms.is_empty(), request.orbit);
    let report = RenderReport {
        version: env!("CARGO_PKG_VERSION"),
        arguments: request.arguments.clone(),
        patient,
        eye: leading,
        scene,
        light: shown[0].then(|| light.name()),
        // Plus nothing: minus nothing is nothing.
        orbit_deg: shown[0].then_some([orbit.azimuth_deg + 0.0, orbit.elevation_deg + 0.0]),
        distance_mm: shown[0].then_some(orbit.distance_mm),
        quality: shown[0].then(|| request.quality.shading.name()),
        threshold: shown[1].then_some(request.options.threshold),
        panel: request.panels,
        size_px: request.size.to_array(),
        seed,
        fps: request.fps,
        frames,
        interrupted: frames < total,
        fixations: state.fixation_index,
        blinks: state.blink_epoch,
        candidates,
        looked_at: LookedAt::of(shown[1], candidates),
        device: headless.adapter(),
        ready_after_s,
        frame_ms_mean: drawn.then(|| times_ms.iter().sum::<f64>() / times_ms.len() as f64),
        frame_ms_median: drawn.then(|| median(&mut times_ms.clone())),
        frame_ms_max: drawn.then(|| times_ms.iter().copied().fold(0.0, f64::max)),
        work: headless.work().since(before),
        removed_frames: after.removed,
        removal: after.removal(&request.out, true),
        left_frames: after.reach,
        remarks,
    };
    let json = serde_json::to_vec_pretty(&report).map_err(|error| WriteError {
        path: "report.json".into(),
        reason: error.to_string(),
    })?;
    // A run that was stopped before its first frame leaves what was there.
    if !rows.is_empty() {
        write_whole(&request.out.join(REPORT), &[&json, &b"\n"[..]].concat())?;
    }
    drop(folder);
    Ok(report)
}

/// What is said of a view in which nothing is.
pub fn nothing_in_view(scene: &str) -> String {
    format!(
        "Nothing of \"{scene}\" that has a distance is in the view: the eye looks past it, sees its back or its \
         edge, looks through it, or has it nearer than 2 cm."
    )
}

/// Middle value, or the mean of the two in the middle; 0 of none.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let Some(above) = values.get(values.len() / 2) else {
        return 0.0;
    };
    if values.len() % 2 == 1 {
        *above
    } else {
        0.5 * (values[values.len() / 2 - 1] + above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted_from_zero_and_never_none() {
        assert_eq!(frame_count(3.0, 10.0), 30);
        assert_eq!(frame_count(0.001, 1.0), 1);
        assert_eq!(frame_count(0.1, 30.0), 3);
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_two_in_the_middle() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!((median(&mut [7.0]), median(&mut [])), (7.0, 0.0));
    }

    #[test]
    fn few_corners_are_joined_by_chance() {
        assert_eq!(LookedAt::of(false, 0), LookedAt::Chance);
        assert_eq!(LookedAt::of(true, 0), LookedAt::Chance);
        let few = LookedAt::of(true, FEWEST_CORNERS - 1);
        assert_eq!(few, LookedAt::CornersAndChance);
        assert_eq!(LookedAt::of(true, FEWEST_CORNERS), LookedAt::Corners);
    }

    #[test]
    fn both_panels_fill_an_odd_width() {
        let ([eye, view], shown) = layout(PanelChoice::Both, UVec2::new(641, 320));
        assert_eq!((eye.x + view.x, shown), (641, [true, true]));
    }
}
