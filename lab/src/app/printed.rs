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

/// Returns a text as one word of a command for a shell: between quotation marks if a shell would read it otherwise.
pub fn quote_word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:,=+%@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else if text.contains(['"', '$', '`', '\\', '!']) {
        // Nothing between apostrophes has a meaning, and an apostrophe itself stands outside them.
        format!("'{}'", text.replace('\'', r"'\''"))
    } else {
        format!("\"{text}\"")
    }
}

#[cfg(test)]
mod tests {
    use super::quote_word;

    #[test]
    fn words_are_quoted_where_a_shell_would_read_them_otherwise() {
        for (text, quoted) in [
            ("a/b.obj", "a/b.obj"),
            ("a room.obj", "\"a room.obj\""),
            ("it's.obj", "\"it's.obj\""),
            ("$5 o'clock.obj", r"'$5 o'\''clock.obj'"),
            ("", "\"\""),
        ] {
            assert_eq!(quote_word(text), quoted);
        }
    }
}
