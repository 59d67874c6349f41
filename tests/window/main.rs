//! Tests the window as a user opens it: under an X server without a screen, by arguments and by mouse and keys
//! (xdotool), and without any display. Tests without a window system are in `lab/view/src/tests`.

#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../common/hang.rs"]
mod hang;

use hang::wait_until;
use ssct::gpu::{DeviceQuery, Gpu, Pixels};
use ssct::methods::{METHODS, Setup, Wants};
use ssct_lab::report::images;
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::library;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// Size of the picture as the option `--size` takes it.
const SIZE: &str = "320x200";
/// Size of the picture in pixels, equal to [`SIZE`].
const EXTENT: [u32; 2] = [320, 200];

/// Runs the window on a built-in scene until it ends, without a display unless one is given. Returns its status and
/// output.
fn view(folder: &Path, display: Option<&str>, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct-view"));
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    command.envs(display.map(|d| ("DISPLAY", d))).current_dir(folder).args(arguments);
    command.args(["--scene", "rooms", "--size", SIZE]);
    command.output().unwrap()
}

/// Checks that the window's program failed with exit status 1 and one sentence, and returns this sentence.
fn refusal(output: &Output) -> String {
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(output.stdout.is_empty());
    message
}

/// An X server for one test, which ends with the test.
struct Xvfb {
    server: Child,
    display: String,
}

impl Xvfb {
    /// Starts an X server. Returns `None`, and prints a line that names the skipped test, if Xvfb is not installed.
    fn start(test: &str) -> Option<Self> {
        let started = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = started else {
            eprintln!("skipped: {test}: there is no Xvfb on the PATH; scripts/setup.sh installs it");
            return None;
        };
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        Some(Self { server, display: format!(":{}", number.trim()) })
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Returns the values of a PNG, 0 to 255, or the bits of an EXR's floats. The files themselves may differ, since an
/// EXR's chunks are written in the order in which threads finish them.
fn values(path: &Path) -> Vec<u32> {
    if path.extension().is_some_and(|e| e == "png") {
        return image::open(path).unwrap().to_rgb8().iter().map(|v| u32::from(*v)).collect();
    }
    let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    let channels = image.layer_data.channel_data.list;
    channels.iter().flat_map(|c| c.sample_data.values_as_f32().map(f32::to_bits)).collect()
}

/// Renders the view and the method that the window begins with, as `ssct render` does.
fn composite() -> Pixels {
    let gpu = Gpu::open(&DeviceQuery { validation: true, ..DeviceQuery::default() }).unwrap();
    let scene = library::scene("rooms").unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let (view, globals) = (&scene.views[0], Globals::default());
    let (camera, materials) = (view.camera(&scene, EXTENT), globals.materials(&scene, view));
    let shot = Shot::new(&mut stage, &METHODS[0], &Setup::new(EXTENT), Wants::REFLECTION, camera, materials).unwrap();
    assert_eq!(METHODS[0].name, "ssct");
    render(&mut stage, &shot, false).unwrap().composite
}

/// A screenshot of the window has the pixels of `ssct render`, in an .exr to the bit and in a .png within one step of 8
/// bits. The window could show another frame, or its panel over the picture.
#[test]
fn what_the_window_shows_is_what_render_renders() {
    let Some(server) = Xvfb::start("what_the_window_shows_is_what_render_renders") else { return };
    let folder = tempfile::tempdir().unwrap();
    // An open panel is no part of the .exr. The device rounds the colours of a .png, which may differ by one step.
    let composite = composite();
    for (name, panel, tolerance) in [("frame.png", "none", 1), ("frame.exr", "tune", 0)] {
        let shot = ["--validation", "--frames", "3", "--panel", panel, "--screenshot"];
        let shown = view(folder.path(), Some(&server.display), &[&shot[..], &[&format!("view-{name}")]].concat());
        assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
        images::write_image(&folder.path().join(format!("render-{name}")), &composite).unwrap();
        let [viewed, rendered] =
            ["view", "render"].map(|program| values(&folder.path().join(format!("{program}-{name}"))));
        assert!(viewed.len() >= 320 * 200 * 3 && viewed.len() == rendered.len(), "{name}: the sizes differ");
        assert!(viewed.iter().zip(&rendered).all(|(a, b)| a.abs_diff(*b) <= tolerance), "{name}: the images differ");
    }
}

/// Returns the record that the option `--json` prints.
fn record(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()[0].take()
}

/// Returns the number of different colours in a range of columns of an image, with each channel rounded to 16 shades.
fn colors(image: &image::RgbImage, columns: std::ops::Range<u32>) -> usize {
    let texels = image.enumerate_pixels().filter(|(x, ..)| columns.contains(x));
    texels.map(|(.., p)| p.0.map(|v| v / 16)).collect::<std::collections::HashSet<_>>().len()
}

/// With each part of the panel, the picture, the panel and the splitting line are in the screenshot, and an idle window
/// submits no work to the GPU. A panel that asks for frames all the time would keep the GPU busy.
#[test]
fn every_part_of_the_panel_opens_beside_the_picture_and_an_idle_window_submits_nothing() {
    let Some(server) =
        Xvfb::start("every_part_of_the_panel_opens_beside_the_picture_and_an_idle_window_submits_nothing")
    else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut screens = Vec::new();
    for panel in ["tune", "live", "inside", "ray", "path", "captures", "shaders"] {
        let file = format!("{panel}.png");
        let idle = ["--validation", "--json", "--frames", "1", "--stay", "0.5", "--panel", panel];
        let more = ["--pick", "100,180", "--against", "unified", "--view", "corridor", "--screenshot", &file];
        let printed = record(&view(folder.path(), Some(&server.display), &[&idle[..], &more].concat()));
        assert!(printed["submissions"].as_u64().unwrap() > 5 && printed["frames"] == 1, "{printed}");
        assert_eq!(
            (&printed["submissions_while_idle"], &printed["idle_s"]),
            (&0.into(), &0.5.into()),
            "{panel}: {printed}"
        );
        let screen = image::open(folder.path().join(&file)).unwrap().to_rgb8();
        assert_eq!(screen.dimensions(), (320 + 340, 200), "the panel is 340 points wide");
        assert!(colors(&screen, 0..320) > 100 && colors(&screen, 330..660) > 8, "{panel}");
        // The splitting line is white from top to bottom, except where the names stand beside it.
        assert!((40..200).all(|y| screen.get_pixel(160, y).0.iter().all(|v| *v > 250)), "{panel}: no line");
        assert!(!screens.contains(&screen), "{panel} looks like another part");
        screens.push(screen);
    }
}

/// On a screen with two pixels for each point, the panel is twice as many pixels wide, and the picture keeps its size.
/// A panel that ignores the scale would be too small to read.
#[test]
fn a_screen_with_large_points_gets_a_panel_of_as_many_pixels() {
    let Some(server) = Xvfb::start("a_screen_with_large_points_gets_a_panel_of_as_many_pixels") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct-view"));
    command.args(["--validation", "--json", "--frames", "1", "--screenshot", "large.png"]);
    command.args(["--scene", "rooms", "--size", "200x200"]).current_dir(folder.path());
    command.env_remove("WAYLAND_DISPLAY").env("DISPLAY", &server.display).env("WINIT_X11_SCALE_FACTOR", "2");
    assert_eq!(record(&command.output().unwrap())["frames"], 1);
    let screen = image::open(folder.path().join("large.png")).unwrap().to_rgb8();
    assert_eq!(screen.dimensions(), (200 + 2 * 340, 200));
    // The panel's background begins where the picture ends.
    let background = screen.get_pixel(879, 1);
    assert!(screen.get_pixel(210, 1) == background && screen.get_pixel(190, 100) != background);
}

/// The window shows each method in turn by the key M, and ends well after other keys, a drag, a wheel, many sizes, and
/// hiding. Each size needs a new swapchain, even one of a single pixel.
#[test]
fn a_window_survives_keys_mouse_and_a_storm_of_sizes() {
    let Some(server) = Xvfb::start("a_window_survives_keys_mouse_and_a_storm_of_sizes") else { return };
    if Command::new("xdotool").arg("version").output().is_err() {
        eprintln!("skipped: there is no xdotool on the PATH; scripts/setup.sh installs it");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut window = Command::new(env!("CARGO_BIN_EXE_ssct-view"))
        .args(["--validation", "--size", SIZE, "--scene", "rooms"])
        .env_remove("WAYLAND_DISPLAY")
        .env("DISPLAY", &server.display)
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut xdotool = |arguments: &str| {
        let output =
            Command::new("xdotool").args(arguments.split(' ')).env("DISPLAY", &server.display).output().unwrap();
        assert!(window.try_wait().unwrap().is_none(), "the window closed before: {arguments}");
        output
    };
    // The title says that a frame was shown.
    let found = xdotool("search --sync --name rooms,.view");
    let id = String::from_utf8(found.stdout).unwrap().lines().next().unwrap().to_owned();
    xdotool(&format!("windowfocus --sync {id}"));
    // The key M goes from the first method through all of them and back to the first. The title names the shown method.
    for n in 1..=METHODS.len() {
        xdotool("key m");
        let name = METHODS[n % METHODS.len()].name;
        let is_shown = || {
            let title = String::from_utf8(xdotool(&format!("getwindowname {id}")).stdout).unwrap();
            title.contains(&format!("— {name} —"))
        };
        wait_until(|| format!("the window, which the key M should make show {name}"), is_shown);
    }
    for key in ["F2", "c", "F2", "c", "F2", "F2", "F2", "F1", "3", "w", "k", "r", "F1", "p", "c"] {
        xdotool(&format!("key {key}"));
    }
    xdotool("mousemove 100 100 mousedown 1 mousemove_relative 40 10 mouseup 1");
    xdotool("click 4");
    for (width, height) in [(640, 480), (97, 61), (1, 1), (799, 33), (500, 300), (41, 599), (660, 200)] {
        xdotool(&format!("windowsize {id} {width} {height}"));
    }
    xdotool(&format!("windowunmap {id}"));
    xdotool(&format!("windowmap --sync {id}"));
    xdotool(&format!("windowfocus {id}"));
    xdotool("key 1");
    // The key that quits comes last, so that all events before it in the queue were handled.
    let _ = Command::new("xdotool").args(["key", "Escape"]).env("DISPLAY", &server.display).output();
    let ended = window.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

/// An animation along two key frames has the asked number of frames, in each of which the camera stands elsewhere. A
/// file of key frames that does not exist is refused by its name.
#[test]
fn an_animation_follows_key_frames() {
    let Some(server) = Xvfb::start("an_animation_follows_key_frames") else { return };
    let folder = tempfile::tempdir().unwrap();
    let keys = "[[key]]\neye = [0, 0, 0]\nlook_at = [1, 0, 0]\n[[key]]\neye = [1, 0, 0]\nlook_at = [2, 0, 1]\n";
    std::fs::write(folder.path().join("way.toml"), keys).unwrap();
    let along = ["--frames", "4", "--path", "way.toml", "--panel", "none", "--animation", "way.gif"];
    let shown = view(folder.path(), Some(&server.display), &along);
    assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
    let gif = std::fs::read(folder.path().join("way.gif")).unwrap();
    let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(gif)).unwrap();
    let frames = image::AnimationDecoder::into_frames(decoder).collect_frames().unwrap();
    assert_eq!(frames.len(), 4);
    assert!(frames.windows(2).all(|f| f[0].buffer() != f[1].buffer()), "the camera moves");
    let refused = view(folder.path(), Some(&server.display), &["--frames", "1", "--path", "no.toml"]);
    assert!(refusal(&refused).contains("no.toml"));
}

/// The modes `mailbox` and `immediate` work, or are refused with a sentence if the display lacks them. Vulkan demands
/// neither of them.
#[test]
fn the_other_ways_to_present_work_or_are_refused_in_a_sentence() {
    let Some(server) = Xvfb::start("the_other_ways_to_present_work_or_are_refused_in_a_sentence") else { return };
    let folder = tempfile::tempdir().unwrap();
    for mode in ["mailbox", "immediate"] {
        let shown =
            view(folder.path(), Some(&server.display), &["--frames", "2", "--panel", "none", "--present-mode", mode]);
        let errors = String::from_utf8_lossy(&shown.stderr);
        assert!(shown.status.success() || errors.contains("does not present by"), "{mode}: {errors}");
    }
}

/// Without a display, or with one that does not answer, the window's program fails with one sentence, which names no
/// place in a source file as a panic would.
#[test]
fn without_a_display_there_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let message = refusal(&view(folder.path(), None, &[]));
    assert!(message.contains("no window") && message.contains("DISPLAY") && !message.contains(".rs"), "{message}");
    let message = refusal(&view(folder.path(), Some(":7654"), &[]));
    assert!(message.contains("no window") && !message.contains(".rs"), "{message}");
}

/// Wrong options, such as a screenshot without a number of frames, are refused with status 2 before a window opens.
/// Such a window would never write its file.
#[test]
fn a_screenshot_needs_a_number_of_frames() {
    let folder = tempfile::tempdir().unwrap();
    let output = view(folder.path(), None, &["--screenshot", "a.png"]);
    assert_eq!(output.status.code(), Some(2));
    let output = view(folder.path(), None, &["--frames", "1", "--screenshot", "a.gif"]);
    assert_eq!(output.status.code(), Some(2), "an image format that is not written is refused before the work");
    for wrong in [&["--inside", "hi-z/x"][..], &["--pick", "3"], &["--panel", "no"], &["--shaders", "nowhere"]] {
        let output = view(folder.path(), None, wrong);
        assert_eq!(output.status.code(), Some(2), "{wrong:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
