//! What can go wrong on a device, one sentence each: what, where, what to do.

use ash::vk;

#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    #[error(
        "no Vulkan loader (libvulkan.so.1) was found: install libvulkan1 and mesa-vulkan-drivers, or use --device cpu"
    )]
    NoLoader,
    #[error("Vulkan is installed but offers no usable device: install mesa-vulkan-drivers, or use --device cpu")]
    NoDevice,
    #[error("no device matches \"{wanted}\"; there are: {available}")]
    UnknownDevice { wanted: String, available: String },
    #[error("device \"{device}\" cannot be used: {missing}")]
    MissingFeature { device: String, missing: String },
    #[error("the validation layer VK_LAYER_KHRONOS_validation is not installed (package vulkan-validationlayers)")]
    NoValidationLayer,
    #[error("the device was lost in pass \"{pass}\"; a shorter pass (smaller --size or time budget) may survive")]
    DeviceLost { pass: String },
    #[error(
        "out of device memory: \"{name}\" needs {bytes} bytes, {allocated} of {limit} bytes are taken; raise --max-memory or reduce the scene"
    )]
    OutOfMemory { name: String, bytes: u64, allocated: u64, limit: u64 },
    #[error(
        "\"{name}\" needs {bytes} bytes, more than the device's {limit_name} of {limit} bytes; reduce the scene or use another device"
    )]
    TooLarge { name: String, bytes: u64, limit_name: &'static str, limit: u64 },
    #[error("kernel \"{kernel}\" reads binding \"{binding}\", which was not given")]
    MissingBinding { kernel: String, binding: String },
    #[error("kernel \"{kernel}\" declares binding \"{binding}\" as {declared}, but got {given}")]
    WrongBinding { kernel: String, binding: String, declared: String, given: &'static str },
    #[error("kernel \"{kernel}\" takes {declared} bytes of push constants, but got {given}")]
    WrongPush { kernel: String, declared: u32, given: usize },
    #[error("kernel \"{kernel}\" cannot be dispatched with {groups:?} workgroups: the limit is {limit:?}")]
    WrongGroups { kernel: String, groups: [u32; 3], limit: [u32; 3] },
    #[error("bytes {first}..{last} are outside \"{name}\", which has {bytes}")]
    OutsideBuffer { name: String, first: u64, last: u64, bytes: u64 },
    #[error("{what} belongs to another device than \"{device}\"")]
    ForeignDevice { what: String, device: String },
    #[error("Vulkan call {call} failed for \"{name}\": {result}")]
    Vulkan { call: &'static str, name: String, result: vk::Result },
    #[error("memory for \"{name}\" could not be allocated: {source}")]
    Allocator { name: String, source: gpu_allocator::AllocationError },
}

impl GpuError {
    /// Says which call failed, on which object.
    pub(super) fn call(call: &'static str, name: &str) -> impl FnOnce(vk::Result) -> GpuError {
        move |result| match result {
            vk::Result::ERROR_DEVICE_LOST => GpuError::DeviceLost { pass: name.to_owned() },
            _ => GpuError::Vulkan { call, name: name.to_owned(), result },
        }
    }
}
