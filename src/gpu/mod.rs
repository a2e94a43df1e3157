//! Devices and kernels as data.
mod adapter;
mod allocate;
mod context;
mod kernel;
#[cfg(feature = "device")]
mod open;
mod timing;
mod transfer;

pub use adapter::{Backend, FETCH_FEATURES, NATIVE_FEATURES, Selection, TierChoice, shortcoming};
pub use allocate::{Allocator, Memory, array_view, view};
pub use context::Gpu;
pub use kernel::{Access, Binding, BindingKind, Constant, FLOAT, Kernel, KernelDesc, Source, Tier};
pub(crate) use kernel::{join, joined, joined_length, on_each_tier};
#[cfg(feature = "device")]
pub use open::{adapters, all_adapters};
pub use timing::Timeline;
