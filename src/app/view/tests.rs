//! The viewer as a window drives it, but without one: events in, images out, under the validation
//! layers.

use super::fly_camera::Motion;
use super::input::Action;
use super::inspect::WalkEnd;
use super::panel::options::reads;
use super::reload::Watch;
use super::state::{Inside, STEPS, Side, State, Tab};
use super::viewer::{Input, Shaders, Viewer};
use crate::app::cli::{CommonOptions, SceneOptions};
use crate::gpu::{DeviceQuery, Gpu, Pixels};
use crate::methods::{METHODS, MethodInfo};
use crate::passes::PathCode;
use crate::passes::look::{Compare, Tone};
use crate::scene::library;
use crate::scene::path::CameraPath;
use crate::study::Globals;
use clap::{Args, FromArgMatches};
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use glam::Vec2;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The picture is 200 pixels wide beside the panel.
const EXTENT: [u32; 2] = [540, 200];
const FORMAT: ash::vk::Format = ash::vk::Format::R8G8B8A8_SRGB;

struct Bench {
    gpu: Gpu,
    viewer: Viewer,
    extent: [u32; 2],
    pixels_per_point: f32,
    time: f64,
}

fn place() -> SceneOptions {
    let command = CommonOptions::augment_args(clap::Command::new("ssct"));
    CommonOptions::from_arg_matches(&command.get_matches_from(["ssct"])).unwrap().place
}

impl Bench {
    fn new() -> Self {
        let gpu = Gpu::open(&DeviceQuery { validation: true, ..DeviceQuery::default() }).unwrap();
        let scene = library::scene("rooms").unwrap();
        let view = scene.view("corridor").unwrap().clone();
        let side = |name: &str| Side::new(crate::methods::find(name).unwrap(), BTreeMap::new());
        let state = State {
            tab: Tab::Tune,
            scene: "rooms".into(),
            camera: Viewer::camera(&scene, &view),
            view,
            moved: false,
            globals: Globals { roughness: Some(0.0), ..Globals::default() },
            sides: [side("ssct"), side("hzct")],
            compare: Compare::One,
            split: 0.5,
            gain: 1.0,
            inside: None,
            tone: Tone::DISPLAY,
            picked: None,
        };
        let viewer = Viewer::new(&gpu, scene, state, place(), FORMAT, Arc::new(|| ())).unwrap();
        Self { gpu, viewer, extent: EXTENT, pixels_per_point: 1.0, time: 0.0 }
    }

    /// A round with events; when the viewer wants the next.
    fn round(&mut self, events: Vec<Event>) -> Option<Duration> {
        self.time += 0.02;
        let [width, height] = self.extent.map(|v| v as f32 / self.pixels_per_point);
        let mut egui = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height))),
            time: Some(self.time),
            events,
            focused: true,
            ..RawInput::default()
        };
        egui.viewports.entry(egui.viewport_id).or_default().native_pixels_per_point = Some(self.pixels_per_point);
        let input = Input { egui, motion: Motion::default(), seconds: 0.02, extent: self.extent };
        let again = self.viewer.update(input).unwrap().again;
        let drawn = self.viewer.draw(|context, _, record| context.once(|frame| record(frame))).unwrap();
        assert!(drawn.is_some(), "after a round there is something to draw");
        again
    }

    /// Rounds until nothing is left to do; how many.
    fn settle(&mut self) -> usize {
        for n in 1..40 {
            if self.round(Vec::new()) != Some(Duration::ZERO) {
                return n;
            }
        }
        panic!("the viewer does not come to rest");
    }

    fn screen(&mut self) -> Pixels {
        self.viewer.read_screen().unwrap()
    }

    fn is_valid(&self, what: &str) {
        self.gpu.check_validation().unwrap_or_else(|e| panic!("{what}: {e}"));
    }

    fn click(&mut self, x: f32, y: f32) {
        let pos = Pos2::new(x, y);
        let button = |pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::default(),
        };
        self.round(vec![Event::PointerMoved(pos)]);
        self.round(vec![button(true)]);
        self.round(vec![button(false)]);
    }

    fn drag(&mut self, from: [f32; 2], to: [f32; 2]) {
        let [from, to] = [from, to].map(|p| Pos2::new(p[0], p[1]));
        let button = |pos, pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::default(),
        };
        self.round(vec![Event::PointerMoved(from)]);
        self.round(vec![button(from, true)]);
        self.round(vec![Event::PointerMoved(from.lerp(to, 0.5))]);
        self.round(vec![Event::PointerMoved(to)]);
        self.round(vec![button(to, false)]);
    }
}

/// Different colours in some columns, of 16 shades a channel.
fn colors(pixels: &Pixels, columns: std::ops::Range<u32>) -> usize {
    let of = |(x, y)| pixels.at(x, y)[..3].iter().map(|v| (v * 15.0).round() as u8).collect::<Vec<_>>();
    let texels = (0..pixels.height).flat_map(|y| columns.clone().map(move |x| (x, y)));
    texels.map(of).collect::<HashSet<_>>().len()
}

#[test]
fn every_part_of_the_panel_opens_and_every_method_is_shown() {
    let mut bench = Bench::new();
    bench.extent = [540, 400];
    let mut panels = HashSet::new();
    for (tab, title) in Tab::SHOWN {
        bench.viewer.state.tab = tab;
        bench.viewer.state.picked = Some([100, 350]);
        bench.settle();
        let screen = bench.screen();
        bench.is_valid(title);
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
            bench.is_valid(info.name);
        }
        bench.viewer.state.compare = Compare::One;
        bench.settle();
        assert!(colors(&bench.screen(), 0..200) > 40, "{}", info.name);
    }
    // The difference of a method from itself is black.
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
    let mut bench = Bench::new();
    bench.viewer.state.tab = Tab::Inside;
    bench.settle();
    let images = bench.viewer.images();
    assert!(images.iter().any(|i| i.name == "hi-z" && i.levels > 5), "{images:?}");
    for image in images {
        for level in [0, 3, image.levels - 1] {
            bench.viewer.state.inside = Some(Inside { name: image.name.into(), level });
            bench.settle();
            bench.is_valid(image.name);
        }
    }
    // Level 3 of the chain is blocks of 8 pixels, of one colour each.
    bench.viewer.state.inside = Some(Inside { name: "hi-z".into(), level: 3 });
    bench.settle();
    let picture = bench.viewer.read_picture().unwrap().unwrap();
    let block = |x: u32, y: u32| (0..8).all(|i| picture.at(8 * x + i, 8 * y) == picture.at(8 * x, 8 * y + i));
    assert!((0..20).all(|i| block(i, i)), "a level's texels are as large as its cells");
    bench.viewer.state.inside = Some(Inside { name: STEPS.into(), level: 0 });
    bench.settle();
    let steps = bench.viewer.read_picture().unwrap().unwrap();
    let most = steps.texels().map(|t| t[0]).fold(0.0, f32::max);
    assert!(most > 10.0 && most < 1025.0 && steps.texels().any(|t| t[0] == 0.0), "{most} steps at most");
    bench.is_valid("steps");
}

#[test]
fn at_rest_nothing_is_submitted_and_a_change_renders_one_frame() {
    let mut bench = Bench::new();
    // Tall enough for both tables of a comparison.
    bench.extent = [540, 900];
    let parts = Tab::SHOWN.map(|(tab, title)| (tab, Compare::One, title));
    for (tab, compare, title) in parts.into_iter().chain([(Tab::Live, Compare::Difference, "Live of two")]) {
        (bench.viewer.state.tab, bench.viewer.state.compare) = (tab, compare);
        bench.viewer.state.choose(1, crate::methods::find("unified").unwrap());
        bench.settle();
        let (frames, submissions) = (bench.viewer.counts()[0], bench.gpu.submissions());
        let egui = RawInput { time: Some(bench.time + 1.0), ..RawInput::default() };
        let input = Input { egui, motion: Motion::default(), seconds: 0.02, extent: bench.extent };
        assert_eq!(bench.viewer.update(input).unwrap().again, None, "{title}: it asks for another drawing");
        assert_eq!(bench.gpu.submissions(), submissions, "{title}: a round without a change submits nothing");
        bench.time += 1.0;
        bench.viewer.act(Action::Roughness(1.0));
        bench.settle();
        assert_eq!(bench.viewer.counts()[0], frames + 1, "{title}: one change, one frame");
    }
}

#[test]
fn a_storm_of_sizes_leaves_the_picture_of_the_last() {
    let mut bench = Bench::new();
    bench.settle();
    let before = bench.screen();
    for extent in [[1, 1], [1000, 3], [3, 700], [421, 2], [641, 479], [2, 2], [420, 419], [1, 333]] {
        bench.extent = extent;
        bench.round(Vec::new());
        bench.is_valid(&format!("{extent:?}"));
        let screen = bench.screen();
        assert_eq!([screen.width, screen.height], extent);
    }
    bench.extent = EXTENT;
    bench.settle();
    let after = bench.screen();
    // The panel shows other numbers.
    let picture = |p: &Pixels| {
        (0..200).flat_map(|y| (0..190).map(move |x| (x, y))).map(|(x, y)| p.at(x, y).to_vec()).collect::<Vec<_>>()
    };
    assert!(picture(&before) == picture(&after));
    bench.is_valid("the last");
}

#[test]
fn larger_points_move_the_picture_and_change_nothing_in_it() {
    let mut bench = Bench::new();
    bench.settle();
    let small = bench.viewer.read_picture().unwrap().unwrap();
    // To another monitor, on which a point is two pixels: the window keeps its size in points.
    (bench.pixels_per_point, bench.extent) = (2.0, EXTENT.map(|v| 2 * v));
    bench.settle();
    bench.is_valid("two pixels a point");
    let large = bench.viewer.read_picture().unwrap().unwrap();
    assert_eq!([large.width, large.height], [2 * small.width, 2 * small.height]);
    bench.drag([100.0, 100.0], [120.0, 100.0]);
    assert!(bench.viewer.state.moved, "the mouse is in points");
    bench.viewer.act(Action::View(2));
    (bench.pixels_per_point, bench.extent) = (1.0, EXTENT);
    bench.settle();
    assert!(bench.viewer.read_picture().unwrap().unwrap() == small, "back, the picture is the same");
    bench.is_valid("back");
}

#[test]
fn rows_are_shown_of_the_options_that_a_method_reads() {
    let mut bench = Bench::new();
    (bench.viewer.state.tab, bench.extent) = (Tab::None, [96, 60]);
    bench.viewer.state.globals.roughness = Some(0.6);
    let another = [
        ("preset", "author"),
        ("iterations", "3"),
        ("start-level", "4"),
        ("cone-samples", "1"),
        ("pixel-step", "7"),
        ("distance-blur", ""),
        ("chain-filter", "gaussian"),
        ("billboard-order", "nearest"),
        ("billboard-occlusion", "depth"),
        ("planar-variant", "target"),
        ("planar-planes", "3"),
        ("resolution-scale", "0.5"),
        ("march", "fixed"),
        ("poster-filter", "volume"),
        ("march-stride", "0.02"),
        ("split", ""),
        ("fade", "off"),
        ("fallback", "environment"),
    ];
    let flags = Side::flags();
    assert!(flags.iter().all(|f| another.iter().any(|(flag, _)| flag == f)), "{flags:?}");
    let frame = |bench: &mut Bench, info, options: &[(&str, &str)]| {
        let options = options.iter().map(|(flag, value)| ((*flag).to_owned(), (*value).to_owned()));
        let side = Side::new(info, options.collect());
        assert_eq!(side.fault, None, "{}", info.name);
        bench.viewer.state.sides[0] = side;
        bench.settle();
        let picture = bench.viewer.read_picture().unwrap().unwrap();
        let images: Vec<_> = bench.viewer.images().into_iter().map(|i| i.name).collect();
        (picture.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), bench.viewer.passes(), images)
    };
    for info in METHODS {
        let (read, not): (Vec<_>, Vec<_>) = another.into_iter().partition(|(flag, _)| reads(info, flag));
        let default = frame(&mut bench, info, &[]);
        assert!(frame(&mut bench, info, &not_refused(info, not)) == default, "{}: what it does not read", info.name);
        for option in read {
            // Here no quad lies behind another, nor behind anything else.
            if info.name == "billboard" {
                continue;
            }
            // Where distances are blurred, the chain is made.
            let blurred = ("distance-blur", "");
            let (with, without) = match (info.name, option.0) {
                ("ssr-fast", "chain-filter") => (vec![blurred, option], frame(&mut bench, info, &[blurred])),
                _ => (vec![option], default.clone()),
            };
            assert!(frame(&mut bench, info, &with) != without, "{}: {option:?} changes nothing", info.name);
        }
    }
    bench.is_valid("options");
}

/// Without the options that a method refuses.
fn not_refused(info: &MethodInfo, options: Vec<(&'static str, &'static str)>) -> Vec<(&'static str, &'static str)> {
    let refused = |flag| !info.is_screen_space() && ["resolution-scale", "fallback"].contains(&flag);
    options.into_iter().filter(|(flag, _)| !refused(*flag)).collect()
}

#[test]
fn the_mouse_turns_the_camera_moves_the_split_and_picks_a_ray() {
    let mut bench = Bench::new();
    bench.viewer.state.compare = Compare::Split;
    bench.settle();
    let camera = bench.viewer.state.camera;
    bench.drag([100.0, 100.0], [50.0, 120.0]);
    assert!((bench.viewer.state.split - 0.25).abs() < 0.01, "{}", bench.viewer.state.split);
    assert_eq!(bench.viewer.state.camera, camera, "moving the line does not turn");
    bench.drag([150.0, 100.0], [170.0, 100.0]);
    let (eye, look_at) = bench.viewer.state.camera.place();
    assert!(bench.viewer.state.moved && eye == camera.place().0 && look_at != camera.place().1);
    bench.viewer.act(Action::View(0));
    assert!(!bench.viewer.state.moved);
    let wheel = |delta| Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, delta),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::default(),
    };
    let speed = bench.viewer.state.camera.speed_m_per_s();
    bench.round(vec![wheel(1.0)]);
    assert!(bench.viewer.state.camera.speed_m_per_s() > speed);

    bench.viewer.state.compare = Compare::One;
    bench.viewer.state.tab = Tab::Ray;
    bench.settle();
    bench.click(60.0, 180.0);
    bench.settle();
    assert_eq!(bench.viewer.state.picked, Some([60, 180]));
    assert_eq!(bench.viewer.ray().map(|r| r.pixel), Some([60, 180]));
    assert!(!bench.viewer.state.moved, "a click does not turn");
    bench.is_valid("the ray");
}

#[test]
fn the_drawn_walk_is_the_shaders() {
    let mut bench = Bench::new();
    bench.viewer.state.tab = Tab::Ray;
    // Where a ray of the thesis passes a cell's corner within rounding, the device may go another way;
    // unified's twin is the same to the bit.
    for (method, least) in [("ssct", 0.99), ("unified", 1.0)] {
        bench.viewer.state.choose(0, crate::methods::find(method).unwrap());
        bench.settle();
        let inspection = bench.viewer.inspection().unwrap();
        let hits = inspection.hits.as_ref().unwrap();
        let (mut rays, mut same, mut steps) = (0, 0, 0);
        for y in (0..hits.height).step_by(7) {
            for x in (0..hits.width).step_by(7) {
                let hit = hits.at(x, y);
                let Some(code) = PathCode::from_channel(hit[3]) else { continue };
                let walk = inspection.pick([x, y]).unwrap().walk;
                let agrees = match (code, walk.as_ref().map(|w| (w.end, w.last()))) {
                    (PathCode::HiZ, Some((WalkEnd::Hit, at))) => {
                        let off = Vec2::new(hit[0] * hits.width as f32, hit[1] * hits.height as f32) - at;
                        off.abs().max_element() <= 1.0
                    }
                    (PathCode::Exhausted, Some((WalkEnd::Exhausted, _)))
                    | (PathCode::None | PathCode::Linear | PathCode::LinearMiss, None) => true,
                    (code, Some((WalkEnd::Left, _))) => !code.is_hit(),
                    _ => false,
                };
                rays += 1;
                same += usize::from(agrees);
                steps += walk.map_or(0, |w| w.cells.len());
            }
        }
        println!("{method}: {same} of {rays} rays end alike, {steps} steps");
        assert!(same as f64 >= least * f64::from(rays) && steps > 2000, "{method}: {same} of {rays}, {steps} steps");
    }
}

#[test]
fn shaders_reload_and_a_broken_one_leaves_the_last_good() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("shaders");
    copy(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders-glsl")), &root);
    let mut watch = Watch::new(&root).unwrap();
    let (sender, changes) = std::sync::mpsc::channel();
    let mut bench = Bench::new();
    bench.viewer.watch(Shaders { folder: "shaders".into(), changes, said: Vec::new() });
    (bench.viewer.state.tab, bench.extent) = (Tab::None, [200, 120]);
    bench.settle();
    let mut edit = |bench: &mut Bench, from: &str, to: &str| {
        let path = root.join("common/composite.frag");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from));
        std::fs::write(&path, text.replace(from, to)).unwrap();
        sender.send(watch.look()).unwrap();
        bench.settle();
        bench.is_valid(to);
        let said = bench.viewer.said_of_shaders();
        let said = said.iter().find(|(name, _)| *name == "common/composite.frag").unwrap().1.clone();
        (said, bench.viewer.read_picture().unwrap().unwrap())
    };
    let before = bench.viewer.read_picture().unwrap().unwrap();
    let (said, red) = edit(&mut bench, "vec4(color, 1.0)", "vec4(1.0, 0.0, 0.0, 1.0)");
    assert_eq!(said, Ok(()));
    assert!(red != before && red.texels().all(|t| t == [1.0, 0.0, 0.0, 1.0]));
    let (said, still) = edit(&mut bench, "vec4(1.0, 0.0, 0.0, 1.0)", "vec4(1.0, nonsense)");
    assert!(said.is_err_and(|m| m.contains("composite.frag") && m.contains("nonsense")));
    assert!(still == red, "the last good one stays in use");
    let (said, again) = edit(&mut bench, "vec4(1.0, nonsense)", "vec4(color, 1.0)");
    assert!(said == Ok(()) && again == before);
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

#[test]
fn key_frames_are_recorded_saved_and_played() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new();
    bench.extent = [32, 20];
    bench.viewer.path.file = folder.path().join("way.toml").display().to_string();
    bench.viewer.path.play_or_stop();
    assert!(bench.viewer.path.message.contains("at least two key frames"), "{}", bench.viewer.path.message);
    for view in 0..3 {
        bench.viewer.act(Action::View(view));
        bench.viewer.act(Action::RecordKey);
    }
    let last = bench.viewer.state.camera.place();
    bench.viewer.path.save();
    let saved = CameraPath::load(Path::new(&bench.viewer.path.file)).unwrap();
    assert_eq!((saved.keys().len(), saved.name.as_str()), (3, "way"));
    assert_eq!(saved.keys(), bench.viewer.path.keys);
    bench.viewer.path.seconds = 0.2;
    bench.viewer.act(Action::View(0));
    let first = bench.viewer.state.camera.place();
    bench.viewer.act(Action::Play);
    bench.round(Vec::new());
    let moving = bench.viewer.state.camera.place();
    assert!(moving != first && moving != last);
    let rounds = bench.settle();
    assert!(rounds > 5, "it goes on by itself, for {rounds} rounds");
    let (eye, look_at) = bench.viewer.state.camera.place();
    assert!(eye.distance(last.0) < 1e-4 && look_at.distance(last.1) < 1e-4);
    bench.viewer.path.keys.clear();
    let file = bench.viewer.path.file.clone();
    bench.viewer.path.load(Path::new(&file)).unwrap();
    assert_eq!(bench.viewer.path.keys, saved.keys());
}

#[test]
fn another_scene_is_loaded_and_the_first_comes_back() {
    let mut bench = Bench::new();
    bench.extent = [64, 40];
    bench.settle();
    let first = bench.viewer.read_picture().unwrap().unwrap();
    bench.viewer.state.scene = "atrium".into();
    bench.settle();
    assert!(bench.viewer.title().starts_with("atrium"), "{}", bench.viewer.title());
    assert!(bench.viewer.read_picture().unwrap().unwrap() != first);
    bench.viewer.state.scene = "rooms".into();
    bench.settle();
    bench.viewer.act(Action::View(2));
    bench.settle();
    assert!(bench.viewer.read_picture().unwrap().unwrap() == first, "{}", bench.viewer.title());
    bench.is_valid("scenes");
}
