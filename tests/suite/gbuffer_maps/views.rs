//! Tests files of several views, such as those of both eyes: each view in parts of its own, or all in one part.

use super::errors::MAP;
use super::files::{Part, floats, write_exr};
use super::named_channels;
use crate::common::folder::Folder;
use exr::meta::attribute::AttributeValue;
use ssct_scenes::GBufferData;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [4, 3];
/// The passes of a view, with the names of their components.
const PASSES: [(&str, &[&str]); 4] =
    [("Depth", &["Z"]), ("Normal", &["X", "Y", "Z"]), ("rough", &["V"]), ("Light", &["R", "G", "B"])];

/// Returns the value of a component of a pass. Depth and light differ between the left and the right view.
fn values(pass: &str, component: &str, is_left: bool) -> f64 {
    match (pass, component) {
        ("Depth", _) => {
            if is_left {
                2.0
            } else {
                3.0
            }
        }
        ("Normal", "Z") => -1.0,
        ("Normal", _) => 0.0,
        ("rough", _) => 0.25,
        _ => {
            if is_left {
                0.5
            } else {
                0.75
            }
        }
    }
}

/// Returns [`MAP`] with the names that the channels have in a layer `L`, and with the text `top` before it.
fn map(top: &str) -> String {
    let renamed = [
        ("\"Z\"", "\"L.Depth.Z\""),
        ("[\"N.X\", \"N.Y\", \"N.Z\"]", "[\"L.Normal.X\", \"L.Normal.Y\", \"L.Normal.Z\"]"),
        ("\"rough\"", "\"L.rough.V\""),
        ("[\"R\", \"G\", \"B\"]", "[\"L.Light.R\", \"L.Light.G\", \"L.Light.B\"]"),
    ];
    let map = renamed.iter().fold(MAP.to_owned(), |map, (name, layer_name)| {
        assert!(map.contains(name), "{name}");
        map.replacen(name, layer_name, 1)
    });
    format!("{top}{map}")
}

/// Reads a file by a map, and returns the G-buffer or the error.
fn read(folder: &Folder, map: &str, file: &str) -> Result<GBufferData, String> {
    folder.write("map.toml", map);
    GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path(file)).map_err(|error| error.to_string())
}

/// Writes a part for each pass and view: the part `L.Depth-left` has the channel `L.Depth.Z`. The attribute `lens` is
/// the angle of the view's lens in degrees.
fn write_parts(folder: &Folder) {
    let part = |(pass, components): &(&str, &[&str]), view: &str| {
        let names: Vec<String> = components.iter().map(|component| format!("L.{pass}.{component}")).collect();
        let samples = components.iter().map(|component| floats(vec![values(pass, component, view == "left"); 12]));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut part = Part::new(named_channels(&names, samples)).named(&format!("L.{pass}-{view}"));
        part.attributes.view_name = Some(view.into());
        part.with("lens", AttributeValue::F32(if view == "left" { 60.0 } else { 50.0 }))
    };
    let parts = PASSES.iter().flat_map(|pass| ["left", "right"].map(|view| part(pass, view)));
    write_exr(&folder.path("parts.exr"), SIZE, parts.collect());
}

/// Writes all passes and views in one part, with channels such as `L.Depth.left.Z`.
fn write_one_part(folder: &Folder) {
    let mut channels = Vec::new();
    for (pass, components) in PASSES {
        for (view, component) in
            ["left", "right"].iter().flat_map(|view| components.iter().map(move |component| (view, component)))
        {
            let value = values(pass, component, *view == "left");
            channels.push((format!("L.{pass}.{view}.{component}"), floats(vec![value; 12])));
        }
    }
    write_exr(&folder.path("one.exr"), SIZE, vec![Part::new(channels)]);
}

/// For either view, the file of many parts and the file of one part give one G-buffer, with the colour of that view. A
/// mixture of both views would look almost right.
#[test]
fn a_view_is_read_from_parts_and_from_one_part() {
    let folder = Folder::new();
    write_parts(&folder);
    write_one_part(&folder);
    for (view, colour) in [("left", 0.5), ("right", 0.75)] {
        let map = map(&format!("view = \"{view}\"\n"));
        let of_parts = read(&folder, &map, "parts.exr").unwrap();
        assert!(of_parts == read(&folder, &map, "one.exr").unwrap(), "{view}");
        assert_eq!(of_parts.color[0].x, colour, "{view}");
    }
}

/// A map without a view, or with an unknown one, is refused with the names of the views.
#[test]
fn a_file_of_several_views_says_which_there_are() {
    let folder = Folder::new();
    write_parts(&folder);
    let without_view = read(&folder, &map(""), "parts.exr").unwrap_err();
    assert!(without_view.contains("or at the top of the map by view, one of left, right"), "{without_view}");
    let error = read(&folder, &map("view = \"middle\"\n"), "parts.exr").unwrap_err();
    assert!(error.contains("there is no view \"middle\" in ") && error.ends_with("which has left, right"), "{error}");
}

/// In a part that OpenEXR's attribute `multiView` divides, plain names belong to the first view, and others have their
/// view before the last component. Channels of no view belong to all. A view that is not listed is refused.
#[test]
fn views_that_share_a_part_are_told_apart_by_their_attribute() {
    let folder = Folder::new();
    let flat = |value: f64| floats(vec![value; 12]);
    let mut channels =
        named_channels(&["N.X", "N.Y", "N.Z", "N.right.X", "N.right.Z"], [0.0, 0.0, -1.0, 0.6, -0.8].map(flat));
    for (prefix, is_left) in [("", true), ("right.", false)] {
        for (name, pass) in [("Z", "Depth"), ("rough", "rough"), ("R", "Light"), ("G", "Light"), ("B", "Light")] {
            channels.push((format!("{prefix}{name}"), flat(values(pass, name, is_left))));
        }
    }
    let mut part = Part::new(channels);
    part.attributes.multi_view_names = Some(vec!["left".into(), "right".into()]);
    write_exr(&folder.path("shared.exr"), SIZE, vec![part]);
    let of_view = |top: &str| read(&folder, &format!("{top}{MAP}"), "shared.exr");
    let [without_view, left, right] = ["", "view = \"left\"\n", "view = \"right\"\n"].map(|top| of_view(top).unwrap());
    assert!(without_view == left && left.depth != right.depth);
    assert_eq!([left.color[0].x, right.color[0].x], [0.5, 0.75]);
    assert!(left.normal[0].x.abs() < 1e-6 && (right.normal[0].x - 0.6).abs() < 1e-6, "{}", right.normal[0]);
    let error = of_view("view = \"middle\"\n").unwrap_err();
    assert!(error.contains("there is no view \"middle\" in ") && error.ends_with("which has left, right"), "{error}");
}

/// An attribute that the parts of both views have is that of the chosen view. The first part of the file is the left
/// one's.
#[test]
fn attributes_are_those_of_the_view() {
    let folder = Folder::new();
    write_parts(&folder);
    let by_attribute = map("view = \"right\"\n").replace("60.0", "{ attribute = \"lens\" }");
    let opening = read(&folder, &by_attribute, "parts.exr").unwrap().camera.lens.fov_y_radians().unwrap();
    assert!((opening.to_degrees() - 50.0).abs() < 1e-4, "{opening}");
}

/// A file without views is read by a map that asks for a view, since parts that name no view belong to all.
#[test]
fn parts_without_a_view_belong_to_every_view() {
    let folder = Folder::new();
    let channels =
        ["L.Depth.Z", "L.Normal.X", "L.Normal.Y", "L.Normal.Z", "L.rough.V", "L.Light.R", "L.Light.G", "L.Light.B"];
    let values = [2.0, 0.0, 0.0, -1.0, 0.25, 0.5, 0.5, 0.5].map(|v| floats(vec![v; 12]));
    write_exr(&folder.path("plain.exr"), SIZE, vec![Part::new(named_channels(&channels, values))]);
    let with_view = read(&folder, &map("view = \"left\"\n"), "plain.exr").unwrap();
    assert!(with_view == read(&folder, &map(""), "plain.exr").unwrap());
}
