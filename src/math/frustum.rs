//! Frustum culling of boxes.

use glam::{Mat4, Vec3, Vec4};

/// The six planes of a clip volume with depth 0…1, pointing inwards, in the space that the matrix
/// maps from. Works for standard and reversed depth alike.
pub struct Frustum([Vec4; 6]);

impl Frustum {
    /// The planes of `to_clip` (Gribb and Hartmann 2001).
    pub fn new(to_clip: &Mat4) -> Self {
        let [x, y, z, w] = [to_clip.row(0), to_clip.row(1), to_clip.row(2), to_clip.row(3)];
        Self([w + x, w - x, w + y, w - y, z, w - z])
    }

    /// False only if a box lies wholly outside one plane. An empty box is outside.
    pub fn may_see(&self, min: Vec3, max: Vec3) -> bool {
        min.cmple(max).all()
            && self.0.iter().all(|plane| {
                let normal = plane.truncate();
                let farthest = Vec3::select(normal.cmpge(Vec3::ZERO), max, min);
                normal.dot(farthest) + plane.w >= 0.0
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};

    #[test]
    fn boxes_in_front_are_seen_and_others_are_not() {
        let c = Camera::new(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 5.0), Lens::default(), 1.5);
        let f = Frustum::new(&(c.view_to_clip_reversed() * c.world_to_view));
        let cube = |x: f32, y: f32, z: f32| f.may_see(Vec3::new(x, y, z) - 0.5, Vec3::new(x, y, z) + 0.5);
        assert!(cube(0.0, 1.0, 5.0));
        assert!(!cube(0.0, 1.0, -5.0), "behind");
        assert!(!cube(20.0, 1.0, 5.0), "right");
        assert!(!cube(0.0, -20.0, 5.0), "below");
        assert!(!cube(0.0, 1.0, 1002.0), "beyond far");
        assert!(f.may_see(Vec3::splat(-1e4), Vec3::splat(1e4)), "around the camera");
        assert!(!f.may_see(Vec3::INFINITY, Vec3::NEG_INFINITY), "empty");
    }
}
