//! Programs that make every texel of their targets, in the shader stage that was chosen. They run as fragment programs
//! over whole targets, or as compute programs with a thread for each texel. `build.rs` makes both from the same source
//! (`shaders-glsl/common/either_stage.glsl`), or from a `.frag` and a `.comp` file that name the same program.

use super::device::Gpu;
use super::image::{Image, ImageDesc};
use super::pipeline::{GraphicsPipeline, SharedPipeline};
use super::program::{InEitherStage, Permutation, PermutationChoice, RaySource, constant_entries, find_permutation};
use crate::error::Result;
use ash::vk;
use std::marker::PhantomData;
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
    /// Returns the usage that an image needs so that programs of this stage can write it.
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
    Compute(StoringPipeline<F>),
}

/// The compute permutation of a program, which stores what the fragment permutation draws.
pub struct StoringPipeline<F> {
    pub(super) pipeline: Arc<SharedPipeline>,
    pub(super) permutation: &'static Permutation,
    /// Images of one texel for unwanted outputs. The program stores nothing there, but every binding needs an image.
    pub(super) unwanted: Arc<[Option<Image>]>,
    /// Keeps the device until the pipeline is gone.
    _gpu: Gpu,
    program: PhantomData<fn() -> F>,
}

impl<F: InEitherStage> PixelPipeline<F> {
    /// Compiles the program for this stage alone. `targets` has formats by location: UNDEFINED for an unwanted output.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::error::Error::Usage) if no compute shader stores to these formats; errors of the device.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        targets: F::Outputs<vk::Format>,
        constants: &F::Constants,
    ) -> Result<Self> {
        Ok(Self(match stage {
            ShaderStage::Fragment => {
                StagePipeline::Fragment(GraphicsPipeline::fullscreen_for_rays(gpu, None, targets, constants)?)
            }
            ShaderStage::Compute => StagePipeline::Compute(StoringPipeline::new(gpu, None, &targets, constants)?),
        }))
    }
}

impl<F: InEitherStage> StoringPipeline<F> {
    /// Compiles the permutation with a source of rays for targets of some formats, as in [`PixelPipeline::new`].
    ///
    /// # Errors
    /// Errors of [`PixelPipeline::new`].
    pub fn new(
        gpu: &Gpu,
        rays: Option<RaySource>,
        targets: &F::Outputs<vk::Format>,
        constants: &F::Constants,
    ) -> Result<Self> {
        let targets = targets.as_ref();
        let chosen = find_permutation::<F>(PermutationChoice { stage: ShaderStage::Compute, rays }, targets)?;
        let unwanted = |(target, (_binding, format)): (&vk::Format, &(u32, vk::Format))| {
            let is_unwanted = *target == vk::Format::UNDEFINED;
            is_unwanted.then(|| unwanted_image(gpu, *format)).transpose()
        };
        let unwanted = targets.iter().zip(chosen.shader.stored).map(unwanted).collect::<Result<_>>()?;
        Self::of_permutation(gpu, chosen, unwanted, constants)
    }

    /// Compiles the same permutation for the same targets with other constants.
    pub fn with_constants(&self, gpu: &Gpu, constants: &F::Constants) -> Result<Self> {
        Self::of_permutation(gpu, self.permutation, Arc::clone(&self.unwanted), constants)
    }

    fn of_permutation(
        gpu: &Gpu,
        permutation: &'static Permutation,
        unwanted: Arc<[Option<Image>]>,
        constants: &F::Constants,
    ) -> Result<Self> {
        let pipeline = SharedPipeline::compute(gpu, permutation.shader, constant_entries(permutation, constants))?;
        Ok(Self { pipeline, permutation, unwanted, _gpu: gpu.clone(), program: PhantomData })
    }
}

fn unwanted_image(gpu: &Gpu, format: vk::Format) -> Result<Image> {
    Image::new(gpu, &ImageDesc::one_level("unwanted output", format, [1, 1], vk::ImageUsageFlags::STORAGE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::programs::HiZ;

    #[test]
    fn the_compute_program_is_that_of_the_targets_formats() {
        let name =
            |format| find_permutation::<HiZ>(ShaderStage::Compute.into(), &[format]).map(|found| found.shader.name);
        let two_depths = name(vk::Format::R32G32_SFLOAT).unwrap();
        let minimum = name(vk::Format::R32_SFLOAT).unwrap();
        assert_eq!((two_depths, minimum), ("thesis/hi_z.frag COMPUTE", "thesis/hi_z.frag COMPUTE MINIMUM"));
        let refused = name(vk::Format::R8_UNORM).unwrap_err().to_string();
        assert!(refused.contains("thesis/hi_z.frag") && refused.contains("R8_UNORM"), "{refused}");
    }
}
