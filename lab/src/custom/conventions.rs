//! The conventions that a method from a folder may have: hands of its spaces, the layout of matrices, clip space.

use serde::Deserialize;

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
