//! Devices and kernels as data.
mod adapter;
mod allocate;
mod context;
mod kernel;
mod layout;
mod link;
mod resource;
mod timing;
mod transfer;

pub use adapter::{
    Backend, FETCH_FEATURES, NATIVE_FEATURES, Selection, TierChoice, adapters, all_adapters,
    shortcoming,
};
pub use allocate::{Allocator, Memory, array_view, view};
pub use context::Gpu;
pub use kernel::{Choice, Constant, Kernel, KernelDesc, KernelError, Tier};
pub use layout::{Field, GpuLayout, size_of_field};
pub use link::{Item, Library, LinkError, Linked, words};
pub use resource::{Access, Binding, BindingKind, Resource, Resources};
pub use timing::Timeline;
