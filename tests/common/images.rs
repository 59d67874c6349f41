//! Compares the composites that the examples for other renderers write with those that the command makes of the same
//! G-buffers.

use glam::{Mat4, Vec3};
use ssct_ground::scene::{Projection, ProjectionKind};
use ssct_scenes::{Camera, GBufferData, Lens, Surface};
use std::path::Path;
use std::process::Command;

/// Returns the 32-bit floats of a file, whose lowest bytes come first.
fn numbers(path: &Path) -> Vec<f32> {
    std::fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// Reads the G-buffer that an example wrote to the folder `images`, of a width and height in pixels. It is converted
/// from the example's right-handed view space and its projection with y down.
fn gbuffer(images: &Path, [width, height]: [u32; 2]) -> GBufferData {
    let values = |name: &str| numbers(&images.join(format!("{name}.f32")));
    // Two matrices, column by column: from view space to clip space, and from world space to view space.
    let camera = values("camera");
    let (clip, view) = camera.split_at(16);
    let vector = |texel: &[f32; 4], z_sign: f32| Vec3::new(texel[0], texel[1], z_sign * texel[2]);
    let vectors = |name: &str, z_sign: f32| values(name).as_chunks::<4>().0.iter().map(|t| vector(t, z_sign)).collect();
    // Channel 0 is the reflectivity, and channel 1 the roughness.
    let material: Vec<Vec3> = vectors("material", 1.0);
    let flip_z = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let kind = ProjectionKind::Perspective;
    let projection = Projection { kind, scale: [clip[0], -clip[5]], shift: [0.0; 2], depth: [-clip[10], clip[14]] };
    let [near, far] = [clip[14] / (1.0 + clip[10]), clip[14] / clip[10]];
    let lens = Lens::perspective(2.0 * (1.0 / projection.scale[1]).atan(), near, far);
    GBufferData {
        width,
        height,
        camera: Camera {
            world_to_view: flip_z * Mat4::from_cols_slice(view),
            lens,
            aspect: projection.scale[1] / projection.scale[0],
            near_plane: None,
            projection: Some(projection),
        },
        depth: values("depth"),
        normal: vectors("normal", -1.0),
        reflectivity: material.iter().map(|m| m.x).collect(),
        roughness: material.iter().map(|m| m.y).collect(),
        color: vectors("color", 1.0),
        surface: vec![Surface::Lit; (width * height) as usize],
    }
}

/// Checks that the composite that an example wrote equals, to the bit, the command's own of the same G-buffer.
///
/// `folder` has the example's files in its subfolder `images`, `size` is the image's width and height in pixels, and
/// the command gets `options` beside its usual ones. More than 1000 pixels must reflect.
#[track_caller]
pub fn check_composite(folder: &Path, size: [u32; 2], options: &[&str]) {
    let images = folder.join("images");
    let file = folder.join("g.exr");
    let data = gbuffer(&images, size);
    std::fs::write(&file, ssct_scenes::gbuffer_file::encode(&data, &file).unwrap()).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_ssct"))
        .args(["gbuffer", "reflect", "g.exr", "--method", "unified", "--own-rays", "auto", "-o", "r.exr"])
        .args(options)
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let expected = ssct_lab::report::images::read_image(&folder.join("r.exr")).unwrap();
    let embedded = numbers(&images.join("composite.f32"));
    let composite: Vec<[f32; 3]> = embedded.as_chunks::<4>().0.iter().map(|t| [t[0], t[1], t[2]]).collect();
    assert_eq!(composite.len(), expected.rgb.len());
    let differ =
        composite.iter().zip(&expected.rgb).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count();
    assert_eq!(differ, 0, "of {} pixels", composite.len());
    let reflects = composite.iter().zip(&data.color).filter(|(a, b)| (a[0] - b.x).abs() > 0.1).count();
    assert!(reflects > 1000, "{reflects} pixels reflect");
}
