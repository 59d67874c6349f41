//! The one table of stages, accesses and layout for each use of an image or a buffer, and the state that says which
//! barrier the next use needs. All barriers come from here, except the full barriers of timing mode (`frame.rs`).

use ash::vk;
use std::sync::{Arc, Mutex, PoisonError};

/// How a pass uses an image or a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Access {
    /// Colour attachment, loaded or cleared, and stored.
    ColorAttachment,
    /// Depth attachment, tested and written.
    DepthAttachment,
    /// Depth and stencil attachment, tested and written.
    DepthStencilAttachment,
    /// Sampled or fetched in a fragment shader.
    FragmentSampled,
    /// Sampled or fetched in a compute shader.
    ComputeSampled,
    /// Stored to (and possibly loaded from) in a compute shader.
    ComputeStorage,
    /// Loaded only, as a storage buffer or image, in a compute shader.
    ComputeStorageRead,
    /// Loaded only, as a storage buffer or image, in a vertex or fragment shader.
    GraphicsStorageRead,
    /// Stored to (and possibly loaded from) in a fragment shader.
    FragmentStorage,
    /// Source of a copy or blit.
    TransferRead,
    /// Destination of a copy, blit, clear or fill.
    TransferWrite,
    /// Vertex or index data.
    VertexInput,
    /// Arguments of an indirect draw or dispatch.
    Indirect,
    /// Corners of triangles or other input of a build of a ray structure.
    BuildInput,
    /// A ray structure that is built, or the memory that its build works in.
    RayStructureBuild,
    /// A ray structure that another one is built over.
    RayStructureRead,
    /// A ray structure that ray queries of compute shaders read.
    RayQuery,
    /// Read by the host after the submission.
    HostRead,
    /// Handed to the presentation engine.
    Present,
}

/// What an [`Access`] means to Vulkan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccessInfo {
    /// Pipeline stages.
    pub stages: vk::PipelineStageFlags2,
    /// Memory accesses.
    pub access: vk::AccessFlags2,
    /// Image layout; undefined for a use that only buffers have.
    pub layout: vk::ImageLayout,
    /// Whether the use writes.
    pub writes: bool,
}

impl Access {
    /// Every use, for tests and tools.
    pub const ALL: [Self; 19] = [
        Self::ColorAttachment,
        Self::DepthAttachment,
        Self::DepthStencilAttachment,
        Self::FragmentSampled,
        Self::ComputeSampled,
        Self::ComputeStorage,
        Self::ComputeStorageRead,
        Self::GraphicsStorageRead,
        Self::FragmentStorage,
        Self::TransferRead,
        Self::TransferWrite,
        Self::VertexInput,
        Self::Indirect,
        Self::BuildInput,
        Self::RayStructureBuild,
        Self::RayStructureRead,
        Self::RayQuery,
        Self::HostRead,
        Self::Present,
    ];

    /// Looks up a use in the table.
    pub const fn info(self) -> AccessInfo {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let (stages, access, layout, writes) = match self {
            Self::ColorAttachment => (
                S::COLOR_ATTACHMENT_OUTPUT,
                A::from_raw(A::COLOR_ATTACHMENT_READ.as_raw() | A::COLOR_ATTACHMENT_WRITE.as_raw()),
                L::COLOR_ATTACHMENT_OPTIMAL,
                true,
            ),
            Self::DepthAttachment => (
                S::from_raw(S::EARLY_FRAGMENT_TESTS.as_raw() | S::LATE_FRAGMENT_TESTS.as_raw()),
                A::from_raw(A::DEPTH_STENCIL_ATTACHMENT_READ.as_raw() | A::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw()),
                L::DEPTH_ATTACHMENT_OPTIMAL,
                true,
            ),
            Self::DepthStencilAttachment => {
                let depth = Self::DepthAttachment.info();
                (depth.stages, depth.access, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, true)
            }
            Self::FragmentSampled => (S::FRAGMENT_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL, false),
            // SHADER_READ, not SHADER_SAMPLED_READ: best practices of 1.3.239 know only the former.
            Self::ComputeSampled => (S::COMPUTE_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL, false),
            Self::ComputeStorage => (
                S::COMPUTE_SHADER,
                A::from_raw(A::SHADER_STORAGE_READ.as_raw() | A::SHADER_STORAGE_WRITE.as_raw()),
                L::GENERAL,
                true,
            ),
            Self::ComputeStorageRead => (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ, L::GENERAL, false),
            Self::GraphicsStorageRead => (
                S::from_raw(S::VERTEX_SHADER.as_raw() | S::FRAGMENT_SHADER.as_raw()),
                A::SHADER_STORAGE_READ,
                L::GENERAL,
                false,
            ),
            Self::FragmentStorage => (
                S::FRAGMENT_SHADER,
                A::from_raw(A::SHADER_STORAGE_READ.as_raw() | A::SHADER_STORAGE_WRITE.as_raw()),
                L::GENERAL,
                true,
            ),
            Self::TransferRead => (S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL, false),
            Self::TransferWrite => (S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL, true),
            Self::VertexInput => (
                S::VERTEX_INPUT,
                A::from_raw(A::VERTEX_ATTRIBUTE_READ.as_raw() | A::INDEX_READ.as_raw()),
                L::UNDEFINED,
                false,
            ),
            Self::Indirect => (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED, false),
            Self::BuildInput => (S::ACCELERATION_STRUCTURE_BUILD_KHR, A::SHADER_READ, L::UNDEFINED, false),
            Self::RayStructureBuild => (
                S::ACCELERATION_STRUCTURE_BUILD_KHR,
                A::from_raw(A::ACCELERATION_STRUCTURE_READ_KHR.as_raw() | A::ACCELERATION_STRUCTURE_WRITE_KHR.as_raw()),
                L::UNDEFINED,
                true,
            ),
            Self::RayStructureRead => {
                (S::ACCELERATION_STRUCTURE_BUILD_KHR, A::ACCELERATION_STRUCTURE_READ_KHR, L::UNDEFINED, false)
            }
            Self::RayQuery => (S::COMPUTE_SHADER, A::ACCELERATION_STRUCTURE_READ_KHR, L::UNDEFINED, false),
            Self::HostRead => (S::HOST, A::HOST_READ, L::GENERAL, false),
            // Presentation is ordered by a semaphore; the barrier only changes the layout.
            Self::Present => (S::NONE, A::NONE, L::PRESENT_SRC_KHR, false),
        };
        AccessInfo { stages, access, layout, writes }
    }
}

/// A caller's use of an image: the image's layout, and the stages and accesses of the last or the next use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageUse {
    /// The image's layout.
    pub layout: vk::ImageLayout,
    /// Pipeline stages that touch the image.
    pub stages: vk::PipelineStageFlags2,
    /// Accesses of these stages.
    pub access: vk::AccessFlags2,
}

impl ImageUse {
    /// Drawn into as a colour attachment.
    pub const COLOR_ATTACHMENT: Self = Self::for_access(Access::ColorAttachment);
    /// Drawn into as a depth attachment; the layout is for the depth aspect alone.
    pub const DEPTH_ATTACHMENT: Self = Self::for_access(Access::DepthAttachment);
    /// Sampled in fragment shaders, in `SHADER_READ_ONLY_OPTIMAL`.
    pub const FRAGMENT_SAMPLED: Self = Self::for_access(Access::FragmentSampled);
    /// Sampled in compute shaders, in `SHADER_READ_ONLY_OPTIMAL`.
    pub const COMPUTE_SAMPLED: Self = Self::for_access(Access::ComputeSampled);
    /// Copied or blitted from.
    pub const TRANSFER_SOURCE: Self = Self::for_access(Access::TransferRead);
    /// Copied, blitted or cleared.
    pub const TRANSFER_TARGET: Self = Self::for_access(Access::TransferWrite);

    const fn for_access(access: Access) -> Self {
        let AccessInfo { stages, access, layout, .. } = access.info();
        Self { layout, stages, access }
    }
}

/// A barrier's two sides, ready for an image or a memory barrier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// Stages that must be done.
    pub src_stages: vk::PipelineStageFlags2,
    /// Writes that must be available.
    pub src_access: vk::AccessFlags2,
    /// Stages that wait.
    pub dst_stages: vk::PipelineStageFlags2,
    /// Accesses to which the writes become visible.
    pub dst_access: vk::AccessFlags2,
    /// Layout before.
    pub old_layout: vk::ImageLayout,
    /// Layout after.
    pub new_layout: vk::ImageLayout,
}

/// What has happened to an image level or a buffer so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    layout: vk::ImageLayout,
    /// Stages of the last write, and its accesses that are not yet available; a layout change counts as a write.
    write_stages: vk::PipelineStageFlags2,
    write_access: vk::AccessFlags2,
    /// Stages and accesses of reads that already see the last write.
    read_stages: vk::PipelineStageFlags2,
    read_access: vk::AccessFlags2,
}

/// The state of an image's level or of a buffer. Clones share the state: a frame keeps a clone to undo its changes.
#[derive(Debug, Clone, Default)]
pub(crate) struct TrackedState(Arc<Mutex<State>>);

impl TrackedState {
    pub fn get(&self) -> State {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn set(&self, state: State) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = state;
    }
}

impl Default for State {
    /// Fresh memory: nothing written, layout undefined.
    fn default() -> Self {
        Self {
            layout: vk::ImageLayout::UNDEFINED,
            write_stages: vk::PipelineStageFlags2::NONE,
            write_access: vk::AccessFlags2::NONE,
            read_stages: vk::PipelineStageFlags2::NONE,
            read_access: vk::AccessFlags2::NONE,
        }
    }
}

impl State {
    /// The state of an image that was just acquired from the presentation engine: the content is lost, and the first
    /// use must follow the stages at which the submission waits for the acquisition.
    pub fn acquired(wait_stages: vk::PipelineStageFlags2) -> Self {
        Self { write_stages: wait_stages, ..Self::default() }
    }

    /// The current layout.
    pub fn layout(&self) -> vk::ImageLayout {
        self.layout
    }

    /// The state in which a caller's use leaves an image.
    pub(super) fn after_use(last: ImageUse) -> Self {
        Self { layout: last.layout, write_stages: last.stages, write_access: last.access, ..Self::default() }
    }

    /// Moves to the next use, and returns the barrier that this use needs, if any.
    pub fn transition(&mut self, next: Access) -> Option<Transition> {
        self.transition_to(next.info())
    }

    /// Moves to a caller's use, before which all earlier work must be done; returns the barrier that the use needs.
    pub(super) fn hand_over(&mut self, to: ImageUse) -> Option<Transition> {
        let ImageUse { layout, stages, access } = to;
        self.transition_to(AccessInfo { stages, access, layout, writes: true })
    }

    /// Moves to a use, and returns the barrier that this use needs. A new layout needs one. After an earlier use, a write needs one,
    /// and so does a read that does not see the last write yet.
    fn transition_to(&mut self, info: AccessInfo) -> Option<Transition> {
        let changes_layout = info.layout != vk::ImageLayout::UNDEFINED && info.layout != self.layout;
        let sees_write = self.read_stages.contains(info.stages) && self.read_access.contains(info.access);
        let is_unused = self.write_stages.is_empty() && self.read_stages.is_empty();
        let before = *self;
        if info.writes || changes_layout {
            *self = Self {
                layout: if changes_layout { info.layout } else { self.layout },
                write_stages: info.stages,
                write_access: if info.writes { info.access } else { vk::AccessFlags2::NONE },
                read_stages: if info.writes { vk::PipelineStageFlags2::NONE } else { info.stages },
                read_access: if info.writes { vk::AccessFlags2::NONE } else { info.access },
            };
        } else {
            self.read_stages |= info.stages;
            self.read_access |= info.access;
        }
        let misses_a_write = !before.write_stages.is_empty() && !sees_write;
        let needs_barrier = changes_layout || (!is_unused && (info.writes || misses_a_write));
        let waits_for_reads = info.writes || changes_layout;
        needs_barrier.then(|| Transition {
            // Every use waits for the last write. A write or a new layout also waits for the reads since then.
            src_stages: before.write_stages
                | if waits_for_reads { before.read_stages } else { vk::PipelineStageFlags2::NONE },
            src_access: before.write_access,
            dst_stages: info.stages,
            dst_access: info.access,
            old_layout: before.layout,
            new_layout: if changes_layout { info.layout } else { before.layout },
        })
    }
}
