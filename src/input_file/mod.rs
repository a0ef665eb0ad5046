//! Files that a user names.

pub mod notation;

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

/// Most characters of a library's message that a sentence quotes.
const MOST_QUOTED: usize = 200;

/// How libraries say that a file ends too soon.
const CUT_OFF: [&str; 3] = [
    "failed to fill whole buffer",
    "unexpected end of file",
    "could not completely read the object",
];

/// A library's message as part of a sentence: one short line, no full stop, no control characters.
pub fn one_clause(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    if CUT_OFF.contains(&text.trim_end_matches('.')) {
        return "it is cut off: it ends before all that it announces is there".into();
    }
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut quoted: String = line.chars().filter(|c| !c.is_control()).collect();
    if let Some((end, _)) = quoted.char_indices().nth(MOST_QUOTED) {
        quoted.truncate(end);
        quoted.push('…');
    }
    quoted.trim_end_matches(['.', ';', ' ']).to_owned()
}

/// The name that is most like another, if one is.
pub fn nearest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let found = found.to_lowercase();
    let alike = |name: &&str| strsim::jaro_winkler(&found, name);
    let best = known
        .iter()
        .copied()
        .max_by(|a, b| alike(a).total_cmp(&alike(b)))?;
    (alike(&best) > 0.86).then_some(best)
}

/// `; did you mean NAME?`, where one of the known names is like the found one.
pub fn did_you_mean(found: &str, known: &[&str]) -> String {
    nearest(found, known).map_or_else(String::new, |name| format!("; did you mean {name}?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_asked_for_that_is_like_what_was_found() {
        let known = ["healthy-blue", "healthy-brown", "glaucoma-early"];
        assert_eq!(nearest("helthy-blue", &known), Some("healthy-blue"));
        assert_eq!(nearest("Healthy_Brown", &known), Some("healthy-brown"));
        assert_eq!(nearest("zzz", &known), None);
        assert_eq!(nearest("", &known), None);
        assert_eq!(
            did_you_mean("glaucoma", &known),
            "; did you mean glaucoma-early?"
        );
        assert_eq!(did_you_mean("xyz", &[]), "");
    }
}
