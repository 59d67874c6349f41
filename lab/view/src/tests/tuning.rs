//! Tests of everything that a user changes: options, the camera, the picked ray, shaders, key frames and captures.

use super::super::cubes::Cross;
use super::super::input::Action;
use super::super::reload::ShaderWatch;
use super::super::state::{InnerImage, Side, Tab};
use super::super::viewer::Shaders;
use super::{TestViewer, copied_shaders};
use egui::{Event, Modifiers, vec2};
use glam::Vec2;
use ssct::methods::{METHODS, MethodInfo, parameters};
use ssct::passes::PathCode;
use ssct::passes::look::Compare;
use ssct_lab::study::inspect::WalkEnd;
use ssct_scenes::path;
use std::path::Path;

/// Each option that a method reads changes its frame: its picture, its passes or its images. All others together change
/// nothing. The window shows a row for each option that a method reads, so that a row without effect would be found.
#[test]
fn an_option_changes_a_frame_exactly_if_the_method_reads_it() {
    let mut bench = TestViewer::new();
    (bench.viewer.state.tab, bench.extent) = (Tab::None, [96, 60]);
    bench.viewer.state.globals.roughness = Some(0.6);
    // For each option a value that differs from its default.
    let values = [
        ("iterations", "3"),
        ("start-level", "4"),
        ("cross-offset", "4"),
        ("direction-tolerance", "1"),
        ("march-stride", "0.02"),
        ("march-steps", "2"),
        ("march-increase", "4"),
        ("search-steps", "0"),
        ("search-decrease", "1"),
        ("search-first", "8"),
        ("search-tolerance", "1"),
        ("cone-samples", "1"),
        ("cone-lengthened", "on"),
        ("cone-angle", "interpolated"),
        ("cone-alpha-min", "50"),
        ("cone-alpha-max", "80"),
        ("cone-xi", "0.5"),
        ("cone-mirror-alpha", "1"),
        ("hi-z-maximum", "on"),
        ("camera-fade", "0"),
        ("dda-stride", "16"),
        ("dda-thickness", "0.01"),
        ("dda-jitter", "on"),
        ("dda-refine", "off"),
        ("dda-steps", "2"),
        ("dda-distance", "0.5"),
        ("stochastic-rays", "4"),
        ("stochastic-gathered", "1"),
        ("stochastic-radius", "9"),
        ("stochastic-part", "0.5"),
        ("stochastic-walk", "thesis"),
        ("pixel-step", "7"),
        ("distance-blur", "on"),
        ("chain-filter", "gaussian"),
        ("chain-mask", "surface"),
        ("chain-mask-tolerance", "0.9"),
        ("billboard-glow", "1"),
        ("billboard-glow-width", "2"),
        ("billboard-order", "nearest"),
        ("billboard-occlusion", "depth"),
        ("planar-variant", "target"),
        ("planar-planes", "3"),
        ("resolution-scale", "0.5"),
        ("bounces", "2"),
        ("march", "fixed"),
        ("poster-filter", "volume"),
        ("edge-retries", "9"),
        ("uniform-steps", "3"),
        ("uniform-stride-min", "0.2"),
        ("uniform-stride-max", "0.5"),
        ("uniform-back", "1"),
        ("mask-filter", "hardware"),
        ("depth-sampling", "nearest"),
        ("spreading-factor", "9"),
        ("split", "on"),
        ("fade", "off"),
        ("fade-start", "0.1"),
        ("fade-end", "1.9"),
        ("fallback", "environment"),
        ("oracle", "2"),
        ("captures", "1"),
        ("capture-side", "128"),
        ("captures-per-frame", "1"),
        ("history", "on"),
        ("edge-tolerance", "0.9"),
        ("billboard-blur", "roughness"),
        ("ibr-depth", "2"),
        ("ibr-side", "8"),
        ("trace-normals", "up"),
        ("bump-after", "0.5"),
        ("history-frames", "3"),
        ("history-deviations", "0.1"),
        ("history-stage", "compute"),
        ("layers", "2"),
        ("layer-separation", "3"),
        ("layer-thickness", "20"),
        ("beyond", "none"),
        ("tracer", "tree"),
        ("own-rays", "16"),
        ("first", "triangles"),
        ("hit-color", "screen"),
        ("stage", "compute"),
        ("trace-stage", "compute"),
        ("resolve-stage", "compute"),
    ];
    let flags: Vec<String> = parameters().iter().map(|(p, _)| p.typed_name()).collect();
    assert!(flags.iter().all(|flag| values.iter().any(|(name, _)| name == flag)), "{flags:?}");
    // Renders a method with options. Returns the bits of its picture, its passes and the names of its images.
    let frame = |bench: &mut TestViewer, info, options: &[(&str, &str)]| {
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
        let (read, unread): (Vec<_>, Vec<_>) =
            values.into_iter().partition(|(name, _)| info.read_parameters().iter().any(|p| p.typed_name() == *name));
        let default = frame(&mut bench, info, &[]);
        let (default_picture, default_passes, default_images) = &default;
        let (picture, passes, images) = frame(&mut bench, info, &not_refused(info, unread));
        let difference = rmse(&picture, default_picture);
        assert!((&passes, &images) == (default_passes, default_images), "{}: what it does not read", info.name);
        // Rays are listed in the order in which threads find them. The last bit of a ray's colour in captures may
        // depend on its neighbours in the list.
        assert!(if info.takes_captures { difference < 1e-4 } else { difference == 0.0 }, "{}: {difference}", info.name);
        for option in read {
            // Some options cannot show in this picture. No ray of a mirror meets a quad here, and no quad is behind
            // anything, so that the methods of quads are left out. Nothing reads the maximum of the Hi-Z. Both stages
            // of a shader make the same image, and so do both tracers. Own rays are for lobes among triangles, and
            // tests/suite/own_rays.rs tests them. The option `first` matters only where rays go beyond the screen.
            let shows_nothing = [
                "hi-z-maximum",
                "first",
                "tracer",
                "own-rays",
                "stage",
                "trace-stage",
                "resolve-stage",
                "history-stage",
            ];
            let (flag, _) = option;
            if ["billboard", "ibr"].contains(&info.name) || shows_nothing.contains(&flag) {
                continue;
            }
            // While nothing moves, the frames of a history differ only for `stochastic`, whose rays are random.
            if ["history-frames", "history-deviations"].contains(&flag) && info.name != "stochastic" {
                continue;
            }
            // Some options show only together with another one, which both frames then have. `ssr-fast` makes the
            // colour chain only if distances are blurred.
            let (blurred, captured, history) = (("distance-blur", "on"), ("captures", "1"), ("history", "on"));
            let (changed_options, unchanged_frame) = match (info.name, flag) {
                ("ssr-fast", "chain-filter") => (vec![blurred, option], frame(&mut bench, info, &[blurred])),
                (_, "cone-alpha-min" | "cone-alpha-max" | "cone-mirror-alpha") => {
                    let interpolated = ("cone-angle", "interpolated");
                    (vec![interpolated, option], frame(&mut bench, info, &[interpolated]))
                }
                (_, "edge-tolerance") => {
                    let edges = ("poster-filter", "edge-aware");
                    (vec![edges, option], frame(&mut bench, info, &[edges]))
                }
                (_, "chain-mask-tolerance") => {
                    let masked = ("chain-mask", "surface");
                    (vec![masked, option], frame(&mut bench, info, &[masked]))
                }
                (_, "bump-after") => {
                    let up = ("trace-normals", "up");
                    (vec![up, option], frame(&mut bench, info, &[up]))
                }
                (_, "history-frames" | "history-deviations") => {
                    (vec![history, option], frame(&mut bench, info, &[history]))
                }
                (_, "layer-separation" | "layer-thickness") => {
                    let layers = ("layers", "2");
                    (vec![layers, option], frame(&mut bench, info, &[layers]))
                }
                // Reflections fade at the screen's border, and follow the oracle, only if rays end on the screen.
                ("unified", "fade" | "fade-start" | "fade-end" | "oracle") => {
                    let alone = ("beyond", "none");
                    (vec![alone, option], frame(&mut bench, info, &[alone]))
                }
                // These options are about captures.
                ("unified", "capture-side" | "captures-per-frame") => {
                    (vec![captured, option], frame(&mut bench, info, &[captured]))
                }
                _ => (vec![option], default.clone()),
            };
            let changed_frame = frame(&mut bench, info, &changed_options);
            assert!(changed_frame != unchanged_frame, "{}: {option:?} changes nothing", info.name);
        }
    }
    bench.assert_valid("options");
}

/// Returns the root mean square difference of two pictures, which are given as the bits of their floats; infinite if
/// their sizes differ.
fn rmse(a: &[u32], b: &[u32]) -> f64 {
    let squared = |(a, b): (&u32, &u32)| f64::from(f32::from_bits(*a) - f32::from_bits(*b)).powi(2);
    if a.len() == b.len() { (a.iter().zip(b).map(squared).sum::<f64>() / a.len() as f64).sqrt() } else { f64::INFINITY }
}

/// Returns the options (flag, value) without those that a method refuses.
fn not_refused(info: &MethodInfo, options: Vec<(&'static str, &'static str)>) -> Vec<(&'static str, &'static str)> {
    let refused = |flag| {
        !info.is_screen_space()
            && ["resolution-scale", "fallback", "trace-normals", "bump-after", "bounces"].contains(&flag)
    };
    options.into_iter().filter(|(flag, _)| !refused(*flag)).collect()
}

#[test]
fn the_mouse_turns_the_camera_moves_the_split_and_picks_a_ray() {
    let mut bench = TestViewer::new();
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
    assert_eq!(bench.viewer.ray.as_ref().map(|r| r.pixel), Some([60, 180]));
    assert!(!bench.viewer.state.moved, "a click does not turn");
    let report = bench.viewer.pixel.as_ref().unwrap().clone();
    assert_eq!((report.pixel, &report.method[..]), ([60, 180], "ssct"));
    assert!(!report.why.is_empty() && report.surface.mesh.is_some(), "{report:?}");
    bench.click(100.0, 40.0);
    bench.settle();
    assert_eq!(bench.viewer.pixel.as_ref().unwrap().pixel, [100, 40], "another pixel is explained");
    bench.viewer.act(Action::Roughness(1.0));
    bench.round(Vec::new());
    assert!(bench.viewer.pixel.is_none(), "nothing is said of a frame that changed");
    bench.assert_valid("the ray");
}

#[test]
fn rays_of_the_drawn_walk_end_where_those_of_the_shader_end() {
    let mut bench = TestViewer::new();
    bench.viewer.state.tab = Tab::Ray;
    // If a ray of the thesis's method passes a cell's corner within rounding, the device may enter another cell than
    // the twin. The twin of `unified` agrees to the bit.
    for (method, least_share) in [("ssct", 0.99), ("unified", 1.0)] {
        let options = [("beyond".to_owned(), "none".to_owned())];
        let options = if method == "unified" { options.to_vec() } else { Vec::new() };
        bench.viewer.state.sides[0] = Side::new(ssct::methods::find(method).unwrap(), options.into_iter().collect());
        bench.settle();
        let inspection = bench.viewer.inspection().unwrap();
        let hits = inspection.hits.as_ref().unwrap();
        let (mut rays, mut alike, mut steps) = (0, 0, 0);
        for y in (0..hits.height).step_by(7) {
            for x in (0..hits.width).step_by(7) {
                let hit = hits.texel(x, y);
                let Some(code) = PathCode::from_channel(hit[3]) else { continue };
                let walk = inspection.pick([x, y]).unwrap().walk;
                let agrees = match (code, walk.as_ref().map(|w| (w.end, w.last()))) {
                    (PathCode::HiZ, Some((WalkEnd::Hit, end))) => {
                        let distance_px = Vec2::new(hit[0] * hits.width as f32, hit[1] * hits.height as f32) - end;
                        distance_px.abs().max_element() <= 1.0
                    }
                    (PathCode::Exhausted, Some((WalkEnd::Exhausted, _)))
                    | (PathCode::None | PathCode::Linear | PathCode::LinearMiss, None) => true,
                    (code, Some((WalkEnd::Left | WalkEnd::Behind, _))) => !code.is_hit(),
                    _ => false,
                };
                rays += 1;
                alike += usize::from(agrees);
                steps += walk.map_or(0, |w| w.cells.len());
            }
        }
        println!("{method}: {alike} of {rays} rays end alike, {steps} steps");
        assert!(
            alike as f64 >= least_share * f64::from(rays) && steps > 2000,
            "{method}: {alike} of {rays}, {steps} steps"
        );
    }
}

#[test]
fn shaders_reload_and_a_broken_one_leaves_the_last_good() {
    let folder = tempfile::tempdir().unwrap();
    let root = copied_shaders(folder.path());
    let mut watch = ShaderWatch::new(&root).unwrap();
    let (sender, changes) = std::sync::mpsc::channel();
    let mut bench = TestViewer::new();
    bench.viewer.watch(Shaders { folder: "shaders".into(), changes, statuses: Vec::new() });
    (bench.viewer.state.tab, bench.extent) = (Tab::None, [200, 120]);
    bench.settle();
    // Replaces text in the shader. Returns the shader's status and the picture.
    let mut edit = |bench: &mut TestViewer, from: &str, to: &str| {
        let path = root.join("common/composite.frag");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from));
        std::fs::write(&path, text.replace(from, to)).unwrap();
        sender.send(watch.scan()).unwrap();
        bench.settle();
        bench.assert_valid(to);
        let status = bench.viewer.shader_statuses();
        let status = status.iter().find(|(name, _)| *name == "common/composite.frag").unwrap().1.clone();
        (status, bench.viewer.read_picture().unwrap().unwrap())
    };
    let before = bench.viewer.read_picture().unwrap().unwrap();
    let (status, red) = edit(&mut bench, "vec4(color, 1.0)", "vec4(1.0, 0.0, 0.0, 1.0)");
    assert_eq!(status, Ok(()));
    assert!(red != before && red.texels().all(|t| t == [1.0, 0.0, 0.0, 1.0]));
    let (status, broken) = edit(&mut bench, "vec4(1.0, 0.0, 0.0, 1.0)", "vec4(1.0, nonsense)");
    assert!(status.is_err_and(|m| m.contains("composite.frag") && m.contains("nonsense")));
    assert!(broken == red, "the last good one stays in use");
    let (status, repaired) = edit(&mut bench, "vec4(1.0, nonsense)", "vec4(color, 1.0)");
    assert!(status == Ok(()) && repaired == before);
}

#[test]
fn key_frames_are_recorded_saved_and_played() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = TestViewer::new();
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
    let saved = path::load(Path::new(&bench.viewer.path.file)).unwrap();
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
fn captures_are_put_where_the_eye_is_moved_and_removed() {
    let mut bench = TestViewer::new();
    bench.viewer.state.tab = Tab::Captures;
    bench.settle();
    bench.viewer.act(Action::MoveCapture);
    let text = &bench.viewer.captures.message;
    assert!(text.contains("no capture to move") && text.contains("ssct follows no rays in captures"), "{text}");
    bench.viewer.captures.forget();
    bench.turn_captures_on("1");
    bench.settle();
    let placed = bench.viewer.captures_shown();
    let before = bench.viewer.read_picture().unwrap().unwrap();
    assert_eq!(placed.len(), 1);
    bench.viewer.act(Action::AddCapture);
    bench.settle();
    let eye = bench.viewer.state.camera.place().0;
    let places = |bench: &TestViewer| bench.viewer.captures_shown().iter().map(|c| c.position).collect::<Vec<_>>();
    assert_eq!(places(&bench), [placed[0].position, eye], "the captures that rays go on in");
    assert_eq!(bench.viewer.state.sides[0].options["captures"], "auto");
    bench.viewer.state.put_camera((placed[0].position, eye));
    bench.viewer.act(Action::MoveCapture);
    bench.settle();
    assert_eq!(places(&bench), [placed[0].position; 2]);
    bench.viewer.act(Action::RemoveCapture);
    bench.viewer.act(Action::View(2));
    bench.settle();
    assert_eq!(places(&bench), [placed[0].position]);
    assert!(bench.viewer.read_picture().unwrap().unwrap() == before, "as at the beginning");
    let folder = tempfile::tempdir().unwrap();
    bench.viewer.captures.file = folder.path().join("c.toml").display().to_string();
    bench.viewer.captures.save(&placed);
    // The scene's file is right-handed.
    let mut in_file = bench.viewer.captures_shown();
    in_file.iter_mut().for_each(|c| c.position.z = -c.position.z);
    let saved = ssct_scenes::capture_file::encode_tables(&in_file);
    assert_eq!(std::fs::read_to_string(folder.path().join("c.toml")).unwrap(), saved);
    bench.assert_valid("captures");
}

#[test]
fn a_picked_ray_goes_on_to_where_a_capture_shows_its_end() {
    let mut bench = TestViewer::new();
    bench.turn_captures_on("1");
    bench.viewer.state.tab = Tab::Ray;
    bench.settle();
    let inspection = bench.viewer.inspection().unwrap();
    let eye = inspection.gbuffer.camera.eye();
    let [width, height] = [inspection.gbuffer.width, inspection.gbuffer.height];
    let pixels = (0..height).step_by(6).flat_map(|y| (0..width).step_by(6).map(move |x| [x, y]));
    let rays: Vec<_> = pixels.filter_map(|p| inspection.pick(p)).collect();
    let hits: Vec<_> =
        rays.iter().filter_map(|r| Some((r.pixel, r.in_world.filter(|b| b.capture == Some(0))?))).collect();
    assert!(hits.len() > 20, "{} rays hit in the capture", hits.len());
    for ray in rays.iter().filter(|r| r.method.is_some_and(|(code, _)| code.is_hit())) {
        let path = ray.in_world.unwrap();
        assert!(path.end == path.lost && ray.beyond_on_screen.is_none(), "a hit on the screen is an end: {path:?}");
    }
    let place = bench.viewer.captures_shown()[0];
    for (pixel, beyond) in &hits {
        // The screen loses the ray somewhere between the ray's beginning and its end, which lie on one line.
        let (to_end, to_lost) = (beyond.end - beyond.begin, beyond.lost - beyond.begin);
        let share = to_lost.dot(to_end) / to_end.length_squared();
        let off_line = (to_lost - share * to_end).length();
        assert!((-0.01..=1.01).contains(&share) && off_line < 0.01 * to_end.length() + 0.01, "{pixel:?}: {beyond:?}");
        assert!(beyond.end.distance(eye) < 100.0 && beyond.points().first() == Some(&beyond.begin));
    }
    bench.viewer.state.picked = Some(hits[0].0);
    bench.viewer.state.inside = Some(InnerImage { name: "capture-1-depth".into(), level: 0 });
    bench.settle();
    bench.assert_valid("the ray in a capture");
    // At the place in the capture's picture that shows the end of a ray, the depth must be that of the end.
    let picture = bench.viewer.read_picture().unwrap().unwrap();
    let cross = Cross::new([picture.width, picture.height]);
    let clip = ssct_scenes::capture::face_camera(place.position, 4, place.near_m).view_to_clip_reversed();
    let mut agreeing = 0;
    for (_, beyond) in &hits {
        let from = beyond.end - place.position;
        let (_, position) = cross.face_and_point(from);
        let shown = picture.texel(position.x as u32, position.y as u32)[0];
        let z = from.abs().max_element();
        let expected = clip.project_point3(glam::Vec3::new(0.0, 0.0, z)).z;
        agreeing += usize::from((shown / expected - 1.0).abs() < 0.1);
    }
    assert!(agreeing * 10 >= hits.len() * 9, "{agreeing} of {} ends lie where the capture has them", hits.len());
    bench.viewer.state.inside = None;
    bench.settle();
    let with_ray = bench.screen();
    bench.viewer.state.picked = Some([0, 0]);
    bench.settle();
    assert!(bench.screen() != with_ray, "the ray is drawn");
    bench.assert_valid("the ray beyond the screen");
}
