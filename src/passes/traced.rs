//! Common parts of the passes that trace and reflect in one program over the whole image.

use super::{HITS, Hits, LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::program::{Fragment, InEitherStage};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, ShaderStage, Target};
use ash::vk;

/// A program with two outputs, and the images of one size for them: the reflection, and the hits where they are asked for.
pub struct TracedPass<F> {
    pipeline: PixelPipeline<F>,
    reflection: Image,
    hits: Option<Image>,
}

impl<F: InEitherStage + Fragment<Outputs<vk::Format> = [vk::Format; 2]>> TracedPass<F> {
    /// Makes the pass and its images of a size in pixels. `constants` must say as well whether hits are wanted.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], constants: &F::Constants, hits: bool) -> Result<Self> {
        let formats = [LIT_COLOR, if hits { HITS } else { vk::Format::UNDEFINED }];
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, formats, constants)?,
            reflection: Image::target_in(gpu, stage, "reflection", LIT_COLOR, extent)?,
            hits: hits.then(|| Image::target_in(gpu, stage, "hits", HITS, extent)).transpose()?,
        })
    }
}

impl<F: InEitherStage + for<'t> Fragment<Outputs<Target<'t>> = [Target<'t>; 2]>> TracedPass<F> {
    /// Records the pass `name`, which runs the program over the whole image.
    pub fn draw(&self, frame: &mut Frame, name: &str, program: &F) -> Result<()> {
        let hits = self.hits.as_ref().map_or(Target::unwanted(), |image| Target::overwrite(image.all()));
        frame.pixels(name, &self.pipeline, [Target::overwrite(self.reflection.all()), hits], program)
    }
}

impl<F> TracedPass<F> {
    /// Returns the reflection that was drawn last, and the hits if there is an image for them.
    pub fn traced(&self) -> (Reflection<'_>, Option<Hits<'_>>) {
        (Reflection(&self.reflection), self.hits.as_ref().map(Hits))
    }
}
