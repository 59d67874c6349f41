//! Ray trace and cone trace of `ssct` and `hzct` (thesis §4.2.2, 4.2.7–4.2.10), in one shader as in the thesis, or
//! split in two.

use super::{ColorChain, GBuffer, HITS, HiZ, Hits, MarchNumbers, Reflection, Visibility, march_constants};
use crate::error::{Error, Result};
use crate::gpu::programs::{ConeTrace, RayTrace, RayTraceConstants, Ssct, SsctConstants};
use crate::gpu::shader::ThesisBlock;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target};
use ash::vk;

const REFLECTION: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipelines and images of one size.
pub struct ThesisTracePass {
    stages: Stages,
    reflection: Image,
    hits: Option<Image>,
}

/// Ray trace and cone trace, in one program or in two.
enum Stages {
    Combined(PixelPipeline<Ssct<'static>>),
    Split { trace: PixelPipeline<RayTrace<'static>>, cone: PixelPipeline<ConeTrace<'static>> },
}

/// The inputs of the pass.
#[derive(Clone, Copy)]
pub struct TraceInput<'a> {
    /// Normals and materials.
    pub gbuffer: GBuffer<'a>,
    /// The Hi-Z chain of standard depth.
    pub hi_z: HiZ<'a>,
    /// The visibility chain.
    pub visibility: Visibility<'a>,
    /// The colour chain.
    pub color: ColorChain<'a>,
}

impl ThesisTracePass {
    /// Makes the pass. Rays towards the camera march by the numbers of `march`; with `None` they are not traced.
    /// `split` makes ray trace and cone trace two passes, which always have an image of the hits; `hits` asks for one.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        march: Option<MarchNumbers>,
        split: bool,
        hits: bool,
    ) -> Result<Self> {
        let (fallback, march) = (march.is_some(), march.unwrap_or_default());
        let image = |name, format| Image::target_in(gpu, stage, name, format, extent);
        let stages = if split {
            Stages::Split {
                trace: PixelPipeline::new(
                    gpu,
                    stage,
                    [HITS],
                    &march_constants!(RayTraceConstants { fallback }, march),
                )?,
                cone: PixelPipeline::new(gpu, stage, [REFLECTION], &())?,
            }
        } else {
            let formats = [REFLECTION, if hits { HITS } else { vk::Format::UNDEFINED }];
            let constants = march_constants!(SsctConstants { fallback, hits }, march);
            Stages::Combined(PixelPipeline::new(gpu, stage, formats, &constants)?)
        };
        Ok(Self {
            stages,
            reflection: image("reflection", REFLECTION)?,
            hits: (split || hits).then(|| image("hits", HITS)).transpose()?,
        })
    }

    /// Records pass "trace+cone", or passes "ray trace" and "cone trace". `is_traced` says that the rays were already
    /// traced over the same depth and normals; if the pass is split, only the cone trace is then recorded.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        input: &TraceInput,
        parameters: &ThesisBlock,
        is_traced: bool,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let hits = self.hits.as_ref().map(Hits);
        let hits_target = self.hits.as_ref().map_or(Target::unwanted(), |image| Target::overwrite(image.all()));
        match &self.stages {
            Stages::Combined(pipeline) => frame.pixels(
                "trace+cone",
                pipeline,
                [Target::overwrite(self.reflection.all()), hits_target],
                &Ssct {
                    thesis: parameters,
                    hiZBuffer: Sampled::nearest(input.hi_z.0.all()),
                    normalBuffer: Sampled::nearest(input.gbuffer.normal.all()),
                    materialBuffer: Sampled::nearest(input.gbuffer.material.all()),
                    colorBuffer: Sampled::trilinear(input.color.0.all()),
                    visibilityBuffer: Sampled::trilinear(input.visibility.0.all()),
                },
            )?,
            Stages::Split { trace, .. } => {
                let program = RayTrace {
                    thesis: parameters,
                    hiZBuffer: Sampled::nearest(input.hi_z.0.all()),
                    normalBuffer: Sampled::nearest(input.gbuffer.normal.all()),
                    materialBuffer: Sampled::nearest(input.gbuffer.material.all()),
                };
                if !is_traced {
                    frame.pixels("ray trace", trace, [hits_target], &program)?;
                }
                if let Some(hits) = hits {
                    self.record_cone(frame, input, parameters, hits)?;
                }
            }
        }
        Ok((Reflection(&self.reflection), hits))
    }

    /// Records pass "cone trace" alone, over hits that any tracer may have found.
    ///
    /// # Errors
    /// [`Error::Usage`] if the pass was made combined.
    pub fn record_cone<'a>(
        &'a self,
        frame: &mut Frame,
        input: &TraceInput,
        parameters: &ThesisBlock,
        hits: Hits,
    ) -> Result<Reflection<'a>> {
        let Stages::Split { cone, .. } = &self.stages else {
            return Err(Error::Usage("the cone trace alone needs ray trace and cone trace as two passes".into()));
        };
        let program = ConeTrace {
            thesis: parameters,
            hiZBuffer: Sampled::nearest(input.hi_z.0.all()),
            normalBuffer: Sampled::nearest(input.gbuffer.normal.all()),
            materialBuffer: Sampled::nearest(input.gbuffer.material.all()),
            colorBuffer: Sampled::trilinear(input.color.0.all()),
            visibilityBuffer: Sampled::trilinear(input.visibility.0.all()),
            hitBuffer: Sampled::nearest(hits.0.all()),
        };
        frame.pixels("cone trace", cone, [Target::overwrite(self.reflection.all())], &program)?;
        Ok(Reflection(&self.reflection))
    }
}
