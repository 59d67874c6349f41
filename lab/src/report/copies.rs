//! Copies files of runs into the folder of the merged run. A run may come from a stranger, so only pictures in its
//! folder are copied, under names without a path.

use crate::study::names::safe_word;
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use std::collections::BTreeMap;

/// The endings of the pictures that measurements make beside records.
const PICTURES: [&str; 4] = ["png", "exr", "webp", "svg"];

/// Elements of the drawings that this program makes. Any other element, such as a script, is refused, since it could do
/// more than show something.
const DRAWING_ELEMENTS: [&str; 14] = [
    "svg", "g", "path", "line", "polyline", "polygon", "rect", "circle", "ellipse", "text", "tspan", "title", "desc",
    "defs",
];

/// Checks the name of a picture that a file gives.
///
/// # Errors
/// The fault of the name, as the end of a sentence about the name.
pub fn check_name(name: &str) -> std::result::Result<(), String> {
    if safe_word(name) != name {
        return Err("is no name of a file".to_owned());
    }
    if name.rsplit_once('.').is_none_or(|(_, ending)| !PICTURES.contains(&ending)) {
        return Err(format!("is no picture: its name must end in .{}", PICTURES.join(", .")));
    }
    Ok(())
}

/// Checks the files of a folder that [`copy_files`] would copy, before anything is written.
pub fn check_files(folder: &PathInFolder) -> Result<()> {
    for listed in folder.list()? {
        let place = folder.join(&listed.name);
        check_name(&listed.name).map_err(|why| Error::malformed(place.path(), None, why))?;
        check_file(&place)?;
    }
    Ok(())
}

/// Checks a picture, if it is there.
///
/// # Errors
/// The errors of [`PathInFolder::read`], and [`Malformed`](ssct_ground::Error::Malformed) for a drawing that could do more than be seen.
pub fn check_file(place: &PathInFolder) -> Result<()> {
    if is_drawing(place) { read_checked(place).map(drop) } else { place.open().map(drop) }
}

/// True if a file is an SVG drawing, by its name.
fn is_drawing(place: &PathInFolder) -> bool {
    place.path().extension().is_some_and(|e| e == "svg")
}

/// Reads a picture, if it is there, and checks it.
fn read_checked(place: &PathInFolder) -> Result<Option<Vec<u8>>> {
    let bytes = place.read()?;
    if let Some(svg) = bytes.as_deref().filter(|_| is_drawing(place)) {
        check_drawing(svg, place)?;
    }
    Ok(bytes)
}

/// Checks a drawing for elements and attributes that a browser would run or load, since a user may open the drawing by itself.
fn check_drawing(svg: &[u8], place: &PathInFolder) -> Result<()> {
    let wrong = |why: String| Err(Error::malformed(place.path(), None, format!("is no drawing that is copied: {why}")));
    let Ok(text) = str::from_utf8(svg) else { return wrong("it is no text".to_owned()) };
    for tag in text.split('<').skip(1) {
        if tag.starts_with("?xml ") || tag.starts_with("!--") || tag.starts_with('/') {
            continue;
        }
        let end = tag.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(tag.len());
        let name = &tag[..end];
        if !DRAWING_ELEMENTS.contains(&name) {
            return wrong(format!("it has the element {name:?}"));
        }
        let mut names = attributes(&tag[end..]).split('=').filter_map(|part| part.split_whitespace().next_back());
        if let Some(name) = names.find(|name| name.to_ascii_lowercase().starts_with("on") || name.contains("href")) {
            return wrong(format!("it has the attribute {name:?}"));
        }
    }
    Ok(())
}

/// Returns the part of a tag before the `>` that ends the tag; a `>` inside quotes does not end it.
fn attributes(tag: &str) -> &str {
    let mut quote = None;
    let end = tag.find(|c: char| {
        match (quote, c) {
            (None, '>') => return true,
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            _ => {}
        }
        false
    });
    &tag[..end.unwrap_or(tag.len())]
}

/// Copies the files of the folders `from` into the folder `to`; of several files of one name, the first. If
/// `must_be_equal` is true, unequal files of one name are refused.
pub fn copy_files(from: &[PathInFolder], to: &PathInFolder, must_be_equal: bool) -> Result<()> {
    let mut places_by_name: BTreeMap<String, Vec<PathInFolder>> = BTreeMap::new();
    for folder in from {
        check_files(folder)?;
        for listed in folder.list()? {
            places_by_name.entry(listed.name.clone()).or_default().push(folder.join(&listed.name));
        }
    }
    places_by_name.iter().try_for_each(|(name, places)| copy_file(places, &to.join(name), must_be_equal))
}

/// Copies the first of some files that exists. If `must_be_equal` is true, all that exist must be equal.
///
/// # Errors
/// The errors of [`check_file`] and of writing, and [`Malformed`](ssct_ground::Error::Malformed) for files that are not equal.
pub fn copy_file(from: &[PathInFolder], to: &PathInFolder, must_be_equal: bool) -> Result<()> {
    let mut first: Option<(&PathInFolder, Vec<u8>)> = None;
    for place in from {
        match (&first, read_checked(place)?) {
            (None, Some(bytes)) => first = Some((place, bytes)),
            (Some((known, bytes)), Some(other)) if must_be_equal && *bytes != other => {
                let message = format!("is not the same as {}", known.path().display());
                return Err(Error::malformed(place.path(), None, message));
            }
            _ => {}
        }
        if first.is_some() && !must_be_equal {
            break;
        }
    }
    first.map_or(Ok(()), |(_, bytes)| to.write(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_files_of_a_name_are_copied_and_others_may_have_to_be_equal() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |name: &str| PathInFolder::folder(folder.path()).join(name);
        for (path, text) in [("a/1.png", "one"), ("b/1.png", "other"), ("b/2.png", "two"), ("c/2.png", "two")] {
            place(path).write(text.as_bytes()).expect("written");
        }
        copy_files(&[place("a"), place("none"), place("b")], &place("to"), false).expect("copied");
        assert_eq!(
            ["to/1.png", "to/2.png"].map(|f| place(f).bytes().expect("there")),
            [b"one", b"two"].map(|t| t.to_vec())
        );
        copy_files(&[place("b"), place("c")], &place("same"), true).expect("equal");
        let refused = copy_files(&[place("a"), place("b")], &place("not"), true).expect_err("not equal").to_string();
        assert!(refused.contains("is not the same as"), "{refused}");
    }

    #[test]
    fn only_names_of_pictures_are_copied() {
        for name in ["a.png", "figure-4.4.svg", "x-r0.1-ssct.exr", "Küche.webp"] {
            assert_eq!(check_name(name), Ok(()), "{name}");
        }
        for name in ["../x.svg", "/etc/x.png", "a/b.png", "x.html", "x", ".x.png", "javascript:x.svg", "a\nb.png", ""] {
            assert!(check_name(name).is_err(), "{name:?}");
        }
    }

    #[test]
    fn drawings_that_could_do_more_than_be_seen_are_refused() {
        let place = PathInFolder::folder("run").join("x.svg");
        let check = |svg: &str| check_drawing(svg.as_bytes(), &place).map_err(|e| e.to_string());
        let good = "<?xml version=\"1.0\"?><svg width=\"1\"><!-- a --><g><text x=\"1\">on = href</text></g></svg>";
        assert_eq!(check(good), Ok(()));
        for (bad, what) in [
            ("<svg><script>alert(1)</script></svg>", "\"script\""),
            ("<svg onload=\"alert(1)\"></svg>", "\"onload\""),
            ("<svg><g\nONCLICK = 'x'/></svg>", "\"ONCLICK\""),
            ("<svg><g x=\">\" onload='a'/></svg>", "\"onload\""),
            ("<svg><foreignObject/></svg>", "\"foreignObject\""),
            ("<svg><a href=\"http://x\"/></svg>", "\"a\""),
            ("<svg><path xlink:href='x'/></svg>", "\"xlink:href\""),
            ("<!DOCTYPE svg [<!ENTITY x 'y'>]><svg/>", "\"\""),
        ] {
            assert!(check(bad).is_err_and(|message| message.contains(what)), "{bad}: {:?}", check(bad));
        }
    }
}
