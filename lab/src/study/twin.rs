//! Numbers that the methods on the device pass to their twins on the CPU.

use ssct::gpu::shader::ThesisBlock;
use ssct_truth::reference::hi_z_ray_trace::HiZConstants;

/// Returns the numbers of a method's parameter block that the thesis's Hi-Z ray tracing reads.
pub fn hi_z_constants(block: &ThesisBlock) -> HiZConstants {
    HiZConstants {
        start_level: block.start_level.max(0) as u32,
        iterations: block.iterations.max(0) as u32,
        cross_offset: block.cross_offset,
    }
}
