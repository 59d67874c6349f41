//! Projections by their numbers, and how they are read off the matrices of other renderers.

use glam::{Mat4, Vec3};

/// The kind of a camera's projection. The kind decides how depth, rays of sight and footprints are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ProjectionKind {
    /// All rays of sight leave from the eye: w is the view-space z, and depth is linear in 1 / z.
    #[default]
    Perspective,
    /// All rays of sight are parallel: w is 1, and depth is linear in z.
    Orthographic,
}

impl ProjectionKind {
    /// Whether rays of sight are parallel.
    pub fn is_orthographic(self) -> bool {
        self == Self::Orthographic
    }

    /// The numbers a and b of reversed depth between a near and a far plane: depth is a + b / z in a perspective and
    /// a + b · z in an orthographic projection. Only a perspective may have its far plane at infinity.
    pub fn reversed_depth(self, near: f64, far: f64) -> [f64; 2] {
        match self {
            Self::Perspective if far.is_infinite() => [0.0, near],
            Self::Perspective => [-near / (far - near), near * far / (far - near)],
            Self::Orthographic => [far / (far - near), -1.0 / (far - near)],
        }
    }

    /// The depth of a view-space z, by the two numbers of [`Self::reversed_depth`].
    pub fn depth_at(self, [a, b]: [f64; 2], z: f64) -> f64 {
        match self {
            Self::Perspective => a + b / z,
            Self::Orthographic => a + b * z,
        }
    }

    /// The view-space z of a depth, by the two numbers of [`Self::reversed_depth`].
    pub fn z_at(self, [a, b]: [f64; 2], depth: f64) -> f64 {
        match self {
            Self::Perspective => b / (depth - a),
            Self::Orthographic => (depth - a) / b,
        }
    }
}

/// How much a lens sees from the lower to the upper side of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldOfView {
    /// A perspective with a vertical field of view in radians, 0 < fov < π.
    Angle(f32),
    /// An orthographic projection that shows this height in metres, > 0, at any distance.
    Height(f32),
}

/// A projection by its numbers: the elements of the matrix with reversed depth that are neither 0 nor 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// The kind of projection.
    pub kind: ProjectionKind,
    /// M_00 and M_11, both above 0: y is up in clip space.
    pub scale: [f32; 2],
    /// How far the image is shifted against the axis of the view, in units of ndc: M_02 and M_12 of a perspective, M_03 and
    /// M_13 of an orthographic projection.
    pub shift: [f32; 2],
    /// The numbers of [`ProjectionKind::reversed_depth`]: M_22 and M_23 of a perspective; otherwise M_23 and M_22.
    pub depth: [f32; 2],
}

impl Projection {
    /// The matrix with reversed depth, or with standard depth, which is 1 minus reversed depth.
    pub(super) fn matrix(self, reversed: bool) -> Mat4 {
        let Self { kind, scale: [x, y], shift: [u, v], depth: [a, b] } = self;
        let [a, b] = if reversed { [a, b] } else { [1.0 - a, -b] };
        let [third_column, fourth_column] = match kind {
            ProjectionKind::Perspective => [[u, v, a, 1.0], [0.0, 0.0, b, 0.0]],
            ProjectionKind::Orthographic => [[0.0, 0.0, b, 0.0], [u, v, a, 1.0]],
        };
        Mat4::from_cols_array_2d(&[[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], third_column, fourth_column])
    }

    /// The distances at which reversed depth is 1 (near plane) and 0 (far plane, infinity if a perspective has none).
    pub fn planes(&self) -> [f32; 2] {
        let [a, b] = self.depth;
        match self.kind {
            ProjectionKind::Perspective => [b / (1.0 - a), if a < 0.0 { -b / a } else { f32::INFINITY }],
            // A near plane at the eye may be rounded to just behind it.
            ProjectionKind::Orthographic => [((1.0 - a) / b).max(0.0), -a / b],
        }
    }

    /// The x of the left and right end of a perspective's image, and the y of its lower and upper end, where z is 1.
    pub(super) fn ends_at_one(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|axis| [-1.0, 1.0].map(|ndc| (ndc - f64::from(self.shift[axis])) / f64::from(self.scale[axis])))
    }

    /// How much the projection sees.
    pub fn opening(&self) -> FieldOfView {
        match self.kind {
            ProjectionKind::Perspective => FieldOfView::Angle(2.0 * (1.0 / self.scale[1]).atan()),
            ProjectionKind::Orthographic => FieldOfView::Height(2.0 / self.scale[1]),
        }
    }
}

/// A projection matrix of another renderer, read into this crate's conventions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadProjection {
    /// The projection in the conventions of this crate.
    pub projection: Projection,
    /// For each axis, 1 if the renderer's view space and ours have it in the same direction, −1 if in opposite ones.
    pub axis_signs: Vec3,
    /// Whether the matrix gives reversed depth.
    pub is_reversed: bool,
    /// The distance of the near plane, in the unit of length of the matrix.
    pub near: f32,
    /// The distance of the far plane; infinite for a projection without one.
    pub far: f32,
}

impl ReadProjection {
    /// Reads a matrix for column vectors, with depth from 0 to 1; `y_is_up` says whether the image's top is at y = w.
    ///
    /// # Errors
    /// The reason why the matrix cannot be used, as the end of a sentence that begins with the matrix's name.
    pub fn new(clip: &Mat4, y_is_up: bool) -> Result<Self, &'static str> {
        if !clip.is_finite() {
            return Err("has numbers that are not finite");
        }
        let [x, y, z, w] = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis]; // the columns
        let kind = match clip.row(3).abs().to_array() {
            [0.0, 0.0, 1.0, 0.0] => ProjectionKind::Perspective,
            [0.0, 0.0, 0.0, 1.0] if w.w > 0.0 => ProjectionKind::Orthographic,
            _ => {
                return Err(
                    "is neither a perspective projection, whose last row is 0, 0, ±1, 0, nor an orthographic one, \
                            whose last row is 0, 0, 0, 1",
                );
            }
        };
        // The column that makes w has the shift of the image: the third in a perspective, else the fourth.
        let (shifts, unshifted) = if kind.is_orthographic() { (w, z) } else { (z, w) };
        let is_plain = x.y == 0.0 && x.z == 0.0 && y.x == 0.0 && y.z == 0.0 && unshifted.x == 0.0 && unshifted.y == 0.0;
        if !is_plain || x.x == 0.0 || y.y == 0.0 {
            return Err("has a rotation, a skew or a translation, or a view of no width");
        }
        let (forward, is_reversed) = match kind {
            ProjectionKind::Perspective => (z.w, w.z > 0.0),
            ProjectionKind::Orthographic => forward_of_orthographic(z.z, w.z)?,
        };
        let up = if y_is_up { 1.0 } else { -1.0 };
        let axis_signs = Vec3::new(x.x.signum(), (up * y.y).signum(), forward);
        // Depth is a + b / z or a + b z, with z along the view.
        let [a, b] = if kind.is_orthographic() { [w.z, z.z * forward] } else { [z.z * forward, w.z] };
        let depth = if is_reversed { [a, b] } else { [1.0 - a, -b] };
        let w_sign = if kind.is_orthographic() { 1.0 } else { forward };
        let shift = [shifts.x * w_sign, up * shifts.y * w_sign];
        let projection = Projection { kind, scale: [x.x.abs(), y.y.abs()], shift, depth };
        let [near, far] = projection.planes();
        if kind == ProjectionKind::Perspective {
            if !(depth[1] > 0.0 && near > 0.0) {
                return Err("has no near plane in front of the eye");
            }
            if depth[0] > 0.0 {
                return Err("has its far plane behind the eye");
            }
        }
        Ok(Self { projection, axis_signs, is_reversed, near, far })
    }
}

/// Returns the direction along z in which an orthographic matrix looks (1 or −1), and whether its depth is reversed,
/// from the slope of depth and the depth at the eye, z = 0. The eye stands before the near plane, so that depth there
/// is at least 1 if reversed, else at most 0. Nothing else tells a right-handed view with standard depth from a
/// left-handed one with reversed depth.
fn forward_of_orthographic(slope: f32, at_eye: f32) -> Result<(f32, bool), &'static str> {
    if slope == 0.0 {
        return Err("gives every point the same depth");
    }
    if at_eye >= 1.0 {
        Ok((-slope.signum(), true))
    } else if at_eye <= 0.0 {
        Ok((slope.signum(), false))
    } else {
        Err(
            "is orthographic and has its near plane behind the eye, where near and far cannot be told apart: move the eye \
             back to the near plane",
        )
    }
}
