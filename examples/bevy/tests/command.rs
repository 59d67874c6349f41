//! The example as a user starts it, with the validation layer on, beside the command on the images that Bevy drew, and beside
//! Bevy's own reflections. Nothing of this package's own is asked: the files are what any renderer would write.

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
    read_first_flat_layer_from_file,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SIZE: (usize, usize) = (320, 180);

/// The command; the variable's path may be relative to the repository.
fn ssct() -> PathBuf {
    let path = std::env::var_os("SSCT_COMMAND").unwrap_or_else(|| "target/debug/ssct".into());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    assert!(path.exists(), "{} is not there: `make build` makes it, `make test-bevy` does both", path.display());
    path
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the example, and returns its line of figures. wgpu turns the layer on, its checks of synchronization among it, and does
/// without where it is not installed; with the loader's variable, that fails.
fn example(folder: &Path, arguments: &[&str]) -> String {
    let mut example = Command::new(env!("CARGO_BIN_EXE_embed-bevy"));
    example.args(["--size", "320x180", "--frames", "8"]).args(arguments).current_dir(folder);
    let output = run(example.env("WGPU_VALIDATION", "1").env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("ERROR") && !said.contains("VUID"), "{said}");
    let line = said.lines().find(|line| line.starts_with('{'));
    line.unwrap_or_else(|| panic!("no figures: {said}")).to_string()
}

/// A number, or a text, of a line of figures.
fn figure<'a>(line: &'a str, name: &str) -> &'a str {
    let (_, rest) = line.split_once(&format!("\"{name}\": ")).unwrap_or_else(|| panic!("no {name}: {line}"));
    match rest.strip_prefix('"') {
        Some(text) => text.split('"').next().unwrap(),
        None => rest.split([',', '}']).next().unwrap(),
    }
}

fn number(line: &str, name: &str) -> f64 {
    figure(line, name).parse().unwrap()
}

/// Channels of an image that the example wrote.
fn channels<const N: usize>(folder: &Path, name: &str) -> [Vec<f32>; N] {
    let bytes = std::fs::read(folder.join(format!("{name}.f32"))).unwrap();
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let stride = numbers.len() / (SIZE.0 * SIZE.1);
    std::array::from_fn(|channel| numbers.iter().copied().skip(channel).step_by(stride.max(1)).collect())
}

/// The images as a G-buffer file. Its view space is left-handed, where that of Bevy is right-handed.
fn write_gbuffer(folder: &Path, file: &Path) {
    let bytes = std::fs::read(folder.join("camera.f32")).unwrap();
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let (mut clip, mut view) = ([0.0; 16], [0.0; 16]);
    clip.copy_from_slice(&numbers[..16]);
    view.copy_from_slice(&numbers[16..]);
    [8, 9, 10, 11].iter().for_each(|i| clip[*i] = -clip[*i]);
    [2, 6, 10, 14].iter().for_each(|i| view[*i] = -view[*i]);
    let [red, green, blue] = channels(folder, "color");
    let [x, y, z] = channels(folder, "normal");
    let [depth] = channels(folder, "depth");
    let [reflectivity, roughness] = channels(folder, "material");
    let z = z.iter().map(|z| -z).collect();
    let made = [("R", red), ("G", green), ("B", blue), ("depth", depth), ("N.X", x), ("N.Y", y), ("N.Z", z)];
    let rest = [("reflectivity", reflectivity), ("roughness", roughness)];
    let list = made.into_iter().chain(rest).map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)));
    let mut attributes = LayerAttributes { world_to_camera: Some(view), ..LayerAttributes::default() };
    attributes.other.insert("viewToClip".into(), AttributeValue::Matrix4x4(clip));
    let layer = Layer::new(SIZE, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list.collect()));
    Image::from_layer(layer).write().to_file(file).unwrap();
}

#[test]
fn the_camera_shows_what_the_command_makes_of_its_images() {
    let folder = folder("command");
    let line = example(&folder, &["out.png", "--with", "screen", "--no-sky", "--images", "images"]);
    let images = folder.join("images");
    write_gbuffer(&images, &folder.join("g.exr"));
    let mut command = Command::new(ssct());
    let command =
        command.args(["gbuffer", "reflect", "g.exr", "--method", "unified", "--reflection-only", "-o", "r.exr"]);
    run(command.env("SSCT_DEVICE", figure(&line, "device")).current_dir(&folder));
    let layer = read_first_flat_layer_from_file(folder.join("r.exr")).unwrap().layer_data;
    let embedded = channels::<4>(&images, "reflection");
    for (name, embedded) in ["R", "G", "B"].into_iter().zip(&embedded) {
        let channel = layer.channel_data.list.iter().find(|c| c.name == *name).unwrap();
        let made: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(made.len(), embedded.len());
        let differ = made.iter().zip(embedded).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "of {} pixels of {name}", made.len());
    }
    let reflects = embedded[3].iter().filter(|sure| **sure > 0.5).count();
    assert!(reflects > 1000, "{reflects} pixels reflect");
}

#[test]
fn mirrors_show_the_world_and_what_moved_in_it() {
    let folder = folder("world");
    let [still, moved] = [&[][..], &["--moved"]].map(|more| {
        let line = example(&folder, &[&["out.png", "--with", "ssct"], more].concat());
        assert!(number(&line, "mirrors") > 10_000.0, "{line}");
        assert!(number(&line, "others_rmse") < 0.05, "the truth is that of another picture: {line}");
        assert!(number(&line, "right") > 0.97, "{line}");
        line
    });
    let bevy = example(&folder, &["out.png", "--with", "bevy"]);
    // A history shows two images in turn.
    example(&folder, &["out.png", "--with", "history", "--roughness", "0.25"]);
    for line in [still, moved] {
        assert!(number(&line, "rmse") < 0.5 * number(&bevy, "rmse"), "{line}, {bevy}");
    }
}
