//! A scripted run of the window: it shows some frames, and takes a screenshot or an animation of them. It can then stay
//! open without a change for a while, which shows whether anything is submitted.

use super::animation::Animation;
use super::viewer::Viewer;
use ssct::gpu::{Gpu, Pixels};
use ssct_lab::error::Result;
use ssct_scenes::path::CameraPath;
use std::time::{Duration, Instant};

/// The plan of a scripted run.
#[derive(Default)]
pub struct ScriptPlan {
    /// The number of frames to show; if `None`, the user is in control.
    pub frames: Option<u32>,
    /// The camera path over the frames.
    pub path: Option<CameraPath>,
    /// Whether to read the screen at the end.
    pub reads_screen: bool,
    /// Whether to read the picture at the end, linear and without the panel.
    pub reads_picture: bool,
    /// The animation to which every frame is added.
    pub animation: Option<Animation>,
    /// How long the window stays open afterwards.
    pub stay: Option<Duration>,
}

/// A scripted run and its results so far.
#[derive(Default)]
pub struct Script {
    plan: ScriptPlan,
    /// The pixels that were read at the end.
    pub pixels: Option<Pixels>,
    /// The numbers of submissions to the device until the frames were finished, and until the window closed.
    pub submissions: [u64; 2],
    /// The number of frames shown so far.
    shown: u32,
    /// The time at which the window closes by itself; `None` before the frames are finished.
    until: Option<Instant>,
    is_done: bool,
}

impl Script {
    /// Makes a run before its first frame.
    pub fn new(plan: ScriptPlan) -> Self {
        Self { plan, ..Self::default() }
    }

    /// Takes the animation out of the run, after the last frame.
    pub fn take_animation(&mut self) -> Option<Animation> {
        self.plan.animation.take()
    }

    /// Returns whether the script controls the window, and not the user.
    pub fn is_running(&self) -> bool {
        self.plan.frames.is_some() && self.until.is_none() && !self.is_done
    }

    /// Returns whether the run has finished.
    pub fn is_done(&self) -> bool {
        self.is_done
    }

    /// Returns the number of frames that were shown and the number that was requested; `None` if no frame is missing.
    pub fn missing(&self) -> Option<(u32, u32)> {
        self.plan.frames.filter(|_| self.is_running()).map(|n| (self.shown, n))
    }

    /// Returns the time at which the window closes by itself, if it is known.
    pub fn deadline(&self) -> Option<Instant> {
        self.until
    }

    /// Returns whether it is time to close the window.
    pub fn is_over(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| now >= until)
    }

    /// Ends the run when the window closes, and records the number of submissions until then.
    pub fn close(&mut self, gpu: &Gpu) {
        self.submissions[1] = gpu.submissions();
        self.is_done = true;
    }

    /// Prepares the next frame, if one is missing: moves the camera along the path, and forces the frame to be rendered
    /// even if nothing changed.
    pub fn prepare_frame(&mut self, viewer: &mut Viewer) {
        let Some(frames) = self.plan.frames.filter(|n| self.is_running() && self.shown < *n) else { return };
        viewer.invalidate();
        if let Some(path) = &self.plan.path {
            let place = path.eye_and_look_at(self.shown as f32 / (frames - 1).max(1) as f32);
            viewer.state.put_camera(place);
        }
    }

    /// Counts a frame that was shown. After the last frame the pixels are read and the run ends, as soon as nothing is
    /// pending (`is_pending`): neither a change of the image nor the panel's analysis of it.
    pub fn finish_frame(&mut self, viewer: &mut Viewer, gpu: &Gpu, is_pending: bool) -> Result<()> {
        let Some(frames) = self.plan.frames else { return Ok(()) };
        if self.shown < frames {
            self.shown += 1;
            if let Some(animation) = &mut self.plan.animation {
                animation.add(&viewer.read_screen()?)?;
            }
        }
        if self.shown < frames || is_pending {
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
