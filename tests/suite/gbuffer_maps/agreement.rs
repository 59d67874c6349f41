//! Tests the check of a map: a frame that is read by wrong conventions contradicts itself, since its normals are not
//! those of the slopes of its depth. The check finds the wrong convention.

use super::files::{Part, floats, write_exr};
use super::named_channels;
use crate::common::folder::Folder;
use exr::image::FlatSamples;
use exr::meta::attribute::IntegerBounds;
use exr::prelude::WritableImage;
use glam::DVec3;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [96, 54];

/// Angle of view from top to bottom, in degrees, of a camera that looks along z.
const FOV_Y_DEG: f64 = 40.0;

/// Distance of the near plane in metres.
const NEAR: f64 = 0.5;

/// Returns the place and the normal that the image point (x, y), in pixels, shows of a tilted floor, a wall and a ball
/// of radius 0.8. Both are in a left-handed view space with y up.
fn visible_surface(x: f64, y: f64, aspect: f64) -> (DVec3, DVec3) {
    let tan_half_fov = (0.5 * FOV_Y_DEG).to_radians().tan();
    let ray = DVec3::new(
        (2.0 * x / f64::from(SIZE[0]) - 1.0) * tan_half_fov * aspect,
        (1.0 - 2.0 * y / f64::from(SIZE[1])) * tan_half_fov,
        1.0,
    );
    let planes = [
        (DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.1, 0.95, -0.1).normalize()),
        (DVec3::new(0.0, 0.0, 8.0), DVec3::new(-0.3, 0.1, -0.9).normalize()),
    ];
    let plane_hit = |(point, normal): (DVec3, DVec3)| (point.dot(normal) / ray.dot(normal), normal);
    let mut hits: Vec<(f64, DVec3)> = planes.into_iter().map(plane_hit).filter(|(t, _)| *t > 0.0).collect();
    let centre = DVec3::new(0.4, 0.1, 4.5);
    // The ball is hit where a t² + 2 b t + c = 0.
    let (a, b, c) = (ray.length_squared(), -ray.dot(centre), centre.length_squared() - 0.8 * 0.8);
    if b * b > a * c {
        let t = (-b - (b * b - a * c).sqrt()) / a;
        hits.push((t, (t * ray - centre) / 0.8));
    }
    let (t, normal) = hits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    (t * ray, normal)
}

/// Returns the channels of the frame, in the order of [`CHANNELS`]. `depth_of` computes the stored depth from a place.
fn frame(depth_of: impl Fn(DVec3) -> f64, aspect: f64) -> Vec<FlatSamples> {
    let pixels: Vec<(DVec3, DVec3)> = (0..SIZE[1])
        .flat_map(|y| (0..SIZE[0]).map(move |x| visible_surface(f64::from(x) + 0.5, f64::from(y) + 0.5, aspect)))
        .collect();
    let channel = |value: &dyn Fn(&(DVec3, DVec3)) -> f64| floats(pixels.iter().map(value));
    vec![
        channel(&|(place, _)| depth_of(*place)),
        channel(&|(_, normal)| normal.x),
        channel(&|(_, normal)| normal.y),
        channel(&|(_, normal)| normal.z),
        channel(&|(place, _)| place.x),
        channel(&|(place, _)| place.y),
        channel(&|(place, _)| place.z),
        channel(&|_| 0.5),
    ]
}

/// Names of the channels: depth, normal, place, and a colour.
const CHANNELS: [&str; 8] = ["Z", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R"];

/// Returns the width over the height of the frame.
fn aspect() -> f64 {
    f64::from(SIZE[0]) / f64::from(SIZE[1])
}

/// Returns a map that is right for the frame, with some pieces replaced and more text after it. Each change is a piece
/// of the map and the text that replaces it.
fn map(changes: &[(&str, &str)], appended: &str) -> String {
    let right_map = format!(
        "[camera]\nfov-y-deg = {FOV_Y_DEG:.1}\nnear = {NEAR}\nfar = 100.0\neye = [0, 0, 0]\nlook-at = [0, 0, 1]\n[depth]\n\
         kind = \"view-z\"\nchannel = \"Z\"\n[normal]\nspace = \"view\"\nchannels = [\"N.X\", \"N.Y\", \"N.Z\"]\n[roughness]\n\
         kind = \"lobe\"\nvalue = 0.0\n[reflectivity]\nvalue = 0.5\n[[color]]\nchannel = \"R\"\n"
    );
    changes.iter().fold(right_map + appended, |map, (piece, replacement)| {
        assert!(map.contains(piece), "{piece} is in the map");
        map.replacen(piece, replacement, 1)
    })
}

/// Returns the sentence of [`GBufferMap::check`] about the file `f.exr`, read by a map; `None` if the check finds
/// nothing wrong.
fn check_message(folder: &Folder, map: &str) -> Option<String> {
    folder.write("map.toml", map);
    let (map, file) = (GBufferMap::load(&folder.path("map.toml")).unwrap(), folder.path("f.exr"));
    map.check(&file, &map.read(&file).unwrap()).unwrap()
}

/// Writes the channels to the file `f.exr`.
fn write(folder: &Folder, samples: Vec<FlatSamples>) {
    write_exr(&folder.path("f.exr"), SIZE, vec![Part::new(named_channels(&CHANNELS, samples))]);
}

/// The section of a map that reads the places of surfaces.
const POSITION: &str = "[position]\nspace = \"view\"\nchannels = [\"P.X\", \"P.Y\", \"P.Z\"]\n";

/// The check finds nothing wrong with the right map, with places of surfaces and without. A false alarm would make
/// users change a right map.
#[test]
fn a_right_map_is_not_doubted() {
    let folder = Folder::new();
    write(&folder, frame(|p| p.z, aspect()));
    assert_eq!(check_message(&folder, &map(&[], "")), None);
    assert_eq!(check_message(&folder, &map(&[], POSITION)), None);
}

/// Six frames are read by maps that are wrong in one convention each, and the check names the convention that would
/// fit. Each makes a picture that looks plausible.
#[test]
fn each_wrong_convention_is_found() {
    let from_near = |p: DVec3| p.length() - NEAR * p.length() / p.z;
    let folder = Folder::new();
    for (depth, changes, right_line) in [
        (&(|p: DVec3| p.length()) as &dyn Fn(DVec3) -> f64, &[][..], "kind = \"distance\" in [depth]"),
        (&from_near, &[], "kind = \"distance-from-near\" in [depth]"),
        (&|p: DVec3| p.z, &[("\"view-z\"", "\"distance\"")], "kind = \"view-z\" in [depth]"),
        (
            &|p: DVec3| p.z,
            &[("[depth]", "[conventions]\nview = \"right\"\n[depth]")],
            "view = \"left\" in [conventions]",
        ),
        (&|p: DVec3| p.z, &[("fov-y-deg", "fov-x-deg")], "an angle from top to bottom (fov-y)"),
        (&|p: DVec3| p.z, &[("[camera]", "origin = \"bottom-left\"\n[camera]")], "origin = \"top-left\""),
    ] {
        write(&folder, frame(depth, aspect()));
        let message =
            check_message(&folder, &map(changes, "")).unwrap_or_else(|| panic!("{right_line}: nothing is said"));
        assert!(message.contains(&format!("; with {right_line} it would be ")), "{right_line}: {message}");
    }
}

/// If a map says 20 degrees where the lens has 40, the check estimates the angle within 2 degrees.
#[test]
fn a_wrong_lens_is_estimated() {
    let folder = Folder::new();
    write(&folder, frame(|p| p.z, aspect()));
    let message = check_message(&folder, &map(&[("fov-y-deg = 40.0", "fov-y-deg = 20.0")], "")).unwrap();
    let fov: f64 = message.split("fov-y-deg = ").nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap();
    assert!((fov - FOV_Y_DEG).abs() < 2.0, "{message}");
}

/// For each quarter of a picture that is read as a whole one, the check names the shift within 2 pixels, and the angle
/// of half the height. A renderer that crops to a border writes such files.
#[test]
fn a_cropped_picture_is_told_apart_from_a_whole_one() {
    let folder = Folder::new();
    for [is_right, is_lower] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        let point_in_whole =
            |pixel: u32, offset: f64, side: u32| 0.5 * (f64::from(pixel) + 0.5 + offset * f64::from(side));
        let quarter = |x: u32, y: u32| {
            visible_surface(point_in_whole(x, is_right, SIZE[0]), point_in_whole(y, is_lower, SIZE[1]), aspect())
        };
        let pixels: Vec<_> = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| quarter(x, y))).collect();
        let channel = |value: &dyn Fn(&(DVec3, DVec3)) -> f64| floats(pixels.iter().map(value));
        let mut samples = vec![channel(&|(place, _)| place.z)];
        samples.extend([0, 1, 2].map(|axis| channel(&|(_, normal)| normal[axis])));
        samples.extend((0..4).map(|_| channel(&|_| 0.5)));
        write(&folder, samples);
        let message = check_message(&folder, &map(&[], "")).unwrap();
        let (_, shift) = message.split_once(" and shift-px = [").unwrap_or_else(|| panic!("{message}"));
        let shift = shift.split_once(']').unwrap().0.split(", ").map(|number| number.parse::<f64>().unwrap());
        let expected = [(0.5 - is_right) * f64::from(SIZE[0]), (0.5 - is_lower) * f64::from(SIZE[1])];
        assert!(
            shift.zip(expected).all(|(found, expected)| (found - expected).abs() <= 2.0),
            "{expected:?}: {message}"
        );
        assert!(message.contains("with fov-y-deg = 20."), "{message}");
    }
}

/// If the file has places of surfaces, the check finds a wrong angle of view by them.
#[test]
fn places_of_surfaces_are_held_against_the_camera() {
    let folder = Folder::new();
    write(&folder, frame(|p| p.z, aspect()));
    let message = check_message(&folder, &map(&[("fov-y-deg", "fov-x-deg")], POSITION)).unwrap();
    assert!(
        message.contains("places of [position] with depth and camera in ") && message.contains("fov-y"),
        "{message}"
    );
}

/// A frame whose header says that pixels are twice as wide as high is read with the right aspect.
#[test]
fn pixels_that_are_not_square_are_read_from_the_header() {
    let folder = Folder::new();
    let part = Part::new(named_channels(&CHANNELS, frame(|p| p.z, 2.0 * aspect())));
    let layer = |part: Part| {
        let channels =
            part.channels.into_iter().map(|(name, samples)| exr::image::AnyChannel::new(name.as_str(), samples));
        let channels = exr::image::AnyChannels::sort(channels.collect());
        let size = exr::prelude::Vec2(SIZE[0] as usize, SIZE[1] as usize);
        exr::image::Layer::new(size, part.attributes, exr::image::Encoding::SMALL_LOSSLESS, channels)
    };
    let window = IntegerBounds::from_dimensions(exr::prelude::Vec2(SIZE[0] as usize, SIZE[1] as usize));
    let mut attributes = exr::meta::header::ImageAttributes::new(window);
    attributes.pixel_aspect = 2.0;
    let image = exr::image::Image::from_layers(attributes, [layer(part)].to_vec());
    image.write().to_file(folder.path("f.exr")).unwrap();
    assert_eq!(check_message(&folder, &map(&[], POSITION)), None);
    folder.write("map.toml", map(&[], ""));
    let data = GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap();
    assert!((f64::from(data.camera.aspect) - 2.0 * aspect()).abs() < 1e-5, "{}", data.camera.aspect);
}
