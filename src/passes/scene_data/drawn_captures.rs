//! The captures that a scene keeps once they are drawn, so that all effects which look into them share one drawing.

use super::SceneData;
use crate::error::Result;
use crate::gpu::{FrameContext, Image};
use ssct_ground::scene::{Capture, Material};
use std::time::Instant;

/// Captures that were drawn, with the cost of the drawing.
#[derive(Clone)]
pub(crate) struct DrawnCaptures {
    /// Places, near planes and size of the captures.
    pub captures: Vec<Capture>,
    /// The properties of the materials that a capture shows.
    pub materials: Vec<Material>,
    /// The image of [`Captures::pyramid`](crate::passes::Captures::pyramid).
    pub pyramid: Image,
    /// The image of [`Captures::normal`](crate::passes::Captures::normal).
    pub normal: Image,
    /// The image of [`Captures::color`](crate::passes::Captures::color).
    pub color: Image,
    /// Time and memory of the drawing.
    pub cost: DrawingCost,
}

/// Time and memory of what is made of a scene once, such as images or triangles.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DrawingCost {
    /// Milliseconds on the host until the device was done.
    pub time_ms: f64,
    /// Bytes of device memory that the images or triangles take.
    pub device_bytes: u64,
}

impl DrawingCost {
    /// Calls `make`, and returns its result, with the cost of making it.
    pub fn measure<T>(
        context: &mut FrameContext,
        make: impl FnOnce(&mut FrameContext) -> Result<T>,
    ) -> Result<(T, Self)> {
        let (bytes_before, begun) = (context.gpu().allocated_bytes(), Instant::now());
        let result = make(context)?;
        let device_bytes = context.gpu().allocated_bytes().saturating_sub(bytes_before);
        Ok((result, Self { time_ms: 1e3 * begun.elapsed().as_secs_f64(), device_bytes }))
    }
}

impl SceneData {
    /// Returns the captures that were drawn last, if they are those that are asked for. `None` if the scene has changed since.
    pub(crate) fn drawn_captures(&self, captures: &[Capture], materials: &[Material]) -> Option<DrawnCaptures> {
        let kept = self.drawn_captures.borrow();
        kept.as_ref().filter(|kept| kept.captures == captures && kept.materials == materials).cloned()
    }

    /// Keeps captures that show the scene as it is now, instead of those that were drawn before.
    pub(crate) fn keep_captures(&self, drawn: DrawnCaptures) {
        *self.drawn_captures.borrow_mut() = Some(drawn);
    }
}
