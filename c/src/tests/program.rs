//! The device, the images and the command buffer of a program that uses the library, under the validation layers.

use super::{assert_ok, sized};
use crate::border::SsctResult;
use crate::context::{SsctContext, SsctContextInfo, ssct_context_create, ssct_enable_features};
use crate::image::{SSCT_USE_TRANSFER_TARGET, SsctImage, ssct_image_use};
use ash::vk;
use std::ffi::{CStr, c_void};
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A message of the layers for Vulkan 1.4, which is no fault. A pass has no attachment for hits if nobody wants the
/// hits, and Vulkan discards what a shader writes to an output without an attachment.
const DISCARDED: &CStr = c"Undefined-Value-ShaderOutputNotConsumed-DynamicRendering";

/// The number of all other messages of the validation layers.
static MESSAGES: AtomicUsize = AtomicUsize::new(0);

/// Prints and counts a message of the validation layers, unless it is [`DISCARDED`].
unsafe extern "system" fn count(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    message: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _: *mut c_void,
) -> vk::Bool32 {
    let (id, text) = unsafe { ((*message).message_id_name_as_c_str(), (*message).message_as_c_str()) };
    if id != Some(DISCARDED) {
        eprintln!("{text:?}");
        MESSAGES.fetch_add(1, Ordering::Relaxed);
    }
    vk::FALSE
}

/// A program's device and command buffer. Only one program exists at a time, since the layers read their table of
/// devices without a lock.
pub struct Program {
    _alone: MutexGuard<'static, ()>,
    _entry: ash::Entry,
    pub instance: ash::Instance,
    messenger: (ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT),
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    features: vk::PhysicalDeviceFeatures,
    features12: vk::PhysicalDeviceVulkan12Features<'static>,
    features13: vk::PhysicalDeviceVulkan13Features<'static>,
    pool: vk::CommandPool,
    pub commands: vk::CommandBuffer,
    images: Vec<(vk::Image, vk::ImageView, vk::DeviceMemory)>,
}

impl Program {
    /// Makes an instance with the layers, and a device with the features that the library needs.
    pub fn new() -> Self {
        static RUNNING: Mutex<()> = Mutex::new(());
        let alone = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        MESSAGES.store(0, Ordering::Relaxed);
        unsafe {
            let entry = ash::Entry::load().unwrap();
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let (layers, extensions) =
                ([c"VK_LAYER_KHRONOS_validation".as_ptr()], [ash::ext::debug_utils::NAME.as_ptr()]);
            let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut validation = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut validation);
            let instance = entry.create_instance(&info, None).unwrap();
            use vk::DebugUtilsMessageSeverityFlagsEXT as S;
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(S::ERROR | S::WARNING)
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(count));
            let debug = ash::ext::debug_utils::Instance::new(&entry, &instance);
            let messenger = debug.create_debug_utils_messenger(&info, None).unwrap();
            let physical = instance.enumerate_physical_devices().unwrap()[0];
            let mut features = vk::PhysicalDeviceFeatures::default();
            let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
            let mut features13 = vk::PhysicalDeviceVulkan13Features::default();
            assert_eq!(ssct_enable_features(&mut features, &mut features12, &mut features13), SsctResult::Ok);
            let (mut chained12, mut chained13) = (features12, features13);
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&features)
                .push_next(&mut chained12)
                .push_next(&mut chained13);
            let device = instance.create_device(physical, &info, None).unwrap();
            let reset = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
            let pool = device.create_command_pool(&vk::CommandPoolCreateInfo::default().flags(reset), None).unwrap();
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).unwrap()[0];
            Self {
                _alone: alone,
                _entry: entry,
                instance,
                messenger: (debug, messenger),
                physical,
                device,
                features,
                features12,
                features13,
                pool,
                commands,
                images: Vec::new(),
            }
        }
    }

    /// Describes the device as `ssct_context_create` needs it.
    pub fn info(&self) -> SsctContextInfo {
        SsctContextInfo {
            struct_size: size_of::<SsctContextInfo>(),
            get_instance_proc_addr: None,
            instance: self.instance.handle(),
            physical_device: self.physical,
            device: self.device.handle(),
            queue_family: 0,
            debug_utils: vk::TRUE,
            features: &self.features,
            features12: &self.features12,
            features13: &self.features13,
            memory: null(),
        }
    }

    /// Makes a context of the device.
    pub fn context(&self) -> *mut SsctContext {
        let mut context = null_mut();
        assert_ok(unsafe { ssct_context_create(&self.info(), &mut context) });
        context
    }

    /// Makes an image of `side` × `side` texels that all have one value, ready to be sampled in fragment shaders. Six
    /// layers make a cube map.
    pub fn image(&mut self, format: vk::Format, side: u32, value: [f32; 4], layers: u32) -> SsctImage {
        let (aspect, usage) = (
            vk::ImageAspectFlags::COLOR,
            vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_DST,
        );
        let part = vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(layers);
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: side, height: side, depth: 1 })
            .mip_levels(1)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let device = &self.device;
        let (image, view) = unsafe {
            let image = device.create_image(&info, None).unwrap();
            let needs = device.get_image_memory_requirements(image);
            let kind = needs.memory_type_bits.trailing_zeros();
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            let memory = device.allocate_memory(&info, None).unwrap();
            device.bind_image_memory(image, memory, 0).unwrap();
            let kind = if layers == 6 { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
            let info =
                vk::ImageViewCreateInfo::default().image(image).view_type(kind).format(format).subresource_range(part);
            let view = device.create_image_view(&info, None).unwrap();
            self.images.push((image, view, memory));
            (image, view)
        };
        let write = ssct_image_use(SSCT_USE_TRANSFER_TARGET);
        let before = vk::ImageMemoryBarrier2::default()
            .image(image)
            .new_layout(write.layout)
            .dst_stage_mask(vk::PipelineStageFlags2::from_raw(write.stages))
            .dst_access_mask(vk::AccessFlags2::from_raw(write.access))
            .subresource_range(part);
        self.submit(|device, commands| unsafe {
            device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&[before]));
            let color = vk::ClearColorValue { float32: value };
            device.cmd_clear_color_image(commands, image, write.layout, &color, &[part]);
            let read = vk::PipelineStageFlags2::FRAGMENT_SHADER;
            let after = before
                .old_layout(write.layout)
                .new_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
                .src_stage_mask(before.dst_stage_mask)
                .src_access_mask(before.dst_access_mask)
                .dst_stage_mask(read)
                .dst_access_mask(vk::AccessFlags2::SHADER_READ);
            device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&[after]));
        });
        SsctImage {
            image,
            view,
            format,
            extent: vk::Extent2D { width: side, height: side },
            ..sized(size_of::<SsctImage>())
        }
    }

    /// Reads the texels of an image of half floats, row by row. `record` records the frame that makes the image of
    /// `side` × `side` texels, and returns the image in the layout for copies.
    pub fn read(&self, side: u32, record: impl FnOnce(vk::CommandBuffer) -> vk::Image) -> Vec<[u16; 4]> {
        use vk::MemoryPropertyFlags as P;
        let texels = (side * side) as usize;
        let info = vk::BufferCreateInfo::default().size(8 * texels as u64).usage(vk::BufferUsageFlags::TRANSFER_DST);
        let device = &self.device;
        unsafe {
            let buffer = device.create_buffer(&info, None).unwrap();
            let needs = device.get_buffer_memory_requirements(buffer);
            let kinds = self.instance.get_physical_device_memory_properties(self.physical);
            let wanted = P::HOST_VISIBLE | P::HOST_COHERENT;
            let fits = |i: &u32| {
                let has_wanted = kinds.memory_types[*i as usize].property_flags.contains(wanted);
                needs.memory_type_bits >> i & 1 == 1 && has_wanted
            };
            let kind = (0..kinds.memory_type_count).find(fits).unwrap();
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            let memory = device.allocate_memory(&info, None).unwrap();
            device.bind_buffer_memory(buffer, memory, 0).unwrap();
            self.submit(|device, commands| {
                let image = record(commands);
                let part =
                    vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
                let extent = vk::Extent3D { width: side, height: side, depth: 1 };
                let copy = vk::BufferImageCopy::default().image_subresource(part).image_extent(extent);
                let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                device.cmd_copy_image_to_buffer(commands, image, layout, buffer, &[copy]);
                let barrier = vk::MemoryBarrier2::default()
                    .src_stage_mask(vk::PipelineStageFlags2::COPY)
                    .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                    .dst_stage_mask(vk::PipelineStageFlags2::HOST)
                    .dst_access_mask(vk::AccessFlags2::HOST_READ);
                device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&[barrier]));
            });
            let mapped = device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap();
            let read = std::slice::from_raw_parts(mapped.cast::<[u16; 4]>(), texels).to_vec();
            device.destroy_buffer(buffer, None);
            device.free_memory(memory, None);
            read
        }
    }

    /// Lets `record` record commands, submits them, and waits until the device is done. Returns the result of `record`.
    pub fn submit<R>(&self, record: impl FnOnce(&ash::Device, vk::CommandBuffer) -> R) -> R {
        unsafe {
            self.device.begin_command_buffer(self.commands, &vk::CommandBufferBeginInfo::default()).unwrap();
            let result = record(&self.device, self.commands);
            self.device.end_command_buffer(self.commands).unwrap();
            let commands = [self.commands];
            let queue = self.device.get_device_queue(0, 0);
            let info = vk::SubmitInfo::default().command_buffers(&commands);
            self.device.queue_submit(queue, &[info], vk::Fence::null()).unwrap();
            self.device.queue_wait_idle(queue).unwrap();
            result
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            for (image, view, memory) in self.images.drain(..) {
                self.device.destroy_image_view(view, None);
                self.device.destroy_image(image, None);
                self.device.free_memory(memory, None);
            }
            self.device.destroy_device(None);
            self.messenger.0.destroy_debug_utils_messenger(self.messenger.1, None);
            self.instance.destroy_instance(None);
        }
        if !std::thread::panicking() {
            assert_eq!(MESSAGES.load(Ordering::Relaxed), 0, "messages of the validation layers");
        }
    }
}
