//! The images that a user's shader may read, by their names in a manifest.

use ssct_ground::conventions::NormalEncoding;
use std::fmt;

/// A kind of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Depth {
    /// Reversed depth: 1 at the near plane, 0 at the far plane.
    Reversed,
    /// Standard depth: 0 at the near plane, 1 at the far plane.
    Standard,
    /// View-space z in metres.
    Linear,
}

/// The space and the encoding of a normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Normal {
    /// True for world space, false for view space.
    pub world: bool,
    /// The encoding of the normal.
    pub encoding: NormalEncoding,
}

/// A chain of minima or maxima of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DepthChain {
    /// True for maxima, false for minima.
    pub maximum: bool,
    /// The depth that the chain is made of.
    pub depth: Depth,
    /// True if sizes are rounded up to powers of two; if false, each size is half of the one before, rounded down.
    pub padded: bool,
}

/// A part of the captures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CapturePart {
    /// Lit colour, cubes.
    Colour,
    /// Front and back depths.
    Pyramid,
    /// Normals.
    Normal,
}

/// An image that a shader reads.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum ImageSource {
    /// Lit colour, level 0 alone.
    LitColour,
    /// Lit colour with its chain, made by the Gaussian or by halving.
    LitColourChain {
        /// True for the Gaussian, false for halving.
        gaussian: bool,
    },
    /// A depth.
    Depth(Depth),
    /// A normal.
    Normal(Normal),
    /// Positions of surfaces.
    Position {
        /// True for world space, false for view space.
        world: bool,
    },
    /// Reflectivity and roughness.
    Material,
    /// A chain of depths.
    DepthChain(DepthChain),
    /// The thesis's Hi-Z chain: minimum and maximum of standard depth.
    ThesisHiZ,
    /// The thesis's visibility.
    Visibility,
    /// The pyramid of `unified`.
    Pyramid,
    /// Blue noise.
    BlueNoise,
    /// Motion on the screen.
    Motion,
    /// The environment.
    Sky,
    /// Captures.
    Captures(CapturePart),
    /// An image of the method's own.
    Own(String),
    /// A source as it was in the frame before.
    Previous(Box<ImageSource>),
}

/// Encodings of normals, in the order of their numbers in the shader.
const ENCODINGS: [(&str, NormalEncoding); 4] = [
    ("float", NormalEncoding::Float),
    ("unorm", NormalEncoding::Unorm),
    ("octahedral", NormalEncoding::Octahedral),
    ("octahedral-unorm", NormalEncoding::OctahedralUnorm),
];

impl Depth {
    /// Returns the kind of depth with a name in a manifest.
    fn from_name(name: &str) -> Option<Self> {
        [("reversed", Self::Reversed), ("standard", Self::Standard), ("linear", Self::Linear)]
            .into_iter()
            .find(|(known, _)| *known == name)
            .map(|(_, depth)| depth)
    }
}

impl ImageSource {
    /// Reads a source by its name in a manifest; `is_own` says whether the method has an image of this name.
    ///
    /// # Errors
    /// A clause that says what is wrong with the name.
    pub fn parse(text: &str, is_own: impl Fn(&str) -> bool + Copy) -> Result<Self, String> {
        let words: Vec<&str> = text.split(':').collect();
        let unknown = || {
            format!(
                "{text:?} is no image that there is: lit-colour, lit-colour-chain, depth:reversed, normal:view, position:view, material, \
                 hi-z:min:reversed, thesis-hi-z, visibility, pyramid, blue-noise, motion, sky, captures:colour, previous:… \
                 or an image of this method"
            )
        };
        Ok(match words[..] {
            ["previous", ref rest @ ..] if !rest.is_empty() => {
                let original = Self::parse(&rest.join(":"), is_own)?;
                if !original.can_be_kept() {
                    return Err(format!("what {original} was in the frame before is not kept"));
                }
                Self::Previous(Box::new(original))
            }
            [name] if is_own(name) => Self::Own(name.to_owned()),
            ["lit-colour"] => Self::LitColour,
            ["lit-colour-chain"] => Self::LitColourChain { gaussian: false },
            ["lit-colour-chain", "gaussian"] => Self::LitColourChain { gaussian: true },
            ["depth", which] => Self::Depth(Depth::from_name(which).ok_or_else(unknown)?),
            ["normal", space @ ("view" | "world"), ref rest @ ..] if rest.len() < 2 => {
                let name = rest.first().copied().unwrap_or("float");
                let (_, encoding) = *ENCODINGS.iter().find(|(known, _)| *known == name).ok_or_else(unknown)?;
                Self::Normal(Normal { world: space == "world", encoding })
            }
            ["position", space @ ("view" | "world")] => Self::Position { world: space == "world" },
            ["material"] => Self::Material,
            ["hi-z", which @ ("min" | "max"), depth, ref rest @ ..] if matches!(rest, [] | ["padded"]) => {
                let depth = Depth::from_name(depth).ok_or_else(unknown)?;
                Self::DepthChain(DepthChain { maximum: which == "max", depth, padded: !rest.is_empty() })
            }
            ["thesis-hi-z"] => Self::ThesisHiZ,
            ["visibility"] => Self::Visibility,
            ["pyramid"] => Self::Pyramid,
            ["blue-noise"] => Self::BlueNoise,
            ["motion"] => Self::Motion,
            ["sky"] => Self::Sky,
            ["captures", "colour"] => Self::Captures(CapturePart::Colour),
            ["captures", "pyramid"] => Self::Captures(CapturePart::Pyramid),
            ["captures", "normal"] => Self::Captures(CapturePart::Normal),
            _ => return Err(unknown()),
        })
    }

    /// True for an image of one level that can be kept for the next frame.
    fn can_be_kept(&self) -> bool {
        matches!(
            self,
            Self::LitColour | Self::Depth(_) | Self::Normal(_) | Self::Position { .. } | Self::Material | Self::Own(_)
        )
    }

    /// True if shaders read the image between its texels, so that it needs a linear sampler.
    pub fn is_smooth(&self) -> bool {
        match self {
            Self::LitColour | Self::LitColourChain { .. } | Self::Sky | Self::Visibility => true,
            Self::Captures(part) => *part == CapturePart::Colour,
            Self::Previous(original) => original.is_smooth(),
            _ => false,
        }
    }
}

/// Writes the name that a manifest uses.
impl fmt::Display for ImageSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let depth = |d: &Depth| match d {
            Depth::Reversed => "reversed",
            Depth::Standard => "standard",
            Depth::Linear => "linear",
        };
        match self {
            Self::LitColour => write!(f, "lit-colour"),
            Self::LitColourChain { gaussian: false } => write!(f, "lit-colour-chain"),
            Self::LitColourChain { gaussian: true } => write!(f, "lit-colour-chain:gaussian"),
            Self::Depth(d) => write!(f, "depth:{}", depth(d)),
            Self::Normal(n) => {
                let encoding =
                    ENCODINGS.iter().find(|(_, encoding)| *encoding == n.encoding).map_or("", |(name, _)| name);
                write!(f, "normal:{}:{encoding}", if n.world { "world" } else { "view" })
            }
            Self::Position { world } => write!(f, "position:{}", if *world { "world" } else { "view" }),
            Self::Material => write!(f, "material"),
            Self::DepthChain(h) => {
                let (which, padded) = (if h.maximum { "max" } else { "min" }, if h.padded { ":padded" } else { "" });
                write!(f, "hi-z:{which}:{}{padded}", depth(&h.depth))
            }
            Self::ThesisHiZ => write!(f, "thesis-hi-z"),
            Self::Visibility => write!(f, "visibility"),
            Self::Pyramid => write!(f, "pyramid"),
            Self::BlueNoise => write!(f, "blue-noise"),
            Self::Motion => write!(f, "motion"),
            Self::Sky => write!(f, "sky"),
            Self::Captures(CapturePart::Colour) => write!(f, "captures:colour"),
            Self::Captures(CapturePart::Pyramid) => write!(f, "captures:pyramid"),
            Self::Captures(CapturePart::Normal) => write!(f, "captures:normal"),
            Self::Own(name) => write!(f, "{name}"),
            Self::Previous(original) => write!(f, "previous:{original}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_is_read_as_it_is_written() {
        let own = |name: &str| name == "result";
        for text in [
            "lit-colour",
            "lit-colour-chain",
            "lit-colour-chain:gaussian",
            "depth:reversed",
            "depth:standard",
            "depth:linear",
            "normal:view:float",
            "normal:world:octahedral-unorm",
            "position:view",
            "position:world",
            "material",
            "hi-z:min:reversed",
            "hi-z:max:linear:padded",
            "thesis-hi-z",
            "visibility",
            "pyramid",
            "blue-noise",
            "motion",
            "sky",
            "captures:colour",
            "result",
            "previous:result",
            "previous:depth:linear",
        ] {
            assert_eq!(ImageSource::parse(text, own).map(|s| s.to_string()).as_deref(), Ok(text));
        }
        for wrong in ["", "depth", "depth:other", "normal:view:half", "hi-z:min", "previous", "previous:sky", "other"] {
            assert!(ImageSource::parse(wrong, own).is_err(), "{wrong}");
        }
    }
}
