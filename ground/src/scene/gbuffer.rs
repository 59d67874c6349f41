//! A G-buffer on the host; the references and the G-buffer files use it.

use super::{Camera, Surface};
use crate::math::constants;
use glam::{DMat4, DVec3, DVec4, Vec3};

/// The images of a G-buffer (docs/definitions.md) as arrays: rows from the top, pixel (i, j) at `j · width + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct GBufferData {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The camera that the G-buffer was rendered with.
    pub camera: Camera,
    /// Reversed depth (near 1, far 0; 0 is sky).
    pub depth: Vec<f32>,
    /// View-space normal; zero where there is no surface. The length is not exactly 1, since 16-bit floats stored it.
    pub normal: Vec<Vec3>,
    /// Reflectivity, 0…1.
    pub reflectivity: Vec<f32>,
    /// Roughness ϱ.
    pub roughness: Vec<f32>,
    /// Lit colour, linear; on a surface that shows the environment, the environment as the camera sees it there.
    pub color: Vec<Vec3>,
    /// What the surface shows. [`Surface::Sky`] stands for the environment of [`sky`](super::sky), and for no other.
    pub surface: Vec<Surface>,
}

impl GBufferData {
    /// A pixel that is not sky reflects if its reflectivity is above this (docs/definitions.md, "Surfaces").
    pub const REFLECTS_ABOVE: f32 = constants::REFLECTS_ABOVE as f32;

    /// The array index of a pixel.
    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Whether a pixel reflects.
    pub fn reflects(&self, index: usize) -> bool {
        self.depth[index] > 0.0 && self.reflectivity[index] > Self::REFLECTS_ABOVE
    }

    /// Which pixels reflect, rows from the top.
    pub fn reflecting(&self) -> Vec<bool> {
        (0..self.depth.len()).map(|i| self.reflects(i)).collect()
    }

    /// Clamps colours to the greatest 16-bit float, and returns the number of pixels that were brighter.
    pub fn clamp_colours(&mut self) -> usize {
        let greatest = Vec3::splat(half::f16::MAX.to_f32());
        let mut clamped = 0;
        for colour in self.color.iter_mut().filter(|colour| colour.cmpgt(greatest).any()) {
            *colour = colour.min(greatest);
            clamped += 1;
        }
        clamped
    }

    /// View to clip space with reversed depth: the f32 matrix that the G-buffer was rendered with, converted to f64.
    pub fn view_to_clip(&self) -> DMat4 {
        self.camera.view_to_clip_reversed().as_dmat4()
    }

    /// The view-space position of a point of the image with continuous pixel coordinates (pixel (i, j) has its
    /// centre at i + ½, j + ½) and reversed depth. `clip_to_view` is the inverse of [`Self::view_to_clip`].
    pub fn unproject(&self, x: f64, y: f64, depth: f64, clip_to_view: &DMat4) -> DVec3 {
        let ndc = DVec3::new(2.0 * x / f64::from(self.width) - 1.0, 1.0 - 2.0 * y / f64::from(self.height), depth);
        clip_to_view.project_point3(ndc)
    }

    /// The pixel coordinates and reversed depth of a view-space point; `None` if it is behind the eye (w ≤ 0).
    pub fn project(&self, view: DVec3, view_to_clip: &DMat4) -> Option<DVec3> {
        let clip: DVec4 = *view_to_clip * view.extend(1.0);
        (clip.w > 0.0).then(|| {
            DVec3::new(
                (0.5 + 0.5 * clip.x / clip.w) * f64::from(self.width),
                (0.5 - 0.5 * clip.y / clip.w) * f64::from(self.height),
                clip.z / clip.w,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;

    /// A G-buffer that has colours alone.
    fn with_colors([width, height]: [u32; 2], color: Vec<Vec3>) -> GBufferData {
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), width as f32 / height as f32);
        let (depth, normal, reflectivity, roughness, surface) = Default::default();
        GBufferData { width, height, camera, depth, normal, reflectivity, roughness, color, surface }
    }

    #[test]
    fn colours_beyond_half_floats_are_clamped_and_counted() {
        let color = vec![Vec3::splat(65504.0), Vec3::new(70_000.0, 1.0, 0.5), Vec3::ZERO, Vec3::splat(1e30)];
        let mut data = with_colors([2, 2], color);
        assert_eq!(data.clamp_colours(), 2);
        let most = Vec3::splat(65504.0);
        assert_eq!(data.color, [most, Vec3::new(65504.0, 1.0, 0.5), Vec3::ZERO, most]);
        assert_eq!(data.clamp_colours(), 0);
    }

    #[test]
    fn project_and_unproject_are_inverse() {
        let empty = with_colors([30, 20], Vec::new());
        let view_to_clip = empty.view_to_clip();
        let point = DVec3::new(-0.7, 0.4, 3.0);
        let seen = empty.project(point, &view_to_clip).expect("in front");
        assert!(seen.x < 15.0 && seen.y < 10.0, "−x must be on the left and +y at the top: {seen}");
        assert!((empty.unproject(seen.x, seen.y, seen.z, &view_to_clip.inverse()) - point).length() < 1e-9);
        assert_eq!(empty.project(DVec3::new(0.0, 0.0, -1.0), &view_to_clip), None);
    }
}
