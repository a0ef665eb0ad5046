//! Files that are either whole or not there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file or folder that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {reason}")]
pub struct WriteError {
    /// What was to be written.
    pub path: String,
    /// What the system said.
    pub reason: String,
}

fn refused(path: &Path) -> impl Fn(io::Error) -> WriteError {
    let path = path.display().to_string();
    move |error| WriteError {
        path: path.clone(),
        reason: error.to_string(),
    }
}

/// Makes a folder that can be written to, before any work is spent on what goes into it.
pub fn prepare_folder(folder: &Path) -> Result<(), WriteError> {
    fs::create_dir_all(folder).map_err(refused(folder))?;
    let probe = folder.join(".ocularium-probe");
    fs::write(&probe, b"").map_err(refused(folder))?;
    fs::remove_file(&probe).map_err(refused(folder))
}

/// Writes a file beside its place and moves it there, so that nobody ever sees half of it.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".partial");
    let partial: PathBuf = path.with_file_name(name);
    let result = fs::write(&partial, bytes).and_then(|()| fs::rename(&partial, path));
    if result.is_err() {
        // What cannot be written may not be removable either; the first error is the one to tell.
        let _ = fs::remove_file(&partial);
    }
    result.map_err(refused(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_leaves_no_part() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_whole(&path, b"one").expect("written");
        write_whole(&path, b"two").expect("written");
        assert_eq!(fs::read(&path).expect("read"), b"two");
        assert_eq!(fs::read_dir(folder.path()).expect("list").count(), 1);
    }

    #[test]
    fn a_folder_below_a_file_is_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, b"x").expect("written");
        let error = prepare_folder(&file.join("out"))
            .expect_err("refused")
            .to_string();
        assert!(error.contains("file/out"), "{error}");
    }
}
