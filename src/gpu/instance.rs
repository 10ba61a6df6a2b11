//! The Vulkan instance, the validation layer's messages, and the list of physical devices.

use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use ash::{ext, vk};

use super::error::GpuError;
use super::info::{DeviceInfo, DeviceKind, Limits};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Vulkan 1.2 is what the kernels' SPIR-V 1.5 needs.
const LEAST_API: u32 = vk::API_VERSION_1_2;

pub(super) struct Instance {
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Boxed: the messenger holds its address.
    messages: Box<Mutex<Vec<String>>>,
    pub raw: ash::Instance,
    pub has_debug_utils: bool,
    /// Holds the loaded library; dropped last.
    _entry: ash::Entry,
}

impl Instance {
    /// `loader`: another path than the system's libvulkan.so.1, for tests.
    pub fn open(validation: bool, loader: Option<&str>) -> Result<Instance, GpuError> {
        // SAFETY: loading a shared library runs its initialisers; the Vulkan loader's are made for that.
        let entry = unsafe { loader.map_or_else(|| ash::Entry::load(), |path| ash::Entry::load_from(path)) };
        let entry = entry.map_err(|_| GpuError::NoLoader)?;
        // SAFETY: no input but `entry`, which is loaded.
        let version = unsafe { entry.try_enumerate_instance_version() }.ok().flatten().unwrap_or(vk::API_VERSION_1_0);
        if version < LEAST_API {
            return Err(GpuError::NoDevice);
        }
        // SAFETY: as above.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
        let has_debug_utils = extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ext::debug_utils::NAME));
        if validation && !has_layer(&entry) {
            return Err(GpuError::NoValidationLayer);
        }

        let application =
            vk::ApplicationInfo::default().application_name(c"steradian").api_version(vk::API_VERSION_1_3);
        let extension_names: Vec<_> = has_debug_utils.then_some(ext::debug_utils::NAME.as_ptr()).into_iter().collect();
        let layer_names: Vec<_> = validation.then_some(VALIDATION_LAYER.as_ptr()).into_iter().collect();
        let messages = Box::new(Mutex::new(Vec::new()));
        let mut messenger_info = messenger_info(&messages);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extension_names)
            .enabled_layer_names(&layer_names);
        if validation && has_debug_utils {
            info = info.push_next(&mut messenger_info);
        }
        // SAFETY: the info's pointers live until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => GpuError::NoDevice,
            result => GpuError::Vulkan { call: "vkCreateInstance", name: "instance".to_owned(), result },
        })?;
        let mut instance = Instance { messenger: None, messages, raw, has_debug_utils, _entry: entry };
        if validation && has_debug_utils {
            instance.listen()?;
        }
        Ok(instance)
    }

    /// What the validation layer said so far.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }

    pub fn clear_messages(&self) {
        self.messages.lock().unwrap_or_else(|e| e.into_inner()).clear();
    }

    /// Physical devices in the loader's order, with what is known of each.
    pub fn devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>, GpuError> {
        // SAFETY: the instance is alive.
        let found = unsafe { self.raw.enumerate_physical_devices() };
        let found = found.map_err(GpuError::call("vkEnumeratePhysicalDevices", "instance"))?;
        Ok(found.iter().enumerate().map(|(index, &physical)| (physical, self.describe(physical, index))).collect())
    }

    /// The compute queue family to use: one without graphics where there is one.
    pub fn queue_family(&self, physical: vk::PhysicalDevice) -> Option<(u32, vk::QueueFamilyProperties)> {
        // SAFETY: `physical` is of this instance.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(physical) };
        let able = families.iter().enumerate().filter(|(_, f)| f.queue_flags.contains(vk::QueueFlags::COMPUTE));
        able.min_by_key(|(_, f)| f.queue_flags.contains(vk::QueueFlags::GRAPHICS)).map(|(i, f)| (i as u32, *f))
    }

    fn listen(&mut self) -> Result<(), GpuError> {
        let functions = ext::debug_utils::Instance::new(&self._entry, &self.raw);
        // SAFETY: the callback's user data is the boxed Vec, which outlives the messenger (destroyed first in Drop).
        let messenger = unsafe { functions.create_debug_utils_messenger(&messenger_info(&self.messages), None) };
        let messenger = messenger.map_err(GpuError::call("vkCreateDebugUtilsMessengerEXT", "instance"))?;
        self.messenger = Some((functions, messenger));
        Ok(())
    }

    fn describe(&self, physical: vk::PhysicalDevice, index: usize) -> DeviceInfo {
        // SAFETY: `physical` is of this instance.
        let api = unsafe { self.raw.get_physical_device_properties(physical) }.api_version;
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default();
        if api >= vk::API_VERSION_1_1 {
            properties = properties.push_next(&mut subgroup).push_next(&mut maintenance);
        }
        if api >= LEAST_API {
            properties = properties.push_next(&mut driver);
        }
        // SAFETY: the chain holds structs that this device's version knows, alive until the call returns.
        unsafe { self.raw.get_physical_device_properties2(physical, &mut properties) };
        let p = properties.properties;
        // SAFETY: `physical` is of this instance.
        let memory = unsafe { self.raw.get_physical_device_memory_properties(physical) };
        let heap = |h: &&vk::MemoryHeap| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        let queue = self.queue_family(physical);
        let version =
            |v: u32| format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v));
        let driver_info = text(driver.driver_info_as_c_str());
        DeviceInfo {
            index,
            name: text(p.device_name_as_c_str()),
            kind: match p.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Software,
                _ => DeviceKind::Other,
            },
            is_software: p.device_type == vk::PhysicalDeviceType::CPU,
            driver: text(driver.driver_name_as_c_str()),
            driver_version: if driver_info.is_empty() { version(p.driver_version) } else { driver_info },
            api_version: version(api),
            vendor_id: p.vendor_id,
            device_id: p.device_id,
            subgroup_size: subgroup.subgroup_size,
            timestamp_period_ns: match queue {
                Some((_, family)) if family.timestamp_valid_bits > 0 => p.limits.timestamp_period,
                _ => 0.0,
            },
            limits: Limits {
                max_texel_elements: p.limits.max_texel_buffer_elements,
                max_storage_range: p.limits.max_storage_buffer_range,
                max_allocation: maintenance.max_memory_allocation_size,
                heap: memory.memory_heaps_as_slice().iter().filter(heap).map(|h| h.size).max().unwrap_or(0),
                max_groups: p.limits.max_compute_work_group_count,
                max_group_size: p.limits.max_compute_work_group_size,
                max_group_invocations: p.limits.max_compute_work_group_invocations,
                max_shared_bytes: p.limits.max_compute_shared_memory_size,
                max_push_bytes: p.limits.max_push_constants_size,
                max_storage_bindings: p.limits.max_per_stage_descriptor_storage_buffers,
                max_texel_bindings: p.limits.max_per_stage_descriptor_sampled_images,
            },
            problem: match queue {
                _ if api < LEAST_API => Some(format!("it offers Vulkan {}, and 1.2 is needed", version(api))),
                None => Some("it has no compute queue".to_owned()),
                Some(_) => None,
            },
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices hold the instance, so none is alive; the messenger goes before the instance.
        unsafe {
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn text(name: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

fn has_layer(entry: &ash::Entry) -> bool {
    // SAFETY: no input but the loaded entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
}

fn messenger_info(messages: &Mutex<Vec<String>>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        // GENERAL holds the loader's remarks on other drivers of the machine, which are no fault of ours.
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages) as *mut c_void)
}

/// Appends the message to the `Mutex<Vec<String>>` behind `user_data`.
unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid callback data, and `user_data` is the Mutex given in `messenger_info`.
    unsafe {
        let message = (*data).message_as_c_str().map(|m| m.to_string_lossy().into_owned()).unwrap_or_default();
        let messages = &*(user_data as *const Mutex<Vec<String>>);
        messages.lock().unwrap_or_else(|e| e.into_inner()).push(message);
    }
    vk::FALSE
}
