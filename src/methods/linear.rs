//! `linear`: every ray by a linear march (thesis §4.2.2), which `ssct` keeps for rays towards the camera,
//! and a mirror lookup where it ends: the method has no gloss.

use super::thesis::{self, Variant};
use super::{Input, Intermediate, Method, MethodInfo, Preset, Sees, Setup, Traced, Tuning};
use crate::error::Result;
use crate::gpu::{Frame, Gpu};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::linear_trace::{LinearTracePass, March};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "linear",
    summary: "linear march with a growing or constant stride, mirror lookup: no gloss",
    source: "Hermanns 2015, §4.2.2",
    sees: Sees::Screen,
    settings: |base| {
        let published = Setup { preset: Preset::Published, ..base };
        let fixed = Setup { march: March::Fixed, ..published };
        // A hundred steps that span the screen.
        let across = Setup { tuning: Tuning { march_stride: Some(0.01), ..Tuning::default() }, ..fixed };
        let author = Setup { preset: Preset::Author, ..base };
        [super::full_and_half(base), vec![author, fixed, across]].concat()
    },
    create: |gpu, setup| Ok(Box::new(LinearMethod::new(gpu, setup)?)),
};

struct LinearMethod {
    depth: HiZPass,
    trace: LinearTracePass,
    variant: Variant,
}

impl LinearMethod {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        Ok(Self {
            depth: HiZPass::depth_alone(gpu, setup.extent)?,
            trace: LinearTracePass::new(gpu, setup.extent, setup.march, setup.split)?,
            variant: Variant { preset: setup.preset, tuning: setup.tuning, fallback: true, fade: setup.fade },
        })
    }
}

impl Method for LinearMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let depth = self.depth.record(frame, gbuffer)?;
        let parameters = thesis::parameters(&self.variant, input.camera, gbuffer.depth.extent(), 1);
        let (reflection, hits) = self.trace.record(frame, gbuffer, depth, &parameters)?;
        let intermediates =
            vec![Intermediate { name: "standard-depth", content: Content::StandardDepth, image: depth.0 }];
        Ok(Traced { hits, intermediates, ..Traced::new(reflection) })
    }
}
