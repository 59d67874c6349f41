//! Standard output. Every text that a command prints loses here the characters that a terminal would obey, which the name of a file, a
//! scene or a shard may contain.

use crate::study::names::{is_unsafe_in_lines, with_replacements};
use std::io::{Result, StdoutLock, Write};

/// Standard output, without characters that a terminal obeys.
pub struct PrintableOutput(StdoutLock<'static>);

/// Locks standard output. What is written to it loses the characters that a terminal obeys.
pub fn out() -> PrintableOutput {
    PrintableOutput(std::io::stdout().lock())
}

impl Write for PrintableOutput {
    /// Writes a whole text, from which the characters that a terminal obeys are removed. Returns the length of the text
    /// before that, as if all of it had been written.
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        // Texts are written in one piece, so that no character is split between two calls.
        let text = String::from_utf8_lossy(bytes);
        self.0.write_all(with_replacements(&text, is_unsafe_in_lines).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.0.flush()
    }
}

/// Prints a value as JSON and ends the line. Characters that a terminal obeys are escaped as numbers, so that nothing is lost.
pub fn json(value: &serde_json::Value) -> Result<()> {
    writeln!(out(), "{}", crate::study::names::json_text(&value.to_string()))
}
