//! The acceleration structure for ray queries. The device builds a bottom level over triangles, and a top level that
//! holds the bottom level as one instance, unmoved.

use super::device::{Gpu, RayQueries, vulkan};
use super::frame::{FrameContext, Mode};
use super::memory::{Buffer, MemoryPlace};
use crate::error::Result;
use ash::vk;

/// Both levels of the structure. The buffers that they were built from are not read any more.
pub struct RayStructure {
    top: Level,
    bottom: Level,
    build_ms: f64,
}

/// Triangles in a buffer that was made with [`RayStructure::INPUT`]. Each triangle has three corners, one after the
/// other, and each corner begins with its place in three floats.
pub struct Corners<'a> {
    /// The buffer.
    pub buffer: &'a Buffer,
    /// The byte at which the first corner begins.
    pub first_byte: u64,
    /// Bytes from one corner to the next.
    pub stride: u64,
    /// The number of triangles.
    pub triangles: u32,
}

impl RayStructure {
    /// The usage that a buffer must have so that a structure can be built of it.
    pub const INPUT: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
        vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR.as_raw()
            | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS.as_raw(),
    );

    /// Builds the structure over triangles, numbered in the order of the buffer. A ray query proposes each triangle as
    /// a candidate, and the shader decides whether it counts as a hit.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] without ray queries, [`crate::error::Error::Memory`] without memory.
    pub fn build(context: &mut FrameContext, corners: &Corners) -> Result<Self> {
        let gpu = context.gpu().clone();
        gpu.ray_queries()?; // a device without ray queries is refused: its buffers have no addresses
        let count = corners.triangles;
        let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(address(corners.buffer.address() + corners.first_byte))
            .vertex_stride(corners.stride)
            .max_vertex(count.saturating_mul(3).saturating_sub(1))
            .index_type(vk::IndexType::NONE_KHR);
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data });
        let bottom_build = Build { kind: vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, geometry, count };
        let (bottom, bottom_scratch) = Level::new(&gpu, &bottom_build)?;
        let words = instance(bottom.address()?);
        let instances = Buffer::upload(&gpu, "ray instance", bytemuck::cast_slice(&words), Self::INPUT)?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(address(instances.address()));
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
        let top_build = Build { kind: vk::AccelerationStructureTypeKHR::TOP_LEVEL, geometry, count: 1 };
        let (top, top_scratch) = Level::new(&gpu, &top_build)?;

        let mut frame = context.begin(Mode::Timed)?;
        frame.build_rays("rays/bottom", &bottom_build, (&bottom, &bottom_scratch), (corners.buffer, None))?;
        frame.build_rays("rays/top", &top_build, (&top, &top_scratch), (&instances, Some(&bottom)))?;
        let build_ms = frame.finish()?.passes.iter().map(|pass| pass.ms).sum();
        Ok(Self { top, bottom, build_ms })
    }

    /// Time that the device took to build the structure, in milliseconds.
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }

    /// The top level, which shaders bind.
    pub(super) fn handle(&self) -> vk::AccelerationStructureKHR {
        self.top.handle
    }

    /// The memory of both levels.
    pub(super) fn buffers(&self) -> [&Buffer; 2] {
        [&self.top.buffer, &self.bottom.buffer]
    }
}

/// One level: an acceleration structure and its memory.
pub(super) struct Level {
    gpu: Gpu,
    pub(super) handle: vk::AccelerationStructureKHR,
    pub(super) buffer: Buffer,
}

/// The input of a structure's build: `count` triangles or instances.
pub(super) struct Build {
    pub(super) kind: vk::AccelerationStructureTypeKHR,
    pub(super) geometry: vk::AccelerationStructureGeometryKHR<'static>,
    pub(super) count: u32,
}

impl Build {
    /// Returns the description for Vulkan; the structure to build and its scratch memory are still to be set.
    pub(super) fn info(&self) -> vk::AccelerationStructureBuildGeometryInfoKHR<'_> {
        vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(self.kind)
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(std::slice::from_ref(&self.geometry))
    }
}

impl Level {
    /// Makes an empty structure for a build, and the scratch memory that the build works in.
    fn new(gpu: &Gpu, build: &Build) -> Result<(Self, Buffer)> {
        let RayQueries { structures: functions, scratch_alignment } = gpu.ray_queries()?;
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: the description is complete; addresses in it are not read here.
        unsafe {
            functions.get_acceleration_structure_build_sizes(
                vk::AccelerationStructureBuildTypeKHR::DEVICE,
                &build.info(),
                &[build.count],
                &mut sizes,
            );
        }
        let usage =
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let bytes = sizes.acceleration_structure_size;
        let buffer = Buffer::new(gpu, "ray structure", bytes, usage, MemoryPlace::Device)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.handle()).size(bytes).ty(build.kind);
        // SAFETY: the buffer is large enough and outlives the structure, which is destroyed in `drop`.
        let handle = unsafe { functions.create_acceleration_structure(&info, None) }
            .map_err(vulkan("vkCreateAccelerationStructureKHR"))?;
        gpu.name(handle, "ray structure");
        let level = Self { gpu: gpu.clone(), handle, buffer };
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let bytes = sizes.build_scratch_size + scratch_alignment;
        Ok((level, Buffer::new(gpu, "ray scratch", bytes, usage, MemoryPlace::Device)?))
    }

    fn address(&self) -> Result<u64> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(self.handle);
        // SAFETY: the structure is alive.
        Ok(unsafe { self.gpu.ray_queries()?.structures.get_acceleration_structure_device_address(&info) })
    }
}

impl Drop for Level {
    fn drop(&mut self) {
        if let Ok(queries) = self.gpu.ray_queries() {
            // SAFETY: submissions are waited for before resources go (`FrameContext`).
            unsafe { queries.structures.destroy_acceleration_structure(self.handle, None) };
        }
    }
}

/// Wraps an address on the device in the union by which Vulkan takes an address on the device or the host.
fn address(device_address: u64) -> vk::DeviceOrHostAddressConstKHR {
    vk::DeviceOrHostAddressConstKHR { device_address }
}

/// Returns the words of a `VkAccelerationStructureInstanceKHR` for the structure at an address. Words 0 to 11 are three
/// rows of the identity matrix, the upper byte of word 12 is a mask for every ray, and words 14 and 15 are the address.
fn instance(device_address: u64) -> [u32; 16] {
    let one = 1.0_f32.to_bits();
    let mut words = [0; 16];
    (words[0], words[5], words[10]) = (one, one, one);
    words[12] = 0xff << 24;
    (words[14], words[15]) = (device_address as u32, (device_address >> 32) as u32);
    words
}
