//! `sslr`: screen space local reflections, with which the thesis compares its own method (§4.3, after Killzone Shadow
//! Fall): a uniform march, a mask of the hits, and blurred chains of both.

use super::thesis::{self, UniformMarchParams};
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, MethodRequest};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Sampler};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::mask_chain::{MaskChainPass, MaskFilter};
use crate::passes::sslr_reflection::SslrReflectionPass;
use crate::passes::sslr_trace::SslrTracePass;
use ssct_ground::parameter::{Parameter, Parameters, choices, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    // The last pass reads colours alone, and does not know how far the hits are from the border.
    fades: false,
    parameters: SslrParams::table,
    ..MethodInfo::screen(
        "sslr",
        "uniform march with a stride by roughness, masked blur chain, one lookup in it",
        "Hermanns 2015, §4.3; Valient, Killzone Shadow Fall",
        |gpu, request| Ok(Box::new(SslrMethod::new(gpu, request)?)),
    )
};

choices! {
    /// How the march of `sslr` reads depth.
    pub enum DepthSampling {
        /// Between the texels: with the nearest, a ray whose first step stays in its pixel hits that very pixel.
        Linear = "linear",
        /// The nearest texel.
        Nearest = "nearest",
    }
}

parameters! {
    /// Parameters of `sslr`.
    pub struct SslrParams {
        /// Parameters of the march.
        march: UniformMarchParams,
        /// How the chains of ray trace colour and mask are filtered. The author's program leaves its blur shaders out
        /// and lets the GPU make the chains.
        mask_filter: MaskFilter =
            Parameter::new(MaskFilter::Weighted).author(MaskFilter::Hardware).source("§4.3.2"),
        /// How the march reads depth.
        depth_sampling: DepthSampling = Parameter::new(DepthSampling::Linear)
            .author(DepthSampling::Nearest)
            .source("not printed"),
        /// Factor on the level of the chain that a reflection reads. The author's is twice the chain's length, and five
        /// times the ray's.
        spreading_factor: f32 = Parameter::new(1.0).author(10.0).above(0.0, 1000.0).source("§4.3.3"),
    }
}

struct SslrMethod {
    depth: HiZPass,
    trace: SslrTracePass,
    chain: MaskChainPass,
    reflection: SslrReflectionPass,
    parameters: SslrParams,
}

impl SslrMethod {
    fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let (extent, stage) = (request.setup.extent, request.setup.stage());
        let parameters: SslrParams = request.setup.parameters();
        let trace = SslrTracePass::new(gpu, stage, extent, parameters.march.uniform_steps, request.hits)?;
        Ok(Self {
            depth: HiZPass::depth_alone(gpu, stage, extent)?,
            chain: MaskChainPass::new(gpu, stage, extent, trace.formats(), parameters.mask_filter)?,
            trace,
            reflection: SslrReflectionPass::new(gpu, stage, extent)?,
            parameters,
        })
    }
}

impl Method for SslrMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = &input.gbuffer;
        let depth = input.in_first_bounce(|| self.depth.record(frame, gbuffer), || self.depth.recorded())?;
        let parameters = self.parameters;
        let (levels, fades) = (1, false);
        let block = parameters.march.fill(thesis::block(input.camera, gbuffer.depth.extent(), levels, fades));
        let sampler = match parameters.depth_sampling {
            DepthSampling::Linear => Sampler::TrilinearClamp,
            DepthSampling::Nearest => Sampler::NearestClamp,
        };
        let (traced, hits) = self.trace.record(frame, gbuffer, depth, sampler, &block)?;
        let chain = self.chain.record(frame, traced)?;
        let reflection = self.reflection.record(frame, gbuffer, chain, parameters.spreading_factor)?;
        let intermediate = |name, content, image| Intermediate { name, content, image };
        let intermediates = vec![
            intermediate("standard-depth", Content::StandardDepth, depth.0),
            intermediate("ray-trace-color", Content::Color, chain.color),
            intermediate("mask", Content::Share, chain.mask),
        ];
        Ok(MethodOutput { hits, intermediates, ..MethodOutput::new(reflection) })
    }
}
