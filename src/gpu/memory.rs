//! A Vulkan buffer with its memory, counted: the owner behind `Table` and `Buffer`.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::device::{Device, Shared};
use super::error::GpuError;

/// Copies between host and device memory go through a staging buffer of at most this size.
const STAGING_BYTES: u64 = 64 << 20;

pub(super) struct Memory {
    pub name: String,
    pub bytes: u64,
    pub raw: vk::Buffer,
    allocation: Option<Allocation>,
    pub device: Device,
}

impl Memory {
    /// A buffer of `bytes` bytes, not yet written. On a device that shares the host's memory it is mapped.
    pub fn new(device: &Device, name: &str, bytes: u64, usage: vk::BufferUsageFlags) -> Result<Memory, GpuError> {
        use super::info::DeviceKind::{Integrated, Software};
        let is_shared = matches!(device.info().kind, Software | Integrated);
        let location = if is_shared { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
        let usage = usage | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        Memory::allocate(device, name, bytes, usage, location)
    }

    fn allocate(
        device: &Device,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Memory, GpuError> {
        let shared = &device.shared;
        let bytes = bytes.max(16).next_multiple_of(16);
        let limit = shared.info.limits.max_allocation;
        if bytes > limit {
            return Err(GpuError::TooLarge {
                name: name.to_owned(),
                bytes,
                limit_name: "maxMemoryAllocationSize",
                limit,
            });
        }
        let allocated = shared.allocated.load(Ordering::Relaxed);
        let out_of_memory =
            || GpuError::OutOfMemory { name: name.to_owned(), bytes, allocated, limit: shared.memory_limit };
        if allocated.saturating_add(bytes) > shared.memory_limit {
            return Err(out_of_memory());
        }
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: a plain buffer of nonzero size.
        let raw = unsafe { shared.raw.create_buffer(&info, None) }.map_err(GpuError::call("vkCreateBuffer", name))?;
        // From here on Drop frees what was made.
        let mut memory = Memory { name: name.to_owned(), bytes, raw, allocation: None, device: device.clone() };
        shared.set_name(raw, name);
        // SAFETY: `raw` is alive.
        let requirements = unsafe { shared.raw.get_buffer_memory_requirements(raw) };
        let request = AllocationCreateDesc {
            name,
            requirements,
            location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation =
            shared.with_allocator(|allocator| allocator.allocate(&request)).map_err(|source| match source {
                gpu_allocator::AllocationError::OutOfMemory => out_of_memory(),
                source => GpuError::Allocator { name: name.to_owned(), source },
            })?;
        // SAFETY: the allocation meets the buffer's requirements and is bound to nothing else.
        let bound = unsafe { shared.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        memory.allocation = Some(allocation);
        let now = shared.allocated.fetch_add(bytes, Ordering::Relaxed) + bytes;
        shared.peak.fetch_max(now, Ordering::Relaxed);
        bound.map_err(GpuError::call("vkBindBufferMemory", name))?;
        Ok(memory)
    }

    /// Copies `source` to byte `offset`.
    pub fn write(&self, offset: u64, source: &[u8]) -> Result<(), GpuError> {
        self.check(offset, source.len() as u64)?;
        if let Some(mapped) = self.mapped() {
            let _exclusive = self.device.shared.lock_queue();
            // SAFETY: the range was checked, and the queue's lock keeps the device and other host threads away.
            unsafe { std::ptr::copy_nonoverlapping(source.as_ptr(), mapped.add(offset as usize), source.len()) };
            return Ok(());
        }
        let step = STAGING_BYTES.min(source.len() as u64);
        let staging = self.staging(step, vk::BufferUsageFlags::TRANSFER_SRC, MemoryLocation::CpuToGpu)?;
        for (i, part) in source.chunks(step.max(1) as usize).enumerate() {
            staging.write(0, part)?;
            let at = offset + i as u64 * step;
            self.device.submit(&format!("upload {}", self.name), |pass| {
                pass.copy(&staging, 0, self, at, part.len() as u64);
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Copies the bytes from `offset` on to `target`.
    pub fn read(&self, offset: u64, target: &mut [u8]) -> Result<(), GpuError> {
        self.check(offset, target.len() as u64)?;
        if let Some(mapped) = self.mapped() {
            let _exclusive = self.device.shared.lock_queue();
            // SAFETY: as in `write`.
            unsafe { std::ptr::copy_nonoverlapping(mapped.add(offset as usize), target.as_mut_ptr(), target.len()) };
            return Ok(());
        }
        let step = STAGING_BYTES.min(target.len() as u64);
        let staging = self.staging(step, vk::BufferUsageFlags::TRANSFER_DST, MemoryLocation::GpuToCpu)?;
        for (i, part) in target.chunks_mut(step.max(1) as usize).enumerate() {
            let at = offset + i as u64 * step;
            self.device.submit(&format!("download {}", self.name), |pass| {
                pass.copy(self, at, &staging, 0, part.len() as u64);
                Ok(())
            })?;
            staging.read(0, part)?;
        }
        Ok(())
    }

    pub fn fill_zero(&self) -> Result<(), GpuError> {
        if let Some(mapped) = self.mapped() {
            let _exclusive = self.device.shared.lock_queue();
            // SAFETY: the mapping is `bytes` long; the lock keeps the device and other host threads away.
            unsafe { std::ptr::write_bytes(mapped, 0, self.bytes as usize) };
            return Ok(());
        }
        let pass = format!("clear {}", self.name);
        self.device.submit(&pass, |pass| {
            pass.fill_zero(self);
            Ok(())
        })?;
        Ok(())
    }

    fn staging(&self, bytes: u64, usage: vk::BufferUsageFlags, location: MemoryLocation) -> Result<Memory, GpuError> {
        Memory::allocate(&self.device, &format!("staging of {}", self.name), bytes, usage, location)
    }

    fn mapped(&self) -> Option<*mut u8> {
        // gpu-allocator maps every host-visible allocation for its lifetime; such memory is also host-coherent there.
        self.allocation.as_ref()?.mapped_ptr().map(|p| p.as_ptr().cast())
    }

    fn check(&self, first: u64, length: u64) -> Result<(), GpuError> {
        let last = first.saturating_add(length);
        if last <= self.bytes {
            return Ok(());
        }
        Err(GpuError::OutsideBuffer { name: self.name.clone(), first, last, bytes: self.bytes })
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        let shared = &self.device.shared;
        // SAFETY: every submission that uses the buffer borrows its owner and was waited for.
        unsafe { shared.raw.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for an allocation of another allocator.
            let _ = shared.with_allocator(|allocator| allocator.free(allocation));
            shared.allocated.fetch_sub(self.bytes, Ordering::Relaxed);
        }
    }
}

impl Shared {
    fn with_allocator<T>(self: &Arc<Self>, run: impl FnOnce(&mut gpu_allocator::vulkan::Allocator) -> T) -> T {
        let mut guard = self.allocator.lock().unwrap_or_else(|e| e.into_inner());
        run(guard.as_mut().expect("the allocator is taken only when the last owner of the device drops"))
    }
}
