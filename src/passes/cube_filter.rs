//! A cube map's pre-filtering (thesis §3.1.3 and 4.2.11: "pre-filter it with a blur pass"): level 0 as
//! it was captured, and coarser levels blurred by the Phong lobe of a roughness each.

use super::LIT_COLOR;
use crate::error::Result;
use crate::gpu::shader::CubeFilterBlock;
use crate::gpu::sync::Access;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, ImageDesc, Sampled, image, programs};
use ash::vk;
use ssct_ground::math::phong;

/// Side of a face in texels.
pub const FACE_SIZE: u32 = 256;

/// Levels of a filtered map. The coarsest has 8 texels a side for the roughest lobe, whose cone is about five of them wide. In each
/// finer level the texels and the cone are half as wide.
pub const LEVELS: u32 = 6;

/// Directions of a lobe that are averaged, at every level.
const SAMPLES: u32 = 64;

/// Roughness of a level: 0 at level 0, then doubling up to 1 at the coarsest. `CubeLevel` in GLSL is the inverse.
pub fn level_roughness(level: u32) -> f64 {
    if level == 0 { 0.0 } else { 2_f64.powi(level as i32 - (LEVELS as i32 - 1)) }
}

/// The pipeline.
pub struct CubeFilterPass {
    pipeline: ComputePipeline<programs::CubeFilter<'static>>,
}

impl CubeFilterPass {
    /// Compiles the pipeline.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { pipeline: ComputePipeline::new(gpu)? })
    }

    /// Makes a cube map for the caller to fill in level 0, and then to hand to [`Self::record`].
    pub fn source(gpu: &Gpu) -> Result<Image> {
        use vk::ImageUsageFlags as U;
        let usage = U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        cube(gpu, "cube source", image::full_chain([FACE_SIZE; 2]), usage)
    }

    /// Makes an image for the result.
    pub fn target(gpu: &Gpu, name: &str) -> Result<Image> {
        use vk::ImageUsageFlags as U;
        cube(gpu, name, LEVELS, U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST)
    }

    /// Records passes "cube/1" … (the source's own chain) and "cube filter/0" …, down to the coarsest level.
    pub fn record(&self, frame: &mut Frame, source: &Image, target: &Image) -> Result<()> {
        for level in 1..source.levels() {
            frame.blit(&format!("cube/{level}"), source.level(level - 1), source.level(level))?;
        }
        frame.copy("cube filter/0", source.level(0), target.level(0))?;
        for level in 1..target.levels() {
            let lobe = CubeFilterBlock { exponent: phong::exponent(level_roughness(level)) as f32, samples: SAMPLES };
            let slice = target.level(level);
            let source = Sampled::trilinear(source.all());
            let [width, height] = slice.extent();
            frame.compute(
                &format!("cube filter/{level}"),
                &self.pipeline,
                &programs::CubeFilter { source, filtered: slice, lobe: &lobe },
                [width, height, target.layers()],
            )?;
        }
        frame.make_ready(target.all(), Access::FragmentSampled);
        Ok(())
    }
}

fn cube(gpu: &Gpu, name: &str, levels: u32, usage: vk::ImageUsageFlags) -> Result<Image> {
    Image::new(gpu, &ImageDesc { name, format: LIT_COLOR, extent: [FACE_SIZE; 2], levels, layers: 6, usage })
}
