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

use std::sync::LazyLock;

/// sRGB's transfer function, encoded to linear, for 0…1 (IEC 61966-2-1).
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// sRGB's transfer function, linear to encoded, for 0…1 (IEC 61966-2-1).
pub fn linear_to_srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// The angle of the point (x, y) in radians, rounded from f64. The built-in scenes need it to be the same on every machine, and C
/// libraries differ in the last bits of their `atan2f` (glibc before and since 2.41).
pub fn atan2(y: f32, x: f32) -> f32 {
    f64::from(y).atan2(f64::from(x)) as f32
}

/// Clamps a linear value to 0…1 and encodes it as an sRGB byte, as in the display image of docs/definitions.md,
/// "Surfaces". NaN becomes black.
pub fn display_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let mut byte = DISPLAY_BYTES.byte_of_part[(linear * DisplayBytes::PARTS as f32) as usize];
    while linear >= DISPLAY_BYTES.least_value[usize::from(byte) + 1] {
        // A greater byte begins within the part, at or before the value.
        byte += 1;
    }
    byte
}

/// Encodes a linear value of 0…1 as an sRGB byte by the definition, without the table that [`display_byte`] uses.
fn encoded_byte(linear: f32) -> u8 {
    (linear_to_srgb(linear) * 255.0 + 0.5) as u8
}

static DISPLAY_BYTES: LazyLock<DisplayBytes> = LazyLock::new(DisplayBytes::new);

/// A table of the linear values at which sRGB bytes begin. Looking a byte up is faster than computing a power.
struct DisplayBytes {
    /// The byte at the lower end of each of [`Self::PARTS`] equal parts of 0…1; the last entry is the byte of 1.
    byte_of_part: [u8; Self::PARTS + 1],
    /// The least linear value of each byte; the entry 256, which is no byte, is greater than every value.
    least_value: [f32; 257],
}

impl DisplayBytes {
    /// The number of parts: a power of two, so that the product of a value and this number is exact.
    const PARTS: usize = 4096;

    /// Computes both arrays from [`encoded_byte`].
    fn new() -> Self {
        let byte_of_part = std::array::from_fn(|part| encoded_byte(part as f32 / Self::PARTS as f32));
        // A binary search over the bits of floats finds each entry; positive floats and their bits have the same order.
        let mut least_value = [f32::INFINITY; 257];
        for (byte, least) in (0..=255).zip(&mut least_value) {
            let (mut below, mut above) = (0, 1.0_f32.to_bits());
            while below < above {
                let middle = below + (above - below) / 2;
                if encoded_byte(f32::from_bits(middle)) < byte { below = middle + 1 } else { above = middle }
            }
            *least = f32::from_bits(below);
        }
        Self { byte_of_part, least_value }
    }
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

    #[test]
    fn bytes_that_are_looked_up_are_those_of_the_definition() {
        let around = |least: &f32| [least.next_down().max(0.0), *least, least.next_up()];
        let beginnings = DISPLAY_BYTES.least_value[..256].iter().flat_map(around);
        for linear in beginnings.chain((0..=100_000).map(|k| k as f32 / 100_000.0)) {
            assert_eq!(display_byte(linear), encoded_byte(linear), "{linear:e}");
        }
    }
}
