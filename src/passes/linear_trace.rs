//! Traces every ray by a linear march of thesis §4.2.2, and looks up the mirror's colour where the ray ends.

use super::traced::TracedPass;
use super::{GBuffer, HiZ, Hits, MarchNumbers, Reflection, march_constants};
use crate::error::Result;
use crate::gpu::programs::{Linear, LinearConstants};
use crate::gpu::shader::ThesisBlock;
use crate::gpu::{Frame, Gpu, Sampled, ShaderStage};
use ssct_ground::parameter::choices;

choices! {
    /// Which of the two listings marches.
    pub enum LinearMarch {
        /// The second: a stride that grows, and a binary search.
        Growing = "growing",
        /// The first: a constant stride, and nothing after it.
        Fixed = "fixed",
    }
}

/// Pipeline and images of one size.
pub struct LinearTracePass(TracedPass<Linear<'static>>);

impl LinearTracePass {
    /// Makes the pass. `hits` asks for an image of the hits.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        march: LinearMarch,
        numbers: MarchNumbers,
        hits: bool,
    ) -> Result<Self> {
        let constants = march_constants!(LinearConstants { fixed: march == LinearMarch::Fixed, hits }, numbers);
        Ok(Self(TracedPass::new(gpu, stage, extent, &constants, hits)?))
    }

    /// Records pass "ray trace". `depth` has the standard depth in level 0.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        depth: HiZ,
        parameters: &ThesisBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let program = Linear {
            thesis: parameters,
            hiZBuffer: Sampled::trilinear(depth.0.level(0)),
            normalBuffer: Sampled::nearest(gbuffer.normal.all()),
            materialBuffer: Sampled::nearest(gbuffer.material.all()),
            colorBuffer: Sampled::trilinear(gbuffer.color.level(0)),
        };
        self.0.draw(frame, "ray trace", &program)?;
        Ok(self.0.traced())
    }
}
