//! Lenses, views and cameras.

use super::MaterialChange;
use glam::camera::lh::{proj::directx::perspective, view::look_to_mat4};
use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec3, Vec4};

/// The parameters of a perspective projection, without the aspect ratio.
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
    /// The lens of the author's program: 74° vertical field of view, near plane 0.1 m, far plane 1000 m.
    fn default() -> Self {
        Self { fov_y_radians: 74_f32.to_radians(), near_m: 0.1, far_m: 1000.0 }
    }
}

/// A named camera position of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// The name that users and records use.
    pub name: String,
    /// Camera position in world space, in metres.
    pub eye: Vec3,
    /// The world-space point in the middle of the image.
    pub look_at: Vec3,
    /// A lens that replaces the scene's.
    pub lens: Option<Lens>,
    /// Changes to materials, by the material's name.
    pub materials: Vec<(String, MaterialChange)>,
}

/// A view through a lens at an aspect ratio, with the matrices of docs/definitions.md, "Spaces".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view: left-handed, +z into the scene.
    pub world_to_view: Mat4,
    /// The lens.
    pub lens: Lens,
    /// Width over height of the image.
    pub aspect: f32,
    /// A plane in view space that replaces the near plane where depth is reversed: points with n · x + w < 0
    /// are not drawn. The camera must be behind it.
    pub near_plane: Option<Vec4>,
    /// A projection that is known by its numbers alone, in place of lens and aspect.
    pub projection: Option<Projection>,
}

/// The elements of a perspective matrix with reversed depth that are neither 0 nor 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// M_00 and M_11, both above 0: y is up in clip space.
    pub scale: [f32; 2],
    /// How far the image is shifted against the axis of the view: M_02 and M_12, in units of ndc.
    pub shift: [f32; 2],
    /// M_22 and M_23: depth is the first plus the second over z.
    pub depth: [f32; 2],
}

impl Projection {
    /// The matrix, with reversed depth or with standard depth, which is one minus that.
    fn matrix(self, reversed: bool) -> Mat4 {
        let Self { scale: [x, y], shift: [u, v], depth: [a, b] } = self;
        let [a, b] = if reversed { [a, b] } else { [1.0 - a, -b] };
        Mat4::from_cols_array_2d(&[[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [u, v, a, 1.0], [0.0, 0.0, b, 0.0]])
    }
}

/// What can be read off the perspective matrix of any renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadProjection {
    /// The projection in the conventions of this crate.
    pub projection: Projection,
    /// For each axis, 1 if the renderer's view space and ours have it in the same direction, −1 if in opposite ones.
    pub turn: Vec3,
    /// Whether the matrix gives reversed depth.
    pub is_reversed: bool,
    /// The distance of the near plane, in the unit of length of the matrix.
    pub near: f32,
    /// The distance of the far plane; infinite for a projection without one.
    pub far: f32,
}

impl ReadProjection {
    /// Reads a matrix that is multiplied by column vectors, with depth from 0 to 1; `y_is_up` says whether the top of
    /// the image is at y = w.
    ///
    /// # Errors
    /// Why the matrix cannot be used, as the rest of a sentence that begins with its name.
    pub fn new(clip: &Mat4, y_is_up: bool) -> Result<Self, &'static str> {
        if !clip.is_finite() {
            return Err("has numbers that are not finite");
        }
        let [x, y, z, w] = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis];
        if x.w != 0.0 || y.w != 0.0 || w.w != 0.0 || z.w.abs() != 1.0 {
            return Err("is no perspective projection: its last row must be 0, 0, ±1, 0");
        }
        let is_plain = x.y == 0.0 && x.z == 0.0 && y.x == 0.0 && y.z == 0.0 && w.x == 0.0 && w.y == 0.0;
        if !is_plain || x.x == 0.0 || y.y == 0.0 {
            return Err("has a rotation, a skew or a translation, or a view of no width");
        }
        let forward = z.w;
        let up = if y_is_up { 1.0 } else { -1.0 };
        let turn = Vec3::new(x.x.signum(), (up * y.y).signum(), forward);
        // Depth is a + b / z, with z along the view.
        let (a, b) = (z.z * forward, w.z);
        let is_reversed = b > 0.0;
        let [a, b] = if is_reversed { [a, b] } else { [1.0 - a, -b] };
        let near = b / (1.0 - a);
        if !(b > 0.0 && near > 0.0) {
            return Err("has no near plane in front of the eye");
        }
        if a > 0.0 {
            return Err("has its far plane behind the eye");
        }
        let far = if a < 0.0 { -b / a } else { f32::INFINITY };
        let shift = [z.x * forward, up * z.y * forward];
        let projection = Projection { scale: [x.x.abs(), y.y.abs()], shift, depth: [a, b] };
        Ok(Self { projection, turn, is_reversed, near, far })
    }
}

/// How far the numbers of a rotation may be from those of an exact one.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// Whether a matrix is a rotation, with or without a mirroring.
pub fn is_rotation(matrix: &DMat3) -> bool {
    let off = matrix.transpose() * *matrix - DMat3::IDENTITY;
    off.to_cols_array().iter().all(|v| v.abs() <= ROTATION_TOLERANCE)
}

/// Points closer to a mirror than this, in metres, do not appear in it, so that the mirror does not reflect
/// itself.
const MIRROR_CLEARANCE_M: f64 = 2e-3;

impl Camera {
    /// A camera at `eye` that looks at `look_at`. If it looks straight up or down, the image's up direction is
    /// world +z or −z.
    pub fn new(eye: Vec3, look_at: Vec3, lens: Lens, aspect: f32) -> Self {
        let forward = (look_at - eye).normalize_or(Vec3::Z);
        let up = if forward.y.abs() > 0.999_999 { Vec3::Z * -forward.y.signum() } else { Vec3::Y };
        Self { world_to_view: look_to_mat4(eye, forward, up), lens, aspect, near_plane: None, projection: None }
    }

    /// Whether the camera can be used: the lens is within its ranges, and the matrices are finite and
    /// invertible.
    pub fn is_sound(&self) -> bool {
        let Lens { fov_y_radians: fov, near_m: near, far_m: far } = self.lens;
        let in_range = fov > 0.0 && fov < std::f32::consts::PI && near > 0.0 && far > near && far.is_finite();
        in_range
            && self.aspect > 0.0
            && self.aspect.is_finite()
            && self.world_to_view.inverse().is_finite()
            && self.view_to_clip_reversed().is_finite()
            && self.view_to_clip_reversed().as_dmat4().inverse().is_finite()
    }

    /// View to clip space with standard depth (near 0, far 1), which the published methods use.
    pub fn view_to_clip(&self) -> Mat4 {
        if let Some(projection) = self.projection {
            return projection.matrix(false);
        }
        perspective(self.lens.fov_y_radians, self.aspect, self.lens.near_m, self.lens.far_m)
    }

    /// View to clip space with reversed depth (near 1, far 0), with which the G-buffer is rendered.
    ///
    /// If there is a [`Camera::near_plane`], the third row of the matrix makes that plane the near plane
    /// (Lengyel 2005, for reversed depth): depth is 1 − s (n · x + w) / z, with s chosen so that depth stays
    /// above 0 at the frustum's corners.
    pub fn view_to_clip_reversed(&self) -> Mat4 {
        if let Some(projection) = self.projection {
            return projection.matrix(true);
        }
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

    /// Transforms a world-space plane (unit normal and offset) to this camera's view space.
    pub fn plane_in_view(&self, plane: Vec4) -> Vec4 {
        (self.world_to_view.as_dmat4().inverse().transpose() * plane.as_dvec4()).as_vec4()
    }

    /// This camera's view of the world reflected at a world-space plane (unit normal towards the camera, and
    /// offset): each reflected point appears where a mirror in that plane shows it. Everything behind the
    /// mirror is cut away. The matrix has the determinant −1, so it reverses the winding of triangles.
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
            assert!(distance > 0.0, "in front of the mirror");
            let image = point - 2.0 * distance * normal;
            let [seen, shown] = [usual.project_point3(image), mirrored.project_point3(point)];
            assert!(seen.truncate().distance(shown.truncate()) < 1e-4, "{seen} is not {shown}");
            assert!(shown.z > 0.0 && shown.z < 1.0, "{shown}");
            // On the plane, depth is 1 except for the clearance; behind it, depth is greater and the point is
            // cut away.
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
            // A ray away from the eye through a point just behind the mirror. (Far away its depth tends to a
            // number above 0 that depends on the ray.)
            let ray = matrix.inverse().project_point3(Vec3::new(x, y, 0.999)).normalize();
            let depths: Vec<f32> =
                (1..40).map(|k| matrix.project_point3(ray * (1.5 + k as f32 * k as f32)).z).collect();
            assert!(depths.windows(2).all(|d| d[0] > d[1]), "{x}, {y}: {depths:?}");
            assert!(depths.iter().all(|d| *d > 0.0), "{x}, {y}: {depths:?}");
        }
    }
}
