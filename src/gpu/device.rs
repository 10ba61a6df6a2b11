//! Opening a device, and the facade that makes tables, buffers and pipelines on it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::buffer::Buffer;
use super::error::GpuError;
use super::info::{Choice, DeviceInfo, choose};
use super::instance::Instance;
use super::pipeline::{Binding, Pipeline};
use super::submit::{Elapsed, Queue, Recorder};
use super::table::{Table, TableBody};
use crate::shader::compile::Spirv;

#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Turns the Khronos validation layer on; its messages are in `Device::messages`.
    pub validation: bool,
    /// Limit on the memory of all tables and buffers, in bytes; the device's heap limits it too.
    pub max_memory: Option<u64>,
}

/// What `--device` came to.
pub enum Selected {
    Vulkan(Device),
    /// The CPU reference, with the reason when it was not asked for.
    Cpu {
        reason: Option<String>,
    },
}

/// All devices of the machine in the loader's order. Without a loader: `NoLoader`; without a driver: `NoDevice`.
pub fn list() -> Result<Vec<DeviceInfo>, GpuError> {
    Ok(Instance::open(false, None)?.devices()?.into_iter().map(|(_, info)| info).collect())
}

/// Opens what `choice` means. `Auto` falls back to the CPU reference where Vulkan is missing, and says why.
pub fn select(choice: &Choice, options: &Options) -> Result<Selected, GpuError> {
    match (choice, Device::open(choice, options)) {
        (Choice::Cpu, _) => Ok(Selected::Cpu { reason: None }),
        (_, Ok(device)) => Ok(Selected::Vulkan(device)),
        (Choice::Auto, Err(e @ (GpuError::NoLoader | GpuError::NoDevice))) => {
            let what = e.to_string();
            let what = what.trim_end_matches(", or use --device cpu");
            Ok(Selected::Cpu { reason: Some(format!("{what}; until then the CPU reference renders")) })
        }
        (_, Err(e)) => Err(e),
    }
}

/// An open device. Cheap to clone; closed when the last table, buffer, pipeline and clone are gone.
#[derive(Clone)]
pub struct Device {
    pub(super) shared: Arc<Shared>,
}

/// The owner of the Vulkan device; every object made on it holds one of these.
pub(super) struct Shared {
    pub info: DeviceInfo,
    pub raw: ash::Device,
    pub allocator: Mutex<Option<Allocator>>,
    pub allocated: AtomicU64,
    pub peak: AtomicU64,
    pub memory_limit: u64,
    /// Also locks host access to mapped buffers, so that it never overlaps with a submission.
    pub queue: Mutex<Queue>,
    names: Option<ext::debug_utils::Device>,
    instance: Instance,
}

impl Device {
    /// Opens the device that `choice` means (`Auto`: a GPU, else software Vulkan).
    pub fn open(choice: &Choice, options: &Options) -> Result<Device, GpuError> {
        Device::open_with_loader(choice, options, None)
    }

    pub(super) fn open_with_loader(
        choice: &Choice,
        options: &Options,
        loader: Option<&str>,
    ) -> Result<Device, GpuError> {
        if *choice == Choice::Cpu {
            return Err(GpuError::NoDevice);
        }
        let instance = Instance::open(options.validation, loader)?;
        let devices = instance.devices()?;
        let infos: Vec<DeviceInfo> = devices.iter().map(|(_, info)| info.clone()).collect();
        let picked = choose(&infos, choice)?;
        let (physical, info) = (devices[picked].0, infos[picked].clone());
        let (family, _) = instance.queue_family(physical).ok_or(GpuError::NoDevice)?;

        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        // An index outside a buffer reads zero or stays inside it: the facade is safe whatever a kernel's text does.
        let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&features);
        // SAFETY: the family exists; robustBufferAccess is a feature that every device has.
        let raw = unsafe { instance.raw.create_device(physical, &create, None) }
            .map_err(GpuError::call("vkCreateDevice", &info.name))?;
        // On an error below, the device itself stays alive until the process ends: opening is not retried in a loop.
        let queue = Queue::new(&raw, family, info.timestamp_period_ns)?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            // Small blocks: tables are few and large, and get their own; the peak is what a render needs.
            allocation_sizes: AllocationSizes::new(4 << 20, 4 << 20),
        })
        .map_err(|source| GpuError::Allocator { name: info.name.clone(), source })?;
        let names = instance.has_debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let memory_limit = options.max_memory.unwrap_or(u64::MAX).min(info.limits.heap);
        let shared = Shared {
            info,
            raw,
            allocator: Mutex::new(Some(allocator)),
            allocated: AtomicU64::new(0),
            peak: AtomicU64::new(0),
            memory_limit,
            queue: Mutex::new(queue),
            names,
            instance,
        };
        Ok(Device { shared: Arc::new(shared) })
    }

    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// What the validation layer said since opening or `clear_messages`. Empty without `Options::validation`.
    pub fn messages(&self) -> Vec<String> {
        self.shared.instance.messages()
    }

    pub fn clear_messages(&self) {
        self.shared.instance.clear_messages();
    }

    /// Bytes of all tables and buffers alive.
    pub fn allocated_bytes(&self) -> u64 {
        self.shared.allocated.load(Ordering::Relaxed)
    }

    /// The most that `allocated_bytes` ever was.
    pub fn peak_bytes(&self) -> u64 {
        self.shared.peak.load(Ordering::Relaxed)
    }

    /// Uploads a read-only table; `name` is the one its GLSL was generated with. A record is whole rows of 16 bytes.
    pub fn table<T: bytemuck::Pod>(&self, name: &str, records: &[T], body: TableBody) -> Result<Table, GpuError> {
        const { assert!(size_of::<T>().is_multiple_of(16), "a record is whole rows of 16 bytes") };
        Table::new(self, name, bytemuck::cast_slice(records), body)
    }

    /// A read-write storage buffer of `bytes` zero bytes.
    pub fn buffer(&self, name: &str, bytes: u64) -> Result<Buffer, GpuError> {
        Buffer::new(self, name, bytes)
    }

    /// A compute pipeline; `constants` are (constant_id, bits). Bindings and push constants come from the SPIR-V.
    pub fn pipeline(&self, spirv: &Spirv, constants: &[(u32, u32)]) -> Result<Pipeline, GpuError> {
        Pipeline::new(self, spirv, constants)
    }

    /// Runs one dispatch and waits; wall-clock time. Bindings that the kernel does not have are ignored, so the same list
    /// serves every kernel of a scene.
    pub fn dispatch(
        &self,
        pipeline: &Pipeline,
        bindings: &[Binding<'_>],
        push: &[u8],
        groups: [u32; 3],
    ) -> Result<Duration, GpuError> {
        self.submit(pipeline.name(), |pass| pass.dispatch(pipeline, bindings, push, groups)).map(|elapsed| elapsed.wall)
    }

    /// Records a pass, submits it and waits for it. Each command sees what the ones before it wrote.
    /// `record` only records: making, reading or submitting anything on the device inside it would wait for itself.
    pub fn submit<'a>(
        &self,
        pass: &str,
        record: impl FnOnce(&mut Recorder<'a>) -> Result<(), GpuError>,
    ) -> Result<Elapsed, GpuError> {
        super::submit::submit(self, pass, record)
    }

    pub(super) fn is(&self, shared: &Arc<Shared>) -> bool {
        Arc::ptr_eq(&self.shared, shared)
    }
}

impl Shared {
    pub fn lock_queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Gives a Vulkan object the name that messages and captures show.
    pub fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(functions), Ok(name)) = (&self.names, std::ffi::CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle is alive and of this device; the name lives until the call returns. A name that
        // could not be set changes nothing else.
        let _ = unsafe { functions.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: every object made on the device holds this Shared, so none is alive, and every submission was waited for.
        unsafe {
            // The allocator frees its blocks with the device, so it goes first.
            self.allocator.lock().unwrap_or_else(|e| e.into_inner()).take();
            self.queue.lock().unwrap_or_else(|e| e.into_inner()).destroy(&self.raw);
            self.raw.destroy_device(None);
        }
    }
}
