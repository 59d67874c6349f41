//! Pure functions that the references and the methods share: colour encoding, projection, cones, the Phong lobe,
//! random numbers and noise, and the versions of the oracle.

pub mod cone;
pub mod constants;
pub mod frustum;
pub mod noise;
pub mod phong;
pub mod projection;
pub mod random;
pub mod version;

pub use version::OracleVersion;

/// sRGB's transfer function, encoded to linear, for 0…1 (IEC 61966-2-1).
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// sRGB's transfer function, linear to encoded, for 0…1 (IEC 61966-2-1).
pub fn linear_to_srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// The angle of the point (x, y) in radians, rounded from f64. The built-in scenes are made with this function, since C libraries
/// differ in the last bits of their `atan2f` (glibc before and since 2.41), and a scene must be the same on every machine.
pub fn atan2(y: f32, x: f32) -> f32 {
    f64::from(y).atan2(f64::from(x)) as f32
}

/// Clamps a linear value to 0…1 and encodes it as an sRGB byte, as in the display image of docs/definitions.md,
/// "Surfaces". NaN becomes black.
pub fn display_byte(linear: f32) -> u8 {
    (linear_to_srgb(linear.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
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
