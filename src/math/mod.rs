//! Pure functions: colour encoding, projection, cones and the Phong lobe. And what references and methods must
//! mean alike.

pub mod cone;
pub mod constants;
pub mod frustum;
pub mod oracle_version;
pub mod phong;
pub mod projection;

pub use oracle_version::OracleVersion;

/// sRGB's transfer function, encoded to linear, for 0…1 (IEC 61966-2-1).
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// sRGB's transfer function, linear to encoded, for 0…1 (IEC 61966-2-1).
pub fn linear_to_srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Clamped and sRGB-encoded to a byte: the display image of DEFINITIONS, "Surfaces". NaN is black.
pub fn display_byte(linear: f32) -> u8 {
    (linear_to_srgb(linear.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

/// Rec. 709 luminance of a linear colour.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_every_byte() {
        for byte in 0..=255_u8 {
            assert_eq!(display_byte(srgb_to_linear(f32::from(byte) / 255.0)), byte);
        }
        assert_eq!((display_byte(f32::NAN), display_byte(-1.0), display_byte(9.0)), (0, 0, 255));
    }
}
