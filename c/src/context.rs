//! The caller's device.

use crate::border::{
    Failure, Outcome, SsctResult, copy_struct, create, destroy, guard, sized_structs, stated_size, to_c_text,
    to_reference, to_reference_mut, value_or,
};
use crate::live;
use crate::memory::{CallersMemory, SsctMemory};
use crate::vulkan::{
    PFN_vkGetInstanceProcAddr, VkBool32, VkDevice, VkInstance, VkPhysicalDevice, VkPhysicalDeviceFeatures,
    VkPhysicalDeviceVulkan12Features, VkPhysicalDeviceVulkan13Features,
};
use ash::vk::{self, Handle};
use ssct::{Context, DeviceHandles, EnabledFeatures};
use std::ffi::{CString, c_char};
use std::sync::OnceLock;

/// A device of yours that reflections are recorded for. Destroying the context destroys none of your handles.
pub struct SsctContext {
    pub(crate) context: Context,
    /// Name, driver, version of Vulkan, and kind of the device, for `ssct_context_device_info`.
    device: [CString; 4],
}

/// A device that you made, with all features on that `ssct_enable_features` turns on.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctContextInfo {
    /// sizeof(SsctContextInfo).
    pub struct_size: usize,
    /// The loader's function, if you loaded it yourself; NULL for the system's loader.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// The instance, made for Vulkan 1.3 (VkApplicationInfo::apiVersion).
    pub instance: VkInstance,
    /// The physical device.
    pub physical_device: VkPhysicalDevice,
    /// The device.
    pub device: VkDevice,
    /// The family of the queues that you submit to; it does both graphics and compute.
    pub queue_family: u32,
    /// Whether the instance has VK_EXT_debug_utils on: passes and objects then have names.
    pub debug_utils: VkBool32,
    /// The features of Vulkan 1.0 that are on.
    pub features: *const VkPhysicalDeviceFeatures,
    /// The features of Vulkan 1.2 that are on; structs that are chained to it are ignored.
    pub features12: *const VkPhysicalDeviceVulkan12Features,
    /// The features of Vulkan 1.3 that are on; structs that are chained to it are ignored.
    pub features13: *const VkPhysicalDeviceVulkan13Features,
    /// Your allocator; NULL for the library's own.
    pub memory: *const SsctMemory,
}

/// Name, driver, version and kind of a device. The texts stay until the context is destroyed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctDeviceInfo {
    /// sizeof(SsctDeviceInfo).
    pub struct_size: usize,
    /// The device's name.
    pub name: *const c_char,
    /// Name and version of the driver.
    pub driver: *const c_char,
    /// The highest version of Vulkan that the device has, such as "1.3.230".
    pub api: *const c_char,
    /// "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other".
    pub kind: *const c_char,
}

/// A method, and a line that describes it.
#[repr(C)]
pub struct SsctMethod {
    /// The method's name, as in `SsctReflectionsInfo.method`.
    pub name: *const c_char,
    /// What the method does.
    pub summary: *const c_char,
}

sized_structs!(SsctContextInfo, SsctDeviceInfo);

/// Returns the version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn ssct_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Turns on the features that this library needs in the three structs, and leaves other features as they are. All of
/// them are features of core Vulkan 1.3, so that no extension is needed. Some devices lack `largePoints`: turn this
/// feature off there, and only the method "unified" cannot be made. Set `sType` of the last two structs before the
/// call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_enable_features(
    features: *mut VkPhysicalDeviceFeatures,
    features12: *mut VkPhysicalDeviceVulkan12Features,
    features13: *mut VkPhysicalDeviceVulkan13Features,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for pointers to such structs.
        let (features, features12, features13) = unsafe {
            (
                to_reference_mut("features", features)?,
                to_reference_mut("features12", features12)?,
                to_reference_mut("features13", features13)?,
            )
        };
        check_s_type("features12", features12.s_type, VkPhysicalDeviceVulkan12Features::default().s_type)?;
        check_s_type("features13", features13.s_type, VkPhysicalDeviceVulkan13Features::default().s_type)?;
        ssct::enable_features(features, features12, features13);
        Ok(())
    })
}

/// Refuses a struct whose `sType` is not `needed`, the one that Vulkan gives the struct's type.
fn check_s_type(argument: &str, given: vk::StructureType, needed: vk::StructureType) -> Outcome<()> {
    if given == needed {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "sType of the argument {argument} is {}; it must be VK_STRUCTURE_TYPE_{needed:?}",
        given.as_raw()
    )))
}

/// Makes a context of your device, and writes the new context to `context`, or NULL if the call fails.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_create(
    info: *const SsctContextInfo,
    context: *mut *mut SsctContext,
) -> SsctResult {
    let make = || {
        // SAFETY: the header asks for pointers to such structs, and for handles that belong together.
        let context = unsafe {
            let info = copy_struct("info", info)?;
            Context::new(to_device_handles(&info)?)?
        };
        let device_info = context.info();
        let texts = [&device_info.name, &device_info.driver, &device_info.api, &device_info.kind];
        let device = texts.map(|words| to_c_text(words));
        Ok(SsctContext { context, device })
    };
    // SAFETY: the header asks for a valid place.
    unsafe { create("context", context, make) }
}

/// Destroys a context; NULL is allowed. Objects that were made with the context stay usable, and keep what they need.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_destroy(context: *mut SsctContext) {
    // SAFETY: the header asks for an object that is not yet destroyed.
    unsafe { destroy(context) };
}

/// Writes name, driver, version and kind of the device to `info`, whose `struct_size` is set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_device_info(
    context: *const SsctContext,
    info: *mut SsctDeviceInfo,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such pointers.
        let (context, struct_size) = unsafe { (live::read("context", context)?, stated_size("info", info)?) };
        let [name, driver, api, kind] = context.device.each_ref().map(|words| words.as_ptr());
        // SAFETY: the header asks for a struct of the stated size, which is at least the size of `SsctDeviceInfo`.
        unsafe { info.write(SsctDeviceInfo { struct_size, name, driver, api, kind }) };
        Ok(())
    })
}

/// Returns true if passes can be timed, which needs a queue family with timestamps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_has_timestamps(context: *const SsctContext) -> bool {
    // SAFETY: the header asks for such a pointer.
    value_or(false, || Ok(unsafe { live::read("context", context) }?.context.has_timestamps()))
}

/// Returns how many bytes of device memory the library has allocated with the context; 0 if the context has an
/// allocator of yours.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_allocated_bytes(context: *const SsctContext) -> u64 {
    // SAFETY: the header asks for such a pointer.
    value_or(0, || Ok(unsafe { live::read("context", context) }?.context.allocated_bytes()))
}

/// Destroys the pipelines that no object uses now. Without this call such pipelines are kept, so that an object that is
/// made or resized later compiles nothing twice.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_context_trim(context: *const SsctContext) {
    // SAFETY: the header asks for such a pointer.
    value_or((), || unsafe { live::read("context", context) }.map(|context| context.context.trim()));
}

/// Returns an array of the methods that need no scene, and writes its length to `count`. All these methods need a
/// G-buffer; "captures" also needs capture cubes, and "traced" also needs triangles. The array stays for as long as the
/// library is loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_methods(count: *mut u32) -> *const SsctMethod {
    static METHODS: OnceLock<Methods> = OnceLock::new();
    value_or(std::ptr::null(), || {
        let methods = METHODS.get_or_init(Methods::new);
        // SAFETY: the header asks for a valid place.
        *unsafe { to_reference_mut("count", count) }? = methods.rows.len() as u32;
        Ok(methods.rows.as_ptr())
    })
}

/// The array that [`ssct_methods`] returns, with the texts that the array's pointers lead to.
struct Methods {
    /// The texts that the rows point to.
    _texts: Vec<CString>,
    rows: Vec<SsctMethod>,
}

// SAFETY: the pointers are to texts of the struct itself, which nothing changes.
unsafe impl Send for Methods {}
// SAFETY: the pointers are to texts of the struct itself, which nothing changes.
unsafe impl Sync for Methods {}

impl Methods {
    /// Makes the rows of all methods that need no scene.
    fn new() -> Self {
        let texts: Vec<_> = ssct::methods().flat_map(|(name, summary)| [to_c_text(name), to_c_text(summary)]).collect();
        let to_row = |[name, summary]: &[CString; 2]| SsctMethod { name: name.as_ptr(), summary: summary.as_ptr() };
        let rows = texts.as_chunks::<2>().0.iter().map(to_row).collect();
        Self { _texts: texts, rows }
    }
}

/// Converts the caller's handles and features to the Rust interface's type, and loads the functions of Vulkan.
///
/// # Safety
/// The handles are NULL or belong together, and pointers are NULL or to such structs.
unsafe fn to_device_handles(info: &SsctContextInfo) -> Result<DeviceHandles, Failure> {
    for (name, is_null) in [
        ("instance", info.instance.is_null()),
        ("physical_device", info.physical_device.is_null()),
        ("device", info.device.is_null()),
    ] {
        if is_null {
            return Err(Failure::usage(format!("the field {name} of SsctContextInfo is a null handle")));
        }
    }
    // SAFETY: the caller keeps to the contract above. Structs that are chained to the features are not read.
    unsafe {
        let enabled = EnabledFeatures {
            core: *to_reference("features", info.features)?,
            vulkan12: vk::PhysicalDeviceVulkan12Features {
                p_next: std::ptr::null_mut(),
                ..*to_reference("features12", info.features12)?
            },
            vulkan13: vk::PhysicalDeviceVulkan13Features {
                p_next: std::ptr::null_mut(),
                ..*to_reference("features13", info.features13)?
            },
        };
        let memory = match info.memory.is_null() {
            true => None,
            false => {
                Some(Box::new(CallersMemory::new(&copy_struct("memory", info.memory)?)?) as Box<dyn ssct::DeviceMemory>)
            }
        };
        let entry = match info.get_instance_proc_addr {
            Some(get_instance_proc_addr) => ash::Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr }),
            None => ash::Entry::load().map_err(|e| Failure {
                code: SsctResult::NoDevice,
                sentence: format!("the system's Vulkan loader cannot be opened: {e}"),
            })?,
        };
        let instance = ash::Instance::load(entry.static_fn(), info.instance);
        let device = ash::Device::load(instance.fp_v1_0(), info.device);
        Ok(DeviceHandles {
            entry,
            instance,
            physical: info.physical_device,
            device,
            queue_family: info.queue_family,
            enabled,
            debug_utils: info.debug_utils != vk::FALSE,
            memory,
        })
    }
}

const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<SsctContext>();
};
