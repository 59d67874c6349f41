//! `ssct-view`: a window for viewing methods and tuning their parameters. `ssct view` starts it.
//!
//! [`state`](mod@state) is the plain data that the user changes. [`viewer`] renders a frame whenever the state asks for
//! a different one, and [`panel`] displays and changes the state. [`window`] connects viewer and panel to the window
//! system by [`presentation`], and [`script`] runs them without a user.

mod animation;
mod captures;
mod cubes;
mod fly_camera;
mod follow;
mod history;
mod input;
mod options;
mod panel;
mod path;
mod pictures;
mod presentation;
mod reference_command;
mod reference_error;
mod reload;
mod script;
mod setup;
mod state;
#[cfg(test)]
mod tests;
mod viewer;
mod window;

use ssct_lab::app::{self, resolve};
use ssct_lab::{custom, report, stage, study};

use animation::Animation;
use ash::vk;
use clap::Args;
use options::{TwoMethods, ViewOptions};
use path::PathEditor;
use presentation::swapchain;
use report::images;
use script::{Script, ScriptPlan};
use setup::ViewerSetup;
use ssct::gpu::{self, DeviceQuery, Gpu};
use ssct::methods::{self, METHODS, MethodInfo};
use ssct::passes::look::{Compare, Tone};
use ssct_lab::error::{Error, Result};
use ssct_scenes::path as path_file;
use ssct_scenes::{Scene, View};
use state::{Side, State, given_options};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use viewer::Viewer;
use window::{App, no_window};
use winit::event_loop::{ControlFlow, EventLoop};

/// How long a frame of an animation is shown, in milliseconds.
const ANIMATION_DELAY_MS: u16 = 80;

fn main() -> ExitCode {
    app::run_program(options::command, run)
}

/// Opens the window; returns when it is closed.
fn run(options: &ViewOptions) -> anyhow::Result<()> {
    custom::watch();
    let common = &options.common;
    let sides = compared_sides(options)?;
    let globals = resolve::one_globals(&common.place, "view shows one image")?;
    if let Some(path) = &options.screenshot {
        images::check_extension(path)?;
    }
    if let Some(path) = options.animation.as_ref().filter(|p| !has_extension(p, "gif")) {
        return Err(Error::usage(format!("{}: an animation is written as .gif", path.display())).into());
    }
    let mut path = PathEditor::default();
    if let Some(file) = &options.path {
        path.load(file)?;
    }
    let camera_path = options.path.as_deref().map(path_file::load).transpose()?;
    let shaders = watched_folder(options)?;
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
    });
    let gpu = gpu.map_err(|error| match error {
        ssct::Error::Vulkan { result: vk::Result::ERROR_EXTENSION_NOT_PRESENT, .. } => {
            Error::NoWindow("no Vulkan driver here can present to this window system".into())
        }
        error => error.into(),
    })?;
    let state = initial_state(options, &scene, view, globals, sides);
    let is_png = options.screenshot.as_ref().is_some_and(|p| has_extension(p, "png"));
    let script = Script::new(ScriptPlan {
        frames: options.frames,
        path: camera_path.filter(|_| options.frames.is_some()),
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
    write_out(options, app.script, counts, &gpu)?;
    gpu.check_validation()?;
    Ok(())
}

/// Writes the files and the record of a scripted run. `rendered` is the number of frames that were rendered, and
/// `drawn` the number of times that panel and picture were drawn.
fn write_out(options: &ViewOptions, mut script: Script, [rendered, drawn]: [u64; 2], gpu: &Gpu) -> anyhow::Result<()> {
    if let (Some(path), Some(pixels)) = (&options.screenshot, &script.pixels) {
        images::write_image(path, pixels)?;
    }
    if let (Some(path), Some(animation)) = (&options.animation, script.take_animation()) {
        animation.write(path)?;
    }
    if options.json {
        let [after_last_frame, at_close] = script.submissions;
        let summary = serde_json::json!({
            "kind": "view", "definitions": study::record::DEFINITIONS, "device": gpu.info(),
            "frames": rendered, "drawings": drawn,
            "submissions": at_close, "submissions_while_idle": at_close - after_last_frame,
            "idle_s": options.stay.map(|d| d.as_secs_f64()),
            "validation": options.common.device.validation.then(|| gpu.validation().len()),
        });
        ssct_lab::app::printed::json(&serde_json::json!([summary]))?;
    }
    Ok(())
}

/// Returns the shown method and the method to compare with, both with the options of the command line.
fn compared_sides(options: &ViewOptions) -> Result<[Side; 2]> {
    let first = methods::find(&options.method)?;
    let second = match &options.against {
        Some(name) => methods::find(name)?,
        // The key `C` compares with this method until the user chooses another one.
        None => METHODS.iter().find(|m| m.name != first.name).unwrap_or(first),
    };
    let typed_options = method_options(&std::env::args_os().collect::<Vec<_>>());
    let side = |method: &'static MethodInfo| Side::new(method, typed_options.clone());
    let sides = [side(first), side(second)];
    // The other method may lack some of the options: it leaves them out, and the panel says so.
    match &sides[0].fault {
        Some(fault) => Err(Error::usage(fault.clone())),
        None => Ok(sides),
    }
}

/// Returns the options of methods among the arguments of the program, by their flags. The first argument is the
/// program's name.
fn method_options(arguments: &[std::ffi::OsString]) -> BTreeMap<String, String> {
    let command = ViewOptions::augment_args(clap::Command::new("ssct-view"));
    command.try_get_matches_from(arguments).map(|matches| given_options(&matches)).unwrap_or_default()
}

/// Returns the state with which the window opens.
fn initial_state(options: &ViewOptions, scene: &Scene, view: View, globals: stage::Globals, sides: [Side; 2]) -> State {
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

/// Returns the folder whose shaders are watched: the folder of the option, which must contain shaders, or that of the
/// repository. `None` without an option if the program does not run in the repository.
fn watched_folder(options: &ViewOptions) -> Result<Option<PathBuf>> {
    match &options.shaders {
        Some(folder) => reload::ShaderWatch::new(folder).map(|_| Some(folder.clone())),
        None => Ok(Some(PathBuf::from(gpu::glsl::FOLDER)).filter(|f| f.is_dir())),
    }
}

/// Returns whether a file has an extension, in upper or lower case.
fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}
