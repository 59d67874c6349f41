//! `ssr`: a march along the reflection in screen space, a sample a pixel (Schmidt 2013, section 5.4,
//! listing 4). `ssr-fast` is the same with the march of listing 5; both are [`SchmidtMethod`].

use super::{Input, Method, MethodInfo, Sees, Setup, Traced, Tuning};
use crate::error::Result;
use crate::gpu::shader::SchmidtBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::LIT_COLOR;
use crate::passes::color_chain::ColorChainPass;
use crate::passes::schmidt_trace::{March, SchmidtTracePass};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "ssr",
    summary: "march along the reflection in screen space, a sample a pixel; mirrors only",
    source: "Schmidt 2013, §5.4, listing 4",
    sees: Sees::Screen,
    settings: |base| [super::full_and_half(base), steps(base, &[2, 4, 8])].concat(),
    create: |gpu, setup| Ok(Box::new(SchmidtMethod::new(gpu, setup, March::PerPixel)?)),
};

/// A base with each of some strides of the march, in pixels.
pub fn steps(base: Setup, pixels: &[u32]) -> Vec<Setup> {
    let with = |n: &u32| Setup { tuning: Tuning { pixel_step: Some(*n), ..Tuning::default() }, ..base };
    pixels.iter().map(with).collect()
}

/// Schmidt's screen-space reflections. They know no roughness: every reflection is a mirror's.
pub struct SchmidtMethod {
    /// The blur reads a coarse level of the lit colour; without it there is no chain.
    chain: Option<ColorChainPass>,
    trace: SchmidtTracePass,
    parameters: SchmidtBlock,
}

impl SchmidtMethod {
    /// With the march of listing 4 or 5. Of the two, listing 5 alone has the blur.
    pub fn new(gpu: &Gpu, setup: &Setup, march: March) -> Result<Self> {
        let blur = setup.tuning.distance_blur && march == March::Optimized;
        let chain = || ColorChainPass::new(gpu, setup.extent, LIT_COLOR, setup.chain_filter);
        Ok(Self {
            chain: blur.then(chain).transpose()?,
            trace: SchmidtTracePass::new(gpu, setup.extent, march, setup.split)?,
            parameters: SchmidtBlock {
                user_pixelStepSize: setup.tuning.pixel_step.unwrap_or(1) as f32,
                fadeToEdges: i32::from(setup.fade),
                toggleBlur: i32::from(blur),
            },
        })
    }
}

impl Method for SchmidtMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let diffuse = match &self.chain {
            Some(chain) => chain.record(frame, gbuffer)?.0.all(),
            None => gbuffer.color.level(0),
        };
        let (reflection, hits) = self.trace.record(frame, gbuffer, diffuse, input.camera, &self.parameters)?;
        Ok(Traced { hits, ..Traced::new(reflection) })
    }
}
