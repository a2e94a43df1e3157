//! Devices and kernels as data.
mod context;
mod kernel;
mod layout;

pub use context::Gpu;
pub use kernel::{Access, Binding, BindingKind, FLOAT, Kernel, KernelDesc, Source, Tier};
pub use layout::{Field, GpuLayout, size_of_field};
