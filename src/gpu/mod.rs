//! Devices and kernels as data.
mod allocate;
mod context;
mod kernel;
mod layout;
mod timing;

pub use allocate::{Allocator, Memory, array_view, view};
pub use context::Gpu;
pub use kernel::{Access, Binding, BindingKind, FLOAT, Kernel, KernelDesc, Source, Tier};
pub use layout::{Field, GpuLayout, size_of_field};
pub use timing::Timeline;
