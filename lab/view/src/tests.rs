//! Tests of the viewer without a window. Each test drives the viewer as a window does: events go in, images come out,
//! and the validation layers are on.

mod showing;
mod tuning;

use super::fly_camera::{FlyCamera, FlyMotion};
use super::state::{Side, State, Tab};
use super::viewer::{Viewer, ViewerInput};
use clap::{Args, FromArgMatches};
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use ssct::gpu::{DeviceQuery, Gpu, Pixels};
use ssct::methods::METHODS;
use ssct::passes::look::{Compare, Tone};
use ssct_lab::app::cli::{CommonOptions, SceneOptions};
use ssct_lab::stage::Globals;
use ssct_scenes::{View, library};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Width and height of the window in pixels; beside the panel, 200 pixels of width are left for the picture.
const EXTENT: [u32; 2] = [540, 200];
/// The format of the image that the viewer draws, as a window's would be.
const FORMAT: ash::vk::Format = ash::vk::Format::R8G8B8A8_SRGB;

/// A viewer without a window, which a test drives round by round.
struct TestViewer {
    gpu: Gpu,
    viewer: Viewer,
    /// Width and height of the window in pixels.
    extent: [u32; 2],
    pixels_per_point: f32,
    /// Time of the last round in seconds.
    time: f64,
}

/// Returns a state without a scene; both sides show the first method.
pub(super) fn state() -> State {
    let side = || Side::new(&METHODS[0], BTreeMap::new());
    let view = View::default();
    State {
        tab: Tab::Tune,
        scene: String::new(),
        camera: FlyCamera::new(&view, 1.0),
        view,
        moved: false,
        globals: Globals::default(),
        sides: [side(), side()],
        compare: Compare::One,
        split: 0.5,
        gain: 1.0,
        inside: None,
        tone: Tone::DISPLAY,
        picked: None,
    }
}

/// Copies the shaders into a folder, where they can be edited; returns the folder of the copies.
pub(super) fn copied_shaders(folder: &Path) -> PathBuf {
    let root = folder.join("shaders");
    copy(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders-glsl")), &root);
    root
}

/// Copies a folder with everything in it.
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

/// Returns the options of a scene as they are without any flag.
fn place() -> SceneOptions {
    let command = CommonOptions::augment_args(clap::Command::new("ssct"));
    CommonOptions::from_arg_matches(&command.get_matches_from(["ssct"])).unwrap().place
}

/// The event of the left mouse button at a point of the window.
fn mouse_button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::default() }
}

impl TestViewer {
    /// Opens a device, and makes a viewer of the view `corridor` of `rooms`, with mirrors and the methods `ssct` and
    /// `hzct`.
    fn new() -> Self {
        let gpu = Gpu::open(&DeviceQuery { validation: true, ..DeviceQuery::default() }).unwrap();
        let scene = library::scene("rooms").unwrap();
        let view = scene.view("corridor").unwrap().clone();
        let side = |name: &str| Side::new(ssct::methods::find(name).unwrap(), BTreeMap::new());
        let state = State {
            scene: "rooms".into(),
            camera: Viewer::camera(&scene, &view),
            view,
            globals: Globals { roughness: Some(0.0), ..Globals::default() },
            sides: [side("ssct"), side("hzct")],
            ..state()
        };
        let viewer = Viewer::new(&gpu, scene, state, place(), FORMAT, Arc::new(|| ())).unwrap();
        Self { gpu, viewer, extent: EXTENT, pixels_per_point: 1.0, time: 0.0 }
    }

    /// Shows the method `unified` with so many captures of 128² texels a face.
    fn turn_captures_on(&mut self, count: &str) {
        let unified = ssct::methods::find("unified").unwrap();
        self.viewer.state.choose(0, unified);
        for (option, value) in [("captures", count), ("capture-side", "128")] {
            self.viewer.state.sides[0].set(option, Some(value.into()));
        }
        assert_eq!(self.viewer.state.sides[0].fault, None);
    }

    /// Runs one round with events; returns after what time the viewer asks for the next one, if it does.
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
        let input = ViewerInput { egui, motion: FlyMotion::default(), seconds: 0.02, extent: self.extent };
        let again = self.viewer.update(input).unwrap().again;
        let drawn = self.viewer.draw(|context, _, record| Ok(context.once(|frame| record(frame))?)).unwrap();
        assert!(drawn.is_some(), "a round must leave something to draw");
        again
    }

    /// Runs rounds until nothing is left to do; returns their number.
    fn settle(&mut self) -> usize {
        for rounds in 1..40 {
            if self.round(Vec::new()) != Some(Duration::ZERO) {
                return rounds;
            }
        }
        panic!("the viewer does not come to rest");
    }

    /// Returns the screen as it was last drawn.
    fn screen(&mut self) -> Pixels {
        self.viewer.read_screen().unwrap()
    }

    /// Asserts that the validation layers found nothing; `what` is for the message.
    fn assert_valid(&self, what: &str) {
        self.gpu.check_validation().unwrap_or_else(|e| panic!("{what}: {e}"));
    }

    /// Clicks at a point of the window, in points.
    fn click(&mut self, x: f32, y: f32) {
        let pos = Pos2::new(x, y);
        self.round(vec![Event::PointerMoved(pos)]);
        self.round(vec![mouse_button(pos, true)]);
        self.round(vec![mouse_button(pos, false)]);
    }

    /// Drags the mouse from one point of the window to another, in points.
    fn drag(&mut self, from: [f32; 2], to: [f32; 2]) {
        let [from, to] = [from, to].map(|p| Pos2::new(p[0], p[1]));
        self.round(vec![Event::PointerMoved(from)]);
        self.round(vec![mouse_button(from, true)]);
        self.round(vec![Event::PointerMoved(from.lerp(to, 0.5))]);
        self.round(vec![Event::PointerMoved(to)]);
        self.round(vec![mouse_button(to, false)]);
    }
}
