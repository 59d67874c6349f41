//! Parses the statements of maps in MTL files: options, followed by a file name that may contain blanks.

use super::{Place, distinct, without_comment};
use crate::obj::images::{ImageStatement, resolve};
use std::path::Path;

/// The options of a map statement that matter to the loader.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MapOptions {
    /// The bump multiplier (`-bm`).
    multiplier: f32,
    /// Whether `-s`, `-o` or `-t` is given with numbers that transform texture coordinates.
    transformed: bool,
    /// Whether `-mm`, `-imfchan` or `-clamp` is given with a value that changes the image.
    altered: bool,
}

/// Reads the options at the beginning of a text into `options`, and returns the text after them.
fn take_options<'a>(text: &'a str, options: &mut MapOptions) -> &'a str {
    let mut rest = text;
    while rest.starts_with('-') {
        let (option, mut after_values) = take_word(rest);
        // The greatest number of words that follow the option, and whether they must be numbers.
        let (most_words, are_numbers) = match option {
            "-bm" | "-boost" | "-texres" => (1, true),
            "-mm" => (2, true),
            "-o" | "-s" | "-t" => (3, true),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-colorspace" | "-imfchan" | "-type" => (1, false),
            _ => break,
        };
        for index in 0..most_words {
            let (word, after_word) = take_word(after_values);
            let value = word.parse::<f32>().ok().filter(|number| number.is_finite());
            if word.is_empty() || (are_numbers && value.is_none()) {
                break;
            }
            match (option, value) {
                ("-bm", Some(value)) => options.multiplier = value.clamp(-16.0, 16.0),
                ("-o" | "-t", Some(value)) => options.transformed |= value != 0.0,
                ("-s", Some(value)) => options.transformed |= value != 1.0 && index < 2,
                // The defaults of the two numbers, base and gain, are 0 and 1.
                ("-mm", Some(value)) => options.altered |= value != index as f32,
                // The channels l and m are luminance and alpha, which masks and factors are read from anyway.
                _ => {
                    options.altered |= matches!((option, word), ("-clamp", "on") | ("-imfchan", "r" | "g" | "b" | "z"))
                }
            }
            after_values = after_word;
        }
        rest = after_values;
    }
    rest
}

/// Parses `arguments`, the options and the file name of a map statement; `None` if there is no file name.
///
/// Names may contain blanks, hyphens and `#`. Several readings of the text are tried, and the first that names an
/// existing file is used:
///
/// 1. everything after the options;
/// 2. the same without a comment;
/// 3. the same without options after the name;
/// 4. the last word, which may follow unknown options.
///
/// Each reading is also tried with each backslash before a blank removed. If no file exists, the third reading is the
/// name.
pub(super) fn image_statement(place: &Place, arguments: &str) -> Option<ImageStatement> {
    let mut options = MapOptions { multiplier: 1.0, transformed: false, altered: false };
    let after_options = take_options(arguments, &mut options);
    let uncommented = without_comment(after_options);
    // Returns true if an option begins at an offset: then `take_options` takes some text, and the rest is shorter.
    let is_option = |offset: &usize| {
        let text = uncommented[*offset..].trim_start();
        let mut ignored = options;
        take_options(text, &mut ignored).len() < text.len()
    };
    let end_of_name = uncommented.match_indices(" -").map(|(offset, _)| offset).find(is_option);
    let (before_late_options, late_options) =
        end_of_name.map_or((uncommented, ""), |offset| uncommented.split_at(offset));
    let last_word = uncommented.split_whitespace().next_back().unwrap_or(uncommented);
    let folder = place.path.parent().unwrap_or(Path::new(""));
    let clean = |name: &str| name.trim().trim_matches('"').trim().to_owned();
    let readings = [after_options, uncommented, before_late_options, last_word].into_iter();
    let names = readings.flat_map(|text| [clean(text), clean(&text.replace("\\ ", " "))]);
    let names = distinct(names.filter(|name| !name.is_empty()));
    let found = names.into_iter().find(|name| resolve(folder, name).is_some());
    let name = found.unwrap_or_else(|| clean(before_late_options));
    // If the name ends before the options after it, these count, too.
    if name.len() <= before_late_options.len() {
        take_options(late_options.trim_start(), &mut options);
    }
    let MapOptions { multiplier, transformed, altered } = options;
    (!name.is_empty()).then(|| ImageStatement {
        name,
        mtl_path: place.path.to_owned(),
        line: place.line,
        multiplier,
        is_normal_map: false,
        transformed,
        altered,
    })
}

/// Splits a text into its first word and the text after it.
fn take_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parses the statement of a map; returns its name, bump multiplier and whether it transforms texture coordinates.
    fn image(arguments: &str) -> Option<(String, f32, bool)> {
        let place = Place { path: Path::new("a.mtl"), line: 3 };
        image_statement(&place, arguments).map(|image| (image.name, image.multiplier, image.transformed))
    }

    #[test]
    fn options_of_maps_are_not_part_of_the_name() {
        let assert_parsed = |arguments, name: &str, multiplier, transformed| {
            assert_eq!(image(arguments), Some((name.into(), multiplier, transformed)), "{arguments}");
        };
        assert_parsed("a b.png", "a b.png", 1.0, false);
        assert_parsed("-bm 0.5 bump.png", "bump.png", 0.5, false);
        assert_parsed("-s 1 1 1 -o 0 0 0 -bm 2 x.png", "x.png", 2.0, false);
        assert_parsed("-s 2 2 x.png", "x.png", 1.0, true);
        assert_parsed("-clamp on -imfchan l x.png", "x.png", 1.0, false);
        assert_parsed("-mm 0 1 \"my file.png\"", "my file.png", 1.0, false);
        assert_parsed("-odd-name.png", "-odd-name.png", 1.0, false);
        assert_parsed("-colorspace sRGB x.png", "x.png", 1.0, false);
        assert_parsed("x.png # the bark", "x.png", 1.0, false);
        assert_parsed("x.png -bm 0.5 -clamp on # the bark", "x.png", 0.5, false);
        assert_parsed("x-y -z.png", "x-y -z.png", 1.0, false);
        assert_eq!(image("  "), None);
    }

    #[test]
    fn options_that_change_an_image_are_told_from_those_that_do_not() {
        let place = Place { path: Path::new("a.mtl"), line: 3 };
        let is_altered =
            |options: &str| image_statement(&place, &format!("{options} x.png")).map(|image| image.altered);
        for options in ["-mm 0.5 0.1", "-mm 0 2", "-clamp on", "-imfchan g"] {
            assert_eq!(is_altered(options), Some(true), "{options}");
        }
        for options in ["-mm 0 1", "-clamp off", "-imfchan l", "-imfchan m", "-blendu on", "-s 2 2 2"] {
            assert_eq!(is_altered(options), Some(false), "{options}");
        }
    }
}
