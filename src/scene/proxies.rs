//! What the methods beside the screen-space ones ask of a scene: places of cube maps. Plain data that
//! stands beside the geometry and changes nothing of it.

use super::Aabb;
use glam::Vec3;

/// A place where a cube map is captured, and the box that stands for the surroundings when its
/// lookups are corrected for parallax (Schmidt 2013, section 5.2, listing 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// What records and pictures call it.
    pub name: String,
    /// World position of the capture in metres, inside [`Probe::bounds`].
    pub position: Vec3,
    /// The proxy box (`AABB` in listing 1), world, metres.
    pub bounds: Aabb,
}

impl Probe {
    /// The probe of a scene that states none: in the middle of its bounds, with these as box.
    pub fn in_the_middle_of(bounds: Aabb) -> Self {
        Self { name: "middle".into(), position: 0.5 * (bounds.min + bounds.max), bounds }
    }

    /// Scales about the origin.
    pub(super) fn scale(&mut self, factor: f32) {
        self.position *= factor;
        self.bounds = Aabb { min: self.bounds.min * factor, max: self.bounds.max * factor };
    }
}
