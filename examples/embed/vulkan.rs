//! The renderer itself. Only the features of its device and the function `handles` are made for reflections.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};
use std::error::Error;

/// Width and height of all images.
pub const SIZE: [u32; 2] = [640, 360];
/// The format of colour images: four 16-bit floats.
pub const HALF: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// The format of the depth buffer.
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
const EXTENT: vk::Extent2D = vk::Extent2D { width: SIZE[0], height: SIZE[1] };

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The device with its allocator and its first queue; `features` are those that the device was made with.
pub struct Renderer {
    entry: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    features: ssct::EnabledFeatures,
    queue: vk::Queue,
    allocator: Option<Allocator>,
    pool: vk::CommandPool,
}

/// An image with its view and memory.
pub struct Picture {
    pub image: vk::Image,
    pub view: vk::ImageView,
    allocation: Allocation,
}

/// A render pass, and the framebuffer and pipeline that draw in it.
pub struct Pass {
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
}

impl Renderer {
    /// Opens the first Vulkan device, with the features that `ssct` needs.
    pub fn new() -> Result<Self> {
        // SAFETY: what is made is destroyed in `destroy`; every structure lives through its call.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let physical = *instance.enumerate_physical_devices()?.first().ok_or("no Vulkan device")?;
            let mut features = ssct::EnabledFeatures::default();
            ssct::enable_features(&mut features.core, &mut features.vulkan12, &mut features.vulkan13);
            let (mut v12, mut v13) = (features.vulkan12, features.vulkan13);
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&features.core)
                .push_next(&mut v12)
                .push_next(&mut v13);
            let device = instance.create_device(physical, &info, None)?;
            let allocator = Some(Allocator::new(&AllocatorCreateDesc {
                instance: instance.clone(),
                device: device.clone(),
                physical_device: physical,
                debug_settings: Default::default(),
                buffer_device_address: false,
                allocation_sizes: Default::default(),
            })?);
            let (pool, queue) = (device.create_command_pool(&Default::default(), None)?, device.get_device_queue(0, 0));
            Ok(Self { entry, instance, physical, device, features, queue, allocator, pool })
        }
    }

    /// Returns the handles from which `ssct` makes its context on this device.
    pub fn handles(&self) -> ssct::DeviceHandles {
        ssct::DeviceHandles {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical: self.physical,
            device: self.device.clone(),
            queue_family: 0,
            enabled: self.features.clone(),
            debug_utils: false,
            memory: None,
        }
    }

    /// Makes an image that the render pass draws, and that is then sampled and copied.
    pub fn picture(&mut self, format: vk::Format) -> Result<Picture> {
        use vk::{ImageAspectFlags as A, ImageUsageFlags as U};
        let is_depth = format == DEPTH;
        let (aspect, target) =
            if is_depth { (A::DEPTH, U::DEPTH_STENCIL_ATTACHMENT) } else { (A::COLOR, U::COLOR_ATTACHMENT) };
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(EXTENT.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(target | U::SAMPLED | U::TRANSFER_SRC);
        // SAFETY: as in `new`.
        unsafe {
            let image = self.device.create_image(&info, None)?;
            let requirements = self.device.get_image_memory_requirements(image);
            let allocation = self.allocate(requirements, MemoryLocation::GpuOnly, false)?;
            self.device.bind_image_memory(image, allocation.memory(), allocation.offset())?;
            let range = vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(1);
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(range);
            Ok(Picture { image, view: self.device.create_image_view(&info, None)?, allocation })
        }
    }

    /// Allocates memory at `location`; `linear` is true for buffers.
    fn allocate(
        &mut self,
        needs: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Result<Allocation> {
        let (requirements, allocation_scheme) = (needs, AllocationScheme::GpuAllocatorManaged);
        let desc = AllocationCreateDesc { name: "embed", requirements, location, linear, allocation_scheme };
        Ok(self.allocator.as_mut().ok_or("destroyed")?.allocate(&desc)?)
    }

    /// Makes a render pass over three colours and a depth, and the pipeline of the scene. The pass leaves its images in
    /// the layout to sample them.
    pub fn pass(&self, colors: &[Picture], depth: &Picture) -> Result<Pass> {
        let attachment = |format| {
            vk::AttachmentDescription::default()
                .format(format)
                .samples(vk::SampleCountFlags::TYPE_1)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
                .final_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
        };
        let attachments = [HALF, HALF, HALF, DEPTH].map(attachment);
        let reference = |attachment, layout| vk::AttachmentReference { attachment, layout };
        let references = [0, 1, 2].map(|i| reference(i, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL));
        let depth_reference = reference(3, vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
        let subpass = vk::SubpassDescription::default().color_attachments(&references);
        let subpasses = [subpass.depth_stencil_attachment(&depth_reference)];
        let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
        let views: Vec<_> = colors.iter().chain([depth]).map(|p| p.view).collect();
        let pushes = [vk::PushConstantRange { stage_flags: vk::ShaderStageFlags::FRAGMENT, offset: 0, size: 128 }];
        // SAFETY: as in `new`.
        unsafe {
            let pass = self.device.create_render_pass(&info, None)?;
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(pass)
                .attachments(&views)
                .width(SIZE[0])
                .height(SIZE[1])
                .layers(1);
            let framebuffer = self.device.create_framebuffer(&info, None)?;
            let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&pushes);
            let layout = self.device.create_pipeline_layout(&info, None)?;
            let compiler = shaderc::Compiler::new()?;
            let module = |text, kind, name| -> Result<vk::ShaderModule> {
                let code = compiler.compile_into_spirv(text, kind, name, "main", None)?;
                let info = vk::ShaderModuleCreateInfo::default().code(code.as_binary());
                Ok(self.device.create_shader_module(&info, None)?)
            };
            let vertex = module(include_str!("scene.vert"), shaderc::ShaderKind::Vertex, "scene.vert")?;
            let fragment = module(include_str!("scene.frag"), shaderc::ShaderKind::Fragment, "scene.frag")?;
            let stage =
                |flags, module| vk::PipelineShaderStageCreateInfo::default().stage(flags).module(module).name(c"main");
            let stages = [stage(vk::ShaderStageFlags::VERTEX, vertex), stage(vk::ShaderStageFlags::FRAGMENT, fragment)];
            let triangles = vk::PrimitiveTopology::TRIANGLE_LIST;
            let input = vk::PipelineVertexInputStateCreateInfo::default();
            let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(triangles);
            let viewports = [vk::Viewport::default().width(SIZE[0] as f32).height(SIZE[1] as f32).max_depth(1.0)];
            let scissors = [EXTENT.into()];
            let viewport = vk::PipelineViewportStateCreateInfo::default().viewports(&viewports).scissors(&scissors);
            let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
            let samples =
                vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
            let depth_state = vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(true)
                .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
            let blend =
                [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA); 3];
            let blends = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
            let info = vk::GraphicsPipelineCreateInfo::default()
                .stages(&stages)
                .vertex_input_state(&input)
                .input_assembly_state(&assembly)
                .viewport_state(&viewport)
                .rasterization_state(&raster)
                .multisample_state(&samples)
                .depth_stencil_state(&depth_state)
                .color_blend_state(&blends)
                .layout(layout)
                .render_pass(pass);
            let pipelines = self.device.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None);
            let pipeline = pipelines.map_err(|(_, e)| e)?[0];
            [vertex, fragment].into_iter().for_each(|module| self.device.destroy_shader_module(module, None));
            Ok(Pass { pass, framebuffer, layout, pipeline })
        }
    }

    /// Returns a command buffer that is recording.
    pub fn begin(&self) -> Result<vk::CommandBuffer> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: as in `new`; the pool frees its command buffers.
        unsafe {
            let commands = self.device.allocate_command_buffers(&info)?[0];
            self.device.begin_command_buffer(commands, &begin)?;
            Ok(commands)
        }
    }

    /// Records the render pass, which draws the scene through a camera with the matrices `clip` (view to clip) and
    /// `view` (world to view).
    pub fn draw(&self, commands: vk::CommandBuffer, pass: &Pass, clip: &[f32; 16], view: &[f32; 16]) {
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(pass.pass)
            .framebuffer(pass.framebuffer)
            .render_area(EXTENT.into())
            .clear_values(&[vk::ClearValue { color: vk::ClearColorValue { float32: [0.0; 4] } }; 4]);
        let numbers: Vec<u8> = clip.iter().chain(view).flat_map(|v| v.to_ne_bytes()).collect();
        // SAFETY: the command buffer is recording, and everything lives until it was submitted.
        unsafe {
            self.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
            self.device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pass.pipeline);
            self.device.cmd_push_constants(commands, pass.layout, vk::ShaderStageFlags::FRAGMENT, 0, &numbers);
            self.device.cmd_draw(commands, 3, 1, 0, 0);
            self.device.cmd_end_render_pass(commands);
        }
    }

    /// Records copies of images, which must be in the layout `TRANSFER_SRC_OPTIMAL`, submits the command buffer, and
    /// waits. Returns the numbers of each image, texel by texel.
    pub fn submit_and_read(
        &mut self,
        commands: vk::CommandBuffer,
        images: &[(&str, vk::Image, vk::Format)],
    ) -> Result<Vec<Vec<f32>>> {
        let texels = (SIZE[0] * SIZE[1]) as usize;
        // SAFETY: as in `new`; the queue is waited for before anything is destroyed.
        unsafe {
            let mut buffers = Vec::new();
            for (_, image, format) in images {
                let info = vk::BufferCreateInfo::default().size(8 * texels as u64);
                let buffer = self.device.create_buffer(&info.usage(vk::BufferUsageFlags::TRANSFER_DST), None)?;
                let requirements = self.device.get_buffer_memory_requirements(buffer);
                let allocation = self.allocate(requirements, MemoryLocation::GpuToCpu, true)?;
                self.device.bind_buffer_memory(buffer, allocation.memory(), allocation.offset())?;
                let aspect = if *format == DEPTH { vk::ImageAspectFlags::DEPTH } else { vk::ImageAspectFlags::COLOR };
                let copy = vk::BufferImageCopy::default()
                    .image_subresource(vk::ImageSubresourceLayers::default().aspect_mask(aspect).layer_count(1))
                    .image_extent(EXTENT.into());
                let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                self.device.cmd_copy_image_to_buffer(commands, *image, layout, buffer, &[copy]);
                buffers.push((buffer, allocation));
            }
            self.device.end_command_buffer(commands)?;
            let submitted = [commands];
            let submits = [vk::SubmitInfo::default().command_buffers(&submitted)];
            self.device.queue_submit(self.queue, &submits, vk::Fence::null())?;
            self.device.queue_wait_idle(self.queue)?;
            let mut values_of_images = Vec::new();
            for ((_, _, format), (buffer, allocation)) in images.iter().zip(buffers) {
                let bytes = allocation.mapped_slice().ok_or("not mapped")?;
                let half = |b: &[u8; 2]| half::f16::from_ne_bytes(*b).to_f32();
                values_of_images.push(match *format {
                    DEPTH => bytes.as_chunks().0[..texels].iter().map(|b| f32::from_ne_bytes(*b)).collect(),
                    _ => bytes.as_chunks().0[..4 * texels].iter().map(half).collect(),
                });
                self.device.destroy_buffer(buffer, None);
                self.allocator.as_mut().ok_or("destroyed")?.free(allocation)?;
            }
            Ok(values_of_images)
        }
    }

    /// Destroys everything. The device must be idle.
    pub fn destroy(mut self, pictures: impl Iterator<Item = Picture>, pass: Pass) {
        // SAFETY: the device is idle, and nothing is used any more.
        unsafe {
            for Picture { image, view, allocation } in pictures {
                self.device.destroy_image_view(view, None);
                self.device.destroy_image(image, None);
                let _ = self.allocator.as_mut().map(|allocator| allocator.free(allocation));
            }
            self.device.destroy_pipeline(pass.pipeline, None);
            self.device.destroy_pipeline_layout(pass.layout, None);
            self.device.destroy_framebuffer(pass.framebuffer, None);
            self.device.destroy_render_pass(pass.pass, None);
            self.device.destroy_command_pool(self.pool, None);
            drop(self.allocator.take());
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

/// Writes linear RGBA as a picture, with a gamma of 2.2, which is close to sRGB.
pub fn write_png(path: &str, rgba: &[f32]) -> Result<()> {
    let rgb = rgba.as_chunks::<4>().0.iter().flat_map(|t| [t[0], t[1], t[2]]);
    let bytes = rgb.map(|v| (v.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8).collect();
    Ok(image::RgbImage::from_raw(SIZE[0], SIZE[1], bytes).ok_or("a picture of another size")?.save(path)?)
}
