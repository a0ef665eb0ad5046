//! The command line's arguments.

use super::placement::{SceneUnit, Span, parse_at, parse_length, parse_span};
use super::values::{
    parse_distance, parse_fps, parse_orbit, parse_scene_fps, parse_seconds, parse_seed, parse_size,
    parse_threshold,
};
use crate::anatomy::Laterality;
use crate::appearance::EyeQuality;
use crate::lab::measure::MeasureTable;
use crate::patients::PatientFile;
use crate::scene::depth_file::DepthUnit;
use crate::stage::PanelLight;
use bevy::math::UVec2;
use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Who is shown and measured where nobody is named.
pub(super) const DEFAULT_PATIENT: &str = "healthy-brown";

/// An anatomically accurate human eye to look at and to look through.
///
/// Without a command it opens a window: on the left the patient's eye, on the right what the
/// patient sees.
#[derive(Parser)]
#[command(version, max_term_width = 100, args_conflicts_with_subcommands = true)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Option<Command>,
    #[command(flatten)]
    pub(super) shown: Shown,
    /// Opens the window with what a link shows: the page's whole address, or what stands after its #.
    /// --patient, --eye, --scene and --seed given beside it win.
    #[arg(long, value_name = "LINK")]
    pub(super) link: Option<String>,
}

/// What is shown.
#[derive(Args, Clone)]
pub(super) struct Shown {
    /// A built-in patient (`ocularium patients` lists them) or a patient file (RON).
    #[arg(long, default_value = DEFAULT_PATIENT, value_name = "P")]
    pub(super) patient: PathBuf,
    /// The eye that is drawn and that sees, right or left; as the patient's file says without it.
    #[arg(long, value_enum, value_name = "EYE", ignore_case = true)]
    pub(super) eye: Option<EyeArg>,
    /// A built-in scene (`ocularium scenes`), a glTF or GLB file, a photograph (PNG, JPEG, WebP, GIF,
    /// TIFF, BMP), or pictures that follow one another: a folder of them, or a moving GIF, PNG or WebP.
    #[arg(long, default_value = "room", value_name = "S")]
    pub(super) scene: PathBuf,
    /// Distance of a photograph without a depth image: 0.4m, 40cm, 400mm, inf; 3m without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_at, allow_hyphen_values = true)]
    pub(super) at: Option<f32>,
    /// Height of a photograph: as an angle (20deg, 1 to 120; 50deg without it) or a length (21cm).
    #[arg(long, value_name = "HEIGHT", value_parser = parse_span, allow_hyphen_values = true)]
    pub(super) span: Option<Span>,
    /// Pictures a second of those that follow one another, 0.1 to 240; as a moving file says, or 25, without it.
    #[arg(long, value_name = "F", value_parser = parse_scene_fps, allow_hyphen_values = true)]
    pub(super) scene_fps: Option<f32>,
    /// What one unit of a glTF file is; the metre without it, as glTF says.
    #[arg(long, value_enum, value_name = "UNIT")]
    pub(super) scene_unit: Option<SceneUnit>,
    /// Depth image of a photograph, grey.
    #[arg(long, value_name = "IMAGE")]
    pub(super) depth: Option<PathBuf>,
    /// What a depth image's codes mean. Without it, 8 bits are inverse, and 16 bits are inverse or
    /// millimetres, whichever is likelier; the report says which.
    #[arg(long, value_enum, value_name = "UNIT", requires = "depth")]
    pub(super) depth_unit: Option<DepthUnit>,
    /// Distance of white in an inverse depth image; 0.5m without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, requires = "depth")]
    pub(super) depth_near: Option<f32>,
    /// Distance of black in an inverse depth image; infinitely far without it.
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, requires = "depth")]
    pub(super) depth_far: Option<f32>,
    /// What the eye is lit by, seen from outside.
    #[arg(long, value_enum, default_value = "window", value_name = "LIGHT")]
    pub(super) light: LightArg,
    /// How much of an eye's optics and relief is drawn.
    #[arg(long, value_enum, default_value = "full", value_name = "STAGE")]
    pub(super) stage: StageArg,
    /// Seed of every random choice, 0 to 18446744073709551615.
    #[arg(
        long,
        default_value_t = 1,
        value_name = "N",
        value_parser = parse_seed,
        allow_hyphen_values = true
    )]
    pub(super) seed: u64,
}

#[derive(Subcommand)]
pub(super) enum Command {
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
    /// acts on all but three: eyes, blur-disc and mtf are of published eyes.
    Measure(MeasureArgs),
    /// Lists the built-in patients.
    Patients,
    /// Lists the built-in scenes.
    Scenes,
    /// Says whether a patient file or a head path is sound.
    Check {
        /// The file (RON).
        file: PathBuf,
    },
}

/// [`PanelLight`] on the command line.
#[derive(Clone, Copy)]
pub(super) struct LightArg(pub(super) PanelLight);

impl ValueEnum for LightArg {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [LightArg; PanelLight::ALL.len()] = {
            let mut all = [LightArg(PanelLight::Scene); PanelLight::ALL.len()];
            let mut i = 0;
            while i < all.len() {
                all[i] = LightArg(PanelLight::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.description()))
    }
}

/// What the picture of an eye is built up from (François et al. 2007, figure 9).
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StageArg {
    /// The iris flat behind a clear window, evenly lit.
    None,
    /// The view refracted by the cornea.
    Refraction,
    /// And the light: concentrated on the iris as the cornea does.
    Light,
    /// And the iris' relief: all of it.
    Full,
    /// All of it, but with the iris where parallax mapping puts it in place of refraction.
    Parallax,
    /// That on the left and refraction on the right half of the iris.
    SideBySide,
}

impl StageArg {
    /// The patient with the rest left out, on either eye.
    pub(super) fn of(self, patient: PatientFile) -> PatientFile {
        if self == Self::Full {
            return patient;
        }
        patient.with_change(None, |eye| {
            if let Self::Parallax | Self::SideBySide = self {
                eye.look_parallax = if self == Self::Parallax { 1.0 } else { 0.5 };
                return;
            }
            eye.look_iris_relief = 0.0;
            if self != Self::Light {
                eye.look_caustic_scale = 0.0;
            }
            if self == Self::None {
                eye.look_refraction = 0.0;
            }
        })
    }
}

/// [`Laterality`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum EyeArg {
    /// The right eye.
    #[value(name = "OD", alias = "right")]
    Right,
    /// The left eye.
    #[value(name = "OS", alias = "left")]
    Left,
}

impl EyeArg {
    pub(super) fn laterality(self) -> Laterality {
        match self {
            Self::Right => Laterality::OD,
            Self::Left => Laterality::OS,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum PanelArg {
    /// The patient's eye.
    Eye,
    /// What the patient sees.
    View,
    /// Both, the eye on the left.
    Both,
}

/// [`EyeQuality`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum QualityArg {
    /// One sample a pixel and the quicker iris, as a window has it where processors draw.
    Fast,
    /// Four samples a pixel and the finer iris.
    Full,
}

impl QualityArg {
    pub(super) fn quality(self) -> EyeQuality {
        match self {
            Self::Fast => EyeQuality::PLAIN,
            Self::Full => EyeQuality::default(),
        }
    }
}

#[derive(Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) shown: Shown,
    /// Which panels are in the picture.
    #[arg(long, value_enum, default_value = "both")]
    pub(super) panel: PanelArg,
    /// Width and height of the picture in pixels, each 16 to 8192.
    #[arg(long, default_value = "1280x640", value_name = "WxH", value_parser = parse_size)]
    pub(super) size: UVec2,
    /// Length in seconds, above 0 to 3600.
    #[arg(long, default_value_t = 3.0, value_name = "T", value_parser = parse_seconds, allow_hyphen_values = true)]
    pub(super) seconds: f64,
    /// Frames a second, above 0 to 1000.
    #[arg(long, default_value_t = 10.0, value_name = "F", value_parser = parse_fps, allow_hyphen_values = true)]
    pub(super) fps: f64,
    /// The folder for frames, trace.csv and report.json; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Where the camera before the eye stands: degrees to the patient's right and up,
    /// -85 to 85 and -80 to 80.
    #[arg(long, default_value = "0,0", value_name = "AZ,EL", value_parser = parse_orbit, allow_hyphen_values = true)]
    pub(super) orbit: [f32; 2],
    /// Distance of that camera from the cornea in mm, 35 to 1000.
    #[arg(long, default_value_t = 93.0, value_name = "MM", value_parser = parse_distance, allow_hyphen_values = true)]
    pub(super) distance: f32,
    /// How finely the eye is drawn.
    #[arg(long, value_enum, default_value = "full")]
    pub(super) quality: QualityArg,
    /// The way that the head goes through the scene: a file (RON) with a list of moments, as in
    /// [(time_s: 0.0), (time_s: 2.0, forward_m: 1.0, right_m: 0.2, up_m: 0.0, yaw_deg: 20.0, pitch_deg: -5.0)],
    /// against where the scene puts it; or "walk", one that comes with the program.
    #[arg(long, value_name = "FILE")]
    pub(super) head_path: Option<PathBuf>,
    /// Draw a ring in the view where the eye looks.
    #[arg(long)]
    pub(super) marker: bool,
    /// FAST threshold for what may be looked at, 0 to 255.
    #[arg(
        long,
        default_value_t = 20,
        value_name = "T",
        value_parser = parse_threshold,
        allow_hyphen_values = true
    )]
    pub(super) threshold: u8,
}

#[derive(Args)]
pub(super) struct FeatureArgs {
    /// An image (PNG, JPEG, WebP, GIF, TIFF, BMP), at least 7×7 and at most 16384 pixels wide or high; colour becomes
    /// Rec. 709 luma.
    pub(super) image: PathBuf,
    /// Threshold, 0 to 255: a corner's ring differs by more than this.
    #[arg(long, value_name = "T", value_parser = parse_threshold, allow_hyphen_values = true)]
    pub(super) threshold: u8,
    /// Keep corners whose neighbours are as strong or stronger.
    #[arg(long)]
    pub(super) no_nms: bool,
}

#[derive(Args)]
pub(super) struct BenchArgs {
    /// Fewer and smaller runs.
    #[arg(long)]
    pub(super) quick: bool,
    /// The folder for CSV, plots and the summary.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
}

#[derive(Args)]
pub(super) struct MeasureArgs {
    /// What to measure.
    #[arg(value_enum)]
    pub(super) table: Measured,
    /// A built-in patient (`ocularium patients` lists them) or a patient file (RON); healthy-brown without it.
    #[arg(long, value_name = "P")]
    pub(super) patient: Option<PathBuf>,
    /// The eye that is measured, right or left; as the patient's file says without it.
    #[arg(long, value_enum, value_name = "EYE", ignore_case = true)]
    pub(super) eye: Option<EyeArg>,
    /// A file for the table in place of standard output; its folder is made if it is not there.
    #[arg(long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
}

/// What can be measured: a table that is computed, or a picture that is drawn.
#[derive(Clone, Copy)]
pub(super) enum Measured {
    Table(MeasureTable),
    Looks,
    IrisPicture,
}

impl ValueEnum for Measured {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [Measured; MeasureTable::ALL.len() + 2] = {
            let mut all = [Measured::Looks; MeasureTable::ALL.len() + 2];
            all[MeasureTable::ALL.len()] = Measured::IrisPicture;
            let mut i = 0;
            while i < MeasureTable::ALL.len() {
                all[i] = Measured::Table(MeasureTable::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Table(table) => PossibleValue::new(table.name()).help(table.description()),
            Self::Looks => PossibleValue::new("looks").help(crate::lab::looks::MEANING),
            Self::IrisPicture => {
                PossibleValue::new("iris-picture").help(crate::lab::iris_picture::MEANING)
            }
        })
    }
}
