//! Compares the composites that the examples for other renderers write with those that the command makes of the same
//! G-buffers.

use glam::{Mat4, Vec3};
use ssct_ground::scene::{Projection, ProjectionKind};
use ssct_scenes::{Camera, GBufferData, Lens, Surface};
use std::path::Path;
use std::process::Command;

/// The 32-bit floats of a file.
fn numbers(path: &Path) -> Vec<f32> {
    std::fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// The G-buffer that an example drew, converted from its right-handed view space and its projection with y down.
fn gbuffer(images: &Path, [width, height]: [u32; 2]) -> GBufferData {
    let values = |name: &str| numbers(&images.join(format!("{name}.f32")));
    let camera = values("camera");
    let (clip, view) = camera.split_at(16);
    let vectors =
        |name: &str, z: f32| values(name).as_chunks::<4>().0.iter().map(|t| Vec3::new(t[0], t[1], z * t[2])).collect();
    let material: Vec<Vec3> = vectors("material", 1.0);
    let turn = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let kind = ProjectionKind::Perspective;
    let projection = Projection { kind, scale: [clip[0], -clip[5]], shift: [0.0; 2], depth: [-clip[10], clip[14]] };
    let [near, far] = [clip[14] / (1.0 + clip[10]), clip[14] / clip[10]];
    let lens = Lens::perspective(2.0 * (1.0 / projection.scale[1]).atan(), near, far);
    GBufferData {
        width,
        height,
        camera: Camera {
            world_to_view: turn * Mat4::from_cols_slice(view),
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

/// Checks that the composite in a folder's `images` equals, to the bit, what the command makes of the G-buffer there.
/// The command gets `options` beside its usual ones.
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
    let command = ssct_lab::report::images::read_image(&folder.join("r.exr")).unwrap();
    let embedded = numbers(&images.join("composite.f32"));
    let shown: Vec<[f32; 3]> = embedded.as_chunks::<4>().0.iter().map(|t| [t[0], t[1], t[2]]).collect();
    assert_eq!(shown.len(), command.rgb.len());
    let differ = shown.iter().zip(&command.rgb).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count();
    assert_eq!(differ, 0, "of {} pixels", shown.len());
    let reflects = shown.iter().zip(&data.color).filter(|(a, b)| (a[0] - b.x).abs() > 0.1).count();
    assert!(reflects > 1000, "{reflects} pixels reflect");
}
