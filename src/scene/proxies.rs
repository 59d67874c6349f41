//! What the methods beside the screen-space ones ask of a scene: places of cube maps, impostors, and
//! lights with an extent. Plain data that stands beside the geometry and changes nothing of it.

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

/// A rectangle with an image that stands in reflections for something bright or relevant (Schmidt
/// 2013, section 5.3, listing 2).
///
/// The image shows the thing as the scene lights it, for an impostor isn't lit again. Both halves
/// run the way of the texture coordinates, so half_u × half_v points to the side from which the
/// image reads unmirrored. The point of texture coordinates (u, v) is
/// `centre + (2u − 1) half_u + (2v − 1) half_v`.
#[derive(Debug, Clone, PartialEq)]
pub struct Impostor {
    /// What records and pictures call it.
    pub name: String,
    /// World position of its middle, metres.
    pub centre: Vec3,
    /// From the centre to the middle of the image's right edge, world, metres.
    pub half_u: Vec3,
    /// From the centre to the middle of the image's bottom edge, world, metres; orthogonal to
    /// [`Impostor::half_u`].
    pub half_v: Vec3,
    /// Index into [`super::Scene::textures`] of an sRGB image; alpha 0 where nothing is.
    pub texture: usize,
}

/// A light with an extent, for the method `area-light` (thesis §3.1.1). It lights nothing else: no
/// other method sees it, and neither G-buffer nor references do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaLight {
    /// Where it is and what it is like.
    pub shape: AreaShape,
    /// Linear radiance that it gives off evenly, each channel ≥ 0.
    pub radiance: Vec3,
}

/// The shape of an [`AreaLight`]: world positions and lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaShape {
    /// A ball.
    Sphere {
        /// Its middle.
        centre: Vec3,
        /// Greater than 0.
        radius: f32,
    },
    /// All points within a distance of a line segment: a tube with round ends.
    Capsule {
        /// One end of the segment.
        a: Vec3,
        /// The other.
        b: Vec3,
        /// Greater than 0.
        radius: f32,
    },
    /// A rectangle that shines to the side of half_u × half_v.
    Rectangle {
        /// Its middle.
        centre: Vec3,
        /// From the middle to the middle of one edge.
        half_u: Vec3,
        /// To the middle of the next; orthogonal to half_u.
        half_v: Vec3,
    },
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

    /// Moves it.
    pub(super) fn translate(&mut self, offset: Vec3) {
        self.position += offset;
        self.bounds = Aabb { min: self.bounds.min + offset, max: self.bounds.max + offset };
    }
}

impl Impostor {
    /// Unit vector to the side from which the image reads unmirrored.
    pub fn normal(&self) -> Vec3 {
        self.half_u.cross(self.half_v).normalize_or(Vec3::NEG_Z)
    }

    /// Scales about the origin.
    pub(super) fn scale(&mut self, factor: f32) {
        self.centre *= factor;
        self.half_u *= factor;
        self.half_v *= factor;
    }
}

impl AreaShape {
    /// Scales about the origin.
    pub(super) fn scale(&mut self, factor: f32) {
        match self {
            Self::Sphere { centre, radius } => {
                *centre *= factor;
                *radius *= factor;
            }
            Self::Capsule { a, b, radius } => {
                *a *= factor;
                *b *= factor;
                *radius *= factor;
            }
            Self::Rectangle { centre, half_u, half_v } => {
                *centre *= factor;
                *half_u *= factor;
                *half_v *= factor;
            }
        }
    }

    /// Moves it.
    pub(super) fn translate(&mut self, offset: Vec3) {
        match self {
            Self::Sphere { centre, .. } | Self::Rectangle { centre, .. } => *centre += offset,
            Self::Capsule { a, b, .. } => {
                *a += offset;
                *b += offset;
            }
        }
    }
}
