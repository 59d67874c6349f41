//! Captures: cubes of six images of the scene, each made at a fixed place by the scene passes. They show what the
//! screen does not (docs/definitions.md, "Captures"). Here is only where they stand; [`super::placement`] finds
//! places, and a scene file may name them (`[[capture]]`).

use crate::math::constants;
use glam::Vec3;

/// The most captures that a scene can have.
pub const MAX_CAPTURES: usize = constants::CAPTURE_SLOTS as usize;

/// The greatest side of a face, in texels.
pub const MAX_RESOLUTION: u32 = 4096;

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
    /// The near plane where nothing else is said, in metres. The placement leaves more room than this to every
    /// surface.
    pub const NEAR_M: f32 = 0.05;
    /// The resolution where nothing else is said, in texels.
    pub const RESOLUTION: u32 = 512;

    /// A capture at a place, with the default near plane and resolution.
    pub fn at(position: Vec3) -> Self {
        Self { position, near_m: Self::NEAR_M, resolution: Self::RESOLUTION }
    }

    /// Scales place and near plane about the origin.
    pub(super) fn scale(&mut self, factor: f32) {
        self.position *= factor;
        self.near_m *= factor;
    }

    /// The table of a scene file that gives this capture.
    pub fn to_toml(&self) -> String {
        let Self { position: Vec3 { x, y, z }, near_m, resolution } = self;
        format!("[[capture]]\nplace = [{x:?}, {y:?}, {z:?}]\nresolution = {resolution}\nnear = {near_m:?}\n")
    }
}
