//! Checks the passes of a manifest: the targets or threads that each pass runs over, and the meaning of the names in
//! its shader. The module `bindings` checks the shader itself.

use super::sections::{BufferSection, ImageSection, InputSection, PassSection, PassStage, SamplerName};
use crate::custom::built_in;
use crate::custom::source::ImageSource;
use crate::custom::values::Feed;
use ssct_ground::Result;
use ssct_scenes::source_text::SourceText;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A level of an image, as a manifest names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelOf {
    /// All levels of a sampled image.
    All,
    /// The level of this number.
    Number(u32),
    /// The level that the pass is recorded for, minus this number.
    Current(u32),
}

/// The image or buffer that a name in a shader stands for.
#[derive(Debug, Clone)]
pub struct PassInput {
    /// The image or buffer.
    pub what: InputKind,
    /// The sampler, if the manifest names one.
    pub sampler: Option<SamplerName>,
    /// The level of an image.
    pub level: LevelOf,
    /// The place of the input in the manifest, in bytes.
    span: Range<usize>,
}

/// An image, or a buffer of the method's own by its name.
#[derive(Debug, Clone, PartialEq)]
pub enum InputKind {
    Image(ImageSource),
    Buffer(String),
}

/// A pass that is checked, except for the text of its shader.
#[derive(Debug, Clone)]
pub struct Pass {
    /// The name of the pass.
    pub name: String,
    /// The file, or the path of a built-in shader.
    pub shader: PathBuf,
    /// For a built-in shader, the path in the method's folder at which a file would replace it.
    pub awaited: Option<PathBuf>,
    /// The stage of the shader.
    pub stage: PassStage,
    /// The macros that are defined for the shader, as `NAME` or `NAME=VALUE`.
    pub defines: Vec<String>,
    /// The image and the level that the pass draws to, for each target.
    pub targets: Vec<(String, LevelOf)>,
    /// The extent that the pass runs over.
    pub domain: PassDomain,
    /// The first and the last of the levels that the pass is recorded for, one after another.
    pub levels: Option<[u32; 2]>,
    /// True if each level of the pass is recorded right after the same level of the pass before it.
    pub interleaved: bool,
    /// The images and buffers by their names in the shader.
    pub inputs: BTreeMap<String, PassInput>,
    /// The values by their names in the shader, each with its place in the manifest.
    pub values: BTreeMap<String, (Feed, Range<usize>)>,
    /// The place of the pass in the manifest, in bytes.
    pub span: Range<usize>,
}

/// The extent that a pass runs over.
#[derive(Debug, Clone, PartialEq)]
pub enum PassDomain {
    /// The targets of a fragment pass.
    Targets,
    /// A thread for each texel of an image's level.
    Threads(String, LevelOf),
    /// The number of workgroups along each axis.
    Workgroups([u32; 3]),
    /// The name of the buffer that holds the number of workgroups along each axis.
    Indirect(String),
}

/// The images and buffers that passes may name.
pub(super) struct KnownNames<'a> {
    pub(super) images: &'a BTreeMap<String, ImageSection>,
    pub(super) buffers: &'a BTreeMap<String, BufferSection>,
}

/// The inputs and the values that a manifest gives to every pass.
type Shared<'a> = (&'a BTreeMap<String, Spanned<InputSection>>, &'a BTreeMap<String, Spanned<toml::Value>>);

impl KnownNames<'_> {
    /// Checks a section `[[pass]]` and makes a pass of it. `inputs` and `values` are given to every pass, `parameters`
    /// has the names of the method's parameters, and `source` is the manifest.
    pub(super) fn pass(
        &self,
        folder: &Path,
        section: &Spanned<PassSection>,
        (inputs, values): Shared,
        parameters: &[String],
        source: &SourceText,
    ) -> Result<Pass> {
        let pass = section.get_ref();
        let file = folder.join(pass.shader.get_ref());
        let built_in = if file.exists() { None } else { pass.shader.get_ref().to_str().and_then(built_in::path) };
        let (shader, awaited) = match built_in {
            Some(shader) => (shader, Some(file)),
            None => (file, None),
        };
        let stage_by_extension = match shader.extension().and_then(|e| e.to_str()) {
            Some("frag" | "fs" | "fsh" | "glslf") => Some(PassStage::Fragment),
            Some("comp" | "cs" | "glslc") => Some(PassStage::Compute),
            _ => None,
        };
        let Some(stage) = pass.stage.or(stage_by_extension) else {
            let message = format!("{}: say stage = \"fragment\" or \"compute\"", pass.shader.get_ref().display());
            return Err(source.error(pass.shader.span(), message));
        };
        let targets = pass.targets.iter().map(|text| self.written_level(text, source)).collect::<Result<Vec<_>>>()?;
        let domain = self.domain(section, stage, !targets.is_empty(), source)?;
        let mut all_inputs = BTreeMap::new();
        for (name, input) in inputs.iter().chain(&pass.inputs) {
            all_inputs.insert(name.clone(), self.input(input, source)?);
        }
        let mut all_values = BTreeMap::new();
        for (name, value) in values.iter().chain(&pass.values) {
            let feed = Feed::parse(value.get_ref(), parameters)
                .map_err(|m| source.error(value.span(), format!("{name}: {m}")))?;
            all_values.insert(name.clone(), (feed, value.span()));
        }
        if pass.levels.is_some_and(|[first, last]| first > last || last > 31) {
            return Err(source.error(section.span(), "levels must be the first and the last of some levels up to 31"));
        }
        if pass.interleaved && pass.levels.is_none() {
            return Err(source.error(section.span(), "an interleaved pass has levels, as the pass before it has"));
        }
        Ok(Pass {
            name: pass.name.get_ref().clone(),
            shader,
            awaited,
            stage,
            defines: pass.defines.clone(),
            targets,
            domain,
            levels: pass.levels,
            interleaved: pass.interleaved,
            inputs: all_inputs,
            values: all_values,
            span: section.span(),
        })
    }

    /// Reads the name of an image with the level that a pass writes; level 0 if the text names no level.
    fn written_level(&self, text: &Spanned<String>, source: &SourceText) -> Result<(String, LevelOf)> {
        let (name, level) = level_of(text.get_ref()).map_err(|m| source.error(text.span(), m))?;
        if !self.images.contains_key(name) {
            return Err(source.error(text.span(), format!("there is no [image.{name}]")));
        }
        Ok((name.to_owned(), if level == LevelOf::All { LevelOf::Number(0) } else { level }))
    }

    /// Returns the extent that a pass runs over, and refuses keys that do not fit its stage.
    fn domain(
        &self,
        section: &Spanned<PassSection>,
        stage: PassStage,
        has_targets: bool,
        source: &SourceText,
    ) -> Result<PassDomain> {
        let pass = section.get_ref();
        let message = match (stage, &pass.threads, pass.workgroups, &pass.indirect) {
            (PassStage::Fragment, None, None, None) if has_targets => return Ok(PassDomain::Targets),
            (PassStage::Fragment, ..) => "a fragment pass has targets, and neither threads nor workgroups",
            (PassStage::Compute, ..) if has_targets => "a compute pass has no targets; it stores to images",
            (PassStage::Compute, Some(threads), None, None) => {
                let (name, level) = self.written_level(threads, source)?;
                return Ok(PassDomain::Threads(name, level));
            }
            (PassStage::Compute, None, Some(groups), None) => return Ok(PassDomain::Workgroups(groups)),
            (PassStage::Compute, None, None, Some(buffer)) => {
                if !self.buffers.contains_key(buffer.get_ref()) {
                    return Err(source.error(buffer.span(), format!("there is no [buffer.{}]", buffer.get_ref())));
                }
                return Ok(PassDomain::Indirect(buffer.get_ref().clone()));
            }
            (PassStage::Compute, ..) => {
                "a compute pass says one of threads (an image), workgroups or indirect (a buffer)"
            }
        };
        Err(source.error(section.span(), message))
    }

    /// Checks an input, which is the name of a buffer, of an image of the method's own, or of another source.
    fn input(&self, section: &Spanned<InputSection>, source: &SourceText) -> Result<PassInput> {
        let (text, sampler) = match section.get_ref() {
            InputSection::Plain(text) => (text, None),
            InputSection::With { image, sampler } => (image, Some(*sampler)),
        };
        let span = section.span();
        if self.buffers.contains_key(text) {
            return Ok(PassInput { what: InputKind::Buffer(text.clone()), sampler, level: LevelOf::All, span });
        }
        let is_own = |name: &str| self.images.contains_key(name);
        // A level may follow the name of one of the method's own images.
        let (name, level) = match text.split_once(':') {
            Some((name, _)) if is_own(name) => level_of(text).map_err(|m| source.error(span.clone(), m))?,
            _ => (text.as_str(), LevelOf::All),
        };
        let image = ImageSource::parse(name, is_own).map_err(|m| source.error(span.clone(), m))?;
        Ok(PassInput { what: InputKind::Image(image), sampler, level, span })
    }
}

impl PassInput {
    /// The place of the input in the manifest.
    pub fn span(&self) -> &Range<usize> {
        &self.span
    }
}

/// Splits `name`, `name:2`, `name:level` or `name:level-1` into the image's name and its level: all levels, level 2,
/// the level that the pass is recorded for, or the level before it.
fn level_of(text: &str) -> std::result::Result<(&str, LevelOf), String> {
    let Some((name, level)) = text.split_once(':') else { return Ok((text, LevelOf::All)) };
    let parsed = match level.strip_prefix("level") {
        Some("") => Some(LevelOf::Current(0)),
        Some(minus_n) => minus_n.strip_prefix('-').and_then(|n| n.parse().ok()).map(LevelOf::Current),
        None => level.parse().ok().map(LevelOf::Number),
    };
    parsed.map(|level| (name, level)).ok_or_else(|| format!("{text:?}: a level is a number, level, or level-1"))
}
