//! `ssct`: Hi-Z tracing, a linear march for rays towards the camera, and cone tracing (thesis ch. 4).
//! `hzct` leaves the march out. [`ThesisMethod`] implements both methods.

use super::thesis::{self, ConeParams, FadeParams, HiZParams, MarchParams};
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, MethodRequest, Setup, Wants};
use crate::error::Result;
use crate::gpu::shader::ThesisBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::color_chain::{ChainFilter, ChainMask, ColorChainPass};
use crate::passes::hi_z::HiZPass;
use crate::passes::thesis_trace::{ThesisTracePass, TraceInput};
use crate::passes::visibility::VisibilityPass;
use crate::passes::{Content, GBuffer, Hits, MarchNumbers, Reflection};
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};
use ssct_ground::scene::Camera;

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    traces_hi_z: true,
    parameters: SsctParams::table,
    ..MethodInfo::screen(
        "ssct",
        "Hi-Z tracing, linear fallback for rays towards the camera, cone tracing",
        "Hermanns 2015, ch. 4",
        |gpu, request| {
            let parameters: SsctParams = request.setup.parameters();
            let march = Some(parameters.march.numbers());
            Ok(Box::new(ThesisMethod::new(gpu, request, parameters.drawn, march, parameters.fill_function())?))
        },
    )
};

parameters! {
    /// Parameters of `ssct`.
    pub struct SsctParams {
        /// Parameters of the Hi-Z traversal.
        hi_z: HiZParams,
        /// Parameters of the march of rays towards the camera.
        march: MarchParams,
        /// Parameters of the cone trace.
        cone: ConeParams,
        /// Where reflections fade.
        border: FadeParams,
        /// How the passes are made.
        drawn: ThesisDrawing,
    }
}

parameters! {
    /// How the passes of `ssct` and `hzct` are made.
    pub struct ThesisDrawing {
        /// How the colour chain is filtered.
        chain_filter: ChainFilter = Parameter::new(ChainFilter::Hardware)
            .sweep(Preset::Published, &[ChainFilter::Gaussian])
            .source("§4.2.6"),
        /// What the blur of the colour chain leaves out. A mask needs the Gaussian, which then filters the chain.
        chain_mask: ChainMask =
            Parameter::new(ChainMask::None).source("Hermanns 2015, ch. 6 and §4.3.2; not which mask"),
        /// Greatest difference of depths that the mask by surfaces takes for one surface, as a part of the lesser
        /// depth.
        chain_mask_tolerance: f32 = Parameter::new(0.1).above(0.0, 1.0).source("this project"),
        /// The Hi-Z buffer keeps the maximum of depth beside the minimum. Nothing reads it.
        hi_z_maximum: bool = Parameter::new(false).author(true).source("§4.2.4: the minimum"),
        /// Trace rays and cones in two passes instead of one.
        split: bool = Parameter::new(false).source("§4.2.3: combined"),
    }
}

impl SsctParams {
    /// Returns a function that fills in those members of a block that these parameters decide.
    fn fill_function(self) -> Fill {
        Box::new(move |block| self.border.fill(self.cone.fill(self.march.fill(self.hi_z.fill(block)))))
    }
}

/// A function that fills in those members of a uniform block that the parameters of a method decide.
pub(super) type Fill = Box<dyn Fn(ThesisBlock) -> ThesisBlock + Send>;

/// The thesis's passes in their order.
pub struct ThesisMethod {
    hi_z: HiZPass,
    visibility: VisibilityPass,
    color: ColorChainPass,
    trace: ThesisTracePass,
    fade: bool,
    fill: Fill,
}

impl ThesisMethod {
    /// Makes the method with a linear march as the fallback (`ssct`) or without one (`hzct`).
    pub(super) fn new(
        gpu: &Gpu,
        request: &MethodRequest,
        drawn: ThesisDrawing,
        march: Option<MarchNumbers>,
        fill: Fill,
    ) -> Result<Self> {
        let (extent, stage) = (request.setup.extent, request.setup.stage());
        Ok(Self {
            hi_z: HiZPass::new(gpu, stage, extent, drawn.hi_z_maximum)?,
            visibility: VisibilityPass::new(gpu, stage, extent)?,
            color: ColorChainPass::masked(
                gpu,
                stage,
                extent,
                drawn.chain_filter,
                (drawn.chain_mask, drawn.chain_mask_tolerance),
            )?,
            trace: ThesisTracePass::new(gpu, stage, extent, march, drawn.split, request.hits)?,
            fade: request.setup.effect().fade,
            fill,
        })
    }

    /// Makes the chains and the cone trace alone, which [`Self::record_cone`] records for the hits of any tracer.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn cone_alone(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        let parameters: SsctParams = setup.parameters();
        let request = MethodRequest::new(setup, Wants { hits: true, reflection: true, composite: false });
        // Only split passes have a cone trace that can be recorded alone.
        let drawn = ThesisDrawing { split: true, ..parameters.drawn };
        Self::new(gpu, &request, drawn, Some(parameters.march.numbers()), parameters.fill_function())
    }

    /// Records the chains and the cone trace for the hits of any tracer, for a method made by [`Self::cone_alone`].
    pub fn record_cone<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer<'a>,
        camera: &Camera,
        hits: Hits,
    ) -> Result<Reflection<'a>> {
        let (input, parameters) = self.chains(frame, &Input::of_screen(*gbuffer, camera))?;
        self.trace.record_cone(frame, &input, &parameters, hits)
    }

    /// Records the chains that ray trace and cone trace read, and returns them with the uniform block of both.
    fn chains<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<(TraceInput<'a>, ThesisBlock)> {
        let (gbuffer, camera) = (&input.gbuffer, input.camera);
        let hi_z = input.in_first_bounce(|| self.hi_z.record(frame, gbuffer), || self.hi_z.recorded())?;
        let visibility = input
            .in_first_bounce(|| self.visibility.record(frame, hi_z, &camera.lens), || self.visibility.recorded())?;
        let color = self.color.record_masked(frame, gbuffer, hi_z, &camera.lens)?;
        let block = thesis::block(camera, gbuffer.depth.extent(), hi_z.0.levels(), self.fade);
        Ok((TraceInput { gbuffer: *gbuffer, hi_z, visibility, color }, (self.fill)(block)))
    }
}

impl Method for ThesisMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let (chains, parameters) = self.chains(frame, input)?;
        // In later bounces the rays are already traced, over the same depth and normals.
        let (reflection, hits) = self.trace.record(frame, &chains, &parameters, input.bounce > 0)?;
        let intermediate = |name, content, image| Intermediate { name, content, image };
        let intermediates = vec![
            intermediate("hi-z", Content::StandardDepth, chains.hi_z.0),
            intermediate("visibility", Content::Share, chains.visibility.0),
        ];
        Ok(MethodOutput { hits, intermediates, ..MethodOutput::new(reflection) })
    }
}
