//! A capture on the CPU (docs/definitions.md, "Images"): six images of the scene, in which the references follow rays.

use glam::Vec3;
use ssct_scenes::capture::face_camera;
use ssct_scenes::{Capture, GBufferData, Surface, sky};

/// Six images of the scene around a place, the faces of a cube.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureData {
    /// Place from which the images were made, in the world, in metres.
    pub place: Vec3,
    /// The faces in Vulkan's order +x −x +y −y +z −z. All faces have the same size and lens. Normals are in the view
    /// space of the face, and colours are the lit colour, black where the sky is seen.
    pub faces: Vec<GBufferData>,
}

impl CaptureData {
    /// Makes the images of a capture. `texel` gets the direction of each texel, in world axes, whose greatest component
    /// is 1. It returns what the texel shows: the view depth in metres (infinite for sky), the normal in world axes,
    /// and the lit colour.
    pub fn from_texels(capture: &Capture, mut texel: impl FnMut(Vec3) -> (f64, Vec3, Vec3)) -> Self {
        let side = capture.resolution;
        let texel_count = (side * side) as usize;
        let faces = (0..6).map(|face| {
            let camera = face_camera(capture.position, face, capture.near_m);
            let mut data = GBufferData {
                width: side,
                height: side,
                camera,
                depth: Vec::with_capacity(texel_count),
                normal: Vec::with_capacity(texel_count),
                reflectivity: vec![0.0; texel_count],
                roughness: vec![0.0; texel_count],
                color: Vec::with_capacity(texel_count),
                surface: vec![Surface::Lit; texel_count],
            };
            let view_to_clip = data.view_to_clip();
            for i in 0..side * side {
                let uv = [i % side, i / side].map(|v| (v as f32 + 0.5) / side as f32);
                let (view_z_m, normal, color) = texel(sky::face_direction(face, uv[0], uv[1]));
                // Reversed depth depends on z alone, and sky has 0.
                let depth = if view_z_m.is_finite() {
                    view_to_clip.project_point3(glam::DVec3::new(0.0, 0.0, view_z_m)).z
                } else {
                    0.0
                };
                data.depth.push(depth.clamp(0.0, 1.0) as f32);
                data.normal.push(camera.world_to_view.transform_vector3(normal));
                data.color.push(color);
            }
            data
        });
        Self { place: capture.position, faces: faces.collect() }
    }
}
