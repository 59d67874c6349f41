//! Verdict on the reflection of a pixel: whether it is right, and if it is wrong, whether the screen reference is right
//! (docs/dump.md, "Verdict").

use crate::reference::pixel::EstimatedColor;
use glam::Vec3;
use serde::{Serialize, Serializer};
use ssct_ground::math::linear_to_srgb;

/// The [`difference`] of two reflections above which they count as different.
pub const WRONG: f32 = 0.1;

/// Number of standard errors of a reference that are added to [`WRONG`].
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
    /// Judges a reflection, after its fade, by the references of the same pixel.
    pub fn judge(shown: Vec3, screen: &EstimatedColor, world: &EstimatedColor) -> Self {
        // Whether the shown reflection and the screen reference differ from the world reference.
        let [own, best] =
            [EstimatedColor { color: shown, ..EstimatedColor::default() }, *screen].map(|one| differs(&one, world));
        match (own, best) {
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

/// The difference of two linear colours as a display shows them: root mean square over the channels, in shares of the way from
/// black to white. In linear values, a missing dark reflection would look like a small error.
pub fn difference(a: Vec3, b: Vec3) -> f32 {
    rms(display(a) - display(b))
}

/// The colour that a display shows for a linear colour, 0…1 in each channel.
fn display(color: Vec3) -> Vec3 {
    color.map(|v| linear_to_srgb(if v.is_nan() { v } else { v.clamp(0.0, 1.0) }))
}

/// The root mean square of three numbers.
fn rms(v: Vec3) -> f32 {
    (v.length_squared() / 3.0).sqrt()
}

/// Whether two colours differ by more than [`WRONG`] and more than their standard errors explain; NaN always differs.
fn differs(a: &EstimatedColor, b: &EstimatedColor) -> bool {
    let reach = |one: &EstimatedColor| difference(one.color + STANDARD_ERRORS * one.standard_error, one.color);
    let found = difference(a.color, b.color);
    found.is_nan() || found > WRONG + reach(a).hypot(reach(b))
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
        // A display shows 0.36 in place of 0.29 here, which is hardly visible, although the linear value is half as bright
        // again.
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
