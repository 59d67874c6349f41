//! Reads texts that people write (scene files, camera paths, maps of G-buffers, manifests of methods) within a limit of
//! size. Errors name the line.

use super::encoding;
use serde::de::DeserializeOwned;
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue, Deserializer};

/// The largest file of a scene or of a camera path that can be read, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// Greatest number of unknown keys that one error names.
const MOST_UNKNOWN_KEYS: usize = 32;

/// A text with its path, for errors that name the line.
#[derive(Clone, Copy)]
pub struct SourceText<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Contents of the file.
    pub text: &'a str,
}

impl SourceText<'_> {
    /// Makes an error at a byte range of the text.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> Error {
        Error::malformed(self.path, Some(self.line(span)), message)
    }

    /// Returns the line, from 1, in which a byte range begins.
    pub fn line(&self, span: Range<usize>) -> usize {
        line_of(self.text.as_bytes(), span.start)
    }

    /// Parses the text as TOML to a value of the type `T`.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line. One error names all unknown keys, and the first other fault.
    pub fn deserialized<T: DeserializeOwned>(&self) -> Result<T> {
        let mut table = DeTable::parse(self.text).map_err(|e| self.syntax_error(&e))?;
        let mut errors: Vec<toml::de::Error> = Vec::new();
        loop {
            let error = match T::deserialize(Deserializer::from(table.clone())) {
                Ok(value) if errors.is_empty() => return Ok(value),
                Ok(_) => break,
                Err(error) => error,
            };
            // An unknown key is removed, and the rest is read again, to find further faults.
            let is_removed =
                names_unknown_key(&error) && error.span().is_some_and(|span| remove_key(table.get_mut(), &span));
            errors.push(error);
            if !is_removed || errors.len() == MOST_UNKNOWN_KEYS {
                break;
            }
        }
        Err(self.joined_error(&mut errors))
    }

    /// Joins several errors into one, at the line of the first. Errors about unknown keys come first, in the order of
    /// the text.
    fn joined_error(&self, errors: &mut [toml::de::Error]) -> Error {
        errors.sort_by_key(|e| (!names_unknown_key(e), e.span().map_or(0, |span| span.start)));
        let [first, others @ ..] = errors else { return Error::malformed(self.path, None, "cannot be read") };
        let clause_with_line = |e: &toml::de::Error| {
            let line = e.span().map_or(String::new(), |span| format!("line {}: ", self.line(span)));
            format!("; {line}{}", clause(e))
        };
        self.error_like(first, clause(first) + &others.iter().map(clause_with_line).collect::<String>())
    }

    /// Makes an error about the syntax or the types of this TOML text.
    pub fn syntax_error(&self, error: &toml::de::Error) -> Error {
        self.error_like(error, clause(error))
    }

    /// Makes an error with the text `message` in the line of `error`, if that line is known.
    fn error_like(&self, error: &toml::de::Error, message: String) -> Error {
        Error::malformed(self.path, error.span().map(|span| self.line(span)), message)
    }
}

/// Returns true if an error is about a key that is not allowed in its table.
fn names_unknown_key(error: &toml::de::Error) -> bool {
    error.message().starts_with("unknown field")
}

/// Returns the message of an error, in one line.
fn clause(error: &toml::de::Error) -> String {
    error.message().trim().replace('\n', "; ")
}

/// Removes the key at the byte range `span` of the text from `table`, or from a table within it. Returns false if no
/// key is there.
fn remove_key(table: &mut DeTable, span: &Range<usize>) -> bool {
    let found = table.iter().find(|(key, _)| key.span() == *span).map(|(key, _)| key.get_ref().to_string());
    if let Some(key) = found {
        return table.remove(key.as_str()).is_some();
    }
    table.iter_mut().any(|(_, value)| remove_key_within(value.get_mut(), span))
}

/// Removes the key at the byte range `span` of the text from the tables within a value. Returns false if no key is
/// there.
fn remove_key_within(value: &mut DeValue, span: &Range<usize>) -> bool {
    match value {
        DeValue::Table(table) => remove_key(table, span),
        DeValue::Array(items) => items.iter_mut().any(|value| remove_key_within(value.get_mut(), span)),
        _ => false,
    }
}

/// Reads a text of at most `max_bytes` bytes, without its byte-order mark. `content` names the expected content in
/// errors, as in "a scene file".
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] for a longer text, and, with the line, for a text
/// that is not UTF-8.
pub fn read(path: &Path, content: &str, max_bytes: u64) -> Result<String> {
    let bytes = bounded::read(path, content, max_bytes)?;
    if let Some(name) = encoding::wide_encoding(&bytes) {
        return Err(Error::malformed(path, None, format!("is {name} text; save it as UTF-8")));
    }
    String::from_utf8(encoding::without_mark(&bytes).to_vec()).map_err(|e| {
        let line = line_of(e.as_bytes(), e.utf8_error().valid_up_to());
        Error::malformed(path, Some(line), format!("{content} must be UTF-8 text"))
    })
}

/// Reads the text of a program like [`read`]. A text that is not UTF-8 is read as Latin-1, since comments in programs
/// may have any bytes.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] for a longer text, and for a text in UTF-16 or
/// UTF-32.
pub fn read_program(path: &Path, content: &str, max_bytes: u64) -> Result<String> {
    let bytes = bounded::read(path, content, max_bytes)?;
    decode(path, &bytes).map(Cow::into_owned)
}

/// Decodes a text, and leaves out its byte-order mark. A text that is not UTF-8 is read as Latin-1, so that different
/// names in it stay different. `path` names the file in errors.
///
/// # Errors
/// [`Error::Malformed`] for a text in UTF-16 or UTF-32.
pub(super) fn decode<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    if let Some(name) = encoding::wide_encoding(bytes) {
        return Err(Error::malformed(path, None, format!("is {name} text; save it as UTF-8")));
    }
    let bytes = encoding::without_mark(bytes);
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
    })
}

/// Returns the line, counted from 1, of the byte at an offset.
fn line_of(text: &[u8], offset: usize) -> usize {
    1 + text[..offset.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// Returns the name of a file without its folder and without `.scene.toml` or `.toml`.
pub fn stem(path: &Path) -> String {
    let name = PathBuf::from(path.file_stem().unwrap_or_default());
    let stem =
        if name.extension().is_some_and(|extension| extension == "scene") { name.with_extension("") } else { name };
    stem.to_string_lossy().into_owned()
}
