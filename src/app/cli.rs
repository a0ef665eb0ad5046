//! The command line.

mod arguments;
mod check;
mod features;
mod measure;
mod placement;
mod sentences;
mod values;
mod window;

use crate::appearance::EyeOrbit;
use crate::lab::render::{PanelChoice, RenderReport, RenderRequest, layout, render};
use crate::patients::{PRESETS, load_patient};
use crate::percept::ViewOptions;
use crate::scene::catalog::{BuiltIn, LoadedScene, SceneSource};
use crate::stage::{HeadPath, Session};
use arguments::{Cli, Command, PanelArg, RenderArgs, Shown};
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use placement::{SceneUnit, photo_options};
use sentences::{complain, inform, one_line, say};
use std::error::Error;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs the program and says how it ended: 0, 1 for what a user got wrong, 2 for the command line.
pub fn run() -> ExitCode {
    let matches = Cli::command().get_matches();
    let cli = match Cli::from_arg_matches(&matches) {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    if cli.command.is_some() || std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Mesa's device-selection layer looks for a compositor and complains on stderr where there
        // is none; a command without a window has no use for it, nor has one without a session.
        // SAFETY: this is the program's only thread so far.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
    match execute(cli, &matches) {
        Ok(code) => code,
        Err(error) => {
            complain(&error);
            ExitCode::FAILURE
        }
    }
}

fn execute(cli: Cli, matches: &ArgMatches) -> Result<ExitCode, Box<dyn Error>> {
    match cli.command {
        None => {
            return window::open(&cli.shown, cli.link.as_deref(), matches);
        }
        Some(_) if cli.link.is_some() => {
            return Err("--link opens the window, and goes with no command".into());
        }
        Some(Command::Render(arguments)) => return render_command(&arguments),
        Some(Command::Features(arguments)) => features::features(&arguments)?,
        Some(Command::Bench(arguments)) => {
            ctrlc::set_handler(crate::lab::bench::interrupt)?;
            crate::lab::bench::run(&arguments.out, arguments.quick)?;
        }
        Some(Command::Measure(arguments)) => measure::measure_command(&arguments)?,
        Some(Command::Patients) => {
            let mut out = std::io::stdout().lock();
            for preset in PRESETS {
                let patient = load_patient(preset.name)?;
                say(
                    &mut out,
                    &format!("{:<20} {}", preset.name, patient.description),
                )?;
            }
        }
        Some(Command::Scenes) => {
            let mut out = std::io::stdout().lock();
            for scene in BuiltIn::ALL {
                say(
                    &mut out,
                    &format!("{:<20} {}", scene.name(), scene.description()),
                )?;
            }
        }
        Some(Command::Check { file }) => {
            let name = file.display().to_string();
            let lines = match load_patient(&file) {
                Ok(patient) => check::checked(&patient, &name),
                Err(no_patient) => match HeadPath::load(&file) {
                    Ok(path) => vec![check::checked_path(&path, &name)],
                    // What is a list is no patient.
                    Err(error) if error.is_list() => return Err(error.into()),
                    Err(_) => return Err(no_patient.into()),
                },
            };
            let mut out = std::io::stdout().lock();
            for line in lines {
                say(&mut out, &one_line(&line))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn session(shown: &Shown) -> Result<Session, Box<dyn Error>> {
    let mut patient = load_patient(&shown.patient)?;
    if let Some(eye) = shown.eye {
        patient.eye = eye.laterality();
    }
    let options = photo_options(shown)?;
    let source = SceneSource::parse(&shown.scene, shown.depth.as_deref())?;
    if !matches!(source, SceneSource::Photo { .. }) && (shown.at.is_some() || shown.span.is_some())
    {
        return Err(format!(
            "--at and --span place a photograph, and the scene {:?} is none",
            shown.scene
        )
        .into());
    }
    if !matches!(source, SceneSource::Model { .. }) && shown.scene_unit.is_some() {
        return Err(format!(
            "--scene-unit is the unit of a glTF file, and the scene {:?} is none",
            shown.scene
        )
        .into());
    }
    for remark in patient.remarks() {
        complain(&format!("{}: {remark}", shown.patient.display()));
    }
    let scene = source.load(&options, shown.scene_unit.map(SceneUnit::metres))?;
    let moves = matches!(&scene, LoadedScene::Photo(photo) if photo.course.is_some());
    if shown.scene_fps.is_some() && !moves && !shown.scene.is_dir() {
        return Err(format!(
            "--scene-fps is the rate of pictures that follow one another, and the scene {:?} has none",
            shown.scene
        )
        .into());
    }
    for remark in scene.remarks() {
        complain(remark);
    }
    Ok(Session {
        light: shown.light.0,
        ..Session::new(shown.stage.of(patient), scene, shown.seed)
    })
}

fn render_command(arguments: &RenderArgs) -> Result<ExitCode, Box<dyn Error>> {
    let panels = match arguments.panel {
        PanelArg::Eye => PanelChoice::Eye,
        PanelArg::View => PanelChoice::View,
        PanelArg::Both => PanelChoice::Both,
    };
    let (sizes, drawn) = layout(panels, arguments.size);
    if let Some(small) = sizes
        .iter()
        .zip(drawn)
        .find(|(size, drawn)| *drawn && size.min_element() < 16)
    {
        complain(&format!(
            "--size {}x{} leaves a panel of {}x{} pixels; each panel needs at least 16x16",
            arguments.size.x, arguments.size.y, small.0.x, small.0.y
        ));
        return Ok(ExitCode::from(2));
    }
    let folder = |path: &Path| path.canonicalize().ok().filter(|path| path.is_dir());
    if let Some(scene) = folder(&arguments.shown.scene)
        && folder(&arguments.out) == Some(scene)
    {
        return Err(format!(
            "--out {:?} is the folder of the scene's own pictures; choose another",
            arguments.out
        )
        .into());
    }
    let head_path = arguments
        .head_path
        .as_deref()
        .map(HeadPath::load)
        .transpose()?;
    let request = RenderRequest {
        panels,
        size: arguments.size,
        seconds: arguments.seconds,
        fps: arguments.fps,
        orbit: EyeOrbit {
            azimuth_deg: arguments.orbit[0],
            elevation_deg: arguments.orbit[1],
            distance_mm: arguments.distance,
        },
        quality: arguments.quality.quality(),
        options: ViewOptions {
            marker: arguments.marker,
            threshold: arguments.threshold,
            ..ViewOptions::default()
        },
        head_path,
        out: arguments.out.clone(),
        arguments: std::env::args_os()
            .skip(1)
            .map(|argument| argument.to_string_lossy().into_owned())
            .collect(),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    // A second Ctrl-C ends the program at once; whole files stay whole either way.
    ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            crate::lab::bench::leave(130);
        }
    })?;
    let session = session(&arguments.shown)?;
    let told = session.scene.remarks().len();
    let lively = std::io::stderr().is_terminal();
    let report = render(session, &request, &stop, |done, total| {
        if lively {
            eprint!("\rframe {done} of {total}");
        }
    })?;
    if lively {
        eprintln!();
    }
    for remark in report.remarks.iter().skip(told) {
        complain(remark);
    }
    Ok(conclude(&report, &arguments.out))
}

fn conclude(report: &RenderReport, out: &Path) -> ExitCode {
    if report.frames == 0 {
        complain("interrupted before the first frame; nothing was written");
        return ExitCode::from(130);
    }
    let pace = report
        .frame_ms_median
        .map_or_else(String::new, |ms| format!("; {ms:.0} ms a frame"));
    inform(&format!(
        "{} frame{}, trace.csv and report.json in {} ({}{pace})",
        report.frames,
        if report.frames == 1 { "" } else { "s" },
        out.display(),
        report.device,
    ));
    if let Some(removal) = &report.removal {
        complain(removal);
    }
    if report.interrupted {
        complain("interrupted; what is in the folder is whole");
        return ExitCode::from(130);
    }
    ExitCode::SUCCESS
}
