//! `examples/embed` as a user starts it.

use glam::{Mat4, Vec3};
use ssct::scene::Projection;
use ssct_lab::scene::{Camera, GBufferData, Lens, Surface};
use std::path::Path;
use std::process::Command;

/// Numbers of a file of the example.
fn numbers(path: &Path) -> Vec<f32> {
    std::fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// The example as a user starts it, and the command on the images that it drew.
#[test]
fn the_example_shows_what_the_command_makes_of_its_images() {
    let program = std::env::current_exe().unwrap();
    let program = program.ancestors().nth(2).unwrap().join("examples/embed");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(&program)
        .args(["out.png", "images"])
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .current_dir(folder.path())
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("VUID") && !said.contains("SYNC-"), "{said}");
    let of = |name: &str| numbers(&folder.path().join(format!("images/{name}.f32")));
    let camera = of("camera");
    let (clip, view) = camera.split_at(16);
    let (width, height) = (640, 360);
    let vectors =
        |name: &str, z: f32| of(name).as_chunks::<4>().0.iter().map(|t| Vec3::new(t[0], t[1], z * t[2])).collect();
    let material: Vec<Vec3> = vectors("material", 1.0);
    let turn = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let projection = Projection { scale: [clip[0], -clip[5]], shift: [0.0; 2], depth: [-clip[10], clip[14]] };
    let [near, far] = [clip[14] / (1.0 + clip[10]), clip[14] / clip[10]];
    let lens = Lens { fov_y_radians: 2.0 * (1.0 / projection.scale[1]).atan(), near_m: near, far_m: far };
    let data = GBufferData {
        width,
        height,
        camera: Camera {
            world_to_view: turn * Mat4::from_cols_slice(view),
            lens,
            aspect: projection.scale[1] / projection.scale[0],
            near_plane: None,
            projection: Some(projection),
        },
        depth: of("depth"),
        normal: vectors("normal", -1.0),
        reflectivity: material.iter().map(|m| m.x).collect(),
        roughness: material.iter().map(|m| m.y).collect(),
        color: vectors("color", 1.0),
        surface: vec![Surface::Lit; (width * height) as usize],
    };
    let file = folder.path().join("g.exr");
    std::fs::write(&file, ssct_lab::scene::gbuffer_file::encode(&data, &file).unwrap()).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_ssct"))
        .args(["gbuffer", "reflect", "g.exr", "--method", "unified", "-o", "r.exr"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let command = ssct_lab::report::images::read_image(&folder.path().join("r.exr")).unwrap();
    let embedded = of("composite");
    let shown: Vec<[f32; 3]> = embedded.as_chunks::<4>().0.iter().map(|t| [t[0], t[1], t[2]]).collect();
    let differ = shown.iter().zip(&command.rgb).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count();
    assert_eq!(differ, 0, "of {} pixels", shown.len());
    assert!(shown.iter().zip(of("color").as_chunks::<4>().0).any(|(a, b)| (a[0] - b[0]).abs() > 0.1), "it reflects");
}
