//! The resources that frames reuse, and the beginning of frames.

use super::quirks::settle;
use super::sets::DescriptorSets;
use super::uniforms::Uniforms;
use super::{Frame, Mode};
use crate::error::{Error, Result};
use crate::gpu::device::{Gpu, vulkan};
use crate::gpu::image::ImagePool;
use crate::gpu::timing::{PassTime, Statistics, Timestamps};
use ash::vk;

/// Resources that frames reuse: uniform memory, descriptor sets, queries, and, for frames that this crate submits, a
/// command buffer and a fence. A context records one frame at a time.
pub struct FrameContext {
    pub(super) gpu: Gpu,
    /// The command buffer that is recorded into.
    pub(super) commands: vk::CommandBuffer,
    /// The crate's own command buffer; `None` if a caller records frames into command buffers of its own.
    pub(super) own_commands: Option<OwnCommands>,
    pub(super) slots: Vec<Slot>,
    /// The slot of the frame that is recorded.
    pub(super) slot: usize,
    pub(super) statistics: Option<Statistics>,
    pub(super) settling: Option<settle::Settling>,
    /// The pool that effects take images from.
    pub(super) pool: Option<ImagePool>,
}

/// The command buffer of frames that this crate submits, and their fence.
pub(super) struct OwnCommands {
    gpu: Gpu,
    pool: vk::CommandPool,
    pub(super) commands: vk::CommandBuffer,
    pub(super) fence: vk::Fence,
}

/// The resources that a frame needs until the device is done with the frame. A slot serves one frame at a time, so that
/// as many frames may be under way as there are slots.
pub(super) struct Slot {
    pub(super) uniforms: Uniforms,
    pub(super) sets: DescriptorSets,
    pub(super) timestamps: Timestamps,
    /// Labels of the timed passes of the slot's last frame, in order, and whether the time of each counts.
    pub(super) timed: Vec<(String, bool)>,
}

impl Slot {
    fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            uniforms: Uniforms::new(gpu)?,
            sets: DescriptorSets::new(gpu),
            timestamps: Timestamps::new(gpu)?,
            timed: Vec::new(),
        })
    }

    /// Returns the times of the timed passes, and the frame's time, in milliseconds. The first timestamp begins the
    /// frame, two for each pass follow, and the last one ends the frame.
    pub(super) fn times(&self) -> Result<(Vec<PassTime>, f64)> {
        let stamps = self.timestamps.milliseconds()?;
        let (pass_stamps, _) = stamps.get(1..).unwrap_or_default().as_chunks::<2>();
        let time = |((name, counted), [begin, end]): (&(String, bool), &[f64; 2])| PassTime {
            name: name.clone(),
            ms: end - begin,
            start_ms: *begin,
            counted: *counted,
        };
        Ok((self.timed.iter().zip(pass_stamps).map(time).collect(), stamps.last().copied().unwrap_or(0.0)))
    }
}

impl OwnCommands {
    fn new(gpu: &Gpu) -> Result<Self> {
        let device = gpu.raw();
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.shared().queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the create info is complete; `drop` destroys the pool, and accepts null handles after a failure.
        let pool = unsafe { device.create_command_pool(&info, None) }.map_err(vulkan("vkCreateCommandPool"))?;
        let (commands, fence) = (vk::CommandBuffer::null(), vk::Fence::null());
        let mut own = Self { gpu: gpu.clone(), pool, commands, fence };
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        // SAFETY: the create infos are complete; `drop` destroys the fence, and the pool with its command buffers.
        unsafe {
            own.commands = device.allocate_command_buffers(&info).map_err(vulkan("vkAllocateCommandBuffers"))?[0];
            own.fence = device.create_fence(&vk::FenceCreateInfo::default(), None).map_err(vulkan("vkCreateFence"))?;
        }
        gpu.name(own.commands, "frame");
        Ok(own)
    }
}

impl Drop for OwnCommands {
    fn drop(&mut self) {
        let device = self.gpu.raw();
        // SAFETY: no submission is under way; null handles are allowed.
        unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

impl FrameContext {
    /// Makes a context for frames that this crate submits and waits for, one at a time.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let mut context = Self::for_caller(gpu, 1)?;
        context.statistics = gpu.shared().has_pipeline_statistics.then(|| Statistics::new(gpu)).transpose()?;
        context.own_commands = Some(OwnCommands::new(gpu)?);
        Ok(context)
    }

    /// Makes a context for frames in a caller's command buffers, `slots` of which may be under way at once.
    ///
    /// # Errors
    /// [`Error::Usage`] for 0 slots.
    pub fn for_caller(gpu: &Gpu, slots: usize) -> Result<Self> {
        if slots == 0 {
            return Err(Error::Usage("no frame can be under way: frames_in_flight is 0".into()));
        }
        Ok(Self {
            gpu: gpu.clone(),
            commands: vk::CommandBuffer::null(),
            own_commands: None,
            slots: (0..slots).map(|_| Slot::new(gpu)).collect::<Result<_>>()?,
            slot: 0,
            statistics: None,
            settling: settle::Settling::new(gpu)?,
            pool: None,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Lends a pool, or none, to the effects that are made from now on, for images whose content no later frame needs.
    pub fn lend_images(&mut self, pool: Option<ImagePool>) {
        self.pool = pool;
    }

    /// Returns a handle of the device for one effect. If a pool is lent, images that the handle makes come from it.
    pub fn gpu_of_effect(&self) -> Gpu {
        self.pool.as_ref().map_or_else(|| self.gpu.clone(), |pool| self.gpu.pooled(pool))
    }

    /// Begins a frame that this crate submits. If the device lacks the queries of `mode`, the frame has none.
    ///
    /// # Errors
    /// [`Error::Usage`] if the context records into a caller's command buffers.
    pub fn begin(&mut self, mode: Mode) -> Result<Frame<'_>> {
        let device = self.gpu.raw();
        let Some(own) = &self.own_commands else {
            return Err(Error::Usage("these frames are recorded into the caller's command buffers".into()));
        };
        self.commands = own.commands;
        // SAFETY: no submission is under way: `Frame::finish` waits, and an abandoned frame was never submitted.
        unsafe {
            device
                .reset_command_pool(own.pool, vk::CommandPoolResetFlags::empty())
                .map_err(vulkan("vkResetCommandPool"))?;
            let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device.begin_command_buffer(own.commands, &info).map_err(vulkan("vkBeginCommandBuffer"))?;
            self.begin_slot(0, mode)
        }
    }

    /// Begins a frame in a caller's command buffer; [`Frame::end`] ends the frame.
    ///
    /// # Errors
    /// [`Error::Usage`] for a slot that does not exist.
    ///
    /// # Safety
    /// The command buffer is recording, outside rendering, for a queue of the device's family. Commands of an earlier
    /// frame of the slot are no longer under way. The commands of this frame are submitted before those of a later
    /// frame of this context, or the frame is dropped without [`Frame::end`] and its command buffer thrown away.
    pub unsafe fn begin_in(&mut self, commands: vk::CommandBuffer, slot: usize, mode: Mode) -> Result<Frame<'_>> {
        self.slot(slot)?;
        self.commands = commands;
        // SAFETY: `begin_slot` asks for a part of this function's contract.
        unsafe { self.begin_slot(slot, mode) }
    }

    /// Begins a frame with a slot's resources, which are reset.
    ///
    /// # Safety
    /// The command buffer is recording, and nothing that the slot recorded is under way.
    unsafe fn begin_slot(&mut self, slot: usize, mode: Mode) -> Result<Frame<'_>> {
        self.slot = slot;
        let resources = &mut self.slots[slot];
        // SAFETY: by the contract, no submission that reads a set of the slot is under way.
        unsafe { resources.sets.reset() }?;
        resources.uniforms.reset();
        resources.timed.clear();
        match mode {
            Mode::Plain => {}
            Mode::Timed => resources.timestamps.reset(),
            Mode::Counted => {
                if let Some(statistics) = &mut self.statistics {
                    statistics.reset();
                }
            }
        }
        Frame::new(self, mode)
    }

    /// The times of the last frame of a slot, once the device is done; empty unless the mode was [`Mode::Timed`].
    ///
    /// # Errors
    /// [`Error::Usage`] for a slot that does not exist.
    pub fn times(&self, slot: usize) -> Result<Vec<PassTime>> {
        Ok(self.slot(slot)?.times()?.0)
    }

    fn slot(&self, slot: usize) -> Result<&Slot> {
        let slots = self.slots.len();
        let wrong =
            || Error::Usage(format!("the slot is {slot}; frames_in_flight is {slots}, so that it is below that"));
        self.slots.get(slot).ok_or_else(wrong)
    }

    /// Records passes, submits them, and waits until the device is done: for uploads and the like.
    pub fn once(&mut self, record: impl FnOnce(&mut Frame) -> Result<()>) -> Result<()> {
        let mut frame = self.begin(Mode::Plain)?;
        record(&mut frame)?;
        frame.finish().map(|_| ())
    }
}
