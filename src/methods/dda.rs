//! `dda`: traces every ray by a march over pixels with a constant thickness (McGuire and Mara, "Efficient GPU
//! Screen-Space Ray Tracing", JCGT 2014), as most engines do. The colour is a mirror's: the method has no gloss.

use super::layers::LayerParams;
use super::thesis::{FadeParams, UNBOUNDED};
use super::{Input, Method, MethodInfo, MethodOutput, MethodRequest};
use crate::error::Result;
use crate::gpu::shader::DdaBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::dda_trace::DdaTracePass;
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    parameters: DdaParams::table,
    ..MethodInfo::screen(
        "dda",
        "perspective-correct march over pixels with a constant thickness, mirror lookup: no gloss",
        "McGuire and Mara 2014",
        |gpu, request| Ok(Box::new(DdaMethod::new(gpu, request)?)),
    )
};

/// The source of values that the paper leaves to its user.
const TUNED: &str = "McGuire and Mara 2014 leave it open; tuned (docs/findings.md)";

parameters! {
    /// Parameters of `dda`.
    pub struct DdaParams {
        /// Pixels along the longer axis of the ray from one sample to the next.
        dda_stride: u32 = Parameter::new(4)
            .within(1, 64)
            .unit("pixels")
            .sweep(Preset::Published, &[1, 16])
            .source(TUNED),
        /// Assumed thickness of every surface along the view; deeper rays pass behind it.
        dda_thickness: f32 = Parameter::new(0.25)
            .between(0.0, 1000.0)
            .unit("m")
            .sweep(Preset::Published, &[0.05, 0.1, 0.5, 1.0])
            .source(TUNED),
        /// Samples are shifted along the ray by up to half a stride, from pixel to pixel in a fixed pattern of 4 × 4,
        /// so that bands become noise.
        dda_jitter: bool = Parameter::new(false)
            .sweep(Preset::Published, &[true])
            .source(TUNED),
        /// A hit is searched for by halves within the step that found it, and must stand up there. Steps in which the
        /// ray goes behind what is seen are searched, too.
        dda_refine: bool = Parameter::new(true)
            .sweep(Preset::Published, &[false])
            .source("not in McGuire and Mara 2014; as engines do"),
        /// Samples of a ray at most; a ray that needs more is a miss.
        dda_steps: u32 = Parameter::new(UNBOUNDED).within(1, 65536).source("McGuire and Mara 2014 leave it open"),
        /// Length at which a ray ends.
        dda_distance: f32 = Parameter::new(1000.0)
            .above(0.0, 1e6)
            .unit("m")
            .source("McGuire and Mara 2014 leave it open; the far plane of the default lens"),
        /// Where reflections fade.
        border: FadeParams,
        /// Layers of depth.
        layers: LayerParams,
    }
}

struct DdaMethod {
    trace: DdaTracePass,
    parameters: DdaBlock,
}

impl DdaMethod {
    fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let (setup, p) = (&request.setup, request.setup.parameters::<DdaParams>());
        let [fade_start, fade_end] = p.border.ends();
        Ok(Self {
            trace: DdaTracePass::new(
                gpu,
                setup.stage(),
                setup.extent,
                [p.dda_jitter, p.dda_refine],
                p.layers.layers,
                request.hits,
            )?,
            parameters: DdaBlock {
                stride: p.dda_stride as f32,
                thickness: p.dda_thickness,
                longest: p.dda_distance,
                steps: p.dda_steps as i32,
                fade_start,
                fade_end,
                fade: i32::from(setup.effect().fade),
            },
        })
    }
}

impl Method for DdaMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let (reflection, hits) =
            self.trace.record(frame, &input.gbuffer, input.second_layer.as_ref(), input.camera, &self.parameters)?;
        Ok(MethodOutput { hits, ..MethodOutput::new(reflection) })
    }
}
