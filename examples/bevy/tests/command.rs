//! Starts the example as a user does, with the validation layer on. Compares its pictures with the command `ssct`,
//! which reads the images that Bevy drew, and with Bevy's own reflections. The tests call no function of this package.

#[path = "../../wgpu/tests/support/mod.rs"]
mod support;

use std::path::{Path, PathBuf};
use std::process::Command;
use support::{assert_equal, channels, run, ssct, write_gbuffer};

const SIZE: (usize, usize) = (320, 180);

/// Makes a folder for the files of a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the example, and returns its line of figures. wgpu turns the validation layer on, with its checks of
/// synchronization. The variable of Vulkan's loader names the layer, too, so that the example fails where the layer is
/// not installed.
fn example(folder: &Path, arguments: &[&str]) -> String {
    let mut example = Command::new(env!("CARGO_BIN_EXE_embed-bevy"));
    example.args(["--size", "320x180", "--frames", "8"]).args(arguments).current_dir(folder);
    let output = run(example.env("WGPU_VALIDATION", "1").env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation"));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!printed.contains("ERROR") && !printed.contains("VUID"), "{printed}");
    let line = printed.lines().find(|line| line.starts_with('{'));
    line.unwrap_or_else(|| panic!("no figures: {printed}")).to_string()
}

/// Returns the value after a name in a line of figures, as text without quotes.
fn figure<'a>(line: &'a str, name: &str) -> &'a str {
    let (_, rest) = line.split_once(&format!("\"{name}\": ")).unwrap_or_else(|| panic!("no {name}: {line}"));
    match rest.strip_prefix('"') {
        Some(text) => text.split('"').next().unwrap(),
        None => rest.split([',', '}']).next().unwrap(),
    }
}

/// The number after a name in a line of figures.
fn number(line: &str, name: &str) -> f64 {
    figure(line, name).parse().unwrap()
}

#[test]
fn the_camera_shows_what_the_command_makes_of_its_images() {
    let folder = folder("command");
    let line = example(&folder, &["out.png", "--with", "screen", "--sky", "none", "--images", "images"]);
    let images = folder.join("images");
    write_gbuffer(&images, SIZE, &folder.join("g.exr"));
    let mut command = Command::new(ssct());
    let reflect = ["gbuffer", "reflect", "g.exr", "--method", "unified", "--own-rays", "auto"];
    let command = command.args(reflect).args(["--reflection-only", "-o", "r.exr"]);
    run(command.env("SSCT_DEVICE", figure(&line, "device")).current_dir(&folder));
    let embedded = channels::<4>(&images, "reflection", SIZE);
    assert_equal(&folder.join("r.exr"), &embedded);
    let [.., fade] = &embedded;
    let reflecting = fade.iter().filter(|fade| **fade > 0.5).count();
    assert!(reflecting > 1000, "{reflecting} pixels reflect");
}

#[test]
fn mirrors_show_the_world_and_what_moved_in_it() {
    let folder = folder("world");
    let [still, moved] = [&[][..], &["--moved"]].map(|motion| {
        let line = example(&folder, &[&["out.png", "--with", "ssct"], motion].concat());
        assert!(number(&line, "mirrors") > 10_000.0, "{line}");
        assert!(number(&line, "others_rmse") < 0.05, "the truth is that of another picture: {line}");
        assert!(number(&line, "right") > 0.97, "{line}");
        line
    });
    let bevy = example(&folder, &["out.png", "--with", "bevy"]);
    // With a history, the reflections write two images in turn; both must be shown without an error.
    example(&folder, &["out.png", "--with", "history", "--roughness", "0.25"]);
    // With the plugin, a camera without the component still shows all surfaces that do not reflect.
    let off = example(&folder, &["out.png", "--with", "off"]);
    assert!(number(&off, "others_rmse") < 0.05, "{off}");
    for line in [still, moved] {
        assert!(number(&line, "rmse") < 0.5 * number(&bevy, "rmse"), "{line}, {bevy}");
    }
}

#[test]
fn mirrors_show_the_environment_map_the_way_round_that_bevy_does() {
    let folder = folder("sky");
    // With `nothing`, Bevy's lighting adds the map by itself: this checks that the sky of the truth is the right way
    // round.
    for with in ["nothing", "ssct", "traced"] {
        let line = example(&folder, &["out.png", "--with", with, "--sky", "colorful"]);
        assert!(number(&line, "sky_rmse") < 0.01, "{with}: {line}");
    }
}

#[test]
fn what_is_lit_is_in_the_mirror_as_the_screen_shows_it() {
    let folder = folder("lit");
    example(&folder, &["mirrored.png", "--lit", "--with", "nothing", "--mirrored"]);
    let [shown, guessed] = ["ssct", "guess"]
        .map(|with| example(&folder, &["out.png", "--lit", "--with", with, "--mirror", "mirrored.png"]));
    assert!(number(&shown, "rmse") < 0.8 * number(&guessed, "rmse"), "{shown}, {guessed}");
    assert!(number(&shown, "right") > number(&guessed, "right") + 0.3, "{shown}, {guessed}");
}
