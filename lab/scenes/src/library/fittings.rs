//! Parts that are fitted to walls: recesses, frames, mouldings and pictures.

use super::builder::{MeshBuilder, Rect};
use glam::{Vec2, Vec3};
use ssct_geometry::impostor_image::ImpostorFrame;

/// The face of an upright wall along x or z. A point of the face is given by its metres to the right of the origin, as
/// seen from the front, and by its height: the x and the y of a [`Rect`].
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// A point of the face at height 0.
    pub origin: Vec3,
    /// Unit vector to the right, as seen from the front.
    pub right: Vec3,
}

impl Face {
    /// Makes a face from a point at height 0 and the unit vector to the right.
    pub fn new(origin: [f32; 3], right: Vec3) -> Self {
        Self { origin: Vec3::from(origin), right }
    }

    /// Returns the unit vector out of the wall.
    pub fn outward(&self) -> Vec3 {
        Vec3::Y.cross(self.right)
    }

    /// Returns the world-space point `x` metres to the right of the origin, at the height `y`, and `out_m` metres out
    /// of the wall.
    pub fn point_at(&self, x: f32, y: f32, out_m: f32) -> Vec3 {
        self.origin + x * self.right + y * Vec3::Y + out_m * self.outward()
    }

    /// Adds the part of the face within `extent`, except for the openings `holes`.
    pub fn wall(&self, mesh: &mut MeshBuilder, extent: Rect, holes: &[Rect]) {
        mesh.panel([self.origin, self.right, Vec3::Y], extent, holes);
    }

    /// Adds a box over a rectangle of the face, from `from` to `to` metres out of the wall; negative distances are
    /// inside the wall.
    pub fn block(&self, mesh: &mut MeshBuilder, rect: Rect, [from, to]: [f32; 2]) {
        let (corner, opposite) =
            (self.point_at(rect.min.x, rect.min.y, from), self.point_at(rect.max.x, rect.max.y, to));
        mesh.cuboid(corner.min(opposite), corner.max(opposite));
    }

    /// Adds a frame of four boxes around a rectangle. The boxes are `width` metres wide, and lie between the two
    /// distances `out_m` out of the wall.
    pub fn border(&self, mesh: &mut MeshBuilder, rect: Rect, width: f32, out_m: [f32; 2]) {
        let (low, high) = (rect.min, rect.max);
        let outer = Rect { min: low - width, max: high + width };
        let (x, y) = ([outer.min.x, outer.max.x], [low.y, high.y]);
        for bar in [
            Rect::new(x, [outer.min.y, low.y]),
            Rect::new(x, [high.y, outer.max.y]),
            Rect::new([outer.min.x, low.x], y),
            Rect::new([high.x, outer.max.x], y),
        ] {
            self.block(mesh, bar, out_m);
        }
    }

    /// Adds the four inner sides (reveals) of the opening `rect`, which reaches `depth` metres into the wall. They face
    /// the middle of the opening.
    pub fn reveals(&self, mesh: &mut MeshBuilder, rect: Rect, depth: f32) {
        let (low, high) = (rect.min, rect.max);
        let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
        let middle = 0.5 * (low + high);
        for k in 0..4 {
            let ((x, y), (next_x, next_y)) = (corners[k], corners[(k + 1) % 4]);
            let edge_middle = self.point_at(0.5 * (x + next_x), 0.5 * (y + next_y), 0.0);
            let facing = self.point_at(middle.x, middle.y, 0.0) - edge_middle;
            let side = [
                self.point_at(x, y, 0.0),
                self.point_at(next_x, next_y, 0.0),
                self.point_at(next_x, next_y, -depth),
                self.point_at(x, y, -depth),
            ];
            mesh.polygon(&side, facing);
        }
    }

    /// Adds a rectangle that shows one whole image, `out_m` metres out of the wall.
    pub fn picture(&self, mesh: &mut MeshBuilder, rect: Rect, out_m: f32) {
        let (middle, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
        mesh.picture(self.point_at(middle.x, middle.y, out_m), half.x * self.right, half.y * Vec3::Y);
    }

    /// Returns the frame of an impostor over a rectangle, `out_m` metres out of the wall, whose image is `width` texels
    /// wide.
    pub fn portrait(&self, name: &'static str, rect: Rect, out_m: f32, width: u32) -> ImpostorFrame {
        let (middle, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
        ImpostorFrame {
            name,
            centre: self.point_at(middle.x, middle.y, out_m),
            half_right: half.x * self.right,
            half_up: half.y * Vec3::Y,
            width,
        }
    }
}

/// Makes a rectangle from the x and y of its centre and its size, in metres.
pub fn centred_rect(x: f32, y: f32, width: f32, height: f32) -> Rect {
    let half = 0.5 * Vec2::new(width, height);
    Rect { min: Vec2::new(x, y) - half, max: Vec2::new(x, y) + half }
}

/// Makes a rectangle that stands on the ground, from the x of its middle, its width and its height, in metres.
pub fn standing_rect(x: f32, width: f32, height: f32) -> Rect {
    Rect::new([x - 0.5 * width, x + 0.5 * width], [0.0, height])
}
