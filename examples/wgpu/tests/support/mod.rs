//! Runs the command `ssct` on the images that an example drew, in files of a kind that any renderer could write.

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
    read_first_flat_layer_from_file,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The path of the command `ssct`: the variable `SSCT_COMMAND`, which may be relative to the repository, or the debug
/// build.
pub fn ssct() -> PathBuf {
    let path = std::env::var_os("SSCT_COMMAND").unwrap_or_else(|| "target/debug/ssct".into());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    assert!(path.exists(), "{} is not there: `make build` makes it", path.display());
    path
}

/// Runs a command, which must succeed, and returns its output.
pub fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Reads the first N channels of the image `name` that the example wrote into `folder`, with width x height pixels.
pub fn channels<const N: usize>(folder: &Path, name: &str, (width, height): (usize, usize)) -> [Vec<f32>; N] {
    let bytes = std::fs::read(folder.join(format!("{name}.f32"))).unwrap();
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let stride = numbers.len() / (width * height);
    std::array::from_fn(|channel| numbers.iter().copied().skip(channel).step_by(stride.max(1)).collect())
}

/// Writes the example's images as a G-buffer file. The example's view space is right-handed and that of the file is
/// left-handed, so z is negated.
pub fn write_gbuffer(folder: &Path, size: (usize, usize), file: &Path) {
    let bytes = std::fs::read(folder.join("camera.f32")).unwrap();
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let (mut view_to_clip, mut world_to_view) = ([0.0; 16], [0.0; 16]);
    view_to_clip.copy_from_slice(&numbers[..16]);
    world_to_view.copy_from_slice(&numbers[16..]);
    // The third column of view to clip, and the third row of world to view, belong to z in view space.
    [8, 9, 10, 11].iter().for_each(|i| view_to_clip[*i] = -view_to_clip[*i]);
    [2, 6, 10, 14].iter().for_each(|i| world_to_view[*i] = -world_to_view[*i]);
    let [red, green, blue] = channels(folder, "color", size);
    let [x, y, z] = channels(folder, "normal", size);
    let [depth] = channels(folder, "depth", size);
    let [reflectivity, roughness] = channels(folder, "material", size);
    let z = z.iter().map(|z| -z).collect();
    let surface = [("R", red), ("G", green), ("B", blue), ("depth", depth), ("N.X", x), ("N.Y", y), ("N.Z", z)];
    let factors = [("reflectivity", reflectivity), ("roughness", roughness)];
    let channel = |(name, values)| AnyChannel::new(name, FlatSamples::F32(values));
    let channels = AnyChannels::sort(surface.into_iter().chain(factors).map(channel).collect());
    let mut attributes = LayerAttributes { world_to_camera: Some(world_to_view), ..LayerAttributes::default() };
    attributes.other.insert("viewToClip".into(), AttributeValue::Matrix4x4(view_to_clip));
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(file).unwrap();
}

/// Fails unless the first three channels of an example's image equal red, green and blue of the command's file to the
/// bit.
pub fn assert_equal(file: &Path, embedded: &[Vec<f32>]) {
    let layer = read_first_flat_layer_from_file(file).unwrap().layer_data;
    for (name, embedded) in ["R", "G", "B"].into_iter().zip(embedded) {
        let channel = layer.channel_data.list.iter().find(|c| c.name == *name).unwrap();
        let expected: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(expected.len(), embedded.len());
        let differ = expected.iter().zip(embedded).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "of {} pixels of {name}", expected.len());
    }
}
