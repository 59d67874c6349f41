//! `ssct view`: a window for viewing methods and tuning their parameters.
//!
//! [`state`] holds what the user changes, as plain data. [`viewer`] renders a frame whenever the state asks for
//! a different one. [`panel`] displays and changes the state. [`window`] connects both to the window system,
//! and [`script`] runs them without a user.

mod animation;
mod captures;
mod cubes;
mod fly_camera;
mod follow;
mod history;
mod input;
mod inspect;
mod panel;
mod path;
mod pictures;
mod reference_error;
mod reload;
mod script;
mod setup;
mod state;
#[cfg(test)]
mod tests;
mod viewer;
mod window;

use super::cli::{CommonOptions, size};
use super::parameters::choice;
use super::resolve;
use crate::custom;
use crate::error::{Error, Result};
use crate::gpu::{DeviceQuery, Gpu};
use crate::methods::{self, METHODS, MethodInfo};
use crate::passes::look::{Compare, Tone};
use crate::report::images;
use crate::scene::path as path_file;
use crate::scene::{Scene, View};
use crate::window::{PresentMode, swapchain};
use animation::Animation;
use clap::{Args, ValueEnum};
use path::PathEditor;
use script::{Script, ScriptPlan};
use setup::ViewerSetup;
use state::{Inside, Side, State, Tab, given_options};
use std::collections::{BTreeMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;
use viewer::Viewer;
use window::{App, no_window};
use winit::event_loop::{ControlFlow, EventLoop};

/// Milliseconds of a frame of an animation.
const ANIMATION_DELAY_MS: u16 = 80;

/// Options of `ssct view`.
#[derive(Debug, Args)]
#[command(after_help = "\
Keys, by their place on a US keyboard:
  W A S D, Q E   fly forward, left, back, right, down, up; with Shift fast
  mouse          look around while a button is held; the wheel changes the speed;
                 a click picks a ray while the part `ray` of the panel is open;
                 the line between two methods can be drawn
  1 ... 9        the scene's named views
  M              the next method
  C              one method, two side by side, their difference
  R, Shift+R     rougher, smoother
  K, P           record a key frame of the camera, play the key frames
  N, B, Delete   put a new capture at the eye, move the selected one, remove it
  F1, F2         show or hide the panel, open its next part
  Esc            quit")]
pub struct ViewOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Method to begin with
    #[arg(long, value_name = "NAME", default_value = "ssct")]
    pub method: String,
    /// Second method to compare with
    #[arg(long, value_name = "NAME")]
    pub against: Option<String>,
    /// How two methods are shown
    #[arg(long, value_name = "HOW", value_enum, default_value_t, requires = "against")]
    pub compare: TwoMethods,
    /// Width and height of the picture
    ///
    /// The panel stands beside the picture.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: [u32; 2],
    /// Part of the panel that is open.
    #[arg(long, value_name = "PART", value_enum, default_value_t)]
    pub panel: Tab,
    /// Show an intermediate, a capture (`capture-1-color`, `-depth`, `-normal`), or the heat map `steps`, instead of the
    /// finished image.
    #[arg(long, value_name = "NAME[/LEVEL]", value_parser = inside)]
    pub inside: Option<Inside>,
    /// Pixel whose ray is drawn, for `--panel ray`.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub pick: Option<[u32; 2]>,
    /// File with key frames of the camera
    ///
    /// `ssct path` measures along the same file. With --frames, the frames follow the key frames.
    #[arg(long, value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Folder of shaders to watch; by default ./shaders-glsl if it exists.
    #[arg(long, value_name = "DIR")]
    pub shaders: Option<PathBuf>,
    /// How images replace one another on the screen.
    #[arg(long, value_name = "MODE", value_parser = choice::<PresentMode>(), default_value = "fifo")]
    pub present_mode: PresentMode,
    /// Show so many frames, take no input, and quit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// File for what the last frame shows
    ///
    /// A .png shows the window, an .exr the picture alone, linear.
    #[arg(long, value_name = "FILE", requires = "frames")]
    pub screenshot: Option<PathBuf>,
    /// File for the frames, as an animated .gif.
    #[arg(long, value_name = "FILE", requires = "frames")]
    pub animation: Option<PathBuf>,
    /// Time to stay open after the frames and take input.
    #[arg(long, value_name = "SECONDS", requires = "frames", value_parser = seconds)]
    pub stay: Option<Duration>,
    /// Print what was shown and submitted, as JSON
    #[arg(long, requires = "frames")]
    pub json: bool,
}

/// How two methods are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum TwoMethods {
    /// Side by side, with a line that can be moved.
    #[default]
    Split,
    /// The magnitude of their difference.
    Difference,
}

/// Opens the window; returns when it is closed.
pub fn run(options: &ViewOptions) -> anyhow::Result<()> {
    custom::watch();
    let common = &options.common;
    let sides = sides(options)?;
    let globals = resolve::one_globals(&common.place, "view shows one image")?;
    if let Some(path) = &options.screenshot {
        images::check_extension(path)?;
    }
    if let Some(path) = options.animation.as_ref().filter(|p| !ends_with(p, "gif")) {
        return Err(Error::Usage(format!("{}: an animation is written as .gif", path.display())).into());
    }
    let mut path = PathEditor::default();
    if let Some(file) = &options.path {
        path.load(file)?;
    }
    let way = options.path.as_deref().map(path_file::load).transpose()?;
    let shaders = shaders(options)?;
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, None)?;

    let events = EventLoop::<()>::with_user_event().build();
    let events = events.map_err(|e| no_window("the display cannot be opened", &e))?;
    events.set_control_flow(ControlFlow::Wait);
    let gpu = Gpu::open(&DeviceQuery {
        device: common.device.device.clone(),
        validation: common.device.validation,
        instance_extensions: swapchain::instance_extensions(&events)?,
        ..DeviceQuery::default()
    })?;
    let state = state(options, &scene, view, globals, sides);
    let is_png = options.screenshot.as_ref().is_some_and(|p| ends_with(p, "png"));
    let script = Script::new(ScriptPlan {
        frames: options.frames,
        path: way.filter(|_| options.frames.is_some()),
        reads_screen: is_png,
        reads_picture: options.screenshot.is_some() && !is_png,
        animation: options.animation.is_some().then(|| Animation::new(ANIMATION_DELAY_MS)),
        stay: options.stay,
    });
    let mut app = App {
        gpu: gpu.clone(),
        size: options.size,
        present_mode: options.present_mode,
        setup: Some(ViewerSetup { scene, state, place: common.place.clone(), path, shaders }),
        viewer: None,
        script,
        proxy: events.create_proxy(),
        keys: HashSet::new(),
        last: None,
        outcome: Ok(()),
        open: None,
    };
    events.run_app(&mut app).map_err(|e| no_window("the display was lost", &e))?;
    app.outcome?;
    if let Some((shown, frames)) = app.script.missing() {
        return Err(Error::NoWindow(format!("it was closed after {shown} of {frames} frames")).into());
    }
    let counts = app.viewer.as_ref().map_or([0, 0], Viewer::counts);
    drop(app.viewer);
    write(options, app.script, counts, &gpu)?;
    gpu.check_validation()?;
    Ok(())
}

/// Writes the files and the record of a scripted run.
fn write(options: &ViewOptions, mut script: Script, [rendered, drawn]: [u64; 2], gpu: &Gpu) -> anyhow::Result<()> {
    if let (Some(path), Some(pixels)) = (&options.screenshot, &script.pixels) {
        images::write_image(path, pixels)?;
    }
    if let (Some(path), Some(animation)) = (&options.animation, script.take_animation()) {
        animation.write(path)?;
    }
    if options.json {
        let [then, now] = script.submissions;
        let summary = serde_json::json!({
            "kind": "view", "definitions": u32::from(options.common.method_options.setup([1, 1]).effect().definitions), "device": gpu.info(),
            "frames": rendered, "drawings": drawn, "submissions": now, "submissions_while_idle": now - then,
            "idle_s": options.stay.map(|d| d.as_secs_f64()),
            "validation": options.common.device.validation.then(|| gpu.validation().len()),
        });
        writeln!(std::io::stdout(), "{}", serde_json::json!([summary]))?;
    }
    Ok(())
}

/// The method and the one to compare with; both have the options of the command line.
fn sides(options: &ViewOptions) -> Result<[Side; 2]> {
    let first = methods::find(&options.method)?;
    let second = match &options.against {
        Some(name) => methods::find(name)?,
        // The method that the key `C` compares with until another one is chosen.
        None => METHODS.iter().find(|m| m.name != first.name).unwrap_or(first),
    };
    let given = given(&std::env::args_os().skip(1).collect::<Vec<_>>());
    let side = |method: &'static MethodInfo| Side::new(method, given.clone());
    let sides = [side(first), side(second)];
    match &sides[0].fault {
        Some(fault) => Err(Error::Usage(fault.clone())),
        None => Ok(sides),
    }
}

/// The methods' options among the arguments of `ssct view`, which begin with `view`.
fn given(arguments: &[std::ffi::OsString]) -> BTreeMap<String, String> {
    let command = ViewOptions::augment_args(clap::Command::new("view"));
    command.try_get_matches_from(arguments).map(|matches| given_options(&matches)).unwrap_or_default()
}

fn state(options: &ViewOptions, scene: &Scene, view: View, globals: crate::study::Globals, sides: [Side; 2]) -> State {
    State {
        tab: options.panel,
        scene: viewer::scene_name(&options.common.place),
        camera: Viewer::camera(scene, &view),
        view,
        moved: false,
        globals,
        sides,
        compare: match (&options.against, options.compare) {
            (None, _) => Compare::One,
            (Some(_), TwoMethods::Split) => Compare::Split,
            (Some(_), TwoMethods::Difference) => Compare::Difference,
        },
        split: 0.5,
        gain: 4.0,
        inside: options.inside.clone(),
        tone: Tone {
            range: if options.inside.as_ref().is_some_and(|i| i.name == state::STEPS) {
                [0.0, 64.0]
            } else {
                [0.0, 1.0]
            },
            ..Tone::DISPLAY
        },
        picked: options.pick,
    }
}

/// The folder whose shaders are watched.
fn shaders(options: &ViewOptions) -> Result<Option<PathBuf>> {
    match &options.shaders {
        Some(folder) => reload::ShaderWatch::new(folder).map(|_| Some(folder.clone())),
        None => Ok(Some(PathBuf::from(crate::gpu::glsl::FOLDER)).filter(|f| f.is_dir())),
    }
}

fn ends_with(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Parses `--inside`, as in `hi-z/3`.
fn inside(text: &str) -> std::result::Result<Inside, String> {
    let (name, level) = text.split_once('/').unwrap_or((text, "0"));
    let level = level.parse().map_err(|_| format!("{text:?}: the slash must be followed by a level, as in hi-z/3"))?;
    Ok(Inside { name: name.to_owned(), level })
}

/// Parses a pixel, as in `120,80`.
fn pixel(text: &str) -> std::result::Result<[u32; 2], String> {
    let wrong = || format!("{text:?} is not a pixel; write it as 120,80");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([x.trim().parse().map_err(|_| wrong())?, y.trim().parse().map_err(|_| wrong())?])
}

fn seconds(text: &str) -> std::result::Result<Duration, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    Duration::try_from_secs_f64(value).map_err(|_| format!("{text} seconds cannot be waited for"))
}
