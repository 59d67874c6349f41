//! Lenses, views and cameras.

use super::MaterialChange;
use super::projection::{FieldOfView, Projection, ProjectionKind};
use crate::error::Error;
use glam::camera::lh::{proj::directx::perspective, view::look_to_mat4};
use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec3, Vec4};

/// The parameters of a projection, without the aspect ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// How much the lens sees, by an angle in a perspective and by a height in an orthographic projection.
    pub opening: FieldOfView,
    /// Near plane in metres, > 0; the near plane of an orthographic projection may be at the eye.
    pub near_m: f32,
    /// Far plane in metres, > near.
    pub far_m: f32,
}

impl Default for Lens {
    /// The lens of the author's program: 74° vertical field of view, near plane 0.1 m, far plane 1000 m.
    fn default() -> Self {
        Self::perspective(74_f32.to_radians(), 0.1, 1000.0)
    }
}

impl Lens {
    /// A perspective with a vertical field of view.
    pub const fn perspective(fov_y_radians: f32, near_m: f32, far_m: f32) -> Self {
        Self { opening: FieldOfView::Angle(fov_y_radians), near_m, far_m }
    }

    /// An orthographic projection of an image that is `height_m` metres high.
    pub const fn orthographic(height_m: f32, near_m: f32, far_m: f32) -> Self {
        Self { opening: FieldOfView::Height(height_m), near_m, far_m }
    }

    /// The kind of the lens's projection.
    pub fn kind(&self) -> ProjectionKind {
        match self.opening {
            FieldOfView::Angle(_) => ProjectionKind::Perspective,
            FieldOfView::Height(_) => ProjectionKind::Orthographic,
        }
    }

    /// The vertical field of view; `None` for an orthographic projection, which has none.
    pub fn fov_y_radians(&self) -> Option<f32> {
        match self.opening {
            FieldOfView::Angle(fov) => Some(fov),
            FieldOfView::Height(_) => None,
        }
    }

    /// Returns the height in metres of what the image shows at a view-space z.
    pub fn height_at_m(&self, z: f32) -> f32 {
        match self.opening {
            FieldOfView::Angle(fov) => 2.0 * z * (0.5 * fov).tan(),
            FieldOfView::Height(height) => height,
        }
    }

    /// The lens of a scene whose lengths are scaled.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        let opening = match self.opening {
            FieldOfView::Angle(fov) => FieldOfView::Angle(fov),
            FieldOfView::Height(height) => FieldOfView::Height(height * factor),
        };
        Self { opening, near_m: self.near_m * factor, far_m: self.far_m * factor }
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
    /// A plane in view space that replaces the near plane of a perspective with reversed depth. A point x with
    /// n · x + w < 0 is not drawn. The camera must be behind the plane.
    pub near_plane: Option<Vec4>,
    /// A projection that is given by numbers, in place of lens and aspect.
    pub projection: Option<Projection>,
}

/// Greatest deviation of the numbers of a rotation from those of an exact rotation.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// Whether a matrix is a rotation, with or without a mirroring.
pub fn is_rotation(matrix: &DMat3) -> bool {
    let deviation = matrix.transpose() * *matrix - DMat3::IDENTITY;
    deviation.to_cols_array().iter().all(|v| v.abs() <= ROTATION_TOLERANCE)
}

/// Points closer to a mirror than this, in metres, do not appear in it, so that the mirror does not reflect itself.
const MIRROR_CLEARANCE_M: f64 = 2e-3;

impl Camera {
    /// A camera at `eye` that looks at `look_at`. If it looks straight up or down, the image's up is world +z or −z.
    pub fn new(eye: Vec3, look_at: Vec3, lens: Lens, aspect: f32) -> Self {
        let forward = (look_at - eye).normalize_or(Vec3::Z);
        let up = if forward.y.abs() > 0.999_999 { Vec3::Z * -forward.y.signum() } else { Vec3::Y };
        Self { world_to_view: look_to_mat4(eye, forward, up), lens, aspect, near_plane: None, projection: None }
    }

    /// Whether the camera can be used: the lens is within its ranges, and the matrices are finite and invertible.
    pub fn is_sound(&self) -> bool {
        let Lens { opening, near_m: near, far_m: far } = self.lens;
        let sees_something = match opening {
            FieldOfView::Angle(fov) => fov > 0.0 && fov < std::f32::consts::PI && near > 0.0,
            FieldOfView::Height(height) => height > 0.0 && height.is_finite() && near >= 0.0,
        };
        sees_something
            && far > near
            && far.is_finite()
            && self.aspect > 0.0
            && self.aspect.is_finite()
            && self.world_to_view.inverse().is_finite()
            && self.view_to_clip_reversed().is_finite()
            && self.view_to_clip_reversed().as_dmat4().inverse().is_finite()
    }

    /// Makes a camera from the numbers of a projection matrix, from which its lens and aspect ratio are computed.
    pub fn of_projection(world_to_view: Mat4, projection: Projection) -> Self {
        let [near, far] = projection.planes();
        let lens = Lens { opening: projection.opening(), near_m: near, far_m: far };
        let aspect = projection.scale[1] / projection.scale[0];
        Self { world_to_view, lens, aspect, near_plane: None, projection: Some(projection) }
    }

    /// Returns the camera with its image shifted by some pixels of an image of size `extent`, to the right and down.
    /// Renderers that average frames shift each by part of a pixel. A shift of 0 changes nothing, to the bit.
    #[must_use]
    pub fn jittered(self, [right, down]: [f32; 2], extent: [u32; 2]) -> Self {
        if [right, down] == [0.0; 2] {
            return self;
        }
        let numbers = self.projection_numbers();
        let [x, y] = numbers.shift;
        let shift = [x + 2.0 * right / extent[0] as f32, y - 2.0 * down / extent[1] as f32];
        Self { projection: Some(Projection { shift, ..numbers }), ..self }
    }

    /// The numbers of the camera's projection, without the [`Camera::near_plane`].
    pub fn projection_numbers(&self) -> Projection {
        match (self.projection, self.lens.opening) {
            (Some(projection), _) => projection,
            (None, FieldOfView::Height(height)) => self.orthographic(height),
            (None, FieldOfView::Angle(fov)) => {
                // With far and near exchanged, depth is reversed.
                let reversed = perspective(fov, self.aspect, self.lens.far_m, self.lens.near_m);
                let (scale, depth) = ([reversed.x_axis.x, reversed.y_axis.y], [reversed.z_axis.z, reversed.w_axis.z]);
                Projection { kind: ProjectionKind::Perspective, scale, shift: [0.0; 2], depth }
            }
        }
    }

    /// Refuses a camera for passes that were made for the other kind of projection.
    ///
    /// # Errors
    /// [`Error::Usage`] with both kinds.
    pub fn check_kind(&self, made_for: ProjectionKind) -> crate::error::Result<()> {
        if self.kind() == made_for {
            return Ok(());
        }
        let describe = |kind| if kind == ProjectionKind::Perspective { "a perspective" } else { "orthographic" };
        let (is, made_for) = (describe(self.kind()), describe(made_for));
        Err(Error::Usage(format!("the camera is {is}, and the passes were made for one that is {made_for}")))
    }

    /// The kind of the camera's projection.
    pub fn kind(&self) -> ProjectionKind {
        self.projection.map_or(self.lens.kind(), |projection| projection.kind)
    }

    /// The reach at a view-space z, in metres; tolerances of depth are shares of the reach. The reach is z in a
    /// perspective, where a pixel's width grows with z, and the picture's height in an orthographic projection.
    pub fn reach_m(&self, z: f64) -> f64 {
        match self.kind() {
            ProjectionKind::Perspective => z,
            ProjectionKind::Orthographic => 2.0 / f64::from(self.view_to_clip_reversed().y_axis.y),
        }
    }

    /// The unit direction in view space in which the camera sees a point.
    pub fn sight(&self, point: DVec3) -> DVec3 {
        match self.kind() {
            ProjectionKind::Perspective => point.normalize(),
            ProjectionKind::Orthographic => DVec3::Z,
        }
    }

    /// View to clip space with standard depth (near 0, far 1), which the published methods use.
    pub fn view_to_clip(&self) -> Mat4 {
        match (self.projection, self.lens.opening) {
            (Some(projection), _) => projection.matrix(false),
            (None, FieldOfView::Angle(fov)) => perspective(fov, self.aspect, self.lens.near_m, self.lens.far_m),
            (None, FieldOfView::Height(height)) => self.orthographic(height).matrix(false),
        }
    }

    /// The projection of an image that is `height_m` metres high.
    fn orthographic(&self, height_m: f32) -> Projection {
        let kind = ProjectionKind::Orthographic;
        let depth = kind.reversed_depth(self.lens.near_m.into(), self.lens.far_m.into()).map(|v| v as f32);
        let up = 2.0 / height_m;
        Projection { kind, scale: [up / self.aspect, up], shift: [0.0; 2], depth }
    }

    /// View to clip space with reversed depth (near 1, far 0), with which the G-buffer is rendered.
    ///
    /// If there is a [`Camera::near_plane`], the third row of the matrix makes that plane the near plane (Lengyel 2005,
    /// for reversed depth). Depth is 1 − s (n · x + w) / z, where s keeps depth above 0 at the frustum's corners.
    pub fn view_to_clip_reversed(&self) -> Mat4 {
        // Where the image ends to the left and right, and below and above, at a distance of 1 m.
        let (usual, [horizontal, vertical]) = match (self.projection, self.lens.opening) {
            (Some(projection), _) => (projection.matrix(true), projection.ends_at_one()),
            (None, FieldOfView::Height(height)) => return self.orthographic(height).matrix(true),
            (None, FieldOfView::Angle(fov)) => {
                let up = f64::from(0.5 * fov).tan();
                let right = up * f64::from(self.aspect);
                (perspective(fov, self.aspect, self.lens.far_m, self.lens.near_m), [[-right, right], [-up, up]])
            }
        };
        let is_perspective = self.kind() == ProjectionKind::Perspective;
        let Some(plane) = self.near_plane.filter(|_| is_perspective).map(|p| p.as_dvec4()) else { return usual };
        let corners = horizontal.into_iter().flat_map(|x| vertical.map(|y| DVec3::new(x, y, 1.0)));
        let steepest = corners.map(|corner| plane.truncate().dot(corner)).fold(0.0, f64::max);
        let scale = if steepest > 0.0 { 0.999 / steepest } else { 1.0 };
        let depth = (DVec4::Z - scale * plane).as_vec4();
        let mut rows = usual.transpose();
        rows.z_axis = depth;
        rows.transpose()
    }

    /// Transforms a world-space plane (unit normal and offset) to this camera's view space, by the inverse transpose.
    pub fn plane_in_view(&self, plane: Vec4) -> Vec4 {
        (self.world_to_view.as_dmat4().inverse().transpose() * plane.as_dvec4()).as_vec4()
    }

    /// This camera's view of the world reflected at a world-space plane (unit normal towards the camera, and
    /// offset): each reflected point appears where a mirror in that plane shows it. Everything behind the
    /// mirror is cut away. The matrix has the determinant −1, so it reverses the winding of triangles.
    pub fn mirrored(&self, plane: Vec4) -> Self {
        let (normal, offset) = (plane.truncate().as_dvec3(), f64::from(plane.w));
        // The reflection of a point x at the plane is x − 2 (n · x + w) n.
        let mirror = DMat4::from_cols(
            (DVec3::X - 2.0 * normal.x * normal).extend(0.0),
            (DVec3::Y - 2.0 * normal.y * normal).extend(0.0),
            (DVec3::Z - 2.0 * normal.z * normal).extend(0.0),
            (-2.0 * offset * normal).extend(1.0),
        );
        let mut near_plane = -self.plane_in_view(plane).as_dvec4(); // the reflection turns the normal round
        near_plane.w -= MIRROR_CLEARANCE_M;
        Self {
            world_to_view: (self.world_to_view.as_dmat4() * mirror).as_mat4(),
            near_plane: Some(near_plane.as_vec4()),
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
        check_mirror(&camera);
        check_mirror(&camera.jittered([20.0, -7.0], [90, 60]));
        check_mirror(&Camera::of_projection(camera.world_to_view, camera.projection_numbers()));
    }

    /// Checks where points in front of a mirror and behind it appear to a camera that is reflected at the mirror.
    fn check_mirror(camera: &Camera) {
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
            // On the plane, depth is 1 except for the clearance. Behind it, depth is greater and the point is cut away.
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
        // A shift of a quarter of the image adds corners that are steeper to the plane.
        for matrix in [behind, behind.jittered([0.0, -15.0], [90, 60])].map(|camera| camera.view_to_clip_reversed()) {
            check_order(matrix);
        }
    }

    /// Checks that depths fall along rays away from the eye, and stay above 0.
    fn check_order(matrix: Mat4) {
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
