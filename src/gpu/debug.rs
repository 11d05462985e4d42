//! Names, labels and validation. In: an instance with `VK_EXT_debug_utils`. Out: object names and pass labels that
//! tools such as RenderDoc show, and the messages of the validation layer, collected.

use super::failure;
use crate::Result;
use ash::ext::debug_utils;
use ash::vk::{self, Handle};
use std::ffi::{CStr, CString, c_void};
use std::sync::{Mutex, PoisonError};

/// Collects validation messages until dropped; must go before its instance.
pub(super) struct Messenger {
    loader: debug_utils::Instance,
    raw: vk::DebugUtilsMessengerEXT,
    /// In the order they came. Boxed: its address is what the driver calls back with.
    messages: Box<Mutex<Vec<String>>>,
}

impl Messenger {
    pub(super) fn new(entry: &ash::Entry, instance: &ash::Instance) -> Result<Self> {
        let loader = debug_utils::Instance::new(entry, instance);
        let messages = Box::<Mutex<Vec<String>>>::default();
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(collect))
            .user_data((&raw const *messages).cast_mut().cast());
        // SAFETY: the callback's data lives in the box that this Messenger holds until the messenger is destroyed.
        let raw = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .map_err(failure::of("vkCreateDebugUtilsMessengerEXT"))?;
        Ok(Messenger {
            loader,
            raw,
            messages,
        })
    }
}

impl Messenger {
    /// The messages so far.
    pub(super) fn messages(&self) -> Vec<String> {
        self.messages
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: made by this loader, destroyed once; the owner drops it before the instance.
        unsafe { self.loader.destroy_debug_utils_messenger(self.raw, None) };
    }
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `messages` is the pointer given in Messenger::new, alive while the messenger is; the layer passes a valid
    // `data` whose message is a C string.
    let (messages, text) = unsafe {
        let message = (*data).p_message;
        let text = if message.is_null() {
            c"(no text)"
        } else {
            CStr::from_ptr(message)
        };
        (
            &*messages.cast::<Mutex<Vec<String>>>(),
            text.to_string_lossy().into_owned(),
        )
    };
    messages
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(text);
    vk::FALSE
}

/// Names objects and labels passes where the instance has `VK_EXT_debug_utils`; otherwise does nothing.
pub(super) struct Labels(Option<debug_utils::Device>);

impl Labels {
    pub(super) fn new(instance: &ash::Instance, device: &ash::Device, enabled: bool) -> Self {
        Labels(enabled.then(|| debug_utils::Device::new(instance, device)))
    }

    pub(super) fn name<H: Handle>(&self, object: H, name: &str) {
        if let Some(functions) = &self.0 {
            let name = c_string(name);
            let info = vk::DebugUtilsObjectNameInfoEXT::default()
                .object_handle(object)
                .object_name(&name);
            // SAFETY: the object was just made by this device. A name that cannot be set is no loss.
            let _ = unsafe { functions.set_debug_utils_object_name(&info) };
        }
    }

    /// Opens a label around what is recorded next.
    ///
    /// # Safety
    /// `commands` is being recorded.
    pub(super) unsafe fn begin(&self, commands: vk::CommandBuffer, name: &str) {
        if let Some(functions) = &self.0 {
            let name = c_string(name);
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            // SAFETY: the caller's promise.
            unsafe { functions.cmd_begin_debug_utils_label(commands, &label) };
        }
    }

    /// Closes the label.
    ///
    /// # Safety
    /// `commands` is being recorded, with a label open.
    pub(super) unsafe fn end(&self, commands: vk::CommandBuffer) {
        if let Some(functions) = &self.0 {
            // SAFETY: the caller's promise.
            unsafe { functions.cmd_end_debug_utils_label(commands) };
        }
    }
}

fn c_string(name: &str) -> CString {
    CString::new(name.replace('\0', " ")).unwrap_or_default()
}
