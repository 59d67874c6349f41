//! Starts the example as a user does, with the validation layer on, and the command `ssct` on the images that it drew.
//! Both must make the same image. The test calls no function of this package.

mod support;

use std::path::Path;
use std::process::Command;
use support::{assert_equal, channels, run, ssct, write_gbuffer};

const SIZE: (usize, usize) = (640, 360);

#[test]
fn the_example_shows_what_the_command_makes_of_its_images() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wgpu");
    std::fs::create_dir_all(&folder).unwrap();
    let mut example = Command::new(env!("CARGO_BIN_EXE_embed-wgpu"));
    let example = example.args(["out.png", "images"]).current_dir(&folder);
    // wgpu turns the validation layer on, with its checks of synchronization. The variable of Vulkan's loader names the
    // layer, too, so that the example fails where the layer is not installed.
    let output = run(example.env("WGPU_VALIDATION", "1").env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation"));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!printed.contains("Validation"), "{printed}");
    let device = printed.lines().next().unwrap();

    let images = folder.join("images");
    write_gbuffer(&images, SIZE, &folder.join("g.exr"));
    let mut command = Command::new(ssct());
    let command =
        command.args(["gbuffer", "reflect", "g.exr", "--method", "unified", "--own-rays", "auto", "-o", "r.exr"]);
    run(command.env("SSCT_DEVICE", device).current_dir(&folder));
    let embedded = channels::<3>(&images, "composite", SIZE);
    assert_equal(&folder.join("r.exr"), &embedded);
    let [lit_red, ..] = channels::<3>(&images, "color", SIZE);
    let [red, ..] = &embedded;
    let reflecting = red.iter().zip(&lit_red).filter(|(composite, lit)| (*composite - *lit).abs() > 0.1).count();
    assert!(reflecting > 1000, "{reflecting} pixels reflect");
}
