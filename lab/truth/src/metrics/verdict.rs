//! Verdict on the reflection of a pixel: whether it matches the world reference, and if not, whether the screen
//! reference does (docs/dump.md, "Verdict").

use crate::reference::pixel::EstimatedColor;
use glam::Vec3;
use serde::{Serialize, Serializer};
use ssct_ground::math::linear_to_srgb;

/// The [`difference`] of two reflections above which they count as different.
pub const WRONG: f32 = 0.1;

/// The number of standard errors of a reference by which a difference may exceed [`WRONG`].
const STANDARD_ERRORS: f32 = 3.0;

/// Result of comparing a pixel's reflection with the references.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PixelVerdict {
    /// The pixel does not reflect.
    NotReflecting,
    /// The reflection matches the world reference.
    Right,
    /// The reflection differs from the world reference, though the screen reference matches it.
    WrongByScreen,
    /// The reflection differs from the world reference, and so does the screen reference.
    WrongByWorld,
}

impl PixelVerdict {
    /// Judges the reflection that a pixel shows after its fade (linear RGB) by the screen reference and the world
    /// reference of the same pixel.
    pub fn judge(shown: Vec3, screen: &EstimatedColor, world: &EstimatedColor) -> Self {
        // The shown colour has no standard error.
        let [shown_differs, screen_differs] =
            [EstimatedColor { color: shown, ..EstimatedColor::default() }, *screen].map(|color| differs(&color, world));
        match (shown_differs, screen_differs) {
            (false, _) => Self::Right,
            (true, false) => Self::WrongByScreen,
            (true, true) => Self::WrongByWorld,
        }
    }

    /// The name of the verdict in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotReflecting => "does not reflect",
            Self::Right => "right",
            Self::WrongByScreen => "wrong by the screen",
            Self::WrongByWorld => "wrong by the world",
        }
    }
}

impl Serialize for PixelVerdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Returns the difference of two linear colours as a display shows them: the root mean square over the sRGB channels,
/// where black and white differ by 1. In linear values, a missing dark reflection would count as a small error.
pub fn difference(a: Vec3, b: Vec3) -> f32 {
    rms(display(a) - display(b))
}

/// Returns the sRGB colour that a display shows for a linear colour, 0…1 in each channel; NaN stays NaN.
fn display(color: Vec3) -> Vec3 {
    color.map(|v| linear_to_srgb(if v.is_nan() { v } else { v.clamp(0.0, 1.0) }))
}

/// Returns the root mean square of the three components.
fn rms(v: Vec3) -> f32 {
    (v.length_squared() / 3.0).sqrt()
}

/// Returns whether the [`difference`] of two colours exceeds [`WRONG`] by more than their standard errors explain; NaN
/// always differs.
fn differs(a: &EstimatedColor, b: &EstimatedColor) -> bool {
    // The displayed difference that `STANDARD_ERRORS` standard errors of one colour make.
    let uncertainty =
        |known: &EstimatedColor| difference(known.color + STANDARD_ERRORS * known.standard_error, known.color);
    let measured = difference(a.color, b.color);
    measured.is_nan() || measured > WRONG + uncertainty(a).hypot(uncertainty(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey colour that is known without error.
    fn exact(grey: f32) -> EstimatedColor {
        EstimatedColor { color: Vec3::splat(grey), standard_error: Vec3::ZERO }
    }

    #[test]
    fn what_the_screen_has_decides_who_is_wrong() {
        let judged = |shown: f32, screen: f32, world: f32| {
            PixelVerdict::judge(Vec3::splat(shown), &exact(screen), &exact(world))
        };
        assert_eq!(judged(0.5, 0.0, 0.55), PixelVerdict::Right, "whatever the screen has");
        assert_eq!(judged(0.0, 0.5, 0.5), PixelVerdict::WrongByScreen);
        assert_eq!(judged(0.0, 0.0, 0.5), PixelVerdict::WrongByWorld);
        assert_eq!(judged(f32::NAN, 0.5, 0.5), PixelVerdict::WrongByScreen);
    }

    #[test]
    fn a_dark_reflection_that_is_missing_is_wrong() {
        let dark = exact(0.09);
        assert_eq!(PixelVerdict::judge(Vec3::ZERO, &dark, &dark), PixelVerdict::WrongByScreen);
        // A display hardly shows the difference of these values, although one of them is nearly half as bright again.
        assert!(difference(Vec3::splat(0.1), Vec3::splat(0.07)) < WRONG);
        assert_eq!(difference(Vec3::splat(7.0), Vec3::ONE), 0.0, "a display shows nothing above white");
    }

    #[test]
    fn a_difference_that_chance_explains_is_right() {
        let judged = |error: f32| {
            let world = EstimatedColor { color: Vec3::splat(0.5), standard_error: Vec3::splat(error) };
            PixelVerdict::judge(Vec3::splat(0.8), &exact(0.5), &world)
        };
        assert_eq!([judged(0.0), judged(0.1)], [PixelVerdict::WrongByScreen, PixelVerdict::Right]);
    }
}
