//! G-buffers for the tests of this module.

use crate::scene::{Camera, GBufferData, Lens};
use glam::{DVec3, Vec3};

fn camera(aspect: f32) -> Camera {
    Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), aspect)
}

/// Reversed depth of a view depth in metres with the default lens; 0 (sky) for an infinite one.
pub fn depth_of(z: f64) -> f32 {
    if z.is_infinite() {
        return 0.0;
    }
    camera(1.0).view_to_clip_reversed().as_dmat4().project_point3(DVec3::new(0.0, 0.0, z)).z as f32
}

/// A G-buffer with the default lens from reversed depths and view-space normals; mirrors everywhere,
/// black.
pub fn gbuffer(
    width: u32,
    height: u32,
    depth: impl Fn(u32, u32) -> f32,
    normal: impl Fn(u32, u32) -> Vec3,
) -> GBufferData {
    let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    GBufferData {
        width,
        height,
        camera: camera(width as f32 / height as f32),
        depth: pixels.iter().map(|(x, y)| depth(*x, *y)).collect(),
        normal: pixels.iter().map(|(x, y)| normal(*x, *y)).collect(),
        reflectivity: vec![1.0; pixels.len()],
        roughness: vec![0.0; pixels.len()],
        color: vec![Vec3::ZERO; pixels.len()],
    }
}

/// A wall across the view, `z` metres away.
pub fn flat(width: u32, height: u32, z: f64) -> GBufferData {
    gbuffer(width, height, |_, _| depth_of(z), |_, _| Vec3::NEG_Z)
}

/// A floor 1 m below the eye up to a wall 5 m away, which goes up without end.
pub fn floor_and_wall(width: u32, height: u32) -> GBufferData {
    let slope = |y: u32| {
        let ndc = 1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height);
        ndc * f64::from(Lens::default().fov_y_radians / 2.0).tan()
    };
    // The floor is seen along y = slope · z = −1.
    let is_floor = move |y| slope(y) < -1.0 / 5.0;
    gbuffer(
        width,
        height,
        |_, y| depth_of(if is_floor(y) { -1.0 / slope(y) } else { 5.0 }),
        |_, y| if is_floor(y) { Vec3::Y } else { Vec3::NEG_Z },
    )
}
