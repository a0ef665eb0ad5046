//! A folder of frames: whose they are, and what becomes of those that were there before.
//!
//! Enters: frames in their order. Leaves: `frame_NNNNN.png`. What is called so and was written by no run of
//! this program is never replaced or removed.

use crate::output_file::{FolderLock, WriteError, prepare_folder, write_whole};
use std::path::{Path, PathBuf};

/// What a run says of its frames.
pub const REPORT: &str = "report.json";

/// A folder into which one run writes its frames.
#[derive(Debug)]
pub struct FrameFolder {
    out: PathBuf,
    lock: FolderLock,
    /// Frames that an earlier run left.
    earlier: u64,
    /// Whether its trace was taken away.
    trace_went: bool,
}

/// What became of the frames of an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Afterwards {
    /// Frames of it that were removed.
    pub removed: u64,
    /// Frames of it that lie after those of this run.
    pub left: u64,
    /// How far their numbers go beyond those of this run.
    pub reach: u64,
    /// Frames that are nobody's.
    pub strange: u64,
    /// Whether an earlier run's trace was taken away, with the first frame.
    pub trace_went: bool,
}

impl FrameFolder {
    /// Takes the folder, which is made where it is not there.
    ///
    /// # Errors
    /// Where it cannot be written, another run writes into it, or it holds a film that is somebody's own.
    pub fn take(out: &Path) -> Result<Self, WriteError> {
        prepare_folder(out)?;
        let lock = FolderLock::take(out)?;
        let counted = earlier_frames(out);
        // A killed run has noted its frames; those of another its report counts.
        let earlier = counted.unwrap_or(0).max(lock.left.unwrap_or(0));
        let first = frame_path(out, 0);
        if earlier == 0 && first.exists() {
            return Err(WriteError {
                path: first.display().to_string(),
                reason: "a picture of this name is there, and no report of an earlier run counts it; choose \
                         another folder with --out"
                    .into(),
            });
        }
        let trace = out.join("trace.csv");
        if counted.is_none() && lock.left.is_none() && trace.exists() {
            return Err(WriteError {
                path: trace.display().to_string(),
                reason: "a table of this name is there, and no report of an earlier run is beside it; choose another \
                         folder with --out"
                    .into(),
            });
        }
        Ok(Self {
            out: out.into(),
            lock,
            earlier,
            trace_went: false,
        })
    }

    /// Writes a frame; with the first, what an earlier run said of its own is forgotten.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn put(&mut self, frame: u64, png: &[u8]) -> Result<(), WriteError> {
        write_whole(&frame_path(&self.out, frame), png)?;
        self.lock.note((frame + 1).max(self.earlier))?;
        if frame == 0 {
            self.trace_went |= self.out.join("trace.csv").exists();
            forget_earlier_run(&self.out)?;
        }
        Ok(())
    }

    /// After `frames` of them: a run that is whole takes away what an earlier one has more.
    ///
    /// # Errors
    /// Where that cannot be done.
    pub fn end(&self, frames: u64, is_whole: bool) -> Result<Afterwards, WriteError> {
        let (later, strange) = later_frames(&self.out, frames, self.earlier)?;
        let (removed, left) = if is_whole {
            (remove(&later)?, 0)
        } else {
            (0, later.len() as u64)
        };
        Ok(Afterwards {
            removed,
            left,
            reach: if left > 0 { self.earlier - frames } else { 0 },
            strange,
            trace_went: self.trace_went,
        })
    }
}

impl Afterwards {
    /// What was taken away of an earlier run, by one that `traces` or does not; `None` where nothing was.
    pub fn removal(&self, out: &Path, traces: bool) -> Option<String> {
        let mut gone = Vec::new();
        if self.removed > 0 {
            gone.push(format!("its frames beyond these ({})", self.removed));
        }
        if self.trace_went && !traces {
            gone.push("its trace.csv".into());
        }
        (!gone.is_empty()).then(|| {
            let what = if self.removed > 0 {
                "was longer"
            } else {
                "left more"
            };
            let (gone, verb) = (
                gone.join(" and "),
                if gone == ["its trace.csv"] {
                    "was"
                } else {
                    "were"
                },
            );
            format!(
                "an earlier run into {} {what}; {gone} {verb} removed",
                out.display()
            )
        })
    }

    /// What a user should know of it, one sentence each.
    pub fn remarks(&self, out: &Path) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.strange > 0 {
            remarks.push(format!(
                "{} holds {} that no report counts and that {} not of this run.",
                out.display(),
                more_frames(self.strange),
                if self.strange == 1 { "is" } else { "are" }
            ));
        }
        if self.left > 0 {
            remarks.push(format!(
                "{} holds {} of an earlier run: this one was stopped before it came to {}.",
                out.display(),
                more_frames(self.left),
                if self.left == 1 { "it" } else { "them" }
            ));
        }
        remarks
    }
}

fn refused(path: &Path, error: &std::io::Error) -> WriteError {
    WriteError {
        path: path.display().to_string(),
        reason: error.to_string(),
    }
}

fn more_frames(count: u64) -> String {
    match count {
        1 => "1 more frame".into(),
        many => format!("{many} more frames"),
    }
}

/// Removes what an earlier run said of its frames, now that they are replaced: a run that fails on the
/// way must not leave its own beside them.
fn forget_earlier_run(out: &Path) -> Result<(), WriteError> {
    for name in ["trace.csv", "report.json"] {
        let path = out.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(refused(&path, &error));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Frames that an earlier run into this folder wrote, and those that it left there, as its report says; `None`
/// where there is no report of this program.
fn earlier_frames(out: &Path) -> Option<u64> {
    let report = std::fs::read(out.join(REPORT)).ok()?;
    let report: serde_json::Value = serde_json::from_slice(&report).ok()?;
    let of_program = report["version"].is_string() && report["fps"].is_number();
    let frames = report["frames"].as_u64().filter(|_| of_program)?;
    Some(frames + report["left_frames"].as_u64().unwrap_or(0))
}

/// Of the frames numbered `frames` and above those that an earlier run left, which wrote `earlier`; and
/// how many others there are.
fn later_frames(out: &Path, frames: u64, earlier: u64) -> Result<(Vec<PathBuf>, u64), WriteError> {
    let (mut later, mut strange) = (Vec::new(), 0);
    for entry in std::fs::read_dir(out).map_err(|error| refused(out, &error))? {
        let path = entry.map_err(|error| refused(out, &error))?.path();
        let number = path
            .file_name()
            .and_then(|name| name.to_str()?.strip_prefix("frame_")?.strip_suffix(".png"))
            .and_then(|digits| digits.parse::<u64>().ok());
        // Only names that this program gives.
        let ours = |number: &u64| *number >= frames && frame_path(out, *number) == path;
        match number.filter(ours) {
            Some(number) if number < earlier => later.push(path),
            Some(_) => strange += 1,
            None => {}
        }
    }
    Ok((later, strange))
}

/// Removes files; says how many.
fn remove(paths: &[PathBuf]) -> Result<u64, WriteError> {
    for path in paths {
        std::fs::remove_file(path).map_err(|error| refused(path, &error))?;
    }
    Ok(paths.len() as u64)
}

fn frame_path(out: &Path, frame: u64) -> PathBuf {
    out.join(format!("frame_{frame:05}.png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_frames_of_an_earlier_run_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = ["frame_00000.png", "frame_00001.png", "frame_00007.png"];
        let others = [
            "frame_00009.png",
            "frame_100000.png",
            "frame_7.png",
            "frame_00008.jpg",
            "frame_.png",
            "notes_00009.png",
        ];
        for name in names.iter().chain(&others) {
            std::fs::write(folder.path().join(name), b"x").expect("written");
        }
        let counted = earlier_frames(folder.path()).unwrap_or(0);
        let (later, strange) = later_frames(folder.path(), 2, counted).expect("a folder");
        assert_eq!((later.len(), strange), (0, 3), "no report counts them");
        let report = folder.path().join("report.json");
        std::fs::write(&report, r#"{"version": "1", "fps": 5, "frames": 8}"#).expect("written");
        let counted = earlier_frames(folder.path()).unwrap_or(0);
        let (later, strange) = later_frames(folder.path(), 2, counted).expect("a folder");
        assert_eq!((remove(&later).expect("removed"), strange), (1, 2));
        for name in names[..2].iter().chain(&others) {
            assert!(folder.path().join(name).exists(), "{name}");
        }
    }

    #[test]
    fn what_an_earlier_run_said_is_forgotten() {
        let folder = tempfile::tempdir().expect("a folder");
        forget_earlier_run(folder.path()).expect("nothing there");
        for name in ["trace.csv", "report.json", "notes.txt"] {
            std::fs::write(folder.path().join(name), b"x").expect("written");
        }
        forget_earlier_run(folder.path()).expect("removed");
        let left = std::fs::read_dir(folder.path()).expect("a folder");
        assert_eq!(left.count(), 1);
    }

    #[test]
    fn only_a_report_of_the_program_counts() {
        let folder = tempfile::tempdir().expect("a folder");
        let film = folder.path().join("frame_00000.png");
        std::fs::write(&film, b"mine").expect("written");
        for report in ["garbage", r#"{"frames": 1000}"#, "", r#"{"frames": "x"}"#] {
            std::fs::write(folder.path().join(REPORT), report).expect("written");
            let error = FrameFolder::take(folder.path()).expect_err(report);
            assert!(error.reason.contains("no report"), "{error}");
            assert_eq!(std::fs::read(&film).expect("there"), b"mine");
        }
    }

    #[test]
    fn a_run_that_was_stopped_knows_what_it_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let report = |frames: u64, left: u64| {
            let text = format!(
                r#"{{"version": "1", "fps": 2.0, "frames": {frames}, "left_frames": {left}}}"#
            );
            std::fs::write(folder.path().join(REPORT), text).expect("written");
        };
        let run = |frames: u64, is_whole: bool| {
            let mut into = FrameFolder::take(folder.path()).expect("ours");
            for frame in 0..frames {
                into.put(frame, b"x").expect("written");
            }
            into.end(frames, is_whole).expect("ended")
        };
        assert_eq!(run(7, true).left, 0);
        report(7, 0);
        let stopped = run(3, false);
        assert_eq!((stopped.removed, stopped.left), (0, 4));
        assert_eq!(stopped.removal(folder.path(), true), None);
        assert_eq!(stopped.reach, 4);
        report(3, stopped.reach);
        let after = run(2, true);
        assert_eq!((after.removed, after.left, after.strange), (5, 0, 0));
        let removal = after.removal(folder.path(), true).expect("a sentence");
        assert!(
            removal.contains("its frames beyond these (5) were removed"),
            "{removal}"
        );
    }
}
