//! What the program says on a terminal, a line at a time.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

/// Writes a line; a reader that has gone away is no error.
pub(super) fn say(out: &mut impl Write, line: &str) -> std::io::Result<()> {
    match writeln!(out, "{line}") {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(unwritten(&error)),
        Ok(()) => Ok(()),
    }
}

/// Why standard output could not be written.
pub(super) fn unwritten(error: &std::io::Error) -> std::io::Error {
    std::io::Error::new(
        error.kind(),
        format!("cannot write standard output: {error}"),
    )
}

/// Says on stderr what went wrong or should be known.
pub(super) fn complain(sentence: &(impl Display + ?Sized)) {
    inform(&format!("ocularium: {sentence}"));
}

/// Says a sentence on stderr.
pub(super) fn inform(sentence: &str) {
    // Nobody can be told that nothing can be told; the exit status still says how it ended.
    let _ = writeln!(std::io::stderr(), "{}", one_line(sentence));
}

/// A sentence with its control characters spelt out, and those that turn the direction of writing. A
/// file's name may hold them: a terminal takes them for commands, a log for the end of the line, and a
/// reader for what is not there.
pub(super) fn one_line(sentence: &str) -> String {
    let mut line = String::with_capacity(sentence.len());
    for c in sentence.chars() {
        let turns = matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        );
        if c.is_control() || turns {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_is_one_line_without_commands() {
        assert_eq!(one_line("a\nb\u{1b}[31mc"), "a\\nb\\u{1b}[31mc");
        assert_eq!(one_line("gnp.\u{202e}a\u{2067}"), "gnp.\\u{202e}a\\u{2067}");
        assert_eq!(one_line("21° to “40°” é"), "21° to “40°” é");
    }
}
