//! Formats of a G-buffer, which round its numbers, and the ladder of formats that is measured.

use super::ExactGBuffer;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use ssct_ground::math::{linear_to_srgb, srgb_to_linear};
use ssct_scenes::GBufferData;

/// Bytes of a pixel's reflectivity and roughness, which are two 16-bit floats on every rung.
const MATERIAL_BYTES: u32 = 4;

/// Format of depth. In fixed point, standard and reversed depth have the same steps, counted from opposite ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DepthFormat {
    /// 32-bit float, near 1, far 0.
    F32Reversed,
    /// 32-bit float, near 0, far 1.
    F32Standard,
    /// 24-bit fixed point, in 4 bytes.
    D24,
    /// 16-bit fixed point.
    D16,
}

impl DepthFormat {
    /// Returns the name in plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32Reversed => "f32 reversed",
            Self::F32Standard => "f32 standard",
            Self::D24 => "D24",
            Self::D16 => "D16",
        }
    }

    fn bytes_per_pixel(self) -> u32 {
        match self {
            Self::F32Reversed | Self::F32Standard | Self::D24 => 4,
            Self::D16 => 2,
        }
    }

    /// Rounds a reversed depth of 0…1 as the format does: returns the reversed depth that is read back after it is
    /// stored.
    pub fn store(self, reversed: f64) -> f32 {
        let fixed = |steps: f64| ((reversed * steps).round() / steps) as f32;
        match self {
            Self::F32Reversed => reversed as f32,
            Self::F32Standard => 1.0 - (1.0 - reversed) as f32,
            Self::D24 => fixed(f64::from((1 << 24) - 1)),
            Self::D16 => fixed(f64::from(u16::MAX)),
        }
    }
}

/// Format of normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NormalFormat {
    /// 32-bit floats.
    Rgba32f,
    /// 16-bit floats.
    Rgba16f,
    /// 10 bits a coordinate, −1…1 over 0…1023.
    Rgb10a2,
    /// 8 bits a coordinate, −1…1 over 0…255.
    Rgba8,
}

impl NormalFormat {
    /// Returns the name in plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgba32f => "RGBA32F",
            Self::Rgba16f => "RGBA16F",
            Self::Rgb10a2 => "RGB10A2",
            Self::Rgba8 => "RGBA8",
        }
    }

    fn bytes_per_pixel(self) -> u32 {
        match self {
            Self::Rgba32f => 16,
            Self::Rgba16f => 8,
            Self::Rgb10a2 | Self::Rgba8 => 4,
        }
    }

    /// Rounds a normal as the format does: returns the normal that is read back after it is stored, whose length may
    /// not be exactly 1.
    pub fn store(self, normal: Vec3) -> Vec3 {
        let fixed = |v: f32, steps: f32| unit_steps(0.5 + 0.5 * v, steps) * 2.0 - 1.0;
        let store_coordinate = |v: f32| match self {
            Self::Rgba32f => v,
            Self::Rgba16f => half(v),
            Self::Rgb10a2 => fixed(v, 1023.0),
            Self::Rgba8 => fixed(v, 255.0),
        };
        normal.map(store_coordinate)
    }
}

/// Format of the lit colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorFormat {
    /// 32-bit floats.
    Rgba32f,
    /// 16-bit floats.
    Rgba16f,
    /// Floats without a sign: 6, 6 and 5 bits of mantissa.
    R11g11b10f,
    /// 10 bits a channel, linear, 0…1.
    Rgb10a2,
    /// 8 bits a channel, sRGB, 0…1.
    Rgba8Srgb,
}

impl ColorFormat {
    /// Returns the name in plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgba32f => "RGBA32F",
            Self::Rgba16f => "RGBA16F",
            Self::R11g11b10f => "R11G11B10F",
            Self::Rgb10a2 => "RGB10A2",
            Self::Rgba8Srgb => "RGBA8 sRGB",
        }
    }

    fn bytes_per_pixel(self) -> u32 {
        match self {
            Self::Rgba32f => 16,
            Self::Rgba16f => 8,
            Self::R11g11b10f | Self::Rgb10a2 | Self::Rgba8Srgb => 4,
        }
    }

    /// Rounds a linear colour as the format does: returns the linear colour that is read back after it is stored.
    pub fn store(self, color: Vec3) -> Vec3 {
        match self {
            Self::Rgba32f => color,
            Self::Rgba16f => color.map(half),
            Self::R11g11b10f => {
                Vec3::new(unsigned_float(color.x, 6), unsigned_float(color.y, 6), unsigned_float(color.z, 5))
            }
            Self::Rgb10a2 => color.map(|v| unit_steps(v, 1023.0)),
            Self::Rgba8Srgb => color.map(|v| srgb_to_linear(unit_steps(linear_to_srgb(v.clamp(0.0, 1.0)), 255.0))),
        }
    }
}

/// Rounds to the nearest 16-bit float.
fn half(v: f32) -> f32 {
    half::f16::from_f32(v).to_f32()
}

/// Rounds to the nearest multiple of 1 / `steps` in 0…1.
fn unit_steps(v: f32, steps: f32) -> f32 {
    (v.clamp(0.0, 1.0) * steps).round() / steps
}

/// Rounds to the nearest unsigned float with 5 bits of exponent (as in 16-bit floats) and `mantissa_bits` bits of
/// mantissa. Negative numbers become 0, and numbers above the range become the greatest float.
fn unsigned_float(v: f32, mantissa_bits: i32) -> f32 {
    let v = f64::from(v).max(0.0);
    let greatest = (2.0 - 2.0_f64.powi(-mantissa_bits)) * 2.0_f64.powi(15);
    // The least exponent of a normal float is −14, and denormals have the same step; the greatest exponent is 15.
    let exponent = v.log2().floor().clamp(-14.0, 15.0) as i32;
    let step = 2.0_f64.powi(exponent - mantissa_bits);
    ((v / step).round() * step).min(greatest) as f32
}

/// The formats of a G-buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Storage {
    /// The format of depth.
    pub depth: DepthFormat,
    /// The format of normals.
    pub normal: NormalFormat,
    /// The format of the lit colour.
    pub color: ColorFormat,
}

impl Storage {
    /// The formats with which the ladder begins, which are the finest.
    pub const FINEST: Self =
        Self { depth: DepthFormat::F32Reversed, normal: NormalFormat::Rgba32f, color: ColorFormat::Rgba32f };

    /// The formats of [`ssct::passes::gbuffer`].
    pub const SSCT: Self = Self { normal: NormalFormat::Rgba16f, color: ColorFormat::Rgba16f, ..Self::FINEST };

    /// Returns the bytes of a pixel, including reflectivity and roughness.
    pub fn bytes_per_pixel(self) -> u32 {
        self.depth.bytes_per_pixel() + self.normal.bytes_per_pixel() + self.color.bytes_per_pixel() + MATERIAL_BYTES
    }

    /// Names the formats that differ from those of [`Storage::FINEST`].
    pub fn name(self) -> String {
        let finest = Self::FINEST;
        let parts = [
            (self.depth != finest.depth).then(|| format!("depth {}", self.depth.name())),
            (self.normal != finest.normal).then(|| format!("normal {}", self.normal.name())),
            (self.color != finest.color).then(|| format!("colour {}", self.color.name())),
        ];
        let parts: Vec<_> = parts.into_iter().flatten().collect();
        if parts.is_empty() { "all 32-bit float".into() } else { parts.join(", ") }
    }

    /// Rounds a G-buffer as the formats do: returns the G-buffer that is read back after it is stored.
    pub fn store(self, exact: &ExactGBuffer) -> GBufferData {
        GBufferData {
            depth: exact.depth.iter().map(|d| self.depth.store(*d)).collect(),
            normal: exact.data.normal.iter().map(|n| self.normal.store(*n)).collect(),
            color: exact.data.color.iter().map(|c| self.color.store(*c)).collect(),
            ..exact.data.clone()
        }
    }

    /// Returns the rungs of the ladder: the finest formats, each coarser format by itself, those of [`Self::SSCT`],
    /// and several combinations of coarser formats.
    pub fn ladder() -> Vec<Self> {
        use ColorFormat as C;
        use DepthFormat as D;
        use NormalFormat as N;
        let finest = Self::FINEST;
        let depths = [D::F32Standard, D::D24, D::D16].map(|depth| Self { depth, ..finest });
        let normals = [N::Rgba16f, N::Rgb10a2, N::Rgba8].map(|normal| Self { normal, ..finest });
        let colors = [C::Rgba16f, C::R11g11b10f, C::Rgb10a2, C::Rgba8Srgb].map(|color| Self { color, ..finest });
        let together = [
            Self::SSCT,
            Self { color: C::R11g11b10f, ..Self::SSCT },
            Self { color: C::Rgba8Srgb, ..Self::SSCT },
            Self { normal: N::Rgb10a2, color: C::R11g11b10f, ..finest },
            Self { depth: D::D16, normal: N::Rgba8, color: C::Rgba8Srgb },
        ];
        [&[finest], &depths[..], &normals, &colors, &together].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_depth_format_errs_by_at_most_half_its_step() {
        // The reversed depth of a view depth in metres, with the near plane at 0.1 m and the far plane at 1000 m.
        let reversed = |z: f64| 0.1 * (1000.0 - z) / (z * (1000.0 - 0.1));
        let greatest_error = |format: DepthFormat| {
            let error = |z: i32| (f64::from(format.store(reversed(f64::from(z)))) - reversed(f64::from(z))).abs();
            (50..=150).map(error).fold(0.0, f64::max)
        };
        let [exact, standard] = [DepthFormat::F32Reversed, DepthFormat::F32Standard].map(greatest_error);
        assert!(exact <= reversed(50.0) * 2.0_f64.powi(-24), "{exact}");
        assert!(standard > 100.0 * exact && standard <= 2.0_f64.powi(-25), "{standard}");
        let [d24, d16] = [DepthFormat::D24, DepthFormat::D16].map(greatest_error);
        assert!(d24 > 100.0 * exact && d24 <= 0.5 / f64::from((1 << 24) - 1) + 1e-10, "{d24}");
        assert!(d16 > 100.0 * d24 && d16 <= 0.5 / 65535.0 + 1e-10, "{d16}");
        for format in [DepthFormat::F32Reversed, DepthFormat::F32Standard, DepthFormat::D24, DepthFormat::D16] {
            assert_eq!((format.store(0.0), format.store(1.0)), (0.0, 1.0), "sky and the near plane stay");
        }
    }

    #[test]
    fn small_floats_are_those_of_the_format() {
        // With 6 bits of mantissa 1 + 2⁻⁶ is exact. The least denormal is 2⁻²⁰.
        assert_eq!(unsigned_float(1.015_625, 6), 1.015_625);
        assert_eq!(unsigned_float(1.0, 5), 1.0);
        assert_eq!(unsigned_float(1.01, 5), 1.0);
        assert_eq!((unsigned_float(1e9, 6), unsigned_float(1e9, 5)), (65024.0, 64512.0));
        assert_eq!((unsigned_float(-1.0, 6), unsigned_float(0.0, 6)), (0.0, 0.0));
        assert_eq!(unsigned_float(2.0_f32.powi(-20), 6), 2.0_f32.powi(-20));
        assert_eq!(unsigned_float(2.0_f32.powi(-22), 6), 0.0);
    }

    #[test]
    fn bytes_and_names_tell_the_rungs_apart() {
        assert_eq!(Storage::FINEST.bytes_per_pixel(), 40);
        assert_eq!(Storage::SSCT.bytes_per_pixel(), 24);
        let mut names: Vec<_> = Storage::ladder().into_iter().map(Storage::name).collect();
        assert!(names.contains(&"normal RGBA16F, colour RGBA16F".to_owned()));
        names.sort();
        names.dedup();
        assert_eq!(names.len(), Storage::ladder().len());
    }
}
