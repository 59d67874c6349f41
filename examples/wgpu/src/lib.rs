//! Hands wgpu's device and textures to `ssct`, and the images that `ssct` makes back to wgpu. Any renderer on wgpu's
//! Vulkan backend can use this file unchanged; the example in Bevy does.

use ash::vk;
use std::error::Error;
use wgpu::TextureFormat;
use wgpu::hal::api::Vulkan;

/// The format of colour images: four 16-bit floats. The images that `ssct` makes have it too.
pub const HALF: TextureFormat = TextureFormat::Rgba16Float;
/// The error message if wgpu runs on another backend.
pub const NO_VULKAN: &str = "wgpu runs on something else than Vulkan";

/// The result of functions that can fail.
pub type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Makes a Vulkan instance; returns it with its fastest adapter. The environment variable `WGPU_VALIDATION=1` turns the
/// validation layer on.
///
/// # Errors
/// Says that there is no Vulkan adapter.
pub async fn fastest() -> Result<(wgpu::Instance, wgpu::Adapter)> {
    let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
    description.backends = wgpu::Backends::VULKAN;
    // wgpu's usual flags for debugging also write WGSL into the shaders as their source language, which the validation
    // layer of Vulkan 1.3.239 reports as an error.
    description.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(description);
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    let adapter = instance.request_adapter(&options).await?;
    Ok((instance, adapter))
}

/// Opens a device with some of wgpu's own features and with those that `ssct` needs.
///
/// wgpu's `open_with_callback` can chain structures, but it sets the features of Vulkan 1.0 itself, and it chains
/// `maintenance4` as off. This function therefore makes the device itself, with the same calls as wgpu.
///
/// # Errors
/// Says what failed.
pub fn open(
    adapter: &wgpu::Adapter,
    features: wgpu::Features,
    limits: &wgpu::Limits,
) -> Result<wgpu::hal::OpenDevice<Vulkan>> {
    // SAFETY: the structures live through the call that reads them, each is in the chain once, and wgpu owns the new
    // device.
    unsafe {
        let adapter = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let extensions = adapter.required_device_extensions(features);
        let mut wgpu_features = adapter.physical_device_features(&extensions, features);
        let enabled = enabled_features(wgpu_features.get_core());
        // wgpu chains one structure for each feature, and Vulkan does not allow the structure of a whole version beside
        // them.
        let mut host_query_reset = vk::PhysicalDeviceHostQueryResetFeatures::default().host_query_reset(true);
        let mut dynamic_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut synchronization2 = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
        let info = wgpu_features
            .add_to_device_create(info)
            .enabled_features(&enabled.core)
            .push_next(&mut host_query_reset)
            .push_next(&mut dynamic_rendering)
            .push_next(&mut synchronization2);
        // wgpu's structure for `maintenance4` is found in the chain, and turned on.
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

/// Returns the features that [`open`] turns on: `wgpu_features`, the features of Vulkan 1.0 that wgpu turns on, and
/// those that `ssct` needs. Every feature in the list must be on, since `Context::new` checks by this list that it has
/// what it needs.
fn enabled_features(wgpu_features: vk::PhysicalDeviceFeatures) -> ssct::EnabledFeatures {
    let mut wanted = ssct::EnabledFeatures { core: wgpu_features, ..Default::default() };
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

/// Returns the handles from which `ssct` makes its context on a device. [`open`] must have made the device with the
/// same `features`.
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

/// Returns layout, stages and access of a texture in wgpu's state `RESOURCE`, in which wgpu samples textures.
pub fn resource(format: TextureFormat) -> ssct::ImageUse {
    use vk::{ImageLayout as L, PipelineStageFlags2 as S};
    let is_depth = format.is_depth_stencil_format();
    ssct::ImageUse {
        layout: if is_depth { L::DEPTH_STENCIL_READ_ONLY_OPTIMAL } else { L::SHADER_READ_ONLY_OPTIMAL },
        stages: S::VERTEX_SHADER | S::FRAGMENT_SHADER | S::COMPUTE_SHADER,
        access: vk::AccessFlags2::SHADER_READ,
    }
}

/// Describes a texture of wgpu, of one layer or a cube, as an input of `ssct`. The texture must be in the state
/// `RESOURCE` before the reflections, and is in this state after them.
///
/// # Errors
/// Says that wgpu does not run on Vulkan.
pub fn input(adapter: &wgpu::Adapter, texture: &wgpu::Texture, view: &wgpu::TextureView) -> Result<ssct::ImageInput> {
    let (format, extent) = (texture.format(), [texture.width(), texture.height()]);
    // Each guard of `as_hal` is taken in its own statement, since wgpu panics if two are held at once.
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

/// Wraps an image that `ssct` made, and that is in the state `RESOURCE`, as a texture of wgpu. wgpu does not destroy
/// the image.
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
    // wgpu calls this function in place of destroying the image.
    let (on_drop, memory) = (Box::new(|| ()), wgpu::hal::vulkan::TextureMemory::External);
    // SAFETY: the image belongs to the device, matches the description, and is in the state `RESOURCE` when wgpu first
    // uses it.
    unsafe {
        let hal = device.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let texture = hal.texture_from_raw(image.image, &raw, Some(on_drop), memory);
        drop(hal);
        Ok(device.create_texture_from_hal::<Vulkan>(texture, &description, wgpu::TextureUses::RESOURCE))
    }
}

/// Describes a texture with one mip level. The third number of the size is the number of layers.
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

/// Records the copy of a texture to a buffer that can be mapped. Returns the buffer, and the bytes from one row to the
/// next.
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

/// Bytes of a texel; the format must not be compressed, and must not have both depth and stencil.
pub fn bytes_of(format: TextureFormat) -> u32 {
    format.block_copy_size(None).unwrap_or_default()
}

/// Converts texels to 32-bit floats. Their channels are 16-bit floats, or one 32-bit float if `format` says so.
pub fn floats(bytes: &[u8], format: TextureFormat) -> Vec<u8> {
    if [TextureFormat::R32Float, TextureFormat::Depth32Float].contains(&format) {
        return bytes.to_vec();
    }
    let halves = bytes.as_chunks::<2>().0.iter();
    halves.flat_map(|half| half::f16::from_ne_bytes(*half).to_f32().to_le_bytes()).collect()
}
