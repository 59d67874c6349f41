//! Images of materials.

/// How the bytes of a texture stand for numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Colour: decoded from sRGB on sampling.
    Srgb,
    /// Data: normals, masks, reflectivity.
    Linear,
}

/// An RGBA image, 8 bits a channel, rows from the top.
#[derive(Clone, PartialEq, Eq)]
pub struct Texture {
    /// File name or the generator's name, for labels.
    pub name: String,
    /// Width in texels, ≥ 1.
    pub width: u32,
    /// Height in texels, ≥ 1.
    pub height: u32,
    /// 4 · width · height bytes.
    pub rgba: Vec<u8>,
    /// What the bytes mean.
    pub encoding: Encoding,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Texture({:?}, {}x{}, {:?})", self.name, self.width, self.height, self.encoding)
    }
}
