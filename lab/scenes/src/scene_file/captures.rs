//! Reads and writes the `[[capture]]` tables ([`crate::capture`]) of scene files and of the list in a folder of
//! captures ([`crate::capture_file`]).

use crate::capture::{Capture, MAX_CAPTURES, MAX_RESOLUTION};
use crate::obj::Handedness;
use crate::source_text::{self, SourceText};
use crate::{Aabb, gltf};
use serde::Deserialize;
use ssct_ground::{Error, Result};
use std::path::Path;
use toml::Spanned;

/// The contents of the list of a folder of captures.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListOfCaptures {
    /// The least and the greatest corner of the scene's bounds.
    bounds: Option<Spanned<[[f32; 3]; 2]>>,
    #[serde(default)]
    capture: Vec<Spanned<CaptureSection>>,
}

/// Reads the list of a folder of captures: at least one `[[capture]]` table, all with one near plane. Returns the
/// captures and the `bounds` of the list, a box outside of which there is no surface; the default is [`Aabb::ALL`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Malformed`], with the line if known, for any other fault.
pub(crate) fn load_list(path: &Path) -> Result<(Vec<Capture>, Aabb)> {
    let text = source_text::read(path, "a list of captures", crate::source_text::MAX_FILE_BYTES)?;
    let source = SourceText { path, text: &text };
    let list: ListOfCaptures = source.deserialized()?;
    let captures = source.captures(&list.capture, 1.0)?;
    let Some(first) = captures.first() else {
        return Err(Error::malformed(path, None, "it lists no captures"));
    };
    if let Some((other, section)) =
        captures.iter().zip(&list.capture).find(|(capture, _)| capture.near_m != first.near_m)
    {
        let message = format!(
            "all captures of a folder have one near plane: this one has {} m, the first has {} m",
            other.near_m, first.near_m
        );
        return Err(source.error(section.span(), message));
    }
    let checked_bounds = |stated: &Spanned<[[f32; 3]; 2]>| {
        let message = "bounds must be the least and the greatest corner of a box, of finite numbers";
        Aabb::between(*stated.get_ref()).ok_or_else(|| source.error(stated.span(), message))
    };
    let bounds = list.bounds.as_ref().map_or(Ok(Aabb::ALL), checked_bounds)?;
    Ok((captures, bounds))
}

/// A `[[capture]]` table; lengths are in metres.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaptureSection {
    place: Spanned<[f32; 3]>,
    resolution: Option<Spanned<u32>>,
    near: Option<Spanned<f32>>,
}

/// Returns the text of a scene file with other captures. Its `[[capture]]` tables are removed, and tables of
/// `captures`, in the coordinates of the file, follow at the end. The other text is not changed. `path` names the file
/// in errors.
///
/// # Errors
/// [`Error::Malformed`] if the text is no TOML, is the list of a folder of captures, or states captures in another form
/// than `[[capture]]` tables.
pub fn with_captures(text: &str, captures: &[Capture], path: &Path) -> Result<String> {
    let source = SourceText { path, text };
    // Parses everything in a text but its captures, which must be the same before and after the replacement.
    let without_captures = |text: &str| {
        let mut table: toml::Table = toml::from_str(text)?;
        table.remove("capture");
        Ok(table)
    };
    let before = without_captures(text).map_err(|e| source.syntax_error(&e))?;
    if before.contains_key("bounds") {
        let message =
            "it is the list of a folder of captures, whose images stay where they were captured; name another file";
        return Err(Error::malformed(path, None, message));
    }
    // Lines are kept unless they belong to a [[capture]] table, which ends where the next table begins.
    let mut is_capture = false;
    let mut other_lines = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with('[') {
            is_capture = line.replace(char::is_whitespace, "").starts_with("[[capture]]");
        }
        if !is_capture {
            other_lines.push_str(line);
            other_lines.push('\n');
        }
    }
    let coordinates = coordinates(&before);
    let tables = captures.iter().map(|capture| coordinates.capture(*capture).to_toml()).collect::<Vec<_>>().join("\n");
    let new_text =
        if other_lines.trim().is_empty() { tables } else { format!("{}\n\n{tables}", other_lines.trim_end()) };
    if without_captures(&new_text).ok() != Some(before) {
        let message = "it names captures by other tables than [[capture]], which cannot be replaced";
        return Err(Error::malformed(path, None, message));
    }
    Ok(new_text)
}

/// Returns the coordinates of the positions in a scene file, whose other contents may be faulty.
fn coordinates(file: &toml::Table) -> Handedness {
    let stated = |key: &str| file.get(key).and_then(|value| value.clone().try_into().ok());
    let meshes = file.get("mesh").and_then(toml::Value::as_array).into_iter().flatten();
    let mut files = meshes.filter_map(|mesh| mesh.get("file").and_then(toml::Value::as_str));
    Handedness::of_places(
        stated("coordinates"),
        stated("handedness"),
        files.any(|name| !gltf::is_named(Path::new(name))),
    )
}

impl SourceText<'_> {
    /// Reads and checks `[[capture]]` tables, in the order of the file. Lengths are multiplied by `extra_scale`.
    pub(super) fn captures(&self, sections: &[Spanned<CaptureSection>], extra_scale: f32) -> Result<Vec<Capture>> {
        let mut captures: Vec<Capture> = Vec::new();
        for section in sections {
            let resolution_span = || section.get_ref().resolution.as_ref().map_or(section.span(), Spanned::span);
            let capture = self.capture(section.get_ref(), extra_scale)?;
            if captures.len() == MAX_CAPTURES {
                return Err(self.error(section.span(), format!("a scene has at most {MAX_CAPTURES} captures")));
            }
            if let Some(first) =
                captures.first().map(|first| first.resolution).filter(|first| *first != capture.resolution)
            {
                let message = format!(
                    "all captures of a scene have one resolution: this one has {}, the first has {first}",
                    capture.resolution
                );
                return Err(self.error(resolution_span(), message));
            }
            captures.push(capture);
        }
        Ok(captures)
    }

    /// Reads and checks one `[[capture]]` table, whose lengths are multiplied by `extra_scale`.
    fn capture(&self, section: &CaptureSection, extra_scale: f32) -> Result<Capture> {
        let resolution = match &section.resolution {
            Some(stated) if !(1..=MAX_RESOLUTION).contains(stated.get_ref()) => {
                let message = format!("resolution must lie in 1 to {MAX_RESOLUTION}, but is {}", stated.get_ref());
                return Err(self.error(stated.span(), message));
            }
            stated => stated.as_ref().map_or(Capture::RESOLUTION, |resolution| *resolution.get_ref()),
        };
        let mut near_m = Capture::NEAR_M * extra_scale;
        if let Some(near) = &section.near {
            near_m = self.positive("near", near)? * extra_scale;
            if !near_m.is_finite() {
                return Err(self.error(near.span(), format!("near is too large: {}", near.get_ref())));
            }
        }
        Ok(Capture { position: self.place("place", &section.place, extra_scale)?, near_m, resolution })
    }
}
