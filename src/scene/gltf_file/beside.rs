//! What lies outside a glTF file's own text: inline data, files beside it, its binary part.

use super::super::model::SceneError;
use super::super::photo::read_named_file;
use super::malformed;
use crate::input_file::one_clause;
use gltf::{Document, buffer};
use percent_encoding::percent_decode_str;
use std::path::Path;

/// Where the files are that a glTF file names.
#[derive(Clone, Copy, Debug)]
pub enum Beside<'a> {
    /// In this folder.
    Folder(&'a Path),
    /// Among these, by name: what was dropped or chosen together with it.
    Files(&'a [(String, Vec<u8>)]),
}

impl Beside<'_> {
    /// The bytes behind a URI of the file `name`; sentences call what is wanted `kind`.
    pub(super) fn read(
        &self,
        uri: &str,
        name: &str,
        kind: &'static str,
    ) -> Result<Vec<u8>, SceneError> {
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
            let decoded = encoded.and_then(base64_decode);
            return decoded
                .ok_or_else(|| malformed(name, format!("an inline {kind} is not valid base64")));
        }
        if uri.contains("://") {
            return Err(malformed(
                name,
                format!(
                    "it refers to \"{}\", but only files beside it are read",
                    one_clause(&uri)
                ),
            ));
        }
        let wanted = percent_decode_str(uri).decode_utf8_lossy();
        match self {
            Self::Folder(folder) if folder.join(&*wanted).exists() => {
                read_named_file(&folder.join(&*wanted), kind)
            }
            Self::Files(files) => {
                // A folder that was chosen file by file has lost its subfolders.
                let last = |path: &str| path.rsplit(['/', '\\']).next().map(str::to_owned);
                let found = files.iter().find(|(name, _)| last(name) == last(&wanted));
                found.map(|(_, bytes)| bytes.clone()).ok_or_else(|| {
                    malformed(
                        name,
                        format!(
                            "its {kind} \"{}\" was not chosen with it: choose or drop them together",
                            one_clause(&wanted)
                        ),
                    )
                })
            }
            Self::Folder(_) => Err(malformed(
                name,
                format!("its {kind} \"{}\" is not beside it", one_clause(&wanted)),
            )),
        }
    }
}

/// All buffers of a document; `blob` is the binary part of a GLB file.
pub(super) fn read_buffers(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    name: &str,
    beside: Beside,
) -> Result<Vec<buffer::Data>, SceneError> {
    let read = |buffer: gltf::Buffer| {
        let bytes = match buffer.source() {
            buffer::Source::Bin => blob
                .take()
                .ok_or_else(|| malformed(name, "its binary part is missing"))?,
            buffer::Source::Uri(uri) => beside.read(uri, name, "buffer file")?,
        };
        // A binary part may be up to three bytes longer or, as some write it, shorter.
        if bytes.len().next_multiple_of(4) < buffer.length() {
            return Err(malformed(
                name,
                format!(
                    "its buffer {} has {} bytes, of {} announced",
                    buffer.index(),
                    bytes.len(),
                    buffer.length()
                ),
            ));
        }
        Ok(buffer::Data(bytes))
    };
    document.buffers().map(read).collect()
}

/// RFC 4648, section 4; white space is not allowed.
fn base64_decode(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(digits.len() * 3 / 4);
    let (mut bits, mut count) = (0u32, 0);
    for &digit in digits {
        let value = match digit {
            b'A'..=b'Z' => digit - b'A',
            b'a'..=b'z' => digit - b'a' + 26,
            b'0'..=b'9' => digit - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_meets_the_vectors_of_rfc_4648() {
        for (text, plain) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(base64_decode(text).unwrap(), plain.as_bytes());
        }
        assert_eq!(base64_decode("Zm9*"), None);
    }

    #[test]
    fn a_named_file_is_found_among_those_that_came_with_it() {
        let files = [("some/a bé.bin".to_owned(), vec![1, 2, 3])];
        let read = |uri: &str| Beside::Files(&files).read(uri, "x.gltf", "buffer file");
        assert_eq!(read("parts/a%20b%C3%A9.bin").expect("found"), [1, 2, 3]);
        assert_eq!(read("data:;base64,Zm8=").expect("inline"), b"fo");
        for (uri, part) in [
            ("b.bin", "was not chosen with it"),
            ("https://example.org/b.bin", "only files beside it"),
            ("data:,text", "base64"),
        ] {
            let sentence = read(uri).expect_err(uri).to_string();
            assert!(
                sentence.contains(part) && sentence.contains("x.gltf"),
                "{sentence}"
            );
        }
    }
}
