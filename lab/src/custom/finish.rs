//! Converts the images of a method from a folder into the images that every method returns: the reflection with its
//! fade, and hits.

use super::manifest::{Alpha, HitEncoding, Manifest, format_of};
use super::values::FrameState;
use ssct::error::Result;
use ssct::gpu::program::Sampled;
use ssct::gpu::programs::{CustomHits, CustomReflection};
use ssct::gpu::shader::{CustomHitsBlock, CustomOutputBlock};
use ssct::gpu::{Frame, Gpu, GraphicsPipeline, Image, ShaderStage, Target};
use ssct::methods::Input;
use ssct::passes::hi_z::HiZPass;
use ssct::passes::{HITS, LIT_COLOR};
use ssct_ground::math::constants::{
    ALPHA_FADE, ALPHA_NONE, ALPHA_PREMULTIPLIED, HITS_PIXEL, HITS_UV, HITS_UV_DEPTH, HITS_UV_MASKED, HITS_VIEW,
};

/// The passes that make the reflection, and hits if they are wanted, from the method's images.
pub struct Finish {
    /// The conversion of the reflection; `None` if the method's own image is used without a change.
    reflection: Option<ReflectionConversion>,
    /// The conversion of hits; `None` if hits are not wanted, or are used without a change.
    hits: Option<HitsConversion>,
    /// True if the method encodes hits as the project's own methods do, so that the method's image of hits is used without a change.
    has_our_hits: bool,
}

/// The pass that converts a method's image of the reflection.
struct ReflectionConversion {
    pipeline: GraphicsPipeline<CustomReflection<'static>>,
    target: Image,
    /// The meaning of the fourth channel, a code `ALPHA_*`.
    alpha: i32,
}

/// The passes that convert a method's image of hits.
struct HitsConversion {
    /// The pass that makes standard depth.
    depth: HiZPass,
    pipeline: GraphicsPipeline<CustomHits<'static>>,
    target: Image,
    /// The encoding of the method's hits, a code `HITS_*`.
    encoding: i32,
}

impl Finish {
    /// Makes the passes for images of `extent` pixels; `hits` says whether hits are wanted.
    pub fn new(gpu: &Gpu, manifest: &Manifest, extent: [u32; 2], hits: bool) -> Result<Self> {
        let output = &manifest.output;
        let section = &manifest.images[&output.reflection];
        let has_our_reflection =
            output.alpha == Alpha::Fade && section.scale == 1.0 && format_of(&section.format) == Some(LIT_COLOR);
        let alpha = match output.alpha {
            Alpha::Fade => ALPHA_FADE,
            Alpha::Premultiplied => ALPHA_PREMULTIPLIED,
            Alpha::None => ALPHA_NONE,
        };
        let reflection = (!has_our_reflection)
            .then(|| -> Result<_> {
                let target = Image::target(gpu, "reflection", LIT_COLOR, extent)?;
                Ok(ReflectionConversion { pipeline: GraphicsPipeline::fullscreen(gpu, [LIT_COLOR])?, target, alpha })
            })
            .transpose()?;
        let encoding = match output.hits_are {
            HitEncoding::Uv => HITS_UV,
            HitEncoding::UvMasked => HITS_UV_MASKED,
            HitEncoding::UvDepth | HitEncoding::UvDepthPath => HITS_UV_DEPTH,
            HitEncoding::Pixel => HITS_PIXEL,
            HitEncoding::ViewPosition => HITS_VIEW,
        };
        let has_our_encoding = output.hits_are == HitEncoding::UvDepthPath;
        let wants_hits = hits && output.hits.is_some();
        let hits = (wants_hits && !has_our_encoding)
            .then(|| -> Result<_> {
                let target = Image::target(gpu, "hits", HITS, extent)?;
                Ok(HitsConversion {
                    depth: HiZPass::depth_alone(gpu, ShaderStage::Fragment, extent)?,
                    pipeline: GraphicsPipeline::fullscreen(gpu, [HITS])?,
                    target,
                    encoding,
                })
            })
            .transpose()?;
        Ok(Self { reflection, hits, has_our_hits: wants_hits && has_our_encoding })
    }

    /// Makes the reflection from `drawn`, the image into which the method drew it.
    pub fn reflection<'a>(&'a self, frame: &mut Frame, input: &Input<'_, '_>, drawn: &'a Image) -> Result<&'a Image> {
        let Some(ReflectionConversion { pipeline, target, alpha }) = &self.reflection else { return Ok(drawn) };
        let extent = input.gbuffer.depth.extent();
        let resolution = extent.map(|v| v as f32);
        let block = CustomOutputBlock { resolution, alpha: *alpha, ..CustomOutputBlock::default() };
        let level = drawn.level(0);
        let has_same_size = drawn.extent() == extent;
        let program = CustomReflection {
            reflection_buffer: if has_same_size { Sampled::nearest(level) } else { Sampled::trilinear(level) },
            material_buffer: Sampled::nearest(input.gbuffer.material.all()),
            given: &block,
        };
        frame.fullscreen("reflection", pipeline, [Target::overwrite(target.all())], &program)?;
        Ok(target)
    }

    /// Makes the hits from `drawn`, the image into which the method drew them; `None` if hits are not wanted.
    pub fn hits<'a>(
        &'a self,
        frame: &mut Frame,
        input: &Input<'_, '_>,
        drawn: &'a Image,
        state: &FrameState,
    ) -> Result<Option<&'a Image>> {
        if self.has_our_hits {
            return Ok(Some(drawn));
        }
        let Some(HitsConversion { depth, pipeline, target, encoding }) = &self.hits else { return Ok(None) };
        let standard = depth.record(frame, &input.gbuffer)?;
        let block = CustomHitsBlock {
            view_to_clip: state.view_to_clip(input.camera).as_mat4().to_cols_array_2d(),
            resolution: input.gbuffer.depth.extent().map(|v| v as f32),
            encoding: *encoding,
            ..CustomHitsBlock::default()
        };
        let program = CustomHits {
            hit_buffer: Sampled::nearest(drawn.level(0)),
            material_buffer: Sampled::nearest(input.gbuffer.material.all()),
            depth_buffer: Sampled::nearest(standard.0.level(0)),
            given: &block,
        };
        frame.fullscreen("hits", pipeline, [Target::overwrite(target.all())], &program)?;
        Ok(Some(target))
    }
}
