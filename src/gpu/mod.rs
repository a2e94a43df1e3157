//! Devices and kernels as data.
mod adapter;
mod context;
mod kernel;
mod layout;
mod transfer;

pub use adapter::{
    Backend, NATIVE_FEATURES, Selection, Tier, TierChoice, adapters, all_adapters, shortcoming,
};
pub use context::Gpu;
pub use kernel::{Access, Binding, BindingKind, FLOAT, Kernel, KernelDesc, Source};
pub use layout::{Field, GpuLayout, size_of_field};
