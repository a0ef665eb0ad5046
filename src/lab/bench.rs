//! `ocularium bench`: speed and error, measured on this machine.
//!
//! Leaves, in a folder: `frames.csv` (milliseconds a frame by case), `field.csv`
//! (the sharpness field in rooms of different volume), `summary.json`, and
//! `frames.svg`; of each approximation `errors-TASK.csv` and `errors-TASK.svg` (error against
//! time), of all together `errors.csv`, `errors.json` and, to be read, `errors.md`. Every number is
//! measured in this run.
//!
//! The approximations are measured in a process of their own: none of the app's threads runs beside
//! them.

use super::approximations::{
    self, Effort, Requirement, TableSize, Task, joint_csv, report, requirements,
    tables_at_run_time, task_csv,
};
use super::eye_cost::{self, EyeCost};
use super::eye_frames::{self, EyeFrames, FixedSteps};
use super::frame_cost::{self, CrowdCost, ViewsCost, WalkCost};
use super::headless::{Headless, HeadlessError};
use super::irradiance;
use super::render::median;
use crate::appearance::EyeQuality;
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::output_file::{FolderLock, WriteError, prepare_folder, write_whole};
use crate::patients::{PatientError, load_patient};
use crate::percept::gpu_data::table_slots;
use crate::scene::catalog::LoadedScene;
use crate::scene::model::SceneError;
use crate::scene::room::{room, room_scaled};
use crate::stage::Session;
use crate::stage::head::HeadPathError;
use bevy::math::UVec2;
use bevy::prelude::Msaa;
use plotters::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Environment variable of the process that measures the approximations: the file for its tasks.
const TASKS_FILE: &str = "OCULARIUM_BENCH_TASKS";

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A frame could not be made.
    #[error(transparent)]
    Frame(#[from] HeadlessError),
    /// A built-in patient is unsound.
    #[error(transparent)]
    Patient(#[from] PatientError),
    /// A built-in scene is unsound.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An eye was lit by others than the lamps that were to be measured.
    #[error("an eye was lit otherwise than it was to be")]
    OtherLight,
    /// A change of an eye did not show.
    #[error("an eye that was changed looks as before")]
    Unchanged,
    /// The walk that comes with the program is unsound.
    #[error(transparent)]
    Walk(#[from] HeadPathError),
    /// An eye that was to be measured did not do what it was told.
    #[error("no frame in which the eye {} could be measured", if *.0 { "turns" } else { "stands still" })]
    NoSuchFrame(bool),
    /// A plot could not be drawn.
    #[error("the plot {0} could not be drawn: {1}")]
    Plot(&'static str, String),
    /// The process that measures the approximations did not do so.
    #[error("the approximations could not be measured: {0}")]
    Apart(String),
}

/// Milliseconds of the frames of one case.
#[derive(Clone, Debug, Serialize)]
struct FrameCase {
    name: &'static str,
    /// Samples a pixel of the eye; a window takes 1 on software and 4 on a GPU.
    samples_per_pixel: u32,
    width_px: u32,
    height_px: u32,
    frames: usize,
    ready_after_s: f64,
    ms_median: f64,
    ms_p95: f64,
    frames_per_s: f64,
}

/// The field in one room.
#[derive(Clone, Debug, Serialize)]
struct FieldCase {
    room: &'static str,
    volume_factor: f32,
    voxels: u32,
    table_bytes: u64,
    bytes_per_voxel: f64,
    ms_median: f64,
}

#[derive(Serialize)]
struct Summary {
    version: &'static str,
    device: String,
    processors: usize,
    quick: bool,
    frames: Vec<FrameCase>,
    field: Vec<FieldCase>,
    field_time_ratio_8x_volume: f64,
    /// What an eye costs the processor.
    eye: EyeCost,
    /// What its picture costs, by lamps and distance.
    eye_frames: Vec<EyeFrames>,
    /// From a change of the border layer's melanin to the picture with it.
    pigment_change_ms: f64,
    /// From the front, 30° and 60°.
    fixed_steps: Vec<FixedSteps>,
    /// What people cost whom nobody draws.
    crowds: Vec<CrowdCost>,
    /// What views of one still scene cost.
    views: Vec<ViewsCost>,
    /// What a view costs while its head walks.
    walk: WalkCost,
    /// What was asked of the optics and tissue library, and what was found.
    requirements: Vec<Requirement>,
    /// Bytes that it reads at run time.
    core_tables: Vec<TableSize>,
    errors: Vec<Task>,
}

fn session(patient: &str, factor: f32) -> Result<Session, BenchError> {
    let model = if factor == 1.0 {
        room()?
    } else {
        room_scaled(factor)?
    };
    let scene = LoadedScene::Model(Box::new(model));
    Ok(Session::new(load_patient(patient)?, scene, 7))
}

/// Times `count` frames of a sixtieth of a second, sorted, in ms.
pub(super) fn time_frames(headless: &mut Headless, from_s: f64, count: usize) -> Vec<f64> {
    let mut times: Vec<f64> = (1..=count)
        .map(|frame| {
            let at = Instant::now();
            headless.go_to(from_s + frame as f64 / 60.0);
            headless.finish_frame();
            at.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

fn frame_case(
    name: &'static str,
    patient: &str,
    size: UVec2,
    shown: [bool; 2],
    msaa: Msaa,
    count: usize,
) -> Result<(FrameCase, String), BenchError> {
    let started = Instant::now();
    let mut headless = Headless::new(session(patient, 1.0)?, [size; 2], shown)?;
    let ready_after_s = started.elapsed().as_secs_f64();
    headless.set_quality(EyeQuality {
        msaa,
        ..EyeQuality::PLAIN
    });
    // The first frames build the pipelines of this quality and fill caches.
    time_frames(&mut headless, 0.0, 8);
    let times = time_frames(&mut headless, 1.0, count);
    let ms_median = median(&mut times.clone());
    let panels = shown.iter().filter(|&&shown| shown).count() as u32;
    let case = FrameCase {
        name,
        samples_per_pixel: msaa.samples(),
        width_px: size.x * panels,
        height_px: size.y,
        frames: count,
        ready_after_s,
        ms_median,
        ms_p95: times[(count - 1) * 95 / 100],
        frames_per_s: 1e3 * count as f64 / times.iter().sum::<f64>(),
    };
    Ok((case, headless.adapter()))
}

/// The same view in rooms of different volume, frame by frame in turn, so that whatever else the
/// machine does falls on all alike.
fn field_cases(count: usize) -> Result<Vec<FieldCase>, BenchError> {
    let size = UVec2::splat(320);
    let rooms = [("room", 1.0f32), ("room, 8 × the volume", 8.0)];
    let mut running = Vec::new();
    for (_, factor) in rooms {
        let mut headless =
            Headless::new(session("healthy-brown", factor)?, [size; 2], [false, true])?;
        // In rooms of different size an eye that looks about looks at different things.
        headless
            .world()
            .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
                azimuth_rad: 0.0,
                elevation_rad: 0.0,
                distance_m: 1.0,
            }));
        time_frames(&mut headless, 0.0, 60);
        running.push((headless, Vec::new()));
    }
    for frame in 0..count {
        for (headless, times) in &mut running {
            times.extend(time_frames(headless, 1.0 + frame as f64 / 60.0, 1));
        }
    }
    Ok(rooms
        .into_iter()
        .zip(running)
        .map(|((room, volume_factor), (headless, mut times))| {
            let voxels = headless.percept().captured().occupied;
            let table_bytes = u64::from(table_slots(0, size.x * size.y)) * 12;
            FieldCase {
                room,
                volume_factor,
                voxels,
                table_bytes,
                bytes_per_voxel: table_bytes as f64 / f64::from(voxels.max(1)),
                ms_median: median(&mut times),
            }
        })
        .collect())
}

/// Measures the approximations and writes them to `file`.
fn approximate(file: &Path, quick: bool) -> Result<(), BenchError> {
    let effort = if quick { Effort::QUICK } else { Effort::FULL };
    let stopwatch = effort.stopwatch();
    let mut tasks = approximations::measure(&effort, &stopwatch);
    tasks.push(irradiance::measure(&stopwatch, effort.cases));
    Ok(write_whole(file, &json(file, &tasks)?)?)
}

/// What an interruption has to clear away, or to wait for.
#[derive(Default)]
struct Underway {
    /// The process that measures the approximations, and its file.
    apart: Option<(Child, PathBuf)>,
    /// Files are being written: it is over in a moment.
    writing: bool,
    /// The folder that they go to.
    folder: Option<FolderLock>,
}

static UNDERWAY: Mutex<Underway> = Mutex::new(Underway {
    apart: None,
    writing: false,
    folder: None,
});

fn underway() -> MutexGuard<'static, Underway> {
    UNDERWAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends a bench that the user interrupts: nothing is kept. To be called from another thread than
/// [`run`]'s; does nothing while the files are being written.
pub fn interrupt() {
    // The process apart is interrupted too, and its parent speaks for both.
    if std::env::var_os(TASKS_FILE).is_some() {
        leave(130);
    }
    let mut underway = underway();
    if underway.writing {
        return;
    }
    if let Some((mut child, file)) = underway.apart.take() {
        // It may have ended by itself, and its file may not be there yet.
        let _ = child.kill();
        let _ = child.wait();
        let _ = std::fs::remove_file(file);
    }
    drop(underway.folder.take());
    eprintln!("ocularium: interrupted; a bench is kept whole or not at all, so nothing was kept");
    leave(130);
}

/// Ends the process with `code` while its other threads are at work.
///
/// `std::process::exit` runs the destructors of the libraries beside those threads, and a graphics
/// driver that compiles a shader meanwhile then aborts, with a code of its own.
pub fn leave(code: i32) -> ! {
    #[cfg(unix)]
    // SAFETY: it takes a number, touches no memory and does not return.
    unsafe {
        libc::_exit(code)
    }
    #[cfg(not(unix))]
    std::process::exit(code)
}

/// [`approximate`] in a process of its own.
fn approximate_apart(out: &Path, quick: bool) -> Result<Vec<Task>, BenchError> {
    let apart = |error: &dyn core::fmt::Display| BenchError::Apart(error.to_string());
    let file = out.join(".ocularium-errors.json");
    let program = std::env::current_exe().map_err(|error| apart(&error))?;
    let mut command = Command::new(program);
    command.args(["bench", "--out"]).arg(out);
    if quick {
        command.arg("--quick");
    }
    let child = command
        .env(TASKS_FILE, &file)
        .stdin(Stdio::null())
        .spawn()
        .map_err(|error| apart(&error))?;
    underway().apart = Some((child, file.clone()));
    let status = loop {
        // The lock is let go of between looks, so that an interruption finds the child.
        match underway().apart.as_mut().map(|(child, _)| child.try_wait()) {
            Some(Ok(Some(status))) => break status,
            Some(Ok(None)) => {}
            Some(Err(error)) => return Err(apart(&error)),
            None => return Err(apart(&"it was interrupted")),
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    underway().apart = None;
    if !status.success() {
        return Err(apart(&status));
    }
    let text = std::fs::read(&file).map_err(|error| apart(&error))?;
    std::fs::remove_file(&file).map_err(|error| apart(&error))?;
    serde_json::from_slice(&text).map_err(|error| apart(&error))
}

fn json(path: &Path, value: &impl Serialize) -> Result<Vec<u8>, WriteError> {
    serde_json::to_vec_pretty(value).map_err(|error| WriteError {
        path: path.display().to_string(),
        reason: error.to_string(),
    })
}

/// Measures, writes the files, and prints what a person wants to know.
pub fn run(out: &Path, quick: bool) -> Result<(), BenchError> {
    if let Some(file) = std::env::var_os(TASKS_FILE) {
        return approximate(Path::new(&file), quick);
    }
    prepare_folder(out)?;
    underway().folder = Some(FolderLock::take(out)?);
    let done = measure_into(out, quick);
    underway().folder = None;
    done
}

fn measure_into(out: &Path, quick: bool) -> Result<(), BenchError> {
    let count = if quick { 40 } else { 200 };
    let square = UVec2::splat(320);
    let (plain, smooth) = (Msaa::Off, Msaa::Sample4);
    let brown = "healthy-brown";
    let mut cases = vec![
        ("both panels", brown, square, [true, true], plain),
        ("eye alone", brown, square, [true, false], plain),
        ("view alone", brown, square, [false, true], plain),
        ("view, -3 D", "myope-3d", square, [false, true], plain),
        ("view, -2 x 30", "astigmat", square, [false, true], plain),
        (
            "both, glaucoma",
            "glaucoma-moderate",
            square,
            [true, true],
            plain,
        ),
        ("both, 4 samples", brown, square, [true, true], smooth),
        ("none shown", brown, square, [false, false], plain),
    ];
    if !quick {
        cases.push((
            "both panels, 640",
            brown,
            UVec2::splat(640),
            [true, true],
            plain,
        ));
    }
    let mut frames = Vec::new();
    let mut device = String::new();
    for (name, patient, size, shown, msaa) in cases {
        let (case, adapter) = frame_case(name, patient, size, shown, msaa, count)?;
        eprintln!(
            "{:<18} {:>4}x{:<4} {:7.1} ms a frame (95 %: {:.1}), {:.1} frames/s, ready after {:.1} s",
            case.name,
            case.width_px,
            case.height_px,
            case.ms_median,
            case.ms_p95,
            case.frames_per_s,
            case.ready_after_s,
        );
        device = adapter;
        frames.push(case);
    }
    let field = field_cases(count)?;
    for case in &field {
        eprintln!(
            "{:<22} {:7.2} ms a frame, {} voxels, {:.1} MB of table",
            case.room,
            case.ms_median,
            case.voxels,
            case.table_bytes as f64 / 1e6,
        );
    }
    let eye = eye_cost::eye(session(brown, 1.0)?, 4 * count)?;
    eprintln!(
        "an eye costs the processor {:.2} ms a frame while it turns, {:.2} ms while it looks at one place, \
         {:.2} ms while time stands; the frame without it {:.2} ms",
        eye.turning_ms, eye.still_ms, eye.paused_ms, eye.nothing_shown_ms
    );
    let eye_frames = eye_frames::cases(|| session(brown, 1.0), count)?;
    for case in &eye_frames {
        eprintln!("eye, {:<14} {:7.2} ms a frame", case.name, case.ms_median);
    }
    let pigment_change_ms = eye_frames::pigment_change(session(brown, 1.0)?, count)?;
    eprintln!("eye, its melanin changed {pigment_change_ms:7.2} ms to the picture with it");
    let fixed_steps = [0.0, 30.0, 60.0]
        .map(|deg| eye_frames::fixed_steps(|| session(brown, 1.0), deg, count))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    for steps in &fixed_steps {
        eprintln!(
            "iris from {:>2.0}° {:7.2} ms a frame fast, {:.2} full, {:.2} by 64 steps ({:.2} times full), RMS difference from the last {:.2} and {:.2} %",
            steps.angle_deg,
            steps.fast_ms,
            steps.full_ms,
            steps.fixed_ms,
            steps.slower(),
            100.0 * steps.fast_rms_share,
            100.0 * steps.full_rms_share
        );
    }
    let crowds = [1, 10, 100]
        .map(|people| frame_cost::crowd(people, count))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    for crowd in &crowds {
        eprintln!(
            "{:>4} people, none drawn {:7.2} ms a frame, gaze {:.0}°",
            crowd.people, crowd.ms_median, crowd.turned_deg
        );
    }
    let views = [1, 4]
        .map(|cameras| frame_cost::views(cameras, count))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    for view in &views {
        eprintln!(
            "{:>4} views of one scene {:7.2} ms a frame, {:.2} presents, {:.2} captures",
            view.cameras, view.ms_median, view.presents, view.captures
        );
    }
    let walk = frame_cost::walking(session(brown, 1.0)?, square.x, count)?;
    eprintln!(
        "view while the head walks {:7.2} ms a frame with {:.2} captures, {:.2} at rest",
        walk.ms_median, walk.captures, walk.ms_median_at_rest
    );
    let mut errors = approximate_apart(out, quick)?;
    let requirements = requirements(&errors);
    errors.push(eye_frames::task(&fixed_steps));
    for requirement in &requirements {
        eprintln!("{requirement}");
    }
    let summary = Summary {
        version: env!("CARGO_PKG_VERSION"),
        device,
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        quick,
        field_time_ratio_8x_volume: field[1].ms_median / field[0].ms_median,
        frames,
        field,
        eye,
        eye_frames,
        pigment_change_ms,
        fixed_steps,
        crowds,
        views,
        walk,
        requirements,
        core_tables: tables_at_run_time(),
        errors,
    };
    underway().writing = true;
    let written = write_files(out, &summary);
    underway().writing = false;
    written?;
    eprintln!(
        "frames.csv, field.csv, errors.csv, errors.md, summary.json, frames.svg and {} plots of error \
         against time in {}",
        summary.errors.len(),
        out.display()
    );
    Ok(())
}

fn write_files(out: &Path, summary: &Summary) -> Result<(), BenchError> {
    let mut text = String::from(
        "case,samples_per_pixel,width_px,height_px,frames,ready_after_s,ms_median,ms_p95,frames_per_s\n",
    );
    for c in &summary.frames {
        text += &format!(
            "{:?},{},{},{},{},{:.3},{:.3},{:.3},{:.3}\n",
            c.name,
            c.samples_per_pixel,
            c.width_px,
            c.height_px,
            c.frames,
            c.ready_after_s,
            c.ms_median,
            c.ms_p95,
            c.frames_per_s
        );
    }
    write_whole(&out.join("frames.csv"), text.as_bytes())?;
    let mut text =
        String::from("room,volume_factor,voxels,table_bytes,bytes_per_voxel,ms_median\n");
    for c in &summary.field {
        text += &format!(
            "{:?},{},{},{},{:.2},{:.3}\n",
            c.room, c.volume_factor, c.voxels, c.table_bytes, c.bytes_per_voxel, c.ms_median
        );
    }
    write_whole(&out.join("field.csv"), text.as_bytes())?;
    let path = out.join("summary.json");
    write_whole(&path, &json(&path, summary)?)?;
    write_whole(
        &out.join("errors.csv"),
        joint_csv(&summary.errors).as_bytes(),
    )?;
    let path = out.join("errors.json");
    write_whole(&path, &json(&path, &summary.errors)?)?;
    write_whole(&out.join("errors.md"), report(&summary.errors).as_bytes())?;
    for task in &summary.errors {
        let name = |ending: &str| out.join(format!("errors-{}.{ending}", task.name));
        write_whole(&name("csv"), task_csv(task).as_bytes())?;
        write_whole(&name("svg"), approximations::plot(task).as_bytes())?;
    }
    let svg = frames_plot(&summary.frames)
        .map_err(|error| BenchError::Plot("frames.svg", error.to_string()))?;
    Ok(write_whole(&out.join("frames.svg"), svg.as_bytes())?)
}

/// Bars of the median frame time, with the 100 ms of ten frames a second marked.
fn frames_plot(cases: &[FrameCase]) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (760, 60 + 44 * cases.len() as u32))
            .into_drawing_area();
        area.fill(&WHITE)?;
        let longest = cases.iter().map(|case| case.ms_p95).fold(110.0, f64::max);
        let mut chart = ChartBuilder::on(&area)
            .margin(10)
            .x_label_area_size(34)
            .y_label_area_size(8)
            .build_cartesian_2d(0.0..longest * 1.05, 0.0..cases.len() as f64)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .x_desc("milliseconds a frame: median, and 95th percentile as a line")
            .draw()?;
        for (row, case) in cases.iter().enumerate() {
            let y = (cases.len() - 1 - row) as f64;
            chart.draw_series([Rectangle::new(
                [(0.0, y + 0.2), (case.ms_median, y + 0.8)],
                RGBColor(70, 120, 170).filled(),
            )])?;
            chart.draw_series([PathElement::new(
                [(case.ms_p95, y + 0.2), (case.ms_p95, y + 0.8)],
                RGBColor(170, 70, 60),
            )])?;
            let label = format!(
                "{} {}×{}: {:.1} ms",
                case.name, case.width_px, case.height_px, case.ms_median
            );
            chart.draw_series([Text::new(
                label,
                (longest * 0.01, y + 0.62),
                ("sans-serif", 15).into_font(),
            )])?;
        }
        chart.draw_series([PathElement::new(
            [(100.0, 0.0), (100.0, cases.len() as f64)],
            RGBColor(90, 90, 90).mix(0.6),
        )])?;
        area.present()?;
    }
    Ok(svg)
}
