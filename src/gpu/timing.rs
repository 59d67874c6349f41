//! Timestamp and pipeline-statistics queries of one frame.

use super::device::{Gpu, vulkan};
use crate::error::Result;
use ash::vk;

/// How long a pass took in one frame.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassTime {
    /// The pass's label; a level of a chain follows a slash, as in "hi-z/3".
    pub name: String,
    /// Milliseconds between the timestamps around the pass.
    pub ms: f64,
    /// Milliseconds from the frame's first timestamp to the one before the pass; negative if the pass ran in an earlier frame.
    #[serde(default)]
    pub start_ms: f64,
    /// Whether the pass counts towards the method's total (docs/definitions.md, "Time").
    pub counted: bool,
}

const QUERIES_PER_POOL: u32 = 512;

/// Queries of one kind, taken in order from pools. A frame adds the pools that it needs, and later frames reuse them.
struct Queries {
    gpu: Gpu,
    name: &'static str,
    kind: vk::QueryType,
    counters: vk::QueryPipelineStatisticFlags,
    pools: Vec<vk::QueryPool>,
    /// Number of queries that the frame has taken, from all pools.
    taken: u32,
}

impl Queries {
    /// Makes the first pool. `counters` are what a query of pipeline statistics counts; empty for timestamps.
    fn new(
        gpu: &Gpu,
        name: &'static str,
        kind: vk::QueryType,
        counters: vk::QueryPipelineStatisticFlags,
    ) -> Result<Self> {
        let mut queries = Self { gpu: gpu.clone(), name, kind, counters, pools: Vec::new(), taken: 0 };
        queries.grow()?;
        Ok(queries)
    }

    /// Forgets the queries of the last frame.
    fn reset(&mut self) {
        for pool in &self.pools {
            // SAFETY: hostQueryReset is enabled and no submission is under way.
            unsafe { self.gpu.raw().reset_query_pool(*pool, 0, QUERIES_PER_POOL) };
        }
        self.taken = 0;
    }

    /// Takes the next query, and returns its pool and its number in the pool.
    fn next_query(&mut self) -> Result<(vk::QueryPool, u32)> {
        if self.taken == QUERIES_PER_POOL * self.pools.len() as u32 {
            self.grow()?;
        }
        let query = (self.pools[(self.taken / QUERIES_PER_POOL) as usize], self.taken % QUERIES_PER_POOL);
        self.taken += 1;
        Ok(query)
    }

    /// Adds a pool of queries.
    fn grow(&mut self) -> Result<()> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(self.kind)
            .query_count(QUERIES_PER_POOL)
            .pipeline_statistics(self.counters);
        // SAFETY: the create info is complete; destroyed in `drop`.
        let pool = unsafe { self.gpu.raw().create_query_pool(&info, None) }
            .map_err(vulkan(format!("vkCreateQueryPool for {}", self.name)))?;
        self.gpu.name(pool, self.name);
        self.pools.push(pool);
        // SAFETY: hostQueryReset is enabled, and nothing uses the new pool.
        unsafe { self.gpu.raw().reset_query_pool(pool, 0, QUERIES_PER_POOL) };
        Ok(())
    }

    /// The results of all queries that were taken, in order, after the submission that wrote them is done.
    fn results<T: bytemuck::Zeroable + Copy>(&self) -> Result<Vec<T>> {
        let mut results = vec![T::zeroed(); self.taken as usize];
        for (pool_results, pool) in results.chunks_mut(QUERIES_PER_POOL as usize).zip(&self.pools) {
            // SAFETY: all these queries were written by the finished submission.
            unsafe { self.gpu.raw().get_query_pool_results(*pool, 0, pool_results, vk::QueryResultFlags::TYPE_64) }
                .map_err(vulkan(format!("vkGetQueryPoolResults for {}", self.name)))?;
        }
        Ok(results)
    }
}

impl Drop for Queries {
    fn drop(&mut self) {
        for pool in &self.pools {
            // SAFETY: no submission is under way (`FrameContext`).
            unsafe { self.gpu.raw().destroy_query_pool(*pool, None) };
        }
    }
}

/// Two timestamps a pass, plus one before the first and one after the last pass.
pub(super) struct Timestamps(Queries);

impl Timestamps {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let none = vk::QueryPipelineStatisticFlags::empty();
        Ok(Self(Queries::new(gpu, "timestamps", vk::QueryType::TIMESTAMP, none)?))
    }

    /// Forgets the timestamps of the last frame.
    pub fn reset(&mut self) {
        self.0.reset();
    }

    /// Writes the next timestamp; timestamps are numbered in the order of recording.
    pub fn stamp(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        let (pool, query) = self.0.next_query()?;
        // SAFETY: the command buffer is recording; the query was reset and is written once.
        unsafe {
            self.0.gpu.raw().cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, pool, query);
        }
        Ok(())
    }

    /// Returns the milliseconds from the first timestamp to each one, after the submission is done.
    pub fn milliseconds(&self) -> Result<Vec<f64>> {
        let ticks: Vec<u64> = self.0.results()?;
        let shared = self.0.gpu.shared();
        let (mask, period) = (shared.timestamp_mask, f64::from(shared.limits.timestamp_period));
        let first = ticks.first().copied().unwrap_or(0);
        // A counter of fewer than 64 bits may wrap: subtract first, then mask. The period is in nanoseconds.
        Ok(ticks.iter().map(|tick| (tick.wrapping_sub(first) & mask) as f64 * period * 1e-6).collect())
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

/// One pipeline-statistics query a pass. Work is counted in a frame of its own, since counting disturbs the times.
pub(super) struct Statistics {
    queries: Queries,
    /// The query that was begun.
    begun: Option<(vk::QueryPool, u32)>,
}

impl Statistics {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        use vk::QueryPipelineStatisticFlags as F;
        let counters = F::VERTEX_SHADER_INVOCATIONS
            | F::CLIPPING_PRIMITIVES
            | F::FRAGMENT_SHADER_INVOCATIONS
            | F::COMPUTE_SHADER_INVOCATIONS;
        let queries = Queries::new(gpu, "pipeline statistics", vk::QueryType::PIPELINE_STATISTICS, counters)?;
        Ok(Self { queries, begun: None })
    }

    pub fn reset(&mut self) {
        self.queries.reset();
        self.begun = None;
    }

    /// Begins the next query, which [`Self::end`] ends.
    pub fn begin(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        let (pool, query) = self.queries.next_query()?;
        // SAFETY: outside a render pass, and ended by `end` before the next.
        unsafe { self.queries.gpu.raw().cmd_begin_query(commands, pool, query, vk::QueryControlFlags::empty()) };
        self.begun = Some((pool, query));
        Ok(())
    }

    /// Ends the query that [`Self::begin`] began.
    pub fn end(&mut self, commands: vk::CommandBuffer) {
        if let Some((pool, query)) = self.begun.take() {
            // SAFETY: the query was begun in the same command buffer.
            unsafe { self.queries.gpu.raw().cmd_end_query(commands, pool, query) };
        }
    }

    /// Returns the work of each pass, in order, after the submission is done.
    pub fn results(&self) -> Result<Vec<PassWork>> {
        let counts: Vec<[u64; 4]> = self.queries.results()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::device::DeviceQuery;
    use crate::gpu::frame::{FrameContext, Mode};
    use crate::gpu::memory::{Buffer, MemoryPlace};

    #[test]
    fn a_frame_with_more_passes_than_a_pool_has_queries_is_timed_and_counted() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let mut context = FrameContext::new(&gpu).expect("a context");
        let buffer =
            Buffer::new(&gpu, "filled", 4, vk::BufferUsageFlags::TRANSFER_DST, MemoryPlace::Device).expect("a buffer");
        let passes = QUERIES_PER_POOL as usize + 1;
        // The second frame of a mode takes the pools of the first.
        for mode in [Mode::Timed, Mode::Timed, Mode::Counted, Mode::Counted] {
            let mut frame = context.begin(mode).expect("a frame");
            for word in 0..passes as u32 {
                frame.fill("fill", &buffer, word).expect("a pass");
            }
            let report = frame.finish().expect("a report");
            let counted = if gpu.shared().has_pipeline_statistics { passes } else { 0 };
            let expected = if mode == Mode::Timed { [passes, 0] } else { [0, counted] };
            assert_eq!([report.passes.len(), report.work.len()], expected, "{mode:?}");
            let sum: f64 = report.passes.iter().map(|p| p.ms).sum();
            assert!(report.passes.iter().all(|p| p.ms >= 0.0) && sum <= report.frame_ms + 1e-6, "{sum}");
        }
    }
}
