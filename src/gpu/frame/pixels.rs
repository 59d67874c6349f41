//! Passes that make every texel of their targets, in either shader stage.

use super::bind::ProgramInputs;
use super::draw::Workgroups;
use super::{Frame, Resource, Target};
use crate::error::{Error, Result};
use crate::gpu::pixels::{PixelPipeline, StagePipeline, StoringPipeline};
use crate::gpu::program::InEitherStage;
use crate::gpu::shader::{Binding, BindingKind};

impl Frame<'_> {
    /// Records a pass of a program over whole targets, all of one size, in the shader stage of its pipeline. The first
    /// target must be wanted, since a compute program takes the size from this target. Targets are overwritten or kept:
    /// a compute program clears none.
    pub fn pixels<F: InEitherStage>(
        &mut self,
        name: &str,
        pipeline: &PixelPipeline<F>,
        targets: F::Outputs<Target>,
        program: &F,
    ) -> Result<()> {
        match &pipeline.0 {
            StagePipeline::Fragment(pipeline) => self.fullscreen(name, pipeline, targets, program),
            StagePipeline::Compute(pipeline) => {
                self.store(name, pipeline, targets.as_ref(), ProgramInputs::to(program))
            }
        }
    }

    /// Dispatches a thread for each texel of the targets, which are bound as images beside what the program reads.
    fn store<'g>(
        &mut self,
        name: &str,
        made: &'g StoringPipeline,
        targets: &[Target<'g>],
        mut inputs: ProgramInputs<'g>,
    ) -> Result<()> {
        let mut extent = None;
        for ((target, (binding, _)), unwanted) in targets.iter().zip(made.shader.stored).zip(&made.unwanted) {
            let image = match (target.slice(), unwanted) {
                (Some(slice), _) => {
                    extent.get_or_insert(slice.extent());
                    slice.stored()
                }
                (None, Some(unwanted)) => unwanted.all(),
                (None, None) => return Err(Error::Usage(format!("{name}: an output has no target"))),
            };
            let binding = Binding { name: "output", binding: *binding, kind: BindingKind::StorageImage, count: 1 };
            inputs.resources.push((binding, Resource::Storage(image)));
        }
        let [width, height] = extent.unwrap_or([1, 1]);
        let [x, y, _] = made.pipeline.local_size;
        let groups = Workgroups::Counted([width.div_ceil(x), height.div_ceil(y), 1]);
        self.dispatch(name, &made.pipeline, &inputs, groups)
    }
}
