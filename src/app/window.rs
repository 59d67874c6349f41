//! `ssct view`: a window to fly through a scene. Input goes to the [`Viewer`], its images to the
//! screen. A frame is rendered when something changed, and only then.

use super::cli::{CommonOptions, size};
use super::fly_camera::Motion;
use super::resolve;
use super::viewer::Viewer;
use crate::error::{Error, Result};
use crate::gpu::{DeviceQuery, Gpu, Pixels, PresentMode, Swapchain, swapchain};
use crate::methods;
use crate::report::images;
use clap::Args;
use glam::{Vec2, Vec3};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{CursorGrabMode, Window, WindowId};

/// Options of `ssct view`.
#[derive(Debug, Args)]
#[command(after_help = "\
Keys, by their place on a US keyboard:
  W A S D, Q E   fly forward, left, back, right, down, up; with Shift fast
  mouse          look around while a button is held; the wheel changes the speed
  1 ... 9        the scene's named views
  M              the next method
  R, Shift+R     rougher, smoother
  Esc            quit")]
pub struct ViewOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The method to begin with.
    #[arg(long, default_value = "ssct")]
    pub method: String,
    /// Width and height of the window in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: [u32; 2],
    /// How images replace one another on the screen.
    #[arg(long, value_enum, default_value_t)]
    pub present_mode: PresentMode,
    /// Show N frames, take no input, and quit.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Write the last of the frames: .png (display) or .exr (linear).
    #[arg(long, value_name = "FILE", requires = "frames")]
    pub screenshot: Option<PathBuf>,
}

/// Opens the window; returns when it is closed.
pub fn run(options: &ViewOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let method = methods::find(&options.method)?;
    let globals = resolve::one_globals(&common.place, "view shows one image")?;
    if let Some(path) = &options.screenshot {
        images::check_extension(path)?;
    }
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, None)?;
    let views =
        scene.views.iter().map(|v| resolve::with_lens(&scene, v.clone(), &common.place)).collect::<Result<Vec<_>>>()?;

    let events = EventLoop::new().map_err(|e| no_window("the display cannot be opened", &e))?;
    events.set_control_flow(ControlFlow::Wait);
    let gpu = Gpu::open(&DeviceQuery {
        device: common.device.device.clone(),
        validation: common.device.validation,
        instance_extensions: swapchain::instance_extensions(&events)?,
        ..DeviceQuery::default()
    })?;
    let setup = resolve::setup(&common.method_options, options.size);
    let mut app = App {
        gpu: gpu.clone(),
        size: options.size,
        present_mode: options.present_mode,
        remaining: options.frames,
        viewer: Viewer::new(&gpu, scene, views, view, method, globals, setup)?,
        open: None,
        input: Input::default(),
        outcome: Ok(None),
    };
    events.run_app(&mut app).map_err(|e| no_window("the display was lost", &e))?;
    let last = app.outcome?;
    if let (Some(frames), Some(left @ 1..)) = (options.frames, app.remaining) {
        let shown = frames - left;
        return Err(Error::NoWindow(format!("it was closed after {shown} of {frames} frames")).into());
    }
    drop(app.viewer);
    if let (Some(path), Some(pixels)) = (&options.screenshot, last) {
        images::write_image(path, &pixels)?;
    }
    gpu.check_validation()?;
    Ok(())
}

/// What the event loop drives.
struct App {
    gpu: Gpu,
    size: [u32; 2],
    present_mode: PresentMode,
    viewer: Viewer,
    open: Option<Open>,
    input: Input,
    /// Frames still to be shown in a scripted run.
    remaining: Option<u32>,
    /// The last frame of a scripted run, or what ended the run.
    outcome: Result<Option<Pixels>>,
}

/// A window while it is open.
struct Open {
    swapchain: Swapchain,
    window: Arc<Window>,
    title: String,
}

/// What is held down.
#[derive(Default)]
struct Input {
    keys: HashSet<KeyCode>,
    /// Whether a mouse button is held.
    looking: bool,
    /// When the camera last moved by keys, while it does.
    moved_at: Option<Instant>,
}

/// What a key does once.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Action {
    Quit,
    NextMethod,
    Roughness(f32),
    View(usize),
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none() {
            let opened = self.open_window(events);
            self.check(events, opened);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::RedrawRequested => {
                let drawn = self.redraw(events);
                self.check(events, drawn);
            }
            WindowEvent::Resized(_) | WindowEvent::Occluded(false) => self.request_redraw(),
            // A scripted run shows what its arguments say, whatever the mouse lies on.
            _ if self.remaining.is_some() => {}
            WindowEvent::KeyboardInput { event, .. } => self.key(events, &event),
            WindowEvent::MouseInput { state, .. } => self.look(state == ElementState::Pressed),
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 50.0,
                };
                self.viewer.steer(|camera| {
                    camera.change_speed(notches);
                    false
                });
            }
            // What is released elsewhere is not heard of here.
            WindowEvent::Focused(false) => {
                self.input.keys.clear();
                self.look(false);
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (true, DeviceEvent::MouseMotion { delta: (x, y) }) = (self.input.looking, event) {
            let turned = self.viewer.steer(|camera| {
                camera.turn(Vec2::new(x as f32, y as f32));
                true
            });
            if turned {
                self.request_redraw();
            }
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface must go before the connection to the display does.
        self.open = None;
    }
}

impl App {
    fn open_window(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.size;
        let attributes =
            Window::default_attributes().with_title("ssct").with_inner_size(PhysicalSize::new(width, height));
        let window = events.create_window(attributes).map_err(|e| no_window("it cannot be opened", &e))?;
        let window = Arc::new(window);
        let swapchain = Swapchain::new(&self.gpu, &window, self.present_mode)?;
        window.request_redraw();
        self.open = Some(Open { swapchain, window, title: String::new() });
        Ok(())
    }

    /// Moves the camera by the keys held, renders and shows a frame, and asks for another if the
    /// image goes on changing.
    fn redraw(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let flying = self.fly();
        let Some(open) = &mut self.open else { return Ok(()) };
        let PhysicalSize { width, height } = open.window.inner_size();
        let Some(extent) = open.swapchain.prepare([width, height])? else { return Ok(()) };
        let is_last = self.remaining == Some(1);
        let (shown, pixels) = self.viewer.draw(extent, |context, image| {
            open.window.pre_present_notify();
            let shown = open.swapchain.present(context, image.all())?;
            let pixels = (shown && is_last).then(|| context.read(image.all())).transpose()?;
            Ok((shown, pixels))
        })?;
        let title = self.viewer.title();
        if open.title != title {
            open.window.set_title(&title);
            open.title = title;
        }
        if shown {
            self.remaining = self.remaining.map(|n| n - 1);
        }
        if pixels.is_some() {
            self.outcome = Ok(pixels);
            events.exit();
        } else if flying || !shown || self.remaining.is_some() {
            open.window.request_redraw();
        }
        Ok(())
    }

    /// Flies as far as the time since the last frame allows; whether keys ask for it.
    fn fly(&mut self) -> bool {
        let motion = motion(&self.input.keys);
        if motion.direction == Vec3::ZERO {
            self.input.moved_at = None;
            return false;
        }
        let now = Instant::now();
        // The first step takes a frame's time; a long frame does not throw the camera across the room.
        let seconds = self.input.moved_at.map_or(1.0 / 60.0, |then| (now - then).as_secs_f32().min(0.1));
        self.input.moved_at = Some(now);
        self.viewer.steer(|camera| camera.fly(motion, seconds));
        true
    }

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        if event.state == ElementState::Released {
            self.input.keys.remove(&code);
            return;
        }
        self.input.keys.insert(code);
        let changed = match action(code, shift(&self.input.keys)) {
            Some(Action::Quit) => {
                events.exit();
                false
            }
            Some(Action::NextMethod) if !event.repeat => {
                self.viewer.next_method();
                true
            }
            Some(Action::Roughness(steps)) => {
                self.viewer.change_roughness(steps);
                true
            }
            Some(Action::View(index)) => self.viewer.show_view(index),
            Some(Action::NextMethod) | None => motion(&self.input.keys).direction != Vec3::ZERO,
        };
        if changed {
            self.request_redraw();
        }
    }

    /// Starts or ends looking around; meanwhile the cursor stays hidden in the window, where the
    /// window system can keep it there.
    fn look(&mut self, looking: bool) {
        self.input.looking = looking;
        let Some(open) = &self.open else { return };
        open.window.set_cursor_visible(!looking);
        let modes: &[_] =
            if looking { &[CursorGrabMode::Locked, CursorGrabMode::Confined] } else { &[CursorGrabMode::None] };
        let _ = modes.iter().any(|mode| open.window.set_cursor_grab(*mode).is_ok());
    }

    fn request_redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// Ends the run if something failed; `run` reports it.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(e) = result {
            self.outcome = Err(e);
            events.exit();
        }
    }
}

/// What the window system objects to. Its text begins with a line of winit's own source, and the
/// cause stands behind the last colon.
fn no_window(what: &str, error: &impl std::fmt::Display) -> Error {
    let text = error.to_string();
    let cause = text.rsplit(": ").next().unwrap_or(&text);
    Error::NoWindow(format!("{what}: {}", cause.trim_end_matches('.')))
}

fn shift(keys: &HashSet<KeyCode>) -> bool {
    keys.contains(&KeyCode::ShiftLeft) || keys.contains(&KeyCode::ShiftRight)
}

/// What a key does when it goes down.
fn action(code: KeyCode, shift: bool) -> Option<Action> {
    use KeyCode as K;
    const DIGITS: [KeyCode; 9] =
        [K::Digit1, K::Digit2, K::Digit3, K::Digit4, K::Digit5, K::Digit6, K::Digit7, K::Digit8, K::Digit9];
    match code {
        K::Escape => Some(Action::Quit),
        K::KeyM => Some(Action::NextMethod),
        K::KeyR => Some(Action::Roughness(if shift { -1.0 } else { 1.0 })),
        _ => DIGITS.iter().position(|d| *d == code).map(Action::View),
    }
}

/// Where the keys held ask to fly.
fn motion(keys: &HashSet<KeyCode>) -> Motion {
    let axis = |plus, minus| f32::from(keys.contains(&plus)) - f32::from(keys.contains(&minus));
    let direction = Vec3::new(
        axis(KeyCode::KeyD, KeyCode::KeyA),
        axis(KeyCode::KeyE, KeyCode::KeyQ),
        axis(KeyCode::KeyW, KeyCode::KeyS),
    );
    Motion { direction, fast: shift(keys) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_what_the_help_says() {
        assert_eq!(action(KeyCode::KeyR, false), Some(Action::Roughness(1.0)));
        assert_eq!(action(KeyCode::KeyR, true), Some(Action::Roughness(-1.0)));
        assert_eq!(action(KeyCode::Digit1, false), Some(Action::View(0)));
        assert_eq!(action(KeyCode::Digit9, false), Some(Action::View(8)));
        assert_eq!(action(KeyCode::KeyW, false), None);
    }

    #[test]
    fn opposite_keys_cancel_and_shift_is_fast() {
        let held = |keys: &[KeyCode]| motion(&keys.iter().copied().collect());
        assert_eq!(held(&[KeyCode::KeyW, KeyCode::KeyS]).direction, Vec3::ZERO);
        let m = held(&[KeyCode::KeyA, KeyCode::KeyE, KeyCode::ShiftLeft]);
        assert_eq!((m.direction, m.fast), (Vec3::new(-1.0, 1.0, 0.0), true));
    }
}
