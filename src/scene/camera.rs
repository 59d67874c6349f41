//! Lenses, views and cameras.

use super::MaterialChange;
use glam::camera::lh::{proj::directx::perspective, view::look_to_mat4};
use glam::{DMat4, DVec3, DVec4, Mat4, Vec3, Vec4};

/// The projection's numbers, without the aspect ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Vertical field of view in radians, 0 < fov < π.
    pub fov_y_radians: f32,
    /// Near plane in metres, > 0.
    pub near_m: f32,
    /// Far plane in metres, > near.
    pub far_m: f32,
}

impl Default for Lens {
    /// The author's program: 74° vertical, near 0.1, far 1000.
    fn default() -> Self {
        Self { fov_y_radians: 74_f32.to_radians(), near_m: 0.1, far_m: 1000.0 }
    }
}

/// A named place to look from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// The name on the command line and in records.
    pub name: String,
    /// Camera position, world, metres.
    pub eye: Vec3,
    /// A point in the middle of the image.
    pub look_at: Vec3,
    /// A lens other than the scene's.
    pub lens: Option<Lens>,
    /// Materials that this view changes, by name.
    pub materials: Vec<(String, MaterialChange)>,
}

/// A view through a lens at an aspect ratio: the matrices of DEFINITIONS, "Spaces".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view: left-handed, +z into the scene.
    pub world_to_view: Mat4,
    /// The lens.
    pub lens: Lens,
    /// Width over height of the image.
    pub aspect: f32,
    /// A plane in view space that stands for the near plane where depth is reversed: of the points
    /// with n · x + w < 0 nothing is drawn. The camera stands behind it.
    pub near_plane: Option<Vec4>,
}

/// What stands so close before a mirror isn't seen in it, in metres: so the mirror doesn't show itself.
const MIRROR_CLEARANCE_M: f64 = 2e-3;

impl Camera {
    /// A camera at `eye` towards `look_at`. Straight up or down, the image's up is world +z or −z.
    pub fn new(eye: Vec3, look_at: Vec3, lens: Lens, aspect: f32) -> Self {
        let forward = (look_at - eye).normalize_or(Vec3::Z);
        let up = if forward.y.abs() > 0.999_999 { Vec3::Z * -forward.y.signum() } else { Vec3::Y };
        Self { world_to_view: look_to_mat4(eye, forward, up), lens, aspect, near_plane: None }
    }

    /// View to clip with standard depth (near 0, far 1): what the published methods use.
    pub fn view_to_clip(&self) -> Mat4 {
        perspective(self.lens.fov_y_radians, self.aspect, self.lens.near_m, self.lens.far_m)
    }

    /// View to clip with reversed depth (near 1, far 0): what the G-buffer is rendered with.
    ///
    /// With a [`Camera::near_plane`] the third row makes that plane the near one (Lengyel 2005, for
    /// reversed depth): depth is 1 − s (n · x + w) / z, and s keeps the frustum's corners above 0.
    pub fn view_to_clip_reversed(&self) -> Mat4 {
        let usual = perspective(self.lens.fov_y_radians, self.aspect, self.lens.far_m, self.lens.near_m);
        let Some(plane) = self.near_plane.map(|p| p.as_dvec4()) else { return usual };
        let up = f64::from(0.5 * self.lens.fov_y_radians).tan();
        let right = up * f64::from(self.aspect);
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let steepest = corners
            .map(|(x, y)| plane.truncate().dot(DVec3::new(x * right, y * up, 1.0)))
            .into_iter()
            .fold(0.0, f64::max);
        let scale = if steepest > 0.0 { 0.999 / steepest } else { 1.0 };
        let depth = (DVec4::Z - scale * plane).as_vec4();
        let mut rows = usual.transpose();
        rows.z_axis = depth;
        rows.transpose()
    }

    /// A plane of the world (unit normal and offset) in this camera's view space.
    pub fn plane_in_view(&self, plane: Vec4) -> Vec4 {
        (self.world_to_view.as_dmat4().inverse().transpose() * plane.as_dvec4()).as_vec4()
    }

    /// This camera's view of the world mirrored at a plane of the world (unit normal towards the camera,
    /// and offset): each mirrored point appears where the mirror shows it. What stands behind the mirror
    /// is cut away. The view turns windings round, for it has a determinant of −1.
    pub fn mirrored(&self, plane: Vec4) -> Self {
        let (normal, offset) = (plane.truncate().as_dvec3(), f64::from(plane.w));
        // x − 2 (n · x + w) n
        let mirror = DMat4::from_cols(
            (DVec3::X - 2.0 * normal.x * normal).extend(0.0),
            (DVec3::Y - 2.0 * normal.y * normal).extend(0.0),
            (DVec3::Z - 2.0 * normal.z * normal).extend(0.0),
            (-2.0 * offset * normal).extend(1.0),
        );
        let mut before = -self.plane_in_view(plane).as_dvec4();
        before.w -= MIRROR_CLEARANCE_M;
        Self {
            world_to_view: (self.world_to_view.as_dmat4() * mirror).as_mat4(),
            near_plane: Some(before.as_vec4()),
            ..*self
        }
    }

    /// Camera position in the world.
    pub fn eye(&self) -> Vec3 {
        self.world_to_view.inverse().w_axis.truncate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_point_appears_where_the_mirror_shows_it() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, -3.0), Vec3::new(0.5, 0.5, 4.0), Lens::default(), 1.5);
        let normal = Vec3::new(0.1, 0.9, -0.2).normalize();
        let plane = normal.extend(0.3);
        let behind = camera.mirrored(plane);
        let usual = camera.view_to_clip_reversed() * camera.world_to_view;
        let mirrored = behind.view_to_clip_reversed() * behind.world_to_view;
        for point in [Vec3::new(0.0, 1.0, 3.0), Vec3::new(-2.0, 3.0, 8.0), Vec3::new(3.0, 6.4, 20.0)] {
            let distance = normal.dot(point) + 0.3;
            assert!(distance > 0.0, "before the mirror");
            let image = point - 2.0 * distance * normal;
            let [seen, shown] = [usual.project_point3(image), mirrored.project_point3(point)];
            assert!(seen.truncate().distance(shown.truncate()) < 1e-4, "{seen} is not {shown}");
            assert!(shown.z > 0.0 && shown.z < 1.0, "{shown}");
            // On the plane depth is 1 but for the clearance, and behind it more: cut away.
            let foot = point - distance * normal;
            assert!((mirrored.project_point3(foot).z - 1.0).abs() < 0.02 && mirrored.project_point3(foot).z > 1.0);
            assert!(mirrored.project_point3(image).z > 1.0);
        }
        assert!(behind.world_to_view.determinant() < 0.0);
        assert!(behind.mirrored(plane).world_to_view.abs_diff_eq(camera.world_to_view, 1e-5));
    }

    #[test]
    fn the_near_plane_keeps_the_order_of_depths() {
        let camera = Camera::new(Vec3::new(0.0, 1.6, 0.0), Vec3::new(0.0, 1.0, 5.0), Lens::default(), 1.5);
        let behind = camera.mirrored(Vec3::Y.extend(0.0));
        let matrix = behind.view_to_clip_reversed();
        for (x, y) in [(-1.0, -0.9), (0.0, -0.3), (0.9, 0.1)] {
            // A ray down the view, through a point just behind the mirror. (Far away its depth tends to a
            // number above 0, which depends on the ray.)
            let ray = matrix.inverse().project_point3(Vec3::new(x, y, 0.999)).normalize();
            let depths: Vec<f32> =
                (1..40).map(|k| matrix.project_point3(ray * (1.5 + k as f32 * k as f32)).z).collect();
            assert!(depths.windows(2).all(|d| d[0] > d[1]), "{x}, {y}: {depths:?}");
            assert!(depths.iter().all(|d| *d > 0.0), "{x}, {y}: {depths:?}");
        }
    }
}
