//! Passes that make every texel of their targets, in either shader stage.

use super::bind::ProgramInputs;
use super::draw::Workgroups;
use super::{Frame, Resource, Target};
use crate::error::{Error, Result};
use crate::gpu::memory::Buffer;
use crate::gpu::pixels::{PixelPipeline, StagePipeline, StoringPipeline};
use crate::gpu::program::InEitherStage;
use crate::gpu::shader::{Binding, BindingKind};

impl Frame<'_> {
    /// Records a pass of a program over whole targets, all of one size, in the shader stage of its pipeline. At least
    /// one target must be wanted, since a compute program takes the size from the first such target. No target may be
    /// one that is cleared first: a compute program cannot clear.
    pub fn pixels<F: InEitherStage>(
        &mut self,
        name: &str,
        pipeline: &PixelPipeline<F>,
        targets: F::Outputs<Target>,
        program: &F,
    ) -> Result<()> {
        match &pipeline.0 {
            StagePipeline::Fragment(pipeline) => self.fullscreen(name, pipeline, targets, program),
            StagePipeline::Compute(pipeline) => self.store(name, pipeline, targets, program),
        }
    }

    /// Dispatches a thread for each texel of the targets, which are bound as images beside the program's resources. No
    /// target may be one that is cleared first.
    pub fn store<F: InEitherStage>(
        &mut self,
        name: &str,
        pipeline: &StoringPipeline<F>,
        targets: F::Outputs<Target>,
        program: &F,
    ) -> Result<()> {
        let targets = targets.as_ref();
        let [width, height] = targets.iter().find_map(Target::slice).map_or([1, 1], |slice| slice.extent());
        let [x, y, _] = pipeline.pipeline.local_size;
        let groups = Workgroups::Counted([width.div_ceil(x), height.div_ceil(y), 1]);
        self.dispatch(name, &pipeline.pipeline, &inputs_with_targets(name, pipeline, targets, program)?, groups)
    }

    /// Does the same as [`Self::store`], with as many workgroups as three words of a buffer say, from byte `offset` on.
    pub fn store_indirect<F: InEitherStage>(
        &mut self,
        name: &str,
        pipeline: &StoringPipeline<F>,
        targets: F::Outputs<Target>,
        program: &F,
        (arguments, offset): (&Buffer, u64),
    ) -> Result<()> {
        let inputs = inputs_with_targets(name, pipeline, targets.as_ref(), program)?;
        self.dispatch(name, &pipeline.pipeline, &inputs, Workgroups::Indirect(arguments, offset))
    }
}

/// Returns the inputs of a program: the resources that it reads, and the images of its targets, to which it stores.
fn inputs_with_targets<'a, F: InEitherStage>(
    name: &str,
    pipeline: &'a StoringPipeline<F>,
    targets: &[Target<'a>],
    program: &'a F,
) -> Result<ProgramInputs<'a>> {
    let shader = pipeline.permutation.shader;
    let mut inputs = ProgramInputs::from_program(shader, program)?;
    for ((target, (binding, _)), unwanted) in targets.iter().zip(shader.stored).zip(pipeline.unwanted.iter()) {
        let image = match (target.slice(), unwanted) {
            (Some(slice), _) => slice.stored(),
            (None, Some(unwanted)) => unwanted.all(),
            (None, None) => return Err(Error::Usage(format!("{name}: an output has no target"))),
        };
        let binding = Binding { name: "output", binding: *binding, kind: BindingKind::StorageImage, count: 1 };
        inputs.resources.push((binding, Resource::Storage(image)));
    }
    Ok(inputs)
}
