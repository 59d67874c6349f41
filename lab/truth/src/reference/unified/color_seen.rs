//! What a glossy ray of `unified` sees at its hit, for the twin of `ColorSeen`.

use crate::reference::Level;
use glam::{Vec2, Vec3};

/// The colour that a glossy ray sees at its hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorSeen {
    /// Two levels of the chain, with their weights, which a device's filter mixes.
    Over([(Footprint, f32); 2]),
    /// A mean of those texels that the ray can have seen.
    Between(Vec3),
}

impl ColorSeen {
    /// The colour, linear.
    pub fn color(&self) -> Vec3 {
        match self {
            Self::Over([(low, _), (high, share)]) => low.mean + (high.mean - low.mean) * *share,
            Self::Between(color) => *color,
        }
    }
}

/// Four texels that a bilinear lookup mixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Their weighted mean.
    pub mean: Vec3,
    /// The least and the greatest of them, channel by channel.
    pub range: [Vec3; 2],
}

impl Footprint {
    /// What is around texture coordinates in an image.
    pub(super) fn around(image: &Level<Vec3>, uv: Vec2) -> Self {
        let side = Vec2::new(image.width as f32, image.height as f32);
        let place = (uv * side - 0.5).clamp(Vec2::ZERO, side - 1.0);
        let (first, part) = (place.as_uvec2(), place.fract());
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| image.at_clamped(first.x + x, first.y + y));
        let (upper, lower) = (a + (b - a) * part.x, c + (d - c) * part.x);
        Self { mean: upper + (lower - upper) * part.y, range: [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))] }
    }
}
