//! Additions to a scene that the methods outside screen space need: probes for cube maps, impostors, and lights
//! with an extent. They are plain data beside the geometry and do not change it.

use super::Aabb;
use glam::Vec3;

/// A place where a cube map is captured, and the box that approximates the surroundings when lookups are
/// corrected for parallax (Schmidt 2013, section 5.2, listing 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The name that records and pictures use.
    pub name: String,
    /// World position of the capture in metres, inside [`Probe::bounds`].
    pub position: Vec3,
    /// The proxy box (`AABB` in listing 1) in world space, in metres.
    pub bounds: Aabb,
}

/// A rectangle with an image that replaces a bright or important object in reflections (Schmidt 2013, §5.3, listing 2).
///
/// The image shows the object already lit, because an impostor is not lit again. The vectors half_u and half_v
/// point in the directions of increasing u and v, so half_u × half_v points to the side from which the image is
/// not mirrored. The point with texture coordinates (u, v) is `centre + (2u − 1) half_u + (2v − 1) half_v`.
#[derive(Debug, Clone, PartialEq)]
pub struct Impostor {
    /// The name that records and pictures use.
    pub name: String,
    /// World position of the rectangle's centre, in metres.
    pub centre: Vec3,
    /// From the centre to the middle of the image's right edge, world, metres.
    pub half_u: Vec3,
    /// From the centre to the middle of the image's bottom edge, world, metres; orthogonal to [`Impostor::half_u`].
    pub half_v: Vec3,
    /// Index into [`super::Scene::textures`] of an sRGB image; alpha is 0 where the object is absent.
    pub texture: usize,
}

/// A light with an extent, for the method `area-light` (thesis §3.1.1). Only that method sees it; it does not
/// light the scene, and neither the G-buffer nor the references include it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaLight {
    /// Position and shape.
    pub shape: AreaShape,
    /// Linear radiance, equal everywhere and in all directions; each channel is ≥ 0.
    pub radiance: Vec3,
}

/// The shape of an [`AreaLight`], with world positions and lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaShape {
    /// A ball.
    Sphere {
        /// Centre.
        centre: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
    /// All points within `radius` of a line segment: a tube with round ends.
    Capsule {
        /// One end of the segment.
        a: Vec3,
        /// The other end.
        b: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
    /// A rectangle that emits light on the side of half_u × half_v.
    Rectangle {
        /// Centre.
        centre: Vec3,
        /// From the centre to the middle of one edge.
        half_u: Vec3,
        /// From the centre to the middle of an adjacent edge; orthogonal to half_u.
        half_v: Vec3,
    },
    /// A box.
    Cuboid {
        /// Centre.
        centre: Vec3,
        /// From the centre to the middle of one face.
        half_u: Vec3,
        /// From the centre to the middle of an adjacent face; orthogonal to half_u.
        half_v: Vec3,
        /// Half the length of the third side, along half_u × half_v, > 0.
        half_w: f32,
    },
    /// A tube with flat ends, which shine too.
    Cylinder {
        /// The middle of one end.
        a: Vec3,
        /// The middle of the other end.
        b: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
}

impl Probe {
    /// The probe of a scene that defines none: at the centre of the scene's bounds, with the bounds as its box.
    pub fn in_the_middle_of(bounds: Aabb) -> Self {
        Self { name: "middle".into(), position: 0.5 * (bounds.min + bounds.max), bounds }
    }

    /// Scales the probe about the origin.
    pub fn scale(&mut self, factor: f32) {
        self.position *= factor;
        self.bounds = Aabb { min: self.bounds.min * factor, max: self.bounds.max * factor };
    }

    pub(super) fn translate(&mut self, offset: Vec3) {
        self.position += offset;
        self.bounds = Aabb { min: self.bounds.min + offset, max: self.bounds.max + offset };
    }
}

impl Impostor {
    /// Returns the unit vector towards the side from which the image is not mirrored.
    pub fn normal(&self) -> Vec3 {
        self.half_u.cross(self.half_v).normalize_or(Vec3::NEG_Z)
    }

    /// Scales the impostor about the origin.
    pub fn scale(&mut self, factor: f32) {
        self.centre *= factor;
        self.half_u *= factor;
        self.half_v *= factor;
    }
}

impl AreaShape {
    /// Scales the shape about the origin.
    pub fn scale(&mut self, factor: f32) {
        match self {
            Self::Sphere { centre, radius } => {
                *centre *= factor;
                *radius *= factor;
            }
            Self::Capsule { a, b, radius } | Self::Cylinder { a, b, radius } => {
                *a *= factor;
                *b *= factor;
                *radius *= factor;
            }
            Self::Rectangle { centre, half_u, half_v } => {
                *centre *= factor;
                *half_u *= factor;
                *half_v *= factor;
            }
            Self::Cuboid { centre, half_u, half_v, half_w } => {
                *centre *= factor;
                *half_u *= factor;
                *half_v *= factor;
                *half_w *= factor;
            }
        }
    }

    pub(super) fn translate(&mut self, offset: Vec3) {
        match self {
            Self::Sphere { centre, .. } | Self::Rectangle { centre, .. } | Self::Cuboid { centre, .. } => {
                *centre += offset;
            }
            Self::Capsule { a, b, .. } | Self::Cylinder { a, b, .. } => {
                *a += offset;
                *b += offset;
            }
        }
    }
}
