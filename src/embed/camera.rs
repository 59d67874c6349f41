//! A camera from the matrices of another renderer.

use crate::error::{Error, Result};
use glam::{Mat3, Mat4, Vec4};
use ssct_ground::conventions::ClipY;
use ssct_ground::scene::Camera;
use ssct_ground::scene::camera::is_rotation;
use ssct_ground::scene::projection::ReadProjection;

/// The camera of a frame, in the caller's conventions. The matrices alone tell handedness, whether y is up, whether
/// depth is reversed, whether the far plane is finite, and the shift of a jittered projection.
///
/// A matrix is 16 numbers, column by column, and is multiplied by column vectors from the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraInput {
    /// World to view space: a rotation and a translation.
    pub world_to_view: [f32; 16],
    /// View to clip space: a perspective or an orthographic projection, with the jitter that the images were drawn
    /// with. An orthographic projection has its near plane at the eye or in front of the eye.
    pub view_to_clip: [f32; 16],
    /// The place of the image's top in clip space.
    pub clip_y: ClipY,
}

/// The caller's camera in our conventions.
pub(super) struct ConvertedCamera {
    pub camera: Camera,
    /// Factor and offset that turn the caller's depth into reversed depth: factor · depth + offset.
    pub to_reversed: [f32; 2],
    /// The matrix from the caller's view space to ours.
    pub their_view_to_ours: Mat3,
}

/// Ratio of far to near plane that stands for an infinite projection, since some published methods need a far plane.
const INFINITE_FAR: f32 = 1e7;

impl CameraInput {
    /// Reads the conventions off the matrices, and converts the camera. An error names the matrix that is no camera's.
    pub(super) fn converted(&self) -> Result<ConvertedCamera> {
        let wrong = |which: &str, why: &str| Error::Usage(format!("the camera's {which} {why}"));
        if !self.world_to_view.iter().all(|v| v.is_finite()) {
            return Err(wrong("world_to_view", "has numbers that are not finite"));
        }
        let clip = Mat4::from_cols_array(&self.view_to_clip);
        let read = ReadProjection::new(&clip, self.clip_y == ClipY::Up).map_err(|why| wrong("view_to_clip", why))?;
        let ReadProjection { projection, axis_signs, is_reversed, near: near_m, .. } = read;
        let their_view_to_ours = Mat3::from_diagonal(axis_signs);
        let world = Mat4::from_cols_array(&self.world_to_view);
        if !is_rotation(&Mat3::from_mat4(world).as_dmat3()) || world.row(3) != Vec4::W {
            return Err(wrong("world_to_view", "is no rotation and translation: scale belongs to the scene"));
        }
        let mut camera = Camera::of_projection(Mat4::from_mat3(their_view_to_ours) * world, projection);
        if !projection.kind.is_orthographic() {
            camera.lens.far_m = camera.lens.far_m.min(INFINITE_FAR * near_m);
        }
        Ok(ConvertedCamera {
            camera,
            to_reversed: if is_reversed { [1.0, 0.0] } else { [-1.0, 1.0] },
            their_view_to_ours,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, Vec4Swizzles};

    /// Conventions of engines: name, projection, place of the image's top, and sign of view-space z before the eye.
    fn conventions() -> Vec<(&'static str, Mat4, ClipY, f32)> {
        let perspectives = perspectives().into_iter().map(|(name, clip, y)| (name, clip, y, clip.z_axis.w));
        perspectives.chain(parallels()).collect()
    }

    /// Orthographic projections with the near plane at 0.25 m or at the eye. `matrix` takes the factor of y, the shift
    /// of the image, and numbers that make the depth a + b z, where z is `forward` times view-space z.
    fn parallels() -> Vec<(&'static str, Mat4, ClipY, f32)> {
        let (fx, fy, near, far) = (0.2_f32, 0.3_f32, 0.25_f32, 80.0_f32);
        let matrix = |y: f32, [u, v]: [f32; 2], (a, b): (f32, f32), forward: f32| {
            Mat4::from_cols_array(&[fx, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, 0.0, forward * b, 0.0, u, v, a, 1.0])
        };
        let reversed = |near: f32| (far / (far - near), -1.0 / (far - near));
        let standard = |near: f32| (-near / (far - near), 1.0 / (far - near));
        let (centred, shifted) = ([0.0; 2], [0.2, -0.3]);
        vec![
            ("parallel, left-handed, reversed", matrix(fy, centred, reversed(near), 1.0), ClipY::Up, 1.0),
            ("parallel, right-handed, reversed", matrix(fy, centred, reversed(near), -1.0), ClipY::Up, -1.0),
            ("parallel, left-handed, standard, y down", matrix(-fy, shifted, standard(near), 1.0), ClipY::Down, 1.0),
            ("parallel, right-handed, standard, off axis", matrix(fy, shifted, standard(near), -1.0), ClipY::Up, -1.0),
            ("parallel, near plane at the eye", matrix(fy, [0.0, 0.1], standard(0.0), -1.0), ClipY::Up, -1.0),
            ("parallel, near plane at the eye, reversed", matrix(fy, [0.0, 0.1], reversed(0.0), 1.0), ClipY::Down, 1.0),
        ]
    }

    /// Perspective projections with the near plane at 0.25 m. `matrix` takes the factor of y, the shift of the image,
    /// and numbers that make the depth a + b / z, where z is `forward` times view-space z.
    fn perspectives() -> Vec<(&'static str, Mat4, ClipY)> {
        let (fx, fy, near, far) = (1.2_f32, 1.9_f32, 0.25_f32, 80.0_f32);
        let matrix = |y: f32, [u, v]: [f32; 2], (a, b): (f32, f32), forward: f32| {
            Mat4::from_cols_array(&[fx, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, u, v, forward * a, forward, 0.0, 0.0, b, 0.0])
        };
        let standard = (far / (far - near), -near * far / (far - near));
        let reversed = (-near / (far - near), near * far / (far - near));
        vec![
            ("left-handed, y up, reversed", matrix(fy, [0.0; 2], reversed, 1.0), ClipY::Up),
            ("left-handed, y up, standard", matrix(fy, [0.0; 2], standard, 1.0), ClipY::Up),
            ("right-handed, flipped y, standard", matrix(-fy, [0.0; 2], standard, -1.0), ClipY::Down),
            ("right-handed, y up, infinite reversed", matrix(fy, [0.0; 2], (0.0, near), -1.0), ClipY::Up),
            ("y down, z forward, infinite standard", matrix(fy, [0.0; 2], (1.0, -near), 1.0), ClipY::Down),
            ("right-handed, jittered", matrix(fy, [0.01, -0.02], reversed, -1.0), ClipY::Up),
        ]
    }

    #[test]
    fn every_convention_shows_a_point_where_the_caller_s_matrices_show_it() {
        for (name, clip, clip_y, forward) in conventions() {
            let world = Mat4::from_rotation_y(0.4) * Mat4::from_translation(Vec3::new(1.0, -2.0, 0.5));
            let input =
                CameraInput { world_to_view: world.to_cols_array(), view_to_clip: clip.to_cols_array(), clip_y };
            let ConvertedCamera { camera, to_reversed, .. } = input.converted().expect(name);
            assert_eq!(camera.kind().is_orthographic(), name.starts_with("parallel"), "{name}");
            let (near_m, far_m) = (camera.lens.near_m, camera.lens.far_m);
            assert!((near_m - 0.25).abs() < 1e-5 || name.contains("at the eye") && near_m == 0.0, "{name}: {near_m}");
            assert!((80.0 / far_m - 1.0).abs() < 1e-3 || name.contains("infinite"), "{name}: {far_m}");
            assert!(camera.view_to_clip_reversed().is_finite() && camera.view_to_clip().is_finite(), "{name}");
            for point in [Vec3::new(0.3, 0.2, 2.0), Vec3::new(-1.0, 0.7, 20.0), Vec3::new(0.0, -0.4, 0.6)] {
                let in_view = point * Vec3::new(1.0, 1.0, forward);
                let position = world.inverse().transform_point3(in_view).extend(1.0);
                let theirs = clip * world * position;
                let theirs = theirs.xyz() / theirs.w;
                let ours = camera.view_to_clip_reversed() * camera.world_to_view * position;
                let ours = ours.xyz() / ours.w;
                let up = if clip_y == ClipY::Up { 1.0 } else { -1.0 };
                let expected = Vec3::new(theirs.x, up * theirs.y, to_reversed[0] * theirs.z + to_reversed[1]);
                assert!(ours.distance(expected) < 2e-5, "{name}: {ours} is not {expected}");
                assert!((camera.world_to_view * position).z > 0.0, "{name}");
            }
        }
    }

    #[test]
    fn what_is_no_camera_is_refused_with_a_sentence() {
        let (_, clip, clip_y, _) = conventions().swap_remove(0);
        let good =
            CameraInput { world_to_view: Mat4::IDENTITY.to_cols_array(), view_to_clip: clip.to_cols_array(), clip_y };
        assert!(good.converted().is_ok());
        // Each change spoils one number of a camera that is taken; the message must have the word.
        let refused = |change: fn(&mut CameraInput), word: &str| {
            let mut input = good;
            change(&mut input);
            let said = input.converted().err().expect(word).to_string();
            assert!(said.contains(word), "{said}");
        };
        refused(|c| c.view_to_clip[11] = 0.0, "perspective");
        refused(|c| c.view_to_clip[4] = 0.3, "skew");
        refused(|c| c.view_to_clip[14] = f32::NAN, "finite");
        refused(|c| c.view_to_clip[10] = 0.5, "far plane");
        let parallel = |change: fn(&mut [f32; 16]), word: &str| {
            let mut view_to_clip = parallels()[0].1.to_cols_array();
            change(&mut view_to_clip);
            let said = CameraInput { view_to_clip, ..good }.converted().err().expect(word).to_string();
            assert!(said.contains(word), "{said}");
        };
        parallel(|m| m[14] = 0.5, "near plane behind the eye");
        parallel(|m| m[8] = 0.1, "skew");
        parallel(|m| m[10] = 0.0, "same depth");
        parallel(|m| m[15] = 2.0, "last row");
        refused(|c| c.world_to_view[0] = 2.0, "scale");
    }
}
