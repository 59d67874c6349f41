//! A minimal renderer that takes reflections from `ssct`: it computes a G-buffer on the CPU, copies it to the device,
//! records `unified`, and returns the texels of its images. `packaged.rs` runs it here, and builds the same file
//! against the packaged crate.

use ash::vk;
use std::error::Error;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Width and height in pixels; odd, so that no pyramid divides evenly.
pub const SIZE: [u32; 2] = [97, 61];

/// Bytes of a texel of the composite, and of the reflection: four 16-bit floats.
pub const TEXEL: usize = 8;

/// Formats of the input images, in the order depth, normal, material, colour: one 32-bit float for depth, four for the
/// others.
const INPUTS: [vk::Format; 4] = {
    use vk::Format as F;
    [F::R32_SFLOAT, F::R32G32B32A32_SFLOAT, F::R32G32B32A32_SFLOAT, F::R32G32B32A32_SFLOAT]
};

/// Distance of the near plane, in metres.
const NEAR: f32 = 0.1;

/// Factors of x and y in the projection: clip-space x and y are these times view-space x and y.
const SCALE: [f32; 2] = [1.2, 1.2 * SIZE[0] as f32 / SIZE[1] as f32];

/// Computes the G-buffer of pixel (`x`, `y`), counted from the top left: its reversed depth; then its normal, its
/// material (reflectivity, roughness) and its colour.
///
/// The scene is a floor, which is rougher to the right, before a pillar and a chequered wall. Only operations that IEEE
/// 754 rounds exactly are used, so that every build computes the same.
fn pixel(x: u32, y: u32) -> ([f32; 1], [[f32; 4]; 3]) {
    // The centre of the pixel, from -1 to 1 along an axis; then how far its ray goes right and up for each metre ahead.
    let centre = |coordinate: u32, axis: usize| (coordinate as f32 + 0.5) / SIZE[axis] as f32 * 2.0 - 1.0;
    let (right, up) = (centre(x, 0) / SCALE[0], -centre(y, 1) / SCALE[1]);
    let is_pillar = |z: f32| (right * z).abs() < 0.6 && up * z < 1.0;
    let wall = if is_pillar(4.0) { 4.0 } else { 8.0 };
    let floor = if up < 0.0 { -1.0 / up } else { f32::INFINITY };
    let z = if floor < wall { floor } else { wall };
    let parity = |metres: f32| (metres * 1.5).floor().rem_euclid(2.0);
    let depth = [NEAR / z];
    if floor < wall {
        let roughness = 0.2 * (x as f32 / SIZE[0] as f32);
        return (depth, [[0.0, 1.0, 0.0, 0.0], [0.7, roughness, 0.0, 0.0], [0.05, 0.05, 0.06, 1.0]]);
    }
    let color = if z == 4.0 { [2.0, 0.5, 0.1, 1.0] } else { [0.2, 0.3 + 0.5 * parity(right * z), parity(up * z), 1.0] };
    (depth, [[0.0, 0.0, -1.0, 0.0], [0.0; 4], color])
}

/// Opens a device, renders one frame, and returns the bytes of the composite's texels, followed by those of the
/// reflection's.
pub fn picture() -> Result<Vec<u8>> {
    // SAFETY: handles are of this instance and device, which are destroyed last, after the queue was waited for; every
    // structure lives through its call.
    unsafe {
        let entry = ash::Entry::load()?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&info, None)?;
        let physical = *instance.enumerate_physical_devices()?.first().ok_or("no Vulkan device")?;
        let families = instance.get_physical_device_queue_family_properties(physical);
        let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let family =
            families.iter().position(|f| f.queue_flags.contains(wanted)).ok_or("no queue for graphics")? as u32;
        let mut enabled = ssct::EnabledFeatures::default();
        ssct::enable_features(&mut enabled.core, &mut enabled.vulkan12, &mut enabled.vulkan13);
        let (mut vulkan12, mut vulkan13) = (enabled.vulkan12, enabled.vulkan13);
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&enabled.core)
            .push_next(&mut vulkan12)
            .push_next(&mut vulkan13);
        let device = instance.create_device(physical, &info, None)?;
        let handles = ssct::DeviceHandles {
            entry: entry.clone(),
            instance: instance.clone(),
            physical,
            device: device.clone(),
            queue_family: family,
            enabled,
            debug_utils: false,
            memory: None,
        };
        let renderer = Renderer { instance: &instance, physical, device: &device, family };
        let texels = renderer.frame(handles);
        device.destroy_device(None);
        instance.destroy_instance(None);
        texels
    }
}

/// The handles that the renderer's functions need. `family` is the index of the queue family.
struct Renderer<'a> {
    instance: &'a ash::Instance,
    physical: vk::PhysicalDevice,
    device: &'a ash::Device,
    family: u32,
}

impl Renderer<'_> {
    /// Renders one frame and reads its images back, as [`picture`] returns them.
    ///
    /// # Safety
    /// The handles are those of the renderer.
    unsafe fn frame(&self, handles: ssct::DeviceHandles) -> Result<Vec<u8>> {
        let device = self.device;
        let [width, height] = SIZE;
        let coordinates = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut texels: [Vec<u8>; 4] = Default::default();
        for (x, y) in coordinates {
            let (depth, vectors) = pixel(x, y);
            texels[0].extend(depth[0].to_ne_bytes());
            for (texels, values) in texels[1..].iter_mut().zip(vectors) {
                texels.extend(values.into_iter().flat_map(f32::to_ne_bytes));
            }
        }
        let size = (width * height) as usize * TEXEL;
        // SAFETY: as in `picture`.
        unsafe {
            let context = ssct::Context::new(handles)?;
            let info = ssct::ReflectionsInfo { extent: SIZE, method: "unified", ..Default::default() };
            let mut reflections = ssct::Reflections::new(&context, &info)?;

            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(self.family);
            let pool = device.create_command_pool(&pool, None)?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info)?[0];
            device.begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default())?;

            let (mut images, mut buffers) = (Vec::new(), Vec::new());
            for (format, bytes) in INPUTS.into_iter().zip(&texels) {
                images.push(self.image(format)?);
                buffers.push(self.buffer(bytes.len(), vk::BufferUsageFlags::TRANSFER_SRC)?);
                let ((image, ..), (buffer, memory)) = (images[images.len() - 1], buffers[buffers.len() - 1]);
                let mapped = device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), mapped.cast::<u8>(), bytes.len());
                device.unmap_memory(memory);
                let barrier = vk::ImageMemoryBarrier::default()
                    .image(image)
                    .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                    .new_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
                    .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .subresource_range(WHOLE);
                device.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::TOP_OF_PIPE,
                    vk::PipelineStageFlags::TRANSFER,
                    vk::DependencyFlags::empty(),
                    &[],
                    &[],
                    &[barrier],
                );
                let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
                device.cmd_copy_buffer_to_image(commands, buffer, image, layout, &[copy()]);
            }

            let inputs: Vec<_> = images
                .iter()
                .zip(INPUTS)
                .map(|((image, view, _), format)| {
                    ssct::ImageInput::color(*image, *view, format, SIZE)
                        .used(ssct::ImageUse::TRANSFER_TARGET, ssct::ImageUse::FRAGMENT_SAMPLED)
                })
                .collect();
            // The eye is at the origin, and looks along +z; depth is reversed, and the far plane infinitely far.
            let world_to_view = std::array::from_fn(|i| if i % 5 == 0 { 1.0 } else { 0.0 });
            let [x, y] = SCALE;
            let view_to_clip = [x, 0., 0., 0., 0., y, 0., 0., 0., 0., 0., 1., 0., 0., NEAR, 0.];
            let recorded = reflections.record(
                commands,
                &ssct::FrameInput {
                    slot: 0,
                    camera: ssct::CameraInput { world_to_view, view_to_clip, clip_y: ssct::ClipY::Up },
                    depth: inputs[0],
                    normal: ssct::NormalInput {
                        image: inputs[1],
                        space: ssct::NormalSpace::World,
                        encoding: ssct::NormalEncoding::Float,
                    },
                    reflectivity: ssct::FactorInput::Channel(inputs[2], 0),
                    roughness: ssct::FactorInput::Channel(inputs[2], 1),
                    reflectors: ssct::Reflectors::UNKNOWN,
                    color: inputs[3],
                    sky: None,
                    captures: None,
                    triangles: None,
                    triangle_numbers: None,
                    motion: None,
                    timed: false,
                    outputs: ssct::ImageUse::TRANSFER_SOURCE,
                },
            )?;

            let outputs = [recorded.composite.ok_or("no composite")?, recorded.reflection.ok_or("nothing reflects")?];
            for output in outputs {
                assert_eq!(output.format, vk::Format::R16G16B16A16_SFLOAT);
                buffers.push(self.buffer(size, vk::BufferUsageFlags::TRANSFER_DST)?);
                let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                let (buffer, _) = buffers[buffers.len() - 1];
                device.cmd_copy_image_to_buffer(commands, output.image, layout, buffer, &[copy()]);
            }
            let barrier = vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ);
            device.cmd_pipeline_barrier(
                commands,
                vk::PipelineStageFlags::TRANSFER,
                vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &[barrier],
                &[],
                &[],
            );
            device.end_command_buffer(commands)?;
            let (queue, submitted) = (device.get_device_queue(self.family, 0), [commands]);
            let submit = vk::SubmitInfo::default().command_buffers(&submitted);
            device.queue_submit(queue, &[submit], vk::Fence::null())?;
            device.queue_wait_idle(queue)?;

            let mut texels_read = Vec::new();
            for (_, memory) in &buffers[buffers.len() - outputs.len()..] {
                let mapped = device.map_memory(*memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
                texels_read.extend(std::slice::from_raw_parts(mapped.cast::<u8>(), size));
                device.unmap_memory(*memory);
            }

            drop((reflections, context));
            device.destroy_command_pool(pool, None);
            for (image, view, memory) in images {
                device.destroy_image_view(view, None);
                device.destroy_image(image, None);
                device.free_memory(memory, None);
            }
            for (buffer, memory) in buffers {
                device.destroy_buffer(buffer, None);
                device.free_memory(memory, None);
            }
            Ok(texels_read)
        }
    }

    /// Makes an image of `SIZE` that is copied to and sampled. Returns the image, its view and its memory.
    fn image(&self, format: vk::Format) -> Result<(vk::Image, vk::ImageView, vk::DeviceMemory)> {
        let [width, height] = SIZE;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED);
        // SAFETY: as in `picture`.
        unsafe {
            let image = self.device.create_image(&info, None)?;
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.memory(needs, vk::MemoryPropertyFlags::empty())?;
            self.device.bind_image_memory(image, memory, 0)?;
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(WHOLE);
            Ok((image, self.device.create_image_view(&info, None)?, memory))
        }
    }

    /// Makes a buffer of `size` bytes that the host can map. Returns the buffer and its memory.
    fn buffer(&self, size: usize, usage: vk::BufferUsageFlags) -> Result<(vk::Buffer, vk::DeviceMemory)> {
        use vk::MemoryPropertyFlags as P;
        // SAFETY: as in `picture`.
        unsafe {
            let info = vk::BufferCreateInfo::default().size(size as u64).usage(usage);
            let buffer = self.device.create_buffer(&info, None)?;
            let needs = self.device.get_buffer_memory_requirements(buffer);
            let memory = self.memory(needs, P::HOST_VISIBLE | P::HOST_COHERENT)?;
            self.device.bind_buffer_memory(buffer, memory, 0)?;
            Ok((buffer, memory))
        }
    }

    /// Allocates memory that meets the requirements `needs` and has all properties `wanted`. Each image and buffer has
    /// memory of its own, since there are few.
    fn memory(&self, needs: vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags) -> Result<vk::DeviceMemory> {
        // SAFETY: as in `picture`.
        unsafe {
            let types = self.instance.get_physical_device_memory_properties(self.physical);
            let fits = |(i, t): &(usize, &vk::MemoryType)| {
                needs.memory_type_bits & (1 << i) != 0 && t.property_flags.contains(wanted)
            };
            let kind = types.memory_types_as_slice().iter().enumerate().find(fits).ok_or("no memory")?.0;
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind as u32);
            Ok(self.device.allocate_memory(&info, None)?)
        }
    }
}

/// The whole of an image: its one level and layer.
const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// Returns the region that copies between a whole image and a buffer.
fn copy() -> vk::BufferImageCopy {
    let [width, height] = SIZE;
    let layers = vk::ImageSubresourceLayers::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .base_array_layer(0)
        .layer_count(1);
    vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D { width, height, depth: 1 })
}
