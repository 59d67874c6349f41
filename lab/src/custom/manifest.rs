//! Reads the manifest of a method's folder and checks it as a whole. `sections` has its sections as they are written,
//! `passes` checks each pass, and `parameters` makes the method's parameters.

mod parameters;
mod passes;
mod sections;

pub use passes::{InputKind, LevelOf, Pass, PassDomain};
pub use sections::{Alpha, HitEncoding, ImageSection, PassStage, SamplerName};

use super::MANIFEST;
use super::conventions::Conventions;
use super::source::ImageSource;
use ash::vk;
use passes::KnownNames;
use sections::{BufferSection, OutputSection, ParameterSection, Sections};
use ssct_ground::{Error, Result};
use ssct_scenes::source_text::{self, SourceText};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// The largest manifest, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The longest time of a frame, if the manifest gives none.
const PATIENCE: Duration = Duration::from_secs(60);

/// Greatest ratio of an image's side to the frame's side.
const MOST_SCALE: f32 = 4.0;

/// The most bytes that a buffer can have at any size of the frame: 64 GiB, so that sums with bytes for each pixel fit.
const MOST_BUFFER_BYTES: u64 = 1 << 36;

/// A checked manifest.
#[derive(Debug, Clone)]
pub struct Manifest {
    /// The folder of the manifest.
    pub folder: PathBuf,
    /// The text of the manifest, for messages about places in it.
    text: String,
    /// The name of the method.
    pub name: String,
    /// One sentence about the method.
    pub summary: String,
    /// The document that the method comes from.
    pub source: String,
    /// The conventions of the shaders.
    pub conventions: Conventions,
    /// The folder for includes that are not beside the file that includes them.
    pub include: PathBuf,
    /// True if the method follows rays in captures.
    pub captures: bool,
    /// The longest time that a frame may take.
    pub patience: Duration,
    /// The parameters by name, in the order of the manifest.
    parameters: Vec<(String, Spanned<ParameterSection>)>,
    /// The method's own images, by name.
    pub images: BTreeMap<String, ImageSection>,
    /// The method's own buffers, by name.
    pub buffers: BTreeMap<String, BufferSection>,
    /// The passes in the order in which they run.
    pub passes: Vec<Pass>,
    /// The images that the method returns.
    pub output: OutputSection,
}

impl Manifest {
    /// Reads `method.toml` of a folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST);
        let text = source_text::read(&path, "a manifest", MAX_BYTES)?;
        let source = SourceText { path: &path, text: &text };
        let sections: Sections = source.deserialized().map_err(|error| list_missing_keys(&source, error))?;
        Self::checked(folder, text, sections)
    }

    /// Checks the sections of a manifest one by one and against each other.
    fn checked(folder: &Path, text: String, sections: Sections) -> Result<Self> {
        let path = folder.join(MANIFEST);
        let source = SourceText { path: &path, text: &text };
        let name = sections.name.get_ref();
        if !is_word(name) {
            let message = format!("the name {name:?} must consist of small letters, digits and hyphens");
            return Err(source.error(sections.name.span(), message));
        }
        let patience = match &sections.patience_s {
            None => PATIENCE,
            Some(s) if *s.get_ref() > 0.0 && *s.get_ref() <= 1e5 => Duration::from_secs_f64(*s.get_ref()),
            Some(s) => return Err(source.error(s.span(), "patience-s must be above 0 and at most 100000 seconds")),
        };
        let images = check_images(&sections.image, &source)?;
        let buffers = check_buffers(&sections.buffer, &images, &source)?;
        if sections.pass.is_empty() {
            return Err(Error::malformed(&path, None, "there is no [[pass]]"));
        }
        let passes = check_passes(folder, &sections, &KnownNames { images: &images, buffers: &buffers }, &source)?;
        check_output(&sections.output, &images, &source)?;
        check_histories(&sections.image, &passes, &source)?;
        let mut parameters: Vec<_> = sections.parameter.into_iter().collect();
        parameters.sort_by_key(|(_, section)| section.span().start);
        Ok(Self {
            folder: folder.to_path_buf(),
            name: name.clone(),
            summary: sections.summary,
            source: sections.source.unwrap_or_else(|| "a folder".to_owned()),
            conventions: sections.conventions,
            include: folder.join(sections.include.unwrap_or_default()),
            captures: sections.captures,
            patience,
            parameters,
            images,
            buffers,
            passes,
            output: sections.output.into_inner(),
            text,
        })
    }

    /// Makes an error at a place of the manifest.
    pub fn error(&self, span: &Range<usize>, message: impl Into<String>) -> Error {
        SourceText { path: &self.folder.join(MANIFEST), text: &self.text }.error(span.clone(), message)
    }

    /// True if a value of this name feeds a shader.
    pub fn reads_value(&self, name: &str) -> bool {
        self.passes.iter().any(|p| p.values.values().any(|(feed, _)| feed.is_named(name)))
    }
}

/// Checks the sections of images, and returns them by name.
fn check_images(
    sections: &BTreeMap<String, Spanned<ImageSection>>,
    source: &SourceText,
) -> Result<BTreeMap<String, ImageSection>> {
    for (name, image) in sections {
        let section = image.get_ref();
        let fault = if format_of(&section.format).is_none() {
            let known = FORMATS.map(|(name, _)| name).join(", ");
            format!("no format {:?}; there is: {known}", section.format)
        } else if section.format.ends_with('i') && section.clear.number().is_some_and(|number| number != 0.0) {
            format!("{} has whole numbers, which are cleared to 0 alone (true)", section.format)
        } else if !(section.scale > 0.0 && section.scale <= MOST_SCALE) {
            format!("the scale must be above 0 and at most {MOST_SCALE}")
        } else {
            continue;
        };
        return Err(source.error(image.span(), format!("image {name}: {fault}")));
    }
    Ok(sections.iter().map(|(name, image)| (name.clone(), image.get_ref().clone())).collect())
}

/// Checks the sections of buffers, and returns them by name.
fn check_buffers(
    sections: &BTreeMap<String, Spanned<BufferSection>>,
    images: &BTreeMap<String, ImageSection>,
    source: &SourceText,
) -> Result<BTreeMap<String, BufferSection>> {
    for (name, buffer) in sections {
        let section = buffer.get_ref();
        if !(0.0..=1024.0).contains(&section.bytes_per_pixel) || (section.bytes == 0 && section.bytes_per_pixel == 0.0)
        {
            let message = format!("buffer {name} needs bytes, or bytes-per-pixel up to 1024, or both");
            return Err(source.error(buffer.span(), message));
        }
        if section.bytes > MOST_BUFFER_BYTES {
            let message = format!("buffer {name}: bytes must be at most {MOST_BUFFER_BYTES}");
            return Err(source.error(buffer.span(), message));
        }
        if images.contains_key(name) {
            return Err(source.error(buffer.span(), format!("{name} is the name of an image already")));
        }
    }
    Ok(sections.iter().map(|(name, buffer)| (name.clone(), buffer.get_ref().clone())).collect())
}

/// Checks the passes, each by itself and against the passes before it, and returns them in their order.
fn check_passes(folder: &Path, sections: &Sections, known: &KnownNames, source: &SourceText) -> Result<Vec<Pass>> {
    let parameters: Vec<String> = sections.parameter.keys().cloned().collect();
    let mut passes: Vec<Pass> = Vec::new();
    for section in &sections.pass {
        let pass = known.pass(folder, section, (&sections.inputs, &sections.values), &parameters, source)?;
        if pass.interleaved && passes.last().is_none_or(|before| before.levels != pass.levels) {
            let message =
                format!("pass {:?} is interleaved, and no pass with the same levels stands before it", pass.name);
            return Err(source.error(section.span(), message));
        }
        if passes.iter().any(|before| before.name == pass.name) {
            return Err(source.error(section.span(), format!("there are two passes {:?}", pass.name)));
        }
        passes.push(pass);
    }
    Ok(passes)
}

/// Checks that the images which a method returns exist, and that hits are encoded in an image that can hold them.
fn check_output(
    section: &Spanned<OutputSection>,
    images: &BTreeMap<String, ImageSection>,
    source: &SourceText,
) -> Result<()> {
    let output = section.get_ref();
    for image in [Some(&output.reflection), output.hits.as_ref()].into_iter().flatten() {
        if !images.contains_key(image) {
            return Err(source.error(section.span(), format!("output: there is no [image.{image}]")));
        }
    }
    if output.hits_are == HitEncoding::UvDepthPath
        && let Some(hits) = output.hits.as_ref().and_then(|name| images.get(name))
        && (hits.format != "rgba32f" || hits.scale != 1.0 || hits.levels != 1)
    {
        let message = "output: hits that are uv-depth-path stand in an image of the format rgba32f and the scale 1, with \
                       one level";
        return Err(source.error(section.span(), message));
    }
    Ok(())
}

/// Checks that an image has a history if and only if a pass reads the image as it was in the frame before.
fn check_histories(
    images: &BTreeMap<String, Spanned<ImageSection>>,
    passes: &[Pass],
    source: &SourceText,
) -> Result<()> {
    for (name, image) in images {
        let previous = InputKind::Image(ImageSource::Previous(Box::new(ImageSource::Own(name.clone()))));
        let is_read = passes.iter().flat_map(|pass| pass.inputs.values()).any(|input| input.what == previous);
        let fault = match (image.get_ref().history, is_read) {
            (true, false) => "has a history that no pass reads",
            (false, true) => "is read as it was in the frame before without history = true",
            _ => continue,
        };
        return Err(source.error(image.span(), format!("image {name} {fault}")));
    }
    Ok(())
}

/// The form in which a table is written in a manifest.
#[derive(Clone, Copy)]
enum TableForm {
    /// Keys at the top of the manifest.
    Top,
    /// `[table]`.
    Once,
    /// `[table.name]`.
    ByName,
    /// `[[table]]`.
    InOrder,
}

/// Tables of a manifest, and the keys that each of them must have.
const REQUIRED: [(&str, TableForm, &[&str]); 5] = [
    ("", TableForm::Top, &["name", "summary", "pass", "output"]),
    ("parameter", TableForm::ByName, &["help", "default"]),
    ("image", TableForm::ByName, &["format"]),
    ("output", TableForm::Once, &["reflection"]),
    ("pass", TableForm::InOrder, &["name", "shader"]),
];

/// Replaces an error about one missing key by an error that lists all missing keys; returns any other error unchanged.
fn list_missing_keys(source: &SourceText, error: Error) -> Error {
    let message = error.to_string();
    if message.contains("unknown field") || !message.contains("missing field") {
        return error;
    }
    let missing = toml::from_str::<toml::Table>(source.text).map_or(Vec::new(), |table| missing_keys(&table));
    let verb = match missing.len() {
        0 => return error,
        1 => "is",
        _ => "are",
    };
    Error::malformed(source.path, None, format!("{} {verb} missing", missing.join(", ")))
}

/// Returns every key that a manifest must have and lacks, such as `image.result.format`.
fn missing_keys(manifest: &toml::Table) -> Vec<String> {
    let mut missing = Vec::new();
    for (name, form, keys) in REQUIRED {
        for (place, table) in find_tables(manifest, name, form) {
            missing.extend(keys.iter().filter(|key| !table.contains_key(**key)).map(|key| format!("{place}{key}")));
        }
    }
    missing
}

/// Returns the tables with a name, which are written in the given form. Each comes with the text that stands before its
/// keys in messages.
fn find_tables<'t>(manifest: &'t toml::Table, name: &str, form: TableForm) -> Vec<(String, &'t toml::Table)> {
    let value = manifest.get(name);
    let table = value.and_then(toml::Value::as_table);
    let list = value.and_then(toml::Value::as_array).into_iter().flatten();
    match form {
        TableForm::Top => vec![(String::new(), manifest)],
        TableForm::Once => table.map(|table| (format!("{name}."), table)).into_iter().collect(),
        TableForm::ByName => {
            let named = table.into_iter().flatten();
            named.filter_map(|(key, value)| Some((format!("{name}.{key}."), value.as_table()?))).collect()
        }
        TableForm::InOrder => {
            list.zip(1..).filter_map(|(value, n)| Some((format!("{name} {n}: "), value.as_table()?))).collect()
        }
    }
}

/// True for a name of small letters, digits and hyphens alone, which a flag or a file can have unchanged.
fn is_word(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
}

/// The formats that a method's own images can have, by their names in manifests.
const FORMATS: [(&str, vk::Format); 16] = [
    ("r8", vk::Format::R8_UNORM),
    ("rg8", vk::Format::R8G8_UNORM),
    ("rgba8", vk::Format::R8G8B8A8_UNORM),
    ("rgba8-srgb", vk::Format::R8G8B8A8_SRGB),
    ("r16f", vk::Format::R16_SFLOAT),
    ("rg16f", vk::Format::R16G16_SFLOAT),
    ("rgba16f", vk::Format::R16G16B16A16_SFLOAT),
    ("r32f", vk::Format::R32_SFLOAT),
    ("rg32f", vk::Format::R32G32_SFLOAT),
    ("rgba32f", vk::Format::R32G32B32A32_SFLOAT),
    ("r32ui", vk::Format::R32_UINT),
    ("rg32ui", vk::Format::R32G32_UINT),
    ("rgba32ui", vk::Format::R32G32B32A32_UINT),
    ("r32i", vk::Format::R32_SINT),
    ("r11f-g11f-b10f", vk::Format::B10G11R11_UFLOAT_PACK32),
    ("rgb10-a2", vk::Format::A2B10G10R10_UNORM_PACK32),
];

/// The image format that manifests call `name`; `None` if there is no format of this name.
pub fn format_of(name: &str) -> Option<vk::Format> {
    FORMATS.iter().find(|(known, _)| *known == name).map(|(_, format)| *format)
}
