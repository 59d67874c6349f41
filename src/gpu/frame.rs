//! One frame: its passes, each with its label, timestamps and barriers, recorded and submitted.
//!
//! A pass states what it reads and writes by its program's struct and its targets; the frame derives the barriers from the table
//! in [`super::sync`]. In timing mode a full barrier separates passes, so that they cannot overlap and their times add up to the
//! frame's.

mod bind;
mod context;
mod draw;
mod pixels;
mod quirks;
mod rays;
mod sets;
mod target;
mod transfer;
mod uniforms;

use super::device::vulkan;
use super::image::{Image, ImageSlice};
use super::memory::{Buffer, TexelBuffer};
use super::pipeline::SharedPipeline;
use super::program::Sampled;
use super::ray_structure::RayStructure;
use super::sync::{Access, ImageUse, State, TrackedState, Transition};
use super::timing::{PassTime, PassWork};
use crate::error::{Error, Result};
use ash::vk;
use bind::ProgramInputs;
pub use context::FrameContext;
use context::Slot;
pub use draw::Raster;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};
pub use target::Target;

/// The purpose of recording a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// For its images only: exact barriers, no queries.
    Plain,
    /// For its times: two timestamps a pass, a full barrier between passes.
    Timed,
    /// For its work: pipeline statistics of each pass.
    Counted,
}

/// A resource for one binding of a program, as [`Program::resource`](super::program::Program::resource) returns it.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// An image, sampled or fetched.
    Sampled(Sampled<'a>),
    /// Sampled images, one for each element of the shader's array.
    SampledArray(&'a [Sampled<'a>]),
    /// A level of an image, stored to.
    Storage(ImageSlice<'a>),
    /// A level of an image, loaded without a sampler.
    Loaded(ImageSlice<'a>),
    /// The bytes of a uniform block.
    Uniform(&'a [u8]),
    /// A buffer, read as texels.
    Texels(&'a TexelBuffer),
    /// An acceleration structure, for ray queries of compute shaders.
    Rays(&'a RayStructure),
    /// A storage buffer, read and written.
    Buffer(&'a Buffer),
    /// A storage buffer, only read.
    ReadBuffer(&'a Buffer),
}

/// The passes, times and work of one frame.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub struct FrameReport {
    /// Time of each pass, in order; empty unless [`Mode::Timed`].
    pub passes: Vec<PassTime>,
    /// Milliseconds from the frame's first timestamp to its last; 0 unless [`Mode::Timed`].
    pub frame_ms: f64,
    /// When the host recorded the frame, and how long it recorded and waited; `None` for a frame that the caller submits.
    #[serde(default)]
    pub host: Option<HostTime>,
    /// Work of each pass, in order; empty unless [`Mode::Counted`].
    pub work: Vec<PassWork>,
    /// The passes recorded, in order.
    pub recorded: Vec<String>,
    /// The passes that the frame did not need.
    pub skipped: Vec<Skipped>,
}

/// The host's side of a frame.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HostTime {
    /// When recording began, in microseconds since 1970.
    pub begun_us: u64,
    /// Milliseconds from then until the frame was submitted.
    pub record_ms: f64,
    /// Milliseconds from the submission until the device was done.
    pub wait_ms: f64,
}

/// A pass that a frame did not need.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Skipped {
    /// Label of the pass.
    pub pass: String,
    /// Reason why the frame did not need the pass, as a clause.
    pub why: String,
}

/// A frame that is being recorded.
pub struct Frame<'c> {
    context: &'c mut FrameContext,
    mode: Mode,
    /// Label of each recorded pass, and whether the pass counts towards the method's time.
    passes: Vec<(String, bool)>,
    /// Work that the host did for the frame, reported like passes.
    host_work: Vec<PassTime>,
    skipped: Vec<Skipped>,
    /// Whether the next pass counts towards the method's time.
    counted: bool,
    /// Prefix of the names of passes.
    prefix: String,
    pending: Barriers,
    undo: Undo,
    /// Flags of the pipelines that are settled once this frame is submitted (`quirks/settle.rs`).
    settled: Vec<Arc<AtomicBool>>,
    begun: (SystemTime, Instant),
}

/// States of images and buffers before the frame, restored if the frame, and thus its barriers, are never submitted.
#[derive(Default)]
struct Undo(Vec<(TrackedState, State)>);

impl Drop for Undo {
    fn drop(&mut self) {
        for (state, before) in self.0.drain(..).rev() {
            state.set(before);
        }
    }
}

/// Barriers collected for one call.
#[derive(Default)]
struct Barriers {
    images: Vec<vk::ImageMemoryBarrier2<'static>>,
    buffers: Vec<vk::BufferMemoryBarrier2<'static>>,
}

impl<'c> Frame<'c> {
    /// Makes a frame whose command buffer is recording, and writes its first timestamp.
    fn new(context: &'c mut FrameContext, mode: Mode) -> Result<Self> {
        let mut frame = Self {
            context,
            mode,
            passes: Vec::new(),
            host_work: Vec::new(),
            skipped: Vec::new(),
            counted: false,
            prefix: String::new(),
            pending: Barriers::default(),
            undo: Undo::default(),
            settled: Vec::new(),
            begun: (SystemTime::now(), Instant::now()),
        };
        frame.stamp()?;
        Ok(frame)
    }
}

impl Frame<'_> {
    /// Lets the passes that follow count towards the method's total time.
    pub fn begin_effect(&mut self) {
        self.counted = true;
    }

    /// Puts a prefix, which is `name` and a slash, before the names of the passes that follow, so that passes that are
    /// recorded again have names of their own. `None` ends the prefix.
    pub fn set_prefix(&mut self, name: Option<&str>) {
        self.prefix = name.map_or(String::new(), |name| format!("{name}/"));
    }

    /// Notes a pass that this frame does not need, and why.
    pub fn skip(&mut self, pass: &str, why: &str) {
        self.skipped.push(Skipped { pass: format!("{}{pass}", self.prefix), why: why.to_owned() });
    }

    /// Notes work that the host did for this frame before it was recorded, as a pass that took so many milliseconds.
    pub fn note_host_work(&mut self, name: &str, ms: f64) {
        let name = format!("{}{name}", self.prefix);
        self.host_work.push(PassTime { name, ms, start_ms: 0.0, counted: self.counted });
    }

    /// Makes levels of an image ready for a use by barriers outside of a pass, for example after an upload.
    pub fn make_ready(&mut self, slice: ImageSlice, access: Access) {
        self.use_image(slice, access);
        self.flush();
    }

    /// Takes over a caller's image, which the caller used last as `last` says.
    pub fn take_over(&mut self, image: &Image, last: ImageUse) {
        for (_, state) in image.all().states() {
            self.undo.0.push((state.clone(), state.get()));
            state.set(State::after_use(last));
        }
    }

    /// Records the barriers after which the caller may use an image as `next` says, and sees all that is recorded here.
    pub fn hand_over(&mut self, image: &Image, next: ImageUse) {
        for (level, state) in image.all().states() {
            let mut current = state.get();
            self.undo.0.push((state.clone(), current));
            let transition = current.hand_over(next);
            state.set(current);
            self.image_barrier(image, level, transition);
        }
        self.flush();
    }

    /// Submits the frame, waits for the device, and reads the queries.
    pub fn finish(self) -> Result<FrameReport> {
        self.submit(&[], &[])
    }

    /// Finishes a frame that is presented: waits for `acquired` before `wait_stages`, and signals `rendered` when done.
    pub fn finish_presenting(
        self,
        acquired: vk::Semaphore,
        wait_stages: vk::PipelineStageFlags2,
        rendered: vk::Semaphore,
    ) -> Result<FrameReport> {
        let semaphore_info =
            |semaphore, stages| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(stages);
        self.submit(
            &[semaphore_info(acquired, wait_stages)],
            &[semaphore_info(rendered, vk::PipelineStageFlags2::ALL_COMMANDS)],
        )
    }

    /// Submits the frame between two lists of semaphores, waits until the device is done, and reads the queries.
    fn submit(mut self, waits: &[vk::SemaphoreSubmitInfo], signals: &[vk::SemaphoreSubmitInfo]) -> Result<FrameReport> {
        self.stamp()?;
        let device = self.context.gpu.raw();
        let Some(own) = &self.context.own_commands else {
            return Err(Error::Usage("this frame is submitted by whoever began its command buffer".into()));
        };
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(own.commands)];
        let submit = vk::SubmitInfo2::default()
            .wait_semaphore_infos(waits)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(signals);
        let fences = [own.fence];
        let submitted;
        // SAFETY: the command buffer is complete; the unsignalled fence is waited for before anything is reused.
        unsafe {
            device.end_command_buffer(own.commands).map_err(vulkan("vkEndCommandBuffer"))?;
            let queue = self.context.gpu.queue()?;
            self.context.gpu.count_submission();
            device.queue_submit2(*queue, &[submit], fences[0]).map_err(vulkan("vkQueueSubmit2"))?;
            submitted = Instant::now();
            self.undo.0.clear();
            self.settled.iter().for_each(|pipeline| pipeline.store(true, Ordering::Relaxed));
            let waited = self.wait(&fences);
            if waited.is_err() {
                // A lost device is idle. Any other must become idle before the resources that it uses are destroyed.
                let _ = device.device_wait_idle();
            }
            device.reset_fences(&fences).map_err(vulkan("vkResetFences"))?;
            waited.map_err(vulkan("vkWaitForFences"))?;
        }
        let host_work = std::mem::take(&mut self.host_work);
        let mut report = self.report();
        report.recorded.splice(..0, host_work.iter().map(|pass| pass.name.clone()));
        let (system_time, begun) = self.begun;
        let milliseconds = |from: Instant, to: Instant| 1e3 * to.duration_since(from).as_secs_f64();
        report.host = Some(HostTime {
            begun_us: system_time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_micros() as u64),
            record_ms: milliseconds(begun, submitted),
            wait_ms: milliseconds(submitted, Instant::now()),
        });
        match (self.mode, &self.context.statistics) {
            (Mode::Timed, _) => {
                let slot = self.slot();
                (report.passes, report.frame_ms) = slot.times()?;
                report.passes.splice(..0, host_work);
            }
            (Mode::Counted, Some(statistics)) => report.work = statistics.results()?,
            _ => {}
        }
        Ok(report)
    }

    /// Waits for the fences of a submission. If the frame exceeds the limit of [`Gpu::wait_at_most`](super::Gpu::wait_at_most),
    /// calls the function that belongs to the limit, and waits on.
    fn wait(&self, fences: &[vk::Fence]) -> std::result::Result<(), vk::Result> {
        // SAFETY: the fences belong to the device, and are destroyed after this call.
        let wait = |nanoseconds: u64| unsafe { self.device().wait_for_fences(fences, true, nanoseconds) };
        let Some((limit, give_up)) = self.context.gpu.shared().frame_timeout.get() else { return wait(u64::MAX) };
        wait(limit.as_nanos().try_into().unwrap_or(u64::MAX)).or_else(|result| {
            if result != vk::Result::TIMEOUT {
                return Err(result);
            }
            let passes: Vec<&str> = self.passes.iter().map(|(name, _)| name.as_str()).collect();
            give_up(&format!(
                "a frame was not done in {} s, so that a shader of it may run forever; its passes: {}",
                limit.as_secs_f64(),
                passes.join(", ")
            ));
            wait(u64::MAX)
        })
    }

    /// Ends a frame in a caller's command buffer, which the caller submits. The report says what was recorded; the times are
    /// known later ([`FrameContext::times`]).
    pub fn end(mut self) -> Result<FrameReport> {
        self.stamp()?;
        self.undo.0.clear();
        self.settled.iter().for_each(|pipeline| pipeline.store(true, Ordering::Relaxed));
        Ok(self.report())
    }

    /// Reports the recorded and the skipped passes; the slot keeps the names of timed passes.
    fn report(&mut self) -> FrameReport {
        let passes = std::mem::take(&mut self.passes);
        let recorded = passes.iter().map(|(name, _)| name.clone()).collect();
        if self.mode == Mode::Timed {
            self.slot().timed = passes;
        }
        FrameReport { recorded, skipped: std::mem::take(&mut self.skipped), ..FrameReport::default() }
    }

    fn slot(&mut self) -> &mut Slot {
        &mut self.context.slots[self.context.slot]
    }

    /// Records a pass: label, timestamps and statistics around the commands that `record` records.
    fn pass(&mut self, name: &str, record: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let commands = self.context.commands;
        let name = format!("{}{name}", self.prefix);
        self.context.gpu.begin_label(commands, &name);
        if self.mode == Mode::Timed {
            self.full_barrier();
        }
        self.stamp()?;
        if let (Mode::Counted, Some(statistics)) = (self.mode, &mut self.context.statistics) {
            statistics.begin(commands)?;
        }
        record(self)?;
        if let (Mode::Counted, Some(statistics)) = (self.mode, &mut self.context.statistics) {
            statistics.end(commands);
        }
        self.stamp()?;
        self.context.gpu.end_label(commands);
        self.passes.push((name, self.counted));
        Ok(())
    }

    /// Notes which pipeline a pass runs, on a device that tells what its compiler made.
    fn note_program(&self, pass: &str, pipeline: &Arc<SharedPipeline>) {
        if let Some(executables) = &self.context.gpu.shared().executables {
            executables.note(&format!("{}{pass}", self.prefix), self.counted, pipeline);
        }
    }

    /// Writes a timestamp if the frame is timed.
    fn stamp(&mut self) -> Result<()> {
        let commands = self.context.commands;
        if self.mode == Mode::Timed { self.slot().timestamps.stamp(commands) } else { Ok(()) }
    }

    fn device(&self) -> &ash::Device {
        self.context.gpu.raw()
    }

    /// Makes everything before the barrier done and visible to everything after it.
    fn full_barrier(&self) {
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE);
        let barriers = [barrier];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: outside rendering.
        unsafe { self.device().cmd_pipeline_barrier2(self.context.commands, &info) };
    }

    /// Collects the barriers of a pass's resources; the next [`Self::flush`] records them. Accesses are for sampled
    /// images, for images and buffers that are only loaded, and for those that are stored to.
    fn prepare(&mut self, inputs: &ProgramInputs, [sampled, loaded, stored]: [Access; 3]) {
        for (_, resource) in &inputs.resources {
            match *resource {
                Resource::Sampled(Sampled(slice, _)) => self.use_image(slice, sampled),
                Resource::SampledArray(images) => images.iter().for_each(|s| self.use_image(s.0, sampled)),
                Resource::Storage(slice) => self.use_image(slice, stored),
                Resource::Loaded(slice) => self.use_image(slice, loaded),
                Resource::Texels(texels) => self.use_buffer(texels.buffer(), loaded),
                Resource::Rays(structure) => {
                    structure.buffers().into_iter().for_each(|b| self.use_buffer(b, Access::RayQuery));
                }
                Resource::Buffer(b) => self.use_buffer(b, stored),
                Resource::ReadBuffer(b) => self.use_buffer(b, loaded),
                Resource::Uniform(_) => {}
            }
        }
    }

    /// Collects the barriers that make the levels of a slice ready for an access.
    fn use_image(&mut self, slice: ImageSlice, access: Access) {
        for (level, state) in slice.states() {
            let transition = change_state(&mut self.undo, state, access);
            self.image_barrier(slice.image(), level, transition);
        }
    }

    /// Collects the barrier of a level; the next [`Self::flush`] records it.
    fn image_barrier(&mut self, image: &Image, level: u32, transition: Option<Transition>) {
        let Some(t) = transition else { return };
        self.pending.images.push(
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(t.src_stages)
                .src_access_mask(t.src_access)
                .dst_stage_mask(t.dst_stages)
                .dst_access_mask(t.dst_access)
                .old_layout(t.old_layout)
                .new_layout(t.new_layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image.handle())
                .subresource_range(image.range(level, 1)),
        );
    }

    /// Collects the barrier that makes a buffer ready for an access.
    fn use_buffer(&mut self, buffer: &Buffer, access: Access) {
        if let Some(t) = change_state(&mut self.undo, buffer.state(), access) {
            self.pending.buffers.push(
                vk::BufferMemoryBarrier2::default()
                    .src_stage_mask(t.src_stages)
                    .src_access_mask(t.src_access)
                    .dst_stage_mask(t.dst_stages)
                    .dst_access_mask(t.dst_access)
                    .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .buffer(buffer.handle())
                    .size(vk::WHOLE_SIZE),
            );
        }
    }

    /// Records the collected barriers as one call.
    fn flush(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        if !pending.images.is_empty() || !pending.buffers.is_empty() {
            let info = vk::DependencyInfo::default()
                .image_memory_barriers(&pending.images)
                .buffer_memory_barriers(&pending.buffers);
            // SAFETY: outside rendering; the handles are alive.
            unsafe { self.device().cmd_pipeline_barrier2(self.context.commands, &info) };
        }
    }
}

/// Changes a tracked state to an access, and returns the barrier that the change needs. `undo` keeps the earlier state.
fn change_state(undo: &mut Undo, state: &TrackedState, access: Access) -> Option<Transition> {
    let mut current = state.get();
    undo.0.push((state.clone(), current));
    let transition = current.transition(access);
    state.set(current);
    transition
}
