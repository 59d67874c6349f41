//! Conversions between view space, clip space, texture coordinates and depth (thesis Alg. 2, Eq. 2.3). Clip space has x
//! to the right, y up and depth 0…1; texture coordinates have (0, 0) at the top left (docs/definitions.md, "Spaces").

use glam::{DMat4, DVec3};

/// `Project` of Alg. 2: maps a view-space point to (u, v, depth).
pub fn project(view: DVec3, view_to_clip: &DMat4) -> DVec3 {
    let p = view_to_clip.project_point3(view);
    DVec3::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, p.z)
}

/// `Unproject` of Alg. 2: maps (u, v, depth) to a view-space point.
pub fn unproject(screen: DVec3, clip_to_view: &DMat4) -> DVec3 {
    clip_to_view.project_point3(DVec3::new(screen.x * 2.0 - 1.0, 1.0 - screen.y * 2.0, screen.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};
    use glam::Vec3;
    use proptest::prelude::*;

    fn camera(near_m: f32, far_m: f32) -> Camera {
        let lens = Lens { near_m, far_m, ..Lens::default() };
        Camera::new(Vec3::ZERO, Vec3::Z, lens, 16.0 / 9.0)
    }

    #[test]
    fn the_axes_are_where_the_definitions_put_them() {
        let m = camera(0.1, 1000.0).view_to_clip().as_dmat4();
        let centre = project(DVec3::new(0.0, 0.0, 5.0), &m);
        assert!((centre.x - 0.5).abs() < 1e-9 && (centre.y - 0.5).abs() < 1e-9);
        assert!(project(DVec3::new(1.0, 0.0, 5.0), &m).x > 0.5, "+x is right");
        assert!(project(DVec3::new(0.0, 1.0, 5.0), &m).y < 0.5, "+y is up");
        assert!(project(DVec3::new(0.0, 0.0, 0.1), &m).z.abs() < 1e-6, "near is 0");
        assert!((project(DVec3::new(0.0, 0.0, 1000.0), &m).z - 1.0).abs() < 1e-6, "far is 1");
        let reversed = camera(0.1, 1000.0).view_to_clip_reversed().as_dmat4();
        assert!((project(DVec3::new(0.0, 0.0, 0.1), &reversed).z - 1.0).abs() < 1e-6, "reversed near is 1");
        assert!(project(DVec3::new(0.0, 0.0, 1000.0), &reversed).z.abs() < 1e-6, "reversed far is 0");
    }

    proptest! {
        #[test]
        fn project_and_unproject_are_inverse(u in 0.0..1.0_f64, v in 0.0..1.0_f64, z in 0.2..900.0_f64) {
            for m in [camera(0.1, 1000.0).view_to_clip_reversed().as_dmat4(), camera(0.1, 1000.0).view_to_clip().as_dmat4()] {
                let depth = project(DVec3::new(0.0, 0.0, z), &m).z;
                let view = unproject(DVec3::new(u, v, depth), &m.inverse());
                prop_assert!((view.z - z).abs() < 1e-6 * z);
                let back = project(view, &m);
                prop_assert!((back - DVec3::new(u, v, depth)).length() < 1e-9);
            }
        }
    }
}
