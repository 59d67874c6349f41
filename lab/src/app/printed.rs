//! Standard output. Everything that a command prints goes through here, so that no name of a file, a scene or a shard is
//! obeyed by a terminal.

use crate::study::names::{is_obeyed_in_lines, without_obeyed};
use std::io::{Result, StdoutLock, Write};

/// Standard output, without characters that a terminal obeys.
pub struct PrintableOutput(StdoutLock<'static>);

/// Locks standard output. What is written to it loses the characters that a terminal obeys.
pub fn out() -> PrintableOutput {
    PrintableOutput(std::io::stdout().lock())
}

impl Write for PrintableOutput {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        // Texts come whole, each with the characters that it begins.
        let text = String::from_utf8_lossy(bytes);
        self.0.write_all(without_obeyed(&text, is_obeyed_in_lines).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.0.flush()
    }
}

/// Prints a value as JSON and ends the line. Characters that a terminal obeys are written by their numbers, so that
/// nothing is lost.
///
/// # Errors
/// Errors of standard output.
pub fn json(value: &serde_json::Value) -> Result<()> {
    writeln!(out(), "{}", crate::study::names::json_text(&value.to_string()))
}
