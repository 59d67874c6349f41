//! Names of cells, roughness values and devices for pages and files, and texts of foreign origin made safe for each
//! place.

use sha2::{Digest, Sha256};
use ssct::gpu::DeviceInfo;
use std::borrow::Cow;

/// Name in records of the combination of the oracle's hits with the cone trace of the thesis.
pub const EXACT_HITS: &str = "exact-hits+cone";
/// Name in records of the screen reference, whose error against the world is measured; also the name of its picture.
pub const SCREEN_REFERENCE: &str = "screen-reference";

/// Returns the name of a cell, with which the names of its files begin.
pub fn cell_name(scene: &str, view: &str, [width, height]: [u32; 2], roughness: Option<f32>) -> String {
    let [scene, view] = [scene, view].map(safe_word);
    format!("{scene}-{view}-{width}x{height}-r{}", roughness_name(roughness))
}

/// Returns the name of a global roughness: the number, or "own" if the materials keep their roughness.
pub fn roughness_name(value: Option<f32>) -> String {
    value.map_or_else(|| "own".into(), |r| format!("{r}"))
}

/// Returns a number and the name of what is counted, such as "3 cells"; the name gets an s unless the number is 1.
pub fn count_text(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// Makes a short part of a file's name from the name that a user or a file gives to a scene, a view or a variant.
/// Separators of folders, and characters with a meaning in file systems, shell patterns or addresses of pages, are
/// replaced. A name that had to be changed ends in a digest of the original, so that different names stay different.
pub fn safe_word(name: &str) -> Cow<'_, str> {
    const MOST_BYTES: usize = 64;
    let is_safe = |c: char| !is_unsafe_in_line(c) && !r#"/\:*?"<>|%#"#.contains(c);
    if !name.is_empty() && name.len() <= MOST_BYTES && !name.starts_with('.') && name.chars().all(is_safe) {
        return name.into();
    }
    let mut word = String::new();
    for c in name.chars() {
        if word.len() + c.len_utf8() > MOST_BYTES {
            break;
        }
        word.push(if is_safe(c) && !(c == '.' && word.is_empty()) { c } else { '_' });
    }
    let digest = Sha256::digest(name.as_bytes());
    word.push('-');
    word.extend(digest.iter().take(4).map(|byte| format!("{byte:02x}")));
    word.into()
}

/// Whether a character is unsafe in a line of text, since programs obey it instead of showing it: a control character,
/// an end of a line, or a character that changes the direction of text.
pub fn is_unsafe_in_line(c: char) -> bool {
    let changes_direction = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let ends_line_or_paragraph = matches!(c, '\u{2028}' | '\u{2029}');
    c.is_control() || changes_direction || ends_line_or_paragraph
}

/// Whether a character is unsafe in a text of several lines, in which ends of lines and tabs are allowed.
pub fn is_unsafe_in_lines(c: char) -> bool {
    is_unsafe_in_line(c) && !matches!(c, '\n' | '\t')
}

/// Returns a text with the replacement character U+FFFD in the place of each unsafe character.
pub fn with_replacements(text: &str, is_unsafe: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_unsafe) {
        return text.into();
    }
    text.chars().map(|c| if is_unsafe(c) { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// Makes a name safe for one line of text: unsafe characters, such as ends of lines, are replaced by U+FFFD.
pub fn one_line(name: &str) -> Cow<'_, str> {
    with_replacements(name, is_unsafe_in_line)
}

/// Makes a text safe for a cell of a table in Markdown, on one line: no character of the text ends the cell, begins
/// HTML, or makes a link or an image.
pub fn markdown_cell(text: &str) -> String {
    let escaped = |c: char| match c {
        '<' => "&lt;".to_owned(),
        '|' | '`' | '[' | ']' => format!("\\{c}"),
        _ => c.to_string(),
    };
    one_line(text).chars().map(escaped).collect()
}

/// Makes a text safe for a cell of a CSV file, on one line, so that spreadsheet programs do not take it for a formula.
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    let is_formula = text.len() > 1 && text.starts_with(['=', '+', '-', '@']) && text.parse::<f64>().is_err();
    if is_formula { format!("'{}", one_line(text)).into() } else { one_line(text) }
}

/// Writes the unsafe characters of JSON as escapes. Such characters occur within strings alone, where the escapes mean
/// the same characters.
pub fn json_text(json: &str) -> String {
    let escaped = |c: char| {
        if is_unsafe_in_lines(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() }
    };
    json.chars().map(escaped).collect()
}

/// Returns the shortest name that tells a device from the other devices of a table. The name is the device's own; if
/// another device has the same name, the driver follows. If another device has the same name and driver, the version of
/// Vulkan and the kind of the device follow, too.
pub fn name_among(device: &DeviceInfo, others: &[&DeviceInfo]) -> String {
    let (name, driver) = (&device.name, &device.driver);
    let mut namesakes = others.iter().filter(|other| **other != device && other.name == *name).peekable();
    if namesakes.peek().is_none() {
        name.clone()
    } else if namesakes.all(|other| other.driver != *driver) {
        format!("{name} ({driver})")
    } else {
        format!("{name} ({driver}, Vulkan {}, {})", device.api, device.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn names_become_safe_words_of_file_names_and_stay_different() {
        for plain in ["exit sign", "Küche (Süd)", "front 2", "r0.4", "a-b_c"] {
            assert_eq!(safe_word(plain), plain);
        }
        let long = "x".repeat(400);
        let wide = "\u{30ab}".repeat(100);
        let odd = [
            "", ".", "..", "a/b", "a\\b", "a_b/", "../../x", "a\0b", "a\nb", "a:b", "50 %", "#1", ".hidden", &long,
            &wide,
        ];
        let words: BTreeSet<String> = odd.iter().map(|name| safe_word(name).into_owned()).collect();
        assert_eq!(words.len(), odd.len(), "{words:?}");
        for word in &words {
            let path = Path::new(word);
            assert!(path.components().count() == 1 && path.file_name().is_some_and(|f| f == word.as_str()), "{word:?}");
            assert!(word.len() < 80 && !word.starts_with('.') && !word.contains(char::is_control), "{word:?}");
        }
    }

    #[test]
    fn names_are_made_safe_for_each_place() {
        let bad = "=\u{1b}[31m|<b>\u{9b}\n\u{202e}`[x](y)";
        assert_eq!(one_line(bad), "=\u{fffd}[31m|<b>\u{fffd}\u{fffd}\u{fffd}`[x](y)");
        assert_eq!(markdown_cell(bad), "=\u{fffd}\\[31m\\|&lt;b>\u{fffd}\u{fffd}\u{fffd}\\`\\[x\\](y)");
        assert_eq!(csv_cell(bad), format!("'{}", one_line(bad)));
        for cell in ["+cmd", "-x", "@sum", "=1+1"] {
            assert_eq!(csv_cell(cell), format!("'{cell}"));
        }
        for cell in ["-1.5", "+2", "1e-9", "a=b", "", "-inf", "-"] {
            assert_eq!(csv_cell(cell), cell);
        }
        let json = serde_json::json!([bad]).to_string();
        assert!(!json_text(&json).contains(is_unsafe_in_line));
        assert_eq!(serde_json::from_str::<Vec<String>>(&json_text(&json)).expect("JSON"), [bad]);
        for plain in ["Küche (Süd)", "a, b", "\u{30ab}", "r 0.1"] {
            assert_eq!((one_line(plain).as_ref(), markdown_cell(plain).as_str()), (plain, plain));
        }
    }

    #[test]
    fn devices_of_one_name_are_told_apart_by_driver_or_version() {
        let device = |name: &str, driver: &str, api: &str| {
            let kind = "CPU".to_owned();
            DeviceInfo { name: name.to_owned(), driver: driver.to_owned(), api: api.to_owned(), kind }
        };
        let old = device("llvmpipe", "Mesa 22.3", "1.3.230");
        let new = device("llvmpipe", "Mesa 25.0", "1.4.305");
        let other = device("SwiftShader", "5.0", "1.3.0");
        let all = [&old, &new, &other, &old];
        let names = [&old, &new, &other].map(|d| name_among(d, &all));
        assert_eq!(names, ["llvmpipe (Mesa 22.3)", "llvmpipe (Mesa 25.0)", "SwiftShader"]);
        assert_eq!(name_among(&old, &[&old, &other]), "llvmpipe");
        let same_driver = device("llvmpipe", "Mesa 22.3", "1.2.0");
        assert_eq!(name_among(&old, &[&old, &same_driver]), "llvmpipe (Mesa 22.3, Vulkan 1.3.230, CPU)");
    }
}
