//! The example as a user starts it, with the validation layer on, and the command on the images that it drew. Nothing of this
//! package's own is asked: the files are what any renderer would write.

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
    read_first_flat_layer_from_file,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SIZE: (usize, usize) = (640, 360);

/// The command; the variable's path may be relative to the repository.
fn ssct() -> PathBuf {
    let path = std::env::var_os("SSCT_COMMAND").unwrap_or_else(|| "target/debug/ssct".into());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    assert!(path.exists(), "{} is not there: `make build` makes it, `make test-wgpu` does both", path.display());
    path
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Channels of an image that the example wrote.
fn channels<const N: usize>(folder: &Path, name: &str) -> [Vec<f32>; N] {
    let bytes = std::fs::read(folder.join(format!("{name}.f32"))).unwrap();
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let stride = numbers.len() / (SIZE.0 * SIZE.1);
    std::array::from_fn(|channel| numbers.iter().copied().skip(channel).step_by(stride.max(1)).collect())
}

/// The images as a G-buffer file. Its view space is left-handed, where that of the example is right-handed.
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
fn the_example_shows_what_the_command_makes_of_its_images() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wgpu");
    std::fs::create_dir_all(&folder).unwrap();
    let mut example = Command::new(env!("CARGO_BIN_EXE_embed-wgpu"));
    let example = example.args(["out.png", "images"]).current_dir(&folder);
    // wgpu turns the layer on, its checks of synchronization among it, and does without where it is not installed; with the
    // loader's variable, that fails.
    let output = run(example.env("WGPU_VALIDATION", "1").env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("Validation"), "{said}");
    let device = said.lines().next().unwrap();

    let images = folder.join("images");
    write_gbuffer(&images, &folder.join("g.exr"));
    let mut command = Command::new(ssct());
    let command = command.args(["gbuffer", "reflect", "g.exr", "--method", "unified", "-o", "r.exr"]);
    run(command.env("SSCT_DEVICE", device).current_dir(&folder));
    let layer = read_first_flat_layer_from_file(folder.join("r.exr")).unwrap().layer_data;
    let embedded = channels::<3>(&images, "composite");
    for (name, embedded) in ["R", "G", "B"].into_iter().zip(&embedded) {
        let channel = layer.channel_data.list.iter().find(|c| c.name == *name).unwrap();
        let made: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(made.len(), embedded.len());
        let differ = made.iter().zip(embedded).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "of {} pixels of {name}", made.len());
    }
    let [lit, ..] = channels::<3>(&images, "color");
    let reflects = embedded[0].iter().zip(&lit).filter(|(a, b)| (*a - *b).abs() > 0.1).count();
    assert!(reflects > 1000, "{reflects} pixels reflect");
}
