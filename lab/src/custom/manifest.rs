//! The manifest of a method's folder, checked.

use super::MANIFEST;
use super::source::ImageSource;
use super::values::Feed;
use crate::error::{Error, Result};
use crate::parameter::{Choice, Domain, Parameter, Preset, Value};
use ash::vk;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// The largest manifest, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// How long a frame may take, if the manifest does not say.
const PATIENCE: Duration = Duration::from_secs(60);

/// The most texels of an image's side over those of the frame.
const MOST_SCALE: f32 = 4.0;

/// A checked manifest.
#[derive(Debug, Clone)]
pub struct Manifest {
    /// Where it lies.
    pub folder: PathBuf,
    text: String,
    pub name: String,
    pub summary: String,
    pub source: String,
    pub conventions: Conventions,
    /// Where includes are looked for that do not stand beside the file that includes them.
    pub include: PathBuf,
    pub captures: bool,
    /// How long a frame may take.
    pub patience: Duration,
    parameters: Vec<(String, Spanned<ParameterSection>)>,
    pub images: BTreeMap<String, ImageSection>,
    pub buffers: BTreeMap<String, BufferSection>,
    pub passes: Vec<Pass>,
    pub output: OutputSection,
}

/// In which conventions a shader thinks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Conventions {
    /// Which hand view space follows: `left`, looking along +z, `right`, along −z, or `right-z-up`, along +y.
    #[serde(default)]
    pub view: Hand,
    /// Which hand world space follows: `left`, `right`, in which z is turned, or `right-z-up`, in which y and z change places.
    #[serde(default)]
    pub world: Hand,
    /// How matrices lie in memory.
    #[serde(default)]
    pub matrices: MatrixLayout,
    /// Which way y of clip space points.
    #[serde(default)]
    pub clip_y: ClipAxis,
    /// The depth of clip space that matrices give.
    #[serde(default)]
    pub clip_depth: ClipDepth,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hand {
    #[default]
    Left,
    Right,
    /// x to the right, y forwards, z up.
    RightZUp,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MatrixLayout {
    #[default]
    Columns,
    Rows,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClipAxis {
    #[default]
    Up,
    Down,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClipDepth {
    #[default]
    Standard,
    Reversed,
    /// From −1 to 1, as OpenGL has it.
    MinusOneToOne,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Sections {
    name: Spanned<String>,
    summary: String,
    #[serde(default)]
    source: Option<String>,
    #[serde(default)]
    include: Option<PathBuf>,
    #[serde(default)]
    captures: bool,
    #[serde(default)]
    patience_s: Option<Spanned<f64>>,
    #[serde(default)]
    conventions: Conventions,
    #[serde(default)]
    parameter: BTreeMap<String, Spanned<ParameterSection>>,
    #[serde(default)]
    image: BTreeMap<String, Spanned<ImageSection>>,
    #[serde(default)]
    buffer: BTreeMap<String, Spanned<BufferSection>>,
    #[serde(default)]
    inputs: BTreeMap<String, Spanned<InputSection>>,
    #[serde(default)]
    values: BTreeMap<String, Spanned<toml::Value>>,
    pass: Vec<Spanned<PassSection>>,
    output: Spanned<OutputSection>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct ParameterSection {
    help: String,
    default: toml::Value,
    #[serde(default)]
    range: Option<[f64; 2]>,
    #[serde(default)]
    choices: Vec<String>,
    #[serde(default)]
    unit: String,
    #[serde(default)]
    sweep: Vec<toml::Value>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ImageSection {
    /// Name of the format.
    pub format: String,
    /// Its side over that of the frame.
    #[serde(default = "one")]
    pub scale: f32,
    /// Levels; 0 for all.
    #[serde(default = "one_level")]
    pub levels: u32,
    /// Whether what it held in the frame before can be read.
    #[serde(default)]
    pub history: bool,
    /// Whether it is cleared to 0 at the beginning of each frame.
    #[serde(default)]
    pub clear: bool,
}

fn one() -> f32 {
    1.0
}

fn one_level() -> u32 {
    1
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BufferSection {
    /// Bytes, whatever the frame's size.
    #[serde(default)]
    pub bytes: u64,
    /// Further bytes for each pixel.
    #[serde(default)]
    pub bytes_per_pixel: f64,
    /// The word that it is filled with at the beginning of each frame.
    #[serde(default)]
    pub fill: Option<u32>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum InputSection {
    Plain(String),
    With { image: String, sampler: SamplerName },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerName {
    Nearest,
    Linear,
    Repeat,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct PassSection {
    name: Spanned<String>,
    shader: Spanned<PathBuf>,
    #[serde(default)]
    stage: Option<PassStage>,
    #[serde(default)]
    defines: Vec<String>,
    #[serde(default)]
    targets: Vec<Spanned<String>>,
    #[serde(default)]
    threads: Option<Spanned<String>>,
    #[serde(default)]
    workgroups: Option<[u32; 3]>,
    #[serde(default)]
    indirect: Option<Spanned<String>>,
    #[serde(default)]
    levels: Option<[u32; 2]>,
    #[serde(default)]
    inputs: BTreeMap<String, Spanned<InputSection>>,
    #[serde(default)]
    values: BTreeMap<String, Spanned<toml::Value>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassStage {
    Fragment,
    Compute,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct OutputSection {
    /// The image with the reflection.
    pub reflection: String,
    /// What is in its fourth channel.
    #[serde(default)]
    pub alpha: Alpha,
    /// The image with the hits.
    #[serde(default)]
    pub hits: Option<String>,
    /// How they are encoded.
    #[serde(default)]
    pub hits_are: HitEncoding,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alpha {
    #[default]
    Fade,
    Premultiplied,
    None,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HitEncoding {
    #[default]
    Uv,
    UvMasked,
    UvDepth,
    Pixel,
    ViewPosition,
}

/// Which level of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelOf {
    /// All of them, of an image that is sampled.
    All,
    /// This one.
    Number(u32),
    /// The one that the pass is recorded for, less so many.
    Current(u32),
}

/// What a name of a shader stands for.
#[derive(Debug, Clone)]
pub struct PassInput {
    pub what: InputKind,
    pub sampler: Option<SamplerName>,
    pub level: LevelOf,
    at: Range<usize>,
}

/// An image or a buffer.
#[derive(Debug, Clone, PartialEq)]
pub enum InputKind {
    Image(ImageSource),
    Buffer(String),
}

/// A pass, checked but for what its shader says.
#[derive(Debug, Clone)]
pub struct Pass {
    pub name: String,
    pub shader: PathBuf,
    pub stage: PassStage,
    pub defines: Vec<String>,
    pub targets: Vec<(String, LevelOf)>,
    pub reach: PassReach,
    /// The levels that it is recorded for, one after another, both ends included.
    pub levels: Option<[u32; 2]>,
    pub inputs: BTreeMap<String, PassInput>,
    pub values: BTreeMap<String, (Feed, Range<usize>)>,
    pub at: Range<usize>,
}

/// How far a compute pass reaches.
#[derive(Debug, Clone, PartialEq)]
pub enum PassReach {
    /// A fragment pass: over its targets.
    Targets,
    /// A thread for each texel of an image's level.
    Threads(String, LevelOf),
    Workgroups([u32; 3]),
    Indirect(String),
}

impl Manifest {
    /// Reads `method.toml` of a folder.
    ///
    /// # Errors
    /// [`Error::Io`] without one; [`Error::Malformed`] with the line of what is wrong.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST);
        let text = read_text(&path, "a manifest", MAX_BYTES)?;
        let sections: Sections = toml::from_str(&text).map_err(|e| {
            let line = e.span().map(|span| line_of(&text, span.start));
            Error::malformed(&path, line, e.message().trim().replace('\n', "; "))
        })?;
        Self::checked(folder, text, sections)
    }

    fn checked(folder: &Path, text: String, sections: Sections) -> Result<Self> {
        let path = folder.join(MANIFEST);
        let wrong =
            |at: Range<usize>, message: String| Error::malformed(&path, Some(line_of(&text, at.start)), message);
        let name = sections.name.get_ref();
        let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || !name.chars().all(is_word) {
            let message = format!("the name {name:?} must consist of small letters, digits and hyphens");
            return Err(wrong(sections.name.span(), message));
        }
        let patience = match &sections.patience_s {
            None => PATIENCE,
            Some(s) if *s.get_ref() > 0.0 && *s.get_ref() <= 1e5 => Duration::from_secs_f64(*s.get_ref()),
            Some(s) => return Err(wrong(s.span(), "patience-s must be above 0 and at most 100000 seconds".into())),
        };
        for (name, image) in &sections.image {
            let of = image.get_ref();
            if format_of(&of.format).is_none() {
                let known = FORMATS.map(|(name, _)| name).join(", ");
                return Err(wrong(image.span(), format!("image {name}: no format {:?}; there is: {known}", of.format)));
            }
            if !(of.scale > 0.0 && of.scale <= MOST_SCALE) {
                return Err(wrong(
                    image.span(),
                    format!("image {name}: the scale must be above 0 and at most {MOST_SCALE}"),
                ));
            }
        }
        let images: BTreeMap<String, ImageSection> =
            sections.image.iter().map(|(name, image)| (name.clone(), image.get_ref().clone())).collect();
        let buffers: BTreeMap<String, BufferSection> =
            sections.buffer.iter().map(|(name, b)| (name.clone(), b.get_ref().clone())).collect();
        for (name, buffer) in &sections.buffer {
            let of = buffer.get_ref();
            if !(0.0..=1024.0).contains(&of.bytes_per_pixel) || (of.bytes == 0 && of.bytes_per_pixel == 0.0) {
                let message = format!("buffer {name} needs bytes, or bytes-per-pixel up to 1024, or both");
                return Err(wrong(buffer.span(), message));
            }
            if images.contains_key(name) {
                return Err(wrong(buffer.span(), format!("{name} is the name of an image already")));
            }
        }
        let known = Known { images: &images, buffers: &buffers };
        let parameters: Vec<String> = sections.parameter.keys().cloned().collect();
        let mut ordered: Vec<_> = sections.parameter.into_iter().collect();
        ordered.sort_by_key(|(_, section)| section.span().start);
        let mut passes = Vec::new();
        let mut names: Vec<String> = Vec::new();
        if sections.pass.is_empty() {
            return Err(Error::malformed(&path, None, "there is no [[pass]]"));
        }
        for pass in &sections.pass {
            let checked = known.pass(folder, pass, (&sections.inputs, &sections.values), &parameters, &wrong)?;
            if names.contains(&checked.name) {
                return Err(wrong(pass.span(), format!("there are two passes {:?}", checked.name)));
            }
            names.push(checked.name.clone());
            passes.push(checked);
        }
        let output = sections.output.get_ref().clone();
        for image in [Some(&output.reflection), output.hits.as_ref()].into_iter().flatten() {
            if !images.contains_key(image) {
                let message = format!("output: there is no [image.{image}]");
                return Err(wrong(sections.output.span(), message));
            }
        }
        for (name, image) in &sections.image {
            let previous = ImageSource::Previous(Box::new(ImageSource::Own(name.clone())));
            let reads = |p: &Pass| p.inputs.values().any(|i| i.what == InputKind::Image(previous.clone()));
            if image.get_ref().history != passes.iter().any(reads) {
                let (has, or) = if image.get_ref().history {
                    ("has a history that no pass reads", "")
                } else {
                    ("is read as it was in the frame before", " without history = true")
                };
                return Err(wrong(image.span(), format!("image {name} {has}{or}")));
            }
        }
        Ok(Self {
            folder: folder.to_path_buf(),
            name: name.clone(),
            summary: sections.summary,
            source: sections.source.unwrap_or_else(|| "a folder".to_owned()),
            conventions: sections.conventions,
            include: folder.join(sections.include.unwrap_or_default()),
            captures: sections.captures,
            patience,
            parameters: ordered,
            images,
            buffers,
            passes,
            output,
            text,
        })
    }

    /// An error at a place of the manifest.
    pub fn error(&self, at: &Range<usize>, message: impl Into<String>) -> Error {
        Error::malformed(self.folder.join(MANIFEST), Some(line_of(&self.text, at.start)), message)
    }

    /// Whether a value of this name feeds a shader.
    pub fn reads_value(&self, name: &str) -> bool {
        self.passes.iter().any(|p| p.values.values().any(|(given, _)| given.is_named(name)))
    }

    /// Its own parameters. What they borrow lives as long as the program.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a default outside its range, and the like.
    pub fn parameters(&self) -> Result<Vec<Parameter>> {
        self.parameters.iter().map(|(name, section)| self.parameter(name, section)).collect()
    }

    fn parameter(&self, name: &str, section: &Spanned<ParameterSection>) -> Result<Parameter> {
        let at = section.span();
        let of = section.get_ref();
        let wrong = |message: &str| self.error(&at, format!("parameter {name}: {message}"));
        let leak = |text: &str| -> &'static str { text.to_owned().leak() };
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-') {
            return Err(wrong("the name must consist of small letters, digits and hyphens"));
        }
        let choices: &'static [Choice] =
            of.choices.iter().map(|c| Choice { name: leak(c), help: "" }).collect::<Vec<_>>().leak();
        let value = |value: &toml::Value| -> Option<Value> {
            Some(match value {
                toml::Value::Boolean(on) => Value::Switch(*on),
                toml::Value::Integer(n) => Value::Count(u32::try_from(*n).ok()?),
                toml::Value::Float(n) => Value::Number(*n as f32),
                toml::Value::String(s) => Value::Choice(choices.iter().find(|c| c.name == s)?.name),
                _ => return None,
            })
        };
        let none = "the default must be true, false, a number, or one of the choices; 1.0 is a number, 1 a whole one";
        let published = value(&of.default).ok_or_else(|| wrong(none))?;
        let domain = match (published, of.range) {
            (Value::Switch(_), None) => Domain::Switch,
            (Value::Choice(_), None) => Domain::Choices(choices),
            (Value::Count(_), Some([least, most])) => Domain::Count(least as u32, most as u32),
            (Value::Number(_), Some([least, most])) => {
                Domain::Number { least: least as f32, with_least: true, most: most as f32 }
            }
            (Value::Count(_) | Value::Number(_), None) => return Err(wrong("a number needs a range")),
            _ => return Err(wrong("only numbers have a range")),
        };
        let sweep = of.sweep.iter().map(|v| value(v).ok_or_else(|| wrong("the sweep has values of another type")));
        let sweep: Vec<Value> = sweep.collect::<Result<_>>()?;
        if let Some(outside) = [published].iter().chain(&sweep).find(|v| !domain.has(**v)) {
            return Err(wrong(&format!("{outside} is outside {domain}")));
        }
        let help = of.help.trim();
        let help = if help.ends_with('.') { help.to_owned() } else { format!("{help}.") };
        let name: &'static str = name.replace('-', "_").leak();
        if crate::methods::parameters().iter().any(|(p, _)| p.name == name && p.domain != domain) {
            return Err(wrong("another method has a parameter of this name that takes other values; rename it"));
        }
        Ok(Parameter {
            name,
            help,
            unit: leak(&of.unit),
            domain,
            published,
            author: published,
            source: leak(&self.name),
            sweep: sweep.into_iter().map(|v| (Preset::Published, v)).collect(),
        })
    }
}

/// What passes may name.
struct Known<'a> {
    images: &'a BTreeMap<String, ImageSection>,
    buffers: &'a BTreeMap<String, BufferSection>,
}

/// Inputs and values that hold for every pass.
type Shared<'a> = (&'a BTreeMap<String, Spanned<InputSection>>, &'a BTreeMap<String, Spanned<toml::Value>>);

impl Known<'_> {
    fn pass(
        &self,
        folder: &Path,
        section: &Spanned<PassSection>,
        (inputs, values): Shared,
        parameters: &[String],
        wrong: &impl Fn(Range<usize>, String) -> Error,
    ) -> Result<Pass> {
        let of = section.get_ref();
        let shader = folder.join(of.shader.get_ref());
        let by_name = match shader.extension().and_then(|e| e.to_str()) {
            Some("frag" | "fs" | "fsh" | "glslf") => Some(PassStage::Fragment),
            Some("comp" | "cs" | "glslc") => Some(PassStage::Compute),
            _ => None,
        };
        let Some(stage) = of.stage.or(by_name) else {
            let message = format!("{}: say stage = \"fragment\" or \"compute\"", of.shader.get_ref().display());
            return Err(wrong(of.shader.span(), message));
        };
        let image = |text: &Spanned<String>| -> Result<(String, LevelOf)> {
            let (name, level) = level_of(text.get_ref()).map_err(|m| wrong(text.span(), m))?;
            if !self.images.contains_key(name) {
                return Err(wrong(text.span(), format!("there is no [image.{name}]")));
            }
            // What is written is one level.
            let level = if level == LevelOf::All { LevelOf::Number(0) } else { level };
            Ok((name.to_owned(), level))
        };
        let targets: Vec<_> = of.targets.iter().map(image).collect::<Result<_>>()?;
        let reach = match (stage, &of.threads, of.workgroups, &of.indirect) {
            (PassStage::Fragment, None, None, None) if !targets.is_empty() => PassReach::Targets,
            (PassStage::Fragment, ..) => {
                return Err(wrong(
                    section.span(),
                    "a fragment pass has targets, and neither threads nor workgroups".into(),
                ));
            }
            (PassStage::Compute, ..) if !targets.is_empty() => {
                return Err(wrong(section.span(), "a compute pass has no targets; it stores to images".into()));
            }
            (PassStage::Compute, Some(of), None, None) => {
                let (name, level) = image(of)?;
                PassReach::Threads(name, level)
            }
            (PassStage::Compute, None, Some(groups), None) => PassReach::Workgroups(groups),
            (PassStage::Compute, None, None, Some(buffer)) => {
                if !self.buffers.contains_key(buffer.get_ref()) {
                    return Err(wrong(buffer.span(), format!("there is no [buffer.{}]", buffer.get_ref())));
                }
                PassReach::Indirect(buffer.get_ref().clone())
            }
            (PassStage::Compute, ..) => {
                let message = "a compute pass says one of threads (an image), workgroups or indirect (a buffer)";
                return Err(wrong(section.span(), message.into()));
            }
        };
        let mut all_inputs = BTreeMap::new();
        for (name, input) in inputs.iter().chain(&of.inputs) {
            all_inputs.insert(name.clone(), self.input(input, wrong)?);
        }
        let mut all_values = BTreeMap::new();
        for (name, value) in values.iter().chain(&of.values) {
            let given =
                Feed::parse(value.get_ref(), parameters).map_err(|m| wrong(value.span(), format!("{name}: {m}")))?;
            all_values.insert(name.clone(), (given, value.span()));
        }
        if of.levels.is_some_and(|[first, last]| first > last || last > 31) {
            return Err(wrong(section.span(), "levels must be the first and the last of some levels up to 31".into()));
        }
        Ok(Pass {
            name: of.name.get_ref().clone(),
            shader,
            stage,
            defines: of.defines.clone(),
            targets,
            reach,
            levels: of.levels,
            inputs: all_inputs,
            values: all_values,
            at: section.span(),
        })
    }

    fn input(
        &self,
        section: &Spanned<InputSection>,
        wrong: &impl Fn(Range<usize>, String) -> Error,
    ) -> Result<PassInput> {
        let (text, sampler) = match section.get_ref() {
            InputSection::Plain(text) => (text, None),
            InputSection::With { image, sampler } => (image, Some(*sampler)),
        };
        let at = section.span();
        if self.buffers.contains_key(text) {
            return Ok(PassInput { what: InputKind::Buffer(text.clone()), sampler, level: LevelOf::All, at });
        }
        let own = |name: &str| self.images.contains_key(name);
        // A level stands behind the name of an image of the method's own.
        let (name, level) = match text.split_once(':') {
            Some((name, _)) if own(name) => level_of(text).map_err(|m| wrong(at.clone(), m))?,
            _ => (text.as_str(), LevelOf::All),
        };
        let source = ImageSource::parse(name, own).map_err(|m| wrong(at.clone(), m))?;
        Ok(PassInput { what: InputKind::Image(source), sampler, level, at })
    }
}

impl PassInput {
    /// Where the manifest says it.
    pub fn at(&self) -> &Range<usize> {
        &self.at
    }
}

/// An image and its level: `name`, `name:2`, `name:level`, `name:level-1`.
fn level_of(text: &str) -> std::result::Result<(&str, LevelOf), String> {
    let Some((name, level)) = text.split_once(':') else { return Ok((text, LevelOf::All)) };
    let parsed = match level.strip_prefix("level") {
        Some("") => Some(LevelOf::Current(0)),
        Some(less) => less.strip_prefix('-').and_then(|n| n.parse().ok()).map(LevelOf::Current),
        None => level.parse().ok().map(LevelOf::Number),
    };
    parsed.map(|level| (name, level)).ok_or_else(|| format!("{text:?}: a level is a number, level, or level-1"))
}

/// Formats of images that a method keeps, as GLSL names them.
const FORMATS: [(&str, vk::Format); 15] = [
    ("r8", vk::Format::R8_UNORM),
    ("rg8", vk::Format::R8G8_UNORM),
    ("rgba8", vk::Format::R8G8B8A8_UNORM),
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

/// The format of a name.
pub fn format_of(name: &str) -> Option<vk::Format> {
    FORMATS.iter().find(|(known, _)| *known == name).map(|(_, format)| *format)
}

/// The line of a byte, from 1.
fn line_of(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|b| **b == b'\n').count()
}

/// Reads a text of at most so many bytes.
pub fn read_text(path: &Path, what: &str, most: u64) -> Result<String> {
    let unreadable = |e| Error::io("read", path, e);
    let length = std::fs::metadata(path).map_err(unreadable)?.len();
    if length > most {
        return Err(Error::malformed(
            path,
            None,
            format!("{what} of {length} bytes is too large; at most {most} are read"),
        ));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    String::from_utf8(bytes).map_err(|_| Error::malformed(path, None, format!("{what} must be UTF-8 text")))
}
