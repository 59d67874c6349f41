//! Pre-filters a cube map (thesis §3.1.3 and 4.2.11: "pre-filter it with a blur pass"). Level 0 stays as it was
//! captured, and each coarser level is blurred by the Phong lobe of one roughness.

use super::LIT_COLOR;
use crate::error::Result;
use crate::gpu::shader::CubeFilterBlock;
use crate::gpu::sync::Access;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, ImageDesc, Sampled, image, programs};
use ash::vk;
use ssct_ground::math::phong;

/// Side of a face in texels.
pub const FACE_SIZE: u32 = 256;

/// Levels of a filtered map. The coarsest level has 8 texels a side for the roughest lobe, whose cone is about five
/// texels wide. In each finer level the texels and the cone are half as wide.
pub const LEVELS: u32 = 6;

/// Number of directions of a lobe that are averaged for each texel.
const SAMPLES: u32 = 64;

/// Returns the roughness of a level: 0 at level 0, then doubling up to 1 at the coarsest. Inverse: `CubeLevel` in GLSL.
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

    /// Makes a cube map whose level 0 the caller fills before it passes the map to [`Self::record`] as `source`.
    pub fn source(gpu: &Gpu) -> Result<Image> {
        use vk::ImageUsageFlags as U;
        let usage = U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        cube(gpu, "cube source", image::full_chain([FACE_SIZE; 2]), usage)
    }

    /// Makes a cube map for the result of [`Self::record`], to be passed as `target`.
    pub fn target(gpu: &Gpu, name: &str) -> Result<Image> {
        use vk::ImageUsageFlags as U;
        cube(gpu, name, LEVELS, U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST)
    }

    /// Records passes "cube/1" …, which make the source's chain, and "cube filter/0" …, which make the target's levels.
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
