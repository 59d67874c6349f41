//! The window of `ssct view`: passes input to the [`Viewer`], and the viewer's image to the screen. The window is drawn
//! only when something has happened.

use super::input::{Action, action_of_key, is_shift_pressed, motion_of_keys};
use super::panel;
use super::script::Script;
use super::setup::ViewerSetup;
use super::state::Tab;
use super::viewer::{Viewer, ViewerInput, ViewerOutput};
use crate::presentation::{PresentMode, Swapchain};
use ssct::gpu::Gpu;
use ssct_lab::error::{Error, Result};
use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{CursorGrabMode, Window, WindowId};

/// The application that the event loop drives.
pub struct App {
    /// The device.
    pub gpu: Gpu,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// The present mode, which decides how images replace one another on the screen.
    pub present_mode: PresentMode,
    /// The data from which the viewer is built once there is a window.
    pub setup: Option<ViewerSetup>,
    /// The viewer.
    pub viewer: Option<Viewer>,
    /// The scripted run; without frames in its plan, it does nothing.
    pub script: Script,
    /// Wakes the event loop from another thread.
    pub proxy: EventLoopProxy<()>,
    /// The keys that are pressed.
    pub keys: HashSet<KeyCode>,
    /// The time of the last frame, if the next frame follows at once.
    pub last: Option<Instant>,
    /// The error that ended the run, if any.
    pub outcome: Result<()>,
    /// The window, while it is open.
    pub open: Option<Open>,
}

/// An open window.
pub struct Open {
    swapchain: Swapchain,
    /// Turns events of the window into input of egui.
    egui: egui_winit::State,
    window: Arc<Window>,
    title: String,
    /// Whether the mouse turns the camera, so that the cursor is hidden.
    looking: bool,
}

impl ApplicationHandler<()> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none() {
            let opened = self.open_window(events);
            self.check(events, opened);
        }
    }

    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            if self.script.is_over(Instant::now()) {
                self.script.close(&self.gpu);
                events.exit();
            } else {
                self.request_redraw();
            }
        }
    }

    /// Draws again, since another thread has something to show.
    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {
        self.request_redraw();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        // A scripted run must not depend on where the mouse happens to be.
        let takes_input = !self.script.is_running();
        // Changes of the scale factor always go to egui.
        let listens = takes_input || matches!(event, WindowEvent::ScaleFactorChanged { .. });
        if let (true, Some(open)) = (listens, &mut self.open)
            && open.egui.on_window_event(&open.window, &event).repaint
            && event != WindowEvent::RedrawRequested
        {
            open.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::RedrawRequested => {
                let drawn = self.redraw(events);
                self.check(events, drawn);
            }
            WindowEvent::Resized(_) | WindowEvent::Occluded(false) => self.request_redraw(),
            // A window that gets the focus also receives synthetic events for the keys that are pressed then. They are
            // ignored.
            WindowEvent::KeyboardInput { event, is_synthetic, .. }
                if takes_input && !(is_synthetic && event.state == ElementState::Pressed) =>
            {
                self.handle_key(events, &event);
            }
            // All keys count as released, since a release in another window would not be reported.
            WindowEvent::Focused(false) => self.keys.clear(),
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (DeviceEvent::MouseMotion { delta }, Some(open)) = (event, &mut self.open)
            && open.looking
        {
            open.egui.on_mouse_motion(delta);
            open.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface must be destroyed before the connection to the display is closed.
        self.open = None;
    }
}

impl App {
    /// Opens the window, and builds the viewer in it.
    fn open_window(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let Some(setup) = self.setup.take() else { return Ok(()) };
        let scale = events.primary_monitor().map_or(1.0, |m| m.scale_factor());
        let panel_width = if setup.state.tab == Tab::None { 0.0 } else { f64::from(panel::WIDTH) * scale };
        let size = PhysicalSize::new(self.size[0] + panel_width.round() as u32, self.size[1]);
        let attributes = Window::default_attributes().with_title("ssct").with_inner_size(size);
        let window = events.create_window(attributes).map_err(|e| no_window("it cannot be opened", &e))?;
        let window = Arc::new(window);
        let swapchain = Swapchain::new(&self.gpu, &window, self.present_mode)?;
        let proxy = self.proxy.clone();
        // Waking fails only if the loop has ended, and then there is nothing to wake.
        let wake = Arc::new(move || {
            let _ = proxy.send_event(());
        });
        let viewer = setup.build_viewer(&self.gpu, swapchain.screen_format(), wake)?;
        let egui = egui_winit::State::new(
            viewer.egui().clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(self.gpu.max_image_size() as usize),
        );
        window.request_redraw();
        self.viewer = Some(viewer);
        self.open = Some(Open { swapchain, egui, window, title: String::new(), looking: false });
        Ok(())
    }

    /// Runs one round of the viewer and shows its image; requests another one if the image is still changing.
    fn redraw(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let (Some(open), Some(viewer)) = (&mut self.open, &mut self.viewer) else { return Ok(()) };
        let PhysicalSize { width, height } = open.window.inner_size();
        let Some(extent) = open.swapchain.prepare([width, height])? else { return Ok(()) };
        let now = Instant::now();
        // The first step takes one frame's time. The limit keeps the camera from jumping after a long frame.
        let seconds = self.last.map_or(1.0 / 60.0, |then| (now - then).as_secs_f32().min(0.1));
        let mut input = open.egui.take_egui_input(&open.window);
        // egui gets the size of the surface, which may differ from the window's while the window is being resized.
        let points = |v: u32| v as f32 / egui_winit::pixels_per_point(viewer.egui(), &open.window);
        input.screen_rect =
            Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(points(extent[0]), points(extent[1]))));
        // A scripted run puts the camera on its path, if it has one, and has each frame rendered anew.
        self.script.prepare_frame(viewer);
        let motion = motion_of_keys(&self.keys);
        let ViewerOutput { platform, again } = viewer.update(ViewerInput { egui: input, motion, seconds, extent })?;
        open.egui.handle_platform_output(&open.window, platform);
        let shown = viewer.draw(|context, screen, record| {
            open.window.pre_present_notify();
            open.swapchain.present(context, screen, record)
        })?;
        // The window's title and cursor follow the viewer.
        open.follow(viewer);
        let shown = shown == Some(true);
        let goes_on = again == Some(Duration::ZERO) || !shown;
        self.last = goes_on.then_some(now);
        if shown && self.script.is_running() {
            // Counts the frame. After the last one, the run ends when image and comparison with a reference are final.
            self.script.finish_frame(viewer, &self.gpu, goes_on || viewer.is_waiting())?;
            if self.script.is_done() {
                events.exit();
                return Ok(());
            }
        }
        let next_time = [again.map(|d| now + d), self.script.deadline()].into_iter().flatten().min();
        events.set_control_flow(next_time.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        // Other threads wake the loop when their results have arrived.
        if goes_on || (self.script.is_running() && !viewer.is_waiting()) {
            open.window.request_redraw();
        }
        Ok(())
    }

    /// Handles a key that is pressed or released.
    fn handle_key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        if event.state == ElementState::Released {
            self.keys.remove(&code);
            return;
        }
        let Some(viewer) = &mut self.viewer else { return };
        // Keys that are typed into a text field of the panel must not move the camera.
        if viewer.egui().egui_wants_keyboard_input() {
            return;
        }
        self.keys.insert(code);
        match action_of_key(code, is_shift_pressed(&self.keys)) {
            Some(Action::Quit) => events.exit(),
            // While a key is held, only changes of the roughness are repeated.
            Some(action) if !event.repeat || matches!(action, Action::Roughness(_)) => viewer.act(action),
            _ => {}
        }
        self.request_redraw();
    }

    /// Requests that the window is drawn, if it is open.
    fn request_redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// Ends the run if `result` is an error, which the caller of the event loop reports.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(e) = result {
            self.outcome = Err(e);
            events.exit();
        }
    }
}

impl Open {
    /// Updates the window's title and cursor to match the viewer. While the mouse turns the camera, the cursor is
    /// hidden and, if the window system supports it, held in the window.
    fn follow(&mut self, viewer: &Viewer) {
        let title = viewer.title();
        if self.title != title {
            self.window.set_title(&title);
            self.title = title;
        }
        let looking = viewer.is_looking();
        if self.looking != looking {
            self.looking = looking;
            self.window.set_cursor_visible(!looking);
            let modes: &[_] =
                if looking { &[CursorGrabMode::Locked, CursorGrabMode::Confined] } else { &[CursorGrabMode::None] };
            let _ = modes.iter().any(|mode| self.window.set_cursor_grab(*mode).is_ok());
        }
    }
}

/// Makes an error of ours from an error of winit; `what` says what failed. The text of winit's error begins with a
/// place in winit's source; the cause follows the last colon.
pub fn no_window(what: &str, error: &impl std::fmt::Display) -> Error {
    let text = error.to_string();
    let cause = text.rsplit(": ").next().unwrap_or(&text);
    Error::NoWindow(format!("{what}: {}", cause.trim_end_matches('.')))
}
