//! Lenses, views and cameras.

use super::MaterialChange;
use glam::camera::lh::{proj::directx::perspective, view::look_to_mat4};
use glam::{Mat4, Vec3};

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
}

impl Camera {
    /// A camera at `eye` towards `look_at`. Straight up or down, the image's up is world +z or −z.
    pub fn new(eye: Vec3, look_at: Vec3, lens: Lens, aspect: f32) -> Self {
        let forward = (look_at - eye).normalize_or(Vec3::Z);
        let up = if forward.y.abs() > 0.999_999 { Vec3::Z * -forward.y.signum() } else { Vec3::Y };
        Self { world_to_view: look_to_mat4(eye, forward, up), lens, aspect }
    }

    /// View to clip with standard depth (near 0, far 1): what the published methods use.
    pub fn view_to_clip(&self) -> Mat4 {
        perspective(self.lens.fov_y_radians, self.aspect, self.lens.near_m, self.lens.far_m)
    }

    /// View to clip with reversed depth (near 1, far 0): what the G-buffer is rendered with.
    pub fn view_to_clip_reversed(&self) -> Mat4 {
        perspective(self.lens.fov_y_radians, self.aspect, self.lens.far_m, self.lens.near_m)
    }

    /// Camera position in the world.
    pub fn eye(&self) -> Vec3 {
        self.world_to_view.inverse().w_axis.truncate()
    }
}
