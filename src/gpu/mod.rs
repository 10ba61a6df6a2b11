//! The device: opening Vulkan, tables and buffers, pipelines, submission. The only `unsafe` of the project.
//!
//! A safe facade over `ash` and `gpu-allocator`: one Rust owner per Vulkan object, each holding its device and freeing
//! itself in Drop; no raw handle leaves this module. Work is recorded in a closure, submitted and waited for:
//! on lavapipe submit and wait cost 74 us, and a progressive renderer needs no frames in flight.
//! Bindings come from the SPIR-V (`shader::reflect`) and are given by name. Leaves out graphics, images, several queues.
//! Tests: the units here and `gpu::tests`, which run with the validation layer, whose every message fails the test.
#![allow(unsafe_code)]

mod buffer;
mod device;
mod error;
mod info;
mod instance;
mod memory;
mod pipeline;
pub mod renderer;
mod submit;
mod table;
#[cfg(test)]
mod tests;

pub mod driver_cache;

pub use buffer::Buffer;
pub use device::{Device, Options, Selected, list, select};
pub use error::GpuError;
pub use info::{Choice, DeviceInfo, DeviceKind, Limits, choose};
pub use pipeline::{Binding, Pipeline, Resource};
pub use submit::{Elapsed, Recorder};
pub use table::{Table, TableBody};
