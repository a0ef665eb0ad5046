//! Files that a user names.

use std::io::{Error, ErrorKind};
use std::path::Path;

/// Reads a whole file of at most `most` bytes. A folder, pipe or device is refused before it is opened:
/// a pipe may wait forever, a device may never end.
///
/// # Errors
/// The system's, or one of kind [`ErrorKind::InvalidInput`] whose text is a clause about the file.
pub fn read_input_file(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let refused = |reason: String| Error::new(ErrorKind::InvalidInput, reason);
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(refused("it is a folder, not a file".into()));
    }
    if !found.is_file() {
        return Err(refused("it is a pipe or a device, not a file".into()));
    }
    if found.len() > most {
        let bytes = found.len();
        return Err(refused(format!(
            "it has {bytes} bytes, but may have at most {most}"
        )));
    }
    std::fs::read(path)
}
