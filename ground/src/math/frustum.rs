//! Visibility of boxes and triangles against a clip volume.

use glam::{Mat4, Vec3, Vec4};

/// The six planes of a clip volume with standard or reversed depth, pointing inwards, in the space that the matrix maps from.
pub struct Frustum([Vec4; 6]);

impl Frustum {
    /// The planes of `to_clip` (Gribb and Hartmann 2001).
    pub fn new(to_clip: &Mat4) -> Self {
        let [x, y, z, w] = [to_clip.row(0), to_clip.row(1), to_clip.row(2), to_clip.row(3)];
        Self([w + x, w - x, w + y, w - y, z, w - z])
    }

    /// Returns false if a box lies wholly outside one of the planes, or is empty; else true.
    pub fn may_see(&self, min: Vec3, max: Vec3) -> bool {
        min.cmple(max).all()
            && self.0.iter().all(|plane| {
                let normal = plane.truncate();
                let farthest = Vec3::select(normal.cmpge(Vec3::ZERO), max, min);
                normal.dot(farthest) + plane.w >= 0.0
            })
    }
}

/// The share of the screen that a triangle would cover if nothing hid it. `to_clip` has standard depth. The triangle is clipped
/// against all planes but the far one, and counts from both sides.
pub fn projected_area(to_clip: &Mat4, triangle: &[Vec3; 3]) -> f32 {
    let planes = [Vec4::Z, Vec4::W + Vec4::X, Vec4::W - Vec4::X, Vec4::W + Vec4::Y, Vec4::W - Vec4::Y];
    let mut polygon: Vec<Vec4> = triangle.iter().map(|p| *to_clip * p.extend(1.0)).collect();
    for plane in planes {
        // Cuts off the part of the polygon behind the plane (Sutherland and Hodgman 1974).
        let mut clipped = Vec::with_capacity(polygon.len() + 1);
        for (i, &corner) in polygon.iter().enumerate() {
            let next = polygon[(i + 1) % polygon.len()];
            let (from, to) = (plane.dot(corner), plane.dot(next));
            if from >= 0.0 {
                clipped.push(corner);
            }
            if (from >= 0.0) != (to >= 0.0) {
                clipped.push(corner.lerp(next, from / (from - to)));
            }
        }
        polygon = clipped;
    }
    let points: Vec<_> = polygon.iter().filter(|p| p.w > 0.0).map(|p| p.truncate().truncate() / p.w).collect();
    let doubled_area: f32 =
        (2..points.len()).map(|i| (points[i - 1] - points[0]).perp_dot(points[i] - points[0])).sum();
    0.125 * doubled_area.abs() // ½ · ¼, since the screen's area in these coordinates is 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};

    #[test]
    fn the_area_of_a_triangle_is_that_of_its_part_on_screen() {
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, Lens::perspective(1.0, 0.1, 1000.0), 1.0);
        let matrix = camera.view_to_clip() * camera.world_to_view;
        let half_height = 5.0 * 0.5_f32.tan(); // at a distance of 5 m
        let point = |x: f32, y: f32| Vec3::new(x * half_height, y * half_height, 5.0);
        let area = |a, b, c| projected_area(&matrix, &[a, b, c]);
        assert!((area(point(-1.0, -1.0), point(1.0, -1.0), point(1.0, 1.0)) - 0.5).abs() < 1e-4, "half the screen");
        assert!(
            (area(point(-9.0, -1.0), point(9.0, -1.0), point(0.0, 80.0)) - 1.0).abs() < 1e-4,
            "more than all of it"
        );
        assert_eq!(area(point(2.0, 0.0), point(3.0, 0.0), point(3.0, 1.0)), 0.0, "beside it");
        assert_eq!(area(-point(-1.0, -1.0), -point(1.0, -1.0), -point(1.0, 1.0)), 0.0, "behind");
        // A floor that begins behind the camera covers the lower half of the screen, but for what the near plane cuts.
        let floor = area(Vec3::new(-1e4, -1.0, -1e3), Vec3::new(1e4, -1.0, -1e3), Vec3::new(0.0, -1.0, 1e6));
        assert!((0.49..0.5).contains(&floor), "{floor}");
    }

    #[test]
    fn boxes_in_front_are_seen_and_others_are_not() {
        let camera = Camera::new(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 5.0), Lens::default(), 1.5);
        let frustum = Frustum::new(&(camera.view_to_clip_reversed() * camera.world_to_view));
        let cube = |x: f32, y: f32, z: f32| frustum.may_see(Vec3::new(x, y, z) - 0.5, Vec3::new(x, y, z) + 0.5);
        assert!(cube(0.0, 1.0, 5.0));
        assert!(!cube(0.0, 1.0, -5.0), "behind");
        assert!(!cube(20.0, 1.0, 5.0), "right");
        assert!(!cube(0.0, -20.0, 5.0), "below");
        assert!(!cube(0.0, 1.0, 1002.0), "beyond far");
        assert!(frustum.may_see(Vec3::splat(-1e4), Vec3::splat(1e4)), "around the camera");
        assert!(!frustum.may_see(Vec3::INFINITY, Vec3::NEG_INFINITY), "empty");
    }
}
