//! Compute pipelines whose layout is read from their SPIR-V, and the resources given to them by name.

use std::collections::HashSet;
use std::ffi::CString;

use ash::vk;

use super::buffer::Buffer;
use super::device::Device;
use super::error::GpuError;
use super::memory::Memory;
use super::table::{Table, TableBody};
use crate::shader::compile::Spirv;
use crate::shader::reflect::{BindingKind, Reflection};

/// A resource and the name that the GLSL gives it.
#[derive(Clone, Copy)]
pub struct Binding<'a> {
    pub name: &'a str,
    pub resource: Resource<'a>,
}

#[derive(Clone, Copy)]
pub enum Resource<'a> {
    Table(&'a Table),
    Buffer(&'a Buffer),
}

impl<'a> Resource<'a> {
    fn memory(self) -> &'a Memory {
        match self {
            Resource::Table(table) => &table.memory,
            Resource::Buffer(buffer) => &buffer.memory,
        }
    }

    /// What it is in the words of an error.
    fn describe(self) -> &'static str {
        match self {
            Resource::Table(t) if t.body == TableBody::Texel => "a table with a texel body",
            Resource::Table(Table { body: TableBody::Paged { .. }, .. }) => "a table in pages",
            Resource::Table(_) => "a table with a storage body",
            Resource::Buffer(_) => "a buffer",
        }
    }

    /// Descriptors it takes.
    fn count(self) -> u32 {
        match self {
            Resource::Table(Table { body: TableBody::Paged { pages, .. }, .. }) => *pages,
            _ => 1,
        }
    }

    fn suits(self, kind: BindingKind, is_read_only: bool) -> bool {
        match self {
            Resource::Table(t) if t.body == TableBody::Texel => kind == BindingKind::TexelBuffer,
            Resource::Table(_) => kind == BindingKind::StorageBuffer && is_read_only,
            Resource::Buffer(_) => kind == BindingKind::StorageBuffer,
        }
    }
}

pub struct Pipeline {
    name: String,
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    reflection: Reflection,
    pub(super) device: Device,
}

impl Pipeline {
    pub(super) fn new(device: &Device, spirv: &Spirv, constants: &[(u32, u32)]) -> Result<Pipeline, GpuError> {
        let (shared, name) = (&device.shared, spirv.name());
        let reflection = spirv.reflection().clone();
        check_limits(device, name, &reflection)?;
        // From here on Drop frees what was made: null handles are ignored.
        let mut pipeline = Pipeline {
            name: name.to_owned(),
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            reflection,
            device: device.clone(),
        };
        let slots: Vec<_> = pipeline
            .reflection
            .bindings
            .iter()
            .map(|b| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(b.binding)
                    .descriptor_type(descriptor_type(b.kind))
                    .descriptor_count(b.count)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
        // SAFETY: the infos below and what they point to live until their calls return, and hold live objects of this device.
        pipeline.set_layout = unsafe { shared.raw.create_descriptor_set_layout(&set_info, None) }
            .map_err(GpuError::call("vkCreateDescriptorSetLayout", name))?;
        let set_layouts = [pipeline.set_layout];
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(pipeline.reflection.push_bytes)];
        let push_ranges = if pipeline.reflection.push_bytes > 0 { &push[..] } else { &[] };
        let layout_info =
            vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(push_ranges);
        // SAFETY: as above.
        pipeline.layout = unsafe { shared.raw.create_pipeline_layout(&layout_info, None) }
            .map_err(GpuError::call("vkCreatePipelineLayout", name))?;

        let module_info = vk::ShaderModuleCreateInfo::default().code(spirv.words());
        // SAFETY: as above; the words come from shaderc (`Spirv` has no other constructor), so they are valid SPIR-V.
        let module = unsafe { shared.raw.create_shader_module(&module_info, None) }
            .map_err(GpuError::call("vkCreateShaderModule", name))?;
        shared.set_name(module, name);
        let result = pipeline.create(module, constants);
        // SAFETY: a module may go once the pipeline was made, or failed to be.
        unsafe { shared.raw.destroy_shader_module(module, None) };
        pipeline.raw = result?;
        shared.set_name(pipeline.raw, name);
        Ok(pipeline)
    }

    fn create(&self, module: vk::ShaderModule, constants: &[(u32, u32)]) -> Result<vk::Pipeline, GpuError> {
        let entries: Vec<_> = constants
            .iter()
            .enumerate()
            .map(|(i, &(id, _))| vk::SpecializationMapEntry { constant_id: id, offset: i as u32 * 4, size: 4 })
            .collect();
        let values: Vec<u32> = constants.iter().map(|&(_, bits)| bits).collect();
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main")
            .specialization_info(&specialization);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: module and layout are alive, of this device, and the layout was made from the module's own reflection.
        let made = unsafe { self.device.shared.raw.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        let made = made.map_err(|(_, result)| GpuError::call("vkCreateComputePipelines", &self.name)(result))?;
        Ok(made[0])
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn reflection(&self) -> &Reflection {
        &self.reflection
    }

    /// A descriptor set with the resources that this kernel names, in a pool of its own.
    pub(super) fn bind(&self, bindings: &[Binding<'_>]) -> Result<BoundSet, GpuError> {
        let shared = &self.device.shared;
        let mut set =
            BoundSet { pool: vk::DescriptorPool::null(), raw: vk::DescriptorSet::null(), device: self.device.clone() };
        if self.reflection.bindings.is_empty() {
            return Ok(set);
        }
        let kinds: HashSet<_> = self.reflection.bindings.iter().map(|b| b.kind).collect();
        let sizes: Vec<_> = kinds
            .iter()
            .map(|&kind| {
                let count = self.reflection.bindings.iter().filter(|b| b.kind == kind).map(|b| b.count).sum();
                vk::DescriptorPoolSize { ty: descriptor_type(kind), descriptor_count: count }
            })
            .collect();
        let pool_info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the infos below and what they point to live until their calls return.
        set.pool = unsafe { shared.raw.create_descriptor_pool(&pool_info, None) }
            .map_err(GpuError::call("vkCreateDescriptorPool", &self.name))?;
        let layouts = [self.set_layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
        // SAFETY: the pool was made for exactly this layout.
        set.raw = unsafe { shared.raw.allocate_descriptor_sets(&info) }
            .map_err(GpuError::call("vkAllocateDescriptorSets", &self.name))?[0];

        for declared in &self.reflection.bindings {
            let given = bindings.iter().find(|b| b.name == declared.name).ok_or_else(|| GpuError::MissingBinding {
                kernel: self.name.clone(),
                binding: declared.name.clone(),
            })?;
            let memory = given.resource.memory();
            if !self.device.is(&memory.device.shared) {
                let device = self.device.info().name.clone();
                return Err(GpuError::ForeignDevice { what: format!("\"{}\"", given.name), device });
            }
            if !given.resource.suits(declared.kind, declared.is_read_only) || given.resource.count() != declared.count {
                return Err(GpuError::WrongBinding {
                    kernel: self.name.clone(),
                    binding: declared.name.clone(),
                    declared: declared.describe(),
                    given: given.resource.describe(),
                });
            }
            let views = match given.resource {
                Resource::Table(table) => [table.view],
                Resource::Buffer(_) => [vk::BufferView::null()],
            };
            let ranges = match given.resource {
                Resource::Table(table) => table.ranges(),
                Resource::Buffer(_) => vec![(0, vk::WHOLE_SIZE)],
            };
            let buffers: Vec<_> = ranges
                .into_iter()
                .map(|(offset, range)| vk::DescriptorBufferInfo { buffer: memory.raw, offset, range })
                .collect();
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set.raw)
                .dst_binding(declared.binding)
                .descriptor_type(descriptor_type(declared.kind));
            let write = match declared.kind {
                BindingKind::TexelBuffer => write.texel_buffer_view(&views),
                _ => write.buffer_info(&buffers),
            };
            // SAFETY: the set is not in use; buffer and view are alive and of the declared type (checked by `suits`).
            unsafe { shared.raw.update_descriptor_sets(&[write], &[]) };
        }
        Ok(set)
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let device = &self.device.shared.raw;
        // SAFETY: submissions that run the pipeline borrow it and were waited for; null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// A descriptor set alive for one submission.
pub(super) struct BoundSet {
    pool: vk::DescriptorPool,
    pub raw: vk::DescriptorSet,
    device: Device,
}

impl Drop for BoundSet {
    fn drop(&mut self) {
        // SAFETY: dropped after the submission that used it was waited for; frees the set with the pool.
        unsafe { self.device.shared.raw.destroy_descriptor_pool(self.pool, None) };
    }
}

fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::TexelBuffer => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        _ => vk::DescriptorType::STORAGE_BUFFER,
    }
}

fn check_limits(device: &Device, name: &str, reflection: &Reflection) -> Result<(), GpuError> {
    let info = device.info();
    let missing = |missing: String| Err(GpuError::MissingFeature { device: info.name.clone(), missing });
    if let Some(odd) = reflection.bindings.iter().find(|b| b.kind == BindingKind::Other || b.set != 0) {
        return missing(format!("kernel \"{name}\" declares \"{}\", which is no table or buffer of set 0", odd.name));
    }
    let count = |kind| reflection.bindings.iter().filter(|b| b.kind == kind).map(|b| b.count).sum::<u32>();
    for (kind, limit) in [
        (BindingKind::StorageBuffer, info.limits.max_storage_bindings),
        (BindingKind::TexelBuffer, info.limits.max_texel_bindings),
    ] {
        if count(kind) > limit {
            return missing(format!("kernel \"{name}\" binds {} {kind:?}s and the limit is {limit}", count(kind)));
        }
    }
    if reflection.push_bytes > info.limits.max_push_bytes {
        let limit = info.limits.max_push_bytes;
        return missing(format!(
            "kernel \"{name}\" takes {} push bytes and the limit is {limit}",
            reflection.push_bytes
        ));
    }
    CString::new(name).map(|_| ()).or_else(|_| missing(format!("kernel name {name:?} holds a zero byte")))
}
