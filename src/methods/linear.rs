//! `linear`: every ray by a linear march (thesis §4.2.2), which `ssct` keeps for rays towards the camera,
//! and a mirror lookup where it ends: the method has no gloss.

use super::thesis::{self, FadeParams, MarchParams};
use super::{Input, Intermediate, Making, Method, MethodInfo, Traced};
use crate::error::Result;
use crate::gpu::{Frame, Gpu};
use crate::parameter::{Parameter, Parameters, Preset, parameters};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::linear_trace::{LinearMarch, LinearTracePass};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    parameters: LinearParams::table,
    // A hundred steps that span the screen.
    combinations: |base| {
        vec![base.with(|p: &mut LinearParams| {
            (p.march, p.numbers.march_stride) = (LinearMarch::Fixed, 0.01);
        })]
    },
    ..MethodInfo::screen(
        "linear",
        "linear march with a growing or constant stride, mirror lookup: no gloss",
        "Hermanns 2015, §4.2.2",
        |gpu, making| Ok(Box::new(LinearMethod::new(gpu, making)?)),
    )
};

parameters! {
    /// Parameters of `linear`.
    pub struct LinearParams {
        /// Which of the thesis's two listings the method linear marches by.
        march: LinearMarch = Parameter::new(LinearMarch::Growing)
            .sweep(Preset::Published, &[LinearMarch::Fixed])
            .source("§4.2.2"),
        /// Parameters of the march.
        numbers: MarchParams,
        /// Where reflections fade.
        border: FadeParams,
    }
}

struct LinearMethod {
    depth: HiZPass,
    trace: LinearTracePass,
    numbers: MarchParams,
    border: FadeParams,
    fade: bool,
}

impl LinearMethod {
    fn new(gpu: &Gpu, making: &Making) -> Result<Self> {
        let (extent, stage) = (making.setup.extent, making.setup.stage());
        let parameters: LinearParams = making.setup.of();
        Ok(Self {
            depth: HiZPass::depth_alone(gpu, stage, extent)?,
            trace: LinearTracePass::new(
                gpu,
                stage,
                extent,
                parameters.march,
                parameters.numbers.numbers(),
                making.hits,
            )?,
            numbers: parameters.numbers,
            border: parameters.border,
            fade: making.setup.effect().fade,
        })
    }
}

impl Method for LinearMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let depth = input.once(|| self.depth.record(frame, gbuffer), || self.depth.made())?;
        let block = thesis::block(input.camera, gbuffer.depth.extent(), 1, self.fade);
        let parameters = self.border.fill(self.numbers.fill(block));
        let (reflection, hits) = self.trace.record(frame, gbuffer, depth, &parameters)?;
        let intermediates =
            vec![Intermediate { name: "standard-depth", content: Content::StandardDepth, image: depth.0 }];
        Ok(Traced { hits, intermediates, ..Traced::new(reflection) })
    }
}
