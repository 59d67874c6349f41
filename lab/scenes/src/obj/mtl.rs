//! Reads materials from MTL files.
//!
//! The reader of the crate tobj panics on a `Kd` with one number, and takes the options of maps as part of the file
//! name. This module therefore reads the few statements that matter itself, with line numbers:
//!
//! | statement | meaning |
//! |---|---|
//! | `Kd` | albedo or base colour, linear, clamped to 0…1; black with a `map_Kd` counts as white, as exporters mean it |
//! | `Ks`, `Ns`, `Ka`, `Ni`, `illum` | by the law of the exporter ([`laws`]); by Wavefront's `Ks` is the reflectivity (1 if absent) and `Ns` a Phong exponent (absent or ≤ 0: roughness 0, the author's default) |
//! | `Pr`, `Pm`, `map_Pr`, `map_Pm` | roughness and metalness as those of glTF |
//! | `Ke`, `map_Ke` | emission |
//! | `map_Kd`, `map_Ks`, `map_d` | image of the colour, factor on the value of `Ks`, alpha mask |
//! | `bump`, `map_bump` | normal map or height field, as the image's content says; `-bm` scales its tilt |
//! | `norm` | normal map; `-bm` scales its tilt |
//!
//! A value that is no number counts as missing, with a warning ([`number`], [`colour`]).
//! Other statements that change the look of a material are dropped, with a warning for each kind ([`lost_meaning`]).
//! `sharpness`, `map_Ka`, `map_aat` and unknown statements are ignored, but unknown maps get a warning.

mod laws;
mod maps;

use super::images::{ImageStatement, MaterialImages, resolve};
use super::text::{NO_MATERIAL, stated_number};
use super::{decode, read_limited};
use glam::Vec3;
use ssct_geometry::bounded::printable_name;
use ssct_ground::Result;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use laws::{Exporter, Law};
use maps::image_statement;

/// A material: the statements of one `newmtl` block.
#[derive(Debug, Clone, Default)]
pub(super) struct Definition {
    /// The law, that is, the exporter's meaning of the numbers, once it was chosen.
    law: Law,
    /// The colour of `Kd`.
    diffuse: Option<Vec3>,
    /// The colour of `Ks`.
    specular: Option<Vec3>,
    /// The colour of `Ke`.
    emission: Option<Vec3>,
    /// The colour of `Ka`.
    ambient: Option<Vec3>,
    /// The number of `Ns`.
    exponent: Option<f32>,
    /// The number of `Pr`.
    roughness: Option<f32>,
    /// The number of `Pm`.
    metalness: Option<f32>,
    /// The index of refraction (`Ni`).
    ior: Option<f32>,
    /// The model of illumination (`illum`).
    model: Option<u32>,
    images: MaterialImages,
    /// The image of `map_Ns`, whose meaning the law decides.
    exponent_image: Option<ImageStatement>,
    /// The image of `refl`, whose meaning the law decides.
    reflection_image: Option<ImageStatement>,
    /// File and line of a positive `Tf` that filters no colour, which Blender writes for transparent surfaces.
    transmission: Option<String>,
    /// Warnings about dropped statements, one for each kind, with the file and line of the first statement.
    dropped: BTreeMap<&'static str, String>,
}

impl Definition {
    /// Adds a warning for each kind of dropped statement.
    pub(super) fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.dropped.iter().map(|(sentence, place)| format!("{place}: {sentence}")));
    }

    /// Returns the images that the material names.
    pub(super) fn images(&self) -> MaterialImages {
        self.images.clone()
    }
}

/// Reads the MTL files that the `mtllib` statements of the OBJ file at `obj_path` name. `statements` are their lines
/// and texts. A file that is named twice is read once, and a missing file adds a warning. If several files define a
/// name, the first of them counts.
pub(super) fn read_libraries(
    obj_path: &Path,
    statements: &[(usize, String)],
    warnings: &mut Vec<String>,
) -> Result<Definitions> {
    let folder = obj_path.parent().unwrap_or(Path::new(""));
    let mut definitions = Definitions::default();
    let mut read_names = HashSet::new();
    for (line, statement) in statements {
        for (name, path) in library_names(folder, statement) {
            if !read_names.insert(name.clone()) {
                continue;
            }
            match path {
                Some(path) => {
                    let bytes = read_limited(&path)?;
                    for (name, definition) in read_materials(&path, &decode(&path, &bytes)?) {
                        definitions.named.entry(name).or_insert(definition);
                    }
                }
                None => warnings.push(format!(
                    "{}:{line}: the MTL file {} is missing; its materials are white",
                    obj_path.display(),
                    printable_name(&name)
                )),
            }
        }
    }
    let name_pairs = definitions.named.keys().map(|name| (without_comment(name).to_owned(), name.clone()));
    definitions.by_uncommented = name_pairs.collect();
    Ok(definitions)
}

/// Finds the files that an `mtllib` statement names, and returns each name with its path, or `None` if there is no such
/// file. The longest run of words that names an existing file is one name; a blank after a backslash always belongs to
/// a name.
fn library_names(folder: &Path, statement: &str) -> Vec<(String, Option<PathBuf>)> {
    /// Greatest number of words in a name that is searched for, unless the whole statement is a name.
    const MOST_WORDS: usize = 16;
    // Returns a name with its path, if the file exists.
    let existing = |name: &str| Some((name.to_owned(), Some(resolve(folder, name)?)));
    if let Some(whole) = spellings(statement).iter().find_map(|name| existing(name)) {
        return vec![whole];
    }
    // A blank that belongs to a name is replaced by a line end, which no name contains, while the words are split.
    let marked = without_comment(statement).replace("\\ ", "\n");
    let words: Vec<String> =
        marked.split([' ', '\t']).filter(|word| !word.is_empty()).map(|word| word.replace('\n', " ")).collect();
    let mut names = Vec::new();
    let mut unread_words = &words[..];
    while let Some(first) = unread_words.first() {
        let mut word_counts = (1..=unread_words.len().min(MOST_WORDS)).rev();
        let longest = word_counts.find_map(|count| Some((count, existing(&unread_words[..count].join(" "))?)));
        let (count, name) = longest.unwrap_or_else(|| (1, (first.clone(), None)));
        names.push(name);
        unread_words = &unread_words[count..];
    }
    names
}

/// The materials of the MTL files of an OBJ file.
#[derive(Default)]
pub(super) struct Definitions {
    /// The materials by their names as written.
    named: HashMap<String, Definition>,
    /// The names as written, by the names without comments.
    by_uncommented: HashMap<String, String>,
}

impl Definitions {
    /// Returns true if the MTL files define no material.
    pub(super) fn is_empty(&self) -> bool {
        self.named.is_empty()
    }

    /// Returns the material of a name. In the OBJ and in the MTL file, some programs write a comment after the name,
    /// which is ignored if the names differ otherwise. A name itself may contain a `#`.
    pub(super) fn get(&self, name: &str) -> Option<&Definition> {
        let uncommented = without_comment(name);
        let named = |name: &str| self.named.get(name);
        named(name).or_else(|| named(uncommented)).or_else(|| named(self.by_uncommented.get(uncommented)?))
    }
}

/// Returns a statement without its comment. A comment begins with a `#` after a blank.
fn without_comment(statement: &str) -> &str {
    let follows_blank = |(offset, _): &(usize, &str)| statement[..*offset].ends_with(char::is_whitespace);
    let comment = statement.match_indices('#').find(follows_blank);
    comment.map_or(statement, |(offset, _)| &statement[..offset]).trim_end()
}

/// Returns the ways to read the rest of a statement as one file name, without repetitions: unchanged, without a
/// comment, and then the same two with each backslash before a blank removed.
fn spellings(statement: &str) -> Vec<Cow<'_, str>> {
    let plain = [statement, without_comment(statement)];
    let unescaped = plain.map(|text| Cow::Owned(text.replace("\\ ", " ")));
    distinct(plain.map(Cow::Borrowed).into_iter().chain(unescaped))
}

/// Returns the items without repetitions, in their order.
fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for item in items {
        if !distinct.contains(&item) {
            distinct.push(item);
        }
    }
    distinct
}

/// Reads the materials in the text of one MTL file. If a name occurs twice, the last definition is used.
fn read_materials(path: &Path, text: &str) -> HashMap<String, Definition> {
    let mut definitions = HashMap::new();
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let mut current: Option<(String, Definition)> = None;
    let mut exporter = Exporter::default();
    // Chooses the law (the meaning of the numbers) of a material whose statements are complete.
    let with_law = |current: Option<(String, Definition)>, exporter| {
        current.map(|(name, mut definition)| {
            definition.choose_law(exporter);
            (name, definition)
        })
    };
    for (index, line) in text.split(separator).enumerate() {
        let line = line.trim();
        let (keyword, arguments) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let arguments = arguments.trim();
        let place = Place { path, line: index + 1 };
        if keyword.eq_ignore_ascii_case("newmtl") {
            definitions.extend(with_law(current.take(), exporter));
            let name = if arguments.is_empty() { NO_MATERIAL } else { arguments };
            current = Some((name.to_owned(), Definition::default()));
        } else if line.starts_with('#') {
            exporter = Exporter::from_comment(line).unwrap_or(exporter);
        } else if let Some((_, definition)) = &mut current {
            read_statement(&place, &keyword.to_ascii_lowercase(), arguments, definition);
        }
    }
    definitions.extend(with_law(current, exporter));
    definitions
}

/// The file and line of a statement.
struct Place<'a> {
    path: &'a Path,
    line: usize,
}

impl std::fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}:{}", self.path.display(), self.line)
    }
}

/// Reads a statement of a material into its definition. `keyword` is in lower case, and `arguments` is the text after
/// the keyword.
fn read_statement(place: &Place, keyword: &str, arguments: &str, definition: &mut Definition) {
    let image = || image_statement(place, arguments);
    match keyword {
        "kd" => definition.diffuse = colour(place, arguments, definition),
        "ks" => definition.specular = colour(place, arguments, definition),
        "ns" => definition.exponent = number(place, arguments, definition),
        "pr" => definition.roughness = number(place, arguments, definition),
        "pm" => definition.metalness = number(place, arguments, definition),
        "ke" => {
            definition.emission = colour(place, arguments, definition);
            if definition.emission.is_some_and(|emission| emission.max_element() > 1.0) {
                definition.note_dropped(place, "emission brighter than 1 counts as 1");
            }
        }
        "ka" => definition.ambient = colour(place, arguments, definition),
        "ni" => definition.ior = number(place, arguments, definition),
        "illum" => definition.model = number(place, arguments, definition).map(|model| model as u32),
        "map_ke" => definition.images.emission = image(),
        "map_pr" => definition.images.roughness = image(),
        "map_pm" => definition.images.metalness = image(),
        "tf" if first_number(arguments).is_some_and(|number| number > 0.0)
            && lost_meaning(keyword, arguments).is_none() =>
        {
            definition.transmission = Some(place.to_string());
        }
        "map_ns" => definition.exponent_image = definition.exponent_image.take().or_else(image),
        "refl" | "map_refl" => definition.reflection_image = definition.reflection_image.take().or_else(image),
        "map_kd" => definition.images.albedo = image(),
        "map_ks" => definition.images.reflectivity = image(),
        "map_d" | "map_opacity" => definition.images.mask = image(),
        "bump" | "map_bump" => definition.images.normal = image(),
        "norm" => {
            definition.images.normal = image().map(|image| ImageStatement { is_normal_map: true, ..image });
        }
        _ => {
            if let Some(sentence) = lost_meaning(keyword, arguments) {
                definition.note_dropped(place, sentence);
            }
        }
    }
}

/// Returns the warning about a statement that is not read, or `None` if nothing is lost, for example because the
/// statement has the default value. `arguments` is the text after the keyword.
fn lost_meaning(keyword: &str, arguments: &str) -> Option<&'static str> {
    let numbers = || arguments.split_whitespace().map_while(|word| word.parse::<f32>().ok());
    let differs_from = |default: f32| numbers().any(|number| number != default);
    // In a `d` statement, the option -halo may precede the number.
    let opacity = arguments.strip_prefix("-halo").unwrap_or(arguments).split_whitespace().next();
    match keyword {
        "d" if opacity.and_then(|word| word.parse::<f32>().ok()).is_some_and(|number| number < 1.0) => {
            Some(TRANSPARENCY)
        }
        "tr" if differs_from(0.0) => Some(TRANSPARENCY),
        "tf" if differs_from(1.0) => Some(TRANSPARENCY),
        "ps" | "pc" | "aniso" if differs_from(0.0) => {
            Some("sheen, clear coats and anisotropy are not supported and were ignored")
        }
        "map_ps" | "map_pc" | "map_pcr" | "map_aniso" | "map_anisor" => {
            Some("sheen, clear coats and anisotropy are not supported and were ignored")
        }
        "disp" | "map_disp" | "decal" | "map_decal" => {
            Some("displacement and decals are not supported and were ignored")
        }
        // Exporters write map_Ka beside an equal map_Kd, and map_aat asks for antialiasing, which textures have anyway.
        "map_ka" | "map_aat" => None,
        _ if keyword.starts_with("map_") => Some("a statement is unknown and was ignored"),
        _ => None,
    }
}

/// The warning about transparency.
const TRANSPARENCY: &str = "transparency (d, Tr, Tf) is not supported; the surface is opaque where it has no map_d";

impl Definition {
    /// Notes a warning about a dropped statement, unless the material has the same warning already.
    fn note_dropped(&mut self, place: &Place, sentence: &'static str) {
        self.note_dropped_at(&place.to_string(), sentence);
    }

    /// Notes a warning like [`Self::note_dropped`], with the place as text.
    fn note_dropped_at(&mut self, place: &str, sentence: &'static str) {
        self.dropped.entry(sentence).or_insert_with(|| place.to_owned());
    }
}

/// Returns the number in the first word of a statement; `None` if it is no number, or not finite.
fn first_number(arguments: &str) -> Option<f32> {
    arguments.split_whitespace().next()?.parse().ok().filter(|number: &f32| number.is_finite())
}

/// Returns the number in the first word of `arguments`, the text of a statement after its keyword. The result is
/// `None`, with a warning, if the word is no finite number.
fn number(place: &Place, arguments: &str, definition: &mut Definition) -> Option<f32> {
    let word = arguments.split_whitespace().next().unwrap_or("");
    let stated = stated_number(word);
    let number = stated.map(|number| number as f32).filter(|number| number.is_finite());
    if number.is_none() {
        let has_comma = stated_number(&word.replace(',', ".")).is_some();
        definition.note_dropped(
            place,
            match stated {
                Some(_) => "a statement with a number that is not finite was ignored",
                None if has_comma => "a statement with a decimal comma was ignored; MTL files have decimal points",
                None => "a statement whose value is no number was ignored",
            },
        );
    }
    number
}

/// Returns the colour of a statement: three numbers, or one for all three channels. The result is `None`, with a
/// warning, for another count, for words that are no finite numbers, and for spectral curves and CIE XYZ. `arguments`
/// is the text after the keyword.
fn colour(place: &Place, arguments: &str, definition: &mut Definition) -> Option<Vec3> {
    let words: Vec<&str> = arguments.split_whitespace().take_while(|word| !word.starts_with('#')).take(3).collect();
    if matches!(words.first(), Some(&("spectral" | "xyz"))) {
        definition.note_dropped(place, "colours as spectral curves or CIE XYZ are not supported and were ignored");
        return None;
    }
    let numbers: Vec<f32> = words.iter().filter_map(|word| number(place, word, definition)).collect();
    match (&numbers[..], words.len()) {
        (&[r, g, b], _) => Some(Vec3::new(r, g, b)),
        (&[grey], 1) => Some(Vec3::splat(grey)),
        (numbers, word_count) => {
            if numbers.len() == word_count {
                definition.note_dropped(place, "a colour that has neither one number nor three was ignored");
            }
            None
        }
    }
}
