//! Devices and kernels as data.
mod adapter;
mod allocate;
mod cache;
mod context;
pub mod error;
mod kernel;
mod link;
#[cfg(feature = "device")]
mod open;
mod resource;
mod timing;
mod transfer;

pub(crate) use adapter::missed_limit;
pub use adapter::{
    Backend, FETCH_FEATURES, NATIVE_FEATURES, STORAGE_FORMATS, Selection, TierChoice, shortcoming,
};
pub use allocate::{Allocator, Memory, array_view, view};
pub use cache::KernelCache;
pub use context::{Gpu, unusable_adapter};
pub use kernel::{Choice, Constant, Kernel, KernelDesc, KernelError, Tier};
pub use link::{Item, Library, LinkError, Linked, words};
#[cfg(feature = "device")]
pub use open::{adapters, all_adapters};
pub use resource::{Access, Binding, BindingKind, Resource, Resources};
pub use timing::Timeline;
