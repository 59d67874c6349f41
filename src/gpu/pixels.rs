//! Programs that make every texel of their targets, in the shader stage that was chosen. They run as fragment programs
//! over whole targets, or as compute programs, a thread a texel, that `build.rs` makes from the same source
//! (`shaders-glsl/common/either_stage.glsl`).

use super::device::Gpu;
use super::image::{Image, ImageDesc};
use super::pipeline::{GraphicsPipeline, SharedPipeline};
use super::program::{Constants, InEitherStage};
use super::shader::Shader;
use crate::error::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// The shader stage for a program that exists for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShaderStage {
    /// Fragment shaders, drawn over targets.
    Fragment,
    /// Compute shaders, which store to images.
    Compute,
}

impl ShaderStage {
    /// How a program of this stage uses the images that it writes.
    pub fn target_usage(self) -> vk::ImageUsageFlags {
        match self {
            Self::Fragment => vk::ImageUsageFlags::COLOR_ATTACHMENT,
            Self::Compute => vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE,
        }
    }
}

/// The pipeline of a program in one stage.
pub struct PixelPipeline<F>(pub(super) StagePipeline<F>);

pub(super) enum StagePipeline<F> {
    Fragment(GraphicsPipeline<F>),
    Compute(StoringPipeline),
}

/// A compute program that stores what the fragment program draws.
pub(super) struct StoringPipeline {
    pub pipeline: Arc<SharedPipeline>,
    pub shader: &'static Shader,
    /// Images of one texel for the outputs that nobody wants. The program stores nothing to them, but every binding needs an
    /// image.
    pub unwanted: Vec<Option<Image>>,
    /// Keeps the device until the pipeline is gone.
    _gpu: Gpu,
}

impl<F: InEitherStage> PixelPipeline<F> {
    /// Compiles the program for this stage alone. The formats of the targets are given by location: UNDEFINED for an
    /// output that nobody wants.
    ///
    /// # Errors
    /// [`Error::Usage`] if no compute program of the source stores to images of these formats; errors of the device.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        targets: F::Outputs<vk::Format>,
        constants: &F::Constants,
    ) -> Result<Self> {
        Ok(Self(match stage {
            ShaderStage::Fragment => {
                StagePipeline::Fragment(GraphicsPipeline::fullscreen_with(gpu, targets, constants)?)
            }
            ShaderStage::Compute => {
                let shader = storing(F::SHADER, F::COMPUTE, targets.as_ref())?;
                StagePipeline::Compute(StoringPipeline::new(gpu, shader, targets.as_ref(), constants.entries())?)
            }
        }))
    }
}

impl StoringPipeline {
    fn new(gpu: &Gpu, shader: &'static Shader, targets: &[vk::Format], constants: Vec<(u32, u32)>) -> Result<Self> {
        let unwanted = |(target, (_, format)): (&vk::Format, &(u32, vk::Format))| {
            let is_unwanted = *target == vk::Format::UNDEFINED;
            is_unwanted.then(|| unwanted_image(gpu, *format)).transpose()
        };
        Ok(Self {
            pipeline: SharedPipeline::compute(gpu, shader, constants)?,
            shader,
            unwanted: targets.iter().zip(shader.stored).map(unwanted).collect::<Result<_>>()?,
            _gpu: gpu.clone(),
        })
    }
}

fn unwanted_image(gpu: &Gpu, format: vk::Format) -> Result<Image> {
    let usage = vk::ImageUsageFlags::STORAGE;
    Image::new(gpu, &ImageDesc { name: "unwanted output", format, extent: [1, 1], levels: 1, layers: 1, usage })
}

/// Finds the compute program that stores to images of the formats `targets`. UNDEFINED fits every format.
fn storing(fragment: &Shader, programs: &'static [Shader], targets: &[vk::Format]) -> Result<&'static Shader> {
    let fits = |shader: &&Shader| {
        let same = |((_, stored), target): (&(u32, vk::Format), &vk::Format)| {
            *target == vk::Format::UNDEFINED || stored == target
        };
        shader.stored.iter().zip(targets).all(same)
    };
    programs.iter().find(fits).ok_or_else(|| {
        Error::Usage(format!(
            "the shader {} has no compute program that stores to images of the formats {targets:?}: it runs in fragment \
             shaders alone",
            fragment.name
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::program::Program;
    use crate::gpu::programs::HiZ;

    #[test]
    fn the_compute_program_is_that_of_the_targets_formats() {
        let name = |format| storing(HiZ::SHADER, HiZ::COMPUTE, &[format]).map(|shader| shader.name);
        let both = name(vk::Format::R32G32_SFLOAT).unwrap();
        let minimum = name(vk::Format::R32_SFLOAT).unwrap();
        assert_eq!((both, minimum), ("thesis/hi_z.frag COMPUTE", "thesis/hi_z.frag COMPUTE MINIMUM"));
        let refused = name(vk::Format::R8_UNORM).unwrap_err().to_string();
        assert!(refused.contains("thesis/hi_z.frag") && refused.contains("R8_UNORM"), "{refused}");
    }
}
