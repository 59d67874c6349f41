//! The messages of the validation layers: collected, counted, and compared with an allow-list.

use crate::error::{Error, Result};
use ash::vk;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_void};
use std::ops::Range;
use std::sync::Mutex;

/// The name of the layer that gives the messages.
pub const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A message that does not fail a run.
#[derive(Debug)]
pub struct AllowedMessage {
    /// ID of the message.
    pub id: &'static str,
    /// The versions of the layer that give this message, as Vulkan encodes versions; the end is not included.
    pub versions: Range<u32>,
    /// Beginning of the names of the drivers with which the message comes; "" for every driver.
    pub driver: &'static str,
    /// Reason why the message does not fail a run.
    pub reason: &'static str,
}

/// The first layers for Vulkan 1.4.
const LAYER_1_4: u32 = vk::make_api_version(0, 1, 4, 0);

/// The layers that give two messages of best practices. The layers of Debian 13, 1.4.309, give them. The layers of the
/// browser Chromium, which scripts/drivers.sh fetches and gives the version 1.4.0, do not.
const LAYERS_1_4_309: Range<u32> = vk::make_api_version(0, 1, 4, 1)..vk::make_api_version(0, 1, 4, 310);

/// The reason why messages about the stage ALL_COMMANDS are allowed.
const FULL_BARRIERS: &str = "timing mode stamps at ALL_COMMANDS and separates passes by full barriers on purpose, so that neighbours cannot overlap";

/// Beginning of the name of the driver that needs frame/quirks/settle.rs.
pub(super) const MESA_22: &str = "llvmpipe Mesa 22.";

/// The reason why messages about dispatches without workgroups are allowed.
const SETTLING: &str = "on lavapipe of Mesa 22, dispatches of no workgroups keep it from compiling programs again \
                        (frame/quirks/settle.rs)";

/// The reason why messages about the extension VK_EXT_debug_utils are allowed.
const MESSENGER: &str = "VK_EXT_debug_utils carries these very messages";

/// The messages that do not fail a run.
pub const ALLOWED: &[AllowedMessage] = &[
    AllowedMessage {
        id: "UNASSIGNED-BestPractices-pipeline-stage-flags",
        versions: 0..LAYER_1_4,
        driver: "",
        reason: FULL_BARRIERS,
    },
    AllowedMessage {
        id: "BestPractices-pipeline-stage-flags2-compute",
        versions: LAYERS_1_4_309,
        driver: "",
        reason: FULL_BARRIERS,
    },
    AllowedMessage {
        id: "UNASSIGNED-BestPractices-vkCreateInstance-specialuse-extension-debugging",
        versions: 0..LAYER_1_4,
        driver: "",
        reason: MESSENGER,
    },
    AllowedMessage {
        id: "BestPractices-specialuse-extension",
        versions: LAYERS_1_4_309,
        driver: "",
        reason: MESSENGER,
    },
    AllowedMessage {
        id: "UNASSIGNED-BestPractices-vkCmdDispatch-group-count-zero",
        versions: 0..LAYER_1_4,
        driver: MESA_22,
        reason: SETTLING,
    },
    AllowedMessage {
        id: "BestPractices-vkCmdDispatch-group-count-zero",
        versions: LAYER_1_4..u32::MAX,
        driver: MESA_22,
        reason: SETTLING,
    },
    AllowedMessage {
        id: "Undefined-Value-ShaderOutputNotConsumed-DynamicRendering",
        versions: LAYER_1_4..u32::MAX,
        driver: "",
        reason: "where nobody wants the hits of a pass, it has no attachment for them; Vulkan discards what a shader \
                 writes to an output without an attachment",
    },
];

/// Messages that a run with a window may give by chance, and that do not fail it.
pub const ALLOWED_OF_WINDOWS: &[AllowedMessage] = &[AllowedMessage {
    id: "BestPractices-vkCreateSharedSwapchainsKHR-SuboptimalSwapchain",
    versions: LAYER_1_4..u32::MAX,
    driver: "",
    reason: "a window may change its size while its frame is on the way; the next frame has images of the new size",
}];

/// The messages of one device.
#[derive(Debug, Default)]
pub struct ValidationLog {
    messages: Mutex<Vec<Message>>,
}

/// One message.
#[derive(Debug, Clone)]
pub struct Message {
    /// ID of the message, as in the allow-list.
    pub id: String,
    /// Text of the message.
    pub text: String,
    /// Whether the allow-list names the message.
    pub allowed: bool,
}

impl ValidationLog {
    /// Every message so far.
    pub fn messages(&self) -> Vec<Message> {
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }

    /// The messages outside the allow-list.
    pub fn violations(&self) -> Vec<Message> {
        let messages = self.messages.lock().unwrap_or_else(|e| e.into_inner());
        messages.iter().filter(|m| !m.allowed).cloned().collect()
    }

    /// Adds a message, which is allowed if either list has its ID, whatever the layer's version and the driver.
    fn push(&self, id: String, text: String) {
        let allowed = ALLOWED.iter().chain(ALLOWED_OF_WINDOWS).any(|known| known.id == id);
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).push(Message { id, text, allowed });
    }
}

/// Returns an error that names the identifier of every message, if there are any messages.
pub fn check(messages: &[Message]) -> Result<()> {
    let Some(first) = messages.first() else { return Ok(()) };
    let mut times = BTreeMap::<&str, usize>::new();
    for message in messages {
        *times.entry(&message.id).or_default() += 1;
    }
    let ids = times.into_iter().map(|(id, times)| (id.to_owned(), times)).collect();
    Err(Error::Validation { ids, first: first.text.clone() })
}

/// Returns the create info of a messenger that writes into a log. The log must outlive what is created with this info.
pub(super) fn messenger(log: &ValidationLog) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(S::WARNING | S::ERROR)
        .message_type(T::VALIDATION | T::PERFORMANCE)
        .pfn_user_callback(Some(callback))
        .user_data(std::ptr::from_ref(log).cast_mut().cast())
}

/// The debug-utils callback; its user data is a `ValidationLog` that outlives the messenger.
///
/// # Safety
/// Vulkan calls this function with valid pointers; `user_data` must point to a live [`ValidationLog`].
unsafe extern "system" fn callback(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: by the function's contract, both pointers are valid; strings that are not null are null-terminated.
    unsafe {
        let (Some(data), Some(log)) = (data.as_ref(), user_data.cast::<ValidationLog>().as_ref()) else {
            return vk::FALSE;
        };
        let text = |p: *const std::ffi::c_char| {
            if p.is_null() { String::new() } else { CStr::from_ptr(p).to_string_lossy().into_owned() }
        };
        let (id, message) = (text(data.p_message_id_name), text(data.p_message));
        if severity >= vk::DebugUtilsMessageSeverityFlagsEXT::WARNING {
            tracing::warn!(target: "vulkan", "{message}");
            log.push(id, message);
        } else {
            tracing::debug!(target: "vulkan", "{message}");
        }
    }
    vk::FALSE
}

#[cfg(test)]
mod tests {
    use super::{Message, check};
    use crate::gpu::device::{DeviceQuery, Gpu};
    use crate::gpu::memory::{Buffer, MemoryPlace};
    use ash::vk;

    /// Fills a buffer twice, with or without a barrier between, and returns the identifiers of the layers' messages.
    fn fill_twice(with_barrier: bool) -> (Gpu, Vec<String>) {
        let gpu = Gpu::open(&DeviceQuery { validation: true, ..DeviceQuery::default() }).expect("a device");
        let buffer = Buffer::new(&gpu, "filled twice", 256, vk::BufferUsageFlags::TRANSFER_DST, MemoryPlace::Device)
            .expect("a buffer");
        let device = gpu.raw();
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.shared().queue_family);
        // SAFETY: the command buffer is recorded, submitted once and waited for; then all is destroyed.
        unsafe {
            let pool = device.create_command_pool(&pool_info, None).expect("a pool");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).expect("a command buffer")[0];
            let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device.begin_command_buffer(commands, &once).expect("to begin");
            device.cmd_fill_buffer(commands, buffer.handle(), 0, 256, 1);
            if with_barrier {
                let barriers = [vk::MemoryBarrier2::default()
                    .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
                    .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                    .dst_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
                    .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE)];
                device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&barriers));
            }
            device.cmd_fill_buffer(commands, buffer.handle(), 0, 256, 2);
            device.end_command_buffer(commands).expect("to end");
            let infos = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
            let submit = vk::SubmitInfo2::default().command_buffer_infos(&infos);
            device.queue_submit2(*gpu.queue().expect("a queue"), &[submit], vk::Fence::null()).expect("to submit");
            device.device_wait_idle().expect("to wait");
            device.destroy_command_pool(pool, None);
        }
        drop(buffer);
        let ids = gpu.violations().into_iter().map(|m| m.id).collect();
        (gpu, ids)
    }

    #[test]
    fn the_layers_see_a_known_hazard_and_nothing_without_it() {
        let (gpu, messages) = fill_twice(false);
        assert!(messages.iter().any(|id| id == "SYNC-HAZARD-WRITE-AFTER-WRITE"), "{messages:?}");
        assert!(gpu.check_validation().is_err(), "a message fails the run");
        let (gpu, messages) = fill_twice(true);
        assert_eq!(messages, [""; 0]);
        assert!(gpu.check_validation().is_ok());
    }

    #[test]
    fn the_error_names_every_identifier_and_how_to_see_the_messages() {
        let message = |id: &str| Message { id: id.into(), text: format!("the text of {id}"), allowed: false };
        assert!(check(&[]).is_ok());
        let said = check(&[message("VUID-b"), message("VUID-a"), message("VUID-b")]).err().map(|e| e.to_string());
        assert_eq!(
            said.as_deref(),
            Some(
                "the validation layers reported 3 message(s) outside the allow-list: 1 of VUID-a, 2 of VUID-b \
                 (SSCT_LOG=vulkan=warn prints each whole); the first: the text of VUID-b"
            )
        );
    }

    #[test]
    fn an_allowed_message_has_an_id_of_its_own_and_a_reason() {
        for (n, super::AllowedMessage { id, versions, reason, .. }) in super::ALLOWED.iter().enumerate() {
            assert!(!reason.is_empty() && !id.is_empty() && !versions.is_empty());
            assert!(super::ALLOWED[..n].iter().all(|other| other.id != *id), "{id} twice");
        }
    }
}
