//! Timestamp and pipeline-statistics queries of one frame.

use super::device::{Gpu, vulkan};
use crate::error::Result;
use ash::vk;

/// How long a pass took in one frame.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassTime {
    /// The pass's label; a level of a chain follows a slash, as in "hi-z/3".
    pub name: String,
    /// Milliseconds between the timestamps around it.
    pub ms: f64,
    /// Whether the pass counts towards the method's total (DEFINITIONS, "Time").
    pub counted: bool,
}

/// Pass slots of a query pool; a frame with more fails loudly.
const MAX_PASSES: u32 = 256;

/// Two timestamps a pass, plus one before the first and one after the last pass.
pub(super) struct Timestamps {
    gpu: Gpu,
    pool: vk::QueryPool,
    used: u32,
}

impl Timestamps {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_PASSES + 2);
        // SAFETY: the create info is complete; destroyed in `drop`.
        let pool =
            unsafe { gpu.raw().create_query_pool(&info, None) }.map_err(vulkan("vkCreateQueryPool for timestamps"))?;
        gpu.name(pool, "timestamps");
        Ok(Self { gpu: gpu.clone(), pool, used: 0 })
    }

    /// Forgets the last frame.
    pub fn reset(&mut self) {
        // SAFETY: hostQueryReset is enabled and no submission is under way.
        unsafe { self.gpu.raw().reset_query_pool(self.pool, 0, 2 * MAX_PASSES + 2) };
        self.used = 0;
    }

    /// Writes the next timestamp; the slots follow in the order of recording.
    pub fn stamp(&mut self, commands: vk::CommandBuffer) {
        assert!(self.used < 2 * MAX_PASSES + 2, "more than {MAX_PASSES} passes in a frame");
        // SAFETY: the command buffer is recording; the slot was reset and is written once.
        unsafe {
            self.gpu.raw().cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, self.pool, self.used);
        }
        self.used += 1;
    }

    /// Milliseconds of every stamp since the first, after the submission is done.
    pub fn milliseconds(&self) -> Result<Vec<f64>> {
        if self.used == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; self.used as usize];
        // SAFETY: all these slots were written by the finished submission.
        unsafe {
            self.gpu.raw().get_query_pool_results(
                self.pool,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )
        }
        .map_err(vulkan("vkGetQueryPoolResults for timestamps"))?;
        let (mask, period) = (self.gpu.shared().timestamp_mask, f64::from(self.gpu.shared().limits.timestamp_period));
        // A counter of fewer than 64 bits may wrap: subtract first, then mask.
        Ok(ticks.iter().map(|t| (t.wrapping_sub(ticks[0]) & mask) as f64 * period * 1e-6).collect())
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        // SAFETY: no submission is under way (`FrameContext`).
        unsafe { self.gpu.raw().destroy_query_pool(self.pool, None) };
    }
}

/// Work that the device counted in a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PassWork {
    /// Vertex shader invocations.
    pub vertex_invocations: u64,
    /// Primitives that clipping let through.
    pub clipping_primitives: u64,
    /// Fragment shader invocations.
    pub fragment_invocations: u64,
    /// Compute shader invocations.
    pub compute_invocations: u64,
}

/// One pipeline-statistics query a pass; a run of its own, since it disturbs the times.
pub(super) struct Statistics {
    gpu: Gpu,
    pool: vk::QueryPool,
    used: u32,
}

impl Statistics {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        use vk::QueryPipelineStatisticFlags as F;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::PIPELINE_STATISTICS)
            .query_count(MAX_PASSES)
            .pipeline_statistics(
                F::VERTEX_SHADER_INVOCATIONS
                    | F::CLIPPING_PRIMITIVES
                    | F::FRAGMENT_SHADER_INVOCATIONS
                    | F::COMPUTE_SHADER_INVOCATIONS,
            );
        // SAFETY: the feature is enabled where this is called; destroyed in `drop`.
        let pool =
            unsafe { gpu.raw().create_query_pool(&info, None) }.map_err(vulkan("vkCreateQueryPool for statistics"))?;
        gpu.name(pool, "pipeline statistics");
        Ok(Self { gpu: gpu.clone(), pool, used: 0 })
    }

    pub fn reset(&mut self) {
        // SAFETY: as for the timestamps.
        unsafe { self.gpu.raw().reset_query_pool(self.pool, 0, MAX_PASSES) };
        self.used = 0;
    }

    pub fn begin(&self, commands: vk::CommandBuffer) {
        assert!(self.used < MAX_PASSES, "more than {MAX_PASSES} passes in a frame");
        // SAFETY: outside a render pass, and ended by `end` before the next.
        unsafe { self.gpu.raw().cmd_begin_query(commands, self.pool, self.used, vk::QueryControlFlags::empty()) };
    }

    pub fn end(&mut self, commands: vk::CommandBuffer) {
        // SAFETY: follows `begin` in the same command buffer.
        unsafe { self.gpu.raw().cmd_end_query(commands, self.pool, self.used) };
        self.used += 1;
    }

    pub fn results(&self) -> Result<Vec<PassWork>> {
        if self.used == 0 {
            return Ok(Vec::new());
        }
        let mut counts = vec![[0_u64; 4]; self.used as usize];
        // SAFETY: all these slots were written by the finished submission; four counters each.
        unsafe {
            self.gpu.raw().get_query_pool_results(
                self.pool,
                0,
                &mut counts,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )
        }
        .map_err(vulkan("vkGetQueryPoolResults for statistics"))?;
        Ok(counts
            .into_iter()
            .map(|[vertex_invocations, clipping_primitives, fragment_invocations, compute_invocations]| PassWork {
                vertex_invocations,
                clipping_primitives,
                fragment_invocations,
                compute_invocations,
            })
            .collect())
    }
}

impl Drop for Statistics {
    fn drop(&mut self) {
        // SAFETY: no submission is under way (`FrameContext`).
        unsafe { self.gpu.raw().destroy_query_pool(self.pool, None) };
    }
}
