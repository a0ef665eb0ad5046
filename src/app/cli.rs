//! The command line.

mod placement;
mod sentences;
mod window;

use crate::anatomy::Laterality;
use crate::appearance::EyeOrbit;
use crate::input_file::one_clause;
use crate::lab::measure::{MeasureTable, MeasuredEye, measure};
use crate::lab::render::{PanelChoice, RenderReport, RenderRequest, layout, render};
use crate::output_file::{WriteError, prepare_folder, write_whole};
use crate::patients::{PRESETS, PatientFile, load_patient};
use crate::percept::{ViewOptions, fast};
use crate::scene::catalog::{BuiltIn, SceneSource};
use crate::scene::depth_file::DepthUnit;
use crate::scene::photo::read_named_file;
use crate::scene::picture_file::{Meaning, decode_picture, on_white};
use crate::stage::{HeadPath, Session};
use bevy::math::UVec2;
use clap::builder::PossibleValue;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use image::DynamicImage;
use placement::{SceneUnit, Span, parse_at, parse_length, parse_span, photo_options};
use sentences::{complain, inform, one_line, say, unwritten};
use std::error::Error;
use std::fmt::Display;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// An anatomically accurate human eye to look at and to look through.
///
/// Without a command it opens a window: on the left the patient's eye, on the right what the
/// patient sees.
#[derive(Parser)]
#[command(version, max_term_width = 100, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    shown: Shown,
    /// Opens the window with what a link shows: the page's whole address, or what stands after its #.
    /// --patient, --scene and --seed given beside it win.
    #[arg(long, value_name = "LINK")]
    link: Option<String>,
}

/// What is shown.
#[derive(Args, Clone)]
struct Shown {
    /// A built-in patient (`ocularium patients` lists them) or a patient file (RON).
    #[arg(long, default_value = "healthy-brown", value_name = "P")]
    patient: PathBuf,
    /// A built-in scene (`ocularium scenes`), a glTF or GLB file, or a photograph (PNG, JPEG, WebP,
    /// GIF, TIFF, BMP).
    #[arg(long, default_value = "room", value_name = "S")]
    scene: PathBuf,
    /// Distance of a photograph without a depth image: 0.4m, 40cm, 400mm, inf; 3m without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_at, allow_hyphen_values = true)]
    at: Option<f32>,
    /// Height of a photograph: as an angle (20deg, 1 to 120; 50deg without it) or a length (21cm).
    #[arg(long, value_name = "HEIGHT", value_parser = parse_span, allow_hyphen_values = true)]
    span: Option<Span>,
    /// What one unit of a glTF file is; the metre without it, as glTF says.
    #[arg(long, value_enum, value_name = "UNIT")]
    scene_unit: Option<SceneUnit>,
    /// Depth image of a photograph, grey.
    #[arg(long, value_name = "IMAGE")]
    depth: Option<PathBuf>,
    /// What a depth image's codes mean. Without it, 8 bits are inverse, and 16 bits are inverse or
    /// millimetres, whichever is likelier; the report says which.
    #[arg(long, value_enum, value_name = "UNIT", requires = "depth")]
    depth_unit: Option<DepthUnit>,
    /// Distance of white in an inverse depth image; 0.5m without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, requires = "depth")]
    depth_near: Option<f32>,
    /// Distance of black in an inverse depth image; infinitely far without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, requires = "depth")]
    depth_far: Option<f32>,
    /// Seed of every random choice, 0 to 18446744073709551615.
    #[arg(
        long,
        default_value_t = 1,
        value_name = "N",
        value_parser = parse_whole::<u64>,
        allow_hyphen_values = true
    )]
    seed: u64,
}

#[derive(Subcommand)]
enum Command {
    /// Renders frames, trace.csv and report.json into a folder, without a window.
    Render(RenderArgs),
    /// Finds FAST-9/16 corners of an image; prints CSV x,y,score.
    Features(FeatureArgs),
    /// Measures speed and error; writes CSV, plots and a summary into a folder.
    Bench(BenchArgs),
    /// Computes a table of the eye's optics or tissue; prints JSON.
    ///
    /// Units stand in the keys, sources and conventions at the top; the same table is the same bytes
    /// each time. A number that does not exist is null, and null_reasons beside it says why. --patient
    /// acts on pupil-ratio, refraction-function, glare, tissue and tear-film; eyes, blur-disc and mtf
    /// are of published eyes and do not depend on it.
    Measure(MeasureArgs),
    /// Lists the built-in patients.
    Patients,
    /// Lists the built-in scenes.
    Scenes,
    /// Says whether a patient file is sound.
    Check {
        /// The patient file (RON).
        file: PathBuf,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum PanelArg {
    /// The patient's eye.
    Eye,
    /// What the patient sees.
    View,
    /// Both, the eye on the left.
    Both,
}

#[derive(Args)]
struct RenderArgs {
    #[command(flatten)]
    shown: Shown,
    /// Which panels are in the picture.
    #[arg(long, value_enum, default_value = "both")]
    panel: PanelArg,
    /// Width and height of the picture in pixels, each 16 to 8192.
    #[arg(long, default_value = "1280x640", value_name = "WxH", value_parser = parse_size)]
    size: UVec2,
    /// Length in seconds, above 0 to 3600.
    #[arg(long, default_value_t = 3.0, value_name = "T", value_parser = parse_seconds, allow_hyphen_values = true)]
    seconds: f64,
    /// Frames a second, above 0 to 1000.
    #[arg(long, default_value_t = 10.0, value_name = "F", value_parser = parse_fps, allow_hyphen_values = true)]
    fps: f64,
    /// The folder for frames, trace.csv and report.json; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Where the camera before the eye stands: degrees to the patient's right and up,
    /// -85 to 85 and -80 to 80.
    #[arg(long, default_value = "0,0", value_name = "AZ,EL", value_parser = parse_orbit, allow_hyphen_values = true)]
    orbit: [f32; 2],
    /// Distance of that camera from the cornea in mm, 35 to 400.
    #[arg(long, default_value_t = 93.0, value_name = "MM", value_parser = parse_distance, allow_hyphen_values = true)]
    distance: f32,
    /// The way that the head goes through the scene: a file (RON) with a list of moments, as in
    /// [(time_s: 0.0), (time_s: 2.0, forward_m: 1.0, right_m: 0.2, up_m: 0.0, yaw_deg: 20.0, pitch_deg: -5.0)],
    /// against where the scene puts it.
    #[arg(long, value_name = "FILE")]
    head_path: Option<PathBuf>,
    /// Draw a ring in the view where the eye looks.
    #[arg(long)]
    marker: bool,
    /// FAST threshold for what may be looked at, 0 to 255.
    #[arg(
        long,
        default_value_t = 20,
        value_name = "T",
        value_parser = parse_whole::<u8>,
        allow_hyphen_values = true
    )]
    threshold: u8,
}

#[derive(Args)]
struct FeatureArgs {
    /// An image (PNG, JPEG, WebP, GIF, TIFF, BMP), at least 7×7 and at most 16384 pixels wide or high; colour becomes
    /// Rec. 709 luma.
    image: PathBuf,
    /// Threshold, 0 to 255: a corner's ring differs by more than this.
    #[arg(long, value_name = "T", value_parser = parse_whole::<u8>, allow_hyphen_values = true)]
    threshold: u8,
    /// Keep corners whose neighbours are as strong or stronger.
    #[arg(long)]
    no_nms: bool,
}

#[derive(Args)]
struct BenchArgs {
    /// Fewer and smaller runs.
    #[arg(long)]
    quick: bool,
    /// The folder for CSV, plots and the summary.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Args)]
struct MeasureArgs {
    /// What to measure.
    #[arg(value_enum)]
    table: MeasureTable,
    /// A built-in patient (`ocularium patients` lists them) or a patient file (RON).
    #[arg(long, default_value = "healthy-brown", value_name = "P")]
    patient: PathBuf,
    /// A file for the table in place of standard output; its folder is made if it is not there.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl ValueEnum for MeasureTable {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.description()))
    }
}

fn parse_size(text: &str) -> Result<UVec2, String> {
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

/// A whole number of those that `N` has.
fn parse_whole<N: FromStr + Bounded + Display>(text: &str) -> Result<N, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("{text:?} is not a whole number from 0 to {}", N::MOST))
}

/// Unsigned numbers.
trait Bounded: Sized {
    /// The largest.
    const MOST: Self;
}

impl Bounded for u64 {
    const MOST: Self = Self::MAX;
}

impl Bounded for u8 {
    const MOST: Self = Self::MAX;
}

fn parse_range(text: &str, what: &str, low: f64, high: f64) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|value| *value > low && *value <= high)
        .ok_or_else(|| format!("{text:?} is not {what} above {low} and up to {high}"))
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_range(text, "a number of seconds", 0.0, 3600.0)
}

fn parse_fps(text: &str) -> Result<f64, String> {
    parse_range(text, "a frame rate", 0.0, 1000.0)
}

fn parse_distance(text: &str) -> Result<f32, String> {
    text.parse::<f32>()
        .ok()
        .filter(|value| (35.0..=400.0).contains(value))
        .ok_or_else(|| format!("{text:?} is not a distance of 35 to 400 mm"))
}

fn parse_orbit(text: &str) -> Result<[f32; 2], String> {
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
        Some(Command::Features(arguments)) => features(&arguments)?,
        Some(Command::Bench(arguments)) => {
            ctrlc::set_handler(crate::lab::bench::interrupt)?;
            crate::lab::bench::run(&arguments.out, arguments.quick)?;
        }
        Some(Command::Measure(arguments)) => measure_command(&arguments)?,
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
            let patient = load_patient(&file)?;
            let mut out = std::io::stdout().lock();
            for line in checked(&patient, &file.display().to_string()) {
                say(&mut out, &one_line(&line))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// What there is to say of a sound patient file: who it is, what either eye has, and what comes otherwise
/// than written.
fn checked(patient: &PatientFile, file: &str) -> Vec<String> {
    let leading = match patient.eye {
        Laterality::OD => "right",
        Laterality::OS => "left",
    };
    let mut lines = vec![format!(
        "{file} is sound: {}, {} years; the {leading} eye leads.",
        one_clause(&patient.name),
        patient.age_years
    )];
    for (name, eye) in [("right", Laterality::OD), ("left", Laterality::OS)] {
        let own = patient.of_eye(eye);
        let mut parts = vec![format!(
            "{} D sphere, {} D cylinder",
            own.sphere_d, own.cylinder_d
        )];
        parts.extend(
            own.condition_captions()
                .into_iter()
                .map(|(_, caption)| caption.trim_end_matches('.').to_owned()),
        );
        lines.push(format!("{name} eye: {}.", parts.join("; ")));
    }
    lines.extend(
        patient
            .remarks()
            .into_iter()
            .map(|remark| format!("{remark}.")),
    );
    lines
}

fn session(shown: &Shown) -> Result<Session, Box<dyn Error>> {
    let patient = load_patient(&shown.patient)?;
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
    for remark in scene.remarks() {
        complain(remark);
    }
    Ok(Session::new(patient, scene, shown.seed))
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
    if report.removed_frames > 0 {
        complain(&format!(
            "an earlier run into {} was longer; its frames beyond these were removed ({})",
            out.display(),
            report.removed_frames
        ));
    }
    if report.interrupted {
        complain("interrupted; what is in the folder is whole");
        return ExitCode::from(130);
    }
    ExitCode::SUCCESS
}

fn measure_command(arguments: &MeasureArgs) -> Result<(), Box<dyn Error>> {
    let eye = measured_eye(&load_patient(&arguments.patient)?);
    let Some(file) = &arguments.out else {
        let text = measure(arguments.table, &eye)?;
        return Ok(say(&mut std::io::stdout().lock(), &text)?);
    };
    prepare_file(file)?;
    let text = measure(arguments.table, &eye)? + "\n";
    write_whole(file, text.as_bytes())?;
    inform(&format!("{} in {}", arguments.table.name(), file.display()));
    Ok(())
}

/// Makes the folder of a file, and sees that the file can be written, before any work is spent on it.
fn prepare_file(file: &Path) -> Result<(), WriteError> {
    let refused = |reason: String| WriteError {
        path: file.display().to_string(),
        reason,
    };
    // Replacing a folder fails late; replacing a device would be worse.
    let other = std::fs::metadata(file).is_ok_and(|found| !found.is_file());
    if other || file.file_name().is_none() {
        return Err(refused("it is not a file".into()));
    }
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    prepare_folder(folder).map_err(|error| refused(error.reason))
}

/// Diameter of the hole in the iris of a patient whose pupil light would set, mm.
const USUAL_PUPIL_MM: f64 = 4.0;

/// What of a patient is measured: of her leading eye.
fn measured_eye(patient: &PatientFile) -> MeasuredEye {
    let (eye, cornea, iris, ..) = patient.eye_components(patient.eye);
    let magnification = cornea.pupil_magnification(iris.depth_mm);
    let held_mm = patient
        .pupil
        .diameter_mm()
        .map(|seen_mm| seen_mm / magnification);
    let pigment = iris.pigment();
    MeasuredEye {
        name: patient.name.clone(),
        right_eye: eye.laterality == Laterality::OD,
        age_years: patient.age_years,
        anterior_radius_mm: cornea.anterior_radius_mm,
        anterior_shape_factor: cornea.anterior_p,
        posterior_radius_mm: cornea.posterior_radius_mm,
        posterior_shape_factor: cornea.posterior_p,
        corneal_thickness_mm: cornea.thickness_mm,
        cornea_index: cornea.index,
        aqueous_index: cornea.aqueous_index,
        limbus_radius_mm: cornea.limbus_radius_mm,
        iris_depth_mm: iris.depth_mm,
        pupil_diameter_mm: held_mm.unwrap_or(USUAL_PUPIL_MM),
        pupil_nasal_mm: iris.pupil_decentration_mm[0],
        pupil_superior_mm: iris.pupil_decentration_mm[1],
        stroma_melanin_fraction: pigment.stroma_melanin_fraction,
        border_layer_melanin_fraction: pigment.border_layer_melanin_fraction,
        eumelanin_ratio: pigment.eumelanin_ratio,
        glare_pigment: iris.color.glare_pigment(),
        lipid_thickness_nm: cornea.lipid_thickness_nm,
    }
}

fn features(arguments: &FeatureArgs) -> Result<(), Box<dyn Error>> {
    let name = arguments.image.display().to_string();
    let bytes = read_named_file(&arguments.image, "image")?;
    let picture = decode_picture(&bytes, &name, 7, Meaning::Colour)?;
    for remark in &picture.remarks {
        complain(remark);
    }
    let image = DynamicImage::ImageRgb16(on_white(picture.image)).into_rgb8();
    let grey: Vec<u8> = image
        .pixels()
        .map(|pixel| fast::luma_of_srgb8(pixel.0))
        .collect();
    let corners = fast::detect(
        &grey,
        image.width() as usize,
        image.height() as usize,
        arguments.threshold,
        !arguments.no_nms,
    )?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    say(&mut out, "x,y,score")?;
    for corner in &corners {
        say(
            &mut out,
            &format!("{},{},{}", corner.x, corner.y, corner.score),
        )?;
    }
    match out.flush() {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(unwritten(&error).into()),
        Ok(()) => Ok(()),
    }
}
