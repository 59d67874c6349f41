//! The pass that builds a ray structure.

use super::Frame;
use crate::error::Result;
use crate::gpu::memory::Buffer;
use crate::gpu::ray_structure::{Build, Level};
use crate::gpu::sync::Access;
use ash::vk;

impl Frame<'_> {
    /// Builds the acceleration structure `level` from the buffer `input`, whose instances may refer to the structure
    /// `below`. The build works in the memory of `scratch`.
    pub(in crate::gpu) fn build_rays(
        &mut self,
        name: &str,
        build: &Build,
        (level, scratch): (&Level, &Buffer),
        (input, below): (&Buffer, Option<&Level>),
    ) -> Result<()> {
        let gpu = self.context.gpu.clone();
        let queries = gpu.ray_queries()?;
        self.pass(name, |frame| {
            frame.use_buffer(input, Access::BuildInput);
            if let Some(below) = below {
                frame.use_buffer(&below.buffer, Access::RayStructureRead);
            }
            frame.use_buffer(&level.buffer, Access::RayStructureBuild);
            frame.use_buffer(scratch, Access::RayStructureBuild);
            frame.flush();
            let scratch_address = vk::DeviceOrHostAddressKHR {
                device_address: scratch.address().next_multiple_of(queries.scratch_alignment),
            };
            let info = build.info().dst_acceleration_structure(level.handle).scratch_data(scratch_address);
            let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(build.count)];
            // SAFETY: the buffers that the addresses lie in are alive until the submission is waited for, hold what is
            // described, and are ready by the barriers above.
            unsafe {
                queries.structures.cmd_build_acceleration_structures(frame.context.commands, &[info], &[&range]);
            }
            Ok(())
        })
    }
}
