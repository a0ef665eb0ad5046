//! The window: opened with a link or without, and opened again where the graphics device was lost.

use super::placement::{SceneUnit, photo_options};
use super::sentences::complain;
use super::{Shown, session};
use crate::app::windowed::{self, WindowError};
use crate::scene::photo::read_file;
use crate::scene::pictures::pictures_in;
use crate::stage::Session;
use crate::ui::link_state::LinkState;
use crate::ui::own_files::{OwnFile, Placement};
use crate::ui::{OwnScene, is_own, session_of};
use clap::ArgMatches;
use clap::parser::ValueSource;
use std::error::Error;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

/// A device that is lost sooner than this would be lost again and again.
const WORTH_ANOTHER: Duration = Duration::from_secs(20);

/// Opens the window and waits until it is closed.
pub(super) fn open(
    shown: &Shown,
    link: Option<&str>,
    matches: &ArgMatches,
) -> Result<ExitCode, Box<dyn Error>> {
    let (session, start, said) = requested(shown, link, matches)?;
    crate::lab::headless::require_device()?;
    let opened = Instant::now();
    let own = own_scene(shown, &session)?;
    match windowed::run(session, start, &said, own) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(WindowError::Interrupted) => Ok(ExitCode::from(windowed::INTERRUPTED)),
        Err(WindowError::DeviceLost {
            reason,
            link: Some(link),
            own_scene,
        }) if opened.elapsed() > WORTH_ANOTHER => {
            // What came from the command line is there to be read again; what was dropped is not.
            let given = shown.scene.display().to_string();
            let keeps_scene = own_scene.as_ref() == Some(&given);
            let but = match own_scene {
                Some(name) if !keeps_scene => format!("; only \"{name}\" has to be opened again"),
                _ => String::new(),
            };
            complain(&format!(
                "the graphics device was lost ({reason}); the window opens again with what it showed{but}"
            ));
            let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
            // A window cannot be opened twice in one process.
            let status = Command::new(std::env::current_exe()?)
                .args(again(&arguments, &link, keeps_scene))
                .status()?;
            Ok(ExitCode::from(status.code().map_or(1, |code| code as u8)))
        }
        Err(error) => Err(error.into()),
    }
}

/// The files of a scene from the command line, so that the controls can have them read in another unit.
fn own_scene(shown: &Shown, session: &Session) -> Result<OwnScene, Box<dyn Error>> {
    if session.scene.name() != shown.scene.display().to_string() || !is_own(&session.scene) {
        return Ok(OwnScene::default());
    }
    let file = |path: &Path, is_depth: bool| -> Result<OwnFile, Box<dyn Error>> {
        Ok(OwnFile {
            name: path.display().to_string(),
            bytes: read_file(path)?,
            folder: path.parent().map(Path::to_owned),
            is_depth,
        })
    };
    let scenes = if shown.scene.is_dir() {
        pictures_in(&shown.scene)?
    } else {
        vec![shown.scene.clone()]
    };
    let files: Result<Vec<OwnFile>, _> = scenes.iter().map(|path| file(path, false)).collect();
    let mut files = files?;
    if let Some(depth) = &shown.depth {
        files.push(file(depth, true)?);
    }
    let placement = Placement {
        photo: photo_options(shown)?,
        unit_m: shown.scene_unit.map(SceneUnit::metres),
    };
    Ok(OwnScene::of(files, placement))
}

/// What the command line and its link ask for together, and what cannot be obeyed.
fn requested(
    shown: &Shown,
    link: Option<&str>,
    matches: &ArgMatches,
) -> Result<(Session, LinkState, Vec<String>), Box<dyn Error>> {
    let Some(link) = link else {
        let session = session(shown)?;
        let start = LinkState {
            seed: session.seed,
            ..LinkState::default()
        };
        return Ok((session, start, Vec::new()));
    };
    let (mut start, refused) = LinkState::parse(link);
    for sentence in &refused {
        complain(sentence);
    }
    let given = |name: &str| matches.value_source(name) == Some(ValueSource::CommandLine);
    if given("seed") {
        start.seed = shown.seed;
    }
    let mut wanted = session_of(&start)?;
    if let Some(eye) = shown.eye {
        wanted.patient.eye = eye.laterality();
    }
    if given("patient") || given("scene") {
        let own = session(shown)?;
        if given("patient") {
            wanted.patient = own.patient;
        }
        if given("scene") {
            wanted.scene = own.scene;
        }
    }
    Ok((wanted, start, refused))
}

/// The same arguments with another link, which knows patient, seed and built-in scene as they are now.
fn again(arguments: &[OsString], link: &str, keeps_scene: bool) -> Vec<OsString> {
    let scene = [
        "--scene",
        "--scene-unit",
        "--at",
        "--span",
        "--scene-fps",
        "--depth",
        "--depth-unit",
        "--depth-near",
        "--depth-far",
    ];
    let scene = if keeps_scene { &scene[..0] } else { &scene[..] };
    let stale = [&["--link", "--patient", "--eye", "--seed"][..], scene].concat();
    let mut kept: Vec<OsString> = Vec::new();
    let mut arguments = arguments.iter();
    while let Some(argument) = arguments.next() {
        let text = argument.to_string_lossy();
        if stale.contains(&&*text) {
            arguments.next();
        } else if !stale
            .iter()
            .any(|name| text.starts_with(&format!("{name}=")))
        {
            kept.push(argument.clone());
        }
    }
    kept.extend(["--link".into(), link.into()]);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_that_opens_again_keeps_the_users_scene_and_takes_the_rest_from_the_link() {
        let arguments = |text: &str| text.split(' ').map(OsString::from).collect::<Vec<_>>();
        let given = arguments(
            "--scene a.glb --patient myope-3d --eye OS --link=v=1 --scene-unit cm --seed 4",
        );
        assert_eq!(
            again(&given, "v=1&seed=9", true),
            arguments("--scene a.glb --scene-unit cm --link v=1&seed=9")
        );
        let given = arguments("--link v=1 --seed=4");
        assert_eq!(again(&given, "v=1", true), arguments("--link v=1"));
        // Another scene was chosen meanwhile, or dropped: what the link says is shown.
        let given = arguments("--scene p.png --at 0.4m --depth-unit=mm --depth d.png --seed 4");
        assert_eq!(again(&given, "v=1", false), arguments("--link v=1"));
    }
}
