//! Hands what wgpu draws with to `ssct`: the device, textures, and the images that come back. Any renderer on wgpu's Vulkan
//! backend may do with it as it is; the example in Bevy does.

use ash::vk;
use std::error::Error;
use wgpu::TextureFormat;
use wgpu::hal::api::Vulkan;

pub const HALF: TextureFormat = TextureFormat::Rgba16Float;
pub const NO_VULKAN: &str = "wgpu runs on something else than Vulkan";

pub type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// The instance, and its fastest device on Vulkan. `WGPU_VALIDATION=1` turns the validation layer on.
///
/// # Errors
/// Says that there is none.
pub async fn fastest() -> Result<(wgpu::Instance, wgpu::Adapter)> {
    let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
    description.backends = wgpu::Backends::VULKAN;
    // wgpu's usual flags for debugging also name WGSL in the shaders as their source, which the layer of Vulkan 1.3.239 takes
    // for an error.
    description.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(description);
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    let adapter = instance.request_adapter(&options).await?;
    Ok((instance, adapter))
}

/// Opens a device with some of wgpu's own features and with those that `ssct` needs.
///
/// wgpu's `open_with_callback` would do for what is chained, but neither for the features of Vulkan 1.0, which it sets itself
/// and hides, nor for `maintenance4`, which it chains as off. So the device is made here, just as wgpu makes it.
///
/// # Errors
/// Says what failed.
pub fn open(
    adapter: &wgpu::Adapter,
    features: wgpu::Features,
    limits: &wgpu::Limits,
) -> Result<wgpu::hal::OpenDevice<Vulkan>> {
    // SAFETY: the structures live through the call that reads them, each in the chain once, and wgpu owns what is made.
    unsafe {
        let adapter = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let extensions = adapter.required_device_extensions(features);
        let mut of_wgpu = adapter.physical_device_features(&extensions, features);
        let enabled = enabled_features(of_wgpu.get_core());
        // wgpu chains features one by one, which excludes the structures of whole versions.
        let mut host_query_reset = vk::PhysicalDeviceHostQueryResetFeatures::default().host_query_reset(true);
        let mut dynamic_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut synchronization2 = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
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
        Ok(adapter.device_from_raw(device, None, &extensions, features, limits, &hints, 0, 0)?)
    }
}

/// The features that [`open`] turns on, given wgpu's of Vulkan 1.0, and no more: `Context::new` compares them with what it needs.
fn enabled_features(of_wgpu: vk::PhysicalDeviceFeatures) -> ssct::EnabledFeatures {
    let mut wanted = ssct::EnabledFeatures { core: of_wgpu, ..Default::default() };
    ssct::enable_features(&mut wanted.core, &mut wanted.vulkan12, &mut wanted.vulkan13);
    ssct::EnabledFeatures {
        core: wanted.core,
        vulkan12: vk::PhysicalDeviceVulkan12Features::default().host_query_reset(true),
        vulkan13: vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true),
    }
}

/// What `ssct` is told of a device that [`open`] made with the same features of wgpu's.
///
/// # Errors
/// Says that wgpu does not run on Vulkan.
pub fn handles(
    adapter: &wgpu::Adapter,
    device: &wgpu::Device,
    features: wgpu::Features,
) -> Result<ssct::DeviceHandles> {
    // SAFETY: nothing is destroyed.
    let core = unsafe {
        let adapter = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        adapter.physical_device_features(&adapter.required_device_extensions(features), features).get_core()
    };
    // SAFETY: as above.
    let device = unsafe { device.as_hal::<Vulkan>() }.ok_or(NO_VULKAN)?;
    let instance = device.shared_instance();
    Ok(ssct::DeviceHandles {
        entry: instance.entry().clone(),
        instance: instance.raw_instance().clone(),
        physical: device.raw_physical_device(),
        device: device.raw_device().clone(),
        queue_family: device.queue_family_index(),
        enabled: enabled_features(core),
        debug_utils: instance.extensions().contains(&ash::ext::debug_utils::NAME),
        memory: None,
    })
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

/// A texture of wgpu's, of one layer or a cube, that is in the state `RESOURCE`, and is to stay so.
///
/// # Errors
/// Says that wgpu does not run on Vulkan.
pub fn input(adapter: &wgpu::Adapter, texture: &wgpu::Texture, view: &wgpu::TextureView) -> Result<ssct::ImageInput> {
    let (format, extent) = (texture.format(), [texture.width(), texture.height()]);
    // wgpu panics where a statement holds two of its guards.
    // SAFETY: nothing is destroyed.
    let image = unsafe { texture.as_hal::<Vulkan>().ok_or(NO_VULKAN)?.raw_handle() };
    // SAFETY: as above.
    let view = unsafe { view.as_hal::<Vulkan>().ok_or(NO_VULKAN)?.raw_handle() };
    // SAFETY: as above.
    let raw_format = unsafe { adapter.as_hal::<Vulkan>() }.ok_or(NO_VULKAN)?.texture_format_as_raw(format);
    let constructor = match (format.is_depth_stencil_format(), texture.depth_or_array_layers()) {
        (true, _) => ssct::ImageInput::depth,
        (false, 6) => ssct::ImageInput::cube,
        (false, _) => ssct::ImageInput::color,
    };
    Ok(constructor(image, view, raw_format, extent).used(resource(format), resource(format)))
}

/// An image of the library's that is in the state `RESOURCE`, as a texture of wgpu's. wgpu does not destroy it.
///
/// # Errors
/// Says that wgpu does not run on Vulkan.
pub fn adopt(device: &wgpu::Device, name: &str, image: &ssct::OutputImage) -> Result<wgpu::Texture> {
    let [width, height] = image.extent;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
    let description = description(name, [width, height, 1], HALF, usage);
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
    unsafe {
        let hal = device.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let texture = hal.texture_from_raw(image.image, &raw, Some(stays), memory);
        drop(hal);
        Ok(device.create_texture_from_hal::<Vulkan>(texture, &description, wgpu::TextureUses::RESOURCE))
    }
}

/// A texture with one level, and with layers or one.
pub fn description(
    name: &str,
    [width, height, depth_or_array_layers]: [u32; 3],
    format: TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

/// Records copying a texture into a buffer that can be mapped, and says how many bytes a row there has.
pub fn copy_out(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    texture: &wgpu::Texture,
) -> (wgpu::Buffer, u32) {
    let row = (texture.width() * bytes_of(texture.format())).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    (buffer, row)
}

/// Bytes of a texel of a format that is not compressed and has one aspect.
pub fn bytes_of(format: TextureFormat) -> u32 {
    format.block_copy_size(None).unwrap_or_default()
}

/// Texels of halves or of one float each as 32-bit floats.
pub fn floats(bytes: &[u8], format: TextureFormat) -> Vec<u8> {
    if [TextureFormat::R32Float, TextureFormat::Depth32Float].contains(&format) {
        return bytes.to_vec();
    }
    let halves = bytes.as_chunks::<2>().0.iter();
    halves.flat_map(|half| half::f16::from_ne_bytes(*half).to_f32().to_le_bytes()).collect()
}
