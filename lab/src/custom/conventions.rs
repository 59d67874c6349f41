//! The conventions that a method from a folder may have: handedness of its spaces, layout of matrices, clip space.

use serde::Deserialize;
use ssct_ground::conventions::{Axes, ClipDepth, ClipY, MatrixOrder};

/// The conventions of a method's shaders.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Conventions {
    /// How the axes of view space lie.
    #[serde(default)]
    pub view: Axes,
    /// How the axes of world space lie.
    #[serde(default)]
    pub world: Axes,
    /// How matrices lie in memory.
    #[serde(default)]
    pub matrices: MatrixOrder,
    /// Where the top of the image is in clip space.
    #[serde(default = "up")]
    pub clip_y: ClipY,
    /// The kind of depth in clip space that the matrices give.
    #[serde(default)]
    pub clip_depth: ClipDepth,
}

/// The default of `clip_y`.
fn up() -> ClipY {
    ClipY::Up
}

impl Default for Conventions {
    fn default() -> Self {
        let (view, world, matrices, clip_depth) = Default::default();
        Self { view, world, matrices, clip_y: up(), clip_depth }
    }
}
