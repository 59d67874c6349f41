//! What the validation layers say: collected, counted, and held against an allow-list.

use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

/// Message IDs that do not fail a run, each with its reason.
pub const ALLOWED: &[(&str, &str)] = &[
    (
        "UNASSIGNED-BestPractices-vkCreateInstance-specialuse-extension-debugging",
        "VK_EXT_debug_utils is what names objects and carries these very messages",
    ),
    ("UNASSIGNED-BestPractices-vkCreateDevice-specialuse-extension-debugging", "as above, for the device"),
    (
        "UNASSIGNED-BestPractices-vkBindMemory-small-dedicated-allocation",
        "small images and buffers have memory of their own where the driver prefers it; few are made, none in a frame",
    ),
    ("UNASSIGNED-BestPractices-vkAllocateMemory-small-allocation", "as above"),
    (
        "UNASSIGNED-BestPractices-pipeline-stage-flags2-compute",
        "timing mode separates passes by full barriers on purpose, so that neighbours cannot overlap",
    ),
    (
        "UNASSIGNED-BestPractices-pipeline-stage-flags",
        "timing mode stamps at ALL_COMMANDS on purpose, so that a time holds all of a pass",
    ),
];

/// The messages of one device.
#[derive(Debug, Default)]
pub struct ValidationLog {
    messages: Mutex<Vec<Message>>,
}

/// One message.
#[derive(Debug, Clone)]
pub struct Message {
    /// Its ID, as in the allow-list.
    pub id: String,
    /// Its text.
    pub text: String,
    /// Whether the allow-list names it.
    pub allowed: bool,
}

impl ValidationLog {
    /// Every message so far.
    pub fn messages(&self) -> Vec<Message> {
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }

    /// The messages outside the allow-list.
    pub fn violations(&self) -> Vec<Message> {
        self.messages().into_iter().filter(|m| !m.allowed).collect()
    }

    fn push(&self, id: String, text: String) {
        let allowed = ALLOWED.iter().any(|(known, _)| *known == id);
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).push(Message { id, text, allowed });
    }
}

/// The debug-utils callback; its user data is a `ValidationLog` that outlives the messenger.
///
/// # Safety
/// Vulkan calls it with valid pointers; `user_data` must point to a live [`ValidationLog`].
pub(super) unsafe extern "system" fn callback(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: both pointers are valid for the call, by the function's contract; strings that are
    // not null are null-terminated.
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
