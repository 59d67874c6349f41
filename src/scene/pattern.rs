//! Generated images that stand in for missing textures, by their names.

use super::Texture;

/// What a generated image is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A colour, sRGB.
    Albedo,
    /// A tangent-space normal map, green up.
    Normal,
}

/// The image for a file name, or `None` where the name says nothing.
pub fn by_name(_file_name: &str, _role: Role) -> Option<Texture> {
    None
}
