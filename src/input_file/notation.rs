//! Text in RON that a user wrote.
//!
//! Enters: the text. Leaves: what it says, or where and in which field it cannot be read, and what
//! stands there.

use super::one_clause;
use ron::error::Error;
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;

/// Most characters of a value that a sentence quotes.
const MOST_QUOTED: usize = 60;

/// Why a text could not be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// The field, from the outside in; places of a list count from 1.
    pub path: Vec<String>,
    /// What is wrong there.
    pub kind: FaultKind,
}

/// What is wrong in a text.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// There is no field of this name.
    UnknownField {
        /// The name.
        found: String,
        /// Those that there are.
        known: &'static [&'static str],
    },
    /// A field has not one of the words that it may have.
    UnknownWord {
        /// What stands there.
        found: String,
        /// The words.
        known: &'static [&'static str],
    },
    /// A field has a value of another kind than it may have.
    Value {
        /// What stands there; empty where it ends before that.
        found: String,
    },
    /// A field is given twice.
    Twice {
        /// Its name.
        field: &'static str,
    },
    /// A field that has no default is not given.
    Missing {
        /// Its name.
        field: &'static str,
    },
    /// It is not RON, as a clause.
    Notation(String),
}

impl Fault {
    /// The field as a user writes it, as in `left.cataract.nuclear`; empty for the whole.
    pub fn field(&self) -> String {
        let mut name = String::new();
        for part in &self.path {
            if !name.is_empty() && !part.starts_with('[') {
                name.push('.');
            }
            name.push_str(part);
        }
        name
    }
}

/// What is said of a field that holds what it must not.
pub fn not_allowed(field: &str, value: &str, allowed: &str) -> String {
    if value.is_empty() {
        format!("{field} has no value; it must be {allowed}")
    } else {
        format!("{field} = {value} is not allowed; it must be {allowed}")
    }
}

/// Names in their order, as in "a, b or c".
pub fn one_of(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).into(),
        [some @ .., last] => format!("{} or {last}", some.join(", ")),
    }
}

/// Reads a value; optional ones stand without `Some`.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, Fault> {
    // Some editors begin a file with this mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let mut reader = ron::Deserializer::from_str_with_options(text, &options)
        .map_err(|error| fault(text, &[], error))?;
    match serde_path_to_error::deserialize(&mut reader) {
        Ok(value) => match reader.end() {
            Ok(()) => Ok(value),
            Err(error) => Err(fault(text, &[], reader.span_error(error))),
        },
        Err(error) => {
            let path: Vec<String> = error.path().iter().filter_map(name_of).collect();
            let error = reader.span_error(error.into_inner());
            Err(fault(text, &path, error))
        }
    }
}

fn name_of(segment: &Segment) -> Option<String> {
    match segment {
        Segment::Seq { index } => Some(format!("[{}]", index + 1)),
        Segment::Map { key } => Some(key.clone()),
        // A word such as `Fixed` in front of a value.
        Segment::Enum { variant } => Some(variant.clone()),
        Segment::Unknown => None,
    }
}

fn fault(text: &str, path: &[String], error: ron::error::SpannedError) -> Fault {
    let from = byte_of(text, error.span.start.line, error.span.start.col);
    let mut at = byte_of(text, error.span.end.line, error.span.end.col);
    let mut path = path.to_vec();
    let kind = match error.code {
        Error::NoSuchStructField {
            expected, found, ..
        } => {
            if path.last() == Some(&found) {
                path.pop();
            }
            at = text[..at].rfind(&found).unwrap_or(at);
            FaultKind::UnknownField {
                found: one_clause(&found),
                known: expected,
            }
        }
        Error::NoSuchEnumVariant {
            expected, found, ..
        } => {
            if path.last() == Some(&found) {
                path.pop();
            }
            at = text[..at].rfind(&found).unwrap_or(at);
            FaultKind::UnknownWord {
                found: one_clause(&found),
                known: expected,
            }
        }
        Error::DuplicateStructField { field, .. } => {
            if path.last().is_some_and(|last| last == field) {
                path.pop();
            }
            FaultKind::Twice { field }
        }
        Error::MissingStructField { field, .. } => FaultKind::Missing { field },
        // A whole number's field reads 1.5 as 1 and what does not belong there.
        Error::ExpectedComma if runs_on(text, at) => {
            path = key_before(text, at).into_iter().collect();
            let (start, found) = value_before(text, at, &path);
            at = start;
            FaultKind::Value { found }
        }
        _ if let Some(comma) = decimal_comma(text, from, at) => {
            at = comma;
            path = Vec::new();
            FaultKind::Notation("a number has a decimal point, as in 1.5, not a comma".into())
        }
        code => match notation(&code, text).or_else(|| misplaced(&code, &text[..from])) {
            Some(clause) => FaultKind::Notation(clause),
            None => {
                let (start, found) = value_before(text, at, &path);
                at = start;
                FaultKind::Value { found }
            }
        },
    };
    let (line, column) = place_of(text, at);
    Fault {
        line,
        column,
        path,
        kind,
    }
}

/// What makes a text no RON; `None` where a value is merely of another kind than wanted.
fn notation(code: &Error, text: &str) -> Option<String> {
    let ends = |what: &str| Some(format!("the text ends before {what}"));
    match code {
        Error::Eof => ends("all its brackets are closed"),
        Error::ExpectedStringEnd => ends("a quotation mark is closed"),
        Error::UnclosedBlockComment => ends("a comment /* is closed by */"),
        Error::ExpectedComma => {
            Some("a comma is missing before this, or a bracket does not belong here".into())
        }
        Error::ExpectedMapColon => Some("a colon is missing after a field's name".into()),
        Error::TrailingCharacters => {
            Some("something follows the bracket that closes the whole".into())
        }
        Error::NoSuchExtension(name) => Some(format!("there is no extension {name:?} of RON")),
        Error::InvalidEscape(_) => Some("a \\ in a text begins nothing that is known".into()),
        Error::UnexpectedChar(found) => {
            Some(format!("the character {found:?} does not belong here"))
        }
        Error::ExceededRecursionLimit => Some("its brackets are nested too deep".into()),
        Error::ExpectedAttribute | Error::ExpectedAttributeEnd => {
            Some("only #![enable(…)] may begin with #".into())
        }
        _ if text.trim().is_empty() => Some("it is empty".into()),
        _ => None,
    }
}

/// A comma between two digits next to a fault, where a field's name would follow it.
fn decimal_comma(text: &str, from: usize, at: usize) -> Option<usize> {
    let near = text[..at.max(from)].rfind(',')?;
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let name_expected = text[near + 1..at.max(from)]
        .chars()
        .all(|c| c.is_ascii_digit());
    let before = text[..near].chars().next_back();
    let after = text[near + 1..].chars().next();
    // In a pair a comma stands between numbers.
    let opened = text[..near].rfind(['(', '[', ':'])?;
    (name_expected && is_digit(before) && is_digit(after) && text[opened..].starts_with(':'))
        .then_some(near)
}

/// A name that is not there, told from what stands before the fault.
fn misplaced(code: &Error, before: &str) -> Option<String> {
    let behind = before.trim_end().chars().next_back();
    (matches!(
        code,
        Error::ExpectedIdentifier | Error::InvalidIdentifier(_) | Error::SuggestRawIdentifier(_)
    ) && matches!(behind, Some('(' | ',')))
    .then(|| "a field's name is expected here, as in age_years: 40".into())
}

/// Does a value go on at this byte, of which only the beginning was taken?
fn runs_on(text: &str, at: usize) -> bool {
    let belongs = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || "._+-".contains(c));
    belongs(text[..at].chars().next_back()) && belongs(text[at..].chars().next())
}

/// The name of the field whose value ends before this byte.
fn key_before(text: &str, at: usize) -> Option<String> {
    let name = text[..at].rsplit_once(':')?.0.trim_end();
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let start = name.rfind(|c| !is_part(c)).map_or(0, |end| end + 1);
    name.get(start..).map(str::to_owned)
}

/// Where the value of the field at `path` begins that ends near the byte `at`, and what it is.
fn value_before(text: &str, at: usize, path: &[String]) -> (usize, String) {
    let name = path.iter().rev().find(|part| !part.starts_with('['));
    let Some(name) = name else {
        let start = text.len() - text.trim_start().len();
        return (start, one_value(&text[start..], false));
    };
    // The name with a value behind it: a value may hold the name again.
    let is_key = |key: &usize| {
        let rest = text[key + name.len()..].trim_start();
        rest.starts_with([':', '('])
    };
    let mut keys = text[..at].rmatch_indices(name.as_str()).map(|(key, _)| key);
    let last = text[..at].rfind(name.as_str());
    let Some(key) = keys.find(is_key).or(last) else {
        return (at, String::new());
    };
    let behind = key + name.len();
    let rest = text[behind..].trim_start();
    let Some(value) = rest.strip_prefix([':', '(']) else {
        // Nothing is given.
        return (behind, String::new());
    };
    let value = value.trim_start();
    let start = text.len() - value.len();
    (start, one_value(value, rest.starts_with('(')))
}

/// The value that a text begins with, up to the comma or bracket behind it; of what stands in a word's
/// brackets all.
fn one_value(text: &str, in_brackets: bool) -> String {
    let (mut depth, mut quoted, mut escaped) = (0, false, false);
    let end = text.find(|c: char| {
        if quoted {
            quoted = escaped || c != '"';
            escaped = c == '\\' && !escaped;
            return false;
        }
        match c {
            '"' => quoted = true,
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth == 0 => return true,
            ')' | ']' | '}' => depth -= 1,
            ',' => return depth == 0 && !in_brackets,
            _ => {}
        }
        false
    });
    let value = one_clause(&text[..end.unwrap_or(text.len())].trim());
    match value.char_indices().nth(MOST_QUOTED) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value,
    }
}

/// The byte at a line and column, both from 1.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let lines = text.split_inclusive('\n').take(line.saturating_sub(1));
    let start: usize = lines.map(str::len).sum();
    let rest = &text[start..];
    let beside = rest.char_indices().nth(column.saturating_sub(1));
    start + beside.map_or(rest.len(), |(offset, _)| offset)
}

fn place_of(text: &str, at: usize) -> (usize, usize) {
    let before = &text[..at];
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    (
        before.matches('\n').count() + 1,
        before[start..].chars().count() + 1,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields, default)]
    struct Outer {
        number: f64,
        whole: u64,
        word: Word,
        pair: [f64; 2],
        text: String,
        maybe: Option<f64>,
        inner: Option<Inner>,
        list: Vec<Inner>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        depth: f64,
    }

    #[derive(Debug, Default, Deserialize, PartialEq)]
    enum Word {
        #[default]
        One,
        Two(f64),
    }

    fn said(text: &str) -> (String, FaultKind, (usize, usize)) {
        let fault = read::<Outer>(text).expect_err(text);
        (fault.field(), fault.kind, (fault.line, fault.column))
    }

    #[test]
    fn a_value_of_another_kind_is_quoted_with_its_field() {
        for (text, field, found, place) in [
            ("(number: \"old\")", "number", "\"old\"", (1, 10)),
            ("(\n  number: old, whole: 2)", "number", "old", (2, 11)),
            ("(whole: -1)", "whole", "-1", (1, 9)),
            ("(whole: 1.5)", "whole", "1.5", (1, 9)),
            ("(pair: 2.0)", "pair", "2.0", (1, 8)),
            (
                "(pair: (2.0, \"x, )\"))",
                "pair[2]",
                "(2.0, \"x, )\")",
                (1, 8),
            ),
            ("(text: Ann)", "text", "Ann", (1, 8)),
            ("(maybe: yes)", "maybe", "yes", (1, 9)),
            ("(inner: (depth: none))", "inner.depth", "none", (1, 17)),
            ("(inner: 3)", "inner", "3", (1, 9)),
            (
                "(list: [(depth: 1), (depth: []) ])",
                "list[2].depth",
                "[]",
                (1, 29),
            ),
            ("(word: Two(x))", "word.Two", "x", (1, 12)),
            ("(word: Two(1, 2))", "word.Two", "1, 2", (1, 12)),
            ("(word: Two)", "word.Two", "", (1, 11)),
            ("(number: )", "number", "", (1, 10)),
            ("(number: number)", "number", "number", (1, 10)),
        ] {
            let found = FaultKind::Value {
                found: found.into(),
            };
            assert_eq!(said(text), (field.into(), found, place), "{text}");
        }
    }

    #[test]
    fn names_that_are_not_known_come_with_those_that_are() {
        let (field, kind, place) = said("(inner: (deep: 1.0))");
        assert_eq!((&*field, place), ("inner", (1, 10)));
        let FaultKind::UnknownField { found, known } = kind else {
            panic!("{kind:?}");
        };
        assert_eq!((&*found, known), ("deep", &["depth"][..]));
        let (field, kind, _) = said("(word: Three)");
        assert_eq!(field, "word");
        let FaultKind::UnknownWord { found, known } = kind else {
            panic!("{kind:?}");
        };
        assert_eq!((&*found, known), ("Three", &["One", "Two"][..]));
        let (_, kind, _) = said(&format!("({}: 1.0)", "x".repeat(5000)));
        let FaultKind::UnknownField { found, .. } = kind else {
            panic!("{kind:?}");
        };
        assert!(found.chars().count() <= 201);
    }

    #[test]
    fn what_is_missing_or_twice_is_named() {
        assert_eq!(said("(inner: ())").1, FaultKind::Missing { field: "depth" });
        assert_eq!(said("(inner: ())").0, "inner");
        assert_eq!(
            said("(number: 1.0, number: 2.0)").1,
            FaultKind::Twice { field: "number" }
        );
    }

    #[test]
    fn what_is_no_ron_is_said_in_words() {
        for (text, part) in [
            ("(number: 1.0", "bracket"),
            ("(number: 1.0 whole: 2)", "comma"),
            ("(number: 1,5)", "decimal point"),
            ("(inner: (depth: 3,0))", "decimal point"),
            ("(list: [(depth: 1,5)])", "decimal point"),
            ("(\"number\": 1.0)", "name is expected"),
            ("(number: 1.0,,)", "name is expected"),
            ("(,)", "name is expected"),
            ("(1.0)", "name is expected"),
            ("(number 1.0)", "colon"),
            ("(number: 1.0) x", "follows"),
            ("(text: \"abc", "quotation mark"),
            ("", "empty"),
            ("(number: 1.0 /* x", "*/"),
        ] {
            let (_, kind, _) = said(text);
            let FaultKind::Notation(clause) = kind else {
                panic!("{text}: {kind:?}");
            };
            assert!(clause.contains(part), "{text}: {clause}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_text_makes_it_fail(
            text in "\\PC{0,60}",
            near in "\\((number|inner|list|word|眼): ?[^:]{0,12}[,)]? ?(whole: 1,5|ä|👁)?\\)?",
        ) {
            for text in [text, near] {
                if let Err(fault) = read::<Outer>(&text) {
                    proptest::prop_assert!(fault.line >= 1 && fault.column >= 1);
                    proptest::prop_assert!(fault.field().chars().count() < 500);
                }
            }
        }
    }

    #[test]
    fn sound_text_is_read() {
        let read = |text: &str| super::read::<Outer>(text).expect(text);
        assert_eq!(read("()"), Outer::default());
        assert_eq!(read("\u{feff}(maybe: 2.0)").maybe, Some(2.0));
        assert_eq!(read("(word: Two(3.0))").word, Word::Two(3.0));
    }
}
