//! Recognises the encodings of texts from other programs: byte-order marks, and units of 16 or 32 bits.

/// The byte-order mark of UTF-8, which some editors write before a text.
const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Strips the byte-order mark of UTF-8 from the start of a text; a text without the mark is returned unchanged.
pub(super) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(UTF8_MARK).unwrap_or(text)
}

/// Returns the name of the encoding of a text in UTF-16 or UTF-32; `None` for any other text, such as UTF-8.
///
/// A text in UTF-16 or UTF-32 begins with a byte-order mark, or its first bytes alternate with zeros, since the first
/// characters of every format that is read here are ASCII.
pub(super) fn wide_encoding(text: &[u8]) -> Option<&'static str> {
    match *text {
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] => Some("UTF-32"),
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("UTF-16"),
        [0, 0, 0, first, ..] | [first, 0, 0, 0, ..] if first != 0 => Some("UTF-32"),
        [0, first, 0, second, ..] | [first, 0, second, 0, ..] if first != 0 && second != 0 => Some("UTF-16"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart_by_their_first_bytes() {
        let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        let utf32 = |text: &str| text.chars().flat_map(|c| (c as u32).to_be_bytes()).collect::<Vec<u8>>();
        for (text, name) in [
            (utf16("\u{feff}v 0"), Some("UTF-16")),
            (utf16("v 0"), Some("UTF-16")),
            (utf32("v 0"), Some("UTF-32")),
            (utf32("\u{feff}v"), Some("UTF-32")),
            (b"v 0 0 0".to_vec(), None),
            ("\u{feff}v 0 0".as_bytes().to_vec(), None),
            (vec![0; 8], None),
            (Vec::new(), None),
        ] {
            assert_eq!(wide_encoding(&text), name, "{text:?}");
        }
        assert_eq!(without_mark("\u{feff}v 0".as_bytes()), b"v 0");
        assert_eq!(without_mark(b"v 0"), b"v 0");
    }
}
