//! The sections of a manifest as serde reads them: their keys, the defaults of keys, and the words that keys may have. `manifest` and
//! `passes` check what keys mean together.

use crate::custom::conventions::Conventions;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use toml::Spanned;

/// A whole manifest: its keys and its tables.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Sections {
    pub(super) name: Spanned<String>,
    pub(super) summary: String,
    #[serde(default)]
    pub(super) source: Option<String>,
    #[serde(default)]
    pub(super) include: Option<PathBuf>,
    #[serde(default)]
    pub(super) captures: bool,
    #[serde(default)]
    pub(super) patience_s: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) conventions: Conventions,
    #[serde(default)]
    pub(super) parameter: BTreeMap<String, Spanned<ParameterSection>>,
    #[serde(default)]
    pub(super) image: BTreeMap<String, Spanned<ImageSection>>,
    #[serde(default)]
    pub(super) buffer: BTreeMap<String, Spanned<BufferSection>>,
    #[serde(default)]
    pub(super) inputs: BTreeMap<String, Spanned<InputSection>>,
    #[serde(default)]
    pub(super) values: BTreeMap<String, Spanned<toml::Value>>,
    pub(super) pass: Vec<Spanned<PassSection>>,
    pub(super) output: Spanned<OutputSection>,
}

/// A table `[parameter.name]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct ParameterSection {
    pub(super) help: String,
    pub(super) default: toml::Value,
    #[serde(default)]
    pub(super) range: Option<[f64; 2]>,
    #[serde(default)]
    pub(super) choices: Vec<String>,
    #[serde(default)]
    pub(super) unit: String,
    #[serde(default)]
    pub(super) sweep: Vec<toml::Value>,
}

/// A table `[image.name]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ImageSection {
    /// Name of the format.
    pub format: String,
    /// Ratio of the image's side to the frame's side.
    #[serde(default = "one")]
    pub scale: f32,
    /// Number of levels; 0 for all levels down to one texel.
    #[serde(default = "one_level")]
    pub levels: u32,
    /// True if a shader can read the image as it was in the frame before.
    #[serde(default)]
    pub history: bool,
    /// The value to which the image is cleared at the beginning of each frame.
    #[serde(default)]
    pub clear: Clear,
}

/// The value to which an image is cleared at the beginning of each frame.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged, expecting = "clear must be true, false or a number")]
pub enum Clear {
    /// True clears to 0, and false leaves the image as it is.
    Whether(bool),
    /// The number that clears every channel.
    Number(f32),
}

impl Default for Clear {
    fn default() -> Self {
        Self::Whether(false)
    }
}

impl Clear {
    /// The number that clears every channel, if the image is cleared.
    pub fn number(self) -> Option<f32> {
        match self {
            Self::Whether(is_cleared) => is_cleared.then_some(0.0),
            Self::Number(number) => Some(number),
        }
    }
}

/// The default of `scale`.
fn one() -> f32 {
    1.0
}

/// The default of `levels`.
fn one_level() -> u32 {
    1
}

/// A table `[buffer.name]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BufferSection {
    /// Number of bytes at any size of the frame.
    #[serde(default)]
    pub bytes: u64,
    /// Further bytes for each pixel.
    #[serde(default)]
    pub bytes_per_pixel: f64,
    /// The 32-bit word with which the buffer is filled at the beginning of each frame.
    #[serde(default)]
    pub fill: Option<u32>,
}

/// An input: a name, or a name with a sampler.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "an input must be a name, or { image = …, sampler = … }")]
pub(super) enum InputSection {
    Plain(String),
    With { image: String, sampler: SamplerName },
}

/// The samplers that a manifest can name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerName {
    Nearest,
    Linear,
    Repeat,
}

/// A table `[[pass]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct PassSection {
    pub(super) name: Spanned<String>,
    pub(super) shader: Spanned<PathBuf>,
    #[serde(default)]
    pub(super) stage: Option<PassStage>,
    #[serde(default)]
    pub(super) defines: Vec<String>,
    #[serde(default)]
    pub(super) targets: Vec<Spanned<String>>,
    /// The image, with its level, that has a texel for each thread.
    #[serde(default)]
    pub(super) threads: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) workgroups: Option<[u32; 3]>,
    #[serde(default)]
    pub(super) indirect: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) levels: Option<[u32; 2]>,
    /// True if each level of the pass is recorded right after the same level of the pass before it.
    #[serde(default)]
    pub(super) interleaved: bool,
    #[serde(default)]
    pub(super) inputs: BTreeMap<String, Spanned<InputSection>>,
    #[serde(default)]
    pub(super) values: BTreeMap<String, Spanned<toml::Value>>,
}

/// The stage of a pass's shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassStage {
    Fragment,
    Compute,
}

/// The table `[output]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct OutputSection {
    /// The image with the reflection.
    pub reflection: String,
    /// The meaning of the reflection's fourth channel.
    #[serde(default)]
    pub alpha: Alpha,
    /// The image with the hits.
    #[serde(default)]
    pub hits: Option<String>,
    /// The encoding of the hits.
    #[serde(default)]
    pub hits_are: HitEncoding,
}

/// The meanings that the reflection's fourth channel can have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alpha {
    #[default]
    Fade,
    Premultiplied,
    None,
}

/// The encodings that hits can have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HitEncoding {
    #[default]
    Uv,
    UvMasked,
    UvDepth,
    Pixel,
    ViewPosition,
    /// The encoding of the project's own shaders: texture coordinates, standard depth and PATH_*.
    UvDepthPath,
}
