//! Reads materials from MTL files.
//!
//! tobj's own reader panics on a `Kd` with one number and keeps the options of maps in the file name. This
//! module therefore reads the few statements that matter itself, with line numbers:
//!
//! | statement | meaning |
//! |---|---|
//! | `Kd` | albedo, linear, clamped to 0…1; black with a `map_Kd` counts as white, as exporters mean it |
//! | `Ks` | its luminance is the reflectivity; 1 if absent |
//! | `Pr` | roughness |
//! | `Ns` | without `Pr`: Phong exponent, see [`roughness_of_exponent`]; absent or ≤ 0 states no gloss: roughness 0, the author's default |
//! | `map_Kd`, `map_Ks`, `map_d` | albedo image, factor on the reflectivity, alpha mask |
//! | `bump`, `map_bump`, `norm` | normal map or height field, as the image's content says; `-bm` scales its tilt |
//!
//! What else changes how a material looks is dropped, and a warning for each kind says so ([`loss`]). `Ka`, `Ni`, `illum`,
//! `sharpness` and what is unknown say nothing that the other statements would need.

use super::images::{ImageStatement, MaterialImages, resolve};
use super::text::{NO_MATERIAL, stated_number};
use super::{decode, read_limited};
use crate::error::{Error, Result};
use crate::scene::bounded::shown;
use crate::scene::material_terms::roughness_of_exponent;
use crate::scene::{Material, texture::luminance};
use glam::Vec3;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

/// One `newmtl` block.
#[derive(Debug, Clone, Default)]
pub(super) struct Definition {
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    exponent: Option<f32>,
    roughness: Option<f32>,
    images: MaterialImages,
    /// What was dropped, and the file and line where it was first met.
    dropped: BTreeMap<&'static str, String>,
}

impl Definition {
    /// The material without its name, surface and images.
    pub(super) fn material(&self) -> Material {
        let roughness = self.roughness.or(self.exponent.map(roughness_of_exponent));
        let mut albedo = self.diffuse.unwrap_or(Vec3::ONE).clamp(Vec3::ZERO, Vec3::ONE);
        if albedo == Vec3::ZERO && self.images.albedo.is_some() {
            albedo = Vec3::ONE;
        }
        Material {
            albedo,
            reflectivity: self.specular.map_or(1.0, luminance).clamp(0.0, 1.0),
            roughness: roughness.unwrap_or(0.0).clamp(0.0, 1.0),
            ..Material::default()
        }
    }

    /// Adds a sentence for each kind of statement that was dropped.
    pub(super) fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.dropped.iter().map(|(sentence, place)| format!("{place}: {sentence}")));
    }

    /// The images that the material names.
    pub(super) fn images(&self) -> MaterialImages {
        self.images.clone()
    }
}

/// Reads the files that the `mtllib` statements of the OBJ file at `obj_path` name. A missing file adds a
/// warning. A name with blanks is one file if such a file exists, and several files otherwise.
pub(super) fn read_libraries(
    obj_path: &Path,
    statements: &[(usize, String)],
    warnings: &mut Vec<String>,
) -> Result<Definitions> {
    let folder = obj_path.parent().unwrap_or(Path::new(""));
    let mut definitions = Definitions::default();
    let mut seen = HashSet::new();
    for (line, statement) in statements {
        let whole = spellings(statement).into_iter().find_map(|name| Some((resolve(folder, &name)?, name)));
        let files = match whole {
            Some((path, name)) => vec![(name.into_owned(), Some(path))],
            None => {
                let words = without_comment(statement).split_whitespace();
                words.map(|name| (name.to_owned(), resolve(folder, name))).collect()
            }
        };
        for (name, path) in files {
            if !seen.insert(name.clone()) {
                continue;
            }
            match path {
                Some(path) => {
                    let bytes = read_limited(&path)?;
                    read(&path, &decode(&path, &bytes)?, &mut definitions.named)?;
                }
                None => warnings.push(format!(
                    "{}:{line}: the MTL file {} is missing; its materials are white",
                    obj_path.display(),
                    shown(&name)
                )),
            }
        }
    }
    let bare = definitions.named.keys().map(|name| (without_comment(name).to_owned(), name.clone()));
    definitions.bare = bare.collect();
    Ok(definitions)
}

/// The materials of the MTL files of an OBJ file.
#[derive(Default)]
pub(super) struct Definitions {
    named: HashMap<String, Definition>,
    /// Their names without comments behind them.
    bare: HashMap<String, String>,
}

impl Definitions {
    pub(super) fn is_empty(&self) -> bool {
        self.named.is_empty()
    }

    /// The material of a name, with or without a comment behind it, as some programs write one. A name may have a `#` of
    /// its own.
    pub(super) fn get(&self, name: &str) -> Option<&Definition> {
        let bare = without_comment(name);
        let named = |name: &str| self.named.get(name);
        named(name).or_else(|| named(bare)).or_else(|| named(self.bare.get(bare)?))
    }
}

/// A statement without a comment that a blank separates from it.
fn without_comment(statement: &str) -> &str {
    let behind_blank = |(at, _): &(usize, &str)| statement[..*at].ends_with(char::is_whitespace);
    let comment = statement.match_indices('#').find(behind_blank);
    comment.map_or(statement, |(at, _)| &statement[..at]).trim_end()
}

/// The ways in which the rest of a statement may name one file, each once: as it stands, without a comment, and each with
/// blanks that a backslash marks as parts of the name.
fn spellings(statement: &str) -> Vec<Cow<'_, str>> {
    let plain = [statement, without_comment(statement)];
    let escaped = plain.map(|text| Cow::Owned(text.replace("\\ ", " ")));
    different(plain.map(Cow::Borrowed).into_iter().chain(escaped))
}

/// What differs from all before it, of a few things.
fn different<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}

/// Adds the materials of one MTL file; if a name occurs twice, the last definition counts.
fn read(path: &Path, text: &str, definitions: &mut HashMap<String, Definition>) -> Result<()> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let mut current: Option<(String, Definition)> = None;
    for (index, line) in text.split(separator).enumerate() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let place = Place { path, line: index + 1 };
        if keyword.eq_ignore_ascii_case("newmtl") {
            definitions.extend(current.take());
            let name = if rest.is_empty() { NO_MATERIAL } else { rest };
            current = Some((name.to_owned(), Definition::default()));
        } else if let Some((_, definition)) = &mut current {
            statement(&place, &keyword.to_ascii_lowercase(), rest, definition)?;
        }
    }
    definitions.extend(current);
    Ok(())
}

/// The file and line of a statement.
struct Place<'a> {
    path: &'a Path,
    line: usize,
}

fn statement(place: &Place, keyword: &str, rest: &str, definition: &mut Definition) -> Result<()> {
    let image = || image_statement(place, rest);
    match keyword {
        "kd" => definition.diffuse = colour(place, keyword, rest, definition)?,
        "ks" => definition.specular = colour(place, keyword, rest, definition)?,
        "ns" => definition.exponent = number(place, keyword, rest, definition)?,
        "pr" => definition.roughness = number(place, keyword, rest, definition)?,
        "map_kd" => definition.images.albedo = image(),
        "map_ks" => definition.images.reflectivity = image(),
        "map_d" | "map_opacity" => definition.images.mask = image(),
        "bump" | "map_bump" | "norm" => definition.images.normal = image(),
        _ => {
            if let Some(sentence) = loss(keyword, rest) {
                definition.drop_kind(place, sentence);
            }
        }
    }
    Ok(())
}

/// What is lost with a statement that is not read; `None` if it is nothing, as with the value that it has without one.
fn loss(keyword: &str, rest: &str) -> Option<&'static str> {
    let numbers = || rest.split_whitespace().map_while(|word| word.parse::<f32>().ok());
    let is_not = |usual: f32| numbers().any(|v| v != usual);
    // The option -halo stands before the number.
    let opacity = rest.strip_prefix("-halo").unwrap_or(rest).split_whitespace().next();
    match keyword {
        "d" if opacity.and_then(|word| word.parse::<f32>().ok()).is_some_and(|v| v < 1.0) => Some(TRANSPARENCY),
        "tr" if is_not(0.0) => Some(TRANSPARENCY),
        "tf" if is_not(1.0) => Some(TRANSPARENCY),
        "ke" if is_not(0.0) => Some("emission (Ke) is not supported and was ignored"),
        "map_ke" => Some("images of emission (map_Ke) are not supported and were ignored"),
        "map_ns" | "map_pr" => Some("images of roughness (map_Pr, map_Ns) are not supported and were ignored"),
        "map_pm" | "pm" if keyword == "map_pm" || is_not(0.0) => {
            Some("metalness (Pm, map_Pm) is not supported and was ignored; Ks says what a surface reflects")
        }
        "ps" | "pc" | "pcr" | "aniso" | "anisor" if is_not(0.0) => {
            Some("sheen, clear coats and anisotropy are not supported and were ignored")
        }
        "map_ps" | "map_pc" | "map_pcr" => Some("sheen, clear coats and anisotropy are not supported and were ignored"),
        "refl" | "map_refl" => Some("reflection maps (refl) are not supported and were ignored"),
        "disp" | "map_disp" | "decal" => Some("displacement and decals are not supported and were ignored"),
        _ => None,
    }
}

const TRANSPARENCY: &str = "transparency (d, Tr, Tf) is not supported; the surface is opaque where it has no map_d";

impl Definition {
    fn drop_kind(&mut self, place: &Place, sentence: &'static str) {
        self.dropped.entry(sentence).or_insert_with(|| format!("{}:{}", place.path.display(), place.line));
    }
}

/// A number; `None`, with a warning, for one that is not finite.
fn number(place: &Place, keyword: &str, rest: &str, definition: &mut Definition) -> Result<Option<f32>> {
    let word = rest.split_whitespace().next().unwrap_or("");
    let stated = stated_number(word).ok_or_else(|| {
        let message = format!("{keyword} needs a finite number, not {:?}", shown(word));
        Error::malformed(place.path, Some(place.line), message)
    })?;
    let number = Some(stated as f32).filter(|v| v.is_finite());
    if number.is_none() {
        definition.drop_kind(place, "a statement with a number that is not finite was ignored");
    }
    Ok(number)
}

/// A colour given as three numbers, or as one number for all three channels; `None` for numbers that are not finite, and for
/// spectral curves and CIE XYZ, which are not supported.
fn colour(place: &Place, keyword: &str, rest: &str, definition: &mut Definition) -> Result<Option<Vec3>> {
    let words: Vec<&str> = rest.split_whitespace().take_while(|w| !w.starts_with('#')).collect();
    if matches!(words.first(), Some(&("spectral" | "xyz"))) {
        definition.drop_kind(place, "colours as spectral curves or CIE XYZ are not supported and were ignored");
        return Ok(None);
    }
    let numbers: Vec<Option<f32>> =
        words.iter().take(3).map(|w| number(place, keyword, w, definition)).collect::<Result<_>>()?;
    match numbers[..] {
        [r, g, b] => Ok(r.zip(g).zip(b).map(|((r, g), b)| Vec3::new(r, g, b))),
        [grey] => Ok(grey.map(Vec3::splat)),
        _ => {
            let message = format!("{keyword} needs three numbers, not {}", numbers.len());
            Err(Error::malformed(place.path, Some(place.line), message))
        }
    }
}

/// What the options of a map say.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MapOptions {
    multiplier: f32,
    transformed: bool,
}

/// Takes the options at the beginning of a text; gives what follows them.
fn take_options<'a>(text: &'a str, options: &mut MapOptions) -> &'a str {
    let mut rest = text;
    while rest.starts_with('-') {
        let (option, mut after) = take_word(rest);
        // The most words that belong to the option, and whether they must be numbers.
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
/// Names have blanks, hyphens and `#` of their own, so that the longest text of which there is a file counts: all that
/// follows the options, then without a comment, then without options behind it, then its last word, behind options that are
/// unknown. If there is no such file, it is the third.
fn image_statement(place: &Place, rest: &str) -> Option<ImageStatement> {
    let mut options = MapOptions { multiplier: 1.0, transformed: false };
    let whole = take_options(rest, &mut options);
    let bare = without_comment(whole);
    let is_option = |at: &usize| {
        let mut ignored = options;
        take_options(bare[*at..].trim_start(), &mut ignored).len() < bare[*at..].trim_start().len()
    };
    let tail = bare.match_indices(" -").map(|(at, _)| at).find(is_option);
    let (head, tail) = tail.map_or((bare, ""), |at| bare.split_at(at));
    let last = bare.split_whitespace().next_back().unwrap_or(bare);
    let folder = place.path.parent().unwrap_or(Path::new(""));
    let clean = |name: &str| name.trim().trim_matches('"').trim().to_owned();
    let spelt = [whole, bare, head, last].into_iter().flat_map(|text| [clean(text), clean(&text.replace("\\ ", " "))]);
    let spelt = different(spelt.filter(|name| !name.is_empty()));
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
