//! Parts that are fitted to walls: recesses, frames, mouldings and pictures.

use super::builder::{MeshBuilder, Rect};
use glam::{Vec2, Vec3};
use ssct_geometry::impostor_image::ImpostorFrame;

/// The face of an upright wall along x or z. A point is given by `a`, its metres to the right of the origin (seen from the
/// front), a height, and a distance out of the wall.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// A point of the face at height 0.
    pub origin: Vec3,
    /// Unit vector to the right.
    pub right: Vec3,
}

impl Face {
    /// A face from a point at height 0 and its unit vector to the right.
    pub fn new(origin: [f32; 3], right: Vec3) -> Self {
        Self { origin: Vec3::from(origin), right }
    }

    /// Unit vector out of the wall.
    pub fn outward(&self) -> Vec3 {
        Vec3::Y.cross(self.right)
    }

    /// The world-space point `a` metres to the right of the origin, at the height `y`, `out` metres out of the wall.
    pub fn point_at(&self, a: f32, y: f32, out: f32) -> Vec3 {
        self.origin + a * self.right + y * Vec3::Y + out * self.outward()
    }

    /// Adds the face itself, with openings.
    pub fn wall(&self, mesh: &mut MeshBuilder, extent: Rect, holes: &[Rect]) {
        mesh.panel([self.origin, self.right, Vec3::Y], extent, holes);
    }

    /// A box on or in the face, between two distances out of the face.
    pub fn block(&self, mesh: &mut MeshBuilder, rect: Rect, [from, to]: [f32; 2]) {
        let (p, q) = (self.point_at(rect.min.x, rect.min.y, from), self.point_at(rect.max.x, rect.max.y, to));
        mesh.cuboid(p.min(q), p.max(q));
    }

    /// Four boxes around a rectangle, `width` wide, between two distances out of the face.
    pub fn border(&self, mesh: &mut MeshBuilder, rect: Rect, width: f32, out: [f32; 2]) {
        let (low, high) = (rect.min, rect.max);
        let outer = Rect { min: low - width, max: high + width };
        let (x, y) = ([outer.min.x, outer.max.x], [low.y, high.y]);
        for bar in [
            Rect::new(x, [outer.min.y, low.y]),
            Rect::new(x, [high.y, outer.max.y]),
            Rect::new([outer.min.x, low.x], y),
            Rect::new([high.x, outer.max.x], y),
        ] {
            self.block(mesh, bar, out);
        }
    }

    /// The four reveals of an opening that is `depth` deep.
    pub fn reveals(&self, mesh: &mut MeshBuilder, rect: Rect, depth: f32) {
        let (low, high) = (rect.min, rect.max);
        let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
        let middle = 0.5 * (low + high);
        for k in 0..4 {
            let ((a, b), (c, d)) = (corners[k], corners[(k + 1) % 4]);
            let facing = self.point_at(middle.x, middle.y, 0.0) - self.point_at(0.5 * (a + c), 0.5 * (b + d), 0.0);
            let sides = [
                self.point_at(a, b, 0.0),
                self.point_at(c, d, 0.0),
                self.point_at(c, d, -depth),
                self.point_at(a, b, -depth),
            ];
            mesh.polygon(&sides, facing);
        }
    }

    /// A rectangle that shows one whole image, `out` metres out of the wall.
    pub fn picture(&self, mesh: &mut MeshBuilder, rect: Rect, out: f32) {
        let (middle, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
        mesh.picture(self.point_at(middle.x, middle.y, out), half.x * self.right, half.y * Vec3::Y);
    }

    /// The rectangle of an impostor, `out` metres out of the wall, whose image is `width` texels wide.
    pub fn portrait(&self, name: &'static str, rect: Rect, out: f32, width: u32) -> ImpostorFrame {
        let (middle, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
        ImpostorFrame {
            name,
            centre: self.point_at(middle.x, middle.y, out),
            half_right: half.x * self.right,
            half_up: half.y * Vec3::Y,
            width,
        }
    }
}

/// A rectangle given by its centre and size.
pub fn centred_rect(a: f32, y: f32, width: f32, height: f32) -> Rect {
    let half = 0.5 * Vec2::new(width, height);
    Rect { min: Vec2::new(a, y) - half, max: Vec2::new(a, y) + half }
}

/// A rectangle that stands on the ground, given by its centre, width and height.
pub fn standing(a: f32, width: f32, height: f32) -> Rect {
    Rect::new([a - 0.5 * width, a + 0.5 * width], [0.0, height])
}
