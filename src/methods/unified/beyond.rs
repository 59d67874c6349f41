//! Chooses between the passes that follow lost rays through captures and those that follow them among triangles.

use crate::error::Result;
use crate::gpu::Frame;
use crate::passes::follow::{FollowInput, FollowPass};
use crate::passes::triangle_trace::{TriangleInput, TriangleTracePass};
use crate::passes::unified_gloss::GlossImages;
use crate::passes::{Canvas, GBuffer, Hits};

/// The passes that follow the rays on the list of lost rays.
pub(super) enum BeyondPass {
    Captures(FollowPass),
    Triangles(TriangleTracePass),
}

/// The inputs of a [`BeyondPass`] in a frame.
pub(super) enum BeyondInput<'a> {
    Captures(FollowInput<'a>),
    Triangles(TriangleInput<'a>),
}

impl BeyondPass {
    /// Records the pass that follows the mirror rays on the list and finishes their pixels.
    pub(super) fn record_mirrors(
        &self,
        frame: &mut Frame,
        input: &BeyondInput,
        (gbuffer, canvas, hits): (&GBuffer, Canvas, Option<Hits>),
    ) -> Result<()> {
        match (self, input) {
            (Self::Captures(pass), BeyondInput::Captures(input)) => {
                pass.record_mirrors(frame, *input, gbuffer, canvas, hits)
            }
            (Self::Triangles(pass), BeyondInput::Triangles(input)) => {
                pass.record_mirrors(frame, *input, gbuffer, canvas, hits)
            }
            _ => Ok(()), // The effect gives each pass the input of its kind.
        }
    }

    /// Records the pass that follows the rays of narrow lobes and writes into their records what they see.
    pub(super) fn record_narrow(&self, frame: &mut Frame, input: &BeyondInput, gloss: &GlossImages) -> Result<()> {
        let images = [&gloss.records, &gloss.ends];
        match (self, input) {
            (Self::Captures(pass), BeyondInput::Captures(input)) => pass.record_narrow(frame, *input, images),
            (Self::Triangles(pass), BeyondInput::Triangles(input)) => pass.record_narrow(frame, *input, images),
            _ => Ok(()), // The effect gives each pass the input of its kind.
        }
    }

    /// Records the pass that follows the rays of cells with wide lobes and writes where they end and what they see.
    pub(super) fn record_wide(&self, frame: &mut Frame, input: &BeyondInput, gloss: &GlossImages) -> Result<()> {
        let images = [&gloss.place, &gloss.seen, &gloss.ends];
        match (self, input) {
            (Self::Captures(pass), BeyondInput::Captures(input)) => pass.record_wide(frame, *input, images),
            (Self::Triangles(pass), BeyondInput::Triangles(input)) => pass.record_wide(frame, *input, images),
            _ => Ok(()), // The effect gives each pass the input of its kind.
        }
    }
}
