//! Types that say how other renderers lay out their spaces, matrices, depth and normals. The door, methods from folders and maps of
//! G-buffers share these types, and each uses those that it needs.

use glam::{DMat3, DVec3};
use serde::Deserialize;

/// How the axes of a space lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// x to the right, y up, z forwards: the axes of this project.
    #[default]
    Left,
    /// x to the right, y up, z backwards.
    Right,
    /// x to the right, y forwards, z up.
    RightZUp,
    /// x forwards, y to the right, z up.
    LeftZUp,
    /// x to the right, y down, z forwards.
    RightYDown,
}

impl Axes {
    /// Every choice of axes, with its name in files.
    pub const NAMES: [(&str, Self); 5] = [
        ("left", Self::Left),
        ("right", Self::Right),
        ("right-z-up", Self::RightZUp),
        ("left-z-up", Self::LeftZUp),
        ("right-y-down", Self::RightYDown),
    ];

    /// Returns the matrix that takes a vector from these axes to the project's. The matrix has the axes x, y and z as
    /// columns; its inverse is its transpose.
    pub fn to_ours(self) -> DMat3 {
        match self {
            Self::Left => DMat3::IDENTITY,
            Self::Right => DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z),
            Self::RightZUp => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y),
            Self::LeftZUp => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
            Self::RightYDown => DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::Z),
        }
    }
}

/// The order in which a matrix lists its numbers. The matrix is multiplied by column vectors from the right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MatrixOrder {
    /// Column by column.
    #[default]
    Columns,
    /// Row by row.
    Rows,
}

/// Where the top of the image is in a renderer's clip space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClipY {
    /// The image's top is at y = −w, as in Vulkan with a viewport of positive height.
    #[default]
    Down,
    /// The image's top is at y = w: the viewport has a negative height.
    Up,
}

/// The depth of clip space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClipDepth {
    /// 0 at the near plane and 1 at the far plane.
    #[default]
    Standard,
    /// 1 at the near plane and 0 at the far plane, which may be infinitely far away.
    Reversed,
    /// −1 at the near plane and 1 at the far plane, as OpenGL has it.
    MinusOneToOne,
}

/// The space in which normals are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalSpace {
    /// The caller's view space.
    View,
    /// The caller's world space.
    World,
}

/// How the texels of an image hold unit normals, in the order of the codes from `CONVERT_VIEW_NORMAL` on in GLSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NormalEncoding {
    /// A texel holds x, y and z without a mapping, in floats or signed normalised numbers.
    Float,
    /// A texel holds x, y and z, each mapped from −1…1 to 0…1.
    Unorm,
    /// A texel holds two numbers, −1…1: the place on an octahedron that is unfolded to a square.
    Octahedral,
    /// A texel holds the place on the octahedron, with both numbers mapped to 0…1.
    OctahedralUnorm,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_rotations_or_mirrors_of_the_hand_that_their_name_says() {
        for (name, axes) in Axes::NAMES {
            let to_ours = axes.to_ours();
            assert_eq!(to_ours * to_ours.transpose(), DMat3::IDENTITY, "{name}");
            assert_eq!(to_ours.determinant(), if name.starts_with("left") { 1.0 } else { -1.0 }, "{name}");
            let up = if name.ends_with("z-up") { DVec3::Z } else { DVec3::Y };
            let down = name.ends_with("y-down");
            assert_eq!(to_ours * up, if down { DVec3::NEG_Y } else { DVec3::Y }, "{name}");
        }
    }
}
