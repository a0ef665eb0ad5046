//! Files that are either whole or not there.

use std::fs;
use std::io::{self, Seek, Write};
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
    if fs::metadata(folder).is_ok_and(|found| !found.is_dir()) {
        return Err(WriteError {
            path: folder.display().to_string(),
            reason: "it is a file, not a folder".into(),
        });
    }
    fs::create_dir_all(folder).map_err(|error| match error.kind() {
        io::ErrorKind::NotADirectory => WriteError {
            path: folder.display().to_string(),
            reason: "a part of its path is a file, not a folder".into(),
        },
        _ => refused(folder)(error),
    })?;
    let probe = folder.join(".ocularium-probe");
    fs::write(&probe, b"").map_err(refused(folder))?;
    fs::remove_file(&probe).map_err(refused(folder))
}

/// The right to write into a folder, until it is dropped; another run of the program is refused.
///
/// The system lets go of it when the program ends, however that happens.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    held: fs::File,
    /// Where a run was killed that wrote into it: how many of its files it had noted.
    pub left: Option<u64>,
}

impl FolderLock {
    /// Takes the folder.
    ///
    /// # Errors
    /// Where another run writes into it, or nothing can be written.
    pub fn take(folder: &Path) -> Result<Self, WriteError> {
        let path = folder.join(".ocularium-lock");
        let left = fs::read_to_string(&path).ok();
        let left = left.map(|count| count.trim().parse().unwrap_or(0));
        // What another run has noted in it stays.
        let file = fs::OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(refused(&path))?;
        match file.try_lock() {
            Ok(()) => Ok(Self {
                path,
                held: file,
                left,
            }),
            Err(fs::TryLockError::WouldBlock) => Err(WriteError {
                path: folder.display().to_string(),
                reason: "another run is writing into this folder; choose another with --out".into(),
            }),
            // A file system without locks is no reason not to write.
            Err(fs::TryLockError::Error(_)) => Ok(Self {
                path,
                held: file,
                left,
            }),
        }
    }
}

impl FolderLock {
    /// Notes how many files have been written, for the run after one that is killed.
    ///
    /// # Errors
    /// The system's.
    pub fn note(&mut self, files: u64) -> Result<(), WriteError> {
        let noted = self
            .held
            .rewind()
            .and_then(|()| write!(self.held, "{files:020}"));
        noted.map_err(refused(&self.path))
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Whether it is there or not, it locks nobody out.
        let _ = fs::remove_file(&self.path);
    }
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
    fn a_folder_belongs_to_one_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let lock = FolderLock::take(folder.path()).expect("free");
        let error = FolderLock::take(folder.path())
            .expect_err("taken")
            .to_string();
        assert!(error.contains("another run"), "{error}");
        assert_eq!(lock.left, None);
        drop(lock);
        drop(FolderLock::take(folder.path()).expect("free again"));
        // What a killed run leaves.
        let mut killed = FolderLock::take(folder.path()).expect("free");
        for files in [9, 10] {
            killed.note(files).expect("noted");
        }
        let note = fs::read(folder.path().join(".ocularium-lock")).expect("a note");
        drop(killed);
        fs::write(folder.path().join(".ocularium-lock"), note).expect("written");
        let next = FolderLock::take(folder.path()).expect("free");
        assert_eq!(next.left, Some(10));
        drop(next);
        assert_eq!(fs::read_dir(folder.path()).expect("list").count(), 0);
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
        let error = prepare_folder(&file).expect_err("refused").to_string();
        assert!(error.ends_with("it is a file, not a folder"), "{error}");
    }
}
