//! `sslr`: screen space local reflections as the thesis sets them against its own method (§4.3, after
//! Killzone Shadow Fall): uniform march, mask, blurred chain.

use super::thesis::{self, Preset, Variant};
use super::{Input, Intermediate, Method, MethodInfo, Sees, Setup, Traced};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Sampler};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::mask_chain::{MaskChainPass, MaskFilter};
use crate::passes::sslr_reflection::SslrReflectionPass;
use crate::passes::sslr_trace::SslrTracePass;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "sslr",
    summary: "uniform march with a stride by roughness, masked blur chain, one lookup in it",
    source: "Hermanns 2015, §4.3; Valient, Killzone Shadow Fall",
    sees: Sees::Screen,
    settings: |base| {
        let author = Setup { preset: Preset::Author, ..base };
        [super::full_and_half(base), vec![author]].concat()
    },
    create: |gpu, setup| Ok(Box::new(SslrMethod::new(gpu, setup)?)),
};

struct SslrMethod {
    depth: HiZPass,
    trace: SslrTracePass,
    chain: MaskChainPass,
    reflection: SslrReflectionPass,
    variant: Variant,
}

impl SslrMethod {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        let filter = match setup.preset {
            Preset::Published => MaskFilter::Weighted,
            // The author's program leaves its blur shaders out and lets the GPU make the chains.
            Preset::Author => MaskFilter::Hardware,
        };
        let trace = SslrTracePass::new(gpu, setup.extent, setup.split)?;
        Ok(Self {
            depth: HiZPass::depth_alone(gpu, setup.extent)?,
            chain: MaskChainPass::new(gpu, setup.extent, trace.formats(), filter)?,
            trace,
            reflection: SslrReflectionPass::new(gpu, setup.extent)?,
            // It has no fade: it keeps no hit whose distance from the border could be known.
            variant: Variant { preset: setup.preset, tuning: setup.tuning, fallback: true, fade: false },
        })
    }
}

impl Method for SslrMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let depth = self.depth.record(frame, gbuffer)?;
        let parameters = thesis::parameters(&self.variant, input.camera, gbuffer.depth.extent(), 1);
        let (depth_sampler, spreading_factor) = match self.variant.preset {
            // With nearest sampling a ray whose first step stays in its pixel hits that very pixel.
            Preset::Published => (Sampler::TrilinearClamp, 1.0),
            // Twice the chain's length, and five times the ray's.
            Preset::Author => (Sampler::NearestClamp, 10.0),
        };
        let (traced, hits) = self.trace.record(frame, gbuffer, depth, depth_sampler, &parameters)?;
        let chain = self.chain.record(frame, traced)?;
        let reflection = self.reflection.record(frame, gbuffer, chain, spreading_factor)?;
        let made = |name, content, image| Intermediate { name, content, image };
        let intermediates = vec![
            made("standard-depth", Content::StandardDepth, depth.0),
            made("ray-trace-color", Content::Color, chain.color),
            made("mask", Content::Share, chain.mask),
        ];
        Ok(Traced { hits, intermediates, ..Traced::new(reflection) })
    }
}
