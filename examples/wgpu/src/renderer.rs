//! The renderer itself, on wgpu.

use ash::vk;
use std::error::Error;
use wgpu::TextureFormat;
use wgpu::hal::api::Vulkan;

pub const HALF: TextureFormat = TextureFormat::Rgba16Float;
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;
pub const NO_VULKAN: &str = "wgpu runs on something else than Vulkan";

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

pub struct Renderer {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: wgpu::Adapter,
    enabled: ssct::EnabledFeatures,
    scene: wgpu::RenderPipeline,
    camera: wgpu::BindGroup,
    show: wgpu::RenderPipeline,
}

/// A texture with its view.
pub struct Picture {
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Picture {
    fn of(texture: wgpu::Texture) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }
}

// ---- reflections ----

/// Opens a device with wgpu's own features and those that `ssct` needs, and says which are on.
///
/// wgpu's `open_with_callback` would do for what is chained, but neither for the features of Vulkan 1.0, which it sets itself
/// and hides, nor for `maintenance4`, which it chains as off. So the device is made here, just as wgpu makes it.
fn open(adapter: &wgpu::Adapter) -> Result<(wgpu::hal::OpenDevice<Vulkan>, ssct::EnabledFeatures)> {
    let (features, limits) = (wgpu::Features::empty(), wgpu::Limits::default());
    // SAFETY: the structures live through the call that reads them, each in the chain once, and wgpu owns what is made.
    unsafe {
        let adapter = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let extensions = adapter.required_device_extensions(features);
        let mut of_wgpu = adapter.physical_device_features(&extensions, features);
        let mut wanted = ssct::EnabledFeatures { core: of_wgpu.get_core(), ..Default::default() };
        ssct::enable_features(&mut wanted.core, &mut wanted.vulkan12, &mut wanted.vulkan13);
        // wgpu chains features one by one, which excludes the structures of whole versions.
        let mut host_query_reset = vk::PhysicalDeviceHostQueryResetFeatures::default().host_query_reset(true);
        let mut dynamic_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut synchronization2 = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
        // What these turn on, and no more: `Context::new` compares it with what it needs.
        let enabled = ssct::EnabledFeatures {
            core: wanted.core,
            vulkan12: vk::PhysicalDeviceVulkan12Features::default().host_query_reset(true),
            vulkan13: vk::PhysicalDeviceVulkan13Features::default()
                .dynamic_rendering(true)
                .synchronization2(true)
                .maintenance4(true),
        };
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
        let info = of_wgpu
            .add_to_device_create(info)
            .enabled_features(&enabled.core)
            .push_next(&mut host_query_reset)
            .push_next(&mut dynamic_rendering)
            .push_next(&mut synchronization2);
        let mut next = info.p_next.cast_mut().cast::<vk::BaseOutStructure>();
        while !next.is_null() {
            if (*next).s_type == vk::StructureType::PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES {
                (*next.cast::<vk::PhysicalDeviceMaintenance4Features>()).maintenance4 = vk::TRUE;
            }
            next = (*next).p_next;
        }
        let instance = adapter.shared_instance().raw_instance();
        let device = instance.create_device(adapter.raw_physical_device(), &info, None)?;
        let hints = wgpu::MemoryHints::default();
        let open = adapter.device_from_raw(device, None, &extensions, features, &limits, &hints, 0, 0)?;
        Ok((open, enabled))
    }
}

/// How a texture of a format is in wgpu's state `RESOURCE`, in which wgpu samples it.
pub fn resource(format: TextureFormat) -> ssct::ImageUse {
    use vk::{ImageLayout as L, PipelineStageFlags2 as S};
    let is_depth = format.is_depth_stencil_format();
    ssct::ImageUse {
        layout: if is_depth { L::DEPTH_STENCIL_READ_ONLY_OPTIMAL } else { L::SHADER_READ_ONLY_OPTIMAL },
        stages: S::VERTEX_SHADER | S::FRAGMENT_SHADER | S::COMPUTE_SHADER,
        access: vk::AccessFlags2::SHADER_READ,
    }
}

impl Renderer {
    /// What a library is told of the device.
    pub fn handles(&self) -> Result<ssct::DeviceHandles> {
        // SAFETY: nothing is destroyed.
        let device = unsafe { self.device.as_hal::<Vulkan>() }.ok_or(NO_VULKAN)?;
        let instance = device.shared_instance();
        Ok(ssct::DeviceHandles {
            entry: instance.entry().clone(),
            instance: instance.raw_instance().clone(),
            physical: device.raw_physical_device(),
            device: device.raw_device().clone(),
            queue_family: device.queue_family_index(),
            enabled: self.enabled.clone(),
            debug_utils: instance.extensions().contains(&ash::ext::debug_utils::NAME),
            memory: None,
        })
    }

    /// A texture of wgpu's that is in the state `RESOURCE`, and is to stay so.
    pub fn input(&self, picture: &Picture) -> Result<ssct::ImageInput> {
        let Picture { texture, view } = picture;
        let (format, extent) = (texture.format(), [texture.width(), texture.height()]);
        // wgpu panics where a statement holds two of its guards.
        // SAFETY: nothing is destroyed.
        let image = unsafe { texture.as_hal::<Vulkan>().ok_or(NO_VULKAN)?.raw_handle() };
        // SAFETY: as above.
        let view = unsafe { view.as_hal::<Vulkan>().ok_or(NO_VULKAN)?.raw_handle() };
        // SAFETY: as above.
        let adapter = unsafe { self.adapter.as_hal::<Vulkan>() }.ok_or(NO_VULKAN)?;
        let raw_format = adapter.texture_format_as_raw(format);
        let is_depth = format.is_depth_stencil_format();
        let of = if is_depth { ssct::ImageInput::depth } else { ssct::ImageInput::color };
        Ok(of(image, view, raw_format, extent).used(resource(format), resource(format)))
    }

    /// An image of the library's that is in the state `RESOURCE`, as a texture of wgpu's. wgpu does not destroy it.
    pub fn adopt(&self, image: &ssct::OutputImage) -> Result<Picture> {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let description = description("composite", image.extent, HALF, usage);
        let raw = wgpu::hal::TextureDescriptor {
            label: description.label,
            size: description.size,
            mip_level_count: description.mip_level_count,
            sample_count: description.sample_count,
            dimension: description.dimension,
            format: description.format,
            usage: wgpu::TextureUses::RESOURCE | wgpu::TextureUses::COPY_SRC,
            memory_flags: wgpu::hal::MemoryFlags::empty(),
            view_formats: Vec::new(),
        };
        let (stays, memory) = (Box::new(|| ()), wgpu::hal::vulkan::TextureMemory::External);
        // SAFETY: the image is the device's, as described, and in that state when wgpu uses it first.
        let texture = unsafe {
            let device = self.device.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
            let texture = device.texture_from_raw(image.image, &raw, Some(stays), memory);
            drop(device);
            self.device.create_texture_from_hal::<Vulkan>(texture, &description, wgpu::TextureUses::RESOURCE)
        };
        Ok(Picture::of(texture))
    }
}

// ---------------------

impl Renderer {
    pub fn new(view_to_clip: &[f32; 16], world_to_view: &[f32; 16]) -> Result<Self> {
        let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
        description.backends = wgpu::Backends::VULKAN;
        // `WGPU_VALIDATION=1` turns the validation layer on. wgpu's usual flags for debugging also name WGSL in the shaders as
        // their source, which the layer of Vulkan 1.3.239 takes for an error.
        description.flags = wgpu::InstanceFlags::empty().with_env();
        let instance = wgpu::Instance::new(description);
        let power_preference = wgpu::PowerPreference::HighPerformance;
        let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        let (open, enabled) = open(&adapter)?;
        // SAFETY: the device is of this adapter, and has the default's features and limits.
        let (device, queue) = unsafe { adapter.create_device_from_hal(open, &wgpu::DeviceDescriptor::default()) }?;
        let module = device.create_shader_module(wgpu::include_wgsl!("scene.wgsl"));
        let scene = pipeline(&device, &module, "scene", &[HALF; 3], Some(DEPTH));
        let show = pipeline(&device, &module, "show", &[TextureFormat::Rgba8UnormSrgb], None);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("camera"),
            size: 128,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let numbers: Vec<u8> = view_to_clip.iter().chain(world_to_view).flat_map(|v| v.to_ne_bytes()).collect();
        queue.write_buffer(&buffer, 0, &numbers);
        let entries = [wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }];
        let layout = &scene.get_bind_group_layout(0);
        let camera = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        Ok(Self { device, queue, adapter, enabled, scene, camera, show })
    }

    pub fn picture(&self, name: &str, extent: [u32; 2], format: TextureFormat) -> Picture {
        use wgpu::TextureUsages as U;
        let usage = U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC;
        Picture::of(self.device.create_texture(&description(name, extent, format, usage)))
    }

    /// Draws the scene, and leaves all images in the state `RESOURCE`.
    pub fn draw(&self, colors: [&Picture; 3], depth: &Picture) -> wgpu::CommandBuffer {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        render(&mut encoder, &self.scene, &self.camera, &colors, Some(depth));
        let all = colors.into_iter().chain([depth]).map(|picture| wgpu::TextureTransition {
            texture: &picture.texture,
            selector: None,
            state: wgpu::TextureUses::RESOURCE,
        });
        encoder.transition_resources(std::iter::empty(), all);
        encoder.finish()
    }

    /// Shows a linear image. It is sampled, and so stays in the state `RESOURCE`.
    pub fn show(&self, linear: &Picture, screen: &Picture) -> wgpu::CommandBuffer {
        let entries = [wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&linear.view) }];
        let layout = &self.show.get_bind_group_layout(0);
        let image =
            self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        render(&mut encoder, &self.show, &image, &[screen], None);
        encoder.finish()
    }

    /// Waits for a submission, or for all.
    pub fn wait(&self, submission: Option<&wgpu::SubmissionIndex>) -> Result<()> {
        self.device.poll(wgpu::PollType::Wait { submission_index: submission.cloned(), timeout: None })?;
        Ok(())
    }

    /// The bytes of images whose rows are multiples of 256 bytes.
    pub fn read<'a>(&self, pictures: impl Iterator<Item = &'a Picture>) -> Result<Vec<Vec<u8>>> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut buffers = Vec::new();
        for Picture { texture, .. } in pictures {
            let row = texture.width() * texture.format().block_copy_size(None).ok_or("a format that cannot be read")?;
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: u64::from(row) * u64::from(texture.height()),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
            buffers.push(buffer);
        }
        self.queue.submit([encoder.finish()]);
        // A failure shows where the range is asked for.
        buffers.iter().for_each(|buffer| buffer.map_async(wgpu::MapMode::Read, .., |_| ()));
        self.wait(None)?;
        buffers.iter().map(|buffer| Ok(buffer.get_mapped_range(..)?.to_vec())).collect()
    }
}

fn description(
    name: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    fragment: &str,
    colors: &[TextureFormat],
    depth: Option<TextureFormat>,
) -> wgpu::RenderPipeline {
    let targets: Vec<_> = colors.iter().map(|format| Some((*format).into())).collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("whole_image"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: depth.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A pass of one triangle into cleared images.
fn render(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bindings: &wgpu::BindGroup,
    colors: &[&Picture],
    depth: Option<&Picture>,
) {
    let (ops, depth_slice, resolve_target) = (wgpu::Operations::default(), None, None);
    let color = |view| wgpu::RenderPassColorAttachment { view, depth_slice, resolve_target, ops };
    let attachments: Vec<_> = colors.iter().map(|picture| Some(color(&picture.view))).collect();
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &attachments,
        depth_stencil_attachment: depth.map(|depth| wgpu::RenderPassDepthStencilAttachment {
            view: &depth.view,
            depth_ops: Some(wgpu::Operations::default()),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bindings, &[]);
    pass.draw(0..3, 0..1);
}

/// Texels of an image as 32-bit floats.
pub fn floats(bytes: &[u8], format: TextureFormat) -> Vec<u8> {
    if format == DEPTH {
        return bytes.to_vec();
    }
    bytes.chunks_exact(2).flat_map(|b| half::f16::from_ne_bytes([b[0], b[1]]).to_f32().to_le_bytes()).collect()
}
