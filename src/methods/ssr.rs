//! `ssr`: a march along the reflection in screen space, with one sample for each pixel on the way (Schmidt 2013,
//! section 5.4, listing 4). `ssr-fast` uses the march of listing 5 instead. [`SchmidtMethod`] implements both methods.

use super::layers::LayerParams;
use super::{Input, Method, MethodInfo, MethodOutput, MethodRequest};
use crate::error::Result;
use crate::gpu::shader::SchmidtBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::LIT_COLOR;
use crate::passes::color_chain::{ChainFilter, ColorChainPass};
use crate::passes::schmidt_trace::{SchmidtMarch, SchmidtTracePass};
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    parameters: SsrParams::table,
    ..MethodInfo::screen(
        "ssr",
        "march along the reflection in screen space, a sample a pixel; mirrors only",
        "Schmidt 2013, §5.4, listing 4",
        |gpu, request| {
            let SsrParams { pixel_step, .. } = request.setup.parameters();
            Ok(Box::new(SchmidtMethod::new(gpu, request, SchmidtMarch::PerPixel, pixel_step, None)?))
        },
    )
};

parameters! {
    /// Parameters of `ssr`.
    pub struct SsrParams {
        /// Pixels that the march goes at once.
        pixel_step: u32 = Parameter::new(1)
            .within(1, 1024)
            .unit("pixels")
            .sweep(Preset::Published, &[2, 4, 8])
            .source("Schmidt 2013, listing 4"),
        /// Layers of depth.
        layers: LayerParams,
    }
}

/// Schmidt's screen-space reflections, which ignore roughness: every reflection is that of a mirror.
pub struct SchmidtMethod {
    /// The colour chain, of which the blur reads a coarse level; `None` without the blur.
    chain: Option<ColorChainPass>,
    /// The chain of the second layer; `None` if there is one layer, or no chain.
    second_chain: Option<ColorChainPass>,
    trace: SchmidtTracePass,
    parameters: SchmidtBlock,
}

impl SchmidtMethod {
    /// Makes the method with the march of listing 4 or 5. Only listing 5 has a blur, which reads a mip chain of the lit
    /// colour. `blur` says how this chain is filtered; `None` leaves the blur out.
    pub(super) fn new(
        gpu: &Gpu,
        request: &MethodRequest,
        march: SchmidtMarch,
        pixel_step: u32,
        blur: Option<ChainFilter>,
    ) -> Result<Self> {
        let (extent, fade, stage) = (request.setup.extent, request.setup.effect().fade, request.setup.stage());
        let has_second_layer = request.setup.parameters::<LayerParams>().has_second();
        let make_chain = || blur.map(|filter| ColorChainPass::new(gpu, stage, extent, LIT_COLOR, filter)).transpose();
        Ok(Self {
            chain: make_chain()?,
            second_chain: if has_second_layer { make_chain()? } else { None },
            trace: SchmidtTracePass::new(gpu, stage, extent, march, request.hits, has_second_layer)?,
            parameters: SchmidtBlock {
                user_pixelStepSize: pixel_step as f32,
                fadeToEdges: i32::from(fade),
                toggleBlur: i32::from(blur.is_some()),
            },
        })
    }
}

impl Method for SchmidtMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = &input.gbuffer;
        let color = match &self.chain {
            Some(chain) => chain.record(frame, gbuffer)?.0.all(),
            None => gbuffer.color.level(0),
        };
        let second_layer = match (&self.second_chain, &input.second_layer) {
            (Some(chain), Some(layer)) => Some((layer, chain.record(frame, layer)?.0.all())),
            (None, Some(layer)) => Some((layer, layer.color.level(0))),
            (_, None) => None,
        };
        let (reflection, hits) =
            self.trace.record(frame, gbuffer, color, second_layer, input.camera, &self.parameters)?;
        Ok(MethodOutput { hits, ..MethodOutput::new(reflection) })
    }
}
