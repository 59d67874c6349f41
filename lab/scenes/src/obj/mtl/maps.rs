//! The statements of maps in MTL files: options, followed by a name that may contain blanks.

use super::{Place, distinct, without_comment};
use crate::obj::images::{ImageStatement, resolve};
use std::path::Path;

/// The options of a map that are used.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MapOptions {
    /// The bump multiplier (`-bm`).
    multiplier: f32,
    /// Whether `-s`, `-o` or `-t` would transform texture coordinates.
    transformed: bool,
}

/// Takes the options at the beginning of a text; returns the text after them.
fn take_options<'a>(text: &'a str, options: &mut MapOptions) -> &'a str {
    let mut rest = text;
    while rest.starts_with('-') {
        let (option, mut after) = take_word(rest);
        // Greatest number of words of the option, and whether they must be numbers.
        let (most, numeric) = match option {
            "-bm" | "-boost" | "-texres" => (1, true),
            "-mm" => (2, true),
            "-o" | "-s" | "-t" => (3, true),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-colorspace" | "-imfchan" | "-type" => (1, false),
            _ => break,
        };
        for i in 0..most {
            let (word, further) = take_word(after);
            let value = word.parse::<f32>().ok().filter(|v| v.is_finite());
            if word.is_empty() || (numeric && value.is_none()) {
                break;
            }
            match (option, value) {
                ("-bm", Some(value)) => options.multiplier = value.clamp(-16.0, 16.0),
                ("-o" | "-t", Some(value)) => options.transformed |= value != 0.0,
                ("-s", Some(value)) => options.transformed |= value != 1.0 && i < 2,
                _ => {}
            }
            after = further;
        }
        rest = after;
    }
    rest
}

/// Parses the options and the file name of a map; `None` if there is no file name.
///
/// Names may contain blanks, hyphens and `#`. Several readings of the text are tried, and the first that names an existing file
/// is used. The readings are: everything after the options; this text without a comment; this text without options
/// after the name; and the last word, which may follow unknown options. If no file exists, the third reading is the
/// name.
pub(super) fn image_statement(place: &Place, rest: &str) -> Option<ImageStatement> {
    let mut options = MapOptions { multiplier: 1.0, transformed: false };
    let whole = take_options(rest, &mut options);
    let bare = without_comment(whole);
    let is_option = |offset: &usize| {
        let mut ignored = options;
        take_options(bare[*offset..].trim_start(), &mut ignored).len() < bare[*offset..].trim_start().len()
    };
    let tail = bare.match_indices(" -").map(|(offset, _)| offset).find(is_option);
    let (head, tail) = tail.map_or((bare, ""), |place| bare.split_at(place));
    let last = bare.split_whitespace().next_back().unwrap_or(bare);
    let folder = place.path.parent().unwrap_or(Path::new(""));
    let clean = |name: &str| name.trim().trim_matches('"').trim().to_owned();
    let spelt = [whole, bare, head, last].into_iter().flat_map(|text| [clean(text), clean(&text.replace("\\ ", " "))]);
    let spelt = distinct(spelt.filter(|name| !name.is_empty()));
    let found = spelt.into_iter().find(|name| resolve(folder, name).is_some());
    let name = found.unwrap_or_else(|| clean(head));
    if name.len() <= head.len() {
        take_options(tail.trim_start(), &mut options);
    }
    let MapOptions { multiplier, transformed } = options;
    (!name.is_empty()).then(|| ImageStatement {
        name,
        mtl_path: place.path.to_owned(),
        line: place.line,
        multiplier,
        transformed,
    })
}

fn take_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(rest: &str) -> Option<(String, f32, bool)> {
        let place = Place { path: Path::new("a.mtl"), line: 3 };
        image_statement(&place, rest).map(|i| (i.name, i.multiplier, i.transformed))
    }

    #[test]
    fn options_of_maps_are_not_part_of_the_name() {
        let is = |rest, name: &str, multiplier, transformed| {
            assert_eq!(image(rest), Some((name.into(), multiplier, transformed)), "{rest}");
        };
        is("a b.png", "a b.png", 1.0, false);
        is("-bm 0.5 bump.png", "bump.png", 0.5, false);
        is("-s 1 1 1 -o 0 0 0 -bm 2 x.png", "x.png", 2.0, false);
        is("-s 2 2 x.png", "x.png", 1.0, true);
        is("-clamp on -imfchan l x.png", "x.png", 1.0, false);
        is("-mm 0 1 \"my file.png\"", "my file.png", 1.0, false);
        is("-odd-name.png", "-odd-name.png", 1.0, false);
        is("-colorspace sRGB x.png", "x.png", 1.0, false);
        is("x.png # the bark", "x.png", 1.0, false);
        is("x.png -bm 0.5 -clamp on # the bark", "x.png", 0.5, false);
        is("x-y -z.png", "x-y -z.png", 1.0, false);
        assert_eq!(image("  "), None);
    }
}
