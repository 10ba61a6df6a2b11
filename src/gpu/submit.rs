//! Recording a pass, submitting it, waiting for it; how long it took.

use std::time::{Duration, Instant};

use ash::vk;

use super::buffer::Buffer;
use super::device::Device;
use super::error::GpuError;
use super::memory::Memory;
use super::pipeline::{Binding, BoundSet, Pipeline};

/// How long a submission took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Elapsed {
    /// From before the submission to after the wait; holds a driver's JIT, which lavapipe runs at the first dispatch.
    pub wall: Duration,
    /// Between the device's own timestamps, where it has them. On lavapipe they are the CPU's clock.
    pub device: Option<Duration>,
}

/// The one queue with its one command buffer, used by one submission at a time.
pub(super) struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    timestamps: vk::QueryPool,
    period_ns: f32,
}

impl Queue {
    pub fn new(device: &ash::Device, family: u32, period_ns: f32) -> Result<Queue, GpuError> {
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
        // SAFETY: plain creations on a live device; each info lives until its call returns.
        unsafe {
            let pool =
                device.create_command_pool(&pool_info, None).map_err(GpuError::call("vkCreateCommandPool", "queue"))?;
            let commands_info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device
                .allocate_command_buffers(&commands_info)
                .map_err(GpuError::call("vkAllocateCommandBuffers", "queue"))?[0];
            let fence = device
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .map_err(GpuError::call("vkCreateFence", "queue"))?;
            let mut timestamps = vk::QueryPool::null();
            if period_ns > 0.0 {
                let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
                timestamps =
                    device.create_query_pool(&info, None).map_err(GpuError::call("vkCreateQueryPool", "queue"))?;
            }
            Ok(Queue { raw: device.get_device_queue(family, 0), pool, commands, fence, timestamps, period_ns })
        }
    }

    /// # Safety
    /// Nothing submitted is still running, and the queue is not used again.
    pub unsafe fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: by the caller's promise.
        unsafe {
            device.destroy_query_pool(self.timestamps, None);
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Records the commands of a pass. What it is given must live until the pass was waited for, hence `'a`.
pub struct Recorder<'a> {
    device: Device,
    commands: vk::CommandBuffer,
    sets: Vec<BoundSet>,
    command_count: usize,
    borrowed: std::marker::PhantomData<&'a ()>,
}

impl<'a> Recorder<'a> {
    /// Runs `groups` workgroups of `pipeline`. Its bindings are looked up by name in `bindings`; others are ignored.
    pub fn dispatch(
        &mut self,
        pipeline: &'a Pipeline,
        bindings: &[Binding<'a>],
        push: &[u8],
        groups: [u32; 3],
    ) -> Result<(), GpuError> {
        let (kernel, limit) = (pipeline.name().to_owned(), self.device.info().limits.max_groups);
        if !self.device.is(&pipeline.device.shared) {
            let what = format!("kernel \"{kernel}\"");
            return Err(GpuError::ForeignDevice { what, device: self.device.info().name.clone() });
        }
        let declared = pipeline.reflection().push_bytes;
        if push.len() != declared as usize {
            return Err(GpuError::WrongPush { kernel, declared, given: push.len() });
        }
        if groups.iter().zip(limit).any(|(&count, limit)| count > limit) {
            return Err(GpuError::WrongGroups { kernel, groups, limit });
        }
        let set = pipeline.bind(bindings)?;
        self.wait_for_previous();
        let (raw, commands) = (&self.device.shared.raw, self.commands);
        // SAFETY: the command buffer is recording; pipeline, layout and set are alive until the wait (`'a`, `sets`).
        unsafe {
            raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw);
            if set.raw != vk::DescriptorSet::null() {
                let sets = [set.raw];
                raw.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::COMPUTE, pipeline.layout, 0, &sets, &[]);
            }
            if !push.is_empty() {
                raw.cmd_push_constants(commands, pipeline.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            raw.cmd_dispatch(commands, groups[0], groups[1], groups[2]);
        }
        self.sets.push(set);
        Ok(())
    }

    /// Sets every byte of `buffer` to zero.
    pub fn clear(&mut self, buffer: &'a Buffer) -> Result<(), GpuError> {
        if !self.device.is(&buffer.memory.device.shared) {
            let what = format!("\"{}\"", buffer.name());
            return Err(GpuError::ForeignDevice { what, device: self.device.info().name.clone() });
        }
        self.fill_zero(&buffer.memory);
        Ok(())
    }

    pub(super) fn fill_zero(&mut self, memory: &'a Memory) {
        self.wait_for_previous();
        // SAFETY: recording; the buffer lives until the wait and has TRANSFER_DST.
        unsafe { self.device.shared.raw.cmd_fill_buffer(self.commands, memory.raw, 0, vk::WHOLE_SIZE, 0) };
    }

    /// Both ranges lie inside their buffers, which are of this device.
    pub(super) fn copy(&mut self, from: &'a Memory, from_at: u64, to: &'a Memory, to_at: u64, bytes: u64) {
        if bytes == 0 {
            return;
        }
        self.wait_for_previous();
        let region = [vk::BufferCopy { src_offset: from_at, dst_offset: to_at, size: bytes }];
        // SAFETY: recording; the callers in `memory` checked the ranges and made the buffers with the usages for it.
        unsafe { self.device.shared.raw.cmd_copy_buffer(self.commands, from.raw, to.raw, &region) };
    }

    /// A full barrier: passes hold few commands, and each needs what the one before wrote.
    fn wait_for_previous(&mut self) {
        if self.command_count > 0 {
            let all = vk::PipelineStageFlags::ALL_COMMANDS;
            self.barrier(all, vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE, all);
        }
        self.command_count += 1;
    }

    fn barrier(&self, from: vk::PipelineStageFlags, to_access: vk::AccessFlags, to: vk::PipelineStageFlags) {
        let memory =
            [vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::MEMORY_WRITE).dst_access_mask(to_access)];
        // SAFETY: recording; a global memory barrier names no object.
        unsafe {
            let flags = vk::DependencyFlags::empty();
            self.device.shared.raw.cmd_pipeline_barrier(self.commands, from, to, flags, &memory, &[], &[]);
        }
    }
}

pub(super) fn submit<'a>(
    device: &Device,
    pass: &str,
    record: impl FnOnce(&mut Recorder<'a>) -> Result<(), GpuError>,
) -> Result<Elapsed, GpuError> {
    let raw = &device.shared.raw;
    let queue = device.shared.lock_queue();
    let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    // SAFETY: the queue's lock makes pool, command buffer, queries and fence ours, and the last submission was waited for.
    unsafe {
        raw.reset_command_pool(queue.pool, vk::CommandPoolResetFlags::empty())
            .map_err(GpuError::call("vkResetCommandPool", pass))?;
        raw.begin_command_buffer(queue.commands, &begin).map_err(GpuError::call("vkBeginCommandBuffer", pass))?;
        if queue.period_ns > 0.0 {
            raw.cmd_reset_query_pool(queue.commands, queue.timestamps, 0, 2);
            raw.cmd_write_timestamp(queue.commands, vk::PipelineStageFlags::TOP_OF_PIPE, queue.timestamps, 0);
        }
    }
    let mut recorder = Recorder {
        device: device.clone(),
        commands: queue.commands,
        sets: Vec::new(),
        command_count: 0,
        borrowed: std::marker::PhantomData,
    };
    record(&mut recorder)?;
    recorder.barrier(vk::PipelineStageFlags::ALL_COMMANDS, vk::AccessFlags::HOST_READ, vk::PipelineStageFlags::HOST);

    let start = Instant::now();
    let commands = [queue.commands];
    let submission = [vk::SubmitInfo::default().command_buffers(&commands)];
    // SAFETY: as above; `recorder` keeps the descriptor sets and `'a` the rest alive until the wait below is over. When the
    // wait fails the device is lost, and nothing runs on it any more.
    unsafe {
        if queue.period_ns > 0.0 {
            raw.cmd_write_timestamp(queue.commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, queue.timestamps, 1);
        }
        raw.end_command_buffer(queue.commands).map_err(GpuError::call("vkEndCommandBuffer", pass))?;
        raw.reset_fences(&[queue.fence]).map_err(GpuError::call("vkResetFences", pass))?;
        raw.queue_submit(queue.raw, &submission, queue.fence).map_err(GpuError::call("vkQueueSubmit", pass))?;
        raw.wait_for_fences(&[queue.fence], true, u64::MAX).map_err(GpuError::call("vkWaitForFences", pass))?;
    }
    let wall = start.elapsed();
    let mut ticks = [0u64; 2];
    let mut device_time = None;
    if queue.period_ns > 0.0 {
        // SAFETY: both queries were written by the submission that was waited for.
        let read =
            unsafe { raw.get_query_pool_results(queue.timestamps, 0, &mut ticks, vk::QueryResultFlags::TYPE_64) };
        let nanoseconds = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(queue.period_ns);
        device_time = read.ok().map(|()| Duration::from_nanos(nanoseconds as u64));
    }
    drop(recorder);
    Ok(Elapsed { wall, device: device_time })
}
