//! Tables: read-only rows of 16 bytes (`uvec4`), read in GLSL through `NAME_row(uint)`.
//!
//! Two bodies give the same integers. On lavapipe a uniform texel buffer is the faster: in the render kernel of
//! scenes/cornell.toml, all tables as texels 0.15 Msamples/s against 0.034 as storage buffers (alternating, loaded machine), and 250
//! against 9 M rows/s when every row of 64 MiB is read in order. Its size is limited by `maxTexelBufferElements` (SwiftShader: 65536
//! rows; lavapipe: 2 GiB, 1 GiB read right), a storage buffer's by `maxStorageBufferRange` (lavapipe: 128 MiB). Beyond that a storage
//! buffer is bound in pages: an array of descriptors into one buffer, each within the range. The array is indexed by constants only, since
//! an index that differs between lanes is a feature that not every device has: a row is read from the first page and replaced by a later
//! page's where it lies there.
//! The body is chosen per table before the text is generated. Tests: `gpu::tests`.

use ash::vk;

use super::device::Device;
use super::error::GpuError;
use super::info::DeviceInfo;
use super::memory::Memory;
use super::pipeline::{Binding, Resource};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TableBody {
    /// `usamplerBuffer` of format R32G32B32A32_UINT.
    Texel,
    /// `readonly buffer` of `uvec4`.
    Storage,
    /// The same in `pages` of 2^`page_shift` rows.
    Paged { page_shift: u32, pages: u32 },
}

/// Each page is one more read at every look-up where no branch is skipped.
const MAX_PAGES: u32 = 16;

impl TableBody {
    /// The body that suits a table of `rows` rows on this device; an error when neither can hold it.
    pub fn choose(device: &DeviceInfo, name: &str, rows: usize) -> Result<TableBody, GpuError> {
        let bytes = rows as u64 * 16;
        let limits = &device.limits;
        let fits = |body: TableBody| bytes <= body.limit(device).0.min(limits.max_allocation);
        // On a GPU both bodies go through the same cache, and a storage buffer has the larger limit as a rule.
        let order = if device.is_software {
            [Self::Texel, Self::Storage, Self::paged(device, rows)]
        } else {
            [Self::Storage, Self::Texel, Self::paged(device, rows)]
        };
        order.into_iter().find(|&body| fits(body)).ok_or_else(|| {
            let (limit, limit_name) = order.map(|body| body.limit(device)).into_iter().max().unwrap_or((0, "limit"));
            let (limit, limit_name) = if limits.max_allocation < limit {
                (limits.max_allocation, "maxMemoryAllocationSize")
            } else {
                (limit, limit_name)
            };
            GpuError::TooLarge { name: name.to_owned(), bytes, limit_name, limit }
        })
    }

    /// As few pages as the device's storage range allows, and one at least.
    fn paged(device: &DeviceInfo, rows: usize) -> TableBody {
        let page_shift = (device.limits.max_storage_range / 16).max(1).ilog2();
        let pages = rows.div_ceil(1 << page_shift).max(1);
        Self::Paged { page_shift, pages: pages.min(u32::MAX as usize) as u32 }
    }

    /// Largest table in bytes, and what Vulkan calls that limit.
    pub fn limit(self, device: &DeviceInfo) -> (u64, &'static str) {
        match self {
            TableBody::Texel => (u64::from(device.limits.max_texel_elements) * 16, "maxTexelBufferElements * 16"),
            TableBody::Storage => (u64::from(device.limits.max_storage_range), "maxStorageBufferRange"),
            TableBody::Paged { page_shift, .. } => {
                (u64::from(MAX_PAGES) << (page_shift + 4), "maxStorageBufferRange, in 16 pages,")
            }
        }
    }

    /// GLSL that declares table `name` at `binding` of set 0 and defines `uvec4 NAME_row(uint i)`.
    pub fn glsl(self, name: &str, binding: u32) -> String {
        match self {
            TableBody::Texel => format!(
                "layout(set = 0, binding = {binding}) uniform usamplerBuffer {name};\n\
                 uvec4 {name}_row(uint i) {{\n    return texelFetch({name}, int(i));\n}}\n"
            ),
            TableBody::Storage => format!(
                "layout(set = 0, binding = {binding}, std430) readonly buffer {name}_block {{ uvec4 rows[]; }} {name};\n\
                 uvec4 {name}_row(uint i) {{\n    return {name}.rows[i];\n}}\n"
            ),
            TableBody::Paged { page_shift, pages } => {
                let mask = (1u32 << page_shift) - 1;
                let later: String = (1..pages)
                    .map(|p| format!("    if (page == {p}u) {{\n        row = {name}[{p}].rows[k];\n    }}\n"))
                    .collect();
                format!(
                    "layout(set = 0, binding = {binding}, std430) readonly buffer {name}_block {{ uvec4 rows[]; }} \
                     {name}[{pages}];\nuvec4 {name}_row(uint i) {{\n    uint page = i >> {page_shift};\n    \
                     uint k = i & {mask}u;\n    uvec4 row = uvec4(0u);\n    if (page == 0u) {{\n        \
                     row = {name}[0].rows[k];\n    }}\n{later}    return row;\n}}\n"
                )
            }
        }
    }
}

/// A table on the device.
pub struct Table {
    pub(super) view: vk::BufferView,
    pub(super) body: TableBody,
    pub(super) memory: Memory,
    row_count: usize,
}

impl Table {
    pub(super) fn new(device: &Device, name: &str, rows: &[[u32; 4]], body: TableBody) -> Result<Table, GpuError> {
        let bytes = size_of_val(rows) as u64;
        let (limit, limit_name) = body.limit(device.info());
        if bytes > limit {
            return Err(GpuError::TooLarge { name: name.to_owned(), bytes, limit_name, limit });
        }
        let usage = match body {
            TableBody::Texel => vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER,
            TableBody::Storage | TableBody::Paged { .. } => vk::BufferUsageFlags::STORAGE_BUFFER,
        };
        let memory = Memory::new(device, name, bytes, usage)?;
        if rows.is_empty() {
            // Vulkan has no empty buffer: a table without rows holds one of zeros.
            memory.fill_zero()?;
        }
        memory.write(0, bytemuck::cast_slice(rows))?;
        let mut table = Table { view: vk::BufferView::null(), body, memory, row_count: rows.len() };
        if body == TableBody::Texel {
            let info = vk::BufferViewCreateInfo::default()
                .buffer(table.memory.raw)
                .format(vk::Format::R32G32B32A32_UINT)
                .range(vk::WHOLE_SIZE);
            // SAFETY: the buffer is bound to memory and has the texel usage; every device supports the format for it.
            table.view = unsafe { device.shared.raw.create_buffer_view(&info, None) }
                .map_err(GpuError::call("vkCreateBufferView", name))?;
            device.shared.set_name(table.view, name);
        }
        Ok(table)
    }

    pub fn name(&self) -> &str {
        &self.memory.name
    }

    pub fn body(&self) -> TableBody {
        self.body
    }

    pub fn row_count(&self) -> usize {
        self.row_count
    }

    pub fn bytes(&self) -> u64 {
        self.memory.bytes
    }

    /// (offset, bytes) of each descriptor.
    pub(super) fn ranges(&self) -> Vec<(u64, u64)> {
        let TableBody::Paged { page_shift, pages } = self.body else { return vec![(0, vk::WHOLE_SIZE)] };
        let page = 16u64 << page_shift;
        (0..u64::from(pages)).map(|p| (p * page, page.min(self.memory.bytes - p * page))).collect()
    }

    /// Binds the table to the GLSL table of the same name.
    pub fn binding(&self) -> Binding<'_> {
        Binding { name: &self.memory.name, resource: Resource::Table(self) }
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        // SAFETY: submissions that read the table borrow it and were waited for; a null view is ignored.
        unsafe { self.memory.device.shared.raw.destroy_buffer_view(self.view, None) };
    }
}
