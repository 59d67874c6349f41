//! Tests files as other programs write them: compressions that keep some channels exactly, and images with overscan.

use super::errors::{self, MAP};
use super::files::{Part, floats, halves, write_exr};
use super::named_channels;
use crate::common::folder::Folder;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, Vec2, WritableImage};
use glam::Vec3;
use ssct_scenes::GBufferData;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Size of the image in pixels.
const SIZE: [u32; 2] = [8, 4];
/// The channels of the frame.
const NAMES: [&str; 8] = ["Z", "N.X", "N.Y", "N.Z", "rough", "R", "G", "B"];

/// Returns the values of all channels at a pixel. Pixels outside the image have values, too.
fn values(x: i32, y: i32) -> [f64; 8] {
    let depth = 2.0 + 0.01 * f64::from(x) + 0.13 * f64::from(y);
    let [red, green] = [12.9, 78.2].map(|rate| 0.5 + 0.4 * (rate * f64::from(x) + 4.1 * f64::from(y)).sin());
    [depth, 0.6, 0.0, -0.8, 0.25, red, green, 0.5]
}

/// Returns the samples of each channel over a window of `width` × `height` pixels that begins at `position`.
fn channels(position: [i32; 2], [width, height]: [u32; 2]) -> Vec<FlatSamples> {
    let pixels = || (0..height as i32).flat_map(|y| (0..width as i32).map(move |x| (x + position[0], y + position[1])));
    (0..NAMES.len()).map(|channel| floats(pixels().map(|(x, y)| values(x, y)[channel]))).collect()
}

/// Reads a file by the map without mistakes, and returns the G-buffer or the error.
fn read_frame(folder: &Folder, name: &str) -> Result<GBufferData, String> {
    folder.write("map.toml", MAP);
    let map = GBufferMap::load(&folder.path("map.toml")).unwrap();
    map.read(&folder.path(name)).map_err(|error| error.to_string())
}

/// Writes the frame without compression or overscan, and reads it back.
fn read_plain_frame(folder: &Folder) -> GBufferData {
    write_exr(&folder.path("plain.exr"), SIZE, vec![Part::new(named_channels(&NAMES, channels([0, 0], SIZE)))]);
    read_frame(folder, "plain.exr").unwrap()
}

/// A frame of 32-bit floats in a B44 or B44A file is read exactly, since these compressions round 16-bit floats alone.
/// To refuse them for depth in every case would refuse good files.
#[test]
fn floats_survive_b44_to_the_bit() {
    let folder = Folder::new();
    let expected = read_plain_frame(&folder);
    for compression in [Compression::B44, Compression::B44A] {
        let part = Part::new(named_channels(&NAMES, channels([0, 0], SIZE))).compressed(compression);
        write_exr(&folder.path("b44.exr"), SIZE, vec![part]);
        assert!(read_frame(&folder, "b44.exr").unwrap() == expected, "{compression}");
    }
}

/// Colours of 16-bit floats in a B44 file are read with their rounding. Depth of 16-bit floats in such a file is
/// refused, since rays would meet its steps.
#[test]
fn colours_may_be_rounded_by_b44_and_depth_may_not() {
    let folder = Folder::new();
    let expected = read_plain_frame(&folder);
    // Depth and normals stay 32-bit floats, and the colours (`NAMES` from R on) become 16-bit floats.
    let mut mixed = channels([0, 0], SIZE);
    for samples in &mut mixed[5..] {
        let FlatSamples::F32(values) = samples.clone() else { unreachable!("they are floats") };
        *samples = halves(values.into_iter().map(f64::from));
    }
    write_exr(
        &folder.path("b44.exr"),
        SIZE,
        vec![Part::new(named_channels(&NAMES, mixed)).compressed(Compression::B44)],
    );
    let found = read_frame(&folder, "b44.exr").unwrap();
    assert_eq!((&found.depth, &found.normal), (&expected.depth, &expected.normal));
    let distance = found.color.iter().zip(&expected.color).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(distance < 0.1 && distance > 0.0, "{distance}");
    // This change of the map takes the depth from a channel of 16-bit floats.
    let rounded_depth = ("channel = \"Z\"\n", "file = \"b44.exr\"\nchannel = \"R\"\n");
    let message = errors::map_error(&errors::folder(), &[rounded_depth]);
    assert!(message.contains("was rounded by b44 compression"), "{message}");
}

/// Pixels at a limit of the map are sky even if no 32-bit float equals the limit's decimal number.
#[test]
fn limits_of_sky_are_rounded_as_pixels_are() {
    let folder = Folder::new();
    for (kind, key, limit, surface) in [
        ("reversed", "sky-beyond", 0.05, 0.5),
        ("standard", "sky-beyond", 0.95, 0.5),
        ("view-z", "sky-beyond", 9.7, 2.0),
        ("view-z", "sky-value", -9999.9, 2.0),
    ] {
        let mut depths = vec![surface; 32];
        depths[0] = limit;
        let mut samples = channels([0, 0], SIZE);
        samples[0] = floats(depths);
        write_exr(&folder.path("sky.exr"), SIZE, vec![Part::new(named_channels(&NAMES, samples))]);
        let map = MAP.replace("kind = \"view-z\"", &format!("kind = \"{kind}\"\n{key} = {limit}"));
        let depth = super::read_by_map(&folder, &map, "sky.exr").depth;
        assert!(depth[0] == 0.0 && depth[1] > 0.0, "{kind} {key}: {} {}", depth[0], depth[1]);
    }
}

/// Writes a file whose stored pixels begin at `position` and are `stored` many in x and y, and whose image begins at
/// pixel 0, 0 and has the size [`SIZE`].
fn write_overscan(folder: &Folder, name: &str, position: [i32; 2], stored: [u32; 2]) {
    let any_channels =
        NAMES.iter().zip(channels(position, stored)).map(|(name, samples)| AnyChannel::new(*name, samples));
    let attributes = LayerAttributes { layer_position: Vec2(position[0], position[1]), ..LayerAttributes::default() };
    let size = Vec2(stored[0] as usize, stored[1] as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(any_channels.collect()));
    let window = IntegerBounds::from_dimensions(Vec2(SIZE[0] as usize, SIZE[1] as usize));
    Image::from_layers(ImageAttributes::new(window), [layer].to_vec()).write().to_file(folder.path(name)).unwrap();
}

/// Files whose stored window is larger than the image give the frame without overscan. Read whole, the image would be
/// shifted against the camera.
#[test]
fn overscan_is_cut_to_the_image() {
    let folder = Folder::new();
    let expected = read_plain_frame(&folder);
    for (position, stored) in [([-2, -1], [12, 7]), ([0, 0], [9, 4]), ([0, -3], [8, 7])] {
        write_overscan(&folder, "over.exr", position, stored);
        assert!(read_frame(&folder, "over.exr").unwrap() == expected, "{position:?} {stored:?}");
    }
    let [_, _, _, _, _, red, green, blue] = values(1, 0).map(|v| v as f32);
    assert_eq!(expected.color[1], Vec3::new(red, green, blue));
}

/// Files whose stored window does not cover the image are refused with a sentence.
#[test]
fn data_that_leave_a_part_of_the_image_out_are_refused() {
    let folder = Folder::new();
    for (position, stored) in [([1, 0], [8, 4]), ([0, 0], [8, 3]), ([-4, -4], [8, 4])] {
        write_overscan(&folder, "piece.exr", position, stored);
        let message = read_frame(&folder, "piece.exr").unwrap_err();
        assert!(message.ends_with("only whole images can be read"), "{message}");
    }
}
