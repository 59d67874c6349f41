//! The window of `ssct view`: input goes to the [`Viewer`], its image to the screen. It draws when
//! something happened, and only then.

use super::input::{Action, action, motion, shift};
use super::script::Script;
use super::state::Tab;
use super::viewer::{Input, Updated, Viewer};
use super::{Opening, panel};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, PresentMode, Swapchain};
use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{CursorGrabMode, Window, WindowId};

/// What the event loop drives.
pub struct App {
    /// The device.
    pub gpu: Gpu,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// How images replace one another.
    pub present_mode: PresentMode,
    /// What the viewer is made from, once there is a window.
    pub opening: Option<Opening>,
    /// The viewer.
    pub viewer: Option<Viewer>,
    /// What a run by arguments does; without frames, nothing.
    pub script: Script,
    /// Wakes the loop from another thread.
    pub proxy: EventLoopProxy<()>,
    /// What is held down.
    pub keys: HashSet<KeyCode>,
    /// When the last frame was made, while frames follow one another.
    pub last: Option<Instant>,
    /// What ended the run.
    pub outcome: Result<()>,
    /// The window while it is open.
    pub open: Option<Open>,
}

/// A window while it is open.
pub struct Open {
    swapchain: Swapchain,
    egui: egui_winit::State,
    window: Arc<Window>,
    title: String,
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

    /// Another thread has something to show.
    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {
        self.request_redraw();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        // A run by arguments shows what they say, whatever the mouse lies on.
        let takes_input = !self.script.is_running();
        // How large a point is, egui must know in any case.
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
            // A window that gets the focus is told of the keys that are held then, beside their own events.
            WindowEvent::KeyboardInput { event, is_synthetic, .. }
                if takes_input && !(is_synthetic && event.state == ElementState::Pressed) =>
            {
                self.key(events, &event);
            }
            // What is released elsewhere is not heard of here.
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
        // The surface must go before the connection to the display does.
        self.open = None;
    }
}

impl App {
    fn open_window(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let Some(opening) = self.opening.take() else { return Ok(()) };
        let scale = events.primary_monitor().map_or(1.0, |m| m.scale_factor());
        let beside = if opening.state.tab == Tab::None { 0.0 } else { f64::from(panel::WIDTH) * scale };
        let size = PhysicalSize::new(self.size[0] + beside.round() as u32, self.size[1]);
        let attributes = Window::default_attributes().with_title("ssct").with_inner_size(size);
        let window = events.create_window(attributes).map_err(|e| no_window("it cannot be opened", &e))?;
        let window = Arc::new(window);
        let swapchain = Swapchain::new(&self.gpu, &window, self.present_mode)?;
        let proxy = self.proxy.clone();
        // A loop that is over needs no waking.
        let wake = Arc::new(move || {
            let _ = proxy.send_event(());
        });
        let viewer = opening.viewer(&self.gpu, swapchain.screen_format(), wake)?;
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

    /// One round of the viewer, shown; and another asked for if the image goes on changing.
    fn redraw(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let (Some(open), Some(viewer)) = (&mut self.open, &mut self.viewer) else { return Ok(()) };
        let PhysicalSize { width, height } = open.window.inner_size();
        let Some(extent) = open.swapchain.prepare([width, height])? else { return Ok(()) };
        let now = Instant::now();
        // The first step takes a frame's time; a long frame does not throw the camera across the room.
        let seconds = self.last.map_or(1.0 / 60.0, |then| (now - then).as_secs_f32().min(0.1));
        let mut input = open.egui.take_egui_input(&open.window);
        // The surface may be another size than the window says, while it is being resized.
        let points = |v: u32| v as f32 / egui_winit::pixels_per_point(viewer.egui(), &open.window);
        input.screen_rect =
            Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(points(extent[0]), points(extent[1]))));
        self.script.begin(viewer);
        let motion = motion(&self.keys);
        let Updated { platform, again } = viewer.update(Input { egui: input, motion, seconds, extent })?;
        open.egui.handle_platform_output(&open.window, platform);
        let shown = viewer.draw(|context, screen, record| {
            open.window.pre_present_notify();
            open.swapchain.present(context, screen, record)
        })?;
        open.follow(viewer);
        let shown = shown == Some(true);
        let goes_on = again == Some(Duration::ZERO) || !shown;
        self.last = goes_on.then_some(now);
        if shown && self.script.is_running() {
            self.script.end(viewer, &self.gpu, goes_on || viewer.is_waiting())?;
            if self.script.is_done() {
                events.exit();
                return Ok(());
            }
        }
        let wait = [again.map(|d| now + d), self.script.deadline()].into_iter().flatten().min();
        events.set_control_flow(wait.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        // What another thread works out wakes the loop when it is there.
        if goes_on || (self.script.is_running() && !viewer.is_waiting()) {
            open.window.request_redraw();
        }
        Ok(())
    }

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        if event.state == ElementState::Released {
            self.keys.remove(&code);
            return;
        }
        let Some(viewer) = &mut self.viewer else { return };
        // What is typed into a field of the panel is none of the camera's.
        if viewer.egui().egui_wants_keyboard_input() {
            return;
        }
        self.keys.insert(code);
        match action(code, shift(&self.keys)) {
            Some(Action::Quit) => events.exit(),
            // A key that is held steps on only where steps are small.
            Some(action) if !event.repeat || matches!(action, Action::Roughness(_)) => viewer.act(action),
            _ => {}
        }
        self.request_redraw();
    }

    fn request_redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// Ends the run if something failed; whoever started it reports it.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(e) = result {
            self.outcome = Err(e);
            events.exit();
        }
    }
}

impl Open {
    /// Title and cursor follow the viewer. While the mouse looks around, the cursor stays hidden in the
    /// window, where the window system can keep it there.
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

/// What the window system objects to. Its text begins with a line of winit's own source, and the
/// cause stands behind the last colon.
pub fn no_window(what: &str, error: &impl std::fmt::Display) -> Error {
    let text = error.to_string();
    let cause = text.rsplit(": ").next().unwrap_or(&text);
    Error::NoWindow(format!("{what}: {}", cause.trim_end_matches('.')))
}
