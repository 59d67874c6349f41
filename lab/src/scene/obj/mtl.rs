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

use super::images::{ImageStatement, MaterialImages, resolve};
use super::{read_limited, text::NO_MATERIAL};
use crate::error::{Error, Result};
use crate::scene::material_terms::roughness_of_exponent;
use crate::scene::{Material, texture::luminance};
use glam::Vec3;
use std::collections::HashMap;
use std::path::Path;

/// One `newmtl` block.
#[derive(Debug, Clone, Default)]
pub(super) struct Definition {
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    exponent: Option<f32>,
    roughness: Option<f32>,
    images: MaterialImages,
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
) -> Result<HashMap<String, Definition>> {
    let folder = obj_path.parent().unwrap_or(Path::new(""));
    let mut definitions = HashMap::new();
    let mut seen = Vec::new();
    for (line, statement) in statements {
        let files = match resolve(folder, statement) {
            Some(path) => vec![(statement.as_str(), Some(path))],
            None => statement.split_whitespace().map(|name| (name, resolve(folder, name))).collect(),
        };
        for (name, path) in files {
            if seen.contains(&name) {
                continue;
            }
            seen.push(name);
            match path {
                Some(path) => {
                    let bytes = read_limited(&path)?;
                    read(&path, &String::from_utf8_lossy(&bytes), &mut definitions)?;
                }
                None => warnings.push(format!(
                    "{}:{line}: the MTL file {name} is missing; its materials are white",
                    obj_path.display()
                )),
            }
        }
    }
    Ok(definitions)
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
        "kd" => definition.diffuse = colour(place, keyword, rest)?,
        "ks" => definition.specular = colour(place, keyword, rest)?,
        "ns" => definition.exponent = Some(number(place, keyword, rest)?),
        "pr" => definition.roughness = Some(number(place, keyword, rest)?),
        "map_kd" => definition.images.albedo = image(),
        "map_ks" => definition.images.reflectivity = image(),
        "map_d" | "map_opacity" => definition.images.mask = image(),
        "bump" | "map_bump" | "norm" => definition.images.normal = image(),
        _ => {}
    }
    Ok(())
}

fn number(place: &Place, keyword: &str, rest: &str) -> Result<f32> {
    let word = rest.split_whitespace().next().unwrap_or("");
    word.parse().ok().filter(|n: &f32| n.is_finite()).ok_or_else(|| {
        let message = format!("{keyword} needs a finite number, not {word:?}");
        Error::malformed(place.path, Some(place.line), message)
    })
}

/// A colour given as three numbers, or as one number for all three channels. Spectral curves and CIE XYZ are
/// not supported.
fn colour(place: &Place, keyword: &str, rest: &str) -> Result<Option<Vec3>> {
    let words: Vec<&str> = rest.split_whitespace().take_while(|w| !w.starts_with('#')).collect();
    if matches!(words.first(), Some(&("spectral" | "xyz"))) {
        return Ok(None);
    }
    let numbers = words.iter().take(3).map(|w| number(place, keyword, w)).collect::<Result<Vec<_>>>()?;
    match numbers[..] {
        [r, g, b] => Ok(Some(Vec3::new(r, g, b))),
        [grey] => Ok(Some(Vec3::splat(grey))),
        _ => {
            let message = format!("{keyword} needs three numbers, not {}", numbers.len());
            Err(Error::malformed(place.path, Some(place.line), message))
        }
    }
}

/// Parses the options and the file name of a map; `None` if there is no file name.
fn image_statement(place: &Place, rest: &str) -> Option<ImageStatement> {
    let mut rest = rest;
    let mut multiplier = 1.0;
    let mut transformed = false;
    while rest.starts_with('-') {
        let (option, mut after) = take_word(rest);
        // The most words that belong to the option, and whether they must be numbers.
        let (most, numeric) = match option {
            "-bm" | "-boost" | "-texres" => (1, true),
            "-mm" => (2, true),
            "-o" | "-s" | "-t" => (3, true),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" => (1, false),
            _ => break,
        };
        for i in 0..most {
            let (word, further) = take_word(after);
            let value = word.parse::<f32>().ok().filter(|v| v.is_finite());
            if (numeric && value.is_none()) || further.is_empty() {
                break;
            }
            match (option, value) {
                ("-bm", Some(value)) => multiplier = value.clamp(-16.0, 16.0),
                ("-o" | "-t", Some(value)) => transformed |= value != 0.0,
                ("-s", Some(value)) => transformed |= value != 1.0 && i < 2,
                _ => {}
            }
            after = further;
        }
        rest = after;
    }
    let name = rest.trim_matches('"').trim();
    (!name.is_empty()).then(|| ImageStatement {
        name: name.to_owned(),
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
        assert_eq!(image("  "), None);
    }
}
