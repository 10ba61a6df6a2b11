//! Read-write storage buffers: what a kernel writes and the host reads back.

use std::ops::Range;

use ash::vk;
use bytemuck::Pod;

use super::device::Device;
use super::error::GpuError;
use super::memory::Memory;
use super::pipeline::{Binding, Resource};

pub struct Buffer {
    pub(super) memory: Memory,
}

impl Buffer {
    pub(super) fn new(device: &Device, name: &str, bytes: u64) -> Result<Buffer, GpuError> {
        let limit = u64::from(device.info().limits.max_storage_range);
        if bytes > limit {
            return Err(GpuError::TooLarge {
                name: name.to_owned(),
                bytes,
                limit_name: "maxStorageBufferRange",
                limit,
            });
        }
        let buffer = Buffer { memory: Memory::new(device, name, bytes, vk::BufferUsageFlags::STORAGE_BUFFER)? };
        buffer.clear()?;
        Ok(buffer)
    }

    pub fn name(&self) -> &str {
        &self.memory.name
    }

    /// Size in bytes, a multiple of 16.
    pub fn bytes(&self) -> u64 {
        self.memory.bytes
    }

    /// Binds the buffer to the GLSL block or variable of the same name.
    pub fn binding(&self) -> Binding<'_> {
        Binding { name: &self.memory.name, resource: Resource::Buffer(self) }
    }

    /// Elements `range` of the buffer seen as an array of `T`.
    pub fn read<T: Pod>(&self, range: Range<usize>) -> Result<Vec<T>, GpuError> {
        let mut target = vec![T::zeroed(); range.len()];
        self.read_into(range.start, &mut target)?;
        Ok(target)
    }

    /// Fills `target` with the elements from `first` on, without an allocation.
    pub fn read_into<T: Pod>(&self, first: usize, target: &mut [T]) -> Result<(), GpuError> {
        self.memory.read((first as u64).saturating_mul(size_of::<T>() as u64), bytemuck::cast_slice_mut(target))
    }

    /// Writes `source` from element `first` on.
    pub fn write<T: Pod>(&self, first: usize, source: &[T]) -> Result<(), GpuError> {
        self.memory.write((first as u64).saturating_mul(size_of::<T>() as u64), bytemuck::cast_slice(source))
    }

    /// Sets every byte to zero.
    pub fn clear(&self) -> Result<(), GpuError> {
        self.memory.fill_zero()
    }
}
