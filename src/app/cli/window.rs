//! The window: opened with a link or without, and opened again where the graphics device was lost.

use super::sentences::complain;
use super::{Shown, session};
use crate::app::Session;
use crate::app::link::LinkState;
use crate::app::windowed::{self, WindowError};
use crate::ui::session_of;
use clap::ArgMatches;
use clap::parser::ValueSource;
use std::error::Error;
use std::ffi::OsString;
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
    match windowed::run(session, start, &said) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(WindowError::Interrupted) => Ok(ExitCode::from(windowed::INTERRUPTED)),
        Err(WindowError::DeviceLost {
            reason,
            link: Some(link),
        }) if opened.elapsed() > WORTH_ANOTHER => {
            complain(&format!(
                "the graphics device was lost ({reason}); the window opens again with what it showed"
            ));
            let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
            // A window cannot be opened twice in one process.
            let status = Command::new(std::env::current_exe()?)
                .args(again(&arguments, &link))
                .status()?;
            Ok(ExitCode::from(status.code().map_or(1, |code| code as u8)))
        }
        Err(error) => Err(error.into()),
    }
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

/// The same arguments with another link, which knows patient and seed as they are now.
fn again(arguments: &[OsString], link: &str) -> Vec<OsString> {
    let stale = ["--link", "--patient", "--seed"];
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
        let given =
            arguments("--scene a.glb --patient myope-3d --link=v=1 --scene-unit cm --seed 4");
        assert_eq!(
            again(&given, "v=1&seed=9"),
            arguments("--scene a.glb --scene-unit cm --link v=1&seed=9")
        );
        let given = arguments("--link v=1 --seed=4");
        assert_eq!(again(&given, "v=1"), arguments("--link v=1"));
    }
}
