//! Images of materials.

/// How the bytes of a texture encode numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Colour; it is decoded from sRGB when it is sampled.
    Srgb,
    /// Data such as normals, masks and reflectivity.
    Linear,
}

/// An RGBA image with 8 bits per channel, rows from the top.
#[derive(Clone, PartialEq, Eq)]
pub struct Texture {
    /// The file name or the generator's name, for labels.
    pub name: String,
    /// Width in texels, ≥ 1.
    pub width: u32,
    /// Height in texels, ≥ 1.
    pub height: u32,
    /// 4 · width · height bytes.
    pub rgba: Vec<u8>,
    /// How the bytes encode numbers.
    pub encoding: Encoding,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Texture({:?}, {}x{}, {:?})", self.name, self.width, self.height, self.encoding)
    }
}
