//! `linear`: traces every ray by the linear march of thesis §4.2.2, which `ssct` uses for rays towards the camera
//! alone. The colour is a mirror's: the method has no gloss.

use super::thesis::{self, FadeParams, MarchParams};
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, MethodRequest};
use crate::error::Result;
use crate::gpu::{Frame, Gpu};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::linear_trace::{LinearMarch, LinearTracePass};
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    parameters: LinearParams::table,
    ..MethodInfo::screen(
        "linear",
        "linear march with a growing or constant stride, mirror lookup: no gloss",
        "Hermanns 2015, §4.2.2",
        |gpu, request| Ok(Box::new(LinearMethod::new(gpu, request)?)),
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
    fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let (extent, stage) = (request.setup.extent, request.setup.stage());
        let parameters: LinearParams = request.setup.parameters();
        Ok(Self {
            depth: HiZPass::depth_alone(gpu, stage, extent)?,
            trace: LinearTracePass::new(
                gpu,
                stage,
                extent,
                parameters.march,
                parameters.numbers.numbers(),
                request.hits,
            )?,
            numbers: parameters.numbers,
            border: parameters.border,
            fade: request.setup.effect().fade,
        })
    }
}

impl Method for LinearMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = &input.gbuffer;
        let depth = input.in_first_bounce(|| self.depth.record(frame, gbuffer), || self.depth.recorded())?;
        let levels = 1;
        let block = thesis::block(input.camera, gbuffer.depth.extent(), levels, self.fade);
        let parameters = self.border.fill(self.numbers.fill(block));
        let (reflection, hits) = self.trace.record(frame, gbuffer, depth, &parameters)?;
        let intermediates =
            vec![Intermediate { name: "standard-depth", content: Content::StandardDepth, image: depth.0 }];
        Ok(MethodOutput { hits, intermediates, ..MethodOutput::new(reflection) })
    }
}
