//! Devices and kernels as data.
mod adapter;
mod allocate;
mod context;
mod kernel;
mod layout;
mod timing;
mod transfer;

pub use adapter::{
    Backend, FETCH_FEATURES, NATIVE_FEATURES, STORAGE_FORMATS, Selection, TierChoice, adapters, all_adapters,
    shortcoming,
};
pub use allocate::{Allocator, Memory, array_view, view};
pub use context::{Gpu, unusable_adapter};
pub use kernel::{Access, Binding, BindingKind, Constant, FLOAT, Kernel, KernelDesc, Source, Tier};
pub(crate) use kernel::{join, joined, joined_length, on_each_tier};
pub use layout::{Field, GpuLayout, size_of_field};
pub use timing::Timeline;
