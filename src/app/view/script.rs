//! A run by arguments alone: some frames, a screenshot or an animation of them, and then a while in
//! which nothing happens, to see that nothing is submitted.

use super::animation::Animation;
use super::viewer::Viewer;
use crate::error::Result;
use crate::gpu::{Gpu, Pixels};
use crate::scene::path::CameraPath;
use std::time::{Duration, Instant};

/// What is to be done.
#[derive(Default)]
pub struct Plan {
    /// Frames to show; `None` leaves everything to the user.
    pub frames: Option<u32>,
    /// The way of the camera over the frames.
    pub path: Option<CameraPath>,
    /// Whether the screen is read at the end.
    pub reads_screen: bool,
    /// Whether the picture is read at the end, linear and without panel.
    pub reads_picture: bool,
    /// Every frame is added.
    pub animation: Option<Animation>,
    /// How long the window stays open after that.
    pub stay: Option<Duration>,
}

/// What was done of it.
#[derive(Default)]
pub struct Script {
    plan: Plan,
    /// What was read.
    pub pixels: Option<Pixels>,
    /// Submissions when the frames were done, and when the window closed.
    pub submissions: [u64; 2],
    shown: u32,
    until: Option<Instant>,
    is_done: bool,
}

impl Script {
    /// Before the first frame.
    pub fn new(plan: Plan) -> Self {
        Self { plan, ..Self::default() }
    }

    /// The animation, after the last frame.
    pub fn take_animation(&mut self) -> Option<Animation> {
        self.plan.animation.take()
    }

    /// Whether the arguments decide what is shown.
    pub fn is_running(&self) -> bool {
        self.plan.frames.is_some() && self.until.is_none() && !self.is_done
    }

    /// Whether there is nothing left to do.
    pub fn is_done(&self) -> bool {
        self.is_done
    }

    /// Frames shown of those to show, if some are missing.
    pub fn missing(&self) -> Option<(u32, u32)> {
        self.plan.frames.filter(|_| self.is_running()).map(|n| (self.shown, n))
    }

    /// When the window closes by itself.
    pub fn deadline(&self) -> Option<Instant> {
        self.until
    }

    /// Whether it is time to close.
    pub fn is_over(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| now >= until)
    }

    /// Notes what was submitted when the window closes.
    pub fn close(&mut self, gpu: &Gpu) {
        self.submissions[1] = gpu.submissions();
        self.is_done = true;
    }

    /// Before a frame: it is rendered, whether anything changed or not.
    pub fn begin(&mut self, viewer: &mut Viewer) {
        let Some(frames) = self.plan.frames.filter(|n| self.is_running() && self.shown < *n) else { return };
        viewer.invalidate();
        if let Some(path) = &self.plan.path {
            let place = path.at(self.shown as f32 / (frames - 1).max(1) as f32);
            viewer.state.steer(|camera| {
                camera.put(place);
                true
            });
        }
    }

    /// After a frame was shown; `goes_on` says that what is shown still changes by itself.
    pub fn end(&mut self, viewer: &mut Viewer, gpu: &Gpu, goes_on: bool) -> Result<()> {
        let Some(frames) = self.plan.frames else { return Ok(()) };
        if self.shown < frames {
            self.shown += 1;
            if let Some(animation) = &mut self.plan.animation {
                animation.add(&viewer.read_screen()?)?;
            }
        }
        // The panel's answers come after the last frame.
        if self.shown < frames || goes_on {
            return Ok(());
        }
        if self.plan.reads_screen {
            self.pixels = Some(viewer.read_screen()?);
        } else if self.plan.reads_picture {
            self.pixels = viewer.read_picture()?;
        }
        self.submissions = [gpu.submissions(); 2];
        match self.plan.stay {
            Some(stay) => self.until = Some(Instant::now() + stay),
            None => self.is_done = true,
        }
        Ok(())
    }
}
