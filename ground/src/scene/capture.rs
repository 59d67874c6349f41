//! Captures: cubes of six images of the scene, each made at a fixed place by the scene passes. Captures show what the
//! screen does not (docs/definitions.md, "Captures"). This file has only the places of captures, which the laboratory's
//! placement finds, or a scene file names (`[[capture]]`).

use super::{Camera, Lens, sky};
use crate::math::constants;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// The most captures that a scene can have.
pub const MAX_CAPTURES: usize = constants::CAPTURE_SLOTS as usize;

/// The greatest side of a face, in texels.
pub const MAX_RESOLUTION: u32 = 4096;

/// The bounds of a scene are grown on every side by this share of their diagonal. A ray that is lost outside of them
/// ends in the sky, but not one that a capture of low resolution loses a little behind an outer wall.
pub const BOUNDS_MARGIN: f32 = 0.02;

/// How far the faces of a cube of images see, in metres. Reversed depth in floats is precise enough for this range.
pub const FAR_M: f32 = 10_000.0;

/// The camera of one face of a cube of images around a position. The faces are in Vulkan's order +x −x +y −y +z −z, and
/// each sees a quarter turn, so that the six leave no gap. The camera's image is the face as it lies in memory: for the
/// faces up and down, [`Camera::new`] turns the image as Vulkan's layout needs.
pub fn face_camera(position: Vec3, face: usize, near_m: f32) -> Camera {
    let lens = Lens::perspective(FRAC_PI_2, near_m, FAR_M);
    Camera::new(position, position + sky::face_direction(face, 0.5, 0.5), lens, 1.0)
}

/// A place where a cube of images of the scene is captured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capture {
    /// World position of the cube's centre, in metres.
    pub position: Vec3,
    /// Distance of each face's near plane from the centre in metres, > 0: what is nearer is not in the images.
    pub near_m: f32,
    /// Width and height of each of the six faces in texels, 1…[`MAX_RESOLUTION`]; the same for all captures of a
    /// scene, because their faces are layers of one image.
    pub resolution: u32,
}

impl Capture {
    /// The default near plane, in metres. The placement leaves more room than this to every surface.
    pub const NEAR_M: f32 = 0.05;
    /// The default resolution, in texels.
    pub const RESOLUTION: u32 = 512;

    /// A capture at a place, with the default near plane and resolution.
    pub fn placed_at(position: Vec3) -> Self {
        Self { position, near_m: Self::NEAR_M, resolution: Self::RESOLUTION }
    }

    /// Scales place and near plane about the origin.
    pub(super) fn scale(&mut self, factor: f32) {
        self.position *= factor;
        self.near_m *= factor;
    }

    /// The table of a scene file that gives this capture.
    pub fn to_toml(self) -> String {
        let Self { position: Vec3 { x, y, z }, near_m, resolution } = self;
        format!("[[capture]]\nplace = [{x:?}, {y:?}, {z:?}]\nresolution = {resolution}\nnear = {near_m:?}\n")
    }
}

/// How many captures a scene is to have, and where they come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WantedCaptures {
    /// All captures of the scene file; if there are none, as many as the laboratory's placement finds worth their cost.
    Auto,
    /// The number of captures: first those of the scene file, in its order, then places that show most of what the
    /// others do not. There are fewer if no further place shows anything new, and never more than [`MAX_CAPTURES`].
    Count(usize),
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4Swizzles;

    #[test]
    fn a_face_camera_sees_the_directions_of_its_texels() {
        let position = Vec3::new(3.0, -1.0, 2.0);
        for face in 0..6 {
            let camera = face_camera(position, face, 0.1);
            for (u, v) in [(0.5, 0.5), (0.1, 0.5), (0.5, 0.1), (0.9, 0.8)] {
                let world = position + 5.0 * sky::face_direction(face, u, v);
                let clip = camera.view_to_clip() * camera.world_to_view * world.extend(1.0);
                let ndc = clip.xy() / clip.w;
                let seen = glam::Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
                assert!(clip.w > 0.0 && seen.abs_diff_eq(glam::Vec2::new(u, v), 1e-5), "{face}: {seen}");
            }
        }
    }
}
