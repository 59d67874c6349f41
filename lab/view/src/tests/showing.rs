//! Tests of the screen: panel, methods and intermediates are shown at any size, and nothing is done if nothing changes.

use super::super::fly_camera::FlyMotion;
use super::super::input::Action;
use super::super::state::{InnerImage, STEPS, Tab};
use super::super::viewer::ViewerInput;
use super::{EXTENT, TestViewer};
use egui::RawInput;
use ssct::gpu::Pixels;
use ssct::methods::METHODS;
use ssct::passes::look::Compare;
use std::collections::HashSet;

/// Returns the number of different colours in a range of columns, with 16 levels per channel.
fn colors(pixels: &Pixels, columns: std::ops::Range<u32>) -> usize {
    let color = |(x, y)| pixels.texel(x, y)[..3].iter().map(|v| (v * 15.0).round() as u8).collect::<Vec<_>>();
    let texels = (0..pixels.height).flat_map(|y| columns.clone().map(move |x| (x, y)));
    texels.map(color).collect::<HashSet<_>>().len()
}

#[test]
fn every_part_of_the_panel_opens_and_every_method_is_shown() {
    let mut bench = TestViewer::new();
    bench.extent = [540, 400];
    let mut panels = HashSet::new();
    for (tab, title) in Tab::SHOWN {
        bench.viewer.state.tab = tab;
        bench.viewer.state.picked = Some([100, 350]);
        bench.settle();
        let screen = bench.screen();
        bench.assert_valid(title);
        assert!(colors(&screen, 0..200) > 40, "{title}: the picture has {} colours", colors(&screen, 0..200));
        assert!(colors(&screen, 220..540) > 8, "{title}: the panel is empty");
        let bits = screen.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(panels.insert(bits), "{title} looks like another part");
    }
    bench.extent = EXTENT;
    for info in METHODS {
        bench.viewer.state.choose(0, info);
        for compare in [Compare::One, Compare::Split, Compare::Difference] {
            bench.viewer.state.compare = compare;
            bench.viewer.state.tab = if compare == Compare::One { Tab::Live } else { Tab::Tune };
            bench.settle();
            bench.assert_valid(info.name);
        }
        bench.viewer.state.compare = Compare::One;
        bench.settle();
        assert!(colors(&bench.screen(), 0..200) > 40, "{}", info.name);
    }
    // The difference of a method from itself must be black.
    bench.viewer.state.choose(1, &METHODS[0]);
    bench.viewer.state.choose(0, &METHODS[0]);
    (bench.viewer.state.compare, bench.viewer.state.tab) = (Compare::Difference, Tab::None);
    bench.settle();
    assert_eq!(colors(&bench.screen(), 0..540), 1);
    drop(bench.viewer);
    bench.gpu.check_validation().unwrap();
}

#[test]
fn every_intermediate_is_shown_at_every_level_and_a_range_fits() {
    let mut bench = TestViewer::new();
    bench.viewer.state.tab = Tab::Inside;
    bench.settle();
    let images = bench.viewer.images();
    assert!(images.iter().any(|i| i.name == "hi-z" && i.levels > 5), "{images:?}");
    for image in images {
        for level in [0, 3, image.levels - 1] {
            bench.viewer.state.inside = Some(InnerImage { name: image.name.clone(), level });
            bench.settle();
            bench.assert_valid(&image.name);
        }
    }
    // Level 3 of the chain consists of blocks of 8 pixels with one colour each.
    bench.viewer.state.inside = Some(InnerImage { name: "hi-z".into(), level: 3 });
    bench.settle();
    let picture = bench.viewer.read_picture().unwrap().unwrap();
    let block = |x: u32, y: u32| (0..8).all(|i| picture.texel(8 * x + i, 8 * y) == picture.texel(8 * x, 8 * y + i));
    assert!((0..20).all(|i| block(i, i)), "texels of a level must be as large as its cells");
    bench.viewer.state.inside = Some(InnerImage { name: STEPS.into(), level: 0 });
    bench.settle();
    let steps = bench.viewer.read_picture().unwrap().unwrap();
    let most = steps.texels().map(|t| t[0]).fold(0.0, f32::max);
    assert!(most > 10.0 && most < 1025.0 && steps.texels().any(|t| t[0] == 0.0), "{most} steps at most");
    bench.assert_valid("steps");
}

#[test]
fn captures_are_shown_as_crosses_at_every_level() {
    let mut bench = TestViewer::new();
    bench.turn_captures_on("1");
    bench.viewer.state.tab = Tab::Inside;
    bench.settle();
    let images = bench.viewer.images();
    let mut seen = HashSet::new();
    for (name, levels) in [("capture-1-color", 8), ("capture-1-depth", 1), ("capture-1-normal", 1)] {
        let image = images.iter().find(|i| i.name == name).unwrap_or_else(|| panic!("{name}: {images:?}"));
        assert_eq!((image.levels, image.extent), (levels, [128, 128]));
        for level in HashSet::from([0, levels - 1]) {
            bench.viewer.state.inside = Some(InnerImage { name: name.into(), level });
            bench.settle();
            bench.assert_valid(name);
            let picture = bench.viewer.read_picture().unwrap().unwrap();
            // The picture is 200 pixels wide and high: faces have 50 pixels a side, and the cross begins at row 25.
            assert_eq!([picture.width, picture.height], [200, 200]);
            let pixel = |x, y| &picture.texel(x, y)[..3];
            assert!([(0, 30), (0, 0), (199, 199), (120, 40)].iter().all(|(x, y)| pixel(*x, *y) == [0.0; 3]), "{name}");
            assert!(
                [(75, 100), (175, 100), (75, 50), (75, 150)].iter().all(|(x, y)| pixel(*x, *y) != [0.0; 3]),
                "{name}"
            );
            assert!(seen.insert(picture.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>()), "{name}/{level}");
        }
    }
    bench.viewer.state.inside = None;
    bench.settle();
    let finished = bench.viewer.read_picture().unwrap().unwrap();
    assert!(seen.insert(finished.values.iter().map(|v| v.to_bits()).collect()));
}

#[test]
fn at_rest_nothing_is_submitted_and_a_change_renders_one_frame() {
    let mut bench = TestViewer::new();
    // The window is tall enough for both tables of a comparison.
    bench.extent = [540, 900];
    let parts = Tab::SHOWN.map(|(tab, title)| (tab, Compare::One, title));
    for (tab, compare, title) in parts.into_iter().chain([(Tab::Live, Compare::Difference, "Live of two")]) {
        (bench.viewer.state.tab, bench.viewer.state.compare) = (tab, compare);
        bench.viewer.state.choose(1, ssct::methods::find("unified").unwrap());
        bench.settle();
        let (frames, submissions) = (bench.viewer.counts()[0], bench.gpu.submissions());
        let egui = RawInput { time: Some(bench.time + 1.0), ..RawInput::default() };
        let input = ViewerInput { egui, motion: FlyMotion::default(), seconds: 0.02, extent: bench.extent };
        assert_eq!(bench.viewer.update(input).unwrap().again, None, "{title}: it must not ask for another drawing");
        assert_eq!(bench.gpu.submissions(), submissions, "{title}: a round without a change must submit nothing");
        bench.time += 1.0;
        bench.viewer.act(Action::Roughness(1.0));
        bench.settle();
        assert_eq!(bench.viewer.counts()[0], frames + 1, "{title}: one change, one frame");
    }
}

#[test]
fn a_storm_of_sizes_leaves_the_picture_of_the_last() {
    let mut bench = TestViewer::new();
    bench.settle();
    let before = bench.screen();
    for extent in [[1, 1], [1000, 3], [3, 700], [421, 2], [641, 479], [2, 2], [420, 419], [1, 333]] {
        bench.extent = extent;
        bench.round(Vec::new());
        bench.assert_valid(&format!("{extent:?}"));
        let screen = bench.screen();
        assert_eq!([screen.width, screen.height], extent);
    }
    bench.extent = EXTENT;
    bench.settle();
    let after = bench.screen();
    // The panel shows other numbers, so only the pictures are compared.
    let picture = |p: &Pixels| {
        (0..200).flat_map(|y| (0..190).map(move |x| (x, y))).map(|(x, y)| p.texel(x, y).to_vec()).collect::<Vec<_>>()
    };
    assert!(picture(&before) == picture(&after));
    bench.assert_valid("the last");
}

#[test]
fn larger_points_move_the_picture_and_change_nothing_in_it() {
    let mut bench = TestViewer::new();
    bench.settle();
    let small = bench.viewer.read_picture().unwrap().unwrap();
    // On another monitor a point has two pixels, and the window keeps its size in points.
    (bench.pixels_per_point, bench.extent) = (2.0, EXTENT.map(|v| 2 * v));
    bench.settle();
    bench.assert_valid("two pixels a point");
    let large = bench.viewer.read_picture().unwrap().unwrap();
    assert_eq!([large.width, large.height], [2 * small.width, 2 * small.height]);
    bench.drag([100.0, 100.0], [120.0, 100.0]);
    assert!(bench.viewer.state.moved, "the mouse is in points");
    bench.viewer.act(Action::View(2));
    (bench.pixels_per_point, bench.extent) = (1.0, EXTENT);
    bench.settle();
    assert!(bench.viewer.read_picture().unwrap().unwrap() == small, "back, the picture is the same");
    bench.assert_valid("back");
}

#[test]
fn another_scene_is_loaded_and_the_first_comes_back() {
    let mut bench = TestViewer::new();
    bench.extent = [64, 40];
    bench.settle();
    let first = bench.viewer.read_picture().unwrap().unwrap();
    bench.viewer.state.scene = "atrium".into();
    bench.settle();
    assert!(bench.viewer.title().starts_with("atrium"), "{}", bench.viewer.title());
    assert!(bench.viewer.read_picture().unwrap().unwrap() != first);
    bench.viewer.state.scene = "rooms".into();
    bench.settle();
    // A loaded scene shows its first view; the test began with the view `corridor`, whose index is 2.
    bench.viewer.act(Action::View(2));
    bench.settle();
    assert!(bench.viewer.read_picture().unwrap().unwrap() == first, "{}", bench.viewer.title());
    // Planes that suit the first scene alone are not those of another one.
    bench.viewer.first_place.near = Some(1e9);
    bench.viewer.state.scene = "street".into();
    bench.settle();
    assert!(bench.viewer.title().starts_with("street"), "{:?}", bench.viewer.scene_fault);
    let street = bench.viewer.read_picture().unwrap().unwrap();
    bench.viewer.state.scene = "nowhere.obj".into();
    bench.settle();
    let fault = bench.viewer.scene_fault.clone().unwrap();
    assert!(fault.contains("nowhere.obj") && bench.viewer.state.scene == "street", "{fault}");
    assert!(bench.viewer.read_picture().unwrap().unwrap() == street, "the shown scene stays");
    bench.assert_valid("scenes");
}
